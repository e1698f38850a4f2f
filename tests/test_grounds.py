"""Any shell on any ground: values of an independent derivation, closed forms, invariants."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rrrobot as rr
from rrrobot.drive.gaits import LegMotion
from tests.some import some
from tests.terrain import (
    BOULDER,
    BOX,
    EGG,
    EL,
    GAIT,
    GRAPH,
    LEVEL,
    PAIRS,
    SLOPE,
    SP,
    START,
    Egg,
    model,
)  # fmt: skip

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


@pytest.mark.parametrize("name", some(PAIRS, "BD"))
def test_ten_seconds_have_the_reference_values(name):
    t = rr.simulate(model(*PAIRS[name]), GAIT, 10.0, 1.0, euler=START, rtol=1e-11, atol=1e-12)
    euler, point, force, torque = TEN[name]
    np.testing.assert_allclose(t.euler[-1], euler, atol=2e-8)
    np.testing.assert_allclose(t.ground.point(t.position[-1]), point, atol=2e-9)
    np.testing.assert_allclose(t.contact_force[-1], force, atol=5e-8)
    np.testing.assert_allclose(t.leg_torque[-1], torque, atol=5e-9)
    assert t.slip.max() < 1e-12
    assert np.abs(t.height_error).max() < 1e-12


BALL = """<robot name="ball"><link name="base"><inertial><mass value="2"/>
<inertia ixx="{x}" iyy="{y}" izz="{z}" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
RADIUS = 0.1


def ball(ground, inertia=(0.008, 0.008, 0.008)):
    """A ball with its mass at the centre; a solid one of 2 kg unless told otherwise."""
    text = BALL.format(x=inertia[0], y=inertia[1], z=inertia[2])
    robot = rr.Robot.from_urdf(text, shell=rr.Sphere(RADIUS))
    return rr.FullModel(robot, ground=ground, damping=None)


def test_solid_ball_rolls_down_a_slope_with_five_sevenths_g_sin():
    tilt = 0.2
    down = ball(rr.Plane(normal=(np.sin(tilt), 0, np.cos(tilt))))
    t = rr.simulate(down, rr.StillLegs(()), 1.0, 0.5, start="rest")
    expected = 0.5 * 5 / 7 * 9.81 * np.sin(tilt)
    assert t.position[-1] == pytest.approx((expected, 0), abs=1e-11)
    assert t.required_friction[-1] == pytest.approx(2 / 7 * np.tan(tilt), rel=1e-11)


@pytest.mark.parametrize("rock", [0.3, 2.0])
def test_solid_ball_leaves_a_fixed_sphere_where_the_closed_form_says(rock):
    """From rest at th0 the normal force ends at cos th = 10/17 cos th0, whatever the radii."""
    start = 0.5
    t = rr.simulate(
        ball(rr.Boulder(rock)), rr.StillLegs(()), 1.0 if rock > 1 else 0.42, 0.002, start="rest",
        position=(rock * np.sin(start), 0), rtol=1e-11, atol=1e-12,
    )  # fmt: skip
    cosine, force = t.ground_normal[:, 2], t.normal_force
    assert t.lift_off_time is not None
    k = int(np.flatnonzero(force <= 0)[0])
    share = force[k - 1] / (force[k - 1] - force[k])
    at = cosine[k - 1] + share * (cosine[k] - cosine[k - 1])
    assert at == pytest.approx(10 / 17 * np.cos(start), abs=2e-5)


