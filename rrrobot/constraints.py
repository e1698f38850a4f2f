"""Constraints on acceleration: rolling contact, prescribed joints; KKT build and solve; projectors.

Rolling without slip of a shell with contact arm rho on a plane with unit normal n: the material
point of the shell at the contact stands still,

    v_c + Omega x rho = 0,        v_c, Omega: velocity of the shell's centre, angular velocity.

Along n this is the rate of the height, a holonomic constraint; the two tangent rows, eqs (2)-(3)
of the paper, are nonholonomic. As J v = 0 and, differentiated, J a + gamma = 0 with

    J = J_c - [rho] J_Omega,      gamma = a_c + alpha x rho + Omega x rho_dot   at zero v_dot,

a_c the classical (not spatial) acceleration of the centre. rho_dot is that of the contact point,
which moves over the body; for a sphere it is zero.

`contact_point`, `contact_jacobian` and `contact_drift` are plain functions of any Pinocchio model
with a round body; `RollingContact` is the same for repeated use.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.contact.surfaces import SHELL_FRAME, Surface, ground_basis
from rrrobot.errors import ConstraintError
from rrrobot.rotations import skew

_FRAME = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class ConstraintRows(NamedTuple):
    """Rows of a constraint J a + drift = 0 at a state with J v = residual."""

    jacobian: Array
    """J (m, nv)"""
    drift: Array
    """gamma (m,) [m/s^2 or rad/s^2]"""
    residual: Array
    """J v (m,) [m/s or rad/s]; zero on the constraint"""


class RollingContact:
    """No-slip rolling of a body's shell on a plane.

    Rows are along the columns (t1, t2, n) of `basis`; on level ground, along x, y and z. Rows 0
    and 1 are nonholonomic, row 2 is holonomic.

    Args:
        model: Pinocchio model.
        frame_id: frame of the shell's centre and axes.
        surface: the shell.
        normal: unit normal of the plane (3,).
        rows: which of the rows (0, 1, 2) to impose; all unless a model has fewer freedoms.

    Example:
        >>> import numpy as np, pinocchio as pin, rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> rolling = rr.RollingContact.of(robot)
        >>> q, v = pin.neutral(robot.model), np.zeros(robot.model.nv)
        >>> rolling.evaluate(robot.model.createData(), q, v).jacobian.shape
        (3, 8)
    """

    holonomic = np.array((False, False, True))

    def __init__(
        self,
        model: pin.Model,
        frame_id: int,
        surface: Surface,
        normal: ArrayLike = (0.0, 0.0, 1.0),
        *,
        rows: tuple[int, ...] = (0, 1, 2),
    ) -> None:
        self.model = model
        self.frame_id = frame_id
        self.surface = surface
        n = vector("normal", normal, 3)
        self.normal = n / np.linalg.norm(n)
        self.basis = ground_basis(self.normal)
        self.rows = rows
        self._rows = list(rows)
        self._project = self.basis.T[self._rows]
        self._level = bool(np.array_equal(self._project, np.eye(3)))
        self._still = np.zeros(model.nv)
        # The arm of a sphere is the same at every orientation.
        fixed = surface.fixed_arm(self.normal)
        self._fixed_arm = None if fixed is None else skew(fixed)

    @classmethod
    def of(cls, robot: Any) -> RollingContact:
        """Rolling contact of a `Robot` on its ground."""
        frame = robot.model.getFrameId(SHELL_FRAME)
        return cls(robot.model, frame, robot.shell, robot.ground_normal)

    def evaluate(self, data: pin.Data, q: Array, v: Array) -> ConstraintRows:
        """Jacobian, drift and residual at (q, v). Updates the kinematics in `data`."""
        model, frame_id = self.model, self.frame_id
        pin.forwardKinematics(model, data, q, v, self._still)
        spatial = pin.computeFrameJacobian(model, data, q, frame_id, _FRAME)
        placement = pin.updateFramePlacement(model, data, frame_id)
        acceleration = pin.getFrameClassicalAcceleration(model, data, frame_id, _FRAME)
        arm = self._fixed_arm
        if arm is None:
            rotation, omega = placement.rotation, spatial[3:] @ v
            arm = skew(self.surface.arm(rotation, self.normal))
            arm_rate = self.surface.arm_rate(rotation, omega, self.normal)
            drift = acceleration.linear - arm @ acceleration.angular + skew(omega) @ arm_rate
        else:
            drift = acceleration.linear - arm @ acceleration.angular
        jacobian = spatial[:3] - arm @ spatial[3:]
        if not self._level:
            jacobian, drift = self._project @ jacobian, self._project @ drift
        return ConstraintRows(jacobian, drift, jacobian @ v)

    def height(self, data: pin.Data) -> float:
        """Height of the shell's lowest point over the plane [m], after `evaluate`; zero on it."""
        placement = data.oMf[self.frame_id]
        arm = self.surface.arm(placement.rotation, self.normal)
        return float(self.normal @ (placement.translation + arm))

    def force(self, multipliers: Array) -> Array:
        """Contact force on the body in the world frame (3,) [N] of the rows' multipliers."""
        return self._project.T @ multipliers


