"""Sphinx: the reference from the docstrings, and links to it wherever a page says `rr.name`.

    ```{api}
    Robot
    figures.maps.value_map
    ```

documents names of the package, classes with their members; `figures.maps.*` is all that the module
defines for others. Docstrings are plain text with Google
sections; they are made into reStructuredText here.
"""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from itertools import chain
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.ext.napoleon import Config, GoogleDocstring
from sphinx.transforms import SphinxTransform

import rrrobot

_API = re.compile(r"^```\{api\}\n(.*?)^```$", flags=re.M | re.S)
_SECTION = re.compile(
    r"(Args|Attributes|Returns|Raises|Warns|Example|Examples|Yields):$"
)
_TOGETHER = re.compile(r"^(    \w+(?:, \w+)+):")
_WRAPPED = re.compile(r"^(    (?:\*?\w+, )*\*?\w+,)\n +", flags=re.M)
_CODE = re.compile(r"``?[^`]+``?")
_GOOGLE = Config(
    napoleon_use_ivar=True,
    napoleon_use_rtype=False,
    napoleon_attr_annotations=False,
)
_CALL = re.compile(r"rr\.((?:\w+\.)*\w+)(?:\(.*\))?")


def thing(name: str) -> Any:
    """What a dotted name below the package means; modules only where no attribute has the name."""
    found: Any = rrrobot
    path = "rrrobot"
    for part in name.split("."):
        path += f".{part}"
        found = (
            getattr(found, part) if hasattr(found, part) else import_module(path)
        )
        if inspect.isfunction(found) and not name.endswith(part):
            found = import_module(path)
    return found


def _expand(app: Sphinx, docname: str, source: list[str]) -> None:
    source[0] = _API.sub(lambda match: _directives(match[1].split()), source[0])


def _defined(module: str) -> list[str]:
    """Public functions and classes that a module defines itself, in its order."""
    found = import_module(f"rrrobot.{module}")
    return [
        f"{module}.{name}"
        for name, item in vars(found).items()
        if not name.startswith("_")
        and (inspect.isfunction(item) or inspect.isclass(item))
        and item.__module__ == found.__name__
    ]


def _directives(names: list[str]) -> str:
    lines = []
    every = [
        _defined(name[:-2]) if name.endswith(".*") else [name] for name in names
    ]
    for name in chain.from_iterable(every):
        item = thing(name)
        kind = "class" if inspect.isclass(item) else "function"
        if inspect.isclass(item) and issubclass(item, BaseException):
            kind = "exception"
        module, _, last = f"rrrobot.{name}".rpartition(".")
        lines += [
            f".. py:currentmodule:: {module}",
            "",
            f".. auto{kind}:: {last}",
            "",
        ]
    return "````{eval-rst}\n" + "\n".join(lines) + "\n````"


def _plain(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]
) -> None:
    """Make a docstring of plain text into reStructuredText."""
    if lines and lines[0].startswith("Alias for field number"):
        lines.clear()
        return
    # Names of arguments that go over the end of a line, and code that does.
    text = _WRAPPED.sub(r"\1 ", "\n".join(lines))
    text = _CODE.sub(lambda match: re.sub(r"\n\s*", " ", match[0]), text)
    plain = _restructured(text.split("\n"))
    # As of a method: a property's first line is no "type: text".
    plain = GoogleDocstring(
        plain, _GOOGLE, app, "method", name, obj, options
    ).lines()
    lines[:] = plain


