"""What makes a gait good: goals, as objectives over tables of results."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from rrrobot import serial
from rrrobot.checks import Array, finite
from rrrobot.errors import ParameterError
from rrrobot.studies.optimisation.table import Table


class Goal(ABC):
    """What is to be optimised; a frozen dataclass of its numbers."""

    name: str
    quantity: str
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


@serial.register("fastest")
@dataclass(frozen=True, kw_only=True)
class FastestTravel(Goal):
    """Largest speed; `GaitLimits(max_curvature=...)` keeps the path straight.

    Example:
        >>> import rrrobot as rr
        >>> rr.studies.FastestTravel().unit
        'm/s'
    """

    name = "fastest"
    quantity = "speed"
    unit = "m/s"

    def value(self, table: Table) -> Array:
        return table.speed

    def objective(self, table: Table) -> Array:
        return -table.speed


@serial.register("tightest")
@dataclass(frozen=True, kw_only=True)
class TightestTurn(Goal):
    """Largest |curvature| of the path among gaits of at least a speed.

    Attributes:
        min_speed: greater than zero [m/s].

    Example:
        >>> import rrrobot as rr
        >>> rr.studies.TightestTurn(min_speed=0.002).unit
        '1/m'
    """

    name = "tightest"
    quantity = "|curvature|"
    unit = "1/m"
    min_speed: float = 1e-3

    def __post_init__(self) -> None:
        finite("min_speed", self.min_speed, "m/s", above=0.0)

    def value(self, table: Table) -> Array:
        return np.abs(table.curvature)

    def objective(self, table: Table) -> Array:
        # The logarithm is far less bent than yaw_rate / speed near the least speed.
        return -np.log(np.abs(table.curvature) + 1e-12)


COSTS = {"effort": "N^2 m s", "torque": "N s", "work": "J/m"}


@serial.register("efficient")
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
        >>> rr.studies.LeastEffort(cost="work").unit
        'J/m'
    """

    name = "efficient"
    quantity = "cost per metre"
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


RATES = {"torque": "N m", "power": "W"}


@serial.register("rate")
@dataclass(frozen=True, kw_only=True)
class LeastRate(Goal):
    """Least rms motor torque or mean |power| among gaits of at least a speed: a point of a front.

    Attributes:
        rate: "torque" or "power".
        min_speed: [m/s].

    Raises:
        ParameterError: another rate.
    """

    name = "rate"
    quantity = "rate"
    rate: str = "torque"
    min_speed: float = 1e-3

    def __post_init__(self) -> None:
        if self.rate not in RATES:
            raise ParameterError(f"cost is {self.rate!r}: it must be one of {', '.join(RATES)}.")

    @property
    def unit(self) -> str:  # type: ignore[override]
        """Of the rate."""
        return RATES[self.rate]

    @property
    def column(self) -> str:
        """Name of the result that is the rate."""
        return "rms_torque" if self.rate == "torque" else "power"

    def value(self, table: Table) -> Array:
        return np.asarray(getattr(table, self.column))


@serial.register("target")
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
        >>> rr.studies.TargetMotion(speed=0.005, curvature=2.0).tolerance
        0.001
    """

    name = "target"
    quantity = "rms torque"
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
            f"speed {table.speed[0]:.6g} m/s and {turn} {getattr(table, turn)[0]:.6g} {unit} "
            f"instead of {self.speed:g} and {getattr(self, turn):g}"
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
