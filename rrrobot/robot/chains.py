"""Limbs of a robot: which legs are of one chain, and which chains mirror each other.

A symmetry of a robot is a rotation or reflection S of the base's frame about a place, a permutation
pi of the legs and signs e with

    S (body of leg i at phi) = body of leg pi(i) at phi',      phi'_pi(i) = e_i phi_i

The bodies' centres of mass and joint axes tell it, at leg angles of no symmetry. The limits of the
joints have to be each other's images too: legs alike but for their knees, which all bend one way,
do not mirror each other from front to back.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.errors import ParameterError
from rrrobot.robot.joints import JointIndex
from rrrobot.robot.robot import Robot

SYMMETRIES = {
    "left-right": np.array((1.0, -1.0, 1.0)),
    "front-back": np.array((-1.0, 1.0, 1.0)),
    "half-turn": np.array((-1.0, -1.0, 1.0)),
}
"""Diagonal of S in the base's frame, x to the front and y to the left."""
_CLOSE = 0.02
"""Part of the robot's reach by which images may miss each other: real robots' files differ."""
_ALIKE = 0.05
"""By which limits of joints that mirror each other may differ [rad or m]."""


class Symmetry(NamedTuple):
    """How a symmetry maps leg coordinates: phi' = sign * phi[source]."""

    source: NDArray[np.int64]
    """for each leg, the one that it is the image of (legs,)"""
    sign: Array
    """(legs,)"""

    def image(self, leg_angle: Array) -> Array:
        """Leg coordinates (..., legs) of the mirrored posture."""
        return np.asarray(self.sign * leg_angle[..., self.source])


def leg_chains(robot: Robot) -> tuple[tuple[int, ...], ...]:
    """Legs (indices into `robot.legs`) of each limb, from the base outward; mimics left out.

    A limb is what hangs on the base by one joint; it may branch.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.robot.chains import leg_chains
        >>> leg_chains(rr.Robot.from_parameters())
        ((0,), (1,))
    """
    model = robot.model
    limbs: dict[int, list[int]] = {}
    for joint in range(2, model.njoints):
        if model.names[joint] not in robot.legs:
            continue
        first = joint
        while model.parents[first] > 1:
            first = model.parents[first]
        limbs.setdefault(first, []).append(robot.legs.index(model.names[joint]))
    return tuple(tuple(limb) for limb in limbs.values())


def symmetry_of(robot: Robot, kind: str) -> Symmetry | None:
    """How a robot's legs mirror each other, or None where they do not.

    Args:
        robot: any.
        kind: "left-right", "front-back" or "half-turn" (about the vertical).

    Raises:
        ParameterError: another kind.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.robot.chains import symmetry_of
        >>> found = symmetry_of(rr.Robot.from_parameters(), "left-right")
        >>> found.source.tolist(), found.sign.tolist()
        ([1, 0], [1.0, 1.0])
    """
    if kind not in SYMMETRIES:
        raise ParameterError(f"kind is {kind!r}: it must be one of {', '.join(SYMMETRIES)}.")
    mirror, places = SYMMETRIES[kind], _Places(robot)
    chains = leg_chains(robot)
    n = robot.n_legs
    # One chain after another: the image of each is the chain that comes nearest.
    source, sign = np.full(n, -1), np.ones(n)
    for chain in chains:
        alike = [other for other in chains if len(other) == len(chain)]
        fits = [(*places.match(chain, other, mirror), other) for other in alike]
        miss, signs, other = min(fits, key=lambda fit: fit[0])
        if miss > _CLOSE * places.reach or np.any(source[list(other)] >= 0):
            return None
        source[list(other)], sign[list(other)] = chain, signs
    found = Symmetry(source, sign)
    return found if _mirrors_limits(robot, found) else None


class Ties(NamedTuple):
    """Legs that are each other's images under a robot's symmetries, tied together."""

    group: NDArray[np.int64]
    """which group each leg is of (legs,)"""
    sign: Array
    """leg coordinates over those of the first leg of their group (legs,)"""


