"""Paths of two joints that go round once, and the search for the one that gains most."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import ModelError, ParameterError

PER = ("cycle", "travel")
_SAMPLES = 64

Gain = Callable[[Array, Array], tuple[float, Array]]
"""(path (n, 2), its rate (n, 2)) over a turn -> what it gains, and the change with each point."""


def check_search(per: str, harmonics: int) -> None:
    """Raise ParameterError unless there is such a search."""
    if per not in PER:
        raise ParameterError(f"per is {per!r}: it must be one of {', '.join(PER)}.")
    if not isinstance(harmonics, int) or harmonics not in range(1, 21):
        raise ParameterError(f"harmonics is {harmonics!r}: it must be a whole number 1 to 20.")


def largest_region(
    first: Array, second: Array, heights: Array, tiny: float
) -> tuple[float, Array, Array]:
    """Integral, centre (2,) and spread (2,) of the region of one sign that holds most.

    Args:
        first, second: centres of the cells (m,), (n,).
        heights: of each cell (m, n).
        tiny: what counts as zero.
    """
    from scipy.ndimage import label

    cell = float((first[1] - first[0]) * (second[1] - second[0]))
    best = 0.0, np.zeros(2), np.zeros(2)
    for sign in (1, -1):
        labels, count = label(sign * heights > tiny)
        for i in range(1, count + 1):
            inside = labels == i
            whole = float(heights[inside].sum() * cell)
            if abs(whole) > abs(best[0]):
                weight = np.abs(np.where(inside, heights, 0.0))
                weight /= weight.sum()
                grid = np.stack(np.meshgrid(first, second, indexing="ij"))
                middle = np.sum(grid * weight, axis=(1, 2))
                deviation = grid - middle[:, None, None]
                best = whole, middle, np.sqrt(np.sum(deviation**2 * weight, axis=(1, 2)))
    return best


class PathSearch:
    """Sequential quadratic programming over paths that go round once, as seen from their middle.

        phi(t) = middle + rho(t) (w_j cos t, w_k sin t),   rho > 0 a Fourier series

    is a Fourier series with one harmonic more than rho. Free series would find paths that cross
    themselves to wind again and again, each time for more.

    Args:
        gain: what a path gains: the most is searched for.
        box: limits of the two (2, 2).
        harmonics: of the path.
        per: "cycle", the gain itself, or "travel", per length of the path.
    """

    def __init__(self, gain: Gain, box: Array, harmonics: int, per: str) -> None:
        self.gain, self.box, self.harmonics, self.per = gain, box, harmonics, per
        self.scale = 1.0

    def value(self, x: Array) -> tuple[float, Array]:
        """What is minimised, with its gradient."""
        path, rate = (np.reshape(part @ x, (-1, 2)) for part in (self.place, self.tangent))
        gain, change = self.gain(path, rate)
        slope = self.place.T @ change.ravel()
        if self.per == "travel":
            weight = 2 * np.pi / len(path)
            speed = np.sqrt(np.sum(rate**2, axis=1) + 1e-12)
            travel = weight * float(speed.sum())
            stretch = weight * self.tangent.T @ (rate / speed[:, None]).ravel()
            gain, slope = gain / travel, (slope - gain / travel * stretch) / travel
        return -gain / self.scale, -slope / self.scale

    def run(self, middle: Array, spread: Array) -> Array:
        """The best series (1 + 2 harmonics, 2), rows 1, cos, sin."""
        from scipy.optimize import minimize

        room = np.minimum(middle - self.box[:, 0], self.box[:, 1] - middle)
        width = np.minimum(1.2 * spread, 0.95 * room)
        self.place, self.tangent, round_about = _polar(width, _SAMPLES, self.harmonics)
        start = np.zeros(self.place.shape[1])
        start[:2], start[2] = middle, 1.0
        self.scale = abs(self.value(start)[0]) or 1.0
        # Both legs within limits at all samples, and rho above zero: linear in the coefficients.
        matrix = np.vstack((self.place, -self.place, round_about))
        low, high = (np.tile(side, _SAMPLES) for side in self.box.T)
        bound = np.concatenate((low, -high, np.full(_SAMPLES, 0.05)))
        constraint: Any = {
            "type": "ineq",
            "fun": lambda x: matrix @ x - bound,
            "jac": lambda x: matrix,
        }
        found = minimize(
            self.value,
            start,
            jac=True,
            method="SLSQP",
            constraints=[constraint],
            options={"maxiter": 100, "ftol": 1e-8},
        )
        if not np.all(np.isfinite(found.x)):
            raise ModelError(f"the search for a cycle failed: {found.message}.")
        # The samples are more than the series has terms, so this is exact.
        path = np.reshape(self.place @ found.x, (-1, 2))
        series = np.linalg.lstsq(_series(_SAMPLES, self.harmonics), path, rcond=None)[0]
        return self._inside(np.asarray(series, dtype=float))

    def _inside(self, series: Array) -> Array:
        """Shrunk about the middle of the limits where the path is outside between its samples."""
        path = _series(2048, self.harmonics) @ series
        center, half = self.box.mean(axis=1), np.ptp(self.box, axis=1) / 2
        factor = min(1.0, float((half / np.abs(path - center).max(axis=0)).min()) * (1 - 1e-12))
        moved = factor * series
        moved[0] += (1 - factor) * center
        return moved


def _polar(width: Array, samples: int, harmonics: int) -> tuple[Array, Array, Array]:
    """Path and tangent (2 samples, coefficients), and rho (samples, coefficients), each linear."""
    t = 2 * np.pi * np.arange(samples) / samples
    rho = _series(samples, harmonics - 1)
    j = np.arange(1, harmonics)
    slope = np.hstack((0 * t[:, None], -j * np.sin(np.outer(t, j)), j * np.cos(np.outer(t, j))))
    ray = np.column_stack((np.cos(t), np.sin(t)))[:, :, None] * width[:, None]
    turn = np.column_stack((-np.sin(t), np.cos(t)))[:, :, None] * width[:, None]
    path = ray * rho[:, None]
    tangent = turn * rho[:, None] + ray * slope[:, None]
    middle = np.tile(np.eye(2), (samples, 1))
    n = rho.shape[1]
    return (
        np.hstack((middle, path.reshape(-1, n))),
        np.hstack((0 * middle, tangent.reshape(-1, n))),
        np.hstack((np.zeros((samples, 2)), rho)),
    )


def _series(samples: int, harmonics: int) -> Array:
    """Values (samples, 1 + 2 harmonics) of 1, cos j t, sin j t over one turn."""
    t = 2 * np.pi * np.arange(samples) / samples
    angle = np.outer(t, np.arange(1, harmonics + 1))
    return np.hstack((np.ones((samples, 1)), np.cos(angle), np.sin(angle)))
