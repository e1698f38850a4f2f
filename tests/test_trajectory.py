"""The result object: friction, lift-off, saving and loading exactly, damaged files."""

import json
import pickle
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rrrobot as rr
from rrrobot.simulation.trajectory import FORMAT
from tests import synthetic
from tests.strategies import examples

ARRAYS = ("time", "euler", "euler_rates", "position", "leg_angle", "leg_rate", "contact_force",
          "leg_torque", "energy", "slip", "height_error", "configuration", "velocity",
          "state")  # fmt: skip


@pytest.fixture(scope="module")
def simulated() -> rr.Trajectory:
    model = rr.FullModel(rr.Robot.from_parameters(), ground=rr.Plane((0.01, 0.0, 1.0)))
    return rr.simulate(model, rr.gait("circular"), duration=0.5)


@pytest.fixture(scope="module")
def saved(simulated: rr.Trajectory, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulated.save(tmp_path_factory.mktemp("saved") / "t.npz")


def assert_same(a: rr.Trajectory, b: rr.Trajectory) -> None:
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
        assert getattr(a, name).dtype == getattr(b, name).dtype
    assert a.robot == b.robot
    assert a.ground == b.ground
    assert a.metadata == b.metadata


def test_round_trip_is_exact(simulated, saved):
    loaded = rr.Trajectory.load(str(saved))
    assert_same(loaded, simulated)
    assert repr(loaded) == repr(simulated)
    assert loaded.model_name == "full"
    assert loaded.period == rr.gait("circular").period


def test_loaded_trajectory_can_be_continued(simulated, saved):
    loaded = rr.Trajectory.load(saved)
    gait = rr.gait("circular")
    runs = [
        rr.simulate(rr.FullModel(t.robot, ground=t.ground), gait, duration=0.2, state=t.final_state)
        for t in (simulated, loaded)
    ]
    np.testing.assert_array_equal(runs[0].state, runs[1].state)


@pytest.mark.parametrize(
    "robot",
    [
        rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=(0.05, 0.08))),
        rr.Robot.from_urdf(
            rr.urdf_path(), shell=rr.Ellipsoid((0.12, 0.13, 0.14)), legs=("leg_2",),
            locked={"leg_1": 0.1}, shell_center=(0.01, 0, 0),
        ),
    ],
    ids=["unequal legs", "ellipsoid, one leg locked"],
)  # fmt: skip
def test_round_trip_of_other_robots(tmp_path, robot):
    t = rr.simulate(rr.FullModel(robot), rr.StillLegs(1.5, n_legs=robot.n_legs), duration=0.1)
    assert_same(rr.Trajectory.load(t.save(tmp_path / "t.npz")), t)


def test_names_and_notes_of_any_script(tmp_path):
    odd = {"notes": "Läufe \u2207 \x00 \\ '\"", "nested": {"list": [1, None, True, 0.1]}}
    t = synthetic.trajectory(metadata=odd)
    assert rr.Trajectory.load(t.save(tmp_path / "ö t.npz")).metadata == odd


def test_two_saves_are_one_file(tmp_path, simulated):
    simulated.save(tmp_path / "t.npz")
    simulated.save(tmp_path / "t.npz")
    assert [p.name for p in tmp_path.iterdir()] == ["t.npz"]


@pytest.mark.parametrize("name", ["t", "t.csv", "t.npz.txt", ""])
def test_name_must_end_in_npz(tmp_path, simulated, name):
    with pytest.raises(rr.OutputError, match=r"ends in \.npz"):
        simulated.save(tmp_path / name)


def test_metadata_that_is_not_plain_leaves_the_old_file(tmp_path, simulated):
    path = simulated.save(tmp_path / "t.npz")
    before = path.read_bytes()
    with pytest.raises(rr.OutputError, match="metadata is not plain data"):
        synthetic.trajectory(metadata={"array": np.zeros(2)}).save(path)
    assert path.read_bytes() == before


def refused(path: Path, says: str = "is not a trajectory that rrrobot saved") -> None:
    with pytest.raises(rr.OutputError) as caught:
        rr.Trajectory.load(path)
    assert says in str(caught.value)
    assert repr(str(path)) in str(caught.value)
    assert isinstance(caught.value, OSError)


def test_missing_file(tmp_path):
    refused(tmp_path / "none.npz", "there is no file")


def test_folder(tmp_path):
    refused(tmp_path)


