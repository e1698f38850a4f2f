"""Limit cycles on slopes, boulders and bowls, against the KKT form and the grounds' symmetry."""

import numpy as np
import pytest

import rrrobot as rr

ROBOT = rr.Robot.from_parameters()
LATERAL, CIRCULAR = rr.gait("lateral"), rr.gait("circular")


def on_slope(angle, downhill=(1.0, 0.0), **options):
    x, y = np.sin(angle) * np.array(downhill)
    return rr.FullModel(ROBOT, ground=rr.Plane(normal=(x, y, np.cos(angle))), **options)


def in_bowl(radius):
    return rr.FullModel(ROBOT, ground=rr.Boulder(-radius))


def kkt_period(model, gait, euler, rates, position=(0.0, 0.0)):
    """Angles, rates and contact one period later, by constraints on Pinocchio's dynamics."""
    t = rr.simulate(
        model, gait, gait.period, gait.period, euler=euler, start=rates, position=position,
        rtol=1e-12, atol=1e-12,
    )  # fmt: skip
    return t.euler[-1], t.euler_rates[-1], t.position[-1]


@pytest.fixture(scope="module")
def slope():
    return rr.limit_cycle(on_slope(0.03), LATERAL)


def test_on_a_slope_angles_and_heading_come_back_and_the_place_advances(slope):
    angles, rates, place = kkt_period(slope.model, LATERAL, slope.euler, slope.euler_rates)
    np.testing.assert_allclose(angles, slope.euler, atol=1e-11)
    np.testing.assert_allclose(rates, slope.euler_rates, atol=1e-10)
    np.testing.assert_allclose(place, slope.displacement, rtol=0, atol=1e-12)
    assert slope.residual <= 1e-12
    assert slope.stable
    assert slope.multipliers.size == 6
    # Across the slope: a step up or down would be work without end.
    assert slope.speed == pytest.approx(np.linalg.norm(slope.displacement) / slope.period)


@pytest.mark.slow
def test_multipliers_on_a_slope_are_those_of_the_kkt_form(slope):
    start, step, columns = np.concatenate((slope.euler, slope.euler_rates)), 1e-4, []
    for e in step * np.eye(6):
        low, high = (
            np.concatenate(kkt_period(slope.model, LATERAL, s[:3], s[3:])[:2])
            for s in (start - e, start + e)
        )
        columns.append((high - low) / (2 * step))
    expected = np.linalg.eigvals(np.array(columns).T)
    expected = expected[np.lexsort((-expected.imag, -np.abs(expected).round(6)))]
    np.testing.assert_allclose(slope.multipliers, expected, atol=2e-6)


def test_a_slope_the_other_way_turns_the_cycle_with_it(slope):
    near = slope.point + np.eye(6)[5] * np.pi / 2
    turned = rr.limit_cycle(on_slope(0.03, (0.0, 1.0)), LATERAL, near=near)
    assert turned.euler[2] - slope.euler[2] == pytest.approx(np.pi / 2, abs=1e-9)
    x, y = slope.displacement
    np.testing.assert_allclose(turned.displacement, (-y, x), atol=1e-12)
    np.testing.assert_allclose(turned.multipliers, slope.multipliers, atol=1e-9)


def test_robots_turn_to_the_heading_that_comes_back(slope):
    """From 0.2 rad beside it, by the multiplier of the heading alone."""
    gait, off, periods = LATERAL, np.array((0.0, 0.0, 0.2)), 400
    t = rr.simulate(
        slope.model, gait, periods * gait.period, gait.period, euler=slope.euler + off,
        start=slope.euler_rates, method="momentum", step=gait.period / 24,
    )  # fmt: skip
    left = t.euler[[200, -1], 2] - slope.euler[2]
    assert 0.0 < left[1] < left[0] < 0.2
    assert (left[1] / left[0]) ** (1 / 200) == pytest.approx(abs(slope.multipliers[0]), abs=2e-5)


def test_a_gait_that_turns_has_none_on_a_gentle_slope():
    with pytest.raises(rr.OrbitError, match=r"no heading comes back .* turns by 0\.\d+ to 1"):
        rr.limit_cycle(on_slope(0.03), CIRCULAR)


