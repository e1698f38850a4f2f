"""The single-axis models: roll and pitch roll on the ground, yaw is pivoted; eq (11)."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from rrrobot import serial
from rrrobot.checks import Array
from rrrobot.constraints import Constraint, RollingContact
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.surfaces import SHELL_FRAME
from rrrobot.drive.damping import DampingLike
from rrrobot.models.base import OWN, Model
from rrrobot.models.reduced import pivot_radius, reduced_model
from rrrobot.models.terms import Placement
from rrrobot.robot.robot import Robot
from rrrobot.robot.urdf import ReducedKind
from rrrobot.rotations import quaternion_from_euler, rotation_from_euler

_CHAINS: tuple[ReducedKind, ...] = ("roll", "pitch", "yaw")


class SingleAxisModel(Model):
    """A robot whose body turns about one axis only.

    The minimal state is (angle, contact point); the quasi-velocity is the angle's rate. A
    subclass names the axis and says how the body travels with the angle.
    """

    n_pose = 3
    n_quasi = 1
    axis: int

    row: int | None
    """which row of the rolling contact is left; None for a pivot without gravity"""

    def __init__(
        self, robot: Robot, *, ground: Ground | None = None, damping: DampingLike = OWN
    ) -> None:
        ground = Plane() if ground is None else ground
        kind = _CHAINS[self.axis]
        self.radius = pivot_radius(robot, kind, ground)
        model = reduced_model(robot, kind, ground, gravity=self.row is not None)
        constraints: tuple[Constraint, ...] = ()
        if self.row is not None:
            frame = model.getFrameId(SHELL_FRAME)
            constraints = (RollingContact(model, frame, robot.shell, ground, rows=(self.row,)),)
        super().__init__(robot, model, ground=ground, damping=damping, constraints=constraints)
        self._moving = np.flatnonzero(self.travel())
        self._basis = np.append(self.travel()[self._moving], 1.0)[:, None]

    @abstractmethod
    def travel(self) -> Array:
        """Contact point's velocity per unit of the angle's rate (2,) [m]."""

    @property
    def singular_at_vertical(self) -> bool:
        return False

    def make_pose(self, euler: Array, position: Array) -> Array:
        return np.array((euler[self.axis], *position), dtype=float)

    def place(self, pose: Array) -> Placement:
        euler = np.zeros(3)
        euler[self.axis] = pose[0]
        position = pose[1:]
        return Placement(
            quaternion_from_euler(euler),
            position,
            rotation_from_euler(euler),
            np.append(position[self._moving], pose[0]),
            self._basis,
        )

    def quaternions(self, poses: Array) -> Array:
        euler = np.zeros((len(poses), 3))
        euler[:, self.axis] = poses[:, 0]
        return quaternion_from_euler(euler)

    def pose_rate(self, place: Placement, pose: Array, quasi: Array) -> Array:
        return np.append(quasi, self.travel() * quasi)

    def quasi_acceleration(self, acceleration: Array) -> Array:
        last = 0 if self.row is None else 1
        return acceleration[last : last + 1]

    def body_velocity(self, place: Placement, quasi: Array) -> Array:
        omega = np.zeros(3)
        omega[self.axis] = quasi[0]
        return omega

    def quasi_from_euler_rates(self, pose: Array, rates: Array) -> Array:
        return rates[[self.axis]]

    def damping_force(self, place: Placement, quasi: Array) -> Array:
        angles = [0.0, 0.0, 0.0]
        angles[self.axis] = place.configuration[-1]
        moment = self.damping.moment(angles[0], angles[1], self.body_velocity(place, quasi))
        force = np.zeros(len(place.basis))
        force[-1] = moment[self.axis]
        return force


@serial.register("roll")
class RollModel(SingleAxisModel):
    """Rolls sideways: roll only, with the rolling contact; q = (travel y, roll, legs...).

    Args:
        robot: with a spherical shell, on level ground.
        ground: level; it gives the gravity.
        damping: the robot's own unless told otherwise: on RRRobot 0.01 N m s/rad.

    Example:
        >>> import rrrobot as rr
        >>> rr.RollModel(rr.Robot.from_parameters()).name
        'roll'
    """

    name = "roll"
    row = 1
    damped = (1, 0, 0)
    axis = 0
    axes = (0,)

    def travel(self) -> Array:
        return np.array((0.0, -self.radius))


@serial.register("pitch")
class PitchModel(SingleAxisModel):
    """Rolls forward: pitch only, with the rolling contact; q = (travel x, pitch, legs...).

    Args:
        robot: with a spherical shell, on level ground.
        ground: level; it gives the gravity.
        damping: the robot's own unless told otherwise: on RRRobot 0.01 N m s/rad.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.PitchModel(rr.Robot.from_parameters())
        >>> t = rr.simulate(model, rr.gait("lateral"), duration=1.0)
        >>> bool(abs(t.euler[:, 2]).max() == 0)
        True
    """

    name = "pitch"
    row = 0
    damped = (0, 1, 0)
    axis = 1
    axes = (1,)

    def travel(self) -> Array:
        return np.array((self.radius, 0.0))


@serial.register("yaw")
class YawModel(SingleAxisModel):
    """Turns about the vertical through its centre, without gravity; q = (yaw, legs...).

    Its mass matrix is eq (12), its momentum about the vertical is conserved, and with an
    impulsive start it is zero: eq (14), the kinematic reduction.

    Args:
        robot: with a spherical shell, on level ground.
        damping: none unless told otherwise.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.YawModel(rr.Robot.from_parameters())
        >>> model.mass_matrix(model.make_pose((0, 0, 0), (0, 0)), (0.0, 0.0)).shape
        (3, 3)
    """

    name = "yaw"
    row = None
    damped = (0, 0, 0)
    # Steps of 0.05 s would let the conserved momentum drift by 2e-12 kg m^2/s on RRRobot.
    max_step = 0.03
    axis = 2
    axes = (2,)

    def travel(self) -> Array:
        return np.zeros(2)
