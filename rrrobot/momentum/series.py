"""The engine's part of a shell by any support function: a polynomial of the direction's entries.

On unit vectors h = p_e + p_o, homogeneous polynomials of an even and an odd degree L; each extends
to degree one as p |u|^k with k = 1 - L, so that at |u| = 1

    grad h = grad p + k p u
    Hess h = Hess p + k (grad p u^T + u grad p^T) + p (k 1 + k (k - 2) u u^T)
"""

from __future__ import annotations

from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import inner, lanes
from rrrobot.momentum.lane import H, N, S

_SUMS = 10


@inner
def shell_series(terrain, b, first):  # type: ignore[no-untyped-def]
    """s and H of every lane; rows from `first` on are scratch."""
    top = int(max(terrain.degrees[0], terrain.degrees[1])) + 1
    _powers(b, first + 2 * _SUMS, top)
    even = terrain.even
    _sums(terrain.powers, terrain.weights, 0, even, b, first, first + 2 * _SUMS, top)
    last, second = len(terrain.weights), first + _SUMS
    _sums(terrain.powers, terrain.weights, even, last, b, second, first + 2 * _SUMS, top)
    _combine(terrain.center, 1.0 - terrain.degrees[0], 1.0 - terrain.degrees[1], b, first)


@lanes
def _powers(b, first, top):  # type: ignore[no-untyped-def]
    """u^0, u^1, ... of u = -n_b."""
    for a in range(3):
        row = first + a * top
        for i in range(LANES):
            b[row * LANES + i] = 1.0
        for e in range(1, top):
            for i in range(LANES):
                b[(row + e) * LANES + i] = -b[(N + a) * LANES + i] * b[(row + e - 1) * LANES + i]


@lanes
def _sums(powers, weights, begin, end, b, out, table, top):  # type: ignore[no-untyped-def]
    """Value, gradient and Hessian (xx, yy, zz, xy, xz, yz) of a sum of monomials."""
    for row in range(out, out + _SUMS):
        for i in range(LANES):
            b[row * LANES + i] = 0.0
    for m in range(begin, end):
        ex, ey, ez = powers[m, 0], powers[m, 1], powers[m, 2]
        x0, y0, z0 = table + ex, table + top + ey, table + 2 * top + ez
        x1, y1, z1 = x0 - min(ex, 1), y0 - min(ey, 1), z0 - min(ez, 1)
        x2, y2, z2 = x0 - min(ex, 2), y0 - min(ey, 2), z0 - min(ez, 2)
        w = weights[m]
        wx, wy, wz = w * ex, w * ey, w * ez
        wxx, wyy, wzz = wx * (ex - 1), wy * (ey - 1), wz * (ez - 1)
        for i in range(LANES):
            x, y, z = b[x0 * LANES + i], b[y0 * LANES + i], b[z0 * LANES + i]
            dx, dy, dz = b[x1 * LANES + i], b[y1 * LANES + i], b[z1 * LANES + i]
            b[out * LANES + i] += w * x * y * z
            b[(out + 1) * LANES + i] += wx * dx * y * z
            b[(out + 2) * LANES + i] += wy * x * dy * z
            b[(out + 3) * LANES + i] += wz * x * y * dz
            b[(out + 4) * LANES + i] += wxx * b[x2 * LANES + i] * y * z
            b[(out + 5) * LANES + i] += wyy * x * b[y2 * LANES + i] * z
            b[(out + 6) * LANES + i] += wzz * x * y * b[z2 * LANES + i]
            b[(out + 7) * LANES + i] += wx * ey * dx * dy * z
            b[(out + 8) * LANES + i] += wx * ez * dx * y * dz
            b[(out + 9) * LANES + i] += wy * ez * x * dy * dz


@lanes
def _combine(center, k_even, k_odd, b, first):  # type: ignore[no-untyped-def]
    """s = -x and H."""
    for a in range(3):
        for i in range(LANES):
            b[(S + a) * LANES + i] = -center[a]
    for a in range(6):
        for i in range(LANES):
            b[(H + a) * LANES + i] = 0.0
    for half in range(2):
        k, row = (k_even, first) if half == 0 else (k_odd, first + _SUMS)
        for i in range(LANES):
            u0, u1, u2 = -b[N * LANES + i], -b[(N + 1) * LANES + i], -b[(N + 2) * LANES + i]
            p, g0, g1, g2 = (
                b[row * LANES + i],
                b[(row + 1) * LANES + i],
                b[(row + 2) * LANES + i],
                b[(row + 3) * LANES + i],
            )
            kp = k * p
            far = kp * (k - 2.0)
            b[S * LANES + i] -= g0 + kp * u0
            b[(S + 1) * LANES + i] -= g1 + kp * u1
            b[(S + 2) * LANES + i] -= g2 + kp * u2
            b[H * LANES + i] += b[(row + 4) * LANES + i] + 2.0 * k * g0 * u0 + kp + far * u0 * u0
            b[(H + 1) * LANES + i] += (
                b[(row + 5) * LANES + i] + 2.0 * k * g1 * u1 + kp + far * u1 * u1
            )
            b[(H + 2) * LANES + i] += (
                b[(row + 6) * LANES + i] + 2.0 * k * g2 * u2 + kp + far * u2 * u2
            )
            b[(H + 3) * LANES + i] += (
                b[(row + 7) * LANES + i] + k * (g0 * u1 + g1 * u0) + far * u0 * u1
            )
            b[(H + 4) * LANES + i] += (
                b[(row + 8) * LANES + i] + k * (g0 * u2 + g2 * u0) + far * u0 * u2
            )
            b[(H + 5) * LANES + i] += (
                b[(row + 9) * LANES + i] + k * (g1 * u2 + g2 * u1) + far * u1 * u2
            )
