"""The steady state of motions whose drift, amplitudes and phases are known."""

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rrrobot as rr
from tests import synthetic
from tests.strategies import examples, vectors

OMEGA = 8.0
PERIOD = 2 * np.pi / OMEGA
STILL = np.zeros(3)


def motion(
    *,
    amplitude: np.ndarray = STILL,
    phase: np.ndarray = STILL,
    mean: np.ndarray = STILL,
    drift: np.ndarray = STILL,
    velocity: np.ndarray = STILL[:2],
    wobble: float = 0.0,
    interval: float = 0.01,
    duration: float = 20.0,
    metadata: dict[str, Any] | None = None,
) -> rr.Trajectory:
    """Euler angles mean + drift t + amplitude sin(omega t + phase); contact point v t + wobble.

    v turns with the drift of the yaw, as it does on level ground. Both also have a second harmonic,
    which none of the results may see.
    """
    time = np.arange(0, duration + interval / 2, interval)
    swing = np.sin(np.add.outer(OMEGA * time, phase)) * amplitude
    second = 0.01 * np.cos(2 * OMEGA * time)[:, None]
    euler = mean + np.outer(time, drift) + swing + second
    turned = np.exp(1j * drift[2] * time / 2) * np.sinc(drift[2] * time / (2 * np.pi)) * time
    way = turned * complex(*velocity)
    position = (
        np.column_stack((way.real, way.imag))
        + wobble * np.sin(OMEGA * time + 0.3)[:, None]
        + second
    )
    given_period = {"period": PERIOD} if metadata is None else metadata
    return synthetic.trajectory(
        time.size, time=time, euler=euler, position=position, metadata=given_period
    )


@given(
    amplitude=vectors(3, 0.01, 0.5),
    phase=vectors(3, -3.1, 3.1),
    mean=vectors(3, -1, 1),
    drift=vectors(3, -0.2, 0.2),
    velocity=vectors(2, -0.05, 0.05).filter(lambda v: np.linalg.norm(v) > 1e-3),
)
@examples(25)
def test_known_drift_amplitude_and_phase(amplitude, phase, mean, drift, velocity):
    drift = drift * (0, 0, 1)  # a roll or a pitch that drifts turns the body over
    t = motion(
        amplitude=amplitude, phase=phase, mean=mean, drift=drift, velocity=velocity, wobble=0.02
    )
    s = t.steady_state()
    # Steps are chords between means over arcs of the circle.
    speed = float(np.linalg.norm(velocity)) * np.sinc(drift[2] * PERIOD / (2 * np.pi)) ** 2
    assert s.speed == pytest.approx(speed, abs=1e-8)
    assert s.yaw_rate == pytest.approx(drift[2], abs=1e-8)
    assert s.curvature == pytest.approx(drift[2] / speed, rel=1e-5, abs=1e-5)
    np.testing.assert_allclose(s.amplitude, amplitude, atol=1e-8)
    np.testing.assert_allclose(np.exp(1j * s.phase), np.exp(1j * phase), atol=1e-6)
    middle = s.after + 0.5 * s.cycles * s.period
    np.testing.assert_allclose(s.mean, mean + drift * middle, atol=1e-8)
    assert s.variation < 1e-4
    difference = np.exp(1j * (phase[1] - phase[2]))
    assert np.exp(1j * s.pitch_yaw_phase_difference) == pytest.approx(difference, abs=1e-6)


@given(st.floats(-3, 3), vectors(2, -0.05, 0.05))
@examples(20)
def test_velocity_is_in_the_bodys_mean_axes(yaw, velocity):
    s = motion(mean=np.array((0, 0, yaw)), velocity=velocity).steady_state()
    c, s_ = np.cos(yaw), np.sin(yaw)
    np.testing.assert_allclose(s.velocity, np.array(((c, s_), (-s_, c))) @ velocity, atol=1e-8)


def test_circle_has_its_curvature():
    """Uniform motion round a circle: chords of the cycle means are shorter by a known factor."""
    radius, rate = 0.5, 0.2
    time = np.arange(0, 20.005, 0.01)
    position = radius * np.column_stack((np.cos(rate * time), np.sin(rate * time)))
    euler = np.column_stack((0 * time, 0 * time, rate * time + np.pi / 2))
    t = synthetic.trajectory(
        time.size, time=time, euler=euler, position=position, metadata={"period": PERIOD}
    )
    s = t.steady_state()
    half = 0.5 * rate * PERIOD
    chord = 2 * radius * (np.sin(half) / half) * np.sin(half) / PERIOD
    assert s.speed == pytest.approx(chord, abs=1e-10)
    assert s.yaw_rate == pytest.approx(rate, abs=1e-10)
    np.testing.assert_allclose(s.velocity, (chord, 0), atol=1e-10)


def test_counted_cycles_are_whole_and_begin_at_multiples_of_the_period():
    t = motion(velocity=np.array((0.01, 0)), duration=20.0)
    s = t.steady_state()
    assert s.after == pytest.approx(13 * PERIOD)
    assert s.after >= 10.0
    assert s.cycles == 12
    from_zero = t.steady_state(after=0)
    assert (from_zero.after, from_zero.cycles) == (0.0, 25)
    late = t.steady_state(after=3 * PERIOD)
    assert late.after == pytest.approx(3 * PERIOD)
    assert late.cycles == 22


