"""The momentum engine against Pinocchio's mass matrix and the KKT models."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.drive.gaits import GaitBatch
from rrrobot.momentum.batch import (
    LOADS,
    RESULT,
    decoupled_setting,
    lower,
    ready,
    settled,
    steady_states,
)
from rrrobot.momentum.coefficients import coefficients
from rrrobot.momentum.compiled import in_cache
from rrrobot.momentum.extremes import extremes
from rrrobot.momentum.kernels import LANES, LIFT_OFF, OK, VERTICAL
from rrrobot.momentum.lowering import VERTICAL as SINE_LIMIT
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
    return GaitBatch.sinusoidal(
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
@pytest.mark.parametrize(
    "parameters", [rr.RRRobotParameters(), pytest.param(ODD, marks=pytest.mark.slow)],
    ids=["Table 2", "odd"],
)  # fmt: skip
def test_simulate_by_momentum_equals_kkt(model, parameters):
    kind = model(rr.Robot.from_parameters(parameters))
    for gait in (rr.gait("circular"), rr.RampIn(rr.gait("lateral"), 1.0)):
        kkt = rr.simulate(kind, gait, 2.0, 0.02, step=0.01)
        fast = rr.simulate(kind, gait, 2.0, 0.02, method="momentum", step=0.02)
        np.testing.assert_allclose(fast.state, kkt.state, atol=1e-9)
        np.testing.assert_allclose(fast.euler, kkt.euler, atol=1e-9)
        np.testing.assert_allclose(fast.contact_force, kkt.contact_force, atol=1e-8)
        np.testing.assert_allclose(fast.leg_torque, kkt.leg_torque, atol=1e-9)


@pytest.mark.filterwarnings("ignore::rrrobot.errors.GroundClearanceWarning")
@pytest.mark.parametrize("seed", [8, pytest.param(9, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "damping", [rr.BodyRateDamping(0.3, 0.3, 0.3), pytest.param(0.3, marks=pytest.mark.slow)]
)
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
    table = steady_states(lower(kind), gaits([np.pi / 2, np.pi / 4], np.pi / 2), **COUNTS)
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


@pytest.mark.slow
def test_decoupled_lanes_are_the_decoupled_trajectory():
    robot = rr.Robot.from_parameters()
    for amplitude in (None, 0.35):
        yaw = None if amplitude is None else rr.gait("circular", amplitude=amplitude)
        other = None if yaw is None else GaitBatch.of([yaw])
        row = steady_states(
            decoupled_setting(robot), gaits(np.pi / 4, np.pi / 2), yaw=other, **COUNTS
        )[0]
        s = rr.decoupled(robot, rr.gait("circular"), 30.0, 0.02, yaw_gait=yaw).steady_state()
        assert row[0] == pytest.approx(s.speed, rel=1e-6)
        assert row[3] == pytest.approx(s.yaw_rate, rel=1e-6)
        np.testing.assert_allclose(row[4:7], s.amplitude, atol=1e-7)


def test_lanes_do_not_depend_on_each_other():
    setting = lower(rr.FullModel(rr.Robot.from_parameters()))
    many = gaits(np.linspace(0.5, 2.5, 2 * LANES + 3), 1.0)
    together = steady_states(setting, many, **COUNTS)
    for k in (0, LANES, 2 * LANES + 2):
        alone = many.rows([k])
        np.testing.assert_array_equal(steady_states(setting, alone, **COUNTS)[0], together[k])


def test_ten_steps_a_cycle_give_the_speed():
    setting = lower(rr.FullModel(rr.Robot.from_parameters()))
    plane = gaits(np.linspace(0.3, 2.8, 9)[:, None], np.linspace(0.4, 5.8, 7))
    rough = steady_states(setting, plane, **COUNTS)
    fine = steady_states(setting, plane, **(COUNTS | {"steps_per_cycle": 40}))
    moving = fine[:, 0] > 2e-4
    error = np.abs(rough[moving, 0] / fine[moving, 0] - 1)
    assert moving.sum() > 50 and error.max() < 1e-6


def test_the_plane_of_the_notes():
    """v peaks near 9.7 mm/s; alpha changes sign across offset pi/2 and phase difference pi."""
    setting = lower(rr.FullModel(rr.Robot.from_parameters()))
    offsets, phases = np.linspace(0, np.pi, 13), np.linspace(0, 2 * np.pi, 13)
    table = steady_states(setting, gaits(offsets[:, None], phases), **COUNTS)
    speed, alpha = (table[:, k].reshape(13, 13) for k in (0, 3))
    assert speed.max() == pytest.approx(0.0097, abs=1e-4)
    np.testing.assert_allclose(alpha, -alpha[::-1], atol=1e-7)
    np.testing.assert_allclose(alpha, -alpha[:, ::-1], atol=1e-7)
    assert alpha[3, 3] > 0.01


def test_a_lane_at_the_vertical_is_flagged_and_others_are_untouched():
    setting = lower(rr.FullModel(rr.Robot.from_parameters()))
    calm = gaits([1.0, 1.0, 1.0], 1.0)
    wild = GaitBatch(*(array.copy() for array in calm))
    wild.sine[1] *= 2.5 / 0.3
    wild.cosine[1] *= 2.5 / 0.3
    wild.angular_frequency[1] = 6.5
    rows = steady_states(setting, wild, **COUNTS)
    assert rows[1, -1] == VERTICAL and np.isnan(rows[1, 0])
    np.testing.assert_array_equal(rows[[0, 2]], steady_states(setting, calm, **COUNTS)[[0, 2]])


def test_normal_force_and_lift_off():
    model = rr.FullModel(rr.Robot.from_parameters())
    setting = lower(model)
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


# Torques, power and friction


def loads_of_a_trajectory(model, gait, cycles):
    """By the KKT system, over the last cycle: extremes by parabolas through dense samples."""
    n = 2000
    step = gait.period / 80
    t = rr.simulate(model, gait, cycles * gait.period, gait.period / 20, step=step)
    start = t.state_at(-21)
    last = rr.simulate(model, gait, gait.period, gait.period / n, state=start, step=step)
    torque, rate = last.leg_torque[:-1], last.leg_rate[:-1]
    found = {
        "rms_torque": np.sqrt((torque**2).sum(axis=1).mean()),
        "peak_torque": max(top(np.abs(column)) for column in torque.T),
        "power": np.abs(torque * rate).sum(axis=1).mean(),
    }
    found["friction"] = top(last.required_friction[:-1]) if last.has_contact else np.nan
    return found


def top(values):
    k = int(values.argmax())
    left, here, right = values[k - 1], values[k], values[(k + 1) % values.size]
    return here + 0.125 * (left - right) ** 2 / (2 * here - left - right)


def engine_loads(model, gait, cycles, steps):
    some = GaitBatch.of([gait])
    row = steady_states(
        lower(model), some, cycles=cycles, counted=2, steps_per_cycle=steps, loads=True
    )[0]
    return dict(zip((*RESULT, *LOADS), row, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.name)
@pytest.mark.parametrize("parameters", [rr.RRRobotParameters(), ODD], ids=["Table 2", "odd"])
def test_loads_are_those_of_the_kkt_trajectory(model, parameters):
    kind = model(rr.Robot.from_parameters(parameters))
    gait = rr.SinusoidalGait(
        offset=(0.9, 1.4), amplitude=(0.3, 0.25), angular_frequency=8.0, phase=(0.4, 1.9)
    )
    expected = loads_of_a_trajectory(kind, gait, 30)
    for steps, error in ((20, 2e-6), (10, 1e-3)):
        found = engine_loads(kind, gait, 30, steps)
        for name, value in expected.items():
            # |torque x rate| has corners, at which either mean is less exact.
            rel = max(error, 5e-6) if name == "power" else error
            assert found[name] == pytest.approx(value, rel=rel, nan_ok=True), (name, steps)


@pytest.mark.parametrize(
    "damping",
    [rr.BodyRateDamping(0.3, 0.3, 0.3, legs=0.02), pytest.param(0.3, marks=pytest.mark.slow)],
)
@pytest.mark.parametrize("seed", [3, pytest.param(5, marks=pytest.mark.slow)])
def test_loads_of_random_trees(seed, damping):
    """Revolute, prismatic and continuous joints, damped joints, the shell off the origin."""
    robot = random_robot(seed, 6)
    gait = rr.SinusoidalGait(
        offset=np.linspace(-0.2, 0.2, 6),
        amplitude=0.05,
        angular_frequency=5.0,
        phase=np.arange(6.0),
    )
    model = rr.FullModel(robot, damping=damping)
    expected = loads_of_a_trajectory(model, gait, 12)
    found = engine_loads(model, gait, 12, 24)
    for name, value in expected.items():
        # A motor of an inner joint has many harmonics.
        assert found[name] == pytest.approx(value, rel=2e-5), name


def test_loads_of_decoupled_and_of_stopped_lanes_are_none():
    decoupled = decoupled_setting(rr.Robot.from_parameters())
    calm = gaits([1.0, 1.0], 1.0)
    rows = steady_states(decoupled, calm, loads=True, **COUNTS)
    assert rows.shape[1] == len(RESULT) + len(LOADS)
    assert np.isnan(rows[:, len(RESULT) :]).all() and np.isfinite(rows[:, 0]).all()
    calm.sine[1] *= 2.5 / 0.3
    calm.cosine[1] *= 2.5 / 0.3
    calm.angular_frequency[1] = 6.5
    setting = lower(rr.FullModel(rr.Robot.from_parameters()))
    rows = steady_states(setting, calm, loads=True, **COUNTS)
    assert np.isfinite(rows[0]).all() and np.isnan(rows[1, len(RESULT) :]).all()
    np.testing.assert_array_equal(rows[:, : len(RESULT)], steady_states(setting, calm, **COUNTS))


def test_loads_do_not_depend_on_other_lanes():
    setting = lower(rr.FullModel(rr.Robot.from_parameters()))
    many = gaits(np.linspace(0.5, 2.5, LANES + 3), 1.0)
    together = steady_states(setting, many, loads=True, **COUNTS)
    for k in (0, LANES, LANES + 2):
        alone = many.rows([k])
        np.testing.assert_array_equal(
            steady_states(setting, alone, loads=True, **COUNTS)[0], together[k]
        )


def test_lanes_of_unlike_length_do_not_depend_on_each_other():
    setting = lower(rr.FullModel(rr.Robot.from_parameters()))
    rng = np.random.default_rng(4)
    n = LANES + 5
    some = GaitBatch(
        rng.uniform(0, np.pi, (n, 2)), np.zeros((n, 2)), rng.normal(size=(n, 3, 2)) * 0.1,
        rng.normal(size=(n, 3, 2)) * 0.1, rng.uniform(4, 10, n),
    )  # fmt: skip
    cycles = rng.integers(3, 30, n)
    options = {"counted": 3, "steps": 24}
    together = settled(setting, some, cycles=cycles, **options)
    peaks = np.empty((n, 2))
    found = extremes(setting, some, together.motion, peaks)
    np.testing.assert_array_equal(peaks.max(axis=1), found[:, 3])
    for k in (0, 7, n - 1):
        one = some.rows([k])
        alone = settled(setting, one, cycles=cycles[k : k + 1], **options)
        for a, b in zip(alone, together, strict=True):
            np.testing.assert_array_equal(a[0], b[k])
        np.testing.assert_array_equal(extremes(setting, one, alone.motion)[0], found[k])


# The vertical


@pytest.mark.slow
def test_the_vertical_between_two_steps_is_seen():
    """A pitch of more than 89.5 degrees for 1/50 of a step, at no step."""
    model = rr.FullModel(rr.Robot.from_parameters())
    free = rr.FullModel(model.robot, damping=rr.BodyRateDamping(0.01, 0.01, 0.01))
    setting, steps = lower(free), 16
    some = gaits([np.pi / 2], 0.0)
    some.angular_frequency[:] = 6.0
    low, high = 0.3, 2.0

    def pitch(amplitude, n):
        some.sine[:] = amplitude
        found = settled(setting, some, cycles=np.array([4]), counted=2, steps=n)
        return float(found.results[0, RESULT.index("pitch")])

    wanted = np.deg2rad(89.8)
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if pitch(middle, 160) < wanted else (low, middle)
    assert pitch(low, 160) == pytest.approx(wanted, abs=1e-4)
    # An independent look: the KKT model, at the engine's steps and between them.
    gait = rr.SinusoidalGait(offset=np.pi / 2, amplitude=low, angular_frequency=6.0, n_legs=2)
    t = rr.simulate(free, gait, 4 * gait.period, gait.period / 1600, step=gait.period / 160)
    seen = np.abs(t.euler[:, 1])
    assert seen.max() == pytest.approx(wanted, abs=1e-4)
    assert seen[:: 1600 // steps].max() < np.deg2rad(89.3)
    counts = {"cycles": 4, "counted": 2, "steps_per_cycle": steps}
    assert steady_states(setting, some, **counts)[0, len(RESULT) - 1] == OK
    stops = setting._replace(limit=SINE_LIMIT)
    assert steady_states(stops, some, **counts)[0, len(RESULT) - 1] == VERTICAL
    some.sine[:] = 0.97 * low
    assert steady_states(stops, some, **counts)[0, len(RESULT) - 1] == OK


def test_the_largest_pitch_is_that_of_a_trajectory():
    model = rr.FullModel(rr.Robot.from_parameters())
    for gait in (rr.gait("lateral", amplitude=0.5), rr.gait("circular")):
        t = rr.simulate(model, gait, 6 * gait.period, gait.period / 400, method="momentum")
        found = settled(
            lower(model), GaitBatch.of([gait]), cycles=np.array([6]), counted=2, steps=10
        )
        assert found.results[0, RESULT.index("pitch")] == pytest.approx(
            np.abs(t.euler[:, 1]).max(), rel=2e-4
        )


# Compiling


def test_what_is_compiled_is_known(tmp_path):
    import subprocess
    import sys

    from numba import njit

    def twice(x):
        return 2 * x

    assert not in_cache(njit(twice)) or not njit(twice).signatures
    steady_states(
        lower(rr.FullModel(rr.Robot.from_parameters())),
        gaits([1.0], 1.0),
        **COUNTS,
        loads=True,
    )
    assert ready() and ready(loads=True)
    (tmp_path / "twice.py").write_text(
        "from numba import njit\nfrom rrrobot.momentum.compiled import in_cache\n"
        "@njit(cache=True)\ndef twice(x):\n    return 2 * x\n"
        "print(in_cache(twice))\ntwice(1.0)\nprint(in_cache(twice))\n"
    )

    def said():
        return subprocess.run(
            [sys.executable, "twice.py"], cwd=tmp_path, capture_output=True, text=True, check=True
        ).stdout.split()

    assert said() == ["False", "True"]
    assert said() == ["True", "True"]
    with open(tmp_path / "twice.py", "a") as stream:
        stream.write("# changed\n")
    assert said() == ["False", "True"]


def test_what_the_engine_cannot_do_is_told():
    class Waves(rr.Plane):
        """A ground of one's own."""

    waves = rr.FullModel(rr.Robot.from_parameters(), ground=Waves())
    with pytest.raises(rr.ModelError, match=r"does not know the ground .*Waves"):
        rr.simulate(waves, rr.gait("lateral"), 1.0, method="momentum")
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

    def interrupt(time, _):
        if time > 6.0:
            raise KeyboardInterrupt

    with pytest.raises(rr.SimulationInterrupted) as halted:
        rr.simulate(model, rr.gait("lateral"), 60.0, method="momentum", progress=interrupt)
    assert 6.0 < halted.value.trajectory.time[-1] < 60.0


