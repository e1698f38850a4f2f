"""A robot at rest on its ground, at any heading: how it stands, and how long it rocks on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.contact.ground import Plane
from rrrobot.contact.surfaces import Sphere
from rrrobot.errors import ModelError
from rrrobot.models.base import Model
from rrrobot.momentum.coefficients import coefficients
from rrrobot.orbits.oscillations import equilibrium, modes
from rrrobot.rotations import euler_from_quaternion

_FADED = 12.0
"""Time constants after which a rocking has faded to 6e-6 of itself."""


class Rest(NamedTuple):
    """A robot at rest with its legs held."""

    leg_angle: Array
    """(legs,) [rad]"""
    euler: Array
    """roll, pitch and yaw (3,) [rad]"""
    settling: float
    """how long the body rocks on once the legs are still [s]"""


def rest_of(model: Model, leg_angle: Array, yaw: float = 0.0) -> Rest:
    """How the body stands with these legs at a yaw, and how long it takes to come to it.

    Raises:
        ModelError: it tips over, or its rocking never fades.
    """
    euler = standing(model, leg_angle, yaw)
    rocking = [m for m in modes(model, leg_angle, euler) if np.isfinite(m.period)]
    slowest = min((m.decay_rate for m in rocking), default=0.0)
    if slowest <= 1e-3:
        raise ModelError(
            f"with the legs at {np.round(leg_angle, 4).tolist()} rad the robot's rocking does not "
            "fade (its damping is none, or it tips over), so it never rests: give the model a "
            "damping, or choose other legs with rest=."
        )
    return Rest(np.asarray(leg_angle, dtype=float), euler, _FADED / slowest)


def standing(model: Model, leg_angle: Array, yaw: float = 0.0) -> Array:
    """Roll, pitch and yaw (3,) at which the body rests with the legs held [rad].

    On a plane with the normal n a sphere stands where its centre of mass c, from its own centre,
    is above the contact: R c + r n is vertical. So e = R c is known, and of R = Rz Ry Rx

        (Rx c)_y = (Rz^T e)_y   gives the roll,   Ry (Rx c) = Rz^T e   then the pitch.

    Raises:
        ModelError: there is no such rest.
    """
    shell, ground = model.robot.shell, model.ground
    if type(shell) is not Sphere or type(ground) is not Plane:
        start = np.array((0.0, 0.0, yaw))
        for _ in range(20):  # the search for rest turns the body, about as much each time
            pose = equilibrium(model, leg_angle, start)
            euler = np.asarray(euler_from_quaternion(model.place(pose).quaternion))
            turn = (yaw - euler[2] + np.pi) % (2 * np.pi) - np.pi
            start[2] += turn
            if abs(turn) < 1e-11:
                break
        return np.array((*euler[:2], yaw))
    legs = np.asarray(leg_angle, dtype=float)[None]
    c = coefficients(model.robot, legs, np.zeros_like(legs))[0, :3] / model.robot.mass
    aside = -shell.radius * ground.normal_vector[:2]
    depth = c @ c - aside @ aside
    if depth <= 0:
        raise ModelError(
            f"with the legs at {np.round(leg_angle, 4).tolist()} rad the robot rolls down: its "
            f"centre of mass is {np.sqrt(c @ c):.4g} m from the sphere's centre, and the slope "
            f"needs {np.hypot(*aside):.4g} m."
        )
    cos, sin = np.cos(yaw), np.sin(yaw)
    x, y = cos * aside[0] + sin * aside[1], cos * aside[1] - sin * aside[0]
    across = np.hypot(c[1], c[2])
    if across <= abs(y):
        raise ModelError(f"no rest was found for the legs at {np.round(leg_angle, 4).tolist()}.")
    roll = np.arcsin(y / across) - np.arctan2(c[1], -c[2])
    pitch = np.arctan2(-np.sqrt(across**2 - y**2), c[0]) - np.arctan2(-np.sqrt(depth), x)
    return np.array([*((a + np.pi) % (2 * np.pi) - np.pi for a in (roll, pitch)), yaw])


def radius_of(model: Model) -> float:
    """Half the shell's width [m]."""
    shell = model.robot.shell
    return max(shell.support(np.array(u)) for u in ((1.0, 0, 0), (0, 1.0, 0)))
