"""A boulder, or a bowl: a fixed sphere whose top, or bottom, is the world's origin."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Any, TypeGuard

import numpy as np

from rrrobot import serial
from rrrobot.checks import Array, finite
from rrrobot.contact.ground import Ground, checked_gravity
from rrrobot.errors import ParameterError

LOWEST_NORMAL = 0.05
"""Height n_z of the normal at which a contact counts as at the equator, where (x, y) fail."""


@serial.register("boulder")
@dataclass(frozen=True)
class Boulder(Ground):
    """A fixed sphere with its top at the world's origin: n = z + k P, B = k (1 - n n^T), k = 1/R.

    A negative radius is a bowl, with its lowest point at the origin. Ground coordinates are the
    world's (x, y); the equator, where the ground is vertical, ends them.

    Attributes:
        radius: R [m], not zero; below zero for a bowl.
        gravity: see `Ground`.

    Raises:
        ParameterError: a radius that is zero or not finite.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> rock = rr.Boulder(0.5)
        >>> rock.normal(rock.point(np.array([0.3, 0.0]))).round(9).tolist()
        [0.6, 0.0, 0.8]
    """

    radius: float
    gravity: float | None = None

    def __post_init__(self) -> None:
        radius = finite("radius", self.radius, "m")
        if radius == 0.0:
            raise ParameterError(
                "radius is 0.0 m: a boulder's is above zero, a bowl's below. For flat ground use "
                "Plane()."
            )
        object.__setattr__(self, "radius", radius)
        object.__setattr__(self, "gravity", checked_gravity(self.gravity))

    def point(self, coordinates: Array) -> Array:
        x, y = coordinates
        k, across = 1.0 / self.radius, x * x + y * y
        # z = (n_z - 1) / k, without the difference of near equals.
        return np.array((x, y, -k * across / (1.0 + sqrt(max(1.0 - k * k * across, 0.0)))))

    def coordinate_rates(self, point: Array, velocity: Array) -> Array:
        return velocity[:2]

    def normal(self, point: Array) -> Array:
        n = point / self.radius
        n[2] += 1.0
        return n / sqrt(n @ n)

    def curvature(self, point: Array) -> Array:
        n = self.normal(point)
        return (np.eye(3) - np.outer(n, n)) / self.radius

    def distance(self, point: Array) -> float:
        k = 1.0 / self.radius
        # |z + k p| = 1 on the ground.
        excess = k * (point @ point) + 2.0 * point[2]
        return float(excess / (1.0 + sqrt(max(1.0 + k * excess, 0.0))))

    def leaves(self, coordinates: Array) -> str | None:
        across = float(coordinates @ coordinates) / self.radius**2
        if across < 1.0 - LOWEST_NORMAL**2:
            return None
        kind = "boulder" if self.radius > 0 else "bowl"
        return f"the contact is at the {kind}'s equator, where the ground is vertical"

    def to_dict(self) -> dict[str, Any]:
        return {"type": "boulder", "radius": self.radius, "gravity": self.gravity}


def is_rock(ground: Ground) -> TypeGuard[Boulder]:
    """Whether a ground is a boulder with a top, and no bowl."""
    return isinstance(ground, Boulder) and ground.radius > 0


def depth_of_floor(ground: Ground, floor: float | None) -> float | None:
    """How far the top of a rock is above the floor [m]: its radius unless given; None of no rock.

    Raises:
        ParameterError: a floor below ground that is no rock, or one that is not below its top.
    """
    if is_rock(ground):
        return finite("floor", ground.radius if floor is None else floor, "m", above=0)
    if floor is not None:
        raise ParameterError(f"floor is {floor!r} m: only a rock has one below it, not {ground!r}.")
    return None
