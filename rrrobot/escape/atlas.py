"""Small gaits of a robot about several postures, near its rocking modes: where a search begins."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits import GaitBatch
from rrrobot.errors import ModelError
from rrrobot.escape.bench import Bench
from rrrobot.escape.limits import Rules
from rrrobot.escape.loss import rocking_modes
from rrrobot.escape.polish import Judged, judge
from rrrobot.escape.small import (
    Complex,
    SmallGaits,
    best_small,
    cost,
    leaning,
    small_gaits,
    straight,
)
from rrrobot.escape.spaces import spaces
from rrrobot.models.base import Model
from rrrobot.robot.limits import JointEnds

NEAR = (0.8, 0.9, 1.0, 1.1, 1.2)
"""Frequencies over those of the rocking modes."""
_SCALES = np.geomspace(0.2, 4.0, 12)
_WAYS = 2
"""Eigenvectors of each space."""
_MOST_SWING = 0.8
"""Swing of a joint that makes a unit [rad]."""
_ALIKE = 0.9
_ASIDE = -4.0
"""Slack of a seed that goes elsewhere too: polishing leads it back."""


class Seed(NamedTuple):
    """A small gait that is best for a goal."""

    predicted: float
    """value of the goal at a^H M a = 1"""
    group: str
    """of `spaces`"""
    small: SmallGaits
    amplitude: Complex
    """(legs,)"""


class Atlas:
    """Forms of small gaits about postures at frequencies near the rocking modes.

    Args:
        bench: where gaits run.
        model: its model.
        postures: offsets (k, legs) [rad].
        ends: limits of the joints.
        tilt: allowed [rad].
        groups: see `spaces`.
        near: frequencies over those of the modes.
        stop: asked before each posture.

    Raises:
        ModelError: no posture rocks.
    """

    def __init__(
        self,
        bench: Bench,
        model: Model,
        postures: Array,
        ends: JointEnds,
        tilt: float,
        groups: tuple[str, ...],
        near: tuple[float, ...] = NEAR,
        stop: Callable[[], bool] = lambda: False,
    ) -> None:
        self.bench, self.ends, self.tilt = bench, ends, tilt
        self.spaces = spaces(model.robot, groups)
        self.forms: list[SmallGaits] = []
        self.rocking: list[Array] = []
        for offset in postures:
            if self.forms and stop():
                break
            omegas = rocking_frequencies(model, offset)
            self.rocking.append(omegas)
            if omegas.size:
                wanted = np.unique(np.outer(omegas, near).ravel())
                kept = wanted[np.concatenate(([True], np.diff(np.log(wanted)) > 0.03))]
                self.forms += small_gaits(bench, offset, kept)
        if not self.forms:
            raise ModelError(
                "no small gait about the postures settles: the robot does not rock about a stable "
                "rest there. See the belly's margin and reason, and fit_belly(posture=...)."
            )

    def room(self, small: SmallGaits) -> Array:
        """Largest swing of each leg (legs,) [rad]."""
        ends = self.ends
        sides = np.minimum(small.offset - ends.lower, ends.upper - small.offset)
        rate = 0.9 * ends.velocity / small.omega
        return np.clip(np.minimum(sides, rate), 0.02, _MOST_SWING)

    def seeds(self, rules: Rules, count: int) -> list[Seed]:
        """The best small gaits for a goal, no two alike."""
        found = []
        for small in self.forms:
            metric = cost(small, self.room(small), self.tilt)
            if rules.goal.leans:
                ahead, left, _ = rules.goal.weights
                a = leaning(small, metric, ahead, left)
                size = abs(np.dot(ahead * small.rocking[1] - left * small.rocking[0], a))
                found.append(Seed(float(size), "all", small, a))
                continue
            form = np.tensordot(rules.goal.weights, small.travel, 1)
            for group, basis in self.spaces:
                ways = best_small(form, metric, basis, _WAYS)
                if group == "all" and ways and not rules.goal.turns:
                    x, y, _ = rules.goal.weights
                    aside = (x * small.travel[1] - y * small.travel[0], small.travel[2])
                    ways.append(straight(form, aside, metric))
                for _, a in ways:
                    travel = np.real(np.einsum("j,kjl,l->k", a.conj(), small.travel, a))
                    if rules.goal.slack(travel[None], rules.length).min(initial=1.0) > _ASIDE:
                        value = float(rules.goal.value(travel[None])[0])
                        found.append(Seed(value, group, small, a))
        found.sort(key=lambda seed: -seed.predicted)
        chosen: list[Seed] = []
        for seed in found:
            if all(_apart(seed, other) for other in chosen):
                chosen.append(seed)
            if len(chosen) == count:
                break
        return chosen

    def grown(self, rules: Rules, seeds: list[Seed]) -> list[Judged]:
        """Of each seed, the best of its sizes that the limits allow."""
        k = len(_SCALES)
        swing = np.concatenate([np.outer(_SCALES, seed.amplitude) for seed in seeds])
        offset = np.repeat([seed.small.offset for seed in seeds], k, axis=0)
        gaits = GaitBatch(
            offset, np.zeros_like(offset), swing.real[:, None].copy(), swing.imag[:, None].copy(),
            np.repeat([seed.small.omega for seed in seeds], k),
        )  # fmt: skip
        found = judge(rules, gaits, self.bench(gaits))
        best = []
        for i in range(len(seeds)):
            one, *others = found[k * i : k * (i + 1)]
            for other in others:
                if np.isfinite(other.value) and other.better_than(one):
                    one = other
            best.append(one)
        return best


def _apart(seed: Seed, other: Seed) -> bool:
    """Whether two seeds are different ways to go: another posture, mode or pattern of the legs."""
    if not np.array_equal(seed.small.offset, other.small.offset):
        return True
    if abs(np.log(seed.small.omega / other.small.omega)) > 0.25:
        return True
    a, b = seed.amplitude, other.amplitude
    return bool(abs(a.conj() @ b) < _ALIKE * np.linalg.norm(a) * np.linalg.norm(b))


def rocking_frequencies(model: Model, offset: Array) -> Array:
    """Frequencies of the rocking modes about the rest in a posture [rad/s]; none if it tips."""
    return np.array([2 * np.pi / mode.period for mode in rocking_modes(model, offset)])
