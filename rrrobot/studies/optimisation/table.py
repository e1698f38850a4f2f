"""What populations of gaits give, as tables, and the limits within which that is valid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array, finite
from rrrobot.drive.gaits import GaitBatch
from rrrobot.results import names
from rrrobot.robot.limits import JointEnds, JointLimits, below


def columns() -> tuple[str, ...]:
    """Names of a table's columns."""
    return (*names(), "status")


class Joints(NamedTuple):
    """The farthest and the largest of each leg in a period."""

    low: Array
    """least position (n, legs) [rad]"""
    high: Array
    """greatest position (n, legs) [rad]"""
    rate: Array
    """(n, legs) [rad/s]"""
    acceleration: Array
    """of any leg (n,) [rad/s^2]"""
    torque: Array
    """of the motors (n, legs) [N m]"""

    @classmethod
    def of(cls, gaits: GaitBatch, torque: Array) -> Joints:
        """Those of gaits with their motors' torques (n, legs)."""
        return cls(*gaits.reach(), gaits.fastest()[1], torque)


class Table:
    """Results of gaits by name: `table.speed` is an array (n,); see `rrrobot.results`.

    Args:
        values: (n, columns), the results in order, then the status.
        joints: of each leg.
        multiplier: largest |Floquet multiplier| of each orbit (n,); NaN where it is not known.
        cycles: periods that were simulated for each gait (n,); 0 unless given.
    """

    def __init__(
        self,
        values: Array,
        joints: Joints,
        multiplier: Array | None = None,
        cycles: Array | None = None,
    ) -> None:
        self.values, self.joints = values, joints
        self.multiplier = np.full(len(values), np.nan) if multiplier is None else multiplier
        self.cycles = np.zeros(len(values)) if cycles is None else cycles

    def __getattr__(self, name: str) -> Array:
        if name not in columns():
            raise AttributeError(f"there is no result {name!r}.")
        return np.asarray(self.values[:, columns().index(name)])

    def rows(self, which: NDArray[Any] | slice | list[int]) -> Table:
        """Some of the gaits: indices or a mask."""
        joints = Joints(*(part[which] for part in self.joints))
        return Table(self.values[which], joints, self.multiplier[which], self.cycles[which])

    @staticmethod
    def joined(tables: Sequence[Table]) -> Table:
        """Several tables one after the other."""
        joints = (np.concatenate(parts) for parts in zip(*(t.joints for t in tables), strict=True))
        beside = ([getattr(t, name) for t in tables] for name in ("values", "multiplier", "cycles"))
        values, multiplier, cycles = (np.concatenate(parts) for parts in beside)
        return Table(values, Joints(*joints), multiplier, cycles)

    def to_dict(self) -> dict[str, float]:
        """The first row by name, without the status."""
        return dict(zip(names(), self.values[0].tolist(), strict=False))


def discrepancy(found: Table, measured: Table) -> float:
    """Largest relative difference of the two in speed, yaw rate, torque and friction."""
    a, b = found.to_dict(), measured.to_dict()
    scale = {"yaw_rate": max(abs(b["yaw_rate"]), b["speed"]), "friction": b["friction"]}
    gaps = [
        abs(a[key] - b[key]) / max(scale.get(key, b[key]), 1e-9)
        for key in ("speed", "yaw_rate", "rms_torque", "friction")
        if np.isfinite(b[key])
    ]
    return max(gaps, default=np.inf)


