"""The underside of a base: its pieces, the motors beside it, and its flat face."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.belly.distances import leg_ranges
from rrrobot.belly.placed import placed
from rrrobot.belly.shapes import Piece, Shapes, support
from rrrobot.checks import Array
from rrrobot.errors import ShellError

_FLAT = 2e-3
"""Height over the lowest point up to which the underside counts as on one level [m]."""
_HOUSING = 0.35
"""Reach from its joint's axis, over that of the whole limb, up to which a link is a housing."""
_SWING = 0.3
"""Angle to either side by which a housing is turned to cover it [rad]."""
_POKES = 5e-4


class Face(NamedTuple):
    """The flat part of an underside: what of it lies on a level floor."""

    corners: Array
    """of its convex hull, in turn (n, 2) [m], in the base's frame"""
    height: float
    """z in the base's frame [m]"""


class Underside(NamedTuple):
    """What a shell has to hold."""

    base: list[Piece]
    """of the base itself, in its frame"""
    covered: list[Piece]
    """of motors and hips that would touch before it, in the base's frame"""
    width: float
    """smaller of the base's lengths along x and y [m]"""

    def support(self, directions: Array) -> Array:
        """h (n,) [m] of all of it."""
        return support([*self.base, *self.covered], directions)

    @property
    def links(self) -> tuple[str, ...]:
        """Links beside the base that are to be covered."""
        return tuple(dict.fromkeys(piece.link for piece in self.covered))


def underside(shapes: Shapes, leg_angle: Array, directions: Array) -> Underside:
    """The underside of a robot.

    Args:
        shapes: of the robot.
        leg_angle: posture (legs,) [rad].
        directions: normals at which the belly is to be rolled on (n, 3).

    Raises:
        ShellError: the base has no shape at all, or none with a width.
    """
    robot = shapes.robot
    base = shapes.on_joint(1)
    if not base:
        why = "Add a <collision> to its URDF."
        if shapes.missing:
            why = (
                f"Meshes that cannot be read: {'; '.join(shapes.missing)}. Say with package_dirs= "
                "where they lie."
            )
        raise ShellError(
            f"the base of {robot.name} has no collision or visual shape to fit a belly to. {why}"
        )
    axes = np.vstack((np.eye(3), -np.eye(3)))
    length = support(base, axes).reshape(2, 3).sum(axis=0)
    width = float(length[:2].min())
    if width < _FLAT:
        raise ShellError(
            f"the base of {robot.name} is {1e3 * width:.3g} mm wide: no belly fits an underside "
            "that is no more than a line. Give it a collision or visual shape of its size, or a "
            "shell of your own."
        )
    height, covered = support(base, directions), []
    low, high = leg_ranges(robot)
    for joint in range(2, robot.model.njoints):
        name = robot.model.names[joint]
        own = shapes.on_joint(joint)
        if robot.model.parents[joint] != 1 or name not in robot.legs or not own:
            continue
        if _reach(robot.model, joint, own) > _HOUSING * _limb_reach(shapes, joint):
            continue
        leg = robot.legs.index(name)
        swung: list[Piece] = []
        for turn in (-_SWING, 0.0, _SWING):
            angle = np.array(leg_angle, dtype=float)
            angle[leg] = np.clip(angle[leg] + turn, low[leg], high[leg])
            swung += placed(robot, own, angle)
        if np.any(support(swung, directions) > height + _POKES):
            covered += swung
    return Underside(base, covered, width)


def _reach(model: pin.Model, joint: int, pieces: list[Piece]) -> float:
    """Distance of the farthest point of a body from its joint's axis [m]."""
    axis = np.asarray(model.createData().joints[joint].S).reshape(6)[3:]
    farthest = 0.0
    for piece in pieces:
        across = piece.points - np.outer(piece.points @ axis, axis)
        farthest = max(farthest, float(np.linalg.norm(across, axis=1).max()) + piece.radius)
    return farthest


def _limb_reach(shapes: Shapes, joint: int) -> float:
    """Distance of a limb's farthest point from its first joint [m], all joints at zero."""
    model, robot = shapes.robot.model, shapes.robot
    limb = [int(k) for k in model.subtrees[joint]]
    pieces = [piece for piece in shapes.pieces if piece.joint in limb]
    start = model.jointPlacements[joint].translation
    return max(
        float(np.linalg.norm(piece.points - start, axis=1).max()) + piece.radius
        for piece in placed(robot, pieces, np.zeros(robot.n_legs))
    )


def flat_face(base: list[Piece]) -> Face | None:
    """The face on which a base stands on a level floor; None of one that rests on less."""
    from scipy.spatial import ConvexHull, QhullError

    low = float(-support(base, np.array(((0.0, 0.0, -1.0),)))[0])
    points = [p.points[p.points[:, 2] - p.radius < low + _FLAT, :2] for p in base]
    try:
        found = np.vstack(points)
        hull = ConvexHull(found)
    except (QhullError, ValueError):
        return None
    return Face(found[hull.vertices], low)


def rectangle(face: Face, middle: Array) -> tuple[float, float] | None:
    """Half length and half width of the largest rectangle about a place within a face.

    None where the place is not on the face.
    """
    edges = np.roll(face.corners, -1, axis=0) - face.corners
    outward = np.column_stack((edges[:, 1], -edges[:, 0]))
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-300)
    room = np.sum(outward * (face.corners - middle), axis=1)
    if room.min() <= 0:
        return None
    best = (0.0, 0.0, 0.0)
    for angle in np.linspace(0.02, np.pi / 2 - 0.02, 90):
        c, s = float(np.cos(angle)), float(np.sin(angle))
        size = float((room / (np.abs(outward[:, 0]) * c + np.abs(outward[:, 1]) * s)).min())
        best = max(best, (size * size * c * s, size * c, size * s))
    return best[1], best[2]