def text_file(path: Path) -> None:
    path.write_text("time,roll\n0,0\n")


def empty_file(path: Path) -> None:
    path.touch()


def empty_zip(path: Path) -> None:
    zipfile.ZipFile(path, "w").close()


def one_array(path: Path) -> None:
    with path.open("wb") as stream:
        np.save(stream, np.zeros(3))


def foreign_archive(path: Path) -> None:
    np.savez(path, x=np.zeros(3))


def plain_pickle(path: Path) -> None:
    path.write_bytes(pickle.dumps({"time": [0.0]}))


@pytest.mark.parametrize(
    "write", [text_file, empty_file, empty_zip, one_array, foreign_archive, plain_pickle]
)
def test_foreign_files(tmp_path, write: Callable[[Path], None]):
    write(tmp_path / "t.npz")
    refused(tmp_path / "t.npz")


class Trap:
    """Unpickling this would be noticed."""

    def __reduce__(self) -> tuple[Any, ...]:
        return (pytest.fail, ("a pickle from a file was loaded",))


@pytest.mark.parametrize("name", ["header", "time", "state"])
def test_pickles_inside_are_not_loaded(tmp_path, simulated, saved, name):
    parts = contents(saved) | {name: np.array([Trap()] * len(simulated), dtype=object)}
    np.savez(tmp_path / "t.npz", **parts)
    refused(tmp_path / "t.npz", "Object arrays cannot be loaded")


def contents(path: Path) -> dict[str, Any]:
    with np.load(path) as archive:
        return dict(archive)


def header(path: Path, change: Callable[[dict[str, Any]], Any]) -> np.ndarray:
    data = json.loads(str(contents(path)["header"]))
    return np.array(json.dumps(change(data)))


BAD_HEADERS: dict[str, Callable[[dict[str, Any]], Any]] = {
    "a list": lambda h: [h],
    "other format": lambda h: h | {"format": "rrrobot trajectory 99"},
    "no format": lambda h: {k: v for k, v in h.items() if k != "format"},
    "no robot": lambda h: {k: v for k, v in h.items() if k != "robot"},
    "no metadata": lambda h: {k: v for k, v in h.items() if k != "metadata"},
    "metadata a number": lambda h: h | {"metadata": 3},
    "robot a string": lambda h: h | {"robot": "solo12"},
    "no shell": lambda h: h | {"robot": {k: v for k, v in h["robot"].items() if k != "shell"}},
    "unknown shell": lambda h: h | {"robot": h["robot"] | {"shell": {"type": "cube"}}},
    "no radius": lambda h: h | {"robot": h["robot"] | {"shell": {"type": "sphere"}}},
    "extra field": lambda h: h | {"robot": h["robot"] | {"colour": "red"}},
    "bad urdf": lambda h: h | {"robot": h["robot"] | {"urdf": "<robot name='a'/>"}},
    "urdf a number": lambda h: h | {"robot": h["robot"] | {"urdf": 3}},
    "other legs": lambda h: h | {"robot": h["robot"] | {"legs": ["leg_1", "leg_9"]}},
}


@pytest.mark.parametrize("name", BAD_HEADERS)
def test_bad_headers(tmp_path, saved, name):
    parts = contents(saved) | {"header": header(saved, BAD_HEADERS[name])}
    np.savez(tmp_path / "t.npz", **parts)
    refused(tmp_path / "t.npz")


def test_other_format_is_named(tmp_path, saved):
    parts = contents(saved) | {"header": header(saved, BAD_HEADERS["other format"])}
    np.savez(tmp_path / "t.npz", **parts)
    refused(tmp_path / "t.npz", f"'rrrobot trajectory 99', and this version reads {FORMAT!r}")


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, "NaN"])
def test_header_that_is_no_json(tmp_path, saved, text):
    np.savez(tmp_path / "t.npz", **(contents(saved) | {"header": np.array(text)}))
    refused(tmp_path / "t.npz")


BAD_ARRAYS: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {
    "missing": lambda p: {k: v for k, v in p.items() if k != "energy"},
    "shorter": lambda p: p | {"energy": p["energy"][:-1]},
    "narrower": lambda p: p | {"euler": p["euler"][:, :2]},
    "for other legs": lambda p: p | {"leg_angle": np.zeros((len(p["time"]), 3))},
    "no samples": lambda p: {k: v[:0] if k in ARRAYS else v for k, v in p.items()},
    "text": lambda p: p | {"energy": p["energy"].astype(str)},
    "complex": lambda p: p | {"slip": p["slip"].astype(complex)},
    "a number": lambda p: p | {"state": np.float64(3)},
    "no time": lambda p: p | {"time": np.float64(3)},
}


