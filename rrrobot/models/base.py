"""What a model is: Pinocchio's M a + h = tau + J^T f on one robot, and a minimal state.

A model's state vector is y = (pose, quasi) for prescribed legs and (pose, quasi, leg angles, leg
rates) for torque-driven ones. `pose` locates the body, `quasi` are its independent velocities,
so that

    v = N(pose) quasi + leg rates,

and the constraint J v = 0 holds by construction at every state. A subclass says how pose and
quasi-velocities map to Pinocchio's q and v; the equations of motion are the same for all.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.constraints import (
    ConstraintRows,
    PrescribedJoints,
    RollingContact,
    kkt_build,
    kkt_solve,
)
from rrrobot.drive.damping import Damping, DampingLike, as_damping
from rrrobot.drive.gaits import LegMotion
from rrrobot.errors import ConstraintError, GaitError, ModelError
from rrrobot.integrate import MAX_STEP
from rrrobot.robot.joints import JointIndex, energy, has_mimics, joint_inertia
from rrrobot.robot.robot import Robot

VERTICAL_PITCH = np.deg2rad(89.5)
"""Pitch at which a model stops that is singular at 90 degrees [rad]."""


class Placement(NamedTuple):
    """A pose in every model's terms; made once per evaluation by `Model.place`."""

    quaternion: Array
    """(x, y, z, w) of R_world_body, unit (4,)"""
    position: Array
    """contact point in the ground plane (2,) [m]"""
    rotation: Array
    """R_world_body (3, 3)"""
    configuration: Array
    """the body's part of Pinocchio's q, which comes first (body nq,)"""
    basis: Array
    """the body's part of Pinocchio's v per unit of quasi-velocity (body nv, n_quasi)"""


class Dynamics(NamedTuple):
    """One evaluation of a model's equations of motion."""

    acceleration: Array
    """a (nv,) in the model's Pinocchio coordinates"""
    contact_force: Array
    """force of the ground, or of the pivot, on the robot in the world frame (3,) [N]"""
    leg_torque: Array
    """motor torques (legs,) [N m]; forces [N] for prismatic joints"""
    q: Array
    """Pinocchio's configuration (nq,)"""
    v: Array
    """Pinocchio's velocity (nv,)"""


class Equations(NamedTuple):
    """Terms of M a + C v + G = tau + J^T f in a model's Pinocchio coordinates."""

    mass_matrix: Array
    """M(q) (nv, nv)"""
    coriolis: Array
    """C(q, v) (nv, nv); M_dot - 2 C is skew-symmetric"""
    gravity: Array
    """G(q) (nv,)"""


