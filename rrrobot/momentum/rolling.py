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

from rrrobot.checks import Array
from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import inner, lanes
from rrrobot.momentum.series import shell_series
from rrrobot.momentum.terrain import (
    BOULDER,
    ELLIPSOIDS,
    FLAT,
    GRAPH,
    LEVEL,
    ROUND,
    SLOPE,
    Terrain,
)
from rrrobot.momentum.uneven import graph_normal, graph_rate

R, N, S, H, W, P, X, U, UP = 0, 9, 12, 15, 21, 24, 27, 30, 36
"""First rows of the scratch: R, n_b, s, H (xx, yy, zz, xy, xz, yz), w, p, x_dot, what a graph keeps
(f_x, f_y and Hess f/W), and two that stay: the least room to where the ground or its description
ends, and the least det(1 + H G), each negative once it has been."""
ROOM, DET = UP, UP + 1
N_SCRATCH = UP + 2


def scratch(terrain: Terrain) -> Array:
    """Room for the evaluations of LANES lanes (rows, LANES)."""
    top = int(terrain.degrees.max()) + 1
    return np.zeros((N_SCRATCH + (20 + 3 * top if terrain.weights.size else 0), LANES))


@inner
def rolling_rates(y, c, row, par, k, stage, terrain, b):  # type: ignore[no-untyped-def]
    """k = dy/dt for every lane; b is the scratch."""
    touch_lanes(y, terrain, b)
    _momentum(y, c, row, par, terrain.radius, b)
    if terrain.ground == LEVEL or terrain.ground == SLOPE:
        if terrain.shell == ROUND:
            _rate_round(terrain.radius, 0.0, b)
        else:
            _rate_plane(b)
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
    _travel(terrain, b, k, stage)


@inner
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
        b[R, i] = 1.0 - two * (v * v + z * z)
        b[R + 1, i] = two * (x * v - w * z)
        b[R + 2, i] = two * (x * z + w * v)
        b[R + 3, i] = two * (x * v + w * z)
        b[R + 4, i] = 1.0 - two * (x * x + z * z)
        b[R + 5, i] = two * (v * z - w * x)
        b[R + 6, i] = two * (x * z - w * v)
        b[R + 7, i] = two * (v * z + w * x)
        b[R + 8, i] = 1.0 - two * (x * x + v * v)


@lanes
def _level(b):  # type: ignore[no-untyped-def]
    for a in range(3):
        for i in range(LANES):
            b[N + a, i] = b[R + 6 + a, i]


@lanes
def _slope(basis, b):  # type: ignore[no-untyped-def]
    n0, n1, n2 = basis[2, 0], basis[2, 1], basis[2, 2]
    for a in range(3):
        for i in range(LANES):
            b[N + a, i] = n0 * b[R + a, i] + n1 * b[R + 3 + a, i] + n2 * b[R + 6 + a, i]


@lanes
def _boulder(y, k, limit, b):  # type: ignore[no-untyped-def]
    """n = (k x, k y, sqrt(1 - k^2 (x^2 + y^2)))."""
    for i in range(LANES):
        n0, n1 = k * y[7 * LANES + i], k * y[8 * LANES + i]
        across = n0 * n0 + n1 * n1
        b[ROOM, i] = min(b[ROOM, i], limit - across)
        n2 = np.sqrt(max(1.0 - across, 0.0))
        b[N, i] = n0 * b[R, i] + n1 * b[R + 3, i] + n2 * b[R + 6, i]
        b[N + 1, i] = n0 * b[R + 1, i] + n1 * b[R + 4, i] + n2 * b[R + 7, i]
        b[N + 2, i] = n0 * b[R + 2, i] + n1 * b[R + 5, i] + n2 * b[R + 8, i]


