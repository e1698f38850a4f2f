"""Limit cycles of random gaits and robots against long runs of independent derivations."""

import numpy as np
import pytest

import rrrobot as rr
from tests import kane_lanes as kane
from tests.random_robot import random_robot
from tests.some import some

ROBOT = rr.Robot.from_parameters()
FULL = rr.FullModel(ROBOT)


def random_gaits(n, seed=0):
    rng = np.random.default_rng(seed)
    return kane.Gaits(
        rng.uniform(0, np.pi, (n, 2)), rng.uniform(0.1, 0.4, (n, 2)),
        rng.uniform(0, 2 * np.pi, (n, 2)), rng.uniform(5, 11, n),
    )  # fmt: skip


def cycle_of(gaits, i):
    return rr.limit_cycle(
        FULL,
        rr.SinusoidalGait(
            offset=gaits.offset[i], amplitude=gaits.amplitude[i], phase=gaits.phase[i],
            angular_frequency=float(gaits.omega[i]),
        ),
    )  # fmt: skip


def states(cycles):
    return np.array([np.concatenate((c.euler, c.euler_rates, np.zeros(4))) for c in cycles])


def same_multipliers(c, monodromy, atol=1e-7):
    """As eigenvalues of the two; of nearly equal ones their symmetric functions."""
    expected = kane.sorted_by_size(np.linalg.eigvals(monodromy))
    mine = kane.sorted_by_size(np.asarray(c.multipliers))
    gap = np.abs(expected[:, None] - expected)[np.triu_indices(len(expected), 1)].min()
    if gap > 1e-4:
        np.testing.assert_allclose(mine, expected, atol=atol)
    else:
        np.testing.assert_allclose(np.poly(mine), np.poly(expected), atol=atol)


@pytest.mark.parametrize("n", some([2, 100], ["2"]))
def test_random_gaits_repeat_in_kanes_equations_with_their_multipliers(n):
    gaits = random_gaits(n)
    cycles = [cycle_of(gaits, i) for i in range(n)]
    start = states(cycles)
    end, _ = kane.carried(gaits, start, 1, 60)
    np.testing.assert_allclose(end[:, kane.BACK], start[:, kane.BACK], atol=1e-10)
    turns = [c.turn for c in cycles]
    np.testing.assert_allclose(end[:, 2], turns, rtol=1e-9, atol=1e-12)
    moved = [c.displacement for c in cycles]
    np.testing.assert_allclose(end[:, 6:8], moved, rtol=1e-9, atol=1e-12)
    for c, monodromy in zip(cycles, kane.monodromies(gaits, start, 60), strict=True):
        same_multipliers(c, monodromy)


@pytest.mark.slow
def test_a_hundred_random_gaits_after_two_hundred_cycles_of_kanes_equations():
    """From upright at rest; speed and yaw rate to 1e-9 of what cycle means of the last two do."""
    gaits = random_gaits(100)
    cycles = [cycle_of(gaits, i) for i in range(100)]
    assert all(c.stable and not c.lifts_off for c in cycles)
    end, before = kane.carried(gaits, np.zeros((100, 10)), 199, 48)
    last, _ = kane.carried(gaits, end, 1, 48)
    period = 2 * np.pi / gaits.omega
    means = [(b[:, 8:] - a[:, 8:]) / period[:, None] for a, b in ((before, end), (end, last))]
    speed = np.linalg.norm(means[1] - means[0], axis=1) / period
    yaw_rate = (last[:, 2] - end[:, 2]) / period
    found = np.array([(c.speed, c.yaw_rate) for c in cycles])
    np.testing.assert_allclose(found[:, 0], speed, rtol=1e-9, atol=1e-13)
    np.testing.assert_allclose(found[:, 1], yaw_rate, rtol=1e-9, atol=1e-12)


def robot_of(seed):
    """Twelve random trees of twelve joints, four of fewer, four of RRRobot's kind."""
    rng = np.random.default_rng(100 + seed)
    if seed < 12:
        return random_robot(seed), 0.4, 0.2
    if seed < 16:
        return random_robot(seed, joints=2 * (seed - 11)), 0.4, 0.25
    p = rr.RRRobotParameters(
        leg_mass=tuple(rng.uniform(0.03, 0.08, 2)), servo_mass=tuple(rng.uniform(0.03, 0.08, 2)),
        battery_mass=rng.uniform(0.25, 0.4), shell_radius=rng.uniform(0.11, 0.15),
        leg_length=tuple(rng.uniform(0.06, 0.1, 2)), hip_offset=rng.uniform(0.08, 0.11),
    )  # fmt: skip
    return rr.Robot.from_parameters(p), 0.01, 0.3


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::rrrobot.errors.GroundClearanceWarning")
@pytest.mark.parametrize("seed", range(20))
def test_random_robots_after_two_hundred_cycles_of_the_kkt_form(seed):
    robot, damping, amplitude = robot_of(seed)
    rng = np.random.default_rng(seed)
    n = robot.n_legs
    level = rng.uniform(-0.3, 0.3, n) if seed < 16 else rng.uniform(0.5, 2.5, n)
    loss = rr.BodyRateDamping(*(damping,) * 3) if seed < 16 else damping
    model = rr.FullModel(robot, damping=loss)
    gait = rr.SinusoidalGait(
        offset=level, amplitude=amplitude, angular_frequency=7.0, phase=rng.uniform(0, 6, n)
    )
    c = rr.limit_cycle(model, gait)
    assert c.stable
    tight = {"rtol": 1e-12, "atol": 1e-13}
    long = rr.simulate(model, gait, 199 * gait.period, gait.period, **tight)
    # The last cycle from the origin: far from it the step's tolerance is a part of a large number.
    last = rr.simulate(model, gait, gait.period, gait.period, euler=(*long.euler[-1, :2], 0.0),
                       start=long.euler_rates[-1], **tight)  # fmt: skip
    assert last.euler[-1, 2] == pytest.approx(c.turn, rel=1e-9, abs=1e-12)
    size = np.linalg.norm(c.displacement)
    np.testing.assert_allclose(last.position[-1], c.displacement, atol=1e-9 * size)
    same_multipliers(c, kkt_monodromy(model, gait, c, tight))


def kkt_monodromy(model, gait, c, tight, step=2e-3):
    """Central differences of order six of the KKT form's period in (roll, pitch, rates)."""
    start = np.concatenate((c.euler[:2], c.euler_rates))

    def end(y):
        run = rr.simulate(model, gait, gait.period, gait.period, euler=(*y[:2], 0.0),
                          start=y[2:], **tight)  # fmt: skip
        return np.concatenate((run.euler[-1, :2], run.euler_rates[-1]))

    columns = []
    for e in step * np.eye(5):
        parts = [w * (end(start + k * e) - end(start - k * e))
                 for k, w in ((1, 45 / 60), (2, -9 / 60), (3, 1 / 60))]  # fmt: skip
        columns.append(sum(parts) / step)
    return np.array(columns).T
