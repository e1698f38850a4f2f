"""What must hold along every simulation of the full model."""

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson
from scipy.interpolate import make_interp_spline

import rrrobot as rr
from tests import derivations
from tests.pages import numbers
from tests.random_robot import random_robot
from tests.some import some

UP = (np.pi / 2, np.pi / 2)


@pytest.fixture(scope="module")
def robot():
    return rr.Robot.from_parameters()


def wiggle(n, amplitude=0.3, omega=6.0):
    return rr.SinusoidalGait(
        offset=np.linspace(-0.5, 0.5, n),
        amplitude=amplitude,
        angular_frequency=omega,
        phase=np.arange(n) * 1.0,
        n_legs=n,
    )


@pytest.mark.parametrize(
    "name, v, alpha",
    [
        ("lateral", 0.009656, 0.0),
        ("circular", 0.0066765, 0.0208546),
    ],
)
@pytest.mark.slow
def test_gaits_of_the_paper(robot, name, v, alpha):
    """To the printed digits of the notes and to 1e-6 of the point-mass derivation."""
    model = rr.FullModel(robot)
    t = rr.simulate(model, rr.gait(name), duration=30.0)
    found = t.steady_state()
    assert found.speed == pytest.approx(v, abs=5e-8)
    assert found.yaw_rate == pytest.approx(alpha, abs=1e-7)
    assert t.slip.max() < 1e-12 and np.abs(t.height_error).max() < 1e-12
    assert t.lift_off_time is None and t.normal_force.min() > 0

    gait = rr.gait(name)
    path = derivations.simulate_full(
        derivations.PointMassRobot(), gait.offset[0], 0.3, 8.0, tuple(gait.phase), 30.0, 3001,
        (0.01,) * 3,
    )  # fmt: skip
    np.testing.assert_allclose(t.time, path.time, atol=1e-12)
    np.testing.assert_allclose(t.euler, path.theta, atol=2e-8)
    np.testing.assert_allclose(t.position, path.contact_point, atol=5e-9)
    cycles = derived_cycles(path, gait.period)
    assert found.speed == pytest.approx(cycles[0], rel=1e-6)
    assert found.yaw_rate == pytest.approx(cycles[1], abs=2e-8)


def derived_cycles(path, period):
    """v and alpha of the derivation's path, over cycles from 20 T on, by its own quadrature."""
    values = np.column_stack((path.contact_point, path.theta[:, 2]))
    spline = make_interp_spline(path.time, values, k=5).antiderivative()
    means = np.diff(spline(period * np.arange(20, 39)), axis=0) / period
    steps = np.diff(means, axis=0) / period
    return np.linalg.norm(steps[:, :2], axis=1).mean(), steps[:, 2].mean()


@pytest.mark.parametrize(
    "euler", some([[0.5, 0, 0], [0, 0.5, 0], [0.35, 0.35, 0.2]], {"[0.35, 0.35, 0.2]"})
)
def test_energy_is_conserved_with_legs_held(robot, euler):
    model = rr.FullModel(robot, damping=None)
    t = rr.simulate(model, rr.StillLegs(UP), duration=30.0, euler=euler, start="rest")
    assert np.ptp(t.energy) < 1e-10 * t.energy[0]
    told = numbers(
        "../README.md", r"over (\d+) s of free rocking from ([\d.]+) rad \| ([\de-]+) of"
    )
    assert told == (t.time[-1], 0.5, 1e-10)
    told = numbers(
        "theory/equations.md", r"Over (\d+) s of free rocking rrrobot .* to ([\de-]+) of"
    )
    assert told == (t.time[-1], 1e-10)
    assert t.slip.max() < 1e-12 and np.abs(t.height_error).max() < 1e-12


def power_balance(model, gait, duration=4.0, interval=0.002, **options):
    """Energy minus the work of motors and damping, over the energy's swing."""
    t = rr.simulate(model, gait, duration, interval, **options)
    damping = model.damping
    lost = np.array(
        [
            damping.moment(e[0], e[1], v[3:6]) @ v[3:6] - damping.leg_coefficient * r @ r
            for e, v, r in zip(t.euler, t.velocity, t.leg_rate, strict=True)
        ]
    )
    supplied = np.einsum("ij,ij->i", t.leg_torque, t.leg_rate)
    work = cumulative_simpson(supplied + lost, x=t.time, initial=0)
    return np.abs(t.energy - t.energy[0] - work).max() / np.ptp(t.energy), t


@pytest.mark.parametrize("damping", [0.01, rr.BodyRateDamping(0.01, 0.02, 0.03, legs=0.001)])
def test_power_balance_of_rrrobot(robot, damping):
    model = rr.FullModel(robot, damping=damping)
    error, _ = power_balance(model, rr.gait("circular"))
    assert error < 1e-8


