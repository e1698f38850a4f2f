"""Every kind of gait and move comes back from its own `to_dict`, through JSON, to the last bit."""

import json

import numpy as np
import pytest

import rrrobot as rr
from rrrobot import serial
from rrrobot.drive.moves import LegMoves, Loops, Move, Straight
from rrrobot.drive.schedule import Schedule, stretch
from rrrobot.drive.tables import gait_from_dict

_LOOPS = Loops(center=np.array((1.0, 2.0)), amplitude=np.array((0.2, 0.3)),
               phase=np.array((0.1, 0.7)), turns=2, duration=3.0, ramp=0.25)  # fmt: skip
_STRAIGHT = Straight(start=_LOOPS.end, end=np.array((0.4, 1.1)), duration=0.7, ramp=0.4)
GAITS = {
    "sinusoidal": rr.SinusoidalGait(offset=(0.7, 1.1), amplitude=(0.2, 0.3),
                                    angular_frequency=(8.0, 4.0), phase=(0.1, 2.0)),
    "fourier": rr.FourierGait(offset=(1.0, 2.0), cosine=[[0.0, 0.1], [0.2, 0.0]],
                              sine=[[0.3, 0.0], [0.0, 0.1]], angular_frequency=3.0),
    "still": rr.StillLegs((1.0, 2.0)),
    "ramp_in": rr.RampIn(rr.gait("circular"), 2.0),
    "leg_moves": LegMoves([_LOOPS, _STRAIGHT]),
    "sampled": rr.SampledGait(np.linspace(0.0, 2.0, 9),
                              np.sin(np.pi * np.linspace(0.0, 2.0, 9))[:, None] * (0.2, 0.3)),
    "schedule": Schedule([stretch(6.0, offset=(1.5, 1.4), amplitude=0.3, phase=(0.0, 1.5))],
                         angular_frequency=8.0, rest=(1.5, 1.4), blend=2.0),
}  # fmt: skip


def registered(family):
    """Names of our own classes of a family."""
    return {
        name
        for name, cls in serial._CLASSES.items()
        if issubclass(cls, family) and cls.__module__.startswith("rrrobot.")
    }


@pytest.mark.parametrize("name", sorted(registered(rr.Gait)))
def test_every_registered_gait_comes_back(name):
    # A new kind of gait fails here, by a KeyError, until it has an example above.
    gait = GAITS[name]
    assert gait.to_dict()["type"] == name
    again = gait_from_dict(json.loads(json.dumps(gait.to_dict())))
    assert type(again) is type(gait)
    assert again.n_legs == gait.n_legs and again.period == gait.period
    time = np.linspace(0.0, 4.0, 57)
    for ours, theirs in zip(gait(time), again(time), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_moves_have_an_example_each():
    assert registered(Move) == {move.to_dict()["type"] for move in GAITS["leg_moves"].moves}


def test_a_gait_of_ones_own_comes_back_within_another():
    @rr.register("test_gaits_saved.half")
    class Half(rr.StillLegs):
        def to_dict(self):
            return {"type": "test_gaits_saved.half", "angle": self.angle.tolist()}

    again = gait_from_dict(rr.RampIn(Half((1.0, 1.5)), 1.0).to_dict())
    assert type(again.gait) is Half and again(0.3).angle.tolist() == [1.0, 1.5]


@pytest.mark.parametrize(
    ("data", "text"),
    [
        ({"type": "callable", "name": "f", "period": None}, "gait type is 'callable'"),
        ({"type": "sphere", "radius": 0.1}, "gait type is 'sphere'"),
        ([], "gait type is"),
        ({"type": "sinusoidal", "offset": 1.0}, "amplitude"),
        ({"type": "ramp_in", "duration": 1.0}, "lacks the entry gait"),
        ({"type": "leg_moves", "moves": []}, "moves is empty"),
        ({"type": "leg_moves", "moves": [{"type": "jump"}]}, "move type is 'jump'"),
    ],
)
def test_what_cannot_come_back_is_told(data, text):
    with pytest.raises(rr.GaitError, match=text):
        gait_from_dict(data)
