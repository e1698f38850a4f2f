"""The gravity that acts in a model."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from rrrobot.contact.ground import Ground
from rrrobot.robot.robot import Robot


def gravity_on(robot: Robot, ground: Ground) -> float:
    """g of a robot on a ground [m/s^2]: the ground's, or the robot's own."""
    return robot.gravity if ground.gravity is None else ground.gravity


def at_gravity(model: pin.Model, gravity: float) -> pin.Model:
    """The Pinocchio model under a gravity along -z [m/s^2]: itself if it has that already."""
    if model.gravity.linear[2] == -gravity:
        return model
    other = model.copy()
    other.gravity.linear = np.array((0.0, 0.0, -gravity))
    return other
