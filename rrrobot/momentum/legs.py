"""The legs of batches of gaits at the engine's instants: phases that all share, tables of each."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits.batch import GaitBatch
from rrrobot.errors import GaitError
from rrrobot.momentum.coefficients import (
    LANES,
    N_COEFFICIENTS,
    LaneWork,
    fill_lanes,
    lane_work,
)
from rrrobot.momentum.compiled import inner, lanes
from rrrobot.momentum.kernels import NODES, ROWS_PER_STEP
from rrrobot.momentum.tree import Tree


class GaitWork(NamedTuple):
    """Room for the legs' motion of a block of LANES gaits."""

    lanes: LaneWork
    gait: Array
    """offset, winding, a sine and a cosine for each harmonic (2 + 2 harmonics, legs, LANES)"""
    omega: Array
    """(LANES,) [rad/s]"""


def gait_work(tree: Tree, harmonics: int) -> GaitWork:
    """Room for the legs' motion of blocks of gaits."""
    lanes = lane_work(tree, ROWS_PER_STEP)
    gait = np.zeros((2 + 2 * harmonics, len(lanes.angle), LANES))
    return GaitWork(lanes, gait, np.zeros(LANES))


def stage_times(start: float, step: float, steps: int) -> Array:
    """Instants of the rows of a coefficient table for `steps` equal steps [s]."""
    inner = np.add.outer(np.arange(steps), NODES[:-1]).ravel()
    return start + step * np.append(inner, steps)


@lru_cache(maxsize=8)
def turns_of(steps: int, harmonics: int) -> Array:
    """Sine, cosine and value of a gait's phases j u at the rows of a table (3, rows, harmonics)."""
    return _phases(2 * np.pi / steps, stage_times(0, 1, steps), harmonics)


@lru_cache(maxsize=8)
def turns_at(instants: int, harmonics: int) -> Array:
    """Likewise at equal instants of a period (3, instants, harmonics)."""
    return _phases(2 * np.pi / instants, np.arange(float(instants)), harmonics)


def _phases(scale: float, places: Array, harmonics: int) -> Array:
    turn = scale * np.multiply.outer(places, np.arange(harmonics) + 1)
    return np.array((np.sin(turn), np.cos(turn), turn))


def checked(tree: Tree, gaits: GaitBatch) -> GaitBatch:
    """Gaits as compiled code takes them.

    Raises:
        GaitError: a leg that slides, or a joint that is geared to it, does not come back when the
            leg goes round.
    """
    whole = gaits.contiguous()
    for k in np.flatnonzero(np.any(whole.winding != 0.0, axis=0)):
        ratio = tree.ratio[(tree.leg == k) & ~tree.prismatic]
        if np.any(tree.prismatic[tree.leg == k]) or np.any(ratio != np.round(ratio)):
            raise GaitError(
                f"leg {k + 1} cannot go round and round: it slides, or moves a joint that slides "
                "or is geared by a broken ratio. Give it winding 0."
            )
    return whole


@inner
def tabulate(tree, gaits, first, turns, work, table):  # type: ignore[no-untyped-def]
    """Coefficients of LANES gaits over their periods (rows, 15 LANES)."""
    offset, winding, sine, cosine, omega = gaits
    n, legs = offset.shape
    harmonics, rows = sine.shape[1], len(table) - 1
    for i in range(LANES):
        g = min(first + i, n - 1)
        work.omega[i] = omega[g]
        for leg in range(legs):
            work.gait[0, leg, i], work.gait[1, leg, i] = offset[g, leg], winding[g, leg]
            for j in range(harmonics):
                work.gait[2 + 2 * j, leg, i] = sine[g, j, leg]
                work.gait[3 + 2 * j, leg, i] = cosine[g, j, leg]
    for at in range(0, rows, ROWS_PER_STEP):
        for leg in range(legs):
            _swing(work.gait, work.omega, turns, at, leg, work.lanes.angle, work.lanes.rate)
        fill_lanes(tree, work.lanes, table, at)
    for e in range(N_COEFFICIENTS * LANES):
        table[rows, e] = table[0, e]


@lanes
def _swing(gait, omega, turns, at, leg, angle, rate):  # type: ignore[no-untyped-def]
    """Angle and rate of a leg in every lane at the rows of a step."""
    lanes = len(omega)
    offset, winding, angle, rate = gait[0, leg], gait[1, leg], angle[leg], rate[leg]
    for r in range(ROWS_PER_STEP):
        here, turn = r * LANES, turns[2, at + r, 0]
        for i in range(lanes):
            angle[here + i] = offset[i] + winding[i] * turn
            rate[here + i] = winding[i] * omega[i]
    for j in range(turns.shape[2]):
        a, b = gait[2 + 2 * j, leg], gait[3 + 2 * j, leg]
        for r in range(ROWS_PER_STEP):
            here, s, c = r * LANES, turns[0, at + r, j], turns[1, at + r, j]
            for i in range(lanes):
                angle[here + i] += a[i] * s + b[i] * c
                rate[here + i] += (j + 1.0) * omega[i] * (a[i] * c - b[i] * s)


@inner
def legs_at(omega, offset, winding, sine, cosine, turns, k, leg):  # type: ignore[no-untyped-def]
    """Angles, rates and accelerations (3, legs) of a gait at an instant."""
    for i in range(offset.size):
        leg[0, i], leg[1, i] = offset[i] + winding[i] * turns[2, k, 0], winding[i] * omega
        leg[2, i] = 0.0
        for j in range(len(sine)):
            w, s, c = (j + 1) * omega, turns[0, k, j], turns[1, k, j]
            swing = sine[j, i] * s + cosine[j, i] * c
            leg[0, i] += swing
            leg[1, i] += w * (sine[j, i] * c - cosine[j, i] * s)
            leg[2, i] -= w * w * swing
