"""`rrrobot sweep`, in this process."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import click
import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner, Result

import rrrobot as rr
from rrrobot.cli.main import cli
from rrrobot.cli.sweep import sweep_command
from rrrobot.cli.sweep_grids import parse_grid
from rrrobot.cli.sweep_report import draw_paper
from rrrobot.models.recombined import DecoupledModels
from rrrobot.studies.sweeps.run import sweep

pytestmark = pytest.mark.usefixtures("compiled_engine")

ROBOT = rr.Robot.from_parameters()
SHORT = ("--cycles", "4")
# The group that turns errors into lines and exit codes, with this command.
group: click.Group = type(cli)("rrrobot", commands={"sweep": sweep_command})


def run(*args: str) -> Result:
    return CliRunner().invoke(group, ["sweep", *map(str, args)])


def good(*args: str) -> Result:
    result = run(*args)
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    return result


def data(*args: str) -> dict:
    return json.loads(good(*args, "--json").stdout)


# Grids


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("pi/2", math.pi / 2),
        ("0:pi:3", [0, math.pi / 2, math.pi]),
        ("-pi/2:pi/2:2", [-math.pi / 2, math.pi / 2]),
        ("1:2:1", [1.0]),
        ("0.1, 2*pi", [0.1, 2 * math.pi]),
        ("2:1:3", [2.0, 1.5, 1.0]),
    ],
)
def test_grids(text: str, values: float | list[float]) -> None:
    np.testing.assert_allclose(parse_grid(text), values, rtol=1e-15)
    assert np.ndim(parse_grid(text)) == np.ndim(values)


@pytest.mark.parametrize(
    "text",
    ["", "0:1", "0:1:2:3", "0:1:0", "0:1:-3", "0:1:2.5", "0:1:1e9", "0:nan:3", "a:b:3", "1,,2",
     "0:1:999999999"],
)  # fmt: skip
def test_no_grids(text: str) -> None:
    with pytest.raises(ValueError, match=r"no number|no grid|values"):
        parse_grid(text)
    result = run("--offset", text)
    assert result.exit_code == 2
    assert "Invalid value for '--offset'" in result.stderr


# Results


def test_json_is_the_librarys_numbers() -> None:
    found = data("--offset", "0.5:1.5:3", "--phase-difference", "1,2", *SHORT)
    ds = sweep(rr.FullModel(ROBOT), offset=[0.5, 1.0, 1.5], phase_difference=[1.0, 2.0], cycles=4)
    assert found["sizes"] == {"offset": 3, "phase_difference": 2}
    assert (found["gaits"], found["cycles"], found["counted"]) == (6, 4, 2)
    assert found["status"]["steady_state"] == 6
    assert sum(found["status"].values()) == 6
    best = found["fastest"]
    assert best["speed"] == float(ds.speed.max())
    where = {"offset": best["offset"], "phase_difference": best["phase_difference"]}
    assert float(ds.speed.sel(where)) == best["speed"]
    assert float(ds.yaw_rate.sel(where)) == best["yaw_rate"]
    turn = found["fastest_turn"]
    assert abs(turn["yaw_rate"]) == float(abs(ds.yaw_rate).max())
    assert found["files"] == []


def test_table_says_the_same() -> None:
    text = good("--offset", "pi/4").stdout
    assert "v 6.6765 mm/s, 0.020855 rad/s" in text
    assert "offset 0.7854, phase difference 1.5708, amplitude 0.3" in text
    assert "38, the last 18 counted" in text
    assert "stopped" not in text


def test_what_stops_and_does_not_settle_is_said() -> None:
    args = ("--offset", "pi/2", "--phase-difference", "0", "--frequency", "6")
    text = good(*args, "--amplitude", "0.3,1.4").stdout
    assert "1: pitch reached 90 degrees" in text
    found = data(*args, "--amplitude", "1.4")
    assert found["fastest"] is None
    assert found["status"]["pitch_reached_90_degrees"] == 1


def test_options_reach_the_sweep(tmp_path: Path) -> None:
    out = tmp_path / "sweep.nc"
    args = (
        *("--model", "pivoting", "--offset", "leg_1=0.5", "--offset", "leg_2=0.5:0.9:2"),
        *("--phase", "leg_1=0", "--phase", "leg_2=1", "--amplitude", "0.2", "--frequency", "7"),
        *("--damping", "0.02,0.03,0", "--cycles", "9", "--counted", "4", "--steps", "12"),
        *("--parameter", "leg_mass=0.05,0.06", "--leg-length", "0.09", "--threads", "1"),
    )
    good(*args, "--out", str(out))
    parameters = rr.RRRobotParameters(leg_length=0.09)
    model = rr.PivotingModel(rr.Robot.from_parameters(parameters), damping=(0.02, 0.03, 0.0))
    ds = sweep(
        model,
        offset=(0.5, [0.5, 0.9]),
        phase=(0.0, 1.0),
        amplitude=0.2,
        angular_frequency=7.0,
        parameters={"leg_mass": [0.05, 0.06]},
        cycles=9,
        counted=4,
        steps_per_cycle=12,
    )
    xr.testing.assert_identical(xr.load_dataset(out).drop_vars("checksum"), ds)


@pytest.mark.parametrize("model", ["full", "pivoting", "roll", "pitch", "yaw", "decoupled"])
def test_every_model(model: str) -> None:
    assert f"{model} model" in data("--model", model, "--offset", "pi/4", *SHORT)["title"]


def test_decoupled_with_another_damping(tmp_path: Path) -> None:
    out = tmp_path / "sweep.nc"
    good("--model", "decoupled", "--damping", "0.03", "--offset", "1", *SHORT, "--out", str(out))
    own = (kind(ROBOT, damping=0.03) for kind in (rr.RollModel, rr.PitchModel, rr.YawModel))
    ds = sweep(DecoupledModels(ROBOT, *own), offset=1.0, cycles=4)
    xr.testing.assert_identical(xr.load_dataset(out).drop_vars("checksum"), ds)


def test_robot_of_a_urdf() -> None:
    args = (
        "--urdf",
        str(rr.urdf_path("rrrobot")),
        "--shell-radius",
        "0.12",
        "--offset",
        "1",
        "--damping",
        "0.01",
    )
    ours = data("--offset", "1", *SHORT)["fastest"]
    assert data(*args, *SHORT)["fastest"] == ours


@pytest.mark.slow
def test_loads_are_shown_stored_and_drawn(tmp_path: Path) -> None:
    out, folder = tmp_path / "sweep.nc", tmp_path / "maps"
    args = ("--offset", "1,1.5", "--phase-difference", "1,2", *SHORT, "--loads")
    found = data(*args, "--out", str(out), "--figures", str(folder))
    ds = sweep(
        rr.FullModel(ROBOT), offset=[1.0, 1.5], phase_difference=[1.0, 2.0], cycles=4, loads=True
    )
    xr.testing.assert_identical(xr.load_dataset(out).drop_vars("checksum"), ds)
    settled = ds.friction.where(ds.variation <= 0.05)
    if settled.notnull().any():
        assert found["loads"]["friction"] == [float(settled.min()), float(settled.max())]
        assert found["fastest"]["peak_torque"] == float(
            ds.peak_torque.where(ds.speed == found["fastest"]["speed"]).max()
        )
    names = {Path(name).name for name in found["files"]}
    assert {"friction.png", "peak_torque.png", "rms_torque.png", "power.png"} <= names
    text = good("--offset", "pi/4", "--loads").stdout
    rows = dict(line.split("  ", 1) for line in text.splitlines())
    assert rows["peak torque"].split()[1:] == ["..", rows["peak torque"].split()[0], "N", "m"]
    assert "friction" in rows and rows["power"].endswith(" W")
    assert data("--offset", "pi/4", *SHORT)["loads"] is None


# Compiling


def test_the_engine_says_that_it_is_compiled_once(monkeypatch: pytest.MonkeyPatch) -> None:
    from rrrobot.momentum import batch

    asked: list[dict] = []

    def ready(**what: bool) -> bool:
        asked.append(what)
        return False

    monkeypatch.setattr(batch, "ready", ready)
    result = run("--offset", "1", *SHORT, "--loads")
    assert result.exit_code == 0
    assert result.stderr == ("compiling the momentum engine: about 15 s, once after installation\n")
    assert asked == [{"loads": True, "alone": False}]
    assert run("--offset", "1", *SHORT, "--quiet").stderr == ""


@pytest.mark.slow
def test_an_empty_cache_is_filled_once(tmp_path: Path) -> None:
    """Takes as long as Numba does, so only its words are checked, not its time."""

    command = ("sweep", "--offset", "1", *SHORT, "--json")

    def sweep_once(*more: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-c", "from rrrobot.cli.main import cli; cli()", *command, *more],
            env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
            capture_output=True,
            text=True,
            check=True,
        )

    options: list[tuple[str, ...]] = [(), (), ("--loads",), ("--loads",)]
    first, second, loads, again = (sweep_once(*more) for more in options)
    assert first.stderr.startswith("compiling the momentum engine") and second.stderr == ""
    assert first.stderr.count("\n") == 1
    assert json.loads(first.stdout)["fastest"] == json.loads(second.stdout)["fastest"]
    assert loads.stderr == first.stderr and again.stderr == ""


# Files


def test_paper_preset_resumes_and_draws(tmp_path: Path) -> None:
    out, folder = tmp_path / "plane.nc", tmp_path / "new" / "maps"
    small = ("--paper", "--offset", "0.3:2.8:5", "--phase-difference", "0.3:6:5", *SHORT)
    found = data(*small, "--out", str(out), "--figures", str(folder))
    assert found["sizes"] == {"offset": 5, "phase_difference": 5}
    assert [Path(name).name for name in found["files"]] == [
        "plane.nc",
        "fig_11_pitch_amplitude.png",
        "fig_12_yaw_amplitude.png",
        "fig_14_phase_difference.png",
        "fig_18_translation.png",
        "fig_19_translation_decoupled.png",
        "fig_20_modulation.png",
        "fig_21_inverse.png",
        "fig_22_inverse_decoupled.png",
    ]
    for name in found["files"][1:]:
        assert Path(name).read_bytes().startswith(b"\x89PNG")
    content = out.read_bytes()
    assert "wrote" in good(*small, "--out", str(out)).stdout
    assert out.read_bytes() == content
    refused = run(*small, "--amplitude", "0.2", "--out", str(out))
    assert refused.exit_code == 1
    assert "It differs in amplitude (0.3 there, 0.2 here)" in refused.stderr
    assert "--no-resume" in refused.stderr
    good(*small, "--amplitude", "0.2", "--out", str(out), "--no-resume")
    assert float(xr.load_dataset(out).amplitude) == 0.2


@pytest.mark.slow
def test_paper_preset_over_other_grids(tmp_path: Path) -> None:
    """Figures of the paper are of its plane; of another, those that any plane has."""
    args = ("--paper", "--figures", str(tmp_path), *SHORT)
    for other in (
        ("--offset", "pi/3", "--amplitude", "0.1:0.3:3", "--phase-difference", "0.5:3:3"),
        ("--offset", "1:2:3", "--phase-difference", "1:2:3", "--parameter", "leg_mass=0.06"),
    ):
        names = {Path(name).stem for name in data(*args, *other)["files"]}
        assert {"translation", "inverse"} <= names
    plane = ("--offset", "2:1:2", "--phase-difference", "0:pi:2")
    assert len(data(*args, *plane)["files"]) == 8


def test_paper_plane() -> None:
    found = data("--paper", "--cycles", "2", "--steps", "4")
    assert found["sizes"] == {"offset": 40, "phase_difference": 40}
    best = found["fastest_turn"] or found["fastest"]
    assert (best["amplitude"], best["angular_frequency"]) == (0.3, 8.0)


@pytest.mark.slow
def test_maps_of_any_two_grids(tmp_path: Path) -> None:
    args = ("--offset", "pi/3", "--amplitude", "0.1:0.4:3", "--frequency", "7:9:3", *SHORT)
    files = data(*args, "--figures", str(tmp_path))["files"]
    names = {Path(name).stem for name in files}
    assert names == {"translation", "amplitudes", "inverse", "phase_difference"}
    files = data(*args, "--model", "yaw", "--figures", str(tmp_path))["files"]
    assert "phase_difference" not in {Path(name).stem for name in files}


def test_more_than_two_grids_are_sliced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from rrrobot.figures import maps

    drawn: list[xr.Dataset] = []
    module = import_module("rrrobot.cli.sweep")
    monkeypatch.setattr(
        module, "draw", lambda ds, suffix: (drawn.append(ds), {f"map{suffix}": None})[1]
    )
    monkeypatch.setattr(module, "write_figures", lambda made, to: [to / f for f in made])
    grids = ("--offset", "1,1.2,1.4", "--amplitude", "0.2,0.3", "--frequency", "7:9:3")
    result = run(*grids, *SHORT, "--figures", str(tmp_path), "--json")
    names = {Path(name).name for name in json.loads(result.stdout)["files"]}
    assert names == {"map_amplitude_0.2", "map_amplitude_0.3"}
    assert "2 of 2 maps over offset and angular_frequency, at values of amplitude" in result.stderr
    assert [float(ds.amplitude) for ds in drawn] == [0.2, 0.3]
    for ds in drawn:
        maps.value_map(ds.speed)


def test_modulation_is_used_for_the_decoupled_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    from rrrobot.figures import maps

    drawn: list[xr.Dataset] = []
    inverse = maps.inverse
    monkeypatch.setattr(maps, "inverse", lambda ds: (drawn.append(ds), inverse(ds))[1])
    grids = {"offset": np.linspace(0.6, 2.4, 4), "phase_difference": [1.0, 2.0, 4.0]}
    full = sweep(rr.FullModel(ROBOT), **grids)
    kinds = {"pitch": rr.PitchModel, "yaw": rr.YawModel, "decoupled": DecoupledModels}
    draw_paper(full, lambda name: kinds[name](ROBOT), grids, {})
    decoupled = drawn[1]
    amplitude = decoupled.yaw_model_amplitude.sel(offset=0.6, method="nearest")
    assert 0.3 < float(amplitude) < 0.5
    near = {"offset": 0.6, "phase_difference": 2.0}
    rates = [float(ds.yaw_rate.sel(near, method="nearest")) for ds in (full, decoupled)]
    assert rates[1] == pytest.approx(rates[0], rel=0.05)


# Wrong usage


@pytest.mark.parametrize(
    ("args", "code", "message"),
    [
        ((), 1, "offset is missing"),
        (("--offset", "1", "--offset", "2"), 2, "one grid for all legs, or one JOINT=GRID each"),
        (("--offset", "1", "--offset", "leg_1=2"), 2, "one grid for all legs"),
        (("--offset", "leg_1=1", "--offset", "leg_1=2"), 2, "one grid for all legs"),
        (("--offset", "leg_1=1"), 1, "give it for each of leg_1, leg_2"),
        (("--offset", "1", "--parameter", "0.1,0.2"), 2, "write NAME=GRID"),
        (("--offset", "1", "--parameter", "mass=0.1"), 1, "has no 'mass'"),
        (("--offset", "1", "--cycles", "1"), 1, "cycles is 1"),
        (("--offset", "1", "--threads", "0"), 1, "threads is 0"),
        (("--offset", "1", "--model", "half"), 2, "'half' is not one of"),
        (("--paper", "--phase", "0"), 2, "--phase does not go with --paper"),
        (("--offset", "1", "--out", "no/such.nc"), 1, "there is no folder"),
        (("--offset", "1", "--out", "sweep.csv"), 1, "stored as netCDF"),
        (("--offset", "1", "--figures", "maps"), 2, "over two grids or more; this sweep has 0"),
        (("--offset", "0:1:2", "--figures", "maps"), 2, "over two grids or more; this sweep has 1"),
        (("--offset", "1", "--loads", "--model", "decoupled"), 1, "choose one model, such as full"),
        (("--offset", "1", "--ground", "plane:0,0,0"), 1, "normal is zero"),
    ],
)
def test_wrong_usage(args: tuple[str, ...], code: int, message: str) -> None:
    result = run(*args)
    assert result.exit_code == code, result.output
    assert message in " ".join(result.stderr.split())
    assert "Traceback" not in result.output


def test_figures_need_a_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    args = ("--offset", "0:1:2", "--amplitude", "0.1,0.2")
    result = run(*args, "--figures", str(tmp_path / "file"))
    assert result.exit_code == 1
    assert "cannot make the folder" in result.stderr


def test_a_leg_through_the_ground_is_a_warning() -> None:
    result = run("--offset", "-pi/2", "--leg-length", "0.13", *SHORT)
    assert result.exit_code == 0
    assert "1 of 1 gaits swing a leg through the ground" in result.stderr
    assert "through the ground" in result.stdout


def test_ctrl_c_is_one_line_and_130(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(import_module("rrrobot.studies.sweeps.job").Job, "_collect", stop)
    out = tmp_path / "sweep.nc"
    result = run("--offset", "0:1:100", "--out", str(out), *SHORT)
    assert result.exit_code == 130
    assert result.stderr.startswith("Interrupted: the sweep was interrupted after ")
    assert result.stderr.count("\n") == 1


def test_help_has_examples() -> None:
    text = good("--help").stdout
    for word in ("rrrobot sweep --paper", "START:STOP:COUNT", "--no-resume", "--figures"):
        assert word in text
