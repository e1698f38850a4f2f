"""Populations of gaits through the momentum engine: motion, forces and torques of each.

`Cycles` simulates a gait from an upright impulsive start until `settle_time` has passed, then
averages `COUNTED` cycles; torques and forces are those of the last one. `Orbits` finds the limit
cycle of each gait instead, and has its largest Floquet multiplier. What a gait gives does not
depend on the others beside it.

About a point of a local search the orbits are neighbours: `Around` finds the first from the one
before it, and the others, where gradients are taken, from the first with its dP/dx, which is a step
of the implicit function theorem that is then closed to the last digits.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.drive.gaits import GaitBatch
from rrrobot.errors import ParameterError
from rrrobot.models.base import Model
from rrrobot.momentum.batch import RESULT, Setting, lower, settled
from rrrobot.momentum.extremes import LOADS, extremes
from rrrobot.momentum.kernels import LIFT_OFF, OK
from rrrobot.momentum.lowering import VERTICAL
from rrrobot.orbits import many
from rrrobot.orbits.section import level_section_of
from rrrobot.results import completed
from rrrobot.studies.optimisation.table import Joints, Table, columns

COUNTED = 4
"""Cycles that are averaged."""
_STEPS = np.sort(np.outer((16, 24), 2 ** np.arange(9)).ravel())
"""Steps of a cycle: enough for the harmonics, and for none to be longer than this [s]:"""
_LONGEST_STEP = 0.09


SETTLES = ("cycles", "orbit")
"""Ways to what a gait settles to."""


@dataclass(frozen=True)
class Engine(ABC):
    """A model, ready for populations."""

    setting: Setting
    settle_time: float

    def __call__(self, gaits: GaitBatch) -> Table:
        """What each gait gives; NaN, with a status, of those that stopped."""
        tables, order = [], []
        steps = self.steps(gaits)
        for count in np.unique(steps):
            here = self._ordered(gaits, np.flatnonzero(steps == count))
            tables.append(self._of(gaits.rows(here), int(count)))
            order.append(here)
        return Table.joined(tables).rows(np.argsort(np.concatenate(order), kind="stable"))

    def around(self) -> Callable[[GaitBatch], Table]:
        """The engine for a local search: the first gait is its point, the others are near it."""
        return self

    def check(self) -> Engine | None:
        """What tells whether an upright start comes to what this engine finds; None: it does."""
        return None

    @staticmethod
    def steps(gaits: GaitBatch) -> NDArray[np.int64]:
        """Steps of a cycle of each gait (n,)."""
        wanted = np.maximum(
            2 * np.pi / gaits.angular_frequency / _LONGEST_STEP, 8 + 8 * gaits.order
        )
        return _STEPS[np.minimum(np.searchsorted(_STEPS, wanted), _STEPS.size - 1)]

    def _ordered(self, gaits: GaitBatch, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        return rows

    @abstractmethod
    def _of(self, gaits: GaitBatch, steps: int) -> Table:
        """Results of gaits by so many steps of a cycle."""

    def _table(
        self,
        gaits: GaitBatch,
        results: Array,
        motion: Array,
        cycles: Array,
        multiplier: Array | None = None,
    ) -> Table:
        values = dict(zip(RESULT, results.T, strict=True))
        torque = np.empty(gaits.offset.shape)
        values |= zip(LOADS, extremes(self.setting, gaits, motion, torque).T, strict=True)
        # How much a gait lifts off is for the limits to say.
        status = np.where(values["status"] == LIFT_OFF, OK, values["status"])
        table = np.column_stack([*completed(values | {"status": status}).values()])
        stopped = [name not in ("pitch", "status") for name in columns()]
        table[np.ix_((status != OK) & (status != many.UNSTABLE), stopped)] = np.nan
        return Table(table, Joints.of(gaits, torque), multiplier=multiplier, cycles=cycles)


class Cycles(Engine):
    """What the upright impulsive start comes to in the time to settle."""

    def _counts(self, gaits: GaitBatch) -> NDArray[np.int64]:
        periods = self.settle_time / (2 * np.pi / gaits.angular_frequency)
        return np.ceil(periods - 1e-9).astype(np.int64) + COUNTED

    def _ordered(self, gaits: GaitBatch, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        # Side by side, gaits of like length keep each other waiting least.
        return rows[np.argsort(self._counts(gaits)[rows], kind="stable")]

    def _of(self, gaits: GaitBatch, steps: int) -> Table:
        counts = self._counts(gaits)
        found = settled(self.setting, gaits, cycles=counts, counted=COUNTED, steps=steps)
        return self._table(gaits, found.results, found.motion, counts.astype(float))


class Orbits(Engine):
    """Limit cycles of the legs' period."""

    def _of(self, gaits: GaitBatch, steps: int) -> Table:
        return self.told(gaits, many.orbits_of(self.setting, gaits, steps, stability="known"))

    def told(self, gaits: GaitBatch, found: many.Orbits) -> Table:
        """Orbits as a table: `pitch` is the largest of the cycle, `variation` the residual."""
        return self._table(gaits, found.results, found.motion, found.periods, found.multiplier)

    def around(self) -> Callable[[GaitBatch], Table]:
        return Around(self)

    def check(self) -> Engine | None:
        return Cycles(self.setting, self.settle_time)


class Around:
    """Orbits about points that a local search goes through one after the other."""

    def __init__(self, engine: Orbits) -> None:
        self.engine = engine
        self.last: many.Orbits | None = None

    def __call__(self, gaits: GaitBatch) -> Table:
        """The first gait from the one of the call before, the others from the first."""
        engine, steps = self.engine, int(self.engine.steps(gaits).max())
        point, others = gaits.rows(slice(0, 1)), gaits.rows(slice(1, None))
        first = many.orbits_of(engine.setting, point, steps, near=self.last)
        self.last = first
        tables = [engine.told(point, first)]
        if others.n:
            found = many.orbits_of(engine.setting, others, steps, near=first, stability="known")
            tables.append(engine.told(others, found))
        return Table.joined(tables)


def engine_of(model: Model, settle_time: float, settle: str = "cycles") -> Engine:
    """The engine for a model.

    Raises:
        ModelError: the momentum engine cannot run it, or, by orbits, nothing brakes it or its
            ground is not level.
        ParameterError: no such way to settle.
    """
    if settle not in SETTLES:
        raise ParameterError(f"settle is {settle!r}: it must be 'cycles' or 'orbit'.")
    setting = lower(model)._replace(limit=VERTICAL)
    if settle == "orbit":
        level_section_of(setting, model.name)
        return Orbits(setting, settle_time)
    return Cycles(setting, settle_time)
