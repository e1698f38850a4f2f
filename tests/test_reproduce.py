"""`rrrobot reproduce`: items, report, resuming, and numbers against independent ones."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.backends.backend_agg import FigureCanvasAgg

import rrrobot as rr
from rrrobot.cli.main import cli
from rrrobot.paper import figures as paper
from rrrobot.paper import run
from rrrobot.paper.item import (
    AGREES,
    DIFFERS,
    ERRATUM,
    INPUT,
    OPEN,
    Item,
    Result,
    about,
    above,
    below,
    feature,
    number,
    taken,
)
from rrrobot.paper.run import ITEMS, Reproduction, reproduce
from rrrobot.paper.schematic import mass_points, schematic
from rrrobot.paper.unicycle import unicycle_path
from rrrobot.paper.workshop import Workshop

pytestmark = pytest.mark.usefixtures("compiled_engine")

PAPER_ITEMS = [f"table{i}" for i in range(1, 5)] + [f"fig{i}" for i in range(1, 23)]
ERRATA = [item.key for item in ITEMS if item.key.startswith(("erratum", "open"))]
LONG = {"table4", "fig2", "fig3", "fig6", "fig7", "fig15", "fig16", "fig17", "fig18", "open-start"}
LONG |= {"fig11", "fig12", "fig14", "fig19", "fig20", "fig22", "erratum-eq5", "open-cycles"}
"""Items that take seconds."""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Reproduction:
    short = [key for key in PAPER_ITEMS + ERRATA if key not in LONG]
    return reproduce(tmp_path_factory.mktemp("paper"), only=short, quick=True)


@pytest.fixture(scope="module")
def made_whole(tmp_path_factory: pytest.TempPathFactory) -> Reproduction:
    return reproduce(tmp_path_factory.mktemp("paper"), only=PAPER_ITEMS + ERRATA, quick=True)


@pytest.mark.slow
def test_every_table_and_figure_of_the_paper_is_there() -> None:
    assert [item.key for item in ITEMS][: len(PAPER_ITEMS)] == PAPER_ITEMS
    assert len({item.key for item in ITEMS}) == len(ITEMS)


@pytest.mark.slow
def test_every_figure_has_a_picture_and_numbers(made_whole: Reproduction) -> None:
    for section in made_whole.sections:
        assert section.rows, section.key
        if section.key.startswith("fig"):
            assert section.files == [f"{section.key}.png"]
            content = (made_whole.report.parent / section.files[0]).read_bytes()
            assert content.startswith(b"\x89PNG") and len(content) > 10_000


def hold_every_number(made: Reproduction) -> None:
    texts = [(made.report.parent / name).read_text() for name in ("report.html", "report.md")]
    for section in made.sections:
        for text in texts:
            assert f"rrrobot reproduce --only {section.key}" in text
            assert text.count(f'id="{section.key}"') == 1
    figures = sum(section.key.startswith("fig") for section in made.sections)
    assert texts[0].count("<img") == texts[1].count("![") == figures > 5
    assert (
        texts[1].count("| erratum |")
        == sum(row["verdict"] == ERRATUM for s in made.sections for row in s.rows) + 2
    )  # two headings
    assert all("nan" not in re.sub("<style>.*</style>", "", t, flags=re.S).lower() for t in texts)


def test_the_reports_hold_every_number(made: Reproduction) -> None:
    hold_every_number(made)


@pytest.mark.slow
def test_the_whole_reports_hold_every_number(made_whole: Reproduction) -> None:
    assert len(made_whole.sections) == len(PAPER_ITEMS) + len(ERRATA)
    hold_every_number(made_whole)


def sorted_out(*cases: tuple) -> list:
    """Cases of items; those of long ones are slow."""
    return [
        pytest.param(*case, marks=[pytest.mark.slow] if case[0] in LONG else []) for case in cases
    ]


@pytest.fixture
def row(request: pytest.FixtureRequest) -> Callable[[str, str], dict]:
    """The row of an item; the whole paper is made where the item is a long one."""

    def find(key: str, quantity: str) -> dict:
        made = request.getfixturevalue("made_whole" if key in LONG else "made")
        (found,) = (r for s in made.sections if s.key == key for r in s.rows
                    if r["quantity"] == quantity)  # fmt: skip
        return found

    return find


@pytest.mark.parametrize(
    ("key", "quantity", "expected", "rel"),
    sorted_out(
        # physics.md: Kane's equations of point masses.
        ("fig6", "full model, speed", 9.656, 1e-4),
        ("fig6", "pivoting model, speed", 9.74, 5e-4),
        ("fig7", "full model, yaw rate", 0.0208546, 1e-5),
        ("fig7", "pivoting model, yaw rate", 0.1978, 5e-4),
        ("fig16", "net yaw in a cycle, single-axis over full", 0.01355 / 0.0208546, 5e-4),
        ("table3", "rolling, roll", 1.29251, 1e-5),
        ("table3", "pivoting, pitch", 0.94509, 1e-5),
        (
            "fig13",
            "trajectory A: size of the net yaw in a cycle, by area",
            np.rad2deg(0.0129962291),
            1e-8,
        ),
        ("fig18", "peak speed", 9.656, 1e-3),
        ("erratum-eq12", "with b: difference from Pinocchio", 0.0, 0.0),
    ),
)
def test_numbers(row: Callable, key: str, quantity: str, expected: float, rel: float) -> None:
    assert row(key, quantity)["ours"] == pytest.approx(expected, rel=rel, abs=1e-15)


@pytest.mark.parametrize(
    ("key", "quantity", "verdict"),
    sorted_out(
        ("table3", "pivoting, pitch", ERRATUM),
        ("table4", "pivoting model, speed over the full model's, lateral gait", AGREES),
        ("table4", "single-axis models, speed over the full model's, lateral gait", DIFFERS),
        ("fig12", "yaw model: amplitude at offset pi/2 over that at pi/4", AGREES),
        ("fig15", "yaw phase, single-axis less full", DIFFERS),
        ("erratum-eq5", "the same, corrected", AGREES),
    ),
)
def test_verdicts(row: Callable, key: str, quantity: str, verdict: str) -> None:
    assert row(key, quantity)["verdict"] == verdict


@pytest.mark.slow
def test_the_slip_of_equation_5_is_measured(row: Callable) -> None:
    slip = row("erratum-eq5", "velocity along y that eq (5) leaves, as printed")["ours"]
    # r |cos pitch - cos roll| |roll rate| of the circular gait, from its own angles.
    t = rr.simulate(rr.FullModel(rr.Robot.from_parameters()), rr.gait("circular"), 30.0)
    roll, pitch, yaw = t.euler.T
    expected = 0.12 * (np.cos(roll) - np.cos(pitch)) * np.cos(yaw) * t.euler_rates[:, 0]
    assert slip == pytest.approx(np.abs(expected).max(), rel=1e-3)


def test_a_second_run_keeps_what_is_finished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[tuple[float, float]] = []
    first = reproduce(tmp_path, only=["table2", "fig1"], progress=lambda *now: told.append(now))
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir() if p.is_file()}
    (tmp_path / "fig1.png").unlink()
    again = reproduce(tmp_path, only=["table2", "fig1"], progress=lambda *now: told.append(now))
    assert told == [(0, 2), (1, 2), (2, 2), (0, 1), (1, 1)] and again.kept == ["table2"]
    assert again.sections == first.sections
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir() if p.is_file()} == before
    # Other grids are another run: coarse ones do not replace fine ones, fine ones do coarse.
    with pytest.raises(rr.OutputError, match="holds a full run"):
        reproduce(tmp_path, only=["table2"], quick=True)
    other = tmp_path / "other"
    reproduce(other, only="table2", quick=True)
    assert reproduce(other, only="table2").kept == []
    monkeypatch.setattr(run, "_fingerprint", lambda quick: "other code")
    assert reproduce(tmp_path, only=["table2"]).kept == []


def test_an_interrupted_run_keeps_its_items(tmp_path: Path) -> None:
    def stop(done: float, total: float) -> None:
        if done == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match="1 of 2 items"):
        reproduce(tmp_path, only=["table2", "fig1"], progress=stop)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["report.html", "report.md", "table2.json"]
    assert reproduce(tmp_path, only=["table2", "fig1"]).kept == ["table2"]


def test_a_damaged_file_is_made_anew(tmp_path: Path) -> None:
    reproduce(tmp_path, only=["table2"])
    for damage in ("", "[]", "{}", '{"made_by": 3}'):
        (tmp_path / "table2.json").write_text(damage)
        assert reproduce(tmp_path, only=["table2"]).kept == []


@pytest.mark.parametrize("only", [["fig23"], []])
def test_unknown_keys_are_refused(tmp_path: Path, only: list[str]) -> None:
    with pytest.raises(rr.ParameterError, match=r"--list.*table1 to fig22"):
        reproduce(tmp_path, only=only)


@pytest.mark.slow
def test_verdicts_follow_the_numbers() -> None:
    assert number("x", 1.0, 1.004, within=0.005).verdict == AGREES
    assert number("x", 1.0, 1.006, within=0.005).verdict == DIFFERS
    assert number("x", 1.0, float("nan"), within=1).verdict == DIFFERS
    assert number("x", 2.0, 1.0, within=0.1).ratio == 0.5
    cases = ((below(2), AGREES, "< 2"), (above(2), DIFFERS, "> 2"),
             (about(1, 0.25), AGREES, "1 ± 0.25"))  # fmt: skip
    for limit, verdict, text in cases:
        row = feature("x", "so", 1.0, limit=limit)
        assert (row.verdict, row.limit) == (verdict, text)
    assert feature("x", "so", float("nan"), limit=below(2)).verdict == DIFFERS
    # What is taken from the paper is no agreement, and may not have drifted from it.
    assert taken("x", 2.0, 2.0).verdict == INPUT
    with pytest.raises(rr.RRRobotError, match=r"x is 2\.1"):
        taken("x", 2.0, 2.1)


@pytest.mark.slow
def test_every_verdict_has_its_limit(made_whole: Reproduction) -> None:
    judged = [
        row for s in made_whole.sections for row in s.rows if row["verdict"] in (AGREES, DIFFERS)
    ]
    assert len(judged) > 50
    assert all(row["limit"] for row in judged)
    assert {row["verdict"] for s in made_whole.sections if s.key == "table2" for row in s.rows} == {
        INPUT,
        OPEN,
    }


def test_an_infinite_number_is_refused(tmp_path: Path) -> None:
    rows = (number("x", 1.0, float("nan"), within=1),)
    bad = Item(key="bad", title="", shows="", make=lambda shop: Result(rows=rows))
    with pytest.raises(rr.RRRobotError, match="bad"):
        run._make(bad, Workshop(quick=True), tmp_path, "mark")
    assert not list(tmp_path.iterdir())


def test_command(tmp_path: Path) -> None:
    out = str(tmp_path / "out")
    result = CliRunner().invoke(cli, ["reproduce", "--out", out, "--only", "Table2, fig9"])
    assert result.exit_code == 0, result.output
    assert "leg mass M_l: 0.057 kg (paper: 0.057), input" in result.output
    assert result.output.strip().endswith("report.html")
    result = CliRunner().invoke(cli, ["reproduce", "--out", out, "--only", "fig9", "--json"])
    assert json.loads(result.stdout)["sections"][0]["rows"][0]["verdict"] == AGREES
    result = CliRunner().invoke(cli, ["reproduce", "--list"])
    assert result.output.split()[0] == "table1" and len(result.output.splitlines()) == len(ITEMS)
    result = CliRunner().invoke(cli, ["reproduce", "--only", "fig99"])
    assert result.exit_code == 1 and "Did you mean fig9 or fig19?" in result.output
    (tmp_path / "file").write_text("")
    result = CliRunner().invoke(
        cli, ["reproduce", "--out", str(tmp_path / "file"), "--only", "fig9"]
    )
    assert result.exit_code == 1 and "cannot make the folder" in result.output


def test_figures_take_another_robot() -> None:
    other = rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=0.08, leg_length=0.09))
    shop = Workshop(quick=True, robot=other)
    assert paper.fig_1(other).axes[0].get_xlabel().startswith("y [m]\nC: battery")
    assert len(paper.fig_18(shop.plane("full")).axes) == 6
    at = shop.plane("full").sel(offset=np.pi / 2, phase_difference=np.pi / 2, method="nearest")
    run = rr.simulate(shop.full, rr.gait("lateral"), 30.0, method="momentum")
    assert float(at.speed) == pytest.approx(run.steady_state().speed, rel=1e-5)


def test_mass_points_of_rrrobot() -> None:
    robot = rr.Robot.from_parameters()
    model = rr.FullModel(robot)
    q = model.configuration(model.make_pose(np.array((0.1, 0.2, 0.3)), np.zeros(2)), [0.9, 1.3])
    points = mass_points(robot, q)
    assert sum(p.mass for p in points) == pytest.approx(robot.mass, abs=1e-15)
    import pinocchio as pin

    center = pin.centerOfMass(robot.model, robot.model.createData(), q)
    found = sum(p.mass * p.position for p in points) / robot.mass
    np.testing.assert_allclose(found, center, atol=1e-15)


def test_the_outline_touches_the_ground_at_the_contact() -> None:
    robot = rr.Robot.from_urdf(rr.urdf_path(), shell=rr.Ellipsoid((0.2, 0.13, 0.12)))
    ax = schematic(robot, "side", leg_angle=1.0, euler=(0, 0.4, 0))
    outline = ax.lines[0].get_xydata()
    assert outline[:, 1].min() == pytest.approx(0.0, abs=1e-4)
    with pytest.raises(rr.ParameterError, match="side, front, top"):
        schematic(robot, "left")


@pytest.mark.slow
def test_a_unicycle_follows_itself() -> None:
    """The path of a known unicycle, without oscillation: no error and no side slip."""
    robot = rr.Robot.from_parameters()
    t = rr.simulate(rr.FullModel(robot), rr.gait("circular"), 20.0)
    v, alpha = -0.02, 0.1
    yaw = 0.3 + alpha * t.time
    position = v / alpha * np.column_stack((np.cos(yaw), np.sin(yaw)))
    euler = np.column_stack((0 * yaw, 0 * yaw, yaw))
    from dataclasses import replace

    found = unicycle_path(replace(t, position=position, euler=euler))
    assert found.length == pytest.approx(abs(v) * (found.time[-1] - found.time[0]), rel=1e-3)
    assert found.error < 1e-3 * found.length and abs(found.side_slip) < 1e-3


def test_open_rows_have_no_ratio(made: Reproduction) -> None:
    open_rows = [row for s in made.sections for row in s.rows if row["verdict"] == OPEN]
    assert open_rows and all(row["ratio"] is None for row in open_rows)


@pytest.mark.parametrize("name", ["fig_1", "fig_3", "fig_8", "fig_9", "fig_10"])
def test_nothing_of_a_drawing_is_outside_what_is_saved(name: str) -> None:
    figure = getattr(paper, name)(rr.Robot.from_parameters())
    FigureCanvasAgg(figure).draw()
    frame = figure.bbox.padded(1.0)
    for ax in figure.axes:
        written = (ax.title, ax.xaxis.label, ax.yaxis.label, *ax.texts)
        for text in (text for text in written if text.get_text()):
            box = text.get_window_extent()
            assert frame.contains(box.x0, box.y0), text.get_text()
            assert frame.contains(box.x1, box.y1), text.get_text()
