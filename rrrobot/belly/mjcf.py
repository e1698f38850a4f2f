"""A robot with its belly as an MJCF file: the same bodies, joints and shell for MuJoCo.

Bodies, inertias, axes and joint losses are those of the robot's Pinocchio model: locked joints are
welded and a mimic joint is an equality. A shell that is no ball or ellipsoid becomes a mesh of its
points, the convex pieces of the links meshes of their corners: the file needs no other.

    motor effort = kp (phi_wanted - phi) + kv (phi_dot_wanted - phi_dot)

by one position and one velocity actuator a leg, named LEG and LEG_rate.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from rrrobot.belly.shapes import Piece, Shapes
from rrrobot.checks import Array, finite
from rrrobot.contact.boulder import is_rock
from rrrobot.contact.convexity import sphere_directions
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.surfaces import Ellipsoid, Sphere
from rrrobot.errors import ModelError
from rrrobot.files import write_whole
from rrrobot.robot.joints import joint_inertia
from rrrobot.robot.robot import Robot

_SERVO = 60.0
"""Bandwidth of the legs' servos unless told otherwise [rad/s]."""
_POINTS = 2000
_THIN = 1e-3
"""Half thickness of a flat belly's box [m]."""


def to_mjcf(
    robot: Robot,
    path: str | Path | None = None,
    *,
    ground: Ground | None = None,
    with_shell: bool = True,
    pieces: bool = True,
    friction: float = 0.6,
    servo: float = _SERVO,
) -> str:
    """MJCF of a robot on its ground.

    Args:
        robot: any; such as `belly.robot`.
        path: where to write it, whole or not at all; nothing is written if None.
        ground: a plane or a boulder; level ground unless given.
        with_shell: whether the belly is part of it, as what the robot touches the ground with.
        pieces: whether the links' own shapes are; they touch the ground, and not each other.
        friction: coefficient of sliding friction of all contacts.
        servo: bandwidth of the legs' servos [rad/s].

    Returns:
        the MJCF as text. Its first body has the robot's name and its free joint "base"; qpos is
        Pinocchio's q with the quaternion's w first.

    Raises:
        ModelError: a ground that is neither a plane nor a boulder.
        ParameterError: a number out of range.
        OutputError: the file cannot be written.

    Example:
        >>> import rrrobot as rr
        >>> text = rr.to_mjcf(rr.Robot.from_parameters())
        >>> text.count("<body "), 'type="sphere"' in text
        (3, True)
    """
    friction = finite("friction", friction, at_least=0)
    servo = finite("servo", servo, "rad/s", above=0)
    ground = Plane() if ground is None else ground
    root = Element("mujoco", model=robot.name)
    SubElement(root, "compiler", angle="radian", autolimits="true", inertiafromgeom="false",
               balanceinertia="true", boundinertia="1e-9")  # fmt: skip
    gravity = robot.gravity if ground.gravity is None else ground.gravity
    SubElement(root, "option", gravity=_text((0, 0, -gravity)), integrator="implicitfast",
               cone="elliptic", impratio="10", timestep="0.001")  # fmt: skip
    defaults = SubElement(SubElement(root, "default"), "geom")
    defaults.attrib |= {"friction": _text((friction, 0.005, 0.0001)), "condim": "3"}
    asset, world = SubElement(root, "asset"), SubElement(root, "worldbody")
    SubElement(world, "light", pos="0 0 3", dir="0 0 -1")
    _add_ground(world, ground)
    bodies = _add_bodies(world, robot)
    if with_shell:
        _add_shell(asset, bodies[1], robot)
    if pieces:
        for i, piece in enumerate(Shapes.of(robot).pieces):
            _add_piece(asset, bodies[piece.joint], f"{piece.link}_{i}", piece)
    _add_drives(root, robot, servo)
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode") + "\n"
    if path is not None:
        write_whole(Path(path), text.encode())
    return text


def _add_ground(world: Element, ground: Ground) -> None:
    masks = {"name": "ground", "contype": "1", "conaffinity": "3", "rgba": "0.85 0.87 0.9 1"}
    if isinstance(ground, Plane):
        turn = pin.Quaternion.FromTwoVectors(np.array((0.0, 0, 1)), ground.normal_vector)
        SubElement(world, "geom", masks, type="plane", size="20 20 0.1", quat=_quaternion(turn))
    elif is_rock(ground):
        SubElement(world, "geom", masks, type="sphere", size=_text((ground.radius,)),
                   pos=_text((0, 0, -ground.radius)))  # fmt: skip
    else:
        raise ModelError(
            f"{ground!r} has no counterpart of the same shape in MJCF: give a Plane, or a Boulder "
            "of positive radius."
        )


