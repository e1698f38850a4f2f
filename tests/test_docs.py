"""What the README and the docstrings show must run; what they link to must exist."""

import ast
import builtins
import doctest
import importlib
import inspect
import pkgutil
import re
from pathlib import Path

import numpy as np
import pytest

import rrrobot
import rrrobot.machines.catalog
from rrrobot import files
from rrrobot.escape import atlas, confirming, loss, rolling_off
from rrrobot.orbits import many
from rrrobot.robot import faults, joints, markup, meshes
from rrrobot.simulation.plots import cycle_mean
from tests.some import some

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]
MODULES = sorted(
    module.name
    for module in pkgutil.walk_packages(rrrobot.__path__, "rrrobot.")
    if not module.name.endswith("__main__")
)

# Their examples take seconds.
LONG = {
    f"rrrobot.{name}"
    for name in (
        "orbits.travel", "orbits.branches", "steering.reaching", "studies.comparison",
        "figures.maps", "figures.reduction", "studies.optimisation.pareto",
        "studies.optimisation.result", "studies.optimisation.run", "machines.shells",
        "drive.controllers", "paper.run", "paper.unicycle", "orbits.oscillations",
        "steering.following", "steering.demands", "steering.planner", "machines.cycles",
        "orbits.gradients", "orbits.limit_cycles", "steering.plans", "steering.gears",
        "steering.reachable", "steering.identification", "lab.maps", "reduction.cycles",
        "simulation.trajectory", "simulation.steady",
    )
}  # fmt: skip

assert set(MODULES) > LONG


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(), flags=re.S)


def test_readme_lines_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (code,) = blocks(ROOT / "README.md", "python")
    exec(compile(code, "README.md", "exec"), {})
    assert (tmp_path / "path.png").stat().st_size > 10_000
    assert (tmp_path / "circular.html").stat().st_size > 100_000


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    text = page.read_text()
    # Pictures and films that a page's own code writes are checked in test_site.py.
    code = " ".join(re.findall(r"```(?:python|console).*?```", text, flags=re.S))
    for target in re.findall(r"\]\(([^)#]+)\)", re.sub(r"```.*?```", "", text, flags=re.S)):
        if not target.startswith("http") and not (page.parent / target).exists():
            made = target in code or target.replace(Path(target).stem, "{name}") in code
            assert made, f"{page.name} links to {target}"


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_pages_name_tests_that_exist(page):
    for file, test in re.findall(r"`(test_\w+\.py)(?:::(\w+))?`", page.read_text()):
        text = (ROOT / "tests" / file).read_text()
        assert not test or f"def {test}(" in text, f"{page.name} names {file}::{test}"


def test_the_gallery_s_lines_are_ten_and_stand_by_themselves():
    page = ROOT / "docs" / "gallery.md"
    sections = re.split(r"^## ", page.read_text(), flags=re.M)[1:]
    assert len(sections) >= 8
    for section in sections:
        (code,) = re.findall(r"```python\n(.*?)```", section, flags=re.S)
        assert len([line for line in code.splitlines() if line]) <= 10, section.splitlines()[0]
        names = [node for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Name)]
        made = {name.id for name in names if isinstance(name.ctx, ast.Store)}
        made |= set(re.findall(r"^import \w+ as (\w+)$", code, flags=re.M)) | set(dir(builtins))
        assert {name.id for name in names} <= made, section.splitlines()[0]
        for shown in re.findall(r"!\[[^\]]+\]\(([\w.]+)\)", section):
            assert f'"{shown}"' in code
            # The front page leads to each by a picture of it.
            assert f"images/gallery/{Path(shown).stem}.png" in (ROOT / "docs/index.md").read_text()


def test_the_examples_page_has_every_example_with_its_question():
    rows = re.findall(
        r"^\| (.*?) \| `(\w+\.py)` \|$", (ROOT / "docs/examples.md").read_text(), re.M
    )
    examples = {
        path.name: ast.get_docstring(ast.parse(path.read_text())).splitlines()[0]
        for path in (ROOT / "examples").glob("*.py")
    }
    assert {name: question for question, name in rows} == examples


