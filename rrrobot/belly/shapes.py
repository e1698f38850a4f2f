"""What a robot is made of, as convex pieces on its joints: for distances, clearances and bellies.

A piece is the convex hull of points, made thicker by a radius: a ball is one point, a capsule two,
a box eight, a cylinder 2 x 32 around it, a mesh the hull of its vertices. Its support function is

    h(u) = max of u . p over the points + radius

and Coal takes the same points for distances between two of them. Hulls are on the safe side.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.errors import ParameterError
from rrrobot.robot.meshes import Mesh, MeshError, find_mesh, numbers, origin_of, read_meshes, short
from rrrobot.robot.reader import parse_urdf
from rrrobot.robot.robot import Robot

KINDS = ("collision", "visual")
_SIDES = 32


class Piece(NamedTuple):
    """A convex part of a link."""

    link: str
    joint: int
    """that carries it, in the robot's Pinocchio model; 1 is the base"""
    points: Array
    """in the joint's frame (n, 3) [m]"""
    radius: float
    """by which the hull of the points is thicker [m]"""


@dataclass(frozen=True, eq=False)
class Shapes:
    """The pieces of a robot.

    Attributes:
        robot: whose they are.
        pieces: in the order of the URDF's links.
        missing: meshes that could not be read, and why; what of a link is left stands in for it.

    Example:
        >>> import rrrobot as rr
        >>> shapes = rr.belly.Shapes.of(rr.Robot.from_parameters())
        >>> shapes.links
        ('shell', 'battery', 'servo_1', 'leg_1_link', 'servo_2', 'leg_2_link')
    """

    robot: Robot
    pieces: tuple[Piece, ...]
    missing: tuple[str, ...] = ()

    @classmethod
    def of(cls, robot: Robot, geometry: str = "collision") -> Shapes:
        """Read them.

        Args:
            robot: any.
            geometry: "collision" or "visual": which shapes of a link count; of a link that has
                none of that kind, those of the other.

        Raises:
            ParameterError: another kind.
            UrdfError: a shape has numbers that are none.
        """
        if geometry not in KINDS:
            raise ParameterError(f"geometry is {geometry!r}: it must be one of {', '.join(KINDS)}.")
        other = KINDS[geometry == KINDS[0]]
        found: list[tuple[str, pin.Frame, Element, Any]] = []
        for link in parse_urdf(robot.urdf).findall("link"):
            name = str(link.get("name"))
            frame = robot.model.frames[robot.model.getFrameId(name, pin.FrameType.BODY)]
            elements = link.findall(geometry) or link.findall(other)
            for element in elements:
                for shape in element.findall("geometry/*"):
                    found.append((name, frame, element, shape))
        meshes, missing = _meshes([shape for *_, shape in found], robot.package_dirs)
        pieces = []
        for name, frame, element, shape in found:
            made = _points(shape, meshes)
            if made is not None:
                place = frame.placement * origin_of(element)
                points = made[0] @ place.rotation.T + place.translation
                pieces.append(Piece(name, int(frame.parentJoint), points, made[1]))
        return cls(robot, tuple(pieces), tuple(missing))

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links that have pieces, each once."""
        return tuple(dict.fromkeys(piece.link for piece in self.pieces))

    def on_joint(self, joint: int) -> list[Piece]:
        """Pieces that a joint carries; 1 is the base."""
        return [piece for piece in self.pieces if piece.joint == joint]

    @cached_property
    def capsules(self) -> list[tuple[int, Array, Array, float]]:
        """A capsule around each piece: joint, the two ends (3,) in its frame and the radius [m]."""
        return [(p.joint, *_capsule(p.points, p.radius)) for p in self.pieces]

    @cached_property
    def pairs(self) -> list[tuple[int, int]]:
        """Pairs of pieces whose distance counts.

        Left out are pieces on one joint or on neighbouring ones, and pairs that touch in nearly
        all postures within the joints' limits, as housings do.
        """
        from rrrobot.belly.distances import always_touching

        parents = self.robot.model.parents
        some = [
            (i, j)
            for i, j in combinations(range(len(self.pieces)), 2)
            if (a := self.pieces[i].joint) != (b := self.pieces[j].joint)
            and parents[a] != b
            and parents[b] != a
        ]
        touching = always_touching(self.robot, self.pieces, some)
        return [pair for pair in some if pair not in touching]

    def on(self, robot: Robot) -> Shapes:
        """The pieces on the joints of a robot of the same URDF, some of whose joints are held.

        Pairs that no longer move against each other do not count.
        """
        before, after, moved = self.robot.model, robot.model, []
        for piece in self.pieces:
            was, now = (
                model.frames[model.getFrameId(piece.link, pin.FrameType.BODY)]
                for model in (before, after)
            )
            move = now.placement * was.placement.inverse()
            points = piece.points @ move.rotation.T + move.translation
            moved.append(piece._replace(joint=int(now.parentJoint), points=points))
        made = Shapes(robot, tuple(moved), self.missing)
        made.__dict__["pairs"] = [(i, j) for i, j in self.pairs if moved[i].joint != moved[j].joint]
        return made

    @cached_property
    def geometry(self) -> pin.GeometryModel:
        """Pinocchio's geometry of the pieces, with `pairs` as its pairs."""
        from rrrobot.belly.distances import geometry_model

        return geometry_model(self.pieces, self.pairs)

    def __reduce__(self) -> Any:
        return type(self), (self.robot, self.pieces, self.missing)


