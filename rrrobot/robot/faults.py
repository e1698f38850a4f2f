"""What is wrong with a URDF: everything that the dynamics rest on, checked, and all faults told.

Pinocchio's own parser drops what it does not understand, and stops the process on some malformed
files.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable
from xml.etree.ElementTree import Element

import numpy as np

from rrrobot.errors import UrdfError

# Pinocchio's parser recurses along a chain of links and takes the process with it when its stack
# ends.
_MAX_LINKS = 1000
_MAX_CHAIN = 250
_MOST_TOLD = 12
# Beyond these, products in the mass matrix are no longer exact, or no longer finite, and a
# simulation's first step has no end.
_LIMITS = {"mass": (1e9, "kg"), "inertia": (1e12, "kg m^2"), "origin": (1e5, "m")}

BALL_TYPES = ("spherical", "ball")
MOVING = ("revolute", "continuous", "prismatic")
_JOINT_TYPES = (*MOVING, "fixed", "floating", "planar", *BALL_TYPES)
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
        "dynamics": ("damping", "friction"),
        "mimic": ("multiplier", "offset"),
    },
}
_OPTIONAL = {
    ("origin", "xyz"), ("origin", "rpy"), ("limit", "lower"), ("limit", "upper"),
    ("dynamics", "damping"), ("dynamics", "friction"), ("mimic", "multiplier"),
    ("mimic", "offset"),
}  # fmt: skip
# Exporters print rounding errors: well-known robots have moments of inertia of -4e-8 kg m^2.
_INERTIA_TOLERANCE = 1e-6


class Faults:
    """Faults of one file, in the order of its lines."""

    def __init__(self) -> None:
        self._found: list[tuple[int, str]] = []

    def __bool__(self) -> bool:
        return bool(self._found)

    def add(self, element: Element, fault: str) -> None:
        """Note a fault, a sentence that ends with a full stop."""
        line = getattr(element, "line", 0)
        self._found.append((line, f"{fault[:-1]} (line {line})." if line else fault))

    def tell(self) -> None:
        """Raise UrdfError if there is any."""
        told = list(dict.fromkeys(fault for _, fault in sorted(self._found, key=lambda f: f[0])))
        if len(told) > _MOST_TOLD:
            told[_MOST_TOLD:] = [f"and {len(told) - _MOST_TOLD} more."]
        if len(told) == 1:
            raise UrdfError(told[0])
        if told:
            raise UrdfError(f"the URDF has {len(self._found)} faults: " + " ".join(told))


def check(robot: Element) -> None:
    """Check a <robot> element, its numbers rewritten with single spaces between them.

    Raises:
        UrdfError: links and joints that are not one tree, a joint without what its type needs, a
            number that is missing or none, a negative or non-finite mass or inertia; one message
            for all faults.
    """
    faults = Faults()
    _check_names(robot, faults)
    named = not faults
    _check_joints(robot, faults)
    _check_numbers(robot, faults)
    if named:
        _check_tree(robot, faults)
    faults.tell()


def _check_names(robot: Element, faults: Faults) -> None:
    """Links exist and are not too many; names are unique, not empty and not Pinocchio's own."""
    for tag in ("link", "joint"):
        elements = robot.findall(tag)
        names = Counter(e.get("name") for e in elements)
        if tag == "link" and not names:
            faults.add(robot, "the URDF has no <link>: a robot needs at least one.")
        if names.total() > _MAX_LINKS:
            raise UrdfError(
                f"the URDF has {names.total()} <{tag}> elements: the limit is {_MAX_LINKS}."
            )
        double = [str(name) for name, count in names.items() if count > 1 or not name]
        if double:
            last = next(e for e in reversed(elements) if str(e.get("name")) in double)
            faults.add(last, f"<{tag}> names must be unique and not empty: {listed(double)}.")
        for element in elements:
            name = element.get("name")
            if name in _RESERVED:
                faults.add(
                    element, f"a {tag} is named {name!r}: Pinocchio needs that name; rename."
                )


