"""The viewer: films and live pages, looked at with a headless browser."""

from __future__ import annotations

import os
import re
import signal
import socket
import struct
import subprocess
import sys
import time
import urllib.error
import urllib.request
import warnings
from dataclasses import replace
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from rrrobot.view.film import make_film
from rrrobot.view.films import record
from rrrobot.view.scene import Scene
from rrrobot.view.server import MOST_CONNECTIONS, _key, _put, pack
from rrrobot.view.shapes import robot_visuals
from rrrobot.view.viewer import Viewer
from tests.browser import Browser, find_browser
from tests.some import some

SIZE = (320, 180)

needs_browser = pytest.mark.skipif(find_browser() is None, reason="no Chromium or Chrome")
needs_proc = pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="no /proc/net/tcp")


@pytest.fixture(scope="module")
def trajectory():
    model = rr.FullModel(rr.Robot.from_parameters())
    return rr.simulate(model, rr.gait("circular"), duration=10.0, method="momentum")


@pytest.fixture(scope="module")
def browser():
    with Browser(SIZE) as opened:
        yield opened


@pytest.fixture(scope="module")
def film(trajectory, tmp_path_factory):
    return record(trajectory, tmp_path_factory.mktemp("film") / "circular.html")


def change(a, b):
    """Share of the pixels that differ visibly."""
    return float((np.abs(a - b).max(axis=-1) > 25).mean())


def trace_pixels(picture):
    red, green, blue = np.moveaxis(picture, -1, 0)
    return int(((red > 150) & (green < 90) & (blue > 40) & (blue < 130)).sum())


def node(*path):
    return f"viewer.scene_tree.find({list(path)}).object"


def stands_at(configuration):
    place, turn = configuration[:3].tolist(), configuration[3:7].tolist()
    body = node("world", "robot", "1 root_joint")
    return (
        f"{body}.position.distanceTo(new MeshCat.THREE.Vector3(...{place})) < 1e-6"
        f" && {body}.quaternion.angleTo(new MeshCat.THREE.Quaternion(...{turn})) < 1e-4"
    )


# --- the film, seen ---------------------------------------------------------------------------


@needs_browser
def test_film_is_seen_to_move(browser, film):
    browser.open(film.as_uri())
    pictures = []
    for t in (0.0, 0.4, 6.0):
        browser.seek(t)
        pictures.append(browser.picture())
    assert pictures[0].shape == (SIZE[1], SIZE[0], 3)
    assert pictures[0].std() > 20  # not blank
    assert change(pictures[0], pictures[1]) > 0.03
    assert change(pictures[0], pictures[2]) > 0.03
    browser.seek(0.0)
    assert change(pictures[0], browser.picture()) < 0.001  # the camera did not move
    assert browser.problems == []


@pytest.mark.slow
@needs_browser
def test_film_plays_by_itself_and_over_again(browser, film):
    browser.open(film.as_uri())
    before = browser.picture()
    browser.wait_for("viewer.animator.time > 0.3")
    assert change(before, browser.picture()) > 0.01
    browser.run("viewer.animator.seek(viewer.animator.duration - 0.1)")
    browser.wait_for("viewer.animator.time < 1 && viewer.animator.playing")
    assert browser.run("viewer.animator.duration") == pytest.approx(10.0)


@needs_browser
def test_film_needs_no_network(browser, film):
    browser.open(film.as_uri())
    browser.seek(1.0)
    others = [url for url in browser.requests if not url.startswith("data:")]
    assert others == [film.as_uri()]
    text = film.read_text()
    assert not re.search(r"""(src|href|url)\s*[=(]\s*["']?(https?:)?//""", text)
    # The page forbids itself any connection, whatever its scripts may try.
    assert "default-src 'none'; connect-src 'none'" in text
    with pytest.raises(RuntimeError, match=r"(?i)network|denied|violat"):
        browser.run("(() => {const x = new XMLHttpRequest();"
                    "x.open('GET', 'http://127.0.0.1:9/', false); x.send()})()")  # fmt: skip


