"""What the equations say of every model before anything is computed: symmetry and similarity."""

from dataclasses import replace

import numpy as np
import pytest

import rrrobot as rr
from tests.some import some

SECONDS, INTERVAL, STEP = 1.5, 0.05, 0.01
MODELS = (rr.FullModel, rr.PivotingModel, rr.RollModel, rr.PitchModel, rr.YawModel)
METHODS = ("kkt", "momentum")
GAIT = rr.SinusoidalGait(
    offset=(0.9, 1.2), amplitude=(0.3, 0.35), angular_frequency=8.0, phase=(0.2, 1.9)
)
TABLE_2 = rr.RRRobotParameters()

every_model = pytest.mark.parametrize(
    "kind", some(MODELS, {"full", "pivoting", "pitch"}, lambda k: k.name)
)
every_method = pytest.mark.parametrize("method", METHODS)


def run(kind, gait=GAIT, *, method="kkt", parameters=TABLE_2, scale=1.0, **start):
    """A run of RRRobot with fixed steps, times multiplied by `scale`."""
    return rr.simulate(
        kind(rr.Robot.from_parameters(parameters)), gait, scale * SECONDS, scale * INTERVAL,
        step=scale * STEP, method=method, **start,
    )  # fmt: skip


def decoupled(gait=GAIT, *, parameters=TABLE_2, scale=1.0):
    robot = rr.Robot.from_parameters(parameters)
    return rr.decoupled(robot, gait, scale * SECONDS, scale * INTERVAL, step=scale * STEP)


@every_method
@every_model
def test_a_shifted_start_gives_the_shifted_path(kind, method):
    here, there = run(kind, method=method), run(kind, method=method, position=(3.0, -2.0))
    np.testing.assert_allclose(there.position - (3.0, -2.0), here.position, atol=1e-13)
    np.testing.assert_allclose(there.euler, here.euler, atol=1e-13)
    np.testing.assert_allclose(there.contact_force, here.contact_force, atol=1e-11)


@every_method
@pytest.mark.parametrize("kind", [rr.FullModel, rr.PivotingModel], ids=lambda k: k.name)
def test_a_turned_start_gives_the_turned_path(kind, method):
    turn = 2.2
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array(((c, -s), (s, c)))
    plain = run(kind, method=method, euler=(0.1, -0.2, 0.0))
    turned = run(kind, method=method, euler=(0.1, -0.2, turn))
    np.testing.assert_allclose(turned.position, plain.position @ rotation.T, atol=1e-11)
    np.testing.assert_allclose(turned.euler - (0, 0, turn), plain.euler, atol=1e-10)
    np.testing.assert_allclose(
        turned.contact_force[:, :2], plain.contact_force[:, :2] @ rotation.T, atol=1e-9
    )
    np.testing.assert_allclose(turned.leg_torque, plain.leg_torque, atol=1e-10)


def scaled(ratio):
    """RRRobot with lengths times `ratio`, the gait in time times its root, and the damping that
    then takes the same share: masses stay, so k, in kg m^2/s, grows as ratio^(3/2)."""
    p = TABLE_2
    larger = replace(
        p, shell_radius=ratio * p.shell_radius, leg_length=ratio * p.leg_length,
        hip_offset=ratio * p.hip_offset, damping=ratio**1.5 * p.damping,
    )  # fmt: skip
    slower = rr.SinusoidalGait(
        offset=GAIT.offset, amplitude=GAIT.amplitude, phase=GAIT.phase,
        angular_frequency=GAIT.angular_frequency / np.sqrt(ratio),
    )  # fmt: skip
    return slower, larger


def assert_scaled(large, small, ratio):
    np.testing.assert_allclose(large.time, np.sqrt(ratio) * small.time, rtol=1e-13)
    np.testing.assert_allclose(large.euler, small.euler, atol=1e-10)
    np.testing.assert_allclose(large.position, ratio * small.position, atol=1e-10 * ratio)
    np.testing.assert_allclose(large.contact_force, small.contact_force, atol=1e-8)
    np.testing.assert_allclose(large.leg_torque, ratio * small.leg_torque, atol=1e-9 * ratio)
    np.testing.assert_allclose(large.energy, ratio * small.energy, atol=1e-9 * ratio)


