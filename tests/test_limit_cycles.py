"""Limit cycles against an independent derivation, long simulations and closed forms."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rrrobot as rr
from rrrobot.orbits.limit_cycles import limit_cycle
from tests.derivations import PointMassRobot, _contact_velocity, full_model
from tests.random_robot import random_robot
from tests.some import some

ROBOT = rr.Robot.from_parameters()
FULL = rr.FullModel(ROBOT)
MODELS = (rr.FullModel, rr.PivotingModel, rr.RollModel, rr.PitchModel, rr.YawModel)


def kane_period(gait, state):
    """(roll, pitch, yaw, rates, x, y) one period later by Kane's equations of five points."""
    masses = PointMassRobot()

    def rate(t, y):
        leg = gait(t)
        angles = full_model(masses, y[:3], y[3:6], *leg, damping=(0.01,) * 3).theta_ddot
        return np.concatenate((y[3:6], angles, _contact_velocity(masses, y[:3], y[3:6])))

    span = (0.0, gait.period)
    return solve_ivp(rate, span, state, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]


def test_kanes_equations_repeat_it_and_have_its_multipliers():
    """One period of an independent derivation: closure, net motion, multipliers to 1e-7."""
    gait = rr.gait("circular")
    c = limit_cycle(FULL, gait)
    start = np.concatenate((c.euler, c.euler_rates, (0.0, 0.0)))
    end = kane_period(gait, start)
    back = [0, 1, 3, 4, 5]
    np.testing.assert_allclose(end[back], start[back], atol=2e-11)
    assert end[2] == pytest.approx(c.turn, rel=1e-9)
    np.testing.assert_allclose(end[6:], c.displacement, rtol=1e-9)
    step, columns = 2e-4, []
    for j in back:
        e = np.eye(8)[j] * step
        low, high = (kane_period(gait, start + k * e)[back] for k in (-1, 1))
        far = [kane_period(gait, start + k * e)[back] for k in (-2, 2)]
        columns.append((8 * (high - low) - (far[1] - far[0])) / (12 * step))
    expected = np.linalg.eigvals(np.array(columns).T)
    expected = expected[np.lexsort((-expected.imag, -np.abs(expected).round(8)))]
    np.testing.assert_allclose(c.multipliers, expected, atol=1e-7)


def travelled_the_same(c, long, samples_per_cycle, rel=1e-9):
    """The last cycle of a long run has the limit cycle's displacement and turn, no means taken."""
    last, end = -1 - samples_per_cycle, -1
    turn = long.euler[end, 2] - long.euler[last, 2]
    moved = np.linalg.norm(long.position[end] - long.position[last])
    assert turn == pytest.approx(c.turn, rel=rel, abs=1e-12)
    assert moved == pytest.approx(np.linalg.norm(c.displacement), rel=rel, abs=1e-13)


