"""A function of the plane as a quintic spline with equal knots: smooth enough for a ground.

f is the sum of c[i, j] b(x / h - i) b(y / h - j) with the quintic B-spline b: four times
continuously differentiable, and the error of f'' falls with h^4. Table and weights are what the
compiled engine evaluates.
"""

from __future__ import annotations

import math
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


def _derivatives() -> Array:
    """Entry [d, j, p]: of t^p in the d-th derivative of weight j (3, 6, 6)."""
    found = np.zeros((3, _N, _N))
    found[0] = WEIGHTS
    for d in (1, 2):
        found[d, :, :-1] = found[d - 1, :, 1:] * np.arange(1, _N)
    return found


_DERIVATIVES = _derivatives()


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

    def values(self, at: Array) -> tuple[Array, Array]:
        """f (n,) and (f_x, f_y) (n, 2) at places (n, 2)."""
        where = (at - self.corner) / self.spacing
        cell = np.clip(np.floor(where), 0, np.array(self.table.shape) - _N).astype(int)
        blocks = np.lib.stride_tricks.sliding_window_view(self.table, (_N, _N))
        near = blocks[cell[:, 0], cell[:, 1]]
        powers = (where - cell)[..., None] ** np.arange(_N)
        x, y = np.moveaxis(powers @ _DERIVATIVES[0].T, 1, 0)
        dx, dy = np.moveaxis(powers @ _DERIVATIVES[1].T / self.spacing[:, None], 1, 0)
        across = np.einsum("nij,nj->ni", near, y)
        slope = np.sum(dx * across, axis=1), np.einsum("ni,nij,nj->n", x, near, dy)
        return np.sum(x * across, axis=1), np.column_stack(slope)

    def rows(self) -> Array:
        """The spline across each cell in y, as powers of u from 0 to 1 (knots in x, cells in y, 6).

        f = sum_j w_j(t) sum_q rows[i + j, k, q] u^q in the cell (i, k).
        """
        blocks = np.lib.stride_tricks.sliding_window_view(self.table, _N, axis=1)
        return np.ascontiguousarray(blocks @ WEIGHTS)

    def _near(self, at: Array) -> tuple[Array, Array, Array]:
        """Coefficients around a place, and the weights' derivatives 0, 1, 2 in x and y (3, 6)."""
        cells, weights = [], []
        for k in (0, 1):
            h = float(self.spacing[k])
            where = float(at[k] - self.corner[k]) / h
            cell = min(max(math.floor(where), 0), self.table.shape[k] - _N)
            t = where - cell
            powers = np.array((1.0, t, t * t, t**3, t**4, t**5))
            weights.append(_DERIVATIVES @ powers / np.array(((1.0,), (h,), (h * h,))))
            cells.append(cell)
        i, j = cells
        return self.table[i : i + _N, j : j + _N], weights[0], weights[1]


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
