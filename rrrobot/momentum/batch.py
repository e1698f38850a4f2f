"""Many gaits at once: parameters and gaits -> states after each step, or steady states."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.drive.gaits.batch import GaitBatch
from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import borrowed, compiled, in_cache
from rrrobot.momentum.extremes import LOADS as ALL_LOADS
from rrrobot.momentum.extremes import evaluate, extremes
from rrrobot.momentum.heights import clearance
from rrrobot.momentum.interpolation import interpolation, spline_matrix
from rrrobot.momentum.kernels import (
    ANY,
    BLOCK,
    DECOUPLED,
    LIFT_OFF,
    N_STAGES,
    N_STATE,
    OK,
    ROWS_PER_STEP,
    TURNS_OVER,
    step,
)
from rrrobot.momentum.lane import scratch
from rrrobot.momentum.legs import checked, stage_times, turns_of
from rrrobot.momentum.lowering import Setting, decoupled_setting, lower
from rrrobot.momentum.normal import N_ANY_MOTION
from rrrobot.momentum.settle import settle
from rrrobot.momentum.summary import N_MOTION, N_RESULT, RESULT
from rrrobot.momentum.vertical import largest_tilt, pitch_of
from rrrobot.momentum.work import work_of
from rrrobot.rotations import quaternion_from_euler, turns_over

LOADS = ("friction", "rms_torque", "peak_torque", "power", "torque_share")
"""Further entries of a lane's steady state, on request; see `extremes.LOADS`."""
_YAW_RATE, _PITCH, _CLEARANCE, _TILT, _STATUS = (
    RESULT.index(name) for name in ("yaw_rate", "pitch", "clearance", "tilt", "status")
)

__all__ = [
    "LOADS",
    "N_RESULT",
    "RESULT",
    "ROWS_PER_STEP",
    "Setting",
    "decoupled_setting",
    "lower",
    "march",
    "ready",
    "settled",
    "stage_times",
    "steady_states",
]


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
    work = (np.zeros((N_STAGES, BLOCK)), *(np.zeros(n) for n in (BLOCK, BLOCK, 3 * LANES, BLOCK)))
    rolling = scratch(setting.terrain)
    for first in range(0, lanes, LANES):
        here = slice(first, min(first + LANES, lanes))
        block, table = _padded(y0[here].T), _padded(tables[:, :, here])
        history = np.empty((len(steps) + 1, BLOCK))
        parameters = np.repeat(setting.parameters, LANES)
        rows = per_table or len(steps)
        _march_block(block.ravel(), table.reshape(len(table), -1), parameters, steps, rows,
                     setting.axis, setting.terrain, rolling, work, history)  # fmt: skip
        n = here.stop - first
        out[:, here] = history.reshape(-1, N_STATE, LANES)[:, :, :n].transpose(0, 2, 1)
    return out


def _padded(array: Array) -> Array:
    """The last axis filled up to LANES by copies of its last entry."""
    missing = LANES - array.shape[-1]
    if not missing:
        return np.ascontiguousarray(array)
    return np.concatenate((array, np.repeat(array[..., -1:], missing, axis=-1)), axis=-1)


@compiled()
def _march_block(  # type: ignore[no-untyped-def]
    y, table, par, steps, rows, axis, terrain, rolling, work, history
):
    y, table, par, work, history, rolling = (
        borrowed(y), borrowed(table), borrowed(par), borrowed(work), borrowed(history),
        borrowed(rolling),
    )  # fmt: skip
    if terrain is not None:
        terrain = borrowed(terrain)
    slopes, total, other, areas, h = work
    for e in range(BLOCK):
        history[0, e] = y[e]
    for n in range(steps.size):
        for e in range(BLOCK):
            h[e] = steps[n]
        step(y, table, (n % rows) * ROWS_PER_STEP, h, par, axis, slopes, total, other, areas,
             terrain, rolling)  # fmt: skip
        for e in range(BLOCK):
            history[n + 1, e] = y[e]


class Settled(NamedTuple):
    """What gaits come to."""

    results: Array
    """(n, N_RESULT), as `RESULT` has them; of a lane that stopped all but the status is NaN"""
    motion: Array
    """z_body and angular velocity at the steps of the last cycle (n, steps, N_MOTION), and the
    contact's, of any shell; if decoupled, z_body alone"""


