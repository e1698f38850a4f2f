"""A check stands at one place that every entry passes; what is passed over is told."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.drive.gaits import gait
from rrrobot.steering import Track, follow

MODEL = rr.FullModel(rr.Robot.from_parameters())
ENTRIES = {
    "simulate": lambda p: rr.simulate(MODEL, gait("lateral"), 0.1, progress=p),
    "momentum": lambda p: rr.simulate(MODEL, gait("lateral"), 0.1, method="momentum", progress=p),
    "decoupled": lambda p: rr.decoupled(MODEL.robot, gait("lateral"), 0.1, progress=p),
    "sweep": lambda p: rr.sweep(MODEL, offset=1.0, cycles=2, progress=p),
    "optimise": lambda p: rr.optimise(MODEL, rr.FastestTravel(), budget=100, progress=p),
    "compare": lambda p: rr.studies.compare(MODEL.robot, gait("lateral"), duration=4.0, progress=p),
    "follow": lambda p: follow(MODEL, Track([(0, 0), (0.2, 0)]), duration=1.0, progress=p),
    "reproduce": lambda p: rr.paper.reproduce("unused", only=["table2"], progress=p),
}


@pytest.mark.parametrize("entry", ENTRIES)
def test_progress_is_a_function_or_nothing(entry, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(rr.ParameterError, match="progress is 'yes': it must be True for a bar"):
        ENTRIES[entry]("yes")


@pytest.mark.parametrize("entry", ["simulate", "momentum", "decoupled", "sweep"])
def test_progress_may_be_false(entry):
    ENTRIES[entry](False)


LEG = (
    '<link name="{n}_l"><inertial><origin xyz="0.1 0 0"/><mass value="0.06"/><inertia ixx="1e-5" '
    'ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link><joint name="{n}" '
    'type="revolute"><parent link="body"/><child link="{n}_l"/><origin xyz="0 {y} 0"/>'
    '<axis xyz="0 -1 0"/><limit lower="1.4" upper="1.7" effort="0.05" velocity="0.5"/></joint>'
)


@pytest.fixture(scope="module")
def limited():
    text = (
        '<robot name="r"><link name="body"><inertial><origin xyz="0 0 -0.08"/><mass value="0.4"/>'
        '<inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial></link>'
        f"{LEG.format(n='l', y=-0.12)}{LEG.format(n='r', y=0.12)}</robot>"
    )
    robot = rr.Robot.from_urdf(text, shell=rr.Sphere(0.12))
    return rr.FullModel(robot, damping=rr.BodyRateDamping(0.01, 0.01, 0.01))


def test_sweeps_tell_of_the_file_s_limits(limited):
    """Offsets 1.5 and 1.55 swing by 0.1 within 1.4 .. 1.7; 1.2 by 0.3 below; rates 0.2 .. 2."""
    grid = {"offset": [1.2, 1.5, 1.55], "amplitude": 0.1, "angular_frequency": [2.0, 20.0]}
    with pytest.warns(rr.LimitWarning) as told:
        rr.sweep(limited, **grid, cycles=3, progress=False)
    (message,) = [str(w.message) for w in told]
    assert "of 6 gaits, some pass limits" in message
    for leg in "lr":
        assert f"{leg}: position in 2, by up to 0.3 rad beyond 1.4" in message
        assert f"{leg}: rate in 3, by up to 1.5 rad/s beyond 0.5" in message
    assert "effort" not in message
    with pytest.warns(rr.LimitWarning, match=r"a motor's effort in \d, up to .* times"):
        rr.sweep(limited, **grid, cycles=3, loads=True, progress=False)


def test_sweeps_within_the_limits_say_nothing(limited, recwarn):
    rr.sweep(limited, offset=1.55, amplitude=0.1, angular_frequency=2.0, cycles=3, progress=False)
    assert not [w for w in recwarn if issubclass(w.category, rr.LimitWarning)]


def test_optimise_stays_within_the_limits_unless_told(limited):
    best = rr.optimise(limited, rr.FastestTravel(), budget=200, settle_time=4.0)
    motion = best.gait(np.linspace(0, best.gait.period, 200))
    assert motion.angle.min() >= 1.4 - 1e-9
    assert motion.angle.max() <= 1.7 + 1e-9
    assert np.abs(motion.rate).max() <= 0.5 + 1e-6
    with pytest.warns(rr.LimitWarning, match="position .* rad"):
        rr.optimise(
            limited, rr.FastestTravel(), offset=(0.5, 1.0), amplitude=(0.1, 0.5), budget=100,
            settle_time=4.0, limits=rr.GaitLimits(),
        )  # fmt: skip
