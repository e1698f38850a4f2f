"""One protocol of progress: a function, a bar, nothing, and what is refused everywhere."""

import inspect

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.progress import progress_of

MODEL = rr.FullModel(rr.Robot.from_parameters())
GAIT = rr.gait("lateral")
LONG = {
    "simulate": lambda p: rr.simulate(MODEL, GAIT, 0.5, progress=p),
    "simulate by momentum": lambda p: rr.simulate(MODEL, GAIT, 0.5, method="momentum", progress=p),
    "decoupled": lambda p: rr.decoupled(MODEL.robot, GAIT, 0.5, progress=p),
    "sweep": lambda p: rr.sweep(MODEL, offset=[1.0, 1.2], cycles=3, progress=p),
    "optimise": lambda p: rr.optimise(
        MODEL, "fastest", amplitude=0.3, angular_frequency=8.0, phase_difference=1.5, tied=True,
        budget=100, settle_time=3.0, progress=p,
    ),
    "compare": lambda p: rr.studies.compare(MODEL.robot, GAIT, 6.0, method="momentum", progress=p),
    "branch": lambda p: rr.orbits.branch(
        rr.limit_cycle(MODEL, GAIT), "amplitude", to=0.31, n_points=2, progress=p
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", LONG)
def test_a_function_is_told_what_is_done_of_how_much(name):
    told = []
    LONG[name](lambda done, total: told.append((done, total)))
    done, total = np.array(told).T
    assert len(set(total)) == 1 and np.all(np.diff(done) >= 0)
    assert 0 < done[-1] <= total[0]


@pytest.mark.parametrize("name", LONG)
@pytest.mark.parametrize("wrong", [1, "yes", object])
def test_other_wishes_are_refused_in_one_sentence(name, wrong):
    if callable(wrong):
        wrong = [print]
    with pytest.raises(rr.ParameterError, match=r"progress is .*: it must be True for a bar"):
        LONG[name](wrong)


def test_all_that_take_progress_take_the_same():
    faces = (rr, rr.simulation, rr.studies, rr.orbits, rr.steering, rr.paper)
    functions = {
        getattr(face, name) for face in faces for name in face.__all__
        if inspect.isfunction(getattr(face, name))
    }  # fmt: skip
    found = {}
    for function in functions:
        parameter = inspect.signature(function).parameters.get("progress")
        if parameter is not None:
            found[function.__name__] = parameter.annotation
            assert parameter.default in (False, None), function
    assert {"simulate", "decoupled", "sweep", "optimise", "pareto_front", "compare", "plan",
            "branch", "follow", "reproduce", "unstick"} <= set(found)  # fmt: skip
    assert set(found.values()) == {"Progress"}


def test_a_bar_names_what_is_worked_on(capsys):
    with progress_of(True, "items", 2, "items") as tell:
        tell(1, "first")
        tell(2)
    assert "first: 100%" in capsys.readouterr().err
    with progress_of(None, "items", 2, "items") as tell:
        assert tell is None
