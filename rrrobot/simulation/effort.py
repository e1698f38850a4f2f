"""Why a run takes long, or has no end: its length, a fast gait, a sample time, a stiff body."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import ConstraintError, ParameterError, SlowWarning
from rrrobot.integrate import Progress

MANY_STEPS = 50_000
"""Steps from which a run is called long; a minute, about."""
ENDLESS_STEPS = 10_000_000
"""Steps from which a run is refused: a day, about."""
_FIRST_LOOK, _SURE = 500, 2000


class Effort:
    """Warns once of a run that takes long, with the number of steps and the reason."""

    def __init__(self, flow: Any, times: Array, told: Progress | None) -> None:
        self.told = told
        self.rate: Callable[[float, Array], Array] | None = None
        self._start, self._end = float(times[0]), float(times[-1])
        self._longest = flow.stepping.step or flow.stepping.max_step
        self._steps, self._look = 0, _FIRST_LOOK
        span = self._end - self._start
        clocks = flow.drive.law.clocks if hasattr(flow.drive, "law") else ()
        reasons = {f"a longest step of {self._longest:.3g} s": span / self._longest}
        for clock in clocks:
            reasons[f"a sample time of {clock.period:.3g} s"] = span / clock.period
        why = max(reasons, key=lambda key: reasons[key])
        many = reasons[why]
        self._last, self._before = self._start, 0
        self._warned = flow.method != "kkt"
        most = ENDLESS_STEPS if flow.method == "kkt" else 100 * ENDLESS_STEPS
        if many > (most if self._warned else MANY_STEPS):
            period = flow.drive.period
            if period is not None and self._longest == period / 12:
                why += ", a twelfth of the gait's period"
            said = f"{span:.4g} s with {why} are {many:.3g} steps"
            if many > most:
                raise ParameterError(f"{said}: the limit is {most:.0e}. Shorten the run.")
            self._warned = True
            _warn(f"{said}: this takes long.")

    def progress(self, state: Callable[[], Array | None]) -> Progress:
        """What the integrator calls after each step."""

        def step(now: float) -> None:
            self._steps += 1
            if self._steps == self._look and self.rate is not None:
                # The steps since the look before: a start may be rough and what follows smooth.
                mean = (now - self._last) / (self._steps - self._before)
                self._look, self._last, self._before = 4 * self._look, now, self._steps
                self._judge(now, mean, state())
            if self.told is not None:
                self.told(now)

        return step

    def _judge(self, now: float, mean: float, y: Array | None) -> None:
        """Warn, or stop, if the rest at this mean step [s] takes long, or has no end."""
        expected = (self._end - now) / mean
        if y is None or expected < MANY_STEPS:
            return
        told = (
            f"steps of {mean:.3g} s on average make {expected:.3g} steps for "
            f"{self._end - now:.4g} s"
        )
        advice = (
            f"{self._why(now, y)}. Shorten the run, loosen rtol and atol, or soften what is stiff."
        )
        if expected > ENDLESS_STEPS and self._steps >= _SURE:
            raise ConstraintError(f"{told}, and the limit is {ENDLESS_STEPS:.0e}: {advice}")
        if not self._warned:
            self._warned = True
            _warn(f"{told}: this takes long, as {advice}")

    def _why(self, time: float, y: Array) -> str:
        """The fastest mode of the linearised motion at a state, in words."""
        rate = self.rate
        assert rate is not None
        h = 1e-6 * np.maximum(1.0, np.abs(y))
        columns = [(rate(time, y + d) - rate(time, y - d)) / (2 * d.max()) for d in np.diag(h)]
        values = np.linalg.eigvals(np.array(columns).T)
        fastest = values[np.argmax(np.abs(values))]
        size = abs(fastest)
        if size == 0.0:
            return "the motion is fast"
        if abs(fastest.imag) > abs(fastest.real):
            return f"the motion has an oscillation of {2 * np.pi / size:.3g} s"
        return f"the motion is stiff: its shortest time constant is {1 / size:.3g} s"


def _warn(message: str) -> None:
    warnings.warn(message, SlowWarning, stacklevel=2)
