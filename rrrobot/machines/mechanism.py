"""Any machine: a Pinocchio model, constraints, motors, damping and a fluid, by the full KKT system.

    M a + h = tau + sum of J^T f,        J a + gamma = 0 for every constraint,

motors either prescribed, rows whose multipliers are their torques, or torque driven. The state is
(z, v): coordinates (see `Coordinates`) and Pinocchio's velocity. It is integrated as it is, and
after every step brought back: z onto the holonomic constraints by Newton steps, v onto all rows by
the least change, so that neither drifts however long the run. Prescribed joints follow their motion
exactly at all times.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.constraints import Constraint, Instant, PrescribedJoints, RollingContact
from rrrobot.drive.damping import Damping
from rrrobot.drive.gaits import LegMotion
from rrrobot.errors import ConstraintError, GaitError, ModelError
from rrrobot.kkt import ConstraintRows
from rrrobot.machines.coordinates import Coordinates
from rrrobot.machines.fluid import Fluid
from rrrobot.machines.solve import least, meet, solve
from rrrobot.machines.tree import ROOT
from rrrobot.rotations import euler_from_rotation, rotation_from_quaternion

_CLOSED = 1e-14
"""What positions may be off, per metre from the origin, for velocities to be corrected there."""
_PASSES = 4
PLACED = 1e-6
"""What a start may be off its constraints by before it is refused, per metre from the origin."""
MEETS = 1e-7
"""What a start may break a constraint by before it is refused [m/s or rad/s]."""


class MachineDynamics(NamedTuple):
    """Accelerations and forces of a machine at a state."""

    acceleration: Array
    """v_dot (nv,), Pinocchio's"""
    torques: Array
    """of the motors (shape,) [N m or N]"""
    forces: dict[str, Array]
    """of each constraint, by name; see its docstring"""


