"""Populations of gaits through the momentum engine: motion, forces and torques of each.

A gait is simulated from an upright impulsive start until `settle_time` has passed, then `COUNTED`
cycles are averaged. Forces are evaluated at every step of the last one, and trigonometric
interpolation gives their extremes. What a gait gives does not depend on the others beside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.models.base import Model
from rrrobot.momentum.batch import ROWS_PER_STEP, setting_of
from rrrobot.momentum.coefficients import N_COEFFICIENTS, Tree, fill
from rrrobot.momentum.kernels import (
    BLOCK,
    LANES,
    N_PARAMETER,
    N_STAGES,
    N_STATE,
    NODES,
    NOT_FINITE,
    OK,
    VERTICAL,
    step,
)
from rrrobot.optimise_forces import bodies
from rrrobot.optimise_loads import FRICTION, PITCH, TORQUE, loads, n_signals
from rrrobot.optimise_space import Population
from rrrobot.optimise_table import COLUMNS

COUNTED = 4
"""Cycles that are averaged."""
_STEPS = np.sort(np.outer((16, 24), 2 ** np.arange(9)).ravel())
"""Steps of a cycle: enough for the harmonics, and for none to be longer than this [s]:"""
_LONGEST_STEP = 0.09
_FINER = 4
"""Points of the interpolation for each step."""

N_COLUMNS = len(COLUMNS)
_INDEX = {name: i for i, name in enumerate(COLUMNS)}
_SPEED, _YAW_RATE, _VARIATION = (_INDEX[k] for k in ("speed", "yaw_rate", "variation"))
_PITCH, _STATUS, _CLEARANCE = (_INDEX[k] for k in ("pitch", "status", "clearance"))
_NORMAL, _FRICTION, _POWER = (_INDEX[k] for k in ("normal_force", "friction", "power"))
_RMS, _PEAK = _INDEX["rms_torque"], _INDEX["peak_torque"]

_VERTICAL_PITCH = np.deg2rad(89.5)


@dataclass(frozen=True)
class Engine:
    """A model, ready for populations."""

    tree: Tree
    parameters: Array
    leg_damping: float
    settle_time: float

    def __call__(self, gaits: Population) -> Array:
        """What each gait gives (n, N_COLUMNS); NaN, with a status, of those that stopped."""
        period = 2 * np.pi / gaits.angular_frequency
        wanted = np.maximum(period / _LONGEST_STEP, 8 + 8 * gaits.sine.shape[1])
        steps = _STEPS[np.minimum(np.searchsorted(_STEPS, wanted), _STEPS.size - 1)]
        cycles = np.ceil(self.settle_time / period - 1e-9).astype(np.int64) + COUNTED
        order = np.lexsort((cycles, steps))
        out = np.full((len(period), N_COLUMNS), np.nan)
        scratch = bodies(len(self.tree.mass))
        n_rows = n_signals(gaits.offset.shape[1], len(self.tree.mass))
        for first, last in _blocks(steps[order]):
            lanes = order[first:last]
            n_steps = int(steps[lanes[0]])
            out[lanes] = _block(
                self.tree, self.parameters, self.leg_damping, gaits.offset[lanes],
                gaits.sine[lanes], gaits.cosine[lanes], gaits.angular_frequency[lanes],
                cycles[lanes], n_steps, NODES, _interpolation(n_steps), scratch, n_rows,
            )  # fmt: skip
        return out


def engine_of(model: Model, settle_time: float) -> Engine:
    """The engine for a model.

    Raises:
        ModelError: the momentum engine cannot run it.
    """
    setting = setting_of(model)
    return Engine(setting.tree, setting.parameters, model.damping.leg_coefficient, settle_time)


def _blocks(steps: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Slices of at most LANES lanes with equal step counts, of the sorted counts."""
    edges = [0, *(np.flatnonzero(np.diff(steps)) + 1).tolist(), len(steps)]
    return [
        (first, min(first + LANES, end))
        for start, end in pairwise(edges)
        for first in range(start, end, LANES)
    ]


