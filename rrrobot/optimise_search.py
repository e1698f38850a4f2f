"""A search over gaits: samples of the box, and sequential quadratic programming from the best."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.optimise_table import Table
from rrrobot.optimise_task import (
    TIGHT,
    Evaluator,
    Spent,
    Task,
    best_point,
    best_points,
    best_score,
)

_STEP = 1e-4
"""Of central differences, in the scaled box."""
_SAMPLED, _STARTED = 0.2, 0.8
"""Parts of the budget after which sampling ends, and after which no new start is polished."""
_STARTS, _PATIENCE, _POLISHED_AGAIN = 40, 9, 3
_BATCH = 256


def search(evaluator: Evaluator, task: Task, rng: np.random.Generator) -> Array:
    """The best point found within what the evaluator allows (n,).

    A fifth of that samples the box; the best samples that are not neighbours are polished
    until several in a row bring nothing new; the winner is polished again.
    """
    if evaluator.space.n == 0:
        evaluator(np.zeros((1, 0)))
        return np.zeros(0)
    tight = task._replace(tolerance=TIGHT)
    try:
        sample(evaluator, rng, int(_SAMPLED * evaluator.allowed))
        points, table = evaluator.archive()
        idle, best = 0, np.inf
        for start in best_points(points, task.scores(table), _STARTS):
            if idle == _PATIENCE or evaluator.used > _STARTED * evaluator.allowed:
                break
            polish(evaluator, task, start)
            if task.goal.tolerance > 0 and not tight.reached(evaluator.archive()[1]):
                polish(evaluator, task, start, nearest=True)
            now = best_score(evaluator, tight)
            idle = 0 if now < best - 1e-4 * abs(best) else idle + 1
            best = min(best, now)
        nearest = task.goal.tolerance > 0 and not tight.valid(np.array(best))
        for _ in range(_POLISHED_AGAIN):
            polish(evaluator, task, best_point(evaluator, tight), nearest=nearest)
    except Spent:
        pass
    return best_point(evaluator, tight)


def sample(evaluator: Evaluator, rng: np.random.Generator, count: int) -> None:
    """Simulate a Latin hypercube of gaits; the results are in the archive.

    Every other batch is one of sinusoids: of few numbers, they fill the box better.
    """
    from scipy.stats.qmc import LatinHypercube

    sampler = LatinHypercube(evaluator.space.n, seed=rng)
    for batch, first in enumerate(range(0, count, _BATCH)):
        points = sampler.random(min(_BATCH, count - first))
        evaluator(points if batch % 2 else evaluator.space.sinusoids(points))


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
