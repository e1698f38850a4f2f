"""Pages that are written from results say what the results say; numbers in their sentences, too."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import rrrobot as rr
from benchmarks import report_steering, robots
from rrrobot.escape import atlas, confirming, loss, rolling_off
from rrrobot.orbits import many
from tests.test_docs import spread_of_where_cycles_begin

DOCS = Path(__file__).parent.parent / "docs"
MODELS = {"pivoting": "pivoting", "single-axis": "decoupled", "modulated": "modulated"}


def said(page: str, sentence: str) -> tuple[float, ...]:
    """The numbers of the one place of a page that matches."""
    (found,) = re.finditer(sentence, " ".join((DOCS / page).read_text().split()))
    return tuple(float(number) for number in found.groups())


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
    assert said("robots.md", r"gaits a goal, (\d+) postures") == (robots.POSTURES,)
    assert said("robots.md", r"within friction ([\d.]+)") == (rr.escape.EscapeLimits().friction,)


def test_what_parts_the_ideal_from_mujoco_is_of_its_table():
    rows = [row for row in cells("ideal.md") if row[0] not in ("robot", "---")]
    stiff = [row for row in rows if row[2] == "these, and a stiff contact"]
    turn = max(abs(float(row[5]) - float(row[6])) for row in stiff)
    assert said("ideal.md", r"at most ([\d.]+) mm apart, the turns (\d+)") == (
        max(float(row[7]) for row in stiff), round(turn),
    )  # fmt: skip
    (friction,) = said("ideal.md", r"less than ([\d.]+) everywhere")
    assert friction - 0.02 <= max(float(row[1]) for row in rows) <= friction


@pytest.mark.parametrize(
    ("page", "sentence", "value"),
    [
        ("errata.md", r"begins: ([\de.-]+) of the circular", spread_of_where_cycles_begin),
        ("tutorials/ten_lines.md", r"from ([\d.]+) to [\d.]+ of each mode", lambda: atlas.NEAR[0]),
        ("tutorials/ten_lines.md", r"from [\d.]+ to ([\d.]+) of each mode", lambda: atlas.NEAR[-1]),
        ("tutorials/ten_lines.md", r"differ by more than (\d) %", lambda: 100 * confirming.AGREE),
        ("tutorials/ten_lines.md", r"rounded by (\d) cm", lambda: 100 * rolling_off.EDGE),
        ("tutorials/ten_lines.md", r"damping ratio of ([\d.]+)", lambda: loss.RATIO),
        ("theory/limit_cycles.md", r"comes to in (\d+) periods", lambda: many.SETTLING),
        ("theory/limit_cycles.md", r"no multiplier beyond ([\d.]+)", lambda: many._SURE),
    ],
)
def test_numbers_in_sentences_are_the_code_s(page, sentence, value):
    (number,) = said(page, sentence)
    assert value() == pytest.approx(number, rel=0.03)


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
    low, high = said("table4.md", r"ratio spans .(\d+) to (\d+)")
    wide = plane.spread("pivoting", "curvature", min_speed=2e-3)
    assert (-low, high) == (round(wide.lowest), round(wide.highest))
    row = rr.paper.table_4(
        robot, offsets=at([30, 45, 60, 75, 90]), phase_differences=[np.pi / 2]
    )  # fmt: skip
    yaw = (row.yaw_rate["decoupled"] / row.yaw_rate["full"])[:, 0]
    numbers = said("table4.md", r"\(([\d.]+) at π/4, ([\d.]+) at π/6\)[^(]*"
                                r"\(([\d.]+) at π/3, ([\d.]+) at 75°\)")  # fmt: skip
    np.testing.assert_allclose(yaw[[1, 0, 2, 3]], numbers, atol=0.006)
    factors = said("table4.md", r"factors ([\d.]+) at 75°, ([\d.]+) at 60°, ([\d.]+) at 45°, "
                                r"([\d.]+) at 30°")  # fmt: skip
    np.testing.assert_allclose(row.yaw_amplitude[[3, 2, 1, 0], 0] / 0.3, factors, atol=0.006)


@pytest.mark.slow
def test_the_pivoting_model_drifts_from_rest_as_the_errata_say():
    model = rr.PivotingModel(rr.Robot.from_parameters())
    run = rr.simulate(model, rr.gait("lateral"), 30.0, 0.05, start="rest", method="momentum")
    (turned,) = said("errata.md", r"turns by ([\d.]+) rad in 30 s")
    assert abs(run.euler[-1, 2] - run.euler[0, 2]) == pytest.approx(turned, rel=3e-3)