def _check_tree(robot: Element, faults: Faults) -> None:
    """Joints join existing links, each link has one parent at most, and all are in one tree."""
    links = [str(e.get("name")) for e in robot.findall("link")]
    known, above, joint_of = set(links), dict[str, str](), dict[str, str]()
    whole = True
    for joint in robot.findall("joint"):
        name, ends = shown(joint.get("name")), {}
        for end in ("parent", "child"):
            elements = joint.findall(end)
            if len(elements) > 1:
                whole = False
                faults.add(joint, f"joint {name} has {len(elements)} <{end}> elements: write one.")
                break
            link = elements[0].get("link") if elements else None
            if link not in known:
                whole = False
                faults.add(
                    joint,
                    f"joint {name} has the {end} link {shown(link)}, which the URDF does not "
                    f"define. Its links are: {listed(links)}.",
                )
                break
            ends[end] = str(link)
        if len(ends) < 2:
            continue
        child = ends["child"]
        if child in above:
            whole = False
            faults.add(
                joint,
                f"link {shown(child)} is the child of the joints {shown(joint_of[child])} and "
                f"{name}: in a tree every link has one parent.",
            )
        above[child], joint_of[child] = ends["parent"], str(joint.get("name"))
    if whole:
        _check_roots(robot, links, above, faults)


def _check_roots(robot: Element, links: list[str], above: dict[str, str], faults: Faults) -> None:
    roots = [link for link in links if link not in above]
    if len(roots) != 1:
        faults.add(robot, _roots_fault(roots))
        return
    elements = {str(e.get("name")): e for e in robot.findall("link")}
    for link in links:
        here, length = link, 1
        while here != roots[0] and length <= len(links):
            here, length = above[here], length + 1
        if here != roots[0]:
            faults.add(
                elements[link],
                f"link {shown(link)} hangs in a loop of joints: a robot is one tree.",
            )
            return
        if length > _MAX_CHAIN:
            faults.add(
                elements[link],
                f"link {shown(link)} is at the end of a chain of {length} links: the limit is "
                f"{_MAX_CHAIN}.",
            )
            return


def _roots_fault(roots: list[str]) -> str:
    return (
        f"the URDF has {len(roots)} root links ({listed(roots) or 'a loop'}): a robot is one tree "
        "with one root link."
    )


def root_link(robot: Element) -> str:
    """Name of the one link that is no joint's child.

    Raises:
        UrdfError: there is none or more than one.
    """
    children = {str(e.get("link")) for e in robot.findall("joint/child")}
    roots = [str(e.get("name")) for e in robot.findall("link") if e.get("name") not in children]
    if len(roots) != 1:
        raise UrdfError(_roots_fault(roots))
    return roots[0]


def _check_joints(robot: Element, faults: Faults) -> None:
    """Joint types are URDF's, with the limits that URDF demands; mimics follow what moves."""
    joints = {joint.get("name"): joint for joint in robot.findall("joint")}
    for joint in robot.findall("joint"):
        name, kind = shown(joint.get("name")), joint.get("type")
        if kind not in _JOINT_TYPES:
            faults.add(
                joint,
                f"joint {name} has the type {shown(kind)}: it must be one of "
                f"{', '.join(_JOINT_TYPES)}.",
            )
        if kind in ("revolute", "prismatic") and joint.find("limit") is None:
            faults.add(
                joint,
                f'joint {name} is {kind} and has no limits: add <limit effort="1" '
                'velocity="1" lower="-1" upper="1"/>.',
            )
        mimic = joint.find("mimic")
        if mimic is None:
            continue
        masters, here = [joint.get("name")], mimic
        while here is not None:
            master = here.get("joint")
            if master in masters:
                faults.add(mimic, f"joint {name} mimics {shown(master)}, which follows it.")
                break
            masters.append(master)
            here = joints[master].find("mimic") if master in joints else None  # type: ignore[assignment]


