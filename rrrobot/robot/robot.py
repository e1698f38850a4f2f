"""A robot: URDF -> Pinocchio model with a free-flyer base, a round shell, named legs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.contact.convexity import check_convex
from rrrobot.contact.saved import surface_from_dict
from rrrobot.contact.surfaces import SHELL_FRAME, Sphere, Surface
from rrrobot.errors import ModelError, ShellError, UrdfError
from rrrobot.inline import html_table
from rrrobot.robot.examples import example_urdf
from rrrobot.robot.faults import root_link
from rrrobot.robot.joints import build_model, check_masses, movable_joints
from rrrobot.robot.limits import LegJoints, leg_joints, without_placeholders
from rrrobot.robot.mimics import Coupling, couplings
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.reader import is_text, parse_urdf, read_urdf, urdf_text
from rrrobot.robot.suspicion import warn_of_inertias, warn_of_parts, warn_of_shell
from rrrobot.robot.tree import turn_over
from rrrobot.robot.urdf import LEGS, rrrobot_urdf
from rrrobot.rotations import rotation_from_euler

_OWN_SHELLS = ("rrrobot.contact.surfaces", "rrrobot.contact.shells")
"""Shells that are convex by construction; any other is checked."""
STANDARD_GRAVITY = 9.81
"""g where neither a ground nor a robot's parameters say otherwise [m/s^2]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Robot:
    """A tree of one-degree-of-freedom joints on a free-flyer base whose root link has a shell.

    Make one with `from_parameters`, `from_urdf` or `from_example`. A robot pickles and
    deep-copies; its Pinocchio model must not be changed.

    Attributes:
        name: the URDF's robot name.
        urdf: the URDF as text.
        shell: the round surface, in the frame `SHELL_FRAME`.
        legs: joint names of the legs; every leg array in this package has this order.
        shell_link: link that carries the shell. If it moves against the URDF's root link, the
            tree is turned over, so that it is the base; joints count as in the file.
        shell_center: origin of the shell's frame in that of `shell_link` (3,) [m].
        shell_rpy: roll, pitch, yaw of the shell's frame in that of `shell_link` (3,) [rad].
        locked: positions of the joints that are not legs, held still [rad or m].
        parameters: what `from_parameters` made it from; None for any other robot. Models take its
            gravity and damping unless told otherwise.
        package_dirs: folders where mesh names are looked up; the URDF file's own is the first.
        model: Pinocchio model; q = (base position, base quaternion xyzw, joints), v = (base
            linear and angular velocity in the base frame, joint velocities).
        rooted_urdf: the checked URDF with the base at its root.
        couplings: mimic joint -> the leg that it follows, and how.
        joints: what the URDF says of the legs' joints: limits, damping, friction.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters(rr.RRRobotParameters())
        >>> robot
        Robot('rrrobot', legs=('leg_1', 'leg_2'), shell=Sphere(radius=0.12), mass=0.52 kg)
    """

    urdf: str
    shell: Surface
    legs: tuple[str, ...]
    shell_link: str
    shell_center: Array
    shell_rpy: Array = field(default_factory=lambda: np.zeros(3))
    locked: Mapping[str, float] = field(default_factory=dict)
    parameters: RRRobotParameters | None = None
    package_dirs: tuple[str, ...] = ()
    name: str = field(init=False)
    model: pin.Model = field(init=False, repr=False)
    shell_placement: pin.SE3 = field(init=False, repr=False)
    rooted_urdf: str = field(init=False, repr=False)
    couplings: Mapping[str, Coupling] = field(init=False, repr=False)
    joints: LegJoints = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.shell, Surface):
            raise ShellError(
                f"shell is {self.shell!r}: it must be a surface, such as Sphere(radius=0.12)."
            )
        if type(self.shell).__module__ not in _OWN_SHELLS:
            check_convex(self.shell)
        set_field = object.__setattr__
        for name, unit in (("shell_center", "m"), ("shell_rpy", "rad")):
            set_field(self, name, vector(name, getattr(self, name), 3, unit))
            getattr(self, name).flags.writeable = False
        tree = parse_urdf(self.urdf)
        turn_over(tree, self.shell_link, self.locked)
        set_field(self, "rooted_urdf", urdf_text(tree))
        model = build_model(self.rooted_urdf, pin.JointModelFreeFlyer(), self.legs, self.locked)
        follow = {
            name: coupling
            for name, coupling in couplings(tree, self.locked).items()
            if coupling.leg in self.legs and coupling.ratio != 0
        }
        set_field(self, "couplings", follow)
        joints = leg_joints(tree, self.legs, follow)
        set_field(self, "joints", without_placeholders(joints, self.legs, model))
        model.gravity.linear = np.array((0.0, 0.0, -self.gravity))
        set_field(self, "name", model.name)
        set_field(self, "shell_placement", _add_shell_frame(model, self))
        check_masses(model)
        set_field(self, "model", model)

    @classmethod
    def from_parameters(cls, parameters: RRRobotParameters | None = None) -> Robot:
        """RRRobot from its geometry and masses (Table 2 by default)."""
        p = parameters or RRRobotParameters()
        return cls(
            urdf=rrrobot_urdf(p),
            shell=Sphere(p.shell_radius),
            legs=LEGS,
            shell_link="shell",
            shell_center=np.zeros(3),
            parameters=p,
        )

    @classmethod
    def from_urdf(
        cls,
        source: str | Path,
        *,
        shell: Surface,
        legs: Sequence[str] | None = None,
        locked: Mapping[str, float] | None = None,
        shell_link: str | None = None,
        shell_center: ArrayLike = (0.0, 0.0, 0.0),
        shell_rpy: ArrayLike = (0.0, 0.0, 0.0),
        package_dirs: Sequence[str | Path] = (),
    ) -> Robot:
        """Any URDF robot that rolls on a round belly.

        Args:
            source: path of a URDF file, or the URDF as text.
            shell: the belly, such as `Sphere(0.2)`; it touches the ground at one point.
            legs: joint names in the order that gaits use; all movable joints that are not
                `locked` and mimic none, in Pinocchio's order, unless given. Joints left out are
                held at their `locked` position; mimic joints follow their master.
            locked: joint name -> position of held joints [rad or m]; 0 where it is not named. A
                mimic joint that is named does not follow.
            shell_link: link that carries the shell, any of the tree; the root link unless given.
            shell_center: origin of the shell's frame, its centre, in that link's (3,) [m].
            shell_rpy: roll, pitch, yaw of the shell's frame in that link's, as a URDF's (3,) [rad].
            package_dirs: folders for mesh names, beside the file's own and those in
                ROS_PACKAGE_PATH.

        Raises:
            UrdfError: missing, malformed or hostile file; a joint that has more than one degree
                of freedom or does not exist; no mass.
            ShellError: no such link, no surface.
            ParameterError: a number out of range.

        Warns:
            UrdfWarning: inertias that no body can have; parts that no model takes into account; a
                link that looks like the ball and does not carry the shell.

        Example:
            >>> import rrrobot as rr
            >>> robot = rr.Robot.from_urdf(rr.urdf_path("rrrobot"), shell=rr.Sphere(0.12))
            >>> robot.legs
            ('leg_1', 'leg_2')
        """
        text = read_urdf(source)
        tree = parse_urdf(text)
        root = root_link(tree)
        every = movable_joints(text, shell_link, locked or ())
        follow = couplings(tree, locked or ())
        free = tuple(n for n in every if n not in (locked or {}) and n not in follow)
        chosen = free if legs is None else _leg_names(legs)
        held = {n: 0.0 for n in every if n not in chosen and n not in follow}
        for name, value in (locked or {}).items():
            if name not in held:
                raise UrdfError(
                    f"locked joint {name!r} is no movable joint outside the legs; those are: "
                    f"{', '.join(held) or 'none'}."
                )
            held[name] = finite(f"locked[{name!r}]", value)
        for name, (leg, ratio, offset) in follow.items():
            if leg in held or ratio == 0:
                held[name] = ratio * held.get(leg, 0.0) + offset
        robot = cls(
            urdf=text,
            shell=shell,
            legs=chosen,
            shell_link=shell_link or root,
            shell_center=vector("shell_center", shell_center, 3, "m"),
            shell_rpy=vector("shell_rpy", shell_rpy, 3, "rad"),
            locked=held,
            package_dirs=(*_own_folder(source), *(str(folder) for folder in package_dirs)),
        )
        warn_of_parts(tree)
        warn_of_inertias(tree, robot)
        if shell_link is None:
            warn_of_shell(tree, root, getattr(shell, "radius", None))
        return robot

    @classmethod
    def from_example(cls, name: str, *, shell: Surface, **options: Any) -> Robot:
        """A robot of example-robot-data (extra `robots`), such as "solo12".

        Args:
            name: as `example_robots()` lists them.
            shell: the belly.
            **options: as for `from_urdf`.

        Raises:
            MissingExtraError: the extra is not installed.
            UrdfError: no such robot.
        """
        path, package_dir = example_urdf(name)
        return cls.from_urdf(path, shell=shell, package_dirs=(package_dir,), **options)

    @property
    def n_legs(self) -> int:
        """Number of leg joints."""
        return len(self.legs)

    @property
    def gravity(self) -> float:
        """g [m/s^2] of its parameters, or 9.81; a ground may say otherwise."""
        return STANDARD_GRAVITY if self.parameters is None else self.parameters.gravity

    @property
    def mass(self) -> float:
        """Total mass [kg]."""
        return float(pin.computeTotalMass(self.model))

    def to_dict(self) -> dict[str, Any]:
        """Everything that `from_dict` needs, as plain data for JSON."""
        return {
            "urdf": self.urdf,
            "shell": self.shell.to_dict(),
            "legs": list(self.legs),
            "shell_link": self.shell_link,
            "shell_center": self.shell_center.tolist(),
            "shell_rpy": self.shell_rpy.tolist(),
            "locked": dict(self.locked),
            "parameters": None if self.parameters is None else self.parameters.to_dict(),
            "package_dirs": list(self.package_dirs),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Robot:
        """The robot that `to_dict` wrote; its URDF is checked as any other."""
        parts = dict(data)
        parts["shell"] = surface_from_dict(parts["shell"])
        parts["legs"] = tuple(parts["legs"])
        if parts["parameters"] is not None:
            parts["parameters"] = RRRobotParameters.from_dict(parts["parameters"])
        parts["package_dirs"] = tuple(parts["package_dirs"])
        return cls(**parts)

    def _repr_html_(self) -> str:
        rows = {
            "mass": f"{self.mass:.6g} kg",
            "legs": ", ".join(self.legs) or "none",
            "shell": f"{self.shell!r} of {self.shell_link}",
            "held still": ", ".join(f"{k} at {v:g}" for k, v in self.locked.items()) or "nothing",
        }
        return html_table(f"Robot {self.name}", rows)

    def __repr__(self) -> str:
        return (
            f"Robot({self.name!r}, legs={self.legs}, shell={self.shell}, mass={self.mass:.6g} kg)"
        )

    def __reduce__(self) -> tuple[Any, tuple[dict[str, Any]]]:
        return (_remake, ({f.name: getattr(self, f.name) for f in fields(self) if f.init},))

    def __eq__(self, other: object) -> bool:
        # Where the meshes lie is no part of what a robot is.
        return isinstance(other, Robot) and (
            self.to_dict() | {"package_dirs": ()} == other.to_dict() | {"package_dirs": ()}
        )

    def __hash__(self) -> int:
        return hash((self.urdf, self.shell, self.legs))


def _own_folder(source: str | Path) -> tuple[str, ...]:
    """The folder of a URDF file, none of a text."""
    return () if is_text(source) else (str(Path(source).resolve().parent),)


def _leg_names(legs: Sequence[str]) -> tuple[str, ...]:
    names = (legs,) if isinstance(legs, str) else tuple(legs)
    if len(set(names)) != len(names):
        raise UrdfError(f"legs are {names}: each joint may be named once.")
    return names


def _remake(parts: dict[str, Any]) -> Robot:
    return Robot(**parts)


def _add_shell_frame(model: pin.Model, robot: Robot) -> pin.SE3:
    """Add SHELL_FRAME to the model; return its placement in the base frame."""
    if model.existFrame(SHELL_FRAME):
        raise UrdfError(f"the URDF has the name {SHELL_FRAME!r}: rename it; the shell needs it.")
    bodies = [f.name for f in model.frames if f.type == pin.FrameType.BODY]
    if robot.shell_link not in bodies:
        raise ShellError(
            f"the robot has no link {robot.shell_link!r} to carry the shell. Its links are: "
            f"{', '.join(bodies)}."
        )
    link = model.frames[model.getFrameId(robot.shell_link, pin.FrameType.BODY)]
    placement = link.placement * pin.SE3(rotation_from_euler(robot.shell_rpy), robot.shell_center)
    model.addFrame(pin.Frame(SHELL_FRAME, 1, placement, pin.FrameType.OP_FRAME))
    return placement


def checked_robot(robot: Any) -> Robot:
    """A Robot, which is what models are made of.

    Raises:
        ModelError: it is something else.
    """
    if not isinstance(robot, Robot):
        kind = f"the class {robot.__name__}" if isinstance(robot, type) else type(robot).__name__
        raise ModelError(
            f"robot is {kind}: it must be a Robot, such as Robot.from_parameters() or "
            "Robot.from_urdf(file, shell=Sphere(0.2)). A Pinocchio model alone is rolled by its "
            "constraints: examples/own_pinocchio_model.py."
        )
    return robot
