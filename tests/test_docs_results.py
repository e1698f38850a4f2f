"""Pages that are written from results say what the results say."""

import json
from pathlib import Path

import numpy as np
import pytest

import rrrobot as rr
from benchmarks import report_steering, robots
from rrrobot.paper.table4 import PAPER
from tests.pages import are_printed, numbers, said

DOCS = Path(__file__).parent.parent / "docs"


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
@pytest.mark.parametrize("gait", ["lateral", "circular"])
def test_the_two_gaits_of_table_4_are_what_comes_out(gait):
    found = rr.studies.compare(rr.Robot.from_parameters(), rr.gait(gait), method="momentum")
    full, pivoting, single = (found.states[n] for n in ("full", "pivoting", "decoupled"))
    ratio, paper = found.ratio, PAPER
    if gait == "lateral":
        assert all(abs(state.yaw_rate) < 1e-6 for state in found.states.values())
        values = (1e3 * full.speed, 1e3 * pivoting.speed, ratio("pivoting", "speed"),
                  paper["pivoting"]["speed"], 1e3 * single.speed,
                  ratio("decoupled", "speed"))  # fmt: skip
        are_printed(
            values,
            "table4.md", r"full \| ([\d.]+) \| 0 \|[ |]+ pivoting \| ([\d.]+) \| 0 "
            r"\| \*\*([\d.]+)\*\* \(paper ([\d.]+)\) \| . \| \| "
            r"\| single-axis \| ([\d.]+) \| 0 \| \*\*([\d.]+)",
        )  # fmt: skip
        return
    values: list[float] = [1e3 * full.speed, full.yaw_rate, 1e3 * pivoting.speed, pivoting.yaw_rate,
              ratio("pivoting", "speed"), ratio("pivoting", "curvature"),
              paper["pivoting"]["curvature"], ratio("pivoting", "yaw_rate")]  # fmt: skip
    for name in ("decoupled", "modulated"):
        state = found.states[name]
        values += [1e3 * state.speed, state.yaw_rate]
        values += [ratio(name, "speed"), ratio(name, "curvature")]
    are_printed(
        values,
        "table4.md", r"π/4 \| full \| ([\d.]+) \| ([\d.]+) \|[ |]+ pivoting \| ([\d.]+) "
        r"\| ([\d.]+) \| ([\d.]+) \| \*\*([\d.]+)\*\* \(paper ([\d.]+); yaw rate ([\d.]+)\) "
        r"\| \| \| single-axis \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) "
        r"\| \| \| modulated \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+)",
    )  # fmt: skip
    lags = np.rad2deg([abs(s.pitch_yaw_phase_difference) for s in (single, full)])
    are_printed(lags, "table4.md", r"pitch and yaw \((\d+)° instead of (\d+)° in")
    assert single.amplitude[0] == pytest.approx(full.amplitude[0] / 2, rel=0.02)  # "half"
    are_printed(
        (ratio("pivoting", "yaw_rate"), ratio("pivoting", "curvature")),
        "table4.md", r"tenfold:\*\* ([\d.]+) times in yaw rate and ([\d.]+) in",
    )  # fmt: skip


@pytest.mark.slow
def test_without_yaw_damping_the_full_model_spins_as_table_4_s_page_says():
    model = rr.FullModel(rr.Robot.from_parameters(), damping=(0.01, 0.01, 0.0))
    run = rr.simulate(model, rr.gait("circular"), 250.0, 0.1, method="momentum")
    (spin,) = numbers("table4.md", r"spin above ([\d.]+) rad/s")
    assert spin < (run.euler[-1, 2] - run.euler[-501, 2]) / 50.0 < spin + 1


SPREADS = {
    ("speed", "pivoting"): said("table4.md", r"\| travel, pivoting (\|[^a-z]*)"),
    ("speed", "decoupled"): said("table4.md", r"\| travel, single-axis (\|[^a-z]*)"),
    ("speed", "modulated"): said("table4.md", r"\| travel, modulated (\|[^a-z]*)"),
    ("curvature", "pivoting"): said("table4.md", r"\| curvature, pivoting (\|[^a-z]*)"),
    ("curvature", "decoupled"): said("table4.md", r"\| curvature, single-axis (\|[^a-z]*)"),
    ("curvature", "modulated"): said("table4.md", r"\| curvature, modulated (\|[^a-z]*)"),
}


