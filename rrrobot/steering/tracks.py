"""Paths to follow: any polyline, a circle, a figure eight, and points that move."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import finite
from rrrobot.errors import ParameterError

_SPACING = 1e-3


class Nearest(NamedTuple):
    """The point of a path that is nearest to the robot."""

    along: float
    """arc length from the path's start [m]"""
    aside: float
    """distance of the robot from it, positive to the left [m]"""
    course: float
    """direction of the path [rad]"""
    curvature: float
    """of the path just ahead [1/m]"""


class Track:
    """A path in the plane.

    Args:
        points: corners (n, 2) [m], n at least 2; straight lines between them.
        closed: whether it goes from the last to the first and on.

    Attributes:
        length: [m].

    Raises:
        ParameterError: fewer than two points, or points that are not finite or do not differ.

    Example:
        >>> import rrrobot as rr
        >>> track = rr.steering.Track([(0, 0), (0.5, 0), (0.5, 0.5)])
        >>> round(track.length, 6), round(track.nearest((0.2, 0.01)).aside, 6)
        (1.0, 0.01)
    """

    def __init__(self, points: ArrayLike, *, closed: bool = False) -> None:
        try:
            corners = np.array(points, dtype=float)
        except (TypeError, ValueError):
            corners = np.empty(0)
        if corners.ndim != 2 or corners.shape[1:] != (2,) or len(corners) < 2:
            raise ParameterError(
                f"points have the shape {corners.shape}: a track needs (n, 2), n at least 2."
            )
        if not np.all(np.isfinite(corners)):
            raise ParameterError("points must be finite.")
        self.closed = closed
        ring = np.vstack((corners, corners[:1])) if closed else corners
        step = np.linalg.norm(np.diff(ring, axis=0), axis=1)
        if not step.sum() > 0:
            raise ParameterError("points are all the same: a track needs a length.")
        at = np.concatenate(([0.0], np.cumsum(step)))
        keep = np.concatenate(([True], step > 0))
        self.length = float(at[-1])
        self._at = np.linspace(0.0, self.length, max(3, int(self.length / _SPACING) + 1))
        self.points = np.column_stack([np.interp(self._at, at[keep], x[keep]) for x in ring.T])
        ahead = np.diff(self.points, axis=0)
        self._course = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
        # The course at the middles of the pieces; of a closed path, one more at each end.
        self._middle, self._turned = 0.5 * (self._at[1:] + self._at[:-1]), self._course
        if closed:
            last = (self._course[0] - self._course[-1] + np.pi) % (2 * np.pi) - np.pi
            self._lap = float(self._course[-1] - self._course[0] + last)
            self._middle = np.concatenate(
                (self._middle[-1:] - self.length, self._middle, self._middle[:1] + self.length)
            )
            self._turned = np.concatenate(
                (self._course[-1:] - self._lap, self._course, self._course[:1] + self._lap)
            )

    def nearest(
        self, point: ArrayLike, around: float | None = None, reach: float = 0.05
    ) -> Nearest:
        """The nearest point of the path.

        Args:
            point: (x, y) [m].
            around: only within `reach` of this arc length, so that a robot stays on its branch
                where a path crosses itself.
            reach: [m].
        """
        x = np.asarray(point, dtype=float)
        away = np.linalg.norm(self.points - x, axis=1)
        if around is not None:
            gap = np.abs(self._at - around)
            if self.closed:
                gap = np.abs((gap + self.length / 2) % self.length - self.length / 2)
            away = np.where(gap <= reach, away, np.inf)
        near, pieces = int(away.argmin()), len(self._course)
        # On one of the two pieces that meet at the nearest of the points.
        both = np.array((near, near - 1)) % pieces if self.closed else np.array((near, near - 1))
        both = both[(both >= 0) & (both < pieces)]
        step = self.points[both + 1] - self.points[both]
        rel = x - self.points[both]
        share = np.clip(np.sum(rel * step, axis=1) / np.sum(step**2, axis=1), 0.0, 1.0)
        k = int(np.linalg.norm(rel - share[:, None] * step, axis=1).argmin())
        i = int(both[k])
        course = float(self._course[i])
        normal = np.array((-np.sin(course), np.cos(course)))
        along = float(self._at[i] + share[k] * (self._at[i + 1] - self._at[i]))
        return Nearest(along, float(rel[k] @ normal), course, self._bend(along))

    def _bend(self, at: float, ahead: float = 0.02) -> float:
        """Mean curvature from `at` to `ahead` beyond [1/m]."""

        def course(s: float) -> float:
            laps = np.floor(s / self.length) if self.closed else 0.0
            turn = laps * self._lap if self.closed else 0.0
            return float(np.interp(s - laps * self.length, self._middle, self._turned) + turn)

        return (course(at + ahead) - course(at)) / ahead

    @classmethod
    def circle(cls, center: ArrayLike, radius: float) -> Track:
        """A circle, counter-clockwise."""
        r = finite("radius", radius, "m", above=0)
        turn = np.linspace(0, 2 * np.pi, max(60, int(2 * np.pi * r / _SPACING)), endpoint=False)
        ring = np.column_stack((np.cos(turn), np.sin(turn)))
        return cls(np.asarray(center, dtype=float) + r * ring, closed=True)

    @classmethod
    def eight(cls, width: float = 0.5, center: ArrayLike = (0.0, 0.0)) -> Track:
        """A lying figure eight, Gerono's lemniscate x = a sin t, y = a sin t cos t, a = width/2."""
        a = 0.5 * finite("width", width, "m", above=0)
        t = np.linspace(0, 2 * np.pi, max(200, int(8 * a / _SPACING)), endpoint=False)
        return cls(
            np.asarray(center, dtype=float)
            + a * np.column_stack((np.sin(t), np.sin(t) * np.cos(t))),
            closed=True,
        )
