"""Kinematic reduction: the connection of a body on a pivot, eq (14), and its height functions.

A robot whose body turns about a fixed axis, without gravity along the way, keeps its momentum about
that axis. Started from rest it is zero, so the legs' velocity alone gives the body's:

    I(phi) theta_dot + L(phi) phi_dot = 0    <=>    theta_dot = -A(phi) phi_dot,    A = L / I

I is the inertia about the axis, L_k the momentum per unit rate of leg k; both are entries of
Pinocchio's mass matrix. Round a closed path of the legs Stokes' theorem gives the net yaw as an
area integral of the height functions H_jk = d_k A_j - d_j A_k,

    net yaw = - (line integral of A d phi) = sum over j < k of (integral of H_jk d phi_j d phi_k).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.errors import ModelError, ParameterError
from rrrobot.models.single_axis import YawModel
from rrrobot.robot.joints import JointIndex, joint_inertia, joint_inertia_rate
from rrrobot.robot.robot import Robot


class Connection:
    """The connection A(phi) of a robot whose body turns about one axis: theta_dot = -A phi_dot.

    The derivatives are exact: with Pinocchio's Coriolis matrix, dM/dt = C + C^T along the legs'
    velocity.

    Args:
        robot: any robot, or its YawModel.
        axis: of the turn in the base's frame (3,), any length; the vertical of an upright body
            unless given. Other axes are for a body without gravity on a hinge.
        pivot: a point of the axis in the base's frame (3,) [m]; the shell's centre unless given.

    Attributes:
        twist: velocity of the base per unit of the turn, linear then angular, in its frame (6,).
        legs: where the legs are in Pinocchio's q and v.

    Raises:
        ParameterError: no axis, or numbers that are not finite.
        ModelError: the body has no inertia about the axis (when called).

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> A = rr.reduction.Connection(rr.Robot.from_parameters())
        >>> A((np.pi / 2, np.pi / 2)).round(4).tolist()
        [-0.2159, 0.2159]
    """

    def __init__(
        self,
        robot: Robot | YawModel,
        *,
        axis: ArrayLike = (0.0, 0.0, 1.0),
        pivot: ArrayLike | None = None,
    ) -> None:
        self.robot = robot.robot if isinstance(robot, YawModel) else _as_robot(robot)
        direction = vector("axis", axis, 3)
        if not np.any(direction):
            raise ParameterError("axis is zero: give the direction of the turn, as (0, 0, 1).")
        self.axis = direction / np.linalg.norm(direction)
        center = self.robot.shell_placement.translation
        self.pivot = np.array(center) if pivot is None else vector("pivot", pivot, 3, "m")
        self.n_legs = self.robot.n_legs
        self._model = self.robot.model
        self._data = self._model.createData()
        self.legs = JointIndex(self._model, self.robot.legs)
        self.twist = np.concatenate((np.cross(self.pivot, self.axis), self.axis))
        self._q = pin.neutral(self._model)

    def __call__(self, leg_angle: ArrayLike) -> Array:
        """A(phi) (..., legs) of leg angles (..., legs) [rad/rad, or rad/m of prismatic joints]."""
        return self._map(lambda phi: self._terms(phi)[1], leg_angle, (self.n_legs,))

    def inertia(self, leg_angle: ArrayLike) -> Array:
        """I(phi) about the axis (...) [kg m^2]; eq (12)'s g11 on RRRobot."""
        return self._map(lambda phi: np.array(self._terms(phi)[0]), leg_angle, ())

    def derivative(self, leg_angle: ArrayLike) -> Array:
        """dA_k / d phi_j as [..., j, k] (..., legs, legs) [1/rad]."""

        def at(phi: Array) -> Array:
            inertia, value = self._terms(phi)
            units = np.eye(self.n_legs)
            return np.array([self._along(inertia, value, unit) for unit in units])

        return self._map(at, leg_angle, (self.n_legs, self.n_legs))

    def curvature(self, leg_angle: ArrayLike) -> Array:
        """All height functions H_jk = d_k A_j - d_j A_k, antisymmetric (..., legs, legs)."""
        slope = self.derivative(leg_angle)
        return np.swapaxes(slope, -1, -2) - slope

    def height(self, leg_angle: ArrayLike, pair: tuple[int, int] = (0, 1)) -> Array:
        """Height function H_jk = d_k A_j - d_j A_k of a pair of legs (...) [rad/rad^2].

        A small cycle that goes round counter-clockwise in the (phi_j, phi_k) plane turns the body
        by H_jk times its area.

        Args:
            leg_angle: (..., legs) [rad].
            pair: indices (j, k) of two different legs.

        Raises:
            ParameterError: no such pair, or angles of another shape.

        Example:
            >>> import numpy as np, rrrobot as rr
            >>> A = rr.reduction.Connection(rr.Robot.from_parameters())
            >>> A.height(np.array([(0.8, 0.8), (np.pi / 2, np.pi / 2)])).round(5) + 0.0
            array([-0.04037,  0.     ])
        """
        j, k = self.pair(pair)
        unit = np.eye(self.n_legs)
        return self._map(lambda phi: self._flux(phi, unit[j], unit[k]), leg_angle, ())

    def flux(self, leg_angle: ArrayLike, first: ArrayLike, second: ArrayLike) -> Array:
        """Net yaw per unit of a small parallelogram, sum of H_jk first_j second_k (...)."""
        one, two = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
        phi = self._angles(leg_angle)
        out = [self._flux(*row) for row in zip(*map(self._rows, (phi, one, two)), strict=True)]
        return np.reshape(out, phi.shape[:-1])

    def pair(self, pair: tuple[int, int]) -> tuple[int, int]:
        """The pair, checked."""
        numbers = tuple(pair) if np.ndim(pair) == 1 else ()
        if (
            len(numbers) != 2
            or any(isinstance(i, bool) or not isinstance(i, (int, np.integer)) for i in numbers)
            or not all(0 <= i < self.n_legs for i in numbers)
            or numbers[0] == numbers[1]
        ):
            raise ParameterError(
                f"pair is {pair!r}: it must be two different legs among 0 .. {self.n_legs - 1}."
            )
        return int(numbers[0]), int(numbers[1])

    def _terms(self, phi: Array) -> tuple[float, Array]:
        """(I, A) at one posture."""
        self.legs.write(self._q, phi)
        mass = joint_inertia(self._model, self._data, self._q)
        inertia, momentum = self._project(mass)
        scale = float(np.abs(mass).max())
        if not inertia > 1e-14 * scale:
            raise ModelError(
                f"the body has no inertia about the axis {self.axis.tolist()} with the legs at "
                f"{phi.tolist()}: its turn is undefined there; give it a mass off the axis."
            )
        return inertia, momentum / inertia

    def _project(self, mass: Array) -> tuple[float, Array]:
        row = self.twist @ mass[:6]
        return float(row[:6] @ self.twist), row[self.legs.v]

    def _along(self, inertia: float, value: Array, direction: Array) -> Array:
        """Derivative of A along a direction; the posture is that of the last `_terms`."""
        v = np.zeros(self._model.nv)
        v[self.legs.v] = direction
        inertia_rate, momentum_rate = self._project(
            joint_inertia_rate(self._model, self._data, self._q, v)
        )
        return (momentum_rate - inertia_rate * value) / inertia

    def _flux(self, phi: Array, one: Array, two: Array) -> Array:
        inertia, value = self._terms(phi)
        along_two = self._along(inertia, value, two) @ one
        return np.array(along_two - self._along(inertia, value, one) @ two)

    def _angles(self, leg_angle: ArrayLike) -> Array:
        phi = np.asarray(leg_angle, dtype=float)
        if phi.ndim == 0 or phi.shape[-1] != self.n_legs or not np.all(np.isfinite(phi)):
            raise ParameterError(
                f"leg_angle has shape {phi.shape}: it must hold finite numbers, the last axis one "
                f"for each of the {self.n_legs} legs."
            )
        return phi

    def _rows(self, array: Array) -> Array:
        return array.reshape(-1, self.n_legs)

    def _map(
        self, function: Callable[[Array], Array], leg_angle: ArrayLike, shape: tuple[int, ...]
    ) -> Array:
        phi = self._angles(leg_angle)
        values = [function(row) for row in self._rows(phi)]
        return np.reshape(np.array(values, dtype=float), (*phi.shape[:-1], *shape))


