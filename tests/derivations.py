"""RRRobot's equations of motion, derived by hand from five point masses.

This is the touchstone of the tests: it shares no code with the library and uses no rigid-body
dynamics software, only SymPy for the derivatives of five positions.

Frames and coordinates. World: z up. Body: origin at the sphere's centre, x forward, y left (the
leg-rotation axis), z up. R_world_body = Rz(yaw) Ry(pitch) Rx(roll). Leg 1 hinges at (0, -b, 0),
leg 2 at (0, +b, 0); its tip is at hinge + l (cos phi, 0, sin phi), so phi = pi/2 points up. The
battery is at (0, 0, -r). The generalised coordinates are q = (roll, pitch, yaw, phi1, phi2), the
generalised speeds are u = q_dot; a single-axis model keeps one of the three angles, the other two
are zero.

Kane's method. Point mass i has the velocity v_i(q, u), linear in u, so that

    partial velocity    P_i = dv_i/du
    acceleration        a_i = P_i u_dot + b_i,    b_i = (dv_i/dq) u

and the generalised active forces (gravity, damping, motors) balance the inertia forces:

    sum_i P_i^T (m_i g - m_i a_i) + Q = 0    =>    M u_dot = f,
    M = sum_i m_i P_i^T P_i,    f = sum_i m_i P_i^T (g - b_i) + Q

The sphere's centre moves with v_c = r omega x z when it rolls (the contact point's material
velocity v_c + omega x (-r z) vanishes) and with v_c = 0 when it is pivoted. Rolling enters
through v_c alone, before the partial velocities are taken, hence no multipliers; the contact force
drops out of the balance because it acts where the partial velocities vanish, and it is recovered
from Newton's law, F = sum_i m_i (a_i - g).

SymPy makes positions, P_i and b_i; the sums over the masses are done in numbers.
"""

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
Axis = Literal["roll", "pitch", "yaw"]


@dataclass(frozen=True, kw_only=True)
class PointMassRobot:
    """Masses [kg], lengths [m] and gravity [m/s^2] of RRRobot; defaults are the paper's Table 2.

    Pairs are (leg 1, leg 2). The hip offset b may differ from the shell radius r, and the legs may
    differ from each other.
    """

    battery_mass: float = 0.3
    servo_masses: tuple[float, float] = (0.053, 0.053)
    leg_masses: tuple[float, float] = (0.057, 0.057)
    leg_lengths: tuple[float, float] = (0.1, 0.1)
    shell_radius: float = 0.12
    hip_offset: float = 0.12
    gravity: float = 9.81

    @property
    def masses(self) -> Array:
        """The five masses (5,) [kg]: battery, servo 1, servo 2, leg tip 1, leg tip 2."""
        return np.array([self.battery_mass, *self.servo_masses, *self.leg_masses])

    @property
    def lengths(self) -> tuple[float, float, float, float]:
        """Shell radius r, hip offset b and leg lengths l1, l2 [m]."""
        return (self.shell_radius, self.hip_offset, *self.leg_lengths)


class Motion(NamedTuple):
    """Instantaneous motion and forces; k is 3 free body angles, or 1 in a single-axis model."""

    theta_ddot: Array
    """Second derivative of the Euler angles (3,), a scalar in a single-axis model [rad/s^2]."""
    omega_dot: Array
    """World angular acceleration of the body (3,) [rad/s^2]."""
    phi_ddot: Array
    """Leg accelerations (2,) [rad/s^2]."""
    contact_force: Array
    """World force of the ground, or of the pivot and guides, on the robot (3,) [N]."""
    leg_torque: Array
    """Motor torques (2,), the generalised forces on phi without the legs' damping [N m]."""
    energy: float
    """Kinetic plus potential energy, the latter zero at z = 0 [J]."""
    mass_matrix: Array
    """Mass matrix (k + 2, k + 2) of the constrained system, ordered (angles, phi1, phi2)."""


class Path(NamedTuple):
    """A simulated motion at n instants."""

    time: Array
    """Time (n,) [s]."""
    theta: Array
    """Euler angles (n, 3): roll, pitch, yaw, continuous [rad]."""
    contact_point: Array
    """Contact point (n, 2) in the plane, starting at the origin [m]."""


class _Variant(NamedTuple):
    """What tells the models apart."""

    angles: tuple[int, ...]  # which of roll, pitch, yaw are free; the others are zero
    rolls: bool  # the sphere rolls on z = 0; otherwise its centre is fixed at height r
    has_gravity: bool


