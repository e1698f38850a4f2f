"""Damaged, stale and hostile stores, caches and meshes: told, healed, never silent, never fatal."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.momentum import cache
from rrrobot.robot.meshes import MeshError, find_mesh, read_mesh

SHELL = rr.Sphere(0.2)
STL = (
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
    "endfacet\nendsolid a\n"
)
INERTIAL = (
    '<inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>'
    "</inertial>"
)


def run_sweep(path):
    model = rr.FullModel(rr.Robot.from_parameters())
    return rr.sweep(model, offset=[0.6, 0.8, 1.0], cycles=4, store=path, progress=False)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    path = tmp_path_factory.mktemp("store") / "s.nc"
    return path, run_sweep(path)


@pytest.mark.parametrize("name", ["speed", "yaw_rate", "clearance", "status", "checksum"])
def test_a_flipped_bit_in_a_store_is_told_and_computed_again(stored, tmp_path, name):
    from rrrobot.studies.sweeps.netcdf import begins

    path = shutil.copy(stored[0], tmp_path / "s.nc")
    with path.open("r+b", buffering=0) as stream:
        at = begins(stream)[name]
        stream.seek(at)
        byte = stream.read(1)[0]
        stream.seek(at)
        stream.write(bytes((byte ^ 4,)))
    with pytest.warns(UserWarning, match="1 of 3 gaits in .* are damaged"):
        again = run_sweep(path)
    assert again.identical(stored[1])
    assert run_sweep(path).identical(stored[1])


@pytest.mark.slow
def test_three_hundred_flipped_bits_never_come_back_as_results(stored, tmp_path):
    rng = np.random.default_rng(0)
    raw = stored[0].read_bytes()
    told = 0
    for _ in range(300):
        damaged = bytearray(raw)
        damaged[rng.integers(len(raw))] ^= 1 << rng.integers(8)
        path = tmp_path / "s.nc"
        path.write_bytes(damaged)
        import warnings

        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                found = run_sweep(path)
            except rr.RRRobotError:
                told += 1
                continue
        told += bool(caught)
        for variable in stored[1].data_vars:
            assert found[variable].equals(stored[1][variable])
    assert told > 100


# The engine's compiled code


def test_the_engines_hash_is_of_all_its_sources(tmp_path, monkeypatch):
    copy = tmp_path / "momentum"
    shutil.copytree(Path(cache.__file__).parent, copy)
    monkeypatch.setattr(cache, "_FOLDER", copy)
    hashes = set()
    for path in sorted(copy.glob("*.py")):
        path.write_text(path.read_text() + "# edited\n")
        cache.engine_hash.cache_clear()
        hashes.add(cache.engine_hash())
    monkeypatch.undo()
    cache.engine_hash.cache_clear()
    assert cache.engine_hash() not in hashes
    assert len(hashes) == len(list(copy.glob("*.py")))


CODE = """
import numpy as np, rrrobot as rr
from rrrobot.momentum.coefficients import coefficients, _fill
out = coefficients(rr.Robot.from_parameters(), np.full((1, 2), 0.5), np.ones((1, 2)))
print(out.sum().hex(), sum(_fill.stats.cache_hits.values()))
"""


def in_process(**environment):
    done = subprocess.run(
        [sys.executable, "-c", CODE], capture_output=True, text=True, check=True,
        env=os.environ | environment, cwd=Path(__file__).parent.parent,
    )  # fmt: skip
    number, hits = done.stdout.split()
    return number, int(hits), done.stderr


@pytest.mark.slow
def test_a_damaged_cache_heals_and_a_whole_one_is_used(tmp_path):
    place = {"NUMBA_CACHE_DIR": str(tmp_path)}
    first = in_process(**place)
    assert first[1] == 0
    assert in_process(**place)[:2] == (first[0], 1)
    rng = np.random.default_rng(0)
    files = [p for p in tmp_path.rglob("*") if p.suffix in (".nbi", ".nbc")]
    assert files
    for path in files:
        raw = bytearray(path.read_bytes())
        for at in rng.integers(len(raw), size=5):
            raw[at] ^= 0x55
        path.write_bytes(raw)
    assert in_process(**place)[:2] == (first[0], 0)
    assert in_process(**place)[:2] == (first[0], 1)


@pytest.mark.parametrize("n", [60, pytest.param(600, marks=pytest.mark.slow)])
def test_damaged_caches_are_read_whole_or_not_at_all(tmp_path, n):
    """Flipped bits, cut ends and files under each other's names, of index and data alike."""
    rng = np.random.default_rng(3)
    whole = {("int64",): list(range(50)), ("float64",): {"code": b"x" * 300}}

    def file():
        return cache._File(str(tmp_path), "f", cache.engine_hash())

    for key, data in whole.items():
        file().save(key, data)
    assert all(file().load(key) == data for key, data in whole.items())
    raw = {path: path.read_bytes() for path in sorted(tmp_path.iterdir())}
    assert len(raw) == 3
    missing = 0
    for k in range(n):
        for path, content in raw.items():
            path.write_bytes(content)
        path = list(raw)[rng.integers(3)]
        damaged = bytearray(raw[path])
        if k % 3 == 0:
            damaged[rng.integers(len(damaged))] ^= 1 << rng.integers(8)
        elif k % 3 == 1:
            del damaged[rng.integers(len(damaged)) :]
        else:
            damaged = raw[list(raw)[rng.integers(3)]]
        path.write_bytes(damaged)
        for key, data in whole.items():
            found = file().load(key)
            assert found is None or found == data
            missing += found is None
            file().save(key, data)
            assert file().load(key) == data
    assert missing > n // 2