def as_connection(source: Connection | Robot | YawModel) -> Connection:
    """The connection itself, or that of a robot about the vertical through its shell's centre."""
    return source if isinstance(source, Connection) else Connection(source)


def _as_robot(robot: object) -> Robot:
    if not isinstance(robot, Robot):
        what = getattr(robot, "name", type(robot).__name__)
        raise ModelError(
            f"a connection needs a Robot or its YawModel, not {what!r}: of RRRobot's models only "
            "yaw has a symmetry that gravity keeps; see `reducibility`. For a body without gravity "
            "on another hinge, give the Robot and axis=."
        )
    return robot


def rotation_connection(robot: Robot, leg_angle: ArrayLike) -> Array:
    """Connection of a body free to turn about a point, without gravity: omega = -A(phi) phi_dot.

        A = I^-1 L   (3, legs),   I the inertia about the shell's centre, L the legs' momentum

    omega is in the body's frame. The symmetry is the whole rotation group: the turn of a cycle
    depends on the order of its parts, so there is no area integral, but it is as kinematic as yaw.

    Args:
        robot: any robot.
        leg_angle: (legs,) [rad].

    Raises:
        ModelError: the body has no inertia about some axis.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> up = (np.pi / 2, np.pi / 2)
        >>> rr.reduction.rotation_connection(rr.Robot.from_parameters(), up).round(3) + 0.0
        array([[ 0.   ,  0.   ],
               [-0.104, -0.104],
               [-0.216,  0.216]])
    """
    parts = [Connection(robot, axis=axis) for axis in np.eye(3)]
    model, data, q = robot.model, robot.model.createData(), pin.neutral(robot.model)
    JointIndex(model, robot.legs).write(q, vector("leg_angle", leg_angle, robot.n_legs, "rad"))
    mass = joint_inertia(model, data, q)
    twists = np.array([part.twist for part in parts])
    rows = twists @ mass[:6]
    inertia = rows[:, :6] @ twists.T
    if np.linalg.cond(inertia) > 1e12:
        raise ModelError("the body has no inertia about some axis: its turn is undefined.")
    return np.asarray(np.linalg.solve(inertia, rows[:, parts[0].legs.v]))
