"""What the property-based tests share: settings that repeat from run to run, and generators."""

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy


def examples(n: int) -> settings:
    """`n` examples, the same in each run."""
    return settings(max_examples=n, derandomize=True, deadline=None)


def vectors(size: int, low: float, high: float) -> SearchStrategy[np.ndarray]:
    """Arrays (size,) of numbers between the bounds."""
    return st.lists(st.floats(low, high), min_size=size, max_size=size).map(np.array)


def directions() -> SearchStrategy[np.ndarray]:
    """Unit vectors (3,)."""
    whole = vectors(3, -1, 1).filter(lambda v: np.linalg.norm(v) > 0.1)
    return whole.map(lambda v: v / np.linalg.norm(v))
