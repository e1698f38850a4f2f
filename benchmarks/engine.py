"""The momentum engine: a plane of gaits, loads, a million gaits, threads, legs, cold start.

Run with `python -m benchmarks.engine`; writes benchmarks/results/engine.json. Times are medians of
one run.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.common import (
    COUNTED,
    CYCLES,
    KAPPA,
    MIN_SPEED,
    OMEGA,
    PERIOD,
    RESULTS,
    ROOT,
    STEPS,
    TRUE_STEPS,
    Timing,
    clocked,
    engine,
    engine_motion,
    full_model,
    kkt_motion,
    median,
    plane,
    recorded,
    repeated,
)
from rrrobot import FullModel
from rrrobot.drive.gaits import GaitBatch
from rrrobot.momentum.batch import LOADS, RESULT, lower, steady_states

MILLION_CYCLES = 26
"""The first whole number of cycles that lasts 20 s."""


def grid(rows: int, repeats: int) -> dict[str, Any]:
    """The plane of gaits on one thread."""
    setting, gaits = lower(full_model()), plane(rows, rows).gaits()
    times = repeated(lambda: engine(setting, gaits), repeats)
    wall = [t.wall for t in times]
    return {
        "gaits": rows * rows, "cycles": CYCLES, "repeats": repeats,
        **median(times)._asdict(), "wall_fastest": min(wall), "wall_slowest": max(wall),
    }  # fmt: skip


def with_loads(rows: int, repeats: int) -> dict[str, Any]:
    """The plane with torques, power and friction, and how well the default steps give them."""
    setting, gaits = lower(full_model()), plane(rows, rows).gaits()

    def run(steps: int) -> Any:
        return steady_states(
            setting, gaits, cycles=CYCLES, counted=COUNTED, steps_per_cycle=steps, loads=True
        )[:, len(RESULT) :]

    found = {"gaits": rows * rows, **median(repeated(lambda: run(STEPS), repeats))._asdict()}
    true = run(2 * TRUE_STEPS)
    for steps in (STEPS, 2 * STEPS):
        error = np.abs(run(steps) / true - 1)
        for i, name in enumerate(LOADS):
            found[f"{name}_{steps}_steps_median"] = float(np.median(error[:, i]))
            found[f"{name}_{steps}_steps_worst"] = float(error[:, i].max())
    return found


def accuracy(rows: int, sample: int, seed: int = 1) -> dict[str, Any]:
    """Errors of the engine's speed and yaw rate against the KKT form at random points."""
    points = plane(rows, rows)
    found = engine_motion(engine(lower(full_model()), points.gaits()))
    moving = np.flatnonzero(found.speed > MIN_SPEED)
    chosen = np.random.default_rng(seed).choice(moving, sample, replace=False)
    kkt = [kkt_motion(points.gait(i)) for i in chosen]
    speed = np.concatenate([m.speed for m in kkt])
    yaw_rate = np.concatenate([m.yaw_rate for m in kkt])
    relative = np.abs(found.speed[chosen] / speed - 1)
    return {
        "points": sample, "least_speed": float(speed.min()),
        "speed_median": float(np.median(relative)), "speed_worst": float(relative.max()),
        "yaw_rate_absolute_worst": float(np.abs(found.yaw_rate[chosen] - yaw_rate).max()),
    }  # fmt: skip


def convergence(rows: int, steps: tuple[int, ...]) -> list[dict[str, Any]]:
    """Errors and time of other numbers of steps, against 80."""
    setting, points = lower(full_model()), plane(rows, rows).gaits()
    true = engine_motion(engine(setting, points, steps=2 * TRUE_STEPS)).speed
    rows_ = []
    for n in steps:
        time_ = median(repeated(lambda n=n: engine(setting, points, steps=n), 5))
        speed = engine_motion(engine(setting, points, steps=n)).speed
        error = np.abs(speed / true - 1)[true > MIN_SPEED]
        rows_.append(
            {"steps": n, **time_._asdict(), "speed_median": float(np.median(error)),
             "speed_worst": float(error.max())}
        )  # fmt: skip
    return rows_


def linearity(sizes: tuple[int, ...], repeats: int) -> list[dict[str, Any]]:
    """Time per gait for several numbers of gaits, on one thread."""
    setting, rows = lower(full_model()), []
    for n in sizes:
        gaits = some_gaits(n, 2)
        times = median(repeated(lambda g=gaits: engine(setting, g), repeats))
        rows.append({"gaits": n, **{f"{k}_per_gait": v / n for k, v in times._asdict().items()}})
    return rows


def legs(counts: tuple[int, ...], gaits: int, repeats: int) -> list[dict[str, Any]]:
    """Time per gait on robots with more legs, split into the table and the march."""
    from tests.random_robot import random_robot

    rows = []
    for n in counts:
        setting = lower(FullModel(random_robot(3, n), damping=KAPPA))
        some = some_gaits(gaits, n, amplitude=0.05)
        short, long = (
            median(repeated(lambda s=setting, g=some, c=c: engine(s, g, cycles=c), repeats)).core
            for c in (CYCLES, 3 * CYCLES)
        )
        march = (long - short) / (2 * CYCLES * gaits)
        rows.append(
            {"legs": n, "march_per_cycle": march, "table": short / gaits - CYCLES * march}
        )  # fmt: skip
    return rows


