"""What a notebook shows: whole HTML, escaped, without a network, with pyplot and without."""

import base64
import dataclasses
import io
import pickle
import re
import subprocess
import sys
import time
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

import rrrobot as rr
from rrrobot.drawing import new_axes, new_figure
from rrrobot.inline import html_frame, html_table
from rrrobot.studies.optimisation.goals import FastestTravel
from tests.browser import Browser, find_browser
from tests.some import some

VOID = {"img", "br", "meta", "link", "input", "hr"}


class Tags(HTMLParser):
    """Checks that tags close in their order; collects the text and the sources."""

    def __init__(self, page):
        super().__init__()
        self.open, self.text, self.sources, self.seen = [], "", [], []
        self.feed(page)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.seen.append(tag)
        self.sources += [v for k, v in attrs if k in ("src", "href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


@pytest.fixture(scope="module")
def robot():
    return rr.Robot.from_parameters()


@pytest.fixture(scope="module")
def run(robot):
    return rr.simulate(rr.FullModel(robot), rr.gait("circular"), 20.0, method="momentum")


@pytest.fixture(scope="module")
def results(robot, run):
    best = rr.optimise(
        rr.FullModel(robot), FastestTravel(), offset=1.2, amplitude=0.3, angular_frequency=8.0,
        phase_difference=1.5, settle_time=3.0,
    )  # fmt: skip
    front = rr.pareto_front(rr.FullModel(robot), n_points=2, budget=150, settle_time=4.0, tied=True)
    return {
        "mass": robot,
        "damping": rr.FullModel(robot),
        "Trajectory": run,
        "yaw rate": run.steady_state(),
        "pivoting": rr.studies.compare(robot, rr.gait("circular"), 4.0),
        "curvature": best,
        "Pareto front": front,
        "it holds": rr.limit_cycle(rr.FullModel(robot), rr.gait("circular")),
        "most turn": rr.reduction.optimal_cycle(robot, angle_range=(0.3, 1.5), harmonics=3),
        "missed by": rr.plan(rr.FullModel(robot), goal=(0.0, 0.1, 0.0)),
        "motors": rr.machines.snakeboard(),
        "constraints broken by": rr.machines.chaplygin_sleigh().simulate(None, 0.5),
    }


RESULTS = ("mass", "damping", "Trajectory", "yaw rate", "pivoting", "curvature", "Pareto front")
RESULTS += ("it holds", "most turn", "missed by", "motors", "constraints broken by")


@pytest.mark.parametrize("word", RESULTS)
def test_results_show_whole_html_that_needs_no_network(results, word):
    shown = Tags(results[word]._repr_html_())
    assert word in shown.text
    assert all(source.startswith("data:image/png;base64,") for source in shown.sources)
    assert "script" not in shown.seen


def test_numbers_shown_are_the_result_s(results):
    state = results["yaw rate"]
    assert f"{1000 * state.speed:.4f} mm/s" in state._repr_html_()


def test_names_of_a_urdf_cannot_become_tags(robot):
    name = "<script>alert(1)</script>"
    urdf = robot.urdf.replace('name="rrrobot"', 'name="&lt;script&gt;alert(1)&lt;/script&gt;"', 1)
    hostile = dataclasses.replace(robot, urdf=urdf)
    assert hostile.name == name
    shown = Tags(hostile._repr_html_())
    assert name in shown.text and "script" not in shown.seen


def test_table_escapes_every_part():
    shown = Tags(html_table("<b>", [("<i>", "&")], head=("<u>", '"')))
    assert set(shown.seen) == {"div", "b", "table", "tr", "td", "th"}
    assert "<i>" in shown.text and "<u>" in shown.text


def test_film_is_in_a_frame_of_its_own(run, tmp_path):
    html = rr.show(run, fps=5)._repr_html_()
    assert re.match(r'<iframe srcdoc="[^"]*" sandbox="allow-scripts" ', html)
    frame = HTMLParser()
    pages = []
    frame.handle_starttag = lambda tag, attrs: pages.append(dict(attrs)["srcdoc"])
    frame.feed(html)
    assert pages[0].encode() == rr.record(run, tmp_path / "film.html", fps=5).read_bytes()
    with pytest.raises(rr.ParameterError, match="height"):
        rr.show(run, height=0)


def test_frame_keeps_quotes_and_tags():
    page = '<p class="a">it\'s &amp; "so"</p></iframe>'
    pages = []
    parser = HTMLParser()
    parser.handle_starttag = lambda tag, attrs: pages.append(dict(attrs).get("srcdoc"))
    parser.feed(html_frame(page, height=10))
    assert pages == [page]


def test_figures_and_their_axes_are_pictures(run):
    for shown in (new_figure(), new_axes(), run.plot("path"), run.plot("all")):
        assert shown._repr_png_().startswith(b"\x89PNG")


def test_figures_still_pickle(run):
    figure = pickle.loads(pickle.dumps(run.plot("path").figure))
    assert figure._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "before",
    some(
        ("pass", "import matplotlib; matplotlib.use('agg'); import matplotlib.pyplot"),
        {"imported"},
        lambda code: "nothing" if code == "pass" else "imported",
    ),
)
def test_ipython_displays_figures_and_films(before):
    pytest.importorskip("IPython")
    code = f"""
{before}
from IPython.core.interactiveshell import InteractiveShell
import rrrobot as rr
from tests.some import some
shell = InteractiveShell.instance()
t = rr.simulate(rr.FullModel(rr.Robot.from_parameters()), rr.gait("lateral"), 1.0)
for thing in (t.plot("path"), t.plot("all"), t, rr.show(t)):
    print(*sorted(shell.display_formatter.format(thing)[0]))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [
        "image/png text/plain", "image/png text/plain", "text/html text/plain",
        "text/html text/plain",
    ]  # fmt: skip


@pytest.mark.skipif(find_browser() is None, reason="no Chromium or Chrome")
def test_a_notebook_s_page_plays_the_film_and_asks_for_nothing(run, tmp_path):
    page = tmp_path / "notebook.html"
    cells = run.steady_state()._repr_html_() + run._repr_html_() + rr.show(run)._repr_html_()
    page.write_text(f"<!DOCTYPE html><meta charset='utf-8'><body>{cells}</body>")

    def picture():
        answer = browser.call("Page.captureScreenshot", format="png")
        with Image.open(io.BytesIO(base64.b64decode(answer["data"]))) as image:
            return np.asarray(image.convert("RGB"), dtype=int)

    with Browser((800, 600)) as browser:
        browser.call("Page.navigate", url=page.as_uri())
        browser.wait_for("document.readyState == 'complete' && document.images.length == 1")
        assert browser.run("document.images[0].naturalWidth") > 500
        browser.run("document.querySelector('iframe').scrollIntoView()")
        end = time.monotonic() + 30
        while picture().std() < 5:
            assert time.monotonic() < end, "the frame stays empty"
            time.sleep(0.3)
        time.sleep(1.0)
        first = picture()
        while np.abs(picture() - first).mean() < 0.5:
            assert time.monotonic() < end, "the film does not play"
            time.sleep(0.3)
        assert browser.problems == []
        assert {r.split(":")[0] for r in browser.requests} <= {"file", "data", "blob", "about"}
