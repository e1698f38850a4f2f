"""Sphinx: `{citation}` is CITATION.cff as BibTeX entries, so that there is one source for both."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

CITATION = Path(__file__).parents[2] / "CITATION.cff"
_FIELDS = (
    "journal",
    "volume",
    "issue",
    "start",
    "end",
    "year",
    "doi",
    "url",
    "version",
)
_NAMES = {"issue": "number"}


def bibtex() -> str:
    """The entries of CITATION.cff: the software, then what it refers to."""
    data = yaml.safe_load(CITATION.read_text())
    return "\n\n".join(_entry(item) for item in [data, *data.get("references", ())])


def _entry(item: dict[str, Any]) -> str:
    authors = [_name(author) for author in item["authors"]]
    word = authors[0].split(",")[0].split()[-1].lower()
    article = item.get("type") == "article"
    key = word if article else item["title"].split(":")[0].split()[0]
    fields = {"author": " and ".join(authors), "title": "{" + item["title"] + "}"}
    fields |= {
        _NAMES.get(name, name): str(item[name]) for name in _FIELDS if name in item
    }
    if "start" in fields:
        fields["pages"] = fields.pop("start") + (
            f"--{fields.pop('end')}" if "end" in fields else ""
        )
    lines = [f"  {name} = {{{value}}}," for name, value in fields.items()]
    return "\n".join(
        [f"@{'article' if article else 'software'}{{{key},", *lines, "}"]
    )


def _name(author: dict[str, str]) -> str:
    if "name" in author:
        return "{" + author["name"] + "}"
    given = author.get("given-names")
    return f"{author['family-names']}, {given}" if given else author["family-names"]


class _Citation(SphinxDirective):
    """The BibTeX entries."""

    def run(self) -> list[nodes.Node]:
        self.env.note_dependency(str(CITATION))
        text = bibtex()
        return [nodes.literal_block(text, text, language="bibtex")]


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to Sphinx."""
    app.add_directive("citation", _Citation)
    return {"version": "1", "parallel_read_safe": True}
