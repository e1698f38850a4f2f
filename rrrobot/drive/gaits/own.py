"""Gaits of one's own, as a function of time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import finite, vector
from rrrobot.drive.gaits.base import Gait, LegMotion, leg_count
from rrrobot.errors import GaitError


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
        self.n_legs = leg_count(n_legs)
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
        times = np.linspace(start + step, stop - step, 23)
        first = [self._one(t) for t in times]
        for t, earlier in zip(times, first, strict=True):
            before, here, after = self._one(t - step), self._one(t), self._one(t + step)
            if any(np.any(np.abs(a - b) > 1e-9) for a, b in zip(earlier, here, strict=True)):
                raise GaitError(
                    f"gait {self.name!r} remembers: asked twice for t = {t:.4g} s it gave the "
                    f"angles {earlier.angle.tolist()} and then {here.angle.tolist()}, or other "
                    "rates. It is asked back and forth in time, so it must depend on the time "
                    "alone."
                )
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
