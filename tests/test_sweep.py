"""Sweeps: labels, bits that depend on nothing but the gait, physics of the plane, bad input."""

from __future__ import annotations

import itertools
import json
import math
import multiprocessing
import warnings
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from importlib import import_module

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import rrrobot as rr
from rrrobot.errors import SweepInterrupted
from rrrobot.models.recombined import DecoupledModels
from rrrobot.results import COLUMNS, STATUS, load_names, names
from rrrobot.simulation.heights import clearance
from rrrobot.studies.sweeps import variants as sweep_models
from rrrobot.studies.sweeps.run import sweep
from tests.random_robot import random_robot
from tests.some import some

sweep_module = import_module("rrrobot.studies.sweeps.run")
# Most runs here are shorter than it takes to settle.
pytestmark = pytest.mark.filterwarnings("ignore::rrrobot.errors.UnsettledWarning")
"""`rr.sweep` is the function."""
ROBOT = rr.Robot.from_parameters()
FULL = rr.FullModel(ROBOT)
VARIABLES, LOADS = names(loads=False), load_names()
SHORT = {"cycles": 6, "counted": 3}
"""Enough to tell gaits apart."""
PLANE = {
    "offset": np.linspace(0, np.pi, 9),
    "phase_difference": np.linspace(0, 2 * np.pi, 9),
}


def bits(dataset: xr.Dataset) -> dict[str, bytes]:
    return {str(name): values.to_numpy().tobytes() for name, values in dataset.data_vars.items()}


@pytest.fixture(scope="module")
def plane() -> xr.Dataset:
    return sweep(FULL, **PLANE)


@pytest.fixture(scope="module")
def small() -> xr.Dataset:
    return sweep(FULL, **PLANE, **SHORT)


# What is in the result


@pytest.mark.parametrize(
    "model",
    [FULL, rr.PivotingModel(ROBOT), pytest.param(DecoupledModels(ROBOT), marks=pytest.mark.slow)],
)
def test_is_the_steady_state_of_a_simulation(model: rr.FullModel | DecoupledModels) -> None:
    gait = rr.gait("circular")
    period = gait.period
    ds = sweep(model, offset=np.pi / 4, cycles=20, steps_per_cycle=60)
    if isinstance(model, DecoupledModels):
        run = rr.decoupled(ROBOT, gait, 20 * period, period / 32)
    else:
        run = rr.simulate(model, gait, 20 * period, period / 32)
    state = run.steady_state(after=11 * period)
    assert state.cycles == ds.attrs["counted"] == 9
    for name in ("speed", "yaw_rate", "curvature", "variation"):
        assert float(ds[name]) == pytest.approx(getattr(state, name), rel=1e-6, abs=1e-7), name
    difference = state.pitch_yaw_phase_difference
    assert float(ds.pitch_yaw_phase_difference) == pytest.approx(difference, abs=5e-5)
    assert [float(ds.velocity_x), float(ds.velocity_y)] == pytest.approx(state.velocity, abs=1e-9)
    for i, axis in enumerate(("roll", "pitch", "yaw")):
        for kind in ("amplitude", "phase", "mean"):
            found = float(ds[f"{axis}_{kind}"])
            assert found == pytest.approx(getattr(state, kind)[i], abs=5e-5), (axis, kind)


def test_starts_that_are_tilted() -> None:
    """Two cycles from a tilted impulsive start are far from settled, and a simulation's."""
    gait, period = rr.gait("circular"), rr.gait("circular").period
    slope = rr.FullModel(ROBOT, ground=rr.Plane((0.1, -0.05, 1.0)))
    for model in (FULL, rr.PivotingModel(ROBOT), slope):
        ds = sweep(model, offset=np.pi / 4, start_roll=[0.0, 0.2], start_pitch=-0.3, cycles=2,
                   counted=2, steps_per_cycle=60)  # fmt: skip
        for k, roll in enumerate((0.0, 0.2)):
            t = rr.simulate(
                model, gait, 2 * period, period / 64, euler=(roll, -0.3, 0), method="momentum"
            )
            state = t.steady_state(after=0.0)
            assert float(ds.speed[k]) == pytest.approx(state.speed, rel=1e-6)
            assert float(ds.yaw_rate[k]) == pytest.approx(state.yaw_rate, rel=1e-6, abs=1e-9)
    upright = sweep(FULL, offset=np.pi / 4, cycles=3)
    assert float(sweep(FULL, offset=np.pi / 4, start_roll=0.0, cycles=3).speed) == upright.speed
    with pytest.raises(rr.ParameterError, match="start_pitch is given, and the roll model"):
        sweep(rr.RollModel(ROBOT), offset=1.0, start_pitch=0.1)
    with pytest.raises(rr.ParameterError, match="reaches the vertical"):
        sweep(FULL, offset=1.0, start_pitch=[0.1, 1.6])
    with pytest.raises(rr.ParameterError, match="limit cycle does not depend on its start"):
        sweep(FULL, offset=1.0, start_roll=0.1, settle="orbit")


