"""How a rock lets a robot go: place, speed and pose at a run's end, and a bound on the fall."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.belly.found import Belly
from rrrobot.checks import Array
from rrrobot.simulation.trajectory import Trajectory


class Landing(NamedTuple):
    """Where and how a robot is as its rock lets it go, or as it reaches the floor."""

    ahead: float
    """base's origin from the top of the rock, to where the robot faced at rest [m]"""
    left: float
    """and to the left of that [m]"""
    heading: float
    """which way it faces, to the left of where it faced at rest [rad]"""
    tilt: float
    """angle of its z axis from the vertical; beyond pi/2 it lies on its side or back [rad]"""
    speed: float
    """of the centre of mass [m/s]"""
    room: float
    """height of its lowest point above the floor [m]"""
    impact: float
    """largest speed at which the centre of mass can come down to the floor from there,
    sqrt(speed^2 + 2 g room) [m/s]"""


def landing(belly: Belly, run: Trajectory, depth: float) -> Landing:
    """Of the last sample of a run."""
    model, data = belly.robot.model, belly.robot.model.createData()
    pin.centerOfMass(model, data, run.configuration[-1], run.velocity[-1])
    speed = float(np.linalg.norm(data.vcom[0]))
    room = max(0.0, float(heights(belly, run.configuration[-1]).min()) + depth)
    turn = pin.Quaternion(run.configuration[-1, 3:7].copy()).toRotationMatrix()
    ahead, left = run.configuration[-1, :2].tolist()
    return Landing(
        ahead, left, float(np.arctan2(turn[1, 0], turn[0, 0])),
        float(np.arccos(np.clip(turn[2, 2], -1.0, 1.0))), speed, room,
        float(np.sqrt(speed**2 + 2.0 * run.gravity * room)),
    )  # fmt: skip


def heights(belly: Belly, q: Array) -> Array:
    """Heights of the pieces over the boulder's top (pieces,) [m]."""
    own, data = belly.robot.model, belly.robot.model.createData()
    pin.forwardKinematics(own, data, q)
    return np.array([
        float((piece.points @ data.oMi[piece.joint].rotation[2]).min())
        + data.oMi[piece.joint].translation[2] - piece.radius
        for piece in belly.shapes.pieces
    ])  # fmt: skip