def test_what_derives_from_a_known_model_is_not_taken_for_it():
    """The engine's equations are those of the very classes that it knows."""

    class Sticky(rr.FullModel):
        def damping_force(self, place, quasi):
            return -1.0 * super().damping_force(place, quasi)

    class Quadratic(rr.BodyRateDamping):
        def moment(self, roll, pitch, omega_body):
            return -0.01 * np.abs(omega_body) * omega_body

    class Lens(rr.Ellipsoid):
        """Its functions are its own; the engine's series of them does not reach its sharp rim."""

    class Ramp(rr.Plane):
        def point(self, coordinates):
            return super().point(coordinates) + 1.0

    robot = rr.Robot.from_parameters()
    lens = rr.Robot.from_urdf(rr.urdf_path(), shell=Lens((0.3, 0.3, 0.05)))
    for model, name in (
        (Sticky(robot), "Sticky"),
        (rr.FullModel(robot, damping=Quadratic()), "Quadratic"),
        (rr.FullModel(lens), "polynomial of directions"),
        (rr.FullModel(robot, ground=Ramp()), "does not know the ground"),
    ):
        with pytest.raises(rr.ModelError, match=name):
            rr.simulate(model, rr.gait("lateral"), 1.0, method="momentum")
        with pytest.raises(rr.ModelError, match=name):
            rr.sweep(model, offset=1.0, progress=False)
