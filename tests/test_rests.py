"""Where a robot rests on slopes and uneven ground, how it rocks there, and when it rolls away."""

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from rrrobot.belly.rests import rest_of, standing
from rrrobot.escape.loss import rocking_damping, rocking_modes
from rrrobot.robot.legged import legged_urdf

UP = np.full(2, np.pi / 2)
RADIUS = 0.12


@pytest.fixture(scope="module")
def robot():
    return rr.Robot.from_parameters()


def depth(robot):
    """Of the centre of mass below the ball's middle, legs up [m]."""
    q = np.concatenate((pin.neutral(robot.model)[:7], UP))
    return -pin.centerOfMass(robot.model, robot.model.createData(), q)[2]


def periods(model, euler=(0.0, 0.0, 0.0)):
    found = rr.orbits.modes(model, UP, euler)
    return {m.axis: m.period for m in found if np.isfinite(m.period)}


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_a_ball_rests_tilted_on_a_slope(robot, share):
    # The centre of mass stands over the contact: e sin(tilt) = r sin(slope).
    e = depth(robot)
    slope = np.arcsin(share * e / RADIUS)
    ground = rr.Plane(normal=(0.0, -np.sin(slope), np.cos(slope)))
    model = rr.FullModel(robot, ground=ground, damping=None)
    rest = rest_of(model, UP)
    assert abs(rest.euler[0]) == pytest.approx(np.arcsin(share), abs=1e-9)
    assert rest.euler[1] == pytest.approx(0.0, abs=1e-9) and rest.stable
    # It stays there.
    t = rr.simulate(model, rr.StillLegs(UP), 2.0, euler=rest.euler, start="rest")
    assert np.abs(t.position).max() < 1e-7
    # And rocks there with the period that its modes have.
    t = rr.simulate(
        model, rr.StillLegs(UP), 8.0, euler=rest.euler + np.array((1e-3, 0, 0)), start="rest"
    )
    (mode,) = [m for m in rest.modes if m.axis == "roll" and np.isfinite(m.period)]
    measured = rr.orbits.measured_period(t, "roll", about=rest.euler[0])
    assert measured == pytest.approx(mode.period, rel=1e-4)


def test_on_a_steeper_slope_it_rolls_away(robot):
    slope = np.arcsin(1.02 * depth(robot) / RADIUS)
    ground = rr.Plane(normal=(0.0, -np.sin(slope), np.cos(slope)))
    with pytest.raises(rr.ModelError, match="no rest was found"):
        rr.orbits.equilibrium(rr.FullModel(robot, ground=ground, damping=None), UP)
    belly = rr.fit_belly(robot, ground=ground, posture=UP)
    assert not belly.stable and belly.rest is None and belly.modes == ()
    assert "does not rest" in belly.reason


@pytest.mark.parametrize(("a", "b"), [(2.0, 2.0), (3.0, -1.5), (-1.0, -2.0)])
def test_a_graph_s_curvature_stiffens_each_axis_by_its_own(robot, a, b):
    # z = (a x^2 + b y^2)/2 has B = -(a, b) at its origin: w^2 goes with 1/(1/r + B) - h, the
    # moments about the contact being those of the plane.
    ground = rr.Graph(
        lambda x, y: 0.5 * (a * x * x + b * y * y),
        lambda x, y: (a * x, b * y),
        lambda x, y: ((a, 0.0), (0.0, b)),
    )
    plane = rr.FullModel(robot, damping=None)
    uneven = rr.FullModel(robot, ground=ground, damping=None)
    height, flat = standing(plane, UP)
    same, radii = standing(uneven, UP)
    assert same == pytest.approx(height, abs=1e-12)
    assert flat == pytest.approx([RADIUS, RADIUS])
    # A roll takes the curvature along y, a pitch that along x.
    assert radii == pytest.approx([1 / (1 / RADIUS - b), 1 / (1 / RADIUS - a)], rel=1e-9)
    own, there = periods(plane), periods(uneven)
    for axis, radius in zip(("roll", "pitch"), radii, strict=True):
        wanted = own[axis] * np.sqrt((RADIUS - height) / (radius - height))
        assert there[axis] == pytest.approx(wanted, rel=1e-6)


