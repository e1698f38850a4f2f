"""The full model: the robot rolls on the ground, eq (1) of the paper."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.constraints import RollingContact
from rrrobot.contact.kinematics import contact_velocity
from rrrobot.contact.surfaces import Sphere
from rrrobot.drive.damping import DampingLike
from rrrobot.errors import ModelError
from rrrobot.models.base import Model, Placement
from rrrobot.robot.robot import Robot
from rrrobot.rotations import (
    body_rates_matrix,
    body_rates_matrix_rate,
    euler_from_quaternion,
    euler_from_rotation,
    quaternion_from_euler,
    quaternion_rate,
    rotation_from_euler,
    rotation_from_quaternion,
    skew,
)

_ANGULAR = np.eye(6)[:, 3:]


class PaperEquations(NamedTuple):
    """Terms of eq (1) in the paper's coordinates (x, y, roll, pitch, yaw, legs...)."""

    mass_matrix: Array
    """M(q) (n, n), n = 5 + legs"""
    coriolis: Array
    """C(q, q_dot) (n, n); M_dot - 2 C is skew-symmetric"""
    gravity: Array
    """G(q) (n,)"""
    omega: Array
    """omega^1 and omega^2 of eqs (4)-(5), shape (2, n); eq (5) with its erratum corrected"""
    damping: Array
    """zeta (n,), eq (9)"""