@needs_browser
def test_browser_places_the_robot_where_pinocchio_does(browser, film, trajectory):
    browser.open(film.as_uri())
    model, data = trajectory.robot.model, trajectory.robot.model.createData()
    for t in (0.0, 2.5, 10.0):
        browser.seek(t)
        q = trajectory.configuration[round(t / 0.01)]
        pin.forwardKinematics(model, data, q)
        for joint in (1, 2, 3):
            at = node("world", "robot", f"{joint} {model.names[joint]}")
            place = browser.run(f"{at}.position.toArray()")
            turn = pin.Quaternion(np.array(browser.run(f"{at}.quaternion.toArray()"))).matrix()
            np.testing.assert_allclose(place, data.oMi[joint].translation, atol=1e-6)
            np.testing.assert_allclose(turn, data.oMi[joint].rotation, atol=1e-5)


@pytest.mark.slow
@needs_browser
def test_trace_grows_or_is_whole_or_absent(browser, trajectory, tmp_path):
    count = f"{node('world', 'ground', 'trace', '<object>')}.geometry.drawRange.count"
    browser.open(record(trajectory, tmp_path / "grows.html", axes=False).as_uri())
    counts = []
    for t in (0.0, 5.0, 10.0):
        browser.seek(t)
        counts.append(browser.run(count))
    path = make_film(trajectory, fps=30, speed=1, detail=Scene(trajectory.robot).detail).path
    assert counts[0] == 0 < counts[1] < counts[2] == 6 * (len(path) - 1)
    # The robot hides its trace from most sides; without it, all of the trace is seen.
    hide = f"{node('world', 'robot')}.visible = false"
    browser.run(hide)
    grown = trace_pixels(browser.picture())
    browser.seek(0.0)
    assert grown > 100 and trace_pixels(browser.picture()) == 0

    browser.open(record(trajectory, tmp_path / "whole.html", axes=False, trace="whole").as_uri())
    browser.seek(0.0)
    browser.run(hide)
    assert trace_pixels(browser.picture()) == pytest.approx(grown, rel=0.05)
    browser.open(record(trajectory, tmp_path / "none.html", axes=False, trace=False).as_uri())
    browser.seek(9.0)
    browser.run(hide)
    assert trace_pixels(browser.picture()) == 0
    assert browser.problems == []


