"""The laboratory's page in a headless browser, as a person uses it."""

from __future__ import annotations

import os
import time
from dataclasses import replace

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.lab.outcome import settle
from tests.browser import Browser, find_browser

pytest.importorskip("viser")
pytestmark = pytest.mark.skipif(
    find_browser() is None and not os.environ.get("RRROBOT_REQUIRE_BROWSER"),
    reason="no Chromium or Chrome",
)

ROBOT = rr.Robot.from_parameters()
READY = "document.querySelector('.rr-numbers[data-speed]') != null"
SIZE = (700, 420)
"""Small: a browser without a graphics card draws slowly."""


@pytest.fixture(scope="module")
def lab():
    with rr.laboratory(ROBOT) as opened:
        yield opened


@pytest.fixture(scope="module")
def page(lab):
    with Browser(SIZE, timeout=120, scale=0.25) as browser:
        visit(browser, lab)
        yield browser


def visit(browser, lab):
    """Open the page; its session."""
    before = set(lab.sessions)
    browser.open(lab.url, READY)
    (number,) = set(lab.sessions) - before
    session = lab.sessions[number]
    assert session.settled()
    session.player.playing = False
    return session


def latest(lab):
    return lab.sessions[max(lab.sessions)]


def shown(browser, name):
    """A number that the panel shows, in full."""
    return float(browser.run(f"document.querySelector('.rr-numbers').dataset.{name}"))


def refused(browser):
    """What the panel says of a motion that cannot be."""
    return browser.run("document.querySelector('.rr-refusal')?.innerText ?? ''")


def type_into(browser, label, text):
    """Put text into the field that stands beside a label, as by hand."""
    found = browser.run(
        f"""(() => {{
        const near = [...document.querySelectorAll('p')].find(p => p.innerText == {label!r});
        if (!near) return false;
        const field = near.parentElement.parentElement.querySelector('input[type=text], input:not([type=hidden])');
        Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, 'value').set.call(field, {text!r});
        field.dispatchEvent(new Event('input', {{bubbles: true}}));
        return true;}})()"""  # noqa: E501
    )
    assert found, f"no label {label}"


def press(browser, x, y):
    """A click of the mouse."""
    for kind in ("mousePressed", "mouseReleased"):
        browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)


def tab(browser, name):
    left, top, wide, high = still(
        browser,
        f"""const tabs = [...document.querySelectorAll('[role=tab]')];
        const b = tabs.find(t => t.innerText == {name!r}).getBoundingClientRect();
        return [b.left, b.top, b.width, b.height];""",
    )
    press(browser, left + wide / 2, top + high / 2)


def still(browser, script):
    """A rectangle on the page (left, top, width, height) once it stays where it is."""
    before = None
    while (box := browser.run(f"(() => {{{script}}})()")) != before:
        before = box
        time.sleep(0.3)
    return box


def drag(browser, label, share):
    """Drag a slider's thumb by the mouse to a share of its track."""
    left, top, wide, high = still(
        browser,
        f"""const near = [...document.querySelectorAll('p')].find(p => p.innerText == {label!r});
        const root = near.parentElement.parentElement;
        root.scrollIntoView({{block: 'center'}});
        const b = root.querySelector('.mantine-Slider-track').getBoundingClientRect();
        return [b.left, b.top, b.width, b.height];""",
    )
    x, y = left + share * wide, top + high / 2
    for kind, at in (("mousePressed", left + 0.4 * wide), ("mouseMoved", x), ("mouseReleased", x)):
        browser.call("Input.dispatchMouseEvent", type=kind, x=at, y=y, button="left", buttons=1,
                     clickCount=1)  # fmt: skip


def wait_until(true, seconds=150.0):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.05)


def test_the_page_needs_only_this_computer_and_does_not_complain(page, lab):
    assert lab.url.startswith("http://127.0.0.1:")
    outside = [url for url in page.requests if not url.startswith(
        ("data:", "blob:", lab.url, lab.url.replace("http", "ws").rstrip("/")))]  # fmt: skip
    assert not outside
    assert not page.problems


