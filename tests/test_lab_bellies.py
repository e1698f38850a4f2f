"""The laboratory with a fitted belly: the robot rests on it, and its legs are clear."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

import rrrobot as rr
from rrrobot.cli.lab import lab_command
from rrrobot.lab.bellies import begin, check_belly, collisions, travelling
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.outcome import settle
from rrrobot.view.scene import Scene
from tests.test_lab_excursions import runs_beside_its_trajectory

pytest.importorskip("example_robot_data")
FILE_TOLD = pytest.mark.filterwarnings("ignore::rrrobot.UrdfWarning")


@pytest.fixture(scope="module")
def belly():
    return rr.fit_belly("solo12")


@pytest.fixture(scope="module")
def begun(belly):
    return begin(belly)


def judged(belly, begun):
    """Limits that a run of the settled motion passes, by the general form."""
    knobs, outcome = begun
    run = rr.simulate(
        knobs.model(belly.robot), knobs.gait(), 4.0, 0.02, euler=outcome.cycle.euler,
        start=outcome.cycle.euler_rates,
    )  # fmt: skip
    return rr.belly.feasibility(run, rr.belly.MotionLimits(), belly=belly)


def test_it_begins_at_rest_on_the_belly_with_its_legs_clear(belly, begun):
    knobs, outcome = begun
    assert knobs.offset == pytest.approx(belly.posture)
    assert outcome.settled and outcome.speed > 0.005
    assert judged(belly, begun).violations == ()


@pytest.mark.filterwarnings("ignore::rrrobot.UnsettledWarning")  # of two seconds
def test_it_is_taken_home_with_its_belly(belly, begun, tmp_path, monkeypatch):
    knobs, _ = begun
    runs_beside_its_trajectory(belly.robot, knobs, 1.8, tmp_path, monkeypatch)
    assert Knobs.of(belly.robot).read(knobs.text()) == knobs


def test_what_the_limbs_run_into_is_said(belly, begun):
    knobs, _ = begun
    low = settle(belly.robot, replace(knobs, offset=(0.0,) * belly.robot.n_legs))
    # At their zeros the legs hang straight down.
    assert any("in the ground" in words for words in collisions(belly, low))
    assert collisions(belly, begun[1]) == ()


def test_it_goes_straight_and_nothing_slips(belly, begun):
    knobs, outcome = begun
    assert outcome.friction <= knobs.friction
    # In a minute it goes farther than its base is long, and turns by less than a right angle.
    assert 60 * outcome.speed > 0.4 and abs(60 * outcome.yaw_rate) < 0.5 * np.pi


def test_small_gaits_keep_to_the_joints_limits():
    belly = rr.fit_belly("go2")
    joints = belly.robot.joints
    ways = travelling(belly, replace(Knobs.of(belly.robot), damping=0.1))
    assert ways
    for way in ways:
        swing = np.array(way["amplitude"])
        assert np.all(belly.posture - swing >= joints.lower) and swing.max() > 0.05
        assert np.all(belly.posture + swing <= joints.upper)


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
    violations = judged(belly, (knobs, outcome)).violations
    assert not {one.what for one in violations} & {"clearance", "separation", "position", "tilt"}
