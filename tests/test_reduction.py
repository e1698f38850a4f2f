"""Connection, height functions, net yaw three ways, reducibility, controllability, cycles."""

import numpy as np
import pytest
import sympy as sp

import rrrobot as rr
from rrrobot.drive.moves import LegMoves, Straight, ease, one_leg_gait, out_of_phase_gait
from rrrobot.figures.reduction import fig_13, height_map
from rrrobot.reduction.checks import (
    controllability,
    path_controllability,
    reducibility,
)
from rrrobot.reduction.connection import Connection, rotation_connection
from rrrobot.reduction.cycles import optimal_cycle
from rrrobot.reduction.heights import height_grid, zero_set
from rrrobot.reduction.yaw import net_yaw, yaw_rates
from tests.random_robot import random_robot

UP = np.pi / 2
UNEVEN = rr.RRRobotParameters(
    leg_mass=(0.05, 0.08), servo_mass=(0.06, 0.05), leg_length=(0.09, 0.11), hip_offset=0.1
)


@pytest.fixture(scope="module")
def robot():
    return rr.Robot.from_parameters()


@pytest.fixture(scope="module")
def connection(robot):
    return Connection(robot)


def random_cycle(rng, legs=2, size=0.3):
    return rr.FourierGait(
        offset=rng.uniform(-np.pi, np.pi, legs),
        cosine=size * rng.normal(size=(3, legs)) / np.array([[1], [4], [9]]),
        sine=size * rng.normal(size=(3, legs)) / np.array([[1], [4], [9]]),
        angular_frequency=rng.uniform(3, 8),
    )


def closed_forms():
    """A and H of eq (12), derived by SymPy for legs and hips that differ."""
    m1, m2, l1, l2, s, b, p1, p2 = sp.symbols("m1 m2 l1 l2 s b p1 p2")
    g11 = s * b**2 + (m1 + m2) * b**2 + m1 * (l1 * sp.cos(p1)) ** 2 + m2 * (l2 * sp.cos(p2)) ** 2
    A = [-m1 * l1 * b * sp.sin(p1) / g11, m2 * l2 * b * sp.sin(p2) / g11]
    H = sp.diff(A[0], p2) - sp.diff(A[1], p1)
    # What docs/reduction.md says for equal legs.
    m, length, G = sp.symbols("m l G")
    equal = {m1: m, m2: m, l1: length, l2: length}
    said = -2 * m**2 * length**3 * b * sp.sin(p1) * sp.sin(p2) * (sp.cos(p1) + sp.cos(p2)) / G**2
    assert sp.simplify((H.subs(equal) - said.subs(G, g11.subs(equal))).rewrite(sp.exp)) == 0
    return sp.lambdify((m1, m2, l1, l2, s, b, p1, p2), [*A, H])


@pytest.mark.parametrize("parameters", [rr.RRRobotParameters(), UNEVEN])
def test_connection_and_height_function_are_the_closed_forms(parameters):
    p = parameters
    A = Connection(rr.Robot.from_parameters(p))
    form = closed_forms()
    for phi in np.random.default_rng(1).uniform(-np.pi, np.pi, (50, 2)):
        g = rr.paper.yaw_mass_matrix(p, phi)
        assert np.abs(A(phi) - g[0, 1:] / g[0, 0]).max() < 1e-13
        assert abs(A.inertia(phi) - g[0, 0]) < 1e-15
        masses = (*p.leg_masses, *p.leg_lengths, sum(p.servo_masses), p.hip_offset)
        a1, a2, height = form(*masses, *phi)
        assert np.abs(A(phi) - (a1, a2)).max() < 1e-13
        assert abs(A.height(phi) - height) < 1e-14
        assert abs(A.height(phi, (1, 0)) + height) < 1e-14


def test_connection_of_any_tree_with_its_derivative():
    robot = random_robot(4, 7, shell_center=(0.0, 0.0, 0.0))
    A, model = Connection(robot), rr.YawModel(robot)
    rng = np.random.default_rng(2)
    for phi in rng.normal(size=(5, 7)):
        mass = model.mass_matrix(model.make_pose(np.zeros(3), np.zeros(2)), phi)
        ratio = mass[0, model.legs.v] / mass[0, 0]
        assert np.abs(A(phi) - ratio).max() < 1e-13
        h = 1e-3 * np.eye(7)
        fd = [(8 * (A(phi + e) - A(phi - e)) - A(phi + 2 * e) + A(phi - 2 * e)) / 12e-3 for e in h]
        assert np.abs(A.derivative(phi) - fd).max() < 1e-10
        rate = rng.normal(size=7)
        assert abs(yaw_rates(robot)(phi[None], rate[None])[0] + A(phi) @ rate) < 1e-13
        one, two = rng.normal(size=(2, 7))
        assert abs(A.flux(phi, one, two) - one @ A.curvature(phi) @ two) < 1e-13


