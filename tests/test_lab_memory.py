"""Half an hour of sliders moved at random leaves no memory behind."""

import contextlib
import os
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import rrrobot as rr

pytest.importorskip("viser")
from benchmarks.lab import FREQUENCY, Page

STATM = Path("/proc/self/statm")
SLIDERS = {
    FREQUENCY: (3.0, 20.0),
    "damping [mN m s]": (0.0, 30.0),
    "gravity [m/s²]": (1.0, 20.0),
    "leg mass [g]": (20.0, 140.0),
    "radius [mm]": (121.0, 200.0),
    "friction of ground": (0.1, 1.0),
    "path over [s]": (5.0, 300.0),
    "offset [deg]": (-180.0, 180.0),
    "amplitude [deg]": (0.0, 60.0),
}


def megabytes():
    return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def growth(seconds):
    """Memory after each tenth of a time of random moves [MB], and how many there were."""
    rng = np.random.default_rng(0)
    moves, grown = 0, []
    with rr.laboratory(rr.Robot.from_parameters()) as lab:
        page = Page(lab.url)
        page.wait_for_numbers()
        (session,) = lab.sessions.values()
        threading.Thread(target=listen, args=(page,), daemon=True).start()
        for _ in range(10):
            end = time.monotonic() + seconds / 10
            while time.monotonic() < end:
                label, before = list(SLIDERS)[rng.integers(len(SLIDERS))], session.knobs
                page.say({
                    "type": "GuiUpdateMessage", "uuid": page.uuid[label],
                    "updates": {"value": round(float(rng.uniform(*SLIDERS[label])), 1)},
                })  # fmt: skip
                heard = time.monotonic() + 0.5  # the same value again changes nothing
                while session.knobs is before and time.monotonic() < heard:
                    time.sleep(0.002)
                assert session.settled(60.0)
                moves += 1
            grown.append(megabytes())
        at = session.player.time
        time.sleep(1.0)
        assert session.player.time != at, "the player has stopped"
        page.close()
    return grown, moves


def listen(page):
    with contextlib.suppress(Exception):
        while True:
            page.hear()


@pytest.mark.slow
@pytest.mark.skipif(not STATM.exists(), reason="reads the memory as Linux tells it")
def test_half_an_hour_of_moves_leaves_no_memory_behind():
    grown, moves = growth(1800.0)
    assert moves > 1000
    # Caches fill in the first tenths; then a thousand moves may leave a tenth of a megabyte each.
    assert grown[-1] - grown[3] < 30.0, grown
