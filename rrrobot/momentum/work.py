"""Room for a block of gaits on their way to a steady state."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.momentum.coefficients import LANES, N_COEFFICIENTS
from rrrobot.momentum.kernels import BLOCK, DECOUPLED, N_STAGES, ROWS_PER_STEP
from rrrobot.momentum.lane import scratch
from rrrobot.momentum.legs import GaitWork, gait_work
from rrrobot.momentum.lowering import Setting
from rrrobot.momentum.normal import N_ANY_MOTION
from rrrobot.momentum.vertical import N_PAST


class Work(NamedTuple):
    """Room for a block of LANES gaits."""

    legs: GaitWork
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
    """vertical momentum relative to the centre at the steps of the last cycle (n, LANES); where
    axis is ANY, the whole momentum along the ground's normal"""
    push: Array
    """what its rate lacks of the normal force, where axis is ANY (n, LANES)"""
    rolling: Array
    """scratch, see `rolling.scratch`"""
    status: NDArray[np.int64]
    """(LANES,)"""
    largest: Array
    """|sin pitch| (LANES,)"""
    past: Array
    """see `watch` (N_PAST, 2, LANES)"""
    sides: Array
    """likewise (3, LANES)"""
    now: Array
    """one lane's motion (N_ANY_MOTION,)"""
    low: Array
    """least slope of lift, or least normal force where axis is ANY (LANES,)"""
    sums: Array
    """scratch (2, LANES)"""


def work_of(setting: Setting, harmonics: int, counted: int, n_steps: int) -> Work:
    """Room for blocks of gaits of a number of steps."""
    rows, width = n_steps * ROWS_PER_STEP + 1, N_COEFFICIENTS * LANES
    return Work(
        gait_work(setting.tree, harmonics), np.zeros((rows, width)),
        np.zeros((rows if setting.axis == DECOUPLED else 0, width)),
        np.repeat(setting.parameters, LANES), np.zeros(BLOCK), np.zeros(LANES, dtype=np.int64),
        np.zeros((4, BLOCK)), np.zeros((N_STAGES, BLOCK)), np.zeros(3 * LANES),
        np.zeros((counted, 3 * LANES)), np.zeros((n_steps, 3 * LANES)), np.zeros((n_steps, LANES)),
        np.zeros((n_steps, LANES)), scratch(setting.terrain),
        np.zeros(LANES, dtype=np.int64), np.zeros(LANES), np.zeros((N_PAST, 2, LANES)),
        np.zeros((3, LANES)), np.zeros(N_ANY_MOTION),
        np.zeros(LANES), np.zeros((2, LANES)),
    )  # fmt: skip
