"""Net yaw of a leg motion: by the line integral, by the area integral, by the dynamics."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array, finite
from rrrobot.drive.gaits import Gait, LegMotion
from rrrobot.errors import GaitError, ModelError, ParameterError
from rrrobot.models.single_axis import YawModel
from rrrobot.reduction.connection import Connection, as_connection
from rrrobot.robot.joints import joint_inertia
from rrrobot.robot.robot import Robot

METHODS = ("line", "area", "simulate")
_NODES = 12
_FINEST = 1024
"""Panels of the finest quadrature."""
_CONVERGED = 1e-12


class Span(NamedTuple):
    """A piece of a leg motion in time [s]."""

    start: float
    stop: float


def net_yaw(
    source: Connection | Robot | YawModel,
    gait: Gait,
    *,
    method: str = "line",
    duration: float | None = None,
) -> float:
    """Net turn of the body by a leg motion, one of three ways [rad].

    "line" is -(integral of A(phi) phi_dot dt), "area" the integral of the height functions over the
    cone from the path's middle to the path, so that paths may cross themselves, wind several times
    and move any number of legs; "simulate" integrates the equations of motion of the
    body on its hinge, as the YawModel's.

    Args:
        source: a robot or its connection.
        gait: leg motion; a closed path takes its `period`.
        method: "line", "area" (closed paths only) or "simulate".
        duration: of the motion [s]; its period, or the attribute `duration`, unless given.

    Raises:
        GaitError: the gait does not fit the robot, has no period, or does not close for "area".
        ParameterError: another method; a path so rough that the integral does not converge.
        ModelError: no inertia about the axis, or a simulation that fails.
        ParameterError: the duration is not positive.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> gait = rr.gait("circular")
        >>> methods = ("line", "area", "simulate")
        >>> [round(rr.reduction.net_yaw(robot, gait, method=m), 6) for m in methods]
        [0.010644, 0.010644, 0.010644]
    """
    connection = as_connection(source)
    span = leg_span(connection, gait, duration)
    if method == "line":
        # Pieces between the instants at which a motion is not smooth.
        inside = [float(t) for t in getattr(gait, "knots", ()) if 0 < t < span.stop]
        edges = [span.start, *inside, span.stop]
        pieces = map(Span, edges, edges[1:])
        return float(sum(line_integral(connection, gait, piece) for piece in pieces))
    if method == "area":
        return _area_integral(connection, gait, span)
    if method != "simulate":
        raise ParameterError(f"method is {method!r}: it must be one of {', '.join(METHODS)}.")
    return _simulated(connection, gait, span)


def _simulated(connection: Connection, gait: Gait, span: Span) -> float:
    """Net turn by the equations of motion of the body on its hinge, without gravity.

    With the hinge's twist u in the base's frame, v = (u theta_dot, phi_dot) and Pinocchio's h(q, v)

        u^T M u theta_ddot + u^T M_bl phi_ddot + u^T h = 0,

    at the base's neutral pose, for by symmetry nothing depends on theta. The start is impulsive.
    """
    from scipy.integrate import solve_ivp

    model = connection.robot.model.copy()
    model.gravity.setZero()
    data, q, legs = model.createData(), pin.neutral(model), connection.legs
    twist = connection.twist

    def rate(time: float, y: Array) -> Array:
        motion = gait(time)
        legs.write(q, motion.angle)
        v, a = np.zeros((2, model.nv))
        v[:6], v[legs.v], a[legs.v] = twist * y[1], motion.rate, motion.acceleration
        inertia = twist @ joint_inertia(model, data, q)[:6, :6] @ twist
        moment = twist @ pin.rnea(model, data, q, v, a)[:6]
        return np.array((y[1], -moment / inertia))

    first = gait(span.start)
    y = np.array((0.0, -connection(first.angle) @ first.rate))
    knots = [float(t) for t in getattr(gait, "knots", ()) if span.start < t < span.stop]
    edges = [span.start, *knots, span.stop]
    for start, stop in pairwise(edges):
        run = solve_ivp(rate, (start, stop), y, method="DOP853", rtol=1e-11, atol=1e-13)
        if not run.success:
            raise ModelError(f"the simulation failed at t = {run.t[-1]:.4g} s: {run.message}")
        y = run.y[:, -1]
    return float(y[0])


def leg_span(connection: Connection, gait: Gait, duration: float | None = None) -> Span:
    """The time that a leg motion takes, checked against the robot.

    Raises:
        GaitError: the gait does not fit the robot, or neither repeats nor ends.
    """
    if not isinstance(gait, Gait):
        raise GaitError(f"gait is {type(gait).__name__}: it must be a Gait.")
    if gait.n_legs != connection.n_legs:
        raise GaitError(f"the gait moves {gait.n_legs} legs, the robot has {connection.n_legs}.")
    if duration is not None:
        return Span(0.0, finite("duration", duration, "s", above=0))
    length = gait.period or getattr(gait, "duration", None)
    if length is None:
        raise GaitError(
            "the motion has no end (its period is None): give a gait "
            "with a period, or duration= in seconds."
        )
    return Span(0.0, float(length))


def line_integral(connection: Connection, gait: Callable[[Array], LegMotion], span: Span) -> float:
    """-(integral of A(phi) phi_dot dt) over a span [rad]."""

    def part(times: Array) -> Array:
        motion = gait(times)
        return -np.sum(connection(motion.angle) * motion.rate, axis=-1)

    return integral(part, span)


def yaw_rates(robot: Robot) -> Callable[[Array, Array], Array]:
    """A fast form of -A(phi) phi_dot about the vertical through the shell's centre.

    Args:
        robot: any robot.

    Returns:
        function (angles (n, legs), rates (n, legs)) -> yaw rates (n,) [rad/s].

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> from rrrobot.reduction.yaw import yaw_rates
        >>> up, rate = np.full((1, 2), np.pi / 2), np.array([[1.0, 0.0]])
        >>> yaw_rates(rr.Robot.from_parameters())(up, rate).round(4)
        array([0.2159])
    """
    # Numba loads here, so that it costs nobody who does not use it.
    from rrrobot.momentum.coefficients import N_COEFFICIENTS, fill
    from rrrobot.momentum.tree import tree_of

    tree = tree_of(robot)

    def rate_of(angle: Array, rate: Array) -> Array:
        out = np.empty((len(angle), N_COEFFICIENTS))
        fill(tree, np.ascontiguousarray(angle), np.ascontiguousarray(rate), out)
        # Momentum of the legs about the vertical, and the inertia there.
        return np.asarray(-out[:, 14] / out[:, 5])

    return rate_of


def _area_integral(connection: Connection, gait: Gait, span: Span) -> float:
    ends = gait(np.array(span)).angle
    if np.abs(ends[1] - ends[0]).max() > 1e-9:
        raise GaitError(
            f"the legs end {(ends[1] - ends[0]).tolist()} from where they start: only a closed "
            "path encloses an area; use method='line'."
        )
    middle = gait(np.linspace(*span, 64, endpoint=False)).angle.mean(axis=0)
    nodes, weights = np.polynomial.legendre.leggauss(2 * _NODES)
    radii, weights = (nodes + 1) / 2, weights / 2

    def part(times: Array) -> Array:
        motion = gait(times)
        arm = motion.angle - middle
        total = np.zeros(times.size)
        for radius, weight in zip(radii, weights, strict=True):
            total += weight * radius * connection.flux(middle + radius * arm, arm, motion.rate)
        return total

    return integral(part, span)


def integral(part: Callable[[Array], Array], span: Span) -> float:
    """Composite Gauss-Legendre integral, with panels halved until the value stands still.

    Args:
        part: integrand of times (n,), -> (n,).
        span: of the integral.

    Raises:
        ParameterError: it does not converge.

    Example:
        >>> from rrrobot.reduction.yaw import Span, integral
        >>> round(integral(lambda t: 3 * t**2, Span(0.0, 2.0)), 12)
        8.0
    """
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    panels, last = 4, np.inf
    while panels <= _FINEST:
        edges = np.linspace(*span, panels + 1)
        half = (edges[1] - edges[0]) / 2
        times = (edges[:-1, None] + half * (1 + nodes)).ravel()
        value = float(half * np.sum(part(times).reshape(panels, -1) @ weights))
        if abs(value - last) <= _CONVERGED * max(1.0, abs(value)):
            return value
        panels, last = 2 * panels, value
    raise ParameterError(
        "the integral over the leg motion does not converge: its path is rough or long; give a "
        "shorter duration, or integrate its smooth pieces one by one."
    )
