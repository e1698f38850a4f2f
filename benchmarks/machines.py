"""What the other machines cost: one evaluation of each one's equations, and two whole runs.

Run with `python -m benchmarks.machines`. Processor times, the least of several rounds.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import rrrobot as rr
from benchmarks.common import RESULTS, recorded
from benchmarks.tables import Record, machine, prose, seconds, table

TARGETS = {"rattleback, 20 s": 5.0, "snakeboard, drive gait, 30 s": 1.0}
"""Processor time [s]."""


def evaluation(name: str, rounds: int = 5, calls: int = 200) -> float:
    """Processor time of one evaluation of a machine's right-hand side [s]."""
    body = rr.machines.by_name(name)
    gait = next(iter(body.gaits.values()), None)
    state = body.simulate(gait, 0.01, method="kkt").states[-1]

    def rate() -> None:
        body.model.rate(0.01, state, None if gait is None else gait(0.01), None)

    return min(_clocked(rate, calls) for _ in range(rounds)) / calls


def whole_runs(rounds: int = 3) -> dict[str, float]:
    """Processor time of the two runs that have a target [s]."""
    stone, board = rr.machines.rattleback(), rr.machines.snakeboard()
    half = np.deg2rad(0.5)
    pose = stone.at(rr.rotations.quaternion_from_euler((half, -half, 0.0)))
    runs: dict[str, Callable[[], Any]] = {
        "rattleback, 20 s": lambda: stone.simulate(None, 20.0, pose=pose, start=(0, 0, 5.0)),
        "snakeboard, drive gait, 30 s": lambda: board.simulate(board.gaits["drive"], 30.0),
    }
    stone.simulate(None, 0.1, pose=pose, start=(0, 0, 5.0))
    return {name: min(_clocked(run, 1) for _ in range(rounds)) for name, run in runs.items()}


def _clocked(call: Callable[[], Any], times: int) -> float:
    begin = time.process_time()
    for _ in range(times):
        call()
    return time.process_time() - begin


def machines_page(record: Record) -> str:
    """The section of docs/benchmarks.md."""
    r = record["results"]
    runs = (
        (
            name,
            f"≤ {TARGETS[name]:g} s",
            seconds(took),
            "yes" if took <= TARGETS[name] else "**no**",
        )
        for name, took in r["runs"].items()
    )
    parts = [
        "## The other machines\n",
        prose(f"""Processor time in one process, the least of several. The rattleback rolls by the
            momentum engine, its steps found as it goes; the snakeboard by the KKT system, with
            3001 samples. {machine(record)}"""),
        table(("run", "target", "measured", "met"), runs),
        prose("One evaluation of the equations of motion by the KKT system, default parameters:"),
        table(("machine", "evaluation"), ((n, seconds(s)) for n, s in r["evaluation"].items())),
    ]
    return "\n".join(parts)


def main() -> None:
    """Measure all and write the record."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=Path, default=RESULTS, help="folder of the JSON files")
    with recorded("machines", parser.parse_args().results) as results:
        results["runs"] = whole_runs()
        results["evaluation"] = {name: evaluation(name) for name in rr.machines.all_names()}
        for part in results.values():
            for name, took in part.items():
                print(f"{name:30s} {seconds(took)}")


if __name__ == "__main__":
    main()
