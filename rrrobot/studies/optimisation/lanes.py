"""Populations of gaits through the momentum engine: motion, forces and torques of each.

A gait is simulated from an upright impulsive start until `settle_time` has passed, then `COUNTED`
cycles are averaged, and torques and forces are those of the last one. What a gait gives does not
depend on the others beside it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.drive.gaits import GaitBatch
from rrrobot.models.base import Model
from rrrobot.momentum.batch import RESULT, Setting, lower, settled
from rrrobot.momentum.extremes import LOADS, extremes
from rrrobot.momentum.kernels import LIFT_OFF, OK
from rrrobot.momentum.lowering import VERTICAL
from rrrobot.momentum.tree import Tree
from rrrobot.results import completed
from rrrobot.studies.optimisation.table import columns

COUNTED = 4
"""Cycles that are averaged."""
_STEPS = np.sort(np.outer((16, 24), 2 ** np.arange(9)).ravel())
"""Steps of a cycle: enough for the harmonics, and for none to be longer than this [s]:"""
_LONGEST_STEP = 0.09


@dataclass(frozen=True)
class Engine:
    """A model, ready for populations."""

    setting: Setting
    settle_time: float

    @property
    def tree(self) -> Tree:
        """The robot's bodies."""
        return self.setting.tree

    def __call__(self, gaits: GaitBatch) -> Array:
        """What each gait gives (n, columns), as `Table` has it; NaN, with a status, of those that
        stopped."""
        period = 2 * np.pi / gaits.angular_frequency
        wanted = np.maximum(period / _LONGEST_STEP, 8 + 8 * gaits.order)
        steps = _STEPS[np.minimum(np.searchsorted(_STEPS, wanted), _STEPS.size - 1)]
        cycles = np.ceil(self.settle_time / period - 1e-9).astype(np.int64) + COUNTED
        out = np.empty((len(period), len(columns())))
        for count in np.unique(steps):
            # Side by side, gaits of like length keep each other waiting least.
            here = np.flatnonzero(steps == count)
            here = here[np.argsort(cycles[here], kind="stable")]
            out[here] = self._columns(gaits.rows(here), cycles[here], int(count))
        return out

    def _columns(self, gaits: GaitBatch, cycles: NDArray[np.int64], steps: int) -> Array:
        found = settled(self.setting, gaits, cycles=cycles, counted=COUNTED, steps=steps)
        values = dict(zip(RESULT, found.results.T, strict=True))
        values |= zip(LOADS, extremes(self.setting, gaits, found.motion).T, strict=True)
        # How much a gait lifts off is for the limits to say.
        status = np.where(values["status"] == LIFT_OFF, OK, values["status"])
        table = np.column_stack([*completed(values | {"status": status}).values()])
        stopped = [name not in ("pitch", "status") for name in columns()]
        table[np.ix_(status != OK, stopped)] = np.nan
        return table


def engine_of(model: Model, settle_time: float) -> Engine:
    """The engine for a model.

    Raises:
        ModelError: the momentum engine cannot run it.
    """
    return Engine(lower(model)._replace(limit=VERTICAL), settle_time)
