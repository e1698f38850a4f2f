"""What tests of the command line share."""

import numpy as np
import pytest

import rrrobot as rr


@pytest.fixture(scope="session")
def compiled_engine() -> None:
    """The momentum engine, compiled: otherwise the first command says on stderr that it will be."""
    model = rr.FullModel(rr.Robot.from_parameters())
    rr.sweep(model, offset=[1.0], cycles=4, loads=True, progress=False)
    rr.simulate(model, rr.gait("lateral"), np.pi / 4, method="momentum")


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A folder of the tests' own for the maps that steering keeps."""
    patch = pytest.MonkeyPatch()
    patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
    yield
    patch.undo()
