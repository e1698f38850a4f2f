"""URDF text: RRRobot from its parameters, safe reading, and reduced-joint versions of any robot.

A reduced-joint URDF puts a chain of joints between a fixed `world` and the robot's root link, so
that the body keeps only the freedoms that a simplified model needs:

    pivoting   yaw (z), pitch (y), roll (x)      the three Euler angles, in Pinocchio's order
    roll       travel (y), roll (x)              rolls sideways
    pitch      travel (x), pitch (y)             rolls forward
    yaw        yaw (z)

The chain starts at the given height, which is the shell's radius: the root link's origin, the
shell's centre, then stands where it stands on the ground.
"""

from __future__ import annotations

import math
import sys
import xml.etree.ElementTree as ET
from collections import Counter
from pathlib import Path
from typing import Literal
from xml.parsers import expat

import numpy as np

from rrrobot.checks import finite
from rrrobot.errors import UrdfError
from rrrobot.files import write_whole
from rrrobot.parameters import RRRobotParameters

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
"""Joints (name, type, axis) from the world to the root link of each reduced-joint URDF."""

# Limits beyond any robot that stands. Pinocchio's parser recurses along a chain of links and takes
# the process with it when its stack ends.
_MAX_BYTES = 10_000_000
_MAX_LINKS = 1000
_MAX_CHAIN = 250
_MAX_NESTING = 100

_JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_RESERVED = ("universe", "root_joint")
_PRODUCTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_NUMBERS: dict[str, dict[str, tuple[str, ...]]] = {
    "link": {
        "inertial/mass": ("value",),
        "inertial/inertia": _PRODUCTS,
        "inertial/origin": ("xyz", "rpy"),
        "visual/origin": ("xyz", "rpy"),
        "collision/origin": ("xyz", "rpy"),
    },
    "joint": {
        "origin": ("xyz", "rpy"),
        "axis": ("xyz",),
        "limit": ("effort", "velocity", "lower", "upper"),
    },
}
_OPTIONAL = {("origin", "xyz"), ("origin", "rpy"), ("limit", "lower"), ("limit", "upper")}
# Exporters print rounding errors: well-known robots have moments of inertia of -4e-8 kg m^2.
_INERTIA_TOLERANCE = 1e-6
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
    for axis, rpy in (("x", (0, math.pi / 2, 0)), ("y", (math.pi / 2, 0, 0)), ("z", (0, 0, 0))):
        disc = _Shape("cylinder", radius=1.006 * r, length=0.08 * r)
        _visual(shell, f"band_{axis}", disc, rpy=rpy)

    _mass_point(robot, "battery", p.battery_mass, _Shape("sphere", radius=0.15 * r))
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


def reduced_urdf(urdf: str, kind: ReducedKind, *, height: float = 0.0) -> str:
    """The URDF with the body's freedoms reduced to those of a simplified model.

    Args:
        urdf: text of any URDF with one root link.
        kind: "pivoting", "roll", "pitch" or "yaw"; see the module's table.
        height: of the root link's origin above the ground [m].

    Returns:
        the URDF as text: a new root link `world`, then the chain, then the robot as it was.

    Raises:
        UrdfError: an unknown kind, a name that the chain needs is taken, a malformed URDF.

    Example:
        >>> import pinocchio as pin, rrrobot as rr
        >>> yaw = rr.reduced_urdf(rr.rrrobot_urdf(), "yaw", height=0.12)
        >>> list(pin.buildModelFromXML(yaw).names)
        ['universe', 'base_yaw', 'leg_1', 'leg_2']
    """
    if kind not in CHAINS:
        raise UrdfError(f"kind is {kind!r}: it must be one of {', '.join(CHAINS)}.")
    height = finite("height", height, "m")
    robot = parse_urdf(urdf)
    root = root_link(robot)
    taken = {str(e.get("name")) for tag in ("link", "joint") for e in robot.findall(tag)}
    links = ["world", *(f"{name}_link" for name, _, _ in CHAINS[kind][:-1]), root]
    clash = sorted(taken & ({*links[:-1]} | {name for name, _, _ in CHAINS[kind]}))
    if clash:
        raise UrdfError(
            f"the URDF already has {', '.join(clash)}: rename it; the {kind} chain needs that name."
        )
    for link in links[:-1]:
        ET.SubElement(robot, "link", name=link)
    for i, (name, joint, axis) in enumerate(CHAINS[kind]):
        _joint(robot, name, joint, links[i], links[i + 1], (0, 0, 0 if i else height), axis)
    robot.set("name", f"{robot.get('name', 'robot')}_{kind}")
    return _text(robot)


