"""Flow and State: a run that is cut and continued, events, refusals, runs that take long."""

import numpy as np
import pytest

import rrrobot as rr

ROBOT = rr.Robot.from_parameters()
GAIT = rr.gait("circular")
MODELS = {
    kind.name: kind(ROBOT)
    for kind in (rr.FullModel, rr.PivotingModel, rr.RollModel, rr.PitchModel, rr.YawModel,
                 rr.models.DecoupledModels)
}  # fmt: skip
FIELDS = ("time", "euler", "position", "contact_force", "leg_torque", "energy", "state")
SPRING = rr.LegTorques(
    lambda s: -0.2 * (s.leg_angle - 1.5) - 0.02 * s.leg_rate, angle=(1.2, 1.8), feedback=True
)


def halves(model, drive, cut, duration, **options):
    whole = rr.simulate(model, drive, duration, 0.01, **options)
    first = rr.simulate(model, drive, cut, 0.01, **options)
    second = rr.simulate(model, drive, duration - cut, 0.01, state=first.final_state, **options)
    return whole, second, len(first) - 1


@pytest.mark.parametrize("name", MODELS)
def test_continued_bit_for_bit_at_fixed_steps(name):
    whole, second, n = halves(MODELS[name], GAIT, 0.8, 1.6, step=0.02)
    for part in FIELDS:
        np.testing.assert_array_equal(getattr(second, part), getattr(whole, part)[n:], part)


def test_the_momentum_form_is_continued_bit_for_bit():
    whole, second, n = halves(MODELS["full"], GAIT, 0.8, 1.6, method="momentum")
    for part in FIELDS:
        np.testing.assert_array_equal(getattr(second, part), getattr(whole, part)[n:], part)


@pytest.mark.parametrize("name", MODELS)
def test_continued_at_any_time_with_adaptive_steps(name):
    whole, second, _ = halves(MODELS[name], GAIT, 0.737, 1.5)
    # The cut adds a sample to the first half, and shifts the second's.
    again = rr.simulate(MODELS[name], GAIT, 1.5, 0.01)
    np.testing.assert_array_equal(again.euler, whole.euler)
    assert second.time[0] == 0.737 and second.time[-1] == 1.5
    assert np.abs(second.euler[-1] - whole.euler[-1]).max() < 1e-10
    assert np.abs(second.position[-1] - whole.position[-1]).max() < 1e-10


def test_torque_driven_runs_are_continued():
    whole, second, n = halves(MODELS["full"], SPRING, 0.4, 0.8, step=0.01)
    np.testing.assert_array_equal(second.state, whole.state[n:])


def test_whole_turns_go_on():
    model = rr.FullModel(ROBOT, damping=None)
    still = rr.StillLegs((np.pi / 2, np.pi / 2))
    first = rr.simulate(model, still, 1.0, start=(0.0, 0.0, 15.0))
    assert first.euler[-1, 2] > 2 * np.pi
    second = rr.simulate(model, still, 0.5, state=first.final_state)
    assert abs(second.euler[0, 2] - first.euler[-1, 2]) < 1e-12
    assert second.euler[-1, 2] > first.euler[-1, 2] + 6


def test_states_of_another_kind_are_refused():
    state = rr.simulate(MODELS["full"], GAIT, 0.1).final_state
    with pytest.raises(rr.ModelError, match="type is 'full', and this model's is 'yaw'"):
        rr.simulate(MODELS["yaw"], GAIT, 0.1, state=state)
    other = rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=0.05))
    with pytest.raises(rr.ModelError, match="continue it with the same robot"):
        rr.simulate(rr.FullModel(other), GAIT, 0.1, state=state)
    with pytest.raises(rr.ModelError, match="ground"):
        slope = rr.Plane((0.1, 0.0, 1.0))
        rr.simulate(rr.FullModel(ROBOT, ground=slope), GAIT, 0.1, state=state)
    with pytest.raises(rr.ModelError, match="the legs of the state were prescribed"):
        rr.simulate(MODELS["full"], SPRING, 0.1, state=state)
    with pytest.raises(rr.ParameterError, match="euler would do nothing with state="):
        rr.simulate(MODELS["full"], GAIT, 0.1, state=state, euler=(0.1, 0, 0))
    with pytest.raises(rr.ParameterError, match="must be a State"):
        rr.simulate(MODELS["full"], GAIT, 0.1, state=state.vector)
    flow = rr.simulation.Flow(MODELS["full"], GAIT)
    with pytest.raises(rr.ParameterError, match=r"t0 is 0\.0 s, and the state is at 0.1 s"):
        flow.evolve(0.0, 1.0, state)
    assert flow.evolve(0.0, 0.1, state.at(0.0)).state.time == 0.1


