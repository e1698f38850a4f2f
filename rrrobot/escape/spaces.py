"""Spaces of gaits that a robot's symmetries leave: which legs do the same, and which the opposite.

A reflection or half turn of the robot maps leg angles by phi' = e phi[pi], a gait's amplitudes
alike. Gaits that are their own image, or its opposite (half a cycle later), are a space each; with
two reflections there are four. A goal that is its own image under a symmetry is best reached in
such a space, where travel in other directions vanishes: forward is its own image from left to
right, turning under the half turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import ParameterError
from rrrobot.robot.chains import leg_chains, symmetry_of
from rrrobot.robot.robot import Robot

GROUPS = ("all", "alike", "mirrored", "opposite", "front-back", "diagonal", "one leg")
"""Names of `spaces`: all joints free; all limbs alike, as mirrored by every symmetry; left and
right alike; left and right opposite, half a cycle apart; front and back alike; both alike or both
opposite, as a half turn maps them; one limb alone."""
_REFLECTIONS = ("left-right", "front-back")


class Group(NamedTuple):
    """Gaits that limbs move together in."""

    name: str
    """of `GROUPS`"""
    swings: Array
    """columns span the swings (legs, m)"""
    offsets: Array
    """columns span the postures that are their own images (legs, k)"""


def spaces(robot: Robot, groups: Sequence[str] = GROUPS) -> list[Group]:
    """The spaces of gaits that the robot has.

    Args:
        robot: any.
        groups: of `GROUPS`; those that the robot's limbs do not allow are left out.

    Raises:
        ParameterError: another name, or none that the robot has.
    """
    for name in groups:
        if name not in GROUPS:
            raise ParameterError(f"group is {name!r}: it must be one of {', '.join(GROUPS)}.")
    n = robot.n_legs
    maps = {}
    for kind in (*_REFLECTIONS, "half-turn"):
        found = symmetry_of(robot, kind)
        if found is not None:
            maps[kind] = np.array([found.image(row) for row in np.eye(n)]).T
    signs: dict[str, list[dict[str, int]]] = {
        "all": [{}],
        "alike": [dict.fromkeys(_REFLECTIONS, 1)],
        "mirrored": [{"left-right": 1, "front-back": e} for e in (1, -1)] + [{"left-right": 1}],
        "opposite": [{"left-right": -1, "front-back": e} for e in (1, -1)] + [{"left-right": -1}],
        "front-back": [{"front-back": e} for e in (1, -1)],
        "diagonal": [{"half-turn": e} for e in (1, -1)],
    }
    out: list[Group] = []
    for group in groups:
        if group == "one leg":
            for chain in leg_chains(robot):
                own = np.eye(n)[:, list(chain)]
                out.append(Group(group, own, own))
            continue
        for wanted in signs[group]:
            if all(kind in maps for kind in wanted):
                swings = _common(n, [(maps[kind], e) for kind, e in wanted.items()])
                if swings.shape[1]:
                    out.append(Group(group, swings, _common(n, [(maps[k], 1) for k in wanted])))
    if not out:
        raise ParameterError(
            f"{robot.name} has no limbs that mirror each other as {', '.join(groups)} would: "
            "use groups=('all',)."
        )
    return out


def _common(n: int, wanted: list[tuple[Array, int]]) -> Array:
    """Orthonormal basis of what every map keeps, up to its sign (n, m)."""
    project = np.eye(n)
    for image, sign in wanted:
        project = project @ (0.5 * (np.eye(n) + sign * image))
    left, size, _ = np.linalg.svd(project)
    return np.asarray(left[:, size > 0.5])


def symmetric(robot: Robot, offset: Array) -> Array:
    """Postures (..., legs) averaged with their images, where the robot has symmetries."""
    images = [offset]
    maps = [found for kind in _REFLECTIONS if (found := symmetry_of(robot, kind)) is not None]
    for use in product((False, True), repeat=len(maps)):
        image = offset
        for flag, one in zip(use, maps, strict=True):
            image = one.image(image) if flag else image
        images.append(image)
    return np.asarray(np.mean(images[1:], axis=0))
