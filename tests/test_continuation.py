"""Branches of limit cycles: folds, period doublings and branch points, located and switched."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import rrrobot as rr
from rrrobot.orbits import branches
from tests import kane_lanes as kane
from tests.derivations import PointMassRobot, single_axis_model

ROBOT = rr.Robot.from_parameters()
FULL = rr.FullModel(ROBOT)
LIGHT = 0.003


def kane_single(axis, gait, damping, state):
    """(angle, rate) of a single-axis model one period later, by Kane's equations."""

    def rate(t, y):
        motion = single_axis_model(axis, PointMassRobot(), y[0], y[1], *gait(t), damping=damping)
        return np.array((y[1], float(np.squeeze(motion.theta_ddot))))

    out = solve_ivp(rate, (0.0, gait.period), state, method="DOP853", rtol=1e-11, atol=1e-13)
    return out.y[:, -1]


def kane_monodromy(axis, gait, damping, state, step=1e-4):
    columns = []
    for e in step * np.eye(2):
        low, high = (kane_single(axis, gait, damping, state + k * e) for k in (-1, 1))
        columns.append((high - low) / (2 * step))
    return np.array(columns).T


@pytest.fixture(scope="module")
def mathieu():
    """Legs in phase about the horizontal, a bit above twice the frequency of the roll."""
    model = rr.RollModel(ROBOT, damping=LIGHT)
    omega = 1.04 * 4 * np.pi / rr.orbits.modes(model, (0.0, 0.0))[0].period
    gait = rr.SinusoidalGait(offset=0.0, amplitude=0.02, angular_frequency=omega)
    return rr.orbits.branch(rr.limit_cycle(model, gait), "amplitude", to=0.4)


def test_period_doubling_where_kanes_hill_equation_has_it(mathieu):
    """The upright roll is a solution; its linearisation doubles where a multiplier is -1."""
    omega = mathieu.cycles[0].gait.angular_frequency[0]

    def distance(amplitude):
        gait = rr.SinusoidalGait(offset=0.0, amplitude=amplitude, angular_frequency=omega)
        return np.linalg.det(kane_monodromy("roll", gait, LIGHT, np.zeros(2)) + np.eye(2))

    expected = brentq(distance, 0.1, 0.39, xtol=1e-8)
    (place,) = [i for kind, i in mathieu.special if kind == "period doubling"]
    assert mathieu.value[place] == pytest.approx(expected, abs=1e-6)
    assert mathieu.cycles[place].multipliers[0] == pytest.approx(-1.0, abs=1e-9)
    np.testing.assert_array_equal(mathieu.stable[:place], True)
    np.testing.assert_array_equal(mathieu.stable[place + 1 :], False)


def test_the_doubled_branch(mathieu):
    """Supercritical: it swings over two periods, and its square grows with the amplitude."""
    where = mathieu.value[mathieu.special[0][1]]
    squares, beyond = [], []
    for length in (0.01, 0.015, 0.02):
        c = mathieu.switched(length=length)
        assert c.periods == 2 and c.residual < 1e-11
        P = c.found.map._replace(periods=1)
        other = P(c.point[None])[0]
        assert np.abs(other - c.point).max() > 0.5 * length
        np.testing.assert_allclose(P(other[None])[0], c.point, atol=1e-11)
        squares.append(length**2)
        beyond.append(c.gait.amplitude[0] - where)
    assert all(b > 0 for b in beyond)
    assert beyond[2] / beyond[0] == pytest.approx(squares[2] / squares[0], rel=0.05)


@pytest.fixture(scope="module")
def duffing():
    """The pitch, softening as a pendulum does, through its resonance from above."""
    model = rr.PitchModel(ROBOT, damping=0.0015)
    gait = rr.SinusoidalGait(offset=np.pi / 2, amplitude=0.04, angular_frequency=7.0)
    return rr.orbits.branch(rr.limit_cycle(model, gait), "angular_frequency", to=4.5, back=8.0)


