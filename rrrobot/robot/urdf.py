"""URDF text: RRRobot from its parameters, and reduced-joint versions of any robot.

A reduced-joint URDF puts a chain of joints between a fixed `world` and the robot's root link, so
that the body keeps only the freedoms that a simplified model needs:

    pivoting   yaw (z), pitch (y), roll (x)      the three Euler angles, in Pinocchio's order
    roll       travel (y), roll (x)              rolls sideways
    pitch      travel (x), pitch (y)             rolls forward
    yaw        yaw (z)

The chain starts at the given height, which is the shell's radius, and ends at the shell's centre;
where that is not the root link's origin, a fixed joint leads to the root link.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import finite, vector
from rrrobot.errors import UrdfError
from rrrobot.files import write_whole
from rrrobot.robot.faults import root_link
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.reader import parse_urdf, urdf_text

ReducedKind = Literal["pivoting", "roll", "pitch", "yaw"]

LEGS = ("leg_1", "leg_2")
"""Joint names of RRRobot's legs; Pinocchio sorts siblings by name, so leg 1 comes first."""

CHAINS: dict[str, tuple[tuple[str, str, str], ...]] = {
    "pivoting": (
        ("base_yaw", "revolute", "0 0 1"),
        ("base_pitch", "revolute", "0 1 0"),
        ("base_roll", "revolute", "1 0 0"),
    ),
    "roll": (("base_travel", "prismatic", "0 1 0"), ("base_roll", "revolute", "1 0 0")),
    "pitch": (("base_travel", "prismatic", "1 0 0"), ("base_pitch", "revolute", "0 1 0")),
    "yaw": (("base_yaw", "revolute", "0 0 1"),),
}
"""Joints (name, type, axis) from the world to the shell's centre of each reduced-joint URDF."""
_TO_CENTRE = "shell_centre"
"""Fixed joint from the last of them to a root link whose origin is elsewhere."""

_COLOURS = {
    "shell": "0.93 0.91 0.86 1",
    "band_x": "0.84 0.37 0.00 1",
    "band_y": "0.00 0.45 0.70 1",
    "band_z": "0.25 0.25 0.25 1",
    "mass": "0.20 0.20 0.22 1",
    "leg_1": "0.00 0.62 0.45 1",
    "leg_2": "0.80 0.47 0.65 1",
}


def rrrobot_urdf(parameters: RRRobotParameters | None = None) -> str:
    """URDF of RRRobot: a striped shell, a battery, two servos and two legs.

    The root link `shell` has its origin at the sphere's centre, x forward, y left, z up. Joints
    `leg_1` at (0, -b, 0) and `leg_2` at (0, b, 0) turn about -y, so that an angle of 0 points
    forward and pi/2 straight up. Mass points are links with a mass and no rotational inertia.

    Args:
        parameters: Table 2 unless told otherwise.

    Returns:
        the URDF as text.

    Example:
        >>> import rrrobot as rr
        >>> "leg_1" in rr.rrrobot_urdf(rr.RRRobotParameters())
        True
    """
    p = parameters or RRRobotParameters()
    r, b = p.shell_radius, p.hip_offset
    robot = ET.Element("robot", name="rrrobot", version="1.1")
    for name, rgba in _COLOURS.items():
        ET.SubElement(ET.SubElement(robot, "material", name=name), "color", rgba=rgba)

    shell = ET.SubElement(robot, "link", name="shell")
    _visual(shell, "shell", _Shape("sphere", radius=r))
    # Three great-circle bands, each the rim of a thin disc that stands out of the shell, show
    # any rotation; a ball of one colour shows none.
    # They stand out unequally, so that they do not flicker where they cross.
    bands = (("x", (0, math.pi / 2, 0)), ("y", (math.pi / 2, 0, 0)), ("z", (0, 0, 0)))
    for i, (axis, rpy) in enumerate(bands):
        disc = _Shape("cylinder", radius=(1.006 + 0.002 * i) * r, length=0.08 * r)
        _visual(shell, f"band_{axis}", disc, rpy=rpy)

    # The mass is a point on the shell; its ball is drawn inside, clear of the ground.
    ball = _Shape("sphere", radius=0.15 * r)
    _mass_point(robot, "battery", p.battery_mass, ball, drawn_at=(0, 0, 0.15 * r))
    _joint(robot, "battery_mount", "fixed", "shell", "battery", (0, 0, -r))
    for i, (leg, side) in enumerate(zip(LEGS, (-b, b), strict=True)):
        size = 0.2 * r
        servo, tip = f"servo_{i + 1}", f"{leg}_link"
        _mass_point(robot, servo, p.servo_masses[i], _Shape("box", size=(size, size, size)))
        _joint(robot, f"{servo}_mount", "fixed", "shell", servo, (0, side, 0))
        length = p.leg_lengths[i]
        link = _mass_point(
            robot, tip, p.leg_masses[i], _Shape("sphere", radius=0.14 * r), (length, 0, 0), leg
        )
        rod = _Shape("cylinder", radius=0.04 * r, length=length)
        _visual(link, leg, rod, (length / 2, 0, 0), (0, math.pi / 2, 0))
        _joint(robot, leg, "revolute", "shell", tip, (0, side, 0), "0 -1 0")
    return _text(robot)


