"""The momentum engine against Pinocchio's mass matrix and the KKT models."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.momentum.batch import RESULT, Gaits, decoupled_setting, setting_of, steady_states
from rrrobot.momentum.coefficients import coefficients
from rrrobot.momentum.kernels import LANES, LIFT_OFF, VERTICAL
from tests.random_robot import random_robot

ODD = rr.RRRobotParameters(
    leg_mass=(0.05, 0.08), leg_length=(0.11, 0.07), hip_offset=0.09, shell_radius=0.13
)
MODELS = (rr.FullModel, rr.PivotingModel, rr.RollModel, rr.PitchModel, rr.YawModel)
COUNTS = {"cycles": 38, "counted": 18, "steps_per_cycle": 10}


def gaits(offset, phase):
    offset, phase = np.broadcast_arrays(np.asarray(offset, float), np.asarray(phase, float))
    offset, phase = offset.ravel(), phase.ravel()
    n = offset.size
    return Gaits(
        np.column_stack((offset, offset)),
        np.full((n, 2), 0.3),
        np.column_stack((0 * phase, phase)),
        np.full(n, 8.0),
    )


@pytest.mark.parametrize(
    "robot",
    [
        rr.Robot.from_parameters(),
        rr.Robot.from_parameters(ODD),
        random_robot(3, shell_center=(0,) * 3),
    ],
    ids=["Table 2", "odd", "random tree"],
)
def test_coefficients_are_crba(robot):
    rng = np.random.default_rng(0)
    angle, rate = rng.normal(size=(2, 20, robot.n_legs))
    found = coefficients(robot, angle, rate)
    model = rr.FullModel(robot)
    for k in range(20):
        mass = model.mass_matrix((0, 0, 0, 1, 0, 0), angle[k])
        b, relative = mass[:6, :6], mass[:6][:, model.legs.v] @ rate[k]
        i = b[3:, 3:]
        expected = np.concatenate(
            (
                (-b[2, 4], -b[0, 5], -b[1, 3]),
                (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]),
                relative,
            )
        )
        np.testing.assert_allclose(found[k], expected, atol=1e-13)


def test_coefficients_are_about_the_shells_centre():
    """Shifting the shell's centre shifts moments as Steiner's theorem says."""
    at, centre = random_robot(3, shell_center=(0, 0, 0)), np.array((0.02, -0.01, 0.03))
    shifted = random_robot(3, shell_center=centre)
    rng = np.random.default_rng(1)
    angle, rate = rng.normal(size=(2, 1, 12))
    a, b = coefficients(at, angle, rate)[0], coefficients(shifted, angle, rate)[0]
    np.testing.assert_allclose(b[:3], a[:3] - at.mass * centre, atol=1e-14)
    np.testing.assert_allclose(b[9:12], a[9:12], atol=1e-14)
    np.testing.assert_allclose(b[12:], a[12:] - np.cross(centre, a[9:12]), atol=1e-14)


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.name)
@pytest.mark.parametrize("parameters", [rr.RRRobotParameters(), ODD], ids=["Table 2", "odd"])
def test_simulate_by_momentum_equals_kkt(model, parameters):
    kind = model(rr.Robot.from_parameters(parameters))
    for gait in (rr.gait("circular"), rr.RampIn(rr.gait("lateral"), 2.0)):
        kkt = rr.simulate(kind, gait, 4.0, 0.02, step=0.01)
        fast = rr.simulate(kind, gait, 4.0, 0.02, method="momentum", step=0.02)
        np.testing.assert_allclose(fast.state, kkt.state, atol=1e-9)
        np.testing.assert_allclose(fast.euler, kkt.euler, atol=1e-9)
        np.testing.assert_allclose(fast.contact_force, kkt.contact_force, atol=1e-8)
        np.testing.assert_allclose(fast.leg_torque, kkt.leg_torque, atol=1e-9)


@pytest.mark.parametrize("seed", [8, 9])
@pytest.mark.parametrize("damping", [rr.BodyRateDamping(0.3, 0.3, 0.3), 0.3])
def test_random_trees_after_ten_seconds(seed, damping):
    """Revolute, prismatic and continuous joints, the shell off the base's origin."""
    robot = random_robot(seed)
    gait = rr.SinusoidalGait(
        offset=np.linspace(-0.5, 0.5, 12),
        amplitude=0.2,
        angular_frequency=6.0,
        phase=np.arange(12.0),
    )
    model = rr.FullModel(robot, damping=damping)
    kkt = rr.simulate(model, gait, 10.0, 10.0, step=0.01)
    fast = rr.simulate(model, gait, 10.0, 10.0, method="momentum", step=0.01)
    np.testing.assert_allclose(fast.state[-1], kkt.state[-1], atol=1e-9)


