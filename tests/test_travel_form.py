"""Travel to second order against exact limit cycles and the contact's kinematics."""

import numpy as np
import pytest

import rrrobot as rr

ROBOT = rr.Robot.from_parameters()
FULL = rr.FullModel(ROBOT)


def gait_of(offset, amplitude):
    return rr.SinusoidalGait(offset=offset, amplitude=amplitude, angular_frequency=8.0,
                             phase=(0.0, 1.2))  # fmt: skip


@pytest.fixture(scope="module")
def forms():
    return {
        offset: rr.orbits.travel_form(FULL, offset=offset, angular_frequency=8.0)
        for offset in (np.pi / 2, 0.9)
    }


@pytest.mark.parametrize("offset", [np.pi / 2, 0.9])
def test_the_error_is_of_fourth_order(forms, offset):
    """From 0.2 to 0.0125 rad: halving the amplitude divides the error of v by 16."""
    amplitudes = 0.2 * 0.5 ** np.arange(5)
    errors = []
    for a in amplitudes:
        exact = rr.limit_cycle(FULL, gait_of(offset, a))
        errors.append(abs(forms[offset].predict(gait_of(offset, a)).speed - exact.speed))
        if a < 0.06:
            assert errors[-1] < 0.02 * exact.speed
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    np.testing.assert_allclose(ratios[:3], 16.0, rtol=0.25)


def test_yaw_rate_of_small_gaits(forms):
    small = gait_of(0.9, 0.02)
    exact = rr.limit_cycle(FULL, small)
    assert forms[0.9].predict(small).yaw_rate == pytest.approx(exact.yaw_rate, rel=5e-3)
    assert abs(exact.yaw_rate) > 1e-5


@pytest.mark.parametrize("offset", [np.pi / 2, 0.9])
def test_travel_is_the_area_of_the_linear_response(forms, offset):
    """v from the phases of roll, pitch and yaw, by the rolling contact to second order."""
    a = 0.004
    c = rr.limit_cycle(FULL, gait_of(offset, a))
    swing, phase, r, omega = c.amplitude, c.phase, 0.12, 8.0

    def mean(i, j):
        """<angle_i angle_j'>"""
        return 0.5 * omega * swing[i] * swing[j] * np.sin(phase[i] - phase[j])

    tilt = c.mean[1]
    expected = (
        r * np.cos(tilt) * mean(2, 0),
        r * mean(2, 1) + r * np.sin(tilt) * mean(1, 0),
    )
    found = forms[offset].predict(gait_of(offset, a)).velocity
    np.testing.assert_allclose(found, expected, atol=2e-4 * np.linalg.norm(expected))


def test_best_small_gait_is_best(forms):
    gait, travel = forms[np.pi / 2].best()
    rng = np.random.default_rng(0)
    for _ in range(50):
        u = rng.normal(size=4)
        u /= np.linalg.norm(u)
        assert (
            abs(forms[np.pi / 2].of(*np.split(u, 2)).velocity[1]) <= abs(travel.velocity[1]) + 1e-12
        )
    # Neither in phase nor opposed, and both legs swing.
    assert gait.amplitude[0] == pytest.approx(gait.amplitude[1], rel=0.05)
    assert abs(np.sin(gait.phase[1] - gait.phase[0])) > 0.5


def test_other_gaits_are_refused(forms):
    with pytest.raises(rr.GaitError, match="make another with travel_form"):
        forms[np.pi / 2].predict(gait_of(1.0, 0.1))
    with pytest.raises(rr.GaitError, match="has no period"):
        forms[np.pi / 2].predict(rr.StillLegs((1.0, 1.0)))
    two = rr.FourierGait(
        offset=np.full(2, np.pi / 2), sine=[[0.1, 0.1], [0.02, 0.0]], cosine=np.zeros((2, 2)),
        angular_frequency=8.0,
    )  # fmt: skip
    with pytest.raises(rr.GaitError, match="one harmonic"):
        forms[np.pi / 2].predict(two)