@lanes
def _belly(y, terrain, b):  # type: ignore[no-untyped-def]
    """A flat belly: n is fixed in the body, the contact is where the state has it."""
    q, center = terrain.rotation, terrain.center
    across, along = terrain.reach[0], terrain.reach[1]
    for a in range(3):
        for i in range(LANES):
            x0, x1 = y[7 * LANES + i], y[8 * LANES + i]
            b[N + a, i] = q[a, 2]
            b[S + a, i] = -(center[a] + q[a, 0] * x0 + q[a, 1] * x1)
    for i in range(LANES):
        x0, x1 = y[7 * LANES + i], y[8 * LANES + i]
        upright = q[0, 2] * b[R + 6, i] + q[1, 2] * b[R + 7, i] + q[2, 2] * b[R + 8, i]
        least = upright - np.sqrt(1.0 - terrain.limit)
        least = min(least, min(across - abs(x0), along - abs(x1)))
        b[ROOM, i] = min(b[ROOM, i], least)


@lanes
def _round(center, radius, b):  # type: ignore[no-untyped-def]
    for a in range(3):
        for i in range(LANES):
            b[S + a, i] = radius * b[N + a, i] - center[a]


@lanes
def _round_bend(radius, b):  # type: ignore[no-untyped-def]
    for i in range(LANES):
        n0, n1, n2 = b[N, i], b[N + 1, i], b[N + 2, i]
        b[H, i] = radius * (1.0 - n0 * n0)
        b[H + 1, i] = radius * (1.0 - n1 * n1)
        b[H + 2, i] = radius * (1.0 - n2 * n2)
        b[H + 3, i] = -radius * n0 * n1
        b[H + 4, i] = -radius * n0 * n2
        b[H + 5, i] = -radius * n1 * n2


@lanes
def _ellipsoid(center, terms, b):  # type: ignore[no-untyped-def]
    """x = c - A n/h, H = (A - e e^T)/h with h = sqrt(n.A n), e = A n/h."""
    xx, yy, zz = terms[0, 0], terms[0, 1], terms[0, 2]
    xy, xz, yz = terms[0, 3], terms[0, 4], terms[0, 5]
    c0, c1, c2 = center[0], center[1], center[2]
    for i in range(LANES):
        n0, n1, n2 = b[N, i], b[N + 1, i], b[N + 2, i]
        e0 = xx * n0 + xy * n1 + xz * n2
        e1 = xy * n0 + yy * n1 + yz * n2
        e2 = xz * n0 + yz * n1 + zz * n2
        over = 1.0 / np.sqrt(n0 * e0 + n1 * e1 + n2 * e2)
        e0, e1, e2 = over * e0, over * e1, over * e2
        b[S, i], b[S + 1, i], b[S + 2, i] = e0 - c0, e1 - c1, e2 - c2
        b[H, i], b[H + 1, i] = over * (xx - e0 * e0), over * (yy - e1 * e1)
        b[H + 2, i], b[H + 3, i] = over * (zz - e2 * e2), over * (xy - e0 * e1)
        b[H + 4, i], b[H + 5, i] = over * (xz - e0 * e2), over * (yz - e1 * e2)


@lanes
def _ellipsoids(center, terms, b):  # type: ignore[no-untyped-def]
    """Likewise, summed."""
    for a in range(3):
        for i in range(LANES):
            b[S + a, i] = -center[a]
    for a in range(6):
        for i in range(LANES):
            b[H + a, i] = 0.0
    for j in range(len(terms)):
        xx, yy, zz = terms[j, 0], terms[j, 1], terms[j, 2]
        xy, xz, yz = terms[j, 3], terms[j, 4], terms[j, 5]
        for i in range(LANES):
            n0, n1, n2 = b[N, i], b[N + 1, i], b[N + 2, i]
            e0 = xx * n0 + xy * n1 + xz * n2
            e1 = xy * n0 + yy * n1 + yz * n2
            e2 = xz * n0 + yz * n1 + zz * n2
            # A disc's or a rod's own share ends where its h does.
            square = n0 * e0 + n1 * e1 + n2 * e2
            over = 1.0 / np.sqrt(square) if square > 0.0 else 0.0
            e0, e1, e2 = over * e0, over * e1, over * e2
            b[S, i] += e0
            b[S + 1, i] += e1
            b[S + 2, i] += e2
            b[H, i] += over * (xx - e0 * e0)
            b[H + 1, i] += over * (yy - e1 * e1)
            b[H + 2, i] += over * (zz - e2 * e2)
            b[H + 3, i] += over * (xy - e0 * e1)
            b[H + 4, i] += over * (xz - e0 * e2)
            b[H + 5, i] += over * (yz - e1 * e2)


