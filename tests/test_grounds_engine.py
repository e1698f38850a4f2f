"""The momentum engine against the KKT form on every shell and ground, and against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rrrobot as rr
from rrrobot.drive.gaits import GaitBatch
from rrrobot.momentum.batch import LOADS, RESULT, steady_states
from rrrobot.momentum.kernels import ANY, GROUND_END, OK
from rrrobot.momentum.lowering import lower
from rrrobot.momentum.terrain import fineness, series_at, terrain_of
from rrrobot.simulation.heights import clearance
from tests.random_robot import random_robot
from tests.some import some
from tests.terrain import BOULDER, BOX, EGG, EL, GAIT, GRAPH, LEVEL, PAIRS, SLOPE, SP, START, model

CLOSE = {"rtol": 1e-12, "atol": 1e-13}
BOWL = rr.Boulder(-0.9)
EVERY = {
    **PAIRS,
    "sphere slope": (SP, SLOPE),
    "sphere graph": (SP, GRAPH),
    "box boulder": (BOX, BOULDER),
    "box graph": (BOX, GRAPH),
    "egg slope": (EGG, SLOPE),
    "egg boulder": (EGG, BOULDER),
    "sphere bowl": (SP, BOWL),
    "ellipsoid bowl": (EL, BOWL),
}


def both(full, gait, duration=10.0, step=0.01, **start):
    kkt = rr.simulate(full, gait, duration, 1.0, **({"rtol": 1e-12, "atol": 1e-13} | start))
    fast = rr.simulate(full, gait, duration, 1.0, method="momentum", step=step, **start)
    return kkt, fast


@pytest.mark.parametrize("name", some(EVERY, ("sphere bowl",)))
def test_engine_and_kkt_agree_to_1e_9_after_ten_seconds(name):
    kkt, fast = both(model(*EVERY[name]), GAIT, euler=START)
    np.testing.assert_allclose(fast.euler, kkt.euler, atol=1e-9)
    np.testing.assert_allclose(fast.position, kkt.position, atol=1e-9)
    np.testing.assert_allclose(fast.contact_force, kkt.contact_force, atol=3e-8)


@pytest.mark.filterwarnings("ignore::rrrobot.errors.GroundClearanceWarning")
@pytest.mark.parametrize(
    "ground", some((SLOPE, BOULDER, GRAPH), ("Boulder",), lambda g: type(g).__name__)
)
def test_random_tree_of_twelve_joints(ground):
    """A shell off the base's origin and turned against it, on a random tree of joints."""
    shell = rr.EllipsoidSum([(0.15, 0.17, 0.16), (0.16, 0.14, 0.15)])
    robot = random_robot(7, shell=shell, shell_rpy=(0.3, -0.2, 0.5))
    full = rr.FullModel(robot, ground=ground, damping=0.02)
    gait = rr.SinusoidalGait(
        offset=np.linspace(-0.5, 0.5, 12), amplitude=0.1, angular_frequency=6.0,
        phase=np.linspace(0, 5, 12),
    )  # fmt: skip
    kkt, fast = both(full, gait, 3.0, 0.005)
    np.testing.assert_allclose(fast.euler, kkt.euler, atol=1e-9)
    np.testing.assert_allclose(fast.position, kkt.position, atol=1e-9)
    assert kkt.slip.max() < 1e-11


def test_energy_is_kept_where_nothing_is_lost_or_driven():
    for shell, ground in ((EL, SLOPE), (BOX, BOULDER), (EGG, GRAPH), (EGG, LEVEL)):
        full = rr.FullModel(model(shell, ground).robot, ground=ground, damping=None)
        still = rr.StillLegs((1.2, 1.7))
        t = rr.simulate(
            full, still, 1.5, 0.05, euler=(0.2, -0.1, 0.3), start="rest", method="momentum",
            step=0.005,
        )  # fmt: skip
        assert np.ptp(t.energy) < 1e-11, (shell, ground)
        moved = np.ptp(t.euler, axis=0).max()
        assert moved > 0.05


def test_equal_axes_are_a_sphere_and_no_curvature_is_a_plane():
    euler = {"euler": START, "method": "momentum", "step": 0.02}
    sphere = rr.simulate(model(SP, LEVEL), GAIT, 3.0, 0.5, **euler)
    pairs = (
        (rr.Ellipsoid((0.12,) * 3), LEVEL),
        (rr.EllipsoidSum([(0.05,) * 3, (0.07,) * 3]), LEVEL),
        (SP, rr.Graph.from_grid(*(2 * (np.linspace(-1, 1, 21),)), np.zeros((21, 21)))),
    )
    for shell, ground in pairs:
        full = model(shell, ground)
        assert lower(full).axis == ANY
        for options in (euler, {"euler": START, "step": 0.02}):
            t = rr.simulate(full, GAIT, 3.0, 0.5, **options)
            np.testing.assert_allclose(t.euler, sphere.euler, atol=2e-12)
            np.testing.assert_allclose(t.position, sphere.position, atol=1e-12)


