"""One period of a block of limit cycles, looked at: net motion, amplitudes, phases, forces."""

from __future__ import annotations

import numpy as np

from rrrobot.momentum.charts import put, take
from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import inner
from rrrobot.momentum.kernels import (
    BLOCK,
    DECOUPLED,
    LIFT_OFF,
    NOT_FINITE,
    OK,
    ROWS_PER_STEP,
    VERTICAL,
    step,
)
from rrrobot.momentum.newton import TOLERANCE
from rrrobot.momentum.normal import contact_motion, least_sum, push
from rrrobot.momentum.rolling import evaluate_lanes
from rrrobot.momentum.summary import (
    N_RESULT,
    angles,
    between,
    harmonic,
    least,
    lift,
    motion_of,
    tilt_of,
)

_STATUS = N_RESULT - 1
NO_ORBIT = 7
"""A further reason why a gait has no steady state: no orbit of one period was found."""


@inner
def look(chart, axis, terrain, first, work, motion):  # type: ignore[no-untyped-def]
    """One period from the trial with heading and place: fills angles, lift, push, tilt, areas,
    motion, the end state, and its image."""
    s = work.search
    table, h, par, slopes = work.tables[2], work.h[2], work.parameters, work.slopes
    y, before, total, other = work.state[0], work.state[1], work.state[2], work.state[3]
    put(chart, s.trial, s.scale, y, True)
    for e in range(3 * LANES):
        work.areas[e] = 0.0
    for n in range(len(work.lift)):
        for e in range(BLOCK):
            before[e] = y[e]
        at = n * ROWS_PER_STEP
        step(y, table, at, h, par, axis, slopes, total, other, work.areas, terrain, work.rolling)
        angles(before, axis, work.angles[n])
        if axis == DECOUPLED:
            for i in range(min(LANES, len(motion) - first)):
                tilt_of(before, i, motion[first + i, n])
            continue
        if terrain is not None:
            # The stages have gone over the scratch.
            evaluate_lanes(before, table, at, par, slopes, 0, terrain, work.rolling)
        for i in range(LANES):
            motion_of(before, slopes, i, work.now)
            work.tilt[n, i] = work.now[0]
            if terrain is not None:
                contact_motion(terrain, work.rolling, i, work.now)
                work.lift[n, i], work.push[n, i] = push(work.rolling, work.now, par, i)
            else:
                work.lift[n, i] = lift(work.now, table, at, i)
            if first + i < len(motion):
                for k in range(motion.shape[2]):
                    motion[first + i, n, k] = work.now[k]
    take(chart, y, s.scale, s.image)


@inner
def extremes(axis, terrain, slope_of, value_of, work):  # type: ignore[no-untyped-def]
    """Least of what makes the normal force, and largest |sin pitch|, between the steps."""
    if axis == DECOUPLED:
        return
    low, steep, value = work.low, work.steep, work.sums[0]
    for i in range(len(steep)):
        steep[i] = 0.0
    for m in range(len(value_of)):
        between(value_of[m], work.tilt, value)
        for i in range(len(steep)):
            steep[i] = max(steep[i], abs(value[i]))
    if terrain is not None:
        least_sum(slope_of, work.lift, work.h[2], value_of, work.push, low, work.sums)
    else:
        least(slope_of, work.lift, low, work.sums)


@inner
def summarise(axis, limit, terrain, turns, work, i, row):  # type: ignore[no-untyped-def]
    """Steady state of lane i, from the look at its period; see `rrrobot.orbits.measures`."""
    y, n_steps = work.state[0], len(work.lift)
    period = work.h[2, i] * n_steps
    residual = work.search.size[i]
    row[13], row[_STATUS] = residual, OK
    if not residual <= TOLERANCE:
        row[_STATUS] = NO_ORBIT if np.isfinite(residual) else NOT_FINITE
        return
    turn = y[9 * LANES + i]
    c, s = np.cos(turn), np.sin(turn)
    mx, my = work.areas[i] / period, work.areas[LANES + i] / period
    dx = (y[7 * LANES + i] + c * mx - s * my - mx) / period
    dy = (y[8 * LANES + i] + s * mx + c * my - my) / period
    heading = work.areas[2 * LANES + i] / period + 0.5 * turn
    c, s = np.cos(heading), np.sin(heading)
    row[0], row[1], row[2] = np.hypot(dx, dy), c * dx + s * dy, c * dy - s * dx
    row[3] = turn / period
    for a in range(3):
        harmonic(work.angles, turns, 1, a, turn if a == 2 else 0.0, i, row)
    if axis == DECOUPLED:
        return
    row[15] = work.steep[i]
    if terrain is not None:
        row[14] = work.low[i]
    else:
        weight = work.parameters[i] * work.parameters[3 * LANES + i]
        row[14] = weight + work.low[i] / period
    if work.steep[i] > limit:
        row[_STATUS] = VERTICAL
    elif work.parameters[LANES + i] > 0.0 and row[14] <= 0.0:
        row[_STATUS] = LIFT_OFF
