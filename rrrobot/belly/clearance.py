"""Distances of a robot's pieces from the ground and from each other, along many configurations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.belly.placed import Gauge, Touches, curvature_of
from rrrobot.belly.shapes import Piece, Shapes
from rrrobot.checks import Array
from rrrobot.contact.boulder import Boulder
from rrrobot.contact.ground import Ground, Plane

_INEXACT = 1e-5
"""Error of Coal's distances [m]; it stops at 1e-6."""
_LOWEST = 24
"""Corners of a piece whose distance from uneven ground is asked for: those lowest along z."""


class Clearances(NamedTuple):
    """What `clearances` finds for n configurations."""

    ground: Array
    """least distance of each link from the ground (n, links) [m]; far from a boulder, a bound"""
    links: tuple[str, ...]
    """names of its columns"""
    between: Array
    """least distance of two links that count (n,) [m]; infinite where none do"""
    pair: NDArray[np.int64]
    """which of `shapes.pairs` that is (n,)"""


def gauges(shapes: Shapes, ground: Ground) -> list[Gauge]:
    """One for each piece, for those who ask `clearances` again and again."""
    return [Gauge([piece], curvature_of(ground)) for piece in shapes.pieces]


def clearances(
    shapes: Shapes, configurations: Array, ground: Ground, *, known: Sequence[Gauge] | None = None
) -> Clearances:
    """Distances from the ground and between links.

    Args:
        shapes: of the robot.
        configurations: Pinocchio's q (n, nq), such as `trajectory.configuration`.
        ground: that the robot is on; it may touch anywhere.
        known: `gauges` of the shapes and the ground; made unless given.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> t = rr.simulate(rr.FullModel(robot), rr.gait("lateral"), duration=1.0)
        >>> found = rr.belly.clearances(rr.belly.Shapes.of(robot), t.configuration, t.ground)
        >>> bool(found.ground[:, found.links.index("leg_1_link")].min() > 0)
        True
    """
    model, data = shapes.robot.model, shapes.robot.model.createData()
    n = len(configurations)
    rotation, place = np.empty((model.njoints, n, 3, 3)), np.empty((model.njoints, n, 3))
    for k, q in enumerate(configurations):
        pin.forwardKinematics(model, data, q)
        for joint in range(1, model.njoints):
            rotation[joint, k], place[joint, k] = (
                data.oMi[joint].rotation,
                data.oMi[joint].translation,
            )
    links = shapes.links
    height = np.full((n, len(links)), np.inf)
    even = isinstance(ground, Plane | Boulder)
    if even and known is None:
        known = gauges(shapes, ground)
    for k, piece in enumerate(shapes.pieces):
        i, turn, at = links.index(piece.link), rotation[piece.joint], place[piece.joint]
        if even and known is not None:
            own = _from_ground(known[k], ground, turn, at)
        else:
            own = _from_uneven(piece, ground, turn, at)
        height[:, i] = np.minimum(height[:, i], own)
    return Clearances(height, links, *_between(shapes, configurations, rotation, place))


def _between(
    shapes: Shapes, configurations: Array, rotation: Array, place: Array
) -> tuple[Array, NDArray[np.int64]]:
    """Least distance of the pairs (n,) and which that is (n,), the joints at these placements.

    Coal is asked only of pairs that may be the nearest: from one configuration to the next, no
    distance shrinks by more than what the points of both pieces travel as seen from the base.
    """
    n, pairs = len(configurations), len(shapes.pairs)
    least, nearest = np.full(n, np.inf), np.zeros(n, dtype=np.int64)
    if not pairs:
        return least, nearest
    model, geometry = shapes.robot.model, shapes.geometry
    data, apart = model.createData(), geometry.createData()
    travel = _travel(shapes.pieces, rotation, place)
    one, other = np.array(shapes.pairs).T
    known, best = np.full(pairs, -np.inf), 0
    for k, q in enumerate(configurations):
        pin.updateGeometryPlacements(model, data, geometry, apart, q)
        moved = travel[k, one] + travel[k, other]
        least[k] = pin.computeDistance(geometry, apart, best).min_distance
        for i in np.flatnonzero(known - moved < least[k] + _INEXACT).tolist():
            found = pin.computeDistance(geometry, apart, i).min_distance
            known[i] = found + moved[i]
            if found < least[k]:
                least[k], best = found, i
        nearest[k] = best
    return least, nearest


def _travel(pieces: Sequence[Piece], rotation: Array, place: Array) -> Array:
    """How far, at most, a point of each piece has gone by each configuration (n, pieces) [m].

    As seen from the base: the way of the middle, and of the farthest point around it.
    """
    base = np.swapaxes(rotation[1], -1, -2)
    out = np.zeros((len(base), len(pieces)))
    for i, piece in enumerate(pieces):
        middle = (piece.points.max(axis=0) + piece.points.min(axis=0)) / 2
        reach = np.linalg.norm(piece.points - middle, axis=1).max() + piece.radius
        turn = base @ rotation[piece.joint]
        at = np.einsum("nij,nj->ni", base, place[piece.joint] - place[1]) + turn @ middle
        # A rotation by a moves what is r away by 2 r sin(a/2), and |R - 1| is 2 sqrt(2) sin(a/2).
        turned = np.linalg.norm(np.diff(turn, axis=0), axis=(1, 2)) / np.sqrt(2.0)
        way = np.linalg.norm(np.diff(at, axis=0), axis=1) + reach * turned
        out[1:, i] = np.cumsum(way)
    return out


def _from_ground(gauge: Gauge, ground: Ground, rotation: Array, place: Array) -> Array:
    """Distance of a piece from the ground (n,) [m], its joint at placements (n, 3, 3), (n, 3)."""
    # The ground in the joint's frame, where the piece stays.
    normal = ground.normal(np.zeros(3))
    point = -np.einsum("nij,ni->nj", rotation, place)
    outward = np.einsum("nij,i->nj", rotation, -normal)
    return gauge(Touches(point, outward, gauge.curvature))[:, 0]


def _from_uneven(piece: Piece, ground: Ground, rotation: Array, place: Array) -> Array:
    points = piece.points @ np.swapaxes(rotation, 1, 2) + place[:, None, :]
    order = np.argsort(points[:, :, 2], axis=1)[:, :_LOWEST, None]
    lowest = np.take_along_axis(points, order, axis=1)
    found = ground.distances(lowest.reshape(-1, 3)).reshape(lowest.shape[:2])
    return np.asarray(found.min(axis=1) - piece.radius)