def reduced_urdf(
    urdf: str, kind: ReducedKind, *, height: float = 0.0, centre: ArrayLike = (0.0, 0.0, 0.0)
) -> str:
    """The URDF with the body's freedoms reduced to those of a simplified model.

    Args:
        urdf: text of any URDF with one root link.
        kind: "pivoting", "roll", "pitch" or "yaw"; see the module's table.
        height: of the centre above the ground [m].
        centre: what the body turns about, in the root link's frame (3,) [m].

    Returns:
        the URDF as text: a new root link `world`, then the chain, then the robot as it was.

    Raises:
        UrdfError: an unknown kind, a name that the chain needs is taken, a malformed URDF.

    Example:
        >>> import pinocchio as pin, rrrobot as rr
        >>> yaw = rr.robot.reduced_urdf(rr.rrrobot_urdf(), "yaw", height=0.12)
        >>> list(pin.buildModelFromXML(yaw).names)
        ['universe', 'base_yaw', 'leg_1', 'leg_2']
    """
    if kind not in CHAINS:
        raise UrdfError(f"kind is {kind!r}: it must be one of {', '.join(CHAINS)}.")
    height, centre = finite("height", height, "m"), vector("centre", centre, 3)
    robot = parse_urdf(urdf)
    root = root_link(robot)
    taken = {str(e.get("name")) for tag in ("link", "joint") for e in robot.findall(tag)}
    aside = bool(np.any(centre))
    chain = [f"{name}_link" for name, _, _ in (CHAINS[kind] if aside else CHAINS[kind][:-1])]
    links = ["world", *chain, root]
    joints = {name for name, _, _ in CHAINS[kind]} | ({_TO_CENTRE} if aside else set())
    clash = sorted(taken & ({*links[:-1]} | joints))
    if clash:
        raise UrdfError(
            f"the URDF already has {', '.join(clash)}: rename it; the {kind} chain needs that name."
        )
    for link in links[:-1]:
        ET.SubElement(robot, "link", name=link)
    for i, (name, joint, axis) in enumerate(CHAINS[kind]):
        _joint(robot, name, joint, links[i], links[i + 1], (0, 0, 0 if i else height), axis)
    if aside:
        _joint(robot, _TO_CENTRE, "fixed", links[-2], root, tuple(-centre))
    robot.set("name", f"{robot.get('name', 'robot')}_{kind}")
    return _text(robot)


def rrrobot_files(parameters: RRRobotParameters | None = None) -> dict[str, str]:
    """File name -> text of the five URDFs that the package ships."""
    p = parameters or RRRobotParameters()
    full = rrrobot_urdf(p)
    files = {"rrrobot.urdf": full}
    for kind in CHAINS:
        files[f"{kind}.urdf"] = reduced_urdf(full, kind, height=p.shell_radius)  # type: ignore[arg-type]
    return files


def urdf_path(name: str = "rrrobot") -> Path:
    """Path of a shipped URDF file: rrrobot, pivoting, roll, pitch or yaw.

    Example:
        >>> import rrrobot as rr
        >>> rr.urdf_path("yaw").name
        'yaw.urdf'
    """
    known = ("rrrobot", *CHAINS)
    here = Path(__file__).resolve().parent.parent
    for folder in (here / "urdf_files", here.parent / "urdf"):
        path = folder / f"{name}.urdf"
        if name in known and path.is_file():
            return path
    raise UrdfError(f"there is no shipped URDF {name!r}: it must be one of {', '.join(known)}.")


class _Shape:
    """A URDF <geometry> element."""

    def __init__(self, tag: str, **attributes: float | tuple[float, ...]) -> None:
        self.tag = tag
        self.attributes = {
            key: _numbers(value) if isinstance(value, tuple) else _numbers((value,))
            for key, value in attributes.items()
        }


def _numbers(values: tuple[float, ...]) -> str:
    return " ".join(repr(float(v)) for v in values)


def _origin(
    parent: ET.Element, xyz: tuple[float, ...] = (0, 0, 0), rpy: tuple[float, ...] = (0, 0, 0)
) -> None:
    ET.SubElement(parent, "origin", xyz=_numbers(xyz), rpy=_numbers(rpy))


def _visual(
    link: ET.Element,
    material: str,
    shape: _Shape,
    xyz: tuple[float, ...] = (0, 0, 0),
    rpy: tuple[float, ...] = (0, 0, 0),
) -> None:
    visual = ET.SubElement(link, "visual", name=f"{link.get('name')}_{material}_{shape.tag}")
    _origin(visual, xyz, rpy)
    ET.SubElement(ET.SubElement(visual, "geometry"), shape.tag, shape.attributes)
    ET.SubElement(visual, "material", name=material)


def _mass_point(
    robot: ET.Element,
    name: str,
    mass: float,
    shape: _Shape,
    xyz: tuple[float, ...] = (0, 0, 0),
    material: str = "mass",
    drawn_at: tuple[float, ...] | None = None,
) -> ET.Element:
    link = ET.SubElement(robot, "link", name=name)
    inertial = ET.SubElement(link, "inertial")
    _origin(inertial, xyz)
    ET.SubElement(inertial, "mass", value=repr(mass))
    zero = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0")
    ET.SubElement(inertial, "inertia", zero)
    _visual(link, material, shape, drawn_at or xyz)
    return link


def _joint(
    robot: ET.Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    xyz: tuple[float, ...],
    axis: str | None = None,
) -> None:
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    _origin(joint, xyz)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    if axis is not None:
        ET.SubElement(joint, "axis", xyz=axis)
        # URDF demands limits of a revolute or prismatic joint; these bind nothing.
        ET.SubElement(joint, "limit", lower="-1e9", upper="1e9", effort="1e9", velocity="1e9")


def _text(robot: ET.Element) -> str:
    ET.indent(robot)
    return urdf_text(robot) + "\n"


def main(folder: str = "urdf") -> None:
    """Write the five URDFs, as `make urdf` does."""
    for name, text in rrrobot_files().items():
        write_whole(Path(folder) / name, text.encode())