def threads(gaits: int, repeats: int) -> dict[str, Any]:
    """One thread and two over the same chunks, in turn."""
    setting, some = lower(full_model()), some_gaits(gaits, 2)

    def run(n: int) -> Timing:
        return clocked(lambda: engine(setting, some, threads=n, chunk=320))

    run(2)
    pairs = [(run(1), run(2)) for _ in range(repeats)]
    one, two = (median(list(part)) for part in zip(*pairs, strict=True))
    return {
        "gaits": gaits, "repeats": repeats, "one": one._asdict(), "two": two._asdict(),
        "speed_up_median": float(np.median([a.wall / b.wall for a, b in pairs])),
        "speed_up_best": max(a.wall / b.wall for a, b in pairs),
        # Above one where the two threads work slower for want of free cores or memory.
        "core_seconds_two_to_one": two.core / one.core,
    }  # fmt: skip


def some_gaits(n: int, n_legs: int, amplitude: float | None = None, seed: int = 2) -> GaitBatch:
    """Random gaits of any number of legs."""
    rng = np.random.default_rng(seed)
    shape = (n, n_legs)
    swing = rng.uniform(0.1, 0.4, shape) if amplitude is None else np.full(shape, amplitude)
    return GaitBatch.sinusoidal(
        rng.uniform(0, np.pi, shape), swing, rng.uniform(0, 2 * np.pi, shape), np.full(n, OMEGA)
    )


def million(n: int, n_threads: int = 2) -> dict[str, Any]:
    """Many gaits of 20 s in this process, and its memory."""
    setting = lower(full_model())
    engine(setting, some_gaits(16, 2), cycles=3, counted=2)
    before = _resident()
    gaits = some_gaits(n, 2)
    start = time.perf_counter(), time.process_time()
    found = engine(setting, gaits, cycles=MILLION_CYCLES, counted=8, threads=n_threads, chunk=1600)
    wall, core = time.perf_counter() - start[0], time.process_time() - start[1]
    return {
        "gaits": n, "seconds_each": MILLION_CYCLES * PERIOD, "threads": n_threads, "wall": wall,
        "core": core, "resident_mb": _resident(), "resident_before_mb": before,
        "stopped": int(np.sum(np.isnan(found[:, 0]))),
    }  # fmt: skip


def _resident() -> float:
    """Largest resident memory of this process so far [MB]."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def first_call() -> dict[str, float]:
    """Time in this process of setting the model up, and of the first sweep."""
    start = time.perf_counter()
    lower(full_model())
    ready = time.perf_counter()
    engine(lower(full_model()), plane(4, 4).gaits(), cycles=3, counted=2)
    return {"model": ready - start, "first_sweep": time.perf_counter() - ready}


def fresh(argument: str, *more: str, cache: str | None = None) -> dict[str, Any]:
    """One of the above in a new process, and that process's time."""
    environment = os.environ | ({} if cache is None else {"NUMBA_CACHE_DIR": cache})
    start = time.perf_counter()
    output = subprocess.run(
        [sys.executable, "-m", "benchmarks.engine", argument, *more],
        cwd=ROOT, env=environment, check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    return json.loads(output) | {"process": time.perf_counter() - start}


def cold_start(repeats: int) -> dict[str, Any]:
    """First sweep in a new process, with an empty cache of compiled code and with a full one."""
    with tempfile.TemporaryDirectory() as folder:
        empty = fresh("--first-call", cache=folder)
        full = [fresh("--first-call", cache=folder) for _ in range(repeats)]
    middle = sorted(full, key=lambda r: r["first_sweep"])[len(full) // 2]
    return {"empty_cache": empty, "full_cache": middle, "repeats": repeats}


def main() -> None:
    """Measure, print and write benchmarks/results/engine.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first-call", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--million", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder of the JSON file")
    arguments = parser.parse_args()
    if arguments.first_call:
        print(json.dumps(first_call()))
        return
    if arguments.million:
        print(json.dumps(million(arguments.million)))
        return
    with recorded("engine", arguments.out) as results:
        steps = {
            "grid": lambda: grid(40, 15),
            "loads": lambda: with_loads(40, 9),
            "accuracy": lambda: accuracy(40, 24),
            "convergence": lambda: convergence(20, (6, 8, 10, 12, 16, 20, 40)),
            "linearity": lambda: linearity((400, 1600, 6400, 25600), 5),
            "legs": lambda: legs((2, 4, 8, 12), 800, 5),
            "threads": lambda: threads(6400, 9),
            "cold_start": lambda: cold_start(5),
            "million": lambda: fresh("--million", "1000000"),
        }
        for name, measure in steps.items():
            results[name] = measure()
            print(name, json.dumps(results[name]), flush=True)


if __name__ == "__main__":
    main()
