"""URDF text of robots with any number of legs on a flat box, from a few lengths and masses."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from typing import NamedTuple

from rrrobot.checks import Array, finite, vector
from rrrobot.errors import ParameterError
from rrrobot.robot.reader import urdf_text

_MOST_LEGS = 40
_CHAINS = {
    1: {"hfe": "shank"},
    2: {"hfe": "thigh", "kfe": "shank"},
    3: {"haa": "hip", "hfe": "thigh", "kfe": "shank"},
}
"""Joint -> the part that it moves, of legs with so many joints."""
_RANGE = {"haa": math.pi, "hfe": math.pi, "kfe": 2.8}
_SHARES = {"hip": 0.2, "thigh": 0.5, "shank": 0.3}
"""Parts of a leg's mass, as far as the leg has them."""
_COLOURS = {"body": "0.93 0.91 0.86 1", "hip": "0.20 0.20 0.22 1", "leg": "0.00 0.45 0.70 1"}


class _Part(NamedTuple):
    """A solid: URDF geometry, where its middle is in the link, and its inertia for a unit mass."""

    tag: str
    attributes: dict[str, str]
    middle: tuple[float, float, float]
    inertia: tuple[float, float, float]


def legged_urdf(
    n_limbs: int = 6,
    *,
    n_joints: int = 3,
    body_size: tuple[float, float, float] = (0.4, 0.2, 0.1),
    body_mass: float = 3.0,
    thigh_length: float = 0.16,
    shank_length: float = 0.16,
    leg_mass: float = 0.4,
    max_rate: float = 12.0,
    max_torque: float = 3.0,
) -> str:
    """URDF of a robot with any number of legs on a box.

    Legs come in pairs at the box's sides, left and right, evenly from the front to the back; an odd
    one stands at the middle of the front, and a single leg at the middle of the top. All joints at
    zero, legs point straight down. Joints are L1_haa, L1_hfe, L1_kfe, R1_haa, ...; C_haa, ... of
    the odd leg: abduction about x, hip flexion about y, knee flexion about y. The body's underside
    is flat, as that of most robots: its belly is what `fit_belly` makes of it.

    Args:
        n_limbs: how many legs, from 1.
        n_joints: of each leg: 1 (hfe), 2 (hfe, kfe) or 3 (haa, hfe, kfe).
        body_size: length, width, height of the box [m].
        body_mass: of the box [kg].
        thigh_length, shank_length: from hip to knee, from knee to foot [m].
        leg_mass: of one leg [kg], evenly in thigh and shank, with a hip where there is abduction.
        max_rate: of every joint [rad/s].
        max_torque: of every joint [N m].

    Returns:
        the URDF as text.

    Raises:
        ParameterError: a number out of range.

    Example:
        >>> import rrrobot as rr
        >>> hexapod = rr.robot.legged_urdf(6)
        >>> rr.Robot.from_urdf(hexapod, shell=rr.Sphere(0.3), shell_center=(0, 0, 0.25)).n_legs
        18
    """
    for name, number, most in (
        ("n_limbs", n_limbs, _MOST_LEGS),
        ("n_joints", n_joints, len(_CHAINS)),
    ):
        if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= most:
            raise ParameterError(f"{name} is {number!r}: it must be a whole number, 1 to {most}.")
    size = vector("body_size", body_size, 3, "m", labels=("length", "width", "height"))
    if not (size > 0).all():
        raise ParameterError(f"body_size is {size.tolist()} m: each must be greater than zero.")
    lengths = {
        "thigh": finite("thigh_length", thigh_length, "m", above=0),
        "shank": finite("shank_length", shank_length, "m", above=0),
    }
    masses = _leg_masses(finite("leg_mass", leg_mass, "kg", above=0), n_joints)
    ends = (
        finite("max_rate", max_rate, "rad/s", above=0),
        finite("max_torque", max_torque, "N m", above=0),
    )
    robot = ET.Element("robot", name=f"legged_{n_limbs}x{n_joints}")
    for name, rgba in _COLOURS.items():
        ET.SubElement(ET.SubElement(robot, "material", name=name), "color", rgba=rgba)
    length, width, height = size.tolist()
    squares = (width**2 + height**2, length**2 + height**2, length**2 + width**2)
    box = _Part("box", {"size": _row(*size)}, (0, 0, 0), _scaled(squares, 1 / 12))
    _link(robot, "body", "body", finite("body_mass", body_mass, "kg", above=0), [box])
    for name, hip in _hips(n_limbs, size):
        _leg(robot, name, hip, n_joints, lengths, masses, ends)
    ET.indent(robot)
    return urdf_text(robot) + "\n"


