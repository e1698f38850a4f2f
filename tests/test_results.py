"""One schema of results: what a sweep, an optimiser and a simulation tell of a gait is the same."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot import results
from rrrobot.drive.gaits import GaitBatch
from rrrobot.momentum import batch
from rrrobot.simulation.measures import measured
from rrrobot.studies.optimisation.lanes import engine_of

FULL = rr.FullModel(rr.Robot.from_parameters())
GAIT = rr.SinusoidalGait(
    offset=(0.9, 1.4), amplitude=(0.3, 0.25), angular_frequency=8.0, phase=(0.4, 1.9)
)


def test_the_engine_gives_what_does_not_follow() -> None:
    given = {name for name, column in results.COLUMNS.items() if column.of is None}
    assert {*batch.RESULT, *batch.LOADS} == {*given, "status"}
    assert set(batch.LOADS) == set(results.load_names())


def test_every_result_of_a_sweep_is_that_of_a_simulation() -> None:
    cycles, period = 30, GAIT.period
    ds = rr.sweep(FULL, points=[GAIT], loads=True, cycles=cycles, steps_per_cycle=40)
    t = rr.simulate(FULL, GAIT, cycles * period, period / 240, rtol=1e-11)
    state = t.steady_state(after=(cycles - int(ds.attrs["counted"])) * period)
    own = measured(t, state, slice(-240, None))
    assert list(own) == [*results.COLUMNS, "status"]
    for name in own:
        # Extremes of samples miss the peaks between them, and means of corners a little.
        assert own[name][0] == pytest.approx(float(ds[name][0]), rel=2e-4, abs=2e-7), name


def test_a_result_that_follows_from_others_is_one_line(monkeypatch) -> None:
    """It is then in sweeps, in the optimiser's tables, and in what a simulation confirms."""
    weight = FULL.robot.mass * FULL.gravity
    cost = results.Column(
        "1", "cost of transport", lambda f: f["power"] / (weight * f["speed"]), loads=True
    )
    monkeypatch.setitem(results.COLUMNS, "cost_of_transport", cost)
    ds = rr.sweep(FULL, points=[GAIT], loads=True, cycles=12)
    assert ds.cost_of_transport.attrs == {"units": "1", "long_name": "cost of transport"}
    np.testing.assert_allclose(ds.cost_of_transport, ds.power / (weight * ds.speed), rtol=1e-14)
    assert "cost_of_transport" not in rr.sweep(FULL, points=[GAIT], cycles=4)
    gaits = GaitBatch.of([GAIT])
    table = engine_of(FULL, 8.0)(gaits)
    assert table.cost_of_transport[0] == pytest.approx(float(ds.cost_of_transport[0]), rel=1e-3)
    assert table.to_dict()["cost_of_transport"] == table.cost_of_transport[0]
    with pytest.raises(AttributeError, match="no result 'cost_of_living'"):
        table.cost_of_living  # noqa: B018


def test_a_result_without_meaning_is_none() -> None:
    pivoting = rr.sweep(rr.PivotingModel(FULL.robot), points=[GAIT], loads=True, cycles=4)
    assert pivoting.friction.isnull().all() and float(pivoting.power[0]) > 0
    assert results.curvature(np.array([0.0, 0.0, 0.1]), np.array([0.2, 0.0, 0.3])).tolist() == [
        np.inf, 0.0, pytest.approx(3.0),
    ]  # fmt: skip
