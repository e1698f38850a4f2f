"""Mimic joints follow their master in every model, method and engine.

Checked against the same robot with every joint a leg of its own, driven by hand.
"""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.momentum.coefficients import coefficients
from rrrobot.robot.mimics import couplings
from rrrobot.robot.reader import parse_urdf
from tests.mechanisms import EVERY, LEGS, MATRIX, RATIOS, mimic_urdf, pair, spread

DAMPING = rr.BodyRateDamping(0.02, 0.03, 0.04)
RNG = np.random.default_rng(3)


def models(cls=rr.FullModel, seed=0):
    return [cls(robot, damping=DAMPING) for robot in pair(seed)]


def random_state(model):
    pose = model.make_pose(RNG.uniform(-0.5, 0.5, 3), RNG.uniform(-1, 1, 2))
    return pose, RNG.normal(size=3)


def test_chains_of_mimics_are_followed_to_their_leg():
    found = couplings(parse_urdf(mimic_urdf(mimics=True)))
    assert {name: c.leg for name, c in found.items()} == dict.fromkeys(RATIOS, "hip")
    for name, (ratio, offset) in RATIOS.items():
        assert found[name][1:] == pytest.approx((ratio, offset), abs=1e-15)


def test_legs_are_those_that_move_by_themselves():
    robot = rr.Robot.from_urdf(mimic_urdf(mimics=True), shell=rr.Sphere(0.3))
    assert set(robot.legs) == set(LEGS)
    assert set(robot.couplings) == set(RATIOS)
    assert robot.model.nv == 8


@pytest.mark.parametrize("cls", [rr.FullModel, rr.PivotingModel])
def test_prescribed_dynamics_are_those_of_the_joints_driven_by_hand(cls):
    follows, free = models(cls)
    pose, quasi = random_state(follows)
    angle, rate, acceleration = RNG.normal(size=(3, 2))
    leg = rr.drive.LegMotion(angle, rate, acceleration)
    by_hand = rr.drive.LegMotion(
        spread(angle, offset=True), spread(rate, offset=False), spread(acceleration, offset=False)
    )
    one, other = follows.dynamics(pose, quasi, leg), free.dynamics(pose, quasi, by_hand)
    body = follows.quasi_acceleration(one.acceleration)
    assert body == pytest.approx(free.quasi_acceleration(other.acceleration), rel=1e-10)
    assert one.contact_force == pytest.approx(other.contact_force, rel=1e-10)
    # The hip's motor does the work of the joints that follow.
    assert one.leg_torque == pytest.approx(MATRIX.T @ other.leg_torque, rel=1e-9)
    energies = follows.energy(one.q, one.v), free.energy(other.q, other.v)
    assert energies[0] == pytest.approx(energies[1], rel=1e-12)


def test_mass_matrix_is_reduced_by_the_ratios():
    follows, free = models()
    pose, _ = random_state(follows)
    angle = RNG.normal(size=2)
    whole = free.mass_matrix(pose, spread(angle, offset=True))
    matrix = np.zeros((free.model.nv, follows.model.nv))
    matrix[:6, :6] = np.eye(6)
    rows = free.legs.v[:, None]
    matrix[rows, follows.legs.v] = MATRIX
    reduced = follows.mass_matrix(pose, angle)
    assert reduced == pytest.approx(matrix.T @ whole @ matrix, abs=1e-14)


