"""One lane of a body on any ground: where its numbers stand, its velocity, its rates."""

from __future__ import annotations

import numpy as np
from numba import njit

from rrrobot.checks import Array
from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.terrain import Terrain

R, N, S, H, W, P, X, U, UP = 0, 9, 12, 15, 21, 24, 27, 30, 36
"""First rows of the scratch: R, n_b, s, H (xx, yy, zz, xy, xz, yz), w, p, x_dot, what a graph keeps
(f_x, f_y and Hess f/W), and two that stay: the least room to where the ground or its description
ends, and the least det(1 + H G), each negative once it has been."""
ROOM, DET = UP, UP + 1
N_SCRATCH = UP + 2
N_GRAPH = 1 + 36
"""Further rows that stay: the cell of a graph that a lane was last in, and of its table there."""


def scratch(terrain: Terrain | None) -> Array:
    """Room for the evaluations of LANES lanes: entry r of lane i at r LANES + i."""
    if terrain is None:
        return np.zeros(0)
    series = 20 + 3 * (int(terrain.degrees.max()) + 1)
    rows = np.zeros((N_SCRATCH + N_GRAPH + series, LANES))
    rows[N_SCRATCH] = -1.0  # no cell yet
    return rows.reshape(-1)


@njit(inline="always")
def turn(y, i):  # type: ignore[no-untyped-def]
    """R of lane i, row by row."""
    x, v, z, w = y[i], y[LANES + i], y[2 * LANES + i], y[3 * LANES + i]
    two = 2.0 / (x * x + v * v + z * z + w * w)
    return (
        1.0 - two * (v * v + z * z), two * (x * v - w * z), two * (x * z + w * v),
        two * (x * v + w * z), 1.0 - two * (x * x + z * z), two * (v * z - w * x),
        two * (x * z - w * v), two * (v * z + w * x), 1.0 - two * (x * x + v * v),
    )  # fmt: skip


@njit(inline="always")
def in_body(r, b0, b1, b2):  # type: ignore[no-untyped-def]
    """R^T b, of what `turn` gives."""
    return (
        b0 * r[0] + b1 * r[3] + b2 * r[6],
        b0 * r[1] + b1 * r[4] + b2 * r[7],
        b0 * r[2] + b1 * r[5] + b2 * r[8],
    )


@njit(inline="always")
def in_world(r, x0, x1, x2):  # type: ignore[no-untyped-def]
    """R x."""
    return (
        r[0] * x0 + r[1] * x1 + r[2] * x2,
        r[3] * x0 + r[4] * x1 + r[5] * x2,
        r[6] * x0 + r[7] * x1 + r[8] * x2,
    )


@njit(inline="always")
def omega(y, c, row, i, mass, m0, m1, m2, p0, p1, p2, s0, s1, s2):  # type: ignore[no-untyped-def]
    """w of lane i: I_P w = K - L_rel - s x p_rel."""
    b0 = y[4 * LANES + i] - c[row, 12 * LANES + i] - (s1 * p2 - s2 * p1)
    b1 = y[5 * LANES + i] - c[row, 13 * LANES + i] - (s2 * p0 - s0 * p2)
    b2 = y[6 * LANES + i] - c[row, 14 * LANES + i] - (s0 * p1 - s1 * p0)
    # I_P = I + (s.(mc + t)) 1 - (mc s^T + s t^T), with t = M s + mc; it is symmetric.
    t0, t1, t2 = mass * s0 + m0, mass * s1 + m1, mass * s2 + m2
    u0, u1, u2 = t0 + m0, t1 + m1, t2 + m2
    whole = s0 * u0 + s1 * u1 + s2 * u2
    i00 = c[row, 3 * LANES + i] + whole - s0 * u0
    i11 = c[row, 4 * LANES + i] + whole - s1 * u1
    i22 = c[row, 5 * LANES + i] + whole - s2 * u2
    i01 = c[row, 6 * LANES + i] - m0 * s1 - s0 * t1
    i02 = c[row, 7 * LANES + i] - m0 * s2 - s0 * t2
    i12 = c[row, 8 * LANES + i] - m1 * s2 - s1 * t2
    # The symmetric 3 x 3 system is solved by its adjugate.
    a00 = i11 * i22 - i12 * i12
    a01 = i02 * i12 - i01 * i22
    a02 = i01 * i12 - i02 * i11
    a11 = i00 * i22 - i02 * i02
    a12 = i01 * i02 - i00 * i12
    a22 = i00 * i11 - i01 * i01
    over = 1.0 / (i00 * a00 + i01 * a01 + i02 * a02)
    return (
        over * (a00 * b0 + a01 * b1 + a02 * b2),
        over * (a01 * b0 + a11 * b1 + a12 * b2),
        over * (a02 * b0 + a12 * b1 + a22 * b2),
    )


@njit(inline="always")
def velocity(y, c, row, par, i, s0, s1, s2):  # type: ignore[no-untyped-def]
    """w and p of lane i."""
    m0, m1, m2 = c[row, i], c[row, LANES + i], c[row, 2 * LANES + i]
    p0, p1, p2 = c[row, 9 * LANES + i], c[row, 10 * LANES + i], c[row, 11 * LANES + i]
    mass = par[i]
    w0, w1, w2 = omega(y, c, row, i, mass, m0, m1, m2, p0, p1, p2, s0, s1, s2)
    # M s + mc takes the place of both parts of p.
    t0, t1, t2 = mass * s0 + m0, mass * s1 + m1, mass * s2 + m2
    p0, p1, p2 = p0 + w1 * t2 - w2 * t1, p1 + w2 * t0 - w0 * t2, p2 + w0 * t1 - w1 * t0
    return w0, w1, w2, p0, p1, p2


