"""The pivoting model, eq (6), against five point masses, Pinocchio and its invariants."""

import functools
from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

import rrrobot as rr
from tests.derivations import Motion, PointMassRobot, _rotation, pivoting_model
from tests.twins import (
    TABLE_2,
    UNEQUAL,
    Array,
    State,
    coriolis_checks,
    error,
    library_robot,
    random_points,
    random_state,
)

# Legs that swing freely, or at random, go where the ground would be.
pytestmark = pytest.mark.filterwarnings("ignore::rrrobot.errors.GroundClearanceWarning")

SEEDS = range(25)
# The library's coordinates are (yaw, pitch, roll, legs), the derivation's (roll, pitch, yaw, legs).
REORDER = np.array([2, 1, 0, 3, 4])
PERIOD = 2 * np.pi / 8.0


def case(seed: int) -> tuple[PointMassRobot, rr.Robot, State]:
    rng = np.random.default_rng(seed)
    points = random_points(rng)
    return points, library_robot(points), random_state(rng)


def pose_of(model: rr.PivotingModel, state: State) -> Array:
    return model.make_pose(state.theta, np.array([0.3, -0.2]))


def assert_same(found: rr.models.base.Dynamics, expected: Motion) -> None:
    acceleration = np.concatenate([expected.theta_ddot, expected.phi_ddot])[REORDER]
    assert error(found.acceleration, acceleration) < 1e-9
    assert error(found.contact_force, expected.contact_force) < 1e-9
    assert error(found.leg_torque, expected.leg_torque) < 1e-9


