"""Pinocchio models of checked URDF text, and where named joints stand in them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.checks import Array, vector
from rrrobot.errors import ModelError, ParameterError, UrdfError
from rrrobot.robot.faults import listed, root_link, shown
from rrrobot.robot.mimics import couple, couplings, restore_names
from rrrobot.robot.reader import parse_urdf
from rrrobot.robot.tree import for_pinocchio, turn_over

# Pinocchio's memory grows with the cube of the freedoms: 240 MB here, tens of GB for 1000.
_MAX_LEGS = 150
_OF_JOINT = " (joint)"
_UNIT = 1e-6
"""By how much the length of a quaternion may differ from one."""


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

    def read(self, q: Array) -> Array:
        """Joint coordinates (joints,) [rad or m] of q; continuous ones' within half a turn."""
        out: Array = q[self._q].copy()
        if self._wide.size:
            out[self._wide] = np.arctan2(q[self._q[self._wide] + 1], q[self._q[self._wide]])
        return out


def sliding(model: pin.Model, names: Sequence[str]) -> NDArray[np.bool_]:
    """Which of the named joints slide instead of turning (joints,)."""
    kinds = [model.joints[model.getJointId(name)].shortname() for name in names]
    return np.array([kind.startswith("JointModelP") for kind in kinds], dtype=bool)


def build_model(
    urdf: str,
    root_joint: Any,
    legs: Sequence[str],
    locked: Mapping[str, float],
    base: str | None = None,
) -> pin.Model:
    """Pinocchio model of a URDF text with the `locked` joints held at their positions.

    A mimic joint that is not locked follows its leg: its freedom is the leg's.

    Args:
        urdf: the text.
        root_joint: of the base; None for a fixed one.
        legs: joints that must be there and have one freedom each.
        locked: joint name -> position [rad or m].
        base: link that is to be the root; see `turn_over`.

    Raises:
        UrdfError: Pinocchio cannot read it, a name is missing, a joint has several freedoms.
    """
    tree = parse_urdf(urdf)
    if base is not None:
        turn_over(tree, base, locked)
    movable = _moving(tree)
    for name in (*legs, *locked):
        if name not in movable:
            raise UrdfError(
                f"the URDF has no movable joint {shown(name)}; its movable joints are: "
                f"{listed(movable) or 'none'}."
            )
    every = couplings(tree, locked)
    held = dict(locked)
    for name, (leg, ratio, offset) in every.items():
        if leg in locked or ratio == 0:
            held[name] = ratio * locked.get(leg, 0.0) + offset
    follow = {name: coupling for name, coupling in every.items() if name not in held}
    for name in [leg for leg in legs if leg in follow]:
        raise UrdfError(
            f"joint {shown(name)} mimics {shown(follow[name].leg)}: it follows by itself, so leave "
            "it out of legs, or hold it still with locked={...: 0.0}."
        )
    renamed = couple(tree, follow)
    model = _pinocchio_model(for_pinocchio(tree), root_joint)
    restore_names(model, renamed)
    for name in (*legs, *held):
        freedoms = model.joints[model.getJointId(name)].nv
        if freedoms != 1:
            raise UrdfError(
                f"joint {shown(name)} has {freedoms} degrees of freedom: each joint of the tree "
                "must have one (revolute, continuous or prismatic)."
            )
    if held:
        q = pin.neutral(model)
        index = JointIndex(model, list(held))
        index.write(q, np.array(list(held.values())))
        indices = [model.getJointId(name) for name in held]
        # Pinocchio looks frames up by their names alone, which links and joints may share.
        _rename(model, lambda name: name + _OF_JOINT)
        model = pin.buildReducedModel(model, indices, q)
        _rename(model, lambda name: name.removesuffix(_OF_JOINT))
    return model


def _rename(model: pin.Model, renamed: Callable[[str], str]) -> None:
    """Change the names of joints, and of all frames but the bodies'."""
    for i, name in enumerate(model.names.tolist()):
        model.names[i] = renamed(name)
    for frame in model.frames:
        if frame.type != pin.FrameType.BODY:
            frame.name = renamed(frame.name)


def _pinocchio_model(text: str, root_joint: Any) -> pin.Model:
    root = () if root_joint is None else (root_joint,)
    try:
        return pin.buildModelFromXML(text, *root, mimic=True)
    except (ValueError, RuntimeError) as error:
        reason = str(error).strip().splitlines() or [""]
        raise UrdfError(
            f"Pinocchio cannot read the URDF: {reason[-1][:200]} Its parser says why on the "
            "standard error."
        ) from None


