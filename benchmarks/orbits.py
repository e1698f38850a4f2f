"""Limit cycles of a plane of gaits beside 38 simulated cycles of each.

Run with `python -m benchmarks.orbits`; writes benchmarks/results/orbits.json. Processor times of
one process, the fastest of some runs.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.common import COUNTED, CYCLES, RESULTS, STEPS, full_model, plane
from rrrobot.momentum.batch import RESULT, fourier, lower, steady_states
from rrrobot.orbits.many import orbits_of

ROWS, REPEATS, TRUE_STEPS = 40, 5, 60
_SPEED = RESULT.index("speed")
_MOVING = 2e-4
"""Speed from which on errors are relative [m/s]."""


def measured() -> dict[str, Any]:
    """Times and errors of the ways to settle."""
    setting, sinusoids = lower(full_model()), plane(ROWS, ROWS).gaits()
    gaits = fourier(sinusoids)
    truth = orbits_of(setting, gaits, TRUE_STEPS).results[:, _SPEED]
    moving = truth > _MOVING

    def cycles() -> Any:
        return steady_states(
            setting, sinusoids, cycles=CYCLES, counted=COUNTED, steps_per_cycle=STEPS
        )

    ways: dict[str, Callable[[], Any]] = {
        "cycles": cycles,
        "orbits": lambda: orbits_of(setting, gaits, STEPS, stability=False).results,
        "orbits_and_multipliers": lambda: orbits_of(setting, gaits, STEPS).results,
    }
    out: dict[str, Any] = {"gaits": ROWS * ROWS, "steps": STEPS}
    for name, way in ways.items():
        times = []
        for _ in range(REPEATS):
            start = time.process_time()
            speed = way()[:, _SPEED]
            times.append(time.process_time() - start)
        error = np.abs(speed / truth - 1)[moving]
        out[name] = {
            "seconds": min(times),
            "largest_error": float(error.max()),
            "median_error": float(np.median(error)),
        }
    found = orbits_of(setting, gaits, STEPS, stability=False)
    out["periods_each"] = float(found.periods.mean())
    for name in ("orbits", "orbits_and_multipliers"):
        out[name]["of_cycles"] = out[name]["seconds"] / out["cycles"]["seconds"]
    return out


def main() -> None:
    """Measure, write and print."""
    data = measured()
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / "orbits.json").write_text(json.dumps(data, indent=1) + "\n")
    print(json.dumps(data, indent=1))


if __name__ == "__main__":
    main()
