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
_SAME_TIME = 1e-9
"""Part of a step within which two times are the same."""


class Observer(Protocol):
    """Sees the states as they come."""

    def sampled(self, first: int, states: Array) -> None:
        """Rows first, first + 1, ... of the samples, after the last `stepped`."""

    def stepped(self, ends: Array) -> tuple[int, str] | None:
        """States at the ends of steps (n, ny); the first to stop at and why, or None."""


class Jumps(Protocol):
    """Instants at which the right-hand side, or the state, changes at once."""

    def next(self, time: float) -> float:
        """The first instant later than a time [s]; infinite if there is none."""

    def jump(self, time: float, y: Array) -> Array:
        """The state (ny,) after the instant."""


Correct = Callable[[float, Array], None]
"""(time [s], state (ny,)): changes the state in place."""

Dense = Callable[[Array], Array]
"""States (n, ny) within a step at times (n,) [s]."""


class Watch(Protocol):
    """Looks for events within each step."""

    def step(self, start: float, end: float, dense: Dense) -> float | None:
        """Called after each step; the time [s] at which the integration ends, or None."""


class Integration(NamedTuple):
    """Samples of a solution, complete unless `stop` says why not."""

    times: Array
    """that were reached (n,) [s]; where an event ended the integration, the last is its time"""
    states: Array
    """(n, ny)"""
    time: float
    """where the integrator stood at the end [s]"""
    state: Array
    """and its state there (ny,)"""
    evaluations: int
    """of the right-hand side"""
    stop: str | None = None
    """why it stopped early"""
    interrupted: bool = False
    """whether that was Ctrl-C"""
    ended: bool = False
    """whether an event ended it"""


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
    jumps: Jumps | None = None,
    watch: Watch | None = None,
    progress: Progress | None = None,
    correct: Correct | None = None,
) -> Integration:
    """Integrate dy/dt = rate(t, y) from times[0] to times[-1].

    Fixed steps end at the whole multiples of the step, so a run that is cut in two at one of them
    takes the same steps. No step goes over an instant of `jumps`; a sample at the instant is the
    state after it. `correct` changes the state after each step, and each sample, in place, as back
    onto constraints from which it drifted. Stops, and says why, when the observer asks, when a
    value is not finite, when `rate` raises a GaitError or ConstraintError, and on Ctrl-C; the
    samples up to then are returned.
    """
    run = _Run(rate, y0, times, stepping.checked(), observer, jumps, watch, progress, correct)
    stop, interrupted = None, False
    try:
        run.begin()
        while stop is None and run.now < run.end:
            stop = run.step()
    except KeyboardInterrupt:
        stop, interrupted = "the simulation was interrupted", True
    except (ConstraintError, GaitError) as error:
        stop = str(error).rstrip(".")
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        stop = f"the state ran away within a step ({error}): take a shorter one"
    return run.result(stop, interrupted)


