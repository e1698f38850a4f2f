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

from numba import njit

from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.common_pairs import bent_on_plane
from rrrobot.momentum.compiled import lanes
from rrrobot.momentum.contacts import touch_lanes
from rrrobot.momentum.lane import DET, H, N, P, R, S, W, X, along_plane, finish, velocity
from rrrobot.momentum.terrain import BOULDER, FLAT, ROUND, SLOPE
from rrrobot.momentum.uneven import graph_rate


@njit(inline="always")
def evaluate_lanes(y, c, row, par, k, stage, terrain, b):  # type: ignore[no-untyped-def]
    """k = dy/dt, with w, p and x_dot of every lane left in the scratch."""
    touch_lanes(y, terrain, b)
    if terrain.ground <= SLOPE and terrain.shell != ROUND:
        bent_on_plane(y, c, row, par, k, stage, terrain.plane, b)
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
        _on_slope(terrain.plane, b, k, stage)
    else:
        _on_map(b, k, stage)


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
def _on_slope(plane, b, k, stage):  # type: ignore[no-untyped-def]
    for i in range(LANES):
        r = (
            b[R * LANES + i], b[(R + 1) * LANES + i], b[(R + 2) * LANES + i],
            b[(R + 3) * LANES + i], b[(R + 4) * LANES + i], b[(R + 5) * LANES + i],
        )  # fmt: skip
        along_plane(
            plane, k, stage, i, r,
            b[X * LANES + i], b[(X + 1) * LANES + i], b[(X + 2) * LANES + i],
        )  # fmt: skip
