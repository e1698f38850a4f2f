"""Every error has one root and a built-in parent, and survives a trip between processes."""

import inspect
import pickle

import numpy as np
import pytest

import rrrobot as rr
from rrrobot import errors

ERRORS = [
    cls
    for _, cls in inspect.getmembers(errors, inspect.isclass)
    if issubclass(cls, Exception)
    and not issubclass(cls, Warning)
    and cls.__module__ == errors.__name__
]


@pytest.mark.parametrize("cls", ERRORS)
def test_root_and_built_in_parent(cls):
    assert issubclass(cls, rr.RRRobotError)
    assert getattr(rr, cls.__name__) is cls
    assert cls.__dict__.get("__doc__")  # its own, not its parent's
    if cls is not rr.RRRobotError:
        built_in = [c for c in cls.__mro__ if c.__module__ == "builtins"]
        assert built_in[0] not in (Exception, BaseException, object)


def test_parents_that_callers_may_catch():
    pairs = {
        rr.ParameterError: ValueError, rr.UrdfError: ValueError, rr.GaitError: ValueError,
        rr.ShellError: ValueError, rr.ModelError: ValueError, rr.OutputError: OSError,
        rr.ConstraintError: ArithmeticError, rr.MissingExtraError: ImportError,
        rr.SimulationError: RuntimeError, rr.SimulationInterrupted: KeyboardInterrupt,
    }  # fmt: skip
    for cls, parent in pairs.items():
        assert issubclass(cls, parent)
    assert issubclass(rr.SimulationInterrupted, rr.SimulationError)
    assert issubclass(rr.GroundClearanceWarning, UserWarning)


@pytest.mark.parametrize("cls", [rr.SimulationError, rr.SimulationInterrupted])
def test_a_simulation_error_pickles_with_what_it_carries(cls):
    """As it must between the processes of a sweep."""
    error = cls("stopped, at t = 2 s.", time=2.0, state=np.arange(3.0), trajectory=None)
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is cls
    assert (str(again), again.time, again.trajectory) == ("stopped, at t = 2 s.", 2.0, None)
    np.testing.assert_array_equal(again.state, error.state)


@pytest.mark.parametrize("cls", [c for c in ERRORS if not issubclass(c, rr.SimulationError)])
def test_other_errors_pickle(cls):
    again = pickle.loads(pickle.dumps(cls("a sentence.")))
    assert (type(again), str(again)) == (cls, "a sentence.")
