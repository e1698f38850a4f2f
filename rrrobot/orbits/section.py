"""Coordinates of the state that must come back: tilt and momentum, without heading and place.

On level ground the equations do not change if the robot is turned about the vertical or put
elsewhere. What is left of a state at the start of a period are the vertical in the body's axes and
the momentum K there. The chart

    (roll, pitch)' = 2 (z_y, -z_x) / (1 + z_z),        K / (I omega)

is smooth but for a robot upside down; near upright its first two are roll and pitch [rad]. I is the
mean moment of inertia about the pivot and omega the legs' frequency, so that all are of order one
where the legs move much ("scaled units").

Where nothing brakes the yaw of a pivoted body, its momentum about the vertical stays what it was:
zero after an impulsive start. The chart then holds it at zero.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import ModelError
from rrrobot.momentum.kernels import ANY, DECOUPLED, N_STATE
from rrrobot.momentum.lowering import Setting
from rrrobot.momentum.returns import Cycles
from rrrobot.momentum.terrain import FLAT, LEVEL

_K = 4
"""Where the momentum stands in a state of the engine."""


class Section(NamedTuple):
    """A chart of what must come back."""

    angles: tuple[int, ...]
    """entries of (roll, pitch)' that are free"""
    momenta: tuple[int, ...]
    """entries of K that are free"""
    tilted: bool
    """whether the engine's state is a quaternion; else it is the angles themselves"""
    level: bool
    """whether the momentum about the vertical is held at zero"""

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.angles) + len(self.momenta)

    def point(self, y: Array, scale: Array) -> Array:
        """Coordinates (n, size) of engine states (n, N_STATE); scale: of K (n,)."""
        if self.tilted:
            x, y_, z, w = y[:, :4].T
            over = 2.0 / (z * z + w * w)
            tilt = np.column_stack((over * (y_ * z + w * x), over * (w * y_ - x * z)))
        else:
            tilt = y[:, :2]
        momenta = y[:, [_K + a for a in self.momenta]] / scale[:, None]
        return np.column_stack((tilt[:, list(self.angles)], momenta))

    def state(self, point: Array, scale: Array) -> Array:
        """Engine states (n, N_STATE) of coordinates, at the origin and with yaw zero."""
        n, k = len(point), len(self.angles)
        tilt = np.zeros((n, 2))
        tilt[:, list(self.angles)] = point[:, :k]
        y = np.zeros((n, N_STATE))
        y[:, [_K + a for a in self.momenta]] = point[:, k:] * scale[:, None]
        if not self.tilted:
            y[:, :2] = tilt
            return y
        a, b = 0.5 * tilt.T
        # (a, b, 0, 1) has the tilt; a turn about the vertical takes its yaw away.
        half = -0.5 * np.arctan2(2 * a * b, 1 + a * a - b * b)
        s, c = np.sin(half), np.cos(half)
        y[:, :4] = np.column_stack((c * a - s * b, c * b + s * a, s, c))
        if self.level:
            # K . z = 0, with z in the ratio (-2b, 2a, 1 - a^2 - b^2).
            y[:, _K + 2] = (2 * b * y[:, _K] - 2 * a * y[:, _K + 1]) / (1 - a * a - b * b)
        return y


def section_of(setting: Setting, name: str) -> Section:
    """The chart of a model in the engine's terms.

    Raises:
        ModelError: nothing brakes what rolls or rocks: such a motion never settles; or the ground
            is not level.
    """
    axis, terrain = setting.axis, setting.terrain
    if terrain is not None and (terrain.ground != LEVEL or terrain.shell == FLAT):
        raise ModelError(
            f"the {name} model is not on level ground: there heading and place change the motion, "
            "so no cycle repeats up to a displacement. Give level ground, or simulate."
        )
    losses = setting.parameters[4:7]
    rocking = {0: losses[:1], 1: losses[1:2], 2: np.ones(1), DECOUPLED: losses[:2]}
    free = rocking.get(axis, losses)
    if not np.any(free) or (axis in (0, 1, DECOUPLED) and not np.all(free)):
        raise ModelError(
            f"the {name} model has no damping where it rocks: its motions never settle, and next "
            "to each orbit lie others, so there is no limit cycle. Give damping=, such as 0.01."
        )
    # A generalised force on the yaw's rate, or none, takes nothing from the vertical momentum.
    unbraked = losses[2] == 0.0 and (setting.parameters[7] == 1.0 or axis >= 0)
    if axis == DECOUPLED:
        return Section((0, 1), (0, 1) if unbraked else (0, 1, 2), False, False)
    if axis == 2:
        return Section((), () if unbraked else (2,), True, False)
    if axis >= 0:
        return Section((axis,), (axis,), True, False)
    pivoted = setting.parameters[1] == 0.0
    level = pivoted and unbraked
    return Section((0, 1), (0, 1) if level else (0, 1, 2), True, level)


def momentum_scale(cycles: Cycles) -> Array:
    """I omega of each gait (n,) [N m s]."""
    mass, radius = cycles.setting.parameters[:2]
    if cycles.setting.axis == ANY:
        radius = 0.0
    inertia = cycles.inertia() + mass * radius**2
    return np.asarray(inertia * 2 * np.pi / cycles.period)