@cache
def _interpolation(n: int) -> Array:
    """Matrix (_FINER n, n) from n samples of a period to the trigonometric interpolant."""
    spectrum = np.fft.rfft(np.eye(n), axis=0)
    # Half of the Nyquist term stands at each end of the longer spectrum.
    spectrum[-1] *= 0.5
    return np.ascontiguousarray(_FINER * np.fft.irfft(spectrum, _FINER * n, axis=0))


@njit(cache=True, nogil=True, error_model="numpy")
def _block(  # type: ignore[no-untyped-def]
    tree, parameters, leg_damping, offset, sine, cosine, omega, cycles, n_steps, nodes, finer,
    scratch, n_rows,
):  # fmt: skip
    """Results (n, COLUMNS) of at most LANES gaits with equal step counts."""
    n, n_legs = offset.shape
    h, par = np.empty(LANES), np.empty(N_PARAMETER * LANES)
    for i in range(LANES):
        h[i] = 2.0 * np.pi / omega[min(i, n - 1)] / n_steps
        for p in range(N_PARAMETER):
            par[p * LANES + i] = parameters[p]
    table = _tabulate(tree, offset, sine, cosine, h, n_steps, nodes)
    means, pitch, recent = np.zeros((n, COUNTED, 3)), np.zeros(n), np.zeros((n, 2))
    signals = np.empty((n, n_rows, n_steps))
    slopes, total = np.zeros((N_STAGES, BLOCK)), np.zeros(BLOCK)
    work, areas = np.zeros(BLOCK), np.zeros(3 * LANES)
    state, c, leg = np.empty(N_STATE), np.empty(N_COEFFICIENTS), np.empty((3, n_legs))
    y = np.zeros(BLOCK)
    y[3 * LANES : 4 * LANES] = 1.0
    for cycle in range(cycles.max()):
        areas[:] = 0.0
        for k in range(n_steps):
            at = k * ROWS_PER_STEP
            for i in range(n):
                if cycle == cycles[i] - 1:
                    for s in range(N_STATE):
                        state[s] = y[s * LANES + i]
                    for s in range(N_COEFFICIENTS):
                        c[s] = table[at, s * LANES + i]
                    _legs(k * h[i], omega[i], offset[i], sine[i], cosine[i], leg)
                    loads(tree, state, c, leg, parameters, scratch, signals[i, :, k])
            step(y, table, at, h, par, -1, slopes, total, work, areas)
            for i in range(n):
                if cycle < cycles[i]:
                    _follow(_pitch(y, i), recent[i], pitch[i : i + 1])
        for i in range(n):
            count = cycle - (cycles[i] - COUNTED)
            if 0 <= count < COUNTED:
                for s in range(3):
                    means[i, count, s] = areas[s * LANES + i] / (n_steps * h[i])
    out = np.full((n, N_COLUMNS), np.nan)
    for i in range(n):
        out[i, _PITCH], out[i, _STATUS] = pitch[i], OK
        if pitch[i] < _VERTICAL_PITCH:
            _drift(means[i], h[i] * n_steps, out[i])
            _forces(finer @ signals[i].T, n_legs, leg_damping, out[i])
        else:
            out[i, _STATUS] = VERTICAL if pitch[i] >= _VERTICAL_PITCH else NOT_FINITE
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _legs(t, omega, offset, sine, cosine, leg):  # type: ignore[no-untyped-def]
    """Angles, rates and accelerations (3, legs) of a gait at a time."""
    leg[0], leg[1:] = offset, 0.0
    for j in range(sine.shape[0]):
        w = (j + 1) * omega
        s, c = np.sin(w * t), np.cos(w * t)
        for k in range(offset.size):
            swing = sine[j, k] * s + cosine[j, k] * c
            leg[0, k] += swing
            leg[1, k] += w * (sine[j, k] * c - cosine[j, k] * s)
            leg[2, k] -= w * w * swing