def test_given_starts_and_continuation():
    model = rr.FullModel(rr.Robot.from_parameters())
    options = {"euler": (0.1, -0.2, 0.3), "start": (0.5, 0.2, -1.0), "position": (0.3, 0.4)}
    kkt = rr.simulate(model, rr.gait("lateral"), 2.0, 0.05, step=0.01, **options)
    fast = rr.simulate(
        model, rr.gait("lateral"), 2.0, 0.05, method="momentum", step=0.01, **options
    )
    np.testing.assert_allclose(fast.state, kkt.state, atol=1e-10)


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.name)
def test_steady_states_are_those_of_the_trajectories(model):
    kind = model(rr.Robot.from_parameters())
    table = steady_states(setting_of(kind), gaits([np.pi / 2, np.pi / 4], np.pi / 2), **COUNTS)
    for row, name in zip(table, ("lateral", "circular"), strict=True):
        s = rr.simulate(kind, rr.gait(name), 30.0, 0.02, method="momentum").steady_state()
        found = dict(zip(RESULT, row, strict=True))
        assert found["speed"] == pytest.approx(s.speed, rel=1e-6, abs=1e-10)
        assert found["yaw_rate"] == pytest.approx(s.yaw_rate, rel=1e-6, abs=1e-9)
        assert (found["velocity_x"], found["velocity_y"]) == pytest.approx(
            tuple(s.velocity), rel=1e-5, abs=1e-9
        )
        for i, axis in enumerate(("roll", "pitch", "yaw")):
            assert found[f"{axis}_amplitude"] == pytest.approx(s.amplitude[i], abs=1e-7)
            assert found[f"{axis}_mean"] == pytest.approx(s.mean[i], abs=1e-6)
            if s.amplitude[i] > 1e-3:
                assert found[f"{axis}_phase"] == pytest.approx(s.phase[i], abs=1e-6)
        assert found["status"] == 0


def test_decoupled_lanes_are_the_decoupled_trajectory():
    robot = rr.Robot.from_parameters()
    for amplitude in (None, 0.35):
        other = None if amplitude is None else np.full((1, 2), amplitude)
        row = steady_states(
            decoupled_setting(robot), gaits(np.pi / 4, np.pi / 2), yaw_amplitude=other, **COUNTS
        )[0]
        yaw = None
        if amplitude is not None:
            yaw = rr.gait("circular", amplitude=amplitude)
        s = rr.decoupled(robot, rr.gait("circular"), 30.0, 0.02, yaw_gait=yaw).steady_state()
        assert row[0] == pytest.approx(s.speed, rel=1e-6)
        assert row[3] == pytest.approx(s.yaw_rate, rel=1e-6)
        np.testing.assert_allclose(row[4:7], s.amplitude, atol=1e-7)


def test_lanes_do_not_depend_on_each_other():
    setting = setting_of(rr.FullModel(rr.Robot.from_parameters()))
    many = gaits(np.linspace(0.5, 2.5, 2 * LANES + 3), 1.0)
    together = steady_states(setting, many, **COUNTS)
    for k in (0, LANES, 2 * LANES + 2):
        alone = Gaits(*(array[k : k + 1] for array in many))
        np.testing.assert_array_equal(steady_states(setting, alone, **COUNTS)[0], together[k])


def test_ten_steps_a_cycle_give_the_speed():
    setting = setting_of(rr.FullModel(rr.Robot.from_parameters()))
    plane = gaits(np.linspace(0.3, 2.8, 9)[:, None], np.linspace(0.4, 5.8, 7))
    rough = steady_states(setting, plane, **COUNTS)
    fine = steady_states(setting, plane, **(COUNTS | {"steps_per_cycle": 40}))
    moving = fine[:, 0] > 2e-4
    error = np.abs(rough[moving, 0] / fine[moving, 0] - 1)
    assert moving.sum() > 50 and error.max() < 1e-6


