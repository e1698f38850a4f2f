"""The motion linearised: dx/dt = A x + B u, y = C x + D u about a state, torques as inputs.

x is a deviation of the minimal state: a small rotation of the body in its own axes, the contact
point, and the leg angles; then the quasi-velocities and the leg rates. u is a deviation of the
motor torques, y of (roll, pitch, yaw, leg angles). Derivatives are central differences,
extrapolated by Richardson from the steps 2 h and h.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.drive.torques import LegTorques
from rrrobot.errors import ModelError
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.models.recombined import DecoupledModels
from rrrobot.rotations import euler_from_quaternion
from rrrobot.simulation.flow import Flow
from rrrobot.simulation.state import State

_STEP = 2e-3
"""Of the differences, relative to 1 or to the size of a number. With two extrapolations the error
of the formula is about its sixth power, and that of rounding 1e-16 over it."""


class Linearisation(NamedTuple):
    """State-space matrices; `control.ss(*lin)` takes them.

    x is (rotation or pose, contact point, leg angles, quasi-velocities, leg rates), see the module:
    n = 8 + 2 legs for the full model.
    """

    A: Array
    """(n, n)"""
    B: Array
    """(n, legs)"""
    C: Array
    """(3 + legs, n)"""
    D: Array
    """(3 + legs, legs), zero"""


def linearise(
    model: Model,
    *,
    leg_angle: ArrayLike,
    leg_rate: ArrayLike = 0.0,
    leg_torque: ArrayLike | None = None,
    euler: ArrayLike = (0.0, 0.0, 0.0),
    position: ArrayLike = (0.0, 0.0),
    start: str | ArrayLike = "rest",
    state: State | None = None,
) -> Linearisation:
    """Linearise a model with free legs about a state, such as an equilibrium.

    Along a trajectory, give each of its samples as `state`, with the torques there: the matrices
    then are those of the deviation from the trajectory, in the body's axes as they turn.

    Args:
        model: any with torque-driven legs.
        leg_angle, leg_rate: (legs,) [rad, rad/s].
        leg_torque: (legs,) [N m]; those that hold the legs against acceleration if None.
        euler, position, start: as for `simulate`.
        state: instead of leg_angle, leg_rate, euler, position and start: of a torque-driven run.

    Returns:
        A, B, C, D.

    Raises:
        ModelError: decoupled models, which have no free legs; a state of another model.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> model = rr.RollModel(rr.Robot.from_parameters(), damping=None)
        >>> A, B, C, D = rr.linearise(model, leg_angle=(np.pi / 2, np.pi / 2))
        >>> A.shape, B.shape, C.shape, D.shape
        ((8, 8), (8, 2), (5, 8), (5, 2))
    """
    if isinstance(model, DecoupledModels):
        raise ModelError("decoupled models have no free legs: linearise another model.")
    n = model.n_legs
    if state is None:
        angle = vector("leg_angle", leg_angle, n, "rad", broadcast=True)
        rate = vector("leg_rate", leg_rate, n, "rad/s", broadcast=True)
        drive = LegTorques(np.zeros(n), angle=angle, rate=rate)
        y = Flow(model, drive).start(start=start, euler=euler, position=position).vector
    else:
        state.require(model, torque_driven=True)
        y = state.vector
    pose, quasi, legs = model.split(y)
    if leg_torque is None:
        torque = _holding(model, pose, quasi, legs)
    else:
        torque = vector("leg_torque", leg_torque, n, "N m", broadcast=True)
    chart = _Chart(model, y)

    def rate_of(x: Array) -> Array:
        return chart.rate(x[:-n] if n else x, torque + x[x.size - n :])

    whole = _jacobian(rate_of, np.concatenate((np.zeros(chart.size), np.zeros(n))))
    outputs = _jacobian(chart.outputs, np.zeros(chart.size))
    return Linearisation(
        whole[:, : chart.size], whole[:, chart.size :], outputs, np.zeros((3 + n, n))
    )


class _Chart:
    """Coordinates x (n,) of states near a given one, in which it is zero.

    The rotation is R exp(x): its rate is the inverse of exp's derivative times the body's angular
    velocity; relative to axes that turn with the given motion, the deviation's.
    """

    def __init__(self, model: Model, y: Array) -> None:
        self.model = model
        self.pose, self.quasi, self.legs = (part.copy() for part in model.split(y))
        self._turns = isinstance(model, FullModel)
        self._n_pose = model.n_pose - self._turns
        self.size = self._n_pose + model.n_quasi + self.legs.size
        self._omega0 = self.quasi

    def _state(self, x: Array) -> tuple[Array, Array, Array]:
        n, m = self.model.n_legs, self._n_pose
        at, speeds = x[: m + n], x[m + n :]
        if self._turns:
            turned = _times(self.pose[:4], _exp(at[:3]))
            pose = np.concatenate((turned, self.pose[4:] + at[3:m]))
        else:
            pose = self.pose + at[:m]
        k = self.model.n_quasi
        legs = self.legs + np.concatenate((at[m:], speeds[k:]))
        return pose, self.quasi + speeds[:k], legs

    def rate(self, x: Array, torque: Array) -> Array:
        """dx/dt (n,), less that of the given state's own motion where x turns with it."""
        model, n, m = self.model, self.model.n_legs, self._n_pose
        pose, quasi, legs = self._state(x)
        place = model.place(pose)
        found = model.dynamics(
            place, quasi, leg_angle=legs[:n], leg_rate=legs[n:], leg_torque=torque
        )
        rate = model.pose_rate(place, pose, quasi)
        if self._turns:
            # The given motion turns with omega_0: R = R_0 exp(x), so that with its own axes
            # J(x) x_dot = omega - exp(-x) omega_0.
            own = _rotated(_exp(-x[:3]), self._omega0)
            rate = np.concatenate((_inverse_right(x[:3]) @ (quasi - own), rate[4:]))
        accelerations = (
            model.quasi_acceleration(found.acceleration),
            found.acceleration[model.legs.v],
        )
        return np.concatenate((rate[:m], legs[n:], *accelerations))

    def outputs(self, x: Array) -> Array:
        """Roll, pitch, yaw and leg angles (3 + legs,)."""
        pose, _, legs = self._state(x)
        now = euler_from_quaternion(self.model.quaternions(self.pose[None])[0])
        return np.concatenate((self.model.turned(pose[None], now)[0], legs[: self.model.n_legs]))


