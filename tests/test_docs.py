"""What the README and the docstrings show must run; what they link to must exist."""

import ast
import builtins
import doctest
import importlib
import pkgutil
import re
from pathlib import Path

import pytest

import rrrobot
import rrrobot.machines.catalog
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
