"""Small gaits of a robot about several postures, near its rocking modes: where a search begins."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
from rrrobot.escape.spaces import Group, spaces
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
    group: Group
    """that it is of"""
    small: SmallGaits
    amplitude: Complex
    """(legs,)"""
    bench: Bench
    """for gaits about its posture"""


class Atlas:
    """Forms of small gaits about postures at frequencies near the rocking modes.

    Args:
        model: of the benches.
        postures: offsets (k, legs) [rad].
        benches: where gaits about each posture run.
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
        model: Model,
        postures: Array,
        benches: Sequence[Bench],
        ends: JointEnds,
        tilt: float,
        groups: tuple[str, ...],
        near: tuple[float, ...] = NEAR,
        stop: Callable[[], bool] = lambda: False,
    ) -> None:
        self.ends, self.tilt = ends, tilt
        self.spaces = spaces(model.robot, groups)
        self.forms: list[tuple[SmallGaits, Bench]] = []
        self.rocking: list[Array] = []
        for offset, bench in zip(postures, benches, strict=True):
            if self.forms and stop():
                break
            omegas = rocking_frequencies(model, offset)
            self.rocking.append(omegas)
            if omegas.size:
                wanted = np.unique(np.outer(omegas, near).ravel())
                kept = wanted[np.concatenate(([True], np.diff(np.log(wanted)) > 0.03))]
                self.forms += [(small, bench) for small in small_gaits(bench, offset, kept)]
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
        for small, bench in self.forms:
            every = Group("all", np.eye(small.offset.size), np.eye(small.offset.size))
            metric = cost(small, self.room(small), self.tilt)
            if rules.goal.leans:
                ahead, left, _ = rules.goal.weights
                a = leaning(small, metric, ahead, left)
                size = abs(np.dot(ahead * small.rocking[1] - left * small.rocking[0], a))
                if size > 0:
                    found.append(Seed(float(size), every, small, a, bench))
                continue
            form = np.tensordot(rules.goal.weights, small.travel, 1)
            for group in self.spaces:
                ways = best_small(form, metric, group.swings, _WAYS)
                if group.name == "all" and ways and not rules.goal.turns:
                    x, y, _ = rules.goal.weights
                    aside = (x * small.travel[1] - y * small.travel[0], small.travel[2])
                    ways.append(straight(form, aside, metric))
                for _, a in ways:
                    travel = np.real(np.einsum("j,kjl,l->k", a.conj(), small.travel, a))
                    if rules.goal.slack(travel[None], rules.length).min(initial=1.0) > _ASIDE:
                        value = float(rules.goal.value(travel[None])[0])
                        found.append(Seed(value, group, small, a, bench))
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
        return [self._grown(rules, seed) for seed in seeds]

    @staticmethod
    def _grown(rules: Rules, seed: Seed) -> Judged:
        k, swing = len(_SCALES), np.outer(_SCALES, seed.amplitude)
        offset = np.tile(seed.small.offset, (k, 1))
        gaits = GaitBatch(
            offset, np.zeros_like(offset), swing.real[:, None].copy(), swing.imag[:, None].copy(),
            np.full(k, seed.small.omega),
        )  # fmt: skip
        one, *others = judge(rules, gaits, seed.bench(gaits))
        for other in others:
            if np.isfinite(other.value) and other.better_than(one):
                one = other
        return one


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
