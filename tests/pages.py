"""What the pages say in words; a page is named as from docs/."""

import re
from collections.abc import Iterable
from pathlib import Path

DOCS = Path(__file__).parent.parent / "docs"


def joined(page: str) -> str:
    """A page with its lines joined."""
    return " ".join((DOCS / page).read_text().split())


def said(page: str, sentence: str) -> tuple[str, ...]:
    """The groups of the one place of a page that matches, its lines joined."""
    (found,) = re.finditer(sentence, joined(page))
    return found.groups()


def number(text: str) -> float:
    """As pages print it."""
    return float(text.replace("\N{MINUS SIGN}", "-"))


def numbers(page: str, sentence: str) -> tuple[float, ...]:
    """Those of the one place of a page that matches."""
    return tuple(map(number, said(page, sentence)))


def is_printed(value: float, text: str) -> bool:
    """Whether a value, rounded to the digits that a page prints, is what it prints."""
    digits = len(re.sub(r"e.*|^[\u2212-]?0\.0*|[.\u2212-]", "", text))
    return abs(float(f"{value:.{digits - 1}e}") - number(text)) <= 1e-9 * abs(number(text))


def are_printed(values: Iterable[float], page: str, sentence: str) -> None:
    """Values, rounded to the digits of the one place of a page that matches, are what it prints."""
    for value, text in zip(values, said(page, sentence), strict=True):
        assert is_printed(value, text), f"{page} says {text}, it is {value}"
