"""`rrrobot machines`."""

import json

import pytest
from click.testing import CliRunner

import rrrobot as rr
from rrrobot.cli.main import cli


def run(*arguments):
    return CliRunner().invoke(cli, ["machines", *arguments])


def test_the_list_says_what_each_machine_is():
    result = run("--json")
    assert result.exit_code == 0
    machines = json.loads(result.output)["machines"]
    assert set(machines) == set(rr.machines.all_names())
    kinds = {name: machines[name]["kind"] for name in machines}
    assert kinds["kinematic_snake"] == "kinematic, SE(2)"
    assert kinds["snakeboard"] == "mixed, SE(2)"
    assert kinds["legged_satellite"] == "momentum, SE(3)"
    assert kinds["rrrobot"] == "drift"
    assert kinds["rattleback"] == "free motion"
    assert "rattleback" in run().output


def test_a_gait_is_simulated():
    result = run("snakeboard", "--gait", "drive", "--set", "J=0.1654", "--json")
    data = json.loads(result.output)
    assert data["pose"] == pytest.approx((0.1201482682, -0.001106748307, -0.05812562375), abs=1e-9)
    assert "constraints broken by" in run("chaplygin_sleigh", "--duration", "1").output


def test_urdf_and_mistakes():
    assert run("snakeboard", "--urdf").output.startswith("<robot")
    assert "no such joint" in run("sphericle", "--urdf").output
    assert "there is no machine 'bicycle'" in run("bicycle").output
    assert "has no gait 'fly'" in run("snakeboard", "--gait", "fly").output
    assert "has no parameter 'k'" in run("snakeboard", "--set", "k=1").output
    assert "KEY=VALUE" in run("snakeboard", "--set", "m").output
