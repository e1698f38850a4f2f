"""What rolling costs where nobody measured it: a viscous loss of the rocking, by a damping ratio.

A body's rate about its x and y axes is opposed by kappa_x, kappa_y, and about z by the smaller of
the two, so that roll and pitch about the rest in a posture have the damping ratio zeta:

    decay rate = zeta |eigenvalue|,     to first order decay rate ~ kappa

A robot without any loss never settles, and nothing of its start is ever forgotten.
"""

from __future__ import annotations

import numpy as np

from rrrobot.checks import Array, finite
from rrrobot.drive.damping import BodyRateDamping
from rrrobot.errors import ModelError
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.orbits.oscillations import Mode, modes

RATIO = 0.1
"""Damping ratio unless told: RRRobot's in the paper are 0.10 and 0.12."""

_LIGHT = 0.2
"""Decay rate over the frequency below which the one goes with the loss."""
_SLOW = 1e-3
"""Frequency over the fastest one below which a mode is drift, split by rounding."""


def rocking_modes(model: Model, posture: Array) -> list[Mode]:
    """Modes in which the robot rocks about its rest, slow ones first; none where it tips over."""
    try:
        found = modes(model, posture)
    except ModelError:
        return []
    fastest = max(abs(mode.eigenvalue) for mode in found)
    if any(mode.decay_rate < -_SLOW * fastest for mode in found):
        return []
    return [mode for mode in found if abs(mode.eigenvalue.imag) > _SLOW * fastest]


def rocking_damping(model: FullModel, posture: Array, ratio: float = RATIO) -> BodyRateDamping:
    """Damping about the body's axes that gives both rocking modes this ratio.

    Args:
        model: without damping of its own.
        posture: legs (legs,) [rad].
        ratio: zeta, 0 .. 0.5.

    Raises:
        ParameterError: a ratio out of range.
        ModelError: the robot does not rock in two modes about a stable rest.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> from rrrobot.escape.loss import rocking_damping
        >>> up = np.full(2, np.pi / 2)
        >>> model = rr.FullModel(rr.Robot.from_parameters(), damping=None)
        >>> lossy = rr.FullModel(model.robot, damping=rocking_damping(model, up, 0.1))
        >>> [round(m.decay_rate / abs(m.eigenvalue), 2) for m in rr.modes(lossy, up)[:2]]
        [0.1, 0.1]
    """
    finite("ratio", ratio, above=0)
    if ratio > 0.5:
        raise ModelError(f"the damping ratio is {ratio:g}: rocking needs one of at most 0.5.")
    free = FullModel(model.robot, ground=model.ground, damping=None)
    rocking = rocking_modes(free, posture)
    if len(rocking) != 2:
        raise ModelError(
            f"the robot rocks in {len(rocking)} modes about the rest in this posture, not in roll "
            "and pitch: it tips over, or does not rest. Give damping= yourself, or swing the legs "
            "to where the centre of mass is lower."
        )
    frequency = np.array([abs(mode.eigenvalue) for mode in rocking])
    share = np.column_stack([_share(model, posture, axis, frequency.min()) for axis in range(2)])
    both = np.linalg.solve(share, ratio * frequency)
    if not (both > 0).all():
        # Modes that mix the axes: one loss for both.
        both = np.full(2, float(ratio * frequency.mean() / share.sum(axis=1).mean()))
    return BodyRateDamping(float(both[0]), float(both[1]), float(both.min()))


def _share(model: FullModel, posture: Array, axis: int, slowest: float) -> Array:
    """Decay rate of each rocking mode (2,) over a small loss about one axis alone [1/(N m s)]."""
    small = 1e-3 * model.robot.mass * slowest
    while True:
        kappa = [0.0, 0.0, 0.0]
        kappa[axis] = small
        lossy = FullModel(model.robot, ground=model.ground, damping=BodyRateDamping(*kappa))
        decay = np.array([mode.decay_rate for mode in rocking_modes(lossy, posture)])
        if decay.size == 2 and decay.max() < _LIGHT * slowest:
            return decay / small
        # Moments of inertia go with the square of a robot's size: of a small one it is much.
        small *= 0.1