def steady_states(
    setting: Setting,
    gaits: GaitBatch,
    *,
    cycles: int,
    counted: int,
    steps_per_cycle: int,
    yaw: GaitBatch | None = None,
    tilt: Array | None = None,
    loads: bool = False,
) -> Array:
    """Steady states of many gaits from impulsive starts (n, N_RESULT).

    The columns are `RESULT`, on request followed by `LOADS`; those of a lane that stopped or lifts
    off are NaN, its status says why. Holds no interpreter lock while it computes, so chunks may run
    on threads.

    Args:
        setting: the model.
        gaits: one row a gait.
        cycles: to simulate.
        counted: of these, at the end, over which means are taken; at least 2.
        steps_per_cycle: of a sphere: 10 give about 3e-7 of the speed on RRRobot. Shells that are
            sharper than a sphere take as many times more as their radii of curvature differ.
        yaw: the yaw model's own gaits, for decoupled models; the same if None. The paper's Fig 20.
        tilt: roll and pitch of the starts (n, 2) [rad]; upright if None.
        loads: whether to have these too (n, N_RESULT + len(LOADS)); NaN for decoupled models. On
            RRRobot 10 steps give the torques and the friction to 1e-3, 20 to 1e-6.
    """
    each = np.full(gaits.n, cycles)
    found = settled(
        setting, gaits, cycles=each, counted=counted, steps=steps_per_cycle, yaw=yaw, tilt=tilt
    )
    out = found.results
    if loads and setting.axis != DECOUPLED:
        chosen = [ALL_LOADS.index(name) for name in LOADS]
        out = np.column_stack((out, extremes(setting, gaits, found.motion)[:, chosen]))
    elif loads:
        out = np.column_stack((out, np.full((len(out), len(LOADS)), np.nan)))
    stopped = np.flatnonzero(out[:, _STATUS] != OK)
    out[np.ix_(stopped, np.arange(out.shape[1]) != _STATUS)] = np.nan
    return out


def settled(
    setting: Setting,
    gaits: GaitBatch,
    *,
    cycles: NDArray[np.int64],
    counted: int,
    steps: int,
    yaw: GaitBatch | None = None,
    tilt: Array | None = None,
) -> Settled:
    """Simulate gaits, each for its own number of cycles (n,).

    What a gait gives does not depend on the others beside it, to the last bit. See `steady_states`;
    a lane that lifts off or turns over keeps its numbers here.

    Raises:
        GaitError: a leg cannot go round and round.
    """
    n, steps = gaits.n, steps * setting.fineness
    width = N_ANY_MOTION if setting.axis == ANY else N_MOTION
    found, sine = Settled(np.empty((n, N_RESULT)), np.full((n, steps, width), np.nan)), np.empty(n)
    harmonics = gaits.sine.shape[1]
    slope_of, value_of = _derivative(steps, setting.periodic)
    whole = checked(setting.tree, gaits)
    own = whole if yaw is None else checked(setting.tree, yaw)
    settle(
        setting.tree, setting.axis, setting.limit, setting.terrain, tuple(whole), tuple(own),
        np.ascontiguousarray(cycles, dtype=np.int64), _starts(n, setting, tilt),
        turns_of(steps, harmonics), slope_of, value_of,
        work_of(setting, harmonics, counted, steps), found.motion, sine, found.results,
    )  # fmt: skip
    if setting.axis != DECOUPLED:
        status = found.results[:, _STATUS]
        turn = found.results[:, _YAW_RATE] * 2 * np.pi / gaits.angular_frequency
        goes_on = (status == OK) | (status == LIFT_OFF)
        status[goes_on & turns_over(found.motion[:, :, :3], turn)] = TURNS_OVER
    found.results[:, _PITCH] = np.nan if setting.axis == DECOUPLED else pitch_of(sine)
    found.results[:, _CLEARANCE] = clearance(setting, whole, found.motion)
    if setting.axis != DECOUPLED:
        found.results[:, _TILT] = largest_tilt(found.motion, periodic=setting.periodic)
    return found


def _starts(n: int, setting: Setting, tilt: Array | None) -> Array:
    """States without momentum (n, N_STATE), with roll and pitch (n, 2) [rad]."""
    begin = np.zeros((n, N_STATE))
    if tilt is not None:
        begin[:, :4] = quaternion_from_euler(np.column_stack((tilt, np.zeros(n))))
    elif setting.axis != DECOUPLED:
        begin[:, 3] = 1.0
    return begin


@lru_cache(maxsize=8)
def _derivative(steps: int, periodic: bool) -> tuple[Array, Array]:
    """Matrices (points, n) from n samples of a cycle to an interpolation's slopes and values.

    Trigonometric interpolation where the cycle repeats, at 4 n points; else a spline's, between
    the first sample and the last.
    """
    if periodic:
        return _slope_of(steps), interpolation(steps, 4 * steps)
    slope, value = (spline_matrix(steps, 4, order) for order in (1, 0))
    return steps * slope, value


@lru_cache(maxsize=8)
def _slope_of(steps: int) -> Array:
    """Matrix (4 n, n) from n samples of a period to slopes of their interpolation."""
    order = np.arange(1, (steps + 1) // 2)
    turn = 2 * np.pi / steps * order
    apart = np.subtract.outer(np.arange(4 * steps) / 4, np.arange(steps))
    return np.asarray(-4 * np.pi / steps * (np.sin(apart[:, :, None] * turn) * order).sum(axis=2))


def ready(*, loads: bool = False, alone: bool = False) -> bool:
    """Whether the engine is compiled; if not, its first use takes a while.

    Args:
        loads: with torques and friction.
        alone: for one simulation by `march`, instead of steady states.
    """
    functions = [_march_block] if alone else [settle, *([evaluate] if loads else [])]
    return all(in_cache(function) for function in functions)
