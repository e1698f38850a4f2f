"""Derivatives of limit cycles against central differences of limit cycles found anew."""

import dataclasses

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.orbits.gradients import OUTPUTS
from tests.random_robot import random_robot

PARAMETERS = rr.RRRobotParameters()
ROBOT = rr.Robot.from_parameters(PARAMETERS)
BASE = {"offset": (0.8, 0.9), "amplitude": (0.3, 0.35), "angular_frequency": 7.0,
        "phase": (0.0, 1.2)}  # fmt: skip


def outputs(c):
    return np.array((c.speed, c.yaw_rate, c.curvature, *c.amplitude))


def central(make, step, f):
    """Richardson-extrapolated central difference of f(limit cycle) over a parameter."""
    low, high, lower, higher = (f(make(k * step)) for k in (-1, 1, -2, 2))
    return (8 * (high - low) - (higher - lower)) / (12 * step)


def with_gait(key, leg=None):
    def make(d):
        parts = dict(BASE)
        if leg is None:
            parts[key] = BASE[key] + d
        else:
            parts[key] = tuple(v + d * (i == leg) for i, v in enumerate(BASE[key]))
        return rr.limit_cycle(rr.FullModel(ROBOT), rr.SinusoidalGait(**parts))

    return make


def with_robot(key):
    def make(d):
        changed = dataclasses.replace(PARAMETERS, **{key: getattr(PARAMETERS, key) + d})
        model = rr.FullModel(rr.Robot.from_parameters(changed))
        return rr.limit_cycle(model, rr.SinusoidalGait(**BASE))

    return make


CASES = {
    "offset[0]": (with_gait("offset", 0), 1e-2),
    "amplitude[1]": (with_gait("amplitude", 1), 5e-3),
    "phase[1]": (with_gait("phase", 1), 1e-2),
    "angular_frequency": (with_gait("angular_frequency"), 2e-2),
    "leg_mass": (with_robot("leg_mass"), 2e-4),
    "shell_radius": (with_robot("shell_radius"), 3e-4),
    "leg_length": (with_robot("leg_length"), 3e-4),
    "damping": (with_robot("damping"), 5e-5),
    "gravity": (with_robot("gravity"), 2e-2),
}


@pytest.fixture(scope="module")
def found():
    return rr.orbits.sensitivities(rr.limit_cycle(rr.FullModel(ROBOT), rr.SinusoidalGait(**BASE)))


@pytest.mark.parametrize("name", CASES)
def test_against_differences_of_orbits(found, name):
    make, step = CASES[name][0], CASES[name][1] / 4
    expected = central(make, step, outputs)
    got = np.array([found.of(output, name) for output in OUTPUTS])
    np.testing.assert_allclose(got, expected, rtol=1e-6, atol=1e-8 * np.abs(expected).min())


@pytest.mark.parametrize("name", ["offset[0]", "leg_mass", "damping"])
def test_multipliers_against_differences_of_orbits(found, name):
    make, step = CASES[name][0], CASES[name][1] / 4
    expected = central(make, step, lambda c: c.multipliers)
    got = found.multipliers[found.names.index(name)]
    np.testing.assert_allclose(got, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


def test_speed_of_turned_phases_is_a_time_shift(found):
    """Both legs' phases moved alike: the same motion, begun elsewhere. Amplitudes stay."""
    for output in ("yaw_rate", "roll_amplitude", "pitch_amplitude"):
        both = found.of(output, "phase[0]") + found.of(output, "phase[1]")
        assert abs(both) < 1e-8 * max(abs(found.of(output, "phase[0]")), 1e-3)


def test_scaling_all_lengths_and_masses():
    """Similarity: masses and damping times k leave the motion as it is (Euler's theorem)."""
    c = rr.limit_cycle(rr.FullModel(ROBOT), rr.gait("circular"))
    s = rr.orbits.sensitivities(c, ["leg_mass", "servo_mass", "battery_mass", "damping"])
    weights = np.array([p.value for p in s.parameters])
    for output in OUTPUTS:
        parts = weights * s.derivatives[output]
        assert abs(parts.sum()) < 1e-9 * np.abs(parts).max()


def test_any_robot_has_masses_and_radius():
    model = rr.FullModel(random_robot(1), damping=rr.BodyRateDamping(0.4, 0.4, 0.4))
    gait = rr.SinusoidalGait(offset=np.linspace(-0.2, 0.3, 12), amplitude=0.2,
                             angular_frequency=7.0, phase=np.arange(12.0))  # fmt: skip
    c = rr.limit_cycle(model, gait)
    s = rr.orbits.sensitivities(c)
    masses = [i for i, p in enumerate(s.parameters) if p.unit == "kg"]
    assert len(masses) == 13
    weights = np.array([p.value for p in s.parameters])
    losses = [i for i, name in enumerate(s.names) if name in
              ("damping_roll", "damping_pitch", "damping_yaw")]  # fmt: skip
    parts = (weights * s.derivatives["yaw_rate"])[masses + losses]
    assert abs(parts.sum()) < 1e-8 * np.abs(parts).max()


def test_ranking_plot_and_data(found, tmp_path):
    ranked = found.ranked("yaw_rate")
    effects = np.abs(found.effects("yaw_rate"))
    assert effects[found.names.index(ranked[0])] == effects.max()
    ax = found.plot("yaw_rate")
    ax.figure.savefig(tmp_path / "bars.png")
    assert found.to_dict()["parameters"][0]["name"] == found.names[0]


def test_bad_names(found):
    with pytest.raises(rr.ParameterError, match="no parameter 'legs' here: it must be one of off"):
        rr.orbits.sensitivities(found.cycle, ["legs"])
    with pytest.raises(rr.ParameterError, match="output is 'pace'"):
        found.of("pace", "gravity")
