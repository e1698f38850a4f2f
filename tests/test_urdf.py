"""The URDFs that the package writes: shipped files, other readers, reduced versions."""

import itertools
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rrrobot as rr
from rrrobot.robot.reader import parse_urdf, urdf_text
from rrrobot.robot.urdf import CHAINS, main, rrrobot_files
from tests.random_robot import random_urdf
from tests.strategies import examples

FILES = ("rrrobot", *CHAINS)
FOLDER = Path(__file__).parent.parent / "urdf"
UNEQUAL = rr.RRRobotParameters(
    leg_mass=(0.05, 0.08), servo_mass=(0.04, 0.07), leg_length=(0.11, 0.07), hip_offset=0.09
)


def frames(model: pin.Model, positions: dict[str, float]) -> dict[str, np.ndarray]:
    """Homogeneous transform of each link in the world, by Pinocchio."""
    q = pin.neutral(model)
    for name, value in positions.items():
        joint = model.joints[model.getJointId(name)]
        wide = joint.nq == 2
        q[joint.idx_q : joint.idx_q + joint.nq] = (
            (np.cos(value), np.sin(value)) if wide else (value,)
        )
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    bodies = [(i, f.name) for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY]
    return {name: data.oMf[i].homogeneous for i, name in bodies}


def random_positions(model: pin.Model, seed: int) -> dict[str, float]:
    rng = np.random.default_rng(seed)
    return {name: float(rng.uniform(-3, 3)) for name in model.names[1:]}


@pytest.mark.parametrize("name", FILES)
def test_shipped_file_is_what_the_generator_writes(name):
    assert (FOLDER / f"{name}.urdf").read_bytes() == rrrobot_files()[f"{name}.urdf"].encode()
    assert rr.urdf_path(name).read_bytes() == (FOLDER / f"{name}.urdf").read_bytes()


def test_no_other_file_is_shipped(tmp_path):
    assert sorted(p.name for p in FOLDER.iterdir()) == sorted(rrrobot_files())
    main(str(tmp_path))
    for path in FOLDER.iterdir():
        assert (tmp_path / path.name).read_bytes() == path.read_bytes()


def test_default_path_and_unknown_name():
    assert rr.urdf_path() == rr.urdf_path("rrrobot")
    for name in ("roll_over", "", "../urdf/yaw", "yaw.urdf"):
        with pytest.raises(rr.UrdfError, match="it must be one of rrrobot, pivoting, roll"):
            rr.urdf_path(name)


@pytest.mark.parametrize("name", FILES)
def test_yourdfpy_and_pinocchio_put_every_link_in_the_same_place(name):
    yourdfpy = pytest.importorskip("yourdfpy")
    path = rr.urdf_path(name)
    other = yourdfpy.URDF.load(
        str(path), load_meshes=False, build_scene_graph=True,
        load_collision_meshes=False, build_collision_scene_graph=False,
    )  # fmt: skip
    model = pin.buildModelFromUrdf(str(path))
    root = "shell" if name == "rrrobot" else "world"
    assert other.base_link == root
    assert set(other.actuated_joint_names) == set(model.names[1:])
    for seed in range(3):
        positions = random_positions(model, seed)
        other.update_cfg(positions)
        expected = frames(model, positions)
        assert set(expected) == set(other.link_map)
        for link, transform in expected.items():
            found = other.get_transform(link, root)
            np.testing.assert_allclose(found, transform, atol=1e-12, err_msg=link)


@pytest.mark.parametrize("name", FILES)
def test_total_mass_is_table_2s(name):
    model = pin.buildModelFromUrdf(str(rr.urdf_path(name)), pin.JointModelFreeFlyer())
    assert pin.computeTotalMass(model) == pytest.approx(0.52, abs=1e-15)


