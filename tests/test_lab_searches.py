"""Searches that the laboratory starts: the best gait, and a way to get free."""

from dataclasses import replace

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.outcome import Refusal, settle
from rrrobot.lab.searches import best_gait, played, way_free

ROBOT = rr.Robot.from_parameters()
KNOBS = Knobs.of(ROBOT)


def test_what_cannot_be_searched_is_said():
    with pytest.raises(Refusal, match="raise the damping"):
        best_gait(ROBOT, replace(KNOBS, damping=0.0), "fastest", lambda done, total: None)


@pytest.mark.slow
def test_a_search_ends_where_the_person_stops_it():
    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        way_free(ROBOT, "forward", stop)


@pytest.mark.slow
def test_the_best_gait_is_the_motion_that_the_page_then_shows():
    told = []
    found, words = best_gait(ROBOT, KNOBS, "fastest", lambda done, total: told.append(done))
    shown = settle(ROBOT, found)
    assert shown.speed > 3 * settle(ROBOT, KNOBS).speed
    assert shown.speed == pytest.approx(float(words.split()[1]), rel=1e-3)
    assert told == sorted(told) and len(told) > 5
    assert max(found.amplitude) <= 0.5 + 1e-12 and max(np.abs(found.offset)) <= np.pi


@pytest.mark.slow
def test_a_way_free_is_played_from_rest_as_it_was_confirmed():
    way = way_free(ROBOT, "forward", lambda done, total: None).best("forward")
    found = played(KNOBS, way)
    assert found.screw is None and found.trajectory is way.trajectory
    assert found.speed == pytest.approx(np.hypot(*way.travel[:2]), rel=0.02)
    assert any("forward" in word for word in found.words)
