"""Simulating: sample times, bad arguments, Ctrl-C, and the pitch of 90 degrees."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rrrobot as rr
from rrrobot.integrate import sample_times
from tests.strategies import examples

LATERAL = rr.gait("lateral")


@pytest.fixture(scope="module")
def model() -> rr.FullModel:
    return rr.FullModel(rr.Robot.from_parameters())


@given(st.floats(0.01, 100), st.floats(1e-3, 10))
@examples(100)
def test_sample_times_have_both_ends_and_the_interval(duration, interval):
    times = sample_times(duration, interval)
    assert times[0] == 0.0
    assert times[-1] == duration
    steps = np.diff(times)
    assert np.all(steps > 0)
    np.testing.assert_allclose(steps[:-1], interval, rtol=1e-6)
    assert steps[-1] <= interval * (1 + 1e-6)


@pytest.mark.parametrize(
    ("duration", "interval", "expected"),
    [
        (1.0, 0.25, [0, 0.25, 0.5, 0.75, 1.0]),
        (1.0, 0.3, [0, 0.3, 0.6, 0.9, 1.0]),
        (0.3, 0.1, [0, 0.1, 0.2, 0.3]),
        (0.1, 1.0, [0, 0.1]),
        (0.1, 0.1, [0, 0.1]),
    ],
)
def test_sample_times_by_hand(duration, interval, expected):
    np.testing.assert_allclose(sample_times(duration, interval), expected, rtol=1e-15)


def test_thirty_seconds_are_3001_samples(model):
    assert sample_times(30.0, 0.01).size == 3001
    t = rr.simulate(model, LATERAL, duration=0.25, sample_interval=0.1)
    np.testing.assert_allclose(t.time, (0, 0.1, 0.2, 0.25), rtol=1e-15)
    assert len(t.state) == 4


BAD: list[tuple[dict[str, Any], type[Exception], str]] = [
    *[
        ({name: value}, rr.ParameterError, f"{name} is ")
        for name in ("duration", "sample_interval", "step", "atol")
        for value in (0, -1.0, np.nan, np.inf, "1", True)
    ],
    *[({"rtol": value}, rr.ParameterError, "rtol is ") for value in (0, -1, np.nan, "x")],
    ({"duration": 1e9, "sample_interval": 1e-3}, rr.ParameterError, "the limit is 5e7"),
    ({"duration": None}, rr.ParameterError, "duration is None"),
    ({"start": "fast"}, rr.ModelError, "start is 'fast': it must be 'impulsive', 'rest' or"),
    ({"start": ""}, rr.ModelError, "start is ''"),
    ({"start": (1, 2)}, rr.ParameterError, "start has shape (2,): it must hold 3 numbers (roll"),
    ({"start": (1, 2, np.nan)}, rr.ParameterError, "start is [1.0, 2.0, nan] rad/s"),
    ({"start": None}, rr.ParameterError, "start has shape ()"),
    ({"euler": (0, 0)}, rr.ParameterError, "euler has shape (2,)"),
    ({"euler": (0, np.inf, 0)}, rr.ParameterError, "euler is [0.0, inf, 0.0] rad"),
    ({"position": (0, 0, 0)}, rr.ParameterError, "position has shape (3,)"),
    ({"position": "here"}, rr.ParameterError, "position is 'here'"),
    ({"state": np.zeros(9)}, rr.ParameterError, "state is ndarray: it must be a State"),
    ({"step": 0.01, "rtol": 1e-9}, rr.ParameterError, "rtol would do nothing with step="),
    ({"method": "momentum", "rtol": 1e-9}, rr.ParameterError, "rtol would do nothing with method"),
    ({"method": "momentum", "atol": 1e-9}, rr.ParameterError, "atol would do nothing with method"),
    ({"method": "magic"}, rr.ParameterError, "method is 'magic'"),
    ({"gait": rr.gait}, rr.GaitError, "gait is function: it must be a Gait"),
    ({"gait": "lateral"}, rr.GaitError, "gait is str: it must be a Gait"),
    ({"gait": None}, rr.GaitError, "gait is NoneType"),
    ({"gait": rr.StillLegs((1, 2, 3))}, rr.GaitError, "3 leg joints, but the robot has 2"),
    ({"gait": rr.StillLegs((1,))}, rr.GaitError, "moves 1 leg joint, but"),
    ({"gait": rr.StillLegs(())}, rr.GaitError, "moves 0 leg joints"),
]


@pytest.mark.parametrize(("change", "error", "says"), BAD, ids=[says for _, _, says in BAD])
def test_bad_arguments(model, change, error, says):
    options = {"gait": LATERAL, "duration": 0.1} | change
    with pytest.raises(error) as caught:
        rr.simulate(model, options.pop("gait"), **options)
    assert says in str(caught.value)
    assert isinstance(caught.value, (rr.RRRobotError, ValueError))


def test_ctrl_c_keeps_what_was_computed(model):
    def stop_at_half_a_second(time: float, _: float) -> None:
        if time > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(rr.SimulationInterrupted, match="interrupted") as caught:
        rr.simulate(model, LATERAL, duration=10.0, progress=stop_at_half_a_second)
    error = caught.value
    assert isinstance(error, KeyboardInterrupt)
    assert isinstance(error, rr.SimulationError)
    assert 0.5 < error.time < 0.6
    partial = error.trajectory
    assert partial is not None
    assert error.time - 0.01 < partial.time[-1] <= error.time
    whole = rr.simulate(model, LATERAL, duration=10.0)
    n = len(partial)
    np.testing.assert_array_equal(partial.time, whole.time[:n])
    np.testing.assert_allclose(partial.euler, whole.euler[:n], atol=1e-12)
    assert f"{n} samples" in str(error)
    # What was kept is enough to go on.
    gait = rr.StillLegs((1.5, 1.5))
    rr.simulate(model, gait, duration=0.1, state=error.state)


def test_ctrl_c_at_once(model):
    def stop(*_: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(rr.SimulationInterrupted) as caught:
        rr.simulate(model, LATERAL, duration=1.0, progress=stop)
    assert caught.value.trajectory is not None
    assert len(caught.value.trajectory) >= 1


def test_progress_sees_the_time_grow_to_the_end(model):
    times: list[float] = []
    totals: list[float] = []
    rr.simulate(model, LATERAL, duration=0.7, sample_interval=0.1,
                progress=lambda now, all_: (times.append(now), totals.append(all_)))  # fmt: skip
    assert set(totals) == {0.7}
    assert np.all(np.diff(times) > 0)
    assert times[-1] == pytest.approx(0.7, abs=1e-12)


OVER = {"start": (0.0, 20.0, 0.0), "duration": 2.0}
LEGS = rr.StillLegs((np.pi / 2, np.pi / 2))


def test_euler_damping_stops_at_the_pole_and_says_so(model):
    with pytest.raises(rr.SimulationError) as caught:
        rr.simulate(model, LEGS, **OVER)
    error = caught.value
    assert not isinstance(error, KeyboardInterrupt)
    text = str(error)
    assert "the pitch reached +-90 degrees" in text
    assert f"at t = {error.time:.6g} s" in text
    assert "roll, pitch, yaw = " in text
    assert "BodyRateDamping" in text
    assert 0 < error.time < 1
    partial = error.trajectory
    assert partial is not None
    assert f"{len(partial)} samples" in text
    assert partial.time[-1] <= error.time
    assert partial.time[-1] > error.time - 0.011
    assert abs(partial.euler[-1, 1]) > 1.2
    for name in ("euler", "contact_force", "energy", "configuration", "state"):
        assert np.all(np.isfinite(getattr(partial, name))), name


@pytest.mark.parametrize("damping", [None, rr.BodyRateDamping(0.001, 0.001, 0.001)], ids=repr)
def test_other_damping_passes_over_the_pole(model, damping):
    t = rr.simulate(rr.FullModel(model.robot, damping=damping), LEGS, **OVER)
    assert t.time[-1] == 2.0
    assert t.euler[:, 1].max() > 2 * np.pi
    assert np.abs(np.diff(t.euler, axis=0)).max() < 0.5
    for name in ("euler", "contact_force", "energy", "configuration", "state"):
        assert np.all(np.isfinite(getattr(t, name))), name
    assert t.slip.max() < 1e-12
    assert np.abs(t.height_error).max() < 1e-12
    if damping is None:
        np.testing.assert_allclose(t.energy, t.energy[0], rtol=1e-7)
    else:
        assert np.all(np.diff(t.energy) < 0)


def test_a_gait_that_breaks_mid_run(model):
    def swing(t):
        value = np.nan if t > 20 else 1.5
        return np.full(2, value), np.zeros(2), np.zeros(2)

    broken = rr.CallableGait(swing, n_legs=2, name="swing")
    start = rr.simulate(model, broken, duration=0.1)
    assert np.all(np.isfinite(start.energy))
    with pytest.raises(rr.SimulationError, match=r"angle of gait 'swing' at t = 20\.") as caught:
        rr.simulate(model, broken, duration=21.0, sample_interval=0.5)
    assert 19 < caught.value.trajectory.time[-1] <= caught.value.time <= 20