class Model(ABC):
    """A robot's equations of motion under one set of simplifications.

    Args:
        robot: the robot.
        damping: losses; see `as_damping`.
        pin_model: Pinocchio model in this model's coordinates.
        rolling: the rolling contact, or None for a pivoted model.

    Attributes:
        name: "full", "pivoting", "roll", "pitch" or "yaw".
        axes: Euler angles that are free: 0 roll, 1 pitch, 2 yaw.
        n_pose, n_quasi: sizes of the state's parts.
        max_step: longest step of the adaptive integrator [s].
    """

    name: str
    axes: tuple[int, ...] = (0, 1, 2)
    n_pose: int
    n_quasi: int
    max_step = MAX_STEP

    def __init__(
        self,
        robot: Robot,
        damping: DampingLike,
        pin_model: pin.Model,
        rolling: RollingContact | None,
    ) -> None:
        self.robot = robot
        self.damping: Damping = as_damping(damping)
        self.model = pin_model
        self.data = pin_model.createData()
        self.rolling = rolling
        self.legs = JointIndex(pin_model, robot.legs)
        self.n_legs = robot.n_legs
        self._prescribed = PrescribedJoints(self.legs.v, pin_model.nv)
        self._neutral = pin.neutral(pin_model)

    # What a subclass gives.

    @abstractmethod
    def make_pose(self, euler: Array, position: Array) -> Array:
        """Pose (n_pose,) of Euler angles (3,) [rad] and a contact point (2,) [m]."""

    @abstractmethod
    def place(self, pose: Array) -> Placement:
        """The pose in every model's terms."""

    @abstractmethod
    def quaternions(self, poses: Array) -> Array:
        """Quaternions (n, 4) of poses (n, n_pose), of any length."""

    @abstractmethod
    def pose_rate(self, place: Placement, pose: Array, quasi: Array) -> Array:
        """Rate of the pose (n_pose,) [1/s]."""

    @abstractmethod
    def quasi_acceleration(self, acceleration: Array) -> Array:
        """The entries of a (nv,) that are the rates of the quasi-velocities (n_quasi,)."""

    @abstractmethod
    def body_velocity(self, place: Placement, quasi: Array) -> Array:
        """Angular velocity in the body frame (3,) [rad/s]."""

    @abstractmethod
    def quasi_from_euler_rates(self, pose: Array, rates: Array) -> Array:
        """Quasi-velocities (n_quasi,) of (roll, pitch, yaw) rates (3,) [rad/s]."""

    @abstractmethod
    def damping_force(self, place: Placement, quasi: Array) -> Array:
        """Generalised force of the damping on the body's part of v (body nv,)."""

    # What every model has.

    def configuration(self, pose: ArrayLike | Placement, leg_angle: ArrayLike) -> Array:
        """Pinocchio's q (nq,) of a pose and leg angles."""
        place = self._place(pose)
        q = self._neutral.copy()
        q[: place.configuration.size] = place.configuration
        self.legs.write(q, np.asarray(leg_angle, dtype=float))
        return q

    def velocity(self, pose: ArrayLike | Placement, quasi: Array, leg_rate: Array) -> Array:
        """Pinocchio's v (nv,) of quasi-velocities and leg rates; it satisfies the constraint."""
        basis = self._place(pose).basis
        v = np.zeros(self.model.nv)
        v[: len(basis)] = basis @ quasi
        v[self.legs.v] = leg_rate
        return v

    def _place(self, pose: ArrayLike | Placement) -> Placement:
        if isinstance(pose, Placement):
            return pose
        return self.place(np.asarray(pose, dtype=float))

    def dynamics(
        self,
        pose: ArrayLike | Placement,
        quasi: Array,
        leg: LegMotion | None = None,
        *,
        leg_angle: Array | None = None,
        leg_rate: Array | None = None,
        leg_torque: Array | None = None,
    ) -> Dynamics:
        """Accelerations and forces at a state, by the KKT system.

        Give either `leg`, the prescribed motion of the legs, whose multipliers are the motor
        torques, or `leg_angle`, `leg_rate` and `leg_torque` for torque-driven legs.

        Raises:
            ConstraintError: the system is singular.
            ModelError: neither or both of the two forms are given.
        """
        if (leg_torque is None) == (leg is None):
            raise ModelError("give either leg (prescribed) or leg_torque with leg_angle, leg_rate.")
        angle, rate = (leg.angle, leg.rate) if leg is not None else (leg_angle, leg_rate)
        place = self._place(pose)
        q = self.configuration(place, angle)  # type: ignore[arg-type]
        v = self.velocity(place, quasi, rate)  # type: ignore[arg-type]
        mass = joint_inertia(self.model, self.data, q)
        bias = pin.nonLinearEffects(self.model, self.data, q, v)
        tau = np.zeros(self.model.nv)
        tau[: len(place.basis)] = self.damping_force(place, quasi)
        if self.damping.leg_coefficient:
            tau[self.legs.v] -= self.damping.leg_coefficient * v[self.legs.v]
        rows: list[ConstraintRows] = []
        if self.rolling is not None:
            rows.append(self.rolling.evaluate(self.data, q, v))
        if self.robot.joints.lossy:
            tau[self.legs.v] -= self.robot.joints.loss(v[self.legs.v])
        if leg is not None:
            rows.append(self._prescribed.evaluate(v, leg.rate, leg.acceleration))
        else:
            tau[self.legs.v] += leg_torque
        acceleration, multipliers = kkt_solve(kkt_build(mass, bias, tau, *rows))
        if self.rolling is not None and len(self.rolling.rows) == 3:
            force = self.rolling.force(multipliers[:3])
        else:
            force = self.support_force(q, v, acceleration)
        torque = multipliers[multipliers.size - self.n_legs :] if leg_torque is None else leg_torque
        return Dynamics(acceleration, force, torque, q, v)

    def equations(self, q: Array, v: Array) -> Equations:
        """M, C and G at Pinocchio's q (nq,) and v (nv,): the left side of eqs (1), (6) and (11).

        Example:
            >>> import numpy as np, rrrobot as rr
            >>> model = rr.FullModel(rr.Robot.from_parameters())
            >>> q = model.configuration((0, 0, 0, 1, 0, 0), (1.57, 1.57))
            >>> terms = model.equations(q, np.zeros(8))
            >>> terms.gravity[2].round(4)  # the weight [N]
            np.float64(5.1012)
        """
        if has_mimics(self.model):
            raise ModelError(
                "Pinocchio has no Coriolis matrix of a robot whose joints mimic others: hold those "
                "joints with locked=, or use mass_matrix and dynamics."
            )
        return Equations(
            np.array(joint_inertia(self.model, self.data, q)),
            np.array(pin.computeCoriolisMatrix(self.model, self.data, q, v)),
            np.array(pin.computeGeneralizedGravity(self.model, self.data, q)),
        )

    def support_force(self, q: Array, v: Array, acceleration: Array) -> Array:
        """Force that holds the robot, from Newton's law: d(momentum)/dt - m g (3,) [N]."""
        pin.computeCentroidalMomentumTimeVariation(self.model, self.data, q, v, acceleration)
        weight = pin.computeTotalMass(self.model) * self.model.gravity.linear
        return np.array(self.data.dhg.linear - weight)

    def mass_matrix(self, pose: ArrayLike | Placement, leg_angle: ArrayLike) -> Array:
        """M(q) (nv, nv) in the model's Pinocchio coordinates."""
        return np.array(joint_inertia(self.model, self.data, self.configuration(pose, leg_angle)))

    def energy(self, q: Array, v: Array) -> tuple[float, float]:
        """Kinetic and potential energy [J]; the potential is zero at the world's origin."""
        return energy(self.model, self.data, q, v)

    def momentum(
        self, pose: ArrayLike | Placement, quasi: Array, leg_angle: Array, leg_rate: Array
    ) -> Array:
        """Momentum conjugate to the body's quasi-velocities, N_b^T M v (n_quasi,)."""
        place = self._place(pose)
        mass = self.mass_matrix(place, leg_angle)[: len(place.basis)]
        return place.basis.T @ mass @ self.velocity(place, quasi, leg_rate)

    def impulsive_start(self, pose: ArrayLike, leg_angle: Array, leg_rate: Array) -> Array:
        """Quasi-velocities (n_quasi,) at which that momentum is zero: M_bb v_b = -M_bl phi_dot."""
        place = self._place(pose)
        basis, body = place.basis, slice(len(place.basis))
        mass = self.mass_matrix(place, leg_angle)
        right = basis.T @ mass[body, self.legs.v] @ leg_rate
        try:
            return np.asarray(np.linalg.solve(basis.T @ mass[body, body] @ basis, -right))
        except np.linalg.LinAlgError:
            raise ConstraintError(
                "the body has no inertia about a free axis, so an impulsive start is undefined: "
                "give it a mass there."
            ) from None

    def split(self, state: Array) -> tuple[Array, Array, Array]:
        """(pose, quasi, rest) of a state vector."""
        cut = self.n_pose + self.n_quasi
        return state[: self.n_pose], state[self.n_pose : cut], state[cut:]

    def check_legs(self, n_legs: int) -> None:
        """Raise GaitError unless a drive has as many legs as the robot."""
        if n_legs != self.n_legs:
            raise GaitError(
                f"the gait moves {n_legs} leg joint{'s' * (n_legs != 1)}, but the robot has "
                f"{self.n_legs}: {', '.join(self.robot.legs) or 'none'}. Give one entry for each."
            )

    def start_velocity(
        self, start: str | ArrayLike, pose: Array, leg_angle: Array, leg_rate: Array
    ) -> Array:
        """Quasi-velocities of a start: "impulsive", "rest", or Euler rates (3,) [rad/s]."""
        if isinstance(start, str):
            if start == "impulsive":
                return self.impulsive_start(pose, leg_angle, leg_rate)
            if start == "rest":
                return np.zeros(self.n_quasi)
            raise ModelError(f"start is {start!r}: it must be 'impulsive', 'rest' or Euler rates.")
        rates = vector("start", start, 3, "rad/s", labels=("roll", "pitch", "yaw"))
        self.require_free("start", rates)
        return self.quasi_from_euler_rates(pose, rates)

    @property
    def singular_at_vertical(self) -> bool:
        """Whether the equations are singular at a pitch of +-90 degrees."""
        return self.damping.singular_at_vertical

    def require_free(self, name: str, values: Array) -> None:
        """Raise ModelError where a value is not zero on an axis that this model locks."""
        locked = [i for i in range(3) if i not in self.axes and values[i] != 0]
        if locked:
            names = ("roll", "pitch", "yaw")
            raise ModelError(
                f"{name} is {values.tolist()} (roll, pitch, yaw): the {self.name} model locks "
                f"{', '.join(names[i] for i in locked)}, so that entry must be zero."
            )

    def to_dict(self) -> dict[str, Any]:
        """What the model is, as plain data for metadata."""
        return {"name": self.name, "damping": self.damping.to_dict()}

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.robot!r}, damping={self.damping!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return (_rebuild, (type(self), self.robot, self.damping))


def _rebuild(cls: Any, robot: Robot, damping: Damping) -> Model:
    return cls(robot, damping=damping)