@njit(cache=True, nogil=True, error_model="numpy")
def _tabulate(tree, offset, sine, cosine, h, n_steps, nodes):  # type: ignore[no-untyped-def]
    """Coefficients at the stage times of a period (rows, 15 LANES)."""
    n, n_legs = offset.shape
    rows = n_steps * ROWS_PER_STEP + 1
    table, column = np.empty((rows, N_COEFFICIENTS * LANES)), np.empty((rows, N_COEFFICIENTS))
    angle, rate, leg = np.empty((rows, n_legs)), np.empty((rows, n_legs)), np.empty((3, n_legs))
    for i in range(LANES):
        g = min(i, n - 1)
        if i < n:
            for r in range(rows):
                at = (r // ROWS_PER_STEP + nodes[r % ROWS_PER_STEP]) * h[i]
                _legs(at, 2.0 * np.pi / (n_steps * h[i]), offset[g], sine[g], cosine[g], leg)
                angle[r], rate[r] = leg[0], leg[1]
            fill(tree, angle, rate, column)
        for r in range(rows):
            for c in range(N_COEFFICIENTS):
                table[r, c * LANES + i] = column[r, c]
    return table


@njit(cache=True, nogil=True, error_model="numpy")
def _pitch(y, i):  # type: ignore[no-untyped-def]
    """|pitch| of lane i [rad]."""
    qx, qy, qz, qw = y[i], y[LANES + i], y[2 * LANES + i], y[3 * LANES + i]
    sine = 2.0 * (qw * qy - qz * qx) / (qx * qx + qy * qy + qz * qz + qw * qw)
    return np.arcsin(min(1.0, abs(sine))) if np.isfinite(sine) else np.nan


@njit(cache=True, nogil=True, error_model="numpy")
def _follow(now, recent, largest):  # type: ignore[no-untyped-def]
    """Update the largest value of a signal, between samples too; NaN once it is NaN.

    `recent` holds the last sample and the one before; a parabola goes through the three.
    """
    before, middle = recent[1], recent[0]
    top, bend = now, before - 2.0 * middle + now
    if middle > max(before, now):
        top = middle - 0.125 * (now - before) ** 2 / bend
    if not top < largest[0]:
        largest[0] = top
    recent[1], recent[0] = middle, now


@njit(cache=True, nogil=True, error_model="numpy")
def _drift(means, period, row):  # type: ignore[no-untyped-def]
    """Speed, yaw rate and variation from cycle means (COUNTED, 3), as `steady_state` has them."""
    steps = COUNTED - 1
    lengths = np.empty(steps)
    for k in range(steps):
        lengths[k] = np.hypot(means[k + 1, 0] - means[k, 0], means[k + 1, 1] - means[k, 1]) / period
    speed = lengths.mean()
    row[_SPEED] = speed
    row[_YAW_RATE] = (means[steps, 2] - means[0, 2]) / (steps * period)
    row[_VARIATION] = np.abs(lengths - speed).max() / max(speed, 1e-6 / period)


@njit(cache=True, nogil=True, error_model="numpy")
def _forces(signals, n_legs, leg_damping, row):  # type: ignore[no-untyped-def]
    """Extremes and means over the interpolated signals (points, rows) of a lane."""
    points = len(signals)
    normal, friction = np.inf, 0.0
    square, power, peak = 0.0, 0.0, 0.0
    for k in range(points):
        x = signals[k]
        normal = min(normal, x[0])
        friction = max(friction, np.sqrt((x[FRICTION : FRICTION + 3] ** 2).sum()) / x[0])
        row[_PITCH] = max(row[_PITCH], abs(x[PITCH]))
        for leg in range(n_legs):
            rate = x[TORQUE + n_legs + leg]
            torque = x[TORQUE + leg] + leg_damping * rate
            square += torque * torque / points
            power += abs(torque * rate) / points
            peak = max(peak, abs(torque))
    row[_NORMAL], row[_RMS], row[_POWER], row[_PEAK] = normal, np.sqrt(square), power, peak
    # No friction would do where the ground does not push.
    row[_FRICTION] = friction if normal > 0.0 else np.inf
    row[_CLEARANCE] = signals[:, TORQUE + 2 * n_legs + 1 :].min()
