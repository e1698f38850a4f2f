"""Many gaits at once: parameters and gaits -> states after each step, or steady states."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from rrrobot.checks import Array
from rrrobot.damping import BodyRateDamping, Damping, EulerRateDamping
from rrrobot.errors import ModelError
from rrrobot.models.base import VERTICAL_PITCH, Model
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.momentum.coefficients import N_COEFFICIENTS, Tree, fill, tree_of
from rrrobot.momentum.kernels import (
    BLOCK,
    DECOUPLED,
    LANES,
    LIFT_OFF,
    N_PARAMETER,
    N_STAGES,
    N_STATE,
    NODES,
    NOT_FINITE,
    OK,
    VERTICAL,
    step,
)
from rrrobot.robot import Robot
from rrrobot.surfaces import Sphere

ROWS_PER_STEP = NODES.size - 1
"""Rows of a coefficient table for each step: its distinct stage times, the last being the next
step's first."""

N_RESULT = 16
"""Entries of a lane's steady state; see `RESULT`."""
RESULT = (
    "speed", "velocity_x", "velocity_y", "yaw_rate", "roll_amplitude", "pitch_amplitude",
    "yaw_amplitude", "roll_phase", "pitch_phase", "yaw_phase", "roll_mean", "pitch_mean",
    "yaw_mean", "variation", "normal_force", "status",
)  # fmt: skip


class Setting(NamedTuple):
    """A model in the engine's terms."""

    tree: Tree
    parameters: Array
    """(N_PARAMETER,), as the kernels take them"""
    axis: int
    """-1 for all axes, 0-2 for the one that is free, DECOUPLED for three models side by side"""
    limit: float
    """of the sine of the pitch, where a lane stops; above 1 for models without a singularity"""


def setting_of(model: Model) -> Setting:
    """The engine's terms of a model.

    Raises:
        ModelError: the shell is no sphere, or the ground not level.
    """
    robot = model.robot
    if not isinstance(robot.shell, Sphere) or robot.ground_normal[2] != 1.0:
        raise ModelError(
            f"the momentum engine needs a spherical shell on level ground; this robot has "
            f"{robot.shell} on a ground of normal {robot.ground_normal.tolist()}. Use "
            "method='kkt'."
        )
    rolls = model.rolling is not None
    radius = robot.shell.radius
    gravity = -float(model.model.gravity.linear[2])
    travels = model.name != "yaw"
    numbers = (robot.mass, radius * rolls, radius * travels, gravity, *_damping(model.damping))
    axis = model.axes[0] if len(model.axes) == 1 else -1
    limit = float(np.sin(VERTICAL_PITCH)) if model.singular_at_vertical else 2.0
    return Setting(tree_of(robot), np.array(numbers), axis, limit)


def decoupled_setting(
    robot: Robot,
    roll: RollModel | None = None,
    pitch: PitchModel | None = None,
    yaw: YawModel | None = None,
) -> Setting:
    """The engine's terms of the single-axis models, recombined by rolling; the paper's dampings."""
    models = (roll or RollModel(robot), pitch or PitchModel(robot), yaw or YawModel(robot))
    losses = [_damping(m.damping)[m.axis] for m in models]
    first = setting_of(models[0])
    parameters = first.parameters.copy()
    parameters[4:7] = losses
    return Setting(first.tree, parameters, DECOUPLED, 2.0)


def _damping(damping: Damping) -> tuple[float, float, float, float]:
    if isinstance(damping, EulerRateDamping):
        return damping.roll, damping.pitch, damping.yaw, 1.0
    if isinstance(damping, BodyRateDamping):
        return damping.x, damping.y, damping.z, 0.0
    raise ModelError(f"the momentum engine knows no {type(damping).__name__}; use method='kkt'.")


def stage_times(start: float, step: float, steps: int) -> Array:
    """Instants of the rows of a coefficient table for `steps` equal steps [s]."""
    inner = np.add.outer(np.arange(steps), NODES[:-1]).ravel()
    return start + step * np.append(inner, steps)


def march(
    setting: Setting, tables: Array, steps: Array, y0: Array, per_table: int | None = None
) -> Array:
    """States of lanes after every step (steps + 1, lanes, N_STATE).

    Args:
        setting: the model.
        tables: coefficients (rows, 15, lanes); rows as `stage_times` gives them.
        steps: length of each step of all lanes (n,) [s].
        y0: states at the start (lanes, N_STATE); yaw last.
        per_table: steps after which the table begins anew, for periodic gaits; None: never.
    """
    lanes = y0.shape[0]
    out = np.empty((len(steps) + 1, lanes, N_STATE))
    for first in range(0, lanes, LANES):
        here = slice(first, min(first + LANES, lanes))
        block, table = _padded(y0[here].T), _padded(tables[:, :, here])
        history = np.empty((len(steps) + 1, BLOCK))
        parameters = np.repeat(setting.parameters, LANES)
        rows = per_table or len(steps)
        _march_block(block.ravel(), table.reshape(len(table), -1), parameters, steps, rows,
                     setting.axis, history)  # fmt: skip
        n = here.stop - first
        out[:, here] = history.reshape(-1, N_STATE, LANES)[:, :, :n].transpose(0, 2, 1)
    return out


