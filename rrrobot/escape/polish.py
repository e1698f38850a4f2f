"""From a gait within the limits, or near them, to the best one nearby: all joints, all harmonics.

Sequential linear programming in a trust region: goal and limits are linearised by differences,
simulated side by side; the linear program's step and parts of it are simulated too, and the best
of them is the next gait. Where many limits bind, as they do at a fast gait, this goes straight to
the corner.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import scipy.linalg

from rrrobot.checks import Array
from rrrobot.drive.gaits import GaitBatch
from rrrobot.escape.bench import Bench, Outcome
from rrrobot.escape.limits import Rules

_STEP = 1e-3
"""Of the differences, in units of the swings' room."""
_MARGIN = 4e-3
"""Slack that is kept for what differs between instants looked at and all others."""
_PARTS = np.array((1.0, 0.6, 0.3, 0.1))
_GAIN = 1e-4
"""Of a step, in units of the goal's value, below which the next one is shorter."""
_PRICE = 10.0
"""Of a slack that is missing, in units of the goal's value."""
_FIRST, _WIDEST, _NARROWEST = 0.1, 0.5, 2e-3
"""Half widths of the trust region, in units of the swings' room."""


class Scale(NamedTuple):
    """Gaits as points: (offset, sines, cosines) over the swings' room, log of the frequency."""

    room: Array
    """(legs,) [rad]"""
    harmonics: int

    def points(self, gaits: GaitBatch) -> Array:
        """Points (n, m) of gaits."""
        n, h = gaits.n, gaits.sine.shape[1]
        parts = [gaits.offset / self.room]
        for coefficients in (gaits.sine, gaits.cosine):
            padded = np.zeros((n, self.harmonics, self.room.size))
            padded[:, :h] = coefficients / self.room
            parts.append(padded.reshape(n, -1))
        return np.column_stack((*parts, np.log(gaits.angular_frequency)))

    def directions(self, swings: Array, offsets: Array) -> Array:
        """Points' directions, as columns, in which swings and offsets keep within spaces.

        Args:
            swings, offsets: columns span what each may be (legs, k).
        """
        parts = [offsets, *[swings] * (2 * self.harmonics), np.eye(1)]
        whole = scipy.linalg.block_diag(*parts)
        whole[:-1] /= np.tile(self.room, 1 + 2 * self.harmonics)[:, None]
        return np.asarray(whole / np.abs(whole).max(axis=0))

    def gaits(self, points: Array) -> GaitBatch:
        """Gaits of points (n, m)."""
        legs, n = self.room.size, len(points)
        edges = legs * np.array((1, 1 + self.harmonics, 1 + 2 * self.harmonics))
        offset, sine, cosine, log = np.split(points, edges, axis=1)
        shape = (n, self.harmonics, legs)
        return GaitBatch(
            offset * self.room, np.zeros((n, legs)), sine.reshape(shape) * self.room,
            cosine.reshape(shape) * self.room, np.exp(log[:, 0]),
        )  # fmt: skip


class Judged(NamedTuple):
    """One gait, what it does, and how good that is."""

    gait: GaitBatch
    outcome: Outcome
    value: float
    """of the goal; minus infinity where the gait stopped or does not settle"""
    slack: float
    """least of all limits"""
    binding: tuple[str, ...]
    """limits that bind or are broken"""

    @property
    def valid(self) -> bool:
        """Whether it is within all limits."""
        return self.slack >= 0 and bool(np.isfinite(self.value))

    def better_than(self, other: Judged) -> bool:
        """Deb's rules: within the limits before outside, then by value, or by slack outside."""
        if self.valid != other.valid:
            return self.valid
        return self.value > other.value if self.valid else self.slack > other.slack


def judge(rules: Rules, gaits: GaitBatch, out: Outcome) -> list[Judged]:
    """Gaits with their values and least slacks."""
    names, slacks = rules.slacks(gaits, out)
    found = []
    for i, value in enumerate(rules.value(out)):
        here = np.array([i])
        bound = {n for n, s in zip(names, slacks[i], strict=True) if s < 4 * _MARGIN}
        found.append(
            Judged(gaits.rows(here), out.rows(here), float(value), float(slacks[i].min()),
                   tuple(sorted(bound)))
        )  # fmt: skip
    return found


def climb(
    bench: Bench,
    rules: Rules,
    start: Judged,
    scale: Scale,
    *,
    free: Array | None = None,
    iterations: int = 30,
) -> Iterator[Judged]:
    """The best gait near one, better after every step; ends where no step leads on.

    Args:
        bench: where gaits run.
        rules: limits and the goal.
        start: a gait that settles.
        scale: of the points, and how many harmonics.
        free: directions in which to go, as columns (m, k); all unless given.
        iterations: at most.
    """
    x, best = scale.points(start.gait)[0], start
    ways = np.eye(x.size) if free is None else free
    unit = max(abs(start.value), 1e-6)
    radius = _FIRST
    for _ in range(iterations):
        gaits = scale.gaits(np.vstack((x, x + _STEP * ways.T)))
        out = bench(gaits)
        values, slacks = rules.value(out) / unit, rules.slacks(gaits, out)[1]
        if not np.isfinite(values[0]):
            return
        merit = _merit(values[:1], slacks[:1])[0]
        # A neighbour that does not settle says nothing.
        slope = np.nan_to_num((values[1:] - values[0]) / _STEP, neginf=0.0, posinf=0.0)
        lean = (slacks[1:] - slacks[0]).T / _STEP
        gained = -np.inf
        while gained <= _GAIN:
            if radius < _NARROWEST:
                yield best
                return
            step = ways @ _linear_step(slope, slacks[0] - _MARGIN, lean, radius)
            tries = scale.gaits(x + np.outer(_PARTS, step))
            found = judge(rules, tries, tried := bench(tries))
            gains = _merit(rules.value(tried) / unit, rules.slacks(tries, tried)[1]) - merit
            for one in found:
                if one.better_than(best):
                    best = one
            k = int(np.argmax(gains))
            gained = gains[k]
            radius *= 0.25 if gained <= _GAIN else min(1.6, 2 * _PARTS[k]) if k else 1.6
        x = x + _PARTS[k] * step
        radius = min(_WIDEST, radius)
        yield best


def _merit(values: Array, slacks: Array) -> Array:
    """What steps shall raise (n,)."""
    missing = np.maximum(0.0, _MARGIN - slacks).sum(axis=1)
    return np.nan_to_num(values, neginf=-1e6) - _PRICE * missing


def _linear_step(slope: Array, slack: Array, lean: Array, radius: float) -> Array:
    """The step of the linearised problem within the trust region, limits softened by a price."""
    from scipy.optimize import linprog

    m = slope.size
    # Unknowns: the step (m,), and how much is missing of each limit that is near.
    near = slack - radius * np.abs(lean).sum(axis=1) < 0
    k = int(near.sum())
    found = linprog(
        np.concatenate((-slope, np.full(k, _PRICE))),
        A_ub=np.hstack((-lean[near], -np.eye(k))) if k else None,
        b_ub=slack[near] if k else None,
        bounds=[(-radius, radius)] * m + [(0, None)] * k,
    )
    return radius * np.sign(slope) if found.x is None else np.asarray(found.x[:m])
