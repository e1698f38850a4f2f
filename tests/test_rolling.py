"""Contact kinematics alone, eqs (2)-(5): velocities, the erratum, order of accuracy, holonomy."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

import rrrobot as rr
from rrrobot.integrate import Stepping
from rrrobot.rotations import skew
from tests.twins import Array, library_robot

R = 0.12
UP = np.array([0.0, 0.0, 1.0])
TIGHT = Stepping(rtol=1e-13, atol=1e-15)


def random_rotation(seed: int) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-1, 1, 3) * (np.pi, 1.4, np.pi), rng.uniform(-5, 5, 3)


def pinocchio_omega(euler: Array, rates: Array) -> tuple[Array, Array]:
    """R_world_body and the world angular velocity of a body on Pinocchio's ZYX joint."""
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelSphericalZYX(), pin.SE3.Identity(), "ball")
    data = model.createData()
    pin.forwardKinematics(model, data, euler[::-1].copy(), rates[::-1].copy())
    return data.oMi[joint].rotation, data.oMi[joint].rotation @ data.v[joint].angular


@pytest.mark.parametrize("seed", range(20))
def test_sphere_contact_rate_matches_pinocchio(seed: int) -> None:
    """Eqs (2)-(5) are r Omega x z with Pinocchio's Omega, and so is `contact_velocity`."""
    euler, rates = random_rotation(seed)
    rotation, omega = pinocchio_omega(euler, rates)
    expected = R * np.cross(omega, UP)
    assert rr.contact.sphere_contact_rate(R, euler, rates) == pytest.approx(expected[:2], abs=1e-14)
    moved = rr.contact.contact_velocity(rr.Sphere(R), rotation, omega, UP)
    assert moved == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("seed", range(5))
def test_sphere_contact_rate_is_the_centre_of_a_rolling_robot(seed: int) -> None:
    """The centre's velocity that Pinocchio finds for a free-flyer velocity with J v = 0."""
    euler, rates = random_rotation(seed)
    robot = library_robot()
    model = rr.FullModel(robot)
    pose = model.make_pose(euler, np.zeros(2))
    quasi = model.quasi_from_euler_rates(pose, rates)
    q, v = model.configuration(pose, np.ones(2)), model.velocity(pose, quasi, np.ones(2))
    data, frame = robot.model.createData(), robot.model.getFrameId("rrrobot_shell")
    pin.forwardKinematics(robot.model, data, q, v)
    centre = pin.getFrameVelocity(robot.model, data, frame, pin.LOCAL_WORLD_ALIGNED).linear
    rate = rr.contact.sphere_contact_rate(R, euler, rates)
    assert centre == pytest.approx([*rate, 0.0], abs=1e-13)


def test_rates_broadcast() -> None:
    euler, rates = np.random.default_rng(0).uniform(-1, 1, (2, 4, 5, 3))
    many = rr.contact.sphere_contact_rate(R, euler, rates)
    assert many.shape == (4, 5, 2)
    one = rr.contact.sphere_contact_rate(R, euler[2, 3], rates[2, 3])
    assert many[2, 3] == pytest.approx(one, abs=1e-16)


def row_5(euler: Array, printed: bool) -> Array:
    """omega^2 of eq (5) on (x, y, roll, pitch, yaw), with cos(roll) printed for cos(pitch)."""
    roll, pitch, yaw = euler
    third = np.cos(roll if printed else pitch)
    return np.array([0.0, 1.0, R * third * np.cos(yaw), -R * np.sin(yaw), 0.0])


@pytest.mark.parametrize("seed", range(10))
def test_erratum_of_eq_5(seed: int) -> None:
    """A rolling motion satisfies eq (5) with cos(pitch), and not as the paper prints it.

    What the printed row leaves is r (cos roll - cos pitch) cos(yaw) roll_rate.
    """
    euler, rates = random_rotation(seed)
    _, omega = pinocchio_omega(euler, rates)
    q_dot = np.concatenate([R * np.cross(omega, UP)[:2], rates])
    assert row_5(euler, printed=False) @ q_dot == pytest.approx(0.0, abs=1e-14)
    left = row_5(euler, printed=True) @ q_dot
    roll, pitch, yaw = euler
    assert left == pytest.approx(R * (np.cos(roll) - np.cos(pitch)) * np.cos(yaw) * rates[0])
    assert abs(left) > 1e-4

    omega_2 = rr.paper.paper_equations(
        rr.FullModel(library_robot()), 
        np.concatenate([np.zeros(2), euler, np.ones(2)]), np.zeros(7)
    ).omega[1]  # fmt: skip
    assert omega_2[:5] == pytest.approx(row_5(euler, printed=False), abs=1e-15)


