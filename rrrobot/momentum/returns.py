"""The flow over whole periods of the legs from any state, for many gaits side by side.

The legs' coefficients are tabulated once for each gait; after that a state is carried through a
period as often as one likes: for the return map of a limit cycle, its differences, and a look at
the cycle itself.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait
from rrrobot.drive.gaits.batch import GaitBatch
from rrrobot.momentum.coefficients import LANES, N_COEFFICIENTS, fill
from rrrobot.momentum.compiled import borrowed, compiled, inner
from rrrobot.momentum.kernels import (
    ANY,
    BLOCK,
    DECOUPLED,
    N_STAGES,
    N_STATE,
    ROWS_PER_STEP,
    step,
)
from rrrobot.momentum.lane import ROOM, scratch
from rrrobot.momentum.legs import checked, gait_work, stage_times, tabulate, turns_of
from rrrobot.momentum.lowering import Setting
from rrrobot.momentum.normal import N_ANY_MOTION, contact_motion, push
from rrrobot.momentum.rolling import evaluate_lanes
from rrrobot.momentum.summary import N_MOTION, angles, lift, motion_of

_YAWS_OWN = (5, 14)
"""Coefficients that the yaw model alone takes, where it has a gait of its own."""


class Cycles(NamedTuple):
    """One period of the legs of n gaits, tabulated in blocks of LANES."""

    setting: Setting
    tables: Array
    """coefficients (blocks, rows, 15 LANES)"""
    h: Array
    """step of each lane, for each entry of its state (blocks, BLOCK) [s]"""
    n: int
    """number of gaits; what fills the last block up repeats its last gait"""

    @property
    def steps(self) -> int:
        """Steps in a period."""
        return (self.tables.shape[1] - 1) // ROWS_PER_STEP

    @property
    def period(self) -> Array:
        """Of each gait's legs (n,) [s]."""
        return np.asarray(self.h[:, :LANES].reshape(-1)[: self.n] * self.steps)

    def inertia(self) -> Array:
        """Mean moment of inertia of each gait about the centre (n,) [kg m^2], at the start."""
        first = self.tables[:, 0].reshape(-1, N_COEFFICIENTS, LANES)[:, 3:6].mean(axis=1)
        return np.asarray(first.reshape(-1)[: self.n])


class Seen(NamedTuple):
    """What is seen of a period at the start of each of its steps."""

    start: Array
    """state before the period (n, N_STATE)"""
    end: Array
    """state after the period (n, N_STATE)"""
    areas: Array
    """integrals of x, y and yaw over it (n, 3)"""
    angles: Array
    """roll, pitch and yaw (n, steps, 3) [rad]"""
    motion: Array
    """z_body and angular velocity in the body frame, and of any shell the contact's motion
    (n, steps, entries); if decoupled, NaN (3) and the rates of roll, pitch and yaw"""
    lift: Array
    """vertical momentum relative to the centre, of any shell the whole (n, steps); NaN if
    decoupled"""
    push: Array
    """what its rate lacks of the normal force, of any shell (n, steps)"""
    ground: Array
    """least room to where the ground ends, and least det(1 + H G), of any shell: each is negative
    if the motion does not exist (n, 2)"""