def test_connection_about_another_pivot_and_axis():
    """The shell's centre off the base's origin: the momentum engine's own coefficients."""
    robot = random_robot(5, 5)
    phi, rate = np.random.default_rng(3).normal(size=(2, 5))
    assert abs(yaw_rates(robot)(phi[None], rate[None])[0] + Connection(robot)(phi) @ rate) < 1e-13
    off = Connection(robot, axis=(0.2, -1.0, 0.5), pivot=(0.1, 0.0, 0.2))
    gait = random_cycle(np.random.default_rng(9), 5)
    three = [net_yaw(off, gait, method=m) for m in ("line", "area", "simulate")]
    assert np.ptp(three) < 1e-8 and abs(three[0]) > 1e-6
    body = rr.Robot.from_parameters()
    model = rr.PivotingModel(body)
    phi, rate = phi[:2], rate[:2]
    quasi = model.impulsive_start(model.make_pose(np.zeros(3), np.zeros(2)), phi, rate)
    # At the upright pose (yaw, pitch, roll) rates are the body's angular velocity (z, y, x).
    assert np.abs(rotation_connection(body, phi) @ rate + quasi[::-1]).max() < 1e-13


def test_net_yaw_three_ways_on_random_cycles(robot):
    rng = np.random.default_rng(4)
    largest = 0.0
    for _ in range(3):
        gait = random_cycle(rng)
        line, area, run = (net_yaw(robot, gait, method=m) for m in ("line", "area", "simulate"))
        assert abs(line - area) < 1e-11
        assert abs(line - run) < 1e-8
        t = rr.simulate(rr.YawModel(robot), gait, gait.period, gait.period / 20)
        assert abs(line - t.euler[-1, 2]) < 1e-8
        largest = max(largest, abs(line))
    assert largest > 1e-3


@pytest.mark.parametrize(
    "name, legs",
    [("solo12", 4), ("ur5", 6), pytest.param("talos", 8, marks=pytest.mark.slow)],
)
def test_example_robots_turn_by_leg_motion_alone(name, legs):
    pytest.importorskip("example_robot_data")
    joints = rr.Robot.from_example(name, shell=rr.Sphere(0.5)).legs[:legs]
    robot = rr.Robot.from_example(name, shell=rr.Sphere(0.5), legs=joints)
    gait = random_cycle(np.random.default_rng(5), legs)
    line, area, run = (net_yaw(robot, gait, method=m) for m in ("line", "area", "simulate"))
    assert abs(line) > 1e-5
    assert abs(line - area) < 1e-9
    assert abs(line - run) < 1e-6


def test_fig_13_trajectories(robot):
    A, B = out_of_phase_gait(offset=5 * np.pi / 8 + 0.15), out_of_phase_gait(offset=UP)
    for method in ("line", "area", "simulate"):
        assert net_yaw(robot, A, method=method) == pytest.approx(-0.012996229, abs=1e-9)
        assert abs(net_yaw(robot, B, method=method)) < 1e-12


def test_area_counts_crossings_and_windings(robot):
    """A figure of eight, and a circle that goes round three times."""
    eight = rr.FourierGait(
        offset=(1.0, 1.3), cosine=[[0, 0], [0, 0]], sine=[[0.5, 0], [0, 0.4]], angular_frequency=2
    )
    thrice = rr.FourierGait(
        offset=(1, 1), cosine=[[0, 0], [0, 0], [0, 0.3]], sine=[[0, 0], [0, 0], [0.3, 0]],
        angular_frequency=1,
    )  # fmt: skip
    once = rr.FourierGait(offset=(1, 1), cosine=[[0, 0.3]], sine=[[0.3, 0]], angular_frequency=1)
    for gait in (eight, thrice):
        assert abs(net_yaw(robot, gait) - net_yaw(robot, gait, method="area")) < 1e-12
    assert net_yaw(robot, thrice) == pytest.approx(3 * net_yaw(robot, once), abs=1e-12)


def test_one_leg_gait(robot):
    """Acyclic; forth and back along one leg gains nothing."""
    forth = one_leg_gait((1.0, 1.4), leg=1, target=2.2)
    back = one_leg_gait((1.0, 2.2), leg=1, target=1.0 + 0.4)
    x, w = np.polynomial.legendre.leggauss(40)
    p2 = 1.8 + 0.4 * x
    mlb, ml2 = 0.057 * 0.1 * 0.12, 0.057 * 0.1**2
    g11 = 2 * 0.11 * 0.12**2 + ml2 * (np.cos(1.0) ** 2 + np.cos(p2) ** 2)
    closed = -0.4 * w @ (mlb * np.sin(p2) / g11)
    assert abs(net_yaw(robot, forth) - closed) < 1e-13
    assert abs(net_yaw(robot, forth) + net_yaw(robot, back)) < 1e-13
    assert abs(net_yaw(robot, forth, method="simulate") - closed) < 1e-8


