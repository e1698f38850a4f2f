"""What a model is: a robot, a ground, constraints and damping, and a minimal state.

    M a + h = tau + sum over the constraints of J^T f,       J a + gamma = 0 for each

with M and h from Pinocchio. A model's state vector is y = (pose, quasi) for prescribed legs and
(pose, quasi, leg angles, leg rates) for torque-driven ones. `pose` locates the body, `quasi` are
its independent velocities, so that

    v = N(pose) quasi + leg rates,

and the constraints J v = 0 hold by construction at every state. A subclass declares Pinocchio's
model and the constraints, and says how pose and quasi-velocities map to Pinocchio's q and v.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array
from rrrobot.constraints import Constraint, Instant, PrescribedJoints, RollingContact
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.saved import ground_from_dict
from rrrobot.drive.damping import (
    Damping,
    DampingLike,
    EulerRateDamping,
    as_damping,
    damping_from_dict,
)
from rrrobot.drive.gaits import LegMotion
from rrrobot.errors import ConstraintError, GaitError, ModelError, ParameterError
from rrrobot.inline import shows
from rrrobot.integrate import MAX_STEP
from rrrobot.kkt import ConstraintRows, kkt_build, kkt_solve
from rrrobot.models.terms import Dynamics, Equations, Placement
from rrrobot.robot.joints import JointIndex, checked_state, coriolis_matrix, energy, joint_inertia
from rrrobot.robot.robot import Robot, checked_robot
from rrrobot.rotations import continuous_euler, euler_from_quaternion

VERTICAL_PITCH = np.deg2rad(89.5)
"""Pitch at which a model stops that is singular at 90 degrees [rad]."""
OWN = "robot"
"""As `damping`: that of the robot's parameters, or none."""


