"""XML as robot files have it: read as leniently as Pinocchio reads it, with every element's line.

Files that other readers take and XML forbids: comments that hold "--" or "<!--", white space
before the declaration, prefixes that nobody declared, a default namespace. A comment ends at the
first "-->"; prefixes are parts of names. Entities are refused, so that nothing expands or reaches
out.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from functools import lru_cache
from xml.parsers import expat

from rrrobot.errors import UrdfError

# Limits beyond any robot that stands.
MAX_BYTES = 10_000_000
_MAX_NESTING = 100
# Expat compares an element's attributes with each other: 20,000 of them take seconds.
_MAX_ATTRIBUTES = 200
_LONGEST_NAME = 1000

_COMMENT = re.compile(r"(<!\[CDATA\[).*?\]\]>|<!--.*?-->", re.DOTALL)
_DECLARATION = re.compile(r"\A\s*<\?xml\s[^>]*\?>")


class Element(ET.Element):
    """An element that knows the line of the file where it begins; 0 if it was made here."""

    line: int = 0


def parse_xml(text: str) -> Element:
    """Root element of lenient XML.

    Raises:
        UrdfError: malformed even so, a DOCTYPE, an element beyond all size.

    Example:
        >>> from rrrobot.robot.markup import parse_xml
        >>> root = parse_xml("<robot><!-- old -- one -->\\n<drake:x/></robot>")
        >>> root[0].tag, root[0].line
        ('drake:x', 2)
    """
    try:
        size = len(text.encode())
        check_size(size)
        return _parse(_without_comments(text.lstrip("\ufeff")))
    except (expat.ExpatError, LookupError, ValueError) as error:
        if isinstance(error, UrdfError):
            raise
        raise UrdfError(f"the URDF is not well-formed XML: {error}.") from None


def check_size(n: int) -> None:
    """Refuse more bytes than any robot file has."""
    if n > MAX_BYTES:
        raise UrdfError(f"the URDF has more than {MAX_BYTES} bytes: that is the limit.")


@lru_cache(maxsize=2)
def _without_comments(text: str) -> str:
    """The text with blanks for comments and for the declaration; its lines stay where they are."""
    clean = _COMMENT.sub(_outside_data, text)
    # It is UTF-8 whatever the declaration says, so nothing is lost with it.
    return _DECLARATION.sub(lambda found: _blank(found.group()), clean)


def _outside_data(found: re.Match[str]) -> str:
    """A blank for a comment; what is in a CDATA section is none."""
    return found.group() if found.group(1) else _blank(found.group())


def _blank(text: str) -> str:
    return "\n" * text.count("\n") or " "


def _parse(text: str) -> Element:
    for piece in text.split("<"):
        if piece.count("=") > _MAX_ATTRIBUTES and not piece.startswith("!["):
            raise UrdfError(f"an element has more than {_MAX_ATTRIBUTES} attributes: the limit.")
    builder = ET.TreeBuilder(element_factory=Element)
    depth = 0

    def doctype(*_: object) -> None:
        raise UrdfError(
            "the URDF declares a DOCTYPE: entities are not allowed in a robot file; remove it."
        )

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > _MAX_NESTING:
            raise UrdfError(f"<{tag[:60]}> is nested {depth} deep: the limit is {_MAX_NESTING}.")
        if len(tag) > _LONGEST_NAME:
            raise UrdfError(f"an element's name has {len(tag)} letters: that is no robot's.")
        element = builder.start(tag, attributes)
        element.line = parser.CurrentLineNumber  # type: ignore[attr-defined]

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    parser = expat.ParserCreate("utf-8")
    parser.StartDoctypeDeclHandler = doctype
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = builder.data
    parser.Parse(text.encode(), True)
    root = builder.close()
    assert isinstance(root, Element)
    return root
