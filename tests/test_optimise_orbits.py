"""Optimal gaits by limit cycles: the optima of simulated cycles at a fifth of them, refusals."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.results import STATUS
from rrrobot.robot.chains import ties_of
from rrrobot.studies.optimisation.lanes import engine_of
from rrrobot.studies.optimisation.run import prepare
from rrrobot.studies.optimisation.search import _Local, attained, search
from rrrobot.studies.optimisation.space import Space
from rrrobot.studies.optimisation.table import GaitLimits
from rrrobot.studies.optimisation.task import Evaluator, Task
from tests.some import some

ROBOT = rr.Robot.from_parameters()
MODEL = rr.FullModel(ROBOT)
LATERAL = {"amplitude": 0.3, "angular_frequency": 8.0, "tied": True}
CASES = [
    ("fastest lateral", rr.studies.FastestTravel(), LATERAL | {"budget": 900}, 1e-6),
    (
        "target",
        rr.studies.TargetMotion(speed=0.006, curvature=-1.5),
        {"budget": 2500, "seed": 4},
        1e-4,
    ),
    (
        "tightest",
        rr.studies.TightestTurn(min_speed=0.002),
        {"budget": 4000, "amplitude": (0.1, 0.4), "angular_frequency": (5.0, 10.0)},
        2e-3,
    ),
    (
        "least work",
        rr.studies.LeastEffort(cost="work", min_speed=0.002),
        {"budget": 4000, "amplitude": (0.1, 0.4), "angular_frequency": (5.0, 10.0)},
        2e-3,
    ),
]


@pytest.mark.parametrize(
    ("name", "goal", "box", "tolerance"),
    some(CASES, ["fastest lateral"], lambda case: case[0]),
)
def test_the_same_optimum_with_a_fifth_of_the_cycles(name, goal, box, tolerance):
    """By default budgets of time: 25 s to settle. The optima are measured by one yardstick."""
    box = {"offset": (0.0, np.pi), "amplitude": (0.0, 0.5), "angular_frequency": (2.0, 14.0),
           "phase_difference": (0.0, 2 * np.pi)} | box  # fmt: skip
    budget, seed = box.pop("budget"), box.pop("seed", 0)
    box["ties"] = ties_of(ROBOT) if box.pop("tied", False) else None
    task = Task.of(MODEL, goal, GaitLimits())
    cycles, values = {}, {}
    for settle in ("cycles", "orbit"):
        evaluator = prepare(MODEL, Space(2, **box), GaitLimits(), 25.0, budget, seed, settle)
        point = search(evaluator, task, np.random.default_rng(seed))
        point, comes = attained(evaluator, task, point)
        assert comes
        table = engine_of(MODEL, 60.0)(evaluator.space.population(point[None]))
        assert task._replace(tolerance=1e-3).reached(table)
        cycles[settle], values[settle] = evaluator.cycles, float(goal.value(table)[0])
    assert values["orbit"] == pytest.approx(values["cycles"], rel=tolerance)
    assert cycles["orbit"] <= cycles["cycles"] / 5


def test_the_result_is_confirmed():
    found = rr.optimise(MODEL, "fastest", settle="orbit", budget=400, settle_time=15.0, **LATERAL)
    assert found.met and found.value == pytest.approx(0.0096777, rel=1e-4)
    assert found.search["settle"] == "orbit" and 0 < found.cycles < 8 * found.evaluations
    assert found.to_dict()["cycles"] == found.cycles


def test_an_unreachable_target_gives_the_nearest():
    """The fastest straight gait, 0.0269 m/s, as by simulated cycles."""
    goal = rr.studies.TargetMotion(speed=0.05, curvature=0.0)
    box = {"tied": True, "offset": np.pi / 2, "budget": 800, "settle_time": 15.0}
    found = rr.optimise(MODEL, goal, settle="orbit", **box)
    assert not found.met and "instead of 0.05 and 0" in found.shortfalls[0]
    assert found.steady_state.speed == pytest.approx(0.0269, rel=1e-3)
    assert abs(found.steady_state.curvature) < 0.01


def test_gradients_are_the_orbits_sensitivities():
    """Against the implicit function theorem on tangents of the flow, to 1e-6."""
    box = {"offset": (0.2, 2.8), "amplitude": (0.1, 0.5), "angular_frequency": (4.0, 10.0)}
    space = Space(2, phase_difference=(0.0, 2 * np.pi), **box)
    evaluator = Evaluator(engine_of(MODEL, 25.0, "orbit"), space, 100)
    task = Task.of(MODEL, rr.studies.FastestTravel(), GaitLimits())
    x = np.array((0.3, 0.4, 0.55, 0.5, 0.2, 0.7))
    local = _Local(evaluator, task, x, np.ones(6, dtype=bool), False)
    slopes = -local.slope("objective", x) * local.scale
    names = ("offset[0]", "offset[1]", "amplitude[0]", "amplitude[1]", "phase[1]",
             "angular_frequency")  # fmt: skip
    s = rr.orbits.sensitivities(rr.limit_cycle(MODEL, space.gait(x)), names)
    expected = s.derivatives["speed"] * (space.upper - space.lower)[space.free]
    np.testing.assert_allclose(slopes, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_a_cycle_that_does_not_hold_is_outside_a_limit():
    """Legs in phase, as `test_symmetry_is_lost_with_legs_in_phase`: the forward rocking."""
    gait = {"offset": np.pi / 2, "amplitude": 0.45, "angular_frequency": 5.2,
            "phase_difference": 0.0}  # fmt: skip
    found = rr.optimise(MODEL, "fastest", settle="orbit", settle_time=10.0, **gait)
    assert not found.met
    assert any("limit cycle does not hold: a Floquet multiplier of" in s for s in found.shortfalls)
    table = engine_of(MODEL, 10.0, "orbit")(Space(2, **gait).population(np.zeros((1, 0))))
    assert STATUS[int(table.status[0])] == "orbit_unstable" and table.multiplier[0] > 1
    task = Task.of(MODEL, rr.studies.FastestTravel(), GaitLimits())
    assert task.slacks(table)["stable"][0] < 0 and not task.reached(table)


def test_several_motions_hold_and_the_one_from_rest_counts(monkeypatch):
    """An orbit that the upright start does not come to is passed over, and that is said."""
    from rrrobot.studies.optimisation import search

    monkeypatch.setattr(search, "_SAME", 0.0)
    found = rr.optimise(MODEL, "fastest", settle="orbit", budget=100, settle_time=5.0, **LATERAL)
    assert not found.met and "an upright start does not come to" in found.shortfalls[-1]


@pytest.mark.slow
def test_a_front_by_orbits():
    box = {"n_points": 3, "budget": 900, "tied": True, "offset": (1.2, 1.9)}
    fronts = [rr.pareto_front(MODEL, settle=settle, **box) for settle in ("cycles", "orbit")]
    assert fronts[1].cycles < 0.22 * fronts[0].cycles
    assert fronts[1].speed[-1] == pytest.approx(fronts[0].speed[-1], rel=1e-3)
    assert fronts[1].discrepancy < 0.01


@pytest.mark.parametrize(
    ("model", "options", "error", "words"),
    [
        (MODEL, {"settle": "x"}, rr.ParameterError, "'cycles' or 'orbit'"),
        (rr.FullModel(ROBOT, damping=None), {}, rr.ModelError, "full model has no damping"),
        (rr.FullModel(ROBOT, ground=rr.Plane((0.05, 0, 1))), {}, rr.ModelError, "level"),
        (
            rr.FullModel(rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=1.0))),
            {"amplitude": (2.8, 3.0), "offset": np.pi / 2, "angular_frequency": (5.0, 12.0),
             "phase_difference": 0.0},
            rr.GaitError,
            "no gait within the bounds has a limit cycle",
        ),
    ],
    ids=["way", "undamped", "slope", "none"],
)  # fmt: skip
def test_refusals(model, options, error, words):
    with pytest.raises(error, match=words):
        rr.optimise(model, "fastest", **({"settle": "orbit", "budget": 100} | options))
