"""What other shells and grounds cost the momentum engine, against the sphere on level ground.

Run with `python -m benchmarks.grounds`. Steady states of the same gaits with the same number of
steps, in turns within one process and on one core; the ratio is that of the least CPU times.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from typing import Any

import numpy as np

import rrrobot as rr
from rrrobot.drive.gaits import GaitBatch
from rrrobot.momentum.batch import steady_states
from rrrobot.momentum.lowering import lower

TARGETS = {
    "sphere, level": 1.0,
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


def cost_ratios(gaits: int = 512, rounds: int = 7) -> dict[str, float]:
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
    first = best["sphere, level"]
    return {name: value / first for name, value in best.items()}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    for name, ratio in cost_ratios(rounds=parser.parse_args().rounds).items():
        print(f"{name:20s} {ratio:5.2f}   target {TARGETS[name]:.2f}")


if __name__ == "__main__":
    main()