@needs_browser
@pytest.mark.parametrize("follow", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_robot_is_in_the_picture_all_the_way(browser, follow, tmp_path):
    robot, slope = rr.Robot.from_parameters(), rr.Plane((0.1, -0.06, 1.0))
    down = rr.simulate(rr.FullModel(robot, ground=slope), rr.gait("circular"), duration=3.0)
    # Off it slides, straight across the slope.
    shift = np.outer(down.time, (1.5, 2.0))
    q = down.configuration.copy()
    q[:, :3] += shift @ slope.basis[:, :2].T
    down = replace(down, configuration=q, position=down.position + shift)
    browser.open(record(down, tmp_path / "down.html", follow=follow).as_uri())
    scene = Scene(robot, slope)
    for t in (0.0, 1.5, 3.0):
        browser.seek(t)
        center = scene.pose(down.configuration[round(t / 0.01)]).center
        ends = center + 0.15 * np.vstack((np.eye(3), -np.eye(3)))
        seen = browser.run(
            f"(() => {{const world = {node('world')}; world.updateWorldMatrix(true, false);"
            f"return {ends.tolist()}.map(p => new MeshCat.THREE.Vector3(...p)"
            ".applyMatrix4(world.matrixWorld).project(viewer.camera).toArray())})()"
        )
        assert np.abs(np.array(seen)[:, :2]).max() < 1.0
        if follow:
            assert np.abs(np.array(seen)[:, :2].mean(axis=0)).max() < 0.05
    assert browser.problems == []


@pytest.mark.slow
@needs_browser
@pytest.mark.filterwarnings("ignore:the viewer")
def test_any_robot_is_drawn(browser, tmp_path):
    robot = odd_robot(tmp_path)
    gait = rr.SinusoidalGait(offset=(0.0,), amplitude=(1.0,), angular_frequency=5.0, phase=(0.0,))
    t = rr.simulate(rr.FullModel(robot), gait, duration=1.0)
    browser.open(record(t, tmp_path / "odd.html").as_uri())
    browser.seek(0.0)
    first = browser.picture()
    browser.seek(0.6)
    assert browser.problems == []
    assert change(first, browser.picture()) > 0.01
    # Each visual has been made into a mesh with triangles.
    names = [f"{i} {v.name}" for i, v in enumerate(robot_visuals(robot)) if v.joint == 1]
    for name in names:
        shape = node("world", "robot", "1 root_joint", name, "<object>") + ".geometry"
        assert browser.run(f"{shape}.attributes.position.count") > 2


# --- the film, as a file ----------------------------------------------------------------------


def test_film_is_small_and_the_same_each_time(trajectory, film, tmp_path):
    assert record(trajectory, tmp_path / "again.html").read_bytes() == film.read_bytes()
    long = record(trajectory, tmp_path / "long.html", fps=180.0)  # 1,800 frames
    assert long.stat().st_size < 3e6


def test_film_is_written_whole_or_not_at_all(trajectory, tmp_path, monkeypatch):
    target = tmp_path / "film.html"
    target.write_text("before")

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(rr.OutputError, match="No space left"):
        record(trajectory, target)
    assert target.read_text() == "before"
    assert os.listdir(tmp_path) == ["film.html"]


@pytest.mark.parametrize(
    ("name", "options", "error", "words"),
    [
        ("a.html", {"fps": 0}, rr.ParameterError, "fps is 0"),
        ("a.html", {"fps": float("nan")}, rr.ParameterError, "fps"),
        ("a.html", {"speed": -1.0}, rr.ParameterError, "speed is -1"),
        ("a.html", {"fps": 1e9}, rr.ParameterError, "frames: the limit"),
        ("a.html", {"trace": "half"}, rr.ParameterError, "'whole'"),
        ("a.avi", {}, rr.OutputError, "ends in .html"),
        ("missing/a.html", {}, rr.OutputError, "there is no folder"),
    ],
)
def test_record_refuses(trajectory, tmp_path, name, options, error, words):
    with pytest.raises(error, match=words):
        record(trajectory, tmp_path / name, **options)
    assert os.listdir(tmp_path) == []


def test_a_single_sample_is_a_still_picture(trajectory, tmp_path):
    arrays = [k for k, v in vars(trajectory).items() if isinstance(v, np.ndarray)]
    still = replace(trajectory, **{name: getattr(trajectory, name)[:1] for name in arrays})
    assert record(still, tmp_path / "still.html").stat().st_size > 1e5


def test_names_cannot_become_script(tmp_path):
    hostile = "</script><script>alert(1)</script>"
    escaped = hostile.replace("<", "&lt;")
    urdf = rr.rrrobot_urdf().replace('name="rrrobot"', f'name="{escaped}"')
    robot = rr.Robot.from_urdf(urdf, shell=rr.Sphere(0.12))
    assert robot.name == hostile
    t = rr.simulate(rr.FullModel(robot), rr.gait("circular"), duration=0.1)
    assert "alert(1)</script>" not in record(t, tmp_path / "a.html").read_text()


@pytest.mark.parametrize(("fps", "speed", "frames"), [(30, 1, 301), (7, 3, 24), (500, 1, 5001)])
def test_frames_are_the_motion_at_their_time(trajectory, fps, speed, frames):
    made = make_film(trajectory, fps=fps, speed=speed, detail=0.002)
    assert len(made.configuration) == len(made.reached) == frames
    assert (frames - 1) / made.fps == pytest.approx(10.0 / speed)
    at = np.linspace(0.0, 10.0, frames)
    legs = np.array([np.interp(at, trajectory.time, leg) for leg in trajectory.leg_angle.T]).T
    np.testing.assert_allclose(made.configuration[:, 7:], legs, atol=1e-12)
    np.testing.assert_allclose(made.configuration[-1], trajectory.configuration[-1], atol=1e-14)
    gaps = np.linalg.norm(np.diff(made.path, axis=0), axis=1)
    assert gaps.min() > 0.002 and made.reached[0] == 1 and made.reached[-1] == len(made.path)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.1, -0.2, 1.0)])
