"""The smooth convex shell that holds an underside.

Within the cone of normals at which a belly is rolled on, u with an angle of at most `tilt` from
straight down, nothing pokes out of a shell of support function h where

    gap(u) = h(u) - h_body(u) >= 0,

h_body being that of all that is to be covered: the shell's tangent plane of normal u lies below it.
Of each form, the shell is the one of the least largest gap whose semi-axes are alike enough:
without that, a rounded box would take the body's edges, and the contact jump there.
A sphere of radius r about c has h = c.u + r, so that its best one is a linear program's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np

from rrrobot.belly.shapes import Piece, support
from rrrobot.checks import Array
from rrrobot.contact.shells import EllipsoidSum, FlatBelly
from rrrobot.contact.surfaces import Ellipsoid, Sphere, Surface
from rrrobot.errors import ShellError
from rrrobot.robot.robot import Robot

FORMS = ("sphere", "ellipsoid", "box")
LONGEST = 1.58
"""Longest over shortest semi-axis: radii of curvature then differ by a factor of four at most."""
_RINGS, _ROUND = 5, 24
_LEAST, _MOST = np.log(0.01), np.log(40.0)
"""Of a semi-axis over the body's size, its logarithm."""
_STEPS = 60


class Fit(NamedTuple):
    """A shell that holds a body within a cone of normals."""

    form: str
    """"sphere", "ellipsoid", "box", "flat" or "own" """
    shell: Surface
    center: Array
    """in the base's frame (3,) [m]"""
    error: float
    """largest gap over the cone [m]"""
    thickness: float
    """gap straight down [m]"""


def cone(tilt: float, rings: int = _RINGS, around: int = _ROUND) -> Array:
    """Directions (n, 3) of an angle of at most `tilt` [rad] from straight down, which is first."""
    angle = np.repeat(tilt * np.arange(1, rings + 1) / rings, around)
    turn = np.tile(2 * np.pi * np.arange(around) / around, rings)
    rim = np.column_stack((np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn)))
    return np.vstack(((0.0, 0.0, -1.0), np.column_stack((rim, -np.cos(angle)))))


def fit_form(
    form: str, body: Callable[[Array], Array], tilt: float, middle: Array | None = None
) -> Fit:
    """The best shell of a form.

    Args:
        form: one of `FORMS`.
        body: support function of directions (n, 3) -> (n,) [m].
        tilt: half angle of the cone [rad].
        middle: (x, y) of the centre [m]; free unless given.

    Raises:
        ShellError: no sphere was found.
    """
    directions = cone(tilt)
    height = body(directions)
    size = float(np.ptp(body(np.vstack((np.eye(3), -np.eye(3)))).reshape(2, 3).sum(axis=0)))
    center, radius = _sphere(directions, height, middle)
    if form == "sphere":
        return _measured(form, Sphere(radius), center, body, tilt)
    fits = [
        _measured(form, *found, body, tilt)
        for start in _starts(radius)
        for found in [_smooth(form, directions, height, center, start, size, middle is not None)]
    ]
    return min(fits, key=lambda fit: fit.error)


def ball_of(pieces: Sequence[Piece], tilt: float, allowed: float) -> Fit | None:
    """The ball that a base is, where nothing pokes out of one of its own by more than `allowed`."""
    directions = cone(tilt)
    height = support(pieces, directions)
    for piece in pieces:
        if len(piece.points) == 1:
            center, shell = piece.points[0], Sphere(piece.radius)
            gap = height - directions @ center - piece.radius
            if gap.max() <= allowed:
                return Fit("sphere", shell, center.copy(), float(gap.max()), 0.0)
    return None


def own_fit(robot: Robot, body: Callable[[Array], Array], tilt: float) -> Fit:
    """A robot's own shell where it is: the error counts what pokes out of it, too.

    Raises:
        ShellError: it is flat, or turned against the base.
    """
    place, shell = robot.shell_placement, robot.shell
    turned = not isinstance(shell, Sphere) and not np.allclose(place.rotation, np.eye(3))
    if turned or isinstance(shell, FlatBelly):
        what = "is turned against the base" if turned else "is flat"
        raise ShellError(
            f"the shell of {robot.name} {what}: form='own' needs a round one along the base's "
            "axes. Turn its support function instead, or fit form='flat'."
        )
    directions, center = cone(tilt, 15, 72), np.array(place.translation)
    own = np.array([shell.support(u) for u in directions])
    gap = own + directions @ center - body(directions)
    return Fit("own", shell, center, float(np.abs(gap).max()), float(gap[0]))


def _measured(
    form: str, shell: Surface, center: Array, body: Callable[[Array], Array], tilt: float
) -> Fit:
    """A fit, moved straight down until nothing pokes out between the directions either."""
    directions = cone(tilt, 15, 72)
    height = body(directions)
    own = np.array([shell.support(u) for u in directions])
    poking = (height - own - directions @ center) / -directions[:, 2]
    center = center - np.array((0.0, 0.0, float(poking.max())))
    gap = own + directions @ center - height
    return Fit(form, shell, center, float(gap.max()), float(gap[0]))