def test_a_slider_moves_and_the_path_changes_by_the_right_amount(page, lab):
    session = latest(lab)
    before = shown(page, "speed")
    drag(page, "frequency [rad/s]", 0.25)
    # The thumb may be drawn on its way too.
    wait_until(lambda: session.settled() and session.knobs.frequency < 6.5)
    wait_until(lambda: shown(page, "speed") == session.outcome.speed != before)
    frequency = session.knobs.frequency
    assert 4.5 < frequency < 6.5
    gait = rr.gait("circular", angular_frequency=frequency)
    cycle = session.outcome.cycle
    horizon = round(session.knobs.horizon / gait.period) * gait.period
    model = rr.FullModel(ROBOT)
    steps = len(session.outcome.trajectory) - 1
    run = rr.simulate(model, gait, horizon, gait.period / steps, euler=cycle.euler,
                      start=cycle.euler_rates, method="momentum")  # fmt: skip
    # The path has no last sample of the last period: it is the first of the next.
    end = run.position[-2]
    assert (shown(page, "endX"), shown(page, "endY")) == pytest.approx(tuple(end), abs=2e-6)
    assert shown(page, "speed") == pytest.approx(run.steady_state().speed, rel=1e-5)
    type_into(page, "frequency [rad/s]", "8")
    wait_until(lambda: session.settled() and abs(shown(page, "speed") / before - 1) < 1e-9)


def test_what_cannot_be_is_said_and_the_last_path_stays(page, lab):
    session = latest(lab)
    before = shown(page, "speed")
    type_into(page, "frequency [rad/s]", "20")
    type_into(page, "amplitude [deg]", "70")
    wait_until(lambda: page.run("document.querySelector('.rr-refusal')?.innerText") is not None)
    words = page.run("document.querySelector('.rr-refusal').innerText")
    assert "lifts off" in words and "last good path is kept" in words
    assert session.outcome is not None
    type_into(page, "amplitude [deg]", "17.1887")
    type_into(page, "frequency [rad/s]", "8")
    wait_until(lambda: page.run("document.querySelector('.rr-refusal')") is None)
    assert shown(page, "speed") == pytest.approx(before, rel=1e-4)


def test_a_robot_that_tips_over_is_said_to_and_the_page_lives_on(page, lab):
    session = latest(lab)
    before = shown(page, "speed")
    tab(page, "Robot")
    masses = ("leg mass [g]", "servo mass [g]", "battery [g]")

    def choose(values):
        for k, (label, value) in enumerate(zip(masses, values, strict=True)):
            type_into(page, label, str(value))
            wait_until(lambda k=k, value=value: abs(1e3 * session.knobs.body[k] - value) < 1e-6)

    choose((150, 200, 20))
    wait_until(lambda: "No settled motion" in refused(page))
    type_into(page, "slope [deg]", "6")
    wait_until(lambda: "tips over" in refused(page))
    assert "last good path is kept" in refused(page)
    assert shown(page, "speed") == session.outcome.speed
    type_into(page, "slope [deg]", "0")
    wait_until(lambda: session.knobs.slope == 0.0)
    choose((57, 53, 300))
    wait_until(lambda: session.settled() and not refused(page))
    wait_until(lambda: abs(shown(page, "speed") / before - 1) < 1e-4)
    assert not page.problems
    tab(page, "Gait")


def test_clicking_the_map_selects_the_gait(page, lab):
    session = latest(lab)
    tab(page, "Map")
    assert session.atlas.drawn()
    page.wait_for("document.querySelector('.rr-map[data-name=map] rect[onclick]') != null")
    left, top, wide, high = still(
        page,
        """const r = document.querySelector('.rr-map[data-name=map] rect');
        r.scrollIntoView({block: 'center'});
        const b = r.getBoundingClientRect();
        return [b.left, b.top, b.width, b.height];""",
    )
    press(page, left + 0.75 * wide, top + 0.25 * high)
    wait_until(lambda: session.settled() and abs(session.knobs.offset[0] - np.pi / 2) < 0.05)
    assert session.knobs.offset[0] == session.knobs.offset[1]
    assert session.knobs.phase[1] - session.knobs.phase[0] == pytest.approx(np.pi / 2, abs=0.05)
    alone = settle(ROBOT, session.knobs)
    wait_until(lambda: abs(shown(page, "speed") / alone.speed - 1) < 1e-6)
    # The inverse map: a curvature and a speed.
    type_into(page, "curvature, speed", "2.0 5.0")
    wait_until(lambda: abs(shown(page, "speed") / 0.005 - 1) < 1e-4)
    assert shown(page, "yawRate") == pytest.approx(0.01, rel=1e-3)
    tab(page, "Gait")


