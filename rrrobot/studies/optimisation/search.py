"""A search over gaits: samples of the box, and sequential quadratic programming from the best."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.studies.optimisation.table import Table, discrepancy
from rrrobot.studies.optimisation.task import (
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
_STARTED_SIMPLE = 0.5
"""The second of them where higher harmonics come after sinusoids."""
_STARTS, _PATIENCE, _ENRICHED, _POLISHED_AGAIN = 40, 9, 3, 3
_BATCH = 256
_KICK = 0.02
_CANDIDATES, _APART, _SAME = 16, 0.02, 0.05
"""Points that are simulated until one comes to its orbit, their distance, and what is the same."""
_NEARER, _LONGEST_STALL = 1e-3, 10
"""Relative approach to what is valid that counts, and points in a row without it after which a
polish is given up."""


def search(evaluator: Evaluator, task: Task, rng: np.random.Generator) -> Array:
    """The best point found within what the evaluator allows (n,).

    Sinusoids are sampled; the best samples that are not neighbours are polished until several in a
    row bring nothing new; the best of these are polished with their higher harmonics, if there
    are any; the winner is polished again.
    """
    if evaluator.space.n == 0:
        evaluator(np.zeros((1, 0)))
        return np.zeros(0)
    tight = task._replace(tolerance=TIGHT)
    simple = evaluator.space.sinusoidal()
    started = _STARTED if simple.all() else _STARTED_SIMPLE
    try:
        sample(evaluator, rng, int(_SAMPLED * evaluator.allowed), simple)
        points, table = evaluator.archive()
        idle, best = 0, np.inf
        for start in best_points(points, task.scores(table), _STARTS):
            if idle == _PATIENCE or evaluator.used > started * evaluator.allowed:
                break
            polish(evaluator, task, start, simple)
            if task.goal.tolerance > 0 and not tight.reached(evaluator.archive()[1]):
                polish(evaluator, task, start, simple, nearest=True)
            now = best_score(evaluator, tight)
            idle = 0 if now < best - 1e-4 * abs(best) else idle + 1
            best = min(best, now)
        nearest = task.goal.tolerance > 0 and not tight.valid(np.array(best))
        if not simple.all():
            points, table = evaluator.archive()
            for start in best_points(points, tight.scores(table), _ENRICHED):
                # A symmetric gait may not feel the first bit of a harmonic.
                kick = np.where(simple, 0.0, rng.uniform(-_KICK, _KICK, start.size))
                polish(evaluator, task, start + kick, nearest=nearest)
        for _ in range(_POLISHED_AGAIN):
            polish(evaluator, task, best_point(evaluator, tight), nearest=nearest)
    except Spent:
        pass
    return best_point(evaluator, tight)


def attained(evaluator: Evaluator, task: Task, best: Array) -> tuple[Array, bool]:
    """The best point whose limit cycle an upright impulsive start comes to, and whether there is.

    Where several motions hold, an orbit that was followed from a neighbour may be another one.
    Without such a point it is the best of all.
    """
    check = evaluator.engine.check()
    if check is None:
        return best, True
    points, table = evaluator.archive()
    scores = task._replace(tolerance=TIGHT).scores(table)

    def tried(some: Array) -> NDArray[np.bool_]:
        run = check(evaluator.space.population(some))
        evaluator.cycles += float(run.cycles.sum())
        rows = [int(np.argmax((points == point).all(axis=1))) for point in some]
        gap = [discrepancy(table.rows([i]), run.rows([k])) for k, i in enumerate(rows)]
        return np.array(gap) < _SAME

    if tried(best[None])[0]:
        return best, True
    others = np.array(best_points(points, scores, _CANDIDATES, _APART))
    same = tried(others) if len(others) else np.zeros(1, dtype=bool)
    return (others[np.argmax(same)], True) if same.any() else (best, False)


def sample(
    evaluator: Evaluator, rng: np.random.Generator, count: int, free: NDArray[np.bool_]
) -> None:
    """Simulate a Latin hypercube over the free coordinates; the results are in the archive."""
    from scipy.stats.qmc import LatinHypercube

    points = np.full((count, free.size), 0.5)
    points[:, free] = LatinHypercube(int(free.sum()), seed=rng).random(count)
    for first in range(0, count, _BATCH):
        evaluator(points[first : first + _BATCH])


def polish(
    evaluator: Evaluator,
    task: Task,
    point: Array,
    free: NDArray[np.bool_] | None = None,
    *,
    nearest: bool = False,
    iterations: int = 60,
) -> None:
    """Sequential quadratic programming from a point; the results are in the archive.

    Gradients are central differences, side by side; of orbits they are those of the implicit
    function theorem, see `lanes`. A target is an equality, or, with
    `nearest`, the distance from it is minimised. Coordinates that are not `free` are kept. A
    polish that comes no nearer to its target or its limits is given up: there may be no such gait.
    """
    from scipy.optimize import minimize

    if free is None:
        free = np.ones(point.size, dtype=bool)
    local = _Local(evaluator, task, point, free, nearest)
    constraints = [_constraint(local, "ineq", "slack")]
    if local.equality:
        constraints.append(_constraint(local, "eq", "miss"))
    problem: dict[str, Any] = {
        "fun": partial(local.value, "objective"),
        "jac": partial(local.slope, "objective"),
        "bounds": list(zip(local.low, local.high, strict=True)),
        "constraints": constraints,
        "method": "SLSQP",
        "options": {"maxiter": iterations, "ftol": 1e-9},
    }
    with suppress(_Stalled):
        minimize(x0=point[free], **problem)


def _constraint(local: _Local, kind: str, name: str) -> dict[str, Any]:
    return {"type": kind, "fun": partial(local.value, name), "jac": partial(local.slope, name)}


class _Stalled(Exception):
    """Nothing valid is near."""


class _Local:
    """Objective, limits and misses about a point, with their gradients."""

    def __init__(
        self,
        evaluator: Evaluator,
        task: Task,
        point: Array,
        free: NDArray[np.bool_],
        nearest: bool,
    ) -> None:
        self.evaluator, self.task, self.nearest = evaluator, task, nearest
        self.point, self.free = point, free
        self.low, self.high = (end[free] for end in evaluator.space.box())
        self.last: Array | None = None
        self.tight = task._replace(tolerance=TIGHT)
        self.best, self.idle = np.inf, 0
        self.by = evaluator.engine.around()
        table = evaluator(point[None], self.by)
        self.equality = task.goal.misses(table) is not None and not nearest
        self.scale = max(abs(float(task.goal.objective(table)[0])), 1e-9)

    def value(self, name: str, x: Array) -> Array:
        """One of the values at x."""
        return self._at(x)[0][name]

    def slope(self, name: str, x: Array) -> Array:
        """Gradient of one of the values at x."""
        return self._at(x)[1][name]

    def _at(self, x: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        # Always with gradients: lanes side by side take hardly longer than one.
        if self.last is None or not np.array_equal(self.last, x):
            n = x.size
            ahead = np.minimum(x + _STEP, self.high) - x
            behind = x - np.maximum(x - _STEP, self.low)
            points = np.tile(self.point, (2 * n + 1, 1))
            points[:, self.free] = np.vstack((x, x + np.diag(ahead), x - np.diag(behind)))
            table = self.evaluator(points, self.by)
            self._watch(table)
            found = self._values(table)
            slopes = {k: (v[1 : n + 1] - v[n + 1 :]).T / (ahead + behind) for k, v in found.items()}
            self.last = x.copy()
            self.found = {key: v[0] for key, v in found.items()}, slopes
        return self.found

    def _watch(self, table: Table) -> None:
        """Count the points in a row that are not valid, nor nearer to what is."""
        distance = float(self.tight.distances(table)[0])
        nearer = distance < (1 - _NEARER) * self.best
        self.best = min(self.best, distance)
        self.idle = 0 if nearer or distance == 0 else self.idle + 1
        if self.idle == _LONGEST_STALL:
            raise _Stalled

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