@pytest.mark.parametrize("p", [rr.RRRobotParameters(), UNEQUAL], ids=["Table 2", "unequal"])
def test_five_points_of_mass_where_the_paper_puts_them(p):
    """Each mass at its place, with no inertia of its own, for several leg angles."""
    model = pin.buildModelFromXML(rr.rrrobot_urdf(p))
    assert list(model.names) == ["universe", "leg_1", "leg_2"]
    masses = {
        e.get("name"): float(mass.get("value", "nan"))
        for e in ET.fromstring(rr.rrrobot_urdf(p)).findall("link")
        if (mass := e.find("inertial/mass")) is not None
    }
    assert masses == {
        "battery": p.battery_mass, "servo_1": p.servo_masses[0], "servo_2": p.servo_masses[1],
        "leg_1_link": p.leg_masses[0], "leg_2_link": p.leg_masses[1],
    }  # fmt: skip
    for angles in ((0.0, 0.0), (np.pi / 2, np.pi / 2), (0.4, -1.2)):
        placed = frames(model, dict(zip(("leg_1", "leg_2"), angles, strict=True)))
        np.testing.assert_allclose(placed["battery"][:3, 3], (0, 0, -p.shell_radius), atol=1e-15)
        for i, (angle, side) in enumerate(zip(angles, (-p.hip_offset, p.hip_offset), strict=True)):
            hip = np.array((0, side, 0))
            np.testing.assert_allclose(placed[f"servo_{i + 1}"][:3, 3], hip, atol=1e-15)
            length = p.leg_lengths[i]
            tip = placed[f"leg_{i + 1}_link"] @ (length, 0, 0, 1)
            expected = hip + length * np.array((np.cos(angle), 0, np.sin(angle)))
            np.testing.assert_allclose(tip[:3], expected, atol=1e-15)
    inertia = [e.attrib for e in ET.fromstring(rr.rrrobot_urdf(p)).iter("inertia")]
    assert len(inertia) == 5
    assert {value for entry in inertia for value in entry.values()} == {"0"}


def test_the_shell_shows_its_rotation():
    """Three bands about three axes, of colours that differ from one another and the shell's."""
    robot = ET.fromstring(rr.rrrobot_urdf())
    colours = {m.get("name"): m.find("color").get("rgba") for m in robot.findall("material")}
    (shell,) = [e for e in robot.findall("link") if e.get("name") == "shell"]
    visuals = {v.find("material").get("name"): v for v in shell.findall("visual")}
    assert set(visuals) == {"shell", "band_x", "band_y", "band_z"}
    assert len({colours[name] for name in visuals}) == 4
    axes = []
    for name in ("band_x", "band_y", "band_z"):
        disc = visuals[name].find("geometry/cylinder")
        assert float(disc.get("radius")) > float(
            visuals["shell"].find("geometry/sphere").get("radius")
        )
        rpy = [float(v) for v in visuals[name].find("origin").get("rpy").split()]
        axes.append(pin.rpy.rpyToMatrix(*rpy)[:, 2])
    np.testing.assert_allclose(np.abs(np.linalg.det(axes)), 1, atol=1e-12)


@pytest.mark.parametrize("kind", CHAINS)
def test_reduced_body_stands_at_the_radius_and_moves_on_its_axes(kind):
    text = rr.robot.reduced_urdf(rr.rrrobot_urdf(), kind, height=0.12)
    model = pin.buildModelFromXML(text)
    free = [name for name, _, _ in CHAINS[kind]]
    assert list(model.names) == ["universe", *free, "leg_1", "leg_2"]
    np.testing.assert_allclose(frames(model, {})["shell"][:3, 3], (0, 0, 0.12), atol=1e-15)
    positions = dict(zip(free, (0.3, -0.5, 0.7), strict=False))
    placed = frames(model, positions)["shell"]
    travel = positions.get("base_travel", 0.0)
    along = {"pitch": (travel, 0, 0.12), "roll": (0, travel, 0.12)}
    np.testing.assert_allclose(placed[:3, 3], along.get(kind, (0, 0, 0.12)), atol=1e-15)
    roll, pitch, yaw = (positions.get(f"base_{axis}", 0.0) for axis in ("roll", "pitch", "yaw"))
    np.testing.assert_allclose(placed[:3, :3], pin.rpy.rpyToMatrix(roll, pitch, yaw), atol=1e-15)


