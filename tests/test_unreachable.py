"""What cannot be done: the nearest that can, and why; legs that stop smoothly."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.drive.schedule import Schedule, stretch
from rrrobot.steering import Disc, Sensor, Track, follow, reach
from rrrobot.steering.obstacles import free_distance


@pytest.fixture(scope="module")
def model(home):
    return rr.FullModel(rr.Robot.from_parameters())


def test_too_little_time_leads_part_of_the_way(model):
    goal = (0.5, 0.5, 0.0)
    with pytest.raises(rr.PlanError, match=r"the legs have 15 s, and no way there takes less"):
        rr.plan(model, goal, longest=15.0)
    with pytest.raises(rr.PlanError, match=r"nearest that was found ends at") as caught:
        rr.plan(model, goal, longest=30.0)
    nearest = caught.value.nearest
    assert nearest.gait.duration <= 30.0
    end = nearest.execute(method="momentum", sample_interval=1.0).position[-1]
    np.testing.assert_allclose(end, nearest.predicted[:2], atol=1e-5)
    assert np.hypot(*(end - goal[:2])) < 0.5 * np.hypot(*goal[:2])
    with pytest.raises(rr.PlanError, match="nor a way part of the distance") as caught:
        rr.plan(model, goal, longest=2.0)
    assert caught.value.nearest is None
    with pytest.raises(rr.ParameterError, match="longest is 0"):
        rr.plan(model, goal, longest=0)


@pytest.mark.slow
def test_a_goal_within_an_obstacle_is_approached(model):
    rock = Disc((0.3, 0.0), 0.05)
    with pytest.raises(rr.PlanError, match=r"is -0.05 m from an obstacle") as caught:
        rr.plan(model, (0.3, 0.0, 0.0), obstacles=[rock], margin=0.1)
    nearest = caught.value.nearest
    t = nearest.execute(method="momentum", sample_interval=np.pi / 32)
    means = np.column_stack([np.convolve(c, np.full(8, 1 / 8), "valid") for c in t.position.T])
    away = free_distance([rock], means)
    assert away.min() >= 0.1 and away[-1] < 0.16


@pytest.mark.slow
def test_a_goal_behind_a_closed_wall_is_approached(model):
    angles = np.arange(16) * np.pi / 8
    ring = [Disc((0.3 + 0.3 * np.cos(a), 0.3 * np.sin(a)), 0.06) for a in angles]
    with pytest.raises(rr.PlanError, match=r"keeps 0.1 m from the obstacles") as caught:
        rr.plan(model, (0.3, 0.0, 0.0), start=(1.0, 0, 0), obstacles=ring, margin=0.1, longest=90)
    # The wall's margin ends 0.46 m from the goal.
    assert 0.46 < np.hypot(*(caught.value.nearest.predicted[:2] - (0.3, 0.0))) < 0.6


@pytest.mark.slow
@pytest.mark.parametrize("limit", ["max_power", "max_leg_rate"])
def test_gaits_are_chosen_that_keep_the_limits(model, limit):
    goal = (0.1, 0.15, 0.4)
    asked = rr.plan(model, goal).demands()
    now = {"friction": asked.friction, "max_power": asked.power, "max_leg_rate": asked.leg_rate}
    most = 0.8 * now[limit]
    how = (
        {"max_power": most} if limit == "max_power" else {"limits": rr.GaitLimits(**{limit: most})}
    )
    p = rr.plan(model, goal, **how)
    again = p.demands()
    kept = {"friction": again.friction, "max_power": again.power, "max_leg_rate": again.leg_rate}
    assert kept[limit] <= most and np.hypot(*p.error[:2]) < 1e-3


def test_limits_that_no_gait_keeps(model):
    with pytest.raises(rr.PlanError, match="no gait of the robot keeps the limits"):
        rr.plan(model, (0.2, 0.1, 1.0), limits=rr.GaitLimits(max_torque=0.02))
    with pytest.raises(rr.ParameterError, match="max_power is -1"):
        rr.plan(model, (0.2, 0.1, 1.0), max_power=-1)


@pytest.mark.parametrize(
    ("robot", "message"),
    [
        (rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=1e-9)), "no gait .* travels"),
        (rr.Robot.from_urdf(rr.robot.legged_urdf(1), shell=rr.Sphere(0.3)), "3 leg joint"),
    ],
)  # fmt: skip
def test_robots_for_which_no_gait_travels(robot, message):
    model = rr.FullModel(robot, damping=0.01)
    for work in (
        lambda: rr.plan(model, (0.1, 0.0, 0.0), store=False),
        lambda: follow(model, Track([(0, 0), (1, 0)]), 10.0, store=False),
        lambda: reach(model, (0.1, 0.0, 0.0), store=False),
    ):
        with pytest.raises(rr.ModelError, match=message):
            work()


@pytest.mark.parametrize("fault", ["fails_after", "jumps_after"])
def test_a_measurement_that_is_lost_on_the_way_to_a_goal(model, fault):
    goal = (0.25, 0.1, 0.5)
    found = reach(model, goal, sensor=Sensor(place=1e-3, yaw=0.01, **{fault: 8.0}))
    assert "missing or jumps at 8 s of plan 1" in found.stopped and len(found.tries) == 1
    t = found.tries[0].trajectory
    # Two blends after the fault the legs rest, and then the robot: not at the goal.
    late = t.time > 8.0 + 2 * found.tries[0].plan.gait.blend
    assert not t.leg_rate[late].any() and np.abs(t.euler_rates[-1]).max() < 1e-3
    assert np.hypot(*found.error[:2]) > 0.05
    np.testing.assert_allclose(found.end[:2], t.position[-1])


def test_a_schedule_is_halted_smoothly():
    parts = [
        stretch(5.0, offset=(0.7, 0.9), amplitude=(0.3, 0.4), phase=(0.2, 2.0)),
        stretch(4.0, offset=(1.7, 2.9), amplitude=(0.3, 0.4), phase=(0.2, -2.0)),
    ]
    gait = Schedule(parts, angular_frequency=8.0, rest=(1.5, 1.2), blend=2.0)
    for time in (0.0, 1.0, 3.7, 5.5, 8.0, 10.0):
        short = gait.halted(time)
        assert short.duration <= time + 4.0 and not short(short.duration).rate.any()
        before = np.linspace(0, time, 50)
        np.testing.assert_allclose(short(before).angle, gait(before).angle, atol=1e-14)
        for edge in (time, short.duration - 2.0, short.duration):
            left, right = short(edge - 1e-9), short(edge + 1e-9)
            np.testing.assert_allclose(left.acceleration, right.acceleration, atol=1e-6)
    assert gait.halted(9.5) is gait
