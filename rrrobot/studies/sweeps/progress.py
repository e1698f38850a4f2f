"""How far a sweep is: a bar on stderr, or a function that is told."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rrrobot.checks import told

Tell = Callable[[int], None]
"""Told the number of gaits that are done."""


@contextmanager
def progress_of(
    wish: bool | Callable[[int, int], None] | None, what: str, total: int, done: int
) -> Iterator[Tell]:
    """A function that is told the number of gaits done.

    Args:
        wish: True for a bar, False for none, None for one if stderr is a terminal, or a function
            that is called with (gaits done, gaits in all).
        what: title of the bar.
        total, done: gaits in all, and those that are done already.
    """
    if not isinstance(wish, bool):
        wish = told(wish)
    if callable(wish):
        wish(done, total)
        yield lambda now: wish(now, total)
        return
    if not (sys.stderr.isatty() if wish is None else wish):
        yield lambda now: None
        return
    from tqdm import tqdm

    with tqdm(
        total=total,
        initial=done,
        desc=what,
        unit=" gaits",
        unit_scale=total > 10_000,
        delay=1.0 if wish is None else 0.0,
        leave=bool(wish),
        file=sys.stderr,
    ) as bar:
        yield lambda now: bar.update(now - bar.n)