@pytest.mark.parametrize("name", some(MODULES, set(MODULES) - LONG))
def test_docstring_examples(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = doctest.testmod(importlib.import_module(name))
    assert result.failed == 0


def test_every_public_function_has_an_example():
    """Errors, results and abstract bases are shown where they are used."""
    shown_elsewhere = {
        name
        for name in rrrobot.__all__
        if isinstance(getattr(rrrobot, name), type)
        and (
            issubclass(getattr(rrrobot, name), (Exception, tuple))
            or getattr(getattr(rrrobot, name), "__abstractmethods__", None)
        )
    }
    missing = [
        name
        for name in rrrobot.__all__
        if name not in shown_elsewhere and ">>>" not in (getattr(rrrobot, name).__doc__ or "")
    ]
    assert missing == []


WORDS = (
    "no one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen"
)
WORDS = f"{WORDS} sixteen seventeen eighteen nineteen twenty".split()
MACHINE_COUNT = len(rrrobot.machines.catalog.MACHINES)


@pytest.mark.parametrize(
    ("page", "sentence", "count"),
    [
        ("README.md", r"the snakeboard, and (\w+) other machines", MACHINE_COUNT - 1),
        ("docs/index.md", r"machines.md\) (\w+) machines", MACHINE_COUNT),
        ("docs/tutorials/first_hour.md", r"hour: (\w+) questions", 5),
        ("README.md", r"--figures maps   # (\d+) gaits", 40 * 40),
    ],
)
def test_what_is_counted_is_so_many(page, sentence, count):
    (said,) = re.findall(sentence, (ROOT / page).read_text())
    assert (int(said) if said.isdigit() else WORDS.index(said.lower())) == count


def test_the_readme_s_numbers_are_what_comes_out():
    """The rows of its table of trust that are numbers; what they are held against has its tests."""
    text = (ROOT / "README.md").read_text()
    rows = dict(re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", text, flags=re.M))
    model = rrrobot.FullModel(rrrobot.Robot.from_parameters())
    lateral, circular = (
        rrrobot.simulate(model, rrrobot.gait(name), 30.0, method="momentum")
        for name in ("lateral", "circular")
    )
    said = [float(x) for x in re.findall(r"[\d.]+\d", rows["lateral gait, v"])]
    assert said == pytest.approx(2 * [1000 * lateral.steady_state().speed], rel=2e-6)
    speed, rate, kane, kane_rate = (
        float(x) for x in re.findall(r"[\d.]+\d", rows["circular gait, v and yaw rate"])
    )
    found = circular.steady_state()
    assert (speed, kane) == pytest.approx(2 * (1000 * found.speed,), rel=2e-6)
    assert (rate, kane_rate) == pytest.approx(2 * (found.yaw_rate,), rel=5e-6)
    assert rows["slip and height error, any run"] == "below 1e-15 m/s and m"
    for run in (lateral, circular):
        assert max(run.slip.max(), np.abs(run.height_error).max()) < 1e-15


CIRCULAR = rrrobot.gait("circular")
RRROBOT = rrrobot.Robot.from_parameters()


def turning():
    return rrrobot.limit_cycle(rrrobot.FullModel(RRROBOT), CIRCULAR).yaw_rate


def yaw_inertia(leg_angle):
    return float(
        rrrobot.paper.yaw_mass_matrix(rrrobot.RRRobotParameters(), (leg_angle, leg_angle))[0, 0]
    )


def small_yaw():
    """2 alpha |sin(delta / 2)| a(o) at 0.3 rad, pi/2 and pi/2 [rad]."""
    return 2 * 0.3 * np.sin(np.pi / 4) * LEVER / yaw_inertia(np.pi / 2)


def whole_yaw():
    gait = rrrobot.SinusoidalGait(
        offset=np.pi / 2, amplitude=0.3, angular_frequency=8.0, phase=(0.0, np.pi / 2)
    )
    return 0.5 * np.ptp(
        rrrobot.simulate(rrrobot.YawModel(RRROBOT), gait, 10.0, method="momentum").euler[:, 2]
    )


def pitch_resonance():
    """Of the pitch with the legs up [rad/s]."""
    found = rrrobot.orbits.modes(rrrobot.FullModel(RRROBOT), (np.pi / 2, np.pi / 2))
    return next(2 * np.pi / mode.period for mode in found if mode.axis == "pitch")


def spread_of_where_cycles_begin():
    t = rrrobot.simulate(rrrobot.FullModel(RRROBOT), CIRCULAR, 40.0, method="momentum")
    period = CIRCULAR.period
    time, means = cycle_mean(t.time, t.position, period)
    late = slice(int(np.searchsorted(time, 30.0)), None)
    steps = [np.interp(time[late][:200] + period, time, x) - x[late][:200] for x in means.T]
    speed = np.hypot(*steps) / period
    return np.ptp(speed) / speed.mean()


def said(page, sentence):
    """The groups of the one place of a page that matches, its lines joined."""
    (found,) = re.finditer(sentence, " ".join((ROOT / "docs" / page).read_text().split()))
    return found.groups()


LEVER = 0.057 * 0.1 * 0.12
"""M_l l b [kg m^2]."""


@pytest.mark.parametrize(
    ("page", "sentence", "value"),
    [
        ("extend/constraint.md", r"the same gait turns at ([\d.]+) rad/s", turning),
        ("theory/yaw.md", r"robot turns at ([\d.]+) rad/s", turning),
        ("theory/small_gaits.md", r"resonance at ([\d.]+) rad/s", pitch_resonance),
        ("theory/travel.md", r"by ([\de.-]+) of the circular", spread_of_where_cycles_begin),
        ("theory/travel.md", r"itself, ([\de.-]+) for the circular",
         lambda: (turning() * CIRCULAR.period) ** 2 / 24),
        ("reduction.md", r"up, ([\d.]+) kg", lambda: yaw_inertia(np.pi / 2)),
        ("reduction.md", r"against ([\d.]+) with", lambda: yaw_inertia(0.0)),
        ("reduction.md", r"where a = ([\d.]+)", lambda: LEVER / yaw_inertia(np.pi / 2)),
        ("reduction.md", r"and ([\d.]+) times as\s+high",
         lambda: yaw_inertia(0.0) / yaw_inertia(np.pi / 2)),
        ("reduction.md", r"formula gives ([\d.]+) rad", small_yaw),
        ("reduction.md", r"whole model ([\d.]+) rad", whole_yaw),
        ("files.md", r"more than ([\d.]+) MB", lambda: markup.MAX_BYTES / 1e6),
        ("files.md", r"MB, (\d+) links", lambda: faults._MAX_LINKS),
        ("files.md", r"a chain of (\d+)", lambda: faults._MAX_CHAIN),
        ("files.md", r"(\d+) moving joints", lambda: joints._MAX_LEGS),
        ("files.md", r"process of its own within (\d+) s", lambda: meshes._SECONDS),
        ("files.md", r"pipe that does not stay silent for (\d+) s",
         lambda: files._PATIENCE),
        ("theory/steering.md", r"rests within ([\d.]+) mm",
         lambda: 1e3 * inspect.signature(rrrobot.plan).parameters["tolerance"].default[0]),
        ("theory/steering.md", r"mm and ([\d.]+)°",
         lambda: np.rad2deg(inspect.signature(rrrobot.plan).parameters["tolerance"].default[1])),
        ("errata.md", r"begins: ([\de.-]+) of the circular", spread_of_where_cycles_begin),
        ("tutorials/ten_lines.md", r"from ([\d.]+) to [\d.]+ of each mode", lambda: atlas.NEAR[0]),
        ("tutorials/ten_lines.md", r"from [\d.]+ to ([\d.]+) of each mode", lambda: atlas.NEAR[-1]),
        ("tutorials/ten_lines.md", r"differ by more than (\d) %", lambda: 100 * confirming.AGREE),
        ("tutorials/ten_lines.md", r"rounded by (\d) cm", lambda: 100 * rolling_off.EDGE),
        ("tutorials/ten_lines.md", r"damping ratio of ([\d.]+)", lambda: loss.RATIO),
        ("theory/limit_cycles.md", r"comes to in (\d+) periods", lambda: many.SETTLING),
        ("theory/limit_cycles.md", r"no multiplier beyond ([\d.]+)", lambda: many._SURE),
    ],
)  # fmt: skip
def test_numbers_in_sentences_are_what_comes_out(page, sentence, value):
    """To the digits that are printed."""
    (number,) = said(page, sentence)
    digits = len(re.sub(r"e.*|^0\.0*|\.", "", number))
    assert float(f"{value():.{digits - 1}e}") == pytest.approx(float(number), rel=1e-9), value()


def test_no_page_promises_a_time_by_hand():
    """Times depend on the computer: those that are told come from a measurement."""
    many = r"(?:an? |half a |a few |some )(?:seconds|minutes?|hours?)\b"
    promise = re.compile(rf"(?:#.*: |, |takes |in )(?:about )?{many}")
    generated = {"benchmarks.md", "ideal.md", "robots.md", "CHANGELOG.md"}
    kept = {"answered in an hour"}
    for page in PAGES:
        if page.name in generated:
            continue
        for line in page.read_text().splitlines():
            if not any(words in line for words in kept):
                assert not promise.search(line), f"{page.name}: {line}"