def cycles_of(
    setting: Setting, gaits: GaitBatch, steps: int, yaw: GaitBatch | None = None
) -> Cycles:
    """Tabulate a period of gaits; `yaw`: the yaw model's own, if decoupled."""
    n, harmonics, _ = gaits.sine.shape
    blocks, rows = -(-n // LANES), steps * ROWS_PER_STEP + 1
    turns, work = turns_of(steps, harmonics), gait_work(setting.tree, harmonics)

    def tables(some: GaitBatch) -> Array:
        out = np.empty((blocks, rows, N_COEFFICIENTS * LANES))
        _tabulate(setting.tree, tuple(checked(setting.tree, some)), turns, work, out)
        return out

    table = tables(gaits)
    if yaw is not None:
        _take_yaw(table, tables(yaw))
    return Cycles(setting, table, _step_lengths(2 * np.pi / gaits.angular_frequency, steps), n)


def cycles_of_gait(
    setting: Setting, gait: Gait, period: float, steps: int, yaw: Gait | None = None
) -> Cycles:
    """Tabulate a period of one gait of any kind."""

    def table(some: Gait) -> Array:
        motion = some(stage_times(0.0, period / steps, steps))
        rows = np.empty((len(motion.angle), N_COEFFICIENTS))
        angle, rate = (np.ascontiguousarray(part) for part in motion[:2])
        fill(setting.tree, angle, rate, rows)
        return np.repeat(rows, LANES, axis=1)[None]

    own = table(gait)
    if yaw is not None:
        _take_yaw(own, table(yaw))
    return Cycles(setting, own, _step_lengths(np.array([period]), steps), 1)


def replicated(cycles: Cycles, n: int) -> Cycles:
    """The cycles of one gait n times, for as many starts side by side."""
    blocks = -(-n // LANES)
    return cycles._replace(
        tables=np.repeat(cycles.tables[:1], blocks, axis=0),
        h=np.repeat(cycles.h[:1], blocks, axis=0),
        n=n,
    )


def _take_yaw(table: Array, other: Array) -> None:
    for c in _YAWS_OWN:
        entry = slice(c * LANES, (c + 1) * LANES)
        table[:, :, entry] = other[:, :, entry]


def _step_lengths(period: Array, steps: int) -> Array:
    blocks = _in_blocks((period / steps)[:, None])
    return np.ascontiguousarray(np.tile(blocks, (1, N_STATE)))


def _in_blocks(rows: Array) -> Array:
    """(blocks, width LANES) of rows (n, width); the last is repeated to fill the last block."""
    n, width = rows.shape
    missing = -n % LANES
    if missing:
        rows = np.concatenate((rows, np.repeat(rows[-1:], missing, axis=0)))
    return np.ascontiguousarray(rows.reshape(-1, LANES, width).transpose(0, 2, 1)).reshape(
        -1, width * LANES
    )


def _out_of_blocks(blocks: Array, n: int) -> Array:
    width = blocks.shape[1] // LANES
    rows = blocks.reshape(-1, width, LANES).transpose(0, 2, 1).reshape(-1, width)
    return np.ascontiguousarray(rows[:n])


def carry(cycles: Cycles, y: Array, periods: int = 1) -> Array:
    """States (n, N_STATE) after whole periods of the legs.

    Args:
        cycles: of n gaits.
        y: states at the start (n, N_STATE).
        periods: how many.
    """
    state = _in_blocks(y)
    setting = cycles.setting
    par = np.repeat(setting.parameters, LANES)
    _carry(
        state, cycles.tables, cycles.h, periods, par, setting.axis, setting.terrain,
        scratch(setting.terrain), _scratch(),
    )  # fmt: skip
    return _out_of_blocks(state, cycles.n)


def seen(cycles: Cycles, y: Array) -> Seen:
    """Look at one period that starts from states (n, N_STATE)."""
    state, blocks = _in_blocks(y), len(cycles.tables)
    n, steps, setting = cycles.n, cycles.steps, cycles.setting
    entries = N_ANY_MOTION if setting.axis == ANY else N_MOTION
    areas = np.zeros((blocks, 3 * LANES))
    out = np.full((blocks, steps, (3 + entries + 2) * LANES), np.nan)
    ground = np.full((blocks, 2 * LANES), np.inf)
    par = np.repeat(setting.parameters, LANES)
    _look(
        state, cycles.tables, cycles.h, par, setting.axis, setting.terrain,
        scratch(setting.terrain), _scratch(), areas, out,
        ground,
    )  # fmt: skip
    flat = _history(out, n)
    return Seen(
        y, _out_of_blocks(state, n), _out_of_blocks(areas, n), flat[:, :, :3],
        flat[:, :, 3:-2], flat[:, :, -2], flat[:, :, -1], _out_of_blocks(ground, n),
    )  # fmt: skip


def _history(out: Array, n: int) -> Array:
    blocks, steps, _ = out.shape
    lanes = out.reshape(blocks, steps, -1, LANES).transpose(0, 3, 1, 2)
    return lanes.reshape(blocks * LANES, steps, -1)[:n]


def _scratch() -> tuple[Array, ...]:
    slopes = np.zeros((N_STAGES, BLOCK))
    return (slopes, *(np.zeros(n) for n in (BLOCK, BLOCK, 3 * LANES)), np.zeros(N_ANY_MOTION))


@compiled()
def _tabulate(tree, gaits, turns, work, out):  # type: ignore[no-untyped-def]
    tree, gaits, turns, work, out = (
        borrowed(tree), borrowed(gaits), borrowed(turns), borrowed(work), borrowed(out),
    )  # fmt: skip
    for b in range(len(out)):
        tabulate(tree, gaits, b * LANES, turns, work, out[b])


@compiled()
def _carry(  # type: ignore[no-untyped-def]
    state, tables, h, periods, par, axis, terrain, rolling, work
):
    state, tables, h, par, rolling, work = (
        borrowed(state), borrowed(tables), borrowed(h), borrowed(par), borrowed(rolling),
        borrowed(work),
    )  # fmt: skip
    if terrain is not None:
        terrain = borrowed(terrain)
    slopes, total, other, areas, _ = work
    for b in range(len(state)):
        y, table = state[b], tables[b]
        for _period in range(periods):
            for at in range(0, len(table) - 1, ROWS_PER_STEP):
                step(y, table, at, h[b], par, axis, slopes, total, other, areas, terrain, rolling)


@compiled()
def _look(  # type: ignore[no-untyped-def]
    state, tables, h, par, axis, terrain, rolling, work, areas, out, ground
):
    state, tables, h, par, rolling, work, areas, out, ground = (
        borrowed(state), borrowed(tables), borrowed(h), borrowed(par), borrowed(rolling),
        borrowed(work), borrowed(areas), borrowed(out), borrowed(ground),
    )  # fmt: skip
    if terrain is not None:
        terrain = borrowed(terrain)
    slopes, total, other, _, now = work
    entries = out.shape[2] // LANES - 5
    before = np.empty(BLOCK)
    turned = np.empty(BLOCK)
    for b in range(len(state)):
        y, table = state[b], tables[b]
        if terrain is not None:
            for e in range(2 * LANES):
                rolling[ROOM * LANES + e] = np.inf
        for n in range(out.shape[1]):
            for e in range(BLOCK):
                before[e] = y[e]
            at = n * ROWS_PER_STEP
            step(y, table, at, h[b], par, axis, slopes, total, other, areas[b], terrain, rolling)
            angles(before, axis, turned)
            row = out[b, n]
            for e in range(3 * LANES):
                row[e] = turned[e]
            if axis == DECOUPLED:
                for i in range(LANES):
                    row[6 * LANES + i], row[7 * LANES + i] = slopes[0, i], slopes[0, LANES + i]
                    row[8 * LANES + i] = slopes[0, 9 * LANES + i]
                continue
            _gather(before, table, at, par, slopes, terrain, rolling, now, entries, row)
        if terrain is not None:
            for e in range(2 * LANES):
                ground[b, e] = rolling[ROOM * LANES + e]


@inner
def _gather(  # type: ignore[no-untyped-def]
    y, table, at, par, slopes, terrain, rolling, now, entries, row
):
    """Motion and lift of every lane. Numba leaves out what an argument's type rules out."""
    if terrain is not None:
        # The stages have gone over the scratch.
        evaluate_lanes(y, table, at, par, slopes, 0, terrain, rolling)
    for i in range(LANES):
        motion_of(y, slopes, i, now)
        if terrain is not None:
            contact_motion(terrain, rolling, i, now)
            row[(3 + entries) * LANES + i], row[(4 + entries) * LANES + i] = push(
                rolling, now, par, i
            )
        else:
            row[(3 + entries) * LANES + i] = lift(now, table, at, i)
        for s in range(entries):
            row[(3 + s) * LANES + i] = now[s]
