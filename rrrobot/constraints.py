"""Constraints on a robot's motion: one protocol, rolling contact and prescribed joints.

A constraint is some rows J v = c of the velocities v, c zero unless something is driven, and their
derivative J a + gamma = 0, which the KKT system imposes on the accelerations. Rolling without slip
of a shell with contact arm rho on a ground of unit normal n: the material point of the shell at
the contact stands still,

    v_c + Omega x rho = 0,        v_c, Omega: velocity of the shell's centre, angular velocity.

Along n this is the rate of the height, a holonomic constraint; the two tangent rows, eqs (2)-(3)
of the paper, are nonholonomic. As J v = 0 and, differentiated, J a + gamma = 0 with

    J = J_c - [rho] J_Omega,      gamma = a_c + alpha x rho + Omega x rho_dot   at zero v_dot,

a_c the classical (not spatial) acceleration of the centre. rho_dot = Omega x rho + P_dot is that of
the contact point, which moves over the body with the curvatures of both shell and ground; for a
sphere on a plane it is zero.

`contact_point`, `contact_jacobian` and `contact_drift` are plain functions of any Pinocchio model
with a round body; `RollingContact` is the same for repeated use.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from rrrobot.checks import Array
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.surfaces import SHELL_FRAME, Surface
from rrrobot.contact.touching import Contact, check_pair, contact_rate, touch_near
from rrrobot.drive.gaits import LegMotion
from rrrobot.errors import ConstraintError, ParameterError
from rrrobot.kkt import ConstraintRows
from rrrobot.rotations import skew

_FRAME = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class Instant(NamedTuple):
    """Where a constraint is evaluated."""

    data: pin.Data
    """with positions, velocities and the accelerations at v_dot = 0 of all joints"""
    q: Array
    """Pinocchio's configuration (nq,)"""
    v: Array
    """Pinocchio's velocity (nv,)"""
    time: float = 0.0
    """[s]"""
    legs: LegMotion | None = None
    """prescribed motion of the legs, if they are prescribed"""
    contact: Contact | None = None
    """where the shell touches the ground, if the pose says so"""


class Constraint(ABC):
    """Rows J v = c, J a + gamma = 0 on one Pinocchio model; a subclass gives `rows`.

    Attributes:
        name: under which its force is found in `Dynamics.forces`.
        holonomic: which rows are derivatives of a constraint on positions (m,).
        model: the Pinocchio model; None where the rows need no kinematics.
    """

    name: str
    holonomic: NDArray[np.bool_]
    model: pin.Model | None = None

    @abstractmethod
    def rows(self, at: Instant) -> ConstraintRows:
        """Jacobian, drift and residual, from kinematics that are up to date."""

    def evaluate(
        self,
        data: pin.Data,
        q: Array,
        v: Array,
        *,
        time: float = 0.0,
        legs: LegMotion | None = None,
    ) -> ConstraintRows:
        """Jacobian, drift and residual at (q, v); updates the kinematics in `data`."""
        if self.model is not None:
            pin.forwardKinematics(self.model, data, q, v, np.zeros(self.model.nv))
        return self.rows(Instant(data, q, v, time, legs))

    def force(self, multipliers: Array) -> Array:
        """The constraint's force (m,) of its rows' multipliers; as they are, unless overridden."""
        return multipliers

    def gap(self, at: Instant) -> Array:
        """What the position is off (m,) [m or rad], after `rows`, which are its rate; zero on
        nonholonomic rows, and on all unless overridden."""
        return np.zeros(self.holonomic.size)


