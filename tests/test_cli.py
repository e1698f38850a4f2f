"""The command line, in this process and as a command."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import click
import numpy as np
import pytest
from click.testing import CliRunner, Result
from scipy.io import loadmat

import rrrobot as rr
from rrrobot.cli import simulate as cli_simulate
from rrrobot.cli.main import cli
from rrrobot.cli.types import parse_number

pytestmark = pytest.mark.usefixtures("compiled_engine")

SHORT = ("--duration", "0.5")
URDF = str(rr.urdf_path("rrrobot"))


def run(*args: str) -> Result:
    return CliRunner().invoke(cli, [str(arg) for arg in args])


def good(*args: str) -> Result:
    result = run(*args)
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    return result


def command(*args: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "rrrobot", *args],
        capture_output=True,
        text=True,
        timeout=60,
    )


def strict_json(text: str) -> dict:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} in JSON")

    return json.loads(text, parse_constant=refuse)


def simulated(*args: str) -> dict:
    return strict_json(good("simulate", "--json", *args).stdout)


# Numbers


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.57", 1.57),
        ("-2", -2.0),
        ("+.5e-1", 0.05),
        ("pi", math.pi),
        ("-pi/2", -math.pi / 2),
        ("3*pi/4", 3 * math.pi / 4),
        ("3pi/4", 3 * math.pi / 4),
        (" 0.25 * pi ", math.pi / 4),
        ("1/3", 1 / 3),
    ],
)
def test_numbers(text: str, value: float) -> None:
    assert parse_number(text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["", "1e", "nan", "inf", "pi/0", "2**3", "pi*2", "1+1", "__import__('os')", "pipi"]
)
def test_not_numbers(text: str) -> None:
    with pytest.raises(ValueError, match=r"no number|zero"):
        parse_number(text)


# What simulate computes


def test_json_is_the_librarys_numbers() -> None:
    data = simulated("--gait", "circular", "--duration", "4")
    model = rr.FullModel(rr.Robot.from_parameters())
    t = rr.simulate(model, rr.gait("circular"), duration=4.0)
    settled = t.steady_state().to_dict()
    assert data["steady_state"] == settled
    assert data["no_steady_state_because"] is None
    assert data["end"]["position"] == t.position[-1].tolist()
    assert data["end"]["euler"] == t.euler[-1].tolist()
    assert data["energy"]["max"] == t.energy.max()
    assert data["normal_force"] == {"min": t.normal_force.min(), "max": t.normal_force.max()}
    assert data["required_friction"] == t.required_friction.max()
    assert data["slip"] == t.slip.max()
    assert data["lift_off_time"] is None
    assert data["samples"] == 401


def test_table_shows_the_same_numbers() -> None:
    args = ("--gait", "circular", "--duration", "4")
    data, text = simulated(*args), good("simulate", *args).stdout
    rows = dict(line.split("  ", 1) for line in text.replace("\n  ", "\n").splitlines())
    rows = {name.strip(): value.strip() for name, value in rows.items()}
    settled = data["steady_state"]
    assert rows["speed v"] == f"{1000 * settled['speed']:.4f} mm/s"
    assert float(rows["yaw rate"].split()[0]) == pytest.approx(settled["yaw_rate"], abs=1e-7)
    assert float(rows["curvature"].split()[0]) == pytest.approx(settled["curvature"], abs=1e-4)
    amplitude = float(rows["pitch"].split()[1])
    assert amplitude == pytest.approx(math.degrees(settled["amplitude"][1]), abs=1e-3)
    assert {"normal force", "friction needed", "largest slip", "energy"} <= set(rows)
    assert "LIFTS OFF" not in rows


@pytest.mark.parametrize(
    ("args", "gait"),
    [
        ((), rr.gait("lateral")),
        (("--gait", "circular", "--amplitude", "0.2"), rr.gait("circular", amplitude=0.2)),
        (
            ("--offset", "pi/2,1.2", "--frequency", "6", "--phase", "0,pi/3"),
            rr.SinusoidalGait(
                offset=(math.pi / 2, 1.2),
                amplitude=0.3,
                angular_frequency=6.0,
                phase=(0.0, math.pi / 3),
            ),
        ),
        (("--ramp", "2"), rr.RampIn(rr.gait("lateral"), 2.0)),
        (("--gait", "still"), rr.StillLegs((math.pi / 2,) * 2)),
        (("--gait", "still", "--offset", "1,2"), rr.StillLegs((1.0, 2.0))),
        (
            ("--torque", "0.01,0.02", "--offset", "1.2"),
            rr.LegTorques((0.01, 0.02), angle=(1.2, 1.2)),
        ),
        (("--torque", "0.01"), rr.LegTorques(0.01, angle=(math.pi / 2,) * 2)),
    ],
)
def test_gaits(args: tuple[str, ...], gait: rr.Gait | rr.LegTorques) -> None:
    assert simulated(*SHORT, *args)["gait"] == gait.to_dict()


@pytest.mark.parametrize("model", ["full", "pivoting", "roll", "pitch", "yaw", "decoupled"])
def test_models(model: str) -> None:
    data = simulated(*SHORT, "--model", model)
    assert data["model"]["type"] == model
    assert data["has_contact"] is (model not in ("pivoting", "yaw"))
    assert good("simulate", *SHORT, "--model", model).stdout.startswith("robot")


def test_start_damping_and_integrator() -> None:
    data = simulated(
        *SHORT,
        *("--start", "0.1,0,-0.2", "--euler", "0.1,0.2,pi/4", "--step", "0.01"),
        *("--damping", "0.01,0.02,0.03", "--damping-kind", "body"),
    )
    expected = rr.simulate(
        rr.FullModel(rr.Robot.from_parameters(), damping=rr.BodyRateDamping(0.01, 0.02, 0.03)),
        rr.gait("lateral"),
        0.5,
        start=(0.1, 0, -0.2),
        euler=(0.1, 0.2, math.pi / 4),
        step=0.01,
    )
    assert data["end"]["position"] == expected.position[-1].tolist()
    assert data["integration"]["step"] == 0.01
    assert simulated(*SHORT, "--damping", "0")["model"]["damping"]["roll"] == 0.0


def test_parameters_of_rrrobot() -> None:
    values = {"leg_mass": (0.06, 0.05), "leg_length": 0.09, "battery_mass": 0.2, "gravity": 1.62}
    values |= {"servo_mass": 0.04, "shell_radius": 0.11, "hip_offset": 0.1}
    args = [
        f"--{key.replace('_', '-')}={','.join(map(str, np.atleast_1d(value)))}"
        for key, value in values.items()
    ]
    data = simulated(*SHORT, *args, "--ground", "plane:0,0.1,1")
    robot = rr.Robot.from_parameters(rr.RRRobotParameters(**values))
    model = rr.FullModel(robot, ground=rr.Plane((0, 0.1, 1)))
    t = rr.simulate(model, rr.gait("lateral"), 0.5)
    assert data["end"]["position"] == t.position[-1].tolist()


def test_urdf_is_the_same_robot() -> None:
    urdf = ("--urdf", URDF, "--shell-radius", "0.12", "--damping", "0.01")
    default, read = simulated(*SHORT), simulated(*SHORT, *urdf, "--legs", "leg_1,leg_2")
    assert read["end"]["position"] == pytest.approx(default["end"]["position"], abs=1e-12)
    one = simulated(*SHORT, *urdf, "--legs", "leg_2", "--offset", "1")
    assert one["robot"]["legs"] == ["leg_2"]
    assert one["gait"]["phase"] == [0.0]
    moved = simulated(*SHORT, *urdf, "--shell-center", "0", "0", "0.01", "--shell-link", "shell")
    assert moved["end"]["position"] != read["end"]["position"]


def test_example_robot() -> None:
    pytest.importorskip("example_robot_data")
    args = ("--robot", "solo12", "--shell-radius", "0.25", "--legs", "FL_HFE,FR_HFE")
    data = simulated(*SHORT, *args)
    assert data["robot"]["legs"] == ["FL_HFE", "FR_HFE"]


def test_tables_are_the_trajectory_s(tmp_path: Path) -> None:
    names = {"--csv": "run.csv", "--mat": "run.mat", "--save": "run.npz"}
    args = [text for option, name in names.items() for text in (option, str(tmp_path / name))]
    good("simulate", *SHORT, *args)
    saved = rr.Trajectory.load(tmp_path / "run.npz")
    again = [saved.to_csv(tmp_path / "again.csv"), saved.to_mat(tmp_path / "again.mat")]
    assert again[0].read_bytes() == (tmp_path / "run.csv").read_bytes()
    ours, theirs = (loadmat(tmp_path / name)["euler"] for name in ("again.mat", "run.mat"))
    np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize(
    ("text", "normal"),
    [
        ("level", (0.0, 0.0, 1.0)),
        ("slope:30", (-0.5, 0.0, math.sqrt(0.75))),
        ("slope:-30", (0.5, 0.0, math.sqrt(0.75))),
        ("plane:0,5,12", (0.0, 5 / 13, 12 / 13)),
    ],
)
def test_grounds(text: str, normal: tuple[float, ...]) -> None:
    data = simulated(*SHORT, "--damping-kind", "body", "--ground", text)
    assert data["model"]["ground"]["normal"] == pytest.approx(normal, abs=1e-15)


def test_rocks() -> None:
    for text, radius in (("boulder:0.5", 0.5), ("bowl:0.8", -0.8)):
        data = simulated(*SHORT, "--ground", text)
        assert data["model"]["ground"]["radius"] == radius
        model = rr.FullModel(rr.Robot.from_parameters(), ground=rr.Boulder(radius))
        t = rr.simulate(model, rr.gait("lateral"), 0.5)
        assert data["end"]["position"] == t.position[-1].tolist()


def test_a_grid_of_heights(tmp_path: Path) -> None:
    heights = ["0," + ",".join(f"{0.2 * j - 1:.1f}" for j in range(11))]
    heights += [f"{0.2 * i - 1:.1f}" + f",{0.02 * i}" * 11 for i in range(11)]
    (tmp_path / "hill.csv").write_text("\n".join(heights))
    # Heights that rise evenly are a slope.
    data = simulated(*SHORT, "--ground", f"grid:{tmp_path / 'hill.csv'}")
    model = rr.FullModel(rr.Robot.from_parameters(), ground=rr.Plane((-0.1, 0, 1)))
    wanted = rr.simulate(model, rr.gait("lateral"), 0.5).euler[-1]
    assert data["end"]["euler"] == pytest.approx(wanted, abs=1e-9)
    result = run("simulate", *SHORT, "--ground", f"grid:{tmp_path / 'none.csv'}")
    assert result.exit_code == 1 and "none.csv" in result.output


def test_a_kind_of_damping_needs_its_size_on_other_robots() -> None:
    urdf = ("--urdf", URDF, "--shell-radius", "0.12")
    result = run("simulate", *SHORT, *urdf, "--damping-kind", "body")
    assert result.exit_code == 2 and "--damping-kind needs --damping" in result.output


@pytest.mark.parametrize(
    "text", ["moon", "slope", "slope:90", "slope:x", "plane:1,2", "level:1", "grid"]
)
def test_no_grounds(text: str) -> None:
    result = run("simulate", "--ground", text)
    assert result.exit_code == 2
    assert "Invalid value for '--ground'" in result.output


def test_a_gait_s_file_is_the_gait(tmp_path: Path) -> None:
    path = str(tmp_path / "mine.json")
    args = ("--gait", "circular", "--amplitude", "0.2", "--ramp", "0.3")
    good("gait", *args, "--out", path)
    assert simulated(*SHORT, "--gait", path)["gait"] == simulated(*SHORT, *args)["gait"]
    assert strict_json(good("compare", "--json", "--duration", "4", "--gait", path).stdout)[
        "models"
    ]
    film = tmp_path / "mine.html"
    good("view", "--gait", path, "--duration", "0.5", "--html", str(film))
    assert film.stat().st_size > 100_000


def test_set_points(tmp_path: Path) -> None:
    table, message = str(tmp_path / "joints.csv"), str(tmp_path / "joints.yaml")
    data = strict_json(good("gait", "--json", "--rate", "100", "--out", table).stdout)
    read = np.loadtxt(table, delimiter=",", skiprows=1)
    assert len(read) == data["set_points"]
    np.testing.assert_array_equal(read[:, 1:3], rr.gait("lateral")(read[:, 0]).angle)
    good("gait", "--gait", "still", "--duration", "1", "--out", message)
    assert Path(message).read_text().count("time_from_start") == 51


def test_a_recorded_gait_is_splined(tmp_path: Path) -> None:
    path = tmp_path / "recorded.csv"
    gait = rr.gait("circular")
    time = np.linspace(0.0, gait.period or 0.0, 81)
    np.savetxt(path, np.column_stack((time, gait(time).angle)), delimiter=",", fmt="%.17g")
    end = simulated(*SHORT, "--gait", str(path))["end"]["euler"]
    assert end == pytest.approx(simulated(*SHORT, "--gait", "circular")["end"]["euler"], abs=1e-5)
    np.savetxt(path, np.column_stack((time, gait(time).angle))[:-1], delimiter=",")
    assert_refused(run("simulate", "--gait", str(path)), "closes the cycle")


def test_a_file_s_gait_takes_no_numbers_beside_it(tmp_path: Path) -> None:
    result = run("simulate", "--gait", str(tmp_path / "a.json"), "--amplitude", "1")
    assert result.exit_code == 2 and "--amplitude" in result.output
    assert run("simulate", "--gait", "trot").exit_code == 2
    assert_refused(run("simulate", "--gait", str(tmp_path / "a.json")), "cannot read the gait")


def test_no_steady_state_says_why() -> None:
    short = simulated("--duration", "1")
    assert short["steady_state"] is None
    assert "cycles" in short["no_steady_state_because"]
    still = good("simulate", *SHORT, "--gait", "still").stdout
    assert "no steady state" in still
    assert "no period" in still
    # Cycles are counted after the ramp.
    ramped = simulated("--duration", "6", "--ramp", "3.5")
    assert ramped["steady_state"]["after"] >= 3.5


def test_lift_off_is_said_and_json_has_no_infinity() -> None:
    args = ("--amplitude", "2", "--frequency", "15", "--duration", "0.6")
    data = simulated(*args)
    assert data["lift_off_time"] > 0
    assert data["required_friction"] is None
    text = good("simulate", *args).stdout
    assert "LIFTS OFF" in text
    assert "none would do" in text


# Files


def test_every_output(tmp_path: Path) -> None:
    names = {"--save": "run.npz", "--html": "run.html", "--plot": "run.png"}
    args = [text for option, name in names.items() for text in (option, str(tmp_path / name))]
    data = simulated("--duration", "2", *args)
    assert {Path(name).name for name in data["files"]} == set(names.values())
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    assert "<html" in (tmp_path / "run.html").read_text("utf-8").lower()
    saved = rr.Trajectory.load(tmp_path / "run.npz")
    assert saved.position[-1].tolist() == data["end"]["position"]


@pytest.mark.parametrize(("suffix", "start"), [("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_vector_plots(tmp_path: Path, suffix: str, start: bytes) -> None:
    path = tmp_path / f"run.{suffix}"
    assert f"wrote {path}" in good("simulate", *SHORT, "--plot", str(path)).stdout
    assert path.read_bytes().startswith(start)


@pytest.mark.parametrize(
    ("option", "name"),
    [
        ("--save", "nowhere/run.npz"),
        ("--plot", "nowhere/run.png"),
        ("--html", "nowhere/run.html"),
        ("--save", "run.txt"),
        ("--plot", "run.gif"),
        ("--html", "run"),
        ("--save", "folder.npz"),
    ],
)
def test_outputs_are_checked_before_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, option: str, name: str
) -> None:
    (tmp_path / "folder.npz").mkdir()
    monkeypatch.setattr(cli_simulate, "run_model", lambda *_, **__: pytest.fail("it simulated"))
    assert_refused(run("simulate", option, str(tmp_path / name)), "cannot write")


# Bad input


def assert_refused(result: Result, says: str, code: int = 1) -> None:
    """One line that says so, on stderr only."""
    assert result.exit_code == code, result.output
    assert isinstance(result.exception, SystemExit)
    assert result.stdout == ""
    assert says in result.stderr
    assert result.stderr.startswith("Error: ")
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (("--leg-mass=-1",), "--leg-mass is -1.0 kg"),
        (("--shell-radius", "0"), "--shell-radius is"),
        (("--leg-mass", "1,2,3"), "--leg-mass has 3 entries"),
        (("--urdf", "nowhere.urdf", "--shell-radius", "1"), "there is no URDF file"),
        (("--urdf", URDF, "--shell-radius=-1"), "radius"),
        (("--urdf", URDF, "--shell-radius", "0.12", "--legs", "arm"), "no movable joint 'arm'"),
        (("--urdf", URDF, "--shell-radius", "0.12", "--shell-link", "leg"), "no link 'leg'"),
        (("--offset", "1,2,3"), "it must hold 2 numbers"),
        (("--amplitude", "1e999"), "finite"),
        (("--frequency", "0"), "greater than zero"),
        (("--torque", "1,2,3"), "it must hold 2 numbers"),
        (("--step", "0"), "step is 0.0 s"),
        (("--step=-0.1",), "step is -0.1 s"),
        (("--duration", "0"), "duration is 0.0 s"),
        (("--duration=-3",), "duration is -3.0 s"),
        (("--sample-interval", "0"), "--sample-interval is 0.0 s"),
        (("--sample-interval", "1e-12"), "samples"),
        (("--rtol", "0"), "rtol"),
        (("--ramp", "0"), "--ramp is 0.0 s"),
        (("--damping=-1",), "at least zero"),
        (("--ground", "plane:0,0,-1"), "it must point up"),
        (("--model", "yaw", "--euler", "0.1,0,0"), "locks roll"),
    ],
)
def test_bad_input_is_one_line(args: tuple[str, ...], says: str) -> None:
    assert_refused(run("simulate", *args), says)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "no xml",
        "<robot><link></robot>",
        "<robot name='a'><link name='b'/></robot>",
        "<!DOCTYPE x [<!ENTITY y 'z'>]><robot name='a'><link name='b'/></robot>",
    ],
)
def test_malformed_urdf_is_one_line(tmp_path: Path, text: str) -> None:
    path = tmp_path / "bad.urdf"
    path.write_text(text)
    args = ("simulate", "--urdf", str(path), "--shell-radius", "0.1", "--offset", "1")
    assert_refused(run(*args), "")
    result = command(*args)  # Pinocchio's C++ may print or stop the process.
    assert result.returncode == 1
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (("--offset", "__import__('os')"), "is no number"),
        (("--euler", "1,2"), "give 3"),
        (("--start", "fast"), "impulsive, rest"),
        (("--gait", "gallop"), "gallop"),
        (("--urdf", URDF), "--shell-radius is missing"),
        (("--urdf", URDF, "--robot", "solo12"), "not both"),
        (("--urdf", URDF, "--shell-radius", "1", "--leg-mass", "1"), "--leg-mass"),
        (("--legs", "leg_1"), "--legs"),
        (("--torque", "1", "--gait", "lateral"), "--gait"),
        (("--gait", "still", "--amplitude", "1"), "--amplitude"),
        (("--step", "0.1", "--rtol", "1e-3"), "give one"),
        (("--model", "decoupled", "--torque", "1"), "needs a gait"),
        (("--model", "decoupled", "--start", "rest"), "--start"),
    ],
)
def test_wrong_usage_exits_2(args: tuple[str, ...], says: str) -> None:
    result = run("simulate", *SHORT, *args)
    assert result.exit_code == 2
    assert says in result.stderr
    assert result.stdout == ""


def test_warnings_are_one_line() -> None:
    result = run("simulate", *SHORT, "--leg-length", "0.2", "--json")
    assert result.exit_code == 0
    assert result.stderr.startswith("Warning: --leg-length is 0.2 m")
    assert result.stderr.count("\n") == 1
    strict_json(result.stdout)


# Runs that stop early


@pytest.mark.parametrize("args", [("--start", "0,30,0"), ("--amplitude", "2.5,2", "--phase", "0")])
def test_a_run_that_stops_is_saved(tmp_path: Path, args: tuple[str, ...]) -> None:
    path = tmp_path / "part.npz"
    result = run("simulate", *args, "--save", str(path))
    assert_refused(result, "the pitch reached +-90 degrees")
    assert f"samples up to then are in {path}." in result.stderr
    assert "--damping-kind body" in result.stderr
    assert ".trajectory" not in result.stderr
    part = rr.Trajectory.load(path)
    assert 0 < len(part) < 3001
    assert np.abs(part.euler[:, 1]).max() < math.pi / 2


def test_a_run_that_stops_tells_of_save() -> None:
    assert_refused(run("simulate", "--start", "0,30,0"), "With --save FILE")


def test_interrupt_keeps_what_was_computed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def press_ctrl_c(time: float, part: str = "") -> None:
        if time > 0.5:
            raise KeyboardInterrupt

    @contextmanager
    def bar(*_: object, **__: object) -> Iterator[object]:
        yield press_ctrl_c

    monkeypatch.setattr("rrrobot.simulation.flow.progress_of", bar)
    path = tmp_path / "part.npz"
    result = run("simulate", "--save", str(path))
    assert result.exit_code == 130
    assert result.stdout == ""
    assert result.stderr.startswith("Interrupted: ")
    assert result.stderr.count("\n") == 1
    assert str(path) in result.stderr
    assert 0.4 < rr.Trajectory.load(path).time[-1] < 1.0


def test_interrupt_elsewhere_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def press_ctrl_c(_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli_simulate, "summary", press_ctrl_c)
    result = run("simulate", *SHORT)
    assert (result.exit_code, result.stderr) == (130, "Interrupted: stopped.\n")


# view and robots


def test_view_writes_a_film_of_a_saved_run(tmp_path: Path) -> None:
    saved, film = tmp_path / "run.npz", tmp_path / "run.html"
    good("simulate", *SHORT, "--save", str(saved))
    assert good("view", str(saved), "--html", str(film), "--speed", "0.5").stdout == (
        f"wrote {film}\n"
    )
    assert "<html" in film.read_text("utf-8").lower()
    assert_refused(run("view", str(tmp_path / "none.npz")), "there is no file")
    assert_refused(run("view", str(film), "--no-browser"), "not a trajectory")
    assert_refused(run("view", str(saved), "--html", str(tmp_path / "x.png")), "cannot write")
    assert_refused(run("view", "--duration", "0"), "duration is 0.0 s")


def test_view_serves_the_film(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page that is served is the film's, as long as the command runs."""
    from rrrobot.cli import view

    served: list[str] = []
    opened: list[str] = []

    def wait() -> None:
        with urllib.request.urlopen(opened[0], timeout=10) as page:
            served.append(page.read().decode())
        raise KeyboardInterrupt

    monkeypatch.setattr(
        view, "threading", SimpleNamespace(Event=lambda: SimpleNamespace(wait=wait))
    )
    monkeypatch.setattr(view.webbrowser, "open", opened.append)
    result = run("view", "--gait", "circular", "--duration", "0.2", "--speed", "2", "--quiet")
    assert result.exit_code == 0, result.output
    assert opened == [result.stdout.split()[0]] and result.stderr == "closed\n"
    (page,) = served
    assert '"speed": 2.0' in page and '"loop": false' in page
    assert page.count("<polyline") == 3 + 2 + 2  # roll, pitch, yaw, two angles, two torques