def test_reference_values_after_thirty_seconds() -> None:
    ds = sweep(FULL, offset=[np.pi / 4, np.pi / 2])
    assert (ds.attrs["cycles"], ds.attrs["counted"]) == (38, 18)
    np.testing.assert_allclose(ds.speed, [0.0066765, 0.009656], rtol=1e-4)
    np.testing.assert_allclose(ds.yaw_rate, [0.0208546, 0.0], atol=1e-7)
    assert float(ds.curvature[0]) == pytest.approx(0.0208546 / 0.0066765, rel=1e-4)


def test_peak_and_signs_over_the_plane(plane: xr.Dataset) -> None:
    assert float(plane.speed.max()) == pytest.approx(0.0097, abs=1e-4)
    assert (
        abs(float(plane.offset[plane.speed.max("phase_difference").argmax("offset")]) - np.pi / 2)
        < 0.01
    )
    inner = plane.isel(offset=slice(2, 7), phase_difference=[1, 2, 3, 5, 6, 7])
    assert not inner.status.any()
    signs = np.sign(np.cos(inner.offset)) * np.sign(np.sin(inner.phase_difference))
    off = abs(inner.offset - np.pi / 2) > 0.1
    assert (np.sign(inner.yaw_rate) == signs).where(off, True).all()
    # On the line offset pi/2 nothing turns, on phase difference pi nothing travels far.
    assert abs(plane.sel(offset=np.pi / 2, method="nearest").yaw_rate).max() < 1e-7
    assert float(inner.speed.min()) > 5 * float(plane.speed[4, 4])
    # Legs exchanged: the mirror image.
    mirrored = plane.velocity_y.values[:, ::-1]
    np.testing.assert_allclose(plane.velocity_y, -mirrored, atol=1e-4)


def test_only_the_yaw_model_has_a_hump(plane: xr.Dataset) -> None:
    yaw = sweep(rr.YawModel(ROBOT), **PLANE)

    def hump(ds: xr.Dataset) -> float:
        row = ds.yaw_amplitude.sel(phase_difference=np.pi, method="nearest")
        return float(row[4] / row[2])

    assert hump(yaw) > 1.5
    assert hump(plane) < 1.1
    pitch = sweep(rr.PitchModel(ROBOT), **PLANE)
    np.testing.assert_allclose(pitch.pitch_amplitude, plane.pitch_amplitude, atol=0.02)


@pytest.mark.parametrize("kind", [rr.RollModel, rr.PitchModel, rr.YawModel])
def test_single_axis_models(kind: type[rr.YawModel]) -> None:
    ds = sweep(kind(ROBOT), offset=[0.3, 0.8], **SHORT)
    for axis in ("roll", "pitch", "yaw"):
        moves = bool((ds[f"{axis}_amplitude"] > 1e-3).all())
        assert moves == (axis == kind.name)
    assert ds.pitch_yaw_phase_difference.isnull().all()


def test_yaw_amplitude_of_decoupled_models() -> None:
    models = DecoupledModels(ROBOT, yaw=rr.YawModel(ROBOT, damping=0.001))
    grid = {"offset": [0.5, 0.9], "phase_difference": [1.0, 2.0, 3.0]}
    own = sweep(models, **grid, **SHORT)
    assert "yaw_model_amplitude" not in own.coords
    table = xr.DataArray([np.nan, 0.4], {"offset": grid["offset"]}, ("offset",))
    ds = sweep(models, **grid, yaw_amplitude=table, chunk=5, **SHORT)
    wide = sweep(models, **grid, yaw_amplitude=0.4, **SHORT)
    for name in ("yaw_rate", "yaw_amplitude", "speed", "pitch_amplitude"):
        np.testing.assert_array_equal(ds[name][0], own[name][0])
        np.testing.assert_array_equal(ds[name][1], wide[name][1])
    assert (ds.yaw_amplitude[1] > 1.2 * own.yaw_amplitude[1]).all()
    np.testing.assert_array_equal(ds.pitch_amplitude, own.pitch_amplitude)
    np.testing.assert_array_equal(ds.yaw_model_amplitude, table)
    assert json.loads(ds.attrs["model"])["yaw"]["damping"]["yaw"] == 0.001


