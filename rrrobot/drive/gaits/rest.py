"""Legs at rest, and legs that start from rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import finite
from rrrobot.drive.gaits.base import Gait, LegMotion, broadcast_legs
from rrrobot.errors import GaitError


@serial.register("still")
class StillLegs(Gait):
    """Legs held at fixed angles: phi(t) = angle.

    Example:
        >>> import rrrobot as rr
        >>> rr.StillLegs((1.57, 1.57))(3.0).rate.tolist()
        [0.0, 0.0]
    """

    def __init__(self, angle: ArrayLike, *, n_legs: int | None = None) -> None:
        self.n_legs, (self.angle,) = broadcast_legs(n_legs, angle=angle)

    def __call__(self, time: ArrayLike) -> LegMotion:
        zero = np.zeros((*np.shape(time), self.n_legs))
        return LegMotion(zero + self.angle, zero, zero)

    def to_dict(self) -> dict[str, Any]:
        return {"type": "still", "angle": self.angle.tolist()}


@serial.register("ramp_in")
class RampIn(Gait):
    """Start from rest and blend into a gait: phi = phi_g(0) + s(t / T) (phi_g(t) - phi_g(0)).

    s is the quintic 10 x^3 - 15 x^4 + 6 x^5, so angles, rates and accelerations are continuous
    and the legs start at rest; from t = T on this is the gait itself.

    Args:
        gait: any gait.
        duration: T, greater than zero [s].

    Example:
        >>> import rrrobot as rr
        >>> gait = rr.RampIn(rr.gait("lateral"), duration=2.0)
        >>> gait(0.0).rate.tolist()
        [0.0, 0.0]
    """

    def __init__(self, gait: Gait, duration: float) -> None:
        if not isinstance(gait, Gait):
            raise GaitError(f"gait is {type(gait).__name__}: RampIn blends into a Gait.")
        self.gait = gait
        self.duration = finite("duration", duration, "s", above=0, error=GaitError)
        self.n_legs = gait.n_legs
        self.period = gait.period
        self._start = gait(0.0).angle

    def __call__(self, time: ArrayLike) -> LegMotion:
        motion = self.gait(time)
        x = np.clip(np.asarray(time, dtype=float) / self.duration, 0.0, 1.0)[..., None]
        s = x**3 * (10 - 15 * x + 6 * x * x)
        ds = 30 * x * x * (1 - x) ** 2 / self.duration
        dds = 60 * x * (1 - x) * (1 - 2 * x) / self.duration**2
        swing = motion.angle - self._start
        return LegMotion(
            self._start + s * swing,
            s * motion.rate + ds * swing,
            s * motion.acceleration + 2 * ds * motion.rate + dds * swing,
        )

    def to_dict(self) -> dict[str, Any]:
        return {"type": "ramp_in", "duration": self.duration, "gait": self.gait.to_dict()}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> RampIn:
        """The gait of `to_dict`'s entries."""
        gait: Gait = serial.from_dict(data["gait"], Gait, "gait")  # type: ignore[type-abstract]
        return cls(gait, data["duration"])