def test_the_plane_of_the_notes():
    """v peaks near 9.7 mm/s; alpha changes sign across offset pi/2 and phase difference pi."""
    setting = setting_of(rr.FullModel(rr.Robot.from_parameters()))
    offsets, phases = np.linspace(0, np.pi, 13), np.linspace(0, 2 * np.pi, 13)
    table = steady_states(setting, gaits(offsets[:, None], phases), **COUNTS)
    speed, alpha = (table[:, k].reshape(13, 13) for k in (0, 3))
    assert speed.max() == pytest.approx(0.0097, abs=1e-4)
    np.testing.assert_allclose(alpha, -alpha[::-1], atol=1e-7)
    np.testing.assert_allclose(alpha, -alpha[:, ::-1], atol=1e-7)
    assert alpha[3, 3] > 0.01


def test_a_lane_at_the_vertical_is_flagged_and_others_are_untouched():
    setting = setting_of(rr.FullModel(rr.Robot.from_parameters()))
    calm = gaits([1.0, 1.0, 1.0], 1.0)
    wild = Gaits(*(array.copy() for array in calm))
    wild.amplitude[1], wild.angular_frequency[1] = 2.5, 6.5
    rows = steady_states(setting, wild, **COUNTS)
    assert rows[1, -1] == VERTICAL and np.isnan(rows[1, 0])
    np.testing.assert_array_equal(rows[[0, 2]], steady_states(setting, calm, **COUNTS)[[0, 2]])


def test_normal_force_and_lift_off():
    model = rr.FullModel(rr.Robot.from_parameters())
    setting = setting_of(model)
    rows = steady_states(setting, gaits([np.pi / 2, np.pi / 4], np.pi / 2), **COUNTS)
    for row, name in zip(rows, ("lateral", "circular"), strict=True):
        t = rr.simulate(model, rr.gait(name), 30.0, method="momentum")
        settled = t.normal_force[t.time > 29.0].min()
        assert row[RESULT.index("normal_force")] == pytest.approx(settled, abs=2e-3)
    fast = gaits([0.5, 0.5], 0.3)
    fast.angular_frequency[0] = 40.0
    rows = steady_states(setting, fast, **(COUNTS | {"steps_per_cycle": 16}))
    assert rows[0, -1] == LIFT_OFF and np.isnan(rows[0, 0])
    assert rows[1, -1] == 0
    quick = rr.SinusoidalGait(offset=0.5, amplitude=0.3, angular_frequency=40.0, phase=(0.0, 0.3))
    t = rr.simulate(model, quick, 6.0, 0.002, method="momentum")
    assert t.normal_force[t.time > 5.5].min() < 0


def test_what_the_engine_cannot_do_is_told():
    robot = rr.Robot.from_parameters(ground_normal=(0.1, 0, 1))
    with pytest.raises(rr.ModelError, match="level ground"):
        rr.simulate(rr.FullModel(robot), rr.gait("lateral"), 1.0, method="momentum")
    torques = rr.LegTorques((0.0, 0.0), angle=(1.5, 1.5))
    level = rr.FullModel(rr.Robot.from_parameters())
    with pytest.raises(rr.GaitError, match="prescribed"):
        rr.simulate(level, torques, 1.0, method="momentum")
    with pytest.raises(rr.ParameterError, match="method"):
        rr.simulate(level, rr.gait("lateral"), 1.0, method="magic")


def test_pole_stop_and_interrupt_keep_what_was_computed():
    model = rr.FullModel(rr.Robot.from_parameters())
    with pytest.raises(rr.SimulationError, match="90 degrees") as stopped:
        rr.simulate(model, rr.gait("lateral"), 5.0, start=(0, 30.0, 0), method="momentum")
    assert 0 < len(stopped.value.trajectory) < 501

    def interrupt(time):
        if time > 6.0:
            raise KeyboardInterrupt

    with pytest.raises(rr.SimulationInterrupted) as halted:
        rr.simulate(model, rr.gait("lateral"), 60.0, method="momentum", progress=interrupt)
    assert 6.0 < halted.value.trajectory.time[-1] < 60.0