def test_torque_driven_legs_obey_lagrange_with_the_ratios():
    """M a + h = tau + J^T f of all joints with v = S u: S^T of it, by NumPy alone."""
    import pinocchio as pin

    follows, free = models()
    pose, quasi = random_state(follows)
    angle, rate, torque = RNG.normal(size=(3, 2))
    one = follows.dynamics(pose, quasi, leg_angle=angle, leg_rate=rate, leg_torque=torque)
    q = free.configuration(pose, spread(angle, offset=True))
    v = free.velocity(pose, quasi, spread(rate, offset=False))
    matrix = np.zeros((free.model.nv, follows.model.nv))
    matrix[:6, :6] = np.eye(6)
    matrix[free.legs.v[:, None], follows.legs.v] = MATRIX
    data = free.model.createData()
    rows = rr.constraints.RollingContact.of(free.robot).evaluate(data, q, v)
    mass = matrix.T @ pin.crba(free.model, data, q) @ matrix
    force = -matrix.T @ pin.nonLinearEffects(free.model, data, q, v)
    force[3:6] += DAMPING.moment(0, 0, quasi)
    force[follows.legs.v] += torque
    jacobian = rows.jacobian @ matrix
    system = np.block([[mass, -jacobian.T], [jacobian, np.zeros((3, 3))]])
    expected = np.linalg.solve(system, np.concatenate((force, -rows.drift)))
    assert one.acceleration == pytest.approx(expected[:8], rel=1e-9)
    assert one.contact_force == pytest.approx(expected[8:], rel=1e-9)


def test_the_fast_form_tabulates_what_the_joints_by_hand_give():
    one, other = pair()
    angle, rate = RNG.normal(size=(2, 40, 2))
    fast = coefficients(one, angle, rate)
    slow = coefficients(other, spread(angle, offset=True), spread(rate, offset=False))
    assert fast == pytest.approx(slow, abs=1e-13)


def test_simulations_agree_in_both_methods_and_by_hand():
    follows, free = models()
    gait = rr.SinusoidalGait(
        offset=(0.2, -0.1), amplitude=(0.4, 0.3), angular_frequency=7.0, phase=(0.0, 1.0)
    )
    by_hand = rr.SinusoidalGait(
        offset=spread((0.2, -0.1), offset=True),
        amplitude=np.add(spread((0.4, 0.0), offset=False), (0, 0.3, 0, 0, 0)),
        angular_frequency=7.0,
        phase=(0.0, 1.0, 0.0, 0.0, 0.0),
    )
    runs = [
        rr.simulate(follows, gait, 2.0),
        rr.simulate(follows, gait, 2.0, method="momentum", step=0.005),
        rr.simulate(free, by_hand, 2.0),
    ]
    for other in runs[1:]:
        assert other.position == pytest.approx(runs[0].position, abs=3e-8)
        assert other.contact_force == pytest.approx(runs[0].contact_force, abs=1e-5)
    assert np.abs(runs[0].energy - runs[2].energy).max() < 1e-6
    assert runs[0].slip.max() < 1e-12


@pytest.mark.slow
def test_sweeps_give_the_motors_the_work_of_what_follows():
    follows, free = models()
    grids = {"amplitude": (0.4, 0.3), "offset": (0.2, -0.1), "phase": (0.0, 1.0)}
    by_hand = {
        "amplitude": tuple(np.add(spread((0.4, 0.0), offset=False), (0, 0.3, 0, 0, 0))),
        "offset": tuple(spread((0.2, -0.1), offset=True)),
        "phase": (0.0, 1.0, 0.0, 0.0, 0.0),
    }
    one = rr.sweep(follows, **grids, angular_frequency=7.0, loads=True, progress=False)
    other = rr.sweep(free, **by_hand, angular_frequency=7.0, loads=True, progress=False)
    for name in ("speed", "yaw_rate", "normal_force", "friction"):
        assert float(one[name]) == pytest.approx(float(other[name]), rel=1e-9)
    # The motors' power is that of a simulation, whose torques are Pinocchio's.
    gait = rr.SinusoidalGait(
        offset=grids["offset"], amplitude=grids["amplitude"], angular_frequency=7.0,
        phase=grids["phase"],
    )  # fmt: skip
    cycles = int(one.attrs["cycles"])
    t = rr.simulate(follows, gait, cycles * gait.period, gait.period / 400)
    last = slice(-400, None)
    peak = np.abs(t.leg_torque[last]).max()
    assert float(one.peak_torque) == pytest.approx(peak, rel=2e-3)


