"""The robot as a unicycle, and the reachable set with its boundary."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.drive.schedule import Schedule, stretch
from rrrobot.steering import Gear, Unicycle, reachable_set
from rrrobot.steering.gears import GEARS
from rrrobot.steering.motions import motions_of
from rrrobot.steering.standing import standing
from tests.some import some

PERIOD = np.pi / 4


@pytest.fixture(scope="module")
def model(home):
    return rr.FullModel(rr.Robot.from_parameters())


@pytest.fixture(scope="module")
def motions(model):
    return motions_of(model)


def driven(offset, amplitude, lead, cycles=40):
    part = stretch(cycles * PERIOD, offset=(offset,) * 2, amplitude=amplitude, phase=(0, lead))
    return Schedule([part], angular_frequency=8.0, rest=(np.pi / 2,) * 2, blend=2 * PERIOD)


def test_its_twist_is_the_map_at_its_nodes(model, motions):
    wheel = Unicycle(model, motions)
    some = slice(0, None, 97)
    found = wheel.twist(motions.offset[some], motions.amplitude[some],
                        motions.phase_difference[some])  # fmt: skip
    np.testing.assert_allclose(found, motions.twist[some], atol=1e-12)
    again = wheel.twist(0.7, 0.3, 1.0 + 2 * np.pi)
    np.testing.assert_allclose(again, wheel.twist(0.7, 0.3, 1.0), atol=1e-15)
    assert Unicycle(model, motions, slips=False).twist(0.7, 0.3, 1.0)[0] == 0.0
    with pytest.raises(rr.ParameterError, match="the map of motions has"):
        wheel.twist(4.0, 0.3, 1.0)


@pytest.mark.parametrize(
    ("name", "offset", "amplitude"),
    some(
        [
            (f"{name} {amplitude}", offset, amplitude)
            for name, offset in (("lateral", np.pi / 2), ("circular", np.pi / 4))
            for amplitude in (0.1, 0.3, 0.5)
        ],
        by_default={"circular 0.5"},
        name=lambda case: case[0],
    ),
)
def test_it_is_near_the_full_model(model, motions, name, offset, amplitude):
    lead = np.pi / 2
    run = Unicycle(model, motions).compared(driven(offset, amplitude, lead))
    # A cycle or two of delay where the robot starts and stops: not a part of the path.
    assert run.distance < 0.002 + 0.02 * run.length
    assert run.turn < np.deg2rad(2.0)
    strict = Unicycle(model, motions, slips=False, leans=False).compared(
        driven(offset, amplitude, lead)
    )
    assert strict.distance > 0.999 * run.distance


def test_where_it_leans_it_rolls(model, motions):
    """Legs that go to another offset and do not swing: the robot rolls by its lean."""
    gait = driven(np.pi / 4, 0.0, 0.0, cycles=60)
    end = Unicycle(model, motions).poses(gait, np.array((59 * PERIOD,)), np.zeros(3))[0]
    pitch = standing(model, np.full(2, np.pi / 4))[1]
    np.testing.assert_allclose(end, (0.12 * pitch, 0.0, 0.0), atol=2e-6)
    back = Unicycle(model, motions).poses(gait, np.array((gait.duration,)), np.zeros(3))[0]
    np.testing.assert_allclose(back, 0, atol=1e-12)


@pytest.mark.parametrize("name", GEARS)
def test_the_boundary_bounds(motions, name):
    """No gait of the gear is beyond it, and its corners are gaits."""
    gear = Gear(motions, name)
    curvature, slow, fast = gear.boundary(41)
    assert np.all(slow <= fast)
    for share in (0.1, 0.5, 1.0):
        bend, speed = gear.curve(share)
        inside = np.interp(bend, curvature, fast)
        assert np.all(speed <= inside + 0.02 * fast.max())
    k = 0.5 * gear.curvature[1]
    assert gear.reaches(0.5 * gear.fastest(k), k)
    assert not gear.reaches(1.01 * gear.fastest(k), k)
    assert not gear.reaches(0.001, 1.01 * gear.curvature[1])


@pytest.mark.slow
def test_a_direction_that_a_model_lacks(model):
    """Single-axis models do not travel across their legs."""
    apart = motions_of(model, decoupled=True)
    with pytest.raises(rr.ModelError, match="'forward' do not travel"):
        Gear(apart, "forward")
    figure = reachable_set({"full": motions_of(model), "decoupled": apart})
    names = [[drawn.get_label() for drawn in ax.get_lines()] for ax in figure.axes]
    assert "decoupled" not in names[0] and "decoupled" in names[1]
