"""Reduced-joint Pinocchio models: the robot on a chain of joints instead of a free-flyer."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.surfaces import SHELL_FRAME, Sphere
from rrrobot.errors import ModelError
from rrrobot.models.gravity import gravity_on
from rrrobot.robot.joints import build_model
from rrrobot.robot.robot import Robot, checked_robot
from rrrobot.robot.urdf import CHAINS, ReducedKind, reduced_urdf


def reduced_model(
    robot: Robot, kind: ReducedKind, ground: Ground, *, gravity: bool = True
) -> pin.Model:
    """Pinocchio model of the robot's reduced-joint URDF, its centre a radius above the ground.

    Raises:
        ModelError: the shell is no sphere, or the ground not level.
    """
    radius = pivot_radius(robot, kind, ground)
    centre = robot.shell_placement.translation
    urdf = reduced_urdf(robot.rooted_urdf, kind, height=radius, centre=centre)
    model = build_model(urdf, None, robot.legs, robot.locked)
    model.gravity.linear = np.array((0.0, 0.0, -gravity_on(robot, ground) if gravity else 0.0))
    parent = model.getJointId(CHAINS[kind][-1][0])
    frame = pin.Frame(SHELL_FRAME, parent, pin.SE3.Identity(), pin.FrameType.OP_FRAME)
    model.addFrame(frame)
    return model


def pivot_radius(robot: Robot, kind: str, ground: Ground) -> float:
    """Radius of the spherical shell, whose centre is the pivot [m].

    Raises:
        ModelError: the shell is no sphere, or the ground not level.
    """
    checked_robot(robot)
    if not isinstance(robot.shell, Sphere):
        raise ModelError(
            f"the {kind} model needs a spherical shell; this robot has {robot.shell}. Use the full "
            "model, which rolls on any strictly convex shell."
        )
    if not (isinstance(ground, Plane) and ground.is_level):
        raise ModelError(
            f"the {kind} model needs level ground, not {ground!r}. Use the full model."
        )
    return robot.shell.radius