@pytest.mark.parametrize("seed", SEEDS)
def test_prescribed_legs_match_five_point_masses(seed: int) -> None:
    points, robot, state = case(seed)
    k = state.coefficients
    model = rr.PivotingModel(robot, damping=rr.EulerRateDamping(*k[:3], legs=k[3]))
    found = model.dynamics(pose_of(model, state), state.theta_dot[::-1], state.leg)
    expected = pivoting_model(
        points,
        state.theta,
        state.theta_dot,
        *state.leg,
        damping=k[:3],
        leg_damping=k[[3, 3]],
    )
    assert_same(found, expected)
    assert sum(model.energy(found.q, found.v)) == pytest.approx(expected.energy, rel=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_torque_driven_legs_match_five_point_masses(seed: int) -> None:
    points, robot, state = case(seed)
    k = state.coefficients
    model = rr.PivotingModel(robot, damping=rr.EulerRateDamping(*k[:3], legs=k[3]))
    found = model.dynamics(
        pose_of(model, state),
        state.theta_dot[::-1],
        leg_angle=state.leg.angle,
        leg_rate=state.leg.rate,
        leg_torque=state.torque,
    )
    expected = pivoting_model(
        points,
        state.theta,
        state.theta_dot,
        state.leg.angle,
        state.leg.rate,
        leg_torque=state.torque,
        damping=k[:3],
        leg_damping=k[[3, 3]],
    )
    assert_same(found, expected)


@functools.cache
def body_rate_jacobian() -> Callable[..., list[list[float]]]:
    """d omega_body / d (roll, pitch, yaw rates) = R^T E, as a function of the three angles."""
    angles = sp.symbols("roll pitch yaw")
    R, E = _rotation(*angles)
    return sp.lambdify(angles, (R.T * E).tolist(), modules="math")


@pytest.mark.parametrize("seed", range(20))
def test_body_rate_damping_is_its_generalised_force(seed: int) -> None:
    """Q = -(d omega_body / d theta_dot)^T diag(k) omega_body, added to the undamped motion."""
    points, robot, state = case(seed)
    k = state.coefficients
    model = rr.PivotingModel(robot, damping=rr.BodyRateDamping(*k[:3], legs=k[3]))
    found = model.dynamics(pose_of(model, state), state.theta_dot[::-1], state.leg)
    free = pivoting_model(points, state.theta, state.theta_dot, *state.leg)

    B = np.array(body_rate_jacobian()(*state.theta))
    force = -B.T @ (k[:3] * (B @ state.theta_dot))
    M = free.mass_matrix
    change = np.linalg.solve(M[:3, :3], force)
    acceleration = np.concatenate([free.theta_ddot + change, state.leg.acceleration])
    assert error(found.acceleration, acceleration[REORDER]) < 1e-9
    torque = free.leg_torque + M[3:, :3] @ change + k[3] * state.leg.rate
    assert error(found.leg_torque, torque) < 1e-9


def test_pivot_reaction_at_rest_is_the_weight() -> None:
    model = rr.PivotingModel(library_robot())
    pose = model.make_pose(np.zeros(3), np.zeros(2))
    legs = rr.drive.LegMotion(np.full(2, np.pi / 2), np.zeros(2), np.zeros(2))
    rest = model.dynamics(pose, np.zeros(3), legs)
    assert rest.contact_force == pytest.approx([0.0, 0.0, 0.52 * 9.81], abs=1e-12)
    assert rest.acceleration == pytest.approx(np.zeros(5), abs=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_mass_matrix(seed: int) -> None:
    """Symmetric positive definite; that of the points; Pinocchio's with a ZYX spherical root."""
    points, robot, state = case(seed)
    model = rr.PivotingModel(robot)
    M = model.mass_matrix(pose_of(model, state), state.leg.angle)
    assert np.array_equal(M, M.T) and np.linalg.eigvalsh(M).min() > 1e-6

    by_hand = pivoting_model(points, state.theta, np.zeros(3), state.leg.angle, *np.zeros((2, 2)))
    assert error(M, by_hand.mass_matrix[np.ix_(REORDER, REORDER)]) < 1e-12

    zyx = pin.buildModelFromXML(robot.urdf, pin.JointModelSphericalZYX())
    q = np.concatenate([state.theta[::-1], state.leg.angle])
    assert error(M, pin.crba(zyx, zyx.createData(), q)) < 1e-13


@pytest.mark.parametrize("seed", range(10))
def test_coriolis_matrix(seed: int) -> None:
    _, robot, state = case(seed)
    model = rr.PivotingModel(robot)
    q = model.configuration(pose_of(model, state), state.leg.angle)
    v = model.velocity(pose_of(model, state), state.theta_dot[::-1], state.leg.rate)
    not_skew, wrong_bias = coriolis_checks(model.model, q, v)
    assert not_skew < 1e-8
    assert wrong_bias < 1e-12


def test_energy_is_conserved_without_damping() -> None:
    model = rr.PivotingModel(library_robot(UNEQUAL), damping=None)
    t = rr.simulate(
        model, rr.StillLegs((0.6, 1.9)), 10.0, 0.05, euler=(0.5, 0.4, 0), start=(1, -1, 2)
    )
    assert np.ptp(t.euler[:, 0]) > 0.5
    assert t.energy == pytest.approx(t.energy[0], rel=1e-9)


def test_power_balance_of_a_damped_gait() -> None:
    """The energy gained is the motors' work less the damping's loss."""
    damping = rr.EulerRateDamping(0.01, 0.02, 0.005, legs=0.003)
    model = rr.PivotingModel(library_robot(UNEQUAL), damping=damping)
    t = rr.simulate(model, rr.gait("circular"), 2.0, 0.005)
    loss = (0.01, 0.02, 0.005) * t.euler_rates**2
    power = (t.leg_torque * t.leg_rate - 0.003 * t.leg_rate**2).sum(axis=1) - loss.sum(axis=1)
    work = make_interp_spline(t.time, power, k=5).antiderivative()(t.time)
    assert np.ptp(t.energy) > 0.05
    assert t.energy - t.energy[0] == pytest.approx(work, abs=1e-9)


def test_impulsive_start_has_no_momentum_of_the_euler_rates() -> None:
    model = rr.PivotingModel(library_robot(UNEQUAL))
    gait = rr.SinusoidalGait(offset=(0.5, 1.2), amplitude=0.3, angular_frequency=8, phase=(0.2, 1))
    euler = np.array([0.2, -0.3, 0.5])
    t = rr.simulate(model, gait, 0.1, euler=euler)
    phi, phi_dot, _ = gait(0.0)
    M = pivoting_model(UNEQUAL, euler, np.zeros(3), phi, *np.zeros((2, 2))).mass_matrix
    assert np.abs(t.euler_rates[0]).max() > 0.3
    momentum = M[:3] @ np.concatenate([t.euler_rates[0], phi_dot])
    assert momentum == pytest.approx(np.zeros(3), abs=1e-15)
    pose, quasi, _ = model.split(t.state[0])
    assert model.momentum(pose, quasi, phi, phi_dot) == pytest.approx(np.zeros(3), abs=1e-15)


def test_rest_start_keeps_a_spurious_yaw_drift() -> None:
    """Started at rest, the undamped yaw turns on without end: why starts are impulsive."""
    model = rr.PivotingModel(library_robot())
    gait, step = rr.gait("lateral"), PERIOD / 12
    rest = rr.simulate(model, gait, 30.0, 0.1, start="rest", step=step)
    impulsive = rr.simulate(model, gait, 30.0, 0.1, step=step)
    assert rest.euler[-1, 2] == pytest.approx(-18.8, abs=0.1)
    assert np.abs(impulsive.euler[:, 2]).max() < 0.2


@pytest.mark.parametrize(
    ("name", "speed", "yaw_rate"),
    [("lateral", 0.009738256, 0.0), ("circular", 0.0073779, 0.1978283)],
)
def test_steady_state_of_the_two_gaits(name: str, speed: float, yaw_rate: float) -> None:
    model = rr.PivotingModel(library_robot())
    t = rr.simulate(model, rr.gait(name), 30.0, PERIOD / 25, step=PERIOD / 12)
    steady = t.steady_state()
    assert steady.speed == pytest.approx(speed, rel=1e-5)
    assert steady.yaw_rate == pytest.approx(yaw_rate, abs=1e-6)


def test_simulation_matches_an_integration_of_the_derivation() -> None:
    """Angles and path to 1e-8, the path by eqs (2)-(3), with other software throughout."""
    gait = rr.gait("circular")
    damping = (0.01, 0.01, 0.0)

    def rate(time: float, y: Array) -> Array:
        motion = pivoting_model(UNEQUAL, y[:3], y[3:6], *gait(time), damping=damping)
        _, pitch, yaw = y[:3]
        along, across = np.cos(pitch) * y[3], y[4]
        c, s = np.cos(yaw), np.sin(yaw)
        path = UNEQUAL.shell_radius * np.array([s * along + c * across, s * across - c * along])
        return np.concatenate([y[3:6], motion.theta_ddot, path])

    M = pivoting_model(UNEQUAL, np.zeros(3), np.zeros(3), *gait(0.0)).mass_matrix
    start = -np.linalg.solve(M[:3, :3], M[:3, 3:] @ gait(0.0).rate)
    y0 = np.concatenate([np.zeros(3), start, np.zeros(2)])
    t = rr.simulate(rr.PivotingModel(library_robot(UNEQUAL)), gait, 3.0)
    y = solve_ivp(rate, (0, 3), y0, method="DOP853", t_eval=t.time, rtol=1e-12, atol=1e-13).y.T
    assert np.abs(t.euler - y[:, :3]).max() < 1e-8
    assert np.abs(t.position - y[:, 6:]).max() < 1e-8
    assert np.ptp(t.euler[:, 2]) > 0.3


def test_torques_of_a_gait_drive_the_legs_along_it() -> None:
    """The multipliers of prescribed legs are motor torques: given as torques, they make the gait.

    The torques are interpolated from samples. Only one second, as free legs are unstable.
    """
    model = rr.PivotingModel(library_robot(UNEQUAL))
    gait = rr.gait("circular")
    prescribed = rr.simulate(model, gait, 1.0, 0.002)
    torque = make_interp_spline(prescribed.time, prescribed.leg_torque, k=5)
    start = gait(0.0)
    drive = rr.LegTorques(torque, angle=start.angle, rate=start.rate)
    free = rr.simulate(model, drive, 1.0, 0.002)
    assert free.leg_angle == pytest.approx(prescribed.leg_angle, abs=1e-7)
    assert free.euler == pytest.approx(prescribed.euler, abs=1e-7)
    assert free.contact_force == pytest.approx(prescribed.contact_force, abs=1e-6)


def test_legs_without_torque_conserve_energy_and_yaw_momentum() -> None:
    model = rr.PivotingModel(library_robot(UNEQUAL), damping=None)
    legs = rr.LegTorques((0.0, 0.0), angle=(1.0, 2.0), rate=(0.5, -0.5))
    t = rr.simulate(model, legs, 3.0, 0.05, euler=(0.2, 0.1, 0), start=(0.3, -0.2, 0.5))
    assert np.ptp(t.leg_angle[:, 0]) > 0.5
    assert t.energy == pytest.approx(t.energy[0], rel=1e-8)
    yaw_momentum = []
    for y in t.state:
        pose, quasi, rest = model.split(y)
        yaw_momentum.append(model.momentum(pose, quasi, rest[:2], rest[2:])[0])
    assert np.ptp(yaw_momentum) < 1e-8 * abs(yaw_momentum[0])


def test_the_path_rolls() -> None:
    """The free-flyer motion that the viewer replays neither slips nor sinks, and passes through
    the contact points."""
    robot = library_robot(UNEQUAL)
    t = rr.simulate(rr.PivotingModel(robot), rr.gait("circular"), 2.0, position=(0.4, -0.1))
    assert t.slip.max() < 1e-13
    assert np.abs(t.height_error).max() < 1e-15
    assert t.position[0].tolist() == [0.4, -0.1]
    frame = robot.model.getFrameId("rrrobot_shell")
    points = [rr.contact_point(robot.model, q, frame, robot.shell) for q in t.configuration[::10]]
    assert np.array(points)[:, :2] == pytest.approx(t.position[::10], abs=1e-15)


def test_it_stops_at_the_vertical() -> None:
    model = rr.PivotingModel(library_robot(), damping=None)
    with pytest.raises(rr.SimulationError, match=r"pitch reached \+-90 degrees") as caught:
        rr.simulate(
            model, rr.StillLegs((1.57, 1.57)), 5.0, euler=(0, 1.2, 0), start=(0.0, 12.0, 0.0)
        )
    t = caught.value.trajectory
    assert t is not None and np.all(np.isfinite(t.euler))
    reached = np.interp(np.pi / 2, t.euler[:, 1], t.time)
    assert 0.02 < reached < 0.04
    assert t.time[-1] <= caught.value.time < reached + model.max_step


def test_default_damping_is_eq_10_without_its_legs() -> None:
    damping = rr.PivotingModel(library_robot()).damping
    assert damping == rr.EulerRateDamping(0.01, 0.01, 0.0)
    assert library_robot().model.nv == 8
    assert library_robot(TABLE_2) == rr.Robot.from_parameters()
