"""A search over gaits: what a gait scores, a global search, and a local polish.

Scores order gaits by Deb's rules: valid ones by their objective, invalid ones behind them by how
much they violate. Differential evolution compares scores only, so jumps between them do no harm.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.optimise_goals import GaitLimits, Goal, Table
from rrrobot.optimise_space import Population, Space

Progress = Callable[[int, int], None]
"""Called with the gaits simulated so far and the budget."""

_MISSED, _INVALID, _STOPPED = 1e6, 1e9, 1e15
_EXACT = ("max_variation", "swing")
_MARGIN = 2e-3
"""Distance that gaits keep from limits but those."""
_STEP = 1e-4
"""Of central differences, in the scaled box."""
_TOGETHER = 2e-3
"""Width of a population, in the scaled box, at which a global search ends."""


class Spent(Exception):
    """The budget does not allow another batch."""


class Evaluator:
    """Counts and keeps what is simulated.

    Args:
        engine: population -> results.
        space: the box of gaits.
        budget: gaits that may be simulated.
        progress: see `Progress`.
    """

    def __init__(
        self,
        engine: Callable[[Population], Array],
        space: Space,
        budget: int,
        progress: Progress | None = None,
    ) -> None:
        self.engine, self.space, self.budget = engine, space, budget
        self.progress = progress
        self.used = 0
        self._points: list[Array] = []
        self._tables: list[Table] = []

    def __call__(self, points: Array) -> Table:
        """Results of points (n, space.n).

        Raises:
            Spent: there is no budget for them.
        """
        if self.used + len(points) > self.budget:
            raise Spent
        gaits = self.space.population(points)
        table = Table(self.engine(gaits), *gaits.extremes())
        self.used += len(points)
        self._points.append(points.copy())
        self._tables.append(table)
        if self.progress is not None:
            self.progress(self.used, self.budget)
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
    largest_swing: float
    tolerance: float = 0.02
    """of targets, relative, in a score"""

    def slacks(self, table: Table, margin: float = _MARGIN) -> dict[str, Array]:
        """How far inside each limit the gaits are (n,), of order one."""
        found = {
            name: slack - margin * (name not in _EXACT)
            for name, (slack, _) in self.limits.slack(
                table, self.weight, self.largest_swing
            ).items()
        }
        if self.goal.min_speed > 0:
            found["min_speed"] = table.speed / self.goal.min_speed - 1.0 - 0.05 * margin
        return found

    def scores(self, table: Table) -> Array:
        """Lower is better (n,)."""
        violation = np.zeros(table.speed.shape)
        for slack in self.slacks(table).values():
            violation += np.maximum(0.0, -slack)
        misses = self.goal.misses(table)
        miss = np.zeros(table.speed.shape) if misses is None else np.abs(misses).max(axis=1)
        score = np.where(miss > self.tolerance, _MISSED + miss, self.goal.objective(table))
        score = np.where(violation > 0, _INVALID * (1 + violation) + miss, score)
        return np.where(np.isfinite(score) & (table.status == 0), score, _STOPPED)

    def valid(self, scores: Array) -> Array:
        """Whether scores are those of gaits within the limits, with a target reached (n,)."""
        return np.asarray(scores < _MISSED)


def global_search(evaluator: Evaluator, task: Task, rng: np.random.Generator, budget: int) -> None:
    """Differential evolution within a budget of gaits; the results are in the archive.

    It ends early when its population has drawn together.
    """
    from scipy.optimize import differential_evolution

    n = evaluator.space.n
    size = 16 * int(np.clip(np.ceil(10 * n / 16), 2, 8))
    generations = budget // size - 1
    if generations < 1:
        evaluator(latin_hypercube(rng, min(budget, size), n))
        return
    options: dict[str, Any] = {
        "init": latin_hypercube(rng, size, n),
        "maxiter": generations,
        # Scores jump, so their spread says nothing; see `drawn_together`.
        "tol": 0.0,
        "mutation": (0.4, 0.9),
        "recombination": 0.8,
        "seed": rng,
        "polish": False,
        "updating": "deferred",
        "vectorized": True,
    }

    def scores(points: Any) -> Any:
        return task.scores(evaluator(points.T))

    def drawn_together(intermediate_result: Any) -> bool:
        return bool(np.ptp(intermediate_result.population, axis=0).max() < _TOGETHER)

    box: Any = [(0.0, 1.0)] * n
    differential_evolution(scores, box, callback=drawn_together, **options)


def latin_hypercube(rng: np.random.Generator, size: int, n: int) -> Array:
    """Points in the unit box, one in each of `size` slices along every axis (size, n)."""
    slices = rng.permuted(np.tile(np.arange(size), (n, 1)), axis=1).T
    return (slices + rng.random((size, n))) / size


def best_points(points: Array, scores: Array, count: int, distance: float = 0.1) -> Array:
    """The best points that are at least a distance per axis apart (k <= count, n)."""
    chosen: list[Array] = []
    apart = distance * np.sqrt(points.shape[1])
    for i in np.argsort(scores, kind="stable"):
        if all(np.linalg.norm(points[i] - other) > apart for other in chosen):
            chosen.append(points[i])
        if len(chosen) == count:
            break
    return np.array(chosen)


def polish(
    evaluator: Evaluator,
    task: Task,
    point: Array,
    *,
    nearest: bool = False,
    iterations: int = 60,
) -> None:
    """Sequential quadratic programming from a point; the results are in the archive.

    Gradients are central differences, simulated side by side. A target is an equality, or, with
    `nearest`, the distance from it is minimised.
    """
    from scipy.optimize import minimize

    local = _Local(evaluator, task, point, nearest)
    low, high = evaluator.space.box()

    def part(name: str, order: int = 0) -> Callable[[Array], Array]:
        return lambda x: local(x)[order][name]

    constraints = [{"type": "ineq", "fun": part("slack"), "jac": part("slack", 1)}]
    if local.equality:
        constraints.append({"type": "eq", "fun": part("miss"), "jac": part("miss", 1)})
    problem: dict[str, Any] = {
        "fun": part("objective"),
        "jac": part("objective", 1),
        "bounds": list(zip(low, high, strict=True)),
        "constraints": constraints,
        "method": "SLSQP",
        "options": {"maxiter": iterations, "ftol": 1e-9},
    }
    minimize(x0=point, **problem)


class _Local:
    """Objective, limits and misses about a point, with their gradients."""

    def __init__(self, evaluator: Evaluator, task: Task, point: Array, nearest: bool) -> None:
        self.evaluator, self.task, self.nearest = evaluator, task, nearest
        self.low, self.high = evaluator.space.box()
        self.at: Array | None = None
        table = evaluator(point[None])
        self.equality = task.goal.misses(table) is not None and not nearest
        self.scale = max(abs(float(task.goal.objective(table)[0])), 1e-9)

    def __call__(self, x: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        """Values and gradients by name."""
        if self.at is None or not np.array_equal(self.at, x):
            n = x.size
            ahead = np.minimum(x + _STEP, self.high) - x
            behind = x - np.maximum(x - _STEP, self.low)
            points = np.vstack((x, x + np.diag(ahead), x - np.diag(behind)))
            values = self._values(self.evaluator(points))
            slopes = {
                name: (v[1 : n + 1] - v[n + 1 :]).T / (ahead + behind) for name, v in values.items()
            }
            self.at = x.copy()
            self.found = {name: v[0] for name, v in values.items()}, slopes
        return self.found

    def _values(self, table: Table) -> dict[str, Array]:
        task = self.task
        slacks = [s for name, s in task.slacks(table).items() if name != "max_variation"]
        values = {"slack": np.column_stack(slacks)}
        misses = task.goal.misses(table)
        if misses is not None and self.nearest:
            values["objective"] = (misses**2).sum(axis=1)
        else:
            values["objective"] = task.goal.objective(table) / self.scale
        if misses is not None and self.equality:
            values["miss"] = misses
        # A gait that stopped must not poison the step that led to it.
        return {
            name: np.nan_to_num(v, nan=1e3, posinf=1e3, neginf=-1e3) for name, v in values.items()
        }
