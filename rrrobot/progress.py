"""How far a long piece of work is: one protocol of `progress=` for all that take it.

True shows a bar on stderr, with the rate and the time left; False shows nothing; a function is
called with (done, total), whose unit the caller's docstring names; None shows a bar if stderr is a
terminal. Bars appear after a second.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rrrobot.errors import ParameterError

Progress = bool | Callable[[float, float], object] | None
Tell = Callable[..., None]
"""Told what is done, and if it likes which part is worked on, in words."""


def checked_progress(progress: Progress) -> None:
    """Raise ParameterError unless it is one of the wishes."""
    if callable(progress):
        return
    if progress is not None and not isinstance(progress, bool):
        raise ParameterError(
            f"progress is {progress!r}: it must be True for a bar, False for none, None for one if "
            "stderr is a terminal, or a function of (done, total)."
        )


@contextmanager
def progress_of(
    progress: Progress, what: str, total: float, unit: str, done: float = 0
) -> Iterator[Tell | None]:
    """A function that is told what is done; None where nobody listens.

    Args:
        progress: the caller's wish.
        what: title of a bar.
        total: when it is finished.
        unit: of what is done, such as "gaits" or "s".
        done: already.

    Raises:
        ParameterError: the wish is none of those.
    """
    if callable(progress):
        wish = progress

        def told(now: float, part: str = "") -> None:
            wish(now, total)

        yield told
        return
    checked_progress(progress)
    if not (sys.stderr.isatty() if progress is None else progress):
        yield None
        return
    from tqdm import tqdm

    rate = {"bar_format": "{desc} {percentage:3.0f}% |{bar}| {n:.3g} of {total:.3g} s, "
                          "{remaining} left"} if unit == "s" else {}  # fmt: skip
    with tqdm(
        total=total, initial=done, desc=what, unit=f" {unit}", unit_scale=total > 10_000,
        delay=1.0 if progress is None else 0.0, leave=bool(progress), file=sys.stderr, **rate,
    ) as bar:  # fmt: skip

        def tell(now: float, part: str = "") -> None:
            if part:
                bar.set_description(part, refresh=False)
            bar.update(now - bar.n)

        yield tell
