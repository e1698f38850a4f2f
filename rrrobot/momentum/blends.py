"""Gaits that are blended into each other: many such motions of the legs, and what they come to.

Lane i's legs have the coefficients L[p] (offset, sines, cosines) before part p + 1 begins, at the
time b[p], and go over to L[p + 1] in a given time:

    phi = (1 - q) phi_p + q phi_(p+1),    q(u) = 6 u^5 - 15 u^4 + 10 u^3,    u = (t - b[p]) / blend.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.momentum.coefficients import LANES, N_COEFFICIENTS, fill_lanes, lane_work
from rrrobot.momentum.compiled import borrowed, compiled, inner
from rrrobot.momentum.kernels import (
    BLOCK,
    DECOUPLED,
    N_STAGES,
    N_STATE,
    NODES,
    ROWS_PER_STEP,
    step,
)
from rrrobot.momentum.lane import scratch
from rrrobot.momentum.legs import turns_of
from rrrobot.momentum.lowering import Setting


class Blends(NamedTuple):
    """Leg motions of one frequency, one a row."""

    levels: Array
    """L: offset, sines, cosines (n, parts + 1, 1 + 2 harmonics, legs) [rad]"""
    begins: Array
    """b: when the blend to each part begins (n, parts), rising; infinite where there is none [s]"""
    blend: float
    """time of a blend [s]"""
    angular_frequency: float
    """[rad/s]"""


def final_states(
    setting: Setting,
    blends: Blends,
    y0: Array,
    *,
    duration: float,
    steps_per_cycle: int,
    yaw: Blends | None = None,
) -> Array:
    """States at the end of many leg motions (n, N_STATE).

    Args:
        setting: the model.
        blends: all of whose legs are still after the last blend.
        y0: state that all begin with (N_STATE,).
        duration: of all, up to the next whole step [s].
        steps_per_cycle: see `steady_states`.
        yaw: the yaw model's own legs, for decoupled models.
    """
    own = blends if yaw is None else yaw
    n, _, rows, _ = blends.levels.shape
    length = 2 * np.pi / blends.angular_frequency / steps_per_cycle
    steps = int(np.ceil(duration / length - 1e-9))
    turns = turns_of(steps_per_cycle, (rows - 1) // 2)
    out = np.empty((n, N_STATE))
    work = (np.zeros((N_STAGES, BLOCK)), *(np.zeros(k) for k in (BLOCK, BLOCK, 3 * LANES, BLOCK)))
    rolling, parameters = scratch(setting.terrain), np.repeat(setting.parameters, LANES)
    tables = np.zeros((2, ROWS_PER_STEP + 1, N_COEFFICIENTS * LANES))
    room, own_room = lane_work(setting.tree), lane_work(setting.tree)
    for first in range(0, n, LANES):
        rows_ = np.minimum(np.arange(first, first + LANES), n - 1)
        here = [np.ascontiguousarray(x[rows_]) for x in (*blends[:2], *own[:2])]
        y = np.repeat(y0, LANES)
        _march(
            y, setting.tree, tuple(here), blends.blend, blends.angular_frequency, length, steps,
            NODES, turns, parameters, setting.axis, setting.terrain, rolling, work, tables, room,
            own_room,
        )  # fmt: skip
        count = min(LANES, n - first)
        out[first : first + count] = y.reshape(N_STATE, LANES).T[:count]
    return out


@compiled()
def _march(  # type: ignore[no-untyped-def]
    y, tree, legs, blend, omega, length, steps, nodes, turns, par, axis, terrain, rolling, work,
    tables, room, own_room
):  # fmt: skip
    """LANES motions side by side, y in place; the second table is the yaw model's."""
    y, tree, legs, turns, par, rolling, work, tables, room, own_room = (
        borrowed(y), borrowed(tree), borrowed(legs), borrowed(turns), borrowed(par),
        borrowed(rolling), borrowed(work), borrowed(tables), borrowed(room), borrowed(own_room),
    )  # fmt: skip
    if terrain is not None:
        terrain = borrowed(terrain)
    levels, begins, own_levels, own_begins = legs
    slopes, total, other, areas, h = work
    table, own = tables[0], tables[1]
    last = 0.0
    for i in range(LANES):
        for p in range(begins.shape[1]):
            if np.isfinite(begins[i, p]):
                last = max(last, begins[i, p] + blend)
    period = turns.shape[1] - 1
    for e in range(BLOCK):
        h[e] = length
    for n in range(steps):
        # Once all legs rest the rows are all alike.
        if n == 0 or (n - 1) * length <= last:
            for r in range(ROWS_PER_STEP + 1):
                if r == 0 and n > 0:
                    for e in range(N_COEFFICIENTS * LANES):
                        table[0, e] = table[ROWS_PER_STEP, e]
                    continue
                time = (n + nodes[r]) * length
                turn = (n * ROWS_PER_STEP + r) % period
                _legs_at(levels, begins, blend, omega, time, turns, turn, room)
                fill_lanes(tree, room, table, r)
                if axis == DECOUPLED:  # its inertia and momentum about the vertical
                    _legs_at(own_levels, own_begins, blend, omega, time, turns, turn, own_room)
                    fill_lanes(tree, own_room, own, r)
                    for i in range(LANES):
                        table[r, 5 * LANES + i] = own[r, 5 * LANES + i]
                        table[r, 14 * LANES + i] = own[r, 14 * LANES + i]
        step(y, table, 0, h, par, axis, slopes, total, other, areas, terrain, rolling)


@inner
def _legs_at(  # type: ignore[no-untyped-def]
    levels, begins, blend, omega, time, turns, turn, room
):
    """Angles and rates of the legs of all lanes at an instant."""
    harmonics = turns.shape[2]
    for i in range(LANES):
        part = 0
        while part + 1 < begins.shape[1] and begins[i, part + 1] <= time:
            part += 1
        u = min(max((time - begins[i, part]) / blend, 0.0), 1.0)
        q = u * u * u * (10.0 + u * (6.0 * u - 15.0))
        q1 = 30.0 * (u * (1.0 - u)) ** 2 / blend
        for leg in range(levels.shape[3]):
            angle = levels[i, part, 0, leg]
            change = levels[i, part + 1, 0, leg] - angle
            rate = turning = 0.0
            for j in range(harmonics):
                s, c, w = turns[0, turn, j], turns[1, turn, j], (j + 1.0) * omega
                a, b = levels[i, part, 1 + j, leg], levels[i, part, 1 + harmonics + j, leg]
                da = levels[i, part + 1, 1 + j, leg] - a
                db = levels[i, part + 1, 1 + harmonics + j, leg] - b
                angle += a * s + b * c
                rate += w * (a * c - b * s)
                change += da * s + db * c
                turning += w * (da * c - db * s)
            room.angle[leg, i] = angle + q * change
            room.rate[leg, i] = rate + q * turning + q1 * change
