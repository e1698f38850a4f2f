"""The engine's part of a graph z = f(x, y): its normal by a quintic spline, the contact's rate.

With n = (-f_x, -f_y, 1)/W, F = Hess f and Hw = R H R^T,

    (1 - Hw[:2, :2] F/W) (x_dot, y_dot) = (R H (w x n_b))[:2],      z_dot = f_x x_dot + f_y y_dot

Rows of the scratch `b` are those of `rolling.py`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from rrrobot.contact.splines import DEGREE, WEIGHTS
from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import inner, lanes
from rrrobot.momentum.lane import DET, N_SCRATCH, ROOM, H, N, R, U, W, X

_N_KNOTS = DEGREE + 1
_WEIGHTS = WEIGHTS
_CELL, _ROWS = N_SCRATCH, N_SCRATCH + 1
"""Rows of the cell that a lane was last in, and of what the table has there: of knot j of the x
direction c_jq u^q at 6 j + q, with u from 0 to 1 across the cell in y."""


@njit(inline="always")
def _knot(b, j, t, u, i):  # type: ignore[no-untyped-def]
    """What knot j adds to f_x, f_y, f_xx, f_xy, f_yy, in units of the spacing."""
    at = (_ROWS + _N_KNOTS * j) * LANES + i
    c0, c1, c2 = b[at], b[at + LANES], b[at + 2 * LANES]
    c3, c4, c5 = b[at + 3 * LANES], b[at + 4 * LANES], b[at + 5 * LANES]
    g0 = c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
    g1 = c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * (5.0 * c5))))
    g2 = 2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * (20.0 * c5)))
    c0, c1, c2 = _WEIGHTS[j, 0], _WEIGHTS[j, 1], _WEIGHTS[j, 2]
    c3, c4, c5 = _WEIGHTS[j, 3], _WEIGHTS[j, 4], _WEIGHTS[j, 5]
    w0 = c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5))))
    w1 = c1 + t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + t * (5.0 * c5))))
    w2 = 2.0 * c2 + t * (6.0 * c3 + t * (12.0 * c4 + t * (20.0 * c5)))
    return w1 * g0, w0 * g1, w2 * g0, w1 * g1, w0 * g2


@lanes
def graph_normal(y, corner, spacing, table, b):  # type: ignore[no-untyped-def]
    """n_b of every lane, and f_x, f_y and F/W."""
    hx, hy = 1.0 / spacing[0], 1.0 / spacing[1]
    width = table.shape[1]
    last_x, last_y = float(table.shape[0] - _N_KNOTS), float(width - 1)
    for i in range(LANES):
        at_x = (y[7 * LANES + i] - corner[0]) * hx
        at_y = (y[8 * LANES + i] - corner[1]) * hy
        room = min(min(at_x, last_x + 1.0 - at_x), min(at_y, last_y + 1.0 - at_y))
        b[ROOM * LANES + i] = min(b[ROOM * LANES + i], room)
        cell_x = min(max(np.floor(at_x), 0.0), last_x)
        cell_y = min(max(np.floor(at_y), 0.0), last_y)
        b[U * LANES + i], b[(U + 1) * LANES + i] = at_x - cell_x, at_y - cell_y
        # A number that is not finite stays so through t, and looks up the first cell.
        b[(U + 2) * LANES + i] = cell_x * width + cell_y if room > -1e9 else 0.0
    _look_up(table.reshape(-1), _N_KNOTS * width, b)
    for i in range(LANES):
        t, u = b[U * LANES + i], b[(U + 1) * LANES + i]
        x0, y0, xx0, xy0, yy0 = _knot(b, 0, t, u, i)
        x1, y1, xx1, xy1, yy1 = _knot(b, 1, t, u, i)
        x2, y2, xx2, xy2, yy2 = _knot(b, 2, t, u, i)
        x3, y3, xx3, xy3, yy3 = _knot(b, 3, t, u, i)
        x4, y4, xx4, xy4, yy4 = _knot(b, 4, t, u, i)
        x5, y5, xx5, xy5, yy5 = _knot(b, 5, t, u, i)
        fx = hx * ((x0 + x1) + (x2 + x3) + (x4 + x5))
        fy = hy * ((y0 + y1) + (y2 + y3) + (y4 + y5))
        over = 1.0 / np.sqrt(1.0 + fx * fx + fy * fy)
        b[U * LANES + i], b[(U + 1) * LANES + i] = fx, fy
        b[(U + 2) * LANES + i] = over * hx * hx * ((xx0 + xx1) + (xx2 + xx3) + (xx4 + xx5))
        b[(U + 3) * LANES + i] = over * hx * hy * ((xy0 + xy1) + (xy2 + xy3) + (xy4 + xy5))
        b[(U + 4) * LANES + i] = over * hy * hy * ((yy0 + yy1) + (yy2 + yy3) + (yy4 + yy5))
        n0, n1 = -over * fx, -over * fy
        r6, r7, r8 = b[(R + 6) * LANES + i], b[(R + 7) * LANES + i], b[(R + 8) * LANES + i]
        b[N * LANES + i] = n0 * b[R * LANES + i] + n1 * b[(R + 3) * LANES + i] + over * r6
        b[(N + 1) * LANES + i] = (
            n0 * b[(R + 1) * LANES + i] + n1 * b[(R + 4) * LANES + i] + over * r7
        )
        b[(N + 2) * LANES + i] = (
            n0 * b[(R + 2) * LANES + i] + n1 * b[(R + 5) * LANES + i] + over * r8
        )


@inner
def _look_up(flat, stride, b):  # type: ignore[no-untyped-def]
    """Take from the table what it has of the cell of every lane that is in another than before."""
    for i in range(LANES):
        cell = b[(U + 2) * LANES + i]
        if cell != b[_CELL * LANES + i]:
            b[_CELL * LANES + i] = cell
            at, to = _N_KNOTS * int(cell), _ROWS * LANES + i
            for _ in range(_N_KNOTS):
                for q in range(_N_KNOTS):
                    b[to + q * LANES] = flat[at + q]
                at += stride
                to += _N_KNOTS * LANES


@lanes
def graph_rate(b):  # type: ignore[no-untyped-def]
    """x_dot of every lane."""
    for i in range(LANES):
        w0, w1, w2 = b[W * LANES + i], b[(W + 1) * LANES + i], b[(W + 2) * LANES + i]
        n0, n1, n2 = b[N * LANES + i], b[(N + 1) * LANES + i], b[(N + 2) * LANES + i]
        y0, y1, y2 = w1 * n2 - w2 * n1, w2 * n0 - w0 * n2, w0 * n1 - w1 * n0
        xx, yy, zz = b[H * LANES + i], b[(H + 1) * LANES + i], b[(H + 2) * LANES + i]
        xy, xz, yz = b[(H + 3) * LANES + i], b[(H + 4) * LANES + i], b[(H + 5) * LANES + i]
        r00, r01, r02 = b[R * LANES + i], b[(R + 1) * LANES + i], b[(R + 2) * LANES + i]
        r10, r11, r12 = b[(R + 3) * LANES + i], b[(R + 4) * LANES + i], b[(R + 5) * LANES + i]
        # H R^T's first two columns.
        a0 = xx * r00 + xy * r01 + xz * r02
        a1 = xy * r00 + yy * r01 + yz * r02
        a2 = xz * r00 + yz * r01 + zz * r02
        d0 = xx * r10 + xy * r11 + xz * r12
        d1 = xy * r10 + yy * r11 + yz * r12
        d2 = xz * r10 + yz * r11 + zz * r12
        h00 = r00 * a0 + r01 * a1 + r02 * a2
        h01 = r10 * a0 + r11 * a1 + r12 * a2
        h11 = r10 * d0 + r11 * d1 + r12 * d2
        right0, right1 = a0 * y0 + a1 * y1 + a2 * y2, d0 * y0 + d1 * y1 + d2 * y2
        fxx, fxy, fyy = b[(U + 2) * LANES + i], b[(U + 3) * LANES + i], b[(U + 4) * LANES + i]
        m00, m01 = 1.0 - (h00 * fxx + h01 * fxy), -(h00 * fxy + h01 * fyy)
        m10, m11 = -(h01 * fxx + h11 * fxy), 1.0 - (h01 * fxy + h11 * fyy)
        det = m00 * m11 - m01 * m10
        b[DET * LANES + i] = min(b[DET * LANES + i], det)
        over = 1.0 / det
        x, v = over * (m11 * right0 - m01 * right1), over * (m00 * right1 - m10 * right0)
        z = b[U * LANES + i] * x + b[(U + 1) * LANES + i] * v
        b[X * LANES + i] = r00 * x + r10 * v + b[(R + 6) * LANES + i] * z
        b[(X + 1) * LANES + i] = r01 * x + r11 * v + b[(R + 7) * LANES + i] * z
        b[(X + 2) * LANES + i] = r02 * x + r12 * v + b[(R + 8) * LANES + i] * z
