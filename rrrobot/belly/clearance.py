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
    between, pair = np.full(n, np.inf), np.zeros(n, dtype=np.int64)
    rotation, place = np.empty((model.njoints, n, 3, 3)), np.empty((model.njoints, n, 3))
    apart = shapes.geometry.createData()
    for k, q in enumerate(configurations):
        if shapes.pairs:
            pin.computeDistances(model, data, shapes.geometry, apart, q)
            found = [result.min_distance for result in apart.distanceResults]
            pair[k] = int(np.argmin(found))
            between[k] = found[pair[k]]
        else:
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
    return Clearances(height, links, between, pair)


def _from_ground(gauge: Gauge, ground: Ground, rotation: Array, place: Array) -> Array:
    """Distance of a piece from the ground (n,) [m], its joint at placements (n, 3, 3), (n, 3)."""
    # The ground in the joint's frame, where the piece stays.
    normal = ground.normal(np.zeros(3))
    point = -np.einsum("nij,ni->nj", rotation, place)
    outward = np.einsum("nij,i->nj", rotation, -normal)
    return gauge(Touches(point, outward, gauge.curvature))[:, 0]


def _from_uneven(piece: Piece, ground: Ground, rotation: Array, place: Array) -> Array:
    out = np.empty(len(place))
    for k, (turn, at) in enumerate(zip(rotation, place, strict=True)):
        points = piece.points @ turn.T + at
        lowest = points[np.argsort(points[:, 2])[:_LOWEST]]
        out[k] = min(ground.distance(p) for p in lowest) - piece.radius
    return out
