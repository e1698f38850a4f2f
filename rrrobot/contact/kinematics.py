"""Contact kinematics alone, eqs (2)-(5): a body's rotation -> the path of its contact point.

A sphere that rolls without slip on level ground moves its contact point with

    x_dot = r cos(pitch) sin(yaw) roll_rate + r cos(yaw) pitch_rate
    y_dot = -r cos(pitch) cos(yaw) roll_rate + r sin(yaw) pitch_rate

(the paper's eq (5) prints cos(roll) for cos(pitch) in the second line). For any strictly convex
shell on any smooth ground the curvatures of both decide; Montana's equation.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.contact.surfaces import Surface
from rrrobot.errors import ParameterError
from rrrobot.integrate import Stepping, integrate
from rrrobot.rotations import skew


def contact_velocity(
    surface: Surface,
    rotation: Array,
    omega_world: Array,
    normal: Array,
    curvature: Array | None = None,
) -> Array:
    """Velocity of the contact point along the ground (3,) [m/s], in the world.

        (1 + H B) P_dot = H (Omega x n)

    with H = R d2h R^T of the shell and B of the ground; r Omega x n for a sphere on a plane. The
    same vector is the contact's rate over the body, R x_dot, as there is no slip.

    Args:
        surface: the shell.
        rotation: R_world_shell (3, 3).
        omega_world: angular velocity (3,) [rad/s].
        normal: unit normal of the ground at the contact (3,).
        curvature: B of the ground there (3, 3) [1/m]; a plane's if None.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> up = np.array([0.0, 0.0, 1.0])
        >>> spin = np.array([0.0, 2.0, 0.0])
        >>> forward = rr.contact.contact_velocity(rr.Sphere(0.12), np.eye(3), spin, up)
        >>> forward.round(3).tolist()
        [0.24, 0.0, 0.0]
    """
    hessian = rotation @ surface.hessian(-rotation.T @ normal) @ rotation.T
    along = hessian @ skew(omega_world) @ normal
    if curvature is None:
        return along
    return np.asarray(np.linalg.solve(np.eye(3) + hessian @ curvature, along))


def sphere_contact_rate(radius: float, euler: ArrayLike, euler_rates: ArrayLike) -> Array:
    """(x_dot, y_dot) of a sphere's contact point by eqs (2)-(5) (..., 2) [m/s].

    Args:
        radius: r [m].
        euler: roll, pitch, yaw (..., 3) [rad].
        euler_rates: (..., 3) [rad/s].

    Example:
        >>> import rrrobot as rr
        >>> rr.contact.sphere_contact_rate(0.12, (0, 0, 0), (1.0, 0, 0)).tolist()
        [0.0, -0.12]
    """
    _, pitch, yaw = np.moveaxis(np.asarray(euler, dtype=float), -1, 0)
    roll_rate, pitch_rate, _ = np.moveaxis(np.asarray(euler_rates, dtype=float), -1, 0)
    c, s, along = np.cos(yaw), np.sin(yaw), np.cos(pitch) * roll_rate
    return radius * np.stack((s * along + c * pitch_rate, s * pitch_rate - c * along), axis=-1)


def contact_path(
    radius: float,
    time: ArrayLike,
    euler: ArrayLike | Callable[[float], tuple[ArrayLike, ArrayLike]],
    *,
    position: ArrayLike = (0.0, 0.0),
    stepping: Stepping | None = None,
) -> Array:
    """Path of a sphere's contact point under a given rotation (n, 2) [m].

    Args:
        radius: r [m].
        time: instants (n,) [s], increasing.
        euler: the rotation, either as samples of roll, pitch, yaw (n, 3) [rad] without jumps, or
            as a function of time that returns (euler (3,), euler_rates (3,)). Samples are joined
            by a quintic spline and integrated by Gauss-Legendre quadrature, so the error falls
            with at least the sixth power of the interval; a function is integrated by DOP853.
        position: contact point at time[0] (2,) [m].
        stepping: of the integration of a function.

    Raises:
        ParameterError: fewer than 6 samples, times that do not increase, wrong shapes, values
            that are not finite.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> time = np.linspace(0, 1, 11)
        >>> turn = np.column_stack((0 * time, time, 0 * time))
        >>> rr.contact.contact_path(0.12, time, turn)[-1].round(6).tolist()
        [0.12, 0.0]
    """
    radius = finite("radius", radius, "m", above=0)
    start = vector("position", position, 2, "m")
    instants = np.asarray(time, dtype=float)
    increasing = instants.ndim == 1 and instants.size >= 2 and np.all(np.diff(instants) > 0)
    if not increasing or not np.all(np.isfinite(instants)):
        raise ParameterError(
            "time must be one-dimensional, with at least 2 finite, increasing instants."
        )
    if not callable(euler):
        return start + _sampled_path(radius, instants, np.asarray(euler, dtype=float))
    rotation = euler

    def rate(t: float, _: Array) -> Array:
        angles, rates = rotation(t)
        at = f"at t = {t:.6g} s"
        return sphere_contact_rate(
            radius, vector(f"euler {at}", angles, 3), vector(f"euler_rates {at}", rates, 3)
        )

    result = integrate(rate, start, instants, stepping or Stepping(), observer=None)
    if result.stop is not None:
        raise ParameterError(f"the path could not be integrated: {result.stop}.")
    return result.states


def _sampled_path(radius: float, time: Array, euler: Array) -> Array:
    from scipy.interpolate import make_interp_spline

    if euler.shape != (time.size, 3) or time.size < 6 or not np.all(np.isfinite(euler)):
        raise ParameterError(
            f"euler has shape {euler.shape} for {time.size} instants: it must be finite, (n, 3) "
            "with n >= 6."
        )
    spline = make_interp_spline(time, euler, k=5)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    half = 0.5 * np.diff(time)
    at = (time[:-1] + half)[:, None] + half[:, None] * nodes
    rates = sphere_contact_rate(radius, spline(at), spline.derivative()(at))
    steps = np.einsum("ij,ijk->ik", half[:, None] * weights, rates)
    return np.vstack((np.zeros(2), np.cumsum(steps, axis=0)))
