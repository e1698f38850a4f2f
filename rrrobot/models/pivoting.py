"""The pivoting model: the body turns about its fixed centre, eq (6) of the paper."""

from __future__ import annotations

import numpy as np

from rrrobot import serial
from rrrobot.checks import Array
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.kinematics import sphere_contact_rate
from rrrobot.drive.damping import DampingLike
from rrrobot.models.base import OWN, Model
from rrrobot.models.reduced import pivot_radius, reduced_model
from rrrobot.models.terms import Placement
from rrrobot.robot.robot import Robot
from rrrobot.rotations import (
    body_rates_matrix,
    quaternion_from_euler,
    rotation_from_euler,
)


@serial.register("pivoting")
class PivotingModel(Model):
    """The body on a spherical joint at the shell's centre; its rotation is then rolled out.

        M(q) q_ddot + C(q, q_dot) q_dot + G(q) = tau + zeta,   q = (yaw, pitch, roll, legs...)

    The contact point follows from the rotation by eqs (2)-(3), integrated along, and has no
    influence on it. `contact_force` of its trajectories is the pivot's reaction.

    Args:
        robot: with a spherical shell, on level ground.
        ground: level; it gives the gravity.
        damping: the robot's own unless told otherwise: on RRRobot 0.01 N m s/rad on the roll and
            pitch rates, none on yaw, as eq (10); see `FullModel`.

    Raises:
        ModelError: the robot has another shell, or the ground is not level.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.PivotingModel(rr.Robot.from_parameters())
        >>> model.mass_matrix(model.make_pose((0, 0, 0), (0, 0)), (1.57, 1.57)).shape
        (5, 5)
    """

    name = "pivoting"
    damped = (1, 1, 0)
    n_pose = 5
    n_quasi = 3

    def __init__(
        self, robot: Robot, *, ground: Ground | None = None, damping: DampingLike = OWN
    ) -> None:
        ground = Plane() if ground is None else ground
        self.radius = pivot_radius(robot, self.name, ground)
        pin_model = reduced_model(robot, "pivoting", ground)
        super().__init__(robot, pin_model, ground=ground, damping=damping)

    @property
    def singular_at_vertical(self) -> bool:
        return True

    def make_pose(self, euler: Array, position: Array) -> Array:
        roll, pitch, yaw = euler
        return np.array((yaw, pitch, roll, *position), dtype=float)

    def place(self, pose: Array) -> Placement:
        euler = pose[2::-1]
        return Placement(
            quaternion_from_euler(euler), pose[3:], rotation_from_euler(euler), pose[:3], np.eye(3)
        )

    def quaternions(self, poses: Array) -> Array:
        return quaternion_from_euler(poses[:, 2::-1])

    def pose_rate(self, place: Placement, pose: Array, quasi: Array) -> Array:
        return np.concatenate((quasi, sphere_contact_rate(self.radius, pose[2::-1], quasi[::-1])))

    def quasi_acceleration(self, acceleration: Array) -> Array:
        return acceleration[:3]

    def body_velocity(self, place: Placement, quasi: Array) -> Array:
        _, pitch, roll = place.configuration.tolist()
        return body_rates_matrix(roll, pitch) @ quasi[::-1]

    def quasi_from_euler_rates(self, pose: Array, rates: Array) -> Array:
        return rates[::-1].copy()

    def damping_force(self, place: Placement, quasi: Array) -> Array:
        _, pitch, roll = place.configuration.tolist()
        matrix = body_rates_matrix(roll, pitch)
        moment = self.damping.moment(roll, pitch, matrix @ quasi[::-1])
        return (matrix.T @ moment)[::-1]
