"""Reading URDF text safely: what is checked is what Pinocchio gets.

Pinocchio's own parser drops what it does not understand, and stops the process on some malformed
files, so everything that the dynamics rest on is checked here first, in sentences.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections import Counter
from pathlib import Path
from xml.parsers import expat

import numpy as np

from rrrobot.errors import UrdfError

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