def test_without_a_folder_to_write_code_is_kept_for_the_process(monkeypatch):
    monkeypatch.setattr(cache, "_folders", lambda: iter((Path("/proc/none"),)))
    cache.cache_folder.cache_clear()
    with pytest.warns(UserWarning, match="compiled anew in each process"):
        folder = cache.cache_folder()
    cache.cache_folder.cache_clear()
    assert folder.is_dir()


# Meshes


@pytest.mark.parametrize(
    "name",
    ["m/a.stl", "./m/a.stl", "../m/a.stl", "package://pkg/m/a.stl", "model://pkg/m/a.stl"],
)
def test_meshes_are_found_from_the_file(tmp_path, name, recwarn):
    from rrrobot.view.shapes import robot_visuals

    for folder in ("pkg/urdf/m", "pkg/m"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "a.stl").write_text(STL)
    path = tmp_path / "pkg/urdf/r.urdf"
    mesh = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    path.write_text(f'<robot name="r"><link name="b">{INERTIAL}{mesh}</link></robot>')
    visuals = robot_visuals(rr.Robot.from_urdf(path, shell=SHELL))
    assert "b" in [visual.name for visual in visuals]
    assert not recwarn


def test_meshes_are_found_in_ros_package_path_and_by_file_url(tmp_path, monkeypatch):
    (tmp_path / "pkg").mkdir()
    mesh = tmp_path / "pkg" / "a.stl"
    mesh.write_text(STL)
    for entry in (tmp_path, tmp_path / "pkg"):
        monkeypatch.setenv("ROS_PACKAGE_PATH", f"/none:{entry}")
        assert find_mesh("package://pkg/a.stl", ()) == mesh
    assert find_mesh(f"file://{mesh}", ()) == mesh
    with pytest.raises(MeshError, match=r"is none of \.stl, \.obj, \.dae"):
        find_mesh("a.ply", ())
    with pytest.raises(MeshError, match=r"no file's name|is not found"):
        find_mesh("x" * 5000 + ".stl", (str(tmp_path),))


def test_a_collada_that_contains_itself_stops_nothing(tmp_path):
    path = tmp_path / "loop.dae"
    path.write_text(
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" '
        'version="1.4.1"><library_nodes><node id="a"><instance_node url="#a"/></node>'
        '</library_nodes><library_visual_scenes><visual_scene id="s"><node id="r">'
        '<instance_node url="#a"/></node></visual_scene></library_visual_scenes><scene>'
        '<instance_visual_scene url="#s"/></scene></COLLADA>'
    )
    with pytest.raises(MeshError):
        read_mesh(path, (1.0, 1.0, 1.0))


def test_a_missing_mesh_shows_the_collision_shape_or_a_box():
    from rrrobot.view.shapes import robot_visuals

    mesh = '<visual><geometry><mesh filename="none.stl"/></geometry></visual>'
    ball = '<collision><geometry><sphere radius="0.07"/></geometry></collision>'
    for collision, kind in ((ball, "SphereGeometry"), ("", "BoxGeometry")):
        text = f'<robot name="r"><link name="b">{INERTIAL}{mesh}{collision}</link></robot>'
        with pytest.warns(UserWarning, match=r"collision shapes or boxes instead: 'none\.stl'"):
            visuals = robot_visuals(rr.Robot.from_urdf(text, shell=SHELL))
        assert next(v for v in visuals if v.name == "b").geometry["type"] == kind


