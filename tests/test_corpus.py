"""Robot files as people publish them (tests/urdfs): what becomes of each."""

import warnings
from pathlib import Path

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.view.shapes import robot_visuals

FOLDER = Path(__file__).parent / "urdfs"
# file, options -> legs, mass [kg], what the warnings say.
READ = {
    "pendulum_ball.urdf": ({"shell_link": "ball"}, ("drive",), 4.5, ()),
    "gazebo_quadruped.urdf": ({}, ("FL_hip", "FR_hip"), 7.6, ()),
    "gripper_mimic.urdf": ({}, ("left",), 1.2, ()),
    "cad_export.urdf": ({}, ("coxa",), 1.05, ("base_link", "femur")),
    "ball_hips.urdf": ({}, ("hip_x", "hip_y", "hip_z"), 4.5, ()),
}
REFUSED = {
    "hexapod.urdf.xacro": "<xacro:macro> at line 3",
    "two_trees.urdf": "'c'",
    "world.sdf": "SDF",
}


def test_every_file_has_its_answer():
    files = {path.name for path in FOLDER.iterdir() if path.is_file()}
    assert files == set(READ) | set(REFUSED)


@pytest.mark.parametrize("name", READ)
def test_what_is_read(name):
    options, legs, mass, told = READ[name]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        robot = rr.Robot.from_urdf(FOLDER / name, shell=rr.Sphere(0.3), **options)
    assert robot.legs == legs and robot.mass == pytest.approx(mass, rel=1e-12)
    messages = " ".join(str(w.message) for w in caught)
    assert bool(messages) == bool(told) and all(word in messages for word in told)
    model = rr.FullModel(robot, damping=rr.BodyRateDamping(0.2, 0.2, 0.2))
    gait = rr.SinusoidalGait(offset=0.1, amplitude=np.full(len(legs), 0.05), angular_frequency=5)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        t = rr.simulate(model, gait, 0.5)
    assert t.slip.max() < 1e-12 and abs(t.height_error).max() < 1e-12


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(name, monkeypatch):
    for package in ("xacro", "xacrodoc"):
        monkeypatch.setitem(__import__("sys").modules, package, None)
    with pytest.raises(rr.UrdfError) as caught:
        rr.Robot.from_urdf(FOLDER / name, shell=rr.Sphere(0.3))
    assert REFUSED[name] in str(caught.value) and "\n" not in str(caught.value)


def test_a_sphere_found_by_turning_the_tree_over_rolls_as_the_ball():
    """Locked, the whole is one rigid ball with its centre of mass below: a pendulum on a wheel."""
    robot = rr.Robot.from_urdf(
        FOLDER / "pendulum_ball.urdf", shell=rr.Sphere(0.18), shell_link="ball",
        legs=(), locked={"drive": 0.0},
    )  # fmt: skip
    m, depth, r, g = 4.5, 3.0 * 0.08 / 4.5, 0.18, 9.81
    about_mass_centre = 0.02 + 0.03 + 3.0 * (0.08 - depth) ** 2 + 1.5 * depth**2
    omega = np.sqrt(m * g * depth / (about_mass_centre + m * (r - depth) ** 2))
    found = rr.modes(rr.FullModel(robot), ())
    assert min(abs(abs(mode.eigenvalue) - omega) for mode in found) < 1e-6 * omega


def test_the_mesh_beside_the_file_is_found():
    robot = rr.Robot.from_urdf(FOLDER / "gazebo_quadruped.urdf", shell=rr.Sphere(0.3))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        visuals = robot_visuals(robot)
    trunk = [visual for visual in visuals if visual.name == "trunk"]
    assert trunk and trunk[0].flat and 0.2 < trunk[0].reach < 0.25
