"""The full model against an independent derivation, eq (1), and closed forms."""

import pickle

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from rrrobot.paper import paper_equations
from rrrobot.rotations import body_rates_matrix, body_rates_matrix_rate, rotation_from_quaternion
from tests import derivations
from tests.pages import numbers
from tests.random_robot import random_robot, random_state
from tests.twins import TABLE_2, UNEQUAL, library_robot


@pytest.fixture(scope="module")
def robot():
    return rr.Robot.from_parameters(rr.RRRobotParameters())


def test_reference_state(robot):
    """The figures of the project's physics notes: two derivations gave them."""
    model = rr.FullModel(robot, damping=0.01)
    pose = model.make_pose((0.1, 0.2, 0.3), (0.0, 0.0))
    omega = model.quasi_from_euler_rates(pose, np.array((0.5, -0.4, 0.7)))
    leg = rr.drive.LegMotion(np.array((0.9, 1.3)), np.array((1.0, -2.0)), np.array((3.0, 4.0)))
    found = model.dynamics(pose, omega, leg)
    alpha = rotation_from_quaternion(pose[:4]) @ found.acceleration[3:6]
    # R w_dot is the world's Omega_dot, as Omega x Omega = 0.
    np.testing.assert_allclose(alpha, (-3.99715178, 0.62958431, -3.24837911), atol=1e-8)
    np.testing.assert_allclose(found.contact_force, (-0.02480551, 0.14486663, 5.1065834), atol=1e-8)
    np.testing.assert_allclose(found.leg_torque, (0.04610733, 0.02238164), atol=1e-8)
    assert numbers("../README.md", r"torques \| ([\de-]+) of two derivations") == (1e-8,)


@pytest.mark.parametrize("masses", [TABLE_2, UNEQUAL], ids=["Table 2", "unequal"])
@pytest.mark.parametrize("driven", [False, True], ids=["prescribed", "torques"])
def test_against_point_mass_kane(masses, driven):
    rng = np.random.default_rng(11)
    kappa, on_legs = (0.01, 0.02, 0.03), 0.004
    damping = rr.EulerRateDamping(*kappa, legs=on_legs)
    model = rr.FullModel(library_robot(masses), damping=damping)
    for _ in range(20):
        theta, rates = rng.uniform(-1.2, 1.2, 3), 3 * rng.normal(size=3)
        phi, phi_dot = rng.uniform(-3, 3, 2), 3 * rng.normal(size=2)
        given = 5 * rng.normal(size=2) * (0.05 if driven else 1.0)
        pose = model.make_pose(theta, (0.3, -0.2))
        omega = model.quasi_from_euler_rates(pose, rates)
        if driven:
            kane = derivations.full_model(
                masses, theta, rates, phi, phi_dot, leg_torque=given, damping=kappa,
                leg_damping=(on_legs, on_legs),
            )  # fmt: skip
            found = model.dynamics(pose, omega, leg_angle=phi, leg_rate=phi_dot, leg_torque=given)
        else:
            kane = derivations.full_model(
                masses, theta, rates, phi, phi_dot, given, damping=kappa,
                leg_damping=(on_legs, on_legs),
            )  # fmt: skip
            found = model.dynamics(pose, omega, rr.drive.LegMotion(phi, phi_dot, given))
        alpha = rotation_from_quaternion(pose[:4]) @ found.acceleration[3:6]
        for ours, theirs in (
            (alpha, kane.omega_dot),
            (found.acceleration[model.legs.v], kane.phi_ddot),
            (found.contact_force, kane.contact_force),
            (found.leg_torque, kane.leg_torque),
            (sum(model.energy(found.q, found.v)), kane.energy),
        ):
            np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9)


def test_support_force_is_newtons(robot):
    """The contact multipliers equal the rate of the momentum less the weight."""
    for case, normal in ((robot, (0, 0, 1)), (random_robot(4), (0.1, 0.2, 1.0))):
        model = rr.FullModel(case, ground=rr.Plane(normal), damping=0.01)
        pose, omega, angle, rate = random_state(case, 3)
        found = model.dynamics(pose, omega, rr.drive.LegMotion(angle, rate, np.ones(case.n_legs)))
        by_newton = model.support_force(found.q, found.v, found.acceleration)
        np.testing.assert_allclose(found.contact_force, by_newton, rtol=1e-9, atol=1e-9)


def paper_state(trajectory, i):
    """(q, q_dot) of the paper at a sample of a trajectory."""
    euler, rates = trajectory.euler[i], trajectory.euler_rates[i]
    data = trajectory.robot.model.createData()
    q, v = trajectory.configuration[i], trajectory.velocity[i]
    pin.forwardKinematics(trajectory.robot.model, data, q, v)
    center = pin.getVelocity(
        trajectory.robot.model, data, 1, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    ).linear
    return (
        np.concatenate((trajectory.position[i], euler, trajectory.leg_angle[i])),
        np.concatenate((center[:2], rates, trajectory.leg_rate[i])),
    )


