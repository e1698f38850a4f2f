"""What makes a gait good, and what makes it valid: goals and limits, over tables of results.

A table holds what populations of gaits give, one row a gait, the columns `COLUMNS`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array, finite
from rrrobot.errors import ParameterError

COLUMNS = {
    "speed": "m/s",
    "yaw_rate": "rad/s",
    "variation": "",
    "pitch": "rad",
    "normal_force": "N",
    "friction": "",
    "rms_torque": "N m",
    "peak_torque": "N m",
    "power": "W",
    "clearance": "m",
    "status": "",
}
"""Columns of a table, with units: the first three as `SteadyState` has them; largest |pitch|; least
normal force; friction coefficient that is needed; root of the mean sum of squared motor torques;
largest motor torque; mean of the sum of |torque x rate|; least height of a leg's mass centre above
the ground; why the engine stopped, 0 if it did not. For a prismatic leg, torques are forces."""


class Table:
    """Results of gaits by name: `table.speed` is an array (n,).

    Args:
        values: (n, len(COLUMNS)).
        swing, rate, acceleration: the largest of any leg (n,).
    """

    speed: Array
    yaw_rate: Array
    variation: Array
    pitch: Array
    normal_force: Array
    friction: Array
    rms_torque: Array
    peak_torque: Array
    power: Array
    clearance: Array
    status: Array

    def __init__(self, values: Array, swing: Array, rate: Array, acceleration: Array) -> None:
        for i, name in enumerate(COLUMNS):
            setattr(self, name, values[:, i])
        self.swing, self.rate, self.acceleration = swing, rate, acceleration

    @property
    def curvature(self) -> Array:
        """yaw_rate / speed (n,) [1/m]."""
        return np.asarray(self.yaw_rate / np.maximum(self.speed, 1e-12))

    @property
    def values(self) -> Array:
        """All columns (n, len(COLUMNS))."""
        return np.column_stack([getattr(self, name) for name in COLUMNS])

    def rows(self, which: NDArray[Any] | slice) -> Table:
        """Some of the gaits: indices or a mask."""
        return Table(
            self.values[which], self.swing[which], self.rate[which], self.acceleration[which]
        )

    @staticmethod
    def joined(tables: Sequence[Table]) -> Table:
        """Several tables one after the other."""
        legs = (
            np.concatenate([getattr(t, name) for t in tables])
            for name in ("swing", "rate", "acceleration")
        )
        return Table(np.concatenate([t.values for t in tables]), *legs)

    def to_dict(self) -> dict[str, float]:
        """The first row by name, without the status."""
        names = [name for name in COLUMNS if name != "status"]
        return {name: float(getattr(self, name)[0]) for name in names}


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

    def slack(
        self, table: Table, weight: float, largest_swing: float
    ) -> dict[str, tuple[Array, str]]:
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
            "swing": (
                (largest_swing - t.swing) / max(largest_swing, 1e-9) + 1e-9,
                f"legs swing more than {largest_swing:g} rad",
            ),
            "max_variation": (
                (self.max_variation - t.variation) / (self.max_variation + t.variation),
                f"not steady: steps vary by more than {self.max_variation:g}",
            ),
        }
        if weight > 0:
            found["min_normal_force"] = (
                t.normal_force / weight - self.min_normal_force,
                f"normal force below {self.min_normal_force:g} of the weight",
            )
        tops = {
            "friction": (t.friction, "needs a friction coefficient above {:g}"),
            "max_curvature": (np.abs(t.curvature), "turns tighter than {:g} 1/m"),
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


class Goal(ABC):
    """What is to be optimised; a frozen dataclass of its numbers."""

    name: str
    unit: str
    min_speed: float = 0.0
    tolerance: float = 0.0

    @abstractmethod
    def value(self, table: Table) -> Array:
        """The quantity that is optimised, in `unit` (n,)."""

    def objective(self, table: Table) -> Array:
        """What is minimised (n,)."""
        return self.value(table)

    def misses(self, table: Table) -> Array | None:
        """For targets: relative distance of each quantity from its target (n, k)."""
        return None

    def shortfall(self, table: Table) -> str:
        """For targets: how far the first gait of a table is from it, in words."""
        return ""

    def to_dict(self) -> dict[str, Any]:
        """Name and numbers as plain data."""
        return {"type": self.name} | {f.name: getattr(self, f.name) for f in fields(self)}  # type: ignore[arg-type]


@dataclass(frozen=True, kw_only=True)
class FastestTravel(Goal):
    """Largest speed; `GaitLimits(max_curvature=...)` keeps the path straight.

    Example:
        >>> import rrrobot as rr
        >>> rr.FastestTravel().unit
        'm/s'
    """

    name = "fastest"
    unit = "m/s"

    def value(self, table: Table) -> Array:
        return table.speed

    def objective(self, table: Table) -> Array:
        return -table.speed


@dataclass(frozen=True, kw_only=True)
class TightestTurn(Goal):
    """Largest |curvature| of the path among gaits of at least a speed.

    Attributes:
        min_speed: greater than zero [m/s].

    Example:
        >>> import rrrobot as rr
        >>> rr.TightestTurn(min_speed=0.002).unit
        '1/m'
    """

    name = "tightest"
    unit = "1/m"
    min_speed: float = 1e-3

    def __post_init__(self) -> None:
        finite("min_speed", self.min_speed, "m/s", above=0.0)

    def value(self, table: Table) -> Array:
        return np.abs(table.curvature)

    def objective(self, table: Table) -> Array:
        return -np.abs(table.curvature)


COSTS = {"effort": "N^2 m s", "torque": "N s", "work": "J/m"}


@dataclass(frozen=True, kw_only=True)
class LeastEffort(Goal):
    """Least cost of a metre of travel, among gaits of at least a speed.

    Attributes:
        cost: "effort", the time integral of the summed squared motor torques, which heat the
            motors; "torque", their root mean square over the speed; "work", the integral of
            |torque x rate|.
        min_speed: greater than zero [m/s].

    Example:
        >>> import rrrobot as rr
        >>> rr.LeastEffort(cost="work").unit
        'J/m'
    """

    name = "efficient"
    cost: str = "effort"
    min_speed: float = 1e-3

    def __post_init__(self) -> None:
        if self.cost not in COSTS:
            raise ParameterError(f"cost is {self.cost!r}: it must be one of {', '.join(COSTS)}.")
        finite("min_speed", self.min_speed, "m/s", above=0.0)

    @property
    def unit(self) -> str:  # type: ignore[override]
        """Of the cost."""
        return COSTS[self.cost]

    def value(self, table: Table) -> Array:
        rate = {"effort": table.rms_torque**2, "torque": table.rms_torque, "work": table.power}
        return np.asarray(rate[self.cost] / np.maximum(table.speed, 1e-12))


@dataclass(frozen=True, kw_only=True)
class TargetMotion(Goal):
    """A wanted speed with a wanted curvature or yaw rate, at the least rms torque.

    Attributes:
        speed: [m/s], greater than zero.
        curvature: [1/m], positive to the left; or
        yaw_rate: [rad/s].
        tolerance: relative; of zero targets, of 0.1 1/m and 0.001 rad/s.

    Example:
        >>> import rrrobot as rr
        >>> rr.TargetMotion(speed=0.005, curvature=2.0).tolerance
        0.001
    """

    name = "target"
    unit = "N m"
    speed: float
    curvature: float | None = None
    yaw_rate: float | None = None
    tolerance: float = 1e-3

    def __post_init__(self) -> None:
        finite("speed", self.speed, "m/s", above=0.0)
        finite("tolerance", self.tolerance, above=0.0)
        if (self.curvature is None) == (self.yaw_rate is None):
            raise ParameterError(
                "a target needs its curvature [1/m] or its yaw_rate [rad/s], one of the two."
            )
        for name in ("curvature", "yaw_rate"):
            if getattr(self, name) is not None:
                finite(name, getattr(self, name))

    def value(self, table: Table) -> Array:
        return table.rms_torque

    def misses(self, table: Table) -> Array:
        if self.curvature is not None:
            turn = (table.curvature - self.curvature) / max(abs(self.curvature), 0.1)
        else:
            rate = self.yaw_rate or 0.0
            turn = (table.yaw_rate - rate) / max(abs(rate), 1e-3)
        return np.column_stack((table.speed / self.speed - 1.0, turn))

    def shortfall(self, table: Table) -> str:
        turn = "yaw_rate" if self.curvature is None else "curvature"
        unit = "rad/s" if self.curvature is None else "1/m"
        return (
            f"the nearest found has speed {table.speed[0]:.6g} m/s and {turn} "
            f"{getattr(table, turn)[0]:.6g} {unit}, not {self.speed:g} and {getattr(self, turn):g}"
        )


GOALS: dict[str, type[Goal]] = {
    goal.name: goal for goal in (FastestTravel, TightestTurn, LeastEffort, TargetMotion)
}


def as_goal(goal: Goal | str) -> Goal:
    """A goal, or the one of a name with its defaults.

    Raises:
        ParameterError: no such goal, or one that has no defaults.
    """
    if isinstance(goal, Goal):
        return goal
    if not isinstance(goal, str) or goal not in GOALS:
        raise ParameterError(
            f"goal is {goal!r}: it must be one of {', '.join(GOALS)}, or a Goal such as "
            "TightestTurn(min_speed=0.002)."
        )
    if goal == TargetMotion.name:
        raise ParameterError(
            "goal 'target' needs numbers: give TargetMotion(speed=..., curvature=...)."
        )
    return GOALS[goal]()
