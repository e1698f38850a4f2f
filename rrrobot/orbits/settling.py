"""How long a gait takes to settle: by the slowest decay of small motions about rest."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import RRRobotError
from rrrobot.models.base import Model
from rrrobot.models.recombined import DecoupledModels
from rrrobot.orbits.oscillations import modes

_ALIVE = 1e-6
"""Decay rate up to which a mode counts as one that goes on for ever, over its eigenvalue."""


def settling_time(model: Model | DecoupledModels, postures: Iterable[Array], to: float) -> float:
    """Time in which the slowest mode decays to a share of what it was [s].

    With the legs held, a mode of the eigenvalue -s +- i w is down to the share q of its start after
    ln(1/q) / s. A gait of a small swing settles like that; of a large one it is the scale.

    Args:
        model: any.
        postures: leg angles (legs,) [rad], about which the legs swing.
        to: that share, in (0, 1).

    Returns:
        the longest over the postures; of those without a rest near the upright pose, and of those
        where nothing brakes a mode or one grows, none is known and none is counted. 0 if none is.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> from rrrobot.orbits.settling import settling_time
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> round(settling_time(model, [np.full(2, np.pi / 2)], to=0.001), 2)
        14.11
    """
    parts = model.models if isinstance(model, DecoupledModels) else (model,)
    longest = 0.0
    for posture in postures:
        rates = [rate for part in parts for rate in _decays(part, posture)]
        if rates and min(rates) > 0.0:
            longest = max(longest, math.log(1.0 / to) / min(rates))
    return longest


def _decays(model: Model, posture: Array) -> list[float]:
    """Decay rates about rest, without what drifts; 0 for what decays not at all [1/s]."""
    try:
        found = modes(model, posture)
    except RRRobotError:
        return []
    values = [mode.eigenvalue for mode in found if mode.eigenvalue != 0]
    return [max(-v.real, 0.0) if -v.real > _ALIVE * abs(v) else 0.0 for v in values]


def between(low: Array, high: Array) -> list[Array]:
    """Postures that stand for a range of them (legs,): both ends and the middle."""
    shares = (0.0, 0.5, 1.0) if np.any(high > low) else (0.0,)
    return [low + share * (high - low) for share in shares]