def test_zero_set_is_known_lines(connection):
    lines = zero_set(connection, angle_range=(0.1, 3.0), resolution=25)
    assert len(lines) == 1
    assert np.abs(lines[0].sum(axis=1) - np.pi).max() < 1e-12
    whole = np.concatenate(zero_set(connection, angle_range=(-1.5, 4.5), resolution=24))
    nearest = np.min(np.abs([np.sin(whole[:, 0]), np.sin(whole[:, 1]), np.cos(whole).sum(1)]), 0)
    assert np.quantile(nearest, 0.8) < 1e-12
    first, second, heights = height_grid(connection, angle_range=[(0, 1), (1, 3)], resolution=4)
    assert heights[1, 3] == connection.height((first[1], second[3]))


@pytest.mark.parametrize(
    "kind, weightless_too",
    [
        (rr.YawModel, True),
        (rr.PivotingModel, True),
        (rr.PitchModel, False),
        (rr.RollModel, False),
        (rr.FullModel, False),
    ],
)
def test_which_models_reduce(robot, kind, weightless_too):
    found = reducibility(kind(robot, damping=None))
    assert found.reducible == (kind is rr.YawModel)
    assert (found.gravity > 1) == (kind is not rr.YawModel)
    assert ("gravity" in found.reasons[0]) == (kind is not rr.YawModel)
    free = reducibility(kind(robot, ground=rr.Plane(gravity=0.0), damping=None))
    assert free.reducible == weightless_too
    assert free.gravity == 0
    assert (free.inertia > 1e-3) == (not weightless_too)
    damped = reducibility(kind(robot, ground=rr.Plane(gravity=0.0), damping=0.01))
    assert not damped.reducible and "damping" in " ".join(damped.reasons)


@pytest.mark.parametrize("kind, same", [(rr.PivotingModel, True), (rr.FullModel, False)])
def test_dynamics_at_any_time_scaling(robot, kind, same):
    """Without gravity the pivoting body's path is that of the legs, however they hurry or linger.

    A leg that moves and stops leaves the rolling body turning, at an attitude that depends on how.
    """
    model = kind(robot, ground=rr.Plane(gravity=0.0), damping=None)
    ends = []
    for ramp, duration in ((0.5, 1.2), (0.1, 0.5)):
        move = Straight(
            start=np.array((1.0, 1.4)), end=np.array((2.2, 2.6)), duration=duration, ramp=ramp
        )
        ends.append(rr.simulate(model, LegMoves([move]), duration, rtol=1e-12))
    away = np.abs(ends[0].euler[-1] - ends[1].euler[-1]).max()
    turning = np.abs(ends[0].euler_rates[-1]).max()
    assert (away < 1e-8, turning < 1e-8) == (same, same)
    if not same:
        assert away > 1e-6 and turning > 1e-4


def test_controllability(connection):
    for phi, order in (((0.8, 0.8), 2), ((UP, UP), 3), ((0.4, np.pi - 0.4), 3), ((0, 0.5), 3),
                       ((0, 0), 4), ((0, np.pi), 6)):  # fmt: skip
        found = controllability(connection, phi)
        assert (found.order, found.rank, found.controllable) == (order, 3, True)
    assert not controllability(connection, (0, np.pi), highest_order=5).controllable
    assert all(c.controllable for c in path_controllability(connection, [(0, 1), (1, 1)]))
    single = random_robot(1, 1, shell_center=(0, 0, 0))
    found = controllability(single, (0.3,))
    assert (found.rank, found.dimension, found.controllable) == (1, 2, False)


@pytest.mark.slow
def test_best_cycle_follows_the_zero_set(connection):
    best = optimal_cycle(connection, angle_range=(-0.2, 2.9))
    assert 0.98 < best.net_yaw / best.region_yaw < 1.001
    # The region is bounded by the lines phi_1 = 0, phi_2 = 0, phi_1 + phi_2 = pi.
    path = best.gait(np.linspace(0, best.gait.period, 400)).angle
    away = np.min([np.abs(path[:, 0]), np.abs(path[:, 1]), np.abs(path.sum(1) - np.pi)], axis=0)
    assert np.median(away) < 0.03
    grown = optimal_cycle(connection, angle_range=(0.5, 1.4), harmonics=4)
    inside = grown.gait(np.linspace(0, grown.gait.period, 999)).angle
    assert inside.min() >= 0.5 - 1e-12 and inside.max() <= 1.4 + 1e-12
    circle = out_of_phase_gait(offset=0.95, amplitude=0.45)
    assert grown.net_yaw > abs(net_yaw(connection, circle))