@pytest.mark.parametrize(
    ("name", "model"),
    some(itertools.product(("lateral", "circular"), MODELS), ("circular-full",),
         lambda case: f"{case[0]}-{case[1].name}"),
)  # fmt: skip
def test_what_two_hundred_cycles_come_to(name, model):
    kind, gait = model(ROBOT), rr.gait(name)
    c = limit_cycle(kind, gait)
    long = rr.simulate(
        kind, gait, 200 * gait.period, gait.period / 40, method="momentum", step=gait.period / 80
    )
    s = long.steady_state(after=150 * gait.period)
    travelled_the_same(c, long, 40)
    assert c.residual <= 1e-12
    assert c.stable
    # The spline through the samples has errors of 1e-10.
    assert c.speed == pytest.approx(s.speed, rel=1e-9, abs=1e-10)
    assert c.yaw_rate == pytest.approx(s.yaw_rate, rel=1e-9, abs=1e-10)
    np.testing.assert_allclose(c.velocity, s.velocity, rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(c.amplitude, s.amplitude, atol=2e-9)
    np.testing.assert_allclose(c.mean[:2], s.mean[:2], atol=1e-10)
    for i in np.flatnonzero(s.amplitude > 1e-4):
        assert c.phase[i] == pytest.approx(s.phase[i], abs=1e-8)


def test_the_notes_table():
    """Values of an independent Kane formulation, to all digits that are printed."""
    c = limit_cycle(FULL, rr.gait("circular"))
    assert (c.speed, c.yaw_rate) == pytest.approx((0.0066765, 0.02085466), rel=1e-5)
    c = limit_cycle(rr.PivotingModel(ROBOT), rr.gait("circular"))
    assert (c.speed, c.yaw_rate) == pytest.approx((0.00738, 0.1978), rel=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_random_trees_of_twelve_joints(seed):
    rng = np.random.default_rng(seed)
    model = rr.FullModel(random_robot(seed), damping=rr.BodyRateDamping(0.4, 0.4, 0.4))
    gait = rr.SinusoidalGait(
        offset=rng.uniform(-0.3, 0.3, 12), amplitude=0.2, angular_frequency=7.0,
        phase=rng.uniform(0, 6, 12),
    )  # fmt: skip
    c = limit_cycle(model, gait)
    long = rr.simulate(
        model, gait, 200 * gait.period, gait.period, method="momentum", step=gait.period / 80
    )
    assert c.stable
    travelled_the_same(c, long, 1)


@pytest.mark.slow
def test_an_ellipsoid_rolls_into_its_cycle():
    """A shell that is no sphere: the long run, and the return of Pinocchio's KKT form."""
    base = rr.Robot.from_parameters()
    robot = rr.Robot.from_urdf(base.urdf, shell=rr.Ellipsoid((0.13, 0.12, 0.12)))
    model = rr.FullModel(robot, damping=0.01)
    gait = rr.gait("circular")
    c = limit_cycle(model, gait)
    assert c.stable and c.residual < 1e-12
    t = c.trajectory(c.period, c.period / 200)
    np.testing.assert_allclose(t.euler[-1, :2], t.euler[0, :2], atol=1e-9)
    kkt = rr.simulate(model, gait, c.period, c.period, euler=c.euler, start=c.euler_rates)
    np.testing.assert_allclose(kkt.euler[-1, :2], c.euler[:2], atol=1e-8)
    np.testing.assert_allclose(kkt.euler_rates[-1], c.euler_rates, atol=1e-7)
    assert c.normal_force == pytest.approx(t.normal_force.min(), abs=2e-4)


def test_small_deviations_die_away_as_the_multipliers_say():
    """The momentum engine's own long run, deviation from the cycle after five periods."""
    gait = rr.gait("lateral")
    c = limit_cycle(FULL, gait)
    P, size = c.found.map, 1e-5
    deviation = np.random.default_rng(0).normal(size=(1, 5)) * size
    x = c.point + deviation
    for _ in range(5):
        x = P(x)
    linear = np.linalg.matrix_power(c.found.monodromy, 5) @ deviation[0]
    np.testing.assert_allclose(x[0] - c.point, linear, atol=1e-3 * size * 0.1)


def test_roll_multipliers_have_liouvilles_product():
    """det of the monodromy of one damped axis: exp of minus the integral of kappa / I(t)."""
    gait = rr.gait("circular")
    c = limit_cycle(rr.RollModel(ROBOT), gait)
    t = c.trajectory(c.period, c.period / 400)
    model = rr.RollModel(ROBOT)
    inertia = []
    for y, angle in zip(t.state, t.leg_angle, strict=True):
        place = model.place(y[:3])
        mass = model.mass_matrix(place, angle)[:2, :2]
        inertia.append((place.basis.T @ mass @ place.basis).item())
    integral = np.mean(1 / np.array(inertia)[:-1]) * c.period
    assert np.prod(c.multipliers).real == pytest.approx(np.exp(-0.01 * integral), rel=1e-9)


def test_trajectory_screw_and_centre():
    c = limit_cycle(FULL, rr.gait("circular"))
    t = c.trajectory(3 * c.period, c.period / 30)
    ends = t.position[::30]
    np.testing.assert_allclose(ends[1], c.displacement, atol=1e-12)
    radius = np.linalg.norm(ends - c.centre, axis=1)
    np.testing.assert_allclose(radius, radius[0], rtol=1e-10)
    np.testing.assert_allclose(t.euler[30, :2], t.euler[0, :2], atol=1e-12)
    assert t.normal_force.min() == pytest.approx(c.normal_force, abs=1e-3)


@pytest.mark.slow
def test_decoupled_is_the_three_models_together():
    models, gait = rr.models.DecoupledModels(ROBOT), rr.gait("circular")
    c = limit_cycle(models, gait)
    s = rr.decoupled(ROBOT, gait, 40.0, 0.03).steady_state(after=30.0)
    assert c.speed == pytest.approx(s.speed, rel=1e-7)
    assert c.yaw_rate == pytest.approx(s.yaw_rate, rel=1e-7)
    t = c.trajectory(2 * c.period, c.period / 40)
    np.testing.assert_allclose(t.euler[40, :2], t.euler[0, :2], atol=1e-10)
    np.testing.assert_allclose(t.position[40], c.displacement, atol=1e-10)
    parts = [limit_cycle(m(ROBOT), gait).multipliers for m in (rr.RollModel, rr.PitchModel)]
    both = np.concatenate(parts)
    np.testing.assert_allclose(np.sort(np.abs(both))[::-1], np.abs(c.multipliers), atol=1e-9)


def test_a_cycle_twice_has_squared_multipliers():
    gait = rr.gait("lateral")
    one, two = limit_cycle(FULL, gait), limit_cycle(FULL, gait, periods=2)
    assert two.period == 2 * one.period
    assert two.speed == pytest.approx(one.speed, rel=1e-10)
    np.testing.assert_allclose(np.abs(two.multipliers), np.abs(one.multipliers) ** 2, atol=1e-10)


def test_starts_from_a_neighbour():
    near = limit_cycle(FULL, rr.gait("circular", amplitude=0.29))
    c = limit_cycle(FULL, rr.gait("circular"), near=near)
    far = limit_cycle(FULL, rr.gait("circular"))
    np.testing.assert_allclose(c.point, far.point, atol=1e-11)
    assert c.iterations < far.iterations


def test_plots_and_plain_data(tmp_path):
    c = limit_cycle(FULL, rr.gait("circular"))
    for kind in ("angles", "legs", "multipliers", "path"):
        assert c.plot(kind).get_xlabel()
    c.plot().savefig(tmp_path / "cycle.png")
    data = c.to_dict()
    assert data["stable"] is True and len(data["multipliers"]) == 5
    with pytest.raises(rr.ParameterError, match="kind is 'x'"):
        c.plot("x")


# Bad input

STILL = rr.SinusoidalGait(offset=1.5, amplitude=0.0, angular_frequency=8.0)
TWO_CLOCKS = rr.SinusoidalGait(offset=1.5, amplitude=0.3, angular_frequency=(8.0, 8.0 * 2**0.5))


@pytest.mark.parametrize(
    ("model", "gait", "error", "words"),
    [
        (FULL, STILL, rr.GaitError, "legs do not move"),
        (FULL, rr.StillLegs((1.5, 1.5)), rr.GaitError, "legs do not move"),
        (FULL, TWO_CLOCKS, rr.GaitError, "does not repeat"),
        (FULL, rr.RampIn(rr.gait("lateral"), 2.0), rr.GaitError, "Only legs that repeat"),
        (FULL, "lateral", rr.GaitError, "prescribed Gait"),
        (rr.FullModel(ROBOT, damping=None), rr.gait("lateral"), rr.ModelError, "no damping"),
        (rr.RollModel(ROBOT, damping=None), rr.gait("lateral"), rr.ModelError, "no damping"),
        ("full", rr.gait("lateral"), rr.ModelError, "must be a model"),
    ],
)
def test_bad_input(model, gait, error, words):
    with pytest.raises(error, match=words):
        limit_cycle(model, gait)


@pytest.mark.parametrize("options", [{"periods": 0}, {"periods": 1.5}, {"steps_per_cycle": 2},
                                     {"near": (0.0, 1.0)}])  # fmt: skip
def test_numbers_out_of_range(options):
    with pytest.raises(rr.ParameterError):
        limit_cycle(FULL, rr.gait("lateral"), **options)


def test_no_orbit_says_how_the_search_ended():
    wild = rr.SinusoidalGait(offset=1.0, amplitude=2.5, angular_frequency=6.5)
    with pytest.raises(rr.OrbitError, match=r"after \d+ simulated periods|reaches a pitch"):
        limit_cycle(FULL, wild)