@njit(inline="always")
def finish(  # type: ignore[no-untyped-def]
    y, c, row, par, k, stage, i, zx, zy, zz, s0, s1, s2, w0, w1, w2, p0, p1, p2, x0, x1, x2
):
    """Rates of the quaternion, of K and of yaw of lane i."""
    mass, g = par[i], par[3 * LANES + i]
    t0 = g * (mass * s0 + c[row, i])
    t1 = g * (mass * s1 + c[row, LANES + i])
    t2 = g * (mass * s2 + c[row, 2 * LANES + i])
    k0, k1, k2 = y[4 * LANES + i], y[5 * LANES + i], y[6 * LANES + i]
    f0 = -(w1 * k2 - w2 * k1) - (t1 * zz - t2 * zy) - (x1 * p2 - x2 * p1)
    f1 = -(w2 * k0 - w0 * k2) - (t2 * zx - t0 * zz) - (x2 * p0 - x0 * p2)
    f2 = -(w0 * k1 - w1 * k0) - (t0 * zy - t1 * zx) - (x0 * p1 - x1 * p0)
    brake(y, par, k, stage, i, zx, zy, zz, w0, w1, w2, f0, f1, f2)


@njit(inline="always")
def brake(y, par, k, stage, i, zx, zy, zz, w0, w1, w2, f0, f1, f2):  # type: ignore[no-untyped-def]
    """Rates of the quaternion and of yaw of lane i, and of K: a moment f and the damping."""
    qx, qy, qz, qw = y[i], y[LANES + i], y[2 * LANES + i], y[3 * LANES + i]
    # Euler rates, from sin pitch = -zx and cos pitch (sin roll, cos roll) = (zy, zz).
    over = 1.0 / (zy * zy + zz * zz)
    yaw_rate = over * (zy * w1 + zz * w2)
    euler, d1, d2 = par[7 * LANES + i], par[5 * LANES + i], par[6 * LANES + i]
    body, share = 1.0 - euler, euler * over
    on_roll = par[4 * LANES + i] * (w0 - euler * zx * yaw_rate)
    on_pitch = share * d1 * (zz * w1 - zy * w2)
    lever = share * (zx * on_roll - d2 * yaw_rate)
    f0 -= on_roll
    f1 += zy * lever - zz * on_pitch - body * d1 * w1
    f2 += zz * lever + zy * on_pitch - body * d2 * w2
    k[stage, i] = 0.5 * (qw * w0 + qy * w2 - qz * w1)
    k[stage, LANES + i] = 0.5 * (qw * w1 + qz * w0 - qx * w2)
    k[stage, 2 * LANES + i] = 0.5 * (qw * w2 + qx * w1 - qy * w0)
    k[stage, 3 * LANES + i] = -0.5 * (qx * w0 + qy * w1 + qz * w2)
    k[stage, 4 * LANES + i], k[stage, 5 * LANES + i], k[stage, 6 * LANES + i] = f0, f1, f2
    k[stage, 9 * LANES + i] = yaw_rate


@njit(inline="always")
def bend_of(term, n0, n1, n2):  # type: ignore[no-untyped-def]
    """e = A n/h and H = (A - e e^T)/h of an ellipsoid with h = sqrt(n.A n).

    Zero where a disc's or a rod's h ends: there its share of a sum does.
    """
    xx, yy, zz, xy, xz, yz = term
    e0, e1, e2 = (
        xx * n0 + xy * n1 + xz * n2,
        xy * n0 + yy * n1 + yz * n2,
        xz * n0 + yz * n1 + zz * n2,
    )
    square = n0 * e0 + n1 * e1 + n2 * e2
    over = 1.0 / np.sqrt(square) if square > 0.0 else 0.0
    e0, e1, e2 = over * e0, over * e1, over * e2
    return (
        e0, e1, e2, over * (xx - e0 * e0), over * (yy - e1 * e1), over * (zz - e2 * e2),
        over * (xy - e0 * e1), over * (xz - e0 * e2), over * (yz - e1 * e2),
    )  # fmt: skip


@njit(inline="always")
def normal_of(plane, r):  # type: ignore[no-untyped-def]
    """n_b of a plane, which is None if level: Numba leaves out the other branch."""
    if plane is None:
        return r[6], r[7], r[8]
    return in_body(r, plane[0], plane[1], plane[2])


@njit(inline="always")
def along_plane(plane, k, stage, i, r, x0, x1, x2):  # type: ignore[no-untyped-def]
    """Rates of a plane's coordinates, of P_dot = R x_dot; the plane as in `normal_of`."""
    d0 = r[0] * x0 + r[1] * x1 + r[2] * x2
    d1 = r[3] * x0 + r[4] * x1 + r[5] * x2
    if plane is None:
        k[stage, 7 * LANES + i], k[stage, 8 * LANES + i] = d0, d1
    else:
        k[stage, 7 * LANES + i] = plane[3] * d0 + plane[4] * d1
        k[stage, 8 * LANES + i] = plane[5] * d0 + plane[6] * d1