def _padded(array: Array) -> Array:
    """The last axis filled up to LANES by copies of its last entry."""
    missing = LANES - array.shape[-1]
    if not missing:
        return np.ascontiguousarray(array)
    return np.concatenate((array, np.repeat(array[..., -1:], missing, axis=-1)), axis=-1)


@njit(cache=True, nogil=True, error_model="numpy")
def _march_block(y, table, par, steps, rows, axis, history):  # type: ignore[no-untyped-def]
    slopes, total = np.zeros((N_STAGES, BLOCK)), np.zeros(BLOCK)
    work, areas, h = np.zeros(BLOCK), np.zeros(3 * LANES), np.zeros(LANES)
    history[0] = y
    for n in range(steps.size):
        h[:] = steps[n]
        step(y, table, (n % rows) * ROWS_PER_STEP, h, par, axis, slopes, total, work, areas)
        history[n + 1] = y


class Gaits(NamedTuple):
    """Sinusoidal gaits, one a row: each array (n, legs), the frequency (n,)."""

    offset: Array
    amplitude: Array
    phase: Array
    angular_frequency: Array


def steady_states(
    setting: Setting,
    gaits: Gaits,
    *,
    cycles: int,
    counted: int,
    steps_per_cycle: int,
    yaw_amplitude: Array | None = None,
) -> Array:
    """Steady states of many gaits from an upright impulsive start (n, N_RESULT).

    The columns are `RESULT`, "normal_force" the least of the last cycle [N] (NaN for decoupled
    models); those of a lane that stopped or lifts off are NaN, its status says why. A lane that
    comes to the vertical only between two steps is not noticed. Holds no interpreter lock while
    it computes, so chunks may run on threads.

    Args:
        setting: the model.
        gaits: one row a gait.
        cycles: to simulate.
        counted: of these, at the end, over which means are taken; at least 2.
        steps_per_cycle: 10 give about 3e-7 of the speed on RRRobot.
        yaw_amplitude: of the legs in the yaw model alone (n, legs), for decoupled models; the
            gaits' own if None. The paper's Fig 20.
    """
    out = np.empty((len(gaits.offset), N_RESULT))
    other = gaits.amplitude if yaw_amplitude is None else yaw_amplitude
    _steady_states(
        setting.tree, setting.parameters, setting.axis, setting.limit, gaits.offset,
        gaits.amplitude, gaits.phase, gaits.angular_frequency, other, cycles, counted,
        steps_per_cycle, NODES, out,
    )  # fmt: skip
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _steady_states(  # type: ignore[no-untyped-def]
    tree,
    parameters,
    axis,
    limit,
    offset,
    amplitude,
    phase,
    omega,
    other,
    cycles,
    counted,
    n_steps,
    nodes,
    out,
):
    n, legs = offset.shape
    rows = n_steps * ROWS_PER_STEP + 1
    table = np.empty((rows, N_COEFFICIENTS * LANES))
    angle, rate = np.empty((rows, legs)), np.empty((rows, legs))
    column = np.empty((rows, N_COEFFICIENTS))
    y, h = np.empty(BLOCK), np.empty(LANES)
    par = np.empty(N_PARAMETER * LANES)
    for i in range(LANES):
        for p in range(N_PARAMETER):
            par[p * LANES + i] = parameters[p]
    for first in range(0, n, LANES):
        for i in range(LANES):
            g = min(first + i, n - 1)
            period = 2.0 * np.pi / omega[g]
            h[i] = period / n_steps
            _tabulate(
                tree, h[i], offset[g], amplitude[g], phase[g], omega[g], nodes, angle, rate, column
            )
            for r in range(rows):
                for c in range(N_COEFFICIENTS):
                    table[r, c * LANES + i] = column[r, c]
            if axis == DECOUPLED and np.any(other[g] != amplitude[g]):
                _tabulate(
                    tree, h[i], offset[g], other[g], phase[g], omega[g], nodes, angle, rate, column
                )
                for r in range(rows):
                    table[r, 5 * LANES + i] = column[r, 5]
                    table[r, 14 * LANES + i] = column[r, 14]
        y[:] = 0.0
        if axis != DECOUPLED:
            y[3 * LANES : 4 * LANES] = 1.0
        _settle(y, table, par, axis, limit, h, cycles, counted, n_steps, first, out)


