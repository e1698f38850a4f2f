"""Options of a gait or of torques."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rrrobot.cli.options.group import Group, option
from rrrobot.cli.options.robot import PerLeg, RobotOptions
from rrrobot.cli.types import NUMBER, PER_LEG
from rrrobot.cli.wording import called
from rrrobot.drive.gaits import Gait, RampIn, SinusoidalGait, StillLegs
from rrrobot.drive.gaits import gait as named_gait
from rrrobot.drive.tables import read_gait
from rrrobot.drive.torques import LegTorques
from rrrobot.robot.robot import Robot

if TYPE_CHECKING:
    _ParamType = click.ParamType[Any, Any]
else:
    _ParamType = click.ParamType

GAITS = ("lateral", "circular")
_FILES = (".json", ".csv")
_SINUSOID = ("offset", "amplitude", "frequency", "phase")


class GaitName(_ParamType):
    """A gait's name, or a file that has one."""

    name = "gait"

    def __init__(self, *names: str) -> None:
        self.names = names

    def convert(self, value: Any, param: Any, ctx: Any) -> str:
        if value not in self.names and Path(value).suffix.lower() not in _FILES:
            self.fail(
                f"{value!r} is not one of {', '.join(map(repr, self.names))}, nor a file that "
                f"ends in {' or '.join(_FILES)}.",
                param,
                ctx,
            )
        return str(value)


@dataclass(frozen=True, kw_only=True)
class GaitOptions(Group):
    """A gait that the legs follow."""

    gait: str | None = option(
        "--gait",
        type=GaitName(*GAITS, "still"),
        metavar="|".join((*GAITS, "still", "FILE")),
        help="Gait of the paper (leg 2 leads leg 1 by pi/2), changed by the four options below; "
        "legs held still at --offset; or of a file: .json, as 'rrrobot gait' and 'optimise' write "
        "them, or a .csv table of times and angles. lateral unless given.",
    )
    offset: PerLeg = option("--offset", type=PER_LEG, help="Centre of the swing [rad]; pi/2 is up.")
    amplitude: PerLeg = option(
        "--amplitude", type=PER_LEG, help="Of the swing [rad]; 0.3 unless given."
    )
    frequency: PerLeg = option("--frequency", type=PER_LEG, help="Angular [rad/s]; 8 unless given.")
    phase: PerLeg = option(
        "--phase", type=PER_LEG, help="[rad]; 0,pi/2 on two legs, 0 on more, unless given."
    )
    ramp: float | None = option(
        "--ramp", type=NUMBER, metavar="SECONDS", help="Start from rest and blend in."
    )

    def build(self, robot: Robot, options: RobotOptions) -> Gait:
        """The gait for a robot's legs.

        Raises:
            click.UsageError: options that do not go together.
            GaitError: numbers that do not fit the robot's legs, or a file that is no gait.
        """
        if self.gait == "still":
            self.refuse(("amplitude", "frequency", "phase", "ramp"), "do not go with --gait still")
            return StillLegs(self.start_angle(options), n_legs=robot.n_legs)
        if self.gait is None or self.gait in GAITS:
            gait: Gait = self._sinusoid(robot)
        else:
            self.refuse(_SINUSOID, "do not go with a gait of a file")
            gait = read_gait(self.gait)
        if self.ramp is None:
            return gait
        with called({"duration": "--ramp"}):
            return RampIn(gait, self.ramp)

    def start_angle(self, options: RobotOptions) -> float | tuple[float, ...]:
        """--offset, or upright legs on RRRobot and 0 on others."""
        if self.offset is not None:
            return self.offset
        return math.pi / 2 if options.is_rrrobot else 0.0

    def _sinusoid(self, robot: Robot) -> SinusoidalGait:
        n = robot.n_legs
        if n != 2 and self.offset is None:
            raise click.UsageError(
                f"--offset is missing: the gaits of the paper are for two legs, and {robot.name} "
                f"has {n} leg joint{'s' * (n != 1)}; name two with --legs, or give --offset."
            )
        phase = (0.0, math.pi / 2) if n == 2 else 0.0
        return SinusoidalGait(
            offset=named_gait(self.gait or GAITS[0]).offset if self.offset is None else self.offset,
            amplitude=0.3 if self.amplitude is None else self.amplitude,
            angular_frequency=8.0 if self.frequency is None else self.frequency,
            phase=phase if self.phase is None else self.phase,
            n_legs=n,
        )


@dataclass(frozen=True, kw_only=True)
class TorqueOptions(Group):
    """Torques instead of a gait."""

    torque: PerLeg = option(
        "--torque",
        type=PER_LEG,
        help="Constant motor torques [N m] instead of a gait; --offset is where the legs start.",
    )

    def build(self, gait: GaitOptions, robot: Robot, options: RobotOptions) -> Gait | LegTorques:
        """The torques if they are given, else the gait."""
        if self.torque is None:
            return gait.build(robot, options)
        gait.refuse(("gait", "amplitude", "frequency", "phase", "ramp"), "do not go with --torque")
        angle = gait.start_angle(options)
        angles = angle if isinstance(angle, tuple) else (angle,) * robot.n_legs
        return LegTorques(self.torque, angle=angles)