def _sphere(directions: Array, height: Array, middle: Array | None) -> tuple[Array, float]:
    """Centre and radius of the sphere of the least largest gap."""
    from scipy.optimize import linprog

    n = len(directions)
    one = np.ones((n, 1))
    # Unknowns c, r, t; 0 <= c.u + r - h <= t.
    above = np.hstack((-directions, -one, 0 * one))
    below = np.hstack((directions, one, -one))
    place = [(None, None)] * 2 if middle is None else [(x, x) for x in middle]
    found = linprog(
        (0, 0, 0, 1e-9, 1), np.vstack((above, below)), np.concatenate((-height, height)),
        bounds=[*place, (None, None), (1e-6, None), (0, None)],
    )  # fmt: skip
    if not found.success or found.x is None:
        raise ShellError(f"no sphere holds the underside: {found.message}")
    return found.x[:3], float(found.x[3])


def _starts(radius: float) -> list[Array]:
    """Semi-axes of two ellipsoids that a search begins with (2, 3)."""
    half = np.full(3, radius / 2)
    return [np.array((half, half)), np.array((half * (1.3, 1.0, 1.0), half * (1.0, 0.8, 1.0)))]


def _smooth(
    form: str,
    directions: Array,
    height: Array,
    center: Array,
    start: Array,
    size: float,
    fixed: bool,
) -> tuple[Surface, Array]:
    """An ellipsoid, or a sum of two, by linear programs within a shrinking box of steps."""
    from scipy.optimize import linprog

    terms = 2 if form == "box" else 1
    scale = max(size, 1e-3)
    problem = _Problem(directions, height / scale, terms)
    begin = start if terms == 2 else start.sum(axis=0, keepdims=True)
    x = np.concatenate((center / scale, np.log(begin / scale).ravel()))
    alike = _differences(terms)
    reach, merit = 0.5, problem.merit(x)
    for _ in range(_STEPS):
        gap, by_x = problem.gaps(x)
        one = np.ones((len(gap), 1))
        rows = np.vstack((np.hstack((-by_x, 0 * one)), np.hstack((by_x, -one)), alike))
        right = np.concatenate((gap, -gap, np.log(LONGEST) - alike[:, :-1] @ x))
        low = np.maximum(-reach, np.where(np.arange(x.size) < 3, -np.inf, _LEAST - x))
        high = np.minimum(reach, np.where(np.arange(x.size) < 3, np.inf, _MOST - x))
        if fixed:
            low[:2] = high[:2] = 0.0
        bounds = [*zip(low, high, strict=True), (None, None)]
        found = linprog((*np.zeros(x.size), 1.0), rows, right, bounds=bounds)
        new = x if found.x is None else x + found.x[:-1]
        better = problem.merit(new)
        if better < merit - 1e-7:
            x, merit, reach = new, better, min(1.5 * reach, 0.5)
        else:
            reach *= 0.4
        if reach < 1e-4:
            break
    semi = scale * problem.axes(x)
    shell = EllipsoidSum(list(semi)) if terms == 2 else Ellipsoid(tuple(semi[0]))
    return shell, scale * x[:3]


def _differences(terms: int) -> Array:
    """Rows that take the difference of two semi-axes' logarithms from all unknowns."""
    rows = []
    for term in range(terms):
        for i, j in permutations(range(3), 2):
            row = np.zeros(3 + 3 * terms + 1)
            row[3 + 3 * term + i], row[3 + 3 * term + j] = 1.0, -1.0
            rows.append(row)
    return np.array(rows)


class _Problem:
    """Gaps of sums of ellipsoids, lengths over the body's size.

    The unknowns are the centre (3) and the logarithms of the semi-axes (3 terms).
    """

    def __init__(self, directions: Array, height: Array, terms: int) -> None:
        self.directions, self.height, self.terms = directions, height, terms

    def axes(self, x: Array) -> Array:
        return np.exp(x[3:]).reshape(self.terms, 3)

    def gaps(self, x: Array) -> tuple[Array, Array]:
        """(n,), and its derivative (n, unknowns)."""
        parts = np.square(self.directions)[:, None, :] * np.square(self.axes(x))
        each = np.sqrt(parts.sum(axis=2, keepdims=True))
        gap = each.sum(axis=(1, 2)) + self.directions @ x[:3] - self.height
        by_axes = (parts / each).reshape(len(gap), -1)
        return gap, np.hstack((self.directions, by_axes))

    def merit(self, x: Array) -> float:
        """Largest gap once nothing pokes out."""
        gap = self.gaps(x)[0]
        down = float((gap / self.directions[:, 2]).max())
        return float((gap - down * self.directions[:, 2]).max())
