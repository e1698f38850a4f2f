"""Coordinates of what must come back after a period, of a block of lanes, in Numba."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import inner
from rrrobot.momentum.kernels import BLOCK

_K = 4


class Chart(NamedTuple):
    """What must come back after a period; see `rrrobot.orbits.section`."""

    angles: NDArray[np.int64]
    """entries of (roll, pitch)' that are free"""
    momenta: NDArray[np.int64]
    """entries of K that are free"""
    tilted: bool
    """whether the state is a quaternion; else it is the angles themselves"""
    level: bool
    """whether the momentum about the vertical is held at zero"""


@inner
def put(chart, x, scale, y, ahead):  # type: ignore[no-untyped-def]
    """States y of coordinates x, at the origin; with yaw zero if `ahead`, else with any."""
    n = len(chart.angles)
    for e in range(BLOCK):
        y[e] = 0.0
    for i in range(LANES):
        roll, pitch = 0.0, 0.0
        for k in range(n):
            if chart.angles[k] == 0:
                roll = x[k, i]
            else:
                pitch = x[k, i]
        for k in range(len(chart.momenta)):
            y[(_K + chart.momenta[k]) * LANES + i] = x[n + k, i] * scale[i]
        if not chart.tilted:
            y[i], y[LANES + i] = roll, pitch
            continue
        a, b = 0.5 * roll, 0.5 * pitch
        # (a, b, 0, 1) has the tilt; a turn about the vertical takes its yaw away.
        s, c = 0.0, 1.0
        if ahead:
            half = -0.5 * np.arctan2(2.0 * a * b, 1.0 + a * a - b * b)
            s, c = np.sin(half), np.cos(half)
        y[i], y[LANES + i] = c * a - s * b, c * b + s * a
        y[2 * LANES + i], y[3 * LANES + i] = s, c
        if chart.level:
            # K . z = 0, with z in the ratio (-2b, 2a, 1 - a^2 - b^2).
            along = 2.0 * (b * y[_K * LANES + i] - a * y[(_K + 1) * LANES + i])
            y[(_K + 2) * LANES + i] = along / (1.0 - a * a - b * b)


@inner
def take(chart, y, scale, x):  # type: ignore[no-untyped-def]
    """Coordinates x of states y."""
    n = len(chart.angles)
    for i in range(LANES):
        roll, pitch = y[i], y[LANES + i]
        if chart.tilted:
            a, b, z, w = roll, pitch, y[2 * LANES + i], y[3 * LANES + i]
            over = 2.0 / (z * z + w * w)
            roll, pitch = over * (b * z + w * a), over * (w * b - a * z)
        for k in range(n):
            x[k, i] = roll if chart.angles[k] == 0 else pitch
        for k in range(len(chart.momenta)):
            x[n + k, i] = y[(_K + chart.momenta[k]) * LANES + i] / scale[i]
