"""The report of a reproduction, as Markdown and as one HTML page beside its pictures."""

from __future__ import annotations

import html
import math
from collections import Counter
from typing import Any, NamedTuple

from rrrobot.paper.item import AGREES, DIFFERS, ERRATUM, INPUT, OPEN

_INTRO = (
    "Every table, figure and claim of R. Balasubramanian, A. A. Rizzi and M. T. Mason, An "
    "approximate decoupled dynamics and kinematics analysis of legless locomotion, made anew by "
    "rrrobot: what the paper prints or says, what we get, their ratio, and a verdict that is "
    "computed from the number by the limit beside it. The limit of a printed number is half its "
    "last digit; where the paper has words, such as 'small' or 'well', the limit is ours. Its "
    "figures can be judged only by their captions and the text about them."
)
_MEANING = {
    AGREES: "as the paper has it, to its printed digits or to the limit given in words",
    DIFFERS: "not so",
    ERRATUM: "the paper contradicts itself or its Table 2; the note says what is right",
    INPUT: "taken from the paper; not counted as agreement",
    OPEN: "the paper gives no number; ours is for the record",
}
_HEAD = ("quantity", "paper", "rrrobot", "ratio", "limit", "verdict", "note")


class Section(NamedTuple):
    """An item as the report shows it.

    Attributes:
        key, title, shows: of the item.
        rows: as `rows_to_data` gives them.
        remarks: paragraphs.
        files: pictures, relative to the report.
    """

    key: str
    title: str
    shows: str
    rows: list[dict[str, Any]]
    remarks: list[str]
    files: list[str]

    @property
    def command(self) -> str:
        """That makes it alone."""
        return f"rrrobot reproduce --only {self.key}"


class About(NamedTuple):
    """What a report was made with.

    Attributes:
        versions: of rrrobot and what it builds on.
        quick: whether the grids are coarse.
        missing: keys of items that this run left out.
    """

    versions: dict[str, str]
    quick: bool
    missing: list[str]


def markdown(sections: list[Section], about: About) -> str:
    """The report as Markdown."""
    lines = ["# The paper, reproduced", "", _INTRO, "", *_about_lines(about), ""]
    lines += ["| verdict | rows | |", "|---|---:|---|"]
    lines += [f"| {name} | {n} | {_MEANING[name]} |" for name, n in _counts(sections)]
    lines += ["", "| | " + " | ".join(_MEANING) + " |", "|---|" + "---:|" * len(_MEANING)]
    for section in sections:
        found = Counter(row["verdict"] for row in section.rows)
        cells = " | ".join(str(found[name] or "") for name in _MEANING)
        lines.append(f"| [{section.title}](#{section.key}) | {cells} |")
    for section in sections:
        lines += [
            "",
            f'<a id="{section.key}"></a>',
            "",
            f"## {section.title}",
            "",
            section.shows,
            "",
        ]
        lines += [f"`{section.command}`", ""]
        lines += ["| " + " | ".join(_HEAD) + " |", "|---|---|---:|---:|---:|---|---|"]
        lines += ["| " + " | ".join(_bars(c) for c in _cells(row)) + " |" for row in section.rows]
        for remark in section.remarks:
            lines += ["", remark]
        for file in section.files:
            lines += ["", f"![{section.title}]({file})"]
    return "\n".join(lines) + "\n"


