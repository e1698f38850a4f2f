"""Pieces of a robot in its base's frame, and their distances from the ground below its belly.

Where the belly touches, X in the base's frame with its outward normal u, the ground of curvature
k (of a plane 0, of a boulder 1/R, of a bowl below zero) is away from a point p, d = p - X, by

    e / (1 + sqrt(1 + k e)),      e = k d.d - 2 u.d.

Of a plane and of a bowl, the least over a convex piece is at one of its corners; that of a boulder
is Coal's. A flat belly has the same u wherever it touches; a round one has X = x(u).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.belly.distances import coal_shape
from rrrobot.belly.shapes import Piece
from rrrobot.checks import Array
from rrrobot.contact.boulder import Boulder
from rrrobot.contact.ground import Ground
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.surfaces import Surface
from rrrobot.robot.joints import JointIndex
from rrrobot.robot.robot import Robot
from rrrobot.rotations import euler_from_rotation


class Touches(NamedTuple):
    """Places where a belly may touch the ground, and the ground there."""

    point: Array
    """X (n, 3) [m]"""
    normal: Array
    """u (n, 3), out of the belly"""
    curvature: float
    """k of the ground [1/m]"""


class Floors(NamedTuple):
    """The floor below a rock as it is in the base's frame, for each of some touches."""

    up: Array
    """the world's vertical (n, 3)"""
    height: Array
    """of the floor along it (n,) [m]"""


def placed(robot: Robot, pieces: Sequence[Piece], leg_angle: Array) -> list[Piece]:
    """The pieces with their points in the base's frame, the legs at some angles (legs,)."""
    model, data, q = robot.model, robot.model.createData(), pin.neutral(robot.model)
    JointIndex(model, robot.legs).write(q, leg_angle)
    pin.forwardKinematics(model, data, q)
    base = data.oMi[1].inverse()
    out = []
    for piece in pieces:
        at = base * data.oMi[piece.joint]
        out.append(piece._replace(points=piece.points @ at.rotation.T + at.translation))
    return out


def with_shell(robot: Robot, shell: Surface, center: Array) -> Robot:
    """The robot with a shell whose frame has the base's axes and stands at `center` in it [m]."""
    link = robot.model.frames[robot.model.getFrameId(robot.shell_link, pin.FrameType.BODY)]
    place = link.placement.inverse() * pin.SE3(np.eye(3), center)
    return Robot(
        urdf=robot.urdf,
        shell=shell,
        legs=robot.legs,
        shell_link=robot.shell_link,
        shell_center=np.array(place.translation),
        shell_rpy=np.array(euler_from_rotation(place.rotation)),
        locked=robot.locked,
        parameters=robot.parameters,
        package_dirs=robot.package_dirs,
    )


def curvature_of(ground: Ground) -> float:
    """k of a ground as it is at its origin; of a graph, that of its tangent plane."""
    return 1.0 / ground.radius if isinstance(ground, Boulder) else 0.0


def touches(shell: Surface, center: Array, ground: Ground, tilt: Array, azimuth: Array) -> Touches:
    """Where a belly touches after it has rolled by `tilt` towards `azimuth` from straight down.

    Args:
        shell: without rotation in the base.
        center: of the shell, in the base's frame (3,) [m].
        ground: what it rolls on.
        tilt: (n,) [rad]; on a flat belly, over the ground's curvature, the place of the contact.
        azimuth: (n,) [rad], from the base's x axis to its y axis.
    """
    k = curvature_of(ground)
    across = np.column_stack((np.cos(azimuth), np.sin(azimuth)))
    if isinstance(shell, FlatBelly):
        place = np.column_stack((across * tilt[:, None] / k, np.zeros(len(tilt))))
        return Touches(center + place, np.tile((0.0, 0.0, -1.0), (len(tilt), 1)), k)
    normal = np.column_stack((across * np.sin(tilt)[:, None], -np.cos(tilt)))
    return Touches(center + np.array([shell.contact(u) for u in normal]), normal, k)


def floors(at: Touches, depth: float, azimuth: Array) -> Floors:
    """The floor that is `depth` below the top of a boulder [m].

    Rolling to where it touches, by an arc s of the boulder, the base leans by s / R and by the
    angle of the normal there from straight down; the arc is taken as long as its chord.

    Args:
        at: touches on a boulder; the first is that at rest, straight below.
        depth: of the floor below the boulder's top [m].
        azimuth: to which it leans at each (n,) [rad].
    """
    radius = 1.0 / at.curvature
    lean = np.arccos(np.clip(-at.normal[:, 2], -1.0, 1.0))
    lean = lean + np.linalg.norm(at.point - at.point[0], axis=1) / radius
    across = -np.sin(lean)[:, None] * np.column_stack((np.cos(azimuth), np.sin(azimuth)))
    up = np.column_stack((across, np.cos(lean)))
    center = at.point + radius * at.normal
    return Floors(up, np.sum(up * center, axis=1) + radius - depth)


class Gauge:
    """Distances of pieces, in the base's frame, from the ground that a belly touches.

    Args:
        pieces: see `placed`.
        curvature: of the ground [1/m].
    """

    def __init__(self, pieces: Sequence[Piece], curvature: float) -> None:
        self.pieces, self.curvature = pieces, curvature
        if curvature > 0:
            import coal

            self._ball = coal.Sphere(1.0 / curvature)
            self._request, self._result = coal.DistanceRequest(), coal.DistanceResult()
            self._shapes = []
            for piece in pieces:
                shape, place = coal_shape(piece)
                at = coal.Transform3s(place.rotation, place.translation)
                middle = piece.points.mean(axis=0)
                reach = float(np.linalg.norm(piece.points - middle, axis=1).max()) + piece.radius
                self._shapes.append((shape, at, middle, reach))

    def __call__(self, at: Touches) -> Array:
        """(n, pieces) [m]; of a piece far from a boulder, less: that of the ball around it."""
        if self.curvature > 0:
            return self._from_boulder(at)
        each = [_at_points(p.points, at).min(axis=1) - p.radius for p in self.pieces]
        return np.column_stack(each)

    def _from_boulder(self, at: Touches) -> Array:
        import coal

        radius = 1.0 / self.curvature
        out = np.empty((len(at.point), len(self.pieces)))
        centers = at.point + radius * at.normal
        places = [coal.Transform3s(np.eye(3), center) for center in centers]
        for j, (shape, here, middle, reach) in enumerate(self._shapes):
            out[:, j] = np.linalg.norm(centers - middle, axis=1) - radius - reach
            for i in np.flatnonzero(out[:, j] < 0.1 * reach):
                self._result.clear()
                out[i, j] = coal.distance(
                    shape, here, self._ball, places[i], self._request, self._result
                )
        return out


def _at_points(points: Array, at: Touches) -> Array:
    """Distance of points (m, 3) from the ground (n, m) [m]."""
    along = at.normal @ points.T - np.sum(at.normal * at.point, axis=1)[:, None]
    if at.curvature == 0:
        return -along
    d = points - at.point[:, None, :]
    excess = at.curvature * np.sum(d * d, axis=2) - 2 * along
    return np.asarray(excess / (1 + np.sqrt(np.maximum(1 + at.curvature * excess, 0.0))))