@pytest.mark.slow
def test_table_4_of_the_page_is_what_comes_out():
    robot, at = rr.Robot.from_parameters(), np.deg2rad
    step, last, *between, gaits = numbers(
        "table4.md", r"Offsets 0, (\d+)°, ..., (\d+)° of both legs by phase differences (\d+)°, "
        r"(\d+)°, ..., (\d+)°: (\d+) gaits",
    )  # fmt: skip
    assert numbers("table4.md", r"plane beyond (\d+)° is") == (last,)
    slow, turns = numbers("table4.md", r"travels faster than ([\d.]+) mm/s.* than ([\d.]+) mrad/s:")
    plane = rr.paper.table_4(
        robot, offsets=at(np.arange(0, last + 1, step)),
        phase_differences=at(np.arange(between[0], between[2] + 1, between[1] - between[0])),
    )  # fmt: skip
    assert plane.speed["full"].size == gaits
    for (quantity, model), (row,) in SPREADS.items():
        paper, *cells, counted = (cell.strip() for cell in row.split("|")[1:6])
        assert paper == f"{PAPER.get(model, {}).get(quantity, '')}".removesuffix(".0")
        found = plane.spread(model, quantity, min_speed=slow / 1e3, min_yaw_rate=turns / 1e3)
        for cell, value in zip(cells, found[:3], strict=True):
            assert value == pytest.approx(float(cell), abs=half(cell))
        assert int(counted) == found.gaits
    found = plane.spread("pivoting", "curvature")
    are_printed(found[2:3], "table4.md", r"circular gait, up to ([\d.]+) on the plane")
    threshold, low, high = numbers(
        "table4.md", r"of ([\d.]+) mm/s the piv[^\u2212]* spans (\u2212\d+) to (\d+)"
    )
    wide = plane.spread("pivoting", "curvature", min_speed=threshold / 1e3)
    assert (low, high) == (round(wide.lowest), round(wide.highest))
    degrees = [30, 45, 60, 75, 90]
    row = rr.paper.table_4(robot, offsets=at(degrees), phase_differences=[np.pi / 2])
    yaw = (row.yaw_rate["decoupled"] / row.yaw_rate["full"])[:, 0]
    are_printed(
        (*yaw[[1, 0, 2, 3]], degrees[3]),
        "table4.md", r"\(([\d.]+) at π/4, ([\d.]+) at π/6\)[^(]*"
        r"\(([\d.]+) at π/3, ([\d.]+) at (\d+)°\)",
    )  # fmt: skip
    factors = said("table4.md", r"factors ([\d.]+) at (75)°, ([\d.]+) at (60)°, ([\d.]+) at (45)°, "
                                r"([\d.]+) at (30)°")  # fmt: skip
    for factor, offset in zip(factors[::2], factors[1::2], strict=True):
        found = row.yaw_amplitude[degrees.index(int(offset)), 0] / 0.3
        assert found == pytest.approx(float(factor), abs=half(factor))
    travel = row.ratio("decoupled", "speed")[:, 0]
    most = plane.spread("decoupled", "speed").highest
    are_printed(
        (travel[3], degrees[3], travel[4], most, travel[1]),
        "table4.md", r"we find ([\d.]+) at (\d+)° and ([\d.]+) at π/2, and at most ([\d.]+) on "
        r"the plane\..* down to ([\d.]+) at π/4",
    )  # fmt: skip


def test_table_4_s_page_quotes_the_paper():
    quoted = (
        numbers("table4.md", r"the travel of ([\d.]+) holds"),
        numbers("table4.md", r"Single-axis, travel overpredicted ([\d.]+) times"),
        numbers("table4.md", r"Single-axis, curvature ([\d.]+) times: .*?: ([\d.]+) lies in"),
    )
    pivoting, single = PAPER["pivoting"], PAPER["decoupled"]
    assert quoted == (
        (pivoting["speed"],), (single["speed"],), (single["curvature"], single["curvature"]),
    )  # fmt: skip


@pytest.mark.slow
def test_at_small_offsets_the_full_model_turns_the_other_way_as_table_4_s_page_says():
    (about,) = numbers("table4.md", r"about (\d+)° the full model turns the other way")
    row = rr.paper.table_4(
        rr.Robot.from_parameters(), offsets=np.deg2rad([about - 1, about + 1]),
        phase_differences=[np.pi / 2],
    )  # fmt: skip
    assert row.yaw_rate["full"][0, 0] < 0 < row.yaw_rate["full"][1, 0]


@pytest.mark.slow
def test_the_pivoting_model_drifts_from_rest_as_the_errata_say():
    model = rr.PivotingModel(rr.Robot.from_parameters())
    run = rr.simulate(model, rr.gait("lateral"), 30.0, 0.05, start="rest", method="momentum")
    (turned,) = numbers("errata.md", r"turns by ([\d.]+) rad in 30 s")
    assert abs(run.euler[-1, 2] - run.euler[0, 2]) == pytest.approx(turned, rel=3e-3)
