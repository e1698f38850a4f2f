"""`rrrobot unstick`, in this process: on RRRobot, whose belly is a sphere."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import rrrobot as rr
from rrrobot.cli.main import cli
from tests.test_belly import HEIGHT, LENGTH, WIDTH, board

pytestmark = pytest.mark.usefixtures("compiled_engine")

QUICK = ("rrrobot", "--goal", "left", "--budget", "600", "--postures", "2")


def run(*args: object) -> Result:
    return CliRunner().invoke(cli, ["unstick", *map(str, args)])


def test_the_whole_story_and_how_it_goes_on(tmp_path: Path) -> None:
    result = run(*QUICK, "--out", tmp_path / "free")
    assert result.exit_code == 0, result.output
    for text in ("Belly(round belly of rrrobot", "mode: pitch", "left", "mm/s",
                 "least clearance from the ground", "engine and KKT model differ by"):  # fmt: skip
        assert text in result.stdout, text
    names = {path.name for path in (tmp_path / "free").iterdir()}
    assert names == {
        "report.html", "unstick.json", "left.html", "left.json", "left.csv", "left.ros.json",
        "left.npz",
    }  # fmt: skip
    page = (tmp_path / "free/report.html").read_text()
    # It stands by itself: nothing is loaded from elsewhere.
    assert 'src="http' not in page and "<script" not in page and "data:image/png" in page
    assert "NOT MET" not in page and "<h2>left</h2>" in page
    gait = rr.read_gait(tmp_path / "free/left.json")
    assert gait.n_legs == 2
    # Again: what is there is not searched anew, and its numbers are the same.
    again = run(*QUICK, "--out", tmp_path / "free", "--json", "--no-films")
    assert again.exit_code == 0, again.output
    told = json.loads(again.stdout)
    kept = json.loads((tmp_path / "free/unstick.json").read_text())
    assert told["gaits"] == kept["gaits"]
    assert told["gaits"]["left"][0]["met"] is True
    assert rr.gait_from_dict(told["gaits"]["left"][0]["gait"]).to_dict() == gait.to_dict()
    # Another ground is another story.
    other = run(*QUICK, "--ground", "slope:2", "--out", tmp_path / "free")
    assert other.exit_code == 1 and "another robot, ground" in other.stderr
    # Nor is a failure kept from a search that was smaller.
    other = run(*QUICK, "--budget", "700", "--out", tmp_path / "free")
    assert other.exit_code == 1 and "limits or search" in other.stderr


@pytest.mark.slow
def test_what_is_out_of_reach_is_told() -> None:
    result = run(*QUICK, "--friction", "0.001")
    assert result.exit_code == 1
    assert "Try" in result.stderr and "Traceback" not in result.stderr


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("rrrobot", "--goal", "up"), "goal is 'up': it must be one of forward"),
        (("rrrobot", "--group", "twins"), "group is 'twins'"),
        (("rrrobot", "--joints", "leg_9"), "joint 'leg_9' is none of the robot's"),
        (("legged:six",), "write legged:N or legged:NxJ"),
        (("rrrobot", "--postures", "0"), "postures is 0"),
        (("rrrobot", "--budget", "0"), "--budget is 0: it must be a whole number"),
        (("rrrobot", "--floor", "0.3"), "--floor is 0.3 m: only a rock has one below it"),
        (("no_such_robot.urdf",), "no_such_robot.urdf"),
    ],
)
def test_bad_input_is_one_line(args: tuple[str, ...], message: str) -> None:
    result = run(*args)
    assert result.exit_code == 1
    assert message in result.stderr and len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("change", "ground", "said"),
    [
        # Legs that their limits keep below the belly.
        (('lower="-1.0" upper="1.0"', 'lower="0.5" upper="1.0"'), "level",
         ("forward: ", "mm in the ground within 15 degrees", "touches the ground at rest", "Try")),
        # A rest that is not stable.
        ((f'<box size="{LENGTH} {WIDTH} {HEIGHT}"/>', f'<box size="{LENGTH} {WIDTH} 0.6"/>'),
         "boulder:0.2",
         ("off:0: it tips over in roll", "above the centre of curvature", "Try another form=")),
        (('type="revolute"', 'type="planar"'), "level",
         ("joint 'left_hip' has 3 degrees of freedom", "revolute, continuous or prismatic")),
        # Without a goal: in a bowl they are those of level ground.
        (("", ""), "bowl:0.15", ("forward: the ground curves tighter", "turn left: ", "wider")),
    ],
)  # fmt: skip
def test_robots_that_cannot_are_told_why(
    tmp_path: Path, change: tuple[str, str], ground: str, said: tuple[str, ...]
) -> None:
    path = tmp_path / "board.urdf"
    path.write_text(board().replace(*change))
    goal = {"boulder:0.2": ("--goal", "off:0"), "level": ("--goal", "forward")}.get(ground, ())
    result = run(path, "--ground", ground, *goal, "--quiet")
    assert result.exit_code == 1 and len(result.stderr.splitlines()) == 1
    for text in said:
        assert text in result.stderr, result.stderr


def test_where_meshes_lie_is_said_with_an_option(tmp_path: Path) -> None:
    """The package's own folder may have another name, as of a clone."""
    box = f'<box size="{LENGTH} {WIDTH} {HEIGHT}"/>'
    text = board().replace(box, '<mesh filename="package://mybot/meshes/trunk.stl"/>')
    (tmp_path / "mybot.urdf").write_text(text)
    args = (tmp_path / "mybot.urdf", "--budget", "0", "--quiet")
    result = run(*args)
    assert result.exit_code == 1 and "trunk.stl' is not found" in result.stderr
    assert "Say with --package-dirs where they lie." in result.stderr
    result = run(*args, "--package-dirs", Path(__file__).parent / "urdfs")
    assert "budget is 0" in result.stderr and "trunk.stl" not in result.stderr
    result = run("solo12", "--package-dirs", tmp_path)
    assert result.exit_code == 1 and "no URDF file 'solo12'" in result.stderr
