"""The netCDF file of a sweep: kills, Ctrl-C, full disks, and other sweeps' files."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import rrrobot as rr
from rrrobot.errors import SweepInterrupted
from rrrobot.models.recombined import DecoupledModels
from rrrobot.results import NOT_COMPUTED, curvature
from rrrobot.results import names as result_names
from rrrobot.studies.sweeps import store as sweep_store
from rrrobot.studies.sweeps import variants as sweep_models
from rrrobot.studies.sweeps.run import sweep
from rrrobot.studies.sweeps.store import pending

sweep_module = import_module("rrrobot.studies.sweeps.run")
# Most runs here are shorter than it takes to settle.
pytestmark = pytest.mark.filterwarnings("ignore::rrrobot.errors.UnsettledWarning")
"""`rr.sweep` is the function."""
ROBOT = rr.Robot.from_parameters()
FULL = rr.FullModel(ROBOT)
GRIDS = {
    "offset": np.linspace(0.2, 3.0, 11),
    "phase_difference": np.linspace(0, 2 * np.pi, 7),
    "cycles": 4,
}
SIZE = 77

LONG = """
import numpy as np, rrrobot as rr, sys
from rrrobot.studies.sweeps.run import sweep
model = rr.FullModel(rr.Robot.from_parameters())
print("ready", flush=True)
sweep(model, offset=np.linspace(0.2, 3.0, 60), phase_difference=np.linspace(0, 6, 60), cycles=12,
      store=sys.argv[1], chunk=int(sys.argv[2]), threads=1)
