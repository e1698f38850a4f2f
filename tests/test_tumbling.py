"""Bodies that turn over: what is reported of them is their path, or NaN with the reason."""

import math

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.rotations import rotation_from_quaternion, turns_over

RADIUS, SPIN = 0.1, 5.0


def inertial(mass, moment, place="0 0 0"):
    return (
        f'<inertial><origin xyz="{place}"/><mass value="{mass}"/><inertia ixx="{moment}" ixy="0" '
        f'ixz="0" iyy="{moment}" iyz="0" izz="{moment}"/></inertial>'
    )


@pytest.fixture(scope="module")
def ball():
    text = f'<robot name="ball"><link name="b">{inertial(1, 0.004)}</link></robot>'
    return rr.FullModel(rr.Robot.from_urdf(text, shell=rr.Sphere(RADIUS)), damping=None)


@pytest.mark.parametrize("start", [(0.15, 0, 0, 1), (1, 2, 3, 4), (-2, 1, 0.5, 0.1)])
@pytest.mark.parametrize("twist", [0.0, 0.4])
@pytest.mark.parametrize("method", ["kkt", "momentum"])
def test_a_ball_that_rolls_straight_on_from_any_attitude(ball, start, twist, method):
    """w = (0, 5, twist) stays: x = r 5 t, no curvature, and R after a time is exp([w] T)."""
    quaternion = np.array(start) / np.linalg.norm(start)
    world = np.array((0.0, SPIN, twist))
    body = rotation_from_quaternion(quaternion).T @ world
    state = rr.simulation.State.from_array(ball, np.r_[quaternion, 0, 0, body], time=0.0)
    t = rr.simulate(ball, rr.StillLegs(()), 6.0, state=state, method=method)
    period = 2.0
    s = t.steady_state(period=period, after=0.0)
    assert s.tumbles
    assert "turns over" in s.reason
    assert s.speed == pytest.approx(RADIUS * SPIN, rel=1e-8)
    assert abs(s.yaw_rate) < 1e-9
    assert abs(s.curvature) < 1e-9
    angle = np.linalg.norm(world) * period
    wrapped = angle - 2 * np.pi * np.round(angle / (2 * np.pi))
    np.testing.assert_allclose(s.net_rotation, wrapped * world / np.linalg.norm(world), atol=1e-6)
    for unknown in (s.velocity, s.amplitude, s.phase, s.mean):
        assert np.all(np.isnan(unknown))
    assert s.to_dict()["reason"] == s.reason


@pytest.fixture(scope="module")
def hanging():
    def make(side):
        text = (
            f'<robot name="p"><link name="shell">{inertial(5, 0.2)}</link><link name="p">'
            f'{inertial(22, 0.3, f"0 {side} -0.1")}</link><joint name="drive" type="continuous">'
            '<parent link="shell"/><child link="p"/><axis xyz="0 1 0"/></joint></robot>'
        )
        robot = rr.Robot.from_urdf(text, shell=rr.Sphere(0.305))
        return rr.FullModel(robot, damping=rr.BodyRateDamping(0.3, 0.3, 0.3))

    return make


def pendulum(time, rate=2.0, start=4.0):
    """Turns back at a rate after a soft start."""
    if time >= start:
        return [-rate * (time - start / 2)], [-rate], [0.0]
    x = time / start
    return (
        [-rate * start * (x**3 - x**4 / 2)],
        [-rate * (3 * x**2 - 2 * x**3)],
        [-rate / start * (6 * x - 6 * x**2)],
    )


@pytest.mark.parametrize("side", [pytest.param(0.01, marks=pytest.mark.slow), -0.03])
def test_a_ball_driven_by_a_pendulum_turns_as_its_path_does(hanging, side):
    """The further to the side, the less near the pitch comes to the vertical."""
    gait = rr.CallableGait(pendulum, n_legs=1)
    t = rr.simulate(hanging(side), gait, 40.0, 0.05, start="rest", method="momentum")
    late = t.time >= 20
    x, y = np.gradient(t.position[late], axis=0).T
    heading = np.polyfit(t.time[late], np.unwrap(np.arctan2(y, x)), 1)[0]
    assert heading == pytest.approx({0.01: 0.134, -0.03: -0.398}[side], abs=1e-3)
    s = t.steady_state(period=math.pi)
    assert s.tumbles
    assert s.yaw_rate == pytest.approx(heading, abs=2e-3)
    # The body comes back turned about the vertical by as much as the path.
    assert s.net_rotation[2] == pytest.approx(heading * math.pi, abs=0.02)
    two = t.steady_state(period=math.pi, after=40.0 - 2.99 * math.pi)
    assert two.cycles == 2
    if side == 0.01:
        assert two.yaw_rate == pytest.approx(heading, abs=0.02)


def test_sweeps_and_searches_name_what_turns_over(hanging):
    model = hanging(0.01)
    gaits = {"offset": 0.0, "amplitude": [0.05, 1.0], "angular_frequency": 2.0}
    ds = rr.sweep(model, **gaits, cycles=76)
    flags = dict(zip(ds.status.flag_values, ds.status.flag_meanings.split(), strict=True))
    assert [flags[int(code)] for code in ds.status] == ["steady_state", "turns_over"]
    assert np.isnan(ds.yaw_rate[1])
    assert np.isfinite(ds.yaw_rate[0])


def angles(roll, pitch):
    up = (-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch))
    return np.column_stack(np.broadcast_arrays(*up))


PHASE = 2 * np.pi * np.arange(24) / 24


@pytest.mark.parametrize(
    ("up", "turn", "over"),
    [
        (angles(1.4 * np.sin(PHASE), 0.0), 0.0, False),
        (angles(0.0, 1.5 * np.sin(PHASE)), 0.0, False),
        (angles(0.2 * np.sin(PHASE), 0.3), 7.0, False),
        (angles(PHASE, 0.0), 0.0, True),
        (angles(2 * PHASE, 0.3), 0.0, True),
        (angles(0.1, PHASE), 0.0, True),
        (angles(0.1, 1.8 * np.sin(PHASE)), 0.0, True),
        # A cone about y whose tilt makes the yaw count the turns.
        (np.column_stack((0.98 * np.sin(PHASE), 0.2 + 0 * PHASE, 0.98 * np.cos(PHASE))), 5.8, True),
    ],
)
def test_what_turns_over(up, turn, over):
    assert turns_over(up, turn) == over
    assert turns_over(up[::2], turn) == over
