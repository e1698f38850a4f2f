"""How a belly rests on its ground: the rest pose, its stability, the modes there.

Where the contact is level, the tilting stiffness is M g [(H^-1 + B)^-1 - h] with the belly's radii
of curvature H, the ground's curvature B and the height h of the centre of mass over the contact:
the rest is stable where the centre of mass is below the lower centre of curvature that the two
together have. A roll takes the curvature across, a pitch that along.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.contact.boulder import Boulder
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.touching import touch
from rrrobot.errors import RRRobotError
from rrrobot.models.full import FullModel
from rrrobot.orbits.oscillations import Mode, equilibrium, modes

_GROWS = 1e-5
"""Rate of growth from which a mode counts as unstable [1/s]; a drift's is rounding."""


class Rest(NamedTuple):
    """How a robot rests with its legs held."""

    euler: Array
    """roll, pitch, yaw (3,) [rad]"""
    position: Array
    """of the contact, in the ground's coordinates (2,) [m]"""
    modes: tuple[Mode, ...]
    """undamped, see `orbits.modes`"""

    @property
    def stable(self) -> bool:
        """Whether no small deviation grows."""
        return all(mode.decay_rate > -_GROWS for mode in self.modes)


def rest_of(model: FullModel, leg_angle: Array) -> Rest | str:
    """The rest nearest to upright, or why there is none."""
    try:
        pose = equilibrium(model, leg_angle)
        place = model.place(pose)
        euler = model.turned(pose[None], np.zeros(3))[0]
        if np.abs(euler[:2]).max() > np.pi / 2:
            return "it rests only on its side or its back"
        return Rest(euler, place.position, tuple(modes(model, leg_angle, euler)))
    except (RRRobotError, np.linalg.LinAlgError, FloatingPointError) as error:
        return str(error)


def standing(model: FullModel, leg_angle: Array) -> tuple[float, Array]:
    """Upright on the ground's origin: height h of the centre of mass [m], effective radii (2,) [m].

    The radii are those of belly and ground together, (H^-1 + B)^-1, for roll and for pitch.
    """
    robot, ground = model.robot, model.ground
    pose = model.make_pose(np.zeros(3), np.zeros(2))
    q = model.configuration(pose, leg_angle)
    center = pin.centerOfMass(model.model, model.data, q)
    turn = np.array(robot.shell_placement.rotation)
    contact = touch(robot.shell, ground, turn, np.zeros(2))
    normal = contact.normal
    height = float(normal @ (center - contact.point))
    basis = _along_axes(normal)
    curvature = basis @ ground.curvature(contact.point) @ basis.T
    if isinstance(robot.shell, FlatBelly) and isinstance(ground, Boulder):
        return height, np.full(2, ground.radius)
    hessian = turn @ robot.shell.hessian(-turn.T @ normal) @ turn.T
    both = np.linalg.inv(np.linalg.inv(basis @ hessian @ basis.T) + curvature)
    return height, np.array((both[1, 1], both[0, 0]))


def _along_axes(normal: Array) -> Array:
    """Two tangents (2, 3): over the world's x, and across it."""
    first = np.array((1.0, 0.0, 0.0)) - normal[0] * normal
    first /= np.linalg.norm(first)
    return np.array((first, np.cross(normal, first)))
