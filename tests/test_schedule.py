"""Schedules: smooth in themselves, equal to the gaits that they are made of."""

import json

import numpy as np
import pytest

import rrrobot as rr
from rrrobot import serial
from rrrobot.drive.schedule import Schedule, Stretch, stretch

REST = (np.pi / 2, 1.2)


def make(**options):
    rng = np.random.default_rng(0)
    parts = [
        stretch(5.0, offset=(0.7, 0.9), amplitude=(0.3, 0.4), phase=(0.2, 2.0)),
        Stretch(3.0, rng.normal(size=2), rng.normal(size=(3, 2)), rng.normal(size=(3, 2))),
        stretch(2.0, offset=(1.7, 2.9), amplitude=(0.3, 0.4), phase=(0.2, -2.0)),
    ]
    settings = {"angular_frequency": 8.0, "rest": REST, "blend": 2.0} | options
    return Schedule(parts, **settings)


def test_derivatives():
    gait, h = make(), 1e-4
    time = np.linspace(-0.5, gait.duration + 0.5, 1001)
    m = gait(time)
    ahead, behind = gait(time + h), gait(time - h)
    far, back = gait(time + 2 * h), gait(time - 2 * h)
    for i in (0, 1):
        rate = (8 * (ahead[i] - behind[i]) - (far[i] - back[i])) / (12 * h)
        np.testing.assert_allclose(m[i + 1], rate, atol=2e-6 * np.abs(m[i + 1]).max())


def test_second_derivative_is_continuous():
    gait = make()
    for edge in (0.0, 2.0, 5.0, 7.0, 8.0, 10.0, gait.duration):
        left, right = gait(edge - 1e-9), gait(edge + 1e-9)
        for a, b in zip(left, right, strict=True):
            np.testing.assert_allclose(a, b, atol=1e-6 * max(1.0, np.abs(a).max()))


def test_within_a_stretch_it_is_that_gait():
    gait = make()
    time = np.linspace(2.0, 5.0, 50)
    plain = rr.SinusoidalGait(
        offset=(0.7, 0.9), amplitude=(0.3, 0.4), phase=(0.2, 2.0), angular_frequency=8.0
    )
    for ours, theirs in zip(gait(time), plain(time), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-12)


def test_rest_before_and_after():
    gait = make()
    assert gait.duration == 12.0
    for t in (-1.0, 0.0, 12.0, 99.0):
        m = gait(t)
        np.testing.assert_allclose(m.angle, REST, atol=1e-14)
        assert not m.rate.any() and not m.acceleration.any()


def test_it_comes_back_from_json():
    gait = make()
    again = serial.from_dict(json.loads(json.dumps(gait.to_dict())), rr.Gait, "gait")
    time = np.linspace(0, 12, 100)
    np.testing.assert_array_equal(gait(time).acceleration, again(time).acceleration)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"blend": 2.5}, "stretch 2 takes 2 s: it must be at least the blend"),
        ({"rest": (1.0,)}, "offset of stretch 0"),
        ({"angular_frequency": 0}, "angular_frequency is 0"),
        ({"rest": (np.nan, 1.0)}, "rest"),
    ],
)
def test_what_is_refused(change, message):
    with pytest.raises(rr.RRRobotError, match=message):
        make(**change)
    with pytest.raises(rr.GaitError, match="at least one"):
        Schedule([], angular_frequency=8.0, rest=REST, blend=1.0)
