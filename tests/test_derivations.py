"""The touchstone checked against closed forms, conservation laws and a second formulation."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import simpson, solve_ivp
from scipy.spatial.transform import Rotation

from tests.derivations import (
    Axis,
    Motion,
    PointMassRobot,
    full_model,
    pivoting_model,
    simulate_full,
    single_axis_model,
)

Array = NDArray[np.float64]

TABLE_2 = PointMassRobot()
UNEQUAL = PointMassRobot(
    battery_mass=0.27,
    servo_masses=(0.06, 0.041),
    leg_masses=(0.05, 0.083),
    leg_lengths=(0.09, 0.115),
    shell_radius=0.13,
    hip_offset=0.1,
    gravity=9.7,
)
NAMES = ("full", "pivoting", "roll", "pitch", "yaw")
HOLONOMIC = NAMES[1:]
PERIOD = 2 * np.pi / 8.0


def evaluate(name: str, robot: PointMassRobot, q: Array, u: Array, **forces: Any) -> Motion:
    """Any model in the state q = (angles, phi1, phi2), u = q_dot; legs not accelerated at first."""
    if "leg_torque" not in forces:
        forces = {"phi_ddot": np.zeros(2)} | forces
    if name in ("full", "pivoting"):
        model = full_model if name == "full" else pivoting_model
        return model(robot, q[:3], u[:3], q[3:], u[3:], **forces)
    return single_axis_model(cast(Axis, name), robot, q[0], u[0], q[1:], u[1:], **forces)


def random_state(name: str, seed: int) -> tuple[Array, Array]:
    """A state well away from pitch = pi/2, legs anywhere, rates of a few rad/s."""
    rng = np.random.default_rng(seed)
    k = 3 if name in ("full", "pivoting") else 1
    angles, legs = rng.uniform(-1.0, 1.0, k), rng.uniform(-np.pi, np.pi, 2)
    return np.concatenate([angles, legs]), rng.uniform(-2.0, 2.0, k + 2)


def u_dot_of(motion: Motion) -> Array:
    """The accelerations of all coordinates, in the order of the mass matrix."""
    return np.concatenate([np.atleast_1d(motion.theta_ddot), motion.phi_ddot])


def first(f: Callable[[float], Array], h: float = 2e-4) -> Array:
    """f'(0) by the five-point stencil."""
    return (f(-2 * h) - 8 * f(-h) + 8 * f(h) - f(2 * h)) / (12 * h)


def jacobian(f: Callable[[Array], Array], x: Array) -> Array:
    """df/dx by the five-point stencil, the entries of x along the last axis."""

    def along(e: Array) -> Array:
        return first(lambda t: f(x + t * e))

    return np.stack([along(e) for e in np.eye(len(x))], axis=-1)


def second(f: Callable[[float], Array], h: float = 1e-3) -> Array:
    """f''(0) by the five-point stencil."""
    return (-f(-2 * h) + 16 * f(-h) - 30 * f(0.0) + 16 * f(h) - f(2 * h)) / (12 * h**2)


def rotation(theta: Array) -> Array:
    """R_world_body = Rz Ry Rx."""
    return Rotation.from_euler("ZYX", theta[..., ::-1]).as_matrix()


def axial(matrix: Array) -> Array:
    """The vector of the skew part: omega for R_dot R^T."""
    skew = (matrix - matrix.T) / 2
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])


def test_reference_state() -> None:
    motion = full_model(
        TABLE_2,
        (0.1, 0.2, 0.3),
        (0.5, -0.4, 0.7),
        (0.9, 1.3),
        (1.0, -2.0),
        phi_ddot=(3.0, 4.0),
        damping=(0.01, 0.01, 0.01),
    )
    assert motion.omega_dot == pytest.approx([-3.99715178, 0.62958431, -3.24837911], abs=6e-9)
    assert motion.contact_force == pytest.approx([-0.02480551, 0.14486663, 5.1065834], abs=6e-9)
    assert motion.leg_torque == pytest.approx([0.04610733, 0.02238164], abs=6e-9)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", NAMES)
