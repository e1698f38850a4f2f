"""The paper's second simplification: three single-axis models, recombined by rolling.

The roll, pitch and yaw models run side by side under the same gait; their angles together make the
body's rotation, and eqs (2)-(3) the path of the contact point. All are one system of equations for
the integrator, so the path is as accurate as the angles.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import Array
from rrrobot.contact.kinematics import sphere_contact_rate
from rrrobot.drive.gaits import LegMotion
from rrrobot.errors import GaitError, ModelError
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.models.reduced import pivot_radius
from rrrobot.models.single_axis import PitchModel, RollModel, SingleAxisModel, YawModel
from rrrobot.models.terms import Dynamics, Placement
from rrrobot.robot.robot import Robot
from rrrobot.rotations import (
    body_rates_matrix,
    body_rates_matrix_rate,
    quaternion_from_euler,
    rotation_from_euler,
)

_KINDS: tuple[type[SingleAxisModel], ...] = (RollModel, PitchModel, YawModel)


@serial.register("decoupled")
class DecoupledModels(Model):
    """The single-axis models of one robot, recombined by rolling; for prescribed legs.

    The minimal state is (roll, pitch, yaw, contact point), with the Euler rates as
    quasi-velocities. The motion does not obey the full equations. Its forces are what they demand
    of it, Pinocchio's inverse dynamics of the whole robot along it; `forces["unbalanced"]` is the
    moment about the contact point (3,) [N m] in the body frame that nothing supplies: zero for the
    full model, here what decoupling neglects.

    A gait with twice as many entries as the robot has legs moves the yaw model by the second half.

    Args:
        robot: with a spherical shell, on level ground.
        roll, pitch, yaw: the models, with other dampings than the paper's.

    Raises:
        ModelError: the robot has another shell or ground, or a model is of another robot.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> models = rr.models.DecoupledModels(rr.Robot.from_parameters())
        >>> round(float(rr.sweep(models, offset=np.pi / 4).yaw_rate), 5)
        0.01355
    """

    name = "decoupled"
    n_pose = 5
    n_quasi = 3

    def __init__(
        self,
        robot: Robot,
        roll: RollModel | None = None,
        pitch: PitchModel | None = None,
        yaw: YawModel | None = None,
    ) -> None:
        given = (roll, pitch, yaw)
        self.models: tuple[SingleAxisModel, ...] = tuple(
            kind(robot) if model is None else model
            for kind, model in zip(_KINDS, given, strict=True)
        )
        for kind, model in zip(_KINDS, self.models, strict=True):
            if not isinstance(model, kind):
                raise ModelError(
                    f"{kind.name} is {model!r}: it must be a {kind.__name__} of the robot."
                )
            if model.robot != robot:
                raise ModelError(
                    f"the {model.name} model is of {model.robot!r}, not of {robot!r}: it must be "
                    f"a {kind.__name__} of the same robot."
                )
        self.roll, self.pitch, self.yaw = self.models
        ground = self.roll.ground
        self.radius = pivot_radius(robot, self.name, ground)
        self._body = body = FullModel(robot, ground=ground)
        super().__init__(
            robot, body.model, ground=ground, damping=body.damping, constraints=body.constraints
        )

    def make_pose(self, euler: Array, position: Array) -> Array:
        return np.concatenate((euler, position))

    def place(self, pose: Array) -> Placement:
        euler = pose[:3]
        return Placement(
            quaternion_from_euler(euler), pose[3:], rotation_from_euler(euler), euler, np.eye(3)
        )

    def quaternions(self, poses: Array) -> Array:
        return quaternion_from_euler(poses[:, :3])

    def turned(self, poses: Array, now: Array) -> Array:
        return poses[:, :3]

    def pose_rate(self, place: Placement, pose: Array, quasi: Array) -> Array:
        return np.concatenate((quasi, sphere_contact_rate(self.radius, pose[:3], quasi)))

    def quasi_acceleration(self, acceleration: Array) -> Array:
        return acceleration

    def body_velocity(self, place: Placement, quasi: Array) -> Array:
        roll, pitch, _ = place.configuration.tolist()
        return body_rates_matrix(roll, pitch) @ quasi

    def quasi_from_euler_rates(self, pose: Array, rates: Array) -> Array:
        return rates.copy()

    def damping_force(self, place: Placement, quasi: Array) -> Array:
        matrix = body_rates_matrix(*place.configuration[:2].tolist())
        placed = self._body.place(np.concatenate((place.quaternion, place.position)))
        return np.asarray(matrix.T @ self._body.damping_force(placed, matrix @ quasi)[3:])

    @property
    def singular_at_vertical(self) -> bool:
        return False

    def check_legs(self, n_legs: int) -> None:
        if n_legs != 2 * self.n_legs:
            super().check_legs(n_legs)

    def legs_of(self, leg: LegMotion) -> tuple[LegMotion, LegMotion]:
        """Motion of the whole robot's legs, and of the yaw model's."""
        n = self.n_legs
        first = LegMotion(*(part[..., :n] for part in leg))
        return first, (first if leg.angle.shape[-1] == n else LegMotion(*(p[..., n:] for p in leg)))

    def impulsive_start(self, pose: ArrayLike, leg_angle: Array, leg_rate: Array) -> Array:
        n, angles = self.n_legs, np.asarray(pose, dtype=float)
        own = (slice(0, n), slice(0, n), slice(-n, None) if n else slice(0, 0))
        return np.array(
            [
                model.impulsive_start(
                    np.array((angles[i], 0.0, 0.0)), leg_angle[part], leg_rate[part]
                )[0]
                for i, (model, part) in enumerate(zip(self.models, own, strict=True))
            ]
        )

    def quasi_rate(
        self, place: Placement, quasi: Array, leg: LegMotion, time: float = 0.0
    ) -> Array:
        whole, yaw = self.legs_of(leg)
        rates = np.empty(3)
        for i, (model, motion) in enumerate(zip(self.models, (whole, whole, yaw), strict=True)):
            pose = np.array((place.configuration[i], 0.0, 0.0))
            rates[i] = model.quasi_rate(model.place(pose), quasi[i : i + 1], motion, time)[0]
        return rates

    def dynamics(
        self,
        pose: ArrayLike | Placement,
        quasi: Array,
        leg: LegMotion | None = None,
        *,
        leg_angle: Array | None = None,
        leg_rate: Array | None = None,
        leg_torque: Array | None = None,
        time: float = 0.0,
    ) -> Dynamics:
        """Euler accelerations (3,), and the forces that the full equations demand of them."""
        if leg is None:
            raise GaitError(NEEDS_GAIT)
        placed = self._place(pose)
        return self.inverse(
            placed, quasi, self.quasi_rate(placed, quasi, leg, time), self.legs_of(leg)[0]
        )

    def inverse(
        self, place: Placement, rates: Array, accelerations: Array, leg: LegMotion
    ) -> Dynamics:
        """Forces of the whole robot with these Euler rates (3,) and accelerations (3,), rolling."""
        body, euler = self._body, place.configuration
        placed = body.place(np.concatenate((place.quaternion, place.position)))
        matrix = body_rates_matrix(euler[0], euler[1])
        omega = matrix @ rates
        q = body.configuration(placed, leg.angle)
        v = body.velocity(placed, omega, leg.rate)
        alpha = matrix @ accelerations + body_rates_matrix_rate(euler, rates) @ rates
        a = body.velocity(placed, alpha, leg.acceleration)
        # The base moves with x cross omega, where x = -r R^T n is the contact point in the base
        # frame and so x_dot = x cross omega.
        x = -self.radius * placed.rotation[2]
        a[:3] += np.cross(np.cross(x, omega), omega)
        tau = pin.rnea(body.model, body.data, q, v, a)
        force, torque = placed.rotation @ tau[:3], tau[body.legs.v]
        missing = tau[3:6] - np.cross(x, tau[:3]) - body.damping_force(placed, omega)[3:]
        forces = {"contact": force, "legs": torque, "unbalanced": missing}
        return Dynamics(accelerations, force, torque, q, v, forces, {})

    def remade(self, robot: Robot) -> DecoupledModels:
        return DecoupledModels(robot, *(m.remade(robot) for m in self.models))  # type: ignore[arg-type]

    def to_dict(self) -> dict[str, Any]:
        """What the models are, as plain data for metadata."""
        return {"type": self.name} | {model.name: model.to_dict() for model in self.models}

    @classmethod
    def from_dict(cls, data: Any) -> DecoupledModels:
        """The models of `to_dict`'s entries and "robot"."""
        robot = data["robot"]
        parts = (kind.from_dict({**data[kind.name], "robot": robot}) for kind in _KINDS)
        return cls(robot, *parts)  # type: ignore[arg-type]

    def __repr__(self) -> str:
        return f"DecoupledModels({self.robot!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        make = partial(DecoupledModels, roll=self.roll, pitch=self.pitch, yaw=self.yaw)  # type: ignore[arg-type]
        return (make, (self.robot,))


NEEDS_GAIT = (
    "decoupled models need a prescribed gait: under given torques each single-axis model would "
    "move its legs differently."
)
