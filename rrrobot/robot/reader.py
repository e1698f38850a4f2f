"""Reading robot files safely: what is checked is what Pinocchio gets.

`read_urdf` gets the text, of a file or expanded from xacro; `parse_urdf` makes of it a checked and
normalised tree: `markup` says how lenient the XML may be, `faults` what is refused, `tree` what is
rewritten.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from xml.etree.ElementTree import Element

from rrrobot.errors import UrdfError
from rrrobot.files import read_bytes
from rrrobot.robot import markup
from rrrobot.robot.faults import check
from rrrobot.robot.markup import check_size, parse_xml
from rrrobot.robot.tree import normalise
from rrrobot.robot.xacro import expand_xacro, name_other_dialects, xacro_mark


def parse_urdf(text: str) -> Element:
    """Parse URDF text and check what a dynamics library relies on.

    A document type declaration is refused, so entities can neither expand nor reach out.

    Returns:
        the <robot> element, the world's own joint taken away and ball joints made three;
        `urdf_text` writes it so that every parser reads the same.

    Raises:
        UrdfError: malformed XML, a DOCTYPE, no <robot>, xacro, links and joints that are not one
            tree, a joint without what its type needs, a number that is missing or none, a
            negative or non-finite mass or inertia, a file beyond all size. One message has all
            faults with their lines.
    """
    robot = parse_xml(text)
    name_other_dialects(robot)
    mark = xacro_mark(robot)
    if mark is not None:
        raise UrdfError(
            f"the URDF has unexpanded xacro ({mark[0]} at line {mark[1]}): run `xacro` on it first."
        )
    if not robot.get("name"):
        raise UrdfError("the URDF's <robot> has no name: write <robot name=...>.")
    check(robot)
    normalise(robot)
    return robot


def urdf_text(robot: ET.Element) -> str:
    """What `parse_urdf` read, as text again: no comments, no declarations, plain white space."""
    return ET.tostring(robot, encoding="unicode")


def is_text(source: str | Path) -> bool:
    """Whether a source is URDF text already, and not a file's path."""
    return isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<")


def read_urdf(source: str | Path) -> str:
    """Text of a URDF file, or of a string that is URDF already; checked by `parse_urdf`.

    xacro is expanded where the package for it is installed.

    Raises:
        UrdfError: the file is missing, unreadable, not UTF-8, or not a sound URDF.
    """
    if is_text(source):
        return _expanded(str(source), None)
    path = Path(source)
    try:
        raw = read_bytes(path, markup.MAX_BYTES)
    except FileNotFoundError:
        named = not path.suffix and len(path.parts) == 1
        more = "; example robots need pip install example-robot-data-loaders" if named else ""
        raise UrdfError(f"there is no URDF file {_name(path)}: check the path{more}.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise UrdfError(f"the URDF file {_name(path)} cannot be read: {reason}.") from None
    try:
        check_size(len(raw))
        return _expanded(raw.decode("utf-8-sig"), path)
    except UnicodeDecodeError:
        raise UrdfError(f"the URDF file {_name(path)} is not UTF-8 text.") from None
    except UrdfError as error:
        raise UrdfError(f"{path}: {error}") from None


def _expanded(text: str, path: Path | None) -> str:
    root = parse_xml(text)
    mark = xacro_mark(root) if root.tag == "robot" else None
    if mark is not None:
        text = expand_xacro(text, path, mark)
    parse_urdf(text)
    return text


def _name(path: Path) -> str:
    text = str(path)
    return repr(text if len(text) <= 120 else f"{text[:117]}...")