@lanes
def _momentum(y, c, row, par, radius, b):  # type: ignore[no-untyped-def]
    """w and p of every lane."""
    for i in range(LANES):
        m0, m1, m2 = c[row, i], c[row, LANES + i], c[row, 2 * LANES + i]
        p0, p1, p2 = c[row, 9 * LANES + i], c[row, 10 * LANES + i], c[row, 11 * LANES + i]
        mass = par[i]
        s0, s1, s2 = b[S, i], b[S + 1, i], b[S + 2, i]
        b0 = y[4 * LANES + i] - c[row, 12 * LANES + i] - (s1 * p2 - s2 * p1)
        b1 = y[5 * LANES + i] - c[row, 13 * LANES + i] - (s2 * p0 - s0 * p2)
        b2 = y[6 * LANES + i] - c[row, 14 * LANES + i] - (s0 * p1 - s1 * p0)
        # I_P = I + (2 s.mc + M s.s) 1 - (mc s^T + s mc^T) - M s s^T.
        whole = 2.0 * (m0 * s0 + m1 * s1 + m2 * s2) + mass * (s0 * s0 + s1 * s1 + s2 * s2)
        i00 = c[row, 3 * LANES + i] + whole - (2.0 * m0 + mass * s0) * s0
        i11 = c[row, 4 * LANES + i] + whole - (2.0 * m1 + mass * s1) * s1
        i22 = c[row, 5 * LANES + i] + whole - (2.0 * m2 + mass * s2) * s2
        i01 = c[row, 6 * LANES + i] - m0 * s1 - s0 * m1 - mass * s0 * s1
        i02 = c[row, 7 * LANES + i] - m0 * s2 - s0 * m2 - mass * s0 * s2
        i12 = c[row, 8 * LANES + i] - m1 * s2 - s1 * m2 - mass * s1 * s2
        a00 = i11 * i22 - i12 * i12
        a01 = i02 * i12 - i01 * i22
        a02 = i01 * i12 - i02 * i11
        a11 = i00 * i22 - i02 * i02
        a12 = i01 * i02 - i00 * i12
        a22 = i00 * i11 - i01 * i01
        over = 1.0 / (i00 * a00 + i01 * a01 + i02 * a02)
        w0 = over * (a00 * b0 + a01 * b1 + a02 * b2)
        w1 = over * (a01 * b0 + a11 * b1 + a12 * b2)
        w2 = over * (a02 * b0 + a12 * b1 + a22 * b2)
        b[W, i], b[W + 1, i], b[W + 2, i] = w0, w1, w2
        # M s + mc takes the place of both parts.
        t0, t1, t2 = mass * s0 + m0, mass * s1 + m1, mass * s2 + m2
        b[P, i] = p0 + w1 * t2 - w2 * t1
        b[P + 1, i] = p1 + w2 * t0 - w0 * t2
        b[P + 2, i] = p2 + w0 * t1 - w1 * t0


@lanes
def _rate_round(radius, k, b):  # type: ignore[no-untyped-def]
    """x_dot = r w x n / (1 + k r)."""
    scale = radius / (1.0 + k * radius)
    for i in range(LANES):
        w0, w1, w2 = b[W, i], b[W + 1, i], b[W + 2, i]
        n0, n1, n2 = b[N, i], b[N + 1, i], b[N + 2, i]
        b[X, i] = scale * (w1 * n2 - w2 * n1)
        b[X + 1, i] = scale * (w2 * n0 - w0 * n2)
        b[X + 2, i] = scale * (w0 * n1 - w1 * n0)
    if k < 0.0:
        for i in range(LANES):
            b[DET, i] = min(b[DET, i], 1.0 + k * radius)


