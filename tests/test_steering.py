"""Plans: arcs that meet, exact motions that arrive, and what stands in the way."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.drive.tables import gait_table
from rrrobot.steering import Disc, Gear, Polygon
from rrrobot.steering.arcs import joined, move, path
from rrrobot.steering.motions import corners, motions_of
from rrrobot.steering.obstacles import free_distance
from rrrobot.steering.planner import _apart
from tests import derivations
from tests.some import some

PLACE, TURN = 1e-3, np.deg2rad(0.2)


@pytest.fixture(scope="module")
def model(home):
    return rr.FullModel(rr.Robot.from_parameters())


@pytest.fixture(scope="module")
def motions(model):
    return motions_of(model)


def expm(twist, time):
    """A screw's displacement as the exponential of its matrix."""
    from scipy.linalg import expm

    u, v, w = twist
    g = expm(time * np.array(((0, -w, u), (w, 0, v), (0, 0, 0))))
    return g[0, 2], g[1, 2], np.arctan2(g[1, 0], g[0, 0])


@pytest.mark.parametrize("twist", [(0.02, -0.01, 0.3), (0.01, 0.02, 0.0), (0.01, 0, 1e-9)])
def test_moving_along_a_screw(twist):
    x, y, turn = expm(twist, 4.0)
    pose = np.array((0.3, -0.1, 0.7))
    c, s = np.cos(0.7), np.sin(0.7)
    wanted = (0.3 + c * x - s * y, -0.1 + s * x + c * y, 0.7 + turn)
    np.testing.assert_allclose(move(pose, np.array(twist), np.array(4.0)), wanted, atol=1e-14)


@pytest.mark.slow
def test_motions_are_those_of_simulations(model, motions):
    rng = np.random.default_rng(0)
    for row in rng.choice(len(motions.offset), 2, replace=False):
        gait = rr.SinusoidalGait(
            offset=motions.offset[row], amplitude=motions.amplitude[row], angular_frequency=8.0,
            phase=(0.0, motions.phase_difference[row]),
        )  # fmt: skip
        s = rr.simulate(model, gait, 38 * gait.period, method="momentum").steady_state()
        assert np.linalg.norm(motions.twist[row, :2]) == pytest.approx(s.speed, abs=2e-6)
        assert motions.twist[row, 2] == pytest.approx(s.yaw_rate, abs=2e-5)


def test_corners_span_the_reachable_set(motions):
    """In every direction of travel and turn the corners lose little against all gaits."""
    few = corners(motions, most=12)
    assert len(few.offset) <= 12
    scale = np.abs(motions.twist).max(axis=0)
    rng = np.random.default_rng(1)
    for direction in rng.normal(size=(200, 3)):
        every, some = (((m.twist / scale) @ direction).max() for m in (motions, few))
        assert some > 0.8 * every


def test_arcs_meet_the_goal(motions):
    twists = corners(motions, most=8).twist
    goal = np.array((0.3, -0.2, 2.5))
    found = joined(twists, np.zeros(3), goal, least=1.0, most=200.0)
    assert len(found.time) > 20 and np.all(np.diff(found.time.sum(axis=1)) >= 0)
    for choice, time in zip(found.choice[:20], found.time[:20], strict=True):
        pose = np.zeros(3)
        for k, t in zip(choice, time, strict=True):
            pose = move(pose, twists[k], t)
        away = pose - goal
        away[2] = (away[2] + np.pi) % (2 * np.pi) - np.pi
        np.testing.assert_allclose(away, 0, atol=1e-4)
        np.testing.assert_allclose(path(twists[choice], np.zeros(3), time)[-1], pose, atol=1e-12)


GOALS = [[0.2, 0.1, np.pi / 2], [0.05, -0.02, 3.0], [-0.3, 0.25, -2.0], [0.0, 0.4, 0.0]]


