"""Eq (1) in the paper's own coordinates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.errors import ModelError
from rrrobot.models.full import FullModel
from rrrobot.models.reduced import pivot_radius
from rrrobot.rotations import (
    body_rates_matrix,
    body_rates_matrix_rate,
    rotation_from_euler,
    skew,
)


class PaperEquations(NamedTuple):
    """Terms of eq (1) in the paper's coordinates (x, y, roll, pitch, yaw, legs...)."""

    mass_matrix: Array
    """M(q) (n, n), n = 5 + legs"""
    coriolis: Array
    """C(q, q_dot) (n, n); M_dot - 2 C is skew-symmetric"""
    gravity: Array
    """G(q) (n,)"""
    omega: Array
    """omega^1 and omega^2 of eqs (4)-(5), shape (2, n); eq (5) with its erratum corrected"""
    damping: Array
    """zeta (n,), eq (9)"""


def paper_equations(model: FullModel, q: ArrayLike, q_dot: ArrayLike) -> PaperEquations:
    """The terms of eq (1) in the paper's coordinates.

        M q_ddot + C q_dot + G = tau + (lambda_1 omega^1)^T + (lambda_2 omega^2)^T + zeta

    Args:
        model: of a robot with a spherical shell about the root link's origin, on level ground.
        q: (x, y, roll, pitch, yaw, legs...), shape (5 + legs,) [m, rad]; (x, y) the contact
            point. Pinocchio's free-flyer velocity is v = T(q) q_dot with the height fixed.
        q_dot: its rate [m/s, rad/s]; it need not roll.

    Returns:
        M, C, G, (omega^1, omega^2) and zeta. The tangential contact force is lambda.

    Raises:
        ModelError: the shell is no sphere about the base's origin, or the ground not level.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> terms = rr.paper.paper_equations(model, np.zeros(7), np.zeros(7))
        >>> terms.omega[1].round(3).tolist()
        [0.0, 1.0, 0.12, -0.0, 0.0, 0.0, 0.0]
    """
    n = 5 + model.n_legs
    q, q_dot = vector("q", q, n), vector("q_dot", q_dot, n)
    radius = pivot_radius(model.robot, "full", model.ground)
    if np.any(centre := model.robot.shell_placement.translation):
        raise ModelError(
            "the paper's coordinates are of a robot whose root link's origin is the shell's "
            f"centre; this one's is at {centre.tolist()} m. Take M, C, G in Pinocchio's "
            "coordinates: model.equations."
        )
    euler, rates = q[2:5], q_dot[2:5]
    (_, cp, cy), (_, _, sy) = np.cos(euler), np.sin(euler)
    rotation = rotation_from_euler(euler)
    matrix = body_rates_matrix(euler[0], euler[1])
    omega_body = matrix @ rates
    to_v, to_v_rate = np.zeros((model.model.nv, n)), np.zeros((model.model.nv, n))
    to_v[:3, :2] = rotation.T[:, :2]
    to_v_rate[:3, :2] = (-skew(omega_body) @ rotation.T)[:, :2]
    to_v[3:6, 2:5] = matrix
    to_v_rate[3:6, 2:5] = body_rates_matrix_rate(euler, rates)
    to_v[model.legs.v, 5 + np.arange(model.n_legs)] = 1.0

    configuration = model.configuration(model.make_pose(euler, q[:2]), q[5:])
    v = to_v @ q_dot
    mass, coriolis, gravity = model.equations(configuration, v)
    omega = np.zeros((2, n))
    omega[0, :5] = (1, 0, 0, 0, 0)
    omega[0, 2:4] = -radius * cp * sy, -radius * cy
    omega[1, :5] = (0, 1, 0, 0, 0)
    omega[1, 2:4] = radius * cp * cy, -radius * sy
    zeta = np.zeros(n)
    zeta[2:5] = matrix.T @ model.damping.moment(euler[0], euler[1], omega_body)
    zeta[5:] = -model.damping.leg_coefficient * q_dot[5:]
    return PaperEquations(
        to_v.T @ mass @ to_v,
        to_v.T @ (mass @ to_v_rate + coriolis @ to_v),
        to_v.T @ gravity,
        omega,
        zeta,
    )
