"""What a URDF says of its legs' joints: limits of position, rate and effort, damping and friction.

Limits stop nothing in the models; where a motion passes them is told (`beyond`), and searches for
gaits keep within them (`JointLimits`). Damping and friction act on torque-driven legs, and motors
of prescribed legs have to overcome them:

    effort of the joint = motor's - damping phi_dot - friction tanh(phi_dot / eps)

with eps = 0.01 rad/s: below it, Coulomb's friction is viscous, so a stuck joint creeps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Self
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.errors import ParameterError
from rrrobot.robot.joints import sliding
from rrrobot.robot.mimics import Coupling

if TYPE_CHECKING:
    from rrrobot.robot.robot import Robot

CREEP = 0.01
"""Rate below which friction is viscous [rad/s or m/s]."""
_ROUNDING = 1e-9
_HUGE, _PLACEHOLDER = 10.0, 1000.0
"""Effort limits that are none: from this times weight and reach on, of joints that turn also from
so many N m on."""
_NONE = 1e6
"""Limits of any kind from which on nobody would take them for one."""


class LegJoints(NamedTuple):
    """What the file says of each leg's joint, those that follow it included; arrays (legs,)."""

    lower: Array
    """least position [rad or m]; -inf without limit"""
    upper: Array
    """greatest position [rad or m]; inf without limit"""
    velocity: Array
    """largest rate [rad/s or m/s]; inf without limit"""
    effort: Array
    """largest motor effort [N m or N]; inf without limit, and where the file's is a placeholder"""
    damping: Array
    """[N m s/rad or N s/m]"""
    friction: Array
    """[N m or N]"""
    unlimited: tuple[str, ...] = ()
    """legs whose effort limit in the file is a placeholder; see `without_placeholders`"""

    @property
    def limited(self) -> bool:
        """Whether there is any limit that binds."""
        ends = (self.lower, self.upper, self.velocity, self.effort)
        return any(bool(np.isfinite(end).any()) for end in ends)

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
    return found


def without_placeholders(joints: LegJoints, legs: Sequence[str], model: pin.Model) -> LegJoints:
    """Limits that are limits, read-only: others are infinite.

    Exporters write 1000 N m or more where nobody gave a limit. Taken for none are 1000 N m and more
    of a joint that turns, and whatever exceeds ten times the weight, by a limb's reach if it turns.

    Args:
        joints: of the file.
        legs: their names.
        model: of the robot.
    """
    reach = [0.0, 0.0]
    for joint in range(2, model.njoints):
        above = int(model.parents[joint])
        step = float(np.linalg.norm(model.jointPlacements[joint].translation))
        reach.append(reach[above] + step if above > 1 else 0.0)
    force = _HUGE * pin.computeTotalMass(model) * 9.81
    torque = min(force * max(0.1, *reach), _PLACEHOLDER)
    most = np.where(sliding(model, legs), force, torque)
    none = joints.effort >= most
    told = none & (joints.effort < _NONE)
    lower, upper, velocity = (
        np.where(np.abs(ends) < _NONE, ends, np.copysign(np.inf, ends))
        for ends in (joints.lower, joints.upper, joints.velocity)
    )
    found = LegJoints(
        lower, upper, velocity, np.where(none, np.inf, joints.effort), joints.damping,
        joints.friction, tuple(leg for leg, here in zip(legs, told, strict=True) if here),
    )  # fmt: skip
    for array in found[:-1]:
        array.flags.writeable = False
    return found


class JointEnds(NamedTuple):
    """What each joint may do; infinite where nothing limits it."""

    lower: Array
    """least position (legs,) [rad or m]"""
    upper: Array
    """greatest position (legs,) [rad or m]"""
    velocity: Array
    """largest rate (legs,) [rad/s or m/s]"""
    effort: Array
    """largest motor effort (legs,) [N m or N]"""


Each = float | Sequence[float] | None
"""One number for all legs, one for each leg, or None for those of the robot's file."""