def test_view_serves_until_ctrl_c() -> None:
    args = [sys.executable, "-m", "rrrobot", "view", "--duration", "0.2", "--no-browser"]
    with subprocess.Popen(
        args, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        url = process.stdout.readline().split()[0]
        try:
            assert url.startswith("http://127.0.0.1:")
            with urllib.request.urlopen(url, timeout=10) as page:
                assert b"<html" in page.read().lower()
        finally:
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=30)
    assert process.returncode == 0
    assert errors == "closed\n"


def test_robots() -> None:
    pytest.importorskip("example_robot_data")
    data = json.loads(good("robots", "--json").stdout)
    assert data[0]["name"] == "rrrobot"
    names = [robot["name"] for robot in data if robot["source"] == "example-robot-data"]
    assert names == list(rr.robot.example_robots())
    tried = {robot["name"] for robot in data if robot.get("unstick")}
    assert {"solo12", "legged:6"} <= tried and "baxter" not in tried
    assert "solo12" in good("robots").stdout


def test_robots_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> None:
        raise rr.MissingExtraError("example robots need the extra 'robots'.")

    monkeypatch.setattr("rrrobot.cli.robots.example_robots", missing)
    result = run("robots")
    assert result.exit_code == 0
    first, *others = result.stdout.splitlines()
    assert first.split(maxsplit=1) == ["rrrobot", "built in: Table 2 of the paper"]
    assert others and all(line.startswith("* legged:") for line in others)
    assert "extra 'robots'" in result.stderr


