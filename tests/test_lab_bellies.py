"""The laboratory with a fitted belly: the robot rests on it, and its legs are clear."""

import math
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

import rrrobot as rr
from rrrobot.cli.lab import lab_command
from rrrobot.lab.bellies import begin, check_belly, collisions, swaying
from rrrobot.lab.outcome import settle
from rrrobot.robot.chains import leg_chains
from rrrobot.view.scene import Scene

pytest.importorskip("example_robot_data")
FILE_TOLD = pytest.mark.filterwarnings("ignore::rrrobot.UrdfWarning")


@pytest.fixture(scope="module")
def belly():
    return rr.fit_belly("solo12")


@pytest.fixture(scope="module")
def begun(belly):
    return begin(belly)


def judged(belly, knobs):
    """Limits that a run by the general form from the belly's rest passes."""
    run = rr.simulate(knobs.model(belly.robot), knobs.gait(), 4.0, 0.02, euler=belly.rest)
    return rr.belly.feasibility(run, rr.belly.MotionLimits(), belly=belly)


def test_it_begins_at_rest_on_the_belly_with_its_legs_clear(belly, begun):
    knobs, outcome = begun
    assert knobs.offset == pytest.approx(belly.posture)
    assert max(knobs.amplitude) > 0.04
    assert outcome.settled and outcome.speed > 5e-5
    found = judged(belly, knobs)
    assert {one.what for one in found.violations} <= {"effort", "rate"}


def test_what_the_limbs_run_into_is_said(belly, begun):
    knobs, _ = begun
    low = settle(belly.robot, replace(knobs, offset=(0.0,) * belly.robot.n_legs))
    # At their zeros the legs hang straight down.
    assert any("in the ground" in words for words in collisions(belly, low))
    assert collisions(belly, begun[1]) == ()


def test_limbs_that_mirror_each_other_are_half_a_cycle_apart(belly):
    entries = swaying(belly.robot, belly.posture, 0.2)
    legs = belly.robot.legs
    phase = dict(zip(legs, entries["phase"], strict=True))
    # Hips of both sides turn the same way in the world, half a cycle after what a mirror shows.
    for left, right in (("FL", "FR"), ("HL", "HR")):
        assert math.sin(phase[f"{left}_HAA"]) == pytest.approx(math.sin(phase[f"{right}_HAA"]))
        assert math.sin(phase[f"{left}_HFE"]) == pytest.approx(-math.sin(phase[f"{right}_HFE"]))
    for chain in leg_chains(belly.robot):
        steps = np.diff([entries["phase"][k] for k in chain]) % math.pi
        assert steps == pytest.approx(0.5 * math.pi)


def test_swings_keep_to_the_joints_limits():
    robot = rr.Robot.from_example("a1", shell=rr.Sphere(0.3))
    middle = 0.5 * (robot.joints.lower + robot.joints.upper)
    entries = swaying(robot, middle, 10.0)
    room = 0.5 * (robot.joints.upper - robot.joints.lower)
    assert np.array(entries["amplitude"]) == pytest.approx(0.9 * room)


def test_a_belly_for_a_rock_is_refused():
    with pytest.raises(rr.ModelError, match="level ground"):
        check_belly(rr.fit_belly("solo12", ground=rr.Boulder(0.4)))


@pytest.mark.slow
def test_of_a_dome_only_what_is_below_is_drawn(belly):
    scene = Scene(belly.robot)
    shell = next(v for v in scene.visuals if v.name == "shell")
    points = shell.geometry["data"]["attributes"]["position"]["array"].reshape(-1, 3)
    lowest = belly.center + belly.shell.contact(np.array((0.0, 0.0, -1.0)))
    assert shell.placement.translation == pytest.approx(lowest, abs=1e-12)
    # On the shell, and about as wide as the robot.
    assert np.linalg.norm(points, axis=1).max() < 0.5
    for point in points[:: len(points) // 20]:
        out = point + lowest - belly.center
        assert np.sum((out / belly.shell.semi_axes) ** 2) == pytest.approx(1.0, abs=1e-5)
        assert out[2] < -0.5 * belly.shell_depth
    whole = Scene(rr.Robot.from_parameters())
    assert whole.size == pytest.approx(0.12) and whole.height == pytest.approx(0.12)


def test_a_shell_without_a_radius_is_refused_on_the_command_line():
    ran = CliRunner().invoke(lab_command, ["--robot", "solo12", "--shell-center", "0", "0", "0.1"])
    assert ran.exit_code == 2 and "--shell-center: such options need --shell-radius" in ran.output


@pytest.mark.slow
@FILE_TOLD
@pytest.mark.parametrize("name", ("a1", "go2", "anymal_c"))
def test_other_robots_begin_clear_too(name):
    belly = rr.fit_belly(name)
    knobs, outcome = begin(belly)
    assert outcome is not None and collisions(belly, outcome) == ()
    violations = judged(belly, knobs).violations
    assert not {one.what for one in violations} & {"clearance", "separation", "position", "tilt"}
