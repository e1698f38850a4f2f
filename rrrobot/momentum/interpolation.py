"""Matrices from the samples of a cycle to what lies between them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rrrobot.checks import Array
from rrrobot.momentum.compiled import inner


@lru_cache(maxsize=8)
def interpolation(n: int, points: int) -> Array:
    """Matrix (points, n) from n samples of a period to their trigonometric interpolation."""
    spectrum = np.fft.rfft(np.eye(n), axis=0)
    if n % 2 == 0:
        # Half of the Nyquist term stands at each end of the longer spectrum.
        spectrum[-1] *= 0.5
    return np.ascontiguousarray(points / n * np.fft.irfft(spectrum, points, axis=0))


_REFINED = 2
_FINE = 96
"""Least number of points in a cycle that extremes are first looked for at."""


def between(steps: int, periodic: bool) -> tuple[Array, Array]:
    """Matrices from the steps of a cycle to more instants of it, and from these to fine points.

    Trigonometric interpolation at twice as many instants where the cycle repeats; else the steps
    themselves, and a spline.
    """
    if not periodic:
        return np.eye(steps), spline_matrix(steps, -(-_FINE // steps), 0)
    instants = _REFINED * steps
    return (
        interpolation(steps, instants),
        interpolation(instants, instants * -(-_FINE // instants)),
    )


@lru_cache(maxsize=8)
def spline_matrix(n: int, times: int, order: int) -> Array:
    """Matrix from n samples at 0, 1, ... to a derivative of their spline, `times` points for each.

    For what does not repeat; the last point is the last sample. Quintic with 6 samples or more.
    """
    from scipy.interpolate import make_interp_spline

    at = np.arange(times * (n - 1) + 1) / times
    spline = make_interp_spline(np.arange(n, dtype=float), np.eye(n), k=5 if n >= 6 else 3)
    return np.ascontiguousarray(spline(at, order))


@inner
def interpolate(weights, motion, entry, out):  # type: ignore[no-untyped-def]
    """One entry of a motion at the points between, of transposed weights (n, points)."""
    for k in range(len(out)):
        out[k] = 0.0
    for m in range(len(motion)):
        now = motion[m, entry]
        for k in range(len(out)):
            out[k] += weights[m, k] * now
