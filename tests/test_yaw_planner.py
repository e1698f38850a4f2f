"""The yaw planner: from any configuration at rest to any other."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.drive.moves import LegMoves, Loops, Straight
from rrrobot.reduction.yaw import net_yaw
from rrrobot.steering.yaw_planner import plan_yaw
from tests.random_robot import random_robot
from tests.some import some

LIMITS = (0.2, 2.9)


@pytest.fixture(scope="module")
def model():
    return rr.YawModel(rr.Robot.from_parameters())


def arrival(model, plan, **options):
    # Samples fine enough to count the turns of the body.
    interval = plan.duration / 40
    t = rr.simulate(model, plan.gait, plan.duration, interval, euler=plan.euler, **options)
    return np.append(t.euler[-1, 2], t.leg_angle[-1]) - plan.goal


@pytest.mark.slow
def test_200_random_pairs(model):
    rng = np.random.default_rng(0)
    worst = 0.0
    for _ in range(200):
        start, goal = rng.uniform((-np.pi, 0.3, 0.3), (np.pi, 2.8, 2.8), (2, 3))
        plan = plan_yaw(model, start, goal, angle_range=LIMITS, max_rate=15.0, wrap=True)
        assert np.isclose(np.cos(plan.goal[0] - goal[0]), 1, atol=1e-12)
        # Off the samples, too, the legs stay inside.
        angles = plan.gait(np.linspace(0, plan.duration, 400)).angle
        assert angles.min() >= LIMITS[0] - 1e-12 and angles.max() <= LIMITS[1] + 1e-12
        away = arrival(model, plan, method="momentum", step=0.012)
        worst = max(worst, np.abs(away).max())
    assert worst < 1e-6


@pytest.mark.parametrize("seed", some(range(3), {"1"}))
def test_exact_yaw_with_whole_turns_by_the_reference_dynamics(model, seed):
    rng = np.random.default_rng(seed)
    start, goal = rng.uniform((-1, 0.5, 0.5), (1, 2.5, 2.5), (2, 3))
    goal[0] = start[0] + 0.4 * (-1) ** seed
    plan = plan_yaw(model, start, goal, angle_range=LIMITS, max_rate=4.0)
    assert plan.goal == pytest.approx(goal)
    assert np.abs(arrival(model, plan)).max() < 1e-6
    assert net_yaw(model, plan.gait) == pytest.approx(goal[0] - start[0], abs=1e-10)
    rates = plan.gait(np.linspace(0, plan.duration, 4000)).rate
    assert np.abs(rates).max() <= 4.0 + 1e-9
    assert np.abs(rates[[0, -1]]).max() < 1e-30


def test_second_gait_then_first_gait(model):
    plan = plan_yaw(model, (0, 1.2, 1.6), (0.3, 1.8, 1.0), angle_range=LIMITS)
    assert [type(move) for move in plan.gait.moves] == [Loops, Straight, Straight]
    assert plan.cycles * plan.cycle_yaw + plan.straight_yaw == pytest.approx(0.3, abs=1e-12)
    free = plan_yaw(model, (0, 1.2, 1.6), (0.3, 1.8, 1.0))
    assert free.cycles >= 1


@pytest.mark.slow
def test_motor_torques_track_the_plan(model):
    plan = plan_yaw(model, (0, 1.2, 1.6), (0.3, 1.8, 1.0), angle_range=LIMITS)
    driven = rr.LegTorques(plan.torque, angle=plan.start[1:])
    t = rr.simulate(model, driven, plan.duration, 0.5)
    assert abs(t.euler[-1, 2] - 0.3) < 1e-6
    assert np.abs(t.leg_angle[-1] - plan.goal[1:]).max() < 1e-6
    same = rr.simulate(model, plan.gait, plan.duration, 0.5)
    assert np.abs(plan.torque(same.time) - same.leg_torque).max() < 1e-12
    assert np.abs(same.leg_torque).max() > 1e-3


def test_any_robot_with_more_legs():
    robot = random_robot(8, 4, shell_center=(0.0, 0.0, 0.0))
    goal = (0.01, 0.5, -0.2, 0.3, 0.4)
    plan = plan_yaw(robot, np.zeros(5), goal, pair=(0, 2), max_rate=5.0)
    assert np.abs(arrival(rr.YawModel(robot), plan)).max() < 1e-6


@pytest.mark.filterwarnings("ignore::rrrobot.errors.GroundClearanceWarning")
def test_a_robot_whose_root_is_not_its_centre():
    robot = random_robot(8, 4)
    assert np.abs(robot.shell_placement.translation).max() > 1e-3
    plan = plan_yaw(robot, np.zeros(5), (0.01, 0.5, -0.2, 0.3, 0.4), pair=(0, 2), max_rate=5.0)
    assert np.abs(arrival(rr.YawModel(robot), plan)).max() < 1e-6


def test_nothing_to_do(model):
    plan = plan_yaw(model, (0.2, 1, 1), (0.2, 1, 1))
    assert plan.cycles == 0
    assert np.abs(arrival(model, plan)).max() < 1e-12


def test_infeasible_limits_are_refused(model):
    with pytest.raises(rr.GaitError, match="start: leg 2 is at 3 rad, outside of its limits"):
        plan_yaw(model, (0, 1, 3), (0, 1, 1), angle_range=LIMITS)
    with pytest.raises(rr.GaitError, match="goal: leg 1"):
        plan_yaw(model, (0, 1, 1), (0, 0, 1), angle_range=LIMITS)
    with pytest.raises(rr.GaitError, match=r"max_cycles = 1000.*Widen the limits"):
        plan_yaw(model, (0, 1, 1), (1, 1, 1), angle_range=(0.99, 1.01))
    with pytest.raises(rr.ParameterError, match="low below high"):
        plan_yaw(model, (0, 1, 1), (1, 1, 1), angle_range=(2, 1))
    with pytest.raises(rr.ParameterError, match="max_cycles"):
        plan_yaw(model, (0, 1, 1), (1, 1, 1), max_cycles=0)
    with pytest.raises(rr.ParameterError, match="start has shape"):
        plan_yaw(model, (0, 1), (1, 1, 1))
    with pytest.raises(rr.ModelError, match="1 leg"):
        plan_yaw(random_robot(1, 1, shell_center=(0, 0, 0)), (0, 0), (1, 0))


def test_moves_must_join():
    a = Straight(start=np.zeros(2), end=np.ones(2), duration=1.0)
    with pytest.raises(rr.GaitError, match="must join"):
        LegMoves([a, a])
    with pytest.raises(rr.GaitError, match="empty"):
        LegMoves([])
