"""What a gait is: leg angles with their rates and accelerations at any time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.errors import GaitError

MOST_HARMONICS = 48
_EXACT = 1e-5
"""Difference [rad] up to which harmonics are the gait."""
_POINTS = 512


class LegMotion(NamedTuple):
    """Leg coordinates and their derivatives, each (legs,) at one time or (n, legs) at n times."""

    angle: Array
    """phi [rad]"""
    rate: Array
    """d phi / dt [rad/s]"""
    acceleration: Array
    """d2 phi / dt2 [rad/s^2]"""


class Harmonics(NamedTuple):
    """A periodic gait by its numbers, with u = omega t:

    phi = offset + winding u + sum over j = 1, 2, ... of sine_j sin(j u) + cosine_j cos(j u).
    """

    offset: Array
    """(legs,) [rad]"""
    winding: Array
    """whole turns of each leg in a period (legs,)"""
    sine: Array
    """(harmonics, legs) [rad]"""
    cosine: Array
    """(harmonics, legs) [rad]"""
    angular_frequency: float
    """omega [rad/s]"""


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
        """What the gait is, as plain data; `rrrobot.gait_from_dict` is the inverse."""

    def harmonics(self) -> Harmonics:
        """The gait as harmonics of its period, which sweeps and optimisers take.

        Here by a Fourier transform of a period: the fewest harmonics that give every angle to
        1e-5 rad.

        Raises:
            GaitError: the gait does not repeat, or has corners that harmonics do not give.
        """
        if self.period is None:
            raise GaitError("the gait has no period, so no cycle of it can be swept or optimised.")
        time = self.period / _POINTS * np.arange(2 * _POINTS)
        angle = self(time).angle
        first, again = angle[:_POINTS], angle[_POINTS:]
        turns = np.round((again[0] - first[0]) / (2 * np.pi))
        if np.abs(again - first - 2 * np.pi * turns).max(initial=0.0) > _EXACT:
            raise GaitError(
                "the gait's second period is not its first (it begins otherwise, as RampIn does): "
                "give the gait that it comes to."
            )
        u = 2 * np.pi / _POINTS * np.arange(_POINTS)
        swing = first - np.multiply.outer(u, turns)
        spectrum = np.fft.rfft(swing, axis=0)[: MOST_HARMONICS + 1] / _POINTS
        for last in range(1, MOST_HARMONICS + 1):
            kept = np.zeros((_POINTS // 2 + 1, self.n_legs), dtype=complex)
            kept[: last + 1] = spectrum[: last + 1] * _POINTS
            if np.abs(np.fft.irfft(kept, _POINTS, axis=0) - swing).max(initial=0.0) <= _EXACT:
                own = 2 * spectrum[1 : last + 1]
                return Harmonics(
                    spectrum[0].real, turns, -own.imag, own.real, 2 * np.pi / self.period
                )
        raise GaitError(
            f"{MOST_HARMONICS} harmonics do not give the gait to {_EXACT:g} rad: smooth its "
            "corners, or simulate it alone."
        )


def broadcast_legs(n_legs: int | None, **arrays: ArrayLike) -> tuple[int, list[Array]]:
    """Arrays with one entry per leg; scalars are repeated, two legs if all are scalars."""
    sizes = {name: np.size(value) for name, value in arrays.items() if np.ndim(value) > 0}
    n = max(sizes.values(), default=2) if n_legs is None else leg_count(n_legs)
    return n, [
        vector(name, value, n, broadcast=True, error=GaitError) for name, value in arrays.items()
    ]


def check_turns(name: str, turns: Array) -> None:
    """Raise GaitError unless all are whole."""
    if np.any(turns != np.round(turns)):
        raise GaitError(
            f"{name} is {turns.tolist()}: it must hold whole turns, so that the gait repeats."
        )


def leg_count(n_legs: object) -> int:
    """A number of legs, checked."""
    if isinstance(n_legs, bool) or not isinstance(n_legs, (int, np.integer)) or n_legs < 0:
        raise GaitError(f"n_legs is {n_legs!r}: it must be a whole number, zero or more.")
    return int(n_legs)