class RollingContact(Constraint):
    """No-slip rolling of a body's shell on the ground; its force is the contact force.

    On a plane, rows are along the columns (t1, t2, n) of its basis; on level ground, along x, y
    and z. Rows 0 and 1 are nonholonomic, row 2 is holonomic. On curved ground, rows are along x, y
    and z, and only their sum along the momentary normal is holonomic.

    Args:
        model: Pinocchio model.
        frame_id: frame of the shell's centre and axes.
        surface: the shell.
        ground: level ground unless given.
        rows: which of the rows (0, 1, 2) to impose; all unless a model has fewer freedoms.
        name: of the constraint.

    Example:
        >>> import numpy as np, pinocchio as pin, rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> rolling = rr.constraints.RollingContact.of(robot)
        >>> q, v = pin.neutral(robot.model), np.zeros(robot.model.nv)
        >>> rolling.evaluate(robot.model.createData(), q, v).jacobian.shape
        (3, 8)
    """

    def __init__(
        self,
        model: pin.Model,
        frame_id: int,
        surface: Surface,
        ground: Ground | None = None,
        *,
        rows: tuple[int, ...] = (0, 1, 2),
        name: str = "contact",
    ) -> None:
        self.model = model
        self.frame_id = _existing(model, frame_id)
        self.surface = surface
        self.name = name
        self.ground = ground = Plane() if ground is None else ground
        check_pair(surface, ground)
        self.imposed = rows
        flat = isinstance(ground, Plane)
        self.holonomic = np.array([flat and row == 2 for row in rows])
        basis = ground.basis if isinstance(ground, Plane) else np.eye(3)
        self._project = basis.T[list(rows)]
        self._level = bool(np.array_equal(self._project, np.eye(3)))
        # The arm of a sphere on a plane is the same at every orientation.
        normal = ground.fixed_normal
        fixed = None if normal is None else surface.fixed_arm(normal)
        self._fixed_arm = None if fixed is None else skew(fixed)
        self._ball = None if fixed is None else (normal, fixed)

    @classmethod
    def of(cls, robot: Any, ground: Ground | None = None) -> RollingContact:
        """Rolling contact of a `Robot` on a ground; level ground unless given."""
        frame = robot.model.getFrameId(SHELL_FRAME)
        return cls(robot.model, frame, robot.shell, ground)

    def rows(self, at: Instant) -> ConstraintRows:
        model, data, frame_id = self.model, at.data, self.frame_id
        spatial = pin.computeFrameJacobian(model, data, at.q, frame_id, _FRAME)
        placement = pin.updateFramePlacement(model, data, frame_id)
        acceleration = pin.getFrameClassicalAcceleration(model, data, frame_id, _FRAME)
        arm = self._fixed_arm
        if arm is None:
            rotation, omega = placement.rotation, spatial[3:] @ at.v
            contact = at.contact or self._found(placement)
            arm, turning = skew(contact.arm), skew(omega)
            moving = contact_rate(self.surface, self.ground, rotation, omega, contact)
            arm_rate = turning @ contact.arm + moving
            drift = acceleration.linear - arm @ acceleration.angular + turning @ arm_rate
        else:
            drift = acceleration.linear - arm @ acceleration.angular
        jacobian = spatial[:3] - arm @ spatial[3:]
        if not self._level:
            jacobian, drift = self._project @ jacobian, self._project @ drift
        return ConstraintRows(jacobian, drift, jacobian @ at.v)

    @property
    def is_whole(self) -> bool:
        """Whether all three rows are imposed, so that the multipliers are the whole force."""
        return bool(self.holonomic.size == 3)

    def height(self, data: pin.Data) -> float:
        """Height of the shell's lowest point over the ground [m], after `evaluate`; zero on it."""
        placement = data.oMf[self.frame_id]
        if self._ball is not None:
            normal, arm = self._ball
            return float(normal @ (placement.translation + arm))
        contact = self._found(placement)
        return float(contact.normal @ (placement.translation + contact.arm - contact.point))

    def gap(self, at: Instant) -> Array:
        """The height over the ground along the rows (m,) [m], of any ground."""
        placement = at.data.oMf[self.frame_id]
        normal = self._ball[0] if self._ball is not None else self._found(placement).normal
        return self._project @ (self.height(at.data) * np.asarray(normal))

    def _found(self, placement: pin.SE3) -> Contact:
        """The contact, from where the shell stands alone."""
        return touch_near(self.surface, self.ground, placement.rotation, placement.translation)

    def force(self, multipliers: Array) -> Array:
        """Contact force on the body in the world frame (3,) [N] of the rows' multipliers."""
        return self._project.T @ multipliers


class PrescribedJoints(Constraint):
    """Joints that follow a given motion: v[index] = rate, a[index] = acceleration.

    Its force is what the motors do [N m, or N of prismatic joints].

    Args:
        index: entries of v, shape (m,).
        nv: size of v.
        name: of the constraint.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> rr.constraints.PrescribedJoints(np.array([6, 7]), nv=8).jacobian.shape
        (2, 8)
    """

    def __init__(self, index: ArrayLike, nv: int, *, name: str = "legs") -> None:
        self.index = np.asarray(index, dtype=int)
        self.name = name
        self.holonomic = np.ones(self.index.size, dtype=bool)
        self.jacobian = np.zeros((self.index.size, nv))
        self.jacobian[np.arange(self.index.size), self.index] = 1.0

    def rows(self, at: Instant) -> ConstraintRows:
        if at.legs is None:
            raise ConstraintError("prescribed joints need the motion that they follow: give legs=.")
        _, rate, acceleration = at.legs
        return ConstraintRows(self.jacobian, -acceleration, at.v[self.index] - rate)


def _existing(model: pin.Model, frame_id: int) -> int:
    """A frame's number, if the model has it: Pinocchio ends the process over one that it has not.

    Raises:
        ParameterError: there is no such frame; `getFrameId` gives such a number for a wrong name.
    """
    if isinstance(frame_id, bool) or not 0 <= int(frame_id) < model.nframes:
        names = [frame.name for frame in model.frames]
        few = ", ".join(names[:20]) + (", ..." if len(names) > 20 else "")
        raise ParameterError(
            f"the model has no frame {frame_id!r}: it has {model.nframes} frames, and getFrameId "
            f"of a name that it does not have gives that number. Its frames are: {few}."
        )
    return int(frame_id)


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
    n = Plane(normal).normal_vector
    pin.forwardKinematics(model, data, q)
    placement = pin.updateFramePlacement(model, data, _existing(model, frame_id))
    return placement.translation + surface.arm(placement.rotation, n)


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
    rolling = RollingContact(model, frame_id, surface, Plane(normal))
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
    rolling = RollingContact(model, frame_id, surface, Plane(normal))
    return rolling.evaluate(data or model.createData(), q, v).drift