class FullModel(Model):
    """The robot rolling without slip on its ground: M, C, G from Pinocchio, constraint by KKT.

        M(q) a + C(q, v) v + G(q) = tau + J^T f + zeta,      J a + gamma = 0

    Free-flyer coordinates: q and v of `robot.model`. The minimal state is (quaternion xyzw, contact
    point in the plane), with the body's angular velocity in the body frame as quasi-velocity.

    Args:
        robot: any `Robot`, with any strictly convex shell on any plane.
        damping: 0.01 N m s/rad on each Euler rate unless told otherwise, as the paper's eq (9);
            a number, three numbers (roll, pitch, yaw), a `Damping`, or None.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> t = rr.simulate(model, rr.gait("lateral"), duration=1.0)
        >>> t.euler.shape
        (101, 3)
    """

    name = "full"
    n_pose = 6
    n_quasi = 3

    def __init__(self, robot: Robot, *, damping: DampingLike = 0.01) -> None:
        super().__init__(robot, damping, robot.model, RollingContact.of(robot))
        self._tangents = np.array(RollingContact.of(robot).basis[:, :2])
        self._center = np.array(robot.shell_placement.translation)
        self._shell_rotation = np.array(robot.shell_placement.rotation)
        self._off_center = bool(np.any(self._center))
        self._fixed_arm = fixed = robot.shell.fixed_arm(robot.ground_normal)
        self._fixed_travel = None if fixed is None else self._tangents.T @ skew(fixed)
        self._nv = robot.model.nv

    def make_pose(self, euler: Array, position: Array) -> Array:
        return np.concatenate((quaternion_from_euler(euler), position))

    def place(self, pose: Array) -> Placement:
        quaternion = pose[:4] / sqrt(pose[:4] @ pose[:4])
        rotation = rotation_from_quaternion(quaternion)
        arm = self._arm(rotation) if self._fixed_arm is None else self._fixed_arm
        contact_in_base = arm @ rotation
        configuration = np.empty(7)
        configuration[:3] = self._tangents @ pose[4:] - arm
        configuration[3:] = quaternion
        if self._off_center:
            contact_in_base += self._center
            configuration[:3] -= rotation @ self._center
        basis = _ANGULAR.copy()
        basis[:3] = skew(contact_in_base)
        return Placement(quaternion, pose[4:], rotation, configuration, basis)

    def quaternions(self, poses: Array) -> Array:
        return poses[:, :4]

    def _arm(self, rotation: Array) -> Array:
        """Contact arm in the world (3,)."""
        return self.robot.shell.arm(rotation @ self._shell_rotation, self.robot.ground_normal)

    def pose_rate(self, place: Placement, pose: Array, quasi: Array) -> Array:
        omega = place.rotation @ quasi
        rate = np.empty(6)
        rate[:4] = quaternion_rate(pose[:4], quasi)
        if self._fixed_travel is not None:
            rate[4:] = self._fixed_travel @ omega
        else:
            robot, shell = self.robot, place.rotation @ self._shell_rotation
            travel = contact_velocity(robot.shell, shell, omega, robot.ground_normal)
            rate[4:] = travel @ self._tangents
        return rate

    def quasi_acceleration(self, acceleration: Array) -> Array:
        return acceleration[3:6]

    def body_velocity(self, place: Placement, quasi: Array) -> Array:
        return quasi

    def quasi_from_euler_rates(self, pose: Array, rates: Array) -> Array:
        roll, pitch, _ = euler_from_quaternion(pose[:4])
        return body_rates_matrix(roll, pitch) @ rates

    def damping_force(self, place: Placement, quasi: Array) -> Array:
        tau = np.zeros(6)
        roll, pitch, _ = euler_from_rotation(place.rotation)
        tau[3:] = self.damping.moment(roll, pitch, quasi)
        return tau

    def paper_equations(self, q: ArrayLike, q_dot: ArrayLike) -> PaperEquations:
        """The terms of eq (1) in the paper's coordinates.

            M q_ddot + C q_dot + G = tau + (lambda_1 omega^1)^T + (lambda_2 omega^2)^T + zeta

        Args:
            q: (x, y, roll, pitch, yaw, legs...), shape (5 + legs,) [m, rad]; (x, y) the contact
                point. Pinocchio's free-flyer velocity is v = T(q) q_dot with the height fixed.
            q_dot: its rate [m/s, rad/s]; it need not roll.

        Returns:
            M, C, G, (omega^1, omega^2) and zeta. The tangential contact force is lambda.

        Raises:
            ModelError: the shell is no sphere about the base's origin, or the ground not level.

        Example:
            >>> import numpy as np, rrrobot as rr
            >>> model = rr.FullModel(rr.Robot.from_parameters())
            >>> terms = model.paper_equations(np.zeros(7), np.zeros(7))
            >>> terms.omega[1].round(3).tolist()
            [0.0, 1.0, 0.12, -0.0, 0.0, 0.0, 0.0]
        """
        n = 5 + self.n_legs
        q, q_dot = vector("q", q, n), vector("q_dot", q_dot, n)
        radius = self._paper_radius()
        euler, rates = q[2:5], q_dot[2:5]
        (_, cp, cy), (_, _, sy) = np.cos(euler), np.sin(euler)
        rotation = rotation_from_euler(euler)
        matrix = body_rates_matrix(euler[0], euler[1])
        omega_body = matrix @ rates
        to_v, to_v_rate = np.zeros((self._nv, n)), np.zeros((self._nv, n))
        to_v[:3, :2] = rotation.T[:, :2]
        to_v_rate[:3, :2] = (-skew(omega_body) @ rotation.T)[:, :2]
        to_v[3:6, 2:5] = matrix
        to_v_rate[3:6, 2:5] = body_rates_matrix_rate(euler, rates)
        to_v[self.legs.v, 5 + np.arange(self.n_legs)] = 1.0

        configuration = self.configuration(self.make_pose(euler, q[:2]), q[5:])
        v = to_v @ q_dot
        mass, coriolis, gravity = self.equations(configuration, v)
        omega = np.zeros((2, n))
        omega[0, :5] = (1, 0, 0, 0, 0)
        omega[0, 2:4] = -radius * cp * sy, -radius * cy
        omega[1, :5] = (0, 1, 0, 0, 0)
        omega[1, 2:4] = radius * cp * cy, -radius * sy
        zeta = np.zeros(n)
        zeta[2:5] = matrix.T @ self.damping.moment(euler[0], euler[1], omega_body)
        zeta[5:] = -self.damping.leg_coefficient * q_dot[5:]
        return PaperEquations(
            to_v.T @ mass @ to_v,
            to_v.T @ (mass @ to_v_rate + coriolis @ to_v),
            to_v.T @ gravity,
            omega,
            zeta,
        )

    def _paper_radius(self) -> float:
        shell = self.robot.shell
        if (
            not isinstance(shell, Sphere)
            or np.any(self._center != 0)
            or self.robot.ground_normal[2] != 1.0
        ):
            raise ModelError(
                f"the paper's coordinates need a sphere about the root link's origin on level "
                f"ground; this robot has {shell} at {self._center.tolist()} m and the ground "
                f"normal {self.robot.ground_normal.tolist()}."
            )
        return shell.radius
