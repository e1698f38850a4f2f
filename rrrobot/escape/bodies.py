"""A belly's robot as capsules for the search, its size, and which legs may move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rrrobot.belly.found import Belly
from rrrobot.belly.shapes import Shapes
from rrrobot.checks import Array
from rrrobot.errors import ParameterError
from rrrobot.escape.capsules import Capsules
from rrrobot.robot.chains import leg_chains


def capsules_of(shapes: Shapes, covered: tuple[str, ...]) -> tuple[Capsules, int]:
    """Capsules of a robot's links for `Bench`, and how many limbs there are.

    The base and the links that the shell holds have pairs, and no heights.
    """
    robot = shapes.robot
    chains = leg_chains(robot)
    limb_of = {robot.legs[k]: i for i, chain in enumerate(chains) for k in chain}
    body, ends, radius, limb = [], [], [], []
    for piece, (_, first, second, r) in zip(shapes.pieces, shapes.capsules, strict=True):
        body.append(piece.joint - 1)
        ends.append((first, second))
        radius.append(r)
        free = piece.link in covered or piece.joint <= 1
        name = robot.model.names[piece.joint]
        limb.append(len(chains) if free else limb_of.get(name, len(chains)))
    return Capsules(
        np.array(body, dtype=np.int64), np.array(ends).reshape(-1, 2, 3), np.array(radius),
        np.array(limb, dtype=np.int64), np.array(shapes.pairs, dtype=np.int64).reshape(-1, 2),
        np.zeros(len(shapes.pairs)),
    ), len(chains)  # fmt: skip


def base_length(shapes: Shapes) -> float:
    """Largest extent of the base along x or y [m]."""
    points = np.vstack([piece.points for piece in shapes.on_joint(1)])
    return float(np.ptp(points[:, :2], axis=0).max())


def with_legs(belly: Belly, joints: tuple[str, ...]) -> Belly:
    """The belly of the robot with only some joints as legs, the others held in its posture.

    Raises:
        ParameterError: a joint that is none of the robot's legs.
    """
    robot = belly.robot
    for name in joints:
        if name not in robot.legs:
            raise ParameterError(
                f"joint {name!r} is none of the robot's: they are {', '.join(robot.legs)}."
            )
    posture = dict(zip(robot.legs, belly.posture.tolist(), strict=True))
    held = {name: angle for name, angle in posture.items() if name not in joints}
    some = replace(robot, legs=tuple(joints), locked={**robot.locked, **held})
    moving: Array = np.array([posture[name] for name in joints])
    return replace(belly, robot=some, posture=moving, shapes=belly.shapes.on(some))
