"""The page of a film, used as a person uses it: clock, speed, layers, a phone held upright."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from rrrobot.view.films import film_html
from rrrobot.view.motion import WEIGHT
from rrrobot.view.scene import Scene
from rrrobot.view.shapes import robot_visuals
from tests.browser import Browser, find_browser

needs_browser = pytest.mark.skipif(find_browser() is None, reason="no Chromium or Chrome")


@pytest.fixture(scope="module")
def trajectory():
    model = rr.FullModel(rr.Robot.from_parameters())
    return rr.simulate(model, rr.gait("circular"), duration=4.0)


@pytest.fixture(scope="module")
def browser():
    with Browser((640, 480)) as opened:
        yield opened


@pytest.fixture(scope="module")
def opened(browser, trajectory, tmp_path_factory):
    """Opens a film of the trajectory with these options, held at its start."""
    last = []

    def open_(**options):
        if last == [options]:
            return browser
        last[:] = [options]
        path = tmp_path_factory.mktemp("film") / "film.html"
        path.write_bytes(film_html(trajectory, **options))
        browser.open(path.as_uri(), "typeof page == 'object'")
        browser.seek(0.0)
        return browser

    return open_


def element(name):
    return f"document.getElementById('{name}')"


def click(browser, name):
    browser.run(f"{element(name)}.click(); page.draw()")


def text(browser, name):
    return browser.run(f"{element(name)}.innerText")


def node(path):
    return f"viewer.scene_tree.find('{path}'.split('/').filter(Boolean)).object"


@needs_browser
def test_a_person_plays_pauses_seeks_and_slows_down(opened):
    page = opened(speed=2.0, loop=False)
    assert text(page, "clock") == "0.00 / 4.00 s"
    assert page.run(f"{element('speed')}.value") == "2"
    click(page, "play")
    page.wait_for("viewer.animator.time > 0.1")
    assert page.run(f"viewer.animator.playing && {element('play')}.classList.contains('on')")
    page.run("document.dispatchEvent(new KeyboardEvent('keydown', {key: ' '}))")
    assert page.run("viewer.animator.playing") is False
    page.run(f"{element('at')}.value = 0.75; {element('at')}.oninput({{target: {element('at')}}})")
    page.run("page.draw()")
    assert text(page, "clock") == "3.00 / 4.00 s"
    assert page.run(f"{element('cursor')}.style.left") == "75%"
    page.run("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowLeft'}))")
    page.run("page.draw()")
    assert text(page, "clock") == "2.90 / 4.00 s"
    # Half the pace of the motion is a quarter of the film's.
    page.run(f"{element('speed')}.value = '0.5'; {element('speed')}.onchange("
             f"{{target: {element('speed')}}})")  # fmt: skip
    assert page.run("viewer.animator.mixer.timeScale") == 0.25
    # One that plays once holds its end, and begins anew when asked to.
    page.run("viewer.animator.mixer.timeScale = 1; viewer.animator.seek(1.95); page.draw()")
    click(page, "play")
    page.wait_for("!viewer.animator.playing")
    page.run("page.draw()")
    assert text(page, "clock") == "4.00 / 4.00 s"
    click(page, "play")
    page.wait_for("viewer.animator.playing && viewer.animator.time < 1.5")
    assert page.problems == []


@needs_browser
def test_the_arrow_is_the_contacts_force(opened, trajectory):
    page, at = opened(force=True, labels=True), 2.0
    page.seek(at)
    force = trajectory.contact_force[round(at / 0.01)]
    contact = [*trajectory.position[round(at / 0.01)], 0.0]
    assert page.run(f"{node('/world/force')}.visible")
    place, size = (page.run(f"{node('/world/force')}.{name}.toArray()")
                   for name in ("position", "scale"))  # fmt: skip
    turn = pin.Quaternion(np.array(page.run(f"{node('/world/force')}.quaternion.toArray()")))
    np.testing.assert_allclose(place, contact, atol=1e-6)
    weight = trajectory.robot.mass * trajectory.gravity
    found = turn.matrix()[:, 2] * np.array(size) * weight / (WEIGHT * 0.12)
    np.testing.assert_allclose(found, force, atol=1e-5 * weight)


@needs_browser
def test_names_stand_at_their_legs(opened, trajectory):
    page = opened(force=True, labels=True)
    page.seek(1.0)
    model, data = trajectory.robot.model, trajectory.robot.model.createData()
    pin.forwardKinematics(model, data, trajectory.configuration[100])
    for i, leg in enumerate(trajectory.robot.legs):
        joint = model.getJointId(leg)
        mass = data.oMi[joint].act(model.inertias[joint].lever)
        x, y, _ = page.run(
            f"(() => {{ const p = new MeshCat.THREE.Vector3(...{mass.tolist()});"
            f"{node('/world')}.updateWorldMatrix(true, false);"
            f"p.applyMatrix4({node('/world')}.matrixWorld);"
            "return p.project(viewer.camera).toArray() })()"
        )
        box = page.run(
            f"(() => {{ const b = document.querySelectorAll('#names span')[{i}]"
            ".getBoundingClientRect(); return [b.left, (b.top + b.bottom) / 2] })()"
        )
        wide, tall = page.run("[viewer.dom_element.offsetWidth, viewer.dom_element.offsetHeight]")
        assert box == pytest.approx([(1 + x) / 2 * wide + 8, (1 - y) / 2 * tall], abs=2.0)
        assert page.run(f"document.querySelectorAll('#names span')[{i}].textContent") == leg


@needs_browser
def test_a_picture_has_the_time_and_not_the_controls(opened):
    page = opened(force=True, labels=True)
    page.seek(1.5)
    assert "t =" not in text(page, "caption")
    page.run("page.hold(true)")
    assert text(page, "caption").endswith("t = 1.50 s")
    assert page.run(f"getComputedStyle({element('bar')}).display") == "none"
    assert page.run("document.querySelector('canvas').offsetHeight") == 480
    page.run("page.hold(false)")
    assert page.run("document.querySelector('canvas').offsetHeight") < 480


@pytest.mark.slow
@needs_browser
def test_layers_are_shown_on_request_and_said_in_the_legend(opened):
    page = opened()
    glass, shell = (
        node("/world/robot/1 root_joint/glass"),
        node("/world/robot/1 root_joint/0 shell"),
    )
    assert page.run(f"[{node('/world/force')}, {glass}, {shell}].map(o => o.visible)") == [
        False, False, True,
    ]  # fmt: skip
    assert text(page, "legend").strip() == "x, rolly, pitchz, yawpath of the contact"
    assert page.run(f"{element('names')}.hidden && {element('curves')}.hidden")
    for name in ("axes", "trace", "force", "labels", "translucent", "curves"):
        click(page, f"show-{name}")
    assert page.run(f"[{node('/world/force')}, {glass}, {shell}, {node('/world/axes')},"
                    f"{node('/world/ground/trace')}].map(o => o.visible)") == [
        True, True, False, False, False,
    ]  # fmt: skip
    assert text(page, "legend").strip() == "contact force"
    # The picture makes room for the curves, and the robot stays in it.
    tall = page.run("document.getElementById('meshcat-pane').offsetHeight")
    page.wait_for(f"document.querySelector('canvas').offsetHeight == {tall}")
    assert 150 < tall < 480 - 2 * 56
    assert page.run("document.querySelectorAll('#curves polyline').length") == 7
    assert page.problems == []


@needs_browser
def test_a_phone_held_upright_shows_the_whole_robot(browser, opened, trajectory):
    sizes = {"mobile": False, "deviceScaleFactor": 1}
    browser.call("Emulation.setDeviceMetricsOverride", width=390, height=844, **sizes)
    try:
        page = opened(curves=True)
        page.wait_for("viewer.camera.aspect < 1 && viewer.camera.fov > 40")
        scene = Scene(trajectory.robot)
        across = []
        for t in (0.0, 2.0, 4.0):
            page.seek(t)
            center = scene.pose(trajectory.configuration[round(t / 0.01)]).center
            ends = center + 0.15 * np.vstack((np.eye(3), -np.eye(3)))
            seen = np.array(page.run(
                f"(() => {{ const world = {node('/world')}; world.updateWorldMatrix(true, false);"
                f"return {ends.tolist()}.map(p => new MeshCat.THREE.Vector3(...p)"
                ".applyMatrix4(world.matrixWorld).project(viewer.camera).toArray()) })()"
            ))  # fmt: skip
            assert np.all(np.abs(seen) < 1)
            across.append(np.ptp(seen[:, 0]))
        assert max(across) > 0.8  # of 2, and the robot has moved: it is not a dot in the middle
        bar = page.run(
            "[...document.querySelectorAll('#bar > *')].map(e => e.getBoundingClientRect().right)"
        )
        assert max(bar) <= 390 and page.run("document.body.scrollWidth") <= 390
    finally:
        browser.call("Emulation.setDeviceMetricsOverride", width=640, height=480, **sizes)


def test_what_there_is_not_is_not_shown():
    machine = rr.machines.chaplygin_sleigh()
    run = machine.simulate(None, 0.5, start=(0.5, 0.0, 0.1), sample_interval=0.1)
    film_html(run)
    for name in ("force", "labels", "curves"):
        with pytest.raises(rr.ParameterError, match=f"{name}=True shows nothing"):
            film_html(run, **{name: True})


def test_legs_that_the_urdf_does_not_draw_are_sticks():
    def link(name, mass, x=0.0):
        return (
            f'<link name="{name}"><inertial><origin xyz="{x} 0 0"/><mass value="{mass}"/>'
            '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )

    def joint(name, parent, child, kind="continuous", x=0.0):
        return (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{x} 0.1 0"/><axis xyz="0 1 0"/></joint>'
        )

    text = (
        '<robot name="r">' + link("body", 1.0) + link("thigh", 0.1) + link("shin", 0.1, x=0.04)
        + link("foot", 0.01) + link("held", 0.1, x=0.05)
        + joint("hip", "body", "thigh") + joint("knee", "thigh", "shin", x=0.07)
        + joint("ankle", "shin", "foot", "fixed", x=0.06) + joint("tail", "body", "held")
        + "</robot>"
    )  # fmt: skip
    robot = rr.Robot.from_urdf(text, shell=rr.Sphere(0.3), legs=("hip", "knee"), locked={"tail": 0})
    sticks = {}
    for visual in robot_visuals(robot):
        if visual.geometry["type"] == "CylinderGeometry":
            axis = visual.placement.rotation[:, 1] * visual.geometry["height"] / 2
            middle = visual.placement.translation
            sticks[visual.name] = visual.joint, (middle - axis).round(9), (middle + axis).round(9)
    ends = {name: [*map(abs, (*a, *b))] for name, (_, a, b) in sticks.items()}
    assert {name: found[0] for name, found in sticks.items()} == {"thigh": 2, "shin": 3, "held": 1}
    # In the joint's frame: from the joint to the next one, to the foot, to twice the mass centre.
    assert sorted(ends["thigh"]) == [0, 0, 0, 0, 0.07, 0.1]
    assert sorted(ends["shin"]) == [0, 0, 0, 0, 0.06, 0.1]
    assert sorted(ends["held"]) == [0, 0, 0, 0.1, 0.1, 0.1]
