"""Ground that is no plane: its surface as a mesh, lines on it, and flat things laid on it.

The lines are at even coordinates (u, v) of the ground, which on a boulder or a graph are the
world's x and y.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.contact.ground import Ground
from rrrobot.view.commands import Command, attribute, material, mesh, set_mesh

_FLOOR, _GRID = (0.90, 0.91, 0.92), (0.55, 0.60, 0.66)
_PARTS = 4
"""Pieces of a line between two crossings."""
_MOST = 24
"""Lines on either side of the middle."""


def lay(ground: Ground, flat: Array) -> Array:
    """World points (n, 3) of points (u, v, lift) (n, 3): the lift along the ground's normal [m]."""
    out = np.empty((len(flat), 3))
    for i, (u, v, lift) in enumerate(flat):
        point = ground.point(np.array((u, v)))
        out[i] = point + lift * ground.normal(point)
    return out


def surface(ground: Ground, middle: Array, span: float, step: float, lift: float) -> list[Command]:
    """The ground about a place.

    Args:
        ground: any.
        middle: coordinates (2,) of the place [m].
        span: how far it is drawn to each side [m].
        step: between two lines [m].
        lift: of the lines over the surface, so that they are seen [m].
    """
    count = min(_MOST, math.ceil(span / step))
    first = np.round(middle / step)
    fine = np.arange(-count * _PARTS, count * _PARTS + 1) / _PARTS
    u, v = (step * (first[a] + fine) for a in (0, 1))
    there = np.array([[ground.leaves(np.array((a, b))) is None for b in v] for a in u])
    flat = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    points = np.full((len(flat), 3), np.nan)
    on = there.ravel()
    points[on] = lay(ground, np.column_stack((flat[on], np.zeros(on.sum()))))
    normals = np.array([ground.normal(p) if ok else p for p, ok in zip(points, on, strict=True)])
    grid = points.reshape(u.size, v.size, 3)
    corner = np.arange(u.size * v.size).reshape(u.size, v.size)
    quads = np.stack((corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]), axis=-1)
    whole = there[:-1, :-1] & there[1:, :-1] & there[1:, 1:] & there[:-1, 1:]
    quads = quads[whole]
    faces = np.concatenate((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]))
    used = np.unique(faces)
    number = np.zeros(len(points), dtype=int)
    number[used] = np.arange(used.size)
    raised = grid + lift * normals.reshape(grid.shape)
    lines = _lines(raised, there)
    pen = material(_GRID, "LineBasicMaterial")
    drawn = {"type": "BufferGeometry", "data": {"attributes": {"position": attribute(lines)}}}
    skin = material(_FLOOR, "MeshLambertMaterial", side=2)
    return [
        set_mesh("/world/ground/floor", mesh(points[used], number[faces]), skin),
        set_mesh("/world/ground/grid", drawn, pen, kind="LineSegments"),
    ]


def _lines(grid: Array, there: NDArray[np.bool_]) -> Array:
    """Ends of the pieces of all lines, two rows a piece (2 n, 3)."""
    pieces = []
    for turned in (False, True):
        points = grid.transpose(1, 0, 2) if turned else grid
        on = there.T if turned else there
        rows, seen = points[::_PARTS], on[::_PARTS]
        both = seen[:, :-1] & seen[:, 1:]
        pieces.append(np.stack((rows[:, :-1][both], rows[:, 1:][both]), axis=1).reshape(-1, 3))
    return np.concatenate(pieces)
