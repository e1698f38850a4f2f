"""The roll, pitch and yaw models, eq (11), against five point masses and their invariants."""

from typing import Any, NamedTuple, cast

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp

import rrrobot as rr
from tests.derivations import Axis, Motion, PointMassRobot, single_axis_model
from tests.pages import numbers
from tests.twins import (
    UNEQUAL,
    Array,
    State,
    coriolis_checks,
    error,
    library_robot,
    parameters,
    random_points,
    random_state,
)

# Legs that swing freely, or at random, go where the ground would be.
pytestmark = pytest.mark.filterwarnings("ignore::rrrobot.errors.GroundClearanceWarning")

MODELS: dict[str, Any] = {"roll": rr.RollModel, "pitch": rr.PitchModel, "yaw": rr.YawModel}
AXES = tuple(MODELS)
ROLLING = AXES[:2]
SEEDS = range(20)
GAIT = rr.SinusoidalGait(
    offset=(0.7, 0.9), amplitude=(0.3, 0.4), angular_frequency=8.0, phase=(0.0, 1.9)
)
every_axis = pytest.mark.parametrize("axis", AXES)


class Case(NamedTuple):
    points: PointMassRobot
    robot: rr.Robot
    state: State
    axis: Axis
    index: int

    @property
    def angle(self) -> float:
        return float(self.state.theta[self.index])

    @property
    def rate(self) -> float:
        return float(self.state.theta_dot[self.index])

    def pose(self, model: rr.models.base.Model, angle: float | None = None) -> Array:
        euler = np.zeros(3)
        euler[self.index] = self.angle if angle is None else angle
        return model.make_pose(euler, np.array([0.3, -0.2]))


def make_case(axis: str, seed: int) -> Case:
    rng = np.random.default_rng(seed)
    points = random_points(rng)
    state = random_state(rng)
    return Case(points, library_robot(points), state, cast(Axis, axis), AXES.index(axis))


def assert_same(model: rr.models.base.Model, found: Any, expected: Motion) -> None:
    assert error(model.quasi_acceleration(found.acceleration), [expected.theta_ddot]) < 1e-9
    assert error(found.acceleration[model.legs.v], expected.phi_ddot) < 1e-9
    assert error(found.contact_force, expected.contact_force) < 1e-9
    assert error(found.leg_torque, expected.leg_torque) < 1e-9
    energy = sum(model.energy(found.q, found.v))
    assert energy == pytest.approx(expected.energy, rel=1e-12)


@every_axis
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("law", ["euler", "body"])
def test_prescribed_legs_match_five_point_masses(axis: str, seed: int, law: str) -> None:
    """Both damping laws act with the coefficient of the axis that is free."""
    case = make_case(axis, seed)
    k = case.state.coefficients
    kind = rr.EulerRateDamping if law == "euler" else rr.BodyRateDamping
    model = MODELS[axis](case.robot, damping=kind(*k[:3], legs=k[3]))
    found = model.dynamics(case.pose(model), np.array([case.rate]), case.state.leg)
    expected = single_axis_model(
        case.axis,
        case.points,
        case.angle,
        case.rate,
        *case.state.leg,
        damping=k[case.index],
        leg_damping=k[[3, 3]],
    )
    assert_same(model, found, expected)


@every_axis
@pytest.mark.parametrize("seed", SEEDS)
def test_torque_driven_legs_match_five_point_masses(axis: str, seed: int) -> None:
    case = make_case(axis, seed)
    k, leg = case.state.coefficients, case.state.leg
    model = MODELS[axis](case.robot, damping=rr.EulerRateDamping(*k[:3], legs=k[3]))
    found = model.dynamics(
        case.pose(model),
        np.array([case.rate]),
        leg_angle=leg.angle,
        leg_rate=leg.rate,
        leg_torque=case.state.torque,
    )
    expected = single_axis_model(
        case.axis,
        case.points,
        case.angle,
        case.rate,
        leg.angle,
        leg.rate,
        leg_torque=case.state.torque,
        damping=k[case.index],
        leg_damping=k[[3, 3]],
    )
    assert_same(model, found, expected)