def _moving(tree: Element) -> tuple[str, ...]:
    """Names of a tree's joints that are not fixed, in Pinocchio's order: depth first, by name."""
    below: dict[str, list[tuple[str, str, bool]]] = {}
    for joint in tree.findall("joint"):
        parent, child = (str(joint.find(end).get("link")) for end in ("parent", "child"))  # type: ignore[union-attr]
        moves = joint.get("type") != "fixed"
        below.setdefault(parent, []).append((str(joint.get("name")), child, moves))
    names = []
    todo = sorted(below.get(root_link(tree), ()), reverse=True)
    while todo:
        name, child, moves = todo.pop()
        names += [name] * moves
        todo += sorted(below.get(child, ()), reverse=True)
    return tuple(names)


def movable_joints(
    text: str, base: str | None = None, held: Collection[str] = ()
) -> tuple[str, ...]:
    """Names of a URDF's movable joints, in Pinocchio's order; of the tree with `base` as root."""
    tree = parse_urdf(text)
    if base is not None:
        turn_over(tree, base, held)
    return _moving(tree)


def checked_state(model: pin.Model, q: Any, v: Any) -> tuple[Array, Array]:
    """Pinocchio's q (nq,) and v (nv,), finite and with unit quaternions.

    Raises:
        ParameterError: they are not.
    """
    q, v = vector("q", q, model.nq), vector("v", v, model.nv)
    if not pin.isNormalized(model, q, _UNIT):
        raise ParameterError(
            f"q is {q.tolist()}: its quaternion must be a unit one; pin.normalize makes it so."
        )
    return q, v


def joint_inertia(model: pin.Model, data: pin.Data, q: Array) -> Array:
    """M(q) (nv, nv) of any model, mimic joints included; the array is `data`'s own."""
    if has_mimics(model):
        # In the other convention Pinocchio 4.1 adds to what an earlier call left in the data.
        return np.asarray(pin.crba(model, data, q, pin.Convention.WORLD))
    return np.asarray(pin.crba(model, data, q))


def coriolis_matrix(model: pin.Model, data: pin.Data, q: Array, v: Array) -> Array:
    """C(q, v) (nv, nv) with dM/dt = C + C^T.

    Raises:
        ModelError: joints mimic others, which Pinocchio's matrix knows nothing of.
    """
    if has_mimics(model):
        raise ModelError(
            "Pinocchio has no Coriolis matrix of a robot whose joints mimic others: hold those "
            "joints with locked=, or use mass_matrix and dynamics."
        )
    return np.array(pin.computeCoriolisMatrix(model, data, q, v))


def joint_inertia_rate(model: pin.Model, data: pin.Data, q: Array, v: Array) -> Array:
    """dM/dt (nv, nv) at q along v; Coriolis' matrix and its transpose add up to it."""
    if not has_mimics(model):
        coriolis = coriolis_matrix(model, data, q, v)
        return coriolis + coriolis.T
    # Pinocchio's Coriolis matrix knows no mimic joints; the error of this is of fourth order.
    h = 2e-3 / max(1.0, float(np.abs(v).max()))
    at = [
        np.array(joint_inertia(model, data, pin.integrate(model, q, k * h * v)))
        for k in (-2, -1, 1, 2)
    ]
    return (at[0] - 8 * at[1] + 8 * at[2] - at[3]) / (12 * h)


def energy(model: pin.Model, data: pin.Data, q: Array, v: Array) -> tuple[float, float]:
    """Kinetic and potential energy [J]; the potential is zero at the world's origin."""
    if has_mimics(model):
        # Pinocchio's own energies know no mimic joints.
        height = pin.centerOfMass(model, data, q)
        kinetic = 0.5 * float(v @ joint_inertia(model, data, q) @ v)
        weight = pin.computeTotalMass(model) * model.gravity.linear
        return kinetic, -float(weight @ height)
    kinetic = pin.computeKineticEnergy(model, data, q, v)
    return kinetic, pin.computePotentialEnergy(model, data, q)


def has_mimics(model: pin.Model) -> bool:
    """Whether any joint follows another."""
    return bool(len(model.mimicking_joints))


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