def parse_urdf(text: str) -> ET.Element:
    """Parse URDF text and check what a dynamics library relies on.

    A document type declaration is refused, so entities can neither expand nor reach out.

    Returns:
        the <robot> element; `urdf_text` writes it so that every parser reads the same.

    Raises:
        UrdfError: malformed XML, a DOCTYPE, no <robot>, links and joints that are not one tree,
            a joint without what its type needs, a number that is missing or none, a negative or
            non-finite mass or inertia, a file beyond all size.
    """
    try:
        raw = text.encode()
        _check_size(len(raw))
        _check_markup(raw)
        robot = ET.fromstring(raw, ET.XMLParser(encoding="utf-8"))
    except UrdfError:
        raise
    except (expat.ExpatError, ET.ParseError, LookupError, ValueError) as error:
        raise UrdfError(f"the URDF is not well-formed XML: {error}.") from None
    if robot.tag != "robot":
        raise UrdfError(f"the file's root element is <{robot.tag}>: a URDF starts with <robot>.")
    if not robot.get("name"):
        raise UrdfError("the URDF's <robot> has no name: write <robot name=...>.")
    _check_names(robot)
    _check_tree(robot)
    _check_joints(robot)
    _check_numbers(robot)
    return robot


def urdf_text(robot: ET.Element) -> str:
    """What `parse_urdf` read, as text again: no comments, no declarations, plain white space.

    Pinocchio's parser reads some files otherwise than XML demands, and drops a mass that has
    spaces around it; from this text it reads what was checked.
    """
    return ET.tostring(robot, encoding="unicode")


def root_link(robot: ET.Element) -> str:
    """Name of the one link that is no joint's child.

    Raises:
        UrdfError: there is none or more than one.
    """
    children = {str(e.get("link")) for e in robot.findall("joint/child")}
    roots = [str(e.get("name")) for e in robot.findall("link") if e.get("name") not in children]
    if len(roots) != 1:
        raise UrdfError(
            f"the URDF has {len(roots)} root links ({_listed(roots) or 'a loop'}): a robot is "
            "one tree with one root link."
        )
    return roots[0]


def read_urdf(source: str | Path) -> str:
    """Text of a URDF file, or of a string that is URDF already; checked by `parse_urdf`.

    Raises:
        UrdfError: the file is missing, unreadable, not UTF-8, or not a sound URDF.
    """
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        parse_urdf(source)
        return source
    path = Path(source)
    try:
        with path.open("rb") as stream:
            raw = stream.read(_MAX_BYTES + 1)
    except FileNotFoundError:
        raise UrdfError(f"there is no URDF file {str(path)!r}: check the path.") from None
    except (OSError, ValueError) as error:
        raise UrdfError(f"the URDF file {str(path)!r} cannot be read: {error}.") from None
    try:
        _check_size(len(raw))
        text = raw.decode("utf-8-sig")
        parse_urdf(text)
    except UnicodeDecodeError:
        raise UrdfError(f"the URDF file {str(path)!r} is not UTF-8 text.") from None
    except UrdfError as error:
        raise UrdfError(f"{path}: {error}") from None
    return text


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
    here = Path(__file__).resolve().parent
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
) -> ET.Element:
    link = ET.SubElement(robot, "link", name=name)
    inertial = ET.SubElement(link, "inertial")
    _origin(inertial, xyz)
    ET.SubElement(inertial, "mass", value=repr(mass))
    zero = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0")
    ET.SubElement(inertial, "inertia", zero)
    _visual(link, material, shape, xyz)
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


