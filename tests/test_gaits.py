"""Gaits: exact derivatives, shapes, periods, and what they refuse."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rrrobot as rr
from tests.strategies import examples, vectors

frequencies = vectors(3, 0.5, 12.0)


def sinusoid(data: np.ndarray, omega: np.ndarray) -> rr.Gait:
    offset, amplitude, phase = data.reshape(3, 3)
    return rr.SinusoidalGait(
        offset=offset, amplitude=amplitude, angular_frequency=omega, phase=phase
    )


def fourier(data: np.ndarray, omega: np.ndarray) -> rr.Gait:
    cosine, sine = data[:6].reshape(2, 3), data[3:].reshape(2, 3)
    return rr.FourierGait(
        offset=data[:3], cosine=cosine, sine=sine, angular_frequency=float(omega[0])
    )


def ramp(data: np.ndarray, omega: np.ndarray) -> rr.Gait:
    return rr.RampIn(sinusoid(data, omega), duration=1.5)


def still(data: np.ndarray, omega: np.ndarray) -> rr.Gait:
    return rr.StillLegs(data[:3])


def cubic(data: np.ndarray, omega: np.ndarray) -> rr.Gait:
    a, b, c = 0.1 * data.reshape(3, 3)
    return rr.CallableGait(
        lambda t: (a + b * t + c * t**3, b + 3 * c * t**2, 6 * c * t), n_legs=3, period=2.0
    )


MAKERS = (sinusoid, fourier, ramp, still, cubic)
each_gait = pytest.mark.parametrize("make", MAKERS, ids=lambda make: make.__name__)


@each_gait
@given(data=vectors(9, -1.5, 1.5), omega=frequencies, t=st.floats(0.01, 3.0))
@examples(25)
def test_derivatives_are_those_of_the_angle(make, data, omega, t):
    gait, h = make(data, omega), 1e-4
    before, here, after = gait(t - h), gait(t), gait(t + h)
    rate = (after.angle - before.angle) / (2 * h)
    acceleration = (after.rate - before.rate) / (2 * h)
    # The error is h^2/6 times the third derivative, below 4000 rad/s^3 here.
    np.testing.assert_allclose(here.rate, rate, atol=1e-4)
    np.testing.assert_allclose(here.acceleration, acceleration, atol=2e-3)


@each_gait
@given(data=vectors(9, -1.5, 1.5), omega=frequencies)
@examples(5)
def test_shapes_and_arrays_of_times(make, data, omega):
    gait = make(data, omega)
    assert gait.n_legs == 3
    assert [part.shape for part in gait(0.7)] == [(3,)] * 3
    assert [part.shape for part in gait(np.array(0.7))] == [(3,)] * 3
    times = np.array([[0.0, 0.7, 1.3], [1.5, 2.0, 40.0]])
    motion = gait(times)
    assert [part.shape for part in motion] == [(2, 3, 3)] * 3
    assert [part.shape for part in gait([0.0, 1.0])] == [(2, 3)] * 3
    for index in np.ndindex(times.shape):
        for whole, one in zip(motion, gait(times[index]), strict=True):
            np.testing.assert_allclose(whole[index], one, atol=1e-13)


@each_gait
def test_to_dict_is_plain_data(make):
    data = make(np.linspace(0, 1, 9), np.array((1.0, 2.0, 3.0))).to_dict()
    assert isinstance(data["type"], str)
    assert all(isinstance(v, (str, float, list, dict)) for v in data.values())


def test_sinusoid_is_the_papers_equation():
    gait = rr.SinusoidalGait(offset=(1, 2), amplitude=(0.3, 0.4), angular_frequency=8, phase=(0, 1))
    angle, rate, acceleration = gait(0.25)
    np.testing.assert_allclose(angle, (1 + 0.3 * np.sin(2), 2 + 0.4 * np.sin(3)), rtol=1e-15)
    np.testing.assert_allclose(rate, (2.4 * np.cos(2), 3.2 * np.cos(3)), rtol=1e-14)
    np.testing.assert_allclose(acceleration, (-19.2 * np.sin(2), -25.6 * np.sin(3)), rtol=1e-14)


def test_scalars_are_repeated():
    def n_legs(**changes: Any) -> int:
        scalars = {"offset": 1.0, "amplitude": 0.3, "angular_frequency": 8.0, "phase": 0.0}
        return rr.SinusoidalGait(**(scalars | changes)).n_legs

    assert n_legs() == 2
    assert n_legs(n_legs=12) == 12
    assert n_legs(phase=(0, 1, 2)) == 3
    assert n_legs(offset=(0.5,)) == 1
    assert rr.StillLegs(1.0).angle.tolist() == [1.0, 1.0]
    assert rr.StillLegs(1.0, n_legs=3).angle.tolist() == [1.0] * 3
    assert rr.StillLegs(()).n_legs == 0


@pytest.mark.parametrize(
    ("omega", "period"),
    [
        ((8.0, 8.0), 2 * np.pi / 8),
        ((8.0, 16.0), 2 * np.pi / 8),
        ((6.0, 9.0), 2 * np.pi / 3),
        ((2.0, 3.0, 5.0), 2 * np.pi),
        ((0.8, 1.2), 2 * np.pi / 0.4),
        ((31.0, 32.0), 2 * np.pi),
    ],
)
def test_common_period_of_unequal_frequencies(omega, period):
    gait = rr.SinusoidalGait(offset=1, amplitude=0.3, angular_frequency=omega)
    assert gait.period == pytest.approx(period, rel=1e-14)
    times = np.linspace(0, 1, 7)
    np.testing.assert_allclose(gait(times).angle, gait(times + gait.period).angle, atol=1e-12)


@pytest.mark.parametrize("omega", [(8.0, 8.0 * np.sqrt(2)), (1.0, np.pi), (8.0, 8.0 + 1e-9)])
def test_incommensurate_frequencies_have_no_period(omega):
    gait = rr.SinusoidalGait(offset=1, amplitude=0.3, angular_frequency=omega)
    assert gait.period is None


def test_periods_of_the_others():
    assert rr.StillLegs(1.0).period is None
    assert rr.RampIn(rr.gait("lateral"), 2.0).period == rr.gait("lateral").period
    one = rr.FourierGait(offset=(1,), cosine=[[1]], sine=[[0]], angular_frequency=4.0)
    assert one.period == pytest.approx(np.pi / 2)


def test_fourier_of_one_harmonic_is_the_sinusoid():
    sine = rr.gait("circular", phase_difference=1.0)
    c, s = np.sin(sine.phase), np.cos(sine.phase)
    same = rr.FourierGait(
        offset=sine.offset, cosine=[0.3 * c], sine=[0.3 * s], angular_frequency=8.0
    )
    for a, b in zip(sine(np.linspace(0, 2, 20)), same(np.linspace(0, 2, 20)), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-13)


def test_ramp_starts_at_rest_and_becomes_the_gait():
    gait = rr.gait("lateral")
    ramped = rr.RampIn(gait, 2.0)
    start = ramped(0.0)
    np.testing.assert_array_equal(start.angle, gait(0.0).angle)
    np.testing.assert_array_equal((start.rate, start.acceleration), np.zeros((2, 2)))
    for time in (2.0, 2.5, 100.0):
        for part, full in zip(ramped(time), gait(time), strict=True):
            np.testing.assert_allclose(part, full, atol=1e-13)
    before, after = ramped(2.0 - 1e-7), ramped(2.0 + 1e-7)
    np.testing.assert_allclose(before.acceleration, after.acceleration, atol=1e-4)


def test_gaits_of_the_paper():
    lateral, circular = rr.gait("lateral"), rr.gait("circular")
    assert lateral.offset.tolist() == [np.pi / 2] * 2
    assert circular.offset.tolist() == [np.pi / 4] * 2
    for gait in (lateral, circular):
        assert gait.amplitude.tolist() == [0.3, 0.3]
        assert gait.angular_frequency.tolist() == [8.0, 8.0]
        assert gait.phase.tolist() == [0.0, np.pi / 2]


BAD_SINUSOIDS: list[tuple[dict[str, Any], str]] = [
    ({"offset": (1, 2, 3), "amplitude": (1, 2)}, "amplitude has shape (2,)"),
    ({"offset": [[1, 2]]}, "offset has shape (1, 2)"),
    ({"offset": (1, np.nan)}, "offset is [1.0, nan]: every entry must be finite"),
    ({"amplitude": np.inf}, "amplitude is [inf, inf]"),
    ({"phase": "late"}, "phase is 'late'"),
    ({"phase": True}, "phase is True"),
    ({"phase": (0, 1j)}, "phase is (0, 1j)"),
    ({"angular_frequency": 0}, "angular_frequency is [0.0, 0.0] rad/s: it must be greater"),
    ({"angular_frequency": (8, -8)}, "angular_frequency is [8.0, -8.0]"),
    ({"n_legs": 3, "offset": (1, 2)}, "offset has shape (2,)"),
    ({"n_legs": -1}, "n_legs is -1"),
    ({"n_legs": 1.5}, "n_legs is 1.5"),
]


@pytest.mark.parametrize(("changes", "says"), BAD_SINUSOIDS)
def test_bad_sinusoids(changes, says):
    with pytest.raises(rr.GaitError) as caught:
        rr.SinusoidalGait(**({"offset": 1, "amplitude": 0.3, "angular_frequency": 8} | changes))
    assert says in str(caught.value)
    assert isinstance(caught.value, ValueError)


BAD_FOURIERS: list[tuple[dict[str, Any], str]] = [
    ({"offset": 1.0}, "offset has shape ()"),
    ({"cosine": [[1, 2, 3]]}, "cosine has shape (1, 3)"),
    ({"cosine": [[1, 2], [3, 4]]}, "cosine has shape (2, 2) and sine (1, 2)"),
    ({"cosine": [[1, "a"]]}, "cosine is"),
    ({"cosine": [[1, 2], [3]]}, "cosine is"),
    ({"sine": [[1, np.nan]]}, "sine is [[1.0, nan]]"),
    ({"sine": np.zeros((1, 2, 2))}, "sine has shape (1, 2, 2)"),
    ({"angular_frequency": -8}, "angular_frequency is -8.0 rad/s"),
    ({"angular_frequency": (8, 8)}, "angular_frequency is (8, 8) rad/s"),
]


@pytest.mark.parametrize(("changes", "says"), BAD_FOURIERS)
def test_bad_fouriers(changes, says):
    good = {"offset": (1, 1), "cosine": [[1, 2]], "sine": [[3, 4]], "angular_frequency": 8}
    with pytest.raises(rr.GaitError) as caught:
        rr.FourierGait(**(good | changes))
    assert says in str(caught.value)


ZERO, ONE = np.zeros(2), np.ones(2)
BAD_CALLABLES: list[tuple[Any, str]] = [
    (lambda t: (t * t * np.ones(2), 3 * t * np.ones(2), 3 * np.ones(2)), "its rate at t = "),
    (lambda t: (t * t * np.ones(2), 2 * t * np.ones(2), ZERO), "its acceleration at t = "),
    (lambda t: (np.sin(t * ONE), 1.02 * np.cos(t * ONE), -1.02 * np.sin(t * ONE)), "its rate"),
    (lambda t: (np.abs(t - 5) * np.ones(2), np.sign(t - 5) * np.ones(2), ZERO), "t = 5 s"),
    (lambda t: (ZERO, ZERO), "returned tuple"),
    (lambda t: [ZERO] * 3, "returned list"),
    (lambda t: None, "returned NoneType"),
    (lambda t: (ZERO, np.zeros(3), ZERO), "rate of gait"),
    (lambda t: (ZERO, ZERO, 0.0), "acceleration of gait"),
    (lambda t: (np.array([0, np.nan]), ZERO, ZERO), "angle of gait"),
    (lambda t: (("a", "b"), ZERO, ZERO), "angle of gait"),
    (3, "function is 3"),
]


@pytest.mark.parametrize(("function", "says"), BAD_CALLABLES)
def test_callable_gait_is_checked_when_made(function, says):
    with pytest.raises(rr.GaitError) as caught:
        rr.CallableGait(function, n_legs=2)
    assert says in str(caught.value)


@pytest.mark.parametrize("options", [{"period": 0}, {"period": np.nan}, {"check_span": (1, 1)},
                                     {"check_span": (0, np.nan)}, {"n_legs": 2.0}])  # fmt: skip
def test_bad_options_of_a_callable_gait(options):
    (name,) = options
    with pytest.raises(rr.GaitError, match=f"^{name} is"):
        rr.CallableGait(lambda t: (ZERO,) * 3, **({"n_legs": 2} | options))


def test_check_span_is_all_that_is_checked():
    def late_mistake(t):
        angle = t * np.ones(2)
        return angle, np.ones(2) if t < 2 else ZERO, ZERO

    rr.CallableGait(late_mistake, n_legs=2, check_span=(0, 1))
    with pytest.raises(rr.GaitError):
        rr.CallableGait(late_mistake, n_legs=2, check_span=(0, 4))


def test_name_of_a_callable_gait():
    def hop(t):
        return ZERO, ZERO, ZERO

    named = (
        rr.CallableGait(hop, n_legs=2).to_dict()["name"],
        rr.CallableGait(hop, n_legs=2, name="mine").to_dict()["name"],
    )
    assert named == ("hop", "mine")


@pytest.mark.parametrize("gait", [3, None, rr.LegTorques(0.0, angle=(1, 1))])
def test_ramp_needs_a_gait(gait):
    with pytest.raises(rr.GaitError, match="RampIn blends into a Gait"):
        rr.RampIn(gait, 1.0)


@pytest.mark.parametrize("duration", [0, -1, np.nan, np.inf, "1"])
def test_ramp_needs_a_duration(duration):
    with pytest.raises(rr.GaitError, match=r"^duration is"):
        rr.RampIn(rr.gait("lateral"), duration)


@pytest.mark.parametrize("angle", ["up", (1, np.nan), [[1, 2]], None])
def test_still_legs_need_angles(angle):
    with pytest.raises(rr.GaitError, match=r"^angle (is|has)"):
        rr.StillLegs(angle)


def test_unknown_gait():
    with pytest.raises(rr.GaitError, match="'sideways': it must be one of lateral, circular"):
        rr.gait("sideways")
