"""How far a belly may roll until something else of the robot touches the ground."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rrrobot.belly.placed import Gauge, curvature_of, touches
from rrrobot.belly.shapes import Piece
from rrrobot.checks import Array
from rrrobot.contact.boulder import Boulder
from rrrobot.contact.ground import Ground
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.surfaces import Surface

AZIMUTHS = 2 * np.pi * np.arange(24) / 24
"""Sides that are tried [rad]."""
FARTHEST = float(np.deg2rad(60.0))
"""Tilt up to which is looked [rad]."""
TOUCH = 5e-4
"""Depth up to which what the shell stands for counts as not poking out of it [m]."""
_STEPS, _HALVINGS = 20, 12
NOTHING = "nothing"


@dataclass(frozen=True, kw_only=True, eq=False)
class RollingRange:
    """Tilts at which something but the shell touches, the legs in their posture.

    The tilt is the angle between straight down in the base and the belly's normal at the contact,
    its azimuth the side that goes down, from the base's x axis to its y axis. On a flat belly, it
    is the angle by which it has rolled on its boulder: the contact's place over the radius.

    Attributes:
        azimuth: (n,) [rad], ascending in [0, 2 pi).
        tilt: at which something touches first (n,) [rad]; 60 degrees where nothing does.
        link: what that is (n,).

    Example:
        >>> import rrrobot as rr
        >>> belly = rr.fit_belly(rr.Robot.from_parameters(), posture=(1.57, 1.57))
        >>> set(belly.rolling_range.link)
        {'nothing'}
    """

    azimuth: Array
    tilt: Array
    link: tuple[str, ...]

    @property
    def least(self) -> float:
        """The least tilt of all sides [rad]."""
        return float(self.tilt.min())

    def at(self, azimuth: float | Array) -> Any:
        """Tilt [rad] that an azimuth [rad] allows, between those that were tried."""
        return np.interp(azimuth, self.azimuth, self.tilt, period=2 * np.pi)

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "azimuth": self.azimuth.tolist(),
            "tilt": self.tilt.tolist(),
            "link": list(self.link),
        }


def rolling_range(
    shell: Surface,
    center: Array,
    ground: Ground,
    pieces: Sequence[Piece],
    end: tuple[Array, str],
) -> RollingRange:
    """The range of a belly.

    Args:
        shell: the belly's, without rotation in the base.
        center: of the shell in the base's frame (3,) [m].
        ground: what it rolls on.
        pieces: that may touch, in the base's frame, the legs in their posture; see `placed`.
        end: tilts (len(AZIMUTHS),) at which the belly itself ends [rad], and the name for that.
    """
    around, ends = AZIMUTHS, np.minimum(end[0], FARTHEST)
    names = [end[1] if one < FARTHEST else NOTHING for one in ends]
    low, high = np.zeros(len(around)), ends.copy()
    if not pieces:
        return RollingRange(azimuth=around, tilt=ends, link=tuple(names))

    gauge = Gauge(pieces, curvature_of(ground))

    def least(tilt: Array) -> tuple[Array, Array]:
        found = gauge(touches(shell, center, ground, tilt, around))
        return found.min(axis=1) + TOUCH, found.argmin(axis=1)

    # The first step at which something touches, then halvings.
    steps = np.linspace(0, 1, _STEPS + 1)[1:]
    open_ = np.ones(len(around), dtype=bool)
    begin = least(low)[0] < 0
    high[begin], open_[begin] = 0.0, False
    for part in steps:
        if not open_.any():
            break
        tilt = np.where(open_, part * ends, low)
        hit = open_ & (least(tilt)[0] < 0)
        high[hit], open_[hit] = tilt[hit], False
        low[open_] = tilt[open_]
    touching = ~open_
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        hit = least(middle)[0] < 0
        high[touching & hit] = middle[touching & hit]
        low[touching & ~hit] = middle[touching & ~hit]
    which = least(high)[1]
    for i in np.flatnonzero(touching):
        names[i] = pieces[int(which[i])].link
    return RollingRange(azimuth=around, tilt=np.where(touching, high, ends), link=tuple(names))


def flat_end(belly: FlatBelly, boulder: Boulder, azimuth: Array) -> Array:
    """Angles by which a flat belly rolls on a boulder until the contact is at its edge [rad]."""
    reach = np.full(len(azimuth), np.inf)
    for half, part in ((belly.half_length, np.cos(azimuth)), (belly.half_width, np.sin(azimuth))):
        if half is not None:
            reach = np.minimum(reach, half / np.maximum(np.abs(part), 1e-12))
    return reach / boulder.radius


def round_end(
    shell: Surface, center: Array, body: Callable[[Array], Array], allowed: float
) -> Array:
    """Tilts up to which a body keeps within `allowed` [m] of the shell that stands for it [rad]."""
    out = np.full(len(AZIMUTHS), FARTHEST)
    for tilt in np.deg2rad(np.arange(60.0, 0.0, -1.0)):
        u = np.column_stack((np.sin(tilt) * np.cos(AZIMUTHS), np.sin(tilt) * np.sin(AZIMUTHS),
                             np.full(len(AZIMUTHS), -np.cos(tilt))))  # fmt: skip
        gap = np.array([shell.support(one) for one in u]) + u @ center - body(u)
        out[np.abs(gap) > allowed] = tilt
    return out
