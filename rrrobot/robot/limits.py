"""What a URDF says of its legs' joints: limits of position, rate and effort, damping and friction.

Limits stop nothing in the models; where a motion passes them is told (`beyond`). Damping and
friction act on torque-driven legs, and motors of prescribed legs have to overcome them:

    effort of the joint = motor's - damping phi_dot - friction tanh(phi_dot / eps)

with eps = 0.01 rad/s: below it, Coulomb's friction is viscous, so a stuck joint creeps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from rrrobot.checks import Array
from rrrobot.robot.mimics import Coupling

if TYPE_CHECKING:
    from rrrobot.robot.robot import Robot

CREEP = 0.01
"""Rate below which friction is viscous [rad/s or m/s]."""
_ROUNDING = 1e-9
_HUGE = 10.0
"""Effort limit over weight times reach from which it is a placeholder, and no limit."""


class LegJoints(NamedTuple):
    """What the file says of each leg's joint, those that follow it included; arrays (legs,)."""

    lower: Array
    """least position [rad or m]; -inf without limit"""
    upper: Array
    """greatest position [rad or m]; inf without limit"""
    velocity: Array
    """largest rate [rad/s or m/s]; inf without limit"""
    effort: Array
    """largest motor effort [N m or N]; inf without limit"""
    damping: Array
    """[N m s/rad or N s/m]"""
    friction: Array
    """[N m or N]"""

    @property
    def limited(self) -> bool:
        """Whether there is any limit that binds."""
        ends = (self.lower, self.upper, self.velocity, self.effort)
        return any(bool(np.any(np.abs(end) < 1e6)) for end in ends)

    @property
    def lossy(self) -> bool:
        """Whether any joint has damping or friction."""
        return bool(np.any(self.damping > 0) or np.any(self.friction > 0))

    def loss(self, rate: Array) -> Array:
        """Effort that damping and friction take at rates (..., legs) [N m or N]."""
        return self.damping * rate + self.friction * np.tanh(rate / CREEP)


def leg_joints(tree: Element, legs: Sequence[str], follow: Mapping[str, Coupling]) -> LegJoints:
    """Limits and losses of the legs of a checked URDF.

    A limit of zero in effort or velocity, and positions whose lower limit is not below the upper
    one, are what exporters write where nobody gave limits: they are none. A `continuous` joint has
    no limits of position.
    """
    n = len(legs)
    found = LegJoints(
        np.full(n, -math.inf), np.full(n, math.inf), np.full(n, math.inf), np.full(n, math.inf),
        np.zeros(n), np.zeros(n),
    )  # fmt: skip
    for joint in tree.findall("joint"):
        name = str(joint.get("name"))
        leg, ratio, offset = follow.get(name, Coupling(name, 1.0, 0.0))
        if leg not in legs:
            continue
        k = legs.index(leg)
        dynamics, limit = joint.find("dynamics"), joint.find("limit")
        if dynamics is not None:
            found.damping[k] += ratio**2 * float(dynamics.get("damping", "0"))
            found.friction[k] += abs(ratio) * float(dynamics.get("friction", "0"))
        if limit is None or ratio == 0:
            continue
        low, high, rate, effort = (
            float(limit.get(key, "0")) for key in ("lower", "upper", "velocity", "effort")
        )
        if low < high and joint.get("type") != "continuous":
            ends = sorted(((low - offset) / ratio, (high - offset) / ratio))
            found.lower[k] = max(found.lower[k], ends[0])
            found.upper[k] = min(found.upper[k], ends[1])
        if rate > 0:
            found.velocity[k] = min(found.velocity[k], rate / abs(ratio))
        if effort > 0 and name == leg:
            found.effort[k] = effort
    for array in found:
        array.flags.writeable = False
    return found


def placeholders(robot: Robot) -> tuple[str, ...]:
    """Legs whose effort limit nothing could reach: more than ten times M g and a limb's reach.

    Exporters write such numbers, 1000 N m or more, where nobody gave one.
    """
    model, reach = robot.model, [0.0, 0.0]
    for joint in range(2, model.njoints):
        above = int(model.parents[joint])
        step = float(np.linalg.norm(model.jointPlacements[joint].translation))
        reach.append(reach[above] + step if above > 1 else 0.0)
    most = _HUGE * robot.mass * 9.81 * max(0.1, *reach)
    return tuple(
        leg
        for leg, effort in zip(robot.legs, robot.joints.effort, strict=True)
        if np.isfinite(effort) and effort > most
    )


def beyond(
    joints: LegJoints, legs: Sequence[str], time: Array, angle: Array, rate: Array, torque: Array
) -> list[str]:
    """Each limit that a motion passes: the joint, the extreme and when, and the limit.

    Args:
        joints: the limits.
        legs: their names.
        time: (n,) [s].
        angle, rate, torque: (n, legs).
    """
    told = []
    cases = (
        ("position", angle, joints.lower, -1, "rad"),
        ("position", angle, joints.upper, 1, "rad"),
        ("rate", np.abs(rate), joints.velocity, 1, "rad/s"),
        ("effort", np.abs(torque), joints.effort, 1, "N m"),
    )
    for k, leg in enumerate(legs):
        for what, values, limits, sign, unit in cases:
            excess = sign * (values[:, k] - limits[k])
            over = np.flatnonzero(excess > _ROUNDING * max(1.0, abs(limits[k])))
            if not np.isfinite(limits[k]) or not over.size:
                continue
            worst = int(np.nanargmax(excess))
            side = "below" if sign < 0 else "above"
            told.append(
                f"{leg}: {what} {values[worst, k]:.4g} {unit} at t = {time[worst]:.4g} s, "
                f"{excess[worst]:.3g} {side} the limit {limits[k]:.4g} (first at "
                f"{time[over[0]]:.4g} s)"
            )
    return told
