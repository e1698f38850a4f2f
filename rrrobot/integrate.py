"""Integration of an ordinary differential equation, sampled at given times.

DOP853, the explicit Runge-Kutta method of order 8 of Dormand and Prince (Hairer, Norsett, Wanner:
Solving Ordinary Differential Equations I), in SciPy's implementation, with its dense output of
order 7 between the steps.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from rrrobot.checks import Array, finite
from rrrobot.errors import ConstraintError, GaitError, ParameterError

Progress = Callable[[float], None]
"""Called with the simulated time [s] after each step."""

RTOL = 1e-10
ATOL = 1e-10
MAX_STEP = 0.04
"""Default tolerances and longest step [s] of the adaptive integrator. They keep the energy of a
robot that rocks or tumbles freely to 1e-9 of itself over half a minute."""


SHORTEST_STEP = 1e-9
"""Step below which the integrator gives up [s]."""


class Observer(Protocol):
    """Sees the states as they come."""

    def sampled(self, first: int, states: Array) -> None:
        """Rows first, first + 1, ... of the samples, after the last `stepped`."""

    def stepped(self, y: Array) -> str | None:
        """The state at the end of a step; a reason to stop, or None."""


class Integration(NamedTuple):
    """Samples of a solution, complete unless `stop` says why not."""

    states: Array
    """(n, ny), n the number of times that were reached"""
    time: float
    """where the integrator stood at the end [s]"""
    state: Array
    """and its state there (ny,)"""
    evaluations: int
    """of the right-hand side"""
    stop: str | None
    """why it stopped early"""
    interrupted: bool
    """whether that was Ctrl-C"""


class Stepping(NamedTuple):
    """How to step: `step` fixed [s], or adaptive by tolerances up to `max_step` [s]."""

    step: float | None = None
    rtol: float = RTOL
    atol: float = ATOL
    max_step: float = MAX_STEP

    def checked(self) -> Stepping:
        """The same, checked.

        Raises:
            ParameterError: a number out of range.
        """
        return Stepping(
            None if self.step is None else finite("step", self.step, "s", above=0),
            finite("rtol", self.rtol, at_least=1e-13),
            finite("atol", self.atol, above=0),
            finite("max_step", self.max_step, "s", above=0),
        )

    def to_dict(self) -> dict[str, Any]:
        """What was used, for metadata."""
        used = ("step",) if self.step is not None else ("rtol", "atol", "max_step")
        return {"integrator": "DOP853"} | {key: getattr(self, key) for key in used}


def integrate(
    rate: Callable[[float, Array], Array],
    y0: Array,
    times: Array,
    stepping: Stepping,
    *,
    observer: Observer | None = None,
    progress: Progress | None = None,
) -> Integration:
    """Integrate dy/dt = rate(t, y) from times[0] to times[-1].

    Stops, and says why, when the observer asks, when a value is not finite, when `rate` raises a
    GaitError or ConstraintError, and on Ctrl-C; the samples up to then are returned.
    """
    from scipy.integrate import DOP853

    stepping = stepping.checked()
    start, end = float(times[0]), float(times[-1])
    states = np.empty((times.size, y0.size))
    states[0] = y0
    if observer is not None:
        observer.sampled(0, states[:1])
    filled, now, y, evaluations = 1, start, y0, 0
    stop, interrupted = None, False
    try:
        if stepping.step is not None:
            # An infinite tolerance accepts every step and so keeps the length fixed.
            first = min(stepping.step, end - start)
            solver = DOP853(
                rate, start, y0, end, stepping.step, 1.0, 1e300, first_step=first
            )  # fmt: skip
        else:
            solver = DOP853(rate, start, y0, end, stepping.max_step, stepping.rtol, stepping.atol)
        while stop is None and now < end:
            failure = solver.step()
            evaluations = solver.nfev
            if failure is not None or not np.all(np.isfinite(solver.y)):
                stop = f"the integrator failed: {failure or 'the state is not finite'}".rstrip(".")
                break
            if solver.step_size is not None and solver.step_size < SHORTEST_STEP < end - now:
                stop = f"the step fell to {solver.step_size:.3g} s: the motion is too fast"
                break
            now, y = float(solver.t), solver.y
            reached = int(np.searchsorted(times, now, side="right"))
            if reached > filled:
                states[filled:reached] = solver.dense_output()(times[filled:reached]).T
                if observer is not None:
                    observer.sampled(filled, states[filled:reached])
                filled = reached
            if observer is not None:
                stop = observer.stepped(y)
            if progress is not None:
                progress(now)
    except KeyboardInterrupt:
        stop, interrupted = "the simulation was interrupted", True
    except (ConstraintError, GaitError) as error:
        stop = str(error).rstrip(".")
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        stop = f"the state ran away within a step ({error}): take a shorter one"
    return Integration(states[:filled], now, y, evaluations, stop, interrupted)


def sample_times(duration: float, interval: float) -> Array:
    """0, interval, 2 interval, ..., duration [s]; both ends, the last interval may be shorter.

    Raises:
        ParameterError: a number out of range, or more than 5e7 samples.
    """
    duration = finite("duration", duration, "s", above=0)
    interval = finite("sample_interval", interval, "s", above=0)
    whole = duration / interval
    if whole > 5e7:
        raise ParameterError(
            f"sample_interval is {interval} s for a duration of {duration} s: that is "
            f"{whole:.3g} samples; the limit is 5e7."
        )
    times: Array = interval * np.arange(int(whole + 1e-9) + 1, dtype=float)
    if duration - times[-1] > 1e-9 * interval:
        return np.append(times, duration)
    times[-1] = duration
    return times