class PrescribedJoints:
    """Joints that follow a given motion: v[index] = rate, a[index] = acceleration.

    Args:
        index: entries of v, shape (m,).
        nv: size of v.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> rr.PrescribedJoints(np.array([6, 7]), nv=8).jacobian.shape
        (2, 8)
    """

    def __init__(self, index: ArrayLike, nv: int) -> None:
        self.index = np.asarray(index, dtype=int)
        self.jacobian = np.zeros((self.index.size, nv))
        self.jacobian[np.arange(self.index.size), self.index] = 1.0

    def evaluate(self, v: Array, rate: Array, acceleration: Array) -> ConstraintRows:
        """Rows with drift -acceleration; the multipliers are the motors' efforts [N m or N]."""
        return ConstraintRows(self.jacobian, -acceleration, v[self.index] - rate)


def contact_point(
    model: pin.Model,
    q: Array,
    frame_id: int,
    surface: Surface,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    *,
    data: pin.Data | None = None,
) -> Array:
    """Lowest point of a body's shell against the normal, in the world (3,) [m].

    x_contact = x_centre + rho. For any Pinocchio model; `frame_id` is the shell's frame.

    Example:
        >>> import pinocchio as pin, rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> frame = robot.model.getFrameId("rrrobot_shell")
        >>> rr.contact_point(robot.model, pin.neutral(robot.model), frame, robot.shell).tolist()
        [0.0, 0.0, -0.12]
    """
    data = data or model.createData()
    n = np.asarray(normal, dtype=float)
    pin.forwardKinematics(model, data, q)
    placement = pin.updateFramePlacement(model, data, frame_id)
    return placement.translation + surface.arm(placement.rotation, n / np.linalg.norm(n))


def contact_jacobian(
    model: pin.Model,
    q: Array,
    frame_id: int,
    surface: Surface,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    *,
    data: pin.Data | None = None,
) -> Array:
    """Jacobian J (3, nv) with J v = velocity of the shell's material point at the contact [m/s].

    Rows along (t1, t2, n); x, y, z on level ground. J = J_c - [rho] J_Omega.

    Example:
        >>> import pinocchio as pin, rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> frame = robot.model.getFrameId("rrrobot_shell")
        >>> rr.contact_jacobian(robot.model, pin.neutral(robot.model), frame, robot.shell).shape
        (3, 8)
    """
    rolling = RollingContact(model, frame_id, surface, normal)
    return rolling.evaluate(data or model.createData(), q, np.zeros(model.nv)).jacobian


def contact_drift(
    model: pin.Model,
    q: Array,
    v: Array,
    frame_id: int,
    surface: Surface,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    *,
    data: pin.Data | None = None,
) -> Array:
    """Drift gamma (3,) [m/s^2]: rolling demands J a + gamma = 0 of the acceleration a.

    gamma = a_c + alpha x rho + Omega x rho_dot at v_dot = 0, so d(J v)/dt = J a + gamma at any v.

    Example:
        >>> import numpy as np, pinocchio as pin, rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> frame = robot.model.getFrameId("rrrobot_shell")
        >>> q, v = pin.neutral(robot.model), np.zeros(8)
        >>> rr.contact_drift(robot.model, q, v, frame, robot.shell).tolist()
        [0.0, 0.0, 0.0]
    """
    rolling = RollingContact(model, frame_id, surface, normal)
    return rolling.evaluate(data or model.createData(), q, v).drift


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
        >>> rows = rr.PrescribedJoints([0], nv=2).evaluate(np.zeros(2), np.zeros(1), np.ones(1))
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
        >>> rr.rolling_null_space(np.array([0.0, 0.0, -0.12]), nv=8).shape
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
        >>> P = rr.rolling_projector(np.array([0.0, 0.0, -0.12]), nv=8)
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
        >>> a = rr.projected_acceleration(np.eye(2), np.zeros(2), push, along_x, np.zeros(2))
        >>> a.tolist()
        [3.0, 0.0]
    """
    reduced = basis.T @ mass @ basis
    right = basis.T @ (tau - bias - mass @ basis_rate_u)
    return basis @ np.linalg.solve(reduced, right) + basis_rate_u