def test_printed_eq_5_depends_on_where_the_body_rolls_from() -> None:
    """A ball pitched by 60 degrees at yaw = 90 degrees that rolls on about its own x axis.

    Its axis then points 60 degrees into the ground: cos(60 deg) of the turn rolls, all of it if
    the printed form held.
    """
    euler = np.array([0.0, np.pi / 3, 0.0])
    rate = rr.contact.sphere_contact_rate(R, euler, np.array([1.0, 0.0, 0.0]))
    assert rate == pytest.approx([0.0, -R * 0.5], abs=1e-15)


@pytest.mark.parametrize("seed", range(5))
def test_ellipsoid_contact_velocity_by_finite_differences(seed: int) -> None:
    """The contact point moves with the rolling centre and along the shell: c_dot + rho_dot."""
    rng = np.random.default_rng(seed)
    shell = rr.Ellipsoid((0.15, 0.1, 0.12))
    omega = rng.uniform(-3, 3, 3)
    normal = np.array([0.1, -0.2, 1.0]) / np.linalg.norm([0.1, -0.2, 1.0])
    start = Rotation.random(random_state=seed).as_matrix()

    def arm(t: float) -> Array:
        return shell.arm(expm(skew(omega) * t) @ start, normal)

    h = 1e-3
    arm_rate = (8 * (arm(h) - arm(-h)) - (arm(2 * h) - arm(-2 * h))) / (12 * h)
    expected = np.cross(arm(0.0), omega) + arm_rate
    found = rr.contact.contact_velocity(shell, start, omega, normal)
    assert np.abs(expected).max() > 0.01
    assert found == pytest.approx(expected, abs=1e-10)
    assert found @ normal == pytest.approx(0.0, abs=1e-15)


def tumble(t: Any) -> tuple[Array, Array]:
    """A smooth rotation history and its rates; t a number or an array."""
    t = np.asarray(t, dtype=float)
    angles = (0.5 * np.sin(3 * t), 0.4 * np.cos(2 * t) - 0.4, 0.7 * t + 0.3 * np.sin(5 * t))
    rates = (1.5 * np.cos(3 * t), -0.8 * np.sin(2 * t), 0.7 + 1.5 * np.cos(5 * t))
    return np.stack(angles, axis=-1), np.stack(rates, axis=-1)


def test_samples_are_of_sixth_order_or_better() -> None:
    """Halving the interval divides the error by 64 or more; a trapezoid's would be by 4.

    Measured: 2^7 to 2^8, as the spline's errors within an interval cancel in the integral.
    """
    errors = []
    for n in (40, 80, 160, 320):
        time = np.linspace(0.0, 4.0, n + 1)
        exact = rr.contact.contact_path(R, time, tumble, stepping=TIGHT)
        sampled = rr.contact.contact_path(R, time, tumble(time)[0])
        errors.append(np.abs(sampled - exact).max())
    assert errors[0] < 1e-6
    assert np.min(np.divide(errors[:-1], errors[1:])) > 64


def test_samples_of_a_steady_turn_are_exact() -> None:
    """The spline keeps a polynomial, and the quadrature leaves next to nothing at 30 degrees per
    interval: pitch = t, yaw = 2 t gives r (sin 2t, 1 - cos 2t) / 2."""
    time = np.linspace(0.0, 3.0, 13)
    path = rr.contact.contact_path(R, time, np.outer(time, [0.0, 1.0, 2.0]))
    exact = R / 2 * np.column_stack((np.sin(2 * time), 1 - np.cos(2 * time)))
    assert np.abs(path - exact).max() < 1e-13


def test_a_function_is_integrated_to_the_tolerance() -> None:
    time = np.linspace(0.0, 4.0, 9)
    exact = rr.contact.contact_path(R, time, tumble, stepping=TIGHT)
    default = rr.contact.contact_path(R, time, tumble)
    coarse = rr.contact.contact_path(
        R, time, tumble, stepping=Stepping(rtol=1e-3, atol=1e-3, max_step=1.0)
    )
    assert np.abs(default - exact).max() < 1e-9
    assert 1e-7 < np.abs(coarse - exact).max() < 1e-2


def test_unequal_intervals_and_the_start() -> None:
    time = np.sort(np.random.default_rng(0).uniform(0.0, 2.0, 200))
    exact = rr.contact.contact_path(R, time, tumble, stepping=TIGHT, position=(1.0, -2.0))
    sampled = rr.contact.contact_path(R, time, tumble(time)[0], position=(1.0, -2.0))
    assert sampled[0].tolist() == exact[0].tolist() == [1.0, -2.0]
    assert np.abs(sampled - exact).max() < 1e-6


def smooth(t: float) -> tuple[float, float]:
    """A step from 0 to 1 over 0 <= t <= 1 and its rate."""
    x = min(max(t, 0.0), 1.0)
    return x**3 * (10 - 15 * x + 6 * x**2), 30 * x**2 * (1 - x) ** 2