def test_describes_itself(small: xr.Dataset) -> None:
    assert set(small.data_vars) == {*VARIABLES, "status"}
    for name, unit in ((name, COLUMNS[name].unit) for name in VARIABLES):
        assert small[name].dims == ("offset", "phase_difference")
        assert small[name].attrs["units"] == unit
        assert small[name].attrs["long_name"]
    assert small.status.attrs["flag_values"].tolist() == list(STATUS)
    assert len(small.status.attrs["flag_meanings"].split()) == len(STATUS)
    units = {name: coord.attrs["units"] for name, coord in small.coords.items()}
    assert units == {
        "offset": "rad",
        "phase_difference": "rad",
        "amplitude": "rad",
        "angular_frequency": "rad/s",
    }
    assert (float(small.amplitude), float(small.angular_frequency)) == (0.3, 8.0)
    assert rr.Robot.from_dict(json.loads(small.attrs["robot"])) == ROBOT
    assert rr.RRRobotParameters(**json.loads(small.attrs["parameters"])) == rr.RRRobotParameters()
    assert json.loads(small.attrs["model"]) == FULL.to_dict()
    assert {"rrrobot", "numpy", "numba", "pinocchio", "cpu"} <= set(
        json.loads(small.attrs["versions"])
    )
    counts = [small.attrs[name] for name in ("cycles", "counted", "steps_per_cycle")]
    assert counts == [6, 3, 10]


def test_loads_on_request(small: xr.Dataset) -> None:
    """The same sweep with more variables; what they are is tested with the engine."""
    ds = sweep(FULL, **PLANE, **SHORT, loads=True, chunk=7)
    assert set(ds.data_vars) == {*VARIABLES, *LOADS, "status"}
    assert (small.attrs["loads"], ds.attrs["loads"]) == (0, 1)
    for name in (*VARIABLES, "status"):
        np.testing.assert_array_equal(ds[name], small[name])
    for name, unit in ((name, COLUMNS[name].unit) for name in LOADS):
        assert ds[name].attrs["units"] == unit and ds[name].attrs["long_name"]
        assert (ds[name] > 0).all() or (name == "torque_share" and not ds[name].any()), name
    assert bits(sweep(FULL, **PLANE, **SHORT, loads=True, threads=1)) == bits(ds)
    pivoting = sweep(rr.PivotingModel(ROBOT), offset=1.0, **SHORT, loads=True)
    assert pivoting.friction.isnull() and float(pivoting.peak_torque) > 0
    both = sweep(DecoupledModels(ROBOT), offset=1.0, yaw_amplitude=0.2, **SHORT, loads=True)
    assert all(both[name].isnull() for name in LOADS) and float(both.speed) > 0


@pytest.mark.slow
def test_loads_of_a_settled_gait_are_the_trajectorys() -> None:
    gait = rr.gait("circular")
    ds = sweep(FULL, offset=np.pi / 4, steps_per_cycle=20, loads=True)
    t = rr.simulate(FULL, gait, 38 * gait.period, gait.period / 400, step=gait.period / 80)
    last = slice(-401, -1)
    # 400 samples miss the top of a peak, and the corners of a power, by up to a few 1e-5.
    assert float(ds.friction) == pytest.approx(t.required_friction[last].max(), rel=5e-5)
    assert float(ds.peak_torque) == pytest.approx(np.abs(t.leg_torque[last]).max(), rel=5e-5)
    rms = np.sqrt((t.leg_torque[last] ** 2).sum(axis=1).mean())
    assert float(ds.rms_torque) == pytest.approx(rms, rel=1e-7)
    power = np.abs(t.leg_torque * t.leg_rate)[last].sum(axis=1).mean()
    assert float(ds.power) == pytest.approx(power, rel=5e-5)


def test_meanings_are_the_kernels() -> None:
    from rrrobot.momentum import batch, kernels

    codes = kernels.OK, kernels.VERTICAL, kernels.NOT_FINITE, kernels.LIFT_OFF
    words = ("steady_state", "pitch_reached_90_degrees", "value_not_finite", "lifts_off")
    assert {code: STATUS[code] for code in codes} == dict(zip(codes, words, strict=True))
    assert set(batch.RESULT) <= {*VARIABLES, "status"}
    assert set(batch.LOADS) == set(LOADS)
    assert sweep_module._LANES == kernels.LANES


# Which gait stands where


def echo(setting: object, gaits: object, **_: object) -> np.ndarray:
    """An engine whose results are the gaits."""
    from rrrobot.momentum.batch import RESULT

    out = np.zeros((gaits.n, len(RESULT)))
    columns = (*gaits.offset.T, *gaits.sine[:, 0].T, *gaits.cosine[:, 0].T,
               gaits.angular_frequency)  # fmt: skip
    for i, column in enumerate(columns):
        out[:, i] = column
    out[:, RESULT.index("clearance")] = 1.0
    return out


ECHOED = (
    *("speed", "velocity_x", "velocity_y", "yaw_rate", "roll_amplitude", "pitch_amplitude"),
    "yaw_amplitude",
)
"""Variables in which `echo` puts the seven numbers of a gait of two legs: offsets, a cos(phase),
a sin(phase), the frequency."""