@lanes
def _rate_flat(radius, b):  # type: ignore[no-untyped-def]
    """x_dot = R w x n, R of the boulder."""
    for i in range(LANES):
        w0, w1, w2 = b[W, i], b[W + 1, i], b[W + 2, i]
        n0, n1, n2 = b[N, i], b[N + 1, i], b[N + 2, i]
        b[X, i] = radius * (w1 * n2 - w2 * n1)
        b[X + 1, i] = radius * (w2 * n0 - w0 * n2)
        b[X + 2, i] = radius * (w0 * n1 - w1 * n0)


@lanes
def _rate_plane(b):  # type: ignore[no-untyped-def]
    """x_dot = H (w x n)."""
    for i in range(LANES):
        w0, w1, w2 = b[W, i], b[W + 1, i], b[W + 2, i]
        n0, n1, n2 = b[N, i], b[N + 1, i], b[N + 2, i]
        y0, y1, y2 = w1 * n2 - w2 * n1, w2 * n0 - w0 * n2, w0 * n1 - w1 * n0
        b[X, i] = b[H, i] * y0 + b[H + 3, i] * y1 + b[H + 4, i] * y2
        b[X + 1, i] = b[H + 3, i] * y0 + b[H + 1, i] * y1 + b[H + 5, i] * y2
        b[X + 2, i] = b[H + 4, i] * y0 + b[H + 5, i] * y1 + b[H + 2, i] * y2


@lanes
def _rate_boulder(k, b):  # type: ignore[no-untyped-def]
    """x_dot = (H y + k D y)/(1 + k T + k^2 D), T = tr H, D the product of the principal radii."""
    for i in range(LANES):
        w0, w1, w2 = b[W, i], b[W + 1, i], b[W + 2, i]
        n0, n1, n2 = b[N, i], b[N + 1, i], b[N + 2, i]
        y0, y1, y2 = w1 * n2 - w2 * n1, w2 * n0 - w0 * n2, w0 * n1 - w1 * n0
        xx, yy, zz = b[H, i], b[H + 1, i], b[H + 2, i]
        xy, xz, yz = b[H + 3, i], b[H + 4, i], b[H + 5, i]
        product = xx * yy - xy * xy + xx * zz - xz * xz + yy * zz - yz * yz
        det = 1.0 + k * (xx + yy + zz + k * product)
        b[DET, i] = min(b[DET, i], det)
        over, kd = 1.0 / det, k * product
        b[X, i] = over * (xx * y0 + xy * y1 + xz * y2 + kd * y0)
        b[X + 1, i] = over * (xy * y0 + yy * y1 + yz * y2 + kd * y1)
        b[X + 2, i] = over * (xz * y0 + yz * y1 + zz * y2 + kd * y2)


