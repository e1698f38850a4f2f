"""Sphinx: formulas as MathML, which browsers typeset themselves, in a font that the site brings.

The font is STIX Two Math, as the package ziamath has it, cut down to the characters that are used.
`\\tag{2}` sets the number of an equation.
"""

from __future__ import annotations

import html
import re
import xml.etree.ElementTree as ET
from itertools import pairwise
from pathlib import Path
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.transforms import SphinxTransform
from sphinx.writers.html5 import HTML5Translator

_SPACE = "http://www.w3.org/1998/Math/MathML"
_TAG = re.compile(r"\\tag\{([^}]*)\}")
_ACCENTS = ("\u02d9", "\u00a8", "^", "\u00af", "~", "\u02c6", "\u02dc")
_THIN = {"width": "0.167em"}
# First characters of the alphabets (capitals, small letters) of bold and of bold italic letters.
_BOLD = {
    "bold": {"A": 0x1D400, "a": 0x1D41A, "\u0391": 0x1D6A8, "\u03b1": 0x1D6C2},
    "bold-italic": {
        "A": 0x1D468,
        "a": 0x1D482,
        "\u0391": 0x1D71C,
        "\u03b1": 0x1D736,
    },
}
# Browsers set single letters in italics: Latin (the h has its own place) and Greek.
_ITALICS = [*range(0x1D434, 0x1D468), 0x210E, *range(0x1D6E2, 0x1D71C)]
_characters: set[str] = set()

ET.register_namespace("", _SPACE)


def to_mathml(latex: str, display: str) -> str:
    """MathML of a formula, as browsers want it."""
    source = latex.strip().replace("{aligned}", "{split}")
    # A bracket there would be an option.
    source = re.sub(r"(\\begin\{\w+\})\s*\[", r"\1\\lbrack ", source)
    try:
        tree = ET.fromstring(convert(source, display=display))
    except Exception as error:
        raise ExtensionError(
            f"the formula {latex!r} is not understood: {error!r}"
        ) from None
    unknown = [e.text for e in tree.iter() if "\\" in (e.text or "")]
    if unknown:
        raise ExtensionError(
            f"the formula {latex!r} is not understood: {unknown[0]}"
        )
    _mend(tree)
    for element in tree.iter():
        _characters.update(element.text or "")
    return ET.tostring(tree, encoding="unicode")


def _mend(parent: ET.Element) -> None:
    children = list(parent)
    for child in children:
        _mend(child)
        variant = child.attrib.pop("mathvariant", None)
        if variant in _BOLD and child.text:
            child.text = "".join(_bold(c, _BOLD[variant]) for c in child.text)
    if (
        _name(parent) == "mover"
        and len(children) == 2
        and children[1].text in _ACCENTS
    ):
        parent.set("accent", "true")
        children[1].set("stretchy", "false")
    if _name(parent) in ("mrow", "mtd", "math"):
        _mend_signs(children)
        _space_functions(parent, children)


def _mend_signs(children: list[ET.Element]) -> None:
    """Signs and bars that stand before what they belong to, and slashes, without infix spaces."""
    before, bars = None, 0
    for child in children:
        text = child.text or ""
        if _name(child) == "mo" and text.isalpha():
            child.tag = f"{{{_SPACE}}}mi"
        elif _name(child) == "mo" and text == "/":
            child.attrib.update(lspace="0", rspace="0")
        elif _name(child) == "mo" and text == "|" and "form" not in child.attrib:
            form = "postfix" if bars % 2 else "prefix"
            child.attrib.update(form=form, stretchy="false")
            bars += 1
        elif _name(child) == "mo" and text in ("\u2212", "+", "\u00b1", "\u2213"):
            operand = before is not None and (
                _name(before) != "mo" or (before.text or "") in ")]}|"
            )
            if not operand:
                child.set("form", "prefix")
        if _name(child) != "mspace" and not (_name(child) == "mi" and not text):
            before = child


def _space_functions(parent: ET.Element, children: list[ET.Element]) -> None:
    """Thin spaces about cos, sin and the like, which browsers leave out."""
    for before, after in reversed(list(pairwise(children))):
        first, second = _word(before), _word(after)
        opens = _name(after) == "mo" or _name(after) == "mspace"
        if (first and not opens) or (
            second and _name(before) not in ("mo", "mspace")
        ):
            place = list(parent).index(after)
            parent.insert(place, ET.Element(f"{{{_SPACE}}}mspace", _THIN))


def _word(element: ET.Element) -> bool:
    """Whether this is the name of a function, perhaps with a power."""
    if _name(element) in ("msup", "msub") and len(element):
        return _word(element[0])
    return _name(element) == "mi" and len(element.text or "") > 1


def _bold(character: str, alphabets: dict[str, int]) -> str:
    for first, start in alphabets.items():
        if first <= character <= chr(ord(first) + 25):
            return chr(start + ord(character) - ord(first))
    return character


def _name(element: ET.Element) -> str:
    return element.tag.removeprefix(f"{{{_SPACE}}}")


def _inline(self: HTML5Translator, node: nodes.Element) -> None:
    self.body.append(to_mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _block(self: HTML5Translator, node: nodes.Element) -> None:
    latex = node.astext()
    tag = _TAG.search(latex)
    number = (
        f'<span class="equation-number">({html.escape(tag[1])})</span>'
        if tag
        else ""
    )
    formula = to_mathml(_TAG.sub("", latex), "block")
    self.body.append(
        f'<div class="equation"><div class="formula">{formula}</div>{number}</div>\n'
    )
    raise nodes.SkipNode


class _Together(SphinxTransform):
    """Keeps a formula and the punctuation after it on one line."""

    default_priority = 610

    def apply(self, **_: Any) -> None:
        for math in list(self.document.findall(nodes.math)):
            after = math.next_node(descend=False, siblings=True)
            if (
                not isinstance(after, nodes.Text)
                or after.astext()[0] not in ".,;:)?"
            ):
                continue
            text = after.astext()
            parent, place = math.parent, math.parent.index(math)
            parent[place : place + 2] = [
                nodes.inline(
                    "", "", math, nodes.Text(text[0]), classes=["together"]
                ),
                nodes.Text(text[1:]),
            ]


def _write_font(app: Sphinx, error: Exception | None) -> None:
    """Write the font with the characters of all formulas."""
    if error is not None or app.builder.format != "html":
        return
    import logging

    import ziamath
    from fontTools import subset

    logging.getLogger("fontTools").setLevel(logging.ERROR)
    source = Path(ziamath.__file__).parent / "fonts" / "STIXTwoMath-Regular.ttf"
    options = subset.Options(
        flavor="woff", layout_features=["ssty", "dtls", "flac"]
    )
    font = subset.load_font(str(source), options)
    subsetter = subset.Subsetter(options)
    subsetter.populate(
        unicodes=_ITALICS, text="".join(_characters) + "()[]{}|/√∑∫∮"
    )
    subsetter.subset(font)
    subset.save_font(
        font, str(Path(app.outdir) / "_static" / "STIXTwoMath.woff"), options
    )


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to Sphinx."""
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None),
                               block_renderers=(_block, None))  # fmt: skip
    app.add_transform(_Together)
    app.connect("build-finished", _write_font)
    return {"version": "1", "parallel_read_safe": True}