angle = st.floats(-7, 7, allow_subnormal=False)
grid = st.one_of(angle, st.lists(angle, min_size=1, max_size=4, unique=True))


@settings(deadline=None, max_examples=25)
@given(
    offset=st.one_of(grid, st.tuples(grid, grid)),
    amplitude=st.one_of(grid, st.tuples(grid, grid)),
    phase=st.tuples(grid, grid),
    frequency=st.lists(st.floats(0.1, 20), min_size=1, max_size=3, unique=True),
    chunk=st.integers(1, 50),
)
def test_grids_are_products(offset, amplitude, phase, frequency, chunk) -> None:  # type: ignore[no-untyped-def]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sweep_models, "engine_of", lambda *_: (echo, None))
        ds = sweep(
            FULL,
            offset=offset,
            amplitude=amplitude,
            phase=phase,
            angular_frequency=frequency,
            chunk=chunk,
        )

    def legs(value):  # type: ignore[no-untyped-def]
        return value if isinstance(value, tuple) else (value, value)

    def coord(name, leg, value):  # type: ignore[no-untyped-def]
        own = f"{name}_leg_{leg + 1}"
        found = ds[own] if own in ds.coords else ds[name]
        np.testing.assert_array_equal(found, value)
        return found

    for leg in range(2):
        swing = coord("amplitude", leg, legs(amplitude)[leg])
        turn = coord("phase", leg, phase[leg])
        assert (ds[ECHOED[leg]] == coord("offset", leg, legs(offset)[leg])).all()
        for variable, part in ((ECHOED[2 + leg], np.cos), (ECHOED[4 + leg], np.sin)):
            assert abs(ds[variable] - swing * part(turn)).max() < 1e-14
    np.testing.assert_array_equal(ds.angular_frequency, frequency)
    assert (ds[ECHOED[6]] == ds.angular_frequency).all()
    assert ds.speed.size == math.prod(ds.sizes.values())


def test_phase_difference_leads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep_models, "engine_of", lambda *_: (echo, None))
    ds = sweep(FULL, offset=1.0, phase_difference=[0.5, 0.7])
    first, second = ds[ECHOED[4]], ds[ECHOED[5]]
    assert (first == 0).all()
    np.testing.assert_allclose(second, 0.3 * np.sin([0.5, 0.7]), rtol=1e-15)
    assert float(sweep(FULL, offset=1.0).phase_difference) == np.pi / 2


def test_lists_of_gaits(small: xr.Dataset) -> None:
    pairs = list(itertools.product(PLANE["offset"], PLANE["phase_difference"]))
    gaits = [
        rr.SinusoidalGait(offset=o, amplitude=0.3, angular_frequency=8.0, phase=(0.0, p))
        for o, p in pairs
    ]
    ds = sweep(FULL, points=gaits, **SHORT)
    assert ds.speed.dims == ("gait",)
    assert ds.offset.dims == ("gait", "leg")
    assert ds.leg.values.tolist() == ["leg_1", "leg_2"]
    arrays = {"offset": np.array(pairs)[:, 0], "phase_difference": np.array(pairs)[:, 1]}
    other = sweep(FULL, points=arrays, **SHORT)
    assert bits(ds) == bits(other) == bits(small)
    mixed = sweep(FULL, points=arrays, amplitude=[0.2, 0.3], **SHORT)
    assert mixed.speed.dims == ("gait", "amplitude")
    np.testing.assert_array_equal(mixed.speed.sel(amplitude=0.3), ds.speed)


def test_legs_by_name_equal_legs_by_place() -> None:
    by_name = {"leg_2": [0.5, 1.0, 1.5], "leg_1": 0.7}
    ds = sweep(FULL, offset=by_name, **SHORT)
    assert ds.speed.dims == ("offset_leg_2",)
    assert bits(ds) == bits(sweep(FULL, offset=(0.7, [0.5, 1.0, 1.5]), **SHORT))
    point = {"offset": [[0.7, 1.0]], "phase": [[0.0, np.pi / 2]]}
    one = sweep(FULL, points=point, **SHORT)
    np.testing.assert_array_equal(one.speed[0], ds.speed[1])


def test_many_legs() -> None:
    robot = random_robot(3, joints=6)
    model = rr.FullModel(robot)
    phases = {leg: 0.4 * i for i, leg in enumerate(robot.legs)}
    phases[robot.legs[2]] = np.array([0.0, 1.0])
    ds = sweep(model, offset=0.1, phase=phases, amplitude=[0.05], **SHORT)
    assert dict(ds.sizes) == {f"phase_{robot.legs[2]}": 2, "amplitude": 1}
    assert not ds.status.any()
    assert np.isfinite(ds.clearance).all()
    with pytest.raises(rr.ParameterError, match="has 6: give the phase of each leg by phase="):
        sweep(model, offset=0.1, phase_difference=1.0)


