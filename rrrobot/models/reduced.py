"""Reduced-joint Pinocchio models: the robot on a chain of joints instead of a free-flyer."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.surfaces import SHELL_FRAME, Sphere
from rrrobot.errors import ModelError
from rrrobot.models.gravity import gravity_on
from rrrobot.robot.joints import build_model
from rrrobot.robot.robot import Robot
from rrrobot.robot.urdf import CHAINS, ReducedKind, reduced_urdf


def reduced_model(
    robot: Robot, kind: ReducedKind, ground: Ground, *, gravity: bool = True
) -> pin.Model:
    """Pinocchio model of the robot's reduced-joint URDF, its centre a radius above the ground.

    Raises:
        ModelError: the shell is no sphere about the root link's origin, or the ground not level.
    """
    radius = pivot_radius(robot, kind, ground)
    urdf = reduced_urdf(robot.rooted_urdf, kind, height=radius)
    model = build_model(urdf, None, robot.legs, robot.locked)
    model.gravity.linear = np.array((0.0, 0.0, -gravity_on(robot, ground) if gravity else 0.0))
    parent = model.getJointId(CHAINS[kind][-1][0])
    frame = pin.Frame(SHELL_FRAME, parent, pin.SE3.Identity(), pin.FrameType.OP_FRAME)
    model.addFrame(frame)
    return model


def pivot_radius(robot: Robot, kind: str, ground: Ground) -> float:
    """Radius of the spherical shell about the pivot [m].

    Raises:
        ModelError: the shell is no sphere about the root link's origin, or the ground not level.
    """
    if not isinstance(robot.shell, Sphere):
        raise ModelError(
            f"the {kind} model needs a spherical shell; this robot has {robot.shell}. Use the full "
            "model, which rolls on any strictly convex shell."
        )
    center = robot.shell_placement.translation
    if np.any(np.abs(center) > 1e-12):
        raise ModelError(
            f"the {kind} model turns about the root link's origin, which must be the shell's "
            f"centre; this robot's shell is centred at {center.tolist()} m. Move the root link's "
            "frame to the centre, or use the full model."
        )
    if not (isinstance(ground, Plane) and ground.is_level):
        raise ModelError(
            f"the {kind} model needs level ground, not {ground!r}. Use the full model."
        )
    return robot.shell.radius
