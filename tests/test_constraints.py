"""Rolling constraint, projectors and KKT against finite differences and other formulations."""

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from rrrobot.contact.surfaces import SHELL_FRAME
from tests.random_robot import random_robot, random_state

SHELLS = {
    "sphere": {},
    "ellipsoid": {"shell": rr.Ellipsoid((0.35, 0.3, 0.27))},
    "tilted ground": {"normal": (0.2, -0.1, 1.0)},
    "tilted ellipsoid": {"shell": rr.Ellipsoid((0.3, 0.4, 0.35)), "normal": (-0.3, 0.2, 1)},
}


def integrate(model, q, v, a, t):
    """Configuration and velocity after t along constant acceleration a, to second order in t."""
    return pin.integrate(model, q, v * t + a * t * t / 2), v + a * t


@pytest.fixture(params=SHELLS)
def case(request):
    options = dict(SHELLS[request.param])
    ground = rr.Plane(options.pop("normal", (0.0, 0.0, 1.0)))
    robot = random_robot(3, **options)
    model = robot.model
    rng = np.random.default_rng(7)
    q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
    return robot, ground, q, rng.normal(size=model.nv), rng.normal(size=model.nv)


def test_jacobian_gives_the_velocity_of_the_material_contact_point(case):
    robot, ground, q, v, _ = case
    model, data = robot.model, robot.model.createData()
    frame = model.getFrameId(SHELL_FRAME)
    rolling = rr.constraints.RollingContact.of(robot, ground)
    contact = rr.contact_point(model, q, frame, robot.shell, ground.normal_vector)
    pin.forwardKinematics(model, data, q)
    placement = pin.updateFramePlacement(model, data, frame).copy()
    on_body = placement.actInv(contact)

    def at(t):
        pin.forwardKinematics(model, data, pin.integrate(model, q, v * t))
        return pin.updateFramePlacement(model, data, frame).act(on_body)

    h = 1e-5
    velocity = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)
    found = rolling.ground.basis @ rolling.evaluate(data, q, v).residual
    np.testing.assert_allclose(found, velocity, atol=1e-9)


def test_drift_is_the_rate_of_the_residual(case):
    robot, ground, q, v, a = case
    rolling, data = rr.constraints.RollingContact.of(robot, ground), robot.model.createData()

    def residual(t):
        return rolling.evaluate(data, *integrate(robot.model, q, v, a, t)).residual.copy()

    h = 1e-4
    rate = (8 * (residual(h) - residual(-h)) - (residual(2 * h) - residual(-2 * h))) / (12 * h)
    rows = rolling.evaluate(data, q, v)
    np.testing.assert_allclose(rows.jacobian @ a + rows.drift, rate, rtol=1e-7, atol=1e-8)


def test_drift_of_a_body_fixed_contact_point_would_be_wrong(case):
    """The trap: adding Omega x (Omega x rho), as for a point fixed to the body."""
    robot, ground, q, v, _ = case
    rolling, data = rr.constraints.RollingContact.of(robot, ground), robot.model.createData()
    rows = rolling.evaluate(data, q, v)
    omega = pin.getFrameVelocity(
        robot.model, data, rolling.frame_id, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    ).angular
    arm = robot.shell.arm(data.oMf[rolling.frame_id].rotation, rolling.ground.normal_vector)
    assert np.linalg.norm(np.cross(omega, np.cross(omega, arm))) > 0.01
    wrong = rolling.ground.basis.T @ np.cross(omega, np.cross(omega, arm))
    h = 1e-4
    nothing = np.zeros(robot.model.nv)

    def residual(t):
        return rolling.evaluate(data, *integrate(robot.model, q, v, nothing, t)).residual.copy()

    rate = (residual(h) - residual(-h)) / (2 * h)
    assert np.linalg.norm(rows.drift - rate) < 1e-3 * np.linalg.norm(rows.drift + wrong - rate)


def test_holonomic_row_is_the_rate_of_the_height(case):
    robot, ground, q, v, _ = case
    rolling, data = rr.constraints.RollingContact.of(robot, ground), robot.model.createData()

    def height(t):
        rolling.evaluate(data, pin.integrate(robot.model, q, v * t), v)
        return rolling.height(data)

    h = 1e-5
    rate = (8 * (height(h) - height(-h)) - (height(2 * h) - height(-2 * h))) / (12 * h)
    residual = rolling.evaluate(data, q, v).residual
    assert residual[rolling.holonomic][0] == pytest.approx(rate, abs=1e-9)
    assert rolling.holonomic.tolist() == [False, False, True]


def test_plain_functions_are_the_class():
    robot = random_robot(5)
    model = robot.model
    frame = model.getFrameId(SHELL_FRAME)
    q = pin.integrate(model, pin.neutral(model), np.linspace(-1, 1, model.nv))
    v = np.linspace(1, 2, model.nv)
    rolling = rr.constraints.RollingContact.of(robot, rr.Plane((0.1, 0.2, 1.0)))
    rows = rolling.evaluate(model.createData(), q, v)
    np.testing.assert_array_equal(
        rr.contact_jacobian(model, q, frame, robot.shell, (0.1, 0.2, 1.0)), rows.jacobian
    )
    np.testing.assert_array_equal(
        rr.contact_drift(model, q, v, frame, robot.shell, (0.1, 0.2, 1.0)), rows.drift
    )


