"""The ground that a shell rolls on: a regular surface with a normal and a curvature at each point.

Points P of the ground are in the world; z is up. With the unit normal n out of the ground (n_z > 0)
and the curvature operator B,

    n_dot = B P_dot        for a P that moves along the ground,       B n = 0,  B symmetric.

A plane has B = 0; a convex ground, such as a boulder, has B >= 0 on the tangent plane. Each ground
has two coordinates (u, v) of its own, in which a trajectory's `position` is given: lengths along
(t1, t2) on a plane, the world's (x, y) elsewhere. Boulders and graphs are in their own files.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from rrrobot import serial
from rrrobot.checks import Array, finite, vector
from rrrobot.errors import ParameterError


class Ground(ABC):
    """What a robot rests on, and the gravity there.

    Attributes:
        gravity: g, along -z of the world [m/s^2]; None takes the robot's parameters', or 9.81.
    """

    gravity: float | None

    @property
    def fixed_normal(self) -> Array | None:
        """The unit normal (3,) where it is the same everywhere (a plane), else None."""
        return None

    @abstractmethod
    def point(self, coordinates: Array) -> Array:
        """World point (3,) [m] of ground coordinates (2,)."""

    def coordinates(self, point: Array) -> Array:
        """Ground coordinates (2,) below a point (3,); the world's (x, y) unless overridden."""
        return point[:2]

    @abstractmethod
    def coordinate_rates(self, point: Array, velocity: Array) -> Array:
        """Rates (2,) of the ground coordinates of a point that moves along the ground (3,)."""

    @abstractmethod
    def normal(self, point: Array) -> Array:
        """Unit normal n (3,) at a point (3,)."""

    @abstractmethod
    def curvature(self, point: Array) -> Array:
        """B (3, 3) [1/m] at a point (3,)."""

    @abstractmethod
    def distance(self, point: Array) -> float:
        """Distance of any point near the ground from it [m], above zero outside; to first order."""

    def distances(self, points: Array) -> Array:
        """`distance` of points (n, 3) from the ground (n,) [m]."""
        return np.array([self.distance(point) for point in points])

    def leaves(self, coordinates: Array) -> str | None:
        """Why a contact at these coordinates (2,) is past what the ground describes, or None."""
        return None

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """The ground as plain data; `ground_from_dict` is the inverse."""


@serial.register("plane")
@dataclass(frozen=True, kw_only=True, eq=False)
class Plane(Ground):
    """A plane through the world's origin, level unless told otherwise.

    Attributes:
        normal_vector: unit normal (3,); given as `normal`, of any length. A robot's ground
            points up (n_z > 0), a wall need not.
        basis: columns (t1, t2, n) (3, 3): t1 is the world's x axis laid onto the plane.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> slope = rr.Plane(normal=(-np.sin(0.1), 0, np.cos(0.1)))
        >>> rr.FullModel(rr.Robot.from_parameters(), ground=slope).ground.is_level
        False
    """

    normal_vector: Array
    basis: Array
    gravity: float | None = None

    def __init__(self, normal: Any = (0.0, 0.0, 1.0), *, gravity: float | None = None) -> None:
        n = vector("normal", normal, 3)
        if not n.any():
            raise ParameterError("normal is zero: it must be a direction.")
        n /= np.abs(n).max()
        n /= np.linalg.norm(n)
        basis = ground_basis(n)
        for array in (n, basis):
            array.flags.writeable = False
        object.__setattr__(self, "normal_vector", n)
        object.__setattr__(self, "basis", basis)
        object.__setattr__(self, "gravity", checked_gravity(gravity))

    @property
    def is_level(self) -> bool:
        """Whether the normal is the world's z axis."""
        return bool(self.normal_vector[2] == 1.0)

    @property
    def fixed_normal(self) -> Array:
        return self.normal_vector

    def point(self, coordinates: Array) -> Array:
        return self.basis[:, :2] @ coordinates

    def coordinates(self, point: Array) -> Array:
        return point @ self.basis[:, :2]

    def coordinate_rates(self, point: Array, velocity: Array) -> Array:
        return velocity @ self.basis[:, :2]

    def normal(self, point: Array) -> Array:
        return self.normal_vector

    def curvature(self, point: Array) -> Array:
        return np.zeros((3, 3))

    def distance(self, point: Array) -> float:
        return float(self.normal_vector @ point)

    def to_dict(self) -> dict[str, Any]:
        return {"type": "plane", "normal": self.normal_vector.tolist(), "gravity": self.gravity}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plane) and self.to_dict() == other.to_dict()

    def __hash__(self) -> int:
        return hash((*self.normal_vector.tolist(), self.gravity))

    def __repr__(self) -> str:
        parts = [] if self.is_level else [f"normal={self.normal_vector.tolist()}"]
        parts += [] if self.gravity is None else [f"gravity={self.gravity}"]
        return f"Plane({', '.join(parts)})"


def normals(ground: Ground, coordinates: Array) -> Array:
    """Unit normals (n, 3) at ground coordinates (n, 2)."""
    fixed = ground.fixed_normal
    if fixed is not None:
        return np.broadcast_to(fixed, (len(coordinates), 3))
    return np.array([ground.normal(ground.point(c)) for c in coordinates])


def checked_gravity(gravity: float | None) -> float | None:
    """g [m/s^2], zero or more, or None."""
    return None if gravity is None else finite("gravity", gravity, "m/s^2", at_least=0)


def ground_basis(normal: Array) -> Array:
    """Columns (t1, t2, n) of the ground plane, shape (3, 3), right-handed; identity for n = z.

    t1 is the projection of the world's x axis (of y where n is along x), so that the contact
    point's plane coordinates are the world's x and y on level ground.
    """
    seed = np.array((1.0, 0.0, 0.0)) if abs(normal[0]) < 0.9 else np.array((0.0, 1.0, 0.0))
    first = seed - (seed @ normal) * normal
    first /= np.linalg.norm(first)
    return np.column_stack((first, np.cross(normal, first), normal))
