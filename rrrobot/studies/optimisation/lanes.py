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
from rrrobot.models.base import Model
from rrrobot.momentum.batch import RESULT, FourierGaits, Setting, lower, settled
from rrrobot.momentum.extremes import LOADS, extremes
from rrrobot.momentum.kernels import LIFT_OFF, OK
from rrrobot.momentum.lowering import VERTICAL
from rrrobot.momentum.tree import Tree
from rrrobot.studies.optimisation.space import Population
from rrrobot.studies.optimisation.table import COLUMNS

COUNTED = 4
"""Cycles that are averaged."""
_STEPS = np.sort(np.outer((16, 24), 2 ** np.arange(9)).ravel())
"""Steps of a cycle: enough for the harmonics, and for none to be longer than this [s]:"""
_LONGEST_STEP = 0.09
N_COLUMNS = len(COLUMNS)


@dataclass(frozen=True)
class Engine:
    """A model, ready for populations."""

    setting: Setting
    settle_time: float

    @property
    def tree(self) -> Tree:
        """The robot's bodies."""
        return self.setting.tree

    def __call__(self, gaits: Population) -> Array:
        """What each gait gives (n, N_COLUMNS); NaN, with a status, of those that stopped."""
        period = 2 * np.pi / gaits.angular_frequency
        wanted = np.maximum(period / _LONGEST_STEP, 8 + 8 * gaits.sine.shape[1])
        steps = _STEPS[np.minimum(np.searchsorted(_STEPS, wanted), _STEPS.size - 1)]
        cycles = np.ceil(self.settle_time / period - 1e-9).astype(np.int64) + COUNTED
        out = np.empty((len(period), N_COLUMNS))
        for count in np.unique(steps):
            # Side by side, gaits of like length keep each other waiting least.
            here = np.flatnonzero(steps == count)
            here = here[np.argsort(cycles[here], kind="stable")]
            some = FourierGaits(*(part[here] for part in gaits))
            out[here] = self._columns(some, cycles[here], int(count))
        return out

    def _columns(self, gaits: FourierGaits, cycles: NDArray[np.int64], steps: int) -> Array:
        found = settled(
            self.setting, gaits, cycles=cycles, counted=COUNTED, steps=steps, motion=True
        )
        values = dict(zip(RESULT, found.results.T, strict=True))
        values |= zip(LOADS, extremes(self.setting, gaits, found.motion).T, strict=True)
        values["pitch"] = found.pitch
        if self.setting.parameters[1] == 0.0:
            # A pivot holds without friction.
            values["friction"] = np.zeros(len(cycles))
        # How much a gait lifts off is for the limits to say.
        status = np.where(values["status"] == LIFT_OFF, OK, values["status"])
        table = np.column_stack([values[name] for name in COLUMNS])
        stopped = [name not in ("pitch", "status") for name in COLUMNS]
        table[np.ix_(status != OK, stopped)] = np.nan
        table[:, list(COLUMNS).index("status")] = status
        return table


def engine_of(model: Model, settle_time: float) -> Engine:
    """The engine for a model.

    Raises:
        ModelError: the momentum engine cannot run it.
    """
    return Engine(lower(model)._replace(limit=VERTICAL), settle_time)