def ties_of(robot: Robot) -> Ties:
    """Groups of legs that mirror each other, with the signs that their axes give.

    Mirrored joints whose axes are written the same way turn opposite ways: two hips that swing out
    from the body together have angles of opposite signs if both axes point ahead, and of equal
    signs if each points its own way.

    Raises:
        ParameterError: no two legs mirror each other.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.robot.chains import ties_of
        >>> ties_of(rr.Robot.from_parameters())
        Ties(group=array([0, 0]), sign=array([1., 1.]))
    """
    group, sign = np.arange(robot.n_legs), np.ones(robot.n_legs)
    for kind in SYMMETRIES:
        found = symmetry_of(robot, kind)
        if found is None:
            continue
        for leg, source in enumerate(found.source):
            if group[leg] == group[source]:
                continue
            # phi_leg = e phi_source; a whole group takes the other's sign.
            turn = found.sign[leg] * sign[source] * sign[leg]
            mine = group == group[leg]
            sign[mine] *= turn
            group[mine] = group[source]
    first, group = np.unique(group, return_index=True, return_inverse=True)[1:]
    sign = sign * sign[first][group]
    if first.size == robot.n_legs:
        raise ParameterError(
            f"no two legs of {robot.name} mirror each other, so none can be tied: leave tied out, "
            "and give bounds for each leg."
        )
    return Ties(group, sign)


def _mirrors_limits(robot: Robot, found: Symmetry) -> bool:
    """Whether the range of each joint, within a turn either way, is the image of another's."""
    ends = np.array((robot.joints.lower, robot.joints.upper)).clip(-2 * np.pi, 2 * np.pi)
    images = np.sort(found.image(ends), axis=0)
    return bool(np.abs(images - ends).max(initial=0.0) <= _ALIKE)


class _Places:
    """Where the bodies of legs are, relative to the middle of the limbs' roots."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.model = robot, robot.model
        self.data = self.model.createData()
        self.index = JointIndex(self.model, robot.legs)
        self.joints = [self.model.getJointId(name) for name in robot.legs]
        self.neutral = pin.neutral(self.model)
        roots = [
            self.model.jointPlacements[self.joints[c[0]]].translation for c in leg_chains(robot)
        ]
        self.middle = np.mean(roots, axis=0)
        still = self.at(np.zeros(robot.n_legs), range(robot.n_legs))
        self.reach = max(0.01, float(np.abs(still[0]).max()))

    def at(self, leg_angle: Array, legs: Iterable[int]) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Centres of mass and joint axes (k, 3) of some legs' bodies; which joints turn (k,)."""
        q = self.neutral.copy()
        self.index.write(q, leg_angle)
        pin.computeJointJacobians(self.model, self.data, q)
        centers, axes = [], []
        for leg in legs:
            joint = self.joints[leg]
            place = self.data.oMi[joint]
            centers.append(place.act(self.model.inertias[joint].lever) - self.middle)
            axes.append(self.data.J[:, self.index.v[leg]].copy())
        both = np.array(axes)
        turns = np.any(both[:, 3:] != 0, axis=1)
        return np.array(centers), np.where(turns[:, None], both[:, 3:], both[:, :3]), turns

    def match(
        self, chain: tuple[int, ...], other: tuple[int, ...], mirror: Array
    ) -> tuple[float, Array]:
        """How far the image of a chain is from another [m], with the signs for it.

        The sign of a turning joint follows from its axis, which a reflection turns over.
        """
        zero = np.zeros(self.robot.n_legs)
        (_, axes, turns), (_, others, _) = self.at(zero, chain), self.at(zero, other)
        along = np.sum(mirror * axes * others, axis=1) * np.where(turns, np.prod(mirror), 1.0)
        signs = np.where(along >= 0, 1.0, -1.0)
        miss = 0.0
        for angles in np.random.default_rng(0).uniform(-0.7, 0.7, (4, len(chain))):
            own, image = zero.copy(), zero.copy()
            own[list(chain)], image[list(other)] = angles, signs * angles
            a, b = self.at(own, chain)[0], self.at(image, other)[0]
            miss = max(miss, float(np.abs(mirror * a - b).max()))
        return miss, signs
