"""What reproducing one table, figure or claim of the paper gives."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rrrobot.paper.workshop import Workshop

AGREES, DIFFERS, ERRATUM, OPEN = "agrees", "differs", "erratum", "not printed"
"""Verdicts: as the paper has it; not so; the paper contradicts itself or its own Table 2, and we
say what is right; the paper gives no number, ours is for the record."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One comparison with the paper.

    Attributes:
        quantity: what is compared.
        paper: what the paper prints or says; None if nothing.
        ours: what we get; a number is in `unit`.
        unit: of the numbers.
        verdict: one of AGREES, DIFFERS, ERRATUM, OPEN.
        note: one sentence where the verdict needs a reason.
    """

    quantity: str
    paper: float | str | None
    ours: float | str
    unit: str = ""
    verdict: str
    note: str = ""

    @property
    def ratio(self) -> float | None:
        """Ours over the paper's, of two numbers."""
        if isinstance(self.paper, str) or isinstance(self.ours, str) or not self.paper:
            return None
        return self.ours / self.paper


def number(
    quantity: str, paper: float, ours: float, unit: str = "", *, within: float, note: str = ""
) -> Row:
    """A printed number: agrees if ours is within so much of it, such as half its last digit."""
    agrees = math.isfinite(ours) and abs(ours - paper) <= within
    verdict = AGREES if agrees else DIFFERS
    return Row(quantity=quantity, paper=paper, ours=ours, unit=unit, verdict=verdict, note=note)


def feature(
    quantity: str, paper: str, ours: float | str, unit: str = "", *, holds: bool, note: str = ""
) -> Row:
    """Something the paper shows or says in words, and the measurement that decides it."""
    verdict = AGREES if holds else DIFFERS
    return Row(quantity=quantity, paper=paper, ours=ours, unit=unit, verdict=verdict, note=note)


def record(quantity: str, ours: float | str, unit: str = "", note: str = "") -> Row:
    """A number that the paper does not print."""
    return Row(quantity=quantity, paper=None, ours=ours, unit=unit, verdict=OPEN, note=note)


@dataclass(frozen=True, kw_only=True)
class Result:
    """Rows, figures by name, and remarks: paragraphs of plain text."""

    rows: tuple[Row, ...] = ()
    figures: dict[str, Figure] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Item:
    """One table, figure or claim.

    Attributes:
        key: as in `--only`, such as "fig18".
        title: heading in the report.
        shows: what the paper shows or claims there.
        make: computes it.
    """

    key: str
    title: str
    shows: str
    make: Callable[[Workshop], Result]


def rows_to_data(rows: tuple[Row, ...]) -> list[dict[str, Any]]:
    """As plain data, for JSON."""
    return [asdict(row) | {"ratio": row.ratio} for row in rows]


def row_from_data(data: dict[str, Any]) -> Row:
    """The row that `rows_to_data` wrote.

    Raises:
        TypeError, ValueError: it is none.
    """
    parts = {key: value for key, value in data.items() if key != "ratio"}
    row = Row(**parts)
    words = (row.quantity, row.unit, row.verdict, row.note)
    numbers = all(isinstance(x, str | float | int) or x is None for x in (row.paper, row.ours))
    if not all(isinstance(word, str) for word in words) or not numbers:
        raise TypeError("an entry of a row is of another type")
    return row