def test_most_yaw_per_travel_balances_curvature_and_height(connection):
    """Stationarity of yaw / travel: curvature = height / (yaw / travel), all along the path."""
    best = optimal_cycle(connection, per="travel", angle_range=(0.0, np.pi))
    motion = best.gait(np.linspace(0, best.gait.period, 50))
    (x, y), (ax, ay) = motion.rate.T, motion.acceleration.T
    curvature = (x * ay - y * ax) / np.hypot(x, y) ** 3
    assert np.abs(curvature * best.per_travel / connection.height(motion.angle) - 1).max() < 0.05
    assert best.per_travel > 0.0123


def test_hump_of_fig_12b_is_the_connection(connection):
    """Docs: small legs in antiphase swing the yaw by 2 A M_l l b sin / g11, highest at pi/2."""
    offsets = np.linspace(0, np.pi, 91)
    values = connection(np.column_stack((offsets, offsets)))
    gain = np.abs(values[:, 0]) + np.abs(values[:, 1])
    assert offsets[np.argmax(gain)] == pytest.approx(UP)
    # Half of the hump's sharpness is the inertia, which is least with the legs up.
    bend = np.gradient(np.gradient(np.log(gain[20:71]), offsets[1]), offsets[1])[25]
    assert bend == pytest.approx(-1 - 2 * 2 * 0.057 * 0.01 / 0.003168, rel=0.01)


def test_ease_is_smooth():
    x = np.linspace(0, 1, 2001)
    for ramp in (0.5, 0.1):
        s, rate, bend = ease(x, ramp)
        assert (s[0], s[-1], rate[0], rate[-1], bend[0], bend[-1]) == (0, 1, 0, 0, 0, 0)
        assert np.abs(np.gradient(s, x) - rate)[1:-1].max() < 1e-3
        assert np.abs(np.gradient(rate, x) - bend)[1:-1].max() < 0.05
        assert rate.max() == pytest.approx(1 / (1 - ramp))


def test_pictures(robot, tmp_path):
    figure = fig_13(robot)
    figure.savefig(tmp_path / "fig13.png")
    texts = {text.get_text() for text in figure.axes[0].texts}
    assert {"+", "\N{MINUS SIGN}", "A", "B"} <= texts
    labels = [t.get_text() for t in figure.axes[0].get_legend().get_texts()]
    assert labels[1:] == ["A: -0.7446 deg a cycle", "B: 0 a cycle"]
    height_map(robot, resolution=9, signs=False).figure.savefig(tmp_path / "heights.svg")


def test_refusals(robot, connection):
    with pytest.raises(rr.ParameterError, match="two different legs"):
        connection.height((0, 0), (0, 0))
    with pytest.raises(rr.ParameterError, match="each of the 2 legs"):
        connection((1, 2, 3))
    with pytest.raises(rr.ParameterError, match="axis is zero"):
        Connection(robot, axis=(0, 0, 0))
    with pytest.raises(rr.ModelError, match="only yaw"):
        Connection(rr.PitchModel(robot))
    with pytest.raises(rr.GaitError, match="no end"):
        net_yaw(robot, rr.StillLegs((1, 1)))
    with pytest.raises(rr.GaitError, match="only a closed"):
        net_yaw(robot, one_leg_gait((1, 1), leg=0, target=2), method="area")
    with pytest.raises(rr.GaitError, match="moves 3 legs"):
        net_yaw(robot, rr.StillLegs((1, 1, 1)))
    with pytest.raises(rr.ParameterError, match="method"):
        net_yaw(robot, rr.gait("lateral"), method="guess")
    with pytest.raises(rr.ParameterError, match="low below high"):
        zero_set(robot, angle_range=(1, 0))
    with pytest.raises(rr.ParameterError, match="per is"):
        optimal_cycle(robot, per="far")
    with pytest.raises(rr.GaitError, match="already"):
        one_leg_gait((1, 1), leg=0, target=1)
    with pytest.raises(rr.ModelError, match="no inertia"):
        rod()((0.0,))


def rod():
    """A tip mass alone, moved onto the axis."""
    text = (
        '<robot name="rod"><link name="base"/><link name="tip"><inertial><mass value="1"/>'
        '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>'
        '<joint name="slide" type="prismatic"><parent link="base"/><child link="tip"/>'
        '<axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    return Connection(rr.Robot.from_urdf(text, shell=rr.Sphere(0.1)))
