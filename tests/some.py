"""Cases of which only some run by default; `make test-all` runs them all."""

from collections.abc import Callable, Collection, Iterable
from typing import Any

import pytest


def some(
    cases: Iterable[Any], by_default: Collection[str], name: Callable[[Any], str] = str
) -> list[Any]:
    """Parameters for pytest with the name of each as its id; slow but for those named."""
    cases = list(cases)
    unknown = set(by_default) - {name(case) for case in cases}
    if unknown:
        raise ValueError(f"no such cases: {sorted(unknown)}")
    return [
        pytest.param(
            *(case if isinstance(case, tuple) else (case,)),
            id=name(case),
            marks=() if name(case) in by_default else pytest.mark.slow,
        )
        for case in cases
    ]