def _check_size(n: int) -> None:
    if n > _MAX_BYTES:
        raise UrdfError(f"the URDF has more than {_MAX_BYTES} bytes: that is the limit.")


def _check_markup(raw: bytes) -> None:
    """Refuse a DOCTYPE where it begins, and elements nested too deep; expat's errors pass."""
    depth = 0

    def doctype(*_: object) -> None:
        raise UrdfError(
            "the URDF declares a DOCTYPE: entities are not allowed in a robot file; remove it."
        )

    def start(tag: str, _: object) -> None:
        nonlocal depth
        depth += 1
        if depth > _MAX_NESTING:
            raise UrdfError(f"<{tag}> is nested {depth} deep: the limit is {_MAX_NESTING}.")

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1

    # The text is UTF-8 whatever its declaration says.
    guard = expat.ParserCreate("utf-8")
    guard.StartDoctypeDeclHandler = doctype
    guard.StartElementHandler, guard.EndElementHandler = start, end
    guard.Parse(raw, True)


def _check_names(robot: ET.Element) -> None:
    """Links exist and are not too many; names are unique, not empty and not Pinocchio's own."""
    for tag in ("link", "joint"):
        names = Counter(e.get("name") for e in robot.findall(tag))
        if tag == "link" and not names:
            raise UrdfError("the URDF has no <link>: a robot needs at least one.")
        if names.total() > _MAX_LINKS:
            raise UrdfError(
                f"the URDF has {names.total()} <{tag}> elements: the limit is {_MAX_LINKS}."
            )
        double = [str(name) for name, count in names.items() if count > 1 or not name]
        if double:
            raise UrdfError(f"<{tag}> names must be unique and not empty: {_listed(double)}.")
        reserved = [name for name in _RESERVED if name in names]
        if reserved:
            raise UrdfError(f"a {tag} is named {reserved[0]!r}: Pinocchio needs that name; rename.")


def _check_tree(robot: ET.Element) -> None:
    """Joints join existing links, each link has one parent at most, and all are in one tree."""
    links = [str(e.get("name")) for e in robot.findall("link")]
    known, above, joint_of = set(links), dict[str, str](), dict[str, str]()
    for joint in robot.findall("joint"):
        name, ends = str(joint.get("name")), {}
        for end in ("parent", "child"):
            elements = joint.findall(end)
            if len(elements) > 1:
                raise UrdfError(f"joint {name!r} has {len(elements)} <{end}> elements: write one.")
            link = elements[0].get("link") if elements else None
            if link not in known:
                raise UrdfError(
                    f"joint {name!r} has the {end} link {link!r}, which the URDF does not "
                    f"define. Its links are: {_listed(links)}."
                )
            ends[end] = str(link)
        child = ends["child"]
        if child in above:
            raise UrdfError(
                f"link {child!r} is the child of the joints {joint_of[child]!r} and {name!r}: "
                "in a tree every link has one parent."
            )
        above[child], joint_of[child] = ends["parent"], name
    root = root_link(robot)
    for link in links:
        here, length = link, 1
        while here != root and length <= len(links):
            here, length = above[here], length + 1
        if here != root:
            raise UrdfError(f"link {link!r} hangs in a loop of joints: a robot is one tree.")
        if length > _MAX_CHAIN:
            raise UrdfError(
                f"link {link!r} is at the end of a chain of {length} links: the limit is "
                f"{_MAX_CHAIN}."
            )


