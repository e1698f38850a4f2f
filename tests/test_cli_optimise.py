"""`rrrobot optimise`, in this process."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import rrrobot as rr
from rrrobot.cli.main import cli
from rrrobot.drive.tables import gait_from_dict

pytestmark = pytest.mark.usefixtures("compiled_engine")

QUICK = ("--budget", "150", "--settle-time", "4", "--frequency", "8", "--max-variation", "0.5")


def run(*args: object) -> Result:
    return CliRunner().invoke(cli, ["optimise", *map(str, args)])


def test_the_table_says_what_was_found() -> None:
    result = run(*QUICK, "--amplitude", "0.3", "--offset", "pi/2")
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    for text in ("fastest: speed", "offset             1.5708", "mm/s", "N m rms of all",
                 "confirmed", "seed 0"):  # fmt: skip
        assert text in result.stdout, text


def test_json_goes_back_in(tmp_path: Path) -> None:
    path = tmp_path / "gait.json"
    result = run(*QUICK, "--offset", "1,1.2,1.4,2", "--goal", "efficient", "--cost", "work",
                 "--min-speed", "0.0005", "--json", "--out", path, "--seed", 3)  # fmt: skip
    assert result.exit_code == 0, result.output
    data = json.loads(result.stdout)
    assert data == json.loads(path.read_text())
    assert data["goal"] == {"type": "efficient", "cost": "work", "min_speed": 0.0005}
    assert data["unit"] == "J/m" and data["met"] is True and data["search"]["seed"] == 3
    gait = gait_from_dict(data["gait"])
    assert 1.0 <= gait.offset[0] <= 1.2 and 1.4 <= gait.offset[1] <= 2.0  # type: ignore[attr-defined]
    model = rr.FullModel(rr.Robot.from_parameters())
    speed = rr.simulate(model, gait, 12.0, 0.02).steady_state().speed
    assert speed == pytest.approx(data["steady_state"]["speed"], rel=0.1)


def test_a_target_out_of_reach_is_printed_and_fails(tmp_path: Path) -> None:
    path = tmp_path / "gait.json"
    result = run(*QUICK, "--goal", "target", "--speed", "0.2", "--curvature", "0", "--out", path)
    assert result.exit_code == 1
    assert "target: rms torque" in result.stdout and "Traceback" not in result.output
    assert "falls short: speed 0." in result.stderr and "instead of 0.2 and 0." in result.stderr
    assert json.loads(path.read_text())["met"] is False


@pytest.mark.slow
def test_the_front_is_drawn(tmp_path: Path) -> None:
    picture, path = tmp_path / "front.png", tmp_path / "front.json"
    result = run(*QUICK, "--budget", "600", "--pareto", picture, "--n-points", "4", "--cost",
                 "power", "--tied", "--out", path)  # fmt: skip
    assert result.exit_code == 0, result.output
    assert picture.read_bytes().startswith(b"\x89PNG")
    data = json.loads(path.read_text())
    assert data["cost"] == "power" and 2 <= len(data["points"]) <= 4
    assert gait_from_dict(data["points"][0]["gait"]).n_legs == 2
    assert "power [mW]" in result.stdout and f"wrote {picture}" in result.stdout


def test_another_robot_and_its_limits() -> None:
    result = run(*QUICK, "--leg-mass", "0.08", "--friction", "0.2", "--harmonics", "2", "--json",
                 "--damping", "0.02", "--model", "full")  # fmt: skip
    assert result.exit_code in (0, 1) and "Traceback" not in result.output
    data = json.loads(result.stdout)
    assert data["gait"]["type"] == "fourier" and data["limits"]["friction"] == 0.2
    assert data["model"]["damping"]["roll"] == 0.02


@pytest.mark.parametrize(
    ("args", "code", "text"),
    [
        (("--offset", "2,1"), 1, "the lower one comes first"),
        (("--offset", "1,2,3"), 1, "offset has shape"),
        (("--amplitude", "-1,2"), 1, "lower bound of amplitude"),
        (("--goal", "target"), 2, "needs --speed"),
        (("--goal", "target", "--speed", "0.01"), 1, "one of the two"),
        (("--goal", "fastest", "--speed", "0.01"), 2, "do not go with --goal fastest"),
        (("--goal", "winning"), 2, "winning"),
        (("--goal", "efficient", "--cost", "power"), 1, "cost is 'power'"),
        (("--budget", "5"), 1, "at least 100"),
        (("--seed", "-2"), 1, "seed is -2"),
        (("--n-points", "5"), 2, "with --pareto only"),
        (("--pareto", "front.gif"), 1, "ends in .png or .pdf or .svg"),
        (("--pareto", "front.png", "--speed", "1"), 2, "do not go with --pareto"),
        (("--pareto", "missing/front.png"), 1, "no folder"),
        (("--out", "gait.yaml"), 1, "ends in .json"),
        (("--friction", "-1"), 1, "friction is -1.0"),
        (("--model", "pivoting", "--friction", "0.1"), 1, "no friction"),
        (("--harmonics", "9"), 1, "harmonics is 9"),
    ],
)
def test_bad_options_are_one_line(args: tuple[str, ...], code: int, text: str) -> None:
    result = run(*args)
    assert result.exit_code == code
    assert text in result.stderr and "Traceback" not in result.output
    assert result.stdout == ""


def test_by_limit_cycles() -> None:
    result = run(*QUICK, "--amplitude", "0.3", "--offset", "pi/2", "--settle", "orbit", "--json")
    assert result.exit_code == 0, result.output
    data = json.loads(result.stdout)
    assert data["search"]["settle"] == "orbit" and data["met"]
    assert data["cycles"] < 8 * data["evaluations"]