def test_equation_1_holds_along_a_trajectory(robot):
    """M q_ddot + C q_dot + G - tau - lambda omega - zeta = 0 in the paper's coordinates."""
    damping = rr.EulerRateDamping(0.01, 0.01, 0.01, legs=0.01)
    model = rr.FullModel(robot, damping=damping)
    gait = rr.gait("circular")
    t = rr.simulate(model, gait, duration=3.0, sample_interval=0.1)
    for i in range(len(t)):
        q, q_dot = paper_state(t, i)
        terms = paper_equations(model, q, q_dot)
        pose = np.concatenate((t.configuration[i, 3:7], t.position[i]))
        w = t.velocity[i, 3:6]
        found = model.dynamics(pose, w, gait(t.time[i]))
        matrix = body_rates_matrix(t.euler[i, 0], t.euler[i, 1])
        matrix_rate = body_rates_matrix_rate(t.euler[i], t.euler_rates[i])
        angles = np.linalg.solve(matrix, found.acceleration[3:6] - matrix_rate @ t.euler_rates[i])
        v = t.velocity[i]
        center = model.place(pose).rotation @ (found.acceleration[:3] + np.cross(v[3:6], v[:3]))
        q_ddot = np.concatenate((center[:2], angles, found.acceleration[model.legs.v]))
        tau = np.concatenate((np.zeros(5), found.leg_torque))
        residual = (
            terms.mass_matrix @ q_ddot
            + terms.coriolis @ q_dot
            + terms.gravity
            - tau
            - found.contact_force[:2] @ terms.omega
            - terms.damping
        )
        assert np.abs(residual).max() < 1e-9
        assert np.abs(terms.omega @ q_dot).max() < 1e-14
        assert abs(center[2]) < 1e-12


def test_equation_5_as_printed_does_not_roll(robot):
    """The erratum: with cos(roll) in the third entry the contact slips."""
    model = rr.FullModel(robot)
    t = rr.simulate(model, rr.gait("circular"), duration=1.0)
    q, q_dot = paper_state(t, -1)
    omega = paper_equations(model, q, q_dot).omega
    printed = omega.copy()
    printed[1, 2] = robot.shell.radius * np.cos(q[2]) * np.cos(q[4])
    assert abs(omega[1] @ q_dot) < 1e-14
    assert abs(printed[1] @ q_dot) > 1e-5


def test_paper_coordinates_mass_and_coriolis(robot):
    model = rr.FullModel(robot)
    rng = np.random.default_rng(0)
    for _ in range(10):
        q, q_dot = rng.uniform(-1, 1, 7), rng.normal(size=7)
        terms = paper_equations(model, q, q_dot)
        np.testing.assert_allclose(terms.mass_matrix, terms.mass_matrix.T, atol=1e-14)
        assert np.linalg.eigvalsh(terms.mass_matrix).min() > 0
        h = 1e-4

        def mass(s, q=q, q_dot=q_dot):
            return paper_equations(model, q + s * q_dot, q_dot).mass_matrix

        rate = (8 * (mass(h) - mass(-h)) - (mass(2 * h) - mass(-2 * h))) / (12 * h)
        skew = rate - 2 * terms.coriolis
        np.testing.assert_allclose(skew, -skew.T, atol=1e-10)


def test_free_flyer_equations(robot):
    """M a + C v + G is Pinocchio's inverse dynamics; M_dot - 2 C is skew-symmetric."""
    model = rr.FullModel(robot)
    rng = np.random.default_rng(2)
    q = pin.integrate(model.model, pin.neutral(model.model), rng.normal(size=8))
    v, a = rng.normal(size=(2, 8))
    terms = model.equations(q, v)
    rnea = pin.rnea(model.model, model.data, q, v, a)
    np.testing.assert_allclose(
        terms.mass_matrix @ a + terms.coriolis @ v + terms.gravity, rnea, atol=1e-13
    )
    h = 1e-4

    def mass(s):
        return model.equations(pin.integrate(model.model, q, s * v), v).mass_matrix

    rate = (8 * (mass(h) - mass(-h)) - (mass(2 * h) - mass(-2 * h))) / (12 * h)
    skew = rate - 2 * terms.coriolis
    np.testing.assert_allclose(skew, -skew.T, atol=1e-10)


def test_paper_coordinates_need_the_papers_robot():
    slope = rr.FullModel(rr.Robot.from_parameters(), ground=rr.Plane((0.1, 0, 1)))
    for model, why in ((rr.FullModel(random_robot(0)), "centre"), (slope, "level ground")):
        with pytest.raises(rr.ModelError, match=why):
            n = 5 + model.n_legs
            paper_equations(model, np.zeros(n), np.zeros(n))