def test_a_slope_is_level_ground_with_tilted_gravity():
    """The same robot on a slope, and on level ground in a frame where gravity is tilted."""
    tilt = 0.06
    slope = rr.Plane(normal=(-np.sin(tilt), 0, np.cos(tilt)))
    full = rr.FullModel(model(EL, LEVEL).robot, ground=slope, damping=None)
    turned = rr.FullModel(model(EL, LEVEL).robot, damping=None)
    turn = slope.basis
    turned.model.gravity.linear = turn.T @ np.array((0, 0, -full.gravity))
    start = Rotation.from_euler("xyz", START)
    in_plane = (Rotation.from_matrix(turn.T) * start).as_euler("xyz")
    there = rr.simulate(turned, GAIT, 3.0, 0.5, euler=in_plane, step=0.01)
    for method in ("kkt", "momentum"):
        here = rr.simulate(full, GAIT, 3.0, 0.5, euler=START, step=0.01, method=method)
        np.testing.assert_allclose(here.position, there.position, atol=1e-12)
        np.testing.assert_allclose(
            here.contact_force, there.contact_force @ turn.T, rtol=1e-12, atol=1e-11
        )


def test_a_boulder_that_grows_becomes_a_plane():
    """The difference falls with the radius, by the same factor."""
    euler = {"euler": START, "method": "momentum", "step": 0.02}
    plane = rr.simulate(model(EL, LEVEL), GAIT, 2.0, 2.0, **euler).euler[-1]
    off = [
        np.abs(
            rr.simulate(model(EL, rr.Boulder(r)), GAIT, 2.0, 2.0, **euler).euler[-1] - plane
        ).max()
        for r in (1e4, 1e6)
    ]
    assert off[0] < 1e-4
    assert off[0] / off[1] == pytest.approx(100, rel=0.01)


@pytest.mark.slow
def test_series_of_a_support_function_is_exact():
    placement = (np.array((0.01, 0.02, -0.03)), Rotation.from_rotvec((0.3, -0.4, 1.0)).as_matrix())
    terrain = terrain_of(EGG, placement, LEVEL)
    u = np.array((0.3, -0.5, 0.8)) / np.sqrt(0.98)
    q = placement[1]
    gradient, hessian = series_at(terrain, u)
    np.testing.assert_allclose(gradient, q @ EGG.contact(q.T @ u), **CLOSE)
    np.testing.assert_allclose(hessian, q @ EGG.hessian(q.T @ u) @ q.T, rtol=1e-11, atol=1e-12)

    class Kinked(rr.Ellipsoid):
        """One's own class, far from a sphere."""

    with pytest.raises(rr.ModelError, match="polynomial of directions"):
        terrain_of(Kinked((0.3, 0.1, 0.02)), placement, LEVEL)


def test_steps_follow_the_sharpness():
    assert fineness(SP) == 1
    assert fineness(rr.Ellipsoid((0.12, 0.12, 0.12))) == 1
    assert fineness(EL) == 2
    assert fineness(rr.Ellipsoid((0.15, 0.11, 0.13))) == 3


def gaits(n, amplitude=0.3):
    phase = np.column_stack((np.zeros(n), np.linspace(0.3, 6.0, n)))
    return GaitBatch.sinusoidal(
        np.full((n, 2), 0.8), np.full((n, 2), amplitude), phase, np.full(n, 8.0)
    )


def phase_of(many, row):
    return many.gait(row).phase


