"""The commonest pairs of shell and ground in one loop over lanes each, which makes them fast.

A sphere and an ellipsoid on a plane, a sum of three on level ground, a sphere on a boulder, all
inlined into a step; and, after its contact, any other shell on a plane. See `rolling.py` for the
equations.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import lanes
from rrrobot.momentum.lane import (
    DET,
    ROOM,
    H,
    N,
    P,
    R,
    S,
    W,
    X,
    along_plane,
    bend_of,
    finish,
    in_body,
    in_world,
    normal_of,
    turn,
    velocity,
)


@njit(inline="always")
def round_on_plane(y, c, row, par, k, stage, center, radius, plane):  # type: ignore[no-untyped-def]
    """s = r n - c, x_dot = r w x n; P_dot = r Omega x n."""
    c0, c1, c2 = center[0], center[1], center[2]
    for i in range(LANES):
        r = turn(y, i)
        n0, n1, n2 = normal_of(plane, r)
        s0, s1, s2 = radius * n0 - c0, radius * n1 - c1, radius * n2 - c2
        w0, w1, w2, p0, p1, p2 = velocity(y, c, row, par, i, s0, s1, s2)
        x0, x1, x2 = (
            radius * (w1 * n2 - w2 * n1),
            radius * (w2 * n0 - w0 * n2),
            radius * (w0 * n1 - w1 * n0),
        )
        finish(
            y, c, row, par, k, stage, i, r[6], r[7], r[8], s0, s1, s2, w0, w1, w2, p0, p1, p2,
            x0, x1, x2,
        )  # fmt: skip
        along_plane(plane, k, stage, i, r, x0, x1, x2)


@njit(inline="always")
def round_on_boulder(  # type: ignore[no-untyped-def]
    y, c, row, par, k, stage, center, radius, curvature, limit, b
):
    """n = z + k P, x_dot = r w x n / (1 + k r)."""
    c0, c1, c2 = center[0], center[1], center[2]
    det = 1.0 + curvature * radius
    scale = radius / det
    if curvature < 0.0:
        for i in range(LANES):
            b[DET * LANES + i] = det
    for i in range(LANES):
        r = turn(y, i)
        b0, b1 = curvature * y[7 * LANES + i], curvature * y[8 * LANES + i]
        across = b0 * b0 + b1 * b1
        b[ROOM * LANES + i] = min(b[ROOM * LANES + i], limit - across)
        b2 = np.sqrt(max(1.0 - across, 0.0))
        n0, n1, n2 = in_body(r, b0, b1, b2)
        s0, s1, s2 = radius * n0 - c0, radius * n1 - c1, radius * n2 - c2
        w0, w1, w2, p0, p1, p2 = velocity(y, c, row, par, i, s0, s1, s2)
        x0, x1, x2 = (
            scale * (w1 * n2 - w2 * n1),
            scale * (w2 * n0 - w0 * n2),
            scale * (w0 * n1 - w1 * n0),
        )
        finish(
            y, c, row, par, k, stage, i, r[6], r[7], r[8], s0, s1, s2, w0, w1, w2, p0, p1, p2,
            x0, x1, x2,
        )  # fmt: skip
        k[stage, 7 * LANES + i], k[stage, 8 * LANES + i], _ = in_world(r, x0, x1, x2)


@njit(inline="always")
def ellipsoid_on_plane(y, c, row, par, k, stage, center, terms, plane):  # type: ignore[no-untyped-def]
    """s = e - c, x_dot = (A y - e (e.y))/h with e = A n/h and y = w x n."""
    c0, c1, c2 = center[0], center[1], center[2]
    xx, yy, zz = terms[0, 0], terms[0, 1], terms[0, 2]
    xy, xz, yz = terms[0, 3], terms[0, 4], terms[0, 5]
    for i in range(LANES):
        r = turn(y, i)
        n0, n1, n2 = normal_of(plane, r)
        e0, e1, e2 = (
            xx * n0 + xy * n1 + xz * n2,
            xy * n0 + yy * n1 + yz * n2,
            xz * n0 + yz * n1 + zz * n2,
        )
        over = 1.0 / np.sqrt(n0 * e0 + n1 * e1 + n2 * e2)
        e0, e1, e2 = over * e0, over * e1, over * e2
        s0, s1, s2 = e0 - c0, e1 - c1, e2 - c2
        w0, w1, w2, p0, p1, p2 = velocity(y, c, row, par, i, s0, s1, s2)
        y0, y1, y2 = w1 * n2 - w2 * n1, w2 * n0 - w0 * n2, w0 * n1 - w1 * n0
        ey = e0 * y0 + e1 * y1 + e2 * y2
        x0 = over * (xx * y0 + xy * y1 + xz * y2 - e0 * ey)
        x1 = over * (xy * y0 + yy * y1 + yz * y2 - e1 * ey)
        x2 = over * (xz * y0 + yz * y1 + zz * y2 - e2 * ey)
        finish(
            y, c, row, par, k, stage, i, r[6], r[7], r[8], s0, s1, s2, w0, w1, w2, p0, p1, p2,
            x0, x1, x2,
        )  # fmt: skip
        along_plane(plane, k, stage, i, r, x0, x1, x2)


@njit(inline="always")
def three_on_level(y, c, row, par, k, stage, center, terms):  # type: ignore[no-untyped-def]
    """Likewise of a sum of three ellipsoids, on level ground: s = sum e - c, x_dot = (sum H) y."""
    c0, c1, c2 = center[0], center[1], center[2]
    t0 = terms[0, 0], terms[0, 1], terms[0, 2], terms[0, 3], terms[0, 4], terms[0, 5]
    t1 = terms[1, 0], terms[1, 1], terms[1, 2], terms[1, 3], terms[1, 4], terms[1, 5]
    t2 = terms[2, 0], terms[2, 1], terms[2, 2], terms[2, 3], terms[2, 4], terms[2, 5]
    for i in range(LANES):
        r = turn(y, i)
        n0, n1, n2 = r[6], r[7], r[8]
        e0, e1, e2, axx, ayy, azz, axy, axz, ayz = bend_of(t0, n0, n1, n2)
        f0, f1, f2, bxx, byy, bzz, bxy, bxz, byz = bend_of(t1, n0, n1, n2)
        g0, g1, g2, dxx, dyy, dzz, dxy, dxz, dyz = bend_of(t2, n0, n1, n2)
        s0, s1, s2 = e0 + f0 + g0 - c0, e1 + f1 + g1 - c1, e2 + f2 + g2 - c2
        w0, w1, w2, p0, p1, p2 = velocity(y, c, row, par, i, s0, s1, s2)
        y0, y1, y2 = w1 * n2 - w2 * n1, w2 * n0 - w0 * n2, w0 * n1 - w1 * n0
        xy, xz, yz = axy + bxy + dxy, axz + bxz + dxz, ayz + byz + dyz
        x0 = (axx + bxx + dxx) * y0 + xy * y1 + xz * y2
        x1 = xy * y0 + (ayy + byy + dyy) * y1 + yz * y2
        x2 = xz * y0 + yz * y1 + (azz + bzz + dzz) * y2
        finish(
            y, c, row, par, k, stage, i, r[6], r[7], r[8], s0, s1, s2, w0, w1, w2, p0, p1, p2,
            x0, x1, x2,
        )  # fmt: skip
        along_plane(None, k, stage, i, r, x0, x1, x2)


@lanes
def bent_on_plane(y, c, row, par, k, stage, plane, b):  # type: ignore[no-untyped-def]
    """x_dot = H (w x n), of shells whose contact is in the scratch; leaves w, p, x_dot there."""
    for i in range(LANES):
        n0, n1, n2 = b[N * LANES + i], b[(N + 1) * LANES + i], b[(N + 2) * LANES + i]
        s0, s1, s2 = b[S * LANES + i], b[(S + 1) * LANES + i], b[(S + 2) * LANES + i]
        w0, w1, w2, p0, p1, p2 = velocity(y, c, row, par, i, s0, s1, s2)
        y0, y1, y2 = w1 * n2 - w2 * n1, w2 * n0 - w0 * n2, w0 * n1 - w1 * n0
        xx, yy, zz = b[H * LANES + i], b[(H + 1) * LANES + i], b[(H + 2) * LANES + i]
        xy, xz, yz = b[(H + 3) * LANES + i], b[(H + 4) * LANES + i], b[(H + 5) * LANES + i]
        x0, x1, x2 = (
            xx * y0 + xy * y1 + xz * y2,
            xy * y0 + yy * y1 + yz * y2,
            xz * y0 + yz * y1 + zz * y2,
        )
        b[W * LANES + i], b[(W + 1) * LANES + i], b[(W + 2) * LANES + i] = w0, w1, w2
        b[P * LANES + i], b[(P + 1) * LANES + i], b[(P + 2) * LANES + i] = p0, p1, p2
        b[X * LANES + i], b[(X + 1) * LANES + i], b[(X + 2) * LANES + i] = x0, x1, x2
        r = (
            b[R * LANES + i], b[(R + 1) * LANES + i], b[(R + 2) * LANES + i],
            b[(R + 3) * LANES + i], b[(R + 4) * LANES + i], b[(R + 5) * LANES + i],
            b[(R + 6) * LANES + i], b[(R + 7) * LANES + i], b[(R + 8) * LANES + i],
        )  # fmt: skip
        finish(
            y, c, row, par, k, stage, i, r[6], r[7], r[8], s0, s1, s2, w0, w1, w2, p0, p1, p2,
            x0, x1, x2,
        )  # fmt: skip
        along_plane(plane, k, stage, i, r, x0, x1, x2)