@pytest.mark.parametrize("goal", some(GOALS, by_default={"0.2"}, name=lambda g: f"{g[0]:g}"))
def test_a_plan_arrives_on_the_exact_model(model, goal):
    p = rr.plan(model, goal)
    assert p.lower_bound < p.gait.duration < 4 * p.lower_bound + 25
    t = p.execute()  # by the KKT form
    np.testing.assert_allclose(t.position[-1], p.predicted[:2], atol=1e-8)
    assert np.hypot(*(t.position[-1] - goal[:2])) < PLACE
    turn = (t.euler[-1, 2] - goal[2] + np.pi) % (2 * np.pi) - np.pi
    assert abs(turn) < TURN
    # It rests there.
    assert np.abs(t.euler_rates[-1]).max() < 1e-4 and not t.leg_rate[-1].any()
    assert t.slip.max() < 1e-12


@pytest.mark.slow
def test_the_exported_table_leads_there_by_an_independent_derivation(model, tmp_path):
    """Five point masses by Kane's method, their legs splined through the table's rows."""
    from scipy.integrate import solve_ivp
    from scipy.interpolate import CubicSpline

    goal = (0.12, -0.08, 0.9)
    p = rr.plan(model, goal)
    table = gait_table(p.gait, 50.0, duration=p.gait.duration, joints=model.robot.legs)
    rows = np.genfromtxt(table.to_csv(tmp_path / "legs.csv"), delimiter=",", names=True)
    columns = rows.view(float).reshape(len(rows), -1)
    time, angle = columns[:, 0], columns[:, 1:3]
    spline = CubicSpline(time, angle, bc_type="clamped")
    parts = [spline, spline.derivative(), spline.derivative(2)]
    points = derivations.PointMassRobot()

    def rate(t, state):
        legs = [part(min(t, time[-1])) * (1.0 if i == 0 or t < time[-1] else 0.0)
                for i, part in enumerate(parts)]  # fmt: skip
        theta, dot = state[:3], state[3:6]
        ddot = derivations.full_model(points, theta, dot, *legs, damping=(0.01,) * 3).theta_ddot
        return np.concatenate((dot, ddot, derivations._contact_velocity(points, theta, dot)))

    run = solve_ivp(rate, (0, p.duration), np.zeros(8), rtol=1e-8, atol=1e-10, max_step=0.1)
    end = run.y[:, -1]
    assert np.hypot(*(end[6:] - goal[:2])) < 1e-3
    assert abs(end[2] - goal[2]) < np.deg2rad(0.2)
    # That the table was driven: no motion at all would end 14 cm away.
    np.testing.assert_allclose(end[6:], p.predicted[:2], atol=2e-4)


@pytest.mark.slow
def test_a_plan_keeps_limits(model):
    goal = (0.2, 0.1, np.pi / 2)
    asked = rr.plan(model, goal).demands()
    t = rr.plan(model, goal).execute(sample_interval=np.pi / 120)
    assert asked.torque == pytest.approx(np.abs(t.leg_torque).max(), rel=0.02)
    power = np.abs(t.leg_torque * t.leg_rate).sum(axis=1)
    assert asked.work == pytest.approx(np.trapezoid(power, t.time), rel=1e-6)
    along = t.contact_force[:, 2]
    friction = np.linalg.norm(t.contact_force[:, :2], axis=1) / along
    assert asked.friction == pytest.approx(friction.max(), rel=0.02)
    assert asked.normal_force == pytest.approx(along.min() / (model.robot.mass * 9.81), rel=0.02)
    rr.plan(model, goal, limits=rr.GaitLimits(max_torque=1.1 * asked.torque, friction=0.5))
    with pytest.raises(rr.ParameterError, match="on is 'half'"):
        rr.plan(model, goal, on="half")


