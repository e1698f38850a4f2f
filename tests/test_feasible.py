"""Limits along a run: what is passed, when and by how much; distances; runs that stop there."""

import time

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from rrrobot.belly import MotionLimits, feasibility
from rrrobot.belly.tilting import tilts
from tests.test_belly import BALL, board

GAIT = rr.SinusoidalGait(
    offset=(-0.1, -0.1), amplitude=(0.3, 0.3), angular_frequency=7.0, phase=(0.0, np.pi / 2)
)


@pytest.fixture(scope="module")
def belly():
    robot = rr.Robot.from_urdf(board(), shell=rr.Sphere(1.0))
    return rr.fit_belly(robot, posture=(-0.1, -0.1))


@pytest.fixture(scope="module")
def run(belly):
    return rr.simulate(belly.model(damping=0.05), GAIT, 3.0, 0.01)


def test_every_limit_is_judged_as_the_trajectory_has_it(belly, run):
    wanted = MotionLimits(friction=1e-3, power=1e-3, normal_force=60.0, clearance=0.1)
    found = feasibility(run, wanted, belly=belly)
    by_name = {(v.what, v.where): v for v in found.violations}
    assert {what for what, _ in by_name} == {"friction", "power", "normal force", "clearance"}
    friction = by_name["friction", "board"]
    k = int(np.argmax(run.required_friction))
    assert friction.worst == run.time[k]
    assert friction.amount == pytest.approx(run.required_friction[k] - 1e-3)
    assert friction.time == run.time[np.argmax(run.required_friction > 1e-3)]
    assert by_name["normal force", "board"].value == run.normal_force.min()
    power = np.abs(run.leg_torque * run.leg_rate).sum(axis=1)
    assert by_name["power", "board"].value == pytest.approx(power.max()) == found.peak_power
    # The left arm's ball, from its place in the world.
    model, data, height = run.robot.model, run.robot.model.createData(), []
    for q in run.configuration:
        pin.forwardKinematics(model, data, q)
        height.append(data.oMi[2].act(np.array((0.15, 0, 0)))[2] - BALL)
    assert by_name["clearance", "left"].value == pytest.approx(min(height), abs=1e-12)
    assert "clearance of left" in str(found) and not found.feasible
    assert feasibility(run, belly=belly).feasible


def test_joint_limits_are_of_each_joint_and_huge_efforts_are_none(belly):
    fast = rr.SinusoidalGait(
        offset=(-0.5, -0.1), amplitude=(0.7, 0.3), angular_frequency=7.0, phase=(0.0, np.pi / 2)
    )
    with pytest.warns(rr.LimitWarning):
        run = rr.simulate(belly.model(), fast, 1.5, 0.01)
    found = [v for v in feasibility(run, belly=belly).violations if v.what == "position"]
    (one,) = found
    assert one.where == "left_hip" and one.limit == -1.0
    assert one.amount == pytest.approx(0.2, abs=1e-3)
    solo = rr.Robot.from_example("solo12", shell=rr.Sphere(0.3))
    assert solo.joints.unlimited == solo.legs and np.isinf(solo.joints.effort).all()
    assert belly.robot.joints.unlimited == ()
    anymal = rr.Robot.from_example("anymal", shell=rr.Sphere(0.3))
    assert anymal.joints.unlimited == () and np.isfinite(anymal.joints.effort).all()


def test_the_tilt_is_that_of_the_range(belly):
    model = belly.model(damping=None)
    for tilt, azimuth in ((0.2, 0.0), (0.1, 2.0)):
        # Turned about the axis that puts that side down.
        axis = np.array((-np.sin(azimuth), np.cos(azimuth), 0))
        turn = pin.AngleAxis(tilt, axis).toRotationMatrix()
        q = np.concatenate((np.zeros(3), pin.Quaternion(turn).coeffs(), np.zeros(2)))
        found = tilts(belly, q[None], np.zeros((1, 2)), model.ground)
        assert found[0][0] == pytest.approx(tilt) and found[1][0] == pytest.approx(azimuth)
    still = rr.StillLegs(belly.posture)
    t = rr.simulate(model, still, 0.5, euler=(0.3, 0, 0), start="rest")
    (one,) = [v for v in feasibility(t, belly=belly).violations if v.what == "tilt"]
    assert one.time == 0.0 and one.value == pytest.approx(0.3, rel=1e-3)
    phase = t.euler[int(np.argmin(np.abs(t.time - one.worst))), 0]
    assert one.limit == pytest.approx(belly.rolling_range.at(-np.sign(phase) * np.pi / 2))


