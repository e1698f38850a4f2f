"""A robot with other numbers in its URDF: masses, inertias, lengths, losses, the shell's radius."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from rrrobot.checks import finite
from rrrobot.contact.surfaces import Sphere
from rrrobot.errors import ParameterError
from rrrobot.robot.faults import listed, shown
from rrrobot.robot.reader import parse_urdf, urdf_text
from rrrobot.robot.robot import Robot

_PRODUCTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_OF_LINKS = ("mass", *_PRODUCTS)
_OF_JOINTS = ("length", "damping", "friction")


def varied(robot: Robot, changes: Mapping[str, float]) -> Robot:
    """The robot with some numbers of its URDF changed; it is checked as any other.

    Args:
        robot: from a URDF. One from `RRRobotParameters` has those instead.
        changes: name -> value. `LINK.mass` [kg], the inertia of the link growing with it;
            `LINK.ixx`, ... `LINK.izz` [kg m^2]; `JOINT.length`, the distance of its origin from
            its parent's, in the same direction [m]; `JOINT.damping` [N m s/rad] and
            `JOINT.friction` [N m]; `shell.radius` of a sphere [m], unless a link is so called.

    Raises:
        ParameterError: a name that is none of these, or a value that is not finite.
        UrdfError: the changed file is no sound robot.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_urdf(rr.urdf_path("rrrobot"), shell=rr.Sphere(0.12))
        >>> heavy = rr.robot.varied(robot, {"leg_1_link.mass": 0.1, "shell.radius": 0.13})
        >>> round(heavy.mass - robot.mass, 6), heavy.shell.radius
        (0.043, 0.13)
    """
    if robot.parameters is not None:
        raise ParameterError(
            f"{robot!r} was made from RRRobotParameters: change those, with dataclasses.replace "
            "and Robot.from_parameters."
        )
    tree, shell = parse_urdf(robot.urdf), robot.shell
    owners: dict[str, Any] = {str(e.get("name")): e for e in tree.findall("joint")}
    owners |= {str(e.get("name")): e for e in tree.findall("link")}
    for name, value in changes.items():
        number = finite(name, value)
        owner, _, quantity = name.rpartition(".")
        if (owner, quantity) == ("shell", "radius"):
            if not isinstance(shell, Sphere):
                raise ParameterError(f"shell.radius is of a Sphere, and the shell is {shell!r}.")
            shell = Sphere(number)
            continue
        element = owners.get(owner)
        known = () if element is None else _OF_LINKS if element.tag == "link" else _OF_JOINTS
        if element is None or quantity not in known:
            raise ParameterError(
                f"{shown(name)} is no parameter of {robot.name}: write LINK.mass, LINK.ixx, ..., "
                "JOINT.length, JOINT.damping, JOINT.friction or shell.radius; its links and joints "
                f"are {listed(owners)}."
            )
        _change(element, owner, quantity, number)
    return replace(robot, urdf=urdf_text(tree), shell=shell)


def _change(element: Element, owner: str, quantity: str, value: float) -> None:
    if element.tag == "link":
        mass, inertia = element.find("inertial/mass"), element.find("inertial/inertia")
        if mass is None or inertia is None:
            raise ParameterError(f"link {shown(owner)} has no mass and inertia to change.")
        if quantity != "mass":
            inertia.set(quantity, repr(value))
            return
        before = float(str(mass.get("value")))
        mass.set("value", repr(value))
        for key in _PRODUCTS if before > 0 else ():
            inertia.set(key, repr(float(str(inertia.get(key))) * value / before))
    elif quantity == "length":
        origin = element.find("origin")
        xyz = np.array([float(x) for x in str("" if origin is None else origin.get("xyz")).split()])
        size = float(np.linalg.norm(xyz)) if xyz.size == 3 else 0.0
        if origin is None or not size > 0:
            raise ParameterError(f"joint {shown(owner)} is at its parent's origin: no length.")
        origin.set("xyz", " ".join(repr(float(x)) for x in xyz * value / size))
    else:
        dynamics = element.find("dynamics")
        if dynamics is None:
            dynamics = Element("dynamics")
            element.append(dynamics)
        dynamics.set(quantity, repr(value))
