"""M a = r + J^T f with J a = c where rows may repeat each other and links may have no mass.

The full KKT matrix is factorised; where it is regular that is the answer. Where it is not, by its
estimated condition, the rows are taken apart by their singular values: rows that repeat each other
and agree leave the motion determined and get the multipliers of least norm; rows that contradict
each other, and freedoms without inertia, are refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from math import isfinite
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import ConstraintError

_REGULAR = 1e-13
"""Reciprocal condition number of the KKT matrix above which it is regular."""
_RANK = 1e-9
"""Singular values below this part of the greatest are zero."""
_SURE = 1e-8
"""Pivot of J J^T, as a part of the greatest, above which the rows are independent."""
_AGREE = 1e-7
"""What dependent rows may differ by, as a part of the right-hand side's size."""


Where = Callable[[], str]


def solve(
    mass: Array, right: Array, jacobian: Array, target: Array, names: Sequence[str], where: Where
) -> tuple[Array, Array]:
    """Accelerations a (nv,) and multipliers f (m,) of M a - J^T f = right, J a = target.

    Args:
        mass: M (nv, nv), positive semi-definite.
        right: (nv,).
        jacobian: J (m, nv).
        target: (m,).
        names: of the rows (m,), for messages.
        where: the state in words, for messages.

    Raises:
        ConstraintError: rows contradict each other, or a freedom has no inertia.
    """
    nv, m = right.size, target.size
    matrix = np.zeros((nv + m, nv + m))
    matrix[:nv, :nv] = mass
    matrix[nv:, :nv] = jacobian
    matrix[:nv, nv:] = jacobian.T
    both = np.concatenate((right, target))
    lapack = _lapack()
    norm = lapack.dlange("1", matrix)
    if not isfinite(norm + float(both @ both)):
        raise ConstraintError(f"{where()}: the equations of motion are not finite.")
    # The matrix is symmetric, so its transpose, which is in LAPACK's order, is the same.
    lu, pivots, info = lapack.dgetrf(matrix.T, overwrite_a=True)
    if info == 0 and lapack.dgecon(lu, norm)[0] > _REGULAR:
        solution, _ = lapack.dgetrs(lu, pivots, both)
        return solution[:nv], -solution[nv:]
    return _apart(mass, right, jacobian, target, names, where)


def _apart(
    mass: Array, right: Array, jacobian: Array, target: Array, names: Sequence[str], where: Where
) -> tuple[Array, Array]:
    """The same by singular values."""
    rank, left, values, rows = decompose(jacobian)
    null = left[:, rank:]
    off = null.T @ target
    if np.any(np.abs(off) > _AGREE * max(1.0, float(np.abs(target).max(initial=0.0)))):
        raise ConstraintError(
            f"{where()}: the constraints {dependent(null, names)} depend on each other and "
            "contradict: no motion meets them. Keep the shape away from here, or leave one out."
        )
    meets = rows[:rank].T @ ((left[:, :rank].T @ target) / values[:rank])
    free = rows[rank:].T
    reduced = free.T @ mass @ free
    inertias, axes = np.linalg.eigh(reduced) if free.size else (np.ones(0), np.zeros((0, 0)))
    if inertias.size and inertias[0] <= 1e-13 * max(float(np.abs(mass).max()), 1e-300):
        raise ConstraintError(
            f"{where()}: the motion is undetermined: a freedom has no inertia. Give every moving "
            "link a mass or prescribe its joint."
        )
    a = meets + free @ (axes @ ((axes.T @ (free.T @ (right - mass @ meets))) / inertias))
    generalised = mass @ a - right
    f = left[:, :rank] @ ((rows[:rank] @ generalised) / values[:rank])
    return a, f


def decompose(jacobian: Array) -> tuple[int, Array, Array, Array]:
    """Rank, and U, s, V^T of a Jacobian (m, n)."""
    if jacobian.size == 0:
        m, n = jacobian.shape
        return 0, np.eye(m), np.zeros(0), np.eye(n)
    left, values, rows = np.linalg.svd(jacobian)
    rank = int(np.sum(values > _RANK * values[0])) if values[0] > 0 else 0
    return rank, left, values, rows


def meet(
    jacobian: Array, target: Array, names: Sequence[str], where: Where, tolerance: float
) -> Array:
    """The smallest x (n,) with J x = target.

    Raises:
        ConstraintError: nothing meets the rows to the tolerance.
    """
    rank, left, values, rows = decompose(jacobian)
    off = target - left[:, :rank] @ (left[:, :rank].T @ target)
    if np.any(np.abs(off) > tolerance):
        worst = float(np.abs(off).max())
        broken = dependent(left[:, rank:] * (left[:, rank:].T @ off), names)
        many = "," in broken
        raise ConstraintError(
            f"{where()}: the velocities break the constraint{'s' * many} {broken} by {worst:.3g}: "
            + (
                "these depend on each other here, so not all velocities can be met."
                if many
                else "give velocities that meet it."
            )
        )
    return np.asarray(rows[:rank].T @ ((left[:, :rank].T @ target) / values[:rank]))


def least(jacobian: Array, *targets: Array) -> list[Array]:
    """For each target (m,), the x (n,) of least norm with J x nearest to it."""
    lapack = _lapack()
    factor, info = lapack.dpotrf(jacobian @ jacobian.T)
    pivots = factor.diagonal()
    if info == 0 and pivots.min() ** 2 > _SURE * pivots.max() ** 2:
        return [jacobian.T @ lapack.dpotrs(factor, target)[0] for target in targets]
    inverse = np.linalg.pinv(jacobian, rcond=_RANK)
    return [inverse @ target for target in targets]


def dependent(null: Array, names: Sequence[str]) -> str:
    """Names of the rows that combinations (m, k) of rows which vanish are made of."""
    parts = np.abs(null).max(axis=1)
    return ", ".join(repr(n) for n, p in zip(names, parts, strict=True) if p > 1e-6)


@cache
def _lapack() -> Any:
    from scipy.linalg import lapack

    return lapack