class Mechanism:
    """Equations of motion of a machine.

    Args:
        model: Pinocchio model with a planar or free root.
        constraints: besides the motors.
        motors: names of the actuated joints; their coordinates are the shape.
        drives: rows that prescribe the shape's rates where it is no joints' (a vehicle in a ball).
        damping: moment on the base, in its axes, and torque on the motors' joints.
        fluid: around the base.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.machines.snakeboard().model
        >>> model.motors, [c.name for c in model.constraints]
        (('rotor', 'front_truck', 'back_truck'), ['front', 'back'])
    """

    def __init__(
        self,
        model: pin.Model,
        constraints: Sequence[Constraint] = (),
        *,
        motors: Sequence[str] = (),
        drives: Sequence[Constraint] = (),
        damping: Damping | None = None,
        fluid: Fluid | None = None,
    ) -> None:
        self.model, self.data = model, model.createData()
        self.constraints, self.motors = tuple(constraints), tuple(motors)
        self.damping, self.fluid = damping, fluid
        self.coordinates = Coordinates(model)
        joints = [model.joints[model.getJointId(name)] for name in motors]
        self.shape_v = np.array([joint.idx_v for joint in joints], dtype=int)
        self._shape_z = np.array([self.coordinates.joint[n].start for n in motors], dtype=int)
        own = (PrescribedJoints(self.shape_v, model.nv, name="motors"),) if motors else ()
        self.drives = tuple(drives) or own
        self.n_shape = len(motors) or max(
            (getattr(drive, "rates", np.zeros((0, 0))).shape[1] for drive in self.drives), default=0
        )
        self._imposed = {False: self.constraints, True: (*self.constraints, *self.drives)}
        self._names = {
            driven: [c.name for c in imposed for _ in range(c.holonomic.size)]
            for driven, imposed in self._imposed.items()
        }
        self.planar = model.joints[1].shortname() == "JointModelPlanar"
        self.n_base = model.joints[1].nv
        self._still = np.zeros(model.nv)
        self.machine: Any = None
        """the `Machine` whose equations these are, once it is made: `rr.simulate` asks it"""

    @property
    def rolling(self) -> RollingContact | None:
        """The contact of a shell with the ground, if there is one."""
        return next((c for c in self.constraints if isinstance(c, RollingContact)), None)

    def start(
        self,
        pose: ArrayLike | None = None,
        shape: ArrayLike | None = None,
        passive: Mapping[str, ArrayLike] | None = None,
    ) -> Array:
        """Coordinates z (nz,) of a pose, the motors' shape, and other joints by name.

        Args:
            pose: (x, y, theta) in the plane; position and quaternion (7,) in space.
            shape: (n,) [rad or m].
            passive: coordinates, or quaternions, of joints without a motor.
        """
        z = self.coordinates.neutral.copy()
        root = self.coordinates.joint[ROOT]
        if pose is not None:
            z[root] = vector("pose", pose, root.stop - root.start)
        if shape is not None:
            z[self._shape_z] = vector("shape", shape, self._shape_z.size)
        for name, value in (passive or {}).items():
            at = self.coordinates.joint.get(name)
            if at is None or name == ROOT:
                known = ", ".join(n for n in self.coordinates.joint if n != ROOT)
                raise ModelError(f"there is no joint {name!r}; there are: {known or 'none'}.")
            z[at] = vector(name, np.atleast_1d(value), at.stop - at.start)
        self.coordinates.normalise(z)
        return z

    def shape(self, z: Array) -> Array:
        """The motors' coordinates (n,) of z (nz,) or (samples, nz)."""
        return np.asarray(z[..., self._shape_z])

    def follow(self, z: Array, v: Array, motion: LegMotion) -> None:
        """Put a prescribed motion into the state, in place."""
        if self._shape_z.size:
            z[self._shape_z] = motion.angle
            v[self.shape_v] = motion.rate

    def imposed(self, motion: LegMotion | None) -> tuple[Constraint, ...]:
        """The constraints that act with or without a prescribed motion."""
        return self._imposed[motion is not None]

    def names(self, motion: LegMotion | None) -> list[str]:
        """Of all rows."""
        return self._names[motion is not None]

    def rows(self, q: Array, v: Array, time: float, motion: LegMotion | None) -> ConstraintRows:
        """The rows of all constraints at a state."""
        pin.forwardKinematics(self.model, self.data, q, v, self._still)
        at = Instant(self.data, q, v, time, motion)
        parts = [constraint.rows(at) for constraint in self.imposed(motion)]
        if len(parts) == 1:
            return parts[0]
        if not parts:
            return ConstraintRows(np.zeros((0, self.model.nv)), np.zeros(0), np.zeros(0))
        return ConstraintRows(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def gaps(self, q: Array, v: Array, time: float, motion: LegMotion | None) -> Array:
        """What positions are off on each row (m,), after `rows`; zero on nonholonomic ones."""
        at = Instant(self.data, q, v, time, motion)
        parts = [constraint.gap(at) for constraint in self.imposed(motion)]
        return np.concatenate(parts) if parts else np.zeros(0)

    def check_place(self, z: Array, motion: LegMotion | None) -> None:
        """Raise where coordinates do not meet the holonomic constraints.

        Raises:
            ConstraintError: they do not.
        """
        q = self.coordinates.to_q(z)
        self.rows(q, self._still, 0.0, motion)
        gap = np.abs(self.gaps(q, self._still, 0.0, motion))
        if gap.max(initial=0.0) > PLACED * (1.0 + np.abs(z).max()):
            name = self.names(motion)[int(np.argmax(gap))]
            raise ConstraintError(
                f"{self._where(z, 0.0)()}: the pose is off the constraint {name!r} by "
                f"{gap.max():.3g} m or rad: place it "
                "where it holds; `machine.at(rotation, (x, y))` puts a shell on its ground."
            )

    def mass_matrix(self, q: Array) -> Array:
        """M (nv, nv), with the fluid's."""
        mass = np.array(pin.crba(self.model, self.data, q))
        if self.fluid is not None:
            mass[:6, :6] += self.fluid.matrix
        return mass

    def applied(self, q: Array, v: Array, torque: Array | None) -> Array:
        """tau - h (nv,): motors, damping, weight, the fluid's and inertial forces."""
        total = -np.asarray(pin.nonLinearEffects(self.model, self.data, q, v))
        if torque is not None:
            total[self.shape_v] += torque
        if self.fluid is not None or (self.damping is not None and not self.planar):
            rotation = rotation_from_quaternion(q[3:7])
            if self.fluid is not None:
                total[:6] -= self.fluid.bias(rotation, v)
            if self.damping is not None:
                roll, pitch, _ = euler_from_rotation(rotation)
                total[3:6] += self.damping.moment(roll, pitch, v[3:6])
        if self.damping is not None:
            total[self.shape_v] -= self.damping.leg_coefficient * v[self.shape_v]
        return total

    def dynamics(
        self,
        z: Array,
        v: Array,
        *,
        time: float = 0.0,
        motion: LegMotion | None = None,
        torque: Array | None = None,
    ) -> MachineDynamics:
        """Accelerations and forces at a state, motors prescribed by `motion` or with `torque`.

        Raises:
            ConstraintError: constraints contradict each other, or the motion is undetermined.
        """
        q = self.coordinates.to_q(z)
        mass = self.mass_matrix(q)
        right = self.applied(q, v, torque)
        rows = self.rows(q, v, time, motion)
        a, f = solve(
            mass, right, rows.jacobian, -rows.drift, self.names(motion), self._where(z, time)
        )
        forces, first = {}, 0
        for constraint in self.imposed(motion):
            last = first + constraint.holonomic.size
            forces[constraint.name] = constraint.force(f[first:last])
            first = last
        if motion is not None and self.motors:
            torques = forces.pop("motors")
        else:
            torques = np.zeros(self.shape_v.size) if torque is None else np.asarray(torque)
        return MachineDynamics(a, torques, forces)

    def velocity(
        self,
        z: Array,
        motion: LegMotion | None,
        known: Mapping[int, float],
        *,
        time: float = 0.0,
    ) -> Array:
        """v (nv,) with some entries known: the others are the smallest that meet all rows.

        Raises:
            ConstraintError: nothing meets them.
        """
        v = np.zeros(self.model.nv)
        if motion is not None:
            v[self.shape_v] = motion.rate[: self.shape_v.size]
        for i, value in known.items():
            v[i] = finite("velocity", value)
        rows = self.rows(self.coordinates.to_q(z), v, time, motion)
        given = {*known, *(self.shape_v.tolist() if motion is not None else ())}
        free = [i for i in range(v.size) if i not in given]
        where, names = self._where(z, time), self.names(motion)
        v[free] += meet(rows.jacobian[:, free], -rows.residual, names, where, MEETS)
        return v

    def impulsive(self, z: Array, motion: LegMotion | None, time: float = 0.0) -> Array:
        """v (nv,) that meets the constraints without momentum along what they leave free."""
        q = self.coordinates.to_q(z)
        rows = self.rows(q, np.zeros(self.model.nv), time, motion)
        mass = self.mass_matrix(q)
        still = np.zeros(self.model.nv)
        names, where = self.names(motion), self._where(z, time)
        return solve(mass, still, rows.jacobian, -rows.residual, names, where)[0]

    def rate(self, time: float, state: Array, motion: LegMotion | None, torque: Any) -> Array:
        """Rate of the state (z, v)."""
        z, v = self.split(state)
        if motion is not None:
            self.follow(z, v, motion)
        found = self.dynamics(z, v, time=time, motion=motion, torque=torque)
        return np.concatenate((self.coordinates.rate(z, v), found.acceleration))

    def correct(self, time: float, state: Array, motion: LegMotion | None) -> None:
        """Bring a state that drifted back onto the constraints, in place."""
        z, v = self.split(state)
        if motion is not None:
            self.follow(z, v, motion)
        self.coordinates.normalise(z)
        for left in reversed(range(_PASSES)):
            q = self.coordinates.to_q(z)
            rows = self.rows(q, v, time, motion)
            if not rows.drift.size:
                break
            gap = self.gaps(q, v, time, motion)
            if left == 0 or np.abs(gap).max() < _CLOSED * (1.0 + np.abs(z).max()):
                v -= least(rows.jacobian, rows.residual)[0]
                break
            # Rows at a place that is off by more are not those of the place that it is brought to.
            z -= self.coordinates.rate(z, least(rows.jacobian, gap)[0])
        state[:] = np.concatenate((z, v))

    def split(self, state: Array) -> tuple[Array, Array]:
        """Copies of z and v of a state."""
        cut = self.coordinates.size
        return state[:cut].copy(), state[cut:].copy()

    def energy(self, z: Array, v: Array) -> float:
        """Kinetic and potential energy, zero at rest at the origin's height [J]."""
        q = self.coordinates.to_q(z)
        kinetic = 0.5 * v @ self.mass_matrix(q) @ v
        potential = pin.computePotentialEnergy(self.model, self.data, q)
        lift = 0.0 if self.fluid is None else self.fluid.buoyancy * q[2]
        return float(kinetic + potential - lift)

    def check_shape(self, size: int) -> None:
        """Raise GaitError unless a drive moves as many motors as there are."""
        if size != self.n_shape:
            raise GaitError(
                f"the gait moves {size} joint{'s' * (size != 1)}, but the machine has "
                f"{self.n_shape}: {', '.join(self.motors) or 'none'}. Give one entry for each."
            )

    def _where(self, z: Array, time: float) -> Callable[[], str]:
        def words() -> str:
            shape = ", ".join(f"{x:.4g}" for x in self.shape(z))
            return f"at t = {time:.4g} s" + (f", shape ({shape})" if shape else "")

        return words
