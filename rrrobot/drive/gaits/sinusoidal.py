"""Legs that swing in sinusoids, and the paper's two gaits of that kind by name."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import Array
from rrrobot.drive.gaits.base import Gait, Harmonics, LegMotion, broadcast_legs
from rrrobot.errors import GaitError

_LARGEST = 1e6
"""Angle whose sine is still good to 1e-10 [rad]."""


@serial.register("sinusoidal")
class SinusoidalGait(Gait):
    """phi_k(t) = offset_k + amplitude_k sin(omega_k t + phase_k).

    Args:
        offset: centre of each leg's swing; pi/2 is straight up [rad].
        amplitude: of the swing [rad].
        angular_frequency: omega, greater than zero [rad/s].
        phase: [rad].
        n_legs: number of legs; needed only when every argument is a scalar and the robot does
            not have two legs.

    Scalars are repeated for every leg.

    Raises:
        GaitError: arrays of different sizes, entries that are not finite, omega <= 0, offsets or
            phases beyond 1e6 rad.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> gait = rr.SinusoidalGait(offset=np.pi / 2, amplitude=0.3, angular_frequency=8.0,
        ...                          phase=(0.0, np.pi / 2))
        >>> gait(0.0).rate.round(3).tolist()
        [2.4, 0.0]
    """

    def __init__(
        self,
        *,
        offset: ArrayLike,
        amplitude: ArrayLike,
        angular_frequency: ArrayLike,
        phase: ArrayLike = 0.0,
        n_legs: int | None = None,
    ) -> None:
        self.n_legs, (self.offset, self.amplitude, self.angular_frequency, self.phase) = (
            broadcast_legs(
                n_legs,
                offset=offset,
                amplitude=amplitude,
                angular_frequency=angular_frequency,
                phase=phase,
            )
        )
        if not np.all(self.angular_frequency > 0):
            raise GaitError(
                f"angular_frequency is {self.angular_frequency.tolist()} rad/s: it must be "
                "greater than zero; use StillLegs for legs that do not move."
            )
        for name in ("offset", "phase"):
            if np.any(np.abs(getattr(self, name)) > _LARGEST):
                raise GaitError(
                    f"{name} is {getattr(self, name).tolist()} rad: beyond {_LARGEST:g} rad the "
                    "sines are rounding errors; take whole turns off."
                )
        self.period = _common_period(self.angular_frequency)

    def __call__(self, time: ArrayLike) -> LegMotion:
        omega = self.angular_frequency
        angle = np.multiply.outer(time, omega) + self.phase
        swing = self.amplitude * np.sin(angle)
        rate = self.amplitude * omega * np.cos(angle)
        return LegMotion(self.offset + swing, rate, -omega * omega * swing)

    def to_dict(self) -> dict[str, Any]:
        keys = ("offset", "amplitude", "angular_frequency", "phase")
        return {"type": "sinusoidal"} | {key: getattr(self, key).tolist() for key in keys}

    def harmonics(self) -> Harmonics:
        if self.period is None:
            raise GaitError(
                f"the frequencies {self.angular_frequency.tolist()} rad/s have no common period, "
                "so no cycle of the gait can be swept or optimised."
            )
        base = 2 * np.pi / self.period
        if np.ptp(self.angular_frequency) == 0.0:
            base = float(self.angular_frequency[0])
        order = np.round(self.angular_frequency / base).astype(int)
        sine, cosine = np.zeros((2, order.max(), self.n_legs))
        for leg, (k, a, phase) in enumerate(zip(order, self.amplitude, self.phase, strict=True)):
            sine[k - 1, leg], cosine[k - 1, leg] = a * math.cos(phase), a * math.sin(phase)
        return Harmonics(self.offset, np.zeros(self.n_legs), sine, cosine, base)

    def __repr__(self) -> str:
        return (
            f"SinusoidalGait(offset={self.offset.tolist()}, amplitude={self.amplitude.tolist()}, "
            f"angular_frequency={self.angular_frequency.tolist()}, phase={self.phase.tolist()})"
        )


def gait(
    name: str,
    *,
    amplitude: float = 0.3,
    angular_frequency: float = 8.0,
    phase_difference: float = np.pi / 2,
) -> SinusoidalGait:
    """The paper's gaits: "lateral" (Gait 1, offset pi/2) and "circular" (Gait 2, offset pi/4).

    Leg 2 leads leg 1 by the phase difference.

    Example:
        >>> import rrrobot as rr
        >>> rr.gait("circular").offset.round(4).tolist()
        [0.7854, 0.7854]
    """
    offsets = {"lateral": np.pi / 2, "circular": np.pi / 4}
    if name not in offsets:
        raise GaitError(f"gait is {name!r}: it must be one of {', '.join(offsets)}.")
    return SinusoidalGait(
        offset=(offsets[name],) * 2,
        amplitude=amplitude,
        angular_frequency=angular_frequency,
        phase=(0.0, phase_difference),
    )


def _common_period(omega: Array) -> float | None:
    """Shortest time after which all sinusoids repeat, if their ratios are small fractions."""
    if omega.size == 0:
        return None
    base = float(omega.min())
    for denominator in range(1, 33):
        turns = omega / base * denominator
        whole = np.round(turns)
        if np.all(np.abs(turns - whole) < 1e-12 * turns):
            return 2 * np.pi * denominator / base
    return None