@pytest.mark.parametrize("shell", [rr.Sphere(0.12), rr.Ellipsoid((0.15, 0.12, 0.13))])
def test_contact_point_is_the_trajectorys(normal, shell):
    robot = rr.Robot.from_urdf(rr.urdf_path("rrrobot"), shell=shell)
    ground = rr.Plane(normal)
    t = rr.simulate(rr.FullModel(robot, ground=ground), rr.gait("circular"), duration=0.5)
    scene = Scene(robot, ground)
    contacts = [scene.pose(q).contact for q in t.configuration]
    np.testing.assert_allclose(contacts, t.position, atol=1e-9)
    np.testing.assert_allclose(scene.rest().contact, 0.0, atol=1e-12)


def grounds():
    return {
        "boulder": rr.Boulder(0.5),
        "bowl": rr.Boulder(-0.9),
        "graph": rr.Graph(
            lambda x, y: 0.05 * x * x - 0.1 * x * y + 0.02,
            lambda x, y: (0.1 * x - 0.1 * y, -0.1 * x),
            lambda x, y: ((0.1, -0.1), (-0.1, 0.0)),
        ),
    }


@pytest.mark.parametrize("name", ["boulder", "bowl", "graph"])
def test_curved_ground_is_drawn_where_the_robot_touches_it(name, tmp_path):
    ground = grounds()[name]
    model = rr.FullModel(rr.Robot.from_parameters(), ground=ground)
    t = rr.simulate(model, rr.gait("circular"), duration=0.5)
    scene = Scene(t.robot, ground)
    contacts = np.array([scene.pose(q).contact for q in t.configuration])
    np.testing.assert_allclose(contacts, t.position, atol=1e-9)
    np.testing.assert_allclose(scene.rest().contact, 0.0, atol=1e-12)
    centers = np.array([scene.pose(q).center for q in t.configuration])
    floor, grid = scene.stage(centers, scene.view(centers))[:2]
    vertices = floor["object"]["geometries"][0]["data"]["attributes"]["position"]["array"]
    for point in vertices.reshape(-1, 3)[::7]:
        assert abs(ground.distance(point.astype(float))) < 1e-6
    lines = grid["object"]["geometries"][0]["data"]["attributes"]["position"]["array"]
    assert len(lines) % 6 == 0 and np.all(np.isfinite(lines))
    assert record(t, tmp_path / "rock.html").stat().st_size > 1e5


# --- the robot's looks ------------------------------------------------------------------------


def odd_robot(folder):
    """Every kind of visual, two of them missing; a joint held still."""
    corners = np.array(
        [[(0, 0, 0), (0.3, 0, 0), (0, 0.3, 0)], [(0, 0, 0), (0, 0.3, 0), (0, 0, 0.3)]]
    )
    triangles = b"".join(
        struct.pack("<12fH", 0, 0, 0, *c.ravel(), 0) for c in corners.astype(float)
    )
    (folder / "wing").mkdir()
    (folder / "wing" / "a.stl").write_bytes(bytes(80) + struct.pack("<I", 2) + triangles)
    (folder / "wing" / "b.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    inertial = (
        '<inertial><origin xyz="{}"/><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" '
        'ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    shapes = (
        '<capsule radius="0.2" length="0.4"/>',
        '<cylinder radius="0.1" length="0.5"/>',
        '<mesh filename="package://wing/a.stl" scale="2 -2 2"/>',
        f'<mesh filename="{folder}/wing/b.obj"/>',
        '<mesh filename="package://wing/lost.stl"/>',
        '<mesh filename="package://wing/odd.xyz"/>',
    )
    visuals = "".join(f"<visual><geometry>{shape}</geometry></visual>" for shape in shapes)
    text = f"""<robot name="odd" version="1.1">
    <material name="red"><color rgba="1 0 0 1"/></material>
    <link name="body">{inertial.format("0 0 -0.2")}{visuals}</link>
    <link name="arm">{inertial.format("0 0 0")}<visual><origin xyz="0 0 0.1" rpy="0 0 1"/>
      <geometry><box size="0.1 0.2 0.3"/></geometry><material name="red"/></visual></link>
    <link name="leg">{inertial.format("0 0 0.3")}</link>
    <joint name="held" type="revolute"><parent link="body"/><child link="arm"/>
      <origin xyz="0 0.5 0"/><axis xyz="0 0 1"/>
      <limit lower="-9" upper="9" effort="9" velocity="9"/></joint>
    <joint name="hip" type="continuous"><parent link="body"/><child link="leg"/>
      <axis xyz="0 1 0"/></joint></robot>"""
    return rr.Robot.from_urdf(
        text, shell=rr.Sphere(0.6), legs=["hip"], locked={"held": 0.5}, package_dirs=[folder]
    )


