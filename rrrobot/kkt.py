"""KKT systems of constrained dynamics, M a + h = tau + J^T f with J a + gamma = 0; projectors."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import ConstraintError
from rrrobot.rotations import skew


class ConstraintRows(NamedTuple):
    """Rows of a constraint J a + drift = 0 at a state with J v = residual."""

    jacobian: Array
    """J (m, nv)"""
    drift: Array
    """gamma (m,) [m/s^2 or rad/s^2]"""
    residual: Array
    """J v (m,) [m/s or rad/s]; zero on the constraint"""


class KKTSystem(NamedTuple):
    """M a - J^T f = tau - h,  J a = -gamma, as one symmetric matrix; f are the multipliers."""

    matrix: Array
    """[[M, J^T], [J, 0]], shape (nv + m, nv + m)"""
    right: Array
    """(tau - h, -gamma), shape (nv + m,)"""
    nv: int


class KKTSolution(NamedTuple):
    """Acceleration and multipliers of a KKT system."""

    acceleration: Array
    """a (nv,)"""
    multipliers: Array
    """f (m,): J^T f is the generalised force of the constraints [N or N m]"""


def kkt_build(mass: Array, bias: Array, tau: Array, *rows: ConstraintRows) -> KKTSystem:
    """Assemble the KKT system of M a + h = tau + J^T f with J a + gamma = 0.

    Args:
        mass: M (nv, nv), symmetric positive definite.
        bias: h = C v + G (nv,).
        tau: applied generalised force (nv,).
        *rows: constraints.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> push = rr.drive.LegMotion(np.zeros(1), np.zeros(1), np.ones(1))
        >>> joint = rr.constraints.PrescribedJoints([0], nv=2)
        >>> rows = joint.evaluate(None, None, np.zeros(2), legs=push)
        >>> solution = rr.kkt_solve(rr.kkt_build(np.eye(2), np.zeros(2), np.zeros(2), rows))
        >>> solution.acceleration.tolist(), solution.multipliers.tolist()
        ([1.0, 0.0], [1.0])
    """
    nv = size = bias.shape[0]
    for row in rows:
        size += row.drift.shape[0]
    matrix = np.zeros((size, size))
    right = np.empty(size)
    matrix[:nv, :nv] = mass
    right[:nv] = tau - bias
    at = nv
    for jacobian, drift, _ in rows:
        end = at + drift.shape[0]
        matrix[at:end, :nv] = jacobian
        matrix[:nv, at:end] = jacobian.T
        right[at:end] = -drift
        at = end
    return KKTSystem(matrix, right, nv)


def kkt_solve(system: KKTSystem) -> KKTSolution:
    """Solve a KKT system.

    Raises:
        ConstraintError: it is singular: rows depend on each other.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> free = rr.kkt_build(2 * np.eye(2), np.zeros(2), np.array([1.0, 0.0]))
        >>> rr.kkt_solve(free).acceleration.tolist()
        [0.5, 0.0]
    """
    # LAPACK's LU solve of the transpose, which is the same symmetric matrix in its memory order.
    *_, solution, info = _lapack_solve()(system.matrix.T, system.right)
    if info > 0:
        raise ConstraintError(
            "the KKT matrix is singular: constraint rows depend on each other, or a freedom has "
            "no inertia. Leave a row out, or give every moving link a mass."
        )
    nv = system.nv
    return KKTSolution(solution[:nv], -solution[nv:])


@cache
def _lapack_solve() -> Callable[..., tuple[Array, Array, Array, int]]:
    """LAPACK's dgesv, a third of numpy.linalg.solve's time here. SciPy loads on first use."""
    from scipy.linalg.lapack import dgesv

    return dgesv


def rolling_null_space(contact: Array, nv: int) -> Array:
    """Closed-form basis N (nv, nv - 3) of the velocities of a free-flyer robot that roll.

    v = N u with u = (omega_body, joint velocities): the base's linear velocity is x cross
    omega, x = `contact` from the base's origin to the contact point in the base frame (3,) [m].

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> rr.kkt.rolling_null_space(np.array([0.0, 0.0, -0.12]), nv=8).shape
        (8, 5)
    """
    basis = np.zeros((nv, nv - 3))
    basis[3:] = np.eye(nv - 3)
    basis[:3, :3] = skew(contact)
    return basis


def rolling_projector(contact: Array, nv: int) -> Array:
    """Closed-form orthogonal projector P (nv, nv) onto the null space of the rolling rows.

    P = I - J^T (J J^T)^-1 J. In the base frame J = (I, -[x], 0) with x = `contact` as in
    `rolling_null_space`, so J J^T = (1 + |x|^2) I - x x^T, whose inverse is
    (I + x x^T) / (1 + |x|^2). Lengths in metres and angles in radians count alike.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> P = rr.kkt.rolling_projector(np.array([0.0, 0.0, -0.12]), nv=8)
        >>> bool(np.allclose(P @ P, P)), round(np.trace(P))
        (True, 5)
    """
    jacobian = np.zeros((3, nv))
    jacobian[:, :3] = np.eye(3)
    jacobian[:, 3:6] = -skew(contact)
    inverse = (np.eye(3) + np.outer(contact, contact)) / (1.0 + contact @ contact)
    return np.eye(nv) - jacobian.T @ inverse @ jacobian


def projected_acceleration(
    mass: Array, bias: Array, tau: Array, basis: Array, basis_rate_u: Array
) -> Array:
    """Acceleration (nv,) from the projected equations, without multipliers.

    N^T M N u_dot = N^T (tau - h - M N_dot u),  a = N u_dot + N_dot u.

    Args:
        mass: M (nv, nv).
        bias: h (nv,).
        tau: applied generalised force (nv,).
        basis: N (nv, nu), spanning the null space of J.
        basis_rate_u: N_dot u (nv,).

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> along_x = np.array([[1.0], [0.0]])
        >>> push = np.array([3.0, 5.0])
        >>> a = rr.kkt.projected_acceleration(np.eye(2), np.zeros(2), push, along_x, np.zeros(2))
        >>> a.tolist()
        [3.0, 0.0]
    """
    reduced = basis.T @ mass @ basis
    right = basis.T @ (tau - bias - mass @ basis_rate_u)
    return basis @ np.linalg.solve(reduced, right) + basis_rate_u
