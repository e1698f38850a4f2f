"""What stands in the way: discs and polygons in the plane."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.errors import ParameterError


@dataclass(frozen=True, eq=False)
class Disc:
    """A disc.

    Attributes:
        center: (x, y) [m].
        radius: [m], greater than zero.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> rr.steering.Disc((0.3, 0.0), 0.1).distance(np.zeros((1, 2))).round(3).tolist()
        [0.2]
    """

    center: Array
    radius: float

    def __init__(self, center: ArrayLike, radius: float) -> None:
        object.__setattr__(self, "center", vector("center", center, 2, "m"))
        object.__setattr__(self, "radius", finite("radius", radius, "m", above=0))

    def distance(self, points: Array) -> Array:
        """Distance of points (n, 2) from the disc (n,) [m], negative within it."""
        return np.linalg.norm(points - self.center, axis=1) - self.radius

    def to_dict(self) -> dict[str, Any]:
        return {"type": "disc", "center": self.center.tolist(), "radius": self.radius}


@dataclass(frozen=True, eq=False)
class Polygon:
    """A simple polygon, convex or not.

    Attributes:
        corners: in their order (n, 2) [m], n at least 3.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> wall = rr.steering.Polygon([(0.1, -1), (0.2, -1), (0.2, 1), (0.1, 1)])
        >>> wall.distance(np.array([(0.0, 0.0), (0.15, 0.0)])).round(3).tolist()
        [0.1, -0.05]
    """

    corners: Array

    def __init__(self, corners: ArrayLike) -> None:
        array = np.array(corners, dtype=float)
        if array.ndim != 2 or array.shape[1:] != (2,) or len(array) < 3:
            raise ParameterError(
                f"corners has the shape {array.shape}: a polygon needs (n, 2), n at least 3."
            )
        if not np.all(np.isfinite(array)):
            raise ParameterError("corners must be finite.")
        object.__setattr__(self, "corners", array)

    def distance(self, points: Array) -> Array:
        """Distance of points (n, 2) from the polygon (n,) [m], negative within it."""
        first, second = self.corners, np.roll(self.corners, -1, axis=0)
        edge = second - first
        rel = points[:, None] - first
        length = np.maximum((edge**2).sum(axis=1), 1e-300)
        share = np.clip((rel * edge).sum(axis=2) / length, 0.0, 1.0)
        away = np.linalg.norm(rel - share[..., None] * edge, axis=2).min(axis=1)
        x, y = points[:, :1], points[:, 1:]
        above = (first[:, 1] > y) != (second[:, 1] > y)
        rise = np.where(edge[:, 1] == 0, 1.0, edge[:, 1])
        cross = first[:, 0] + (y - first[:, 1]) / rise * edge[:, 0]
        inside = np.sum(above & (x < cross), axis=1) % 2 == 1
        return np.where(inside, -away, away)

    def to_dict(self) -> dict[str, Any]:
        return {"type": "polygon", "corners": self.corners.tolist()}


Obstacle = Disc | Polygon


def obstacle_from_dict(data: Mapping[str, Any]) -> Obstacle:
    """The obstacle that `to_dict` wrote.

    Raises:
        ParameterError: it is none.
    """
    kind = data.get("type")
    if kind == "disc":
        return Disc(data["center"], data["radius"])
    if kind == "polygon":
        return Polygon(data["corners"])
    raise ParameterError(f"obstacle type is {kind!r}: known are disc, polygon.")


def free_distance(obstacles: Sequence[Obstacle], points: Array) -> Array:
    """Least distance of points (n, 2) from all obstacles (n,) [m]; infinite without any."""
    least = np.full(len(points), np.inf)
    for obstacle in obstacles:
        least = np.minimum(least, obstacle.distance(points))
    return least
