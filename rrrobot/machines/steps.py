"""Integration on constraints: DOP853, and after every step the state is brought back onto them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import ConstraintError, GaitError
from rrrobot.integrate import SHORTEST_STEP, Stepping


class Steps(NamedTuple):
    """Samples of a solution, complete unless `stop` says why not."""

    states: Array
    """(n, ny)"""
    time: float
    """where it stood at the end [s]"""
    state: Array
    """and its state there (ny,)"""
    stop: str | None


def integrate_on(
    rate: Callable[[float, Array], Array],
    correct: Callable[[float, Array], None],
    y0: Array,
    times: Array,
    stepping: Stepping,
) -> Steps:
    """Integrate dy/dt = rate(t, y) over times (n,), `correct` changing y in place after each step.

    Samples are corrected likewise. Stops, and says why, when `rate` raises a ConstraintError or a
    GaitError, as at a singular shape, and when the step falls below `SHORTEST_STEP`.
    """
    from scipy.integrate import DOP853

    used = stepping.checked()
    end = float(times[-1])
    states = np.empty((times.size, y0.size))
    states[0] = y0
    filled, stop = 1, None
    now, y = float(times[0]), y0
    try:
        solver = DOP853(rate, now, y0, end, used.max_step, used.rtol, used.atol)
        while now < end and stop is None:
            failure = solver.step()
            if failure is not None or not np.all(np.isfinite(solver.y)):
                stop = f"the integrator failed: {failure or 'the state is not finite'}".rstrip(".")
                break
            if solver.step_size is not None and solver.step_size < SHORTEST_STEP < end - now:
                stop = f"the step fell to {solver.step_size:.3g} s: the motion is too fast"
                break
            now = float(solver.t)
            reached = int(np.searchsorted(times, now, side="right"))
            if reached > filled:
                states[filled:reached] = solver.dense_output()(times[filled:reached]).T
                for i in range(filled, reached):
                    correct(float(times[i]), states[i])
                filled = reached
            correct(now, solver.y)
            solver.f = rate(now, solver.y)
            y = solver.y
    except (ConstraintError, GaitError) as error:
        stop = str(error).rstrip(".")
    return Steps(states[:filled], now, y, stop)