def test_a_state_from_an_array_goes_on():
    whole = rr.simulate(MODELS["full"], GAIT, 1.0, step=0.01)
    state = rr.simulation.State.from_array(MODELS["full"], whole.state[50], time=0.5)
    second = rr.simulate(MODELS["full"], GAIT, 0.5, state=state, step=0.01)
    np.testing.assert_array_equal(second.state, whole.state[50:])


def test_events_are_located():
    """Roll through zero, where a small pendulum passes its lowest point; against a fine run."""
    model = rr.RollModel(ROBOT, damping=None)
    still = rr.StillLegs((np.pi / 2, np.pi / 2))
    options = {"euler": (-0.1, 0, 0), "start": "rest"}
    up = rr.simulation.Event(lambda at: at.euler[0], direction=1, name="up")
    t = rr.simulate(model, still, 3.0, events=[up], **options)
    times = [hit.time for hit in t.events]
    # A conservative swing from rest: zeros at T/4, 5 T/4, ... and each at zero to the tolerance.
    assert len(times) == 3
    assert times[1] / times[0] == pytest.approx(5.0, abs=1e-8)
    assert all(abs(hit.state[0]) < 1e-10 for hit in t.events)
    end = rr.simulation.Event(lambda at: at.euler[0], terminal=True, direction=1, name="up")
    short = rr.simulate(model, still, 3.0, events=[end], **options)
    assert short.time[-1] == short.final_state.time == times[0]
    assert abs(short.euler[-1, 0]) < 1e-10


def test_lift_off_is_located():
    fast = rr.SinusoidalGait(offset=np.pi / 2, amplitude=1.0, angular_frequency=25.0)
    model = MODELS["roll"]
    full = rr.FullModel(ROBOT, damping=None)
    t = rr.simulate(full, fast, 2.0, events=[rr.simulation.lift_off()])
    assert t.events[0].name == "lift-off"
    assert abs(t.normal_force[-1]) < 1e-8
    assert np.all(t.normal_force[:-1] > 0)
    with pytest.raises(rr.ModelError, match="pivoted"):
        rr.simulate(MODELS["pivoting"], GAIT, 0.1, events=[rr.simulation.lift_off()])
    fast_form = rr.simulate(full, fast, 2.0, method="momentum", events=[rr.simulation.lift_off()])
    assert fast_form.time[-1] == pytest.approx(t.time[-1], abs=1e-9)
    assert abs(fast_form.normal_force[-1]) < 1e-8
    np.testing.assert_allclose(fast_form.state[-1], t.state[-1], atol=1e-9)
    assert len(fast_form) == len(t) and model.name == "roll"


def test_both_forms_find_the_same_events():
    """Between samples 0.1 s apart, on steps of 0.02 s."""
    level = rr.simulation.Event(lambda at: at.euler[0] + 0.01, name="level")
    sink = rr.simulation.Event(lambda at: at.normal_force - 5.0, direction=-1, name="light")
    runs = [
        rr.simulate(MODELS["full"], GAIT, 3.0, 0.1, method=method, events=[level, sink])
        for method in ("kkt", "momentum")
    ]
    first, second = ([(hit.name, hit.time) for hit in t.events] for t in runs)
    assert [name for name, _ in first] == [name for name, _ in second]
    assert len(first) > 6 and {"level", "light"} == {name for name, _ in first}
    np.testing.assert_allclose([t for _, t in first], [t for _, t in second], atol=1e-8)
    np.testing.assert_array_equal(runs[1].state, rr.simulate(
        MODELS["full"], GAIT, 3.0, 0.1, method="momentum").state)  # fmt: skip


def test_long_runs_say_why():
    class Stop(Exception):
        pass

    def stop(*_):
        raise Stop

    quick = rr.SinusoidalGait(offset=1.5, amplitude=0.1, angular_frequency=1e4)
    with pytest.warns(rr.SlowWarning, match="a twelfth of the gait's period"), pytest.raises(Stop):
        rr.simulate(MODELS["full"], quick, 30.0, progress=stop)

    count = []

    def stop_later(*_):
        count.append(1)
        if len(count) > 501:
            raise Stop

    stiff = rr.LegTorques(lambda s: -1e6 * (s.leg_angle - 1.5) - 1e3 * s.leg_rate,
                          angle=(1.4, 1.6), feedback=True)  # fmt: skip
    with pytest.warns(rr.SlowWarning, match="stiff: its shortest"), pytest.raises(Stop):
        rr.simulate(MODELS["full"], stiff, 30.0, progress=stop_later)
