"""Postures for rolling: legs clear of the ground over the range, nothing touching, mass low.

Each limb is searched by itself over its joints' limits, one for all that mirror it: legs of a robot
share nothing but its centre of mass. Capsules around the links tell the clearance in the search,
and Coal the distances of the best.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.belly.distances import leg_ranges
from rrrobot.belly.placed import Floors, Touches
from rrrobot.belly.shapes import Shapes
from rrrobot.checks import Array
from rrrobot.robot.chains import SYMMETRIES, leg_chains, symmetry_of
from rrrobot.robot.joints import JointIndex

_POINTS = 12
"""Power of two: postures of a limb that are tried."""
_ROUNDS = 2
_TRIED, _MOST = 400, 20
"""Postures of which Coal is asked whether links touch, and by how much where all do."""
_APART = 0.005
"""Distance of links that is wanted [m]."""
ASIDE = 0.5
"""What a metre of the centre of mass to the side costs, in metres of its height."""
_SHORT = 30.0
"""What a metre of clearance that is missing costs, likewise."""
_INSIDE = 0.04
"""Part of a joint's range that is kept to its ends."""


Capsule = tuple[int, Array, Array, float]


class Posture(NamedTuple):
    """Legs to roll with."""

    leg_angle: Array
    """(legs,) [rad or m]"""
    separation: float
    """least distance of two links that count, by Coal [m]; infinite if there are none"""


def find_posture(search: Search) -> Posture:
    """The posture of the lowest centre of mass with its limbs clear, as far as the search goes."""
    angle = search.start()
    groups = search.groups()
    for _ in range(_ROUNDS if len(groups) > 1 else 1):
        for group in groups:
            angle = search.improved(angle, group)
    return Posture(angle, search.separation(angle))


def judged(shapes: Shapes, at: Touches, leg_angle: Array) -> Posture:
    """What a given posture (legs,) has [rad or m]."""
    search = Search(shapes, at, np.zeros(2), 0.0, frozenset())
    return Posture(leg_angle, search.separation(leg_angle))


