"""Any robot's parameters, by name or by a function: in the model, in sweeps and in searches."""

import math

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.studies import best_robot, robots_of, sweep_robots

TEXT = (
    '<robot name="r"><link name="body"><inertial><origin xyz="0 0 -0.05"/><mass value="2"/>'
    '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>'
    '<link name="leg"><inertial><origin xyz="0.1 0 0"/><mass value="0.1"/><inertia ixx="1e-4" '
    'ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link><joint name="hip" '
    'type="continuous"><parent link="body"/><child link="leg"/><origin xyz="0 0.06 0.08"/>'
    '<axis xyz="0 -1 0"/></joint></robot>'
)
ROBOT = rr.Robot.from_urdf(TEXT, shell=rr.Sphere(0.2))
MODEL = rr.FullModel(ROBOT, damping=rr.BodyRateDamping(0.05, 0.05, 0.05))


def test_each_name_changes_what_it_says():
    changes = {"body.mass": 3.0, "leg.izz": 2e-4, "hip.length": 0.2, "hip.damping": 0.5,
               "hip.friction": 0.1, "shell.radius": 0.25}  # fmt: skip
    found = rr.robot.varied(ROBOT, changes)
    body, leg = found.model.inertias[1], found.model.inertias[2]
    assert body.mass == pytest.approx(3.0)
    np.testing.assert_allclose(np.diag(body.inertia), 0.03)
    np.testing.assert_allclose(np.diag(leg.inertia), (1e-4, 1e-4, 2e-4))
    np.testing.assert_allclose(found.model.jointPlacements[2].translation, (0, 0.12, 0.16))
    assert found.joints.damping.tolist() == [0.5]
    assert found.joints.friction.tolist() == [0.1]
    assert found.shell == rr.Sphere(0.25)
    assert rr.robot.varied(ROBOT, {}).to_dict()["shell"] == ROBOT.to_dict()["shell"]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"bodi.mass": 1.0}, "'bodi.mass' is no parameter of r"),
        ({"body.length": 1.0}, "'body.length' is no parameter"),
        ({"hip.mass": 1.0}, "'hip.mass' is no parameter"),
        ({"body.mass": math.nan}, "body.mass is nan"),
        ({"body.mass": -1.0}, "must not be negative"),
        ({"body.izz": -1.0}, "negative"),
    ],
)
def test_what_is_no_parameter_or_no_robot_is_refused(changes, says):
    with pytest.raises(rr.RRRobotError, match=says):
        rr.robot.varied(ROBOT, changes)
    with pytest.raises(rr.ParameterError, match="change those"):
        rr.robot.varied(rr.Robot.from_parameters(), {"shell.radius": 0.1})


GRID = {"offset": [0.4, 1.2], "amplitude": 0.4, "angular_frequency": 6.0, "cycles": 6}


def test_a_sweep_over_robots_is_the_sweeps_of_each():
    ds = sweep_robots(MODEL, {"body.mass": [2.5], "shell.radius": [0.2, 0.22]}, **GRID)
    assert dict(ds.sizes) == {"body.mass": 1, "shell.radius": 2, "offset": 2}
    text = TEXT.replace('mass value="2"', 'mass value="2.5"').replace("0.02", "0.025")
    one = rr.FullModel(rr.Robot.from_urdf(text, shell=rr.Sphere(0.22)), damping=MODEL.damping)
    alone = rr.sweep(one, **GRID, progress=False)
    there = ds.sel({"body.mass": 2.5, "shell.radius": 0.22})
    np.testing.assert_allclose(there.speed, alone.speed, rtol=1e-9)
    assert np.ptp(ds.speed.values[0, :, 1]) > 1e-6


def test_parameters_of_a_function():
    def make(slope):
        return rr.FullModel(ROBOT, ground=rr.Plane(normal=(slope, 0, 1)), damping=MODEL.damping)

    (_, flat), (values, steep) = robots_of(MODEL, {"slope": [0.0, 0.1]}, make)
    assert values == {"slope": 0.1}
    assert flat.ground.fixed_normal[0] == 0
    assert steep.ground.fixed_normal[0] == pytest.approx(0.1 / math.hypot(0.1, 1))
    with pytest.raises(rr.ModelError, match="must give a model"):
        robots_of(MODEL, {"x": [1.0]}, lambda x: None)


def test_the_radius_for_a_rocking_period_is_the_closed_form_s():
    """One link: T = 2 pi sqrt((I + m (r - c)^2) / (m g c)), solved for the radius r."""
    text = TEXT[: TEXT.index('<link name="leg">')] + "</robot>"
    ball = rr.FullModel(rr.Robot.from_urdf(text, shell=rr.Sphere(0.2)), damping=None)
    wanted, m, i, c = 1.6, 2.0, 0.02, 0.05

    def miss(model):
        return (rr.modes(model, ())[0].period - wanted) ** 2

    best = best_robot(ball, {"shell.radius": (0.1, 0.6)}, miss, budget=80)
    radius = c + math.sqrt((wanted / (2 * math.pi)) ** 2 * 9.81 * c - i / m)
    assert best.values["shell.radius"] == pytest.approx(radius, abs=1e-4)
    assert len(best.tried) <= 80
    with pytest.raises(rr.ModelError, match=r"every robot .* was refused"):
        best_robot(ball, {"body.mass": (-2.0, -1.0)}, miss, budget=5)