@dataclass(frozen=True, kw_only=True)
class JointLimits:
    """What the joints may do: the limits of the robot's file, or others.

    Attributes:
        max_torque: of each motor [N m or N].
        max_leg_rate: of each joint [rad/s or m/s].
        leg_range: least and greatest position [rad or m]: (low, high) for all legs, or such a pair
            for each.

    Each of them is the file's unless given; infinity lifts it. Effort limits that are placeholders
    are none; `robot.joints.unlimited` names their joints.

    Raises:
        ParameterError: a limit that is not positive, or a range whose ends are reversed.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> rr.GaitLimits(max_torque=(0.1, 0.2)).ends(robot).effort.tolist()
        [0.1, 0.2]
    """

    max_torque: Each = None
    max_leg_rate: Each = None
    leg_range: Sequence[Any] | None = None

    def __post_init__(self) -> None:
        for name in ("max_torque", "max_leg_rate"):
            values = self._numbers(name)
            if values is None:
                continue
            if values.ndim > 1 or not values.size or not (values > 0).all():
                raise ParameterError(
                    f"{name} is {getattr(self, name)!r}: it must be a number above 0, or one for "
                    "each leg; infinity for no limit."
                )
        ends = self._numbers("leg_range")
        if ends is not None and (
            ends.shape[-1:] != (2,) or ends.ndim > 2 or not (ends[..., 0] <= ends[..., 1]).all()
        ):
            raise ParameterError(
                f"leg_range is {self.leg_range!r}: it must be (low, high), the lower one first, or "
                "such a pair for each leg; infinity for no limit."
            )

    def _numbers(self, name: str) -> Array | None:
        value = getattr(self, name)
        if value is None:
            return None
        try:
            found = np.array(value)
            if found.dtype.kind not in "iuf" or np.isnan(found.astype(float)).any():
                raise ValueError
        except (TypeError, ValueError):
            raise ParameterError(
                f"{name} is {value!r}: it must be numbers; leave it out for the file's."
            ) from None
        plain = found.astype(float).tolist()
        # Hashable, and equal where the numbers are.
        object.__setattr__(self, name, _tuples(plain))
        return np.asarray(plain)

    def ends(self, robot: Robot) -> JointEnds:
        """Limits of each joint of a robot: those given, and the file's for the rest.

        Raises:
            ParameterError: limits for each of another number of legs.
        """
        joints, n = robot.joints, robot.n_legs
        given = (("max_torque", (n,)), ("max_leg_rate", (n,)), ("leg_range", (n, 2)))
        own: dict[str, Array] = {}
        for name, shape in given:
            value = self._numbers(name)
            if value is None:
                continue
            if value.ndim == len(shape) and value.shape != shape:
                raise ParameterError(
                    f"{name} has {len(value)} entries: the robot has {n} legs, so give {n}, or one "
                    "for all."
                )
            own[name] = np.broadcast_to(value, shape)
        both = own.get("leg_range", np.column_stack((joints.lower, joints.upper)))
        return JointEnds(
            both[:, 0], both[:, 1], own.get("max_leg_rate", joints.velocity),
            own.get("max_torque", joints.effort),
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """All limits as plain data; infinity as "inf"."""
        return {name: _plain(value) for name, value in asdict(self).items()}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The limits of `to_dict`."""
        return cls(**{name: _parsed(value) for name, value in data.items()})


def _tuples(value: Any) -> Any:
    return tuple(_tuples(entry) for entry in value) if isinstance(value, list) else value


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    return str(value) if isinstance(value, float) and math.isinf(value) else value


def _parsed(value: Any) -> Any:
    if isinstance(value, list):
        return [_parsed(entry) for entry in value]
    return float(value) if value in ("inf", "-inf") else value


def below(value: Array, most: Array | float) -> Array:
    """Slack of positive values below limits: 1 of none used, 0 at the limit, towards -1 above.

    It is (most - value) / (most + value), and 1 where nothing limits.
    """
    value, most = np.minimum(value, 1e9), np.asarray(most)
    with np.errstate(invalid="ignore"):
        slack = (most - value) / (most + value)
    return np.where(np.isinf(most), 1.0 + 0.0 * value, slack)


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