def test_torque_driven_legs_invert_prescribed_legs(name: str, seed: int) -> None:
    q, u = random_state(name, seed)
    k = len(q) - 2
    damping = {"damping": np.squeeze(np.full(k, 0.02)), "leg_damping": (0.003, 0.004)}
    prescribed = evaluate(name, UNEQUAL, q, u, phi_ddot=(3.0, -4.0), **damping)
    free = evaluate(name, UNEQUAL, q, u, leg_torque=prescribed.leg_torque, **damping)
    for field, value in prescribed._asdict().items():
        assert getattr(free, field) == pytest.approx(value, rel=1e-11, abs=1e-12), field


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", NAMES)
def test_power_balance(name: str, seed: int) -> None:
    """dE/dt = motor power - damping losses, for moving legs, prescribed."""
    q, u = random_state(name, seed)
    k = len(q) - 2
    damping, leg_damping = np.array([0.01, 0.02, 0.03])[:k], np.array([0.003, 0.004])
    motion = evaluate(
        name,
        UNEQUAL,
        q,
        u,
        phi_ddot=(3.0, -4.0),
        damping=np.squeeze(damping),
        leg_damping=leg_damping,
    )
    u_dot = u_dot_of(motion)
    power = first(
        lambda t: np.array(
            evaluate(name, UNEQUAL, q + t * u + t**2 / 2 * u_dot, u + t * u_dot).energy
        )
    )
    losses = damping @ u[:k] ** 2 + leg_damping @ u[k:] ** 2
    assert power == pytest.approx(motion.leg_torque @ u[k:] - losses, rel=1e-9, abs=1e-10)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", HOLONOMIC)
