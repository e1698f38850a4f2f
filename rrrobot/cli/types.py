"""Numbers and lists on the command line: 1.57, pi/2, -3*pi/4, and lists of them."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    _ParamType = click.ParamType[Any, Any]
else:
    # Older versions of click have no such parameters.
    _ParamType = click.ParamType

_DIGITS = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_NUMBER = re.compile(rf"([+-]?)(?:({_DIGITS})(?:\s*\*?\s*(pi))?|(pi))(?:\s*/\s*({_DIGITS}))?")


def parse_number(text: str) -> float:
    """A number, pi, or a multiple or fraction of pi.

    Raises:
        ValueError: anything else.

    Example:
        >>> parse_number("-3*pi/4") / math.pi
        -0.75
    """
    match = _NUMBER.fullmatch(text.strip())
    if match is None:
        raise ValueError(f"{text!r} is no number: write 1.57, pi, pi/2 or 3*pi/4.")
    sign, digits, times_pi, pi, divisor = match.groups()
    value = float(digits or 1.0) * (math.pi if times_pi or pi else 1.0)
    if divisor is not None:
        if float(divisor) == 0:
            raise ValueError(f"{text!r} divides by zero.")
        value /= float(divisor)
    return -value if sign == "-" else value


class Number(_ParamType):
    """One number."""

    name = "number"

    def convert(self, value: Any, param: Any, ctx: Any) -> float:
        try:
            return value if isinstance(value, float) else parse_number(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


class Numbers(_ParamType):
    """Numbers with commas between them -> tuple; one alone -> float, meant for every entry.

    Args:
        sizes: how many are allowed; any number of them if empty.
        words: words that are allowed instead of numbers.
    """

    name = "numbers"

    def __init__(self, *sizes: int, words: tuple[str, ...] = ()) -> None:
        self.sizes = sizes
        self.words = words

    def convert(self, value: Any, param: Any, ctx: Any) -> float | str | tuple[float, ...]:
        if not isinstance(value, str) or value in self.words:
            return value
        try:
            numbers = tuple(parse_number(entry) for entry in value.split(","))
        except ValueError as error:
            words = f" Or one of: {', '.join(self.words)}." if self.words else ""
            self.fail(f"{error}{words}", param, ctx)
        if self.sizes and len(numbers) not in self.sizes:
            allowed = " or ".join(str(size) for size in self.sizes)
            self.fail(
                f"{value!r} has {len(numbers)} numbers: give {allowed}, with commas between.",
                param,
                ctx,
            )
        return numbers if len(numbers) > 1 else numbers[0]


class Size(_ParamType):
    """WIDTHxHEIGHT -> two whole numbers [px]."""

    name = "size"

    def get_metavar(self, param: Any, ctx: Any = None) -> str:
        return "WxH"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value
        wide, _, high = str(value).lower().partition("x")
        if not (wide.isdigit() and high.isdigit()):
            self.fail(f"{value!r} is no size: write it as 1280x720.", param, ctx)
        return int(wide), int(high)


NUMBER = Number()
PER_LEG = Numbers()


def names(value: str | None) -> tuple[str, ...] | None:
    """Names with commas between them."""
    if value is None:
        return None
    return tuple(name.strip() for name in value.split(",") if name.strip())
