"""The documentation site: its code runs, its links lead somewhere, and it needs no network."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import quote_plus, unquote, urlsplit

import click
import pytest

import rrrobot
from rrrobot.cli.main import cli
from tests.browser import Browser, find_browser

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
PAGES = sorted(p for p in DOCS.rglob("*.md") if not p.relative_to(DOCS).parts[0].startswith("_"))
NAMES = [str(p.relative_to(DOCS).with_suffix("")) for p in PAGES]

sys.path.insert(0, str(DOCS / "_ext"))

from mathml import to_mathml  # noqa: E402
from page_code import FENCE, PageError, blocks_of, is_kept, is_run, run_page  # noqa: E402

needs_browser = pytest.mark.skipif(
    find_browser() is None and not os.environ.get("RRROBOT_REQUIRE_BROWSER"),
    reason="no Chromium or Chrome",
)


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The built site; one worker builds it, the others wait for it."""
    shared = tmp_path_factory.getbasetemp()
    if os.environ.get("PYTEST_XDIST_WORKER"):
        shared = shared.parent
    out, said = shared / "site", shared / "site.txt"
    try:
        (shared / "site.lock").touch(exist_ok=False)
    except FileExistsError:
        end = time.monotonic() + 900
        while not said.exists() and time.monotonic() < end:
            time.sleep(0.2)
    else:
        command = [sys.executable, "-m", "sphinx", "-n", "-W", "--keep-going", "-q", "-E"]
        command += ["-b", "html", "-d", str(shared / "doctrees"), str(DOCS), str(out)]
        build = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=880)
        draft = shared / "site.draft"
        draft.write_text("" if build.returncode == 0 else build.stdout + build.stderr)
        draft.rename(said)
    assert said.read_text() == ""
    return out