def test_transient_before_the_start_does_not_count():
    t = motion(velocity=np.array((0.01, 0)))
    t.euler[t.time < 9.5, 2] += 5.0
    t.position[t.time < 9.5] += 3.0
    s = t.steady_state()
    assert s.speed == pytest.approx(0.01, abs=1e-9)
    assert s.yaw_rate == pytest.approx(0, abs=1e-9)
    with pytest.warns(rr.UnsettledWarning):
        assert t.steady_state(after=5.0).variation > 1


def test_variation_tells_a_motion_that_has_not_settled():
    time = np.arange(0, 20.005, 0.01)
    position = np.column_stack((0.01 * time * (1 + 0.02 * time), 0 * time))
    t = synthetic.trajectory(
        time.size, time=time, euler=np.zeros((time.size, 3)), position=position,
        metadata={"period": PERIOD},
    )  # fmt: skip
    with pytest.warns(rr.UnsettledWarning, match=r"9\.8 %"):
        s = t.steady_state()
    steps = 0.01 * (1 + 0.04 * (s.after + PERIOD * np.arange(1, s.cycles)))
    assert s.speed == pytest.approx(steps.mean(), abs=1e-10)
    assert s.variation == pytest.approx((steps.max() - steps.mean()) / steps.mean(), rel=1e-6)


def test_nothing_moves():
    s = motion().steady_state()
    assert s.speed == pytest.approx(0, abs=1e-12)
    assert s.curvature == 0.0
    assert json.loads(json.dumps(s.to_dict()))["cycles"] == 12


@pytest.mark.parametrize("rate", [0.2, -0.2])
def test_turn_on_the_spot_has_infinite_curvature(rate):
    time = np.arange(0, 20.005, 0.01)
    euler = np.column_stack((0 * time, 0 * time, rate * time))
    t = synthetic.trajectory(
        time.size, time=time, euler=euler, position=np.zeros((time.size, 2)),
        metadata={"period": PERIOD},
    )  # fmt: skip
    s = t.steady_state()
    assert s.curvature == math.copysign(math.inf, rate)
    assert s.to_dict()["curvature"] is None


def test_a_period_may_be_given():
    t = motion(velocity=np.array((0.01, 0)), metadata={})
    assert t.steady_state(period=PERIOD).speed == pytest.approx(0.01, abs=1e-9)
    twice = t.steady_state(period=2 * PERIOD)
    assert twice.speed == pytest.approx(0.01, abs=1e-9)
    assert twice.cycles == 5


def test_last_interval_may_be_short():
    t = motion(velocity=np.array((0.01, 0)), duration=20.0)
    cut = {name: getattr(t, name)[:-1] for name in ("time", "euler", "position")}
    # 20 s becomes 19.993 s.
    cut["time"] = np.append(cut["time"], 19.993)
    cut["euler"] = np.vstack((cut["euler"], t.euler[-1:]))
    exact = 0.01 * np.array([[19.993, 0]]) + 0.01 * np.cos(2 * OMEGA * 19.993)
    cut["position"] = np.vstack((cut["position"], exact))
    u = synthetic.trajectory(cut["time"].size, metadata={"period": PERIOD}, **cut)
    assert u.steady_state().speed == pytest.approx(0.01, abs=1e-8)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({}, "the gait has no period"),
        ({"period": 0}, "period is 0.0 s: it must be greater than zero"),
        ({"period": np.nan}, "period is nan s"),
        ({"period": "long"}, "period is 'long' s"),
        ({"period": PERIOD, "after": -1}, "after is -1.0 s: it must be at least zero"),
        ({"period": PERIOD, "after": np.inf}, "after is inf s"),
        ({"period": PERIOD, "after": 18.8}, "only 1 whole cycles"),
        ({"period": PERIOD, "after": 25.0}, "only 0 whole cycles"),
        ({"period": 9.0}, "only 0 whole cycles of 9 s fit between 18 s and 20 s"),
        ({"period": 0.2}, "20 samples per cycle: a steady state needs 24"),
    ],
)
def test_what_has_no_steady_state(options, says):
    t = motion(metadata={"period": None})
    with pytest.raises(rr.ParameterError) as caught:
        t.steady_state(**options)
    assert says in str(caught.value)


def test_enough_samples_are_told():
    t = motion(interval=0.05)
    with pytest.raises(rr.ParameterError, match=r"15\.7 samples.*sample_interval <= 0\.03272 s"):
        t.steady_state()
    assert motion(interval=0.0327).steady_state().cycles == 12


def test_phase_difference_is_principal():
    half = motion(amplitude=np.full(3, 0.1), phase=np.array((0, np.pi / 2, -np.pi / 2)))
    assert abs(half.steady_state().pitch_yaw_phase_difference) == pytest.approx(np.pi, abs=1e-6)
    lead = motion(amplitude=np.full(3, 0.1), phase=np.array((0, 3.0, -3.0)))
    expected = 6.0 - 2 * np.pi
    assert lead.steady_state().pitch_yaw_phase_difference == pytest.approx(expected, abs=1e-6)


def test_it_prints_as_a_table():
    t = rr.simulate(rr.FullModel(rr.Robot.from_parameters()), rr.gait("lateral"), 6.0)
    lines = str(t.steady_state(after=3.0)).splitlines()
    assert lines[0].split()[0] == "speed" and lines[0].endswith(" mm/s")
    assert [line.split("  ")[0] for line in lines] == [
        "speed", "yaw rate", "curvature", "roll", "pitch", "yaw", "counted", "steps vary by",
    ]  # fmt: skip