def support(pieces: Sequence[Piece], directions: Array) -> Array:
    """h (n,) [m] of the hull of pieces in directions (n, 3), in the frame of their joint."""
    return np.max([(directions @ p.points.T).max(axis=1) + p.radius for p in pieces], axis=0)


def _meshes(shapes: Sequence[Element], folders: Sequence[str]) -> tuple[dict[str, Mesh], list[str]]:
    """Meshes by the element's key, each file read once; and what is missing."""
    wanted, missing = {}, {}
    for shape in shapes:
        if shape.tag != "mesh" or _key(shape) in wanted:
            continue
        scale = numbers(shape, "scale", 3) if shape.get("scale") else [1.0] * 3
        name = shape.get("filename", "")
        try:
            wanted[_key(shape)] = find_mesh(name, folders), scale
        except MeshError as error:
            missing[_key(shape)] = str(error)
    found = {}
    for key, read in zip(wanted, read_meshes(list(wanted.values())), strict=True):
        if isinstance(read, MeshError):
            why = " ".join(str(read).split())
            missing[key] = f"{short(key.partition(' ')[2])} cannot be read ({why})"
        else:
            found[key] = read
    return found, list(missing.values())


def _key(shape: Element) -> str:
    return f"{shape.get('scale', '1 1 1').replace(' ', ',')} {shape.get('filename', '')}"


def _points(shape: Element, meshes: dict[str, Mesh]) -> tuple[Array, float] | None:
    """Points in the shape's own frame, and the radius around them; None for what is no shape."""
    if shape.tag == "mesh":
        return (_hull(meshes[_key(shape)][0]), 0.0) if _key(shape) in meshes else None
    if shape.tag == "box":
        half = np.array(numbers(shape, "size", 3)) / 2
        return half * np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T, 0.0
    if shape.tag not in ("sphere", "cylinder", "capsule"):
        return None
    (r,) = numbers(shape, "radius", 1)
    if shape.tag == "sphere":
        return np.zeros((1, 3)), r
    (length,) = numbers(shape, "length", 1)
    ends = np.array(((0.0, 0.0, -length / 2), (0.0, 0.0, length / 2)))
    if shape.tag == "capsule":
        return ends, r
    turn = 2 * math.pi * np.arange(_SIDES) / _SIDES
    around = r / math.cos(math.pi / _SIDES)
    ring = np.column_stack((around * np.cos(turn), around * np.sin(turn), 0 * turn))
    return np.vstack([ring + end for end in ends]), 0.0


def _hull(points: Array) -> Array:
    """Corners of the convex hull of points (n, 3); of flat ones, all different points."""
    from scipy.spatial import ConvexHull, QhullError

    points = np.unique(points, axis=0)
    try:
        return points[np.sort(ConvexHull(points).vertices)]
    except (QhullError, ValueError):
        return points


def _capsule(points: Array, radius: float) -> tuple[Array, Array, float]:
    """A capsule around points along their longest axis: its ends (3,), its radius."""
    if len(points) == 1:
        return points[0], points[0], radius
    middle = (points.max(axis=0) + points.min(axis=0)) / 2
    best = None
    for axis in np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]:
        along = (points - middle) @ axis
        across = (points - middle) - np.outer(along, axis)
        shift = (across.max(axis=0) + across.min(axis=0)) / 2
        across = across - (shift - (shift @ axis) * axis)
        r = float(np.linalg.norm(across, axis=1).max())
        cap = np.sqrt(np.maximum(r**2 - np.sum(across**2, axis=1), 0.0))
        low, high = float((along + cap).min()), float((along - cap).max())
        low, high = min(low, high), max(low, high)
        volume = math.pi * r**2 * (high - low + 4 / 3 * r)
        if best is None or volume < best[0]:
            foot = middle + shift - (shift @ axis) * axis
            best = volume, foot + low * axis, foot + high * axis, r + radius
    assert best is not None
    return best[1:]
