"""What a robot looks like: its URDF's visuals and its shell, as three.js geometries.

Each visual is placed in the frame of the Pinocchio joint that carries it, on the robot's own
model, so that joints held still stay where they are held. A shell that the URDF does not draw is
drawn by `shells`. Legs that it does not draw are sticks.
"""

from __future__ import annotations

import math
import warnings
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin

from rrrobot.contact.surfaces import Sphere
from rrrobot.robot.meshes import MeshError, find_mesh, numbers, origin_of, read_mesh, short
from rrrobot.robot.reader import parse_urdf
from rrrobot.robot.robot import Robot
from rrrobot.view.commands import Colour, Geometry, mesh
from rrrobot.view.player import Figure
from rrrobot.view.shells import around, cap_of, directions, lattice, shell_size, shell_visuals
from rrrobot.view.visual import Visual

_STICK_COLOUR: Colour = (0.35, 0.42, 0.50)
_DEFAULT_COLOUR: Colour = (0.72, 0.74, 0.77, 1.0)

# three.js has a cylinder's axis along y, URDF along z.
_Y_TO_Z = pin.SE3(pin.rpy.rpyToMatrix(math.pi / 2, 0, 0), np.zeros(3))


def robot_visuals(robot: Robot | Figure) -> list[Visual]:
    """Visuals of the URDF, and the shell where the URDF does not draw it.

    Warns:
        UserWarning: for meshes that are missing or unreadable, the link's collision shapes stand
            in, or a box of its inertia; one warning names them.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.view.shapes import robot_visuals
        >>> sorted({visual.name for visual in robot_visuals(rr.Robot.from_parameters())})
        ['battery', 'leg_1_link', 'leg_2_link', 'servo_1', 'servo_2', 'shell']
    """
    tree = parse_urdf(robot.urdf)
    materials = {str(m.get("name")): m for m in tree.findall("material")}
    meshes: _Meshes = {}
    visuals, missing = [], []
    for link in tree.findall("link"):
        name = str(link.get("name"))
        frame = robot.model.frames[robot.model.getFrameId(name, pin.FrameType.BODY)]
        for element in link.findall("visual"):
            try:
                shape = _shape(element, robot.package_dirs, meshes)
            except MeshError as error:
                missing.append(str(error))
                element, shape = _stand_in(link)
            if shape is not None:
                geometry, reach, turn, flat = shape
                at = frame.placement * origin_of(element) * turn
                colour = _colour(element, materials)
                visuals.append(Visual(name, frame.parentJoint, at, geometry, colour, reach, flat))
    if missing:
        listed = "; ".join(dict.fromkeys(missing))
        warnings.warn(
            f"the viewer has not all meshes of {robot.name}, and shows collision shapes or boxes "
            f"instead: {listed}.",
            stacklevel=2,
        )
    # A shell that the URDF draws may have its stripes in the same link.
    ours = {visual.name for visual in visuals if _is_shell(visual, robot)}
    visuals = [visual._replace(shell=visual.name in ours) for visual in visuals]
    if isinstance(robot, Robot):
        visuals += _sticks(robot, tree, {visual.name for visual in visuals})
    shown = isinstance(robot, Robot) or robot.shows_shell
    if shown and not any(visual.shell for visual in visuals):
        visuals += shell_visuals(robot, cap_of(robot, visuals))
    return visuals


def _sticks(robot: Robot, tree: ET.Element, drawn: set[str]) -> list[Visual]:
    """Links of which the URDF draws nothing: sticks from their joint to the next, or to the tip.

    The tip is where a uniform stick would end that has the link's mass centre; a ball marks it.
    """
    body = {str(link.get("name")): str(link.get("name")) for link in tree.findall("link")}
    below: dict[str, list[ET.Element]] = {name: [] for name in body}
    for joint in tree.findall("joint"):
        parent, child = (str(joint.find(end).get("link")) for end in ("parent", "child"))  # type: ignore[union-attr]
        below[parent].append(joint)
        if joint.get("type") == "fixed":  # what is fixed to each other is one body
            one, other = body[parent], body[child]
            body = {name: one if of == other else of for name, of in body.items()}
    covered = {body[name] for name in (robot.shell_link, *drawn)}
    r, sticks = 0.03 * shell_size(robot), []
    for link in tree.findall("link"):
        name = str(link.get("name"))
        if body[name] in covered:
            continue
        frame = robot.model.frames[robot.model.getFrameId(name, pin.FrameType.BODY)]
        ends = [origin_of(joint).translation for joint in below[name]]
        inertial = link.find("inertial")
        if not ends and inertial is not None:
            ends = [2 * origin_of(inertial).translation]
        for end in ends:
            long = float(np.linalg.norm(end))
            if long > r:
                turn = pin.Quaternion.FromTwoVectors(np.array((0.0, 0.0, 1.0)), end).matrix()
                at = frame.placement * pin.SE3(turn, end / 2) * _Y_TO_Z
                reach = math.hypot(r, long / 2)
                sticks.append(
                    Visual(name, frame.parentJoint, at, _rod(r, long), _STICK_COLOUR, reach)
                )
            at = frame.placement * pin.SE3(np.eye(3), end)
            sticks.append(Visual(name, frame.parentJoint, at, _ball(2 * r), _STICK_COLOUR, 2 * r))
    return sticks


