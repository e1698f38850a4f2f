"""Blocks of gaits through the engine until they settle, and what they then do per cycle, in Numba.

A gait is a row of a `GaitBatch`. With n equal steps in a period its phase u = w t at every stage of
every step is the same for all gaits, so the sines and cosines are tabulated once, for all.
"""

from __future__ import annotations

import numpy as np

from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import borrowed, compiled, inner
from rrrobot.momentum.kernels import (
    BLOCK,
    DECOUPLED,
    GROUND_END,
    LIFT_OFF,
    N_STATE,
    NOT_FINITE,
    OK,
    ROWS_PER_STEP,
    TIGHT,
    VERTICAL,
    step,
)
from rrrobot.momentum.lane import DET, ROOM
from rrrobot.momentum.legs import tabulate
from rrrobot.momentum.normal import contact_motion, least_sum, push
from rrrobot.momentum.rolling import evaluate_lanes
from rrrobot.momentum.summary import (
    N_RESULT,
    angles,
    drift,
    harmonic,
    least,
    lift,
    motion_of,
    tilt_of,
)
from rrrobot.momentum.terrain import SLOPE
from rrrobot.momentum.vertical import N_PAST, largest_between, may_pass, watch


@compiled()
def settle(  # type: ignore[no-untyped-def]
    tree, axis, limit, terrain, gaits, yaw_gaits, cycles, begin, turns, slope_of, value_of, work,
    motion, sine, out,
):  # fmt: skip
    """Simulate gaits from impulsive starts and write their steady states.

    Args:
        tree, axis, limit, terrain: see `Setting`.
        gaits: offset and winding (n, legs), sine and cosine (n, harmonics, legs), frequency (n,).
        yaw_gaits: those of the yaw model alone, for decoupled models; else not used.
        cycles: of each gait (n,).
        begin: the state that each starts in (n, N_STATE).
        turns: see `turns_of`, (3, rows, harmonics).
        slope_of: (points, steps) from samples of a period to slopes of their trigonometric
            interpolation, times the period; where the motion does not repeat, of a spline's.
        value_of: likewise to the interpolation itself; not used unless axis is ANY.
        work: see `work_of`.
        motion: (n, steps, entries), filled with the last cycle; if decoupled, its z_body alone.
        sine: (n,), filled with the largest |sin pitch|; zero if decoupled.
        out: (n, N_RESULT), filled; of a lane that stopped all but the status is NaN.
    """
    tree, work, gaits, yaw_gaits = (
        borrowed(tree),
        borrowed(work),
        borrowed(gaits),
        borrowed(yaw_gaits),
    )
    turns, slope_of, motion = borrowed(turns), borrowed(slope_of), borrowed(motion)
    value_of = borrowed(value_of)
    if terrain is not None:
        terrain = borrowed(terrain)
    sine, out, begin = borrowed(sine), borrowed(out), borrowed(begin)
    n, n_steps = len(out), slope_of.shape[1]
    for first in range(0, n, LANES):
        for i in range(LANES):
            g = min(first + i, n - 1)
            work.ends[i] = cycles[g]
            for s in range(N_STATE):
                work.h[s * LANES + i] = 2.0 * np.pi / gaits[4][g] / n_steps
                work.state[0][s * LANES + i] = begin[g, s]
        tabulate(tree, gaits, first, turns, work.legs, work.table)
        if axis == DECOUPLED:
            tabulate(tree, yaw_gaits, first, turns, work.legs, work.other)
            for r in range(len(work.table)):
                for i in range(LANES):
                    work.table[r, 5 * LANES + i] = work.other[r, 5 * LANES + i]
                    work.table[r, 14 * LANES + i] = work.other[r, 14 * LANES + i]
        _settle(axis, limit, terrain, first, work, motion, out)
        if terrain is not None:
            least_sum(slope_of, work.lift, work.h, value_of, work.push, work.low, work.sums)
        elif axis != DECOUPLED:
            least(slope_of, work.lift, work.low, work.sums)
        for i in range(min(LANES, n - first)):
            row, period = out[first + i], work.h[i] * n_steps
            for c in range(N_RESULT):
                row[c] = np.nan
            row[N_RESULT - 1], sine[first + i] = work.status[i], work.largest[i]
            if work.status[i] != OK:
                continue
            drift(work.means, period, i, row)
            for a in range(3):
                turned = row[3] * period if a == 2 else 0.0
                harmonic(work.angles, turns, len(work.means), a, turned, i, row)
            if axis != DECOUPLED:
                if terrain is not None:
                    row[14] = work.low[i]
                else:
                    # M g and the least rate of the vertical momentum.
                    weight = work.parameters[i] * work.parameters[3 * LANES + i]
                    row[14] = weight + work.low[i] / period
                # Only a rolling contact can lift off: a pivot also pulls.
                if work.parameters[LANES + i] > 0.0 and row[14] <= 0.0:
                    row[N_RESULT - 1] = LIFT_OFF


