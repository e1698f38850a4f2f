"""Torque-driven legs: constant, by time, by feedback; mistakes before and during a run."""

import numpy as np
import pytest

import rrrobot as rr


@pytest.fixture(scope="module")
def model() -> rr.FullModel:
    return rr.FullModel(rr.Robot.from_parameters())


def state(time: float = 0.5) -> rr.drive.MotionState:
    legs = np.array((1.0, 2.0)), np.array((0.3, -0.3))
    return rr.drive.MotionState(time, np.eye(3), np.zeros(3), np.zeros(2), *legs)


def test_three_kinds():
    constant = rr.LegTorques(0.1, angle=(1, 2))
    assert constant.torque(state()).tolist() == [0.1, 0.1]
    by_time = rr.LegTorques(lambda t: (t, -t), angle=(1, 2))
    assert by_time.torque(state(0.25)).tolist() == [0.25, -0.25]
    feedback = rr.LegTorques(lambda s: s.leg_angle + s.leg_rate, angle=(1, 2), feedback=True)
    assert feedback.torque(state()).tolist() == pytest.approx([1.3, 1.7])
    assert (constant.n_legs, by_time.n_legs, feedback.n_legs) == (2, 2, 2)
    assert rr.LegTorques((1, 2, 3), angle=(0, 0, 0), rate=1).rate.tolist() == [1, 1, 1]


def test_feedback_sees_the_state_of_the_run(model):
    seen = []

    def law(s: rr.drive.MotionState) -> np.ndarray:
        seen.append(s)
        return -0.2 * (s.leg_angle - 1.5) - 0.02 * s.leg_rate

    drive = rr.LegTorques(law, angle=(1.4, 1.7), rate=(0.1, 0.0), feedback=True)
    t = rr.simulate(model, drive, duration=0.2, position=(0.3, -0.2))
    first = seen[0]
    assert first.time == 0.0
    np.testing.assert_array_equal(first.leg_angle, (1.4, 1.7))
    np.testing.assert_array_equal(first.leg_rate, (0.1, 0.0))
    np.testing.assert_array_equal(first.position, (0.3, -0.2))
    np.testing.assert_allclose(first.R_world_body, np.eye(3), atol=1e-15)
    expected = -0.2 * (t.leg_angle - 1.5) - 0.02 * t.leg_rate
    np.testing.assert_allclose(t.leg_torque, expected, atol=1e-14)
    assert np.ptp(t.leg_angle) > 0


def test_constant_torque_in_no_gravity_turns_the_leg(model):
    robot = rr.Robot.from_parameters(rr.RRRobotParameters(gravity=0.0))
    t = rr.simulate(rr.FullModel(robot, damping=None), rr.LegTorques((0.01, 0), angle=(1, 1)), 0.1)
    assert t.leg_rate[-1, 0] > 0.01
    np.testing.assert_array_equal(t.leg_torque, np.tile((0.01, 0.0), (len(t), 1)))


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"torque": (1, 2, 3)}, "torque has shape (3,): it must hold 2 numbers"),
        ({"torque": (1, np.inf)}, "torque is [1.0, inf] N m"),
        ({"torque": "much"}, "torque is 'much'"),
        ({"angle": (1, np.nan)}, "angle is [1.0, nan] rad"),
        ({"angle": [[1, 2]]}, "angle has shape (1, 2)"),
        ({"angle": "up"}, "angle is 'up'"),
        ({"rate": (1, 2, 3)}, "rate has shape (3,)"),
        ({"feedback": True}, "feedback=True needs a function"),
    ],
)
def test_bad_arguments(options, says):
    with pytest.raises(rr.GaitError) as caught:
        rr.LegTorques(**({"torque": 0.0, "angle": (1, 1)} | options))
    assert says in str(caught.value)


def test_wrong_number_of_legs(model):
    with pytest.raises(rr.GaitError, match="3 leg joints, but the robot has 2: leg_1, leg_2"):
        rr.simulate(model, rr.LegTorques(0.0, angle=(1, 1, 1)), duration=1)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("feedback", [False, True])
def test_a_torque_that_is_not_finite_mid_run(model, feedback, bad):
    def torque(arg):
        time = arg.time if feedback else arg
        return (0.001, bad if time > 0.3 else 0.0)

    drive = rr.LegTorques(torque, angle=(1.5, 1.5), feedback=feedback, name="broken")
    with pytest.raises(rr.SimulationError, match=r"'broken' at t = 0\.3.*finite") as caught:
        rr.simulate(model, drive, duration=1.0)
    error = caught.value
    assert isinstance(error, RuntimeError)
    assert 0.2 < error.time <= 0.3 + 1e-9
    assert f"{error.time:.6g}" in str(error)
    assert error.state.vector.shape == (13,)
    assert error.trajectory is not None
    assert error.trajectory.time[-1] <= error.time
    assert error.trajectory.time[-1] > error.time - 0.011
    assert len(error.trajectory) > 20
    assert np.all(np.isfinite(error.trajectory.energy))


def test_a_torque_of_the_wrong_size_mid_run(model):
    drive = rr.LegTorques(lambda t: (0, 0) if t < 0.2 else 0, angle=(1.5, 1.5))
    with pytest.raises(rr.SimulationError, match=r"shape \(\): it must hold 2 numbers") as caught:
        rr.simulate(model, drive, duration=1.0)
    assert len(caught.value.trajectory) > 10


def test_a_torque_wrong_from_the_start(model):
    with pytest.raises(rr.RRRobotError, match="at t = 0 s"):
        rr.simulate(model, rr.LegTorques(lambda t: (np.nan, 0), angle=(1.5, 1.5)), duration=1.0)


def test_an_error_in_the_users_own_function_passes(model):
    def law(t):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        rr.simulate(model, rr.LegTorques(law, angle=(1.5, 1.5)), duration=1.0)


def test_to_dict():
    def push(t):
        return 0, 0

    data = rr.LegTorques(push, angle=(1, 2)).to_dict()
    assert (data["type"], data["name"], data["constant"]) == ("torques", "push", None)
    assert rr.LegTorques((1, 2), angle=(1, 2)).to_dict()["constant"] == [1.0, 2.0]
