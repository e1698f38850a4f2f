"""The full model: the robot rolls on the ground, eq (1) of the paper."""

from __future__ import annotations

from math import sqrt

import numpy as np

from rrrobot import serial
from rrrobot.checks import Array
from rrrobot.constraints import RollingContact
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.kinematics import contact_velocity
from rrrobot.drive.damping import DampingLike
from rrrobot.models.base import OWN, Model
from rrrobot.models.gravity import at_gravity, gravity_on
from rrrobot.models.terms import Placement
from rrrobot.robot.robot import Robot
from rrrobot.rotations import (
    body_rates_matrix,
    euler_from_quaternion,
    euler_from_rotation,
    quaternion_from_euler,
    quaternion_rate,
    rotation_from_quaternion,
    skew,
)

_ANGULAR = np.eye(6)[:, 3:]


@serial.register("full")
class FullModel(Model):
    """The robot rolling without slip on its ground: M, C, G from Pinocchio, constraint by KKT.

        M(q) a + C(q, v) v + G(q) = tau + J^T f + zeta,      J a + gamma = 0

    Free-flyer coordinates: q and v of `robot.model`. The minimal state is (quaternion xyzw, contact
    point in the plane), with the body's angular velocity in the body frame as quasi-velocity.

    Args:
        robot: any `Robot`, with any strictly convex shell.
        ground: level ground unless given.
        damping: the robot's own unless told otherwise: for RRRobot 0.01 N m s/rad on each Euler
            rate, the paper's eq (9); none for a robot from a URDF. A number, three numbers (roll,
            pitch, yaw), a `Damping`, or None for no loss.

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

    def __init__(
        self, robot: Robot, *, ground: Ground | None = None, damping: DampingLike = OWN
    ) -> None:
        ground = Plane() if ground is None else ground
        rolling = RollingContact.of(robot, ground)
        pin_model = at_gravity(robot.model, gravity_on(robot, ground))
        super().__init__(robot, pin_model, ground=ground, damping=damping, constraints=(rolling,))
        self._normal = rolling.normal
        self._tangents = np.array(rolling.basis[:, :2])
        self._center = np.array(robot.shell_placement.translation)
        self._shell_rotation = np.array(robot.shell_placement.rotation)
        self._off_center = bool(np.any(self._center))
        self._fixed_arm = fixed = robot.shell.fixed_arm(self._normal)
        self._fixed_travel = None if fixed is None else self._tangents.T @ skew(fixed)

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
        return self.robot.shell.arm(rotation @ self._shell_rotation, self._normal)

    def pose_rate(self, place: Placement, pose: Array, quasi: Array) -> Array:
        omega = place.rotation @ quasi
        rate = np.empty(6)
        rate[:4] = quaternion_rate(pose[:4], quasi)
        if self._fixed_travel is not None:
            rate[4:] = self._fixed_travel @ omega
        else:
            robot, shell = self.robot, place.rotation @ self._shell_rotation
            travel = contact_velocity(robot.shell, shell, omega, self._normal)
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