@pytest.mark.parametrize("name", some("ADE", ()))
def test_steady_states_are_those_of_a_simulation(name):
    full = model(*PAIRS[name])
    many = gaits(3)
    found = steady_states(lower(full), many, cycles=38, counted=20, steps_per_cycle=20, loads=True)
    gait = rr.SinusoidalGait(
        offset=0.8, amplitude=0.3, angular_frequency=8.0, phase=phase_of(many, 1)
    )
    period = 2 * np.pi / 8
    t = rr.simulate(full, gait, 38 * period, period / 640, method="momentum", step=period / 80)
    steady = t.steady_state(after=18 * period)
    row = dict(zip((*RESULT, *LOADS), found[1], strict=True))
    assert row["status"] == OK
    assert row["speed"] == pytest.approx(steady.speed, rel=2e-5)
    assert row["yaw_rate"] == pytest.approx(steady.yaw_rate, abs=1e-6)
    last = t.time > 37 * period - 1e-9
    assert row["normal_force"] == pytest.approx(t.normal_force[last].min(), abs=2e-3)
    assert row["friction"] == pytest.approx(t.required_friction[last].max(), rel=2e-2)
    assert row["peak_torque"] == pytest.approx(np.abs(t.leg_torque[last]).max(), rel=1e-3)
    assert row["clearance"] == pytest.approx(clearance(t, last), abs=1e-5)


@pytest.mark.parametrize("ground", [SLOPE, BOULDER, GRAPH], ids=["slope", "boulder", "graph"])
def test_loads_where_the_motion_does_not_repeat(ground):
    """Forces of the last cycle on ground whose normal changes along the way."""
    full = model(SP if ground is BOULDER else EL, ground)
    many = gaits(2, amplitude=0.1)
    found = steady_states(lower(full), many, cycles=4, counted=3, steps_per_cycle=20, loads=True)
    period = 2 * np.pi / 8
    gait = rr.SinusoidalGait(
        offset=0.8, amplitude=0.1, angular_frequency=8.0, phase=phase_of(many, 0)
    )
    t = rr.simulate(full, gait, 4 * period, period / 40, method="momentum", step=period / 40)
    # The samples of the engine's own last cycle, from its start to its last step.
    last = slice(-41, -2)
    row = dict(zip((*RESULT, *LOADS), found[0], strict=True))
    assert row["status"] == OK
    assert row["normal_force"] == pytest.approx(t.normal_force[last].min(), abs=5e-3)
    assert row["friction"] == pytest.approx(t.required_friction[last].max(), rel=2e-2)
    assert row["peak_torque"] == pytest.approx(np.abs(t.leg_torque[last]).max(), rel=2e-2)


def test_a_lane_that_rolls_off_its_boulder_stops():
    robot = model(SP, LEVEL).robot
    damping = rr.BodyRateDamping(0.01, 0.01, 0.01)
    unstable = rr.FullModel(robot, ground=rr.Boulder(0.13), damping=damping)
    found = steady_states(lower(unstable), gaits(2), cycles=38, counted=20, steps_per_cycle=10)
    assert np.all(found[:, RESULT.index("status")] == GROUND_END)
    with pytest.raises(rr.SimulationError, match="equator") as stopped:
        rr.simulate(unstable, GAIT, 30.0, method="momentum")
    assert stopped.value.time > 0
    with pytest.raises(rr.SimulationError, match="equator"):
        rr.simulate(unstable, GAIT, 30.0)


def test_flat_belly_on_a_boulder():
    """The dual contact, engine against KKT, energy, and the belly's edge."""
    robot = replace(
        rr.Robot.from_parameters(), shell=rr.FlatBelly(), shell_center=np.array((0, 0, -0.1))
    )
    full = rr.FullModel(robot, ground=rr.Boulder(0.6), damping=0.01)
    gait = rr.SinusoidalGait(
        offset=np.pi / 2, amplitude=0.1, angular_frequency=8.0, phase=(0.0, np.pi / 2)
    )
    kkt, fast = both(full, gait, 5.0)
    np.testing.assert_allclose(fast.state[:, :6], kkt.state[:, :6], atol=1e-9)
    np.testing.assert_allclose(fast.position, kkt.position, atol=1e-9)
    assert kkt.slip.max() < 1e-12
    assert np.abs(kkt.height_error).max() < 1e-12
    free = rr.FullModel(robot, ground=rr.Boulder(0.6), damping=None)
    t = rr.simulate(
        free, rr.StillLegs((1.5, 1.6)), 2.0, 0.05, euler=(0.02, 0.01, 0.3), start="rest",
        method="momentum", step=0.01,
    )  # fmt: skip
    assert np.ptp(t.energy) < 1e-11
    assert np.ptp(t.euler[:, 0]) > 3e-3
    edge = replace(robot, shell=rr.FlatBelly(0.002, 0.002))
    with pytest.raises(rr.SimulationError, match="edge of the flat belly"):
        rr.simulate(rr.FullModel(edge, ground=rr.Boulder(0.6)), gait, 5.0)
    with pytest.raises(rr.ShellError, match="rolls on a Boulder"):
        rr.FullModel(robot)
