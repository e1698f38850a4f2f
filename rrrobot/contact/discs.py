"""The torus and its limit, the thin disc: shells whose edge rolls.

A torus is the set within `tube` of a circle of `radius` about the y axis, the axle:

    h(u) = r sqrt(u_x^2 + u_z^2) + rho |u|

Its principal radii at a contact are rho and rho + r / sqrt(u_x^2 + u_z^2) (at |u| = 1). A disc,
rho = 0, has one radius of curvature zero: its edge is sharp, and it rolls all the same, for rolling
needs the Hessian of h and never the curvature. Lying flat, u = +-y, a torus touches along a circle
and h has no gradient: that is refused.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

from rrrobot import serial
from rrrobot.checks import Array, finite
from rrrobot.contact.surfaces import Surface
from rrrobot.errors import ConstraintError

_FLAT = 1e-9
"""Sine of the axle's angle to the vertical below which a torus lies flat."""


@serial.register("torus")
@dataclass(frozen=True)
class Torus(Surface):
    """A wheel that rolls on its edge, its axle along y: h(u) = r sqrt(u_x^2 + u_z^2) + rho |u|.

    Attributes:
        radius: r, of the circle of the tube's centres, greater than zero [m].
        tube: rho, of the tube; zero is a thin disc [m].

    Example:
        >>> import numpy as np
        >>> from rrrobot.contact.discs import Torus
        >>> coin = Torus(0.3)
        >>> coin.contact(np.array([0.0, 0.0, -1.0])).tolist()
        [0.0, 0.0, -0.3]
        >>> Torus(0.3, 0.02).principal_radii(np.array([0.0, 0.0, -1.0])).round(12).tolist()
        [0.02, 0.32]
    """

    radius: float
    tube: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", finite("radius", self.radius, "m", above=0))
        object.__setattr__(self, "tube", finite("tube", self.tube, "m", at_least=0))

    def support(self, u: Array) -> float:
        return self.radius * sqrt(u[0] ** 2 + u[2] ** 2) + self.tube * float(np.linalg.norm(u))

    def contact(self, u: Array) -> Array:
        across, length = self._lengths(u)
        return self.radius / across * u * (1.0, 0.0, 1.0) + self.tube / length * u

    def hessian(self, u: Array) -> Array:
        across, length = self._lengths(u)
        edge = np.array((-u[2], 0.0, u[0])) / across
        e = u / length
        tube = self.tube / length * (np.eye(3) - np.outer(e, e))
        return self.radius / across * np.outer(edge, edge) + tube

    def _lengths(self, u: Array) -> tuple[float, float]:
        across, length = sqrt(u[0] ** 2 + u[2] ** 2), float(np.linalg.norm(u))
        if across <= _FLAT * length:
            raise ConstraintError(
                "the disc lies flat: it touches the ground along its whole edge, and rolling on "
                "a point ends there. Stop before that, or give it more spin."
            )
        return across, length

    def to_dict(self) -> dict[str, Any]:
        return {"type": "torus", "radius": self.radius, "tube": self.tube}