def test_folds_of_a_softening_pendulum(duffing):
    """Two folds; at each, Kane's equations close and have a multiplier of one."""
    folds = [i for kind, i in duffing.special if kind == "fold"]
    assert len(folds) == 2
    assert duffing.value[-1] == pytest.approx(4.5)
    for i in folds:
        c = duffing.cycles[i]
        start = np.array((c.euler[1], c.euler_rates[1]))
        np.testing.assert_allclose(kane_single("pitch", c.gait, 0.0015, start), start, atol=1e-8)
        values = np.linalg.eigvals(kane_monodromy("pitch", c.gait, 0.0015, start))
        assert np.abs(values - 1).min() < 1e-6
        nearest = np.argmin(np.abs(c.multipliers - 1))
        assert abs(c.multipliers[nearest] - 1) < 1e-8
    # Between the folds the branch does not hold, and runs back.
    one, two = folds
    assert not duffing.stable[one + 1 : two].any()
    assert duffing.value[one] < duffing.value[two]
    assert duffing.stable[: one - 1].all() and duffing.stable[two + 2 :].all()


def test_symmetry_is_lost_with_legs_in_phase():
    """RRRobot rocking forward and back begins to roll and to turn: a branch point."""
    gait = rr.SinusoidalGait(offset=np.pi / 2, amplitude=0.3, angular_frequency=5.2)
    line = rr.orbits.branch(rr.limit_cycle(FULL, gait), "amplitude", to=0.7)
    assert [kind for kind, _ in line.special] == ["branch point"] * 2
    where = line.value[line.special[0][1]]
    assert where == pytest.approx(0.404621, abs=1e-5)
    c = line.switched("branch point", length=0.05)
    assert c.stable and abs(c.yaw_rate) > 0.01 and c.amplitude[0] > 0.01
    mirrored = line.switched("branch point", length=-0.05)
    assert mirrored.yaw_rate == pytest.approx(-c.yaw_rate, rel=1e-6)


@pytest.mark.slow
def test_a_torus_is_born_where_kanes_equations_have_a_pair_of_size_one():
    """Legs in phase, little damping: the pair of the roll leaves the unit circle."""
    light = 0.002
    gait = rr.SinusoidalGait(offset=np.pi / 2, amplitude=0.18, angular_frequency=6.293)
    c = rr.limit_cycle(rr.FullModel(ROBOT, damping=light), gait)
    line = rr.orbits.branch(c, "amplitude", to=0.26, back=0.17)
    ((kind, place),) = line.special
    assert kind == "torus" and line.value[place] == pytest.approx(0.221573, abs=1e-6)
    assert line.stable[:place].all() and not line.stable[place + 1 :].any()
    c = line.cycles[place]
    legs = kane.Gaits(*(np.full((1, 2), x) for x in (np.pi / 2, line.value[place], 0.0)),
                      np.array([6.293]))  # fmt: skip
    start = np.concatenate((c.euler, c.euler_rates, np.zeros(4)))[None]
    end, _ = kane.carried(legs, start, 1, 60, light)
    np.testing.assert_allclose(end[:, kane.BACK], start[:, kane.BACK], atol=1e-10)
    (monodromy,) = kane.monodromies(legs, start, 60, light)
    pair = kane.sorted_by_size(np.linalg.eigvals(monodromy))[:2]
    np.testing.assert_allclose(np.abs(pair), 1.0, atol=1e-7)
    assert abs(pair[0].imag) > 0.5
    np.testing.assert_allclose(pair, c.multipliers[:2], atol=1e-7)


def test_points_of_a_branch_are_limit_cycles():
    c = rr.limit_cycle(FULL, rr.gait("circular"))
    line = rr.orbits.branch(c, "leg_mass", to=0.08)
    assert line.value[-1] == pytest.approx(0.08, rel=1e-12)
    heavy = rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=0.08))
    end = rr.limit_cycle(rr.FullModel(heavy), rr.gait("circular"))
    assert line.cycles[-1].speed == pytest.approx(end.speed, rel=1e-9)
    np.testing.assert_allclose(line.cycles[-1].multipliers, end.multipliers, atol=1e-9)


def test_save_resume_and_plot(tmp_path):
    c = rr.limit_cycle(FULL, rr.gait("circular"))
    store = tmp_path / "branch.nc"
    part = rr.orbits.branch(c, "amplitude", to=0.6, n_points=4, store=store)
    assert "4 points" in part.ended
    whole = rr.orbits.branch(c, "amplitude", to=0.6, store=store)
    direct = rr.orbits.branch(c, "amplitude", to=0.6)
    np.testing.assert_allclose(whole.value[:4], part.value[:4], rtol=1e-9)
    assert whole.value[-1] == pytest.approx(0.6)
    assert whole.cycles[-1].speed == pytest.approx(direct.cycles[-1].speed, rel=1e-9)
    data = whole.to_dataset()
    assert data.speed.attrs["units"] == "m/s" and data.stable.values.all()
    whole.plot("yaw_rate").figure.savefig(tmp_path / "branch.png")
    with pytest.raises(rr.OutputError, match="holds another branch"):
        rr.orbits.branch(c, "offset", to=1.0, store=store)