@every_method
@every_model
def test_larger_robots_move_alike_and_slower(kind, method):
    """Froude's similarity: lengths times c, times times the root of c."""
    ratio = 2.7
    gait, parameters = scaled(ratio)
    large = run(kind, gait, method=method, parameters=parameters, scale=np.sqrt(ratio))
    assert_scaled(large, run(kind, method=method), ratio)


@pytest.mark.slow
def test_larger_decoupled_models_move_alike_and_slower():
    ratio = 0.4
    gait, parameters = scaled(ratio)
    large = decoupled(gait, parameters=parameters, scale=np.sqrt(ratio))
    assert_scaled(large, decoupled(), ratio)


def test_heavier_robots_move_alike():
    """All masses, and with them the damping, times c: the same motion, forces times c."""
    p, c = TABLE_2, 3.1
    heavy = replace(
        p, leg_mass=c * p.leg_mass, servo_mass=c * p.servo_mass, damping=c * p.damping,
        battery_mass=c * p.battery_mass,
    )  # fmt: skip
    light, heavy_run = run(rr.FullModel), run(rr.FullModel, parameters=heavy)
    np.testing.assert_allclose(heavy_run.position, light.position, atol=1e-12)
    np.testing.assert_allclose(heavy_run.contact_force, c * light.contact_force, atol=1e-9)


def mirrored_left_right():
    """Legs change places; y, roll and yaw change sign."""
    gait = rr.SinusoidalGait(
        offset=GAIT.offset[::-1], amplitude=GAIT.amplitude[::-1], angular_frequency=8.0,
        phase=GAIT.phase[::-1],
    )  # fmt: skip
    return gait, np.array((-1, 1, -1)), np.array((1, -1)), slice(None, None, -1)


def mirrored_front_back():
    """phi -> pi - phi; x, pitch and yaw change sign."""
    gait = rr.SinusoidalGait(
        offset=np.pi - GAIT.offset, amplitude=-GAIT.amplitude, angular_frequency=8.0,
        phase=GAIT.phase,
    )  # fmt: skip
    return gait, np.array((1, -1, -1)), np.array((-1, 1)), slice(None)


@pytest.mark.parametrize("mirror", [mirrored_left_right, mirrored_front_back])
@pytest.mark.parametrize(
    "model", some([*MODELS, "decoupled"], {"full"}, lambda m: getattr(m, "name", m))
)
@every_method
def test_a_mirrored_gait_gives_the_mirrored_path(model, method, mirror):
    gait, angles, path, legs = mirror()
    if model == "decoupled":
        one, other = decoupled(), decoupled(gait)
    else:
        one, other = run(model, method=method), run(model, gait, method=method)
    np.testing.assert_allclose(other.euler, one.euler * angles, atol=1e-11)
    np.testing.assert_allclose(other.position, one.position * path, atol=1e-11)
    np.testing.assert_allclose(other.contact_force[:, :2], one.contact_force[:, :2] * path,
                               atol=1e-9)  # fmt: skip
    sign = -1 if mirror is mirrored_front_back else 1
    np.testing.assert_allclose(other.leg_torque, sign * one.leg_torque[:, legs], atol=1e-10)
    assert np.abs(one.position).max() > 1e-3 or model is rr.YawModel


@every_model
def test_models_come_back_from_plain_data(kind):
    model = kind(
        rr.Robot.from_parameters(),
        ground=rr.Plane(gravity=3.7),
        damping=rr.BodyRateDamping(0.02, 0.01, 0.03, legs=0.001),
    )
    again = rr.models.model_from_dict(model.to_dict(), model.robot)
    assert type(again) is kind and again.to_dict() == model.to_dict()
    assert again.gravity == model.gravity
    one, other = (rr.simulate(m, GAIT, 0.2) for m in (model, again))
    np.testing.assert_array_equal(one.state, other.state)
