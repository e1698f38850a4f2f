"""Is a shell convex, and how sharp: its Hessian over directions."""

from __future__ import annotations

import numpy as np

from rrrobot.checks import Array
from rrrobot.contact.surfaces import Ellipsoid, Surface
from rrrobot.errors import ShellError

_DIRECTIONS = 400
_STEP = 1e-4
_CONSISTENT = 1e-5
_POLISHINGS = 60


def radii_range(surface: Surface, directions: int = _DIRECTIONS) -> tuple[float, float]:
    """Smallest and largest principal radius of curvature of a shell, over directions [m].

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.contact.convexity import radii_range
        >>> low, high = radii_range(rr.Ellipsoid((0.2, 0.1, 0.1)))
        >>> round(low, 4), round(high, 4)  # b^2 / a and a^2 / b
        (0.05, 0.4)
    """
    if type(surface) is Ellipsoid:
        shortest, *_, longest = sorted(surface.semi_axes)
        return shortest**2 / longest, longest**2 / shortest
    spread = sphere_directions(directions)
    radii = np.array([surface.principal_radii(u) for u in spread])
    low = _polished(surface, spread[np.argmin(radii[:, 0])], 0, 1.0)[1]
    high = _polished(surface, spread[np.argmax(radii[:, 1])], 1, -1.0)[1]
    return low, high


def check_convex(surface: Surface) -> float:
    """Smallest principal radius of curvature of a shell [m], after trying its three functions.

    Over directions, the contact must be the gradient of the support function, the Hessian the
    gradient of the contact, and the Hessian positive on the tangent plane.

    Raises:
        ShellError: they do not belong together, are not finite, or the shell is not strictly
            convex; with the direction.

    Example:
        >>> import rrrobot as rr
        >>> round(rr.contact.check_convex(rr.Ellipsoid((0.2, 0.1, 0.1))), 4)
        0.05
    """
    directions = sphere_directions(_DIRECTIONS)
    try:
        for u in directions[:: _DIRECTIONS // 25]:
            _check_derivatives(surface, u)
        radii = np.array([surface.principal_radii(u)[0] for u in directions])
    except ShellError:
        raise
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        raise ShellError(
            f"{surface!r}: its functions take a direction (3,) and return arrays of numbers, "
            f"support a number, contact (3,) and hessian (3, 3); {type(error).__name__}: {error}."
        ) from error
    if not np.all(np.isfinite(radii)):
        bad = directions[~np.isfinite(radii)][0]
        raise ShellError(f"{surface!r}: hessian is not finite in the direction {_words(bad)}.")
    worst, least = _polished(surface, directions[np.argmin(radii)], 0, 1.0)
    size = float(np.mean([surface.support(u) for u in directions]))
    if least <= 1e-9 * size:
        raise ShellError(
            f"{surface!r} is not strictly convex: in the direction {_words(worst)} its smaller "
            f"principal radius of curvature is {least:.4g} m, and it must be above zero. Add a "
            "sphere to the support function, or make its odd or sharp part smaller."
        )
    return float(least)


def sphere_directions(n: int) -> Array:
    """n directions spread evenly over the sphere (n, 3)."""
    z = 1.0 - (2.0 * np.arange(n) + 1.0) / n
    turn = np.pi * (1.0 + 5.0**0.5) * np.arange(n)
    across = np.sqrt(1.0 - z * z)
    return np.column_stack((across * np.cos(turn), across * np.sin(turn), z))


def _polished(surface: Surface, u: Array, which: int, sign: float) -> tuple[Array, float]:
    """Direction and value of an extreme principal radius near u, by a shrinking compass."""
    best, size = sign * surface.principal_radii(u)[which], 0.1
    for _ in range(_POLISHINGS):
        side = np.linalg.svd(u[None])[2][1:]
        trials = [u + size * d for t in side for d in (t, -t)]
        trials = [t / np.linalg.norm(t) for t in trials]
        values = [sign * surface.principal_radii(t)[which] for t in trials]
        k = int(np.argmin(values))
        if values[k] < best:
            u, best = trials[k], values[k]
        else:
            size *= 0.5
        if size < 1e-7:
            break
    return u, float(sign * best)


def _check_derivatives(surface: Surface, u: Array) -> None:
    h, x, hessian = surface.support(u), surface.contact(u), surface.hessian(u)
    for what, value in (("support", h), ("contact", x), ("hessian", hessian)):
        if not np.all(np.isfinite(value)):
            raise ShellError(f"{surface!r}: {what} is not finite in the direction {_words(u)}.")
    steps = _STEP * np.eye(3)
    slope = [(surface.support(u + e) - surface.support(u - e)) / (2 * _STEP) for e in steps]
    bend = [(surface.contact(u + e) - surface.contact(u - e)) / (2 * _STEP) for e in steps]
    size = max(float(np.abs(hessian).max()), abs(h), float(np.abs(x).max()))
    for what, found, expected in (
        ("contact is not the gradient of support", x, np.array(slope)),
        ("hessian is not the gradient of contact", hessian, np.array(bend)),
        ("support is not of degree one", surface.support(2 * u), 2 * h),
    ):
        error = float(np.abs(np.asarray(found) - expected).max())
        if not error <= _CONSISTENT * size:
            raise ShellError(
                f"{surface!r}: {what} in the direction {_words(u)}; they differ by {error:.3g} m."
            )


def _words(u: Array) -> str:
    return str(np.round(u, 3).tolist())
