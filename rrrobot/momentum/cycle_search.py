"""Limit cycles of many gaits, in blocks side by side, and what each does in its period, in Numba.

A block starts upright and at rest. Newton's method on the return map of a fifth as many steps, then
of a third, leads near the orbit; Broyden's steps on the map itself close it (`newton.py`). Each
gait goes its own way to the last bit, whichever stand beside it.
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits.batch import GaitBatch
from rrrobot.momentum.batch import _derivative
from rrrobot.momentum.charts import Chart
from rrrobot.momentum.coefficients import LANES, N_COEFFICIENTS
from rrrobot.momentum.compiled import borrowed, compiled, inner
from rrrobot.momentum.cycle_look import extremes, look, summarise
from rrrobot.momentum.kernels import ANY, BLOCK, DECOUPLED, N_STAGES, N_STATE, ROWS_PER_STEP
from rrrobot.momentum.lane import scratch
from rrrobot.momentum.legs import GaitWork, checked, gait_work, tabulate, turns_of
from rrrobot.momentum.lowering import Setting
from rrrobot.momentum.newton import (
    DONE,
    FORETOLD,
    Search,
    approach,
    begin,
    close,
    differentiate,
    image,
    invert,
    judge,
    largest,
    learned,
    search_room,
)
from rrrobot.momentum.normal import N_ANY_MOTION
from rrrobot.momentum.summary import N_MOTION, N_RESULT

_CRUDE, _COARSE = 0.2, 0.3
"""Steps of the first maps, of those of the map itself, and Broyden's steps on each."""
_MORE = (1, 0)


class Found(NamedTuple):
    """Limit cycles of n gaits."""

    results: Array
    """(n, N_RESULT), as `RESULT` has them, "variation" the residual, "pitch" its |sine|, without
    "clearance"; NaN but for the residual and the status where there is no orbit"""
    point: Array
    """coordinates of the orbits' starts (n, d)"""
    slope: Array
    """dP/dx there by forward differences, to about 1e-7 (n, d, d); or, if that was not asked for,
    1 + H^-1 of Broyden's steps"""
    periods: Array
    """simulated for each search by its closing steps and the look (n,)"""
    before: float
    """periods before these, those of fewer steps in part"""
    motion: Array
    """as `Settled.motion`"""


class Room(NamedTuple):
    """Room for a block of LANES gaits; see `Work` for what has the same name there."""

    legs: GaitWork
    tables: tuple[Array, ...]
    """coefficients of the crude, the coarse and the whole map"""
    other: tuple[Array, ...]
    """those of the yaw model alone"""
    h: Array
    """steps of the three (3, BLOCK) [s]"""
    parameters: Array
    state: Array
    slopes: Array
    areas: Array
    angles: Array
    lift: Array
    push: Array
    tilt: Array
    """x of z_body at the steps (n, LANES)"""
    rolling: Array
    now: Array
    low: Array
    steep: Array
    """largest |sin pitch| (LANES,)"""
    sums: Array
    search: Search


def search(
    setting: Setting,
    chart: Chart,
    gaits: GaitBatch,
    steps: int,
    *,
    yaw: GaitBatch | None = None,
    start: tuple[Array, Array] | None = None,
    settling: int = 0,
    most: int = 30,
    slopes: bool = True,
) -> Found:
    """Limit cycles of n gaits of any harmonics, of the legs' period.

    Holds no interpreter lock while it computes.

    Args:
        setting, chart: the model, and what must come back.
        gaits: one row a gait.
        steps: in a period.
        yaw: gaits of the yaw model alone, if decoupled.
        start: coordinates (n, d) and dP/dx (n, d, d) of a neighbour's orbit for each, instead of
            the maps of fewer steps.
        settling: periods of simulation from the upright impulsive start instead of the maps of
            fewer steps.
        most: Broyden's steps.
        slopes: whether to have dP/dx by differences.

    Raises:
        GaitError: a leg cannot go round and round.
    """
    n = gaits.n
    d, harmonics = len(chart.angles) + len(chart.momenta), gaits.sine.shape[1]
    width = N_ANY_MOTION if setting.axis == ANY else N_MOTION
    counts = [max(2 + k, ceil(part * steps)) for k, part in enumerate((_CRUDE, _COARSE))]
    parts = [(1 + d + more) * count / steps for count, more in zip(counts, _MORE, strict=True)]
    before = float(0 if start is not None else settling + 1 + d if settling > 0 else sum(parts))
    found = Found(
        np.full((n, N_RESULT), np.nan), np.empty((n, d)), np.full((n, d, d), np.nan), np.empty(n),
        before, np.full((n, steps, width), np.nan),
    )  # fmt: skip
    counts.append(steps)
    slope_of, value_of = _derivative(steps, True)
    near, slope = start or (np.empty((0, d)), np.empty((0, d, d)))
    turns = tuple(turns_of(count, harmonics) for count in counts)
    _search(
        setting.tree, setting.axis, setting.limit, setting.terrain, chart,
        tuple(checked(setting.tree, gaits)), tuple(checked(setting.tree, yaw or gaits)), turns,
        slope_of, value_of, np.ascontiguousarray(near), np.ascontiguousarray(slope), settling,
        most, slopes, _room(setting, harmonics, counts, d), found,
    )  # fmt: skip
    return found