def _holding(model: Model, pose: Array, quasi: Array, legs: Array) -> Array:
    """Torques (legs,) under which the legs do not accelerate."""
    from rrrobot.drive.gaits import LegMotion

    n = model.n_legs
    still = LegMotion(legs[:n], legs[n:], np.zeros(n))
    return np.asarray(model.dynamics(model.place(pose), quasi, still).leg_torque)


def _jacobian(function: Callable[[Array], Array], at: Array) -> Array:
    """Central differences with steps 4 h, 2 h and h, extrapolated twice; error of order h^6."""

    def differences(h: float) -> Array:
        steps = h * np.eye(at.size)
        return np.array([(function(at + d) - function(at - d)) / (2 * h) for d in steps]).T

    coarse, middle, fine = (differences(k * _STEP) for k in (4, 2, 1))
    once, again = (4 * middle - coarse) / 3, (4 * fine - middle) / 3
    return np.asarray((16 * again - once) / 15)


def _exp(x: Array) -> Array:
    """Quaternion (x, y, z, w) of a rotation vector (3,)."""
    half = 0.5 * x
    size = float(np.linalg.norm(half))
    return np.append(half * np.sinc(size / np.pi), np.cos(size))


def _times(a: Array, b: Array) -> Array:
    """Product of quaternions (x, y, z, w)."""
    u, v = a[:3], b[:3]
    return np.append(a[3] * v + b[3] * u + np.cross(u, v), a[3] * b[3] - u @ v)


def _rotated(q: Array, v: Array) -> Array:
    """Vector turned by a quaternion."""
    return np.asarray(v + 2 * np.cross(q[:3], np.cross(q[:3], v) + q[3] * v))


def _inverse_right(x: Array) -> Array:
    """Inverse of the right Jacobian of exp, up to x^4, for small x: I + [x]/2 + [x]^2/12 + ..."""
    from rrrobot.rotations import skew

    s = skew(x)
    return np.asarray(np.eye(3) + s / 2 + s @ s / 12 * (1 + x @ x / 60))