def test_playing_moves_the_robot_in_real_time(page, lab):
    session = latest(lab)
    player = session.player
    player.restart()
    player.speed, player.playing = 2.0, True
    start = time.monotonic()
    time.sleep(1.5)
    passed = time.monotonic() - start
    player.playing = False
    time.sleep(0.1)
    assert player.time == pytest.approx(2.0 * passed, abs=0.5)
    # The scene has been told: its root joint stands where the motion is at that time.
    player.draw()
    q, shift, _ = session.outcome.frame(player.time)
    place = session.drawing.scene.pose(q).joints[1]
    node = session.drawing.stage._nodes[session.drawing.scene.path(1)]
    assert node.position == pytest.approx((shift * place).translation, abs=1e-6)
    player.speed = 1.0


@pytest.mark.slow
def test_two_pages_do_not_disturb_each_other_and_one_may_come_back(page, lab):
    first = latest(lab)
    before = first.knobs, shown(page, "speed")
    with Browser(SIZE, timeout=120, scale=0.25) as other:
        second = visit(other, lab)
        assert second.knobs != first.knobs
        type_into(other, "frequency [rad/s]", "5")
        wait_until(lambda: second.settled() and second.knobs.frequency == 5.0)
        assert first.knobs == before[0]
        assert shown(page, "speed") == before[1]
        wait_until(lambda: shown(other, "speed") != before[1])
        # Closed and opened again: a session of its own, from the start.
        third = visit(other, lab)
        assert third is not second and third.knobs.frequency == 8.0
        wait_until(lambda: second not in lab.sessions.values())
    wait_until(lambda: list(lab.sessions.values()) == [first])
    assert not page.problems


def test_knobs_can_be_set_by_a_script_too(lab, page):
    session = latest(lab)
    session.choose(replace(session.knobs, gravity=1.62))
    assert session.settled() and session.refusal is None
    assert session.outcome.trajectory.gravity == 1.62


@pytest.mark.slow
def test_a_link_opens_the_same_state_and_code_is_shown(lab, page):
    knobs = replace(latest(lab).knobs, frequency=6.5, gravity=9.81, horizon=40.0)
    before = set(lab.sessions)
    page.open(f"{lab.url}?lab={knobs.text()}", READY)
    wait_until(lambda: set(lab.sessions) - before)
    session = latest(lab)
    session.player.playing = False
    wait_until(lambda: session.knobs == knobs and session.settled())
    alone = settle(ROBOT, knobs)
    wait_until(lambda: abs(shown(page, "speed") / alone.speed - 1) < 1e-9)
    tab(page, "Save")
    page.wait_for(
        "[...document.querySelectorAll('button')].some(b => b.innerText == 'Python code')"
    )
    page.run("[...document.querySelectorAll('button')].find("
             "b => b.innerText == 'Python code').click()")  # fmt: skip
    page.wait_for("document.querySelector('.rr-code') != null")
    assert "angular_frequency=[6.5, 6.5]" in page.run(
        "document.querySelector('.rr-code').innerText"
    )
    assert not page.problems


@pytest.mark.slow
def test_a_notebook_s_cell_shows_the_page_within_it(lab, tmp_path):
    cell = tmp_path / "cell.html"
    cell.write_text(lab._repr_html_())
    before = set(lab.sessions)
    with Browser(SIZE, timeout=120, scale=0.25) as browser:
        browser.open(cell.as_uri(), "document.querySelector('iframe') != null")
        wait_until(lambda: set(lab.sessions) - before)
        assert latest(lab).settled() and latest(lab).refusal is None