@lanes
def _finish(y, c, row, par, k, stage, b):  # type: ignore[no-untyped-def]
    """Rates of the quaternion, of K and of yaw."""
    for i in range(LANES):
        qx, qy, qz, qw = y[i], y[LANES + i], y[2 * LANES + i], y[3 * LANES + i]
        mass, g = par[i], par[3 * LANES + i]
        t0 = mass * b[S, i] + c[row, i]
        t1 = mass * b[S + 1, i] + c[row, LANES + i]
        t2 = mass * b[S + 2, i] + c[row, 2 * LANES + i]
        zx, zy, zz = b[R + 6, i], b[R + 7, i], b[R + 8, i]
        w0, w1, w2 = b[W, i], b[W + 1, i], b[W + 2, i]
        p0, p1, p2 = b[P, i], b[P + 1, i], b[P + 2, i]
        x0, x1, x2 = b[X, i], b[X + 1, i], b[X + 2, i]
        k0, k1, k2 = y[4 * LANES + i], y[5 * LANES + i], y[6 * LANES + i]
        f0 = -(w1 * k2 - w2 * k1) - g * (t1 * zz - t2 * zy) - (x1 * p2 - x2 * p1)
        f1 = -(w2 * k0 - w0 * k2) - g * (t2 * zx - t0 * zz) - (x2 * p0 - x0 * p2)
        f2 = -(w0 * k1 - w1 * k0) - g * (t0 * zy - t1 * zx) - (x0 * p1 - x1 * p0)
        # Euler rates, from sin pitch = -zx and cos pitch (sin roll, cos roll) = (zy, zz).
        over_cos = 1.0 / np.sqrt(zy * zy + zz * zz)
        sr, cr = zy * over_cos, zz * over_cos
        tp = -zx * over_cos
        about = sr * w1 + cr * w2
        yaw_rate = about * over_cos
        on_roll = -par[4 * LANES + i] * (w0 + tp * about)
        on_pitch = -par[5 * LANES + i] * (cr * w1 - sr * w2)
        lever = tp * on_roll - par[6 * LANES + i] * yaw_rate * over_cos
        euler = par[7 * LANES + i]
        body = 1.0 - euler
        f0 += euler * on_roll - body * par[4 * LANES + i] * w0
        f1 += euler * (sr * lever + cr * on_pitch) - body * par[5 * LANES + i] * w1
        f2 += euler * (cr * lever - sr * on_pitch) - body * par[6 * LANES + i] * w2
        k[stage, i] = 0.5 * (qw * w0 + qy * w2 - qz * w1)
        k[stage, LANES + i] = 0.5 * (qw * w1 + qz * w0 - qx * w2)
        k[stage, 2 * LANES + i] = 0.5 * (qw * w2 + qx * w1 - qy * w0)
        k[stage, 3 * LANES + i] = -0.5 * (qx * w0 + qy * w1 + qz * w2)
        k[stage, 4 * LANES + i], k[stage, 5 * LANES + i], k[stage, 6 * LANES + i] = f0, f1, f2
        k[stage, 9 * LANES + i] = yaw_rate


@inner
def _travel(terrain, b, k, stage):  # type: ignore[no-untyped-def]
    """Rates of the contact's coordinates."""
    if terrain.shell == FLAT:
        _on_belly(terrain.rotation, b, k, stage)
    elif terrain.ground == SLOPE:
        _on_slope(terrain.basis, b, k, stage)
    else:
        _on_map(b, k, stage)


@lanes
def _on_belly(q, b, k, stage):  # type: ignore[no-untyped-def]
    for a in range(2):
        for i in range(LANES):
            moved = q[0, a] * b[X, i] + q[1, a] * b[X + 1, i] + q[2, a] * b[X + 2, i]
            k[stage, (7 + a) * LANES + i] = moved


@lanes
def _on_map(b, k, stage):  # type: ignore[no-untyped-def]
    for a in range(2):
        for i in range(LANES):
            r0, r1, r2 = b[R + 3 * a, i], b[R + 3 * a + 1, i], b[R + 3 * a + 2, i]
            k[stage, (7 + a) * LANES + i] = r0 * b[X, i] + r1 * b[X + 1, i] + r2 * b[X + 2, i]


@lanes
def _on_slope(basis, b, k, stage):  # type: ignore[no-untyped-def]
    for i in range(LANES):
        x0, x1, x2 = b[X, i], b[X + 1, i], b[X + 2, i]
        d0 = b[R, i] * x0 + b[R + 1, i] * x1 + b[R + 2, i] * x2
        d1 = b[R + 3, i] * x0 + b[R + 4, i] * x1 + b[R + 5, i] * x2
        d2 = b[R + 6, i] * x0 + b[R + 7, i] * x1 + b[R + 8, i] * x2
        for a in range(2):
            k[stage, (7 + a) * LANES + i] = basis[a, 0] * d0 + basis[a, 1] * d1 + basis[a, 2] * d2