def test_on_a_sharp_ridge_it_tips_over_in_one_axis(robot):
    height, _ = standing(rr.FullModel(robot, damping=None), UP)
    sharp = 1 / height - 1 / RADIUS
    for factor, stable in ((0.98, True), (1.02, False)):
        b = -factor * sharp
        ground = rr.Graph(
            lambda x, y, b=b: 0.5 * b * y * y,
            lambda x, y, b=b: (0.0, b * y),
            lambda x, y, b=b: ((0.0, 0.0), (0.0, b)),
        )
        rest = rest_of(rr.FullModel(robot, ground=ground, damping=None), UP)
        assert rest.stable == stable
        growing = [m.axis for m in rest.modes if m.decay_rate < -1e-3]
        assert growing == ([] if stable else ["roll"])


@pytest.mark.parametrize("degrees", [3.0, 5.0])
def test_a_dome_rests_on_a_slope_with_its_mass_over_the_contact(degrees):
    """Its shell is far larger than the robot: Newton's method must not begin upright."""
    angle = np.deg2rad(degrees)
    slope = rr.Plane((-np.sin(angle), 0.0, np.cos(angle)))
    belly = rr.fit_belly(legged_urdf(4), ground=slope)
    assert belly.stable and belly.reason == ""
    model = belly.model()
    pose = model.make_pose(belly.rest, belly.resting.position)
    q = model.configuration(pose, belly.posture)
    center = pin.centerOfMass(model.model, model.data, q)
    contact = slope.point(belly.resting.position)
    np.testing.assert_allclose(center[:2], contact[:2], atol=1e-9)
    # It leans with the slope, by no more than twice as much.
    assert 1.0 < -belly.rest[1] / angle < 2.0


@pytest.mark.parametrize("azimuth", [1.5, 5.0, 5.5])
def test_a_dome_across_a_slope_drifts_and_does_not_tip(azimuth):
    """Turning in place costs nothing: a double zero, which rounding splits into +-s."""
    angle = np.deg2rad(5.0)
    normal = np.array((np.cos(azimuth), np.sin(azimuth), 1 / np.tan(angle)))
    level = rr.fit_belly(legged_urdf(4))
    model = rr.FullModel(level.robot, ground=rr.Plane(normal), damping=None)
    rest = rest_of(model, level.posture)
    assert rest.stable
    assert [m.decay_rate for m in rest.modes if np.isinf(m.period)] == [0.0, 0.0]
    # It stays where it is put.
    t = rr.simulate(model, rr.StillLegs(level.posture), 20.0, euler=rest.euler, start="rest")
    assert np.abs(t.euler - rest.euler).max() < 1e-6


def test_a_robot_of_one_leg_rests_leaning():
    """Its mass is off the dome's middle: yaw is a double zero there too, on level ground."""
    belly = rr.fit_belly(legged_urdf(1))
    assert belly.stable and belly.reason == "" and abs(belly.rest[0]) > 1e-3


@pytest.mark.parametrize("azimuth", [0.0, 1.5, 2.5])
def test_what_is_searched_on_a_slope_rocks_about_the_rest_that_the_fit_found(azimuth):
    angle = np.deg2rad(5.0)
    slope = rr.Plane((np.cos(azimuth), np.sin(azimuth), 1 / np.tan(angle)))
    belly = rr.fit_belly(legged_urdf(4), ground=slope)
    model = belly.model(damping=None)
    fitted = [mode.period for mode in belly.modes if np.isfinite(mode.period)]
    assert [mode.period for mode in rocking_modes(model, belly.posture)] == pytest.approx(fitted)
    damping = rocking_damping(model, belly.posture, 0.1)
    lossy = rocking_modes(belly.model(damping=damping), belly.posture)
    ratios = [mode.decay_rate / abs(mode.eigenvalue) for mode in lossy]
    assert ratios == pytest.approx([0.1, 0.1], rel=0.1)
