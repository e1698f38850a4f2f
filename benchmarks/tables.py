"""Numbers, tables and paragraphs of docs/benchmarks.md."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from typing import Any

Record = dict[str, Any]


def number(x: float, digits: int = 3) -> str:
    """A number with so many significant digits, without an exponent where that reads better."""
    if x != 0 and not 1e-3 <= abs(x) < 1e5:
        mantissa, exponent = f"{x:.{digits - 1}e}".split("e")
        return f"{mantissa}e{int(exponent)}"
    text = f"{x:.{digits}g}"
    return f"{float(text):.0f}" if "e" in text else text


def error(x: float | None) -> str:
    """A relative error: per cent if large."""
    if x is None:
        return "-"
    return f"{number(100 * x, 2)} %" if x >= 1e-3 else number(x, 2)


def share(x: float) -> str:
    """A share of either sign: per cent if large."""
    return f"{number(100 * x, 2)} %" if abs(x) >= 1e-4 else number(x, 1)


def seconds(x: float) -> str:
    """A duration in the unit that suits it."""
    for limit, factor, unit in ((1e-3, 1e6, "µs"), (1.0, 1e3, "ms"), (120.0, 1.0, "s")):
        if x < limit:
            return f"{number(factor * x)} {unit}"
    return f"{number(x / 60)} min"


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    head = list(head)
    lines = [head, ["---"] * len(head), *map(list, rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def prose(text: str) -> str:
    """A paragraph, or one list item if it begins with "- ", filled anew to 100 columns."""
    item = text.strip().startswith("- ")
    return (
        textwrap.fill(
            " ".join(text.split()),
            100,
            subsequent_indent="  " * item,
            break_long_words=False,
            break_on_hyphens=False,
        )
        + "\n"
    )


def machine(record: Record) -> str:
    """Where and when a record was measured, and whether the cores were free."""
    m = record["machine"]
    versions = ", ".join(f"{name} {v}" for name, v in m["versions"].items())
    before, after = m["load_average_before"][0], m["load_average_after"][0]
    text = (
        f"Measured {m['date']} in {m['minutes']} minutes on {m['cores']} cores ({m['processor']}, "
        f"{m['system']}); {versions}. Load average {before} before, {after} after."
    )
    others = m["cores_taken_by_others"]
    if others is not None and others > 0.1:
        text += (
            f" **The cores were shared:** other processes took {others} of {m['cores']} cores on "
            "average, so wall-clock times, above all of two threads, are longer than on a free "
            "machine. Processor time suffers less."
        )
    return text