# Robots


def test_swept_parameters_make_the_model_anew() -> None:
    damping = rr.BodyRateDamping(0.02, 0.01, 0.03)
    parameters = rr.RRRobotParameters(hip_offset=0.1, servo_mass=(0.05, 0.06))
    model = rr.FullModel(rr.Robot.from_parameters(parameters), damping=damping)
    grids = {"leg_mass": [0.04, 0.06], "shell_radius": [0.11, 0.12, 0.13]}
    gaits = {"offset": [0.6, 0.9], **SHORT}
    ds = sweep(model, parameters=grids, **gaits, chunk=16)
    assert ds.speed.dims == ("leg_mass", "shell_radius", "offset")
    assert ds.shell_radius.attrs["units"] == "m"
    changed = rr.RRRobotParameters(
        hip_offset=0.1, servo_mass=(0.05, 0.06), leg_mass=0.06, shell_radius=0.11
    )
    own = rr.FullModel(rr.Robot.from_parameters(changed), damping=damping)
    alone = sweep(own, **gaits)
    for name in VARIABLES:
        np.testing.assert_array_equal(ds[name].sel(leg_mass=0.06, shell_radius=0.11), alone[name])
    assert len(np.unique(ds.speed)) == ds.speed.size
    assert bits(sweep(model, parameters=grids, **gaits, threads=1)) == bits(ds)


@pytest.mark.parametrize("field", ["battery_mass", "leg_length", "gravity", "servo_mass"])
def test_every_parameter_can_be_swept(field: str) -> None:
    value = 1.1 * rr.RRRobotParameters().to_dict()[field]
    for model in (rr.PivotingModel(ROBOT), DecoupledModels(ROBOT)):
        ds = sweep(model, offset=0.8, parameters={field: [value]}, **SHORT)
        other = model.remade(rr.Robot.from_parameters(rr.RRRobotParameters(**{field: value})))
        assert float(ds.pitch_amplitude[0]) == float(
            sweep(other, offset=0.8, **SHORT).pitch_amplitude
        )


# Bits


@pytest.mark.parametrize(("chunk", "threads"), [(1, 1), (7, 2), (16, 1), (80, 2), (1000, 3)])
def test_chunks_and_threads_do_not_matter(small: xr.Dataset, chunk: int, threads: int) -> None:
    assert bits(sweep(FULL, **PLANE, **SHORT, chunk=chunk, threads=threads)) == bits(small)


@pytest.mark.slow
def test_processes_do_not_matter(small: xr.Dataset) -> None:
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=spawn) as pool:
        assert bits(sweep(FULL, **PLANE, **SHORT, executor=pool, chunk=9)) == bits(small)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_dask_cluster_of_two_processes(small: xr.Dataset) -> None:
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        ds = sweep(FULL, **PLANE, **SHORT, executor=client.get_executor(), chunk=9)
    assert bits(ds) == bits(small)


def test_a_gait_does_not_depend_on_its_neighbours() -> None:
    """Nor on those that stop."""
    amplitude = [0.3, 1.4, 0.2, 1.3]
    ds = sweep(FULL, offset=[np.pi / 4, np.pi / 2], phase_difference=0.0, amplitude=amplitude,
               angular_frequency=[6.0, 8.0])  # fmt: skip
    assert 0 < np.count_nonzero(ds.status) < ds.status.size
    for where in np.ndindex(ds.speed.shape):
        one = ds.isel(dict(zip(ds.speed.dims, where, strict=True)))
        alone = sweep(
            FULL,
            offset=float(one.offset),
            phase_difference=0.0,
            amplitude=float(one.amplitude),
            angular_frequency=float(one.angular_frequency),
        )
        assert bits(alone) == bits(one)


def test_stopped_gaits_say_why() -> None:
    ds = sweep(
        FULL, offset=np.pi / 2, phase_difference=0.0, amplitude=[0.3, 1.4], angular_frequency=6.0
    )
    assert ds.status.values.tolist() == [0, 1]
    stopped = ds.isel(amplitude=1)
    for name in VARIABLES:
        assert bool(stopped[name].isnull()), name
    lifts = sweep(FULL, offset=np.pi / 4, amplitude=[0.3, 0.8], angular_frequency=30.0)
    assert lifts.status.values.tolist() == [0, 3]
    assert 0 < float(lifts.normal_force[0]) < 0.52 * 9.81