print("done", flush=True)
"""


def done(path: Path) -> int:
    """Gaits that are finished in a file, as any reader of netCDF sees it."""
    with xr.open_dataset(path) as ds:
        return int((ds.status != NOT_COMPUTED).sum())


@contextmanager
def running(path: Path, chunk: int = 16) -> Iterator[subprocess.Popen[str]]:
    """A sweep of 3600 gaits in another process, that has begun and not ended."""
    process = subprocess.Popen(
        [sys.executable, "-c", LONG, str(path), str(chunk)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        deadline = time.monotonic() + 60
        while not (path.exists() and done(path) > 100):
            assert time.monotonic() < deadline and process.poll() is None
            time.sleep(0.005)
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.fixture
def store(tmp_path: Path) -> Path:
    return tmp_path / "sweep.nc"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[xr.Dataset, bytes]:
    """The sweep of GRIDS in one go: its dataset and its file."""
    path = tmp_path_factory.mktemp("whole") / "sweep.nc"
    ds = sweep(FULL, **GRIDS, store=path)
    return ds, path.read_bytes()


@contextmanager
def interrupted(after: int, **options: object) -> Iterator[None]:
    """A sweep that is stopped by Ctrl-C after so many gaits."""

    def stop(now: int, total: int) -> None:
        if now >= after:
            raise KeyboardInterrupt

    with pytest.raises(SweepInterrupted) as caught:
        sweep(FULL, **GRIDS, threads=1, progress=stop, **options)
    assert str(options["store"]) in str(caught.value)
    yield


# The file


def test_file_is_the_dataset(whole: tuple[xr.Dataset, bytes], store: Path) -> None:
    ds, content = whole
    store.write_bytes(content)
    # The file alone has the gaits' checksums.
    read = xr.load_dataset(store).drop_vars("checksum")
    xr.testing.assert_identical(read, ds)
    assert not ds.status.any()
    memory = sweep(FULL, **GRIDS)
    xr.testing.assert_identical(memory, ds)


def test_file_with_every_kind_of_coordinate(store: Path) -> None:
    gaits = [
        rr.SinusoidalGait(offset=o, amplitude=0.3, angular_frequency=7.0, phase=(0, 1))
        for o in (0.5, 1.0, 1.5)
    ]
    table = xr.DataArray([0.3, np.nan, 0.4], dims="gait")
    options = {
        "points": gaits,
        "parameters": {"leg_mass": [0.05, 0.06]},
        "yaw_amplitude": table,
        "cycles": 3,
    }
    model = DecoupledModels(ROBOT)
    ds = sweep(model, **options, store=store)
    xr.testing.assert_identical(xr.load_dataset(store).drop_vars("checksum"), ds)
    assert ds.leg.values.tolist() == ["leg_1", "leg_2"]
    # The same again is another name for the same file.
    xr.testing.assert_identical(sweep(model, **options, store=store), ds)


def test_dataset_can_be_saved_as_any_other(whole: tuple[xr.Dataset, bytes], store: Path) -> None:
    whole[0].to_netcdf(store, engine="scipy")
    xr.testing.assert_identical(xr.load_dataset(store), whole[0])


def test_a_finished_sweep_is_not_computed_again(
    whole: tuple[xr.Dataset, bytes], store: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store.write_bytes(whole[1])

    def fail(*_: object, **__: object) -> None:
        raise AssertionError("computed again")

    monkeypatch.setattr(sweep_models, "engine_of", lambda *_: (fail, None))
    xr.testing.assert_identical(sweep(FULL, **GRIDS, store=store), whole[0])
    assert store.read_bytes() == whole[1]


def test_no_resume_begins_anew(whole: tuple[xr.Dataset, bytes], store: Path) -> None:
    sweep(FULL, offset=1.0, cycles=3, store=store)
    sweep(FULL, **GRIDS, store=store, resume=False)
    assert store.read_bytes() == whole[1]


def test_infinite_curvature_is_kept(store: Path) -> None:
    ds = sweep(rr.YawModel(ROBOT), offset=[0.7, np.pi / 2, 2.0], cycles=3, store=store)
    assert np.isposinf(ds.curvature[0]) and np.isneginf(ds.curvature[2])
    xr.testing.assert_identical(xr.load_dataset(store).drop_vars("checksum"), ds)


def test_loads_are_stored_and_resumed(store: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.nc"
    ds = sweep(FULL, **GRIDS, loads=True, store=other)
    with interrupted(30, store=store, chunk=10, loads=True):
        assert 30 <= done(store) < SIZE
    xr.testing.assert_identical(sweep(FULL, **GRIDS, loads=True, store=store), ds)
    assert store.read_bytes() == other.read_bytes()
    with pytest.raises(rr.OutputError, match=r"differs in loads \(1 there, 0 here\)"):
        sweep(FULL, **GRIDS, store=store)


# Interruptions


def test_killed_sweep_goes_on_with_the_same_bits(store: Path, tmp_path: Path) -> None:
    with running(store) as process:
        process.send_signal(signal.SIGKILL)
        assert process.wait(10) == -signal.SIGKILL
    finished = done(store)
    assert 100 < finished < 3600
    partial = xr.load_dataset(store)
    assert partial.speed.where(partial.status == 0).count() == finished
    # Of one chunk, the values may have come to the file, but not its marks.
    assert partial.speed.count() in (finished, finished + 16)
    assert [path.name for path in tmp_path.iterdir()] == ["sweep.nc"]

    grids = {
        "offset": np.linspace(0.2, 3.0, 60),
        "phase_difference": np.linspace(0, 6, 60),
        "cycles": 12,
    }
    told: list[int] = []
    sweep(FULL, **grids, store=store, chunk=333, progress=lambda now, _: told.append(now))
    assert told[0] == finished
    assert told[-1] == 3600
    other = tmp_path / "other.nc"
    sweep(FULL, **grids, store=other)
    assert store.read_bytes() == other.read_bytes()


@pytest.mark.slow
def test_ctrl_c_of_a_process(store: Path) -> None:
    with running(store) as process:
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20)
    assert process.returncode != 0
    assert "done" not in out
    last = err.strip().splitlines()[-1]
    assert "SweepInterrupted: the sweep was interrupted after" in last
    assert f"'{store}' keeps them, and the same sweep goes on from there." in last
    assert f" {done(store)} of 3600 gaits" in last


@pytest.mark.parametrize("chunk", [3, 10])
def test_interrupted_again_and_again(
    whole: tuple[xr.Dataset, bytes], store: Path, chunk: int
) -> None:
    for after in (15, 35, 55):
        with interrupted(after, store=store, chunk=chunk):
            assert after <= done(store) <= after + 2 * chunk
            assert len(store.read_bytes()) == len(whole[1])
    sweep(FULL, **GRIDS, store=store, chunk=11)
    assert store.read_bytes() == whole[1]


def test_a_chunk_counts_only_when_all_of_it_is_written(
    whole: tuple[xr.Dataset, bytes], store: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As if the process died between two of its writes, at each of them in turn."""
    put = sweep_store.ResultsFile._put
    names: list[str] = []

    def recorded(self, name, first, column) -> None:  # type: ignore[no-untyped-def]
        names.append(name)
        put(self, name, first, column)

    monkeypatch.setattr(sweep_store.ResultsFile, "_put", recorded)
    sweep(FULL, **GRIDS, store=store, chunk=SIZE)
    assert names[-1] == "status"
    assert sorted(names) == sorted({*result_names(loads=False), "status", "checksum"})
    for dies_at in (0, len(names) // 2, len(names) - 1):
        store.unlink()
        countdown = iter(range(dies_at, -1, -1))

        def dies(self, name, first, column, left=countdown) -> None:  # type: ignore[no-untyped-def]
            if next(left) == 0:
                raise KeyboardInterrupt
            put(self, name, first, column)

        monkeypatch.setattr(sweep_store.ResultsFile, "_put", dies)
        with pytest.raises(SweepInterrupted, match="after 0 of 77 gaits"):
            sweep(FULL, **GRIDS, store=store, chunk=SIZE)
        assert done(store) == 0
        monkeypatch.setattr(sweep_store.ResultsFile, "_put", put)
        sweep(FULL, **GRIDS, store=store)
        assert store.read_bytes() == whole[1]


# Disks


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """No file of this process may grow beyond a size; writing there fails, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_no_space_at_the_start(store: Path, tmp_path: Path) -> None:
    with largest_file(5000), pytest.raises(rr.OutputError, match=r"cannot write .*sweep\.nc"):
        sweep(FULL, **GRIDS, store=store)
    assert not list(tmp_path.iterdir())


def test_a_disk_that_fails_later(whole: tuple[xr.Dataset, bytes], store: Path) -> None:
    """Values have their places from the start, so a full disk cannot come later; errors can."""
    with interrupted(30, store=store, chunk=10):
        before = done(store)
    with (
        largest_file(len(whole[1]) - 400),
        pytest.raises(rr.OutputError, match=r"cannot write .*sweep.nc.*File too large"),
    ):
        sweep(FULL, **GRIDS, store=store, chunk=10, threads=1)
    assert done(store) >= before
    sweep(FULL, **GRIDS, store=store)
    assert store.read_bytes() == whole[1]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("no/such/sweep.nc", "there is no folder"),
        ("sweep.csv", r"stored as netCDF, \.nc"),
        ("sweep", r"stored as netCDF, \.nc"),
        ("folder.nc", "is a folder|is not the netCDF"),
    ],
)
def test_places_that_cannot_be_written(tmp_path: Path, name: str, message: str) -> None:
    (tmp_path / "folder.nc").mkdir()
    with pytest.raises(rr.OutputError, match=message):
        sweep(FULL, offset=1.0, cycles=3, store=tmp_path / name)


# Other files


@pytest.mark.parametrize(
    ("model", "options", "message"),
    [
        (FULL, {"amplitude": 0.2}, r"amplitude \(0.3 there, 0.2 here\)"),
        (FULL, {"angular_frequency": 7.0}, r"angular_frequency \(8.0 there, 7.0 here\)"),
        (FULL, {"cycles": 5}, r"cycles \(4 there, 5 here\)"),
        (FULL, {"counted": 3}, r"counted \(2 there, 3 here\)"),
        (FULL, {"steps_per_cycle": 12}, r"steps_per_cycle \(10 there, 12 here\)"),
        (FULL, {"offset": [1.0, 2.0]}, r"dimensions \(\{'offset': 11, .* there, \{'offset': 2"),
        (FULL, {"offset": GRIDS["offset"] + 1e-15}, r"offset \(\[0.2, .* there, \[0.2"),
        (FULL, {"offset": (1.0, GRIDS["offset"])}, "dimensions .*offset_leg_2"),
        (FULL, {"amplitude": [0.3]}, "dimensions .*amplitude"),
        (rr.PivotingModel(ROBOT), {}, r"model.type \(full there, pivoting here\)"),
        (rr.FullModel(ROBOT, damping=0.02), {}, r"model.damping.pitch \(0.01 there, 0.02 here\)"),
        (
            rr.FullModel(rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=0.06))),
            {},
            r"parameters.leg_mass \(0.057 there, 0.06 here\); robot.urdf",
        ),
    ],
)
def test_another_sweeps_file_is_refused(
    whole: tuple[xr.Dataset, bytes],
    store: Path,
    model: rr.FullModel,
    options: dict,
    message: str,
) -> None:
    store.write_bytes(whole[1])
    with pytest.raises(rr.OutputError, match=message) as caught:
        sweep(model, **GRIDS | options, store=store)
    assert "holds another sweep. It differs in" in str(caught.value)
    assert len(str(caught.value)) < 1000
    assert store.read_bytes() == whole[1]


def test_another_version_is_refused_where_bits_may_differ(
    store: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep(FULL, offset=1.0, cycles=3, store=store)
    used = sweep_module.versions()
    monkeypatch.setattr(sweep_module, "versions", lambda: used | {"python": "9.9"})
    sweep(FULL, offset=1.0, cycles=3, store=store)
    monkeypatch.setattr(sweep_module, "versions", lambda: used | {"rrrobot": "9.9"})
    with pytest.raises(rr.OutputError, match=r"versions.rrrobot \(.* there, 9.9 here\)"):
        sweep(FULL, offset=1.0, cycles=3, store=store)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"offset,speed\n1,2\n",
        b"CDF\x02",
        b"CDF\x02" + bytes(100),
        b"CDF\x02" + b"\xff" * 400,
        b"\x89HDF\r\n\x1a\n" + bytes(500),
    ],
)
def test_files_that_are_no_sweep(store: Path, content: bytes) -> None:
    store.write_bytes(content)
    with pytest.raises(rr.OutputError, match=r"is not the netCDF file|holds another sweep"):
        sweep(FULL, **GRIDS, store=store)
    assert store.read_bytes() == content


@pytest.mark.parametrize("part", [0.3, 0.9, 0.999])
def test_files_that_are_cut_short(
    whole: tuple[xr.Dataset, bytes], store: Path, part: float
) -> None:
    store.write_bytes(whole[1][: int(part * len(whole[1]))])
    with pytest.raises(rr.OutputError, match="is not the netCDF file of a sweep"):
        sweep(FULL, **GRIDS, store=store)


def test_a_dataset_of_something_else(store: Path) -> None:
    xr.Dataset({"speed": ("offset", [1.0, 2.0])}).to_netcdf(store, engine="scipy")
    with pytest.raises(rr.OutputError, match="is not the netCDF file of a sweep"):
        sweep(FULL, **GRIDS, store=store)


def test_attributes_are_json(whole: tuple[xr.Dataset, bytes]) -> None:
    for name in ("model", "parameters", "robot", "versions"):
        assert isinstance(json.loads(whole[0].attrs[name]), dict)


# Parts


def test_pending_runs() -> None:
    status = np.array([0, -1, -1, -1, -1, 1, -1, -1, 0, -1], dtype=np.int8)
    assert list(pending(status, 100, 100)) == [(1, 5), (6, 8), (9, 10)]
    assert list(pending(status, 100, 3)) == [(1, 4), (4, 5), (6, 8), (9, 10)]
    assert list(pending(status, 5, 100)) == [(1, 5), (6, 8), (9, 10)]
    assert list(pending(status, 2, 100)) == [(1, 2), (2, 4), (4, 5), (6, 8), (9, 10)]
    assert list(pending(np.zeros(4, dtype=np.int8), 4, 4)) == []


def test_curvature_like_a_steady_states() -> None:
    speed = np.array([2.0, 0.0, 0.0, 0.0, np.nan])
    found = curvature(speed, np.array([0.5, 0.3, -0.3, 0.0, np.nan]))
    np.testing.assert_array_equal(found, [0.25, np.inf, -np.inf, 0.0, np.nan])


def test_status_comes_to_the_disk_last(store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[tuple[int, int]] = []
    sync = os.fsync

    def seen(file: int) -> None:
        sync(file)
        if store.exists():
            with xr.open_dataset(store) as ds:
                found.append((int(ds.speed.count()), done(store)))

    monkeypatch.setattr(os, "fsync", seen)
    sweep(FULL, offset=[0.5, 1.0], cycles=3, store=store)
    assert found == [(2, 0), (2, 2)]


# Others


def test_a_store_that_another_run_holds_is_refused(
    whole: tuple[xr.Dataset, bytes], store: Path
) -> None:
    seen: list[str] = []

    def other(done: int, _: int) -> None:
        if done and not seen:
            for resume in (True, False):
                with pytest.raises(rr.OutputError, match="another run is writing") as error:
                    sweep(FULL, **GRIDS, store=store, resume=resume)
                seen.append(str(error.value))

    sweep(FULL, **GRIDS, store=store, chunk=10, progress=other)
    assert len(seen) == 2
    assert store.read_bytes() == whole[1]


@pytest.mark.parametrize("what", ["removed", "replaced"])
def test_a_store_that_is_taken_away_is_noticed_before_the_next_chunk(
    whole: tuple[xr.Dataset, bytes], store: Path, what: str
) -> None:
    def take(done: int, _: int) -> None:
        if done >= 20 and store.exists() and store.read_bytes() != b"mine":
            store.unlink()
            if what == "replaced":
                store.write_bytes(b"mine")

    with pytest.raises(rr.SweepError, match=f"was {what} by another program") as error:
        sweep(FULL, **GRIDS, store=store, chunk=10, threads=1, progress=take)
    kept = error.value.dataset
    assert kept is not None
    computed = kept.status != -1
    assert int(computed.sum()) >= 20
    np.testing.assert_array_equal(kept.speed.where(computed), whole[0].speed.where(computed))
    assert what == "removed" or store.read_bytes() == b"mine"


def test_a_killed_worker_leaves_what_was_finished(
    whole: tuple[xr.Dataset, bytes], store: Path
) -> None:
    with ProcessPoolExecutor(1) as pool:

        def kill(done: int, _: int) -> None:
            for process in pool._processes if done >= 20 else ():
                with suppress(ProcessLookupError):
                    os.kill(process, signal.SIGKILL)

        with pytest.raises(rr.SweepError, match=r"ended at once .*keeps them") as error:
            # One gait a chunk: most are not yet given to the worker when it dies.
            sweep(FULL, **GRIDS, store=store, chunk=1, executor=pool, progress=kill)
    kept = error.value.dataset
    assert kept is not None
    assert 20 <= int((kept.status != -1).sum()) == done(store) < SIZE
    sweep(FULL, **GRIDS, store=store)
    assert store.read_bytes() == whole[1]
