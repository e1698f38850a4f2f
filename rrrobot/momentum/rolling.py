"""The right-hand side of the contact momentum for any shell on any ground, in Numba.

With n_b the ground's normal, z_b the vertical, x the contact from the base's origin O and s = -x,
all in the base's axes, and the fifteen numbers of `coefficients.py` about O,

    K     = I_P w + L_rel + s x p_rel
    p     = M w x s + w x mc + p_rel
    K_dot = -w x K - g (M s + mc) x z_b - x_dot x p + damping
    x_dot = (1 + H G)^-1 H (w x n_b),      P_dot = R x_dot

The state is that of `kernels.py`; its x and y are the contact's coordinates on the ground, of a
flat belly those on the belly. The work of one evaluation is a few loops over lanes, chosen by the
kinds of shell and ground; between them lane's numbers are kept in rows of a scratch.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.common_pairs import (
    bent_on_plane,
    ellipsoid_on_plane,
    round_on_boulder,
    round_on_plane,
)
from rrrobot.momentum.compiled import lanes
from rrrobot.momentum.lane import DET, N_SCRATCH, ROOM, H, N, P, R, S, W, X, finish, velocity
from rrrobot.momentum.series import shell_series
from rrrobot.momentum.terrain import (
    BOULDER,
    ELLIPSOIDS,
    FLAT,
    GRAPH,
    ROUND,
    SLOPE,
)
from rrrobot.momentum.uneven import graph_normal, graph_rate


@njit(inline="always")
def rolling_rates(y, c, row, par, k, stage, terrain, b):  # type: ignore[no-untyped-def]
    """k = dy/dt for every lane; b is the scratch. The common pairs have a loop of their own."""
    if terrain.shell == ROUND and terrain.ground <= SLOPE:
        round_on_plane(y, c, row, par, k, stage, terrain.center, terrain.radius, terrain.basis)
    elif terrain.shell == ROUND and terrain.ground == BOULDER:
        round_on_boulder(
            y, c, row, par, k, stage, terrain.center, terrain.radius, terrain.curvature,
            terrain.limit, b,
        )  # fmt: skip
    elif terrain.shell == ELLIPSOIDS and terrain.ground <= SLOPE and len(terrain.terms) == 1:
        ellipsoid_on_plane(y, c, row, par, k, stage, terrain.center, terrain.terms, terrain.basis)
    else:
        evaluate_lanes(y, c, row, par, k, stage, terrain, b)


@njit(inline="always")
def evaluate_lanes(y, c, row, par, k, stage, terrain, b):  # type: ignore[no-untyped-def]
    """k = dy/dt, with w, p and x_dot of every lane left in the scratch."""
    touch_lanes(y, terrain, b)
    if terrain.ground <= SLOPE and terrain.shell != ROUND:
        bent_on_plane(y, c, row, par, k, stage, terrain.basis, b)
        return
    _momentum(y, c, row, par, b)
    if terrain.ground <= SLOPE:
        _rate_round(terrain.radius, 0.0, b)
    elif terrain.shell == FLAT:
        _rate_flat(1.0 / terrain.curvature, b)
    elif terrain.ground == BOULDER:
        if terrain.shell == ROUND:
            _rate_round(terrain.radius, terrain.curvature, b)
        else:
            _rate_boulder(terrain.curvature, b)
    else:
        graph_rate(b)
    _finish(y, c, row, par, k, stage, b)
    if terrain.shell == FLAT:
        _on_belly(terrain.rotation, b, k, stage)
    elif terrain.ground == SLOPE:
        _on_slope(terrain.basis, b, k, stage)
    else:
        _on_map(b, k, stage)


@njit(inline="always")
def touch_lanes(y, terrain, b):  # type: ignore[no-untyped-def]
    """R, n_b, s and, of shells that are not round, H of every lane."""
    _turns(y, b)
    if terrain.shell == FLAT:
        _belly(y, terrain, b)
        return
    if terrain.ground == SLOPE:
        _slope(terrain.basis, b)
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
        if len(terrain.terms) == 1:
            _ellipsoid(terrain.center, terrain.terms, b)
        else:
            _ellipsoids(terrain.center, terrain.terms, b)
    else:
        shell_series(terrain, b, N_SCRATCH)


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
def _slope(basis, b):  # type: ignore[no-untyped-def]
    n0, n1, n2 = basis[2, 0], basis[2, 1], basis[2, 2]
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
def _ellipsoid(center, terms, b):  # type: ignore[no-untyped-def]
    """x = c - A n/h, H = (A - e e^T)/h with h = sqrt(n.A n), e = A n/h."""
    xx, yy, zz = terms[0, 0], terms[0, 1], terms[0, 2]
    xy, xz, yz = terms[0, 3], terms[0, 4], terms[0, 5]
    c0, c1, c2 = center[0], center[1], center[2]
    for i in range(LANES):
        n0, n1, n2 = b[N * LANES + i], b[(N + 1) * LANES + i], b[(N + 2) * LANES + i]
        e0 = xx * n0 + xy * n1 + xz * n2
        e1 = xy * n0 + yy * n1 + yz * n2
        e2 = xz * n0 + yz * n1 + zz * n2
        over = 1.0 / np.sqrt(n0 * e0 + n1 * e1 + n2 * e2)
        e0, e1, e2 = over * e0, over * e1, over * e2
        b[S * LANES + i], b[(S + 1) * LANES + i], b[(S + 2) * LANES + i] = e0 - c0, e1 - c1, e2 - c2
        b[H * LANES + i], b[(H + 1) * LANES + i] = over * (xx - e0 * e0), over * (yy - e1 * e1)
        b[(H + 2) * LANES + i], b[(H + 3) * LANES + i] = (
            over * (zz - e2 * e2),
            over * (xy - e0 * e1),
        )
        b[(H + 4) * LANES + i], b[(H + 5) * LANES + i] = (
            over * (xz - e0 * e2),
            over * (yz - e1 * e2),
        )


@lanes
def _ellipsoids(center, terms, b):  # type: ignore[no-untyped-def]
    """Likewise, summed."""
    for a in range(3):
        for i in range(LANES):
            b[(S + a) * LANES + i] = -center[a]
    for a in range(6):
        for i in range(LANES):
            b[(H + a) * LANES + i] = 0.0
    for j in range(len(terms)):
        xx, yy, zz = terms[j, 0], terms[j, 1], terms[j, 2]
        xy, xz, yz = terms[j, 3], terms[j, 4], terms[j, 5]
        for i in range(LANES):
            n0, n1, n2 = b[N * LANES + i], b[(N + 1) * LANES + i], b[(N + 2) * LANES + i]
            e0 = xx * n0 + xy * n1 + xz * n2
            e1 = xy * n0 + yy * n1 + yz * n2
            e2 = xz * n0 + yz * n1 + zz * n2
            # A disc's or a rod's own share ends where its h does.
            square = n0 * e0 + n1 * e1 + n2 * e2
            over = 1.0 / np.sqrt(square) if square > 0.0 else 0.0
            e0, e1, e2 = over * e0, over * e1, over * e2
            b[S * LANES + i] += e0
            b[(S + 1) * LANES + i] += e1
            b[(S + 2) * LANES + i] += e2
            b[H * LANES + i] += over * (xx - e0 * e0)
            b[(H + 1) * LANES + i] += over * (yy - e1 * e1)
            b[(H + 2) * LANES + i] += over * (zz - e2 * e2)
            b[(H + 3) * LANES + i] += over * (xy - e0 * e1)
            b[(H + 4) * LANES + i] += over * (xz - e0 * e2)
            b[(H + 5) * LANES + i] += over * (yz - e1 * e2)


@lanes
def _momentum(y, c, row, par, b):  # type: ignore[no-untyped-def]
    """w and p of every lane."""
    for i in range(LANES):
        w0, w1, w2, p0, p1, p2 = velocity(
            y, c, row, par, i, b[S * LANES + i], b[(S + 1) * LANES + i], b[(S + 2) * LANES + i]
        )
        b[W * LANES + i], b[(W + 1) * LANES + i], b[(W + 2) * LANES + i] = w0, w1, w2
        b[P * LANES + i], b[(P + 1) * LANES + i], b[(P + 2) * LANES + i] = p0, p1, p2


@lanes
def _rate_round(radius, k, b):  # type: ignore[no-untyped-def]
    """x_dot = r w x n / (1 + k r)."""
    scale = radius / (1.0 + k * radius)
    for i in range(LANES):
        w0, w1, w2 = b[W * LANES + i], b[(W + 1) * LANES + i], b[(W + 2) * LANES + i]
        n0, n1, n2 = b[N * LANES + i], b[(N + 1) * LANES + i], b[(N + 2) * LANES + i]
        b[X * LANES + i] = scale * (w1 * n2 - w2 * n1)
        b[(X + 1) * LANES + i] = scale * (w2 * n0 - w0 * n2)
        b[(X + 2) * LANES + i] = scale * (w0 * n1 - w1 * n0)
    if k < 0.0:
        for i in range(LANES):
            b[DET * LANES + i] = min(b[DET * LANES + i], 1.0 + k * radius)


@lanes
def _rate_flat(radius, b):  # type: ignore[no-untyped-def]
    """x_dot = R w x n, R of the boulder."""
    for i in range(LANES):
        w0, w1, w2 = b[W * LANES + i], b[(W + 1) * LANES + i], b[(W + 2) * LANES + i]
        n0, n1, n2 = b[N * LANES + i], b[(N + 1) * LANES + i], b[(N + 2) * LANES + i]
        b[X * LANES + i] = radius * (w1 * n2 - w2 * n1)
        b[(X + 1) * LANES + i] = radius * (w2 * n0 - w0 * n2)
        b[(X + 2) * LANES + i] = radius * (w0 * n1 - w1 * n0)


@lanes
def _rate_plane(b):  # type: ignore[no-untyped-def]
    """x_dot = H (w x n)."""
    for i in range(LANES):
        w0, w1, w2 = b[W * LANES + i], b[(W + 1) * LANES + i], b[(W + 2) * LANES + i]
        n0, n1, n2 = b[N * LANES + i], b[(N + 1) * LANES + i], b[(N + 2) * LANES + i]
        y0, y1, y2 = w1 * n2 - w2 * n1, w2 * n0 - w0 * n2, w0 * n1 - w1 * n0
        b[X * LANES + i] = (
            b[H * LANES + i] * y0 + b[(H + 3) * LANES + i] * y1 + b[(H + 4) * LANES + i] * y2
        )
        b[(X + 1) * LANES + i] = (
            b[(H + 3) * LANES + i] * y0 + b[(H + 1) * LANES + i] * y1 + b[(H + 5) * LANES + i] * y2
        )
        b[(X + 2) * LANES + i] = (
            b[(H + 4) * LANES + i] * y0 + b[(H + 5) * LANES + i] * y1 + b[(H + 2) * LANES + i] * y2
        )


@lanes
def _rate_boulder(k, b):  # type: ignore[no-untyped-def]
    """x_dot = (H y + k D y)/(1 + k T + k^2 D), T = tr H, D the product of the principal radii."""
    for i in range(LANES):
        w0, w1, w2 = b[W * LANES + i], b[(W + 1) * LANES + i], b[(W + 2) * LANES + i]
        n0, n1, n2 = b[N * LANES + i], b[(N + 1) * LANES + i], b[(N + 2) * LANES + i]
        y0, y1, y2 = w1 * n2 - w2 * n1, w2 * n0 - w0 * n2, w0 * n1 - w1 * n0
        xx, yy, zz = b[H * LANES + i], b[(H + 1) * LANES + i], b[(H + 2) * LANES + i]
        xy, xz, yz = b[(H + 3) * LANES + i], b[(H + 4) * LANES + i], b[(H + 5) * LANES + i]
        product = xx * yy - xy * xy + xx * zz - xz * xz + yy * zz - yz * yz
        det = 1.0 + k * (xx + yy + zz + k * product)
        b[DET * LANES + i] = min(b[DET * LANES + i], det)
        over, kd = 1.0 / det, k * product
        b[X * LANES + i] = over * (xx * y0 + xy * y1 + xz * y2 + kd * y0)
        b[(X + 1) * LANES + i] = over * (xy * y0 + yy * y1 + yz * y2 + kd * y1)
        b[(X + 2) * LANES + i] = over * (xz * y0 + yz * y1 + zz * y2 + kd * y2)


@lanes
def _finish(y, c, row, par, k, stage, b):  # type: ignore[no-untyped-def]
    """Rates of the quaternion, of K and of yaw."""
    for i in range(LANES):
        finish(
            y, c, row, par, k, stage, i,
            b[(R + 6) * LANES + i], b[(R + 7) * LANES + i], b[(R + 8) * LANES + i],
            b[S * LANES + i], b[(S + 1) * LANES + i], b[(S + 2) * LANES + i],
            b[W * LANES + i], b[(W + 1) * LANES + i], b[(W + 2) * LANES + i],
            b[P * LANES + i], b[(P + 1) * LANES + i], b[(P + 2) * LANES + i],
            b[X * LANES + i], b[(X + 1) * LANES + i], b[(X + 2) * LANES + i],
        )  # fmt: skip


@lanes
def _on_belly(q, b, k, stage):  # type: ignore[no-untyped-def]
    for a in range(2):
        for i in range(LANES):
            moved = (
                q[0, a] * b[X * LANES + i]
                + q[1, a] * b[(X + 1) * LANES + i]
                + q[2, a] * b[(X + 2) * LANES + i]
            )
            k[stage, (7 + a) * LANES + i] = moved


@lanes
def _on_map(b, k, stage):  # type: ignore[no-untyped-def]
    for a in range(2):
        for i in range(LANES):
            r0, r1, r2 = (
                b[(R + 3 * a) * LANES + i],
                b[(R + 3 * a + 1) * LANES + i],
                b[(R + 3 * a + 2) * LANES + i],
            )
            k[stage, (7 + a) * LANES + i] = (
                r0 * b[X * LANES + i] + r1 * b[(X + 1) * LANES + i] + r2 * b[(X + 2) * LANES + i]
            )


@lanes
def _on_slope(basis, b, k, stage):  # type: ignore[no-untyped-def]
    for i in range(LANES):
        x0, x1, x2 = b[X * LANES + i], b[(X + 1) * LANES + i], b[(X + 2) * LANES + i]
        d0 = b[R * LANES + i] * x0 + b[(R + 1) * LANES + i] * x1 + b[(R + 2) * LANES + i] * x2
        d1 = b[(R + 3) * LANES + i] * x0 + b[(R + 4) * LANES + i] * x1 + b[(R + 5) * LANES + i] * x2
        d2 = b[(R + 6) * LANES + i] * x0 + b[(R + 7) * LANES + i] * x1 + b[(R + 8) * LANES + i] * x2
        for a in range(2):
            k[stage, (7 + a) * LANES + i] = basis[a, 0] * d0 + basis[a, 1] * d1 + basis[a, 2] * d2