def _add_bodies(world: Element, robot: Robot) -> dict[int, Element]:
    """One body a joint of the Pinocchio model; by the joint's index."""
    model, data = robot.model, robot.model.createData()
    q = pin.neutral(model)
    pin.forwardKinematics(model, data, q)
    bodies: dict[int, Element] = {}
    for joint in range(1, model.njoints):
        place, inertia = model.jointPlacements[joint], model.inertias[joint]
        above = world if joint == 1 else bodies[int(model.parents[joint])]
        name = robot.name if joint == 1 else f"{model.names[joint]}_body"
        body = SubElement(above, "body", name=name, pos=_text(place.translation),
                          quat=_quaternion(pin.Quaternion(place.rotation)))  # fmt: skip
        if joint == 1:
            SubElement(body, "freejoint", name="base")
        else:
            _add_joint(body, robot, joint, data)
        about = inertia.inertia
        entries = [about[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        SubElement(body, "inertial", pos=_text(inertia.lever), mass=_text((inertia.mass,)),
                   fullinertia=_text(entries))  # fmt: skip
        bodies[joint] = body
    return bodies


def _add_joint(body: Element, robot: Robot, joint: int, data: pin.Data) -> None:
    name = robot.model.names[joint]
    subspace = np.asarray(data.joints[joint].S).reshape(6)
    slides = bool(np.any(subspace[:3]))
    axis = subspace[:3] if slides else subspace[3:]
    made = SubElement(body, "joint", name=name, type="slide" if slides else "hinge",
                      axis=_text(axis / np.linalg.norm(axis)))  # fmt: skip
    if name not in robot.legs:
        return
    k, limits = robot.legs.index(name), robot.joints
    if np.isfinite(limits.lower[k]) and np.isfinite(limits.upper[k]):
        made.set("range", _text((limits.lower[k], limits.upper[k])))
    made.set("damping", _text((limits.damping[k],)))
    made.set("frictionloss", _text((limits.friction[k],)))


def _add_shell(asset: Element, base: Element, robot: Robot) -> None:
    shell, place = robot.shell, robot.shell_placement
    at = {"pos": _text(place.translation), "quat": _quaternion(pin.Quaternion(place.rotation))}
    look = {"name": "shell", "contype": "2", "conaffinity": "1", "rgba": "0.2 0.4 0.7 0.4"}
    if isinstance(shell, Sphere):
        SubElement(base, "geom", look | at, type="sphere", size=_text((shell.radius,)))
    elif isinstance(shell, Ellipsoid):
        SubElement(base, "geom", look | at, type="ellipsoid", size=_text(shell.semi_axes))
    elif isinstance(shell, FlatBelly):
        half = [10.0 if r is None else r for r in (shell.half_length, shell.half_width)]
        above = place.translation + _THIN * place.rotation[:, 2]
        SubElement(base, "geom", look | at | {"pos": _text(above)}, type="box",
                   size=_text((*half, _THIN)))  # fmt: skip
    else:
        points = np.array([shell.contact(u) for u in sphere_directions(_POINTS)])
        _add_mesh(asset, base, "shell", points, look | at)


def _add_piece(asset: Element, body: Element, name: str, piece: Piece) -> None:
    look = {"name": name, "contype": "2", "conaffinity": "1", "rgba": "0.6 0.6 0.6 1"}
    points, radius = piece.points, (piece.radius,)
    if len(points) == 1:
        SubElement(body, "geom", look, type="sphere", size=_text(radius), pos=_text(points[0]))
    elif len(points) == 2:
        SubElement(body, "geom", look, type="capsule", size=_text(radius),
                   fromto=_text(points.ravel()))  # fmt: skip
    else:
        _add_mesh(asset, body, name, points, look)


def _add_mesh(
    asset: Element, body: Element, name: str, points: Array, look: dict[str, str]
) -> None:
    """The hull of points; MuJoCo moves a mesh's frame to its middle and back by itself."""
    SubElement(asset, "mesh", name=name, vertex=_text(points.ravel()), inertia="convex")
    SubElement(body, "geom", look, type="mesh", mesh=name)


def _add_drives(root: Element, robot: Robot, servo: float) -> None:
    """Servos of the legs, and equalities of the joints that follow them."""
    if robot.couplings:
        equality = SubElement(root, "equality")
        for name, coupling in robot.couplings.items():
            SubElement(equality, "joint", joint1=name, joint2=coupling.leg,
                       polycoef=_text((coupling.offset, coupling.ratio, 0, 0, 0)))  # fmt: skip
    if not robot.legs:
        return
    model, q = robot.model, pin.neutral(robot.model)
    inertia = np.diag(joint_inertia(model, model.createData(), q))
    actuators = SubElement(root, "actuator")
    for k, leg in enumerate(robot.legs):
        own = float(inertia[model.joints[model.getJointId(leg)].idx_v])
        gains = {"kp": _text((own * servo**2,))}, {"kv": _text((2 * own * servo,))}
        limit = {}
        if math.isfinite(robot.joints.effort[k]):
            limit["forcerange"] = _text((-robot.joints.effort[k], robot.joints.effort[k]))
        SubElement(actuators, "position", gains[0] | limit, name=leg, joint=leg)
        SubElement(actuators, "velocity", gains[1] | limit, name=f"{leg}_rate", joint=leg)


def _quaternion(turn: Any) -> str:
    return _text((turn.w, turn.x, turn.y, turn.z))


def _text(values: Iterable[float]) -> str:
    return " ".join(f"{float(value):.17g}" for value in values)