class Model(ABC):
    """A robot's equations of motion under one set of simplifications.

    Args:
        robot: the robot.
        pin_model: Pinocchio model in this model's coordinates, with the gravity that acts.
        ground: what the robot rests on.
        damping: losses; see `as_damping`. "robot" takes the robot's own: k on the Euler rates that
            `damped` names, k of the robot's parameters; none for a robot without.
        constraints: besides the prescribed legs.

    Attributes:
        name: "full", "pivoting", "roll", "pitch" or "yaw".
        axes: Euler angles that are free: 0 roll, 1 pitch, 2 yaw.
        damped: which of the Euler rates the paper damps in this model (3,).
        n_pose, n_quasi: sizes of the state's parts.
        max_step: longest step of the adaptive integrator [s].
    """

    name: str
    axes: tuple[int, ...] = (0, 1, 2)
    damped: tuple[int, int, int] = (1, 1, 1)
    n_pose: int
    n_quasi: int
    max_step = MAX_STEP

    def __init__(
        self,
        robot: Robot,
        pin_model: pin.Model,
        *,
        ground: Ground,
        damping: DampingLike = OWN,
        constraints: tuple[Constraint, ...] = (),
    ) -> None:
        up = ground.normal(ground.point(np.zeros(2)))
        if up[2] <= 0:
            raise ParameterError(
                f"the ground's normal is {up.tolist()}: it must point up (third entry above zero)."
            )
        self.robot, self.ground = checked_robot(robot), ground
        own = isinstance(damping, str) and damping == OWN
        self.damping: Damping = self._own_damping() if own else as_damping(damping)
        self.model, self.data = pin_model, pin_model.createData()
        self.constraints = constraints
        self.legs, self.n_legs = JointIndex(pin_model, robot.legs), robot.n_legs
        self._prescribed = PrescribedJoints(self.legs.v, pin_model.nv)
        self._neutral, self._still = pin.neutral(pin_model), np.zeros(pin_model.nv)
        self._lossy = robot.joints.lossy
        contact = self.rolling
        self._whole_contact = contact.name if contact is not None and contact.is_whole else None

    def _own_damping(self) -> Damping:
        k = 0.0 if self.robot.parameters is None else self.robot.parameters.damping
        return EulerRateDamping(*(k * free for free in self.damped))

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

    @property
    def gravity(self) -> float:
        """g that acts in this model [m/s^2]."""
        return -float(self.model.gravity.linear[2])

    @property
    def rolling(self) -> RollingContact | None:
        """The rolling contact among the constraints, or None for a pivoted model."""
        return next((c for c in self.constraints if isinstance(c, RollingContact)), None)

    def configuration(self, pose: ArrayLike | Placement, leg_angle: ArrayLike) -> Array:
        """Pinocchio's q (nq,) of a pose and leg angles."""
        place = self._place(pose)
        q = self._neutral.copy()
        q[: place.configuration.size] = place.configuration
        self.legs.write(q, np.asarray(leg_angle, dtype=float))
        return q

    def velocity(self, pose: ArrayLike | Placement, quasi: Array, leg_rate: Array) -> Array:
        """Pinocchio's v (nv,) of quasi-velocities and leg rates; it satisfies the constraints."""
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
        time: float = 0.0,
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
        motion = leg or LegMotion(angle, rate, self._still)  # type: ignore[arg-type]
        acceleration, multipliers, rows, q, v = self._solved(
            self._place(pose), quasi, motion, leg_torque, time
        )
        forces, first = {}, 0
        for constraint, row in rows:
            last = first + row.drift.size
            forces[constraint.name] = constraint.force(multipliers[first:last])
            first = last
        if self._whole_contact is not None:
            force = forces[self._whole_contact]
        else:
            force = self.support_force(q, v, acceleration)
        torque = forces[self._prescribed.name] if leg_torque is None else leg_torque
        missed = {constraint.name: row.residual for constraint, row in rows}
        return Dynamics(acceleration, force, torque, q, v, forces, missed)

    def _solved(
        self, place: Placement, quasi: Array, leg: LegMotion, torque: Array | None, time: float
    ) -> tuple[Array, Array, list[tuple[Constraint, ConstraintRows]], Array, Array]:
        """Acceleration, multipliers, constraints with rows, q, v; without torques of given legs."""
        q, v = self.configuration(place, leg.angle), self.velocity(place, quasi, leg.rate)
        mass = joint_inertia(self.model, self.data, q)
        bias = pin.nonLinearEffects(self.model, self.data, q, v)
        tau = np.zeros(self.model.nv)
        tau[: len(place.basis)] = self.damping_force(place, quasi)
        if self.damping.leg_coefficient:
            tau[self.legs.v] -= self.damping.leg_coefficient * v[self.legs.v]
        if self._lossy:
            tau[self.legs.v] -= self.robot.joints.loss(v[self.legs.v])
        imposed = (*self.constraints, self._prescribed)
        if torque is not None:
            tau[self.legs.v] += torque
            imposed = self.constraints
        if self.constraints:
            pin.forwardKinematics(self.model, self.data, q, v, self._still)
        at = Instant(self.data, q, v, time, leg if torque is None else None, place.contact)
        rows = [constraint.rows(at) for constraint in imposed]
        solution = kkt_solve(kkt_build(mass, bias, tau, *rows))
        return *solution, list(zip(imposed, rows, strict=True)), q, v

    def quasi_rate(
        self, place: Placement, quasi: Array, leg: LegMotion, time: float = 0.0
    ) -> Array:
        """Rates of the quasi-velocities (n_quasi,) under prescribed legs."""
        return self.quasi_acceleration(self._solved(place, quasi, leg, None, time)[0])

    def turned(self, poses: Array, now: Array) -> Array:
        """Roll, pitch, yaw (n, 3) [rad] of poses (n, n_pose), without jumps from `now` (3,) on."""
        return continuous_euler(euler_from_quaternion(self.quaternions(poses)), now)

    def equations(self, q: Array, v: Array) -> Equations:
        """M, C and G at Pinocchio's q (nq,) and v (nv,): the left side of eqs (1), (6) and (11).

        Example:
            >>> import numpy as np, rrrobot as rr
            >>> model = rr.FullModel(rr.Robot.from_parameters())
            >>> q = model.configuration((0, 0, 0, 1, 0, 0), (1.57, 1.57))
            >>> terms = model.equations(q, np.zeros(8))
            >>> terms.gravity[2].round(4)  # the weight [N]
            np.float64(5.1012)

        Raises:
            ParameterError: q or v of another size or not finite, or a quaternion that is no unit.
        """
        q, v = checked_state(self.model, q, v)
        return Equations(
            np.array(joint_inertia(self.model, self.data, q)),
            coriolis_matrix(self.model, self.data, q, v),
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

    @property
    def singular_at_vertical(self) -> bool:
        """Whether the equations are singular at a pitch of +-90 degrees."""
        return self.damping.singular_at_vertical

    def remade(self, robot: Robot) -> Model:
        """The same model of another robot."""
        return type(self)(robot, ground=self.ground, damping=self.damping)  # type: ignore[call-arg]

    def to_dict(self) -> dict[str, Any]:
        """What the model is besides its robot, as plain data; see `models.model_from_dict`."""
        return {
            "type": self.name,
            "ground": self.ground.to_dict(),
            "damping": self.damping.to_dict(),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Model:
        """The model of `to_dict`'s entries and "robot"."""
        ground, damping = ground_from_dict(data["ground"]), damping_from_dict(data["damping"])
        return cls(data["robot"], ground=ground, damping=damping)  # type: ignore[call-arg]

    _repr_html_ = shows("robot", "ground", "damping")

    def __repr__(self) -> str:
        ground = "" if self.ground == Plane() else f", ground={self.ground!r}"
        return f"{type(self).__name__}({self.robot!r}{ground}, damping={self.damping!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), ground=self.ground, damping=self.damping), (self.robot,)
