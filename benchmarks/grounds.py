"""What other shells and grounds cost the momentum engine, against the sphere on level ground.

Run with `python -m benchmarks.grounds`. Steady states of the same gaits with the same number of
steps, in turns within one process and on one core; the ratio is that of the least processor times.
Where memory comes to lie differs from process to process and changes it by some percent: the median
of several processes counts.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import rrrobot as rr
from benchmarks.common import RESULTS, recorded
from benchmarks.tables import Record, machine, number, prose, table
from rrrobot.drive.gaits import GaitBatch
from rrrobot.momentum.batch import steady_states
from rrrobot.momentum.lowering import lower

FIRST, GAITS = "sphere, level", 512
TARGETS = {
    FIRST: 1.0,
    "sphere, slope": 1.1,
    "sphere, boulder": 1.15,
    "ellipsoid, level": 1.4,
    "rounded box, level": 1.5,
    "ellipsoid, graph": 3.0,
}


def pairs() -> dict[str, tuple[rr.Surface, Any]]:
    """Shells and grounds by name."""
    sphere, ellipsoid = rr.Sphere(0.12), rr.Ellipsoid((0.15, 0.13, 0.12))
    box = rr.EllipsoidSum([(0.06, 0.06, 0.06), (0.06, 0.05, 0.06), (0.06, 0.06, 0.03)])
    graph = rr.Graph(
        lambda x, y: 0.02 * np.sin(3 * x) * np.cos(2 * y),
        lambda x, y: (0.06 * np.cos(3 * x) * np.cos(2 * y), -0.04 * np.sin(3 * x) * np.sin(2 * y)),
        lambda x, y: (
            (-0.18 * np.sin(3 * x) * np.cos(2 * y), -0.12 * np.cos(3 * x) * np.sin(2 * y)),
            (-0.12 * np.cos(3 * x) * np.sin(2 * y), -0.08 * np.sin(3 * x) * np.cos(2 * y)),
        ),
    )
    level, slope = rr.Plane(), rr.Plane(normal=(-0.05, 0.03, 1))
    return {
        "sphere, level": (sphere, level),
        "sphere, slope": (sphere, slope),
        "sphere, boulder": (sphere, rr.Boulder(0.5)),
        "ellipsoid, level": (ellipsoid, level),
        "rounded box, level": (box, level),
        "ellipsoid, graph": (ellipsoid, graph),
    }


def cost_ratios(gaits: int = GAITS, rounds: int = 7) -> dict[str, float]:
    """CPU time of each pair over that of the sphere on level ground."""
    robot = rr.Robot.from_parameters()
    settings = {
        name: lower(rr.FullModel(replace(robot, shell=shell), ground=ground))._replace(fineness=1)
        for name, (shell, ground) in pairs().items()
    }
    phase = np.column_stack((np.zeros(gaits), np.linspace(0.1, 6.2, gaits)))
    many = GaitBatch.sinusoidal(
        np.full((gaits, 2), 0.8), np.full((gaits, 2), 0.3), phase, np.full(gaits, 8.0)
    )
    best = dict.fromkeys(settings, np.inf)
    for _ in range(rounds):
        for name, setting in settings.items():
            begin = time.process_time()
            steady_states(setting, many, cycles=38, counted=20, steps_per_cycle=10)
            best[name] = min(best[name], time.process_time() - begin)
    return {name: value / best[FIRST] for name, value in best.items()}


def grounds_page(record: Record) -> str:
    """The section of docs/benchmarks.md."""
    ratios = record["results"]["ratios"]
    rows = (
        (name, f"≤ {TARGETS[name]:g}", number(median), f"{number(min(of))} to {number(max(of))}",
         "yes" if median <= TARGETS[name] else "**no**")
        for name, of in ratios.items()
        for median in [statistics.median(of)]
        if name != FIRST
    )  # fmt: skip
    runs = len(ratios[FIRST])
    parts = [
        "## Other bellies and grounds\n",
        prose(f"""What they cost the engine against a sphere on level ground: processor time of the
            same {GAITS} gaits with the same steps, in turns in one process; the median of {runs}
            processes and its range. A belly that is not round is also given more steps, by its
            smallest radius. {machine(record)}"""),
        table(("shell, ground", "target", "median", "range", "met"), rows),
    ]
    return "\n".join(parts)


def main() -> None:
    """Measure in several processes and write the record."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=12, help="of each process")
    parser.add_argument("--processes", type=int, default=7)
    parser.add_argument("--one", action="store_true", help="print what this process measures")
    parser.add_argument("--results", type=Path, default=RESULTS, help="folder of the JSON files")
    asked = parser.parse_args()
    if asked.one:
        print(json.dumps(cost_ratios(rounds=asked.rounds)))
        return
    command = [sys.executable, "-m", "benchmarks.grounds", "--one", "--rounds", str(asked.rounds)]
    cost_ratios(rounds=1)
    with recorded("grounds", asked.results) as results:
        found = [
            json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
            for _ in range(asked.processes)
        ]
        results["ratios"] = {name: [one[name] for one in found] for name in TARGETS}
        for name, of in results["ratios"].items():
            print(f"{name:20s} {statistics.median(of):5.2f}   target {TARGETS[name]:.2f}   {of}")


if __name__ == "__main__":
    main()
