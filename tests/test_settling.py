"""A motion that has not settled is said to: how long it takes, the warnings, what is printed."""

import json
import math
import warnings
from types import SimpleNamespace

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.cli.report import summary, table
from rrrobot.models.recombined import DecoupledModels
from rrrobot.orbits.settling import settling_time
from rrrobot.simulation.plots import plot
from rrrobot.simulation.steady import steady_state
from rrrobot.studies.optimisation.run import prepare
from rrrobot.studies.optimisation.space import Space

ROBOT = rr.Robot.from_parameters()
UP = np.full(2, np.pi / 2)
SLOW = rr.FullModel(ROBOT, damping=rr.EulerRateDamping(1e-3, 1e-3, 1e-3))
CIRCULAR = rr.gait("circular")
GRID = {"offset": [1.0, 1.5], "phase_difference": [1.0, 2.0]}


def test_settling_time_of_a_pendulum():
    # The logarithmic decrement of a simulated oscillation about rest.
    model = rr.PitchModel(ROBOT, damping=0.01)
    legs = rr.StillLegs(UP)
    run = rr.simulate(model, legs, 10.0, 0.002, euler=(0, 1e-4, 0), start="rest", method="momentum")
    angle = run.euler[:, 1]
    peaks = np.flatnonzero((angle[1:-1] > angle[:-2]) & (angle[1:-1] > angle[2:])) + 1
    rate = -np.polyfit(run.time[peaks], np.log(angle[peaks]), 1)[0]
    assert settling_time(model, [UP], 0.01) == pytest.approx(math.log(100) / rate, rel=2e-4)


def test_settling_time_is_the_slowest_of_all_postures_and_parts():
    full = rr.FullModel(ROBOT)
    slanted = np.full(2, np.pi / 4)
    each = [settling_time(full, [posture], 0.01) for posture in (UP, slanted)]
    assert settling_time(full, [UP, slanted], 0.01) == max(each) > min(each)
    apart = DecoupledModels(ROBOT)
    alone = [settling_time(part, [UP], 0.01) for part in apart.models]
    assert settling_time(apart, [UP], 0.01) == max(alone)
    # The slower the decay the longer, by linearity of the rate in a small damping.
    assert settling_time(SLOW, [UP], 0.01) == pytest.approx(10 * each[0], rel=0.02)


@pytest.mark.parametrize(
    "model",
    [rr.FullModel(ROBOT, damping=None), rr.YawModel(ROBOT)],
    ids=["undamped", "free yaw"],
)
def test_settling_time_is_none_where_nothing_decays(model):
    assert settling_time(model, [UP], 0.01) == 0.0


def test_a_sweep_simulates_until_the_slowest_mode_is_gone():
    slow = rr.sweep(SLOW, **GRID)
    orbits = rr.sweep(SLOW, **GRID, settle="orbit")
    assert slow.attrs["cycles"] > 150
    assert np.abs(slow.speed / orbits.speed - 1).max() < 2e-3
    assert slow.variation.max() < 0.01
    # RRRobot at the paper's frequency keeps the paper's number.
    assert rr.sweep(rr.FullModel(ROBOT), **GRID).attrs["cycles"] == 38
    faster = rr.sweep(rr.FullModel(ROBOT), **GRID, angular_frequency=14.0)
    assert faster.attrs["cycles"] > 38


def test_a_sweep_over_robots_waits_for_the_slowest():
    gaits = GRID | {"amplitude": 0.1}
    each = [
        rr.sweep(SLOW, **gaits, parameters={"leg_mass": [mass]}).attrs["cycles"]
        for mass in (0.04, 0.06)
    ]
    both = rr.sweep(SLOW, **gaits, parameters={"leg_mass": [0.04, 0.06]})
    assert both.attrs["cycles"] == max(each) > min(each)


def test_a_sweep_that_has_not_settled_warns():
    with pytest.warns(rr.UnsettledWarning, match=r"4 of 4 gaits .*cycles=") as told:
        found = rr.sweep(SLOW, **GRID, cycles=38)
    assert found.variation.min() > 0.05
    assert len(told) == 1
    with pytest.warns(rr.UnsettledWarning, match="4 of 4"):
        rr.sweep(rr.FullModel(ROBOT, damping=None), **GRID)


def test_a_sweep_of_orbits_leaves_the_word_to_the_status():
    # Legs in phase near the pitch's resonance: none that holds, and residuals far above 5 %.
    gaits = {"offset": np.pi / 2, "phase_difference": 0.0, "amplitude": [0.9, 1.0]}
    found = rr.sweep(rr.FullModel(ROBOT), **gaits, angular_frequency=5.0, settle="orbit")
    assert np.all(found.status == 7) and found.variation.min() > 0.05


def test_a_run_that_has_not_settled_warns_and_says_so_wherever_it_is_shown():
    run = rr.simulate(SLOW, CIRCULAR, 30.0, method="momentum")
    with pytest.warns(rr.UnsettledWarning, match=r"not settled.*Simulate longer"):
        state = run.steady_state()
    assert not state.settled
    assert state.spread == pytest.approx(state.variation * state.speed)
    assert state.mean_travel == pytest.approx(np.hypot(*state.velocity))
    data = summary(run)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        title = plot(run).get_suptitle()
        printed = table(data)
    for text in (str(state), state._repr_html_(), printed):
        assert "NOT SETTLED" in text and "mean travel" in text and "speed" not in text
    assert "not settled, mean travel" in title
    assert json.loads(json.dumps(state.to_dict()))["settled"] is False
    assert data["steady_state"]["settled"] is False


def test_a_run_that_has_settled_says_nothing():
    state = rr.simulate(rr.FullModel(ROBOT), CIRCULAR, 30.0, method="momentum").steady_state()
    assert state.settled and "NOT SETTLED" not in str(state)


def test_optimise_settles_by_the_slowest_decay():
    def settle_time(model, **given):
        space = Space(2, offset=(0, np.pi), amplitude=0.3, angular_frequency=8.0,
                      phase_difference=(0, np.pi))  # fmt: skip
        engine = prepare(model, space, rr.GaitLimits(), given.get("own"), 100, 0, "cycles").engine
        return engine.settle_time

    assert settle_time(rr.FullModel(ROBOT)) == 25.0
    assert 200 < settle_time(SLOW) < 300
    assert settle_time(SLOW, own=7.0) == 7.0


@pytest.mark.slow
def test_what_optimise_finds_of_a_little_damped_robot_has_settled():
    best = rr.optimise(SLOW, "fastest", offset=np.pi / 2, amplitude=0.3, angular_frequency=8.0,
                       budget=100)  # fmt: skip
    assert best.met and best.steady_state.variation < 1e-5


def test_steps_of_one_length_to_and_fro_are_no_steady_state():
    time = np.linspace(0.0, 40.0, 40 * 48 + 1)
    along = np.column_stack((0.005 * np.sin(np.pi * time), 0 * time))
    still = np.zeros((time.size, 3))
    state = steady_state(SimpleNamespace(time=time, position=along, euler=still, period=1.0))
    step = 2 * 0.005 * 2 / np.pi  # from the mean of one half of a sine to that of the other
    assert state.speed == pytest.approx(step, rel=1e-6)
    assert state.variation == pytest.approx(20 / 19, rel=1e-6)  # the mean is of 19 steps
    assert not state.settled
    assert state.mean_travel == pytest.approx(step / 19, rel=1e-6)