def test_interrupting_keeps_the_branch(monkeypatch):
    c = rr.limit_cycle(FULL, rr.gait("circular"))
    count, step = [0], branches.Walk._stepped

    def stopped(self, point):
        count[0] += 1
        if count[0] == 4:
            raise KeyboardInterrupt
        return step(self, point)

    monkeypatch.setattr(branches.Walk, "_stepped", stopped)
    with pytest.raises(rr.errors.BranchInterrupted, match="after 4 points") as caught:
        rr.orbits.branch(c, "amplitude", to=0.9)
    assert len(caught.value.branch.cycles) == 4


def test_a_branch_ends_at_lift_off_with_the_reason():
    gait = rr.SinusoidalGait(offset=0.5, amplitude=0.3, angular_frequency=20.0, phase=(0.0, 0.3))
    line = rr.orbits.branch(rr.limit_cycle(FULL, gait), "angular_frequency", to=60.0)
    assert "normal force reaches zero" in line.ended
    assert line.cycles[-1].lifts_off


def test_an_interrupted_branch_is_gone_on_from(monkeypatch, tmp_path):
    c, store = rr.limit_cycle(FULL, rr.gait("circular")), tmp_path / "branch.nc"
    whole = rr.orbits.branch(c, "amplitude", to=0.5)
    count, step = [0], branches.Walk._stepped

    def stopped(self, point):
        count[0] += 1
        if count[0] == 3:
            raise KeyboardInterrupt
        return step(self, point)

    with monkeypatch.context() as patch:
        patch.setattr(branches.Walk, "_stepped", stopped)
        with pytest.raises(rr.errors.BranchInterrupted, match="and so does"):
            rr.orbits.branch(c, "amplitude", to=0.5, store=store)
    resumed = rr.orbits.branch(c, "amplitude", to=0.5, store=store)
    np.testing.assert_allclose(resumed.value[:3], whole.value[:3], rtol=1e-9)
    assert resumed.value[-1] == pytest.approx(0.5, rel=1e-12)
    assert resumed.cycles[-1].speed == pytest.approx(whole.cycles[-1].speed, rel=1e-9)


def test_a_branch_ends_at_the_vertical_with_the_reason():
    """The pitch's swing grows towards resonance until it reaches 90 degrees."""
    gait = rr.SinusoidalGait(offset=np.pi / 2, amplitude=0.8, angular_frequency=5.2)
    line = rr.orbits.branch(rr.limit_cycle(FULL, gait), "amplitude", to=3.0, step=0.3)
    assert "the pitch reaches 90 degrees near amplitude = 1.4" in line.ended
    assert "BodyRateDamping" in line.ended
    top = np.abs(line.cycles[-1].trajectory().euler[:, 1]).max()
    assert np.deg2rad(85) < top < np.pi / 2


def test_bad_input():
    c = rr.limit_cycle(FULL, rr.gait("circular"))
    with pytest.raises(rr.ParameterError, match="damping must stay above 0, for without it"):
        rr.orbits.branch(c, "damping", to=0.0)
    with pytest.raises(rr.ParameterError, match=r"to is -0\.01 kg: leg_mass must stay above 0"):
        rr.orbits.branch(c, "leg_mass", to=-0.01)
    with pytest.raises(rr.ParameterError, match=r"back is -1 rad/s: angular_frequency must stay"):
        rr.orbits.branch(c, "angular_frequency", to=9.0, back=-1.0)
    with pytest.raises(rr.ParameterError, match="no parameter 'hat' here: it must be one of"):
        rr.orbits.branch(c, "hat", to=1.0)
    with pytest.raises(rr.ParameterError, match="where the cycle is already"):
        rr.orbits.branch(c, "amplitude", to=0.3)
    with pytest.raises(rr.ParameterError, match="has 0 events"):
        rr.orbits.branch(c, "amplitude", to=0.31).switched()