# As a command


@pytest.mark.parametrize("name", cli.list_commands(click.Context(cli)))
def test_help_has_an_example(name: str) -> None:
    assert f"  rrrobot {name}" in good(name, "--help").stdout
    assert name in good("--help").stdout


def test_version() -> None:
    result = command("--version")
    assert result.returncode == 0
    assert result.stdout.startswith("rrrobot, version ")


def test_light_to_start() -> None:
    heavy = "{'matplotlib', 'meshcat', 'scipy.integrate', 'example_robot_data', 'tqdm'}"
    check = f"import sys, rrrobot.cli; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, timeout=60)
    assert done.stdout == "[]\n"


def test_command_prints_json_and_nothing_else() -> None:
    result = command("simulate", "--json", *SHORT)
    assert result.returncode == 0
    assert result.stderr == ""
    assert strict_json(result.stdout)["samples"] == 51


def test_command_fails_in_one_line() -> None:
    result = command("simulate", "--leg-mass=-1")
    assert (result.returncode, result.stdout) == (1, "")
    assert (
        result.stderr == "Error: --leg-mass is -1.0 kg: it must be greater than zero and finite.\n"
    )


def test_reader_that_goes_away() -> None:
    args = [sys.executable, "-m", "rrrobot", "simulate", *SHORT]
    with subprocess.Popen(args, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        errors = process.stderr.read()
        process.wait(timeout=30)
    assert errors == b""


# Whatever ends the command


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
@pytest.mark.parametrize(
    "args", [("simulate", *SHORT), ("simulate", *SHORT, "--json"), ("--help",)]
)
def test_a_full_standard_output_is_one_line(args: tuple[str, ...]) -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "rrrobot", *args],
            stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr == "Error: cannot write standard output: No space left on device.\n"