def _check_numbers(robot: Element, faults: Faults) -> None:
    """Every number that enters the dynamics is there and finite; masses are not negative."""
    for owner in (*robot.findall("link"), *robot.findall("joint")):
        place = f"of {owner.tag} {shown(owner.get('name'))}"
        for path, attributes in _NUMBERS[owner.tag].items():
            for element in owner.findall(path):
                values = {a: _read_numbers(element, a, place, faults) for a in attributes}
                if all(value is not None for value in values.values()):
                    _check_values(owner, element, values, place, faults)  # type: ignore[arg-type]
        for inertial in owner.findall("inertial"):
            if inertial.find("mass") is None:
                faults.add(inertial, f"<inertial> {place} has no <mass>: add one.")


def _check_values(
    owner: Element,
    element: Element,
    values: dict[str, list[float]],
    place: str,
    faults: Faults,
) -> None:
    tag = element.tag
    if tag == "mass" and values["value"][0] < 0:
        text = f"<mass value={shown(element.get('value'))}>"
        faults.add(element, f"{text} {place} must not be negative.")
    if tag == "inertia":
        least = float(np.linalg.eigvalsh(inertia_matrix([values[a][0] for a in _PRODUCTS]))[0])
        if not least > -_INERTIA_TOLERANCE:
            faults.add(
                element,
                f"<inertia> {place} has the principal moment {least:.4g} kg m^2: no moment of "
                "inertia is negative.",
            )
    if tag in _LIMITS:
        limit, unit = _LIMITS[tag]
        measured = [values["xyz"]] if tag == "origin" else values.values()
        if any(abs(value) > limit for part in measured for value in part):
            faults.add(element, f"<{tag}> {place} is too large: the limit is {limit:g} {unit}.")
    if tag == "dynamics":
        for name, value in values.items():
            if value and value[0] < 0:
                faults.add(element, f"<dynamics {name}={value[0]!r}> {place} must not be negative.")
    if (
        tag == "axis"
        and owner.get("type") in MOVING
        and not 1e-6 < math.hypot(*values["xyz"]) < 1e6
    ):
        text = f"<axis xyz={shown(element.get('xyz'))}>"
        faults.add(element, f"{text} {place} is no direction: write a unit vector.")


def inertia_matrix(products: list[float]) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """(3, 3) of ixx, ixy, ixz, iyy, iyz, izz."""
    xx, xy, xz, yy, yz, zz = products
    return np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))


def _read_numbers(
    element: Element, attribute: str, place: str, faults: Faults
) -> list[float] | None:
    """The numbers of an attribute; [] if it may be missing and is; None if they are faulty."""
    text = element.get(attribute)
    if text is None and (element.tag, attribute) in _OPTIONAL:
        return []
    where = f"<{element.tag} {attribute}={shown(text)}> {place}"
    if text is None:
        faults.add(element, f"<{element.tag}> {place} has no {attribute}: add it.")
        return None
    size = 3 if attribute in ("xyz", "rpy") else 1
    words = words_of(text, size)
    try:
        values = [_number(word) for word in words]
    except ValueError:
        faults.add(element, f"{where} is not numeric: write plain numbers.")
        return None
    if not all(map(math.isfinite, values)):
        faults.add(element, f"{where} must be finite.")
        return None
    if len(values) != size:
        faults.add(element, f"{where} has {len(values)} numbers: it must have {size}.")
        return None
    element.set(attribute, " ".join(words))
    return values


def words_of(text: str, size: int) -> list[str]:
    """The words of a number or a vector; a vector's may be parted by commas."""
    return re.split(r"\s*,\s*|\s+", text.strip()) if size > 1 and text.strip() else text.split()


def _number(word: str) -> float:
    """A number that C++ reads too: float() also takes 1_000 and the digits of other scripts."""
    if "_" in word or not word.isascii():
        raise ValueError(word)
    return float(word)


def shown(value: str | None) -> str:
    """A name or a value for a message, not longer than fits."""
    if value is not None and len(value) > 60:
        value = f"{value[:57]}..."
    return repr(value)


def listed(names: Iterable[str]) -> str:
    """Names for a message, not more than fit in one."""
    every = list(names)
    few = [name if len(name) <= 60 else f"{name[:57]}..." for name in every[:30]]
    return ", ".join(few) + (f" and {len(every) - 30} more" if len(every) > 30 else "")