class _Run:
    """One integration on its way."""

    def __init__(
        self,
        rate: Callable[[float, Array], Array],
        y0: Array,
        times: Array,
        stepping: Stepping,
        observer: Observer | None,
        jumps: Jumps | None,
        watch: Watch | None,
        progress: Progress | None,
        correct: Correct | None,
    ) -> None:
        self.correct = correct
        self.rate, self.times, self.stepping = rate, times, stepping
        self.observer, self.jumps, self.watch, self.progress = observer, jumps, watch, progress
        self.now, self.end, self.y = float(times[0]), float(times[-1]), y0
        self.states = np.empty((times.size, y0.size))
        self.filled = 0
        self.ended = False
        self.solver: Any = None
        self._fill(self.now, lambda t: np.tile(y0, (t.size, 1)))

    def begin(self) -> None:
        from scipy.integrate import DOP853

        fixed, start, end = self.stepping, self.now, self.end
        if fixed.step is not None:
            # An infinite tolerance accepts every step and so keeps the length fixed.
            self.solver = DOP853(
                self.rate, start, self.y, end, rtol=1.0, atol=1e300, first_step=end - start
            )
        else:
            self.solver = DOP853(
                self.rate, start, self.y, end, fixed.max_step, fixed.rtol, fixed.atol
            )

    def step(self) -> str | None:
        """One step, its samples and events; a reason to stop, or None."""
        solver, start = self.solver, self.now
        jump = self.jumps.next(start) if self.jumps is not None else np.inf
        bound = min(jump, self.end)
        usual = solver.h_abs
        if self.stepping.step is not None:
            bound = _node(start, bound, self.stepping.step)
            usual = solver.h_abs = 2.0 * (bound - start)
        solver.t_bound, solver.status = bound, "running"
        failure = solver.step()
        if failure is not None or not np.all(np.isfinite(solver.y)):
            return f"the integrator failed: {failure or 'the state is not finite'}".rstrip(".")
        if solver.step_size < SHORTEST_STEP < bound - start:
            return f"the step fell to {solver.step_size:.3g} s: the motion is too fast"
        self.now, self.y = float(solver.t), solver.y
        dense: list[Any] = []

        def inside(times: Array) -> Array:
            if not dense:
                dense.append(solver.dense_output())
            return np.asarray(dense[0](times)).T

        found = None if self.watch is None else self.watch.step(start, self.now, inside)
        if found is not None:
            self._end(found, inside)
            return None
        lands = self.now == jump
        self._fill(self.now - (_SAME_TIME * (self.now - start) if lands else 0.0), inside)
        if lands and self.jumps is not None:
            self.y = solver.y = self.jumps.jump(self.now, self.y)
            solver.f = solver.fun(solver.t, solver.y)
            # The step before was cut short at the instant; the next need not be as short.
            solver.h_abs = max(solver.h_abs, usual)
            after = self.now + _SAME_TIME * (self.now - start)
            self._fill(after, lambda t: np.tile(self.y, (t.size, 1)))
        if self.correct is not None:
            self.correct(self.now, solver.y)
            solver.f = solver.fun(solver.t, solver.y)
        stop = self.observer.stepped(self.y[None]) if self.observer is not None else None
        if self.progress is not None:
            self.progress(self.now)
        return None if stop is None else stop[1]

    def _fill(self, until: float, values: Dense) -> None:
        """Samples up to a time."""
        reached = int(np.searchsorted(self.times, until, side="right"))
        if reached > self.filled:
            self.states[self.filled : reached] = values(self.times[self.filled : reached])
            if self.correct is not None and self.solver is not None:
                for i in range(self.filled, reached):
                    self.correct(float(self.times[i]), self.states[i])
            if self.observer is not None:
                self.observer.sampled(self.filled, self.states[self.filled : reached])
            self.filled = reached

    def _end(self, time: float, inside: Dense) -> None:
        """Samples up to an event, and one at it."""
        n = int(np.searchsorted(self.times, time, side="left"))
        self.times = np.append(self.times[:n], time)
        self.states = self.states[: n + 1]
        self._fill(time, inside)
        self.now, self.y = time, self.states[n].copy()
        self.end, self.ended = time, True

    def result(self, stop: str | None, interrupted: bool) -> Integration:
        n = self.filled
        evaluations = 0 if self.solver is None else self.solver.nfev
        return Integration(
            self.times[:n], self.states[:n], self.now, self.y, evaluations, stop, interrupted,
            self.ended,
        )  # fmt: skip


def _node(start: float, bound: float, step: float) -> float:
    """End of a fixed step: the next whole multiple of `step`, or `bound` if that comes first."""
    node = step * (np.floor(start / step + _SAME_TIME) + 1)
    return bound if node > bound - _SAME_TIME * step else float(node)


def sample_times(duration: float, interval: float, start: float = 0.0) -> Array:
    """start, start + interval, ..., start + duration [s]; both ends, the last may be nearer.

    A start at a whole multiple of the interval gives multiples of it to the last bit, so that a
    run that is continued has the times of one that was not cut.

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
    before = round(start / interval)
    aligned = abs(start / interval - before) < 1e-9
    count = np.arange(int(whole + 1e-9) + 1, dtype=float)
    times: Array = interval * (count + before) if aligned else start + interval * count
    times[0], end = start, start + duration
    if end - times[-1] > 1e-9 * interval:
        return np.append(times, end)
    times[-1] = end
    return times