def _check_joints(robot: ET.Element) -> None:
    """Joint types are URDF's, with the limits that URDF demands."""
    for joint in robot.findall("joint"):
        name, kind = joint.get("name"), joint.get("type")
        if kind not in _JOINT_TYPES:
            raise UrdfError(
                f"joint {name!r} has the type {kind!r}: it must be one of "
                f"{', '.join(_JOINT_TYPES)}."
            )
        if kind in ("revolute", "prismatic") and joint.find("limit") is None:
            raise UrdfError(
                f'joint {name!r} is {kind} and has no limits: add <limit effort="1" '
                'velocity="1" lower="-1" upper="1"/>; nothing here stops a joint at them.'
            )


def _check_numbers(robot: ET.Element) -> None:
    """Every number that enters the dynamics is there and finite; masses are not negative.

    Rewrites the numbers with single spaces between them.
    """
    for owner in (*robot.findall("link"), *robot.findall("joint")):
        place = f"of {owner.tag} {owner.get('name')!r}"
        for path, attributes in _NUMBERS[owner.tag].items():
            for element in owner.findall(path):
                values = {a: _read_numbers(element, a, place) for a in attributes}
                if element.tag == "mass" and values["value"][0] < 0:
                    shown = f"<mass value={element.get('value')!r}>"
                    raise UrdfError(f"{shown} {place} must not be negative.")
                if element.tag == "inertia":
                    _check_inertia([values[a][0] for a in attributes], place)
                moves = owner.get("type") in ("revolute", "continuous", "prismatic")
                length = math.hypot(*values["xyz"]) if element.tag == "axis" else 1.0
                if moves and not 1e-6 < length < 1e6:
                    shown = f"<axis xyz={element.get('xyz')!r}>"
                    raise UrdfError(f"{shown} {place} is no direction: write a unit vector.")
        for inertial in owner.findall("inertial"):
            if inertial.find("mass") is None:
                raise UrdfError(f"<inertial> {place} has no <mass>: add one.")


def _read_numbers(element: ET.Element, attribute: str, place: str) -> list[float]:
    """The numbers of an attribute, none if it may be missing and is."""
    text = element.get(attribute)
    if text is None and (element.tag, attribute) in _OPTIONAL:
        return []
    where = f"<{element.tag} {attribute}={text!r}> {place}"
    if text is None:
        raise UrdfError(f"<{element.tag}> {place} has no {attribute}: add it.")
    words = text.split()
    try:
        values = [_number(word) for word in words]
    except ValueError:
        raise UrdfError(f"{where} is not numeric: write plain numbers.") from None
    if not all(map(math.isfinite, values)):
        raise UrdfError(f"{where} must be finite.")
    size = 3 if attribute in ("xyz", "rpy") else 1
    if len(values) != size:
        raise UrdfError(f"{where} has {len(values)} numbers: it must have {size}.")
    element.set(attribute, " ".join(words))
    return values


def _number(word: str) -> float:
    """A number that C++ reads too: float() also takes 1_000 and the digits of other scripts."""
    if "_" in word or not word.isascii():
        raise ValueError(word)
    return float(word)


def _check_inertia(products: list[float], place: str) -> None:
    xx, xy, xz, yy, yz, zz = products
    least = float(np.linalg.eigvalsh(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))[0])
    if not least > -_INERTIA_TOLERANCE:
        raise UrdfError(
            f"<inertia> {place} has the principal moment {least:.4g} kg m^2: no moment of inertia "
            "is negative."
        )


def _listed(names: list[str]) -> str:
    """Names for a message, not more than fit in one."""
    shown = [name if len(name) <= 60 else f"{name[:57]}..." for name in names[:30]]
    return ", ".join(shown) + (f" and {len(names) - 30} more" if len(names) > 30 else "")


def main(folder: str = "urdf") -> None:
    """Write the five URDFs; `python -m rrrobot.urdf [folder]`."""
    for name, text in rrrobot_files().items():
        write_whole(Path(folder) / name, text.encode())


if __name__ == "__main__":
    main(*sys.argv[1:2])
