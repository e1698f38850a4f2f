"""What a gait is: leg angles with their rates and accelerations at any time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
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
        """What the gait is, as plain data; `rrrobot.gait_from_dict` is the inverse."""


def broadcast_legs(n_legs: int | None, **arrays: ArrayLike) -> tuple[int, list[Array]]:
    """Arrays with one entry per leg; scalars are repeated, two legs if all are scalars."""
    sizes = {name: np.size(value) for name, value in arrays.items() if np.ndim(value) > 0}
    n = max(sizes.values(), default=2) if n_legs is None else leg_count(n_legs)
    return n, [
        vector(name, value, n, broadcast=True, error=GaitError) for name, value in arrays.items()
    ]


def leg_count(n_legs: object) -> int:
    """A number of legs, checked."""
    if isinstance(n_legs, bool) or not isinstance(n_legs, (int, np.integer)) or n_legs < 0:
        raise GaitError(f"n_legs is {n_legs!r}: it must be a whole number, zero or more.")
    return int(n_legs)
