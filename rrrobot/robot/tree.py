"""A robot's tree as the models want it: its base at the root, one freedom in each joint.

What a URDF may have beside that is rewritten here, into elements of which Pinocchio makes the same
mechanism:

    a massless root on a `floating` joint        its child is the root: the base floats anyway
    a massless root named world on a `fixed` one likewise
    a `spherical` or `ball` joint j              three revolute joints j_x, j_y, j_z
    a root that does not carry the shell         the tree is turned over at the shell's link
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Collection
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from rrrobot.errors import UrdfError
from rrrobot.robot.faults import BALL_TYPES, root_link
from rrrobot.rotations import rotation_from_euler

_WORLDS = ("world", "World", "map", "odom")


def normalise(robot: Element) -> None:
    """Take the world's own joint away and expand ball joints, in place."""
    _free_the_base(robot)
    for joint in [j for j in robot.findall("joint") if j.get("type") in BALL_TYPES]:
        _expand_ball(robot, joint)


def _free_the_base(robot: Element) -> None:
    root = root_link(robot)
    link = next(e for e in robot.findall("link") if e.get("name") == root)
    joints = [j for j in robot.findall("joint") if _end(j, "parent") == root]
    if link.find("inertial") is not None or len(joints) != 1:
        return
    (joint,) = joints
    if joint.get("type") == "floating" or (joint.get("type") == "fixed" and root in _WORLDS):
        robot.remove(link)
        robot.remove(joint)


def _expand_ball(robot: Element, joint: Element) -> None:
    name, child = str(joint.get("name")), _end(joint, "child")
    taken = {str(e.get("name")) for tag in ("link", "joint") for e in robot.findall(tag)}
    at, parent = list(robot).index(joint), _end(joint, "parent")
    robot.remove(joint)
    for axis, letter in zip(np.eye(3, dtype=int), "xyz", strict=True):
        part = f"{name}_{letter}"
        if part in taken:
            raise UrdfError(
                f"joint {name!r} is {joint.get('type')} and becomes {name}_x, {name}_y, {name}_z: "
                f"the URDF has {part!r} already; rename one."
            )
        end = child if letter == "z" else f"{part}_link"
        made = _joint(part, "continuous", parent, end, axis)
        if letter == "x":
            made.extend(joint.findall("origin"))
        made.extend(joint.findall("dynamics"))
        robot.insert(at, made)
        if letter != "z":
            robot.append(_element("link", name=end))
        at, parent = at + 1, end


def path_down(robot: Element, link: str) -> list[Element]:
    """The joints from the root to a link, in that order; [] of the root and of unknown links."""
    above = {_end(joint, "child"): joint for joint in robot.findall("joint")}
    path: list[Element] = []
    while link in above:
        path.append(above[link])
        link = _end(above[link], "parent")
    return path[::-1]


def turn_over(robot: Element, link: str, held: Collection[str]) -> None:
    """Make a link the root, in place, unless only held and fixed joints part it from the root.

    A joint from P to C with placement T in P and axis e becomes one from C to P with axis -e at
    C's origin, and P hangs on it by T^-1: the relative motion at a coordinate q is the same, and
    so are the coordinate's sign, its rate and the work of its torque.

    Args:
        robot: of `parse_urdf`.
        link: that is to be the root.
        held: names of joints that do not move.
    """
    path = path_down(robot, link)
    if all(j.get("type") == "fixed" or j.get("name") in held for j in path):
        return
    taken = {str(e.get("name")) for e in (*robot.findall("link"), *robot.findall("joint"))}
    for joint in path:
        parent, child = _end(joint, "parent"), _end(joint, "child")
        rotation, translation = placement(joint)
        inverse = rotation.T, -rotation.T @ translation
        for origin in joint.findall("origin"):
            joint.remove(origin)
        if joint.get("type") == "fixed":
            joint.insert(0, _origin(*inverse))
            _set_ends(joint, child, parent)
            continue
        hinge = f"{parent}_at_{joint.get('name')}"
        while hinge in taken:
            hinge += "_"
        taken.add(hinge)
        _set_ends(joint, child, hinge)
        axis = joint.find("axis")
        e = np.array([1.0, 0, 0] if axis is None else _numbers(axis, "xyz"))
        if axis is not None:
            joint.remove(axis)
        joint.append(_element("axis", xyz=_text(-e)))
        weld = _joint(hinge, "fixed", hinge, parent)
        weld.insert(0, _origin(*inverse))
        robot.extend((_element("link", name=hinge), weld))


def placement(joint: Element) -> tuple[Any, Any]:
    """Rotation (3, 3) and translation (3,) [m] of a joint's frame in its parent link's."""
    origin = joint.find("origin")
    xyz = [] if origin is None else _numbers(origin, "xyz")
    rpy = [] if origin is None else _numbers(origin, "rpy")
    rotation = rotation_from_euler(np.array(rpy)) if rpy else np.eye(3)
    return rotation, np.array(xyz or (0.0, 0.0, 0.0))


def _origin(rotation: Any, translation: Any) -> Element:
    # With yaw taken off, the second row is (0, cos roll, -sin roll) at any pitch.
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    c, s = np.cos(yaw), np.sin(yaw)
    pitch = np.arctan2(-rotation[2, 0], c * rotation[0, 0] + s * rotation[1, 0])
    row = c * rotation[1] - s * rotation[0]
    rpy = (np.arctan2(-row[2], row[1]), pitch, yaw)
    return _element("origin", xyz=_text(translation), rpy=_text(rpy))


def for_pinocchio(robot: Element) -> str:
    """The tree and its inertias alone, as text.

    Pinocchio reads no looks from it, so it can stumble over none, such as a material that is
    defined twice; and no space around a mass, which it would drop.
    """
    bare = _element("robot", name=str(robot.get("name")))
    for link in robot.findall("link"):
        made = ET.SubElement(bare, "link", name=str(link.get("name")))
        made.extend(link.findall("inertial")[:1])
    for joint in robot.findall("joint"):
        kept = ("name", "type")
        made = ET.SubElement(bare, "joint", {key: str(joint.get(key)) for key in kept})
        for tag in ("origin", "parent", "child", "axis", "limit", "mimic"):
            made.extend(joint.findall(tag)[:1])
    return ET.tostring(bare, encoding="unicode")


def _joint(name: str, kind: str, parent: str, child: str, axis: Any = None) -> Element:
    joint = _element("joint", name=name, type=kind)
    joint.extend((_element("parent", link=parent), _element("child", link=child)))
    if axis is not None:
        joint.append(_element("axis", xyz=_text(axis)))
    return joint


def _element(tag: str, **attributes: str) -> Element:
    return Element(tag, attributes)


def _end(joint: ET.Element, end: str) -> str:
    element = joint.find(end)
    return "" if element is None else str(element.get("link"))


def _set_ends(joint: Element, parent: str, child: str) -> None:
    for end, link in (("parent", parent), ("child", child)):
        joint.find(end).set("link", link)  # type: ignore[union-attr]


def _numbers(element: ET.Element, name: str) -> list[float]:
    return [float(word) for word in str(element.get(name, "")).split()]


def _text(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)
