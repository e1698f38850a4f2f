"""A search over gaits: what a point of the box scores, a global search, and a local polish.

Scores order points as Deb's rules do: valid gaits by their objective, invalid ones behind them by
how much they violate. Differential evolution compares scores only, so any jump between is fine.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.optimise_goals import COLUMNS, GaitLimits, Goal, Table
from rrrobot.optimise_space import Population, Space

Progress = Callable[[int, int, float], None]

_INVALID, _MISSED, _STOPPED = 1e9, 1e6, 1e12
_LOOSE, _TIGHT = 0.02, 1e-5
_MARGIN = 2e-3
_SPEED_MARGIN = 1e-4
_STEP = 1e-4
"""Of central differences, in the scaled box."""


class Spent(Exception):  # noqa: N818
    """The budget does not allow another batch."""


class Problem:
    """A goal and limits over a box of gaits.

    Attributes:
        evaluations: gaits that were simulated.
        points, scores: all of them.
        history: (evaluations, best value) after each batch that improved it.
    """

    def __init__(
        self,
        engine: Callable[[Population], Array],
        space: Space,
        goal: Goal,
        limits: GaitLimits,
        *,
        weight: float,
        budget: int,
        progress: Progress | None = None,
    ) -> None:
        self.engine, self.space, self.goal, self.limits = engine, space, goal, limits
        self.weight, self.budget, self.progress = weight, budget, progress
        self.evaluations = 0
        self.tolerance = _LOOSE
        self.archive = _Archive(space.n)
        self.history: list[tuple[int, float]] = []

    def table(self, points: Array) -> Table:
        """Results of points (n, space.n).

        Raises:
            Spent: they would exceed the budget.
        """
        if self.evaluations + len(points) > self.budget:
            raise Spent
        gaits = self.space.population(points)
        values = self.engine(gaits)
        self.evaluations += len(points)
        table = Table(values, *gaits.extremes())
        self.archive.add(points, values)
        return table

    def scores(self, table: Table) -> Array:
        """Lower is better (n,)."""
        violation = np.zeros(table.speed.shape)
        for slack in self.slacks(table).values():
            violation += np.maximum(0.0, -slack)
        miss = self.goal.misses(table)
        worst = np.zeros(table.speed.shape) if miss is None else np.abs(miss).max(axis=1)
        score = np.where(worst > self.tolerance, _MISSED + worst, self.goal.objective(table))
        score = np.where(violation > 0, _INVALID * (1 + violation) + worst, score)
        return np.where(np.isfinite(score) & (table.status == 0), score, _STOPPED)
