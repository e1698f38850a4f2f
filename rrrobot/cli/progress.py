"""Progress bars on stderr, if that is a terminal and the work takes more than a second."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from rrrobot.integrate import Progress
from rrrobot.studies.optimisation.task import Progress as SearchProgress


@contextmanager
def progress_bar(
    duration: float, *, quiet: bool = False, doing: str = "simulating"
) -> Iterator[Progress | None]:
    """Of the simulated time, or a film's [s]."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    form = "{desc} {percentage:3.0f}% |{bar}| {n:.3g} of {total:.3g} s, {remaining} left"
    with tqdm(
        total=duration, desc=doing, bar_format=form, leave=False, delay=1.0, file=sys.stderr
    ) as bar:
        yield lambda time: bar.update(time - bar.n)


@contextmanager
def gaits_bar(*, quiet: bool) -> Iterator[SearchProgress | None]:
    """Of the gaits that a search has simulated."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    with tqdm(desc="gaits", leave=False, delay=1.0, file=sys.stderr) as bar:

        def progress(used: int, budget: int) -> None:
            bar.total = budget
            bar.update(used - bar.n)

        yield progress