@pytest.mark.slow
def test_plans_on_the_decoupled_models(model):
    """Exact on those models, by a simulation of its own; centimetres off in truth."""
    maps = motions_of(model, decoupled=True)
    rng = np.random.default_rng(0)
    for row in rng.choice(len(maps.offset), 2, replace=False):
        gait, own = (
            rr.SinusoidalGait(
                offset=maps.offset[row], amplitude=swing, angular_frequency=8.0,
                phase=(0.0, maps.phase_difference[row]),
            )
            for swing in (maps.amplitude[row], maps.yaw_amplitude[row])
        )  # fmt: skip
        s = rr.decoupled(model.robot, gait, 38 * gait.period, yaw_gait=own).steady_state()
        assert np.linalg.norm(maps.twist[row, :2]) == pytest.approx(s.speed, abs=1e-5)
        assert maps.twist[row, 2] == pytest.approx(s.yaw_rate, abs=1e-4)
    goal = (0.2, 0.1, np.pi / 2)
    p = rr.plan(model, goal, on="decoupled")
    own = _apart(model, maps).of_yaw(p.gait)
    apart = rr.decoupled(model.robot, p.gait, p.duration, 0.1, yaw_gait=own, start="rest")
    np.testing.assert_allclose(apart.position[-1], p.predicted[:2], atol=1e-5)
    np.testing.assert_allclose(apart.position[-1], goal[:2], atol=PLACE)
    t = p.execute(sample_interval=0.1)
    assert 2e-3 < np.hypot(*(t.position[-1] - goal[:2])) < 0.1
    for name in ("left", "right"):
        gear = Gear(maps, name)
        drive = gear.drive(0.7 * gear.fastest(3.0), 3.0)
        assert drive.speed == pytest.approx(0.7 * gear.fastest(3.0), rel=1e-9)
        assert drive.twist[2] / drive.speed == pytest.approx(3.0, rel=1e-9)


@pytest.mark.slow
def test_plans_of_little_effort(model):
    goal = (0.12, 0.1, 1.0)
    quick, thrifty = (rr.plan(model, goal, minimise=how) for how in ("time", "effort"))
    assert thrifty.demands().work < 0.95 * quick.demands().work
    assert np.hypot(*thrifty.error[:2]) < PLACE
    with pytest.raises(rr.ParameterError, match="minimise is 'speed'"):
        rr.plan(model, goal, minimise="speed")


@pytest.mark.slow
def test_a_start_elsewhere_is_the_same_plan_moved(model):
    here = rr.plan(model, (0.2, 0.1, 0.5))
    turn, place = 0.8, np.array((1.0, -2.0))
    c, s = np.cos(turn), np.sin(turn)
    goal = (*(place + np.array(((c, -s), (s, c))) @ (0.2, 0.1)), 0.5 + turn)
    there = rr.plan(model, goal, start=(*place, turn))
    assert there.gait.duration == pytest.approx(here.gait.duration, abs=1e-9)
    time = np.linspace(0, here.gait.duration, 100)
    np.testing.assert_allclose(there.gait(time).angle, here.gait(time).angle, atol=1e-4)


@pytest.mark.slow
def test_obstacles_are_passed_at_their_margin(model):
    wall = Polygon([(-0.3, 0.2), (0.15, 0.2), (0.15, 0.25), (-0.3, 0.25)])
    obstacles = (Disc((0.3, 0.1), 0.03), wall)
    p = rr.plan(model, (-0.05, 0.5, 0.0), obstacles=obstacles, margin=0.08)
    direct = rr.plan(model, (-0.05, 0.5, 0.0))
    assert free_distance(obstacles, direct.path[:, :2]).min() < 0.08
    t = p.execute(method="momentum", sample_interval=np.pi / 32)
    means = np.column_stack([np.convolve(c, np.full(8, 1 / 8), "valid") for c in t.position.T])
    assert free_distance(obstacles, means).min() >= 0.08
    assert np.hypot(*p.error[:2]) < PLACE and abs(p.error[2]) < TURN


def test_distances_of_polygons():
    """Against points sampled densely on the edges, and an even-odd test by angles."""
    rng = np.random.default_rng(2)
    corners_ = np.array([(0, 0), (2, 0), (2, 2), (1, 0.5), (0, 2)], dtype=float)
    shape = Polygon(corners_)
    share = np.linspace(0, 1, 2001)[:, None]
    edges = np.vstack(
        [a + share * (b - a) for a, b in zip(corners_, np.roll(corners_, -1, axis=0), strict=True)]
    )
    for point in rng.uniform(-1, 3, (100, 2)):
        away = np.linalg.norm(edges - point, axis=1).min()
        angles = np.unwrap(np.arctan2(*(edges - point).T[::-1]))
        inside = abs(angles[-1] - angles[0]) > np.pi
        found = shape.distance(point[None])[0]
        assert found == pytest.approx(-away if inside else away, abs=1e-3)