def test_lagrange_equations(name: str, seed: int) -> None:
    """d/dt(M u) - dL/dq = Q, from the energy and the mass matrix alone."""
    q, u = random_state(name, seed)
    k = len(q) - 2
    damping = np.array([0.01, 0.02, 0.03])[:k]
    motion = evaluate(name, UNEQUAL, q, u, leg_torque=(0.02, -0.03), damping=np.squeeze(damping))
    u_dot = u_dot_of(motion)

    def momentum(t: float) -> Array:
        return evaluate(name, UNEQUAL, q + t * u + t**2 / 2 * u_dot, u).mass_matrix @ (
            u + t * u_dot
        )

    def lagrangian(q: Array) -> Array:
        state = evaluate(name, UNEQUAL, q, u)
        return np.array(u @ state.mass_matrix @ u - state.energy)

    force = np.concatenate([-damping * u[:k], [0.02, -0.03]])
    assert first(momentum) - jacobian(lagrangian, q) == pytest.approx(force, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("name", ["full", "pivoting"])
def test_newton_euler(name: str, seed: int) -> None:
    """Forces and moments of five accelerated points, accelerations by finite differences.

    The moment about the contact point (or the pivot) is that of the damping alone, E^T N = -k
    theta_dot; each hinge carries its motor's torque about the axis -y.
    """
    q, u = random_state(name, seed)
    k = np.array([0.01, 0.02, 0.03])
    robot, r = UNEQUAL, UNEQUAL.shell_radius
    motion = evaluate(name, robot, q, u, leg_torque=(0.02, -0.03), damping=k)
    u_dot = u_dot_of(motion)

    def attitude(t: float) -> Array:
        return rotation((q + t * u + t**2 / 2 * u_dot)[:3])

    def arms(t: float) -> Array:
        phi = (q + t * u + t**2 / 2 * u_dot)[3:]
        hips = np.array([[0, -robot.hip_offset, 0], [0, robot.hip_offset, 0]])
        swing = np.stack([np.cos(phi), np.zeros(2), np.sin(phi)], axis=1)
        tips = hips + np.array(robot.leg_lengths)[:, None] * swing
        return np.vstack([[[0, 0, -r]], hips, tips]) @ attitude(t).T

    R, z = attitude(0.0), np.array([0.0, 0.0, 1.0])
    alpha = axial(second(attitude) @ R.T)
    assert motion.omega_dot == pytest.approx(alpha, rel=1e-7, abs=1e-7)

    rolls = name == "full"
    a = second(arms) + (r * np.cross(alpha, z) if rolls else 0.0)
    force = robot.masses[:, None] * (a + robot.gravity * z)
    assert motion.contact_force == pytest.approx(force.sum(axis=0), rel=1e-7, abs=1e-7)

    moment = np.cross(arms(0.0) + (r * z if rolls else 0.0), force).sum(axis=0)
    turns = jacobian(rotation, q[:3])
    E = np.stack([axial(turns[..., i] @ R.T) for i in range(3)], axis=1)
    assert E.T @ moment == pytest.approx(-k * u[:3], rel=1e-6, abs=1e-7)

    hinge = np.cross(arms(0.0)[3:] - arms(0.0)[1:3], force[3:]) @ -R[:, 1]
    assert hinge == pytest.approx([0.02, -0.03], rel=1e-6, abs=1e-7)


@pytest.mark.parametrize(("axis", "angle"), [("roll", 0), ("pitch", 1)], ids=["roll", "pitch"])
def test_rolling_single_axis_models_are_slices_of_the_full_model(axis: str, angle: int) -> None:
    q, u = random_state(axis, 0)
    theta = np.zeros(3)
    theta[angle] = q[0]
    keep = [angle, 3, 4]
    full = evaluate("full", UNEQUAL, np.concatenate([theta, q[1:]]), np.zeros(5))
    single = evaluate(axis, UNEQUAL, q, u)
    assert single.mass_matrix == pytest.approx(full.mass_matrix[np.ix_(keep, keep)], rel=1e-12)


def test_legs_held_without_damping_conserve_energy() -> None:
    legs = (0.6, 1.9), (0.0, 0.0), (0.0, 0.0)

    def rate(t: float, y: Array) -> Array:
        return np.concatenate([y[3:], full_model(UNEQUAL, y[:3], y[3:], *legs).theta_ddot])

    start = [0.5, 0.4, 0.0, 1.0, -1.0, 2.0]
    path = solve_ivp(rate, (0.0, 5.0), start, method="DOP853", rtol=1e-11, atol=1e-11).y.T
    energy = np.array([full_model(UNEQUAL, y[:3], y[3:], *legs).energy for y in path])
    assert np.ptp(path[:, 0]) > 0.5
    assert energy == pytest.approx(energy[0], rel=1e-9)


@pytest.mark.parametrize(
    ("name", "kappa", "roll_period", "pitch_period"),
    [
        ("full", 0.0, 1.29251, 1.07346),
        ("full", 0.01, 1.29911, 1.08145),
        ("pivoting", 0.0, 1.18804, 0.94509),
        ("pivoting", 0.01, 1.19524, 0.95419),
    ],
)
def test_table_3(name: str, kappa: float, roll_period: float, pitch_period: float) -> None:
    """Periods 2 pi / Im(eigenvalue) of the linearised motion, legs locked straight up."""

    def acceleration(y: Array) -> Array:
        q, u = np.append(y[:3], [np.pi / 2, np.pi / 2]), np.append(y[3:], [0.0, 0.0])
        return np.asarray(evaluate(name, TABLE_2, q, u, damping=(kappa,) * 3).theta_ddot)

    A = np.eye(6, k=3)
    A[3:] = jacobian(acceleration, np.zeros(6))
    frequency = np.linalg.eigvals(A).imag
    periods = 2 * np.pi / np.sort(frequency[frequency > 1.0])
    assert periods == pytest.approx([roll_period, pitch_period], abs=6e-6)


@pytest.mark.parametrize(
    ("name", "inertia"),
    [("full", [0.010212, 0.007044]), ("pivoting", [0.008628, 0.005460])],
)
def test_inertias_with_legs_up(name: str, inertia: list[float]) -> None:
    q = np.array([0.0, 0.0, 0.0, np.pi / 2, np.pi / 2])
    M = evaluate(name, TABLE_2, q, np.zeros(5)).mass_matrix
    assert np.diag(M)[:2] == pytest.approx(inertia, abs=1e-12)


@pytest.mark.parametrize("hip_offset", [0.12, 0.1])
def test_yaw_mass_matrix_is_eq_12(hip_offset: float) -> None:
    """Eq (12) with M_m = M_s, and with the hip offset b in place of its r."""
    q, _ = random_state("yaw", 3)
    phi1, phi2 = q[1:]
    M_l, M_s, length, b = 0.057, 0.053, 0.1, hip_offset
    M_l_l2 = M_l * length**2
    g11 = 2 * (M_s + M_l) * b**2 + M_l_l2 + M_l_l2 / 2 * (np.cos(2 * phi1) + np.cos(2 * phi2))
    g12, g13 = -M_l * length * b * np.sin(phi1), M_l * length * b * np.sin(phi2)
    expected = [[g11, g12, g13], [g12, M_l_l2, 0.0], [g13, 0.0, M_l_l2]]
    robot = PointMassRobot(hip_offset=hip_offset)
    yaw = evaluate("yaw", robot, q, np.zeros(3)).mass_matrix
    assert yaw == pytest.approx(np.array(expected), rel=1e-12, abs=1e-16)

    upright = np.concatenate([[0.0, 0.0], q])
    pivoting = evaluate("pivoting", robot, upright, np.zeros(5)).mass_matrix
    assert pivoting[2:, 2:] == pytest.approx(yaw, rel=1e-12, abs=1e-16)


def test_yaw_model_has_no_gravity() -> None:
    q, u = random_state("yaw", 4)
    yaw = evaluate("yaw", UNEQUAL, q, u)
    weightless = evaluate("yaw", replace(UNEQUAL, gravity=0.0), q, u)
    for field, value in weightless._asdict().items():
        assert getattr(yaw, field) == pytest.approx(value, rel=1e-12, abs=1e-14), field
    at_rest = evaluate("yaw", UNEQUAL, q, np.zeros(3))
    assert at_rest.leg_torque == pytest.approx(np.zeros(2), abs=1e-15)
    assert at_rest.energy == 0.0


def test_static_equilibrium_rests_on_its_weight() -> None:
    upright, up = np.zeros(3), np.full(2, np.pi / 2)
    q = np.concatenate([upright, up])
    weight = TABLE_2.masses.sum() * TABLE_2.gravity
    for name in ("full", "pivoting"):
        motion = evaluate(name, TABLE_2, q, np.zeros(5))
        assert motion.contact_force == pytest.approx([0.0, 0.0, weight], abs=1e-12)
        assert motion.theta_ddot == pytest.approx(np.zeros(3), abs=1e-12)
    # Battery at z = 0, servos at r, legs at r + l.
    energy = 9.81 * (2 * 0.053 * 0.12 + 2 * 0.057 * 0.22)
    assert motion.energy == pytest.approx(energy, rel=1e-12)


def test_simulated_path_starts_by_an_impulse_and_does_not_slip() -> None:
    h, offset, amplitude, phase = 1e-3, (0.5, 1.2), (0.3, 0.4), (0.2, 1.1)
    path = simulate_full(UNEQUAL, offset, amplitude, 8.0, phase, 0.4, 401, (0.01, 0.01, 0.01))
    phi = np.array(offset) + amplitude * np.sin(phase)
    phi_dot = 8.0 * np.array(amplitude) * np.cos(phase)

    start = (-25 * path.theta[0] + 48 * path.theta[1] - 36 * path.theta[2]) / (12 * h)
    start += (16 * path.theta[3] - 3 * path.theta[4]) / (12 * h)
    M = full_model(UNEQUAL, np.zeros(3), start, phi, phi_dot, (0.0, 0.0)).mass_matrix
    assert M[:3] @ np.append(start, phi_dot) == pytest.approx(np.zeros(3), abs=1e-9)
    assert np.abs(start).max() > 0.5

    def at(values: Array) -> Callable[[float], Array]:
        return lambda t: values[300 + round(t / h)]

    R = rotation(path.theta)
    omega = axial(first(at(R), h) @ R[300].T)
    velocity = UNEQUAL.shell_radius * np.array([omega[1], -omega[0]])
    assert np.abs(path.theta[300]).min() > 0.01
    assert first(at(path.contact_point), h) == pytest.approx(velocity, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("offset", "speed", "yaw_rate"),
    [
        pytest.param(np.pi / 2, 0.009655983, 0.0, marks=pytest.mark.slow),
        (np.pi / 4, 0.006676496, 0.020854659),
    ],
    ids=["lateral", "circular"],
)
def test_steady_state_of_the_two_gaits(offset: float, speed: float, yaw_rate: float) -> None:
    """Net speed and yaw rate from cycle means over the last 19 of 38 periods (14.9 s to 29.8 s).

    The circular gait's speed depends on where in the period a cycle begins, by up to 2e-4 of it.
    """
    cycles, samples = 38, 100
    path = simulate_full(
        TABLE_2,
        offset,
        0.3,
        8.0,
        (0.0, np.pi / 2),
        cycles * PERIOD,
        cycles * samples + 1,
        (0.01, 0.01, 0.01),
    )

    def cycle_means(values: Array) -> Array:
        starts = range(19 * samples, cycles * samples, samples)
        return np.array([simpson(values[i : i + samples + 1], axis=0) / samples for i in starts])

    steps = np.diff(cycle_means(path.contact_point), axis=0) / PERIOD
    assert np.hypot(*steps.T).mean() == pytest.approx(speed, abs=1.5e-9)
    turns = np.diff(cycle_means(path.theta[:, 2])) / PERIOD
    assert turns.mean() == pytest.approx(yaw_rate, abs=5e-8)


def test_wrong_arguments_are_refused() -> None:
    state = (TABLE_2, np.zeros(3), np.zeros(3), np.ones(2), np.zeros(2))
    with pytest.raises(ValueError, match="exactly one"):
        full_model(*state)
    with pytest.raises(ValueError, match="exactly one"):
        pivoting_model(*state, phi_ddot=(0.0, 0.0), leg_torque=(0.0, 0.0))
    with pytest.raises(ValueError, match=r"damping has shape \(2,\), expected \(3,\)"):
        full_model(*state, phi_ddot=(0.0, 0.0), damping=(0.1, 0.1))
    axis: Any = "z"
    with pytest.raises(ValueError, match="axis is 'z'"):
        single_axis_model(axis, TABLE_2, 0.0, 0.0, np.ones(2), np.zeros(2), (0.0, 0.0))