class Page(HTMLParser):
    """Links, resources and anchors of one page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.anchors: set[str] = set()
        self.words = 0
        self.feed(path.read_text())

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        if found.get("id"):
            self.anchors.add(found["id"])
        if tag == "a" and found.get("href"):
            self.links.append(found["href"])
        loads = {"link": "href", "script": "src", "img": "src", "iframe": "src", "source": "src"}
        if tag in loads and found.get(loads[tag]):
            if tag != "link" or found.get("rel") not in ("next", "prev", "index", "search"):
                self.loads.append(found[loads[tag]])
            self.links.append(found[loads[tag]])

    def handle_data(self, data):
        self.words += len(data.split())


@pytest.fixture(scope="session")
def pages(site):
    films = site / "_made"
    return {p: Page(p) for p in sorted(site.rglob("*.html")) if films not in p.parents}


def external(url):
    return bool(urlsplit(url).scheme or urlsplit(url).netloc) and not url.startswith("data:")


def test_every_page_is_built(site):
    assert [name for name in NAMES if not (site / f"{name}.html").exists()] == []


def test_links_lead_somewhere(pages):
    broken = []
    for path, page in pages.items():
        for link in page.links:
            if external(link) or link.startswith("data:"):
                continue
            url = urlsplit(link)
            target = (path.parent / unquote(url.path)).resolve() if url.path else path
            anchors = pages[target].anchors if target in pages else {unquote(url.fragment)}
            if not target.exists() or unquote(url.fragment) not in {"", *anchors}:
                broken.append(f"{path.name}: {link}")
    assert broken == []


def test_nothing_is_loaded_from_elsewhere(site, pages):
    assert [url for page in pages.values() for url in page.loads if external(url)] == []
    for sheet in site.rglob("*.css"):
        assert not re.search(r"(@import|url\()\s*['\"]?(https?:)?//", sheet.read_text()), sheet
    for film in (site / "_made").rglob("*.html"):
        assert [url for url in Page(film).loads if external(url)] == []


def test_every_public_name_is_in_the_reference(site, pages):
    anchors = set().union(*(page.anchors for p, page in pages.items() if "reference" in p.parts))
    assert [n for n in rrrobot.__all__ if f"rrrobot.{n}" not in anchors] == []


def test_every_command_is_in_the_reference(pages):
    (page,) = (page for path, page in pages.items() if path.name == "cli.html")
    names = cli.list_commands(click.Context(cli))
    assert [name for name in names if f"rrrobot-{name}" not in page.anchors] == []


def test_no_page_is_a_stub(pages, site):
    short = {name: pages[site / f"{name}.html"].words for name in NAMES}
    assert {name: n for name, n in short.items() if n < 250} == {}


def test_every_picture_is_drawn(site):
    skipped = [p.name for p in site.rglob("*.html") if "Not drawn here" in p.read_text()]
    try:
        rrrobot.robot.example_robots()
    except rrrobot.MissingExtraError:
        skipped = [name for name in skipped if name != "your_robot.html"]
    assert skipped == []


@pytest.mark.parametrize("path", PAGES, ids=NAMES)
def test_all_code_runs(path):
    """Python and console blocks run when the site is built; others hold no code of ours."""
    for block in FENCE.finditer(path.read_text()):
        info, text = block[2].split(), block[3]
        if not is_run(block[2]):
            language = info[0] if info else ""
            assert language not in ("py", "pycon", "python3", "bash", "shell"), path
            for command in re.findall(r"^rrrobot ([\w-]+)", text, flags=re.M):
                assert cli.get_command(click.Context(cli), command), (
                    f"{path.name}: rrrobot {command}"
                )
    assert all(block.code.strip() for block in blocks_of(path.read_text()))


def test_an_error_in_a_page_is_an_error_of_the_build(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# A page\n\n```python\nx = 1\n```\n\n```python\nassert x == 2\n```\n")
    with pytest.raises(PageError, match="line 8"):
        run_page(page, tmp_path / "out")
    page.write_text("# A page\n\n```console\n$ rrrobot simulate --gait nothing\n```\n")
    with pytest.raises(PageError, match="nothing"):
        run_page(page, tmp_path / "out")
    page.write_text("# A page\n\n```console\n$ rm x\n```\n")
    with pytest.raises(PageError, match="rrrobot"):
        run_page(page, tmp_path / "out")


def test_what_a_page_says_is_kept_until_its_code_changes(tmp_path):
    page, kept = tmp_path / "page.md", tmp_path / "kept"
    lines = (
        "import time, pathlib",
        "pathlib.Path('a.svg').write_text('<svg/>')",
        "print(time.time())",
    )
    code = "\n".join(("```python", *lines, "```\n"))
    page.write_text(code)
    first = run_page(page, tmp_path / "one", kept)
    assert first.files == ["a.svg"] and (tmp_path / "one" / "a.svg").exists()
    page.write_text(f"Some words.\n\n{code}")
    page_moved = run_page(page, tmp_path / "two", kept)
    assert page_moved.output != first.output  # lines of errors would be wrong
    assert run_page(page, tmp_path / "three", kept) == page_moved
    assert (tmp_path / "three" / "a.svg").exists()


def test_pages_of_one_name_are_kept_side_by_side(tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "page.md").write_text(f"```python\nprint('{folder}')\n```\n")
    pages = [tmp_path / folder / "page.md" for folder in ("a", "b")]
    for page in pages:
        run_page(page, tmp_path / "out", tmp_path / "kept")
    assert all(is_kept(page, tmp_path / "kept") for page in pages)


def test_formulas():
    assert "\U0001d42f" in to_mathml(r"\mathbf v", "inline")
    assert 'form="prefix"' in to_mathml("x = -y", "inline")
    assert 'form="prefix"' not in to_mathml("x - y", "inline")
    assert "mspace" in to_mathml(r"r\cos\theta", "inline")
    assert to_mathml(r"\begin{aligned} a &= b \\ c &= d \end{aligned}", "block").count("mtr>") == 4
    with pytest.raises(Exception, match="not understood"):
        to_mathml(r"\begin{matrix} a", "inline")
    with pytest.raises(Exception, match="unheard"):
        to_mathml(r"\unheard x", "inline")


@pytest.fixture(scope="module")
def phone():
    with Browser((390, 800)) as browser:
        yield browser


@needs_browser
def test_pages_fit_a_phone_and_ask_for_nothing(phone, site, pages):
    """No page scrolls sideways at a width of 390 px, and none asks for anything from elsewhere."""
    wide, asked, problems = {}, [], []
    for path in pages:
        phone.requests.clear()
        phone.problems.clear()
        phone.call("Page.navigate", url=path.as_uri())
        phone.wait_for("document.readyState == 'complete'")
        # Of the page itself, and of its contents where something hides what sticks out.
        width = phone.run(
            "Math.max(document.documentElement.scrollWidth, document.body.scrollWidth,"
            " ...[...document.querySelectorAll('article, .content')].map(e => e.scrollWidth))"
        )
        if width > 390:
            wide[path.name] = width
        asked += [url for url in phone.requests if url.startswith(("http", "ws"))]
        problems += phone.problems
    assert wide == {}
    assert asked == [] and problems == []


@needs_browser
def test_films_play_in_the_page(phone, site):
    phone.call("Page.navigate", url=(site / "index.html").as_uri())
    phone.wait_for("document.readyState == 'complete' && document.querySelector('iframe') != null")
    phone.run("document.querySelector('iframe').scrollIntoView({block: 'center'})")
    # The frame is the only thing on the page that moves; a film goes through many pictures.
    pictures, end = set(), time.monotonic() + 60
    while len(pictures) < 4 and time.monotonic() < end:
        pictures.add(phone.call("Page.captureScreenshot", format="png")["data"])
        time.sleep(0.2)
    assert len(pictures) == 4
    # Pages of the file system may not look into one another: look at the film by itself.
    phone.open(phone.run("document.querySelector('iframe').src"))
    assert phone.run("document.getElementById('play').classList.contains('on')")
    before = phone.run("viewer.animator.time")
    phone.wait_for(f"viewer.animator.time != {before}")


@needs_browser
def test_formulas_are_drawn_in_their_font(phone, site):
    phone.call("Page.navigate", url=(site / "theory" / "rolling.html").as_uri())
    phone.wait_for("document.readyState == 'complete'")
    phone.wait_for("document.fonts.check('16px \"STIX Two Math\"')")
    assert phone.run("document.querySelectorAll('math').length") > 50
    fraction = "getComputedStyle(document.querySelector('mfrac')).display"
    assert "math" in phone.run(fraction)


@needs_browser
@pytest.mark.parametrize(
    ("query", "right"),
    [
        ("M, C, G at a state", "tutorials/first_hour"),
        ("CSV and pandas", "reference/simulation"),
        ("my own Pinocchio model", "reference/constraints"),
        ("which command for which question", "tutorials/first_hour"),
        ("limit cycle stability", "theory/limit_cycles"),
        ("stuck robot", "tutorials/ten_lines"),
        ("slip", "theory/rolling"),
        ("export to MuJoCo", "reference/bellies"),
        ("friction needed", "tutorials/torques_and_slopes"),
        ("how accurate", "benchmarks"),
    ],
)
def test_the_search_finds_what_people_type(phone, site, query, right):
    phone.call("Page.navigate", url=f"{(site / 'search.html').as_uri()}?q={quote_plus(query)}")
    phone.wait_for("document.querySelector('#search-results h2')?.innerText == 'Search Results'")
    links = "[...document.querySelectorAll('#search-results li > a')].map(link => link.href)"
    found = [urlsplit(url).path.removesuffix(".html") for url in phone.run(links)]
    assert str(site / right) in found[:2], found[:5]
