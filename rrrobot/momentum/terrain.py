"""A shell and a ground as arrays that the compiled engine can use.

Every shell and ground of the package lowers to one of a few kinds. A shell by a Python support
function becomes a polynomial of directions, a graph a quintic spline, each only if that is exact
to 3e-10 of the size; else it is refused by name.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.contact.boulder import LOWEST_NORMAL, Boulder
from rrrobot.contact.convexity import radii_range, sphere_directions
from rrrobot.contact.graph import Graph
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.shells import EllipsoidSum, FlatBelly
from rrrobot.contact.surfaces import Ellipsoid, Sphere, Surface
from rrrobot.errors import ModelError

ROUND, ELLIPSOIDS, SERIES, FLAT = 0, 1, 2, 3
"""Kinds of shells."""
LEVEL, SLOPE, BOULDER, GRAPH = 0, 1, 2, 3
"""Kinds of grounds."""
_DEGREES = (3, 4, 6, 8, 10, 12, 14, 16, 18, 20)
_EXACT = 3e-10
"""Error of a series, of the size of the shell, in its points and radii of curvature."""
_FINEST = 8


class Terrain(NamedTuple):
    """A shell on a ground, in the base's axes about its origin; lengths in metres."""

    shell: int
    """kind"""
    ground: int
    """kind"""
    center: Array
    """of the shell (3,)"""
    radius: float
    """of a round one"""
    rotation: Array
    """Q of the shell's frame (3, 3); of a flat belly"""
    terms: Array
    """of ellipsoids: A as (xx, yy, zz, xy, xz, yz) (m, 6)"""
    powers: NDArray[np.int64]
    """of a series: exponents of the monomials, those of even degree first (n, 3)"""
    weights: Array
    """of the monomials (n,)"""
    even: int
    """how many are of even degree"""
    degrees: Array
    """the even and the odd degree (2,)"""
    plane: tuple[float, ...]
    """of a plane: n, and its coordinates of the world's x and y of a vector in it (x x, x y, y x,
    y y), n_z being above zero"""
    curvature: float
    """k of a boulder [1/m]"""
    limit: float
    """largest k^2 (x^2 + y^2) of a boulder"""
    corner: Array
    """of a graph's table (2,)"""
    spacing: Array
    """(2,)"""
    table: Array
    """of a quintic spline: powers of u across each cell in y (knots in x, cells in y, 6)"""
    reach: Array
    """half of a flat belly's length and width (2,)"""


def terrain_of(shell: Surface, placement: tuple[Array, Array], ground: Ground) -> Terrain:
    """A shell at (centre, rotation) in the base, on a ground, as arrays.

    Raises:
        ModelError: the engine cannot have the ground or the shell.
    """
    center, rotation = np.array(placement[0]), np.ascontiguousarray(placement[1])
    plain = Terrain(
        ROUND, LEVEL, center, 0.0, rotation, np.zeros((0, 6)),
        np.zeros((0, 3), dtype=np.int64), np.zeros(0), 0, np.zeros(2), (0.0,) * 7, 0.0,
        1.0 - LOWEST_NORMAL**2, np.zeros(2), np.ones(2), np.zeros((6, 1, 6)), np.full(2, np.inf),
    )  # fmt: skip
    return _with_shell(_with_ground(plain, ground), shell)


def fineness(shell: Surface) -> int:
    """How many times the steps of a sphere a shell needs: by its smallest radius of curvature.

    The ratio of the largest to the smallest principal radius, rounded up, at most 8.
    """
    if type(shell) in (Sphere, FlatBelly):
        return 1
    low, high = radii_range(shell)
    return int(min(_FINEST, np.ceil(high / low - 1e-9)))


def _with_ground(terrain: Terrain, ground: Ground) -> Terrain:
    if type(ground) is Plane:
        kind = LEVEL if ground.is_level else SLOPE
        t, n = ground.basis[:, :2].T, ground.normal_vector
        flat = t[:, :2] - np.outer(t[:, 2], n[:2] / n[2])
        return terrain._replace(ground=kind, plane=(*n.tolist(), *flat.ravel().tolist()))
    if type(ground) is Boulder:
        return terrain._replace(ground=BOULDER, curvature=1.0 / ground.radius)
    if type(ground) is Graph:
        table = ground.table()
        return terrain._replace(
            ground=GRAPH, corner=table.corner, spacing=table.spacing, table=table.rows()
        )
    raise ModelError(
        f"the momentum engine does not know the ground {type(ground).__qualname__}: it computes "
        "exactly Plane, Boulder and Graph. Use method='kkt', or give it as a Graph."
    )


