"""`rrrobot reduce`."""

import json

import pytest
from click.testing import CliRunner

from rrrobot.cli.reduce import reduce_command


def run(*arguments):
    return CliRunner().invoke(reduce_command, arguments)


def test_prints_and_plots(tmp_path):
    target = tmp_path / "heights.png"
    result = run("--models", "--optimal", "--angle-range", "0,pi", "--out", str(target))
    assert result.exit_code == 0, result.output
    assert "-0.0129962" in result.output
    assert "yaw, gravity" in result.output and "most per travel" in result.output
    assert target.stat().st_size > 20_000


@pytest.mark.slow
def test_json_with_a_plan():
    result = run("--plan", "0.2,1.2,1.6", "--angle-range", "0.2,2.9", "--offset", "1.2", "--json")
    data = json.loads(result.output)
    assert data["net_yaw"]["line"] == pytest.approx(data["net_yaw"]["simulate"], abs=1e-9)
    assert data["plan"]["arrival_error"] < 1e-6
    assert data["plan"]["cycles"] >= 1


def test_example_robot():
    pytest.importorskip("example_robot_data")
    result = run("--robot", "solo12", "--shell-radius", "0.3", "--pair", "FL_HFE,FR_HFE", "--json")
    data = json.loads(result.output)
    assert data["pair"] == ["FL_HFE", "FR_HFE"]
    assert abs(data["net_yaw"]["line"] - data["net_yaw"]["simulate"]) < 1e-6


@pytest.mark.parametrize(
    "arguments, said",
    [
        (("--pair", "leg_1,leg_9"), "two of the legs"),
        (("--out", "nowhere/x.png"), "no folder"),
        (("--angle-range", "1,0", "--optimal"), "low below high"),
        (("--plan", "1,2"), "goal has shape"),
    ],
)
def test_refusals(arguments, said):
    assert said in str(run(*arguments).exception)