@dataclass(frozen=True, kw_only=True)
class GaitLimits(JointLimits):
    """What a gait must respect to be valid, and what the robot's hardware allows.

    Attributes:
        min_normal_force: least normal force over the robot's weight; below zero it lifts off.
        max_tilt: largest angle of the body's z axis from the ground's normal in the settled cycle,
            roll and pitch together [rad].
        max_variation: largest variation of the step from cycle to cycle, over the step.
        min_clearance: least height of the legs' mass centres above the ground [m]; on RRRobot
            these are the leg tips.
        friction: coefficient that the ground offers; None for enough.
        max_curvature: largest |curvature| of the path [1/m]; None for any.
        max_leg_acceleration: [rad/s^2]; None for any.
        max_torque, max_leg_rate, leg_range: of the joints, those of the robot's file unless given;
            see `JointLimits`.

    Raises:
        ParameterError: a limit that is negative or not finite.

    Example:
        >>> import rrrobot as rr
        >>> rr.GaitLimits(friction=0.1).max_tilt
        1.2
    """

    min_normal_force: float = 0.05
    max_tilt: float = 1.2
    max_variation: float = 0.01
    min_clearance: float = 0.0
    friction: float | None = None
    max_curvature: float | None = None
    max_leg_acceleration: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        for field in fields(self):
            name, value = field.name, getattr(self, field.name)
            if name in JointLimits.__dataclass_fields__:
                continue
            if name == "min_clearance":
                finite(name, value, "m")
            elif name == "min_normal_force":
                finite(name, value, at_least=0.0)
            elif value is not None or name in ("max_tilt", "max_variation"):
                finite(name, value, above=0.0)

    def slack(
        self, table: Table, weight: float, ends: JointEnds, legs: Sequence[str]
    ) -> dict[str, tuple[Array, str]]:
        """For each limit, how far inside it the gaits are (n,), of order one, and what it means.

        A negative entry is a violation.

        Args:
            table: of the gaits.
            weight: of the robot [N].
            ends: what its joints may do; see `JointLimits.ends`.
            legs: their names.
        """
        t = table
        found = {
            "max_tilt": (self.max_tilt - t.tilt, f"tilt above {self.max_tilt:g} rad"),
            "min_clearance": (
                (t.clearance - self.min_clearance) / 0.1,
                f"legs come within {self.min_clearance:g} m of the ground",
            ),
            "max_variation": (
                (self.max_variation - t.variation) / (self.max_variation + t.variation),
                f"not steady: steps vary by more than {self.max_variation:g}",
            ),
        }
        if self.max_curvature is not None:
            # One for each side: an absolute value would be bent where straight gaits are.
            bend, text = t.curvature / self.max_curvature, "turns tighter than {:g} 1/m"
            found["left"] = (1.0 - bend, text.format(self.max_curvature))
            found["right"] = (1.0 + bend, text.format(self.max_curvature))
        if weight > 0:
            found["min_normal_force"] = (
                t.normal_force / weight - self.min_normal_force,
                f"normal force below {self.min_normal_force:g} of the weight",
            )
        if self.friction is not None:
            text = f"needs a friction coefficient above {self.friction:g}"
            found["friction"] = (below(t.friction, self.friction), text)
        if self.max_leg_acceleration is not None:
            most = self.max_leg_acceleration
            slack = below(t.joints.acceleration, most)
            found["max_leg_acceleration"] = (slack, f"leg acceleration above {most:g} rad/s^2")
        return found | self._joint_slack(t.joints, ends, legs)

    @staticmethod
    def _joint_slack(
        joints: Joints, ends: JointEnds, legs: Sequence[str]
    ) -> dict[str, tuple[Array, str]]:
        """One for each joint and limit that is one."""
        found = {}
        for k, leg in enumerate(legs):
            torque, rate, low, high = (
                float(end[k]) for end in (ends.effort, ends.velocity, ends.lower, ends.upper)
            )
            if np.isfinite(torque):
                slack, text = below(joints.torque[:, k], torque), "motor torque of {} above {:g}"
                found[f"torque of {leg}"] = slack, text.format(leg, torque) + " N m"
            if np.isfinite(rate):
                slack, text = below(joints.rate[:, k], rate), "rate of {} above {:g} rad/s"
                found[f"rate of {leg}"] = slack, text.format(leg, rate)
            if np.isfinite(low):
                found[f"lower of {leg}"] = joints.low[:, k] - low, f"{leg} goes below {low:g} rad"
            if np.isfinite(high):
                found[f"upper of {leg}"] = (
                    high - joints.high[:, k],
                    f"{leg} goes above {high:g} rad",
                )
        return found
