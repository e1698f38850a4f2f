"""Any shell on any ground: reference values of an independent derivation, closed forms, invariants."""

from dataclasses import replace

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.drive.gaits import LegMotion
from tests.terrain import BOULDER, EGG, EL, GAIT, GRAPH, LEVEL, PAIRS, SLOPE, SP, START, model

STATE = {
    "A": (
        (-1.598862210, -8.875594031, -3.665430516),
        (-0.378087961, 0.092878889, 5.050288881),
        (0.055456467, 0.033894633),
        (-0.049375417, -0.086803671, 0.000000000),
    ),
    "B": (
        (-2.909223190, -14.529631564, -4.844809012),
        (-0.572667911, 0.171062543, 4.935816178),
        (0.061255944, 0.037875039),
        (-0.052234991, -0.090836345, 0.000113341),
    ),
    "C": (
        (-7.536027573, 6.183251638, -3.606850237),
        (0.187852609, 0.255706471, 5.056617466),
        (0.040654809, 0.013453227),
        (-0.025231803, -0.053108549, 0.003647747),
    ),
    "D": (
        (-2.503723385, -8.417273565, -3.879457252),
        (-0.494906568, 0.175414937, 5.034728216),
        (0.055872504, 0.033681431),
        (-0.055669906, -0.127709210, -0.000000000),
    ),
    "E": (
        (-3.034773044, -1.901665951, -3.254941594),
        (-0.118224200, 0.120895820, 5.107052147),
        (0.048596851, 0.025781027),
        (-0.041492681, -0.074147035, -0.000000000),
    ),
    "F": (
        (-6.545140933, -0.463930210, -4.152663767),
        (-0.049219940, 0.247419436, 5.081513767),
        (0.047927602, 0.021135321),
        (-0.038672358, -0.063216640, 0.004861664),
    ),
    "G": (
        (-0.098397164, -16.205742716, -4.106501057),
        (-0.645511085, 0.063940516, 4.906002076),
        (0.061928597, 0.041938835),
        (-0.049020275, -0.091341333, -0.003099870),
    ),
}
"""alpha [rad/s^2], force [N], torque [N m], P_dot [m/s] at the state below, world."""
TEN = {
    "A": (
        (-0.124590002, 0.286675680, -0.108483113),
        (0.055370907, 0.074585901, -0.000000000),
        (-0.432836098, -0.245611048, 5.080677790),
        (0.065506841, 0.063925953),
    ),
    "B": (
        (-0.186737727, 0.218690643, 0.032768576),
        (0.028270601, 0.093907647, -0.001403699),
        (-0.416416106, -0.299836667, 5.067356259),
        (0.064770438, 0.061792014),
    ),
    "C": (
        (-0.021525776, 0.479233232, 0.200522696),
        (0.053120573, 0.009830171, -0.002926995),
        (0.121016728, -0.084967856, 5.226097321),
        (0.061807473, 0.054669690),
    ),
    "D": (
        (-0.183194544, 0.328838797, 1.365555376),
        (0.062091127, -0.002511374, -0.000000000),
        (0.460678716, -0.945791069, 5.588400189),
        (0.071413687, 0.077005605),
    ),
    "E": (
        (-0.087650054, 0.223083677, -0.050550521),
        (0.037068974, -0.041263896, 0.000000000),
        (-0.125724507, -0.160026202, 5.977631711),
        (0.065125327, 0.061865033),
    ),
    "F": (
        (0.223844519, 0.241160444, 0.063640440),
        (0.045609384, -0.064239057, -0.006245883),
        (0.036763568, -0.127782660, 5.521575326),
        (0.061467987, 0.051610227),
    ),
    "G": (
        (-0.136687979, 0.196595953, 0.036686678),
        (0.027308659, 0.085637202, 0.001729672),
        (-0.418088656, -0.314440615, 5.060780828),
        (0.064656506, 0.062174461),
    ),
}
"""Euler angles [rad], P [m], force [N], torque [N m] after 10 s."""


@pytest.mark.parametrize("name", PAIRS)
def test_state_has_the_reference_values(name):
    """Kane's equations with explicitly parametrised surfaces, to the digits that are printed."""
    at = model(*PAIRS[name])
    pose = at.make_pose(np.array((0.1, 0.2, 0.3)), np.array((0.03, 0.02)))
    quasi = at.quasi_from_euler_rates(pose, np.array((0.5, -0.4, 0.7)))
    leg = LegMotion(np.array((0.9, 1.3)), np.array((1.0, -2.0)), np.array((3.0, 4.0)))
    place = at.place(pose)
    found = at.dynamics(place, quasi, leg)
    alpha, force, torque, p_dot = STATE[name]
    np.testing.assert_allclose(place.rotation @ found.acceleration[3:6], alpha, atol=6e-10)
    np.testing.assert_allclose(found.contact_force, force, atol=6e-10)
    np.testing.assert_allclose(found.leg_torque, torque, atol=6e-10)
    h, rate = 1e-4, at.pose_rate(place, pose, quasi)[4:]
    ahead, behind = (at.ground.point(pose[4:] + s * h * rate) for s in (1, -1))
    np.testing.assert_allclose((ahead - behind) / (2 * h), p_dot, atol=2e-9)


@pytest.mark.parametrize("name", PAIRS)
def test_ten_seconds_have_the_reference_values(name):
    t = rr.simulate(model(*PAIRS[name]), GAIT, 10.0, 1.0, euler=START, rtol=1e-11, atol=1e-12)
    euler, point, force, torque = TEN[name]
    np.testing.assert_allclose(t.euler[-1], euler, atol=2e-8)
    np.testing.assert_allclose(t.ground.point(t.position[-1]), point, atol=2e-9)
    np.testing.assert_allclose(t.contact_force[-1], force, atol=5e-8)
    np.testing.assert_allclose(t.leg_torque[-1], torque, atol=5e-9)
    assert t.slip.max() < 1e-12
    assert np.abs(t.height_error).max() < 1e-12
