"""The Pareto front of speed against motor torque: for each speed, the least that it takes.

The box of gaits is sampled once; then, from the fastest gait down and up again, the torque is
minimised at each speed (epsilon constraints) from the neighbour's gait and from the best samples.
All that is simulated competes for every point, so the front cannot be dominated by it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, whole
from rrrobot.drive.gaits import FourierGait, SinusoidalGait
from rrrobot.errors import GaitError, ParameterError
from rrrobot.inline import html_table
from rrrobot.models.base import Model
from rrrobot.progress import Progress, progress_of
from rrrobot.results import names
from rrrobot.robot.chains import ties_of
from rrrobot.studies.optimisation.goals import FastestTravel, LeastRate
from rrrobot.studies.optimisation.result import confirm
from rrrobot.studies.optimisation.run import legs_of, prepare
from rrrobot.studies.optimisation.saved import read_result, reading, write_result
from rrrobot.studies.optimisation.search import polish, search
from rrrobot.studies.optimisation.space import Space, swing_of
from rrrobot.studies.optimisation.table import GaitLimits, discrepancy
from rrrobot.studies.optimisation.task import (
    Evaluator,
    Spent,
    Task,
    best_point,
    best_points,
)

_FOR_FASTEST = 0.4
"""Part of the budget that finds the fastest gait, and samples the box on the way."""
_ITERATIONS = 40


@dataclass(frozen=True, kw_only=True, eq=False)
class ParetoFront:
    """Gaits of which none is both faster and cheaper than another, the slowest first.

    Attributes:
        speed: (n,) [m/s].
        cost: rms motor torque [N m], or mean of the sum of |torque x rate| [W] (n,).
        cost_name: "torque" or "power".
        gaits: n gaits.
        columns: every result by name (`rrrobot.results`), each (n,).
        tried: (speed, cost) of every valid gait of the search (m, 2).
        discrepancy: largest relative difference to the KKT model, of three gaits of the front.
        limits: what all of them respect.
        evaluations: gaits that were tried.
        cycles: of legs that were simulated for them.
        search: bounds, seed, budget and settle time.
        model: whose gaits they are.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> front = rr.pareto_front(model, n_points=3, budget=400, settle_time=8.0, tied=True)
        >>> bool(all(front.cost[1:] > front.cost[:-1]))
        True
    """

    speed: Array
    cost: Array
    cost_name: str
    gaits: tuple[SinusoidalGait | FourierGait, ...]
    columns: Mapping[str, Array]
    tried: Array = field(repr=False)
    discrepancy: float
    limits: GaitLimits
    evaluations: int
    cycles: float
    search: Mapping[str, Any] = field(repr=False)
    model: Model = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the gaits that lost as plain data."""
        return {
            "cost": self.cost_name,
            "unit": LeastRate(rate=self.cost_name).unit,
            "points": [
                {"gait": gait.to_dict()}
                | {
                    name: float(column[i]) if np.isfinite(column[i]) else None
                    for name, column in self.columns.items()
                }
                for i, gait in enumerate(self.gaits)
            ],
            "discrepancy": self.discrepancy,
            "limits": self.limits.to_dict(),
            "evaluations": self.evaluations,
            "cycles": self.cycles,
            "search": dict(self.search),
            "model": self.model.to_dict(),
            "robot": self.model.robot.to_dict(),
        }

    def save(self, path: str | Path) -> Path:
        """Write the front, without the gaits that lost, to a .json file.

        Raises:
            OutputError: the file cannot be written, or its name does not end in .json.
        """
        return write_result(path, self.to_dict())

    @classmethod
    def load(cls, path: str | Path) -> ParetoFront:
        """Read what `save`, or `rrrobot optimise --out`, wrote; `tried` is then empty.

        Raises:
            OutputError: the file is missing, damaged, or of something else.
        """
        with reading(path):
            data = read_result(path)
            rows = data["points"]
            found = {
                name: np.array([np.nan if row[name] is None else row[name] for row in rows])
                for name in rows[0]
                if name != "gait"
            }
            cost = LeastRate(rate=data["cost"])
            return cls(
                speed=found["speed"], cost=found[cost.column], cost_name=data["cost"],
                gaits=tuple(data["gaits"]), columns=found, tried=np.zeros((0, 2)),
                discrepancy=data["discrepancy"], limits=data["limits"],
                evaluations=data["evaluations"], cycles=data["cycles"], search=data["search"],
                model=data["model"],
            )  # fmt: skip

    def __len__(self) -> int:
        return len(self.gaits)

    def _repr_html_(self) -> str:
        unit = LeastRate(rate=self.cost_name).unit
        head = ("speed [mm/s]", f"{self.cost_name} [m{unit}]", "gait")
        rows = [
            (f"{1000 * speed:.3f}", f"{1000 * cost:.4g}", gait)
            for speed, cost, gait in zip(self.speed, self.cost, self.gaits, strict=True)
        ]
        return html_table(f"Pareto front of {len(self)} gaits", rows, head=head)

    def __repr__(self) -> str:
        unit = LeastRate(rate=self.cost_name).unit
        return (
            f"ParetoFront({len(self)} gaits, speed {self.speed[0]:.4g} .. {self.speed[-1]:.4g} "
            f"m/s, {self.cost_name} {self.cost[0]:.4g} .. {self.cost[-1]:.4g} {unit})"
        )