def test_few_chunks_are_in_flight() -> None:
    class Slow(Executor):
        """Runs a chunk only when many more have been handed in."""

        def __init__(self) -> None:
            self.pool, self.most, self.now = ThreadPoolExecutor(1), 0, 0

        def submit(self, task, /, *args, **kwargs) -> Future:  # type: ignore[no-untyped-def]
            self.now += 1
            self.most = max(self.most, self.now)
            future = self.pool.submit(task, *args, **kwargs)
            future.add_done_callback(lambda _: setattr(self, "now", self.now - 1))
            return future

    slow = Slow()
    sweep(FULL, **PLANE, cycles=2, chunk=1, executor=slow)
    assert 1 < slow.most <= sweep_module._IN_FLIGHT
    slow.pool.shutdown()


# Legs and the ground


@pytest.mark.parametrize(
    "kind",
    some(
        (rr.FullModel, rr.PivotingModel, rr.RollModel, rr.YawModel),
        {"full"},
        lambda kind: kind.name,
    ),
)
def test_clearance_is_that_of_a_trajectory(kind) -> None:
    """The engine's, between its steps, against Pinocchio's kinematics at 400 samples a cycle."""
    parameters = rr.RRRobotParameters(leg_length=(0.1, 0.115), shell_radius=0.121)
    model = kind(rr.Robot.from_parameters(parameters))
    gait = rr.SinusoidalGait(
        offset=(0.4, -0.3), amplitude=(0.4, 0.3), angular_frequency=8.0, phase=(0.2, 1.5)
    )
    ds = sweep(model, points=[gait], cycles=20, steps_per_cycle=20)
    t = rr.simulate(model, gait, 20 * gait.period, gait.period / 400, method="momentum")
    assert float(ds.clearance[0]) == pytest.approx(clearance(t, slice(-401, None)), abs=2e-6)


@pytest.mark.slow
def test_clearance_of_the_decoupled_models_is_that_of_their_path() -> None:
    robot, gait = rr.Robot.from_parameters(), rr.gait("circular", amplitude=0.4)
    ds = sweep(DecoupledModels(robot), points=[gait], cycles=20, steps_per_cycle=20)
    t = rr.decoupled(robot, gait, 20 * gait.period, gait.period / 200)
    assert float(ds.clearance[0]) == pytest.approx(clearance(t, slice(-201, None)), abs=1e-5)
    assert ds.pitch.isnull().all()


def test_a_leg_through_the_ground_is_flagged_not_refused() -> None:
    with pytest.warns(rr.GroundClearanceWarning):
        parameters = rr.RRRobotParameters(leg_length=0.13)
    model = rr.FullModel(rr.Robot.from_parameters(parameters))
    with pytest.warns(rr.GroundClearanceWarning, match="1 of 2 gaits swing a leg") as found:
        ds = sweep(model, offset=[-np.pi / 2, np.pi / 2], **SHORT)
    assert found[0].filename == __file__
    assert float(ds.clearance[0]) < -0.009 and float(ds.clearance[1]) > 0.2
    with warnings.catch_warnings():
        warnings.simplefilter("error", rr.GroundClearanceWarning)
        sweep(FULL, offset=1.5, parameters={"leg_length": [0.1, 0.13]}, **SHORT)


