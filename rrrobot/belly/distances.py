"""Distances between convex pieces by Coal, which comes with Pinocchio."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.robot.joints import JointIndex
from rrrobot.robot.robot import Robot

if TYPE_CHECKING:
    from rrrobot.belly.shapes import Piece

_POSTURES = 200
_NEARLY_ALL = 0.95
"""Part of the postures in which a pair touches that is built to touch."""


def coal_shape(piece: Piece) -> tuple[Any, pin.SE3]:
    """Coal's geometry of a piece, and its placement in the joint's frame."""
    import coal

    points = piece.points
    if len(points) == 1:
        return coal.Sphere(piece.radius), pin.SE3(np.eye(3), points[0])
    if len(points) == 2:
        length = float(np.linalg.norm(points[1] - points[0]))
        axis = (points[1] - points[0]) / length if length else np.array((0.0, 0.0, 1.0))
        turn = pin.Quaternion.FromTwoVectors(np.array((0.0, 0.0, 1.0)), axis).toRotationMatrix()
        return coal.Capsule(piece.radius, length), pin.SE3(turn, points.mean(axis=0))
    vertices, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    # About the middle, where Coal's numbers are best.
    middle = points.mean(axis=0)
    vertices.extend(list(points - middle))
    for a, b, c in _faces(points):
        triangles.append(coal.Triangle(int(a), int(b), int(c)))
    shape = coal.Convex(vertices, triangles)
    if piece.radius:
        shape.setSweptSphereRadius(piece.radius)
    return shape, pin.SE3(np.eye(3), middle)


def _faces(points: Array) -> NDArray[Any]:
    """Outward triangles of the hull of points that are its corners; of flat ones, any."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return np.array([(0, i, i + 1) for i in range(1, len(points) - 1)])
    a, b, c = points[hull.simplices].transpose(1, 0, 2)
    inward = np.sum(np.cross(b - a, c - a) * hull.equations[:, :3], axis=1) < 0
    faces = hull.simplices.copy()
    faces[inward] = faces[inward][:, ::-1]
    return faces


def geometry_model(pieces: Sequence[Piece], pairs: Sequence[tuple[int, int]]) -> pin.GeometryModel:
    """Pinocchio's geometry of pieces, with the pairs whose distances are asked for."""
    geometry = pin.GeometryModel()
    for i, piece in enumerate(pieces):
        shape, place = coal_shape(piece)
        geometry.addGeometryObject(
            pin.GeometryObject(f"{i} {piece.link}", piece.joint, place, shape)
        )
    for i, j in pairs:
        geometry.addCollisionPair(pin.CollisionPair(i, j))
    return geometry


def always_touching(
    robot: Robot, pieces: Sequence[Piece], pairs: Sequence[tuple[int, int]]
) -> set[tuple[int, int]]:
    """The pairs that touch in nearly all postures within the limits (of turns, half a turn)."""
    model = robot.model
    geometry = geometry_model(pieces, pairs)
    data, apart = model.createData(), geometry.createData()
    index, q = JointIndex(model, robot.legs), pin.neutral(model)
    low, high = leg_ranges(robot)
    count = np.zeros(len(pairs))
    for angles in np.random.default_rng(0).uniform(low, high, (_POSTURES, robot.n_legs)):
        index.write(q, angles)
        pin.computeCollisions(model, data, geometry, apart, q, False)
        count += [result.isCollision() for result in apart.collisionResults]
    often = count >= _NEARLY_ALL * _POSTURES
    return {pair for pair, always in zip(pairs, often, strict=True) if always}


def leg_ranges(robot: Robot) -> tuple[Array, Array]:
    """Least and greatest leg positions (legs,): the file's limits, or half a turn either way."""
    joints = robot.joints
    return np.maximum(joints.lower, -np.pi), np.minimum(joints.upper, np.pi)
