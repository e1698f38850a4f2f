"""Coordinates of the state that must come back: all but what the ground's symmetry leaves open.

On level ground the equations do not change if the robot is turned about the vertical or put
elsewhere. What is left of a state at the start of a period are the vertical in the body's axes and
the momentum K there. The chart

    (roll, pitch)' = 2 (z_y, -z_x) / (1 + z_z),        K / (I omega)

is smooth but for a robot upside down; near upright its first two are roll and pitch [rad]. I is the
mean moment of inertia about the pivot and omega the legs' frequency, so that all are of order one
where the legs move much ("scaled units").

A slope is the same everywhere and not in every direction: there the heading must come back too, the
yaw [rad]. A boulder or a bowl is the same when turned about the vertical through its top or bottom:
there the contact must come back in the heading's axes, as the normal's horizontal part, n = k P,

    yaw,      or      k R_z(yaw)^T (x, y).

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
from rrrobot.momentum.terrain import BOULDER, FLAT, GRAPH, SLOPE

_K, _YAW = 4, 9
"""Where momentum and yaw stand in a state of the engine."""


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
    heads: bool = False
    """whether the heading must come back"""
    curvature: float = 0.0
    """k of the ground on which the place must come back [1/m]; 0: it is the same everywhere"""

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.angles) + len(self.momenta) + self.heads + 2 * (self.curvature != 0.0)

    def point(self, y: Array, scale: Array) -> Array:
        """Coordinates (n, size) of engine states (n, N_STATE); scale: of K (n,)."""
        if self.tilted:
            x, y_, z, w = y[:, :4].T
            over = 2.0 / (z * z + w * w)
            tilt = np.column_stack((over * (y_ * z + w * x), over * (w * y_ - x * z)))
        else:
            tilt = y[:, :2]
        momenta = y[:, [_K + a for a in self.momenta]] / scale[:, None]
        parts = [tilt[:, list(self.angles)], momenta]
        if self.heads:
            parts.append(_heading(y)[:, None])
        if self.curvature:
            yaw = _heading(y)
            c, s = self.curvature * np.cos(yaw), self.curvature * np.sin(yaw)
            parts.append(np.column_stack((c * y[:, 7] + s * y[:, 8], c * y[:, 8] - s * y[:, 7])))
        return np.column_stack(parts)

    def state(self, point: Array, scale: Array) -> Array:
        """Engine states (n, N_STATE) of coordinates, with yaw zero and at the origin if that is
        open."""
        n, k = len(point), len(self.angles)
        end = k + len(self.momenta)
        tilt = np.zeros((n, 2))
        tilt[:, list(self.angles)] = point[:, :k]
        y = np.zeros((n, N_STATE))
        y[:, [_K + a for a in self.momenta]] = point[:, k:end] * scale[:, None]
        if not self.tilted:
            y[:, :2] = tilt
            return y
        a, b = 0.5 * tilt.T
        # (a, b, 0, 1) has the tilt; a turn about the vertical takes its yaw away.
        half = -0.5 * np.arctan2(2 * a * b, 1 + a * a - b * b)
        if self.heads:
            y[:, _YAW] = point[:, end]
            half += 0.5 * point[:, end]
        if self.curvature:
            y[:, 7:9] = point[:, end:] / self.curvature
        s, c = np.sin(half), np.cos(half)
        y[:, :4] = np.column_stack((c * a - s * b, c * b + s * a, s, c))
        if self.level:
            # K . z = 0, with z in the ratio (-2b, 2a, 1 - a^2 - b^2).
            y[:, _K + 2] = (2 * b * y[:, _K] - 2 * a * y[:, _K + 1]) / (1 - a * a - b * b)
        return y

    def wrapped(self, point: Array) -> Array:
        """Coordinates with a heading in [-pi, pi]."""
        if not self.heads:
            return point
        point = point.copy()
        point[:, -1] -= 2 * np.pi * np.round(point[:, -1] / (2 * np.pi))
        return point


def _heading(y: Array) -> Array:
    """Yaw of states (n,), with the whole turns that they have made [rad]."""
    x, y_, z, w = y[:, :4].T
    yaw = np.arctan2(2 * (w * z + x * y_), w * w + x * x - y_ * y_ - z * z)
    return np.asarray(yaw + 2 * np.pi * np.round((y[:, _YAW] - yaw) / (2 * np.pi)))


def level_section_of(setting: Setting, name: str) -> Section:
    """The chart of a model on level ground, where all gaits can start from rest.

    Raises:
        ModelError: as `section_of`; or the ground is not level.
    """
    section = section_of(setting, name)
    if section.heads or section.curvature:
        raise ModelError(
            f"the {name} model is not on level ground: the limit cycles of many gaits at once are "
            'of level ground only. Use settle="cycles", or rr.limit_cycle for each gait.'
        )
    return section


def section_of(setting: Setting, name: str) -> Section:
    """The chart of a model in the engine's terms.

    Raises:
        ModelError: nothing brakes what rolls or rocks: such a motion never settles; or no motion
            of the ground onto itself is left, up to which a cycle could repeat.
    """
    axis, terrain = setting.axis, setting.terrain
    heads, curvature = False, 0.0
    if terrain is not None:
        if terrain.ground == GRAPH:
            raise ModelError(
                f"the {name} model is on a Graph, which is no two places alike: no cycle repeats "
                "up to a displacement. Give a plane, level or a slope, or a Boulder; or simulate."
            )
        if terrain.shell == FLAT:
            raise ModelError(
                f"the {name} model has a flat belly: limit cycles are of shells that are round "
                "enough to roll on a plane. Simulate, or give such a shell."
            )
        heads = bool(terrain.ground == SLOPE)
        curvature = terrain.curvature if terrain.ground == BOULDER else 0.0
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
    return Section((0, 1), (0, 1) if level else (0, 1, 2), True, level, heads, curvature)


def momentum_scale(cycles: Cycles) -> Array:
    """I omega of each gait (n,) [N m s]."""
    mass, radius = cycles.setting.parameters[:2]
    if cycles.setting.axis == ANY:
        radius = 0.0
    inertia = cycles.inertia() + mass * radius**2
    return np.asarray(inertia * 2 * np.pi / cycles.period)
