"""Further shells: sums of ellipsoids, which are rounded boxes, and a flat belly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import Array, finite, vector
from rrrobot.contact.surfaces import Surface
from rrrobot.errors import ParameterError, ShellError


@serial.register("ellipsoid sum")
@dataclass(frozen=True)
class EllipsoidSum(Surface):
    """Minkowski sum of ellipsoids about one centre: h(u) = sum of sqrt(u^T A_j u).

    A round one and flat ones together make a rounded box. One or two semi-axes of a term may be
    zero (a disc, a rod), as long as the sum is strictly convex.

    Args:
        semi_axes: (a, b, c) of each ellipsoid along x, y, z of the shell's frame [m], zero or
            more; at least one ellipsoid has all three above zero.

    Raises:
        ParameterError: a semi-axis below zero, or no ellipsoid with all three above zero.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> box = rr.EllipsoidSum([(0.06, 0.06, 0.06), (0.06, 0.05, 0.06), (0.06, 0.06, 0.03)])
        >>> round(box.support(np.array([0.0, 0.0, -1.0])), 9)
        0.15
    """

    semi_axes: tuple[tuple[float, float, float], ...]

    def __init__(self, semi_axes: Sequence[ArrayLike]) -> None:
        given = [vector(f"semi_axes[{i}]", one, 3, "m") for i, one in enumerate(semi_axes)]
        axes = np.array(given).reshape(-1, 3)
        if np.any(axes < 0) or not np.any(np.all(axes > 0, axis=1)):
            raise ParameterError(
                f"semi_axes is {axes.tolist()} m: none may be below zero, and one ellipsoid must "
                "have all three above zero. Add a small sphere to round a box of discs."
            )
        object.__setattr__(self, "semi_axes", tuple(tuple(row) for row in axes.tolist()))

    def _parts(self, u: Array) -> tuple[Array, Array, Array]:
        """Squared semi-axes, A_j u and h_j (m, 1) of the terms that do not vanish at u."""
        squares = np.square(np.asarray(self.semi_axes))
        scaled = squares * np.asarray(u, dtype=float)
        h = np.sqrt(scaled @ u)
        some = h > 0
        return squares[some], scaled[some], h[some, None]

    def support(self, u: Array) -> float:
        return float(self._parts(u)[2].sum())

    def contact(self, u: Array) -> Array:
        _, scaled, h = self._parts(u)
        return np.asarray((scaled / h).sum(axis=0))

    def hessian(self, u: Array) -> Array:
        squares, scaled, h = self._parts(u)
        return np.diag((squares / h).sum(axis=0)) - scaled.T @ (scaled / h**3)

    def ellipsoids(self) -> Array:
        return np.array([np.diag(np.square(axes)) for axes in self.semi_axes])

    def to_dict(self) -> dict[str, Any]:
        return {"type": "ellipsoid sum", "semi_axes": [list(axes) for axes in self.semi_axes]}


@serial.register("flat belly")
@dataclass(frozen=True)
class FlatBelly(Surface):
    """A flat underside that rolls on a boulder: the plane z = 0 of its frame, the robot above.

    Flat ground holds it still, a convex round one lets it roll: the contact's normal is fixed in
    the body, and its place on the belly is what moves. It has no support function of use.

    Attributes:
        half_length, half_width: reach of the belly along x and y of its frame from the origin [m];
            without limit unless given.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> rr.FlatBelly(0.2, 0.1).holds(np.array([0.1, -0.05]))
        True
    """

    half_length: float | None = None
    half_width: float | None = None

    def __post_init__(self) -> None:
        for name in ("half_length", "half_width"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, finite(name, value, "m", above=0))

    def holds(self, point: Array) -> bool:
        """Whether a point (2,) [m] is on the belly."""
        reach = (self.half_length, self.half_width)
        return all(r is None or abs(x) <= r for r, x in zip(reach, point, strict=True))

    def support(self, u: Array) -> float:
        raise self._refusal()

    def contact(self, u: Array) -> Array:
        raise self._refusal()

    def hessian(self, u: Array) -> Array:
        raise self._refusal()

    def _refusal(self) -> ShellError:
        return ShellError(
            "a flat belly touches a plane or a hollow all over, or at its edge: it rolls on a "
            "Boulder only. Put it on one, or give the belly a round shell."
        )

    def to_dict(self) -> dict[str, Any]:
        return {
            "type": "flat belly",
            "half_length": self.half_length,
            "half_width": self.half_width,
        }
