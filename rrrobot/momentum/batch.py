"""Many gaits at once: parameters and gaits -> states after each step, or steady states."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.damping import BodyRateDamping, Damping, EulerRateDamping
from rrrobot.errors import ModelError
from rrrobot.models.base import Model
from rrrobot.momentum.coefficients import N_COEFFICIENTS, Tree, fill, tree_of
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
from rrrobot.surfaces import Sphere

ROWS_PER_STEP = NODES.size - 1
"""Rows of a coefficient table for each step: its distinct stage times, the last being the next
step's first."""

N_RESULT = 16
"""Entries of a lane's steady state; see `RESULT`."""
RESULT = (
    "speed", "velocity_x", "velocity_y", "yaw_rate", "roll_amplitude", "pitch_amplitude",
    "yaw_amplitude", "roll_phase", "pitch_phase", "yaw_phase", "roll_mean", "pitch_mean",
    "yaw_mean", "variation", "clearance", "status",
)  # fmt: skip


class Setting(NamedTuple):
    """A model in the engine's terms."""

    tree: Tree
    parameters: Array
    """(N_PARAMETER,), as the kernels take them"""
    axis: int
    """-1 for all axes, else the one that is free"""


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
    return Setting(tree_of(robot), np.array(numbers), axis)


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
    setting: Setting, gaits: Gaits, *, cycles: int, counted: int, steps_per_cycle: int
) -> Array:
    """Steady states of many gaits from an upright impulsive start (n, N_RESULT).

    The columns are `RESULT`; those of a lane that stopped are NaN, its status says why. Holds no
    interpreter lock while it computes, so chunks may run on threads.

    Args:
        setting: the model.
        gaits: one row a gait.
        cycles: to simulate.
        counted: of these, at the end, over which means are taken; at least 2.
        steps_per_cycle: 10 give about 3e-7 of the speed on RRRobot.
    """
    out = np.empty((len(gaits.offset), N_RESULT))
    _steady_states(
        setting.tree, setting.parameters, setting.axis, gaits.offset, gaits.amplitude,
        gaits.phase, gaits.angular_frequency, cycles, counted, steps_per_cycle, NODES, out,
    )  # fmt: skip
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _steady_states(  # type: ignore[no-untyped-def]
    tree, parameters, axis, offset, amplitude, phase, omega, cycles, counted, n_steps, nodes, out
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
            for r in range(rows):
                at = (r // ROWS_PER_STEP + nodes[r % ROWS_PER_STEP]) * h[i]
                for leg in range(legs):
                    turn = omega[g] * at + phase[g, leg]
                    angle[r, leg] = offset[g, leg] + amplitude[g, leg] * np.sin(turn)
                    rate[r, leg] = amplitude[g, leg] * omega[g] * np.cos(turn)
            fill(tree, angle, rate, column)
            for r in range(rows):
                for c in range(N_COEFFICIENTS):
                    table[r, c * LANES + i] = column[r, c]
        y[:] = 0.0
        y[3 * LANES : 4 * LANES] = 1.0
        _settle(y, table, par, axis, h, cycles, counted, n_steps, first, out)


@njit(cache=True, nogil=True, error_model="numpy")
def _settle(y, table, par, axis, h, cycles, counted, n_steps, first, out):  # type: ignore[no-untyped-def]
    """Simulate a block of lanes and write its steady states."""
    slopes, total = np.zeros((N_STAGES, BLOCK)), np.zeros(BLOCK)
    work, areas = np.zeros(BLOCK), np.zeros(3 * LANES)
    means = np.zeros((counted, 3 * LANES))
    status = np.zeros(LANES, dtype=np.int64)
    sums = np.zeros((counted, n_steps, 3, LANES))
    limit = np.sin(np.deg2rad(89.5))
    for cycle in range(cycles):
        areas[:] = 0.0
        count = cycle - (cycles - counted)
        for n in range(n_steps):
            if count >= 0:
                _angles(y, sums[count, n])
            step(y, table, n * ROWS_PER_STEP, h, par, axis, slopes, total, work, areas)
            for i in range(LANES):
                sine = _sine_pitch(y, i)
                if status[i] == OK and not abs(sine) <= limit:
                    status[i] = VERTICAL if abs(sine) > limit else NOT_FINITE
        if count >= 0:
            for s in range(3):
                for i in range(LANES):
                    means[count, s * LANES + i] = areas[s * LANES + i] / (n_steps * h[i])
    for i in range(min(LANES, out.shape[0] - first)):
        _summarise(means, sums, h[i] * n_steps, status[i], i, out[first + i])


@njit(cache=True, nogil=True, error_model="numpy")
def _sine_pitch(y, i):  # type: ignore[no-untyped-def]
    qx, qy = y[i], y[LANES + i]
    qz, qw = y[2 * LANES + i], y[3 * LANES + i]
    return 2.0 * (qw * qy - qz * qx) / (qx * qx + qy * qy + qz * qz + qw * qw)


@njit(cache=True, nogil=True, error_model="numpy")
def _angles(y, out):  # type: ignore[no-untyped-def]
    """Roll, pitch and yaw of every lane (3, LANES)."""
    for i in range(LANES):
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
        for k in range(counted):
            for n in range(n_steps):
                turn = 2.0 * np.pi * n / n_steps
                late = (k - 0.5 * counted + n / n_steps) * period
                value = angles[k, n, a, i] - drift * late
                sine += np.sin(turn) * value
                cosine += np.cos(turn) * value
                mean += value
        scale = 2.0 / (counted * n_steps)
        out[4 + a] = scale * np.hypot(sine, cosine)
        out[7 + a] = np.arctan2(cosine, sine)
        out[10 + a] = 0.5 * scale * mean
    out[14], out[15] = np.nan, OK
