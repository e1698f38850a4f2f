"""Pinocchio models of checked URDF text, and where named joints stand in them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.errors import UrdfError
from rrrobot.robot.reader import parse_urdf, urdf_text

# Pinocchio's memory grows with the cube of the freedoms: 240 MB here, tens of GB for 1000.
_MAX_LEGS = 150


class JointIndex:
    """Where named one-degree-of-freedom joints stand in q and v of a Pinocchio model.

    A `continuous` joint takes (cos, sin) in q, every other joint its coordinate.

    Attributes:
        v: index of each joint in the velocity, shape (joints,).
    """

    def __init__(self, model: pin.Model, names: Sequence[str]) -> None:
        joints = [model.joints[model.getJointId(name)] for name in names]
        self.v = np.array([joint.idx_v for joint in joints], dtype=int)
        self._q = np.array([joint.idx_q for joint in joints], dtype=int)
        wide = np.array([joint.nq == 2 for joint in joints], dtype=bool)
        self._wide = np.flatnonzero(wide)
        self._plain = np.flatnonzero(~wide)

    def write(self, q: Array, angles: Array) -> None:
        """Put joint coordinates (joints,) [rad or m] into q, in place."""
        if self._wide.size == 0:
            q[self._q] = angles
            return
        q[self._q[self._plain]] = angles[self._plain]
        q[self._q[self._wide]] = np.cos(angles[self._wide])
        q[self._q[self._wide] + 1] = np.sin(angles[self._wide])


def sliding(model: pin.Model, names: Sequence[str]) -> NDArray[np.bool_]:
    """Which of the named joints slide instead of turning (joints,)."""
    kinds = [model.joints[model.getJointId(name)].shortname() for name in names]
    return np.array([kind.startswith("JointModelP") for kind in kinds], dtype=bool)


def build_model(
    urdf: str, root_joint: Any, legs: Sequence[str], locked: Mapping[str, float]
) -> pin.Model:
    """Pinocchio model of a URDF text with the `locked` joints held at their positions.

    Raises:
        UrdfError: Pinocchio cannot read it, a name is missing, a joint has several freedoms.
    """
    # Pinocchio's own parser drops some malformed parts without a word and stops the process on
    # others; check first, and hand on what was checked.
    text = urdf_text(parse_urdf(urdf))
    try:
        model = (
            pin.buildModelFromXML(text)
            if root_joint is None
            else pin.buildModelFromXML(text, root_joint)
        )
    except (ValueError, RuntimeError) as error:
        raise UrdfError(
            f"Pinocchio cannot read the URDF: {error} Its parser says why on the standard error."
        ) from None
    movable = [name for name in model.names[1:] if name != "root_joint"]
    for name in (*legs, *locked):
        if name not in movable:
            raise UrdfError(
                f"the robot has no movable joint {name!r}. Its movable joints are: "
                f"{', '.join(movable) or 'none'}."
            )
    for name in movable:
        joint = model.joints[model.getJointId(name)]
        if joint.nv != 1:
            raise UrdfError(
                f"joint {name!r} has {joint.nv} degrees of freedom: each joint of the tree must "
                "have one (revolute, continuous or prismatic)."
            )
    if locked:
        q = pin.neutral(model)
        index = JointIndex(model, list(locked))
        index.write(q, np.array(list(locked.values())))
        model = pin.buildReducedModel(model, [model.getJointId(name) for name in locked], q)
    return model


def movable_joints(text: str) -> tuple[str, ...]:
    """Names of a URDF's movable joints, in Pinocchio's order."""
    model = build_model(text, pin.JointModelFreeFlyer(), (), {})
    return tuple(name for name in model.names if name not in ("universe", "root_joint"))


def check_masses(model: pin.Model) -> None:
    """Refuse a free-flyer model that no dynamics can be computed of.

    Raises:
        UrdfError: too many joints, no mass, or a mass matrix that is not finite and positive.
    """
    legs = model.nv - 6
    if legs > _MAX_LEGS:
        raise UrdfError(
            f"the robot has {legs} moving joints: the limit is {_MAX_LEGS}; name fewer legs, and "
            "the other joints are held."
        )
    mass = float(pin.computeTotalMass(model))
    if not (math.isfinite(mass) and mass > 0):
        raise UrdfError(f"the robot's total mass is {mass} kg: it must be above zero.")
    matrix = pin.crba(model, model.createData(), pin.neutral(model))
    if not np.all(np.isfinite(matrix)):
        raise UrdfError("the robot's mass matrix is not finite: a mass or a length is too large.")
    values = np.linalg.eigvalsh(matrix)
    if values[0] < -1e-9 * values[-1]:
        raise UrdfError(
            "the robot's mass matrix is not positive: an <inertia> has a negative principal moment."
        )
