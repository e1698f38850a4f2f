"""RRRobot's geometry and masses: Table 2 of the paper."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from rrrobot.checks import finite
from rrrobot.errors import GroundClearanceWarning, ParameterError

PerLeg = float | tuple[float, float]
"""One number for both legs, or a pair (leg 1, leg 2)."""

_UNITS = {
    "leg_mass": "kg",
    "servo_mass": "kg",
    "battery_mass": "kg",
    "shell_radius": "m",
    "leg_length": "m",
    "hip_offset": "m",
}
_PER_LEG = ("leg_mass", "servo_mass", "leg_length")


@dataclass(frozen=True, kw_only=True)
class RRRobotParameters:
    """Geometric and inertial parameters of RRRobot, SI units; the defaults are Table 2.

    Five point masses: the battery at the bottom of the shell, a servo at each hip
    (0, -+hip_offset, 0) from the shell's centre, a leg mass at each leg tip. Shell and legs
    themselves are massless.

    Attributes:
        leg_mass: M_l, at each leg tip [kg]; a pair gives the two legs different masses; a pair
            of one number is that number.
        servo_mass: M_s, at each hip [kg]; or a pair.
        battery_mass: M_b, at (0, 0, -shell_radius) [kg].
        shell_radius: r [m].
        leg_length: l [m]; or a pair.
        hip_offset: b, from the shell's centre to each hip along the leg axis [m]. The paper
            prints no value; its mass matrix (eq 12) uses r, so b = r in Table 2.
        gravity: g [m/s^2], zero or more.
        damping: loss on each Euler rate of the body [N m s/rad], eqs (9)-(10); models of this
            robot take it unless told otherwise.

    Raises:
        ParameterError: a mass or a length is not greater than zero and finite.

    Warns:
        GroundClearanceWarning: a leg that points down reaches the ground.

    Example:
        >>> import rrrobot as rr
        >>> p = rr.RRRobotParameters(leg_mass=0.06)
        >>> p.leg_mass, p.shell_radius, round(p.total_mass, 3)
        (0.06, 0.12, 0.526)
    """

    leg_mass: PerLeg = 0.057
    servo_mass: PerLeg = 0.053
    battery_mass: float = 0.3
    shell_radius: float = 0.12
    leg_length: PerLeg = 0.1
    hip_offset: float = 0.12
    gravity: float = 9.81
    damping: float = 0.01

    def __post_init__(self) -> None:
        for name, unit in _UNITS.items():
            object.__setattr__(self, name, _checked(name, getattr(self, name), unit))
        for name, unit in (("gravity", "m/s^2"), ("damping", "N m s/rad")):
            object.__setattr__(self, name, finite(name, getattr(self, name), unit, at_least=0))
        if self.ground_clearance <= 0:
            warnings.warn(
                f"leg_length is {max(self.leg_lengths)} m and shell_radius is "
                f"{self.shell_radius} m: a leg that points straight down has a clearance of "
                f"{self.ground_clearance:.4g} m, so it touches the ground. The models know no "
                "leg contact; keep the legs up or make them shorter than the radius.",
                GroundClearanceWarning,
                stacklevel=3,
            )

    @property
    def leg_masses(self) -> tuple[float, float]:
        """M_l of leg 1 and leg 2 [kg]."""
        return _pair(self.leg_mass)

    @property
    def servo_masses(self) -> tuple[float, float]:
        """M_s at hip 1 and hip 2 [kg]."""
        return _pair(self.servo_mass)

    @property
    def leg_lengths(self) -> tuple[float, float]:
        """l of leg 1 and leg 2 [m]."""
        return _pair(self.leg_length)

    @property
    def total_mass(self) -> float:
        """Mass of the whole robot [kg]."""
        return self.battery_mass + sum(self.servo_masses) + sum(self.leg_masses)

    @property
    def ground_clearance(self) -> float:
        """Height of a leg tip that points straight down on the upright robot [m]."""
        return self.shell_radius - max(self.leg_lengths)

    def to_dict(self) -> dict[str, Any]:
        """All fields as plain numbers, for metadata and JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> RRRobotParameters:
        """The parameters that `to_dict` wrote; pairs may be lists, as in JSON."""
        return cls(**data)


def _pair(value: PerLeg) -> tuple[float, float]:
    return value if isinstance(value, tuple) else (value, value)


def _checked(name: str, value: Any, unit: str) -> PerLeg:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (tuple, list)):
        if name not in _PER_LEG:
            raise ParameterError(f"{name} is {value!r}: it must be one number, in {unit}.")
        if len(value) != 2:
            raise ParameterError(
                f"{name} has {len(value)} entries, {value!r} {unit}: give one number for both legs "
                "or a pair."
            )
        first, second = (finite(f"{name}[{i}]", v, unit, above=0) for i, v in enumerate(value))
        return first if first == second else (first, second)
    return finite(name, value, unit, above=0)
