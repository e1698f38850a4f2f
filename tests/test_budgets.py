"""What has no end, or nearly none, ends within seconds with the reason."""

import pytest

import rrrobot as rr
from rrrobot.simulation import effort

MODEL = rr.FullModel(rr.Robot.from_parameters())


@pytest.mark.parametrize(
    ("gait", "duration", "says"),
    [
        ({"angular_frequency": 1e8}, 1.0, "a twelfth of the gait's period are .* the limit"),
        ({}, 1e6, "a longest step of 0.04 s are .* the limit"),
    ],
)
@pytest.mark.parametrize("method", ["kkt", "momentum"])
def test_runs_of_too_many_steps_are_refused(gait, duration, says, method):
    if method == "momentum":
        duration *= 100
    with pytest.raises(rr.ParameterError, match=says):
        rr.simulate(MODEL, rr.gait("lateral", **gait), duration, duration / 10, method=method)


@pytest.mark.parametrize(("name", "value"), [("phase", 1e12), ("phase", 1e300), ("offset", -1e9)])
def test_angles_whose_sines_are_rounding_errors_are_refused(name, value):
    options = {"offset": 1.0, "amplitude": 0.3, "angular_frequency": 8.0} | {name: value}
    with pytest.raises(rr.GaitError, match=f"{name} is .* beyond 1e\\+06 rad"):
        rr.SinusoidalGait(**options)


def test_a_run_that_creeps_is_stopped_with_the_reason(monkeypatch):
    """g = 1e6 m/s^2: rocking with 2 ms for 1000 s."""
    monkeypatch.setattr(effort, "_SURE", 500)
    monkeypatch.setattr(effort, "ENDLESS_STEPS", 200_000)
    robot = rr.Robot.from_parameters(rr.RRRobotParameters(gravity=1e6))
    options = {"sample_interval": 100.0, "euler": (0.1, 0.05, 0.0), "start": "rest"}
    with pytest.raises(rr.SimulationError, match=r"steps of .* s on average make .* the limit is"):
        rr.simulate(rr.FullModel(robot), rr.StillLegs((1.5, 1.5)), 1000.0, **options)


@pytest.mark.parametrize(("mass", "origin"), [(1e308, "0 0 0"), (1.0, "0 0 1e8")])
def test_masses_and_lengths_beyond_all_size_are_refused(mass, origin):
    text = (
        f'<robot name="r"><link name="b"><inertial><origin xyz="{origin}"/><mass value="{mass}"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link></robot>'
    )
    with pytest.raises(rr.UrdfError, match=r"is too large: the limit is"):
        rr.Robot.from_urdf(text, shell=rr.Sphere(0.1))


def test_twenty_thousand_attributes_are_refused_at_once():
    text = f'<robot name="r" {" ".join(f"a{i} = {chr(34)}1{chr(34)}" for i in range(20_000))}/>'
    with pytest.raises(rr.UrdfError, match="more than 200 attributes"):
        rr.Robot.from_urdf(text, shell=rr.Sphere(0.1))
