"""How a rock lets a robot go: place, speed, pose and a bound on the fall; whether it goes over."""

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


def goes_over(belly: Belly, run: Trajectory, side: Array) -> bool:
    """Whether a run ends with the centre of mass beyond the contact, or the energy to get there.

    Args:
        belly: of the robot.
        run: on its rock.
        side: horizontal unit vector in the base's frame (2,).
    """
    q = run.configuration[-1]
    center = pin.centerOfMass(belly.robot.model, belly.robot.model.createData(), q)
    arm = center - run.ground.point(run.position[-1])
    return bool(arm @ _out(q, side)[0] > 0 or _to_spare(belly, run, side) > 0)


def _to_spare(belly: Belly, run: Trajectory, side: Array) -> float:
    """Energy left over once it has gone over the contact to a side, for a unit of mass [J/kg].

    As if the legs were held and the contact stayed from a run's end on: with the angular momentum L
    and the inertia I about it, and the centre of mass to rise by d until it is above it,

        L |L| / (2 I m) - g d,      d = 0 where it is beyond it
    """
    own, q, mass = belly.robot.model, run.configuration[-1], belly.robot.mass
    data = own.createData()
    pin.computeCentroidalMomentum(own, data, q, run.velocity[-1])
    arm = data.com[0] - run.ground.point(run.position[-1])
    outward, axis = _out(q, side)
    turning = float((data.hg.angular + np.cross(arm, data.hg.linear)) @ axis)
    inertia = float(axis @ data.Ig.inertia @ axis) + mass * float(np.sum(np.cross(axis, arm) ** 2))
    rise = float(np.linalg.norm(arm) - arm[2]) if arm @ outward < 0 else 0.0
    return turning * abs(turning) / (2.0 * inertia * mass) - run.gravity * rise


def _out(q: Array, side: Array) -> tuple[Array, Array]:
    """Horizontal unit vectors: to a side of the base, and the axis about which it tips there."""
    out = pin.Quaternion(q[3:7].copy()).toRotationMatrix()[:, :2] @ side
    out[2] = 0.0
    out /= np.linalg.norm(out)
    return out, np.cross((0.0, 0.0, 1.0), out)