_VARIANTS = {
    "full": _Variant((0, 1, 2), True, True),
    "pivoting": _Variant((0, 1, 2), False, True),
    "roll": _Variant((0,), True, True),
    "pitch": _Variant((1,), True, True),
    "yaw": _Variant((2,), False, False),
}


class _Kinematics(NamedTuple):
    """Kinematics in one state, the five points stacked: 15 = 5 points x (x, y, z); n speeds."""

    heights: Array  # (5,) z of each point
    partial: Array  # (15, n) partial velocities P_i
    remainder: Array  # (15,) accelerations at u_dot = 0, b_i
    omega_partial: Array  # (3, n) d omega / du
    omega_remainder: Array  # (3,) angular acceleration at u_dot = 0


def _rotation(roll: sp.Expr, pitch: sp.Expr, yaw: sp.Expr) -> tuple[sp.Matrix, sp.Matrix]:
    """R_world_body = Rz Ry Rx, and E of omega_world = E (roll_dot, pitch_dot, yaw_dot).

    Yaw turns about the world's z, pitch about Rz y and roll about Rz Ry x: the columns of E.
    """
    c, s = [sp.cos(a) for a in (roll, pitch, yaw)], [sp.sin(a) for a in (roll, pitch, yaw)]
    Rx = sp.Matrix([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    Ry = sp.Matrix([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
    Rz = sp.Matrix([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
    x, y, z = (sp.eye(3)[:, i] for i in range(3))
    return Rz * Ry * Rx, sp.Matrix.hstack(Rz * Ry * x, Rz * y, z)


@functools.cache
def _derive(name: str, modules: str = "math") -> Callable[..., tuple[list, ...]]:
    """Derive a variant's kinematics once: a function of (q, u, r, b, l1, l2), giving lists.

    With modules "numpy" each entry may be an array over states.
    """
    variant = _VARIANTS[name]
    free = [sp.Symbol(f"theta{i}") for i in variant.angles]
    phi = list(sp.symbols("phi1 phi2"))
    q = sp.Matrix(free + phi)
    u = sp.Matrix([sp.Symbol(f"{s.name}_dot") for s in q])
    r, b, l1, l2 = sp.symbols("r b l1 l2")

    theta, theta_dot = [sp.S.Zero] * 3, [sp.S.Zero] * 3
    for k, i in enumerate(variant.angles):
        theta[i], theta_dot[i] = q[k], u[k]
    R, E = _rotation(*theta)
    omega = E * sp.Matrix(theta_dot)

    battery = sp.Matrix([0, 0, -r])
    hip1, hip2 = sp.Matrix([0, -b, 0]), sp.Matrix([0, b, 0])
    tip1 = hip1 + l1 * sp.Matrix([sp.cos(phi[0]), 0, sp.sin(phi[0])])
    tip2 = hip2 + l2 * sp.Matrix([sp.cos(phi[1]), 0, sp.sin(phi[1])])
    arms = sp.Matrix.vstack(*(R * point for point in (battery, hip1, hip2, tip1, tip2)))

    z = sp.Matrix([0, 0, 1])
    v_centre = r * omega.cross(z) if variant.rolls else sp.zeros(3, 1)
    velocity = sp.Matrix.vstack(*[v_centre] * 5) + arms.jacobian(q) * u

    heights = [r + arms[3 * i + 2] for i in range(5)]
    parts = (
        heights,
        velocity.jacobian(u).tolist(),
        list(velocity.jacobian(q) * u),
        omega.jacobian(u).tolist(),
        list(omega.jacobian(q) * u),
    )
    return sp.lambdify((list(q), list(u), r, b, l1, l2), parts, modules=modules, cse=True)


def _kinematics(name: str, robot: PointMassRobot, q: Array, u: Array) -> _Kinematics:
    """Evaluate a variant's kinematics in the state (q, u)."""
    parts = _derive(name)(q.tolist(), u.tolist(), *robot.lengths)
    return _Kinematics(*(np.array(part, dtype=float) for part in parts))


def _motion(
    name: str,
    robot: PointMassRobot,
    theta: ArrayLike,
    theta_dot: ArrayLike,
    phi: ArrayLike,
    phi_dot: ArrayLike,
    phi_ddot: ArrayLike | None,
    leg_torque: ArrayLike | None,
    damping: ArrayLike,
    leg_damping: ArrayLike,
) -> Motion:
    """Solve M u_dot = f for the unknown half of (phi_ddot, leg_torque) and for theta_ddot."""
    if (phi_ddot is None) == (leg_torque is None):
        raise ValueError(
            "give exactly one of phi_ddot (prescribed legs) and leg_torque (free legs)"
        )
    variant = _VARIANTS[name]
    k = len(variant.angles)
    q = np.concatenate([_vector("theta", theta, k), _vector("phi", phi, 2)])
    u = np.concatenate([_vector("theta_dot", theta_dot, k), _vector("phi_dot", phi_dot, 2)])
    viscosity = np.concatenate(
        [_vector("damping", damping, k), _vector("leg_damping", leg_damping, 2)]
    )
    kin = _kinematics(name, robot, q, u)
    masses = robot.masses
    P, m = kin.partial, np.repeat(masses, 3)
    g = np.array([0.0, 0.0, -robot.gravity if variant.has_gravity else 0.0])
    M = P.T @ (m[:, None] * P)
    f = P.T @ (m * (np.tile(g, 5) - kin.remainder)) - viscosity * u

    if leg_torque is None:
        legs = _vector("phi_ddot", phi_ddot, 2)
        body = np.linalg.solve(M[:k, :k], f[:k] - M[:k, k:] @ legs)
        u_dot = np.concatenate([body, legs])
        torque = M[k:] @ u_dot - f[k:]
    else:
        torque = _vector("leg_torque", leg_torque, 2)
        u_dot = np.linalg.solve(M, f + np.concatenate([np.zeros(k), torque]))

    acceleration = (P @ u_dot + kin.remainder).reshape(5, 3)
    return Motion(
        theta_ddot=u_dot[:3] if k == 3 else u_dot[0],
        omega_dot=kin.omega_partial @ u_dot + kin.omega_remainder,
        phi_ddot=u_dot[k:],
        contact_force=masses @ (acceleration - g),
        leg_torque=torque,
        energy=float(0.5 * u @ M @ u - g[2] * (masses @ kin.heights)),
        mass_matrix=M,
    )


def _vector(name: str, value: ArrayLike | None, size: int) -> Array:
    """The argument as a float vector; a scalar is accepted where one entry is wanted."""
    vector = np.array(value, dtype=float)
    if vector.shape != (size,) and not (size == 1 and vector.shape == ()):
        raise ValueError(f"{name} has shape {vector.shape}, expected {(size,) if size > 1 else ()}")
    return vector.reshape(size)


def full_model(
    robot: PointMassRobot,
    theta: ArrayLike,
    theta_dot: ArrayLike,
    phi: ArrayLike,
    phi_dot: ArrayLike,
    phi_ddot: ArrayLike | None = None,
    leg_torque: ArrayLike | None = None,
    damping: ArrayLike = (0.0, 0.0, 0.0),
    leg_damping: ArrayLike = (0.0, 0.0),
) -> Motion:
    """The sphere rolls without slip on z = 0: eqs (1)-(3), the contact force eliminated.

        M(theta, phi) (theta_ddot, phi_ddot) = f,    v_c = r omega x z

    Arguments: theta, theta_dot (3,) [rad, rad/s], Euler angles (roll, pitch, yaw) and rates; phi,
    phi_dot (2,) [rad, rad/s], legs; exactly one of phi_ddot (2,) [rad/s^2], prescribed legs, and
    leg_torque (2,) [N m], free legs; damping (3,) and leg_damping (2,) [N m s/rad], generalised
    forces -k theta_dot and -k phi_dot. The Euler rates, and so M, are singular at pitch = +-pi/2.
    """
    return _motion(
        "full", robot, theta, theta_dot, phi, phi_dot, phi_ddot, leg_torque, damping, leg_damping
    )


def pivoting_model(
    robot: PointMassRobot,
    theta: ArrayLike,
    theta_dot: ArrayLike,
    phi: ArrayLike,
    phi_dot: ArrayLike,
    phi_ddot: ArrayLike | None = None,
    leg_torque: ArrayLike | None = None,
    damping: ArrayLike = (0.0, 0.0, 0.0),
    leg_damping: ArrayLike = (0.0, 0.0),
) -> Motion:
    """The sphere's centre is a spherical joint fixed at height r: eq (6), v_c = 0.

    Arguments as for `full_model`; contact_force is the pivot's reaction.
    """
    return _motion(
        "pivoting",
        robot,
        theta,
        theta_dot,
        phi,
        phi_dot,
        phi_ddot,
        leg_torque,
        damping,
        leg_damping,
    )


def single_axis_model(
    axis: Axis,
    robot: PointMassRobot,
    theta: float,
    theta_dot: float,
    phi: ArrayLike,
    phi_dot: ArrayLike,
    phi_ddot: ArrayLike | None = None,
    leg_torque: ArrayLike | None = None,
    damping: float = 0.0,
    leg_damping: ArrayLike = (0.0, 0.0),
) -> Motion:
    """One Euler angle is free, the other two are held at zero by frictionless guides: eq (11).

    Roll and pitch roll on z = 0 (v_c = r omega x z); yaw turns about the fixed centre (v_c = 0)
    without gravity. Arguments as for `full_model` with scalar theta [rad], theta_dot [rad/s] and
    damping [N m s/rad]; theta_ddot is a scalar, mass_matrix is (3, 3) and contact_force is the
    force of the ground (or pivot) and the guides together.
    """
    if axis not in ("roll", "pitch", "yaw"):
        raise ValueError(f"axis is {axis!r}, expected 'roll', 'pitch' or 'yaw'")
    return _motion(
        axis, robot, theta, theta_dot, phi, phi_dot, phi_ddot, leg_torque, damping, leg_damping
    )


def simulate_full(
    robot: PointMassRobot,
    offset: ArrayLike,
    amplitude: ArrayLike,
    omega: float,
    phase: ArrayLike,
    duration: float,
    n_out: int,
    damping: ArrayLike,
) -> Path:
    """Integrate `full_model` with the legs following phi = offset + amplitude sin(omega t + phase).

    The state is (roll, pitch, yaw, their rates, contact point); the contact point (x, y) runs below
    the centre, (x_dot, y_dot) = r (omega_y, -omega_x). The body starts upright at the origin, set
    in motion by the impulse that gives the legs their speed, so that the momentum conjugate to the
    Euler rates is zero:

        M_tt theta_dot = -M_tl phi_dot

    Arguments: offset, amplitude, phase [rad], a scalar or one per leg (2,); omega [rad/s];
    duration [s]; n_out instants from 0 to duration, both included; damping (3,) [N m s/rad].
    """
    offset, amplitude, phase = (np.broadcast_to(a, (2,)) for a in (offset, amplitude, phase))

    def legs(t: float) -> tuple[Array, Array, Array]:
        angle = omega * t + phase
        swing = amplitude * np.sin(angle)
        return offset + swing, amplitude * omega * np.cos(angle), -(omega**2) * swing

    def rate(t: float, state: Array) -> Array:
        theta, theta_dot = state[:3], state[3:6]
        theta_ddot = full_model(robot, theta, theta_dot, *legs(t), damping=damping).theta_ddot
        return np.concatenate([theta_dot, theta_ddot, _contact_velocity(robot, theta, theta_dot)])

    upright = np.zeros(3)
    phi, phi_dot, phi_ddot = legs(0.0)
    M = full_model(robot, upright, upright, phi, phi_dot, phi_ddot).mass_matrix
    start = np.concatenate([upright, -np.linalg.solve(M[:3, :3], M[:3, 3:] @ phi_dot), [0.0, 0.0]])
    time = np.linspace(0.0, duration, n_out)
    solution = solve_ivp(
        rate, (0.0, duration), start, method="DOP853", t_eval=time, rtol=1e-12, atol=1e-13
    )
    if not solution.success:
        raise RuntimeError(f"the integration stopped at {solution.t[-1]} s: {solution.message}")
    return Path(time, solution.y[:3].T, solution.y[6:].T)


def _contact_velocity(robot: PointMassRobot, theta: Array, theta_dot: Array) -> Array:
    """Velocity (2,) of the contact point [m/s]: r omega x z by components, eqs (2)-(5).

        x_dot = r (cos pitch sin yaw roll_dot + cos yaw pitch_dot)
        y_dot = r (-cos pitch cos yaw roll_dot + sin yaw pitch_dot)

    The paper's eq (5) prints cos roll for the cos pitch of the second row.
    """
    _, pitch, yaw = theta
    along, across = np.cos(pitch) * theta_dot[0], theta_dot[1]
    cy, sy = np.cos(yaw), np.sin(yaw)
    return robot.shell_radius * np.array([sy * along + cy * across, -cy * along + sy * across])