@given(seed=st.integers(0, 1000), kind=st.sampled_from(list(CHAINS)), height=st.floats(-1, 1))
@examples(15)
def test_reduced_version_of_any_tree_moves_as_the_tree_does(seed, kind, height):
    text = random_urdf(seed, joints=6)
    reduced = pin.buildModelFromXML(rr.robot.reduced_urdf(text, kind, height=height))
    whole = pin.buildModelFromXML(text)
    names = [name for name, _, _ in CHAINS[kind]]
    positions = random_positions(whole, seed)
    base = dict(zip(names, (0.3, -0.5, 0.7), strict=False))
    found = frames(reduced, positions | base)
    lift = frames(reduced, base)["base"]
    assert lift[2, 3] == pytest.approx(height, abs=1e-15)
    for link, transform in frames(whole, positions).items():
        np.testing.assert_allclose(found[link], lift @ transform, atol=1e-12, err_msg=link)
    free = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    assert pin.computeTotalMass(reduced) == pytest.approx(pin.computeTotalMass(free), rel=1e-14)


@pytest.mark.parametrize("kind", CHAINS)
def test_reduced_version_of_an_example_robot(kind):
    pytest.importorskip("example_robot_data")
    robot = rr.Robot.from_example("solo12", shell=rr.Sphere(0.2))
    reduced = pin.buildModelFromXML(rr.robot.reduced_urdf(robot.urdf, kind, height=0.2))
    assert reduced.nv == len(CHAINS[kind]) + 12
    assert pin.computeTotalMass(reduced) == pytest.approx(robot.mass, rel=1e-12)
    assert reduced.name == f"{robot.name}_{kind}"


def test_reducing_twice_needs_other_names():
    once = rr.robot.reduced_urdf(rr.rrrobot_urdf(), "yaw", height=0.12)
    with pytest.raises(rr.UrdfError, match=r"already has base_yaw, world: rename"):
        rr.robot.reduced_urdf(once, "yaw")


@pytest.mark.parametrize(
    ("old", "new", "clash"),
    [
        ("battery", "world", "world"),
        ("leg_1", "base_yaw", "base_yaw"),
        ("servo_1", "base_pitch_link", "base_pitch_link"),
    ],
)
def test_name_clashes_are_named(old, new, clash):
    text = rr.rrrobot_urdf().replace(f'"{old}"', f'"{new}"')
    with pytest.raises(rr.UrdfError, match=f"already has {clash}: rename it; the pivoting chain"):
        rr.robot.reduced_urdf(text, "pivoting")


@pytest.mark.parametrize("kind", ["full", "", "Yaw", None, 3])
def test_unknown_kind(kind):
    with pytest.raises(rr.UrdfError, match="it must be one of pivoting, roll, pitch, yaw"):
        rr.robot.reduced_urdf(rr.rrrobot_urdf(), kind)


@pytest.mark.parametrize("height", [np.nan, np.inf, "high", None])
def test_bad_height(height):
    with pytest.raises(rr.ParameterError, match=r"^height is"):
        rr.robot.reduced_urdf(rr.rrrobot_urdf(), "yaw", height=height)


def test_what_is_read_is_written_again_for_every_parser():
    """Pinocchio's parser drops a mass with spaces around it; what was checked it keeps."""
    text = rr.rrrobot_urdf()
    odd = text.replace('value="0.3"', 'value=" 0.3\n"').replace(
        'xyz="0.0 0.0 -0.12"', 'xyz=" 0.0\n\t0.0   -0.12 "'
    )
    assert odd != text
    again = urdf_text(parse_urdf(odd))
    assert 'value="0.3"' in again
    assert 'xyz="0.0 0.0 -0.12"' in again
    models = [
        pin.buildModelFromXML(t, pin.JointModelFreeFlyer())
        for t in (text, again, urdf_text(parse_urdf(again)))
    ]
    for a, b in itertools.pairwise(models):
        assert a.inertias[1].isApprox(b.inertias[1], 1e-15)
    robot = rr.Robot.from_urdf(odd, shell=rr.Sphere(0.12))
    assert robot.mass == pytest.approx(0.52, abs=1e-15)


def test_encoding_declarations_and_byte_order_marks(tmp_path):
    """The text is UTF-8, whatever its first line claims."""
    text = rr.rrrobot_urdf().replace('"shell"', '"Hülle"')
    declarations = [f'<?xml version="1.0" encoding="{e}"?>' for e in ("latin-1", "utf-16", "x")]
    for head in ("", "\ufeff", "\ufeff<?xml version='1.0'?>", *declarations):
        path = tmp_path / "r.urdf"
        path.write_bytes((head + text).encode())
        for source in (path, str(path), head + text):
            robot = rr.Robot.from_urdf(source, shell=rr.Sphere(0.12))
            assert robot.shell_link == "Hülle"
