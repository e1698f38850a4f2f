"""A belly's robot as capsules for the search, its size, and which legs may move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from rrrobot.belly.shapes import Piece, Shapes
from rrrobot.checks import Array
from rrrobot.errors import ParameterError
from rrrobot.escape.capsules import Capsules
from rrrobot.robot.chains import leg_chains
from rrrobot.robot.robot import Robot


def capsules_of(robot: Robot, shapes: Shapes, covered: tuple[str, ...]) -> tuple[Capsules, int]:
    """Capsules of a robot's links for `Bench`, and how many limbs there are.

    The base and the links that the shell holds have pairs, and no heights. Joints of the robot that
    do not move, of which `shapes` may know, are part of what carries them.
    """
    model = robot.model
    chains = leg_chains(robot)
    limb_of = {robot.legs[k]: i for i, chain in enumerate(chains) for k in chain}
    body, ends, radius, limb = [], [], [], []
    placed = Shapes(robot, tuple(placed_on(robot, shapes)))
    for piece, (_, first, second, r) in zip(placed.pieces, placed.capsules, strict=True):
        body.append(piece.joint - 1)
        ends.append((first, second))
        radius.append(r)
        name = model.names[piece.joint]
        free = piece.link in covered or piece.joint <= 1
        limb.append(len(chains) if free else limb_of.get(name, len(chains)))
    return Capsules(
        np.array(body, dtype=np.int64), np.array(ends).reshape(-1, 2, 3), np.array(radius),
        np.array(limb, dtype=np.int64), np.array(shapes.pairs, dtype=np.int64).reshape(-1, 2),
    ), len(chains)  # fmt: skip


def placed_on(robot: Robot, shapes: Shapes) -> list[Piece]:
    """The pieces on the joints of a robot of the same URDF, some of whose joints may be held."""
    model, own = robot.model, shapes.robot.model
    found = []
    for piece in shapes.pieces:
        before = own.frames[own.getFrameId(piece.link, pin.FrameType.BODY)].placement
        frame = model.frames[model.getFrameId(piece.link, pin.FrameType.BODY)]
        move = frame.placement * before.inverse()
        points = piece.points @ move.rotation.T + move.translation
        found.append(Piece(piece.link, int(frame.parentJoint), points, piece.radius))
    return found


def base_length(shapes: Shapes) -> float:
    """Largest extent of the base along x or y [m]."""
    points = np.vstack([piece.points for piece in shapes.on_joint(1)])
    return float(np.ptp(points[:, :2], axis=0).max())


def with_legs(robot: Robot, posture: Array, joints: tuple[str, ...]) -> tuple[Robot, Array]:
    """The robot with only some joints as legs, the others held in the posture; their posture.

    Raises:
        ParameterError: a joint that is none of the robot's legs.
    """
    for name in joints:
        if name not in robot.legs:
            raise ParameterError(
                f"joint {name!r} is none of the robot's: they are {', '.join(robot.legs)}."
            )
    held = {
        name: float(angle)
        for name, angle in zip(robot.legs, posture, strict=True)
        if name not in joints
    }
    some = replace(robot, legs=tuple(joints), locked={**robot.locked, **held})
    return some, posture[[robot.legs.index(name) for name in joints]]