def _room(setting: Setting, harmonics: int, counts: list[int], d: int) -> Room:
    steps, width = counts[-1], N_COEFFICIENTS * LANES
    decoupled = setting.axis == DECOUPLED

    def tables(wanted: bool) -> tuple[Array, ...]:
        return tuple(np.zeros((wanted * (count * ROWS_PER_STEP + 1), width)) for count in counts)

    forces, pushes, tilts = (np.zeros((steps, LANES)) for _ in range(3))
    return Room(
        gait_work(setting.tree, harmonics), tables(True),
        tables(decoupled), np.zeros((3, BLOCK)), np.repeat(setting.parameters, LANES),
        np.zeros((4, BLOCK)), np.zeros((N_STAGES, BLOCK)), np.zeros(3 * LANES),
        np.zeros((steps, 3 * LANES)), forces, pushes, tilts, scratch(setting.terrain),
        np.zeros(N_ANY_MOTION), np.zeros(LANES), np.zeros(LANES), np.zeros((2, LANES)),
        search_room(d),
    )  # fmt: skip


@compiled()
def _search(  # type: ignore[no-untyped-def]
    tree, axis, limit, terrain, chart, gaits, yaw_gaits, turns, slope_of, value_of, near,
    near_slope, settling, most, slopes, work, found,
):  # fmt: skip
    tree, work, gaits, yaw_gaits = (
        borrowed(tree), borrowed(work), borrowed(gaits), borrowed(yaw_gaits),
    )  # fmt: skip
    chart, found, turns = borrowed(chart), borrowed(found), borrowed(turns)
    slope_of, value_of = borrowed(slope_of), borrowed(value_of)
    near, near_slope = borrowed(near), borrowed(near_slope)
    if terrain is not None:
        terrain = borrowed(terrain)
    s = work.search
    n, d = len(found.results), len(s.x)
    for first in range(0, n, LANES):
        for k in range(2 if settling > 0 or len(near) > 0 else 0, 3):
            _tabulate(tree, axis, gaits, yaw_gaits, first, turns[k], work, work.tables[k],
                      work.other[k])  # fmt: skip
            steps = (len(work.tables[k]) - 1) // ROWS_PER_STEP
            for i in range(LANES):
                for e in range(N_STATE):
                    work.h[k, e * LANES + i] = 2.0 * np.pi / work.legs.omega[i] / steps
        _scale(axis, work)
        fine, h = work.tables[2], work.h[2]
        for i in range(LANES):
            for k in range(d):
                s.x[k, i] = 0.0
        if settling > 0:
            for _ in range(settling):
                image(chart, s.x, fine, h, axis, terrain, work, s.x)
            _from_there(chart, axis, terrain, work)
        elif len(near) > 0:
            for i in range(LANES):
                g = min(first + i, n - 1)
                for k in range(d):
                    s.x[k, i] = near[g, k]
                    for j in range(d):
                        s.slope[k, j, i] = near_slope[g, k, j]
                invert(s, i)
        else:
            for k in range(2):
                approach(chart, work.tables[k], work.h[k], axis, terrain, work, _MORE[k])
        begin(chart, fine, h, axis, terrain, work)
        while True:
            close(chart, fine, h, axis, terrain, work, most)
            look(chart, axis, terrain, first, work, found.motion)
            done = True
            for i in range(LANES):
                if s.stage[i] == FORETOLD:
                    judge(s, i, most)
                    done = done and s.stage[i] == DONE
            if done:
                break
        for i in range(LANES):
            for k in range(d):
                s.F[k, i] = s.image[k, i]
                s.new[k, i] = s.image[k, i] - s.trial[k, i]
            s.size[i] = largest(s.new, i)
        extremes(axis, terrain, slope_of, value_of, work)
        for i in range(min(LANES, n - first)):
            found.periods[first + i] = s.spent[i]
            for k in range(d):
                found.point[first + i, k] = s.x[k, i]
            summarise(axis, limit, terrain, turns[2], work, i, found.results[first + i])
        if slopes:
            differentiate(chart, s.x, s.F, fine, h, axis, terrain, work)
        else:
            for i in range(LANES):
                learned(s, i)
        for i in range(min(LANES, n - first)):
            for k in range(d):
                for j in range(d):
                    found.slope[first + i, k, j] = s.slope[k, j, i]


@inner
def _tabulate(  # type: ignore[no-untyped-def]
    tree, axis, gaits, yaw_gaits, first, turns, work, table, other
):
    """A block's coefficients over a period."""
    if axis == DECOUPLED:
        tabulate(tree, yaw_gaits, first, turns, work.legs, other)
    tabulate(tree, gaits, first, turns, work.legs, table)
    if axis == DECOUPLED:
        for r in range(len(table)):
            for i in range(LANES):
                table[r, 5 * LANES + i] = other[r, 5 * LANES + i]
                table[r, 14 * LANES + i] = other[r, 14 * LANES + i]


@inner
def _scale(axis, work):  # type: ignore[no-untyped-def]
    """Momentum of order one of each lane: see `rrrobot.orbits.section.momentum_scale`."""
    table, par = work.tables[2], work.parameters
    for i in range(LANES):
        inertia = (table[0, 3 * LANES + i] + table[0, 4 * LANES + i] + table[0, 5 * LANES + i]) / 3
        radius = 0.0 if axis == ANY else par[LANES + i]
        work.search.scale[i] = (inertia + par[i] * radius**2) * work.legs.omega[i]


@inner
def _from_there(chart, axis, terrain, work):  # type: ignore[no-untyped-def]
    """H at x by the map itself; lanes whose motion left the numbers start from rest again."""
    s = work.search
    for i in range(LANES):
        if not np.isfinite(largest(s.x, i)):
            for k in range(len(s.x)):
                s.x[k, i] = 0.0
    fine, h = work.tables[2], work.h[2]
    image(chart, s.x, fine, h, axis, terrain, work, s.new)
    differentiate(chart, s.x, s.new, fine, h, axis, terrain, work)
    for i in range(LANES):
        invert(s, i)