def _with_shell(terrain: Terrain, shell: Surface) -> Terrain:
    q = terrain.rotation
    if type(shell) is Sphere:
        return terrain._replace(shell=ROUND, radius=shell.radius)
    if type(shell) in (Ellipsoid, EllipsoidSum):
        turned = q @ np.asarray(shell.ellipsoids()) @ q.T
        rows, columns = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)
        return terrain._replace(
            shell=ELLIPSOIDS, terms=np.ascontiguousarray(turned[:, rows, columns])
        )
    if type(shell) is FlatBelly:
        reach = [np.inf if r is None else r for r in (shell.half_length, shell.half_width)]
        return terrain._replace(shell=FLAT, reach=np.array(reach))
    return _with_series(terrain, shell)


def _with_series(terrain: Terrain, shell: Surface) -> Terrain:
    """Any smooth support function, as a polynomial of the direction's entries."""
    q = terrain.rotation
    probes = sphere_directions(211)
    exact = [(q @ shell.contact(q.T @ u), q @ shell.hessian(q.T @ u) @ q.T) for u in probes]
    points, bends = np.array([e[0] for e in exact]), np.array([e[1] for e in exact])
    size, error = float(np.abs(points).max()), np.inf
    for degree in _DEGREES:
        even, odd = (degree, degree - 1) if degree % 2 == 0 else (degree - 1, degree)
        powers = np.array([*_exponents(even), *_exponents(odd)])
        directions = sphere_directions(3 * len(powers))
        values = np.array([shell.support(q.T @ u) for u in directions])
        matrix = np.prod(directions[:, None, :] ** powers, axis=2)
        weights = np.linalg.lstsq(matrix, values, rcond=1e-15)[0]
        some = np.abs(weights) > 1e-15 * np.abs(weights).max()
        found = terrain._replace(
            shell=SERIES, powers=powers[some], weights=weights[some],
            even=int(np.count_nonzero(some[: len(_exponents(even))])),
            degrees=np.array((even, odd), dtype=float),
        )  # fmt: skip
        ours = [series_at(found, u) for u in probes]
        error = max(
            float(np.abs([o[0] for o in ours] - points).max()),
            float(np.abs([o[1] for o in ours] - bends).max()),
        )
        if error <= _EXACT * size:
            return found
    raise ModelError(
        f"the momentum engine has {shell!r} as a polynomial of directions, and one of degree "
        f"{_DEGREES[-1]} is still off by {error:.2g} m. Use method='kkt', or an EllipsoidSum."
    )


def series_at(terrain: Terrain, u: Array) -> tuple[Array, Array]:
    """Gradient (3,) and Hessian (3, 3) of a series' extension of degree one at a unit vector."""
    gradient, hessian = np.zeros(3), np.zeros((3, 3))
    cut = terrain.even
    for part, degree in ((slice(0, cut), 0), (slice(cut, None), 1)):
        powers, weights = terrain.powers[part], terrain.weights[part]
        k = 1.0 - terrain.degrees[degree]
        p, g, second = _derivatives(powers, weights, u)
        gradient += g + k * p * u
        cross = np.outer(g, u)
        hessian += second + k * (cross + cross.T)
        hessian += p * (k * np.eye(3) + k * (k - 2.0) * np.outer(u, u))
    return gradient, hessian


def _derivatives(powers: NDArray[np.int64], weights: Array, u: Array) -> tuple[float, Array, Array]:
    """Value, gradient and Hessian of a sum of monomials."""

    def sums(*turns: int) -> float:
        scale, left = weights.copy(), powers.copy()
        for axis in turns:
            scale = scale * left[:, axis]
            left[:, axis] = np.maximum(left[:, axis] - 1, 0)
        return float(scale @ np.prod(u**left, axis=1))

    gradient = np.array([sums(a) for a in range(3)])
    return sums(), gradient, np.array([[sums(a, b) for a in range(3)] for b in range(3)])


def _exponents(degree: int) -> list[tuple[int, int, int]]:
    return [(a, b, degree - a - b) for a in range(degree + 1) for b in range(degree + 1 - a)]