def test_chaplygin_ball_keeps_its_momentum_about_the_contact():
    """Centre of mass at the centre, any inertia, level ground: R K is constant."""
    inertia = np.array((0.004, 0.007, 0.0095))
    t = rr.simulate(
        ball(rr.Plane(), inertia), rr.StillLegs(()), 2.0, 0.5, start=(3.0, 2.0, -1.0),
        rtol=1e-12, atol=1e-12,
    )  # fmt: skip
    found = []
    for q, v in zip(t.configuration, t.velocity, strict=True):
        turn = Rotation.from_quat(q[3:7]).as_matrix()
        spin = turn @ (inertia * v[3:6])
        found.append(spin + 2 * np.cross((0, 0, RADIUS), turn @ v[:3]))
    np.testing.assert_allclose(found, found[0][None].repeat(len(found), 0), atol=1e-11)
    assert np.ptp(t.euler[:, 0]) > 1


UP = (np.pi / 2, np.pi / 2)
ROLL, PITCH = 0.010212, 0.007044
"""Of RRRobot, legs straight up: inertia about the contact, of a sphere of 0.12 m [kg m^2]."""


def stiffness(full, axis, inertia):
    """Tilting stiffness, from the mode's frequency [N m]."""
    periods = {m.axis: m.period for m in rr.orbits.modes(full, UP) if np.isfinite(m.period)}
    return inertia * (2 * np.pi / periods[axis]) ** 2


def test_stiffness_is_that_of_the_statics():
    """M g [(H^-1 + B)^-1 - h], the roll by the curvature of the other direction."""
    robot, height, weight = model(SP, LEVEL).robot, 0.0726923077, 0.52 * 9.81
    for rock in (0.5, 0.2, -0.9):
        full = rr.FullModel(robot, ground=rr.Boulder(rock), damping=None)
        arm = 1 / (1 / 0.12 + 1 / rock) - height
        assert stiffness(full, "pitch", PITCH) == pytest.approx(weight * arm, rel=3e-4)
        assert stiffness(full, "roll", ROLL) == pytest.approx(weight * arm, rel=3e-4)
    full = rr.FullModel(model(EL, LEVEL).robot, damping=None)
    a, b, c = EL.semi_axes
    assert stiffness(full, "pitch", PITCH) == pytest.approx(weight * (a * a / c - height), rel=3e-4)
    assert stiffness(full, "roll", ROLL) == pytest.approx(weight * (b * b / c - height), rel=3e-4)


@pytest.mark.parametrize(("rock", "stable"), [(0.1843, False), (0.1845, True)])
def test_a_boulder_too_small_is_no_rest(rock, stable):
    """Of RRRobot with its legs straight up: stable above 0.184390 m."""
    full = rr.FullModel(model(SP, LEVEL).robot, ground=rr.Boulder(rock), damping=None)
    slowest = min(m.decay_rate for m in rr.orbits.modes(full, UP))
    assert (slowest > -1e-3) is stable


@pytest.mark.parametrize("ground", [SLOPE, BOULDER, GRAPH], ids=["slope", "boulder", "graph"])
@pytest.mark.parametrize("shell", [EL, EGG], ids=["ellipsoid", "egg"])
def test_drift_is_the_rate_of_the_slip(shell, ground):
    """d(J v)/dt = J a + gamma along a rolling motion with any a, by differences."""
    full = model(shell, ground)
    pose = full.make_pose(np.array((0.1, 0.2, 0.3)), np.array((0.03, 0.02)))
    quasi, rate = np.array((0.5, -0.9, 0.7)), np.array((1.0, -2.0))
    angle, data = np.array((0.9, 1.3)), full.data
    v = full.velocity(pose, quasi, rate)
    rows = full.rolling.evaluate(data, full.configuration(pose, angle), v)
    np.testing.assert_allclose(rows.residual, 0, atol=1e-13)

    def slip(h):
        place = full.place(pose)
        moved = pose + h * full.pose_rate(place, pose, quasi)
        # The velocity is kept while the place moves: a = 0.
        q = full.configuration(moved, angle + h * rate)
        return full.rolling.evaluate(data, q, v).residual

    h = 1e-4
    numeric = (8 * (slip(h) - slip(-h)) - (slip(2 * h) - slip(-2 * h))) / (12 * h)
    np.testing.assert_allclose(rows.drift, numeric, atol=1e-9)