def test_a_closed_loop_of_angles_displaces_the_ball() -> None:
    """Pitch by a, yaw by b, pitch back, yaw back: r a (1 - cos b, -sin b), like a parked car."""
    a, b = 0.8, 0.5

    def loop(t: float) -> tuple[Array, Array]:
        (p1, dp1), (y1, dy1), (p2, dp2), (y2, dy2) = (smooth(t - k) for k in range(4))
        angles = np.array([0.0, a * (p1 - p2), b * (y1 - y2)])
        return angles, np.array([0.0, a * (dp1 - dp2), b * (dy1 - dy2)])

    time = np.linspace(0.0, 4.0, 401)
    expected = R * a * np.array([1 - np.cos(b), -np.sin(b)])
    path = rr.contact.contact_path(R, time, loop, stepping=TIGHT)
    assert loop(4.0)[0].tolist() == [0.0, 0.0, 0.0]
    assert path[-1] == pytest.approx(expected, abs=1e-9)
    sampled = rr.contact.contact_path(R, time, np.array([loop(t)[0] for t in time]))
    assert sampled[-1] == pytest.approx(expected, abs=1e-7)


def circling(radius: float) -> Callable[[Array], Array]:
    """Roll, pitch, yaw of a ball whose contact point circles once in t = 0 .. 1, in closed form.

    Without spin about the vertical Omega = z x v / r, which turns with the contact point; seen
    from there it is constant, so R(t) = exp(w t z) exp(t (Omega_0 - w z)).
    """
    w = 2 * np.pi
    omega_0 = np.array([-radius * w / R, 0.0, 0.0])

    def euler(time: Array) -> Array:
        turns = Rotation.from_rotvec(np.outer(w * time, UP))
        turns = turns * Rotation.from_rotvec(np.outer(time, omega_0 - w * UP))
        return np.unwrap(turns.as_euler("ZYX")[:, ::-1], axis=0)

    return euler


def test_holonomy_of_a_ball_that_rolls_around_a_circle() -> None:
    """The rotation that carries the contact point around a circle brings back the circle, and
    the ball comes home turned by an angle known in closed form."""
    radius = 0.4 * R
    time = np.linspace(0.0, 1.0, 801)
    euler = circling(radius)(time)
    path = rr.contact.contact_path(R, time, euler, position=(radius, 0.0))
    circle = radius * np.column_stack((np.cos(2 * np.pi * time), np.sin(2 * np.pi * time)))
    assert np.abs(path - circle).max() < 1e-10

    home = Rotation.from_euler("ZYX", euler[-1, ::-1]).magnitude()
    assert home == pytest.approx(2 * np.pi * (np.sqrt(1 + 0.4**2) - 1), abs=1e-12)


def test_a_small_circle_turns_the_ball_by_its_area() -> None:
    """Holonomy per area is the curvature 1 / r^2."""
    radius = 0.01 * R
    spin = circling(radius)(np.array([0.0, 0.25, 0.5, 0.75, 1.0]))[-1, 2]
    assert abs(spin) == pytest.approx(np.pi * radius**2 / R**2, rel=1e-3)


ANGLES = np.zeros((8, 3))
TIME = np.linspace(0.0, 1.0, 8)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, TIME, ANGLES), "radius is 0.0 m"),
        ((np.nan, TIME, ANGLES), "radius is nan m"),
        ((R, TIME[::-1], ANGLES), "increasing"),
        ((R, np.zeros(8), ANGLES), "increasing"),
        ((R, [0.0], ANGLES[:1]), "at least 2"),
        ((R, TIME[:, None], ANGLES), "one-dimensional"),
        ((R, [*TIME[:-1], np.inf], ANGLES), "finite"),
        ((R, [*TIME[:-1], np.nan], ANGLES), "increasing"),
        ((R, TIME, ANGLES[:-1]), r"euler has shape \(7, 3\) for 8 instants"),
        ((R, TIME, ANGLES[:, :2]), r"euler has shape \(8, 2\)"),
        ((R, TIME[:5], ANGLES[:5]), "n >= 6"),
        ((R, TIME, ANGLES * np.nan), "finite"),
        ((R, TIME, lambda t: (np.zeros(3), np.full(3, np.nan))), "euler_rates at t = 0 s"),
        ((R, TIME, lambda t: (np.zeros(2), np.zeros(3))), "euler at t = 0 s has shape"),
    ],
)
def test_bad_input(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(rr.ParameterError, match=message):
        rr.contact.contact_path(*arguments)


def test_bad_start() -> None:
    with pytest.raises(rr.ParameterError, match="position has shape"):
        rr.contact.contact_path(R, TIME, ANGLES, position=(0.0, 0.0, 0.0))