def _restructured(lines: list[str]) -> list[str]:
    out: list[str] = []
    indent, section = 0, ""
    for i, line in enumerate(lines):
        text = line.strip()
        depth = len(line) - len(line.lstrip())
        if not text:
            out.append("")
            continue
        if _SECTION.match(text) and depth == 0:
            section, indent = text, 4
            out.append(line)
            continue
        if depth == 0:
            section, indent = "", 0
        in_example = text.startswith((">>>", "...")) or _in_doctest(lines, i)
        if in_example:
            out.append(line)
            continue
        blank_before = i == 0 or not lines[i - 1].strip()
        formula = depth >= indent + 4 and not section
        if formula and (blank_before or _is_literal(out)):
            if not _is_literal(out):
                out += ["::", ""]
            out.append(line)
            continue
        line = line[:depth] + _escaped(text)
        # napoleon takes "a, b: text" for a b of type a.
        if section == "Attributes:":
            line = _TOGETHER.sub(lambda match: match[0].replace(", ", ","), line)
        out.append(line)
    return out


def _is_literal(out: list[str]) -> bool:
    """Whether the last lines are a literal block."""
    for line in reversed(out):
        if line == "::":
            return True
        if line and not line.startswith("    "):
            return False
    return False


def _in_doctest(lines: list[str], i: int) -> bool:
    """Whether a line is output of an example."""
    for line in reversed(lines[:i]):
        if not line.strip():
            return False
        if line.strip().startswith(">>>"):
            return True
    return False


def _escaped(text: str) -> str:
    parts, at = [], 0
    for code in _CODE.finditer(text):
        parts.append(_plain_words(text[at : code.start()]))
        at = code.end()
        # "`Name`s": a word may not touch the end of the markup.
        touches = text[at : at + 1].isalnum()
        parts.append(f"``{code[0].strip('`')}``" + ("\\ " if touches else ""))
    return "".join([*parts, _plain_words(text[at:])])


def _plain_words(text: str) -> str:
    text = re.sub(r"([*|])", r"\\\1", text)
    return re.sub(r"(\w)_(?=\W|$)", r"\1\\_", text)


def _skip(
    app: Sphinx, what: str, name: str, obj: Any, skip: bool, options: Any
) -> bool | None:
    """Leave out members that have no text of their own.

    A base class describes these methods, and the docstring's attributes these fields of tuples.
    """
    function = obj.fget if isinstance(obj, property) else obj
    inherited = inspect.isfunction(function) and function.__doc__ is None
    told = False
    if (getattr(obj, "__doc__", "") or "").startswith("Alias for field number"):
        data = app.env.temp_data
        owner = getattr(
            import_module(data["autodoc:module"]), data["autodoc:class"], None
        )
        attributes = (inspect.getdoc(owner) or "").partition("Attributes:")[2]
        told = bool(re.search(rf"^    (\w+, )*{name}\b.*:", attributes, flags=re.M))
    return True if inherited or told else None


def _is_public(name: str) -> bool:
    """Whether a dotted name begins with a public one, of the top or of a room."""
    first, _, rest = name.partition(".")
    found = getattr(rrrobot, first, None)
    room = inspect.ismodule(found) and rest.split(".")[0] in getattr(
        found, "__all__", ()
    )
    return first in rrrobot.__all__ or room


class _Links(SphinxTransform):
    """Literals such as `rr.simulate(...)` become links to the reference."""

    default_priority = 600

    def apply(self, **_: Any) -> None:
        for literal in list(self.document.findall(nodes.literal)):
            match = _CALL.fullmatch(literal.astext())
            linked = isinstance(
                literal.parent, (nodes.reference, addnodes.pending_xref)
            )
            if match is None or linked or not _is_public(match[1]):
                continue
            target = f"rrrobot.{match[1]}"
            link = addnodes.pending_xref(
                "", refdomain="py", reftype="obj", reftarget=target, refexplicit=True,
                refdoc=self.env.docname, refwarn=True,
            )  # fmt: skip
            literal.replace_self(link)
            link += literal


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to Sphinx."""
    app.connect("source-read", _expand)
    app.connect("autodoc-process-docstring", _plain)
    app.connect("autodoc-skip-member", _skip)
    app.add_transform(_Links)
    return {"version": "1", "parallel_read_safe": True}