def test_a_flat_belly_s_tilt_is_its_place_over_the_radius():
    robot = rr.Robot.from_urdf(board(arms=False), shell=rr.Sphere(1.0))
    belly = rr.fit_belly(robot, ground=rr.Boulder(0.5))
    t = rr.simulate(belly.model(damping=None), rr.StillLegs(()), 1.0, start=(0.8, 0.4, 0))
    tilt, _ = tilts(belly, t.configuration, t.position, t.ground)
    place = t.state[:, 4:6]
    assert tilt == pytest.approx(np.linalg.norm(place, axis=1) / 0.5, abs=1e-9)
    assert tilt.max() > 0.02


def test_a_run_stops_at_the_first_limit(belly):
    stop = rr.belly.limit_event(belly, MotionLimits(friction=0.1))
    model, still = belly.model(damping=None), rr.StillLegs(belly.posture)
    options = {"euler": (0.1, 0, 0), "start": "rest"}
    whole = rr.simulate(model, still, 1.0, 0.002, **options)
    t = rr.simulate(model, still, 1.0, 0.002, events=[stop], **options)
    over = whole.time[np.argmax(whole.required_friction > 0.1)]
    # It begins beyond, comes down, and stops where it grows past the limit again.
    assert whole.required_friction[0] > 0.1
    falls = np.flatnonzero(np.diff((whole.required_friction > 0.1).astype(int)) == 1)
    assert over == 0.0 and t.events[0].name == "limit"
    assert t.time[-1] == pytest.approx(whole.time[falls[0]], abs=0.004)


def test_links_apart_are_coal_s_distance_and_neighbours_do_not_count():
    solo = rr.Robot.from_example("solo12", shell=rr.Sphere(0.3))
    shapes = rr.belly.Shapes.of(solo)
    parents = solo.model.parents
    for i, j in shapes.pairs:
        a, b = shapes.pieces[i].joint, shapes.pieces[j].joint
        assert a != b and parents[a] != b and parents[b] != a
    # Both shanks turned inward until the feet of one side meet.
    q = np.concatenate((pin.neutral(solo.model)[:7], np.zeros(12)))
    q[2] = 1.0
    apart = rr.belly.clearances(shapes, q[None], rr.Plane())
    assert apart.between[0] > 0.01
    q[7 + 4], q[7 + 5] = 1.5, 0.0
    q[7 + 1], q[7 + 2] = -1.2, 0.0
    q[7 + 0], q[7 + 3] = -0.9, 0.9
    crossed = rr.belly.clearances(shapes, q[None], rr.Plane())
    assert crossed.between[0] < apart.between[0]
    # All feet at the same height over a plane, on a boulder as high where it is below the robot.
    feet = [apart.links.index(f"{leg}_FOOT") for leg in ("FL", "FR", "HL", "HR")]
    assert apart.ground[0, feet] == pytest.approx(apart.ground[0, feet[0]], abs=1e-3)


@pytest.mark.parametrize("jump", [False, True])
def test_pairs_that_are_not_looked_at_are_not_the_nearest(jump):
    """Along a motion, and among postures that have nothing to do with each other."""
    solo = rr.Robot.from_example("solo12", shell=rr.Sphere(0.3))
    shapes = rr.belly.Shapes.of(solo)
    rng, t = np.random.default_rng(4), np.linspace(0, 2 * np.pi, 150)
    q = np.tile(np.concatenate((pin.neutral(solo.model)[:7], np.zeros(12))), (150, 1))
    swing = np.sin(t[:, None] + rng.uniform(0, 6, 12)) * rng.uniform(0.3, 1.5, 12)
    q[:, 7:] = rng.uniform(-1.5, 1.5, (150, 12)) if jump else swing
    q[:, 0] = 3.0 * t
    found = rr.belly.clearances(shapes, q, rr.Plane())
    data, apart = solo.model.createData(), shapes.geometry.createData()
    every = np.empty((150, len(shapes.pairs)))
    for row, one in zip(every, q, strict=True):
        pin.computeDistances(solo.model, data, shapes.geometry, apart, one)
        row[:] = [result.min_distance for result in apart.distanceResults]
    assert np.ptp(every.min(axis=1)) > 0.05 and np.unique(every.argmin(axis=1)).size > 3
    np.testing.assert_allclose(found.between, every.min(axis=1), atol=2e-6)
    np.testing.assert_allclose(every[np.arange(150), found.pair], found.between, atol=2e-6)


def test_distances_of_a_hundred_gaits_take_seconds():
    solo = rr.Robot.from_example("solo12", shell=rr.Sphere(0.3))
    shapes = rr.belly.Shapes.of(solo)
    rng = np.random.default_rng(0)
    q = np.tile(np.concatenate((pin.neutral(solo.model)[:7], np.zeros(12))), (5 * 64, 1))
    q[:, 7:] = rng.uniform(-0.4, 0.4, (len(q), 12))
    assert len(shapes.pairs) > 90
    begin = time.process_time()
    rr.belly.clearances(shapes, q, rr.Plane())
    # Five gaits of 64 samples; a hundred in 10 s are 0.5 s.
    assert time.process_time() - begin < 0.5
