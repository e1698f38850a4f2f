"""Sine, cosine and arctangent without branches, so that a loop over lanes becomes vector code.

The argument of a sine is reduced by multiples of pi/2, that of an arctangent to [0, 0.66] or so,
and polynomials do the rest: those of fdlibm (sine, cosine) and Cephes (arctangent). Errors are
about one unit in the last place of 1 for |angle| < 1e6.
"""

from __future__ import annotations

import numpy as np

from rrrobot.momentum.compiled import compiled

_OVER_HALF_PI = 2.0 / np.pi
# pi/2 in parts of 33 bits, whose multiples by a small whole number are exact.
_P1, _P2, _P3 = 1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624879595063154e-21
_EIGHTH_TURN, _QUARTER_TURN, _HALF_TURN = 0.25 * np.pi, 0.5 * np.pi, np.pi


@compiled(inline="always", fastmath={"contract", "nsz"})
def sine_cosine(x):  # type: ignore[no-untyped-def]
    """(sin x, cos x) of an angle [rad]."""
    k = np.floor(x * _OVER_HALF_PI + 0.5)
    r = ((x - k * _P1) - k * _P2) - k * _P3
    z = r * r
    s = -2.50507602534068634195e-08 + z * 1.58969099521155010221e-10
    s = -1.98412698298579493134e-04 + z * (2.75573137070700676789e-06 + z * s)
    s = -1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 + z * s)
    s = r + r * z * s
    c = 2.08757232129817482790e-09 + z * -1.13596475577881948265e-11
    c = 2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07 + z * c)
    c = 4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * c)
    c = (1.0 - 0.5 * z) + z * z * c
    # Quarter turns: odd ones exchange the two, some change the sign.
    odd = k - 2.0 * np.floor(0.5 * k)
    half = np.floor(0.5 * k)
    sign = 1.0 - 2.0 * (half - 2.0 * np.floor(0.5 * half))
    a = c if odd != 0.0 else s
    b = -s if odd != 0.0 else c
    return sign * a, sign * b


@compiled(inline="always", fastmath={"contract", "nsz"})
def arc_tangent(y, x):  # type: ignore[no-untyped-def]
    """Angle of the point (x, y), in [-pi, pi] [rad]; NaN at the origin."""
    a, b = abs(x), abs(y)
    steep = b > a
    low = a if steep else b
    high = b if steep else a
    near = low > 0.66 * high
    top = low - high if near else low
    bottom = low + high if near else high
    t = top / bottom
    z = t * t
    p = -7.500855792314704667340e1 + z * (
        -1.615753718733365076637e1 + z * -8.750608600031904122785e-1
    )
    p = -6.485021904942025371773e1 + z * (-1.228866684490136173410e2 + z * p)
    q = 1.650270098316988542046e2 + z * (2.485846490142306297962e1 + z)
    q = 1.945506571482613964425e2 + z * (
        4.853903996359136964868e2 + z * (4.328810604912902668951e2 + z * q)
    )
    angle = t + t * z * p / q
    angle = angle + _EIGHTH_TURN if near else angle
    angle = _QUARTER_TURN - angle if steep else angle
    angle = _HALF_TURN - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle
