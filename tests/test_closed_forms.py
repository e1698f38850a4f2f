"""Closed forms against the derivation, against simulations, and against their own derivations."""

import math
from typing import Any

import numpy as np
import pytest
import sympy as sp

import rrrobot as rr
from tests.derivations import PointMassRobot, full_model, pivoting_model, single_axis_model
from tests.twins import TABLE_2, UNEQUAL, Array, library_robot, parameters, random_points

STIFFNESS = 0.241326
K = rr.RRRobotParameters()
UP = (math.pi / 2, math.pi / 2)


@pytest.mark.parametrize(
    ("inertia", "undamped", "damped"),
    [
        (0.010212, 1.29251, 1.29911),
        (0.007044, 1.07346, 1.08145),
        (0.008628, 1.18804, 1.19524),
        (0.005460, 0.94509, 0.95419),
    ],
    ids=["rolling roll", "rolling pitch", "pivoting roll", "pivoting pitch"],
)
def test_composite_period(inertia: float, undamped: float, damped: float) -> None:
    assert rr.paper.composite_period(inertia, STIFFNESS) == pytest.approx(undamped, abs=5.1e-6)
    assert rr.paper.composite_period(inertia, STIFFNESS, 0.01) == pytest.approx(damped, abs=5.1e-6)


def test_composite_period_takes_its_inertia_from_the_mass_matrix() -> None:
    """I about the contact and about the pivot of the five points, legs straight up."""
    zero, still = np.zeros(3), np.zeros((2, 2))
    periods = [
        rr.paper.composite_period(
            model(TABLE_2, zero, zero, UP, *still).mass_matrix[i, i], STIFFNESS
        )
        for model in (full_model, pivoting_model)
        for i in (0, 1)
    ]
    assert periods == pytest.approx([1.29251, 1.07346, 1.18804, 0.94509], abs=5.1e-6)


def small_oscillation(centre: tuple[sp.Expr, sp.Expr], theta: sp.Symbol) -> sp.Expr:
    """T of a unit point mass at centre(theta) = (x, z), linearised about theta = 0, by Lagrange.

    T = 2 pi sqrt(I / k) with I = |d centre / d theta|^2 and k = d2 (g z) / d theta2, at rest.
    """
    g = sp.Symbol("g", positive=True)
    inertia = sum(sp.diff(part, theta) ** 2 for part in centre).subs(theta, 0)
    stiffness = sp.diff(g * centre[1], theta, 2).subs(theta, 0)
    assert sp.simplify(sp.diff(centre[1], theta).subs(theta, 0)) == 0
    return 2 * sp.pi * sp.sqrt(sp.simplify(inertia / stiffness))


def test_eqs_7_and_8_from_lagrange() -> None:
    """A point mass rho above the contact of a rolling wheel, and one rho below a pivot."""
    r, rho, g, theta = sp.symbols("r rho g theta", positive=True)
    below = r - rho
    wheel = (r * theta - below * sp.sin(theta), r - below * sp.cos(theta))
    pendulum = (rho * sp.sin(theta), -rho * sp.cos(theta))
    values = {r: 0.12, rho: 0.07, g: 9.7}
    eq_7 = float(small_oscillation(wheel, theta).subs(values))
    assert rr.paper.rolling_pendulum_period(0.12, 0.07, 9.7) == pytest.approx(eq_7, rel=1e-14)
    eq_8 = float(small_oscillation(pendulum, theta).subs(values))
    assert rr.paper.simple_pendulum_period(0.07, 9.7) == pytest.approx(eq_8, rel=1e-14)
    assert rr.paper.simple_pendulum_period(0.07) == pytest.approx(
        2 * math.pi * math.sqrt(0.07 / 9.81)
    )


def point_mass_robot(height: float) -> rr.Robot:
    """A massless wheel of radius 0.12 with one point mass at `height` over its contact, no legs."""
    urdf = f"""<robot name="wheel"><link name="shell"><inertial>
      <origin xyz="0 0 {height - 0.12!r}"/><mass value="0.3"/>
      <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>
    </inertial></link></robot>"""
    return rr.Robot.from_urdf(urdf, shell=rr.Sphere(0.12))


@pytest.mark.parametrize("height", [0.03, 0.07])
def test_eq_7_is_the_period_of_a_simulated_point_mass(height: float) -> None:
    model = rr.PitchModel(point_mass_robot(height), damping=None)
    t = rr.simulate(model, rr.StillLegs([]), 3.0, 0.002, euler=(0, 1e-4, 0), start="rest")
    expected = rr.paper.rolling_pendulum_period(0.12, height)
    assert rr.orbits.measured_period(t, "pitch") == pytest.approx(expected, rel=1e-6)


def test_eqs_7_and_8_are_composite_periods_of_a_point_mass() -> None:
    m, r, rho, g = 0.3, 0.12, 0.05, 9.81
    rolling = rr.paper.composite_period(m * rho**2, m * g * (r - rho))
    assert rr.paper.rolling_pendulum_period(r, rho) == pytest.approx(rolling, rel=1e-14)
    pivoted = rr.paper.composite_period(m * rho**2, m * g * rho)
    assert rr.paper.simple_pendulum_period(rho) == pytest.approx(pivoted, rel=1e-14)


@pytest.mark.parametrize("seed", range(10))
def test_yaw_mass_matrix(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points, phi = random_points(rng), rng.uniform(-np.pi, np.pi, 2)
    expected = single_axis_model("yaw", points, 0.3, 0.0, phi, *np.zeros((2, 2))).mass_matrix
    found = rr.paper.yaw_mass_matrix(parameters(points), phi)
    assert found == pytest.approx(expected, rel=1e-13, abs=1e-18)


def test_yaw_mass_matrix_as_the_paper_prints_it() -> None:
    """Eq (12), with the servo mass for M_m and r = b of Table 2."""
    m_l, m_s, length, r = 0.057, 0.053, 0.1, 0.12
    phi1, phi2 = 0.4, 2.5
    half = m_l * length**2 / 2 * (np.cos(2 * phi1) + np.cos(2 * phi2))
    g11 = 2 * (m_s + m_l) * r**2 + m_l * length**2 + half
    g12, g13 = -m_l * length * r * np.sin(phi1), m_l * length * r * np.sin(phi2)
    g22 = m_l * length**2
    expected = np.array([[g11, g12, g13], [g12, g22, 0], [g13, 0, g22]])
    assert rr.paper.yaw_mass_matrix(K, (phi1, phi2)) == pytest.approx(expected, rel=1e-14)


OFFSETS = [0.2, np.pi / 4, 1.2, np.pi / 2, 2.5, -1.0]


@pytest.mark.parametrize("offset", OFFSETS)
def test_static_pitch_is_where_the_models_rest(offset: float) -> None:
    expected = rr.paper.static_pitch(K, (offset, offset))
    robot = library_robot()
    pitch = rr.orbits.equilibrium(rr.PitchModel(robot), (offset, offset))
    assert pitch[0] == pytest.approx(expected, abs=1e-12)
    assert pitch[1:].tolist() == pytest.approx([K.shell_radius * expected, 0.0], abs=1e-12)
    whole = rr.FullModel(robot)
    quaternion = rr.orbits.equilibrium(whole, (offset, offset))[:4]
    rest = [0.0, math.sin(expected / 2), 0.0, math.cos(expected / 2)]
    assert quaternion == pytest.approx(rest, abs=1e-12)
    pivoted = rr.orbits.equilibrium(rr.PivotingModel(robot), (offset, offset))
    assert pivoted[:3] == pytest.approx([0.0, expected, 0.0], abs=1e-12)


def test_static_pitch_of_unequal_legs() -> None:
    """Only the pitch model, which holds the roll: there it is exact."""
    legs = (0.3, 2.0)
    model = rr.PitchModel(library_robot(UNEQUAL))
    expected = rr.paper.static_pitch(parameters(UNEQUAL), legs)
    assert abs(expected) > 0.01
    assert rr.orbits.equilibrium(model, legs)[0] == pytest.approx(expected, abs=1e-12)
    at_rest = single_axis_model("pitch", UNEQUAL, expected, 0.0, legs, *np.zeros((2, 2)))
    assert float(at_rest.theta_ddot) == pytest.approx(0.0, abs=1e-12)


def simulated_response(
    points: PointMassRobot, centre: Array, amplitude: Array, phase: Array, omega: float
) -> complex:
    """First harmonic of the settled pitch model, as `pitch_response` gives it, damping 0.05.

    Started on the linear solution, so that only transients of second order are left to decay
    (with 1 / 0.28 s); the harmonic is the discrete Fourier sum over two periods.
    """
    robot = library_robot(points)
    H = rr.paper.pitch_response(parameters(points), centre, omega, damping=0.05)
    z = complex(np.sum(H * amplitude * np.exp(1j * phase)))
    rest = rr.paper.static_pitch(parameters(points), centre)
    gait = rr.SinusoidalGait(
        offset=centre, amplitude=amplitude, angular_frequency=omega, phase=phase
    )
    period = 2 * np.pi / omega
    whole = math.ceil(2.5 / period)
    t = rr.simulate(
        rr.PitchModel(robot, damping=0.05),
        gait,
        (whole + 2) * period,
        period / 32,
        euler=(0.0, rest + z.imag, 0.0),
        start=(0.0, (1j * omega * z).imag, 0.0),
        rtol=1e-9,
        atol=1e-12,
    )
    time, pitch = t.time[32 * whole : -1], t.euler[32 * whole : -1, 1]
    assert len(time) == 64
    return complex(2j * np.mean((pitch - pitch.mean()) * np.exp(-1j * omega * time)))


@pytest.mark.parametrize("omega", [3.0, 6.0, 12.0])
@pytest.mark.parametrize("offset", [np.pi / 2, np.pi / 4, 2.2])
def test_pitch_response_is_that_of_the_simulated_model(omega: float, offset: float) -> None:
    """Amplitude and phase at leg swings of 1e-3 rad, to 1e-5."""
    centre, amplitude = np.full(2, offset), np.full(2, 1e-3)
    phase = np.array([0.3, 0.3 + np.pi / 2])
    H = rr.paper.pitch_response(K, centre, omega, damping=0.05)
    expected = np.sum(H * amplitude * np.exp(1j * phase))
    found = simulated_response(TABLE_2, centre, amplitude, phase, omega)
    assert abs(found / expected - 1) < 1e-5
    assert abs(expected) > 1e-4


@pytest.mark.parametrize("leg", [0, 1])
def test_pitch_response_of_each_of_two_unequal_legs(leg: int) -> None:
    centre, amplitude, phase = np.array([0.4, 1.9]), 1e-3 * np.eye(2)[leg], np.zeros(2)
    H = rr.paper.pitch_response(parameters(UNEQUAL), centre, 7.0, damping=0.05)
    found = simulated_response(UNEQUAL, centre, amplitude, phase, 7.0)
    assert abs(found / (H[leg] * 1e-3) - 1) < 1e-5


@pytest.mark.parametrize("seed", range(10))
def test_pitch_response_is_the_linearised_derivation(seed: int) -> None:
    """(k - I w^2 + i kappa w) H = M w^2 - V, its coefficients from the point masses at rest."""
    rng = np.random.default_rng(seed)
    points = random_points(rng)
    centre, kappa, omega = rng.uniform(-0.5, 3.5, 2), 0.02, rng.uniform(1, 20)
    rest = rr.paper.static_pitch(parameters(points), centre)
    M = single_axis_model("pitch", points, rest, 0.0, centre, *np.zeros((2, 2))).mass_matrix

    def push(theta: float, phi: Array) -> float:
        """Generalised force on the pitch at rest."""
        motion = single_axis_model("pitch", points, theta, 0.0, phi, *np.zeros((2, 2)))
        return float(motion.theta_ddot * motion.mass_matrix[0, 0])

    h = 1e-4
    k = -(push(rest + h, centre) - push(rest - h, centre)) / (2 * h)
    by_leg = np.array(
        [(push(rest, centre + h * e) - push(rest, centre - h * e)) / (2 * h) for e in np.eye(2)]
    )
    expected = (by_leg + M[0, 1:] * omega**2) / (k - M[0, 0] * omega**2 + 1j * kappa * omega)
    found = rr.paper.pitch_response(parameters(points), centre, omega, kappa)
    assert found == pytest.approx(expected, rel=1e-6)


def test_pitch_response_over_frequency() -> None:
    omega = np.linspace(0.0, 20.0, 12).reshape(3, 4)
    H = rr.paper.pitch_response(K, UP, omega)
    assert H.shape == (3, 4, 2)
    assert H[1, 2] == pytest.approx(rr.paper.pitch_response(K, UP, omega[1, 2]), rel=1e-14)
    # A slow swing tilts the body as much as the static pitch says.
    h = 1e-4
    slope = (
        rr.paper.static_pitch(K, (UP[0] + h, UP[1])) - rr.paper.static_pitch(K, (UP[0] - h, UP[1]))
    ) / (2 * h)
    assert H[0, 0, 0] == pytest.approx(slope, rel=1e-6)
    # Undamped, a response without bound at 2 pi / 1.07346 s.
    near = 2 * np.pi / 1.07346 * np.array([0.999, 1.001])
    assert np.abs(rr.paper.pitch_response(K, UP, near, 0.0)[:, 0]).min() > 50


def bad(function: Any, *arguments: Any) -> Any:
    name = function.__name__
    return pytest.param(function, arguments, id=f"{name}{arguments[-1]!r}"[:60])


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        bad(rr.paper.yaw_mass_matrix, K, (1.0, 2.0, 3.0)),
        bad(rr.paper.yaw_mass_matrix, K, (np.nan, 2.0)),
        bad(rr.paper.rolling_pendulum_period, 0.0, 0.1),
        bad(rr.paper.rolling_pendulum_period, 0.1, 0.1),
        bad(rr.paper.rolling_pendulum_period, 0.1, 0.05, 0.0),
        bad(rr.paper.simple_pendulum_period, -1.0),
        bad(rr.paper.simple_pendulum_period, np.inf),
        bad(rr.paper.simple_pendulum_period, 1.0, 0.0),
        bad(rr.paper.composite_period, 0.0, 1.0),
        bad(rr.paper.composite_period, 1.0, 0.0),
        bad(rr.paper.composite_period, 1.0, 1.0, -0.1),
        bad(rr.paper.composite_period, 1.0, 1.0, 2.0),
        bad(rr.paper.composite_period, 1.0, 1.0, 2.1),
        bad(rr.paper.static_pitch, K, (1.0, np.inf)),
        bad(rr.paper.pitch_response, K, UP, -1.0),
        bad(rr.paper.pitch_response, K, UP, np.nan),
        bad(rr.paper.pitch_response, K, UP, 8.0, -0.1),
        bad(rr.paper.pitch_response, K, (1.0,), 8.0),
    ],
)
def test_bad_input(function: Any, arguments: tuple[Any, ...]) -> None:
    with pytest.raises(rr.ParameterError):
        function(*arguments)


def test_an_overdamped_body_does_not_oscillate() -> None:
    assert rr.paper.composite_period(1.0, 1.0, 1.999) > 100
    with pytest.raises(rr.ParameterError, match="above 2 nothing oscillates"):
        rr.paper.composite_period(1.0, 1.0, 2.1)


def test_a_top_heavy_robot_has_no_static_pitch() -> None:
    heavy = rr.RRRobotParameters(leg_mass=0.3)
    for function in (rr.paper.static_pitch, lambda p, a: rr.paper.pitch_response(p, a, 8.0)):
        with pytest.raises(rr.ModelError, match="tip over"):
            function(heavy, UP)
    assert rr.paper.static_pitch(heavy, (-1.0, -1.0)) > 0


def test_an_undamped_body_has_no_response_at_its_own_frequency() -> None:
    p = rr.RRRobotParameters(gravity=0.0)
    with pytest.raises(rr.ModelError, match=r"no finite response at \[0\.0\] rad/s"):
        rr.paper.pitch_response(p, UP, [0.0, 1.0], damping=0.0)