def _hips(legs: int, size: Array) -> list[tuple[str, tuple[float, float, float]]]:
    """Name and place of each leg's hip."""
    length, width, height = size.tolist()
    if legs == 1:
        return [("C", (0.0, 0.0, height / 2))]
    pairs, found = legs // 2, []
    for i in range(pairs):
        x = length / 2 - (length * i / (pairs - 1) if pairs > 1 else length / 2)
        for side, y in (("L", width / 2), ("R", -width / 2)):
            found.append((f"{side}{i + 1}", (x, y, 0.0)))
    if legs % 2:
        found.append(("C", (length / 2, 0.0, 0.0)))
    return found


def _leg_masses(mass: float, joints: int) -> dict[str, float]:
    parts = _CHAINS[joints].values()
    whole = sum(_SHARES[part] for part in parts)
    return {part: mass * _SHARES[part] / whole for part in parts}


def _leg(
    robot: ET.Element,
    name: str,
    hip: tuple[float, float, float],
    joints: int,
    lengths: dict[str, float],
    masses: dict[str, float],
    ends: tuple[float, float],
) -> None:
    """One leg: hip, thigh and shank as far as it has joints; a leg of one joint is a rod."""
    parent, at = "body", hip
    for kind, part in _CHAINS[joints].items():
        link = f"{name}_{part}"
        radius = 0.09 * min(lengths.values())
        if part == "hip":
            solids = [_ball(1.6 * radius, (0.0, 0.0, 0.0))]
        else:
            long = lengths[part] if joints > 1 else sum(lengths.values())
            solids = [_rod(radius, long)]
            if part == "shank":
                solids.append(_ball(1.3 * radius, (0.0, 0.0, -long)))
        _link(robot, link, "hip" if part == "hip" else "leg", masses[part], solids)
        joint = ET.SubElement(robot, "joint", name=f"{name}_{kind}", type="revolute")
        ET.SubElement(joint, "origin", xyz=_row(*at), rpy="0 0 0")
        ET.SubElement(joint, "parent", link=parent)
        ET.SubElement(joint, "child", link=link)
        ET.SubElement(joint, "axis", xyz="1 0 0" if kind == "haa" else "0 1 0")
        rate, torque = (repr(end) for end in ends)
        reach = _RANGE[kind]
        ET.SubElement(
            joint, "limit", lower=repr(-reach), upper=repr(reach), effort=torque, velocity=rate
        )
        parent = link
        at = (0.0, 0.0, 0.0) if part == "hip" else (0.0, 0.0, -lengths["thigh"])


def _rod(radius: float, length: float) -> _Part:
    across = radius**2 / 4 + length**2 / 12
    attributes = {"radius": repr(radius), "length": repr(length)}
    return _Part("cylinder", attributes, (0, 0, -length / 2), (across, across, radius**2 / 2))


def _ball(radius: float, middle: tuple[float, float, float]) -> _Part:
    return _Part("sphere", {"radius": repr(radius)}, middle, _scaled((1, 1, 1), 0.4 * radius**2))


def _link(robot: ET.Element, name: str, colour: str, mass: float, parts: list[_Part]) -> None:
    """A link of solids; its mass is the first one's."""
    link = ET.SubElement(robot, "link", name=name)
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=_row(*parts[0].middle), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=repr(mass))
    xx, yy, zz = (repr(mass * entry) for entry in parts[0].inertia)
    ET.SubElement(inertial, "inertia", ixx=xx, iyy=yy, izz=zz, ixy="0", ixz="0", iyz="0")
    for kind in ("visual", "collision"):
        for part in parts:
            solid = ET.SubElement(link, kind)
            ET.SubElement(solid, "origin", xyz=_row(*part.middle), rpy="0 0 0")
            ET.SubElement(ET.SubElement(solid, "geometry"), part.tag, part.attributes)
            if kind == "visual":
                ET.SubElement(solid, "material", name=colour)


def _scaled(values: tuple[float, float, float], factor: float) -> tuple[float, float, float]:
    x, y, z = values
    return x * factor, y * factor, z * factor


def _row(*values: float) -> str:
    return " ".join(repr(float(value)) for value in values)
