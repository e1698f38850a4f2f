"""The laboratory's sliders, moved by a client without a browser."""

import contextlib
import threading
import time

import numpy as np
import pytest

import rrrobot as rr

pytest.importorskip("viser")
from benchmarks.lab import FREQUENCY, Page
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.outcome import settle

DAMPING = "damping [mN m s]"
MOVED = {"offset [deg]": (30, 60), "amplitude [deg]": (5, 20), FREQUENCY: (6, 9), DAMPING: (8, 14)}


def listen(page):
    with contextlib.suppress(Exception):
        while True:
            page.hear()


def test_no_value_is_lost_when_several_are_typed_at_once():
    rng, robot = np.random.default_rng(0), rr.Robot.from_parameters()
    settle(robot, Knobs.of(robot))  # compiles the engine
    with rr.laboratory(robot) as lab:
        page = Page(lab.url)
        page.wait_for_numbers()
        (session,) = lab.sessions.values()
        threading.Thread(target=listen, args=(page,), daemon=True).start()
        for _ in range(5):
            typed = {name: round(float(rng.uniform(*ends)), 2) for name, ends in MOVED.items()}
            for label, value in typed.items():
                told = {"uuid": page.uuid[label], "updates": {"value": value}}
                page.say({"type": "GuiUpdateMessage", **told})

            def stand(typed=typed):
                k = session.knobs
                stands = (*np.rad2deg(k.offset), *np.rad2deg(k.amplitude), k.frequency)
                offset, swing, frequency, damping = typed.values()
                wanted = (offset, offset, swing, swing, frequency)
                return np.allclose(stands, wanted) and np.isclose(1e3 * k.damping, damping)

            end = time.monotonic() + 10.0
            while not stand() and time.monotonic() < end:
                time.sleep(0.02)
            assert stand(), (typed, session.knobs)
            assert session.settled() and session.outcome.knobs == session.knobs