def test_what_is_refused(model):
    with pytest.raises(rr.ParameterError, match="the start"):
        rr.plan(model, (0.3, 0.0, 0.0), obstacles=[Disc((0.0, 0.0), 0.05)])
    with pytest.raises(rr.ModelError, match="rolls"):
        rr.plan(rr.PivotingModel(model.robot), (0.1, 0, 0))
    with pytest.raises(rr.ModelError, match="does not fade"):
        rr.plan(rr.FullModel(model.robot, damping=None), (0.1, 0, 0))
    with pytest.raises(rr.ParameterError, match="goal"):
        rr.plan(model, (0.1, np.nan, 0))


def test_a_plan_comes_back_from_its_file(model, tmp_path):
    wall = Polygon([(0.3, -0.1), (0.4, -0.1), (0.4, 0.3)])
    p = rr.plan(model, (0.05, -0.1, 0.3), obstacles=[Disc((-0.4, 0.0), 0.1), wall], margin=0.05)
    again = rr.Plan.load(p.save(tmp_path / "p.json"))
    assert again.to_dict() == p.to_dict()
    np.testing.assert_array_equal(again.path, p.path)
    one, two = (x.execute(method="momentum", sample_interval=1.0) for x in (p, again))
    np.testing.assert_array_equal(one.position, two.position)
    # Every command takes it as a gait.
    gait = rr.read_gait(tmp_path / "p.json")
    np.testing.assert_array_equal(gait(np.arange(9.0)).angle, p.gait(np.arange(9.0)).angle)
    (tmp_path / "bad.json").write_text('{"format": "rrrobot plan 1"}')
    with pytest.raises(rr.OutputError, match="not a plan"):
        rr.Plan.load(tmp_path / "bad.json")
    with pytest.raises(rr.OutputError, match=r"\.json"):
        p.save(tmp_path / "p.txt")


def test_a_plans_picture(model):
    wall = Polygon([(0.3, -0.1), (0.4, -0.1), (0.4, 0.3)])
    p = rr.plan(model, (0.05, -0.1, 0.3), obstacles=[wall], margin=0.05)
    ax = p.plot()
    lines = {drawn.get_label(): drawn.get_xydata() for drawn in ax.get_lines()}
    np.testing.assert_array_equal(lines["coarse plan"], p.path[:, :2])
    np.testing.assert_allclose(lines["contact point"][-1], p.goal[:2], atol=PLACE)
    np.testing.assert_allclose(lines["goal"], p.goal[None, :2])
    np.testing.assert_allclose(lines["mean of a cycle"][-1], p.goal[:2], atol=PLACE)


def test_the_plan_command(home, tmp_path):
    import json

    from click.testing import CliRunner

    from rrrobot.cli.main import cli

    files = [tmp_path / name for name in ("p.json", "p.csv", "p.png", "p.html")]
    args = ["plan", "--goal", "-0.05,0.1,pi/8", "--disc", "0.4,0,0.1", "--margin", "0.05",
            "--polygon", "0.3,0.3 0.4,0.3 0.4,0.5", "--quiet"]  # fmt: skip
    for flag, target in zip(("--save", "--csv", "--plot", "--html"), files, strict=True):
        args += [flag, str(target)]
    result = CliRunner().invoke(cli, args)
    assert result.exit_code == 0, result.output
    assert "legs move" in result.output and all(file.stat().st_size > 500 for file in files)
    again = rr.Plan.load(files[0])
    assert [type(o).__name__ for o in again.obstacles] == ["Disc", "Polygon"]
    shown = CliRunner().invoke(cli, [*args[:7], "--quiet", "--json"])
    data = json.loads(shown.stdout)
    assert np.hypot(*data["error"][:2]) < PLACE and data["goal"][2] == pytest.approx(np.pi / 8)
    degrees = CliRunner().invoke(cli, ["plan", "--goal", "0.3,0.2,45"])
    assert degrees.exit_code == 1 and "yaw of --goal is 45 rad" in degrees.output
    for bad in (["--goal", "1,2"], ["--goal", "0,0,0", "--polygon", "1,2 3,4"], []):
        assert CliRunner().invoke(cli, ["plan", *bad]).exit_code == 2
