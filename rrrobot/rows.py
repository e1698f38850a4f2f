"""Constraints of wheels, skates, moving grounds and bodies on bodies, each exact with its drift.

Each class is a `Constraint`: rows J v = c and J a + gamma = 0 on a Pinocchio model. A frame's
velocity in its own axes is V = (v, w); its rate is Pinocchio's spatial acceleration, so a row that
is fixed in a frame, as a knife edge n . v_P = 0, has the drift n . (a_P - w x v_P): the classical
acceleration's n . a_P + (w x n) . v_P.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite
from rrrobot.constraints import Constraint, Instant, RollingContact
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.surfaces import Surface
from rrrobot.errors import ConstraintError
from rrrobot.kkt import ConstraintRows
from rrrobot.rotations import skew

_LOCAL = pin.ReferenceFrame.LOCAL
_WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class NoSideSlip(Constraint):
    """A knife edge, a skate, or a wheel whose spin is left out: n . v_P = 0, nonholonomic.

    Its force is the ground's along n [N].

    Args:
        model: Pinocchio model.
        frame_id: frame whose origin is P, fixed in the link that carries the edge.
        normal: n in the frame's axes (3,), horizontal; its left (0, 1, 0) unless given.
        name: of the constraint.

    Example:
        >>> import rrrobot as rr
        >>> sleigh = rr.machines.chaplygin_sleigh().model
        >>> sleigh.constraints[0].name, sleigh.constraints[0].holonomic.tolist()
        ('blade', [False])
    """

    def __init__(
        self,
        model: pin.Model,
        frame_id: int,
        *,
        normal: ArrayLike = (0.0, 1.0, 0.0),
        name: str = "edge",
    ) -> None:
        self.model, self.frame_id, self.name = model, frame_id, name
        n = Plane(normal).normal_vector
        self._axes = np.concatenate((n, np.zeros(3)))[None, :]
        self.holonomic = np.array([False])

    def rows(self, at: Instant) -> ConstraintRows:
        jacobian = self._axes @ pin.computeFrameJacobian(
            self.model, at.data, at.q, self.frame_id, _LOCAL
        )
        spatial = pin.getFrameAcceleration(self.model, at.data, self.frame_id, _LOCAL).vector
        return ConstraintRows(jacobian, self._axes @ spatial, jacobian @ at.v)


class RollingWheel(Constraint):
    """The longitudinal row of a wheel with its spin: e . (v_c - R w_wheel x z) = 0.

    e is the forward axis of the frame that carries the wheel, whose origin is the wheel's centre
    and which stays horizontal, as on a vehicle in the plane. The sideways row is the axle's
    `NoSideSlip`, once for all wheels on it.

    Args:
        model: Pinocchio model.
        carrier: frame at the wheel's centre in the link that carries it.
        wheel: a frame of the wheel.
        radius: R [m].
        name: of the constraint.

    Example:
        >>> import rrrobot as rr
        >>> racer = rr.machines.roller_racer(wheel_radius=0.05, wheel_mass=0.15)
        >>> [c.name for c in racer.model.constraints][2:]
        ['rear left roll', 'rear right roll', 'front left roll', 'front right roll']
    """

    def __init__(
        self, model: pin.Model, carrier: int, wheel: int, radius: float, *, name: str = "wheel"
    ) -> None:
        self.model, self.name = model, name
        self.carrier, self.wheel = carrier, wheel
        self.radius = finite("radius", radius, "m", above=0)
        self.holonomic = np.array([False])
        self._arm = skew(np.array((0.0, 0.0, self.radius)))

    def rows(self, at: Instant) -> ConstraintRows:
        model, data = self.model, at.data
        carrier = pin.computeFrameJacobian(model, data, at.q, self.carrier, _WORLD)
        wheel = pin.computeFrameJacobian(model, data, at.q, self.wheel, _WORLD)
        forward = pin.updateFramePlacement(model, data, self.carrier).rotation[:, 0]
        # w x R z = -[R z] w
        slip = carrier[:3] + self._arm @ wheel[3:]
        own = pin.getFrameClassicalAcceleration(model, data, self.carrier, _WORLD).linear
        turn = pin.getFrameClassicalAcceleration(model, data, self.wheel, _WORLD).angular
        turning = skew(carrier[3:] @ at.v) @ forward
        drift = forward @ (own + self._arm @ turn) + turning @ (slip @ at.v)
        jacobian = (forward @ slip)[None, :]
        return ConstraintRows(jacobian, np.array([drift]), jacobian @ at.v)


class RollingOnTurntable(RollingContact):
    """Rolling on a plane that turns about its normal through the world's origin, at a steady rate.

    The shell's point moves with the plane's: v_o + w x rho = rate n x (x_o + rho), affine rows.

    Args:
        model, frame_id, surface, ground, name: as of `RollingContact`; the ground is a plane.
        rate: of the turn about the normal [rad/s].

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.turntable_ball(rate=2.0).model.constraints[0].rate
        2.0
    """

    def __init__(
        self,
        model: pin.Model,
        frame_id: int,
        surface: Surface,
        ground: Ground | None = None,
        *,
        rate: float,
        name: str = "contact",
    ) -> None:
        ground = Plane() if ground is None else ground
        if ground.fixed_normal is None:
            raise ConstraintError(f"the turntable's ground is {ground!r}: it must be a Plane.")
        super().__init__(model, frame_id, surface, ground, name=name)
        self.rate = finite("rate", rate, "rad/s")
        self._spin = self.rate * skew(ground.fixed_normal)
        self._axes = np.asarray(ground.basis).T  # type: ignore[attr-defined]

    def rows(self, at: Instant) -> ConstraintRows:
        jacobian, drift, slip = super().rows(at)
        n = self.ground.fixed_normal
        place = at.data.oMf[self.frame_id]
        spatial = pin.computeFrameJacobian(self.model, at.data, at.q, self.frame_id, _WORLD)
        velocity = spatial @ at.v
        u, w = -place.rotation.T @ n, skew(place.rotation.T @ velocity[3:])
        contact = self.surface.contact(u)
        arm = place.rotation @ contact
        arm_rate = place.rotation @ (w @ contact - self.surface.hessian(u) @ (w @ u))
        carried = self._axes @ self._spin @ (place.translation + arm)
        carried_rate = self._axes @ self._spin @ (velocity[:3] + arm_rate)
        return ConstraintRows(jacobian, drift - carried_rate, slip - carried)


class PlanarMotion(Constraint):
    """A frame of a free-flyer that moves in a horizontal plane: v_z = w_x = w_y = 0, holonomic.

    Its force is (F_z, M_x, M_y), what the ground does to all wheels together [N, N m]. A planar
    root joint does the same with three freedoms less.

    Args:
        model: Pinocchio model with a free-flyer.
        frame_id: the frame, whose z axis stays vertical.
        height: of its origin [m].
        name: of the constraint.

    Example:
        >>> import pinocchio as pin
        >>> from rrrobot.rows import PlanarMotion
        >>> PlanarMotion(pin.Model(), 0).holonomic.tolist()
        [True, True, True]
    """

    def __init__(
        self, model: pin.Model, frame_id: int, *, height: float = 0.0, name: str = "plane"
    ) -> None:
        self.model, self.frame_id, self.name = model, frame_id, name
        self.height = finite("height", height, "m")
        self.holonomic = np.ones(3, dtype=bool)

    def rows(self, at: Instant) -> ConstraintRows:
        jacobian = pin.computeFrameJacobian(self.model, at.data, at.q, self.frame_id, _WORLD)[2:5]
        drift = pin.getFrameClassicalAcceleration(self.model, at.data, self.frame_id, _WORLD).vector
        return ConstraintRows(jacobian, drift[2:5], jacobian @ at.v)

    def gap(self, at: Instant) -> Array:
        """What the position is off (3,) [m, rad], of which `rows` are the rate."""
        place = pin.updateFramePlacement(self.model, at.data, self.frame_id)
        up = place.rotation[:, 2]
        return np.array((place.translation[2] - self.height, -up[1], up[0]))


class RelativeRate(Constraint):
    """Two links whose relative angular velocity is driven: (w_2 - w_1) in link 2's axes = S r_dot.

    r is what `legs` prescribe: the motors' own travel. A row of S that is zero is a joint that
    does not turn, or a wheel that does not slip sideways within a ball. Its force is the moment
    on link 2, in its axes [N m].

    Args:
        model: Pinocchio model.
        first, second: frames of the links.
        rates: S (rows, r).
        axes: the rows' axes in link 2's frame (rows, 3); its own x, y and z unless given.
        name: of the constraint.

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.sphericle().model.drives[0].rates.shape
        (3, 2)
    """

    def __init__(
        self,
        model: pin.Model,
        first: int,
        second: int,
        rates: ArrayLike,
        *,
        axes: ArrayLike | None = None,
        name: str = "drive",
    ) -> None:
        self.model, self.name = model, name
        self.first, self.second = first, second
        self.rates = np.asarray(rates, dtype=float)
        self.axes = np.eye(3) if axes is None else np.asarray(axes, dtype=float)
        self.holonomic = np.zeros(len(self.axes), dtype=bool)

    def rows(self, at: Instant) -> ConstraintRows:
        if at.legs is None:
            raise ConstraintError("driven rates need the motion that they follow: give legs=.")
        model, data = self.model, at.data
        one = pin.computeFrameJacobian(model, data, at.q, self.first, _WORLD)[3:]
        two = pin.computeFrameJacobian(model, data, at.q, self.second, _WORLD)[3:]
        turn = pin.updateFramePlacement(model, data, self.second).rotation.T
        alpha = [
            pin.getFrameClassicalAcceleration(model, data, frame, _WORLD).angular
            for frame in (self.first, self.second)
        ]
        relative = (two - one) @ at.v
        # d/dt (R^T w) = R^T (alpha - w_2 x w)
        change = alpha[1] - alpha[0] - skew(two @ at.v) @ relative
        _, rate, acceleration = at.legs
        jacobian = self.axes @ turn @ (two - one)
        drift = self.axes @ turn @ change - self.rates @ acceleration
        return ConstraintRows(jacobian, drift, jacobian @ at.v - self.rates @ rate)


class RollingOnBody(Constraint):
    """A sphere of the robot that rolls on, or inside, another sphere of the same robot.

    d is the unit vector from centre 1 to centre 2, the contact lies at c_1 + R_1 d, and there both
    bodies move alike: v_2 + w_2 x r_2 - v_1 - w_1 x r_1 = 0, r_1 = R_1 d, r_2 = R_2 d inside and
    -R_2 d outside. Three rows along the world's axes: along d the distance of the centres is kept,
    across it there is no slip. The force acts on body 2 [N].

    Args:
        model: Pinocchio model.
        first, second: frames of the spheres' centres.
        radii: (R_1, R_2) [m]; inside, R_1 is the hollow's and greater.
        inside: whether sphere 2 rolls within sphere 1.
        name: of the constraint.

    Raises:
        ConstraintError: a sphere inside a smaller one.

    Example:
        >>> import pinocchio as pin
        >>> from rrrobot.rows import RollingOnBody
        >>> RollingOnBody(pin.Model(), 0, 0, (0.2, 0.05), inside=True).distance
        0.15000000000000002
    """

    def __init__(
        self,
        model: pin.Model,
        first: int,
        second: int,
        radii: tuple[float, float],
        *,
        inside: bool,
        name: str = "inner contact",
    ) -> None:
        self.model, self.name = model, name
        self.first, self.second = first, second
        self.radii = tuple(finite("radii", r, "m", above=0) for r in radii)
        self._sign = 1.0 if inside else -1.0
        self.distance = self.radii[0] - self._sign * self.radii[1]
        if self.distance <= 0:
            raise ConstraintError(
                f"radii are {self.radii} m: a ball rolls only inside a larger hollow."
            )
        self.holonomic = np.zeros(3, dtype=bool)

    def rows(self, at: Instant) -> ConstraintRows:
        model, data = self.model, at.data
        jacobians, places, drifts = [], [], []
        for frame in (self.first, self.second):
            jacobians.append(pin.computeFrameJacobian(model, data, at.q, frame, _WORLD))
            places.append(pin.updateFramePlacement(model, data, frame).translation)
            drifts.append(pin.getFrameClassicalAcceleration(model, data, frame, _WORLD))
        apart = places[1] - places[0]
        length = float(np.linalg.norm(apart))
        d = apart / length
        speed = (jacobians[1] - jacobians[0])[:3] @ at.v
        d_rate = (speed - d * (d @ speed)) / length
        jacobian, drift = np.zeros((3, at.v.size)), np.zeros(3)
        levers = (self.radii[0], self._sign * self.radii[1])
        for j, a, lever, sign in zip(jacobians, drifts, levers, (-1.0, 1.0), strict=True):
            arm, omega = skew(lever * d), j[3:] @ at.v
            jacobian += sign * (j[:3] - arm @ j[3:])
            drift += sign * (a.linear - arm @ a.angular + skew(omega) @ (lever * d_rate))
        return ConstraintRows(jacobian, drift, jacobian @ at.v)

    def gap(self, at: Instant) -> Array:
        """What the distance of the centres is off, along the world's axes (3,) [m]."""
        first, second = (
            pin.updateFramePlacement(self.model, at.data, f).translation
            for f in (self.first, self.second)
        )
        apart = second - first
        length = float(np.linalg.norm(apart))
        return apart * (1.0 - self.distance / length)
