"""Closed forms: eq (12), eqs (7)-(8), composite periods, static pitch, linear pitch response.

For RRRobot's five point masses, all derived by hand from the parameters, so that they check the
models without sharing their code.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rrrobot.checks import Array, finite, vector
from rrrobot.errors import ModelError, ParameterError
from rrrobot.robot.parameters import RRRobotParameters


def yaw_mass_matrix(parameters: RRRobotParameters, leg_angle: ArrayLike) -> Array:
    """Mass matrix of the yaw model in (yaw, phi_1, phi_2), eq (12) of the paper (3, 3).

        g11 = sum of (M_s + M_l) b^2 + M_l l^2 cos^2 phi_k over the legs
        g12 = -M_l l b sin phi_1,   g13 = M_l l b sin phi_2
        g22 = g33 = M_l l^2,        g23 = 0

    The paper writes M_m for the servo mass M_s and, in g12 and g13, r for the hip offset b, which
    are equal in Table 2. Legs may differ.

    Args:
        parameters: masses and lengths.
        leg_angle: (phi_1, phi_2) [rad].

    Returns:
        the matrix [kg m^2].

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> M = rr.paper.yaw_mass_matrix(rr.RRRobotParameters(), (np.pi / 2, np.pi / 2))
        >>> M.round(6).tolist()[0]
        [0.003168, -0.000684, 0.000684]
    """
    phi = vector("leg_angle", leg_angle, 2, "rad")
    b = parameters.hip_offset
    servo, leg, length = _arrays(parameters)
    g11 = np.sum((servo + leg) * b**2 + leg * (length * np.cos(phi)) ** 2)
    g12, g13 = leg * length * b * np.sin(phi) * (-1.0, 1.0)
    g22, g33 = leg * length**2
    return np.array(((g11, g12, g13), (g12, g22, 0.0), (g13, 0.0, g33)))


def rolling_pendulum_period(radius: float, mass_distance: float, gravity: float = 9.81) -> float:
    """Period of one point mass on a rolling wheel, eq (7): T = 2 pi sqrt(rho^2 / (g (r - rho))).

    Args:
        radius: r of the wheel [m].
        mass_distance: rho, from the contact up to the mass in equilibrium, below r [m].
        gravity: g [m/s^2].

    Returns:
        T [s]. It tends to zero with rho: the mass at the contact is at rest there.

    Example:
        >>> import rrrobot as rr
        >>> round(rr.paper.rolling_pendulum_period(0.12, 0.06), 4)
        0.4914
    """
    r = finite("radius", radius, "m", above=0)
    rho = finite("mass_distance", mass_distance, "m", above=0)
    g = finite("gravity", gravity, "m/s^2", above=0)
    if rho >= r:
        raise ParameterError(f"mass_distance is {rho} m: it must be below the radius {r} m.")
    return 2 * math.pi * math.sqrt(rho**2 / (g * (r - rho)))


def simple_pendulum_period(length: float, gravity: float = 9.81) -> float:
    """Period of a point mass on a pivot, eq (8): T = 2 pi sqrt(rho / g) [s].

    Example:
        >>> import rrrobot as rr
        >>> round(rr.paper.simple_pendulum_period(0.12), 4)
        0.6949
    """
    rho = finite("length", length, "m", above=0)
    return 2 * math.pi * math.sqrt(rho / finite("gravity", gravity, "m/s^2", above=0))


def composite_period(inertia: float, stiffness: float, damping: float = 0.0) -> float:
    """Period of small oscillations, T = 2 pi / sqrt(k / I - (kappa / 2 I)^2) [s].

    Args:
        inertia: I about the contact or the pivot [kg m^2].
        stiffness: k = m g d, d the distance of the centre of mass below the sphere's centre
            [N m/rad].
        damping: kappa [N m s/rad].

    Raises:
        ParameterError: a value out of range, or a damping that leaves no oscillation.

    Example:
        >>> import rrrobot as rr
        >>> round(rr.paper.composite_period(0.007044, 0.241326), 5)
        1.07346
    """
    i = finite("inertia", inertia, "kg m^2", above=0)
    k = finite("stiffness", stiffness, "N m/rad", above=0)
    kappa = finite("damping", damping, "N m s/rad", at_least=0)
    square = k / i - (kappa / (2 * i)) ** 2
    if square <= 0:
        raise ParameterError(
            f"damping is {kappa} N m s/rad: above {2 * math.sqrt(k * i):.4g} nothing oscillates."
        )
    return 2 * math.pi / math.sqrt(square)


def static_pitch(parameters: RRRobotParameters, leg_angle: ArrayLike) -> float:
    """Pitch at rest for given leg angles: tan(pitch) = S_c / (M_b r - S_s) [rad].

    S_c and S_s are the sums of M_l l cos phi and M_l l sin phi; the centre of mass hangs below the
    sphere's centre. Legs that differ also make the robot roll, which this leaves out.

    Raises:
        ModelError: the centre of mass is not below the sphere's centre at that pose.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> round(rr.paper.static_pitch(rr.RRRobotParameters(), (np.pi / 4, np.pi / 4)), 5)
        0.28089
    """
    phi = vector("leg_angle", leg_angle, 2, "rad")
    _, leg, length = _arrays(parameters)
    low = parameters.battery_mass * parameters.shell_radius - np.sum(leg * length * np.sin(phi))
    if low <= 0:
        raise ModelError(
            f"with the legs at {phi.tolist()} rad the centre of mass is not below the shell's "
            "centre: the robot would tip over."
        )
    return float(np.arctan2(np.sum(leg * length * np.cos(phi)), low))


def pitch_response(
    parameters: RRRobotParameters,
    leg_angle: ArrayLike,
    angular_frequency: ArrayLike,
    damping: float = 0.01,
) -> NDArray[np.complex128]:
    """Small-amplitude frequency response of the pitch model to each leg (..., 2) [rad/rad].

    About the static pitch theta for the legs' centres phi, with psi = phi - theta,

        H_k(omega) = (M_k omega^2 - V_k) / (k - I omega^2 + i kappa omega)
        M_k = -M_l l (l + r sin psi_k)        coupling inertia
        V_k = M_l g l sin psi_k               coupling by gravity
        k   = M_b g r cos theta - sum of M_l g l sin psi_k
        I   = inertia about the contact

    Legs that swing with A_k sin(omega t + delta_k) pitch the body by the imaginary part of
    sum of H_k A_k exp(i (omega t + delta_k)); amplitude and phase are those of the sum.

    Args:
        parameters: masses and lengths.
        leg_angle: centres (phi_1, phi_2) of the swings [rad].
        angular_frequency: omega, any shape, zero or more [rad/s].
        damping: kappa on the pitch rate [N m s/rad].

    Raises:
        ModelError: the robot would tip over, or has no finite response: undamped, at its own
            frequency.
        ParameterError: a number out of range.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> H = rr.paper.pitch_response(rr.RRRobotParameters(), (np.pi / 2, np.pi / 2), 8.0)
        >>> abs(H[0] * 0.3 + H[1] * 0.3 * np.exp(0.5j * np.pi)).round(4)
        np.float64(0.2576)
    """
    theta = static_pitch(parameters, leg_angle)
    kappa = finite("damping", damping, "N m s/rad", at_least=0)
    omega = np.asarray(angular_frequency, dtype=float)
    if not np.all(np.isfinite(omega) & (omega >= 0)):
        raise ParameterError(
            f"angular_frequency is {omega.tolist()} rad/s: it must be at least zero and finite."
        )
    servo, leg, length = _arrays(parameters)
    r, g, battery = parameters.shell_radius, parameters.gravity, parameters.battery_mass
    psi = vector("leg_angle", leg_angle, 2, "rad") - theta
    sine = np.sin(psi)
    coupling = -leg * length * (length + r * sine)
    by_gravity = leg * g * length * sine
    stiffness = battery * g * r * math.cos(theta) - by_gravity.sum()
    inertia = (
        battery * 2 * r**2 * (1 - math.cos(theta))
        + np.sum(servo) * r**2
        + np.sum(leg * (r**2 + length**2 + 2 * r * length * sine))
    )
    dynamic = stiffness - inertia * omega**2 + 1j * kappa * omega
    if np.any(dynamic == 0):
        raise ModelError(
            f"without damping there is no finite response at {omega[dynamic == 0].tolist()} rad/s, "
            "the body's own frequency: give a damping."
        )
    return (coupling * omega[..., None] ** 2 - by_gravity) / dynamic[..., None]


def _arrays(p: RRRobotParameters) -> tuple[Array, Array, Array]:
    return np.array(p.servo_masses), np.array(p.leg_masses), np.array(p.leg_lengths)