@pytest.mark.filterwarnings("ignore::rrrobot.errors.GroundClearanceWarning")
@pytest.mark.filterwarnings("ignore::rrrobot.errors.LimitWarning")
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"shell": rr.Ellipsoid((0.35, 0.3, 0.27))},
        {"normal": (0.05, -0.02, 1.0)},
        {"shell": rr.Ellipsoid((0.3, 0.36, 0.4)), "normal": (0.02, 0.05, 1.0)},
    ],
    ids=["sphere", "ellipsoid", "slope", "ellipsoid on a slope"],
)
def test_random_tree_of_twelve_joints(options):
    options = dict(options)
    ground = rr.Plane(options.pop("normal", (0, 0, 1)))
    robot = random_robot(8, **options)
    model = rr.FullModel(robot, ground=ground, damping=rr.BodyRateDamping(0.3, 0.3, 0.3))
    error, t = power_balance(model, wiggle(12), duration=2.0)
    assert error < 1e-7
    assert t.slip.max() < 1e-12 and np.abs(t.height_error).max() < 1e-12
    assert np.ptp(t.euler, axis=0).max() > 0.05

    # Legs held, nothing lost: the energy stays.
    free = rr.FullModel(robot, ground=ground, damping=None)
    still = rr.StillLegs(np.zeros(12))
    t = rr.simulate(free, still, 3.0, euler=(0.3, -0.2, 0.1), start=(0.3, 0.2, -0.1))
    assert np.ptp(t.energy) < 1e-9 * abs(t.energy).max()


def test_the_legs_torques_drive_the_same_motion(robot):
    """Torques recorded from a prescribed gait, played back open loop, reproduce it."""
    model = rr.FullModel(robot)
    gait = rr.gait("circular")
    t = rr.simulate(model, gait, 2.0, 0.005, step=0.01)
    spline = make_interp_spline(t.time, t.leg_torque, k=7)
    torques = rr.LegTorques(spline, angle=gait(0.0).angle, rate=gait(0.0).rate)
    again = rr.simulate(model, torques, 2.0, 0.005, step=0.01)
    # Upright legs are unstable under given torques: errors grow a thousandfold in a second.
    np.testing.assert_allclose(again.leg_angle, t.leg_angle, atol=1e-7)
    np.testing.assert_allclose(again.euler, t.euler, atol=1e-7)
    np.testing.assert_allclose(again.position, t.position, atol=1e-7)
    np.testing.assert_allclose(again.contact_force, t.contact_force, atol=1e-6)


def test_constant_and_feedback_torques(robot):
    model = rr.FullModel(robot, damping=rr.EulerRateDamping(0.01, 0.01, 0.01, legs=0.01))
    weight = 0.057 * 9.81 * 0.1

    def hold(state):
        """Gravity compensation of the upright body and a spring to the vertical."""
        assert state.R_world_body.shape == (3, 3) and state.position.shape == (2,)
        return weight * np.cos(state.leg_angle) - 0.5 * (state.leg_angle - np.pi / 2)

    spring = rr.LegTorques(hold, angle=(1.2, 1.9), feedback=True)
    settled = rr.simulate(model, spring, 20.0, 0.05, start="rest")
    np.testing.assert_allclose(settled.leg_angle[-1], np.pi / 2, atol=1e-3)
    constant = rr.LegTorques((0.001, -0.002), angle=UP)
    by_time = rr.LegTorques(lambda time: np.array((0.001, -0.002)), angle=UP)
    a = rr.simulate(model, constant, 1.0, 0.05)
    b = rr.simulate(model, by_time, 1.0, 0.05)
    np.testing.assert_array_equal(a.state, b.state)
    np.testing.assert_array_equal(a.leg_torque, np.tile((0.001, -0.002), (len(a), 1)))


def test_order_of_the_fixed_step(robot):
    """Halving the step divides the error by 2^8: the method is of order 8."""
    model = rr.FullModel(robot)
    gait = rr.gait("circular")
    exact = rr.simulate(model, gait, 2.0, 2.0, step=0.0025).state[-1]
    steps = np.array((0.2, 0.1, 0.05))
    errors = [
        np.abs(rr.simulate(model, gait, 2.0, 2.0, step=h).state[-1] - exact).max() for h in steps
    ]
    order = -np.polyfit(np.log(1 / steps), np.log(errors), 1)[0]
    assert 7.5 < order < 9.5


