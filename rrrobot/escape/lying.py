"""How a robot comes to lie on the floor below its rock, and on which links.

Nobody knows the blows of a fall. What is assumed in their place:

- from where the rock lets it go the robot falls freely, turning as it did, its legs held, as if the
  rock were no longer there;
- the first blow takes all of its energy, and the floor lets nothing slip: from then on it tips
  slowly about what it stands on, downhill, until its centre of mass is over that;
- then the legs go to other postures, slowly, one after the other, and it tips on if it must.

Whether it turns on as it falls often decides what is below, so the fall without turning is looked
at too: where both end on the same links and the same way up, the assumptions matter less.

Tipping about the place of its support that is nearest to below the centre of mass is the steepest
way down of a rigid body on a floor, and ends where the next link touches: with a point of it ahead
by s and above the floor by z, after the angle atan2(z, s).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.belly.shapes import Shapes
from rrrobot.checks import Array
from rrrobot.contact.convexity import sphere_directions
from rrrobot.robot.joints import JointIndex

_BALL = 300
"""Points that stand for a ball."""
_STEP, _LONGEST = 1e-3, 3.0
"""Of the fall [s]."""
_TOUCH = 1e-6
"""Height up to which a point is on the floor, and distance that counts as none [m]."""
_MOST = 1000
"""Turns until it lies, at most."""
_SAME = 0.1
"""Difference of tilts up to which two ways to lie are one [rad]."""


class Lying(NamedTuple):
    """How a robot comes to lie on the floor."""

    ahead: float
    """base's origin from the top of the rock, to where the robot faced at rest [m]"""
    left: float
    """and to the left of that [m]"""
    heading: float
    """which way it faces, to the left of where it faced at rest [rad]"""
    tilt: float
    """angle of its z axis from the vertical [rad]; about pi/2 on its side, pi on its back"""
    first: tuple[str, ...]
    """links that it lies on with the legs as they came"""
    links: tuple[str, ...]
    """and with the legs in the last of the postures that they then go to"""
    postures: tuple[tuple[float, ...], ...]
    """these, one after the other [rad]"""
    path: tuple[tuple[float, float], ...]
    """of the base's origin, ahead and left, from where the rock let it go [m]"""


def lying_of(entry: Mapping[str, Any]) -> Lying:
    """What `_asdict` told."""
    path = tuple((float(x), float(y)) for x, y in entry["path"])
    names: dict[str, Any] = {key: tuple(entry[key]) for key in ("first", "links")}
    postures = tuple(tuple(map(float, one)) for one in entry["postures"])
    return Lying(**{**entry, **names, "path": path, "postures": postures})


class Body(NamedTuple):
    """A robot whose legs are held, in the base's frame."""

    points: Array
    """corners of its hull (n, 3) [m]"""
    links: tuple[str, ...]
    """that they are of (n,)"""
    center: Array
    """of mass (3,) [m]"""
    inertia: Array
    """about it (3, 3) [kg m^2]"""


class Pose(NamedTuple):
    """Of a base."""

    turn: Array
    """base to world (3, 3)"""
    place: Array
    """of its origin (3,) [m]"""

    def of(self, points: Array) -> Array:
        """Points of the base (n, 3) in the world [m]."""
        return np.asarray(points @ self.turn.T + self.place)

    def about(self, pivot: Array, angle: Array) -> Pose:
        """Turned about a point by a rotation vector [rad]."""
        more = pin.exp3(angle)
        return Pose(more @ self.turn, pivot + more @ (self.place - pivot))


def comes_to_lie(
    shapes: Shapes, q: Array, v: Array, floor: float, postures: Sequence[Array], gravity: float
) -> tuple[Lying, ...]:
    """How a robot comes to lie on a level floor: one way, or two if its turning decides.

    Args:
        shapes: of the robot.
        q, v: Pinocchio's configuration and velocity as the rock lets it go; the fall begins there.
        floor: height of the floor (z) [m].
        postures: that the legs go to when it lies, one after the other (legs,) [rad].
        gravity: [m/s^2].
    """
    model = shapes.robot.model
    data = model.createData()
    index = JointIndex(model, shapes.robot.legs)
    legs = index.read(q)
    pin.computeCentroidalMomentum(model, data, q, v)
    spin, speed = data.hg.angular.copy(), data.hg.linear / pin.computeTotalMass(model)
    began = Pose(pin.Quaternion(q[3:7].copy()).toRotationMatrix(), q[:3].copy())
    body, later = held(shapes, legs), [held(shapes, one) for one in postures]
    angles = tuple(tuple(map(float, one)) for one in postures)
    ways = []
    for some in (spin, 0.0 * spin):
        poses, first = tipped(body, fallen(body, began, some, speed, floor, gravity), floor)
        more, links = poses[-1:], first
        for standing in later:
            then, links = tipped(standing, more[-1], floor)
            more = more + then
        turn = more[-1].turn
        places = [(float(p.place[0]), float(p.place[1])) for p in (began, *poses, *more[1:])]
        ways.append(Lying(
            *places[-1], float(np.arctan2(turn[1, 0], turn[0, 0])),
            float(np.arccos(np.clip(turn[2, 2], -1.0, 1.0))), first, links, angles, tuple(places),
        ))  # fmt: skip
    one, other = ways
    same = one.links == other.links and abs(one.tilt - other.tilt) < _SAME
    return (one,) if same else (one, other)