def page(sections: list[Section], about: About) -> str:
    """The report as an HTML page without scripts."""
    e = html.escape
    parts = [f"<h1>The paper, reproduced</h1><p>{e(_INTRO)}</p>"]
    parts += [f"<p>{e(line)}</p>" for line in _about_lines(about)]
    verdicts = "".join(
        f'<tr><td class="{_css(name)}">{name}</td><td>{n}</td><td>{e(_MEANING[name])}</td></tr>'
        for name, n in _counts(sections)
    )
    parts.append(f'<div class="wide"><table>{verdicts}</table></div>')
    contents = "".join(
        f'<li><a href="#{s.key}">{e(s.title)}</a> {_badges(s)}</li>' for s in sections
    )
    parts.append(f"<ul>{contents}</ul>")
    for s in sections:
        head = "".join(f"<th>{name}</th>" for name in _HEAD)
        body = "".join(_html_row(row) for row in s.rows)
        parts.append(
            f'<section id="{s.key}"><h2>{e(s.title)}</h2><p>{e(s.shows)}</p>'
            f"<p><code>{e(s.command)}</code></p>"
            f'<div class="wide"><table><tr>{head}</tr>{body}</table></div>'
            + "".join(f"<p>{e(remark)}</p>" for remark in s.remarks)
            + "".join(f'<img src="{e(f)}" alt="{e(s.title)}" loading="lazy">' for f in s.files)
            + "</section>"
        )
    return _PAGE.format(body="\n".join(parts))


def _about_lines(about: About) -> list[str]:
    versions = ", ".join(f"{name} {version}" for name, version in about.versions.items())
    lines = [f"Made with {versions}."]
    if about.quick:
        lines.append("A quick run: the grids of the maps are coarse.")
    if about.missing:
        lines.append(f"Not in this report: {', '.join(about.missing)}.")
    return lines


def _counts(sections: list[Section]) -> list[tuple[str, int]]:
    found = Counter(row["verdict"] for section in sections for row in section.rows)
    return [(name, found[name]) for name in _MEANING]


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    unit = f" {row['unit']}" if row["unit"] else ""
    paper, ours = row["paper"], row["ours"]
    printed = "" if paper is None else paper if isinstance(paper, str) else f"{paper:g}{unit}"
    found = ours if isinstance(ours, str) else f"{short(ours)}{unit}"
    ratio = "" if row["ratio"] is None else f"{row['ratio']:.3f}"
    return row["quantity"], printed, found, ratio, row["limit"], row["verdict"], row["note"]


def short(value: float) -> str:
    """Five digits; what is below 1e-15 is zero to any reader."""
    return "0" if abs(value) < 1e-15 else f"{value:.5g}" if math.isfinite(value) else "none"


def _html_row(row: dict[str, Any]) -> str:
    cells = [html.escape(cell) for cell in _cells(row)]
    return (
        f"<tr><td>{cells[0]}</td><td>{cells[1]}</td><td class=n>{cells[2]}</td>"
        f"<td class=n>{cells[3]}</td><td class=n>{cells[4]}</td>"
        f'<td class="{_css(cells[5])}">{cells[5]}</td><td>{cells[6]}</td></tr>'
    )


def _badges(section: Section) -> str:
    found = Counter(row["verdict"] for row in section.rows)
    return " ".join(
        f'<span class="{_css(name)}">{n} {name}</span>'
        for name in (AGREES, DIFFERS, ERRATUM)
        if (n := found[name])
    )


def _css(verdict: str) -> str:
    return verdict.replace(" ", "-")


def _bars(cell: str) -> str:
    return cell.replace("|", "\\|")


_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>The paper, reproduced</title>
<style>
body {{ font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 0 auto; padding: 1rem;
  color: #1a1a1a; background: #fff; }}
h2 {{ margin-top: 3rem; border-top: 1px solid #ccc; padding-top: 1rem; }}
.wide {{ overflow-x: auto; }}
table {{ border-collapse: collapse; font-size: 0.9rem; }}
th, td {{ text-align: left; padding: 0.25rem 0.7rem; border-bottom: 1px solid #ddd;
  vertical-align: top; }}
td:first-child {{ min-width: 11rem; }}
.n {{ text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }}
img {{ max-width: 100%; height: auto; display: block; margin: 1rem 0; }}
code {{ background: #f2f2f2; padding: 0.1rem 0.3rem; }}
.agrees {{ color: #00543c; }}
.differs {{ color: #a3000c; font-weight: 600; }}
.erratum {{ color: #7a4b00; font-weight: 600; }}
.not-printed, .input {{ color: #555; }}
li span {{ font-size: 0.85rem; margin-left: 0.4rem; }}
</style></head><body>
{body}
</body></html>
"""
