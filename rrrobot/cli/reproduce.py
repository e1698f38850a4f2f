"""`rrrobot reproduce`: the paper's tables, figures and claims, made anew, and a report."""

from __future__ import annotations

from collections import Counter

import click

from rrrobot.cli.compile import tell_of_compiling
from rrrobot.cli.report import to_json
from rrrobot.paper.item import VERDICTS
from rrrobot.paper.report import Section, short
from rrrobot.paper.run import ITEMS, reproduce


@click.command("reproduce")
@click.option("--out", metavar="DIR", default="paper", show_default=True, help="Folder to fill.")
@click.option("--only", metavar="KEYS", help="Such as fig18,table3; all unless given. See --list.")
@click.option("--quick", is_flag=True, help="Coarse grids for the maps.")
@click.option("--anew", is_flag=True, help="Do not keep what an earlier run has finished.")
@click.option("--list", "show_list", is_flag=True, help="List the keys and stop.")
@click.option("--json", "as_json", is_flag=True, help="As JSON.")
@click.option("--quiet", is_flag=True, help="No progress bar, no word of compiling.")
def reproduce_command(
    out: str,
    only: str | None,
    quick: bool,
    anew: bool,
    show_list: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Make the tables, figures and claims of the paper, and a report that sets ours beside them.

    The folder takes report.html, report.md, a picture for each figure and the numbers of each item
    as JSON. An interrupted run goes on where it stopped.

    \b
    Examples:
      rrrobot reproduce
      rrrobot reproduce --only fig18,table3 --out figures
    """
    if show_list:
        rows = [{"key": item.key, "title": item.title} for item in ITEMS]
        if as_json:
            click.echo(to_json(rows))
        else:
            width = max(len(row["key"]) for row in rows)
            click.echo("\n".join(f"{row['key']:<{width}}  {row['title']}" for row in rows))
        return
    keys = None if only is None else _keys(only)
    tell_of_compiling(quiet=quiet)
    wish = False if quiet else None
    found = reproduce(out, only=keys, quick=quick, resume=not anew, progress=wish)
    if as_json:
        data = {"report": str(found.report), "sections": [s._asdict() for s in found.sections]}
        click.echo(to_json(data))
        return
    for section in found.sections:
        click.echo(_line(section, in_full=keys is not None))
    if found.kept:
        click.echo(f"kept from an earlier run: {len(found.kept)} of {len(found.sections)}")
    counts = Counter(row["verdict"] for section in found.sections for row in section.rows)
    click.echo(", ".join(f"{counts[name]} {name}" for name in VERDICTS))
    click.echo(f"wrote {found.report}")


def _keys(text: str) -> list[str]:
    return [key.strip().lower() for key in text.split(",") if key.strip()]


def _line(section: Section, *, in_full: bool) -> str:
    counts = Counter(row["verdict"] for row in section.rows)
    verdicts = ", ".join(f"{counts[n]} {n}" for n in VERDICTS if counts[n])
    lines = [f"{section.title}: {verdicts}"]
    if in_full:
        for row in section.rows:
            unit = f" {row['unit']}" if row["unit"] else ""
            ours = row["ours"] if isinstance(row["ours"], str) else short(row["ours"]) + unit
            paper = "" if row["paper"] is None else f" (paper: {row['paper']})"
            lines.append(f"  {row['quantity']}: {ours}{paper}, {row['verdict']}")
    return "\n".join(lines)