def held(shapes: Shapes, leg_angle: Array) -> Body:
    """The robot with its legs held (legs,) [rad]."""
    from scipy.spatial import ConvexHull

    model = shapes.robot.model
    data, q = model.createData(), pin.neutral(model)
    JointIndex(model, shapes.robot.legs).write(q, leg_angle)
    pin.ccrba(model, data, q, np.zeros(model.nv))
    every, names = [], []
    for piece in shapes.pieces:
        place = data.oMi[piece.joint]
        points = piece.points @ place.rotation.T + place.translation
        if piece.radius:
            points = (points[:, None] + piece.radius * sphere_directions(_BALL)).reshape(-1, 3)
        every.append(points)
        names += [piece.link] * len(points)
    points = np.vstack(every)
    corners = ConvexHull(points).vertices
    return Body(
        points[corners], tuple(names[i] for i in corners), data.com[0].copy(),
        data.Ig.inertia.copy(),
    )  # fmt: skip


def fallen(
    body: Body, pose: Pose, spin: Array, speed: Array, floor: float, gravity: float
) -> Pose:  # fmt: skip
    """Where a free fall reaches the floor.

    Args:
        body: that falls.
        pose: where it begins.
        spin: angular momentum about the centre of mass, in the world's axes (3,) [kg m^2/s].
        speed: of the centre of mass (3,) [m/s].
        floor: its height [m].
        gravity: [m/s^2].
    """
    speed = np.array(speed, dtype=float)
    for _ in range(round(_LONGEST / _STEP)):
        if pose.of(body.points)[:, 2].min() <= floor:
            break
        half = pin.exp3(_STEP / 2 * _rate(body, pose.turn, spin)) @ pose.turn
        center = pose.turn @ body.center + pose.place
        turn = pin.exp3(_STEP * _rate(body, half, spin)) @ pose.turn
        center = center + _STEP * speed - np.array((0.0, 0.0, 0.5 * gravity * _STEP**2))
        speed[2] -= gravity * _STEP
        pose = Pose(turn, center - turn @ body.center)
    return pose


def _rate(body: Body, turn: Array, spin: Array) -> Array:
    return np.asarray(turn @ np.linalg.solve(body.inertia, turn.T @ spin))


def tipped(body: Body, pose: Pose, floor: float) -> tuple[list[Pose], tuple[str, ...]]:
    """Poses in which it stands on the floor, one after the other, and the links it lies on."""
    poses = []
    for _ in range(_MOST):
        low = pose.of(body.points)[:, 2].min()
        pose = pose._replace(place=pose.place + np.array((0.0, 0.0, floor - low)))
        poses.append(pose)
        points = pose.of(body.points)
        height = points[:, 2] - floor
        on = height < _TOUCH
        center = (pose.turn @ body.center + pose.place)[:2]
        pivot = nearest(points[on, :2], center)
        ahead = center - pivot
        if np.linalg.norm(ahead) < _TOUCH:
            break
        ahead = ahead / np.linalg.norm(ahead)
        angle = np.arctan2(height[~on], (points[~on, :2] - pivot) @ ahead).min()
        axis = np.array((-ahead[1], ahead[0], 0.0))
        pose = pose.about(np.append(pivot, floor), angle * axis)
    return poses, tuple(sorted({body.links[i] for i in np.flatnonzero(on)}))


def nearest(points: Array, at: Array) -> Array:
    """The place of the convex hull of points (n, 2) that is nearest to a point (2,)."""
    rays = points - at
    around = np.sort(np.arctan2(rays[:, 1], rays[:, 0]))
    if np.diff(around, append=around[0] + 2 * np.pi).max() < np.pi:
        return at
    # Outside, or on the boundary: the nearest of all segments between two of them.
    first, step = points[:, None], points[None] - points[:, None]
    length = np.maximum((step**2).sum(axis=2), 1e-30)
    share = np.clip(((at - first) * step).sum(axis=2) / length, 0.0, 1.0)
    places = (first + share[:, :, None] * step).reshape(-1, 2)
    return np.asarray(places[np.argmin(((places - at) ** 2).sum(axis=1))])