def pareto_front(
    model: Model,
    *,
    cost: str = "torque",
    n_points: int = 16,
    offset: ArrayLike | None = None,
    amplitude: ArrayLike | None = None,
    angular_frequency: ArrayLike = (2.0, 14.0),
    phase_difference: ArrayLike = (0.0, 2 * np.pi),
    harmonics: int = 1,
    tied: bool = False,
    winding: ArrayLike = 0,
    limits: GaitLimits | None = None,
    settle: str = "cycles",
    settle_time: float | None = None,
    budget: int | None = None,
    seed: int = 0,
    progress: Progress = False,
) -> ParetoFront:
    """Speed against motor torque: for speeds up to the fastest, the gait that takes the least.

    Args:
        model: `FullModel` or `PivotingModel`.
        cost: "torque", the rms over a cycle of all motors; or "power", the mean sum of
            |torque x rate|.
        n_points: equal steps of speed from zero, at least 2; the front has as many gaits unless one
            is the best for several.
        budget: gaits that may be simulated; 30 000 for each harmonic unless given.
        offset, amplitude, angular_frequency, phase_difference, harmonics, tied, winding, limits,
            settle, settle_time, seed, progress: as for `optimise`.

    Raises:
        ParameterError, ModelError: as `optimise` raises.
        GaitError: no gait within the bounds is within the limits.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> front = rr.pareto_front(
        ...     model, n_points=3, budget=400, settle_time=8.0, angular_frequency=8.0
        ... )
        >>> front.gaits[-1].n_legs
        2
    """
    limits = GaitLimits() if limits is None else limits
    budget = 30_000 * harmonics if budget is None else budget
    LeastRate(rate=cost)
    whole("n_points", n_points, at_least=2)
    legs = legs_of(model)
    ties = ties_of(model.robot) if tied else None
    space = Space(
        legs, **swing_of(model.robot.joints, offset, amplitude, ties),
        angular_frequency=angular_frequency, phase_difference=phase_difference,
        harmonics=harmonics, ties=ties, winding=winding,
    )  # fmt: skip
    if space.n == 0:
        raise ParameterError("every bound is one number: a front needs something to vary.")
    evaluator = prepare(model, space, limits, settle_time, budget, seed, settle)
    with progress_of(progress, "gaits", int(budget), "gaits") as evaluator.tell:
        fastest = Task.of(model, FastestTravel(), limits)
        tasks = _searched(evaluator, fastest, cost, n_points, seed)
    settings = {"settle": settle, "settle_time": evaluator.engine.settle_time,
                "budget": int(budget), "seed": int(seed)}  # fmt: skip
    return _front(model, evaluator, tasks, cost, settings)


def _searched(
    evaluator: Evaluator, fastest: Task, cost: str, n_points: int, seed: int
) -> list[Task]:
    """Find the fastest gait, then the least cost at each speed; the tasks of the front's points."""
    evaluator.allowed = int(_FOR_FASTEST * evaluator.budget)
    search(evaluator, fastest, np.random.default_rng(seed))
    evaluator.allowed = evaluator.budget
    _, table = evaluator.archive()
    scores = fastest.scores(table)
    if not fastest.valid(scores).any():
        raise GaitError(
            "no gait within the bounds is within the limits, so there is no front. `optimise` "
            "says which limits the nearest one breaks."
        )
    speeds = -scores.min() * np.arange(1, n_points + 1) / n_points * (1 - 1e-3)
    tasks = [fastest._replace(goal=LeastRate(rate=cost, min_speed=float(v))) for v in speeds]
    _descend(evaluator, tasks)
    return tasks


def _descend(evaluator: Evaluator, tasks: list[Task]) -> None:
    """Polish the front's points, from the fastest down and up again, while there is budget."""
    try:
        for task in reversed(tasks):
            points, table = evaluator.archive()
            for start in best_points(points, task.scores(table), 2):
                polish(evaluator, task, start, iterations=_ITERATIONS)
        for slower, task in pairwise(tasks):
            polish(evaluator, task, best_point(evaluator, slower), iterations=_ITERATIONS)
        for task in reversed(tasks):
            polish(evaluator, task, best_point(evaluator, task), iterations=_ITERATIONS)
    except Spent:
        pass


def _front(
    model: Model, evaluator: Evaluator, tasks: list[Task], cost: str, settings: dict[str, Any]
) -> ParetoFront:
    points, table = evaluator.archive()
    scores = [task.scores(table) for task in tasks]
    # Mirrored gaits cost the same to the last bit; the faster of them is not dominated.
    best = np.unique([np.lexsort((-table.speed, s))[0] for s in scores])
    goal, limits = tasks[0].goal, tasks[0].limits
    # The fastest gait that costs as much comes last of equals, and is the one to keep.
    best = best[np.lexsort((table.speed[best], goal.value(table)[best]))]
    best = best[np.append(np.diff(goal.value(table)[best]) > 0, True)]
    found = table.rows(best)
    gaits = tuple(evaluator.space.gait(points[i]) for i in best)
    any_speed = tasks[0]._replace(goal=FastestTravel())
    valid = np.flatnonzero(any_speed.valid(any_speed.scores(table)))
    return ParetoFront(
        speed=found.speed,
        cost=goal.value(found),
        cost_name=cost,
        gaits=gaits,
        columns={name: getattr(found, name) for name in names()},
        tried=np.column_stack((table.speed, goal.value(table)))[valid],
        discrepancy=max(
            discrepancy(
                found.rows(slice(i, i + 1)), confirm(model, gaits[i], settings["settle_time"])[2]
            )
            for i in sorted({0, len(gaits) // 2, len(gaits) - 1})
        ),
        limits=limits,
        evaluations=evaluator.used,
        cycles=evaluator.cycles,
        search=evaluator.space.to_dict() | settings,
        model=model,
    )