def test_a_held_master_holds_what_follows_it():
    robot = rr.Robot.from_urdf(
        mimic_urdf(mimics=True), shell=rr.Sphere(0.3), legs=("tail",), locked={"hip": 0.5}
    )
    expected = {name: m * 0.5 + b for name, (m, b) in RATIOS.items()} | {"hip": 0.5}
    assert dict(robot.locked) == pytest.approx(expected)
    assert robot.couplings == {}


def test_a_mimic_that_is_locked_stays():
    robot = rr.Robot.from_urdf(
        mimic_urdf(mimics=True), shell=rr.Sphere(0.3), locked={"b_knee": 0.1}
    )
    # The foot follows the knee, and stands still with it.
    assert robot.locked["c_foot"] == pytest.approx(-0.1 / 3 - 0.1)
    assert set(robot.couplings) == {"slide"}


def test_robots_with_mimics_pickle_and_are_saved():
    import pickle

    robot, _ = pair()
    for copy in (pickle.loads(pickle.dumps(robot)), rr.Robot.from_dict(robot.to_dict())):
        assert copy == robot
        assert copy.couplings == robot.couplings
        assert copy.model.names.tolist() == robot.model.names.tolist()


def test_a_mimic_is_no_leg():
    with pytest.raises(rr.UrdfError, match="mimics 'hip': it follows by itself"):
        rr.Robot.from_urdf(mimic_urdf(mimics=True), shell=rr.Sphere(0.3), legs=EVERY)


def test_what_cannot_follow_is_refused():
    text = mimic_urdf(mimics=False)
    tail = text.replace(
        '<child link="hip_link"/>', '<child link="hip_link"/><mimic joint="tail" multiplier="2"/>'
    )
    with pytest.raises(rr.UrdfError, match="'hip' mimics 'tail', which hangs on it"):
        rr.Robot.from_urdf(tail, shell=rr.Sphere(0.3))
    crossed = tail.replace(
        '<child link="tail_link"/>', '<child link="tail_link"/><mimic joint="hip"/>'
    )
    for master, bad in (
        ("hip", text.replace('"hip_link"/>', '"hip_link"/><mimic joint="hip"/>')),
        ("tail", crossed),
    ):
        with pytest.raises(rr.UrdfError, match=f"mimics '{master}', which follows it"):
            rr.Robot.from_urdf(bad, shell=rr.Sphere(0.3))


def test_a_mimic_of_nothing_is_told_and_moves_by_itself():
    text = mimic_urdf(mimics=False).replace(
        '<child link="hip_link"/>', '<child link="hip_link"/><mimic joint="nobody"/>'
    )
    with pytest.warns(rr.UrdfWarning, match="mimic joint 'hip' .of 'nobody', which moves not"):
        robot = rr.Robot.from_urdf(text, shell=rr.Sphere(0.3))
    assert set(robot.legs) == set(EVERY)


def test_the_coriolis_matrix_is_refused_and_not_wrong():
    model, _ = models()
    with pytest.raises(rr.ModelError, match="no Coriolis matrix"):
        model.equations(model._neutral, np.zeros(8))


def test_the_rate_of_the_inertia_is_its_derivative():
    """Against that of every joint a leg, Coriolis' matrix and its transpose."""
    import pinocchio as pin

    from rrrobot.robot.joints import JointIndex, joint_inertia_rate

    follows, free = (robot.model for robot in pair())
    angle, rate = RNG.normal(size=(2, 2))
    found = []
    for model, names, phi, phi_dot in (
        (follows, LEGS, angle, rate),
        (free, EVERY, spread(angle, offset=True), spread(rate, offset=False)),
    ):
        q, v, index = pin.neutral(model), np.zeros(model.nv), JointIndex(model, names)
        index.write(q, phi)
        v[index.v] = phi_dot
        found.append((joint_inertia_rate(model, model.createData(), q, v), index.v))
    matrix = np.zeros((free.nv, follows.nv))
    matrix[:6, :6] = np.eye(6)
    matrix[found[1][1][:, None], found[0][1]] = MATRIX
    assert found[0][0] == pytest.approx(matrix.T @ found[1][0] @ matrix, abs=1e-10)