@every_axis
def test_simulation_matches_an_integration_of_the_derivation(axis: str) -> None:
    damping = 0.0 if axis == "yaw" else 0.01
    name = cast(Axis, axis)

    def rate(time: float, y: Array) -> Array:
        motion = single_axis_model(name, UNEQUAL, y[0], y[1], *GAIT(time), damping=damping)
        return np.array([y[1], float(motion.theta_ddot)])

    M = single_axis_model(name, UNEQUAL, 0.0, 0.0, *GAIT(0.0)).mass_matrix
    y0 = [0.0, -M[0, 1:] @ GAIT(0.0).rate / M[0, 0]]
    t = rr.simulate(MODELS[axis](library_robot(UNEQUAL)), GAIT, 3.0, 0.05)
    y = solve_ivp(rate, (0, 3), y0, method="DOP853", t_eval=t.time, rtol=1e-12, atol=1e-13).y
    assert np.ptp(y[0]) > 0.1
    assert np.abs(t.euler[:, AXES.index(axis)] - y[0]).max() < 1e-8


@every_axis
@pytest.mark.parametrize("seed", range(10))
def test_mass_matrix(axis: str, seed: int) -> None:
    """Symmetric positive definite; along the rolling motion it is that of the points."""
    case = make_case(axis, seed)
    model = MODELS[axis](case.robot)
    M = model.mass_matrix(case.pose(model), case.state.leg.angle)
    assert np.array_equal(M, M.T) and np.linalg.eigvalsh(M).min() > 1e-6

    N = np.zeros((model.model.nv, 3))
    N[:-2, :1] = model.place(case.pose(model)).basis
    N[model.legs.v, [1, 2]] = 1.0
    still = single_axis_model(
        case.axis, case.points, case.angle, 0.0, case.state.leg.angle, *np.zeros((2, 2))
    )
    assert error(N.T @ M @ N, still.mass_matrix) < 1e-12


@pytest.mark.parametrize("seed", range(20))
def test_yaw_mass_matrix_is_eq_12(seed: int) -> None:
    case = make_case("yaw", seed)
    model = rr.YawModel(case.robot)
    M = model.mass_matrix(case.pose(model), case.state.leg.angle)
    assert error(M, rr.paper.yaw_mass_matrix(parameters(case.points), case.state.leg.angle)) < 1e-13
    assert numbers("../README.md", r"eq \(12\) \| ([\de-]+) \|") == (1e-13,)
    turned = model.mass_matrix(case.pose(model, 2.0), case.state.leg.angle)
    assert np.abs(turned - M).max() < 1e-15


@pytest.mark.parametrize("axis", ROLLING)
def test_rolling_mass_matrix_depends_on_the_angle(axis: str) -> None:
    case = make_case(axis, 0)
    model = MODELS[axis](case.robot)
    here, there = (model.mass_matrix(case.pose(model, a), case.state.leg.angle) for a in (0, 1))
    assert np.abs(here - there).max() > 1e-4


@every_axis
def test_nothing_depends_on_the_contact_point(axis: str) -> None:
    case = make_case(axis, 1)
    model = MODELS[axis](case.robot)
    pose = case.pose(model)
    rate = np.array([case.rate])
    here = model.dynamics(pose, rate, case.state.leg)
    away = pose + np.array([0.0, 3.0, -2.0])
    there = model.dynamics(away, rate, case.state.leg)
    assert there.acceleration == pytest.approx(here.acceleration, rel=1e-12, abs=1e-12)


def test_yaw_dynamics_do_not_depend_on_yaw() -> None:
    case = make_case("yaw", 2)
    model = rr.YawModel(case.robot)
    rate = np.array([case.rate])
    here, there = (model.dynamics(case.pose(model, a), rate, case.state.leg) for a in (0.0, 2.0))
    assert there.acceleration == pytest.approx(here.acceleration, rel=1e-12, abs=1e-12)
    assert there.leg_torque == pytest.approx(here.leg_torque, rel=1e-12, abs=1e-14)


@every_axis
@pytest.mark.parametrize("seed", range(5))
def test_coriolis_matrix(axis: str, seed: int) -> None:
    case = make_case(axis, seed)
    model = MODELS[axis](case.robot)
    q = model.configuration(case.pose(model), case.state.leg.angle)
    # Any velocity, also one that slips.
    v = np.random.default_rng(seed).uniform(-3, 3, model.model.nv)
    not_skew, wrong_bias = coriolis_checks(model.model, q, v)
    assert not_skew < 1e-8
    assert wrong_bias < 1e-12


