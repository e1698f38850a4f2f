"""Viscous losses: a generalised force on each Euler rate (eqs 9-10), or on the body's rates."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from math import cos, sin, tan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import Array, finite, vector
from rrrobot.errors import ParameterError


@dataclass(frozen=True)
class Damping(ABC):
    """Loss on the body, as a moment, and on the legs, as -legs * phi_dot."""

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            checked = finite(f"damping {name}", value, "N m s/rad", at_least=0)
            object.__setattr__(self, name, checked)

    @abstractmethod
    def moment(self, roll: float, pitch: float, omega_body: Array) -> Array:
        """Moment on the body in the body frame (3,) [N m]."""

    @property
    @abstractmethod
    def leg_coefficient(self) -> float:
        """Coefficient of the leg joints [N m s/rad]."""

    @property
    def singular_at_vertical(self) -> bool:
        """Whether the moment is singular where the pitch is +-90 degrees."""
        return False

    def to_dict(self) -> dict[str, Any]:
        """Type and coefficients as plain data."""
        return {"type": type(self).__name__} | asdict(self)


@serial.register("EulerRateDamping")
@dataclass(frozen=True)
class EulerRateDamping(Damping):
    """Generalised force -k theta_dot on each Euler rate: eqs (9) and (10) of the paper.

    The paper prints the matrix with the velocities inside. As a moment on the body it is
    -B^-T diag(k) B^-1 omega, with omega = B theta_dot in the body frame; B is singular at a pitch
    of +-90 degrees.

    Attributes:
        roll, pitch, yaw: coefficients [N m s/rad]; the paper's are 0.01.
        legs: of the leg joints [N m s/rad]. Eq (9) has 0.01 here too. With prescribed legs it
            does not change the motion, only adds legs * phi_dot to the motor torque.

    Example:
        >>> import rrrobot as rr
        >>> eq9 = rr.EulerRateDamping(0.01, 0.01, 0.01, legs=0.01)
        >>> eq9.yaw
        0.01
    """

    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0
    legs: float = 0.0

    def moment(self, roll: float, pitch: float, omega_body: Array) -> Array:
        cr, sr, cp, tp = cos(roll), sin(roll), cos(pitch), tan(pitch)
        x, y, z = omega_body.tolist()
        about = sr * y + cr * z
        on_roll = -self.roll * (x + tp * about)
        on_pitch = -self.pitch * (cr * y - sr * z)
        on_yaw = -self.yaw * about / cp
        lever = tp * on_roll + on_yaw / cp
        return np.array((on_roll, sr * lever + cr * on_pitch, cr * lever - sr * on_pitch))

    @property
    def leg_coefficient(self) -> float:
        return self.legs

    @property
    def singular_at_vertical(self) -> bool:
        return self.roll > 0 or self.pitch > 0 or self.yaw > 0


@serial.register("BodyRateDamping")
@dataclass(frozen=True)
class BodyRateDamping(Damping):
    """Moment -k omega along each body axis; regular at every orientation.

    Attributes:
        x, y, z: coefficients of the angular velocity's components in the body frame
            [N m s/rad].
        legs: of the leg joints [N m s/rad].

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters(), damping=rr.BodyRateDamping(0.01))
        >>> model.damping.x
        0.01
    """

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    legs: float = 0.0

    def moment(self, roll: float, pitch: float, omega_body: Array) -> Array:
        return -omega_body * (self.x, self.y, self.z)

    @property
    def leg_coefficient(self) -> float:
        return self.legs


DampingLike = Damping | float | ArrayLike | str | None


def as_damping(value: DampingLike) -> Damping:
    """A Damping from a number (every Euler rate), three numbers (roll, pitch, yaw), or None (no
    loss)."""
    if isinstance(value, Damping):
        return value
    if value is None:
        return EulerRateDamping()
    if isinstance(value, str):
        raise ParameterError(f"damping is {value!r}: give numbers in N m s/rad, or a Damping.")
    return EulerRateDamping(*vector("damping", value, 3, "N m s/rad", broadcast=True))


def damping_from_dict(data: dict[str, Any]) -> Damping:
    """The damping that `to_dict` wrote."""
    return serial.from_dict(data, Damping, "damping")  # type: ignore[type-abstract]