@pytest.mark.parametrize(
    ("radius", "gait"), [(-0.5, CIRCULAR), (-1.0, LATERAL), (50.0, CIRCULAR)],
    ids=["bowl", "wide bowl", "boulder"],
)  # fmt: skip
def test_on_a_boulder_it_circles_the_top(radius, gait):
    model = rr.FullModel(ROBOT, ground=rr.Boulder(radius))
    c = rr.limit_cycle(model, gait)
    angles, rates, place = kkt_period(model, gait, c.euler, c.euler_rates, c.position)
    np.testing.assert_allclose(angles - c.euler, (0.0, 0.0, c.turn), atol=1e-11)
    np.testing.assert_allclose(rates, c.euler_rates, atol=1e-10)
    cos, sin = np.cos(c.turn), np.sin(c.turn)
    turned = np.array(((cos, -sin), (sin, cos))) @ c.position
    np.testing.assert_allclose(place, turned, atol=1e-11)
    np.testing.assert_allclose(place - c.position, c.displacement, atol=1e-11)
    np.testing.assert_allclose(c.centre, 0.0, atol=1e-9)
    assert c.multipliers.size == 7
    # The mean of the contact goes round on a circle about the top.
    middle = c.trajectory(3 * c.period, c.period / 200).steady_state(after=0.0)
    assert c.speed == pytest.approx(middle.speed, rel=1e-6)
    assert c.yaw_rate == pytest.approx(middle.yaw_rate, rel=1e-6)


@pytest.mark.parametrize("radius", np.linspace(0.7, 1.5, 9).round(3))
def test_a_bowl_s_unstable_circles_are_found_at_every_radius(radius):
    """From rest and where it settles Broyden's steps go astray, where depends on rounding."""
    c = rr.limit_cycle(rr.FullModel(ROBOT, ground=rr.Boulder(-radius)), LATERAL)
    np.testing.assert_allclose(c.centre, 0.0, atol=1e-9)
    assert abs(c.multipliers[0]) == pytest.approx(1.0045, abs=7e-4)


def test_a_wide_bowl_and_a_wide_boulder_are_level_ground():
    level = rr.limit_cycle(rr.FullModel(ROBOT), CIRCULAR)
    wide = [
        rr.limit_cycle(rr.FullModel(ROBOT, ground=rr.Boulder(radius)), CIRCULAR)
        for radius in (-500.0, 500.0)
    ]
    for c in wide:
        assert c.yaw_rate == pytest.approx(level.yaw_rate, rel=2e-3)
    # Half of each: what is odd in the curvature is gone.
    assert sum(c.yaw_rate for c in wide) / 2 == pytest.approx(level.yaw_rate, rel=1e-5)


@pytest.mark.parametrize("kind", ["slope", "bowl"])
def test_branches_and_derivatives_in_the_ground(slope, kind):
    name, value, to, model, gait = {
        "slope": ("slope", 0.03, 0.06, on_slope, LATERAL),
        "bowl": ("bowl_radius", 0.5, 0.52, in_bowl, CIRCULAR),
    }[kind]
    c = slope if kind == "slope" else rr.limit_cycle(model(value), gait)
    line = rr.orbits.branch(c, name, to=to)
    end = rr.limit_cycle(model(to), gait, near=line.cycles[-1])
    assert line.value[0] == pytest.approx(value)
    assert line.value[-1] == pytest.approx(to)
    np.testing.assert_allclose(line.cycles[-1].point, end.point, atol=1e-9)
    assert line.cycles[-1].speed == pytest.approx(end.speed, rel=1e-9)
    again = rr.limit_cycle(line.cycles[-1].model, gait, near=end)
    assert again.speed == pytest.approx(end.speed, rel=1e-9)
    step = 2e-4 * value
    high, low = (rr.limit_cycle(model(value + k * step), gait, near=c) for k in (1, -1))
    s = rr.orbits.sensitivities(c, [name])
    expected = (high.speed - low.speed) / (2 * step)
    assert s.of("speed", name) == pytest.approx(expected, rel=1e-4)


@pytest.mark.slow
def test_starts_on_a_slope_come_to_it(slope):
    found = rr.orbits.attractors(slope.model, LATERAL, n_starts=6)
    assert any(c.point == pytest.approx(slope.point, abs=1e-6) for c in found)


def test_what_has_no_symmetry_is_refused():
    def height(x, y):
        return 0.01 * x * x

    bumpy = rr.Graph(height, lambda x, y: (0.02 * x, 0.0), lambda x, y: ((0.02, 0.0), (0.0, 0.0)))
    with pytest.raises(rr.ModelError, match="no two places alike"):
        rr.limit_cycle(rr.FullModel(ROBOT, ground=bumpy), LATERAL)
    with pytest.raises(rr.ModelError, match="at once are of level ground only"):
        rr.sweep(on_slope(0.03), offset=[0.5, 1.0], settle="orbit")
    with pytest.raises(rr.ParameterError, match="there is no parameter 'slope'"):
        rr.orbits.branch(rr.limit_cycle(rr.FullModel(ROBOT), LATERAL), "slope", to=0.1)
