"""The same sweep by rrrobot's engine, by MuJoCo, and by SymPy's KanesMethod through Numba.

Run with `python -m benchmarks.peers`; writes benchmarks/results/peers.json. The sweep is RRRobot
with the paper's damping over 20 offsets by 20 phase differences, 38 cycles (29.85 s) from an
impulsive start; speed and yaw rate are cycle means over the last 19 cycles.
"""

from __future__ import annotations

import argparse
import json
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import rrrobot as rr
from benchmarks.common import (
    AMPLITUDE,
    COUNTED,
    CYCLES,
    KAPPA,
    OMEGA,
    PAPER_GAITS,
    PERIOD,
    RESULTS,
    STEPS,
    TRUE_STEPS,
    Motion,
    Plane,
    Timing,
    clocked,
    engine,
    engine_motion,
    errors,
    full_model,
    impulsive_rates,
    kkt_motion,
    median,
    motion_of_means,
    plane,
    recorded,
    repeated,
    true_motion,
)
from benchmarks.contact import contact_checks
from rrrobot.momentum.batch import lower
from rrrobot.simulation.steady import steady_state

BODY = rr.BodyRateDamping(KAPPA, KAPPA, KAPPA)
TEN_MS = 79
"""Steps in a cycle that are nearest to 10 ms."""


def true_answer() -> list[dict[str, Any]]:
    """The paper's two gaits by three ways that share no equations."""
    names, rows = ("lateral", "circular"), []
    setting, gaits = lower(full_model()), PAPER_GAITS.gaits()
    ways = {
        f"engine, {n} steps in a cycle": engine_motion(engine(setting, gaits, steps=n))
        for n in (TRUE_STEPS, 2 * TRUE_STEPS)
    }
    both = [kkt_motion(PAPER_GAITS.gait(i)) for i in range(2)]
    ways["KKT, Pinocchio"] = Motion(*(np.concatenate(p) for p in zip(*both, strict=True)))
    both = [by_hand(PAPER_GAITS, i) for i in range(2)]
    ways["point masses by hand"] = Motion(*(np.concatenate(p) for p in zip(*both, strict=True)))
    for way, motion in ways.items():
        for i, name in enumerate(names):
            speed, yaw_rate = float(motion.speed[i]), float(motion.yaw_rate[i])
            rows.append({"way": way, "gait": name, "speed": speed, "yaw_rate": yaw_rate})
    return rows


def by_hand(points: Plane, index: int) -> Motion:
    """A gait by the tests' derivation from five point masses."""
    from tests.derivations import PointMassRobot, simulate_full

    phase = (0.0, points.phase[index])
    path = simulate_full(
        PointMassRobot(), points.offset[index], AMPLITUDE, OMEGA, phase, CYCLES * PERIOD,
        CYCLES * 96 + 1, (KAPPA,) * 3,
    )  # fmt: skip

    class Sampled:
        time, position, euler, period = path.time, path.contact_point, path.theta, PERIOD

    state = steady_state(Sampled(), start=(CYCLES - COUNTED) * PERIOD)
    return Motion(np.array([state.speed]), np.array([state.yaw_rate]))


class Ours:
    """The engine on the sweep, measured again and again while the others run."""

    def __init__(self, points: Plane, damping: rr.drive.Damping | float) -> None:
        self.setting = lower(full_model(damping))
        self.gaits = points.gaits()
        self.times: dict[int, list[Timing]] = {1: [], 2: []}

    def measure(self, repeats: int = 5) -> None:
        for threads, times in self.times.items():
            times += repeated(
                lambda n=threads: engine(self.setting, self.gaits, threads=n), repeats
            )

    def rows(self, true: Motion, damping: str) -> list[dict[str, Any]]:
        found = errors(engine_motion(engine(self.setting, self.gaits)), true)
        return [
            row("rrrobot", f"engine, {STEPS} steps in a cycle", damping, len(self.gaits.offset),
                threads, median(times), found)
            for threads, times in self.times.items()
        ]  # fmt: skip


def row(
    peer: str,
    name: str,
    damping: str,
    gaits: int,
    threads: int,
    timing: Timing,
    found: dict[str, float | None],
    **more: Any,
) -> dict[str, Any]:
    """One line of the comparison; times are for the gaits that were run."""
    return {
        "peer": peer, "name": name, "damping": damping, "gaits": gaits, "threads": threads,
        **timing._asdict(), **found, **more,
    }  # fmt: skip


def mujoco_rows(
    rows: int, true: dict[bool, Motion], threads: int, before: Any = None
) -> list[dict[str, Any]]:
    """Every case of MuJoCo on its part of the sweep."""
    from benchmarks.mujoco_peer import CASES, describe, sweep

    found = []
    for case in CASES:
        if before is not None:
            before()
        index = np.arange(rows * rows).reshape(rows, rows)[:: case.thin, :: case.thin].ravel()
        run = sweep(case, plane(rows, rows).take(index), threads=threads)
        part = Motion(*(values[index] for values in true[case.free_joint]))
        damping = "body rates" if case.free_joint else "Euler rates"
        found.append(
            row("MuJoCo", case.name, damping, index.size, threads, run.timing,
                errors(run.motion, part), settings=describe(case), leg_error=run.leg_error,
                wall_in_all=run.total.wall, core_in_all=run.total.core)
        )  # fmt: skip
        print(json.dumps(found[-1]), flush=True)
    return found