@inner
def _settle(axis, limit, terrain, first, work, motion, out):  # type: ignore[no-untyped-def]
    """Simulate a block of lanes: fill their means, angles, lift, status and motion."""
    h, ends, table, par, slopes = work.h, work.ends, work.table, work.parameters, work.slopes
    y, before, total, other = work.state[0], work.state[1], work.state[2], work.state[3]
    n_steps, counted, n_out = len(work.lift), len(work.means), min(LANES, len(out) - first)
    _begin(work.angles, work.sides, work.status, work.largest)
    if terrain is not None:
        for i in range(LANES):
            work.rolling[ROOM * LANES + i] = work.rolling[DET * LANES + i] = np.inf
    last, first_end = 0, ends[0]
    for i in range(LANES):
        last, first_end = max(last, ends[i]), min(first_end, ends[i])
    for cycle in range(last + 1):
        for e in range(3 * LANES):
            work.areas[e] = 0.0
        for n in range(n_steps):
            for e in range(BLOCK):
                before[e] = y[e]
            at = n * ROWS_PER_STEP
            # The step after the last only for the rates at its start.
            step(y, table, at, h, par, axis, slopes, total, other, work.areas, terrain,
                 work.rolling)  # fmt: skip
            if axis == DECOUPLED:
                _check_finite(before, cycle, n, ends, work.status)
            else:
                known = min(cycle * n_steps + n + 1, N_PAST)
                watch(before, slopes, h, work.past, work.sides)
                _check(
                    work.past, known, work.sides, limit, cycle, n, ends, work.largest, work.status
                )
                if terrain is not None and terrain.ground > SLOPE:
                    _check_ground(work.rolling, cycle, n, ends, work.status)
            if cycle == last:
                break
            if cycle < first_end - counted:
                continue
            angles(before, axis, other)
            fresh = False
            for i in range(n_out):
                if ends[i] - counted <= cycle < ends[i]:
                    for s in range(3):
                        work.angles[n, s * LANES + i] += other[s * LANES + i]
                if cycle == ends[i] - 1 and axis == DECOUPLED:
                    tilt_of(before, i, motion[first + i, n])
                elif cycle == ends[i] - 1:
                    motion_of(before, slopes, i, work.now)
                    if terrain is not None:
                        if not fresh:
                            # The stages have gone over the scratch.
                            evaluate_lanes(before, table, at, par, slopes, 0, terrain, work.rolling)
                            fresh = True
                        contact_motion(terrain, work.rolling, i, work.now)
                        work.lift[n, i], work.push[n, i] = push(work.rolling, work.now, par, i)
                    else:
                        work.lift[n, i] = lift(work.now, table, at, i)
                    for s in range(motion.shape[2]):
                        motion[first + i, n, s] = work.now[s]
        for i in range(LANES):
            count = cycle - (ends[i] - counted)
            if 0 <= count < counted:
                for s in range(3):
                    work.means[count, s * LANES + i] = work.areas[s * LANES + i] / (n_steps * h[i])


@inner
def _begin(angles, sides, status, largest):  # type: ignore[no-untyped-def]
    """Nothing is gathered yet."""
    for n in range(len(angles)):
        for e in range(3 * LANES):
            angles[n, e] = 0.0
    for i in range(LANES):
        status[i], largest[i] = OK, 0.0
        sides[0, i], sides[1, i] = 0.0, 1.0


@inner
def _check_finite(y, cycle, n, ends, status):  # type: ignore[no-untyped-def]
    """Note which lanes of single-axis models have numbers that are not finite."""
    for i in range(LANES):
        done = status[i] != OK or cycle > ends[i] or (cycle == ends[i] and n > 0)
        if not done and not np.isfinite(y[i] + y[LANES + i] + y[9 * LANES + i]):
            status[i] = NOT_FINITE


@inner
def _check_ground(b, cycle, n, ends, status):  # type: ignore[no-untyped-def]
    """Note which lanes have come to where the ground ends, or touch it twice."""
    for i in range(LANES):
        if status[i] not in (OK, NOT_FINITE):
            continue
        if cycle > ends[i] or (cycle == ends[i] and n > 0):
            continue
        if b[ROOM * LANES + i] < 0.0:
            status[i] = GROUND_END
        elif b[DET * LANES + i] <= 0.0:
            status[i] = TIGHT


@inner
def _check(past, known, sides, limit, cycle, n, ends, largest, status):  # type: ignore[no-untyped-def]
    """Follow the largest |sin pitch| of the lanes that are not done, and note which stop."""
    for i in range(LANES):
        if status[i] != OK or cycle > ends[i] or (cycle == ends[i] and n > 0):
            continue
        now = past[N_PAST - 1, 0, i]
        if not np.isfinite(now):
            status[i] = NOT_FINITE
            continue
        if may_pass(past, i, known, largest[i]):
            largest[i] = max(largest[i], largest_between(past, i, known))
        largest[i] = max(largest[i], abs(now))
        if limit < 1.0 and (sides[2, i] < 0.0 or largest[i] > limit):
            status[i] = VERTICAL