def test_body_rate_damping_takes_its_power(robot):
    model = rr.FullModel(robot, damping=rr.BodyRateDamping(0.01, 0.02, 0.03, legs=0.005))
    pose, w, angle, rate = random_state(robot, 5)
    torque = np.array((0.01, -0.02))
    h = 1e-4

    def energy(t):
        """Energy after t, by two Taylor terms of the state."""
        found = model.dynamics(pose, w, leg_angle=angle, leg_rate=rate, leg_torque=torque)
        place = model.place(pose)
        at = pose + t * model.pose_rate(place, pose, w)
        q = model.configuration(at, angle + t * rate)
        v = model.velocity(
            at, w + t * found.acceleration[3:6], rate + t * found.acceleration[model.legs.v]
        )
        return sum(model.energy(q, v))

    power = (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h)
    expected = torque @ rate - w @ ((0.01, 0.02, 0.03) * w) - 0.005 * rate @ rate
    assert power == pytest.approx(expected, rel=1e-6)


def test_ball_on_an_incline_has_the_textbook_acceleration():
    """A homogeneous ball rolls down a slope beta with g sin(beta) / (1 + I / (m r^2))."""
    m, r, beta = 2.0, 0.25, 0.3
    inertia = 0.4 * m * r * r
    ball = (
        '<robot name="ball"><link name="ball"><inertial><mass value="2"/><inertia '
        f'ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link></robot>"
    )
    normal = (np.sin(beta), 0.0, np.cos(beta))
    robot = rr.Robot.from_urdf(ball, shell=rr.Sphere(r))
    model = rr.FullModel(robot, ground=rr.Plane(normal))
    t = rr.simulate(model, rr.StillLegs([]), duration=2.0, sample_interval=0.5, start="rest")
    travelled = 0.5 * 9.81 * np.sin(beta) / 1.4 * t.time**2
    np.testing.assert_allclose(t.position[:, 0], travelled, atol=1e-9)
    np.testing.assert_allclose(t.position[:, 1], 0, atol=1e-12)
    np.testing.assert_allclose(t.normal_force, m * 9.81 * np.cos(beta), rtol=1e-12)
    np.testing.assert_allclose(t.required_friction, np.tan(beta) * 2 / 7, rtol=1e-9)


@pytest.mark.slow
def test_yaw_damping_sets_the_turning(robot):
    """Table 4's tenfold: with a tenth of the yaw damping the full model turns like the pivoting."""

    def turning(model):
        t = rr.simulate(model, rr.gait("circular"), duration=40.0, sample_interval=0.02)
        return t.steady_state(after=30.0).yaw_rate

    light = turning(rr.FullModel(robot, damping=(0.01, 0.01, 0.001)))
    pivoting = turning(rr.PivotingModel(robot))
    said = numbers("table4.md", r"model turns at ([\d.]+) rad/s .* model's ([\d.]+); with")
    assert (light, pivoting) == pytest.approx(said, abs=6e-4)
    damped = turning(rr.PivotingModel(robot, damping=(0.01, 0.01, 0.01)))
    assert abs(damped) < 1e-4


def test_pickle(robot):
    model = rr.FullModel(robot, damping=rr.BodyRateDamping(0.1))
    copy = pickle.loads(pickle.dumps(model))
    assert copy.damping == model.damping and copy.robot == robot
    a = rr.simulate(model, rr.gait("lateral"), duration=0.5)
    b = rr.simulate(copy, rr.gait("lateral"), duration=0.5)
    np.testing.assert_array_equal(a.state, b.state)


def test_wrong_use_is_told(robot):
    model = rr.FullModel(robot)
    with pytest.raises(rr.ModelError, match="prescribed"):
        model.dynamics(np.array([0, 0, 0, 1.0, 0, 0]), np.zeros(3))
    with pytest.raises(rr.ParameterError, match="damping"):
        rr.FullModel(robot, damping=-0.1)
    with pytest.raises(rr.ParameterError, match="damping"):
        rr.FullModel(robot, damping="heavy")


def test_what_is_no_robot_no_model_and_no_state_is_said_so():
    robot = rr.Robot.from_parameters()
    for make in (rr.FullModel, rr.PivotingModel, rr.YawModel):
        for wrong in (robot.model, rr.Robot, "solo12"):
            with pytest.raises(rr.ModelError, match="it must be a Robot"):
                make(wrong)
    with pytest.raises(rr.ModelError, match="model is Robot: it must be a model"):
        rr.simulate(robot, rr.gait("lateral"))
    model = rr.FullModel(robot)
    q = model.configuration((0, 0, 0, 1, 0, 0), (1.5, 1.5))
    for bad, text in (
        (0 * q, "unit one"),
        (1.01 * q, "unit one"),
        (q[:3], "hold 9"),
        (q * np.nan, "finite"),
    ):
        with pytest.raises(rr.ParameterError, match=text):
            model.equations(bad, np.zeros(8))