_Shape = tuple[Geometry, float, pin.SE3, bool]
_Meshes = dict[tuple[Path, tuple[float, ...]], _Shape]


def _shape(visual: ET.Element, package_dirs: tuple[str, ...], meshes: _Meshes) -> _Shape | None:
    """Geometry, reach, placement in the visual's frame, flat; None for an empty visual.

    `meshes` keeps each file that was read: legs are often alike.
    """
    still = pin.SE3.Identity()
    for shape in visual.findall("geometry/*"):
        if shape.tag == "box":
            x, y, z = numbers(shape, "size", 3)
            box = {"type": "BoxGeometry", "width": x, "height": y, "depth": z}
            return box, math.hypot(x, y, z) / 2, still, False
        if shape.tag == "sphere":
            (r,) = numbers(shape, "radius", 1)
            return _ball(r), r, still, False
        if shape.tag == "cylinder":
            (r,), (length,) = numbers(shape, "radius", 1), numbers(shape, "length", 1)
            return _rod(r, length), math.hypot(r, length / 2), _Y_TO_Z, False
        if shape.tag == "capsule":
            (r,), (length,) = numbers(shape, "radius", 1), numbers(shape, "length", 1)
            return _capsule(r, length), r + length / 2, still, False
        if shape.tag == "mesh":
            return _mesh_file(shape, package_dirs, meshes)
    return None


def _stand_in(link: ET.Element) -> tuple[ET.Element, _Shape | None]:
    """A shape for a link whose mesh is missing, and the element that places it."""
    for element in link.findall("collision"):
        if element.find("geometry/mesh") is None:
            shape = _shape(element, (), {})
            if shape is not None:
                return element, shape
    inertial = link.find("inertial")
    inertia, mass = link.find("inertial/inertia"), link.find("inertial/mass")
    if inertial is None or inertia is None or mass is None:
        return link, None
    (m,) = numbers(mass, "value", 1)
    xx, yy, zz = (numbers(inertia, name, 1)[0] for name in ("ixx", "iyy", "izz"))
    if m <= 0 or xx + yy + zz <= 0:
        return link, None
    # Sides of a uniform box with these moments.
    squares = 6 / m * np.array((yy + zz - xx, xx + zz - yy, xx + yy - zz))
    x, y, z = np.sqrt(np.maximum(squares, 1e-8)).tolist()
    box = {"type": "BoxGeometry", "width": x, "height": y, "depth": z}
    return inertial, (box, math.hypot(x, y, z) / 2, pin.SE3.Identity(), False)


def _ball(radius: float) -> Geometry:
    return {
        "type": "SphereGeometry", "radius": radius, "widthSegments": 64, "heightSegments": 40,
    }  # fmt: skip


def _rod(radius: float, length: float) -> Geometry:
    rod = {"type": "CylinderGeometry", "radiusTop": radius, "radiusBottom": radius}
    return {**rod, "height": length, "radialSegments": 64}


def _capsule(radius: float, length: float) -> Geometry:
    half = np.linspace(0, math.pi / 2, 9)
    latitude = np.concatenate((-half[::-1], half))
    points = radius * directions(latitude, around(32))
    points[:9, :, 2] -= length / 2
    points[9:, :, 2] += length / 2
    return lattice(points)


def _mesh_file(shape: ET.Element, package_dirs: tuple[str, ...], meshes: _Meshes) -> _Shape:
    name = shape.get("filename", "")
    scale = tuple(numbers(shape, "scale", 3)) if shape.get("scale") else (1.0, 1.0, 1.0)
    path = find_mesh(name, package_dirs)
    key = path, scale
    if key not in meshes:
        try:
            vertices, faces = read_mesh(path, scale)
        except MeshError as error:
            raise MeshError(f"{short(name)} cannot be read ({error})") from None
        reach = float(np.linalg.norm(vertices, axis=1).max())
        meshes[key] = mesh(vertices, faces), reach, pin.SE3.Identity(), True
    return meshes[key]


def _colour(visual: ET.Element, materials: dict[str, ET.Element]) -> Colour:
    material = visual.find("material")
    if material is None:
        return _DEFAULT_COLOUR
    colour = material.find("color")
    if colour is None and material.get("name") in materials:
        colour = materials[str(material.get("name"))].find("color")
    if colour is None:
        return _DEFAULT_COLOUR
    return tuple(min(max(part, 0.0), 1.0) for part in numbers(colour, "rgba", 4))


def _is_shell(visual: Visual, robot: Robot | Figure) -> bool:
    """Whether a visual of the root link is the shell itself."""
    if not isinstance(robot.shell, Sphere) or visual.geometry["type"] != "SphereGeometry":
        return False
    r = robot.shell.radius
    offset = np.linalg.norm(visual.placement.translation - robot.shell_placement.translation)
    return visual.joint == 1 and abs(visual.reach - r) < 0.02 * r and bool(offset < 0.02 * r)