@pytest.mark.parametrize("name", BAD_ARRAYS)
def test_arrays_that_do_not_fit(tmp_path, saved, name):
    np.savez(tmp_path / "t.npz", **BAD_ARRAYS[name](contents(saved)))
    refused(tmp_path / "t.npz")


@given(data=st.data())
@examples(60)
def test_damaged_bytes_are_refused_or_harmless(saved, tmp_path_factory, data):
    """Any byte changed, or the end cut off: an OutputError, or the very same trajectory."""
    raw = bytearray(saved.read_bytes())
    if data.draw(st.booleans()):
        del raw[data.draw(st.integers(0, len(raw) - 1)) :]
    else:
        for _ in range(data.draw(st.integers(1, 3))):
            raw[data.draw(st.integers(0, len(raw) - 1))] ^= data.draw(st.integers(1, 255))
    path = tmp_path_factory.getbasetemp() / "damaged.npz"
    path.write_bytes(raw)
    try:
        loaded = rr.Trajectory.load(path)
    except rr.OutputError:
        return
    assert_same(loaded, rr.Trajectory.load(saved))


def test_an_archive_that_is_encrypted_or_unknown(tmp_path, saved):
    """The flag and the method of a zip entry that Python's reader does not know."""
    for offset, value in ((6, 1), (8, 99)):
        raw = bytearray(saved.read_bytes())
        raw[offset] = value
        central = raw.index(b"PK\x01\x02")
        raw[central + offset + 2] = value
        path = tmp_path / f"{offset}.npz"
        path.write_bytes(raw)
        refused(path)


def test_required_friction():
    force = np.array([(3.0, 4.0, 10.0), (0, 0, 5), (1, 0, 0), (1, 0, -2), (0, 0, 0)])
    t = synthetic.trajectory(5, contact_force=force)
    np.testing.assert_allclose(t.required_friction, (0.5, 0, np.inf, np.inf, np.inf))
    np.testing.assert_array_equal(t.normal_force, force[:, 2])


def test_required_friction_on_an_incline_is_its_slope():
    """A weight that the ground holds still needs the tangent of the slope."""
    weight = np.tile((0.0, 0.0, 5.0), (3, 1))
    t = synthetic.trajectory(3, contact_force=weight, ground=rr.Plane((-0.3, 0.4, 1.0)))
    np.testing.assert_allclose(t.required_friction, 0.5, rtol=1e-14)
    np.testing.assert_allclose(t.normal_force, 5 / np.sqrt(1.25), rtol=1e-14)


def test_lift_off_time():
    normal = np.array((5.0, 1.0, 0.0, 3.0, -1.0))
    force = np.column_stack((0 * normal, 0 * normal, normal))
    t = synthetic.trajectory(5, duration=4.0, contact_force=force)
    assert t.lift_off_time == 2.0
    assert "LIFTS OFF at 2 s" in repr(t)
    staying = replace(t, contact_force=force + np.array((0, 0, 2)))
    assert staying.lift_off_time is None
    assert "LIFTS OFF" not in repr(staying)


def test_a_pivot_does_not_slip_or_lift_off():
    force = np.tile((1.0, 0, -5.0), (50, 1))
    metadata = {"has_contact": False, "model": {"type": "pivoting"}}
    t = synthetic.trajectory(contact_force=force, metadata=metadata)
    assert t.lift_off_time is None
    with pytest.raises(rr.ModelError, match="pivoting model is pivoted"):
        _ = t.required_friction


def test_repr_and_length():
    position = np.array([(0, 0), (0.03, 0.04), (0.03, 0.0)], dtype=float)
    up = np.tile((0.0, 0.0, 5.0), (3, 1))
    t = synthetic.trajectory(3, duration=2.5, position=position, contact_force=up)
    assert repr(t) == (
        "Trajectory(unknown model of rrrobot, 3 samples, 0 .. 2.5 s, contact travelled 9 cm)"
    )
    assert len(t) == 3
    assert t.period is None


def test_pickles_in_memory(simulated):
    assert_same(pickle.loads(pickle.dumps(simulated)), simulated)
