"""Which settled motions keep within limits: a plan of these is likely to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits import GaitBatch
from rrrobot.models.base import Model
from rrrobot.steering.motions import Motions
from rrrobot.studies.optimisation.table import GaitLimits
from rrrobot.studies.sweeps.counts import enough_cycles

_SHARES = (0.95, 0.75, 0.5)
"""Of the limits, that the settled gaits may use: what gaits are blended asks for more."""
_COUNTED = 2


def within(
    model: Model, motions: Motions, limits: GaitLimits | None, max_power: float | None
) -> Iterator[Motions]:
    """Motions whose settled gaits use shares of the limits, from larger to smaller shares.

    Args:
        model: that the momentum engine knows.
        motions: of it.
        limits: those of torque, leg rate, friction, normal force and clearance.
        max_power: of all motors [W].
    """
    known = settled(model, motions)
    limits = GaitLimits() if limits is None else limits
    ends = limits.ends(model.robot)
    weight = model.robot.mass * model.robot.gravity
    above = known["normal_force"] / weight > limits.min_normal_force
    above &= known["clearance"] > limits.min_clearance
    for share in _SHARES:
        keep = above.copy()
        for value, most in (
            (known["peak_torque"], ends.effort.min()),
            (known["friction"], limits.friction),
            (motions.amplitude * motions.angular_frequency, ends.velocity.min()),
            (known["power"], max_power),
        ):
            if most is not None:
                keep &= value <= share * most
        if np.count_nonzero(keep) < 2 or np.abs(motions.twist[keep]).max() < 1e-6:
            return
        yield motions.take(keep)


def settled(model: Model, motions: Motions) -> dict[str, Array]:
    """Results and loads of settled gaits by name, each (n,); see `rrrobot.results`.

    Args:
        model: that the momentum engine knows.
        motions: of it.
    """
    from rrrobot.momentum.batch import LOADS, RESULT, lower, steady_states

    n, zero = motions.offset.size, np.zeros(motions.offset.size)
    gaits = GaitBatch.sinusoidal(
        np.column_stack((motions.offset,) * 2),
        np.column_stack((motions.amplitude,) * 2),
        np.column_stack((zero, motions.phase_difference)),
        np.full(n, motions.angular_frequency),
    )
    offsets = np.repeat([[motions.offset.min()], [motions.offset.max()]], 2, axis=1)
    cycles = enough_cycles([model], offsets, motions.angular_frequency, _COUNTED)
    found = steady_states(
        lower(model), gaits, cycles=cycles, counted=_COUNTED, steps_per_cycle=10, loads=True
    )
    return dict(zip((*RESULT, *LOADS), found.T, strict=True))