def kane_rows(
    points: Plane, true: Motion, repeats: int, steps: tuple[int, ...]
) -> list[dict[str, Any]]:
    """Both forms of Kane's equations on the whole sweep, at several steps in a cycle."""
    from benchmarks.kane_peer import FORMS, simulator, starts

    found, omega = [], impulsive_rates(points)
    n = points.offset.size
    means = np.empty((n, CYCLES, 3))
    for form in FORMS:
        begin = time.perf_counter()
        run, at = simulator(form), starts(form, omega)
        run(points.offset[:1], points.phase[:1], at[:1], 2, means[:1, :2])
        set_up = time.perf_counter() - begin
        for count in steps:
            sweep = partial(run, points.offset, points.phase, at, count, means)
            timing = median([clocked(sweep) for _ in range(repeats)])
            motion = motion_of_means(means.transpose(1, 0, 2)[-COUNTED:])
            name = f"KanesMethod, rolling as {form}, RK4"
            found.append(
                row("SymPy", name, "Euler rates", n, 1, timing, errors(motion, true),
                    set_up=set_up, steps=count, time_step_ms=1e3 * PERIOD / count)
            )  # fmt: skip
            print(json.dumps(found[-1]), flush=True)
    return found


def ratios(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """How many times faster per gait ours is than each other line, on the same damping."""

    def per_gait(line: dict[str, Any], clock: str) -> float:
        return float(line[clock] / line["gaits"])

    def quotient(line: dict[str, Any], own: dict[str, Any], key: str) -> float | None:
        return line[key] / own[key] if line[key] is not None else None

    found = {}
    for line in rows:
        if line["peer"] == "rrrobot":
            continue
        ours = [r for r in rows if r["peer"] == "rrrobot" and r["damping"] == line["damping"]]
        same = next(r for r in ours if r["threads"] == line["threads"])
        two = next(r for r in ours if r["threads"] == 2)
        one = next(r for r in ours if r["threads"] == 1)
        key = f"{line['peer']}, {line['name']}, {line['damping']}"
        found[key] = {
            "core": per_gait(line, "core") / per_gait(one, "core"),
            "wall_same_threads": per_gait(line, "wall") / per_gait(same, "wall"),
            "wall_two_threads": per_gait(line, "wall") / per_gait(two, "wall"),
            "speed_error_ratio": quotient(line, one, "speed_median"),
            "yaw_rate_error_ratio": quotient(line, one, "yaw_rate_median"),
        }
    return found


def engine_at(points: Plane, true: Motion, steps: tuple[int, ...]) -> list[dict[str, Any]]:
    """Time and error of the engine at several steps in a cycle, on one thread."""
    setting, gaits = lower(full_model()), points.gaits()
    found = []
    for n in steps:
        timing = median(repeated(partial(engine, setting, gaits, steps=n), 5))
        motion = engine_motion(engine(setting, gaits, steps=n))
        found.append(
            row("rrrobot", "engine", "Euler rates", points.offset.size, 1, timing,
                errors(motion, true), steps=n)
        )  # fmt: skip
    return found


def main() -> None:
    """Measure, print and write benchmarks/results/peers.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=20, help="rows and columns of the sweep")
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder of the JSON file")
    arguments = parser.parse_args()
    rows = arguments.rows
    points = plane(rows, rows)
    with recorded("peers", arguments.out, "mujoco", "sympy") as results:
        true = {False: true_motion(points.gaits()), True: true_motion(points.gaits(), BODY)}
        ours = {False: Ours(points, KAPPA), True: Ours(points, BODY)}

        def measure() -> None:
            for one in ours.values():
                one.measure()

        results["sweep"] = {"rows": rows, "cycles": CYCLES, "counted": COUNTED}
        results["true_answer"] = true_answer()
        results["contact"] = contact_checks()
        measure()
        kane = kane_rows(points, true[False], 3, (40, TEN_MS, 2 * TEN_MS, 4 * TEN_MS))
        lines = [line for line in kane if line["steps"] == TEN_MS]
        lines += mujoco_rows(rows, true, 2, measure)
        measure()
        first = ours[False].rows(true[False], "Euler rates")
        lines = first + ours[True].rows(true[True], "body rates") + lines
        results["sweep"]["engine_repeats"] = len(ours[False].times[1])
        results["lines"] = lines
        results["ratios"] = ratios(lines)
        results["work_precision"] = engine_at(points, true[False], (6, 8, 10, 14, 20)) + kane
    print(json.dumps(results["ratios"], indent=1))


if __name__ == "__main__":
    main()