def test_contact_is_found_from_where_the_shell_stands():
    for shell, ground in PAIRS.values():
        full = model(shell, ground)
        pose = full.make_pose(np.array(START), np.array((0.03, -0.02)))
        q = full.configuration(pose, (1.0, 1.0))
        full.rolling.evaluate(full.data, q, np.zeros(8))
        assert full.rolling.height(full.data) == pytest.approx(0, abs=1e-15)
        q[2] += 1e-3
        full.rolling.evaluate(full.data, q, np.zeros(8))
        normal = ground.normal(ground.point(pose[4:]))
        assert full.rolling.height(full.data) == pytest.approx(1e-3 * normal[2], rel=2e-3)


def test_shells_and_grounds_are_saved_and_loaded(tmp_path):
    grid = rr.Graph.from_grid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21), np.zeros((21, 21)))
    for shell, ground in ((BOX, LEVEL), (EGG, BOULDER), (EL, grid)):
        t = rr.simulate(model(shell, ground), GAIT, 0.1, 0.05)
        again = rr.Trajectory.load(t.save(tmp_path / "t.npz"))
        assert again.robot.shell.to_dict() == shell.to_dict()
        assert again.ground.to_dict() == ground.to_dict()
    with pytest.raises(rr.RRRobotError, match="by the function"):
        rr.contact.ground_from_dict(GRAPH.to_dict())


def test_what_is_wrong_is_named():
    with pytest.raises(rr.RRRobotError, match="not strictly convex"):
        replace(model(SP, LEVEL).robot, shell=Egg(0.12, 0.08))
    with pytest.raises(rr.RRRobotError, match="one ellipsoid must"):
        rr.EllipsoidSum([(0.1, 0.1, 0.0)])
    with pytest.raises(rr.RRRobotError, match="gradient is not that of height"):
        rr.Graph(lambda x, y: x * y, lambda x, y: (x, y), lambda x, y: ((0, 1), (1, 0)))
    with pytest.raises(rr.RRRobotError, match="equally spaced"):
        rr.Graph.from_grid((0, 1, 2, 3, 4, 6), range(6), np.zeros((6, 6)))
    with pytest.raises(rr.RRRobotError, match="boulder's is above zero"):
        rr.Boulder(0.0)
    hollow = rr.FullModel(model(EL, LEVEL).robot, ground=rr.Boulder(-0.14))
    with pytest.raises(rr.RRRobotError, match="tighter than the shell"):
        rr.simulate(hollow, GAIT, 1.0)

    class Wrong(Egg):
        def contact(self, u):
            return -super().contact(-u)

    with pytest.raises(rr.RRRobotError, match="contact is not the gradient"):
        rr.contact.check_convex(Wrong())


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("support", lambda u: 1 / 0, "support a number, .*ZeroDivisionError"),
        ("contact", lambda u: [0.0, 0.1], "contact .*TypeError"),
        ("contact", lambda u: np.full(3, np.nan), "contact is not finite"),
        ("hessian", lambda u: np.full((3, 3), np.inf), "hessian is not finite"),
    ],
)
def test_functions_of_a_shell_that_fail_are_named(name, value, said):
    shell = Egg(0.12, 0.03)
    setattr(shell, name, value)
    with pytest.raises(rr.ShellError, match=said):
        replace(model(SP, LEVEL).robot, shell=shell)


def test_a_radius_below_zero_is_seen():
    """Of an egg with too large an odd part, at its blunt end: a + e (6 c - 8 c^3) with c = 1."""
    assert Egg(0.12, 0.07).principal_radii(np.array((2.0, 0.0, 0.0))) == pytest.approx([-0.02] * 2)
    assert Egg(0.12, 0.03).principal_radii(np.array((2.0, 0.0, 0.0))) == pytest.approx([0.06] * 2)