# Bad input


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "offset is missing"),
        ({"offset": []}, "offset is empty"),
        ({"offset": np.array([])}, "offset is empty"),
        ({"offset": [0.0, math.nan]}, "offset is .*every entry must be finite"),
        ({"offset": math.inf}, "offset is inf rad"),
        ({"offset": [[0.0], [1.0]]}, r"offset has shape \(2, 1\)"),
        ({"offset": [[0.0], [1.0, 2.0]]}, "its entries must be numbers"),
        ({"offset": "0:1:3"}, "it must be a number"),
        ({"offset": [True]}, "offset is .True."),
        ({"offset": (0.0, 1.0, 2.0)}, "a tuple of 3: a tuple holds .* leg_1, leg_2"),
        ({"offset": ()}, "a tuple of 0"),
        ({"offset": {"leg_1": 0.0}}, "given for leg_1: give it for each of leg_1, leg_2"),
        ({"offset": {"leg_1": 0.0, "leg_3": 1.0}}, "given for leg_1, leg_3"),
        ({"offset": (0.0, [])}, "offset_leg_2 is empty"),
        ({"offset": 0.0, "amplitude": [0.1, math.inf]}, "amplitude is"),
        ({"offset": 0.0, "angular_frequency": 0.0}, "greater than zero"),
        ({"offset": 0.0, "angular_frequency": [8.0, -1.0]}, "angular_frequency has the value -1"),
        ({"offset": 0.0, "angular_frequency": (8.0, 8.0)}, "angular_frequency is one for all"),
        ({"offset": 0.0, "phase": 0.0, "phase_difference": 1.0}, "both given"),
        ({"offset": 0.0, "phase_difference": (0.0, 1.0)}, "phase_difference is one for all"),
        ({"offset": 0.0, "yaw_amplitude": 0.3}, "yaw_amplitude is for DecoupledModels"),
        ({"offset": 0.0, "cycles": 1}, "cycles is 1: .* from 2 to"),
        ({"offset": 0.0, "cycles": 38.0}, "cycles is 38.0"),
        ({"offset": 0.0, "cycles": True}, "cycles is True"),
        ({"offset": 0.0, "counted": 1}, "counted is 1: .* from 2 to 38"),
        ({"offset": 0.0, "counted": 39}, "counted is 39"),
        ({"offset": 0.0, "steps_per_cycle": 3}, "steps_per_cycle is 3"),
        ({"offset": 0.0, "steps_per_cycle": 10**9}, "steps_per_cycle is 1000000000"),
        ({"offset": 0.0, "loads": 1}, "loads is 1: it must be True or False"),
        ({"offset": 0.0, "chunk": 0}, "chunk is 0"),
        ({"offset": 0.0, "threads": 0}, "threads is 0"),
        ({"offset": 0.0, "parameters": {"mass": [1.0]}}, "has no 'mass'; it has leg_mass"),
        ({"offset": 0.0, "parameters": {"leg_mass": []}}, "leg_mass is empty"),
        ({"offset": 0.0, "parameters": {"leg_mass": [0.1, -0.1]}}, "leg_mass is -0.1 kg"),
        ({"points": []}, "there is no gait"),
        ({"points": {}}, "points has no entry"),
        ({"points": {"offset": []}}, "is empty"),
        ({"points": {"offset": 1.0}}, r"points\['offset'\] has shape \(\)"),
        ({"points": {"offset": [[1.0, 2.0, 3.0]]}}, r"shape \(1, 3\): .* \(n, 2\)"),
        ({"points": {"offset": [1.0], "omega": [8.0]}}, "points has 'omega'"),
        ({"points": {"offset": [1.0], "angular_frequency": [0.0]}}, "must be above 0"),
        ({"points": {"offset": [1.0], "angular_frequency": [[8.0, 8.0]]}}, r"must be \(n,\)"),
        ({"points": {"offset": [1.0], "amplitude": [0.1, 0.2]}}, "different lengths"),
        ({"points": {"offset": [1.0, math.nan]}}, "finite"),
        ({"points": {"offset": [1.0]}, "offset": 1.0}, "points has offset already"),
        ({"points": {"offset": [1.0]}, "phase": 0.0, "phase_difference": 0.0}, "both given"),
        ({"points": {"amplitude": [1.0]}}, "offset is missing"),
        ({"points": [rr.StillLegs(1.0)]}, "the gait has no period"),
        ({"points": [1.0]}, "gait 0 is 1.0: it must be a Gait"),
    ],
)  # fmt: skip
def test_bad_arguments(options: dict, message: str) -> None:
    with pytest.raises((rr.ParameterError, rr.GaitError), match=message):
        sweep(FULL, **options)


def test_gaits_that_no_sweep_has() -> None:
    common = {"offset": 1.0, "amplitude": 0.3}
    one, three = (rr.SinusoidalGait(**common, angular_frequency=8.0, n_legs=n) for n in (2, 3))
    with pytest.raises(rr.GaitError, match="gait 1 has 3 legs"):
        sweep(FULL, points=[one, three])
    with pytest.raises(rr.ParameterError, match=r"shape \(1, 3\)"):
        sweep(FULL, points=[three])


def test_yaw_amplitudes_that_do_not_fit() -> None:
    models = DecoupledModels(ROBOT)
    table = xr.DataArray([0.3, 0.4], {"offset": [0.5, 0.9]}, ("offset",))
    for offset, message in (([0.5, 0.8], "other values of offset"), ([0.5], "dimensions")):
        with pytest.raises(rr.ParameterError, match=message):
            sweep(models, offset=offset, yaw_amplitude=table)
    with pytest.raises(rr.ParameterError, match="infinite"):
        sweep(models, offset=[0.5, 0.9], yaw_amplitude=table / 0.0)
    with pytest.raises(rr.ParameterError, match="it must be"):
        sweep(models, offset=[0.5, 0.9], yaw_amplitude=[0.3, 0.4])  # type: ignore[arg-type]


def test_too_many_gaits_are_refused_at_once() -> None:
    wide = np.linspace(0, 1, 3000)
    with pytest.raises(rr.ParameterError, match="27000000000 gaits, the limit is 50000000"):
        sweep(FULL, offset=wide, phase_difference=wide, amplitude=wide)


