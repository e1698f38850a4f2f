"""Blocks of gaits through the engine until they settle, and what they then do per cycle, in Numba.

A gait is phi = offset + sum over j = 1, 2, ... of sine_j sin(j w t) + cosine_j cos(j w t). With n
equal steps in a period the phase w t at every stage of every step is the same for all gaits, so
its sines and cosines are tabulated once, for all.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.momentum.coefficients import (
    LANES,
    N_COEFFICIENTS,
    LaneWork,
    fill_lanes,
    lane_work,
)
from rrrobot.momentum.compiled import borrowed, inner, lanes
from rrrobot.momentum.kernels import (
    BLOCK,
    DECOUPLED,
    LIFT_OFF,
    N_STAGES,
    N_STATE,
    NOT_FINITE,
    OK,
    VERTICAL,
    step,
)
from rrrobot.momentum.lowering import Setting
from rrrobot.momentum.summary import (
    N_MOTION,
    N_RESULT,
    ROWS_PER_STEP,
    angles,
    drift,
    harmonic,
    least,
    lift,
    motion_of,
)
from rrrobot.momentum.vertical import N_PAST, largest_between, may_pass, watch


class FourierGaits(NamedTuple):
    """Gaits, one a row: phi = offset + sum over j of sine_j sin(j w t) + cosine_j cos(j w t)."""

    offset: Array
    """(n, legs) [rad]"""
    sine: Array
    """(n, harmonics, legs) [rad]"""
    cosine: Array
    """(n, harmonics, legs) [rad]"""
    angular_frequency: Array
    """(n,) [rad/s]"""


class Work(NamedTuple):
    """Room for a block of LANES gaits."""

    lanes: LaneWork
    gait: Array
    """offset, then a sine and a cosine for each harmonic (1 + 2 harmonics, legs, LANES)"""
    omega: Array
    """(LANES,) [rad/s]"""
    table: Array
    """coefficients (rows, 15 LANES)"""
    other: Array
    """those of the yaw model alone"""
    parameters: Array
    """(N_PARAMETER LANES,)"""
    h: Array
    """step of each lane, for each entry of its state (BLOCK,) [s]"""
    ends: NDArray[np.int64]
    """cycles of each lane (LANES,)"""
    state: Array
    """now, at the step before, and scratch (4, BLOCK)"""
    slopes: Array
    """(N_STAGES, BLOCK)"""
    areas: Array
    """integrals of x, y and yaw over a cycle (3 LANES,)"""
    means: Array
    """of x, y and yaw over the counted cycles (counted, 3 LANES)"""
    angles: Array
    """roll, pitch and yaw at the steps of a cycle, summed over the counted ones (n, 3 LANES)"""
    lift: Array
    """vertical momentum relative to the centre at the steps of the last cycle (n, LANES)"""
    status: NDArray[np.int64]
    """(LANES,)"""
    largest: Array
    """|sin pitch| (LANES,)"""
    past: Array
    """see `watch` (N_PAST, 2, LANES)"""
    sides: Array
    """likewise (3, LANES)"""
    now: Array
    """one lane's motion (N_MOTION,)"""


