"""What tests of the command line share, and the engine compiled before workers start."""

import os
import subprocess
import sys
import tempfile

import numpy as np
import pytest

import rrrobot as rr

_MODEL = "import rrrobot as rr; robot = rr.Robot.from_parameters(); model = rr.FullModel(robot{}); "
_SWEEP = "rr.sweep(model, offset=[1.0], cycles=4, loads=True, progress=False); "
_RUN = "rr.simulate(model, rr.gait('lateral'), 0.1, method='momentum'); "
_ORBIT = "rr.sweep(model, offset=[1.0], settle='orbit', progress=False); "
_PLAN = "rr.plan(model, goal=(0.0, 0.1, 0.0)); "
_JOBS = (
    _MODEL.format("") + _SWEEP + _RUN + _MODEL.format(", ground=rr.Boulder(1.0)") + _SWEEP + _RUN,
    _MODEL.format("") + _ORBIT + _PLAN,
)


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the engine in two processes, a part in each; every worker would compile it all."""
    if getattr(session.config.option, "numprocesses", None):
        with tempfile.TemporaryDirectory() as home:
            environment = os.environ | {"XDG_CACHE_HOME": home}
            jobs = [
                subprocess.Popen((sys.executable, "-W", "ignore", "-c", job), env=environment)
                for job in _JOBS
            ]
            if any([job.wait() for job in jobs]):
                raise RuntimeError("the engine cannot be compiled; see above")


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