@pytest.mark.parametrize(
    ("args", "module"),
    [([], "rrrobot.cli.sweep"), (["simulate"], "rrrobot.simulation.run"), (["-h"], "click")],
)
def test_ctrl_c_while_it_starts_is_one_line(args: list[str], module: str) -> None:
    """An interrupt in the middle of the imports, wherever that is."""
    code = (
        "import sys, signal, os\n"
        "class Stop:\n"
        "    def find_spec(self, name, *_):\n"
        f"        if name == {module!r}: os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Stop())\n"
        "from rrrobot.__main__ import main\n"
        "main()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *args], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "Interrupted: stopped.\n")


def test_an_error_that_nobody_expected_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    code = (
        "import rrrobot.cli.main as m\n"
        "def broken(*_, **__): raise ZeroDivisionError('x ' * 9000)\n"
        "m.cli = broken\nfrom rrrobot.__main__ import main\nmain()\n"
    )
    for asked, lines in (("", 1), ("1", 5)):
        monkeypatch.setenv("RRROBOT_TRACEBACK", asked)
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=False
        )
        assert done.returncode == 1
        assert len(done.stderr.splitlines()) >= lines
        assert asked or (done.stderr.startswith("Error: ZeroDivisionError") and lines == 1)
        assert asked or len(done.stderr) < 500


def test_output_that_the_terminal_cannot_show_is_escaped(tmp_path: Path) -> None:
    path = tmp_path / "\u0142\u00f3d\u017a.npz"
    done = subprocess.run(
        [sys.executable, "-m", "rrrobot", "simulate", *SHORT, "--save", str(path)],
        capture_output=True, check=False, env=os.environ | {"PYTHONIOENCODING": "latin-1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert rb"\u0142" + b"\xf3d" + rb"\u017a.npz" in done.stdout
    assert path.exists()


def test_messages_are_of_a_length_that_is_read(tmp_path: Path) -> None:
    long = "x" * 10_000
    for error in (rr.ParameterError(long), rr.OutputError(long), rr.GaitError(f"{long} end")):
        assert len(str(error)) <= 2000
    assert str(rr.GaitError(f"start {long} end")).endswith("end")
    result = CliRunner().invoke(cli, ["view", f"{long}.npz"])
    assert result.exit_code == 1
    assert len(result.output.splitlines()) == 1
    assert len(result.output) < 2100
