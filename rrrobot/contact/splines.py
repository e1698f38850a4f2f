"""A function of the plane as a quintic spline with equal knots: smooth enough for a ground.

f is the sum of c[i, j] b(x / h - i) b(y / h - j) with the quintic B-spline b: four times
continuously differentiable, and the error of f'' falls with h^4. Table and weights are what the
compiled engine evaluates.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from rrrobot.checks import Array

DEGREE = 5
_N = DEGREE + 1


def _weight_polynomials() -> Array:
    """Entry [j, p]: the coefficient of t^p in the weight of knot j of a cell, t in [0, 1]."""
    from math import comb, factorial

    found = np.zeros((_N, _N))
    for j in range(_N):
        # The cardinal B-spline, sum of (-1)^m C(6, m) (s - m)_+^5 / 5!, on s = t + DEGREE - j.
        for m in range(DEGREE - j + 1):
            shift = DEGREE - j - m
            for p in range(_N):
                power = float(shift) ** (DEGREE - p) * comb(DEGREE, p)
                found[j, p] += (-1) ** m * comb(_N, m) * power / factorial(DEGREE)
    return found


WEIGHTS = _weight_polynomials()
"""(6, 6): weight j of a cell is the sum over p of WEIGHTS[j, p] t^p."""


class Surface2(NamedTuple):
    """A quintic spline of two variables on equal cells."""

    corner: Array
    """(x, y) where the first cell begins (2,) [m]"""
    spacing: Array
    """of the cells in x and y (2,) [m]"""
    table: Array
    """c (cells in x + 5, cells in y + 5) [m]"""

    @property
    def upper(self) -> Array:
        """(x, y) where the last cell ends (2,) [m]."""
        return self.corner + self.spacing * (np.array(self.table.shape) - DEGREE)

    def holds(self, at: Array) -> bool:
        """Whether a place (2,) is on the cells."""
        return bool(np.all(at >= self.corner) and np.all(at <= self.upper))

    def value(self, at: Array) -> float:
        """f at a place (2,)."""
        block, x, y = self._near(at)
        return float(x[0] @ block @ y[0])

    def gradient(self, at: Array) -> Array:
        """(f_x, f_y) at a place (2,)."""
        block, x, y = self._near(at)
        return np.array((x[1] @ block @ y[0], x[0] @ block @ y[1]))

    def hessian(self, at: Array) -> Array:
        """Second derivatives (2, 2) at a place (2,)."""
        block, x, y = self._near(at)
        cross = x[1] @ block @ y[1]
        return np.array(((x[2] @ block @ y[0], cross), (cross, x[0] @ block @ y[2])))

    def rows(self) -> Array:
        """The spline across each cell in y, as powers of u from 0 to 1 (knots in x, cells in y, 6).

        f = sum_j w_j(t) sum_q rows[i + j, k, q] u^q in the cell (i, k).
        """
        blocks = np.lib.stride_tricks.sliding_window_view(self.table, _N, axis=1)
        return np.ascontiguousarray(blocks @ WEIGHTS)

    def _near(self, at: Array) -> tuple[Array, Array, Array]:
        """Coefficients around a place, and the weights' derivatives 0, 1, 2 in x and y (3, 6)."""
        where = (at - self.corner) / self.spacing
        last = np.array(self.table.shape) - _N
        cell = np.clip(np.floor(where), 0, last).astype(int)
        i, j = cell
        x, y = (_weights(t, h) for t, h in zip(where - cell, self.spacing, strict=True))
        return self.table[i : i + _N, j : j + _N], x, y


def _weights(t: float, spacing: float) -> Array:
    """Weights of a cell's six knots and their first two derivatives at t in [0, 1] (3, 6)."""
    p = np.arange(_N)
    powers = np.zeros((3, _N))
    powers[0] = t**p
    powers[1, 1:] = p[1:] * powers[0, :-1] / spacing
    powers[2, 2:] = p[2:] * (p[2:] - 1) * powers[0, :-2] / spacing**2
    return powers @ WEIGHTS.T


def fit(corner: Array, spacing: Array, values: Array) -> Surface2:
    """The spline through values (nx, ny) at the cells' corners; third derivatives end at zero.

    Args:
        corner: (x, y) of values[0, 0] (2,) [m].
        spacing: (2,) [m].
        values: at least 6 in each direction [m].
    """
    table = _along(_along(np.asarray(values, dtype=float)).T).T
    return Surface2(
        np.asarray(corner, float), np.asarray(spacing, float), np.ascontiguousarray(table)
    )


def _along(values: Array) -> Array:
    """Coefficients (n + 4, ...) of splines through values (n, ...) along the first axis."""
    from scipy.interpolate import make_interp_spline

    n = len(values)
    knots = np.arange(-DEGREE, n + DEGREE, dtype=float)
    flat = [(3, np.zeros(values.shape[1])), (4, np.zeros(values.shape[1]))]
    ends: Any = (flat, flat)
    spline = make_interp_spline(np.arange(n, dtype=float), values, k=DEGREE, t=knots, bc_type=ends)
    return np.asarray(spline.c)
