"""Round shells by their support function.

A strictly convex shell has the support function h(u) = max of u . x over its points x, u a unit
vector, both in the shell's frame. The shell touches a plane of unit normal n (world) at the point
with u = -R^T n, so with R = R_world_shell

    rho = R dh(u)                                    contact arm, from the centre to the contact

(dh the gradient of the degree-one extension of h, d2h its Hessian, whose eigenvalues on the tangent
plane are the principal radii of curvature). A sphere has h = r |u|, so rho = -r n. How the contact
moves is in `rrrobot.contact.kinematics`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

from rrrobot import serial
from rrrobot.checks import Array, finite, vector
from rrrobot.errors import ParameterError

SHELL_FRAME = "rrrobot_shell"
"""Frame that every Robot adds to its Pinocchio model: the shell's centre and axes."""


class Surface(ABC):
    """A strictly convex shell in its own frame, by its support function.

    A subclass gives `support`, `contact` and `hessian`; everything else follows. `check_convex`
    tries them. Override `arm` only to be faster, and `ellipsoids` where it holds.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> class Egg(rr.Surface):
        ...     def support(self, u):
        ...         return 0.12 * np.linalg.norm(u) + 0.03 * u[0] ** 3 / (u @ u)
        ...     def contact(self, u):
        ...         s = u @ u
        ...         bump = 3 * u[0] ** 2 / s * np.eye(3)[0] - 2 * u[0] ** 3 / s**2 * u
        ...         return 0.12 * u / np.sqrt(s) + 0.03 * bump
        ...     def hessian(self, u):
        ...         s, x, e = u @ u, u[0], np.eye(3)[0]
        ...         cross = np.outer(e, u) + np.outer(u, e)
        ...         bump = 6 * x / s * np.outer(e, e) - 6 * x**2 / s**2 * cross
        ...         bump += 8 * x**3 / s**3 * np.outer(u, u) - 2 * x**3 / s**2 * np.eye(3)
        ...         round_part = (np.eye(3) - np.outer(u, u) / s) / np.sqrt(s)
        ...         return 0.12 * round_part + 0.03 * bump
        ...     def to_dict(self):
        ...         return {"type": "egg"}
        >>> round(rr.contact.check_convex(Egg()), 3)
        0.06
    """

    @abstractmethod
    def support(self, u: Array) -> float:
        """Support function h(u) [m] of a direction u (3,) in the shell's frame."""

    @abstractmethod
    def contact(self, u: Array) -> Array:
        """Gradient dh(u) (3,) [m]: the shell's point with outward normal u."""

    @abstractmethod
    def hessian(self, u: Array) -> Array:
        """Hessian d2h(u) (3, 3) [m]: on the tangent plane, the inverse of the curvature."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """The shell as plain numbers; `surface_from_dict` is the inverse."""

    def arm(self, rotation: Array, normal: Array) -> Array:
        """Contact arm rho (3,) in the world frame [m], for R_world_shell and the normal."""
        return rotation @ self.contact(-rotation.T @ normal)

    def fixed_arm(self, normal: Array) -> Array | None:
        """The contact arm (3,) [m] if it is the same at every orientation, else None."""
        return None

    def ellipsoids(self) -> Array | None:
        """A (m, 3, 3) [m^2] where h(u) = sum of sqrt(u.A_j u); else None."""
        return None

    def principal_radii(self, u: Array) -> Array:
        """The two principal radii of curvature (2,) [m] at the point with normal u."""
        u = u / np.linalg.norm(u)
        first = np.cross(u, np.eye(3)[np.argmin(np.abs(u))])
        first /= np.linalg.norm(first)
        tangent = np.array((first, np.cross(u, first)))
        return np.linalg.eigvalsh(tangent @ self.hessian(u) @ tangent.T)


@serial.register("sphere")
@dataclass(frozen=True)
class Sphere(Surface):
    """A spherical shell: h(u) = r |u|.

    Attributes:
        radius: r [m], greater than zero.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> up = np.array([0.0, 0.0, 1.0])
        >>> rr.Sphere(0.12).arm(np.eye(3), up).tolist()
        [-0.0, -0.0, -0.12]
    """

    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", finite("radius", self.radius, "m", above=0))

    def support(self, u: Array) -> float:
        return self.radius * float(np.linalg.norm(u))

    def contact(self, u: Array) -> Array:
        return self.radius * u / np.linalg.norm(u)

    def hessian(self, u: Array) -> Array:
        length = float(np.linalg.norm(u))
        e = u / length
        return self.radius / length * (np.eye(3) - np.outer(e, e))

    def arm(self, rotation: Array, normal: Array) -> Array:
        return -self.radius * normal

    def fixed_arm(self, normal: Array) -> Array | None:
        return -self.radius * normal

    def ellipsoids(self) -> Array:
        return np.asarray(self.radius**2 * np.eye(3)[None])

    def to_dict(self) -> dict[str, Any]:
        return {"type": "sphere", "radius": self.radius}


@serial.register("ellipsoid")
@dataclass(frozen=True)
class Ellipsoid(Surface):
    """An ellipsoidal shell: h(u) = sqrt(u^T A u) with A = diag(a^2, b^2, c^2).

    Attributes:
        semi_axes: (a, b, c) along x, y, z of the shell's frame [m], each greater than zero.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> shell = rr.Ellipsoid((0.15, 0.1, 0.12))
        >>> shell.support(np.array([1.0, 0.0, 0.0]))
        0.15
    """

    semi_axes: tuple[float, float, float]

    def __post_init__(self) -> None:
        axes = vector("semi_axes", self.semi_axes, 3, "m")
        if not np.all(axes > 0):
            raise ParameterError(f"semi_axes is {axes.tolist()} m: each must be above zero.")
        object.__setattr__(self, "semi_axes", tuple(axes.tolist()))
        object.__setattr__(self, "_squares", axes**2)
        object.__setattr__(self, "_square", np.diag(axes**2))

    def _scaled(self, u: Array) -> tuple[Array, float]:
        scaled = self._squares * u  # type: ignore[attr-defined]
        return scaled, sqrt(scaled @ u)

    def support(self, u: Array) -> float:
        return self._scaled(u)[1]

    def contact(self, u: Array) -> Array:
        scaled, h = self._scaled(u)
        return scaled / h

    def hessian(self, u: Array) -> Array:
        scaled, h = self._scaled(u)
        return self._square / h - scaled[:, None] * (scaled / h**3)  # type: ignore[attr-defined]

    def ellipsoids(self) -> Array:
        return np.array(self._square[None])  # type: ignore[attr-defined]

    def to_dict(self) -> dict[str, Any]:
        return {"type": "ellipsoid", "semi_axes": list(self.semi_axes)}
