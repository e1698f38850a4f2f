"""Where every lane's shell touches its ground: R, n_b, s and H into the scratch.

Rows of the scratch are those of `lane.py`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import lanes
from rrrobot.momentum.lane import N_GRAPH, N_SCRATCH, ROOM, H, N, R, S, bend_of
from rrrobot.momentum.series import shell_series
from rrrobot.momentum.terrain import BOULDER, ELLIPSOIDS, FLAT, GRAPH, ROUND, SLOPE
from rrrobot.momentum.uneven import graph_normal


@njit(inline="always")
def touch_lanes(y, terrain, b):  # type: ignore[no-untyped-def]
    """R, n_b, s and, of shells that are not round, H of every lane."""
    _turns(y, b)
    if terrain.shell == FLAT:
        _belly(y, terrain, b)
        return
    if terrain.ground == SLOPE:
        _slope(terrain.plane, b)
    elif terrain.ground == BOULDER:
        _boulder(y, terrain.curvature, terrain.limit, b)
    elif terrain.ground == GRAPH:
        graph_normal(y, terrain.corner, terrain.spacing, terrain.table, b)
    else:
        _level(b)
    if terrain.shell == ROUND:
        _round(terrain.center, terrain.radius, b)
        if terrain.ground == GRAPH:
            _round_bend(terrain.radius, b)
    elif terrain.shell == ELLIPSOIDS:
        _ellipsoids(terrain.center, terrain.terms, b)
    else:
        shell_series(terrain, b, N_SCRATCH + N_GRAPH)


@lanes
def _turns(y, b):  # type: ignore[no-untyped-def]
    """R of every lane."""
    for i in range(LANES):
        x, v, z, w = y[i], y[LANES + i], y[2 * LANES + i], y[3 * LANES + i]
        two = 2.0 / (x * x + v * v + z * z + w * w)
        b[R * LANES + i] = 1.0 - two * (v * v + z * z)
        b[(R + 1) * LANES + i] = two * (x * v - w * z)
        b[(R + 2) * LANES + i] = two * (x * z + w * v)
        b[(R + 3) * LANES + i] = two * (x * v + w * z)
        b[(R + 4) * LANES + i] = 1.0 - two * (x * x + z * z)
        b[(R + 5) * LANES + i] = two * (v * z - w * x)
        b[(R + 6) * LANES + i] = two * (x * z - w * v)
        b[(R + 7) * LANES + i] = two * (v * z + w * x)
        b[(R + 8) * LANES + i] = 1.0 - two * (x * x + v * v)


@lanes
def _level(b):  # type: ignore[no-untyped-def]
    for a in range(3):
        for i in range(LANES):
            b[(N + a) * LANES + i] = b[(R + 6 + a) * LANES + i]


@lanes
def _slope(plane, b):  # type: ignore[no-untyped-def]
    n0, n1, n2 = plane[0], plane[1], plane[2]
    for a in range(3):
        for i in range(LANES):
            b[(N + a) * LANES + i] = (
                n0 * b[(R + a) * LANES + i]
                + n1 * b[(R + 3 + a) * LANES + i]
                + n2 * b[(R + 6 + a) * LANES + i]
            )


@lanes
def _boulder(y, k, limit, b):  # type: ignore[no-untyped-def]
    """n = (k x, k y, sqrt(1 - k^2 (x^2 + y^2)))."""
    for i in range(LANES):
        n0, n1 = k * y[7 * LANES + i], k * y[8 * LANES + i]
        across = n0 * n0 + n1 * n1
        b[ROOM * LANES + i] = min(b[ROOM * LANES + i], limit - across)
        n2 = np.sqrt(max(1.0 - across, 0.0))
        b[N * LANES + i] = (
            n0 * b[R * LANES + i] + n1 * b[(R + 3) * LANES + i] + n2 * b[(R + 6) * LANES + i]
        )
        b[(N + 1) * LANES + i] = (
            n0 * b[(R + 1) * LANES + i] + n1 * b[(R + 4) * LANES + i] + n2 * b[(R + 7) * LANES + i]
        )
        b[(N + 2) * LANES + i] = (
            n0 * b[(R + 2) * LANES + i] + n1 * b[(R + 5) * LANES + i] + n2 * b[(R + 8) * LANES + i]
        )


@lanes
def _belly(y, terrain, b):  # type: ignore[no-untyped-def]
    """A flat belly: n is fixed in the body, the contact is where the state has it."""
    q, center = terrain.rotation, terrain.center
    across, along = terrain.reach[0], terrain.reach[1]
    for a in range(3):
        for i in range(LANES):
            x0, x1 = y[7 * LANES + i], y[8 * LANES + i]
            b[(N + a) * LANES + i] = q[a, 2]
            b[(S + a) * LANES + i] = -(center[a] + q[a, 0] * x0 + q[a, 1] * x1)
    for i in range(LANES):
        x0, x1 = y[7 * LANES + i], y[8 * LANES + i]
        upright = (
            q[0, 2] * b[(R + 6) * LANES + i]
            + q[1, 2] * b[(R + 7) * LANES + i]
            + q[2, 2] * b[(R + 8) * LANES + i]
        )
        least = upright - np.sqrt(1.0 - terrain.limit)
        least = min(least, min(across - abs(x0), along - abs(x1)))
        b[ROOM * LANES + i] = min(b[ROOM * LANES + i], least)


@lanes
def _round(center, radius, b):  # type: ignore[no-untyped-def]
    for a in range(3):
        for i in range(LANES):
            b[(S + a) * LANES + i] = radius * b[(N + a) * LANES + i] - center[a]


@lanes
def _round_bend(radius, b):  # type: ignore[no-untyped-def]
    for i in range(LANES):
        n0, n1, n2 = b[N * LANES + i], b[(N + 1) * LANES + i], b[(N + 2) * LANES + i]
        b[H * LANES + i] = radius * (1.0 - n0 * n0)
        b[(H + 1) * LANES + i] = radius * (1.0 - n1 * n1)
        b[(H + 2) * LANES + i] = radius * (1.0 - n2 * n2)
        b[(H + 3) * LANES + i] = -radius * n0 * n1
        b[(H + 4) * LANES + i] = -radius * n0 * n2
        b[(H + 5) * LANES + i] = -radius * n1 * n2


@lanes
def _ellipsoids(center, terms, b):  # type: ignore[no-untyped-def]
    """x = c - sum A n/h, H = sum (A - e e^T)/h, see `bend_of`."""
    for a in range(3):
        for i in range(LANES):
            b[(S + a) * LANES + i] = -center[a]
    for a in range(6):
        for i in range(LANES):
            b[(H + a) * LANES + i] = 0.0
    for j in range(len(terms)):
        term = terms[j, 0], terms[j, 1], terms[j, 2], terms[j, 3], terms[j, 4], terms[j, 5]
        for i in range(LANES):
            n0, n1, n2 = b[N * LANES + i], b[(N + 1) * LANES + i], b[(N + 2) * LANES + i]
            e0, e1, e2, xx, yy, zz, xy, xz, yz = bend_of(term, n0, n1, n2)
            b[S * LANES + i] += e0
            b[(S + 1) * LANES + i] += e1
            b[(S + 2) * LANES + i] += e2
            b[H * LANES + i] += xx
            b[(H + 1) * LANES + i] += yy
            b[(H + 2) * LANES + i] += zz
            b[(H + 3) * LANES + i] += xy
            b[(H + 4) * LANES + i] += xz
            b[(H + 5) * LANES + i] += yz
