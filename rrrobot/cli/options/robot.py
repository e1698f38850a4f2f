"""Options of a robot, of the ground below it, of its damping, and the model that they make."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import click

from rrrobot.cli.options.group import Group, option
from rrrobot.cli.types import NUMBER, PER_LEG, Numbers, names, parse_number
from rrrobot.contact.boulder import Boulder
from rrrobot.contact.graph import Graph
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.surfaces import Sphere
from rrrobot.drive.damping import BodyRateDamping, DampingLike, EulerRateDamping
from rrrobot.models.base import OWN, Model
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.robot import Robot

if TYPE_CHECKING:
    _ParamType = click.ParamType[Any, Any]
else:
    _ParamType = click.ParamType

M = TypeVar("M", bound=Model)
PerLeg = float | tuple[float, ...] | None

MODELS: dict[str, type[Model]] = {
    "full": FullModel,
    "pivoting": PivotingModel,
    "roll": RollModel,
    "pitch": PitchModel,
    "yaw": YawModel,
}
DECOUPLED = "decoupled"
"""Not one model but three, recombined: `rrrobot.simulation.recombined`."""
_DEFAULT_ROBOT = "rrrobot"
_TABLE_2 = ("leg_mass", "servo_mass", "battery_mass", "leg_length", "hip_offset")


@dataclass(frozen=True, kw_only=True)
class RobotOptions(Group):
    """RRRobot with masses and lengths of one's own, or any URDF with a round belly."""

    urdf: str | None = option(
        "--urdf", metavar="FILE", help="Robot from a URDF; needs --shell-radius."
    )
    robot: str | None = option(
        "--robot",
        metavar="NAME",
        help="Robot of example-robot-data, as 'rrrobot robots' lists them; needs --shell-radius.",
    )
    shell_radius: float | None = option(
        "--shell-radius", type=NUMBER, help="Radius of the round belly [m]."
    )
    shell_center: tuple[float, float, float] | None = option(
        "--shell-center",
        type=NUMBER,
        nargs=3,
        metavar="X Y Z",
        help="Its centre in the frame of its link [m]; 0 0 0 unless given.",
    )
    shell_link: str | None = option(
        "--shell-link", metavar="NAME", help="Its link; the root link unless given."
    )
    legs: str | None = option(
        "--legs",
        metavar="NAMES",
        help="Joints of the legs, as J1,J2,...; all movable joints unless given. The others are "
        "held at zero.",
    )
    leg_mass: PerLeg = option(
        "--leg-mass", type=PER_LEG, help="RRRobot: mass at each leg tip [kg]."
    )
    servo_mass: PerLeg = option(
        "--servo-mass", type=PER_LEG, help="RRRobot: mass at each hip [kg]."
    )
    battery_mass: float | None = option(
        "--battery-mass", type=NUMBER, help="RRRobot: mass at the bottom [kg]."
    )
    leg_length: PerLeg = option(
        "--leg-length", type=PER_LEG, help="RRRobot: length of each leg [m]."
    )
    hip_offset: float | None = option(
        "--hip-offset", type=NUMBER, help="RRRobot: from the centre to each hip [m]."
    )
    gravity: float | None = option("--gravity", type=NUMBER, help="[m/s^2]; 9.81 unless given.")

    @property
    def is_rrrobot(self) -> bool:
        """Whether it is RRRobot, and not a robot of a URDF."""
        return self.urdf is None and self.robot in (None, _DEFAULT_ROBOT)

    def build(self) -> Robot:
        """The robot.

        Raises:
            click.UsageError: options that do not go together.
            RRRobotError: as `Robot` raises.
        """
        if self.urdf is not None and self.robot is not None:
            raise click.UsageError("give --urdf or --robot, not both.")
        if self.is_rrrobot:
            self.refuse(("shell_center", "shell_link", "legs"), "need --urdf or --robot")
            values = self.given(*_TABLE_2, "shell_radius", "gravity")
            return Robot.from_parameters(RRRobotParameters(**values))
        self.refuse(_TABLE_2, "are RRRobot's: the URDF says the masses and lengths")
        if self.shell_radius is None:
            raise click.UsageError(
                "--shell-radius is missing: the radius of the robot's round belly [m]."
            )
        parts = self.given("shell_center", "shell_link")
        parts |= {"shell": Sphere(self.shell_radius), "legs": names(self.legs)}
        if self.urdf is not None:
            return Robot.from_urdf(Path(self.urdf), **parts)
        return Robot.from_example(str(self.robot), **parts)

    def build_level(self) -> Robot:
        """The robot, where a command's models take level ground and the robot's own gravity."""
        if not self.is_rrrobot:
            self.refuse(("gravity",), "are RRRobot's with this command")
        return self.build()


