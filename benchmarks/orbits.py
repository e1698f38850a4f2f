"""Limit cycles of a plane of gaits beside 38 simulated cycles of each, and of Kane's equations.

Run with `python -m benchmarks.orbits`; writes benchmarks/results/orbits.json. Processor times of
one process and one thread, the fastest of some runs that take turns. Orbits with 8 steps in a
period have smaller errors than 38 cycles of 10 steps: those keep a transient.

Kane's equations by hand, compiled ("kinematics" of `kane_peer.py`), are integrated by RK4 for as
many cycles with the fewest steps whose median error of the speed is below that of 38 cycles; a
whole simulation of 30 s is compared with the search of the motion that it settles to.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.common import (
    COUNTED,
    CYCLES,
    RESULTS,
    STEPS,
    full_model,
    impulsive_rates,
    motion_of_means,
    plane,
)
from benchmarks.kane_peer import simulator, starts
from rrrobot.momentum.batch import RESULT, lower, steady_states
from rrrobot.orbits.many import orbits_of

ROWS, REPEATS, TRUE_STEPS = 40, 7, 60
ORBIT_STEPS = 8
KANE_STEPS, KANE_GAITS = (24, 32, 48, 64, 96), 64
_SPEED = RESULT.index("speed")
_MOVING = 2e-4
"""Speed from which on errors are relative [m/s]."""


def measured() -> dict[str, Any]:
    """Times and errors of the ways to settle."""
    setting, gaits = lower(full_model()), plane(ROWS, ROWS).gaits()
    truth = orbits_of(setting, gaits, TRUE_STEPS).results[:, _SPEED]
    moving = truth > _MOVING

    def cycles() -> Any:
        return steady_states(setting, gaits, cycles=CYCLES, counted=COUNTED, steps_per_cycle=STEPS)

    def orbits(steps: int, stability: str) -> Callable[[], Any]:
        def found() -> Any:
            orbits = orbits_of(setting, gaits, steps, stability=stability)
            if stability == "exact":
                assert orbits.multiplier.max() < 1.0
            return orbits.results

        return found

    ways: dict[str, Callable[[], Any]] = {
        "cycles": cycles,
        "orbits": orbits(ORBIT_STEPS, "none"),
        "orbits_and_stability": orbits(ORBIT_STEPS, "known"),
        "orbits_and_multipliers": orbits(ORBIT_STEPS, "exact"),
        "orbits_of_ten_steps": orbits(STEPS, "none"),
    }
    times: dict[str, list[float]] = {name: [] for name in ways}
    speeds = {name: way()[:, _SPEED] for name, way in ways.items()}
    for _ in range(REPEATS):
        for name, way in ways.items():
            start = time.process_time()
            way()
            times[name].append(time.process_time() - start)
    out: dict[str, Any] = {"gaits": ROWS * ROWS, "steps": STEPS, "orbit_steps": ORBIT_STEPS}
    for name in ways:
        error = np.abs(speeds[name] / truth - 1)[moving]
        out[name] = {
            "seconds": min(times[name]),
            "of_cycles": min(times[name]) / min(times["cycles"]),
            "largest_error": float(error.max()),
            "median_error": float(np.median(error)),
        }
    found = orbits_of(setting, gaits, ORBIT_STEPS, stability="none")
    out["periods_each"] = float(found.periods.mean())
    out["kane"] = kane(truth, out["cycles"]["median_error"])
    each = out["orbits"]["seconds"] / out["gaits"]
    out["kane"]["of_orbits"] = out["kane"]["seconds_each"] / each
    return out


def kane(truth: Any, wanted: float) -> dict[str, Any]:
    """Time of a gait's 30 s by Kane's equations, at a median error of the speed that is wanted."""
    run = simulator("kinematics")
    chosen = np.linspace(0, ROWS * ROWS - 1, KANE_GAITS).astype(int)
    some = plane(ROWS, ROWS).take(chosen)
    start, means = starts("kinematics", impulsive_rates(some)), np.empty((KANE_GAITS, CYCLES, 3))
    moving = truth[chosen] > _MOVING
    error = np.inf
    for steps in KANE_STEPS:
        run(some.offset, some.phase, start, steps, means)
        speed = motion_of_means(means[:, -COUNTED:].transpose(1, 0, 2)).speed
        error = float(np.median(np.abs(speed / truth[chosen] - 1)[moving]))
        if error <= wanted:
            break
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        run(some.offset, some.phase, start, steps, means)
        times.append(time.process_time() - begin)
    return {"steps": steps, "median_error": error, "seconds_each": min(times) / KANE_GAITS}


def main() -> None:
    """Measure, write and print."""
    data = measured()
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / "orbits.json").write_text(json.dumps(data, indent=1) + "\n")
    print(json.dumps(data, indent=1))


if __name__ == "__main__":
    main()
