"""Ten thousand gaits of Solo12 with twelve joints: where they go, and whether they are feasible.

    python -m benchmarks.many_gaits [--gaits 10000] [--best 100]

On all cores: steady states, forces, torques, tilt and joint limits of random gaits about the
belly's posture; then Coal's distances of every link from the ground and from every other through a
cycle of the best. The gaits' frequencies are near the rocking modes.
"""

from __future__ import annotations

import argparse
import time
import warnings
from typing import NamedTuple

import numpy as np

import rrrobot as rr
from rrrobot.belly.clearance import clearances
from rrrobot.drive.gaits import GaitBatch
from rrrobot.escape.bench import Bench
from rrrobot.escape.bodies import base_length, capsules_of
from rrrobot.escape.goals import goal_of
from rrrobot.escape.limits import EscapeLimits, Rules
from rrrobot.escape.loss import rocking_damping, rocking_modes

ROBOT = "solo12"
SWING = 0.04
"""Standard deviation of the legs' sines and cosines [rad]."""


class Ready(NamedTuple):
    """A robot on its belly, and what gaits of it are held against."""

    belly: rr.belly.Belly
    bench: Bench
    rules: Rules


def ready(name: str = ROBOT) -> Ready:
    """The robot's belly on level ground, the goal forward."""
    belly = rr.fit_belly(name)
    loss = rocking_damping(belly.model(damping=None), belly.posture)
    model = belly.model(damping=loss)
    decay = min(mode.decay_rate for mode in rocking_modes(model, belly.posture))
    bench = Bench(model, *capsules_of(belly.shapes, belly.covered), decay)
    limits = EscapeLimits()
    rules = Rules(
        goal_of("forward"), limits, limits.ends(belly.robot), belly.rolling_range.least,
        base_length(belly.shapes),
    )  # fmt: skip
    return Ready(belly, bench, rules)


def random_gaits(at: Ready, n: int, seed: int = 0) -> GaitBatch:
    """Gaits of all joints about the posture."""
    rng, legs = np.random.default_rng(seed), at.belly.robot.n_legs
    modes = [2 * np.pi / mode.period for mode in rocking_modes(at.bench.model, at.belly.posture)]
    omega = rng.choice(modes, n) * rng.uniform(0.8, 1.2, n)
    offset = at.belly.posture + SWING * rng.normal(size=(n, legs))
    sine, cosine = SWING * rng.normal(size=(2, n, 1, legs))
    return GaitBatch(offset, np.zeros((n, legs)), sine, cosine, omega)


def measure(gaits: int = 10_000, best: int = 100) -> dict[str, float]:
    """Seconds of both parts, and how many gaits are feasible."""
    at = ready()
    some = random_gaits(at, gaits)
    at.bench(some.rows(slice(256)), clearance=False)  # compiled
    begin, used = time.perf_counter(), time.process_time()
    out = at.bench(some, clearance=False)
    names, slacks = at.rules.slacks(some, out)
    # Any direction will do; distances are asked for below.
    apart = np.isin(names, ("clearance", "separation", "direction"))
    value = at.rules.value(out)
    searched, used = time.perf_counter() - begin, time.process_time() - used
    feasible = (slacks[:, ~apart] >= 0).all(axis=1)
    order = np.lexsort((-value, ~feasible))[:best]
    shapes = at.belly.shapes
    clearances(shapes, at.bench.configurations(some.rows(order[:1]))[0], at.belly.ground)
    begin, coal = time.perf_counter(), time.process_time()
    every = at.bench.configurations(some.rows(order))
    # Coal holds the interpreter's lock: threads would not help.
    found = [clearances(shapes, one, at.belly.ground) for one in every]
    looked, coal = time.perf_counter() - begin, time.process_time() - coal
    clear = sum(bool(one.between.min() > 0) for one in found)
    return {
        "gaits": gaits, "seconds": searched, "core_seconds": used,
        "settled": int(np.isfinite(value).sum()),
        "feasible": int(feasible.sum()), "best": len(every), "instants": every.shape[1],
        "seconds_coal": looked, "core_seconds_coal": coal,
        "links_apart": clear,
    }  # fmt: skip


def main() -> None:
    """Print what was measured."""
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gaits", type=int, default=10_000)
    parser.add_argument("--best", type=int, default=100)
    for name, value in measure(**vars(parser.parse_args())).items():
        print(f"{name:18s} {value:.4g}")


if __name__ == "__main__":
    main()
