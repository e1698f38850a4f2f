"""Round shells by their support function.

A strictly convex shell has the support function h(u) = max of u . x over its points x, u a unit
vector, both in the shell's frame. The shell touches a plane of unit normal n (world) at the point
with u = -R^T n, so with R = R_world_shell

    rho     = R dh(u)                                contact arm, from the centre to the contact
    rho_dot = R (w x dh(u) + d2h(u) u_dot)           u_dot = -w x u,  w = angular velocity in R

(dh the gradient of the degree-one extension of h, d2h its Hessian). A sphere has h = r |u|, so
rho = -r n and rho_dot = 0: the contact point moves over the body, and not with it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import Array, finite, vector
from rrrobot.errors import ParameterError
from rrrobot.rotations import skew

SHELL_FRAME = "rrrobot_shell"
"""Frame that every Robot adds to its Pinocchio model: the shell's centre and axes."""


class Surface(ABC):
    """A strictly convex shell, centred at the origin of its frame.

    A subclass gives `support`, `contact` and `hessian`; everything else follows. Override `arm`
    and `arm_rate` only to be faster.
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

    def arm_rate(self, rotation: Array, omega_world: Array, normal: Array) -> Array:
        """Rate of the contact arm rho_dot (3,) in the world frame [m/s]."""
        u = -rotation.T @ normal
        w = skew(rotation.T @ omega_world)
        return rotation @ (w @ self.contact(u) - self.hessian(u) @ (w @ u))

    def fixed_arm(self, normal: Array) -> Array | None:
        """The contact arm (3,) [m] if it is the same at every orientation, else None."""
        return None

    def principal_radii(self, u: Array) -> Array:
        """The two principal radii of curvature (2,) [m] at the point with normal u."""
        return np.sort(np.linalg.eigvalsh(self.hessian(u / np.linalg.norm(u))))[1:]


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

    def arm_rate(self, rotation: Array, omega_world: Array, normal: Array) -> Array:
        return np.zeros(3)

    def fixed_arm(self, normal: Array) -> Array | None:
        return -self.radius * normal

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

    def _scaled(self, u: ArrayLike) -> tuple[Array, float]:
        scaled = np.square(np.asarray(self.semi_axes)) * np.asarray(u, dtype=float)
        return scaled, float(np.sqrt(scaled @ np.asarray(u)))

    def support(self, u: Array) -> float:
        return self._scaled(u)[1]

    def contact(self, u: Array) -> Array:
        scaled, h = self._scaled(u)
        return scaled / h

    def hessian(self, u: Array) -> Array:
        scaled, h = self._scaled(u)
        return np.diag(np.square(self.semi_axes)) / h - np.outer(scaled, scaled) / h**3

    def to_dict(self) -> dict[str, Any]:
        return {"type": "ellipsoid", "semi_axes": list(self.semi_axes)}


def surface_from_dict(data: dict[str, Any]) -> Surface:
    """The shell that `to_dict` wrote."""
    return serial.from_dict(data, Surface, "shell")  # type: ignore[type-abstract]