class GroundKind(NamedTuple):
    """A kind of ground on the command line.

    Attributes:
        form: how it is written.
        numbers: how many stand after the colon; None takes a text.
        make: of these numbers, or the text alone, and the gravity.
    """

    form: str
    numbers: int | None
    make: Callable[[tuple[Any, ...], float | None], Ground]


def _slope(numbers: tuple[float, ...], gravity: float | None) -> Ground:
    angle = math.radians(numbers[0])
    return Plane((-math.sin(angle), 0.0, math.cos(angle)), gravity=gravity)


GROUNDS = {
    "level": GroundKind("level", 0, lambda _, gravity: Plane(gravity=gravity)),
    "slope": GroundKind("slope:DEGREES", 1, _slope),
    "plane": GroundKind("plane:NX,NY,NZ", 3, lambda n, gravity: Plane(n, gravity=gravity)),
    "boulder": GroundKind("boulder:R", 1, lambda r, gravity: Boulder(r[0], gravity=gravity)),
    "bowl": GroundKind("bowl:R", 1, lambda r, gravity: Boulder(-r[0], gravity=gravity)),
    "grid": GroundKind("grid:FILE", None, lambda f, g: Graph.from_file(f[0], gravity=g)),
}
"""What --ground takes; a new ground is one entry."""


class GroundChoice(NamedTuple):
    """A ground as it was written."""

    kind: str
    numbers: tuple[Any, ...]


class GroundType(_ParamType):
    """Reads a ground."""

    name = "ground"

    def convert(self, value: Any, param: Any, ctx: Any) -> GroundChoice:
        if isinstance(value, GroundChoice):
            return value
        word, _, text = value.partition(":")
        forms = ", ".join(kind.form for kind in GROUNDS.values())
        if word not in GROUNDS:
            self.fail(f"{value!r} is no ground: write one of {forms}.", param, ctx)
        kind = GROUNDS[word]
        if kind.numbers is None and text:
            return GroundChoice(word, (text,))
        try:
            numbers = tuple(parse_number(entry) for entry in text.split(",")) if text else ()
        except ValueError as error:
            self.fail(str(error), param, ctx)
        if len(numbers) != kind.numbers or (word == "slope" and not abs(numbers[0]) < 90):
            self.fail(f"{value!r} is no {word} ground: write {kind.form}.", param, ctx)
        return GroundChoice(word, numbers)


@dataclass(frozen=True, kw_only=True)
class GroundOptions(Group):
    """What the robot rolls on."""

    ground: GroundChoice = option(
        "--ground",
        type=GroundType(),
        default="level",
        show_default=True,
        metavar="|".join(kind.form for kind in GROUNDS.values()),
        help="A slope rises along x; a plane has this normal; a boulder or a bowl is a sphere of "
        "this radius [m], and the robot starts on its top or its bottom; a grid is a .csv file of "
        "heights [m], y in its first row and x in its first column. Gravity stays along -z.",
    )

    def build(self, robot: RobotOptions) -> Ground:
        """The ground, with its gravity unless that is RRRobot's own."""
        gravity = None if robot.is_rrrobot else robot.gravity
        return GROUNDS[self.ground.kind].make(self.ground.numbers, gravity)


@dataclass(frozen=True, kw_only=True)
class DampingOptions(Group):
    """Viscous losses of the body."""

    damping: PerLeg = option(
        "--damping",
        type=Numbers(1, 3),
        help="Viscous loss, one number or R,P,Y [N m s/rad]; RRRobot's is 0.01 unless given, on "
        "the axes that the paper damps; another robot's is none.",
    )
    damping_kind: str | None = option(
        "--damping-kind",
        type=click.Choice(("euler", "body")),
        help="Of the rates of roll, pitch, yaw (the paper; singular at a pitch of 90 degrees), or "
        "of the rates about the body's axes; euler unless given.",
    )

    def build(self, robot: RobotOptions) -> DampingLike:
        """The damping; the robot's own without these options."""
        value, kind = self.damping, self.damping_kind
        if value is None and kind is None:
            return OWN
        if value is None and not robot.is_rrrobot:
            raise click.UsageError(
                "--damping-kind needs --damping here: RRRobot's 0.01 N m s/rad is not this robot's."
            )
        numbers = (value,) * 3 if isinstance(value, float) else value or (0.01,) * 3
        return (BodyRateDamping if kind == "body" else EulerRateDamping)(*numbers)


class Parts(NamedTuple):
    """What models are made of."""

    robot: Robot
    ground: Ground
    damping: DampingLike

    @classmethod
    def of(cls, robot: RobotOptions, ground: GroundOptions, damping: DampingOptions) -> Parts:
        """The parts that the options stand for."""
        return cls(robot.build(), ground.build(robot), damping.build(robot))

    def model(self, kind: type[M]) -> M:
        """A model of this kind."""
        return kind(self.robot, ground=self.ground, damping=self.damping)  # type: ignore[call-arg]