@every_axis
def test_energy_is_conserved_without_damping(axis: str) -> None:
    """With the legs still, and with the legs free and without torque."""
    model = MODELS[axis](library_robot(UNEQUAL), damping=None)
    start = np.zeros(3)
    start[AXES.index(axis)] = 2.0
    still = rr.simulate(model, rr.StillLegs((0.6, 1.9)), 4.0, 0.05, start=start)
    free = rr.simulate(
        model, rr.LegTorques((0.0, 0.0), angle=(1.0, 2.0), rate=(0.5, -0.5)), 2.0, start=start
    )
    for t in (still, free):
        assert np.ptp(t.euler[:, AXES.index(axis)]) > 0.3
        assert t.energy == pytest.approx(t.energy[0], rel=1e-8)
    assert np.ptp(free.leg_angle[:, 0]) > 0.3


@pytest.mark.parametrize(
    "start", ["impulsive", pytest.param((0.0, 0.0, 1.0), marks=pytest.mark.slow)]
)
def test_yaw_momentum_is_conserved(start: Any) -> None:
    """To 1e-12 kg m^2/s over 30 s at the default settings; zero after an impulsive start."""
    model = rr.YawModel(library_robot())
    gait = rr.gait("circular")
    t = rr.simulate(model, gait, 30.0, 0.1, start=start)
    momentum = [
        model.momentum(y[:3], y[3:], angle, rate)[0]
        for y, angle, rate in zip(t.state, t.leg_angle, t.leg_rate, strict=True)
    ]
    assert np.abs(np.array(momentum) - momentum[0]).max() < 1e-12
    # 38.2 cycles turn it by alpha t = 0.407 rad, or with the momentum of 1 rad/s by more than 20.
    assert abs(t.euler[-1, 2]) > 0.3
    assert abs(momentum[0]) < 1e-17 if start == "impulsive" else momentum[0] > 1e-3


def test_impulsive_yaw_is_the_kinematic_reduction() -> None:
    """Eq (14): g11 yaw_rate + g12 phi1_rate + g13 phi2_rate = 0 all along."""
    t = rr.simulate(rr.YawModel(library_robot(UNEQUAL)), GAIT, 3.0, 0.05)
    for rates, angle, rate in zip(t.euler_rates, t.leg_angle, t.leg_rate, strict=True):
        g11, *g = rr.paper.yaw_mass_matrix(parameters(UNEQUAL), angle)[0]
        assert rates[2] == pytest.approx(-np.array(g) @ rate / g11, abs=1e-9)


@pytest.mark.parametrize("axis", ROLLING)
@pytest.mark.parametrize("seed", range(5))
def test_the_row_that_is_left_out_holds_by_itself(axis: str, seed: int) -> None:
    """The model imposes one row of `RollingContact`; the chain of joints satisfies the other two,
    and the imposed one holds at every velocity that the model can have."""
    case = make_case(axis, seed)
    model = MODELS[axis](case.robot)
    assert isinstance(model.rolling, rr.constraints.RollingContact)
    assert model.rolling.imposed == ({"roll": 1, "pitch": 0}[axis],)
    frame = model.model.getFrameId("rrrobot_shell")
    whole = rr.constraints.RollingContact(model.model, frame, case.robot.shell)
    q = model.configuration(case.pose(model), case.state.leg.angle)
    v = model.velocity(case.pose(model), np.array([case.rate]), case.state.leg.rate)
    rows = whole.evaluate(model.data, q, v)
    imposed = model.rolling.imposed[0]
    others = [i for i in range(3) if i != imposed]
    assert np.abs(rows.residual).max() < 1e-15
    assert rows.jacobian[others] == pytest.approx(np.zeros((2, model.model.nv)), abs=1e-16)
    assert rows.drift[others] == pytest.approx(np.zeros(2), abs=1e-14)
    assert np.abs(rows.jacobian[imposed]).max() == pytest.approx(1.0)
    own = model.rolling.evaluate(model.data, q, v)
    assert np.array_equal(own.jacobian[0], rows.jacobian[imposed])
    assert np.array_equal(own.drift, rows.drift[[imposed]])


