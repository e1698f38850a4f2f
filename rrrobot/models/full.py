"""The full model: the robot rolls on the ground, eq (1) of the paper."""

from __future__ import annotations

from math import sqrt

import numpy as np

from rrrobot import serial
from rrrobot.checks import Array
from rrrobot.constraints import RollingContact
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.touching import contact_rate, coordinate_rates, touch, trouble
from rrrobot.drive.damping import DampingLike
from rrrobot.models.base import OWN, Model
from rrrobot.models.gravity import at_gravity, gravity_on
from rrrobot.models.terms import Placement
from rrrobot.robot.robot import Robot, checked_robot
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
    point in the ground's coordinates), with the body's angular velocity in the body frame as
    quasi-velocity. For a flat belly on a boulder the contact's place on the belly takes the place
    of that on the ground, which follows from the attitude.

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
        rolling = RollingContact.of(checked_robot(robot), ground)
        pin_model = at_gravity(robot.model, gravity_on(robot, ground))
        super().__init__(robot, pin_model, ground=ground, damping=damping, constraints=(rolling,))
        self._center = np.array(robot.shell_placement.translation)
        self._shell_rotation = np.array(robot.shell_placement.rotation)
        self._off_center = bool(np.any(self._center))
        self._fixed_arm = self._fixed_travel = None
        if isinstance(ground, Plane):
            self._tangents = np.array(ground.basis[:, :2])
            self._fixed_arm = fixed = robot.shell.fixed_arm(ground.normal_vector)
            self._fixed_travel = None if fixed is None else self._tangents.T @ skew(fixed)

    def make_pose(self, euler: Array, position: Array) -> Array:
        return np.concatenate((quaternion_from_euler(euler), position))

    def place(self, pose: Array) -> Placement:
        quaternion = pose[:4] / sqrt(pose[:4] @ pose[:4])
        rotation = rotation_from_quaternion(quaternion)
        contact, position, configuration = None, pose[4:], np.empty(7)
        if self._fixed_arm is None:
            robot, ground = self.robot, self.ground
            contact = touch(robot.shell, ground, rotation @ self._shell_rotation, position)
            arm, position = contact.arm, ground.coordinates(contact.point)
            configuration[:3] = contact.point - arm
        else:
            arm = self._fixed_arm
            configuration[:3] = self._tangents @ position - arm
        contact_in_base = arm @ rotation
        configuration[3:] = quaternion
        if self._off_center:
            contact_in_base += self._center
            configuration[:3] -= rotation @ self._center
        basis = _ANGULAR.copy()
        basis[:3] = skew(contact_in_base)
        return Placement(quaternion, position, rotation, configuration, basis, contact)

    def quaternions(self, poses: Array) -> Array:
        return poses[:, :4]

    def trouble(self, pose: Array) -> str | None:
        """Why the contact at a pose (n_pose,) is no longer one that rolls, or None."""
        if self._fixed_arm is not None:
            return None
        rotation = rotation_from_quaternion(pose[:4] / sqrt(pose[:4] @ pose[:4]))
        shell = rotation @ self._shell_rotation
        return trouble(self.robot.shell, self.ground, shell, pose[4:])

    def pose_rate(self, place: Placement, pose: Array, quasi: Array) -> Array:
        omega = place.rotation @ quasi
        rate = np.empty(6)
        rate[:4] = quaternion_rate(pose[:4], quasi)
        if self._fixed_travel is not None:
            rate[4:] = self._fixed_travel @ omega
        else:
            pair, shell = (self.robot.shell, self.ground), place.rotation @ self._shell_rotation
            contact = place.contact or touch(*pair, shell, pose[4:])
            moving = contact_rate(*pair, shell, omega, contact)
            rate[4:] = coordinate_rates(*pair, shell, contact, moving)
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
