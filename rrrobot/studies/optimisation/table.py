"""What populations of gaits give, as tables, and the limits within which that is valid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array, finite
from rrrobot.results import names
from rrrobot.robot.limits import LegJoints

_BESIDE = ("rate", "acceleration", "multiplier", "cycles")
"""What a table has beside its columns."""


def columns() -> tuple[str, ...]:
    """Names of a table's columns."""
    return (*names(), "status")


class Table:
    """Results of gaits by name: `table.speed` is an array (n,); see `rrrobot.results`.

    Args:
        values: (n, columns), the results in order, then the status.
        rate, acceleration: the largest of any leg (n,).
        multiplier: largest |Floquet multiplier| of each orbit (n,); NaN where it is not known.
        cycles: periods that were simulated for each gait (n,); 0 unless given.
    """

    def __init__(
        self,
        values: Array,
        rate: Array,
        acceleration: Array,
        multiplier: Array | None = None,
        cycles: Array | None = None,
    ) -> None:
        self.values = values
        self.rate, self.acceleration = rate, acceleration
        self.multiplier = np.full(len(values), np.nan) if multiplier is None else multiplier
        self.cycles = np.zeros(len(values)) if cycles is None else cycles

    def __getattr__(self, name: str) -> Array:
        if name not in columns():
            raise AttributeError(f"there is no result {name!r}.")
        return np.asarray(self.values[:, columns().index(name)])

    def rows(self, which: NDArray[Any] | slice | list[int]) -> Table:
        """Some of the gaits: indices or a mask."""
        return Table(self.values[which], *(getattr(self, name)[which] for name in _BESIDE))

    @staticmethod
    def joined(tables: Sequence[Table]) -> Table:
        """Several tables one after the other."""
        beside = (np.concatenate([getattr(t, name) for t in tables]) for name in _BESIDE)
        return Table(np.concatenate([t.values for t in tables]), *beside)

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
class GaitLimits:
    """What a gait must respect to be valid, and what the robot's hardware allows.

    Attributes:
        min_normal_force: least normal force over the robot's weight; below zero it lifts off.
        max_pitch: largest |pitch| from the start on [rad]; at pi/2 Euler angles are singular.
        max_variation: largest variation of the step from cycle to cycle, over the step.
        min_clearance: least height of the legs' mass centres above the ground [m]; on RRRobot
            these are the leg tips.
        friction: coefficient that the ground offers; None for enough.
        max_curvature: largest |curvature| of the path [1/m]; None for any.
        max_torque: of each motor [N m]; None for any.
        max_leg_rate: [rad/s]; None for any.
        max_leg_acceleration: [rad/s^2]; None for any.

    Raises:
        ParameterError: a limit that is negative or not finite.

    Example:
        >>> import rrrobot as rr
        >>> rr.GaitLimits(friction=0.1).max_pitch
        1.2
    """

    min_normal_force: float = 0.05
    max_pitch: float = 1.2
    max_variation: float = 0.01
    min_clearance: float = 0.0
    friction: float | None = None
    max_curvature: float | None = None
    max_torque: float | None = None
    max_leg_rate: float | None = None
    max_leg_acceleration: float | None = None

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if name == "min_clearance":
                finite(name, value, "m")
            elif name == "min_normal_force":
                finite(name, value, at_least=0.0)
            elif value is not None or name in ("max_pitch", "max_variation"):
                finite(name, value, above=0.0)

    def slack(self, table: Table, weight: float) -> dict[str, tuple[Array, str]]:
        """For each limit, how far inside it the gaits are (n,), of order one, and what it means.

        A negative entry is a violation.
        """
        t = table
        found = {
            "max_pitch": (self.max_pitch - t.pitch, f"|pitch| above {self.max_pitch:g} rad"),
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
        tops = {
            "friction": (t.friction, "needs a friction coefficient above {:g}"),
            "max_torque": (t.peak_torque, "motor torque above {:g} N m"),
            "max_leg_rate": (t.rate, "leg rate above {:g} rad/s"),
            "max_leg_acceleration": (t.acceleration, "leg acceleration above {:g} rad/s^2"),
        }
        for name, (value, text) in tops.items():
            top = getattr(self, name)
            if top is not None:
                value = np.minimum(value, 1e9)
                found[name] = ((top - value) / (top + value), text.format(top))
        return found

    def to_dict(self) -> dict[str, Any]:
        """All limits as plain data."""
        return asdict(self)


def file_limits(joints: LegJoints) -> GaitLimits:
    """The usual limits, with the least effort and rate that the robot's file allows a leg."""
    effort, rate = (
        float(np.min(ends, initial=np.inf)) for ends in (joints.effort, joints.velocity)
    )
    return GaitLimits(
        max_torque=effort if effort < 1e6 else None, max_leg_rate=rate if rate < 1e6 else None
    )