@pytest.fixture
def odd(tmp_path):
    robot = odd_robot(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return robot_visuals(robot)


def test_missing_meshes_are_named_in_one_warning(tmp_path):
    with pytest.warns(UserWarning) as caught:
        robot_visuals(odd_robot(tmp_path))
    assert len(caught) == 1
    assert "lost.stl' is not found" in str(caught[0].message)
    assert "odd.xyz' is none of .stl, .obj, .dae" in str(caught[0].message)


def test_every_kind_of_visual(odd):
    kinds = [
        visual.geometry["type"] for visual in odd if not visual.name.startswith(("shell", "b_"))
    ]
    assert kinds[:5] == [
        *["BufferGeometry", "CylinderGeometry"],
        *["BufferGeometry"] * 2,
        "BoxGeometry",
    ]
    capsule = points(odd[0])
    tube = np.linalg.norm(capsule - np.clip(capsule, (0, 0, -0.2), (0, 0, 0.2)), axis=1)
    np.testing.assert_allclose(tube, 0.2, atol=1e-6)
    np.testing.assert_allclose(np.ptp(points(odd[2]), axis=0), 0.6, atol=1e-6)  # scaled mesh
    assert points(odd[2]).min() == pytest.approx(-0.6)
    np.testing.assert_allclose(points(odd[3]).max(axis=0), (1, 1, 0), atol=1e-6)


def test_held_joint_and_colour(odd):
    box = next(visual for visual in odd if visual.name == "arm")
    turn = pin.rpy.rpyToMatrix(0, 0, 0.5)
    expected = pin.SE3(turn, np.array((0, 0.5, 0))) * pin.SE3(
        pin.rpy.rpyToMatrix(0, 0, 1), np.array((0, 0, 0.1))
    )
    assert box.joint == 1 and box.placement.isApprox(expected, 1e-9)
    assert box.colour == (1.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(("shell", "drawn"), [
    (rr.Sphere(0.12), 0), (rr.Sphere(0.2), 4), (rr.Ellipsoid((0.15, 0.12, 0.13)), 4),
])  # fmt: skip
def test_a_shell_that_the_urdf_lacks_is_drawn(shell, drawn):
    robot = rr.Robot.from_urdf(rr.urdf_path("rrrobot"), shell=shell)
    ours = [v for v in robot_visuals(robot) if v.geometry["type"] == "BufferGeometry"]
    assert len(ours) == drawn
    if drawn:
        semi_axes = getattr(shell, "semi_axes", 3 * [getattr(shell, "radius", 0)])
        on_it = np.linalg.norm(points(ours[0]) / semi_axes, axis=1)
        np.testing.assert_allclose(on_it, 1.0, atol=1e-6)
        assert ours[0].colour[3] < 1 < np.linalg.norm(points(ours[1]) / semi_axes, axis=1).min()
        assert ours[0].reach == pytest.approx(max(semi_axes))


def points(visual):
    return visual.geometry["data"]["attributes"]["position"]["array"].reshape(-1, 3)


# --- the live page ----------------------------------------------------------------------------


@needs_browser
def test_live_robot_is_seen_to_move(browser, trajectory, capfd):
    with Viewer(trajectory.robot) as viewer:
        viewer.show(trajectory.configuration[0])
        assert not viewer.wait_for_browser(0.0)
        browser.open(viewer.url)
        assert viewer.wait_for_browser(10.0)
        pictures = []
        for i in (0, 40, 900):
            viewer.show(trajectory.configuration[i])
            browser.wait_for(stands_at(trajectory.configuration[i]))
            pictures.append(browser.picture())
        assert pictures[0].std() > 20
        assert change(pictures[0], pictures[1]) > 0.03
        assert change(pictures[1], pictures[2]) > 0.03

        viewer.show_axes(False)
        browser.wait_for(f"!{node('world', 'axes')}.visible")
        browser.open(viewer.url)  # a page opened late shows the same
        browser.wait_for(f"!{node('world', 'axes')}.visible")
        viewer.show(trajectory.configuration[0] + np.eye(9)[0] * 5.0)  # far off the first ground
        browser.wait_for(f"{node('world', 'ground', 'grid', '<object>')}.position.x > 2")
        others = [url for url in browser.requests if not url.startswith("data:")]
        assert others == [viewer.url, viewer.url.replace("http", "ws") + "commands"]
        assert browser.problems == []
    assert "".join(capfd.readouterr()) == ""


@pytest.mark.slow
@needs_browser
def test_live_play_keeps_time_and_draws_the_trace(browser, trajectory):
    pieces = f"Object.keys(viewer.scene_tree.find({['world', 'ground', 'trace']}).children).length"
    with Viewer(trajectory.robot, axes=False) as viewer:
        browser.open(viewer.url)
        for _ in range(2):
            start = time.monotonic()
            viewer.play(trajectory, speed=10.0)
            assert time.monotonic() - start == pytest.approx(1.0, abs=0.3)
            browser.wait_for(stands_at(trajectory.configuration[-1]))
            assert browser.run(pieces) > 1
        browser.run(f"{node('world', 'robot')}.visible = false")
        assert trace_pixels(browser.picture()) > 100
        viewer.clear_trace()
        browser.wait_for(f"{pieces} == 0")
        assert trace_pixels(browser.picture()) == 0
        assert browser.problems == []


def test_play_drops_frames_rather_than_lag(trajectory, monkeypatch):
    with Viewer(trajectory.robot) as viewer:
        drawn = []
        real = viewer._draw
        monkeypatch.setattr(
            viewer, "_draw", lambda *a: (drawn.append(a), time.sleep(0.1), real(*a))
        )
        start = time.monotonic()
        viewer.play(trajectory, speed=10.0)
        assert time.monotonic() - start < 1.5
        assert 5 <= len(drawn) <= 12
        path = make_film(trajectory, fps=60, speed=10, detail=viewer._scene.detail).path
        assert sum(len(contacts) for _, contacts in drawn) == len(path)  # no gap in the trace


@needs_proc
def test_server_listens_on_the_loopback_interface_only(trajectory):
    before = listening()
    with Viewer(trajectory.robot) as viewer:
        port = int(viewer.url.rsplit(":", 1)[1].strip("/"))
        assert listening() - before == {("127.0.0.1", port)}
        outside = own_address()
        if outside is not None:
            with pytest.raises(OSError):
                socket.create_connection((outside, port), timeout=2.0).close()
    assert listening() - before == set()


def listening():
    """Addresses that this process listens on."""
    inodes = set()
    for fd in Path("/proc/self/fd").iterdir():
        try:
            inodes.add(os.readlink(fd))
        except OSError:
            continue
    found = set()
    for name in ("tcp", "tcp6"):
        table = Path("/proc/net", name)
        lines = table.read_text().splitlines()[1:] if table.exists() else []
        for _, local, _, state, *_rest, inode in (line.split()[:10] for line in lines):
            if state == "0A" and f"socket:[{inode}]" in inodes:
                address, port = local.split(":")
                raw = bytes.fromhex(address)
                shown = socket.inet_ntoa(raw[::-1]) if len(raw) == 4 else address
                found.add((shown, int(port, 16)))
    return found


def own_address():
    """An address of this computer that is not the loopback's, if it has one."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # sends nothing
        except OSError:
            return None
        address = probe.getsockname()[0]
    return None if address.startswith("127.") else address


def test_other_sites_get_nothing(trajectory):
    with Viewer(trajectory.robot) as viewer:
        assert b"MeshCat" in urllib.request.urlopen(viewer.url, timeout=5).read()
        rebound = urllib.request.Request(viewer.url, headers={"Host": "evil.example"})
        with pytest.raises(urllib.error.HTTPError, match="404") as refused:
            urllib.request.urlopen(rebound, timeout=5)
        refused.value.close()
        for origin, answer in (("http://evil.example", b"403"), (viewer.url[:-1], b"101")):
            with tab(viewer.url, origin) as foreign:
                assert foreign.recv(12) == b"HTTP/1.1 " + answer


UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "MDEyMzQ1Njc4OWFiY2RlZg==",
}


def tab(url, origin=None):
    """A socket that has asked for the commands as a page of that origin would."""
    host = url.split("/")[2]
    opened = socket.create_connection((host.split(":")[0], int(host.split(":")[1])), timeout=10)
    lines = [f"{name}: {value}" for name, value in (UPGRADE | {"Host": host}).items()]
    lines += [f"Origin: {origin or url[:-1]}"]
    opened.sendall("\r\n".join(["GET /commands HTTP/1.1", *lines, "", ""]).encode())
    return opened


def test_a_tab_that_breaks_off_disturbs_nobody(trajectory, capfd):
    with Viewer(trajectory.robot) as viewer, tab(viewer.url) as stays:
        breaks = tab(viewer.url)
        for i, q in enumerate(trajectory.configuration[:300]):
            viewer.show(q)
            if i == 100:
                breaks.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                breaks.close()
        last = pack(viewer._scene.place(viewer._scene.pose(q))[-1])
        got = stays.recv(12)
        assert got == b"HTTP/1.1 101"
        while last not in got:  # times out if it never comes
            got += stays.recv(1 << 20)
    assert "".join(capfd.readouterr()) == ""


def test_a_request_s_body_is_refused_before_it_is_read(trajectory):
    with Viewer(trajectory.robot) as viewer:
        host, port = viewer.url.split("/")[2].split(":")
        with socket.create_connection((host, int(port)), timeout=10) as opened:
            head = f"POST / HTTP/1.1\r\nHost: {host}:{port}\r\nContent-Length: 98000000\r\n\r\n"
            opened.sendall(head.encode())
            taken = 0
            try:
                while taken < 98_000_000:
                    taken += opened.send(b"x" * 65536)
            except OSError:
                pass
        # What the system's own buffers hold may have gone out.
        assert taken < 20_000_000
        assert b"MeshCat" in urllib.request.urlopen(viewer.url, timeout=5).read()


def test_connections_are_capped_and_come_free_again(trajectory):
    with Viewer(trajectory.robot) as viewer:
        host, port = viewer.url.split("/")[2].split(":")
        idle = [
            socket.create_connection((host, int(port)), timeout=10) for _ in range(MOST_CONNECTIONS)
        ]
        try:
            with pytest.raises(OSError):
                urllib.request.urlopen(viewer.url, timeout=5).read()
        finally:
            for one in idle:
                one.close()
        time.sleep(0.2)
        assert b"MeshCat" in urllib.request.urlopen(viewer.url, timeout=5).read()


HOSTILE_NAMES = ("constructor", "__proto__", "hasOwnProperty", "<object>", "a/b", "toString")


@needs_browser
def test_films_of_joints_with_names_of_javascript_s_own_play(browser, tmp_path):
    """The last frame stands where Pinocchio puts each joint."""
    solid = '<inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial>'
    seen = '<visual><geometry><sphere radius="0.02"/></geometry></visual>'
    legs = "".join(
        f'<link name="l{i}"><inertial><mass value="0.1"/>{solid}{seen}</link>'
        f'<joint name="{escape(name)}" type="continuous"><parent link="body"/><child link="l{i}"/>'
        f'<origin xyz="0 0.0{i} 0"/><axis xyz="0 1 0"/></joint>'
        for i, name in enumerate(HOSTILE_NAMES)
    )
    text = (
        f'<robot name="r"><link name="body"><inertial><mass value="1"/>{solid}</link>{legs}</robot>'
    )
    robot = rr.Robot.from_urdf(text, shell=rr.Sphere(0.3))
    gait = rr.SinusoidalGait(offset=0.5, amplitude=0.3, angular_frequency=6.0, n_legs=6)
    model = rr.FullModel(robot, damping=rr.BodyRateDamping(0.1, 0.1, 0.1))
    t = rr.simulate(model, gait, duration=0.5)
    browser.open(record(t, tmp_path / "names.html").as_uri())
    browser.seek(0.5)
    data, scene = robot.model.createData(), Scene(robot)
    pin.forwardKinematics(robot.model, data, t.configuration[-1])
    for joint in range(2, robot.model.njoints):
        at = node(*scene.path(joint).strip("/").split("/"))
        turn = pin.Quaternion(np.array(browser.run(f"{at}.quaternion.toArray()"))).matrix()
        np.testing.assert_allclose(turn, data.oMi[joint].rotation, atol=1e-5)
        place = browser.run(f"{at}.position.toArray()")
        np.testing.assert_allclose(place, data.oMi[joint].translation, atol=1e-6)
    assert browser.problems == []


def test_only_the_newest_commands_wait_for_a_slow_tab():
    waiting = {}
    for command in (
        {"path": "/a/b", "type": "set_transform"},
        {"path": "/a", "type": "set_object"},
        {"path": "/ab", "type": "set_object"},
        {"path": "/a/b", "type": "set_transform"},
        {"path": "/a/b", "type": "set_property", "property": "visible"},
        {"path": "/a/b", "type": "set_property", "property": "scale"},
    ):
        _put(waiting, _key(command), b"")
    shown = [(key.path, key.type, key.property) for key in waiting]
    assert shown == [
        ("/a", "set_object", ""),
        ("/ab", "set_object", ""),
        ("/a/b", "set_transform", ""),
        ("/a/b", "set_property", "visible"),
        ("/a/b", "set_property", "scale"),
    ]
    _put(waiting, _key({"path": "/a", "type": "delete"}), b"")
    assert [key.path for key in waiting] == ["/ab", "/a"]


SCRIPT = """
import rrrobot as rr, time
from rrrobot.view.viewer import Viewer
viewer = Viewer(rr.Robot.from_parameters())
print(viewer.url, flush=True)
{end}
"""


@pytest.mark.parametrize("end", some(("pass", "raise SystemExit(3)", "time.sleep(60)"), {"pass"}))
def test_server_dies_with_the_script(end):
    script = subprocess.Popen(
        [sys.executable, "-W", "error", "-c", SCRIPT.format(end=end)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    url = script.stdout.readline().strip()
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", url)
    if "sleep" in end:
        urllib.request.urlopen(url, timeout=5).close()
        script.send_signal(signal.SIGKILL)
    rest, complaint = script.communicate(timeout=20)
    assert (rest, complaint) == ("", "")
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(url, timeout=5)


def test_viewer_refuses(trajectory):
    for port in (0, 70000, "8000", True):
        with pytest.raises(rr.ParameterError, match="port is"):
            Viewer(trajectory.robot, port=port)
    with Viewer(trajectory.robot) as viewer:
        port = int(viewer.url.rsplit(":", 1)[1].strip("/"))
        with pytest.raises(rr.OutputError, match=f"port {port}"):
            Viewer(trajectory.robot, port=port)
        with pytest.raises(rr.ParameterError, match="configuration"):
            viewer.show(np.zeros(3))
        with pytest.raises(rr.ParameterError, match="quaternion"):
            viewer.show(np.zeros(9))
        with pytest.raises(rr.ParameterError, match="speed"):
            viewer.play(trajectory, speed=0.0)
        heavier = rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=0.06))
        other = rr.simulate(rr.FullModel(heavier), rr.gait("circular"), duration=0.1)
        with pytest.raises(rr.ModelError, match=r"another|is of Robot"):
            viewer.play(other)
    viewer.close()  # again does nothing
    with pytest.raises(rr.OutputError, match="closed"):
        viewer.show(trajectory.configuration[0])
    with Viewer(trajectory.robot, port=port) as again:  # the port is free again
        assert again.url == viewer.url


def test_import_is_light():
    code = (
        "import sys, rrrobot.view.viewer;"
        "print(*(m for m in ('meshcat', 'tornado', 'umsgpack', 'asyncio') if m in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
