"""A goal, limits and a budget over a box of gaits: what a gait scores, and what is known so far.

Scores order gaits by Deb's rules: valid ones by their objective, behind them those that miss a
target by how far, behind them those outside the limits by how much.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits import GaitBatch
from rrrobot.models.base import Model
from rrrobot.progress import Tell
from rrrobot.results import STATUS
from rrrobot.robot.limits import JointEnds
from rrrobot.studies.optimisation.goals import Goal
from rrrobot.studies.optimisation.space import Space
from rrrobot.studies.optimisation.table import GaitLimits, Table

if TYPE_CHECKING:
    from rrrobot.studies.optimisation.lanes import Engine

TIGHT = 1e-5
"""Relative distance from a target that a polish must reach."""

_MISSED, _INVALID, _STOPPED = 1e6, 1e9, 1e15
_STEADY, _UNSTABLE = (
    next(k for k, name in STATUS.items() if name == wanted)
    for wanted in ("steady_state", "orbit_unstable")
)
_EXACT = ("max_variation", "lower of", "upper of")
"""Beginnings of the names of limits that gaits may touch."""
ROUNDING = 1e-12
_MARGIN = 2e-3
"""Distance that gaits keep from all others."""


class Spent(Exception):
    """The budget does not allow another batch."""


class Evaluator:
    """Counts and keeps what is simulated.

    Args:
        engine: of the model.
        space: the box of gaits.
        budget: gaits that may be simulated in all; `allowed` of them now.
    """

    def __init__(
        self,
        engine: Engine,
        space: Space,
        budget: int,
    ) -> None:
        self.engine, self.space = engine, space
        self.tell: Tell | None = None
        self.budget = self.allowed = budget
        self.used = 0
        self.cycles = 0.0
        self._points: list[Array] = []
        self._tables: list[Table] = []

    def __call__(self, points: Array, by: Callable[[GaitBatch], Table] | None = None) -> Table:
        """Results of points (n, space.n), by the engine, or by one for a local search.

        Raises:
            Spent: there is no budget for them.
        """
        if self.used + len(points) > self.allowed:
            raise Spent
        table = (by or self.engine)(self.space.population(points))
        self.used += len(points)
        self.cycles += float(table.cycles.sum())
        self._points.append(points.copy())
        self._tables.append(table)
        if self.tell is not None:
            self.tell(self.used)
        return table

    def archive(self) -> tuple[Array, Table]:
        """All points and their results, in the order in which they were simulated."""
        self._points = [np.concatenate(self._points)]
        self._tables = [Table.joined(self._tables)]
        return self._points[0], self._tables[0]


class Task(NamedTuple):
    """What is wanted of a gait."""

    goal: Goal
    limits: GaitLimits
    weight: float
    """of the robot [N]; 0 for a pivoted model, which has no ground to lift off from"""
    ends: JointEnds
    """of its legs"""
    legs: tuple[str, ...]
    """their names"""
    tolerance: float = 0.02
    """of targets, relative, in a score"""

    @classmethod
    def of(cls, model: Model, goal: Goal, limits: GaitLimits) -> Task:
        """A goal and limits for a model's robot.

        Raises:
            ParameterError: limits for each of another number of legs.
        """
        robot = model.robot
        weight = robot.mass * model.gravity if model.rolling is not None else 0.0
        return cls(goal, limits, weight, limits.ends(robot), robot.legs)

    def told(self, table: Table) -> dict[str, tuple[Array, str]]:
        """How far inside each limit the gaits are, and what it means; see `GaitLimits.slack`."""
        return self.limits.slack(table, self.weight, self.ends, self.legs)

    def slacks(self, table: Table, margin: float = _MARGIN) -> dict[str, Array]:
        """How far inside each limit the gaits are (n,), of order one."""
        found = {
            name: slack - margin * (not name.startswith(_EXACT))
            for name, (slack, _) in self.told(table).items()
        }
        if self.goal.min_speed > 0:
            found["min_speed"] = table.speed / self.goal.min_speed - 1.0 - 0.05 * margin
        if np.isfinite(table.multiplier).any():
            # An orbit that does not hold is outside a limit of its own.
            found["stable"] = 1.0 - table.multiplier - margin
        return found

    def scores(self, table: Table) -> Array:
        """Lower is better (n,)."""
        violation, miss = self._short(table)
        score = np.where(miss > self.tolerance, _MISSED + miss, self.goal.objective(table))
        score = np.where(violation > 0, _INVALID * (1 + violation) + miss, score)
        goes_on = np.isin(table.status, (_STEADY, _UNSTABLE))
        return np.where(np.isfinite(score) & goes_on, score, _STOPPED)

    def distances(self, table: Table) -> Array:
        """How far from valid (n,): by how much limits and a target are missed."""
        violation, miss = self._short(table)
        distance = violation + np.where(miss > self.tolerance, miss, 0.0)
        return np.nan_to_num(distance, nan=np.inf, posinf=np.inf)

    def _short(self, table: Table) -> tuple[Array, Array]:
        """By how much limits are broken, and a target is missed, each (n,)."""
        violation = np.zeros(table.speed.shape)
        for slack in self.slacks(table).values():
            violation += np.maximum(0.0, -slack - ROUNDING)
        misses = self.goal.misses(table)
        return violation, (0.0 * violation if misses is None else np.linalg.norm(misses, axis=1))

    def reached(self, table: Table) -> bool:
        """Whether any gait of a table is valid."""
        return bool(self.valid(self.scores(table)).any())

    def valid(self, scores: Array) -> Array:
        """Whether scores are those of gaits within the limits, with a target reached (n,)."""
        return np.asarray(scores < _MISSED)


def best_score(evaluator: Evaluator, task: Task) -> float:
    """The lowest score so far."""
    return float(task.scores(evaluator.archive()[1]).min())


def best_point(evaluator: Evaluator, task: Task) -> Array:
    """The point of the lowest score so far (n,)."""
    points, table = evaluator.archive()
    return points[np.argmin(task.scores(table))]


def best_points(points: Array, scores: Array, count: int, distance: float = 0.1) -> list[Array]:
    """The best points (n,) that are at least a distance per axis apart; none that stopped."""
    chosen: list[Array] = []
    apart = distance * np.sqrt(points.shape[1])
    for i in np.argsort(scores, kind="stable"):
        if scores[i] < _STOPPED and all(
            np.linalg.norm(points[i] - other) > apart for other in chosen
        ):
            chosen.append(points[i])
        if len(chosen) == count:
            break
    return chosen
