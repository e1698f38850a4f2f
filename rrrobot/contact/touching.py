"""Where a shell touches the ground, and how that place moves: one form for every pair.

With R = R_world_shell, n the ground's normal at the contact P and rho the arm from the shell's
frame to the contact,

    round shell:              rho = R dh(-R^T n),           P = point of the ground's coordinates
    flat belly on a boulder:  n = R e3,  P = (n - z)/k,     rho = R (x1, x2, 0)

In the second the body's attitude says where on the boulder it stands; the two coordinates of the
contact are its place on the belly.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.contact.boulder import is_rock
from rrrobot.contact.ground import Ground
from rrrobot.contact.kinematics import contact_velocity
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.surfaces import Surface
from rrrobot.errors import ShellError

_ITERATIONS = 50
_STILL = 1e-15


class Contact(NamedTuple):
    """Where a shell touches the ground, in the world."""

    point: Array
    """P (3,) [m]"""
    normal: Array
    """n (3,)"""
    arm: Array
    """rho, from the origin of the shell's frame to P (3,) [m]"""


def check_pair(surface: Surface, ground: Ground) -> None:
    """Raise ShellError where a shell cannot roll on a ground whatever its attitude."""
    if not isinstance(surface, FlatBelly):
        return
    if not is_rock(ground):
        raise ShellError(
            f"a flat belly touches {ground!r} all over, or at its edge: it rolls on a Boulder of "
            "positive radius only. Put it on one, or give the belly a round shell."
        )


def touch(surface: Surface, ground: Ground, rotation: Array, coordinates: Array) -> Contact:
    """The contact of a shell in the attitude R_world_shell (3, 3).

    Args:
        surface, ground: the pair.
        rotation: R (3, 3).
        coordinates: of the contact (2,) [m]: on the ground, or on a flat belly.
    """
    if isinstance(surface, FlatBelly):
        normal = rotation[:, 2]
        return Contact(_foot(ground, normal), normal, rotation[:, :2] @ coordinates)
    point = ground.point(coordinates)
    normal = ground.normal(point)
    return Contact(point, normal, surface.arm(rotation, normal))


def touch_near(surface: Surface, ground: Ground, rotation: Array, origin: Array) -> Contact:
    """The contact of a shell whose frame stands at `origin` (3,), on the ground or near it.

    P is the ground's point below the shell's point of opposite normal, by Newton's method.
    """
    if isinstance(surface, FlatBelly):
        normal = rotation[:, 2]
        point = _foot(ground, normal)
        inward = point - origin
        return Contact(point, normal, inward - (inward @ normal) * normal)
    if ground.fixed_normal is not None:
        # A plane through the world's origin: no search.
        normal = ground.fixed_normal
        arm = surface.arm(rotation, normal)
        inward = origin + arm
        return Contact(inward - (inward @ normal) * normal, normal, arm)
    coordinates = ground.coordinates(origin)
    for _ in range(_ITERATIONS):
        point, normal, arm = touch(surface, ground, rotation, coordinates)
        gap = origin + arm - point
        along = gap - (gap @ normal) * normal
        hessian = rotation @ surface.hessian(-rotation.T @ normal) @ rotation.T
        move = np.asarray(np.linalg.solve(np.eye(3) + hessian @ ground.curvature(point), along))
        coordinates = coordinates + ground.coordinate_rates(point, move)
        if move @ move < _STILL**2:
            break
    return touch(surface, ground, rotation, coordinates)


def contact_rate(
    surface: Surface, ground: Ground, rotation: Array, omega_world: Array, contact: Contact
) -> Array:
    """P_dot = R x_dot (3,) [m/s] of a shell that rolls with omega_world (3,) [rad/s]."""
    if isinstance(surface, FlatBelly):
        return ground.radius * np.cross(omega_world, contact.normal)  # type: ignore[attr-defined]
    curvature = None if ground.fixed_normal is not None else ground.curvature(contact.point)
    return contact_velocity(surface, rotation, omega_world, contact.normal, curvature)


def coordinate_rates(
    surface: Surface, ground: Ground, rotation: Array, contact: Contact, velocity: Array
) -> Array:
    """Rates (2,) of the contact's coordinates, see `touch`, as it moves with P_dot (3,)."""
    if isinstance(surface, FlatBelly):
        return velocity @ rotation[:, :2]
    return ground.coordinate_rates(contact.point, velocity)


def trouble(surface: Surface, ground: Ground, rotation: Array, coordinates: Array) -> str | None:
    """Why a contact is no longer one that rolls, or None.

    The equator of a boulder, the end of a grid or of a belly; or a ground that curves tighter than
    the shell, det(1 + H B) <= 0, where a second contact appears.
    """
    if isinstance(surface, FlatBelly):
        if not surface.holds(coordinates):
            return "the contact is at the edge of the flat belly"
        return ground.leaves(_foot(ground, rotation[:, 2])[:2])
    left = ground.leaves(coordinates)
    if left is not None or ground.fixed_normal is not None:
        return left
    point = ground.point(coordinates)
    normal = ground.normal(point)
    hessian = rotation @ surface.hessian(-rotation.T @ normal) @ rotation.T
    values = np.linalg.eigvals(np.eye(3) + hessian @ ground.curvature(point)).real
    if values.min() > 0:
        return None
    return (
        "the ground curves tighter than the shell (det(1 + H B) <= 0), so that it touches a second "
        "time"
    )


def _foot(ground: Ground, normal: Array) -> Array:
    """The boulder's point of a normal."""
    point: Array = ground.radius * normal  # type: ignore[attr-defined]
    point[2] -= ground.radius  # type: ignore[attr-defined]
    return point