class Search:
    """Postures of a robot, limb by limb: what they lack in clearance, and where the mass is.

    `height` is what a metre of the centre of mass's height costs.

    Args:
        shapes: of the robot.
        at: the contacts over which the limbs are to be clear.
        middle: (x, y) above which the centre of mass is wanted [m].
        room: clearance wanted [m].
        covered: links that the shell holds, which need none.
        floor: of which limbs are to be clear, too.
        kinds: of symmetries that the postures have.
    """

    height = 1.0

    def __init__(
        self,
        shapes: Shapes,
        at: Touches,
        middle: Array,
        room: float,
        covered: frozenset[str],
        floor: Floors | None = None,
        kinds: Sequence[str] = tuple(SYMMETRIES),
    ) -> None:
        robot, self.floor = shapes.robot, floor
        self.robot, self.at, self.middle, self.room = robot, at, middle, room
        self.model, self.data = robot.model, robot.model.createData()
        self.index, self.q = JointIndex(robot.model, robot.legs), pin.neutral(robot.model)
        self.low, self.high = leg_ranges(robot)
        self.names = {name: k for k, name in enumerate(robot.legs)}
        self.capsules = [
            capsule
            for piece, capsule in zip(shapes.pieces, shapes.capsules, strict=True)
            if piece.joint > 1 and piece.link not in covered
        ]
        self.geometry = shapes.geometry
        self.apart = self.geometry.createData()
        self.symmetries = [s for kind in kinds if (s := symmetry_of(robot, kind)) is not None]

    def start(self) -> Array:
        """The posture nearest to zero within the limits."""
        edge = _INSIDE * (self.high - self.low)
        return np.clip(np.zeros(self.robot.n_legs), self.low + edge, self.high - edge)

    def groups(self) -> list[tuple[int, ...]]:
        """Limbs that are searched; the others mirror them."""
        seen: set[int] = set()
        found = []
        for limb in leg_chains(self.robot):
            if seen & set(limb):
                continue
            found.append(limb)
            seen |= self.moved(limb)
        return found

    def improved(self, angle: Array, limb: tuple[int, ...]) -> Array:
        """The best posture of a limb and its images, the others as they are."""
        return self._first_apart(self.candidates(angle, limb)[0], limb)

    def candidates(
        self, angle: Array, limb: tuple[int, ...], free: bool = False
    ) -> tuple[Array, Array]:
        """Postures (n, legs) of a limb and its images, the best first, and what each costs (n,).

        Whatever is in their way if `free`.
        """
        from scipy.stats import qmc

        legs = list(limb)
        unit = qmc.Sobol(len(legs), rng=np.random.default_rng(0)).random_base2(_POINTS)
        edge = _INSIDE * (self.high - self.low)
        low, high = (self.low + edge)[legs], (self.high - edge)[legs]
        mine = [] if free else self.capsules_of(self.moved(limb))
        trials = np.tile(angle, (len(unit) + 1, 1))
        trials[1:, legs] = low + unit * (high - low)
        trials = self.mirrored(trials, limb)
        cost = self.costs(trials, mine)
        spread = np.random.default_rng(1).normal(0, 0.03, (2, 256, len(legs))) * (high - low)
        for part in spread:
            # Finer about the best.
            more = np.repeat(trials[np.argsort(cost, kind="stable")[:8]], 32, axis=0)
            more[:, legs] = np.clip(more[:, legs] + part, low, high)
            more = self.mirrored(more, limb)
            trials, cost = np.vstack((trials, more)), np.append(cost, self.costs(more, mine))
        order = np.argsort(cost, kind="stable")
        return trials[order], cost[order]

    def unlike(self, trials: Array, limb: tuple[int, ...]) -> list[int]:
        """The first of postures (n, legs) that differ in a limb by enough to be worth a try."""
        legs = list(limb)
        return _spread(trials[:, legs], 0.06 * (self.high - self.low)[legs])

    def _first_apart(self, trials: Array, limb: tuple[int, ...]) -> Array:
        """The first of some postures in which nothing touches; if all do, that of the least."""
        tried = trials[self.unlike(trials, limb)]
        for request in self.apart.collisionRequests:
            request.security_margin = _APART
        for angle in tried:
            self.index.write(self.q, angle)
            if not pin.computeCollisions(
                self.model, self.data, self.geometry, self.apart, self.q, True
            ):
                return np.asarray(angle)
        return np.asarray(max(tried[:_MOST], key=self.separation))

    def moved(self, limb: tuple[int, ...]) -> set[int]:
        """The legs of a limb and of those that mirror it."""
        images = [np.flatnonzero(np.isin(one.source, limb)) for one in self.symmetries]
        return set(limb) | {int(k) for image in images for k in image}

    def mirrored(self, trials: Array, limb: tuple[int, ...]) -> Array:
        """Postures (n, legs) with the images of a limb as the limb has it."""
        for symmetry in self.symmetries:
            here = np.isin(symmetry.source, limb) & ~np.isin(np.arange(len(symmetry.source)), limb)
            trials[:, here] = symmetry.image(trials)[:, here]
        return trials

    def capsules_of(self, legs: set[int]) -> list[Capsule]:
        """Those that some legs move."""
        joints = set()
        for joint in range(2, self.model.njoints):
            above = joint
            while above > 1:
                if self.names.get(self.model.names[above]) in legs:
                    joints.add(joint)
                above = self.model.parents[above]
        return [capsule for capsule in self.capsules if capsule[0] in joints]

    def costs(self, trials: Array, capsules: list[Capsule]) -> Array:
        """Height of the centre of mass, its place to the side, what is not clear (n,) [m]."""
        centers, gaps = self.gaps(trials, capsules)
        aside = np.linalg.norm(centers[:, :2] - self.middle, axis=1)
        # Of each: what a housing lacks, no posture changes.
        short = np.maximum(0.0, self.room - gaps.min(axis=2)).sum(axis=1)
        out = np.maximum(0, self.low - trials) + np.maximum(0, trials - self.high)
        return self.height * centers[:, 2] + ASIDE * aside + _SHORT * short + out.sum(axis=1)

    def gaps(self, trials: Array, capsules: list[Capsule]) -> tuple[Array, Array]:
        """Centres of mass (n, 3), distances from ground and floor (n, capsules, touches) [m]."""
        centers = np.empty((len(trials), 3))
        ends = np.empty((len(trials), 2 * len(capsules), 3))
        for i, angle in enumerate(trials):
            self.index.write(self.q, angle)
            centers[i] = pin.centerOfMass(self.model, self.data, self.q)
            for k, (joint, a, b, _) in enumerate(capsules):
                place = self.data.oMi[joint]
                ends[i, 2 * k] = place.act(a)
                ends[i, 2 * k + 1] = place.act(b)
        return centers, self._gaps(ends, capsules)

    def _gaps(self, ends: Array, capsules: list[Capsule]) -> Array:
        """Distance of capsules from ground and floor (n, capsules, touches) [m], by their ends."""
        at, found = self.at, []
        radius = np.array([r for *_, r in capsules])
        for k, (point, normal) in enumerate(zip(at.point, at.normal, strict=True)):
            d = ends - point
            along = d @ normal
            gap = -along
            if at.curvature:
                excess = at.curvature * np.sum(d * d, axis=2) - 2 * along
                gap = excess / (1 + np.sqrt(np.maximum(1 + at.curvature * excess, 0.0)))
            if self.floor is not None:
                gap = np.minimum(gap, ends @ self.floor.up[k] - self.floor.height[k])
            found.append(np.minimum(gap[:, ::2], gap[:, 1::2]) - radius)
        return np.stack(found, axis=2)

    def separation(self, angle: Array) -> float:
        """Least distance of two links that count [m]."""
        if not len(self.geometry.collisionPairs):
            return float("inf")
        self.index.write(self.q, angle)
        pin.computeDistances(self.model, self.data, self.geometry, self.apart, self.q)
        return min(result.min_distance for result in self.apart.distanceResults)


def _spread(angles: Array, apart: Array) -> list[int]:
    """The first rows that differ from all before them by enough to be worth a try."""
    chosen: list[int] = []
    for i, row in enumerate(angles):
        near = np.abs(angles[chosen] - row) < apart
        if not chosen or not near.all(axis=1).any():
            chosen.append(i)
        if len(chosen) == _TRIED:
            break
    return chosen
