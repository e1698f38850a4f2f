"""The engine's part of a graph z = f(x, y): its normal from a quintic spline, and the contact's rate.

With n = (-f_x, -f_y, 1)/W, F = Hess f and Hw = R H R^T,

    (1 - Hw[:2, :2] F/W) (x_dot, y_dot) = (R H (w x n_b))[:2],      z_dot = f_x x_dot + f_y y_dot

Rows of the scratch `b` are those of `rolling.py`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from rrrobot.contact.splines import DEGREE, WEIGHTS
from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import lanes

_R, _N, _H, _W, _X, _U, _ROOM, _DET = 0, 9, 15, 21, 27, 30, 36, 37
_N_KNOTS = DEGREE + 1
_WEIGHTS = WEIGHTS


@njit(inline="always")
def _weight(j, t, order):  # type: ignore[no-untyped-def]
    """Derivative 0, 1 or 2 of the weight of knot j at t."""
    c = _WEIGHTS[j]
    if order == 0:
        return c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
    if order == 1:
        return c[1] + t * (2.0 * c[2] + t * (3.0 * c[3] + t * (4.0 * c[4] + t * 5.0 * c[5])))
    return 2.0 * c[2] + t * (6.0 * c[3] + t * (12.0 * c[4] + t * 20.0 * c[5]))


@lanes
def graph_normal(y, corner, spacing, table, b):  # type: ignore[no-untyped-def]
    """n_b of every lane, and f_x, f_y and F/W."""
    hx, hy = 1.0 / spacing[0], 1.0 / spacing[1]
    last_x, last_y = table.shape[0] - _N_KNOTS, table.shape[1] - _N_KNOTS
    for i in range(LANES):
        at_x = (y[7 * LANES + i] - corner[0]) * hx
        at_y = (y[8 * LANES + i] - corner[1]) * hy
        room = min(min(at_x, last_x + 1 - at_x), min(at_y, last_y + 1 - at_y))
        b[_ROOM, i] = min(b[_ROOM, i], room)
        # A number that is not finite stays so through t.
        cell_x = int(min(max(np.floor(at_x), 0.0), float(last_x))) if room == room else 0
        cell_y = int(min(max(np.floor(at_y), 0.0), float(last_y))) if room == room else 0
        t, u = at_x - cell_x, at_y - cell_y
        y00, y01, y02 = _weight(0, u, 0), _weight(0, u, 1), _weight(0, u, 2)
        y10, y11, y12 = _weight(1, u, 0), _weight(1, u, 1), _weight(1, u, 2)
        y20, y21, y22 = _weight(2, u, 0), _weight(2, u, 1), _weight(2, u, 2)
        y30, y31, y32 = _weight(3, u, 0), _weight(3, u, 1), _weight(3, u, 2)
        y40, y41, y42 = _weight(4, u, 0), _weight(4, u, 1), _weight(4, u, 2)
        y50, y51, y52 = _weight(5, u, 0), _weight(5, u, 1), _weight(5, u, 2)
        fx, fy, fxx, fxy, fyy = 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(_N_KNOTS):
            r = table[cell_x + j]
            c0, c1, c2 = r[cell_y], r[cell_y + 1], r[cell_y + 2]
            c3, c4, c5 = r[cell_y + 3], r[cell_y + 4], r[cell_y + 5]
            g0 = c0 * y00 + c1 * y10 + c2 * y20 + c3 * y30 + c4 * y40 + c5 * y50
            g1 = c0 * y01 + c1 * y11 + c2 * y21 + c3 * y31 + c4 * y41 + c5 * y51
            g2 = c0 * y02 + c1 * y12 + c2 * y22 + c3 * y32 + c4 * y42 + c5 * y52
            x0, x1, x2 = _weight(j, t, 0), _weight(j, t, 1), _weight(j, t, 2)
            fx += x1 * g0
            fy += x0 * g1
            fxx += x2 * g0
            fxy += x1 * g1
            fyy += x0 * g2
        fx, fy = hx * fx, hy * fy
        over = 1.0 / np.sqrt(1.0 + fx * fx + fy * fy)
        b[_U, i], b[_U + 1, i] = fx, fy
        b[_U + 2, i], b[_U + 3, i] = over * hx * hx * fxx, over * hx * hy * fxy
        b[_U + 4, i] = over * hy * hy * fyy
        n0, n1 = -over * fx, -over * fy
        b[_N, i] = n0 * b[_R, i] + n1 * b[_R + 3, i] + over * b[_R + 6, i]
        b[_N + 1, i] = n0 * b[_R + 1, i] + n1 * b[_R + 4, i] + over * b[_R + 7, i]
        b[_N + 2, i] = n0 * b[_R + 2, i] + n1 * b[_R + 5, i] + over * b[_R + 8, i]


@lanes
def graph_rate(b):  # type: ignore[no-untyped-def]
    """x_dot of every lane."""
    for i in range(LANES):
        w0, w1, w2 = b[_W, i], b[_W + 1, i], b[_W + 2, i]
        n0, n1, n2 = b[_N, i], b[_N + 1, i], b[_N + 2, i]
        y0, y1, y2 = w1 * n2 - w2 * n1, w2 * n0 - w0 * n2, w0 * n1 - w1 * n0
        xx, yy, zz = b[_H, i], b[_H + 1, i], b[_H + 2, i]
        xy, xz, yz = b[_H + 3, i], b[_H + 4, i], b[_H + 5, i]
        r00, r01, r02 = b[_R, i], b[_R + 1, i], b[_R + 2, i]
        r10, r11, r12 = b[_R + 3, i], b[_R + 4, i], b[_R + 5, i]
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
        fxx, fxy, fyy = b[_U + 2, i], b[_U + 3, i], b[_U + 4, i]
        m00, m01 = 1.0 - (h00 * fxx + h01 * fxy), -(h00 * fxy + h01 * fyy)
        m10, m11 = -(h01 * fxx + h11 * fxy), 1.0 - (h01 * fxy + h11 * fyy)
        det = m00 * m11 - m01 * m10
        b[_DET, i] = min(b[_DET, i], det)
        over = 1.0 / det
        x, v = over * (m11 * right0 - m01 * right1), over * (m00 * right1 - m10 * right0)
        z = b[_U, i] * x + b[_U + 1, i] * v
        b[_X, i] = r00 * x + r10 * v + b[_R + 6, i] * z
        b[_X + 1, i] = r01 * x + r11 * v + b[_R + 7, i] * z
        b[_X + 2, i] = r02 * x + r12 * v + b[_R + 8, i] * z
