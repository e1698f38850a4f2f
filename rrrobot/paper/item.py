"""What reproducing one table, figure or claim of the paper gives."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from rrrobot.errors import RRRobotError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rrrobot.paper.workshop import Workshop

AGREES, DIFFERS, ERRATUM, INPUT, OPEN = "agrees", "differs", "erratum", "input", "not printed"
"""Verdicts: as the paper has it; not so; the paper contradicts itself or its own Table 2, and we
say what is right; taken from the paper, so its agreement says nothing; the paper gives no number,
ours is for the record."""
VERDICTS = (AGREES, DIFFERS, ERRATUM, INPUT, OPEN)


class Limit(NamedTuple):
    """What a number is held against: ours agrees if it is above `low` and below `high`."""

    low: float = -math.inf
    high: float = math.inf

    def holds(self, ours: float) -> bool:
        """Whether a number lies between; not a number never does."""
        return bool(self.low < ours < self.high)

    def __str__(self) -> str:
        if self.low == -math.inf:
            return f"< {self.high:.3g}"
        if self.high == math.inf:
            return f"> {self.low:.3g}"
        middle, half = (self.low + self.high) / 2, (self.high - self.low) / 2
        return f"{middle:.5g} ± {half:.2g}"


def below(high: float) -> Limit:
    """A number that is to be small."""
    return Limit(high=float(high))


def above(low: float) -> Limit:
    """A number that is to be large."""
    return Limit(low=float(low))


def about(value: float, within: float) -> Limit:
    """A number that is to be near another."""
    return Limit(float(value - within), float(value + within))


@dataclass(frozen=True, kw_only=True)
class Row:
    """One comparison with the paper.

    Attributes:
        quantity: what is compared.
        paper: what the paper prints or says; None if nothing.
        ours: what we get; a number is in `unit`.
        unit: of the numbers.
        verdict: one of VERDICTS.
        limit: what decided between agreement and difference, as text; empty without a verdict.
        note: one sentence where the verdict needs a reason.
    """

    quantity: str
    paper: float | str | None
    ours: float | str
    unit: str = ""
    verdict: str
    limit: str = ""
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
    return Row(
        quantity=quantity, paper=paper, ours=ours, unit=unit, note=note,
        verdict=AGREES if agrees else DIFFERS, limit=f"{paper:.5g} ± {within:.2g}",
    )  # fmt: skip


def feature(
    quantity: str, paper: str, ours: float, unit: str = "", *, limit: Limit, note: str = ""
) -> Row:
    """Something the paper shows or says in words, and the measurement that decides it."""
    return Row(
        quantity=quantity, paper=paper, ours=ours, unit=unit, note=note, limit=str(limit),
        verdict=AGREES if limit.holds(ours) else DIFFERS,
    )  # fmt: skip


def taken(quantity: str, paper: float, ours: float, unit: str = "") -> Row:
    """A parameter that is taken from the paper.

    Raises:
        RRRobotError: it is another by now.
    """
    if ours != paper:
        raise RRRobotError(f"{quantity} is {ours:g}, and the paper prints {paper:g}.")
    return Row(quantity=quantity, paper=paper, ours=ours, unit=unit, verdict=INPUT)


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