@njit(cache=True, nogil=True, error_model="numpy")
def _tabulate(  # type: ignore[no-untyped-def]
    tree, h, offset, amplitude, phase, omega, nodes, angle, rate, out
):
    """Coefficients of one gait over its period (rows, 15); angle and rate are scratch."""
    for r in range(out.shape[0]):
        at = (r // ROWS_PER_STEP + nodes[r % ROWS_PER_STEP]) * h
        for leg in range(offset.size):
            turn = omega * at + phase[leg]
            angle[r, leg] = offset[leg] + amplitude[leg] * np.sin(turn)
            rate[r, leg] = amplitude[leg] * omega * np.cos(turn)
    fill(tree, angle, rate, out)


@njit(cache=True, nogil=True, error_model="numpy")
def _settle(  # type: ignore[no-untyped-def]
    y, table, par, axis, limit, h, cycles, counted, n_steps, first, out
):
    """Simulate a block of lanes and write its steady states."""
    slopes, total = np.zeros((N_STAGES, BLOCK)), np.zeros(BLOCK)
    work, areas = np.zeros(BLOCK), np.zeros(3 * LANES)
    means = np.zeros((counted, 3 * LANES))
    status = np.zeros(LANES, dtype=np.int64)
    sums = np.zeros((counted, n_steps, 3, LANES))
    before, lift = np.zeros(BLOCK), np.zeros((n_steps, LANES))
    sides = np.zeros((2, LANES))
    sides[1] = 1.0
    for cycle in range(cycles):
        areas[:] = 0.0
        count = cycle - (cycles - counted)
        for n in range(n_steps):
            if count >= 0:
                _angles(y, axis, sums[count, n])
                before[:] = y
            step(y, table, n * ROWS_PER_STEP, h, par, axis, slopes, total, work, areas)
            if count == counted - 1:
                _vertical_momentum(before, slopes[0], table[n * ROWS_PER_STEP], lift[n])
            for i in range(LANES):
                if status[i] == OK:
                    status[i] = _check(y, i, axis, limit, sides)
        if count >= 0:
            for s in range(3):
                for i in range(LANES):
                    means[count, s * LANES + i] = areas[s * LANES + i] / (n_steps * h[i])
    for i in range(min(LANES, out.shape[0] - first)):
        row = out[first + i]
        period = h[i] * n_steps
        _summarise(means, sums, period, status[i], i, row)
        if status[i] == OK and axis != DECOUPLED:
            row[14] = par[i] * par[3 * LANES + i] + _least_rate(lift[:, i], period)
            # Only a rolling contact can lift off: a pivot also pulls.
            if par[LANES + i] > 0.0 and row[14] <= 0.0:
                row[:15] = np.nan
                row[15] = LIFT_OFF


@njit(cache=True, nogil=True, error_model="numpy")
def _vertical_momentum(y, k, c, out):  # type: ignore[no-untyped-def]
    """z (w x mc + p_rel) of every lane, from the rates k of the quaternion."""
    for i in range(LANES):
        qx, qy = y[i], y[LANES + i]
        qz, qw = y[2 * LANES + i], y[3 * LANES + i]
        kx, ky, kz, kw = k[i], k[LANES + i], k[2 * LANES + i], k[3 * LANES + i]
        scale = 2.0 / (qx * qx + qy * qy + qz * qz + qw * qw)
        w0 = scale * (qw * kx - kw * qx - (qy * kz - qz * ky))
        w1 = scale * (qw * ky - kw * qy - (qz * kx - qx * kz))
        w2 = scale * (qw * kz - kw * qz - (qx * ky - qy * kx))
        m0, m1, m2 = c[i], c[LANES + i], c[2 * LANES + i]
        out[i] = (
            scale * (qx * qz - qw * qy) * (w1 * m2 - w2 * m1 + c[9 * LANES + i])
            + scale * (qy * qz + qw * qx) * (w2 * m0 - w0 * m2 + c[10 * LANES + i])
            + (1.0 - scale * (qx * qx + qy * qy)) * (w0 * m1 - w1 * m0 + c[11 * LANES + i])
        )


@njit(cache=True, nogil=True, error_model="numpy")
def _least_rate(values, period):  # type: ignore[no-untyped-def]
    """Least time derivative of a periodic quantity, by its trigonometric interpolation."""
    n = values.size
    half = (n + 1) // 2
    sine, cosine = np.zeros(half), np.zeros(half)
    for j in range(1, half):
        scale = 2.0 / n * j * 2.0 * np.pi / period
        for k in range(n):
            turn = 2.0 * np.pi * j * k / n
            sine[j] += scale * values[k] * np.sin(turn)
            cosine[j] += scale * values[k] * np.cos(turn)
    least = np.inf
    for m in range(4 * n):
        rate = 0.0
        for j in range(1, half):
            turn = 0.5 * np.pi * j * m / n
            rate += sine[j] * np.cos(turn) - cosine[j] * np.sin(turn)
        least = min(least, rate)
    return least


@njit(cache=True, nogil=True, error_model="numpy")
def _check(y, i, axis, limit, sides):  # type: ignore[no-untyped-def]
    """Status of lane i after a step; sides holds (sin roll, cos roll) cos pitch of the step before.

    A step that leaps over the vertical turns the roll by half a turn.
    """
    if axis == DECOUPLED:
        return OK if np.isfinite(y[i] + y[LANES + i] + y[9 * LANES + i]) else NOT_FINITE
    sine = _sine_pitch(y, i)
    if not abs(sine) <= 2.0:
        return NOT_FINITE
    qx, qy = y[i], y[LANES + i]
    qz, qw = y[2 * LANES + i], y[3 * LANES + i]
    a = 2.0 * (qw * qx + qy * qz)
    b = qw * qw - qx * qx - qy * qy + qz * qz
    over = a * sides[0, i] + b * sides[1, i] < 0.0
    sides[0, i], sides[1, i] = a, b
    return VERTICAL if limit < 1.0 and (over or abs(sine) > limit) else OK


@njit(cache=True, nogil=True, error_model="numpy")
def _sine_pitch(y, i):  # type: ignore[no-untyped-def]
    qx, qy = y[i], y[LANES + i]
    qz, qw = y[2 * LANES + i], y[3 * LANES + i]
    return 2.0 * (qw * qy - qz * qx) / (qx * qx + qy * qy + qz * qz + qw * qw)


@njit(cache=True, nogil=True, error_model="numpy")
def _angles(y, axis, out):  # type: ignore[no-untyped-def]
    """Roll, pitch and yaw of every lane (3, LANES)."""
    for i in range(LANES):
        if axis == DECOUPLED:
            out[0, i], out[1, i], out[2, i] = y[i], y[LANES + i], y[9 * LANES + i]
            continue
        qx, qy = y[i], y[LANES + i]
        qz, qw = y[2 * LANES + i], y[3 * LANES + i]
        out[0, i] = np.arctan2(2.0 * (qw * qx + qy * qz), qw * qw - qx * qx - qy * qy + qz * qz)
        out[1, i] = np.arcsin(min(1.0, max(-1.0, _sine_pitch(y, i))))
        out[2, i] = y[9 * LANES + i]


@njit(cache=True, nogil=True, error_model="numpy")
def _summarise(means, angles, period, status, i, out):  # type: ignore[no-untyped-def]
    """Steady state of lane i from its cycle means (counted, 3 LANES) and sampled angles."""
    counted, n_steps = means.shape[0], angles.shape[1]
    if status != OK:
        out[:] = np.nan
        out[15] = status
        return
    speed, along_x, along_y = 0.0, 0.0, 0.0
    for k in range(counted - 1):
        dx = (means[k + 1, i] - means[k, i]) / period
        dy = (means[k + 1, LANES + i] - means[k, LANES + i]) / period
        yaw = 0.5 * (means[k + 1, 2 * LANES + i] + means[k, 2 * LANES + i])
        speed += np.hypot(dx, dy)
        along_x += np.cos(yaw) * dx + np.sin(yaw) * dy
        along_y += -np.sin(yaw) * dx + np.cos(yaw) * dy
    steps = counted - 1
    out[0], out[1], out[2] = speed / steps, along_x / steps, along_y / steps
    out[3] = (means[counted - 1, 2 * LANES + i] - means[0, 2 * LANES + i]) / (steps * period)
    worst = 0.0
    for k in range(counted - 1):
        dx = (means[k + 1, i] - means[k, i]) / period
        dy = (means[k + 1, LANES + i] - means[k, LANES + i]) / period
        worst = max(worst, abs(np.hypot(dx, dy) - out[0]))
    out[13] = worst / max(out[0], 1e-6 / period)
    for a in range(3):
        drift = out[3] if a == 2 else 0.0
        sine, cosine, mean = 0.0, 0.0, 0.0
        for n in range(n_steps):
            whole = 0.0
            for k in range(counted):
                late = (k - 0.5 * counted + n / n_steps) * period
                whole += angles[k, n, a, i] - drift * late
            turn = 2.0 * np.pi * n / n_steps
            sine += np.sin(turn) * whole
            cosine += np.cos(turn) * whole
            mean += whole
        scale = 2.0 / (counted * n_steps)
        out[4 + a] = scale * np.hypot(sine, cosine)
        out[7 + a] = np.arctan2(cosine, sine)
        out[10 + a] = 0.5 * scale * mean
    out[14], out[15] = np.nan, OK
