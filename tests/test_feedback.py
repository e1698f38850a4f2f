"""Inverse maps, paths that are followed, robots that are learnt, goals that are reached."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import rrrobot as rr
from rrrobot.cli.main import cli
from rrrobot.drive.schedule import Schedule, stretch
from rrrobot.steering import Gear, MeasuredRun, Sensor, Track, follow, identify, reach
from rrrobot.steering.gears import GEARS
from rrrobot.steering.motions import motions_of
from rrrobot.steering.standing import rest_of, standing
from tests.some import some

NOISE = (1e-3, np.deg2rad(0.5))
OTHER = rr.RRRobotParameters(
    leg_mass=(0.0555, 0.0588), battery_mass=0.29, shell_radius=0.1215, damping=0.013
)


SLOPE = np.tan(np.deg2rad(2.0)) * np.array((np.cos(1.0), np.sin(1.0)))


@pytest.fixture(scope="module")
def model(home):
    return rr.FullModel(rr.Robot.from_parameters())


@pytest.fixture(scope="module")
def other():
    return rr.FullModel(rr.Robot.from_parameters(OTHER))


@pytest.fixture(scope="module")
def tilted(other):
    """The other robot on a slope of 2 deg."""
    return rr.FullModel(other.robot, ground=rr.Plane(normal=(*SLOPE, 1.0)))


@pytest.mark.parametrize("name", some(GEARS, {"left"}))
def test_gears_do_what_they_say(model, name):
    """A gait of the inverse map, simulated, has the speed and the curvature asked for."""
    gear = Gear(motions_of(model), name)
    for curvature in 0.5 * gear.curvature:
        drive = gear.drive(0.7 * gear.fastest(curvature), curvature)
        gait = rr.SinusoidalGait(
            offset=drive.offset, amplitude=drive.amplitude, angular_frequency=8.0,
            phase=(0.0, drive.phase_difference),
        )  # fmt: skip
        s = rr.simulate(model, gait, 38 * gait.period, method="momentum").steady_state()
        # Between the map's nodes, and r (c0 + c1 r) between its two amplitudes.
        assert s.speed == pytest.approx(0.7 * gear.fastest(curvature), rel=0.02)
        assert s.curvature == pytest.approx(curvature, rel=0.03)


@pytest.mark.parametrize("name", some(GEARS, {"forward"}))
def test_gears_are_smooth_and_bounded(model, name):
    gear = Gear(motions_of(model), name)
    low, high = gear.curvature
    found = [gear.drive(0.005, k) for k in np.linspace(0.7 * low, 0.7 * high, 400)]
    for key in ("offset", "amplitude", "phase_difference"):
        assert np.abs(np.diff([getattr(d, key) for d in found])).max() < 0.05
    at_most = gear.drive(1.0, gear.brisk[1])
    assert at_most.amplitude == 0.5
    assert at_most.twist[2] / at_most.speed == pytest.approx(gear.brisk[1], rel=1e-9)
    beyond = gear.drive(1.0, 2 * high)
    assert beyond.speed == gear.fastest(high)
    assert beyond.twist[2] / beyond.speed == pytest.approx(high, rel=1e-9)
    inside = gear.drive(0.6 * gear.fastest(0.3 * high), 0.3 * high)
    assert inside.speed == pytest.approx(0.6 * gear.fastest(0.3 * high), rel=1e-10)
    assert inside.twist[2] / inside.speed == pytest.approx(0.3 * high, rel=1e-10)


def test_nearest_points():
    circle = Track.circle((0.1, 0.2), 0.3)
    near = circle.nearest((0.1 + 0.25, 0.2))
    # To the left of a counter-clockwise circle is within.
    assert near.aside == pytest.approx(0.05, abs=1e-6)
    assert near.course == pytest.approx(np.pi / 2, abs=0.002)
    assert near.curvature == pytest.approx(1 / 0.3, rel=1e-5)
    for angle in np.linspace(0, 2 * np.pi, 50):
        outside = np.array((0.1, 0.2)) + 0.32 * np.array((np.cos(angle), np.sin(angle)))
        found = circle.nearest(outside)
        assert found.aside == pytest.approx(-0.02, abs=1e-6)
        assert np.sin(0.5 * (found.along / 0.3 - angle)) == pytest.approx(0.0, abs=1e-4)
        assert found.curvature == pytest.approx(1 / 0.3, rel=1e-5)
    eight = Track.eight(0.5)
    # At the crossing each branch is its own.
    for along, course in ((0.0, np.pi / 4), (eight.length / 2, 3 * np.pi / 4)):
        found = eight.nearest((0.0, 0.0), along).course
        assert abs(np.sin(2 * (found - course))) < 0.02
    turn = Track([(0, 0), (1, 0), (1, 1)])
    assert turn.nearest((0.995, 0.0)).curvature > 50 and turn.nearest((0.5, 0)).curvature == 0
    for bad in ([(0, 0)], [(0, 0), (0, 0)], [(0, 0), (np.nan, 1)], "way"):
        with pytest.raises(rr.ParameterError):
            Track(bad)


@pytest.mark.slow
def test_an_eight_on_another_robot(model, other):
    sensor = Sensor(place=NOISE[0], yaw=NOISE[1], delay=1)
    run = follow(model, Track.eight(0.5), 150.0, truth=other, sensor=sensor)
    assert run.stopped is None and run.rms < 0.005
    # What the legs did is a gait; replayed it ends at the same place.
    rest = rest_of(other, run.gait.rest, run.start[2])
    t = rr.simulate(other, run.gait, run.gait.duration + rest.settling, 5.0, start="rest",
                    method="momentum", euler=rest.euler, position=run.start[:2])  # fmt: skip
    assert np.hypot(*(t.position[-1] - run.end[:2])) < 1e-5
    ax = run.plot()
    np.testing.assert_array_equal(ax.get_lines()[1].get_xydata(), run.mean[:, :2])


def test_corners_and_backward(model):
    run = follow(model, Track([(0, 0), (0.25, 0), (0.25, 0.2)]), 200.0)
    # A corner is rounded: the smallest radius is 5 cm.
    assert run.stopped is None and run.rms < 0.012
    assert np.abs(run.error[-8:]).max() < 0.012
    assert np.hypot(*(run.end[:2] - (0.25, 0.2))) < 0.05
    back = follow(model, Track.circle((0, 0), 0.2), 60.0, gear="backward")
    assert (
        back.rms < 0.005
        and np.linalg.norm(np.diff(back.mean[-9:, :2], axis=0), axis=1).sum() > 0.03
    )
    with pytest.raises(rr.ParameterError, match="forward or backward"):
        follow(model, Track.eight(), 60.0, gear="left")


def test_a_start_aside(model):
    run = follow(model, Track([(0, 0), (0.6, 0)]), 60.0, start=(0, 0.04, 0.3))
    assert abs(run.error[0]) > 0.03 and np.abs(run.error[-10:]).max() < 0.005


@pytest.mark.parametrize("fault", ["fails_after", "jumps_after"])
def test_lost_measurements_stop_the_legs_smoothly(model, fault):
    run = follow(model, Track([(0, 0), (1, 0)]), 60.0, sensor=Sensor(**{fault: 12.0}))
    assert "no measurement" in run.stopped and len(run.time) < 25
    assert run.end[0] < 0.25
    time = np.linspace(0, run.gait.duration, 20_000)
    motion = run.gait(time)
    assert not motion.rate[-1].any() and not motion.acceleration[-1].any()
    h = time[1]
    np.testing.assert_allclose(np.diff(motion.rate, axis=0) / h, motion.acceleration[1:], atol=1.0)


def measured(model, gait, duration, seed=None):
    euler = rest_of(model, gait(0.0).angle).euler
    t = rr.simulate(model, gait, duration, 0.02, start="rest", euler=euler, method="momentum")
    pose = np.column_stack((t.position, t.euler[:, 2]))
    if seed is not None:
        pose += np.random.default_rng(seed).normal(size=pose.shape) * (NOISE[0], *NOISE)
    return MeasuredRun(time=t.time, pose=pose, leg_angle=t.leg_angle)


@pytest.mark.slow
def test_a_run_tells_the_robot(tilted, tmp_path):
    gait = Schedule(
        [
            stretch(8, offset=(0.3, 0.3), amplitude=0.4, phase=(0, 2.0)),
            stretch(8, offset=(1.57, 1.57), amplitude=0.5, phase=(0, 1.7)),
        ],
        angular_frequency=8.0, rest=(np.pi / 2,) * 2, blend=2.0,
    )  # fmt: skip
    exact = identify(measured(tilted, gait, 25.0))
    want = (0.013, 0.0555, 0.0588, 0.29, 0.1215, *-SLOPE)
    np.testing.assert_allclose(list(exact.value.values()), want, rtol=1e-6)
    run = measured(tilted, gait, 25.0, seed=1)
    found = identify(run)
    away = (np.array(list(found.value.values())) - want) / list(found.uncertainty.values())
    assert np.abs(away).max() < 3.5 and np.sqrt(np.mean(away**2)) > 0.05
    np.testing.assert_allclose(found.noise, NOISE, rtol=0.1)
    # The command, from a table.
    table = np.column_stack((run.time, run.pose, run.leg_angle))
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", comments="",
               header="time [s],x [m],y [m],yaw [rad],leg_1 [rad],leg_2 [rad]")  # fmt: skip
    shown = CliRunner().invoke(cli, ["fit", str(tmp_path / "run.csv"), "--json"])
    data = json.loads(shown.stdout)
    assert data["value"]["damping"] == pytest.approx(found.value["damping"], rel=1e-6)


def test_what_a_fit_refuses(other, tmp_path):
    run = measured(other, rr.RampIn(rr.gait("circular"), 3.0), 10.0)
    with pytest.raises(rr.ParameterError, match="known are"):
        identify(run, free=("colour",))
    with pytest.raises(rr.ParameterError, match="time must increase"):
        MeasuredRun(time=run.time[::-1], pose=run.pose, leg_angle=run.leg_angle)
    (tmp_path / "run.csv").write_text("time,x\n0,1\n")
    with pytest.raises(rr.OutputError, match="lacks the columns y, yaw"):
        MeasuredRun.from_csv(tmp_path / "run.csv")


@pytest.mark.slow
def test_a_goal_is_reached_on_another_robot_on_a_slope(model, tilted):
    sensor = Sensor(place=NOISE[0], yaw=NOISE[1], seed=3)
    found = reach(model, (0.15, -0.2, 1.0), truth=tilted, sensor=sensor)
    first = found.tries[0].trajectory
    assert np.hypot(*(first.position[-1] - (0.15, -0.2))) > 0.01  # without feedback it misses
    assert found.stopped is None and len(found.tries) <= 3
    assert np.hypot(*found.error[:2]) < 0.005 and abs(found.error[2]) < np.deg2rad(2)


@pytest.mark.slow
def test_a_goal_that_moves(model, other):
    sensor = Sensor(place=NOISE[0], yaw=NOISE[1], seed=1)
    found = reach(
        model, lambda t: (0.1 + 0.001 * t, 0.2 - 0.0005 * t, 0.5 + 0.002 * t), truth=other,
        sensor=sensor,
    )  # fmt: skip
    spent = sum(float(t.trajectory.time[-1]) for t in found.tries)
    assert found.stopped is None and len(found.tries) <= 4
    np.testing.assert_allclose(found.goal[:2], (0.1 + 0.001 * spent, 0.2 - 0.0005 * spent))
    assert np.hypot(*found.error[:2]) < 0.005 and abs(found.error[2]) < np.deg2rad(2)


@pytest.mark.slow
def test_a_wild_run_is_learnt_from(model):
    """Half the damping lets gaits of 0.5 rad run wild: the first plan ends half a metre away."""
    other = rr.RRRobotParameters(
        leg_mass=(0.0577, 0.0593), servo_mass=(0.0545, 0.0515), battery_mass=0.294,
        shell_radius=0.1218, damping=0.00505,
    )  # fmt: skip
    ground = rr.Plane(normal=(-0.01438, 0.03182, 1.0))
    truth = rr.FullModel(rr.Robot.from_parameters(other), ground=ground)
    goal = (0.0966, -0.1871, -3.0609)
    plan = rr.plan(model, goal)
    run = plan.execute(truth, method="momentum", sample_interval=0.1)
    assert np.hypot(*(run.position[-1] - goal[:2])) > 0.3
    noise = np.random.default_rng(0).normal(size=(len(run.time), 3)) * (NOISE[0], *NOISE)
    pose = np.column_stack((run.position, run.euler[:, 2])) + noise
    found = identify(
        MeasuredRun(time=run.time, pose=pose, leg_angle=run.leg_angle),
        free=("damping", "leg_mass", "servo_mass", "shell_radius", "slope"), noise=NOISE,
        trust={"damping": 0.5, "leg_mass": 0.1, "servo_mass": 0.1, "shell_radius": 0.05},
    )  # fmt: skip
    assert found.misfit == pytest.approx(1.0, abs=0.1)
    # The battery, which fixes the scale of masses and damping, is a little off.
    assert found.value["damping"] * 0.294 / rr.RRRobotParameters().battery_mass == pytest.approx(
        0.00505, rel=0.02
    )
    np.testing.assert_allclose(found.ground.normal_vector, ground.normal_vector, atol=2e-4)


@pytest.mark.parametrize("legs", [(np.pi / 2, np.pi / 2), (0.4, 2.2)])
def test_standing_on_a_slope(tilted, legs):
    """No acceleration at rest, at any heading, and the same rest as found by Newton's method."""
    for yaw in (0.0, 2.0, -9.0):
        euler = standing(tilted, np.array(legs), yaw)
        assert euler[2] == yaw
        pose = tilted.make_pose(euler, np.zeros(2))
        held = rr.StillLegs(legs)(0.0)
        assert np.abs(tilted.dynamics(pose, np.zeros(3), held).acceleration).max() < 1e-12
    shell = rr.Ellipsoid((OTHER.shell_radius,) * 3)
    robot = rr.Robot.from_urdf(rr.rrrobot_urdf(OTHER), shell=shell)
    same = rr.FullModel(robot, ground=tilted.ground, damping=OTHER.damping)
    found = standing(same, np.array(legs), 2.0)
    np.testing.assert_allclose(found, standing(tilted, np.array(legs), 2.0), atol=1e-9)


def test_the_follow_command(home, tmp_path):
    args = ["follow", "--path", "0,0 0.1,0", "--duration", "20", "--true", "leg_mass=1.05",
            "--noise", "0.001,pi/360", "--delay", "1", "--quiet"]  # fmt: skip
    files = ["--save", str(tmp_path / "f.json"), "--plot", str(tmp_path / "f.png")]
    result = CliRunner().invoke(cli, [*args, *files, "--json"])
    assert result.exit_code == 0, result.output
    data = json.loads(result.stdout)
    assert data["rms"] < 0.01 and data["stopped"] is None
    assert rr.read_gait(tmp_path / "f.json").n_legs == 2
    for bad in (["--true", "colour=2"], ["--path", "0,0 1,1", "--eight", "0.5"]):
        assert CliRunner().invoke(cli, ["follow", *bad]).exit_code == 2
