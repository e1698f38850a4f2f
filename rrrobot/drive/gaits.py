"""Leg trajectories: phi(t) with its first and second derivative.

A gait is called with a time or an array of times and answers the legs' angles [rad] (or positions
[m] of prismatic joints), rates and accelerations. Analytic derivatives make the prescribed-leg
dynamics exact; a gait of your own is checked against finite differences.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import Array, finite, vector
from rrrobot.errors import GaitError


class LegMotion(NamedTuple):
    """Leg coordinates and their derivatives, each (legs,) at one time or (n, legs) at n times."""

    angle: Array
    """phi [rad]"""
    rate: Array
    """d phi / dt [rad/s]"""
    acceleration: Array
    """d2 phi / dt2 [rad/s^2]"""


class Gait(ABC):
    """A leg trajectory. A subclass gives `__call__`, `n_legs` and, if it repeats, `period`."""

    n_legs: int
    period: float | None = None
    """Time after which the motion repeats [s]; None if it does not, or if the legs are still."""

    @abstractmethod
    def __call__(self, time: ArrayLike) -> LegMotion:
        """Leg motion at a time or at an array of times [s]."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """What the gait is, as plain data for metadata."""


def _broadcast_legs(n_legs: int | None, **arrays: ArrayLike) -> tuple[int, list[Array]]:
    """Arrays with one entry per leg; scalars are repeated, two legs if all are scalars."""
    sizes = {name: np.size(value) for name, value in arrays.items() if np.ndim(value) > 0}
    n = max(sizes.values(), default=2) if n_legs is None else _leg_count(n_legs)
    return n, [
        vector(name, value, n, broadcast=True, error=GaitError) for name, value in arrays.items()
    ]


def _leg_count(n_legs: object) -> int:
    if isinstance(n_legs, bool) or not isinstance(n_legs, (int, np.integer)) or n_legs < 0:
        raise GaitError(f"n_legs is {n_legs!r}: it must be a whole number, zero or more.")
    return int(n_legs)


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
        GaitError: arrays of different sizes, entries that are not finite, omega <= 0.

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
            _broadcast_legs(
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

    def __repr__(self) -> str:
        return (
            f"SinusoidalGait(offset={self.offset.tolist()}, amplitude={self.amplitude.tolist()}, "
            f"angular_frequency={self.angular_frequency.tolist()}, phase={self.phase.tolist()})"
        )


@serial.register("fourier")
class FourierGait(Gait):
    """phi_k(t) = offset_k + sum over j of cosine_jk cos(j omega t) + sine_jk sin(j omega t).

    Args:
        offset: mean angle of each leg (legs,) [rad].
        cosine: coefficients of harmonics j = 1, 2, ... (harmonics, legs) [rad].
        sine: likewise.
        angular_frequency: omega of the first harmonic, greater than zero [rad/s].

    Raises:
        GaitError: shapes that do not match, entries that are not finite, omega <= 0.

    Example:
        >>> import rrrobot as rr
        >>> gait = rr.FourierGait(offset=(1.57, 1.57), cosine=[[0, 0.3]], sine=[[0.3, 0]],
        ...                       angular_frequency=8.0)
        >>> gait(0.0).angle.tolist()
        [1.57, 1.87]
    """

    def __init__(
        self,
        *,
        offset: ArrayLike,
        cosine: ArrayLike,
        sine: ArrayLike,
        angular_frequency: float,
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
        return LegMotion(
            self.offset + c @ a + s @ b,
            c @ (w * b) - s @ (w * a),
            -(c @ (w * w * a) + s @ (w * w * b)),
        )

    def to_dict(self) -> dict[str, Any]:
        return {
            "type": "fourier",
            "offset": self.offset.tolist(),
            "cosine": self.cosine.tolist(),
            "sine": self.sine.tolist(),
            "angular_frequency": self.angular_frequency,
        }


@serial.register("still")
class StillLegs(Gait):
    """Legs held at fixed angles: phi(t) = angle.

    Example:
        >>> import rrrobot as rr
        >>> rr.StillLegs((1.57, 1.57))(3.0).rate.tolist()
        [0.0, 0.0]
    """

    def __init__(self, angle: ArrayLike, *, n_legs: int | None = None) -> None:
        self.n_legs, (self.angle,) = _broadcast_legs(n_legs, angle=angle)

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


class CallableGait(Gait):
    """A gait of your own: function(t) -> (angle, rate, acceleration), each (legs,).

    The derivatives are compared with central differences over `check_span` when it is made.

    Args:
        function: of one time [s].
        n_legs: number of legs.
        period: if the motion repeats [s].
        check_span: (from, to) times of the check [s].
        name: for metadata.

    Raises:
        GaitError: wrong sizes, values that are not finite, derivatives that do not match.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> def swing(t):
        ...     return np.array([t**2, 1.0]), np.array([2 * t, 0.0]), np.array([2.0, 0.0])
        >>> rr.CallableGait(swing, n_legs=2)(1.5).angle.tolist()
        [2.25, 1.0]
    """

    def __init__(
        self,
        function: Callable[[float], tuple[ArrayLike, ArrayLike, ArrayLike]],
        *,
        n_legs: int,
        period: float | None = None,
        check_span: tuple[float, float] = (0.0, 10.0),
        name: str | None = None,
    ) -> None:
        if not callable(function):
            raise GaitError(f"function is {function!r}: it must be callable with a time.")
        self.function = function
        self.n_legs = _leg_count(n_legs)
        self.period = (
            None if period is None else finite("period", period, "s", above=0, error=GaitError)
        )
        self.name = name or getattr(function, "__name__", type(function).__name__)
        start, stop = vector("check_span", check_span, 2, "s", error=GaitError)
        if not stop > start:
            raise GaitError(f"check_span is {check_span!r} s: it must end after it starts.")
        self._check(float(start), float(stop))

    def _one(self, time: float) -> LegMotion:
        value = self.function(time)
        if not isinstance(value, tuple) or len(value) != 3:
            raise GaitError(
                f"gait {self.name!r} returned {type(value).__name__}: it must return the tuple "
                "(angle, rate, acceleration)."
            )
        parts = zip(("angle", "rate", "acceleration"), value, strict=True)
        return LegMotion(
            *(
                vector(f"{part} of gait {self.name!r} at t = {time:g} s", v, self.n_legs,
                       error=GaitError)
                for part, v in parts
            )
        )  # fmt: skip

    def __call__(self, time: ArrayLike) -> LegMotion:
        if np.ndim(time) == 0:
            return self._one(float(time))  # type: ignore[arg-type]
        motions = [self._one(float(t)) for t in np.ravel(time)]
        shape = (*np.shape(time), self.n_legs)
        return LegMotion(*(np.reshape(part, shape) for part in zip(*motions, strict=True)))

    def _check(self, start: float, stop: float) -> None:
        step = 1e-3 * (stop - start) / 10
        for t in np.linspace(start + step, stop - step, 23):
            before, here, after = self._one(t - step), self._one(t), self._one(t + step)
            for given, low, high, what in (
                (here.rate, before.angle, after.angle, "rate"),
                (here.acceleration, before.rate, after.rate, "acceleration"),
            ):
                difference = (high - low) / (2 * step)
                scale = 1.0 + np.abs(difference) + np.abs(given)
                if np.any(np.abs(given - difference) > 1e-3 * scale):
                    raise GaitError(
                        f"gait {self.name!r}: its {what} at t = {t:.4g} s is {given.tolist()}, "
                        f"but the finite difference is {difference.tolist()}."
                    )

    def to_dict(self) -> dict[str, Any]:
        return {"type": "callable", "name": self.name, "period": self.period}


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