# Frames


@pytest.mark.parametrize("frame", [-1, 10_000])
def test_a_frame_that_is_not_there_is_refused(frame):
    import pinocchio as pin

    robot = rr.Robot.from_parameters()
    q, v = pin.neutral(robot.model), np.zeros(robot.model.nv)
    for call in (
        lambda: rr.contact_point(robot.model, q, frame, SHELL),
        lambda: rr.contact_jacobian(robot.model, q, frame, SHELL),
        lambda: rr.contact_drift(robot.model, q, v, frame, SHELL),
    ):
        with pytest.raises(rr.ParameterError, match=f"the model has no frame {frame}: it has"):
            call()


# Trajectories


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    model = rr.FullModel(rr.Robot.from_parameters())
    t = rr.simulate(model, rr.gait("lateral"), duration=0.2)
    return t.save(tmp_path_factory.mktemp("t") / "t.npz")


@pytest.mark.parametrize(
    ("name", "change", "says"),
    [
        ("position", lambda a: a * np.nan, "position has values that are not finite"),
        ("energy", lambda a: a + np.inf, "energy has values that are not finite"),
        ("euler", lambda a: a[:-1], "euler has shape"),
        ("leg_angle", lambda a: a.astype(np.float32), "leg_angle has shape .* of float32"),
        ("time", lambda a: a[::-1], "time does not increase"),
    ],
)
def test_trajectories_with_faults_are_refused_by_name(saved, tmp_path, name, change, says):
    with np.load(saved) as archive:
        arrays = dict(archive)
    arrays[name] = change(arrays[name])
    path = tmp_path / "bad.npz"
    np.savez_compressed(path, **arrays)
    with pytest.raises(rr.OutputError, match=says):
        rr.Trajectory.load(path)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("period", "0.8"),
        ("period", -1.0),
        ("period", True),
        ("model", ["full"]),
        ("gait", "lateral"),
        ("has_contact", 1),
        ("integration", {"continuous_memory": "0"}),
        (None, [1, 2]),
    ],
)
def test_metadata_of_other_types_is_refused_by_name(saved, tmp_path, name, value):
    with np.load(saved) as archive:
        arrays = dict(archive)
    header = json.loads(str(arrays["header"]))
    header["metadata"] = value if name is None else header["metadata"] | {name: value}
    arrays["header"] = np.array(json.dumps(header))
    path = tmp_path / "bad.npz"
    np.savez_compressed(path, **arrays)
    what = {"integration": "continuous_memory", None: "no mapping"}.get(name, name)
    with pytest.raises(rr.OutputError, match=what):
        rr.Trajectory.load(path)


def test_a_small_file_may_not_take_gigabytes(saved, tmp_path):
    with np.load(saved) as archive:
        arrays = dict(archive)
    arrays["time"] = np.zeros(20_000_000)
    path = tmp_path / "bomb.npz"
    np.savez_compressed(path, **arrays)
    with pytest.raises(rr.OutputError, match="would unpack to"):
        rr.Trajectory.load(path)


@pytest.mark.slow
def test_three_hundred_damaged_trajectories_are_read_whole_or_refused(saved, tmp_path):
    rng = np.random.default_rng(1)
    raw, whole = saved.read_bytes(), rr.Trajectory.load(saved)
    for k in range(300):
        damaged = bytearray(raw)
        for at in rng.integers(len(raw), size=rng.integers(1, 4)):
            damaged[at] ^= 1 << rng.integers(8)
        if k % 3 == 2:
            del damaged[rng.integers(len(raw)) :]
        path = tmp_path / "d.npz"
        path.write_bytes(damaged)
        try:
            found = rr.Trajectory.load(path)
        except rr.OutputError:
            continue
        assert np.array_equal(found.position, whole.position)


# Robot files


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("part", range(4))
def test_two_thousand_mutated_files_are_read_or_refused(part, capfd):
    import random

    from tests.test_urdf_bad import mutated_text, mutated_tree, read_or_refuse

    seeds = range(1000 + 250 * part, 1250 + 250 * part)
    read = [
        read_or_refuse(mutate(random.Random(s)))
        for s in seeds
        for mutate in (mutated_text, mutated_tree)
    ]
    capfd.readouterr()
    assert 50 < sum(read) < len(read)