@every_axis
def test_trajectories_roll_and_stay_on_their_axis(axis: str) -> None:
    """travel = -r roll or +r pitch; nothing else moves, nothing slips."""
    robot = library_robot(UNEQUAL)
    model = MODELS[axis](robot)
    t = rr.simulate(model, GAIT, 3.0)
    index, r = AXES.index(axis), UNEQUAL.shell_radius
    others = [i for i in range(3) if i != index]
    assert np.all(t.euler[:, others] == 0) and np.all(t.euler_rates[:, others] == 0)
    assert np.ptp(t.euler[:, index]) > 0.05
    travel = {"roll": (0, -r), "pitch": (r, 0), "yaw": (0, 0)}[axis]
    assert t.position == pytest.approx(np.outer(t.euler[:, index], travel), abs=1e-14)
    assert t.slip.max() < 1e-15 and np.abs(t.height_error).max() < 1e-15
    if model.rolling is not None:
        for y, angle, rate in zip(t.state, t.leg_angle, t.leg_rate, strict=True):
            q, v = model.configuration(y[:3], angle), model.velocity(y[:3], y[3:], rate)
            assert np.abs(model.rolling.evaluate(model.data, q, v).residual).max() < 1e-15


@every_axis
@pytest.mark.parametrize("seed", range(3))
def test_reduced_urdf_locks_the_other_axes(axis: str, seed: int) -> None:
    """In Pinocchio's own kinematics of the reduced-joint URDF, at any q and v."""
    case = make_case(axis, seed)
    urdf = rr.robot.reduced_urdf(case.robot.urdf, case.axis, height=case.points.shell_radius)
    model = pin.buildModelFromXML(urdf)
    assert model.nv == {"roll": 4, "pitch": 4, "yaw": 3}[axis]
    data = model.createData()
    q = np.random.default_rng(seed).uniform(-2, 2, model.nq)
    v = np.random.default_rng(seed + 100).uniform(-2, 2, model.nv)
    frame = model.getFrameId("shell")
    pin.forwardKinematics(model, data, q, v)
    body = pin.updateFramePlacement(model, data, frame)
    velocity = pin.getFrameVelocity(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
    angle = q[model.joints[model.getJointId(f"base_{axis}")].idx_q]
    turn = np.zeros(3)
    turn[case.index] = angle
    assert body.rotation == pytest.approx(pin.rpy.rpyToMatrix(turn), abs=1e-15)
    allowed = {"roll": [1, 3], "pitch": [0, 4], "yaw": [5]}[axis]
    locked = [i for i in range(6) if i not in allowed]
    assert np.abs(velocity.vector[locked]).max() < 1e-15
    assert body.translation[2] == case.points.shell_radius
    assert np.abs(velocity.vector[allowed]).min() > 1e-3


@every_axis
def test_a_start_on_a_locked_axis_is_refused(axis: str) -> None:
    model = MODELS[axis](library_robot())
    index = AXES.index(axis)
    for other in {0, 1, 2} - {index}:
        wrong = np.zeros(3)
        wrong[other] = 0.1
        with pytest.raises(rr.ModelError, match=f"start .* the {axis} model locks {AXES[other]}"):
            rr.simulate(model, GAIT, 1.0, start=wrong)
        with pytest.raises(rr.ModelError, match=f"euler .* the {axis} model locks {AXES[other]}"):
            rr.simulate(model, GAIT, 1.0, euler=wrong)
    right = np.zeros(3)
    right[index] = 0.1
    t = rr.simulate(model, GAIT, 0.1, euler=right, start=right)
    assert t.euler[0] == pytest.approx(right, abs=1e-15)
    assert t.euler_rates[0] == pytest.approx(right, abs=1e-15)


def test_pitch_turns_over_the_vertical() -> None:
    """Nothing is singular there: thrown hard, it rolls through, and conserves its energy."""
    model = rr.PitchModel(library_robot(), damping=None)
    t = rr.simulate(model, rr.StillLegs((0.3, 0.3)), 2.0, start=(0.0, 30.0, 0.0))
    assert t.euler[-1, 1] > 4 * np.pi
    assert np.diff(t.euler[:, 1]).min() > 0
    assert t.energy == pytest.approx(t.energy[0], rel=1e-8)
    assert t.position[:, 0] == pytest.approx(0.12 * t.euler[:, 1], abs=1e-12)
