"""Legs that swing in sums of harmonics, and go round in whole turns."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import Array, finite, vector
from rrrobot.drive.gaits.base import Gait, Harmonics, LegMotion, check_turns
from rrrobot.errors import GaitError


@serial.register("fourier")
class FourierGait(Gait):
    """phi_k(t) = offset_k + winding_k omega t
                + sum over j of cosine_jk cos(j omega t) + sine_jk sin(j omega t).

    Args:
        offset: mean angle of each leg (legs,) [rad].
        cosine: coefficients of harmonics j = 1, 2, ... (harmonics, legs) [rad].
        sine: likewise.
        angular_frequency: omega of the first harmonic, greater than zero [rad/s].
        winding: whole turns of each leg in a period, or one number for all: legs that go round
            and round. With no harmonics they do so at a constant rate.

    Raises:
        GaitError: shapes that do not match, entries that are not finite, omega <= 0, turns that
            are not whole.

    Example:
        >>> import rrrobot as rr
        >>> gait = rr.FourierGait(offset=(1.57, 1.57), cosine=[[0, 0.3]], sine=[[0.3, 0]],
        ...                       angular_frequency=8.0)
        >>> gait(0.0).angle.tolist()
        [1.57, 1.87]
        >>> paddle = rr.FourierGait(offset=(0, 3), cosine=[[0, 0]], sine=[[0, 0]],
        ...                         angular_frequency=2.0, winding=(1, -1))
        >>> paddle(0.0).rate.tolist()
        [2.0, -2.0]
    """

    def __init__(
        self,
        *,
        offset: ArrayLike,
        cosine: ArrayLike,
        sine: ArrayLike,
        angular_frequency: float,
        winding: ArrayLike = 0,
    ) -> None:
        self.offset = vector("offset", offset, np.size(offset), error=GaitError)
        self.n_legs = self.offset.size
        self.angular_frequency = finite(
            "angular_frequency", angular_frequency, "rad/s", above=0, error=GaitError
        )
        self.cosine, self.sine = (
            self._coefficients("cosine", cosine),
            self._coefficients("sine", sine),
        )
        if self.cosine.shape != self.sine.shape:
            raise GaitError(
                f"cosine has shape {self.cosine.shape} and sine {self.sine.shape}: both must be "
                "(harmonics, legs)."
            )
        self.winding = vector("winding", winding, self.n_legs, broadcast=True, error=GaitError)
        check_turns("winding", self.winding)
        self.period = 2 * np.pi / self.angular_frequency
        self._omega = self.angular_frequency * np.arange(1, len(self.cosine) + 1)

    def _coefficients(self, name: str, value: ArrayLike) -> Array:
        rule = f"it must hold finite numbers, (harmonics, {self.n_legs})"
        try:
            array = np.atleast_2d(np.array(value, dtype=float))
        except (TypeError, ValueError) as cause:
            raise GaitError(f"{name} is {value!r}: {rule}.") from cause
        if array.ndim != 2 or array.shape[1] != self.n_legs:
            raise GaitError(f"{name} has shape {array.shape}: {rule}.")
        if not np.all(np.isfinite(array)):
            raise GaitError(f"{name} is {array.tolist()}: {rule}.")
        return array

    def __call__(self, time: ArrayLike) -> LegMotion:
        angle = np.multiply.outer(time, self._omega)
        c, s, w = np.cos(angle), np.sin(angle), self._omega[:, None]
        a, b = self.cosine, self.sine
        turning = self.winding * self.angular_frequency
        return LegMotion(
            self.offset + np.multiply.outer(time, turning) + c @ a + s @ b,
            turning + c @ (w * b) - s @ (w * a),
            -(c @ (w * w * a) + s @ (w * w * b)),
        )

    def to_dict(self) -> dict[str, Any]:
        return {
            "type": "fourier",
            "offset": self.offset.tolist(),
            "cosine": self.cosine.tolist(),
            "sine": self.sine.tolist(),
            "angular_frequency": self.angular_frequency,
            "winding": self.winding.tolist(),
        }

    def harmonics(self) -> Harmonics:
        return Harmonics(self.offset, self.winding, self.sine, self.cosine, self.angular_frequency)
