"""How many cycles and steps each gait of a sweep is simulated for."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from rrrobot.checks import Array, whole
from rrrobot.models.base import Model
from rrrobot.models.recombined import DecoupledModels
from rrrobot.orbits.settling import between, settling_time

CYCLES = 38
"""The paper's 30 s at 8 rad/s."""
_MOST = 10_000
_LEFT = 0.001
"""Of the slowest mode, when the counted cycles begin."""


def run_settings(cycles: int | None, counted: int | None, steps: int) -> dict[str, int]:
    """The numbers of cycles and steps of a run, checked; 38 cycles of None."""
    cycles = CYCLES if cycles is None else cycles
    cycles = whole("cycles", cycles, at_least=2, at_most=100_000)
    steps = whole("steps_per_cycle", steps, at_least=4, at_most=1000)
    if counted is None:
        counted = max(2, cycles - math.ceil(cycles / 2) - 1)
    most = min(cycles, 200_000 // steps)
    counted = whole("counted", counted, at_least=2, at_most=most)
    return {"cycles": cycles, "counted": counted, "steps_per_cycle": steps}


def enough_cycles(
    models: Iterable[Model | DecoupledModels],
    offsets: Array,
    angular_frequency: float,
    counted: int,
) -> int:
    """Cycles after which the slowest decay of any of the models leaves little; 38 at least.

    Args:
        models: of the robots, those that stand for all.
        offsets: least and largest of each leg (2, legs) [rad].
        angular_frequency: the highest [rad/s].
        counted: cycles at the end that must be free of what they began with.
    """
    needed = max(settling_time(model, between(*offsets), _LEFT) for model in models)
    before = math.ceil(needed * angular_frequency / (2 * np.pi) - 1e-9)
    return max(CYCLES, min(before + counted, _MOST))
