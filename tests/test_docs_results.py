"""Pages that are written from results say what the results say."""

import json
from pathlib import Path

import numpy as np
import pytest

import rrrobot as rr
from benchmarks import report_steering, robots
from tests.test_docs import said

DOCS = Path(__file__).parent.parent / "docs"
MODELS = {"pivoting": "pivoting", "single-axis": "decoupled", "modulated": "modulated"}


def numbers(page: str, sentence: str) -> tuple[float, ...]:
    """Those of the one place of a page that matches."""
    return tuple(map(float, said(page, sentence)))


def half(cell: str) -> float:
    """Half a unit of a number's last digit."""
    return 0.51 * 10.0 ** -len(cell.partition(".")[2])


def cells(page: str) -> list[list[str]]:
    """Rows of a page's tables."""
    lines = (DOCS / page).read_text().splitlines()
    return [[c.strip(" *") for c in line.split("|")[1:-1]] for line in lines if line[:1] == "|"]


def test_the_steering_study_is_of_its_results():
    assert (DOCS / "steering_study.md").read_text() == report_steering.page()


def test_the_table_of_robots_is_of_its_results():
    results = json.loads(robots.RESULTS.read_text())
    page = (DOCS / "robots.md").read_text()
    assert robots.table(results) in page and robots.reasons(results) in page
    assert {row["budget"] for row in results.values() if "budget" in row} == {robots.BUDGET}
    assert [int(n) for n in said("robots.md", r"(\d+) gaits a goal, (\d+) postures")] == [
        robots.BUDGET, robots.POSTURES,
    ]  # fmt: skip
    assert numbers("robots.md", r"within friction ([\d.]+)") == (rr.escape.EscapeLimits().friction,)


def test_what_parts_the_ideal_from_mujoco_is_of_its_table():
    rows = [row for row in cells("ideal.md") if row[0] not in ("robot", "---")]
    stiff = [row for row in rows if row[2] == "these, and a stiff contact"]
    turn = max(abs(float(row[5]) - float(row[6])) for row in stiff)
    assert numbers("ideal.md", r"at most ([\d.]+) mm apart, the turns (\d+)") == (
        max(float(row[7]) for row in stiff), round(turn),
    )  # fmt: skip
    (friction,) = numbers("ideal.md", r"less than ([\d.]+) everywhere")
    assert friction - 0.02 <= max(float(row[1]) for row in rows) <= friction


@pytest.mark.slow
def test_table_4_of_the_page_is_what_comes_out():
    robot, at = rr.Robot.from_parameters(), np.deg2rad
    plane = rr.paper.table_4(
        robot, offsets=at(np.arange(0, 91, 15)), phase_differences=at(np.arange(30, 331, 30))
    )
    rows = {row[0]: row for row in cells("table4.md")}
    for quantity, name in (("travel", "speed"), ("curvature", "curvature")):
        for ours, model in MODELS.items():
            row, found = rows[f"{quantity}, {ours}"], plane.spread(model, name)
            for cell, value in zip(row[2:5], found[:3], strict=True):
                assert value == pytest.approx(float(cell), abs=half(cell))
            assert int(row[5]) == found.gaits
    low, high = numbers("table4.md", r"ratio spans .(\d+) to (\d+)")
    wide = plane.spread("pivoting", "curvature", min_speed=2e-3)
    assert (-low, high) == (round(wide.lowest), round(wide.highest))
    row = rr.paper.table_4(
        robot, offsets=at([30, 45, 60, 75, 90]), phase_differences=[np.pi / 2]
    )  # fmt: skip
    yaw = (row.yaw_rate["decoupled"] / row.yaw_rate["full"])[:, 0]
    ratios = numbers("table4.md", r"\(([\d.]+) at π/4, ([\d.]+) at π/6\)[^(]*"
                                r"\(([\d.]+) at π/3, ([\d.]+) at 75°\)")  # fmt: skip
    np.testing.assert_allclose(yaw[[1, 0, 2, 3]], ratios, atol=0.006)
    factors = numbers("table4.md", r"factors ([\d.]+) at 75°, ([\d.]+) at 60°, ([\d.]+) at 45°, "
                                r"([\d.]+) at 30°")  # fmt: skip
    np.testing.assert_allclose(row.yaw_amplitude[[3, 2, 1, 0], 0] / 0.3, factors, atol=0.006)


@pytest.mark.slow
def test_the_pivoting_model_drifts_from_rest_as_the_errata_say():
    model = rr.PivotingModel(rr.Robot.from_parameters())
    run = rr.simulate(model, rr.gait("lateral"), 30.0, 0.05, start="rest", method="momentum")
    (turned,) = numbers("errata.md", r"turns by ([\d.]+) rad in 30 s")
    assert abs(run.euler[-1, 2] - run.euler[0, 2]) == pytest.approx(turned, rel=3e-3)
