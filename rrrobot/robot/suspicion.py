"""What a robot's file says and nobody can mean, or nothing here models: told once, in warnings.

No body has principal moments A + B < C, or a radius of gyration far beyond the robot's own size;
files that do were mostly written in other units or exported wrongly.
"""

from __future__ import annotations

import math
import warnings
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.surfaces import Sphere
from rrrobot.errors import UrdfWarning
from rrrobot.robot.faults import MOVING, inertia_matrix, listed, shown
from rrrobot.robot.tree import path_down

_TRIANGLE = 5e-3
"""Part of C by which A + B may miss it: exporters print few digits."""
_NOTHING = 1e-6
"""Part of the robot's mass times its reach squared below which a moment changes no motion."""
_FAR = 3.0
"""Radius of gyration over the robot's reach from which it is suspicious."""
_KNOWN = {
    "robot": {"link", "joint", "material", "transmission", "gazebo", "sensor", "sensors", "group",
              "group_state", "disable_collisions", "ros2_control", "end_effector", "virtual_joint",
              "author"},
    "dynamics": {"damping", "friction"},
}  # fmt: skip
_ONCE = {"link": ("inertial",), "joint": ("origin", "axis", "limit", "dynamics", "mimic")}
_SHELLS = ("shell", "ball", "sphere", "hull")


def warn_of_parts(tree: Element) -> None:
    """Warn of what a URDF has and the models leave out, of links twice described."""
    parts: list[str] = []
    moving = {joint.get("name") for joint in tree.findall("joint") if joint.get("type") in MOVING}
    for element in tree:
        if ":" not in element.tag and element.tag not in _KNOWN["robot"]:
            parts.append(f"<{element.tag[:40]}>{_at(element)}")
    for joint in tree.findall("joint"):
        for dynamics in joint.findall("dynamics"):
            extra = sorted(set(dynamics.keys()) - _KNOWN["dynamics"])
            if extra:
                parts.append(f"{listed(extra)} of joint {joint.get('name')}{_at(dynamics)}")
        for mimic in joint.findall("mimic"):
            if mimic.get("joint") not in moving:
                what = (
                    f"{shown(joint.get('name'))} (of {shown(mimic.get('joint'))}, which moves not)"
                )
                parts.append(f"mimic joint {what}{_at(mimic)}")
    for owner in (*tree.findall("link"), *tree.findall("joint")):
        for tag in _ONCE[owner.tag]:
            if len(owner.findall(tag)) > 1:
                parts.append(f"the second <{tag}> of {owner.tag} {owner.get('name')}{_at(owner)}")
    if parts:
        more = f" and {len(parts) - 10} more" if len(parts) > 10 else ""
        warnings.warn(
            f"robot {tree.get('name')!r} has parts that no model here takes into account: "
            f"{'; '.join(parts[:10])}{more}.",
            UrdfWarning,
            stacklevel=4,
        )


def _at(element: Any) -> str:
    line = getattr(element, "line", 0)
    return f" (line {line})" if line else ""


def warn_of_inertias(tree: Element, robot: Any) -> None:
    """Warn of inertias that no body can have, all links in one message.

    Args:
        tree: the checked URDF.
        robot: the `Robot` that it makes.
    """
    reach = _reach(robot)
    nothing = _NOTHING * robot.mass * reach**2
    thin, wide = [], []
    for link in tree.findall("link"):
        mass, inertia = link.find("inertial/mass"), link.find("inertial/inertia")
        if mass is None or inertia is None:
            continue
        keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        matrix = inertia_matrix([float(str(inertia.get(key))) for key in keys])
        a, b, c = np.linalg.eigvalsh(matrix).tolist()
        name = str(link.get("name"))
        if max(c - a - b, -a) > max(_TRIANGLE * c, nothing):
            thin.append(f"{name} ({a:.3g}, {b:.3g}, {c:.3g})")
        m = float(str(mass.get("value")))
        gyration = math.sqrt(max(c, 0.0) / m) if m else 0.0
        if gyration > _FAR * reach:
            wide.append(f"{name} ({gyration:.3g} m)")
    told = []
    if thin:
        told.append(f"principal moments A + B < C, which no body has, in kg m^2: {listed(thin)}")
    if wide:
        told.append(
            f"radii of gyration far beyond the robot's reach of {reach:.3g} m: {listed(wide)}"
            + _period(robot)
        )
    if told:
        warnings.warn(
            f"robot {robot.name!r} has suspicious inertias: {'; '.join(told)}. Check the units "
            "(kg m^2, not kg mm^2) and the export; they are used as they are.",
            UrdfWarning,
            stacklevel=4,
        )


def _reach(robot: Any) -> float:
    """Distance of the farthest part from the shell's centre [m]."""
    model = robot.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    center = data.oMi[1].act(robot.shell_placement.translation)
    points = [frame.translation for frame in data.oMf]
    points += [data.oMi[i].act(body.lever) for i, body in enumerate(model.inertias) if i]
    shell, axes = robot.shell, np.vstack((np.eye(3), -np.eye(3)))
    if isinstance(shell, FlatBelly):
        size = math.hypot(shell.half_length or 0.0, shell.half_width or 0.0)
    else:
        size = max(float(np.linalg.norm(shell.contact(u))) for u in axes)
    return size + max(float(np.linalg.norm(point - center)) for point in points)


def _period(robot: Any) -> str:
    """The rocking period that follows, in words; nothing where it is no simple one."""
    if not isinstance(robot.shell, Sphere):
        return ""
    model = robot.model
    data = model.createData()
    q = pin.neutral(model)
    body = pin.crba(model, data, q)[:6, :6]
    mass = body[0, 0]
    lever = np.array((-body[2, 4], -body[0, 5], -body[1, 3])) / mass
    below = robot.shell_placement.translation[2] - lever[2]
    if below <= 0:
        return ""
    inertia = float(body[4, 4]) - mass * float(lever[0] ** 2 + lever[2] ** 2)
    about = inertia + mass * (robot.shell.radius - below) ** 2
    period = 2 * math.pi * math.sqrt(about / (mass * 9.81 * below))
    return f", so that it rocks with a period of {period:.3g} s"


def warn_of_shell(tree: Element, root: str, radius: float | None) -> None:
    """Warn where a link that moves against the root looks like the ball, and none was named."""
    if any(word in root.lower() for word in _SHELLS):
        return
    likely = []
    for link in tree.findall("link"):
        name = str(link.get("name"))
        moves = any(j.get("type") in MOVING for j in path_down(tree, name))
        if not moves:
            if _has_ball(link, radius) or any(word in name.lower() for word in _SHELLS):
                return
            continue
        if _has_ball(link, radius) or name.lower() in _SHELLS:
            likely.append(name)
    if likely:
        warnings.warn(
            f"the shell is put on the root link {root!r}, and link {likely[0]!r}, which moves "
            f"against it, looks like the ball: if it is, say shell_link={likely[0]!r}.",
            UrdfWarning,
            stacklevel=4,
        )


def _has_ball(link: Element, radius: float | None) -> bool:
    """Whether a link shows or collides as a sphere of that radius, within 2 %."""
    if radius is None:
        return False
    for sphere in (
        *link.findall("visual/geometry/sphere"),
        *link.findall("collision/geometry/sphere"),
    ):
        try:
            if abs(float(sphere.get("radius", "nan")) / radius - 1) < 0.02:
                return True
        except ValueError:
            continue
    return False
