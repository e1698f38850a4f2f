"""A machine as a tree of links and joints: Pinocchio model and URDF from one description."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.contact.surfaces import Surface
from rrrobot.errors import ModelError, ParameterError
from rrrobot.machines.looks import Look

Root = Literal["planar", "free"]
ROOT = "root_joint"
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def flat(about_z: float) -> Array:
    """Inertia (3, 3) of a plate of which only the moment about z counts [kg m^2]."""
    return np.diag((about_z / 2, about_z / 2, about_z))


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid body: mass [kg], its centre in the link's frame (3,) [m], and the inertia about that
    centre (3, 3), its diagonal (3,) or one number for all axes [kg m^2]; and how it looks."""

    name: str
    mass: float = 0.0
    inertia: ArrayLike = 0.0
    centre: ArrayLike = (0.0, 0.0, 0.0)
    looks: tuple[Look, ...] = ()

    def __post_init__(self) -> None:
        finite(f"mass of {self.name}", self.mass, "kg", at_least=0)
        vector(f"mass centre of {self.name}", self.centre, 3, "m")
        about = self.about_centre
        if not np.all(np.isfinite(about)) or np.linalg.eigvalsh(about)[0] < -1e-12:
            raise ParameterError(
                f"the {self.name} has the inertia {np.diag(about).tolist()} kg m^2 about its "
                "centre: no moment may be below zero. Is a composite inertia below its parts?"
            )

    @property
    def about_centre(self) -> Array:
        """Inertia about the mass centre (3, 3) [kg m^2]."""
        given = np.asarray(self.inertia, dtype=float)
        return given if given.ndim == 2 else np.diag(np.broadcast_to(given, 3))

    @property
    def pinocchio(self) -> pin.Inertia:
        """The same for Pinocchio."""
        return pin.Inertia(
            float(self.mass), np.array(self.centre, dtype=float), np.array(self.about_centre)
        )


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint at a point of its parent, about or along x, y or z of both links, or spherical."""

    name: str
    parent: str
    child: Link
    at: ArrayLike = (0.0, 0.0, 0.0)
    axis: Literal["x", "y", "z", "-x", "-y", "-z"] = "z"
    kind: Literal["turn", "slide", "ball"] = "turn"

    @property
    def direction(self) -> Array:
        """Unit axis (3,)."""
        sign = -1.0 if self.axis[0] == "-" else 1.0
        return sign * np.array(_AXES[self.axis[-1]])

    @property
    def pinocchio(self) -> Any:
        """The same for Pinocchio, with one coordinate each, or a quaternion."""
        if self.kind == "ball":
            return pin.JointModelSpherical()
        if self.kind == "slide":
            return pin.JointModelPrismaticUnaligned(self.direction)
        return pin.JointModelRevoluteUnaligned(self.direction)


class Tree:
    """Links on joints, from a base that moves in the plane or in space.

    Args:
        base: the first link.
        joints: each after its parent; the order is that of the coordinates.
        root: "planar" or "free".
        frames: (name, link, position) of points that constraints need.
        height: of a planar base's origin over the ground, where it is drawn [m].
        skin: a surface about the base's origin that is drawn where no contact has one.

    Example:
        >>> from rrrobot.machines.tree import Joint, Link, Tree, flat
        >>> tree = Tree(Link("board", 2.0, flat(0.1)), [Joint("rotor", "board", Link("wheel",
        ...             0.1, flat(0.01)))], root="planar")
        >>> tree.model().nv, "continuous" in tree.urdf("sled")
        (4, True)
    """

    def __init__(
        self,
        base: Link,
        joints: Sequence[Joint] = (),
        *,
        root: Root = "free",
        frames: Sequence[tuple[str, str, ArrayLike]] = (),
        height: float = 0.0,
        skin: Surface | None = None,
    ) -> None:
        self.height, self.skin = height, skin
        self.base, self.joints, self.root, self.frames = base, tuple(joints), root, tuple(frames)

    def model(self, gravity: float = 9.81) -> pin.Model:
        """The Pinocchio model; links are frames of their names."""
        model = pin.Model()
        model.gravity.linear = np.array((0.0, 0.0, -gravity))
        root = pin.JointModelPlanar() if self.root == "planar" else pin.JointModelFreeFlyer()
        ids = {self.base.name: model.addJoint(0, root, pin.SE3.Identity(), ROOT)}
        model.appendBodyToJoint(1, self.base.pinocchio, pin.SE3.Identity())
        for joint in self.joints:
            place = pin.SE3(np.eye(3), np.array(joint.at, dtype=float))
            ids[joint.child.name] = at = model.addJoint(
                ids[joint.parent], joint.pinocchio, place, joint.name
            )
            model.appendBodyToJoint(at, joint.child.pinocchio, pin.SE3.Identity())
        for name, at in ids.items():
            model.addFrame(pin.Frame(name, at, pin.SE3.Identity(), pin.FrameType.BODY))
        for name, link, point in self.frames:
            place = pin.SE3(np.eye(3), np.array(point, dtype=float))
            model.addFrame(pin.Frame(name, ids[link], place, pin.FrameType.OP_FRAME))
        return model

    def urdf(self, name: str, *, balls: str | None = None) -> str:
        """The same as URDF text, without the root joint, which a reader gives.

        Args:
            name: of the robot.
            balls: joint type to write for spherical joints, for a reader that only draws.

        Raises:
            ModelError: there is a spherical joint, which URDF does not know.
        """
        robot = ET.Element("robot", name=name, version="1.1")
        for link in (self.base, *(joint.child for joint in self.joints)):
            _link(robot, link)
        for name_, link_, point in self.frames:
            _link(robot, Link(name_))
            _joint(robot, f"{name_}_mount", "fixed", link_, name_, point, None)
        for joint in self.joints:
            if joint.kind == "ball" and balls is None:
                raise ModelError(
                    f"joint {joint.name!r} is spherical, and URDF has no such joint: use the "
                    "machine's model, which is built in code."
                )
            # A slide's travel is not bounded here: URDF wants limits all the same.
            kinds = {"turn": "continuous", "slide": "prismatic", "ball": str(balls)}
            kind, axis = kinds[joint.kind], None if joint.kind == "ball" else joint.direction
            element = _joint(
                robot, joint.name, kind, joint.parent, joint.child.name, joint.at, axis
            )
            if kind == "prismatic":
                ET.SubElement(
                    element, "limit", lower="-1e3", upper="1e3", effort="1e3", velocity="1e3"
                )
        ET.indent(robot)
        return ET.tostring(robot, encoding="unicode") + "\n"


def _link(robot: ET.Element, link: Link) -> None:
    element = ET.SubElement(robot, "link", name=link.name)
    about = link.about_centre
    for look in link.looks:
        look.write(element)
    if link.mass == 0 and not about.any():
        return
    inertial = ET.SubElement(element, "inertial")
    ET.SubElement(inertial, "origin", xyz=_numbers(link.centre), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=repr(float(link.mass)))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    at = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    values = {name: repr(float(about[i])) for name, i in zip(names, at, strict=True)}
    ET.SubElement(inertial, "inertia", values)


def _joint(
    robot: ET.Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    at: ArrayLike,
    axis: ArrayLike | None,
) -> ET.Element:
    element = ET.SubElement(robot, "joint", name=name, type=kind)
    ET.SubElement(element, "parent", link=parent)
    ET.SubElement(element, "child", link=child)
    ET.SubElement(element, "origin", xyz=_numbers(at), rpy="0 0 0")
    if axis is not None:
        ET.SubElement(element, "axis", xyz=_numbers(axis))
    return element


def _numbers(values: ArrayLike) -> str:
    return " ".join(repr(float(v)) for v in np.asarray(values).ravel())