def test_dense_samples_are_as_good_as_steps(robot):
    model = rr.FullModel(robot)
    coarse = rr.simulate(model, rr.gait("circular"), 2.0, 0.01)
    fine = rr.simulate(model, rr.gait("circular"), 2.0, 0.01, step=0.005)
    np.testing.assert_allclose(coarse.state, fine.state, atol=1e-8)


def test_impulsive_start_has_no_momentum(robot):
    model = rr.FullModel(robot)
    gait = rr.gait("lateral")
    leg = gait(0.0)
    t = rr.simulate(model, gait, 0.1)
    y = t.state[0]
    assert np.abs(model.momentum(y[:6], y[6:], leg.angle, leg.rate)).max() < 1e-17
    assert np.abs(y[6:]).max() > 0.1
    rest = rr.simulate(model, gait, 0.1, start="rest")
    np.testing.assert_array_equal(rest.velocity[0, :6], 0)
    spun = rr.simulate(model, gait, 0.1, start=(0.1, 0.2, 0.3), euler=(0.3, 0.2, 0.1))
    np.testing.assert_allclose(spun.euler_rates[0], (0.1, 0.2, 0.3), atol=1e-14)


def test_momentum_balance_about_the_contact(robot):
    """K_dot = -w x K - g mc x z - v x p: the one equation for every model, by differences."""
    model = rr.FullModel(robot, damping=None)
    t = rr.simulate(model, rr.gait("circular"), 1.0, 0.001, step=0.005)
    momentum = np.array(
        [
            model.momentum(y[:6], y[6:], a, r)
            for y, a, r in zip(t.state, t.leg_angle, t.leg_rate, strict=True)
        ]
    )
    rate = make_interp_spline(t.time, momentum, k=7).derivative()(t.time)
    for i in range(50, 1000, 50):
        q, v = t.configuration[i], t.velocity[i]
        mass = model.mass_matrix(t.state[i, :6], t.leg_angle[i])
        w, up = v[3:6], rotation(q).T @ (0, 0, 1)
        p = (mass @ v)[:3]
        first_moment = np.array((-mass[2, 4], -mass[0, 5], -mass[1, 3]))
        torque = -9.81 * np.cross(first_moment, up) - np.cross(w, momentum[i])
        torque -= np.cross(v[:3], p)
        np.testing.assert_allclose(rate[i], torque, atol=1e-8)


def rotation(q):
    from rrrobot.rotations import rotation_from_quaternion

    return rotation_from_quaternion(q[3:7])


def test_same_input_same_bits(robot):
    runs = [rr.simulate(rr.FullModel(robot), rr.gait("lateral"), 2.0) for _ in range(2)]
    for name in ("state", "contact_force", "leg_torque", "energy", "euler"):
        np.testing.assert_array_equal(getattr(runs[0], name), getattr(runs[1], name))


def test_continuation_from_the_last_state(robot):
    model, gait = rr.FullModel(robot), rr.gait("lateral")
    whole = rr.simulate(model, gait, 4 * gait.period, gait.period / 80)
    half = rr.simulate(model, gait, 2 * gait.period, gait.period / 80)
    rest = rr.simulate(model, gait, 2 * gait.period, gait.period / 80, state=half.final_state)
    np.testing.assert_allclose(rest.state[-1], whole.state[-1], atol=1e-9)


def test_yaw_is_continuous_over_many_turns(robot):
    model = rr.FullModel(robot, damping=None)
    t = rr.simulate(model, rr.StillLegs(UP), 20.0, 0.5, start=(0, 0, 4.0))
    np.testing.assert_allclose(t.euler[:, 2], 4.0 * t.time, rtol=1e-9, atol=1e-8)
    assert t.euler[-1, 2] > 12 * np.pi


def test_lift_off_is_reported(robot):
    """Legs thrown up hard make the normal force negative."""
    gait = rr.SinusoidalGait(offset=0.0, amplitude=0.3, angular_frequency=60.0)
    t = rr.simulate(rr.FullModel(robot), gait, 0.5, 0.001)
    assert t.lift_off_time is not None and 0 <= t.lift_off_time < 0.2
    assert t.normal_force[t.time == t.lift_off_time][0] <= 0
    assert "LIFTS OFF" in repr(t)


@pytest.mark.slow
def test_one_hour(robot):
    """Neither slip nor height error grows over an hour of gait."""
    t = rr.simulate(rr.FullModel(robot), rr.gait("circular"), 3600.0, 0.5)
    assert t.slip.max() < 1e-12 and np.abs(t.height_error).max() < 1e-12
    first, last = t.time < 600, t.time > 3000
    assert t.slip[last].max() < 2 * t.slip[first].max()
    early, late = (np.polyfit(t.time[w], t.euler[w, 2], 1)[0] for w in (first, last))
    assert late == pytest.approx(early, rel=1e-3)