def test_models_that_the_engine_does_not_know() -> None:
    with pytest.raises(rr.ModelError, match="it must be a model"):
        sweep("full", offset=1.0)  # type: ignore[arg-type]

    class Mine(rr.FullModel):
        """Might have other equations."""

    with pytest.raises(rr.ModelError, match=r"does not know .*Mine"):
        sweep(Mine(ROBOT), offset=1.0)
    still = rr.Robot.from_urdf(ROBOT.urdf, shell=rr.Sphere(0.12), legs=[])
    with pytest.raises(rr.ParameterError, match="no legs"):
        sweep(rr.FullModel(still), offset=1.0)
    with pytest.raises(rr.ParameterError, match="is no parameter of random"):
        sweep(rr.FullModel(random_robot(1, 2)), offset=1.0, parameters={"leg_mass": [0.1]})
    with pytest.raises(rr.ModelError, match="must be a PitchModel of the robot"):
        DecoupledModels(ROBOT, pitch=rr.YawModel(ROBOT))  # type: ignore[arg-type]


def test_errors_of_a_chunk_come_through(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(setting, gaits, **_):  # type: ignore[no-untyped-def]
        raise ZeroDivisionError("of the engine")

    monkeypatch.setattr(sweep_models, "engine_of", lambda *_: (fail, None))
    with pytest.raises(ZeroDivisionError, match="of the engine"):
        sweep(FULL, **PLANE, chunk=3)


# Progress and Ctrl-C


def test_progress_is_told() -> None:
    told: list[tuple[int, int]] = []
    sweep(FULL, **PLANE, cycles=2, chunk=20, threads=1, progress=lambda *now: told.append(now))
    assert told[0] == (0, 81)
    assert told[-1] == (81, 81)
    assert told == sorted(told)
    assert len(told) > 2


def test_bar_shows_rate_and_time_left(capsys: pytest.CaptureFixture[str]) -> None:
    sweep(FULL, **PLANE, cycles=2, chunk=20, progress=True)
    out, err = capsys.readouterr()
    assert out == ""
    assert "full model: 100%" in err
    assert "81/81" in err
    assert "gaits/s" in err
    for quiet in (None, False):
        sweep(FULL, **PLANE, cycles=2, progress=quiet)
        assert capsys.readouterr() == ("", "")


def test_ctrl_c_keeps_what_is_finished(small: xr.Dataset) -> None:
    def stop(done: int, total: int) -> None:
        if done >= 30:
            raise KeyboardInterrupt

    with pytest.raises(SweepInterrupted, match=r"after \d+ of 81 gaits; the error's") as caught:
        sweep(FULL, **PLANE, **SHORT, chunk=10, threads=1, progress=stop)
    assert isinstance(caught.value, KeyboardInterrupt)
    ds = caught.value.dataset
    done = ds.status.values != -1
    assert 30 <= done.sum() < 81
    for name in VARIABLES:
        np.testing.assert_array_equal(ds[name].values[done], small[name].values[done])
        assert ds[name].isnull().values[~done].all()


def test_chunks_that_came_back_meanwhile_are_kept(small: xr.Dataset) -> None:
    class StopsAtTheFourth(Executor):
        count = 0

        def submit(self, task, /, *args, **kwargs) -> Future:  # type: ignore[no-untyped-def]
            self.count += 1
            if self.count == 4:
                raise KeyboardInterrupt
            future: Future = Future()
            future.set_result(task(*args, **kwargs))
            return future

    with pytest.raises(SweepInterrupted, match="after 30 of 81 gaits") as caught:
        sweep(FULL, **PLANE, **SHORT, chunk=10, executor=StopsAtTheFourth())
    kept = caught.value.dataset.speed.values.ravel()[:30]
    np.testing.assert_array_equal(kept, small.speed.values.ravel()[:30])


@pytest.mark.slow
def test_other_bellies_and_grounds_give_what_a_simulation_gives() -> None:
    egg = rr.Robot.from_urdf(ROBOT.urdf, shell=rr.EllipsoidSum([(0.07, 0.06, 0.06), (0.06,) * 3]))
    for model in (
        rr.FullModel(egg, damping=0.02),
        rr.FullModel(ROBOT, ground=rr.Boulder(3.0), damping=rr.BodyRateDamping(0.02, 0.02, 0.02)),
    ):
        ds = sweep(model, offset=1.2, phase_difference=1.5, progress=False)
        gait = rr.SinusoidalGait(offset=1.2, amplitude=0.3, angular_frequency=8.0, phase=(0.0, 1.5))
        t = rr.simulate(model, gait, 38 * gait.period, gait.period / 40, method="momentum")
        state = t.steady_state(after=(38 - int(ds.attrs["counted"])) * gait.period)
        assert float(ds.speed) == pytest.approx(state.speed, rel=2e-3)
        if model.robot is egg:  # on a boulder the pitch never settles
            assert float(ds.pitch_amplitude) == pytest.approx(state.amplitude[1], rel=2e-3)