def test_plain_functions_on_an_arm_with_a_ball_at_its_end():
    """No free-flyer, no Robot: a ball on the last link of somebody's fixed-base arm."""
    model = pin.buildSampleModelManipulator()
    ball = pin.Frame("ball", model.njoints - 1, pin.SE3.Random(), pin.FrameType.OP_FRAME)
    frame = model.addFrame(ball)
    rng = np.random.default_rng(0)
    q, v = pin.randomConfiguration(model), rng.normal(size=model.nv)
    normal = np.array((0.0, 0.6, 0.8))
    shell = rr.Sphere(0.1)
    h = 1e-4

    def residual(t):
        at = pin.integrate(model, q, v * t)
        return rr.contact_jacobian(model, at, frame, shell, normal) @ v

    rate = (8 * (residual(h) - residual(-h)) - (residual(2 * h) - residual(-2 * h))) / (12 * h)
    drift = rr.contact_drift(model, q, v, frame, shell, normal)
    np.testing.assert_allclose(drift, rate, atol=1e-8 * (1 + np.abs(rate).max()))
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    lowest = data.oMf[frame].translation - 0.1 * normal
    np.testing.assert_allclose(rr.contact_point(model, q, frame, shell, normal), lowest, atol=1e-15)


@pytest.mark.parametrize("seed", range(5))
def test_projector_and_null_space(seed):
    robot = random_robot(seed)
    model = rr.FullModel(robot)
    pose, _, angle, _ = random_state(robot, seed)
    place = model.place(pose)
    q = model.configuration(place, angle)
    nv = robot.model.nv
    jacobian = model.rolling.evaluate(model.data, q, np.zeros(nv)).jacobian
    frame = robot.model.getFrameId(SHELL_FRAME)
    world = rr.contact_point(robot.model, q, frame, robot.shell)
    contact = place.rotation.T @ (world - q[:3])
    projector = rr.kkt.rolling_projector(contact, nv)
    basis = rr.kkt.rolling_null_space(contact, nv)
    np.testing.assert_allclose(projector, projector.T, atol=1e-15)
    np.testing.assert_allclose(projector @ projector, projector, atol=1e-14)
    np.testing.assert_allclose(jacobian @ projector, 0, atol=1e-14)
    np.testing.assert_allclose(jacobian @ basis, 0, atol=1e-14)
    expected = np.eye(nv) - np.linalg.pinv(jacobian) @ jacobian
    np.testing.assert_allclose(projector, expected, atol=1e-12)
    assert np.linalg.matrix_rank(basis) == nv - 3
    np.testing.assert_allclose(projector @ basis, basis, atol=1e-14)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("shell", SHELLS)
def test_kkt_projection_and_pinocchio_agree(seed, shell):
    options = dict(SHELLS[shell])
    ground = rr.Plane(options.pop("normal", (0.0, 0.0, 1.0)))
    robot = random_robot(seed, **options)
    model = rr.FullModel(robot, ground=ground, damping=None)
    pose, omega, angle, rate = random_state(robot, seed)
    q, v = model.configuration(pose, angle), model.velocity(pose, omega, rate)
    torque = np.random.default_rng(seed).normal(size=robot.n_legs)
    solution = model.dynamics(pose, omega, leg_angle=angle, leg_rate=rate, leg_torque=torque)

    pin_model, data = robot.model, robot.model.createData()
    rows = model.rolling.evaluate(data, q, v)
    assert np.linalg.norm(rows.residual) < 1e-14
    tau = np.zeros(pin_model.nv)
    tau[model.legs.v] = torque
    by_pinocchio = pin.forwardDynamics(pin_model, data, q, v, tau, rows.jacobian, rows.drift, 0.0)
    scale = np.abs(by_pinocchio).max()
    np.testing.assert_allclose(solution.acceleration, by_pinocchio, atol=1e-9 * scale)

    mass, bias = pin.crba(pin_model, data, q), pin.nonLinearEffects(pin_model, data, q, v)
    # N_dot u by differences along the motion; the projector needs no multipliers.
    nv, h = pin_model.nv, 1e-5
    u = np.concatenate((omega, v[6:]))

    def basis(t):
        place = model.place(pose + t * model.pose_rate(model.place(pose), pose, omega))
        full = np.zeros((nv, nv - 3))
        full[:6, :3] = place.basis
        full[6:, 3:] = np.eye(nv - 6)
        return full

    rate_u = (8 * (basis(h) - basis(-h)) - (basis(2 * h) - basis(-2 * h))) @ u / (12 * h)
    projected = rr.kkt.projected_acceleration(mass, bias, tau, basis(0), rate_u)
    np.testing.assert_allclose(projected, solution.acceleration, atol=1e-9 * scale)


def test_prescribed_joints_move_as_told_and_their_torques_do_it():
    robot = random_robot(1)
    model = rr.FullModel(robot, damping=0.02)
    pose, omega, angle, rate = random_state(robot, 1)
    wanted = np.random.default_rng(2).normal(size=robot.n_legs)
    leg = rr.drive.LegMotion(angle, rate, wanted)
    prescribed = model.dynamics(pose, omega, leg)
    np.testing.assert_allclose(prescribed.acceleration[model.legs.v], wanted, atol=1e-12)
    driven = model.dynamics(
        pose, omega, leg_angle=angle, leg_rate=rate, leg_torque=prescribed.leg_torque
    )
    np.testing.assert_allclose(driven.acceleration, prescribed.acceleration, atol=1e-9)
    np.testing.assert_allclose(driven.contact_force, prescribed.contact_force, atol=1e-9)


def test_dependent_rows_are_refused():
    rows = rr.constraints.PrescribedJoints([0], nv=2).evaluate(
        None, None, np.zeros(2), legs=rr.drive.LegMotion(np.zeros(1), np.zeros(1), np.ones(1))
    )
    system = rr.kkt_build(np.eye(2), np.zeros(2), np.zeros(2), rows, rows)
    with pytest.raises(rr.ConstraintError, match="singular"):
        rr.kkt_solve(system)