AXIS = np.linspace(-1.0, 1.0, 21)
HILLS = 0.02 * np.sin(3 * AXIS)[:, None] * np.cos(2 * AXIS)


@pytest.mark.parametrize(
    ("x", "heights", "said"),
    [
        (AXIS[::-1], HILLS, "0.9 comes after 1. Sort it"),
        (np.where(AXIS > 0.9, np.nan, AXIS), HILLS, "nan is no place"),
        (np.meshgrid(AXIS, AXIS)[0], HILLS, r"it has shape \(21, 21\)"),
        (AXIS**3, HILLS, "its steps are from 0.001 to 0.271"),
        (AXIS, HILLS[:20], r"it must be \(21, 21\)"),
        (AXIS, np.where(np.eye(21) * AXIS > 0.55, np.nan, HILLS), "5 of the 441 .* x = 0.6 m"),
        (AXIS, [[1.0, 2.0], [3.0]], "heights must be an array of numbers"),
        (["a"] * 6, HILLS, "x must be an array of numbers"),
    ],
)
def test_a_grid_of_heights_that_is_none_is_named(x, heights, said):
    with pytest.raises(rr.ParameterError, match=said):
        rr.Graph.from_grid(x, AXIS, heights)


def test_a_grid_is_read_from_a_table_of_few_digits(tmp_path):
    table = np.zeros((22, 31))
    table[1:, 0], table[0, 1:] = np.linspace(0, 1 / 3, 21), np.linspace(-1, 1, 30)
    table[1:, 1:] = 0.1 * np.multiply.outer(table[1:, 0], table[0, 1:])
    np.savetxt(tmp_path / "hills.csv", table, delimiter=",", fmt="%.5g")
    ground = rr.Graph.from_file(tmp_path / "hills.csv")
    assert ground.point(np.array((0.2, 0.5)))[2] == pytest.approx(0.01, abs=1e-5)
    table[3, 4] = np.nan
    np.savetxt(tmp_path / "holes.csv", table, delimiter=",")
    for name, said in (("holes.csv", "1 of the 630 heights"), ("no.csv", "no grid of heights")):
        with pytest.raises(rr.ParameterError, match=f"{name}.*{said}|{said}.*{name}"):
            rr.Graph.from_file(tmp_path / name)


def test_distances_from_a_graph_are_those_of_its_points():
    """Of grids by their splines at once, of formulas by the table once it is there."""
    formula = rr.Graph(GRAPH.height, GRAPH.gradient, GRAPH.hessian)
    grid = rr.Graph.from_grid(AXIS, AXIS, HILLS)
    points = np.random.default_rng(0).uniform(-1.2, 1.2, (50, 3))
    for ground in (grid, formula, BOULDER):
        each = [ground.distance(point) for point in points]
        np.testing.assert_allclose(ground.distances(points), each, atol=1e-12)
    formula.table()
    near = 0.8 * points
    each = [formula.distance(point) for point in near]
    np.testing.assert_allclose(formula.distances(near), each, atol=1e-11)
    assert np.ptp(each) > 0.5


@pytest.mark.parametrize("method", ["kkt", "momentum"])
def test_a_start_where_nothing_rolls_is_refused(method):
    grid = rr.Graph.from_grid(AXIS + 3, AXIS, HILLS)
    hollow = rr.Graph(
        lambda x, y: 5 * (x * x + y * y),
        lambda x, y: (10 * x, 10 * y),
        lambda x, y: ((10.0, 0.0), (0.0, 10.0)),
    )
    for ground, said in ((grid, "edge of the grid"), (hollow, "tighter than the shell")):
        with pytest.raises(rr.ModelError, match=f"cannot start at.*{said}"):
            rr.simulate(model(SP, ground), GAIT, 0.1, method=method)
    t = rr.simulate(model(SP, grid), GAIT, 0.1, method=method, position=(3.0, 0.0))
    assert t.time[-1] == 0.1