def work_of(setting: Setting, harmonics: int, counted: int, n_steps: int) -> Work:
    """Room for blocks of gaits of a number of steps."""
    lanes, rows = lane_work(setting.tree), n_steps * ROWS_PER_STEP + 1
    legs, width = len(lanes.angle), N_COEFFICIENTS * LANES
    return Work(
        lanes, np.zeros((1 + 2 * harmonics, legs, LANES)), np.zeros(LANES),
        np.zeros((rows, width)), np.zeros((rows if setting.axis == DECOUPLED else 0, width)),
        np.repeat(setting.parameters, LANES), np.zeros(BLOCK), np.zeros(LANES, dtype=np.int64),
        np.zeros((4, BLOCK)), np.zeros((N_STAGES, BLOCK)), np.zeros(3 * LANES),
        np.zeros((counted, 3 * LANES)), np.zeros((n_steps, 3 * LANES)), np.zeros((n_steps, LANES)),
        np.zeros(LANES, dtype=np.int64), np.zeros(LANES), np.zeros((N_PAST, 2, LANES)),
        np.zeros((3, LANES)), np.zeros(N_MOTION),
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def settle(  # type: ignore[no-untyped-def]
    tree, axis, limit, gaits, yaw_gaits, cycles, turns, slope_of, work, motion, sine, out
):
    """Simulate gaits from an upright impulsive start and write their steady states.

    Args:
        tree, axis, limit: see `Setting`.
        gaits: offset (n, legs), sine and cosine (n, harmonics, legs), frequency (n,).
        yaw_gaits: those of the yaw model alone, for decoupled models; else not used.
        cycles: of each gait (n,).
        turns: sines and cosines of the gait's phase, (2, rows, harmonics).
        slope_of: (points, steps) from samples of a period to slopes of their trigonometric
            interpolation, times the period.
        work: see `work_of`.
        motion: (n, steps, N_MOTION), filled with the last cycle; (0, steps, ...) to leave it.
        sine: (n,), filled with the largest |sin pitch|.
        out: (n, N_RESULT), filled; of a lane that stopped all but the status is NaN.
    """
    tree, work, gaits, yaw_gaits = (
        borrowed(tree),
        borrowed(work),
        borrowed(gaits),
        borrowed(yaw_gaits),
    )
    turns, slope_of, motion = borrowed(turns), borrowed(slope_of), borrowed(motion)
    sine, out = borrowed(sine), borrowed(out)
    n, n_steps = len(out), slope_of.shape[1]
    for first in range(0, n, LANES):
        for i in range(LANES):
            g = min(first + i, n - 1)
            work.ends[i] = cycles[g]
            for s in range(N_STATE):
                work.h[s * LANES + i] = 2.0 * np.pi / gaits[3][g] / n_steps
        _tabulate(tree, gaits, first, turns, work, work.table)
        if axis == DECOUPLED:
            _tabulate(tree, yaw_gaits, first, turns, work, work.other)
            for r in range(len(work.table)):
                for i in range(LANES):
                    work.table[r, 5 * LANES + i] = work.other[r, 5 * LANES + i]
                    work.table[r, 14 * LANES + i] = work.other[r, 14 * LANES + i]
        _settle(axis, limit, first, work, motion, out)
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
                # M g and the least rate of the vertical momentum.
                weight = work.parameters[i] * work.parameters[3 * LANES + i]
                row[14] = weight + least(slope_of, work.lift, i) / period
                # Only a rolling contact can lift off: a pivot also pulls.
                if work.parameters[LANES + i] > 0.0 and row[14] <= 0.0:
                    row[N_RESULT - 1] = LIFT_OFF


@inner
def _tabulate(tree, gaits, first, turns, work, table):  # type: ignore[no-untyped-def]
    """Coefficients of LANES gaits over their periods (rows, 15 LANES)."""
    offset, sine, cosine, omega = gaits
    n, legs = offset.shape
    harmonics, rows = sine.shape[1], len(table) - 1
    for i in range(LANES):
        g = min(first + i, n - 1)
        work.omega[i] = omega[g]
        for leg in range(legs):
            work.gait[0, leg, i] = offset[g, leg]
            for j in range(harmonics):
                work.gait[1 + 2 * j, leg, i] = sine[g, j, leg]
                work.gait[2 + 2 * j, leg, i] = cosine[g, j, leg]
    for r in range(rows):
        for leg in range(legs):
            _swing(work.gait, work.omega, turns, r, leg, work.lanes.angle, work.lanes.rate)
        fill_lanes(tree, work.lanes, table, r)
    for e in range(N_COEFFICIENTS * LANES):
        table[rows, e] = table[0, e]


@lanes
def _swing(gait, omega, turns, r, leg, angle, rate):  # type: ignore[no-untyped-def]
    """Angle and rate of a leg in every lane."""
    for i in range(LANES):
        angle[leg, i], rate[leg, i] = gait[0, leg, i], 0.0
    for j in range(turns.shape[2]):
        s, c = turns[0, r, j], turns[1, r, j]
        for i in range(LANES):
            a, b = gait[1 + 2 * j, leg, i], gait[2 + 2 * j, leg, i]
            angle[leg, i] += a * s + b * c
            rate[leg, i] += (j + 1.0) * omega[i] * (a * c - b * s)


@inner
def _settle(axis, limit, first, work, motion, out):  # type: ignore[no-untyped-def]
    """Simulate a block of lanes: fill their means, angles, lift, status and motion."""
    h, ends, table, par, slopes = work.h, work.ends, work.table, work.parameters, work.slopes
    y, before, total, scratch = work.state[0], work.state[1], work.state[2], work.state[3]
    n_steps, counted, n_out = len(work.lift), len(work.means), min(LANES, len(out) - first)
    _begin(axis, y, work.angles, work.sides, work.status, work.largest)
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
            step(y, table, at, h, par, axis, slopes, total, scratch, work.areas)
            if axis == DECOUPLED:
                _check_finite(before, cycle, n, ends, work.status)
            else:
                known = min(cycle * n_steps + n + 1, N_PAST)
                watch(before, slopes, h, work.past, work.sides)
                _check(
                    work.past, known, work.sides, limit, cycle, n, ends, work.largest, work.status
                )
            if cycle == last:
                break
            if cycle < first_end - counted:
                continue
            angles(before, axis, scratch)
            for i in range(n_out):
                if ends[i] - counted <= cycle < ends[i]:
                    for s in range(3):
                        work.angles[n, s * LANES + i] += scratch[s * LANES + i]
                if cycle == ends[i] - 1 and axis != DECOUPLED:
                    motion_of(before, slopes, i, work.now)
                    work.lift[n, i] = lift(work.now, table, at, i)
                    if len(motion) > 0:
                        for s in range(N_MOTION):
                            motion[first + i, n, s] = work.now[s]
        for i in range(LANES):
            count = cycle - (ends[i] - counted)
            if 0 <= count < counted:
                for s in range(3):
                    work.means[count, s * LANES + i] = work.areas[s * LANES + i] / (n_steps * h[i])


@inner
def _begin(axis, y, angles, sides, status, largest):  # type: ignore[no-untyped-def]
    """The upright start, with nothing gathered."""
    for e in range(BLOCK):
        y[e] = 0.0
    for n in range(len(angles)):
        for e in range(3 * LANES):
            angles[n, e] = 0.0
    for i in range(LANES):
        if axis != DECOUPLED:
            y[3 * LANES + i] = 1.0
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
