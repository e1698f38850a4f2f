"""`rrrobot follow`: a path followed with feedback, on a robot that may differ from the model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from rrrobot.cli.compile import tell_of_compiling
from rrrobot.cli.options.group import Group, option, takes
from rrrobot.cli.options.robot import DampingOptions, GroundOptions, Parts, RobotOptions
from rrrobot.cli.options.steering import LegOptions, Points
from rrrobot.cli.report import tell
from rrrobot.cli.simulate import checked_file
from rrrobot.cli.types import NUMBER, Numbers
from rrrobot.drive.tables import write_gait
from rrrobot.errors import OutputError
from rrrobot.files import check_writable
from rrrobot.inline import aligned
from rrrobot.models.full import FullModel
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.robot import Robot
from rrrobot.steering.following import STEERED, follow
from rrrobot.steering.robots import Sensor
from rrrobot.steering.tracks import Track


@dataclass(frozen=True, kw_only=True)
class TrackOptions(Group):
    """The path: one of these."""

    path: tuple[tuple[float, float], ...] | None = option(
        "--path",
        type=Points(2),
        metavar='"X,Y X,Y ..."',
        help="Straight lines by these points [m].",
    )
    circle: tuple[float, ...] | None = option(
        "--circle", type=Numbers(3), metavar="X,Y,R", help="A circle [m]."
    )
    eight: float | None = option(
        "--eight", type=NUMBER, metavar="WIDTH", help="A lying figure eight [m]; of 0.5 m unless "
        "a path is given.",
    )  # fmt: skip

    def build(self) -> Track:
        """The path.

        Raises:
            click.UsageError: more than one.
        """
        if len(self.given("path", "circle", "eight")) > 1:
            raise click.UsageError("give one of --path, --circle and --eight.")
        if self.path is not None:
            return Track(self.path)
        if self.circle is not None:
            return Track.circle(self.circle[:2], self.circle[2])
        return Track.eight(0.5 if self.eight is None else self.eight)


@dataclass(frozen=True, kw_only=True)
class TruthOptions(Group):
    """How the driven robot differs from the one that is believed, and how it is seen."""

    scale: tuple[str, ...] = option(
        "--true", multiple=True, metavar="NAME=FACTOR",
        help="A parameter of the driven RRRobot, times that of the believed: leg_mass=1.05.",
    )  # fmt: skip
    noise: float | tuple[float, ...] = option(
        "--noise", type=Numbers(2), default="0,0", show_default=True, metavar="PLACE,YAW",
        help="Standard deviation of each measured pose [m, rad].",
    )  # fmt: skip
    delay: int = option(
        "--delay", type=int, default=0, show_default=True, help="Of the measurement [cycles]."
    )
    seed: int = option("--seed", type=int, default=0, show_default=True, help="Of the noise.")

    def robot(self, believed: Robot) -> Robot:
        """The robot that is driven."""
        if not self.scale:
            return believed
        if believed.parameters is None:
            raise click.UsageError("--true: only RRRobot's parameters can be scaled.")
        values: dict[str, Any] = believed.parameters.to_dict()
        for text in self.scale:
            name, _, factor = text.partition("=")
            try:
                old = values[name]
                values[name] = (
                    tuple(x * float(factor) for x in old)
                    if isinstance(old, (list, tuple))
                    else old * float(factor)
                )
            except (KeyError, ValueError):
                raise click.UsageError(
                    f"--true {text!r}: write NAME=FACTOR, NAME one of {', '.join(values)}."
                ) from None
        return Robot.from_parameters(RRRobotParameters(**values))

    def sensor(self) -> Sensor:
        """How it is seen."""
        place, yaw = self.noise if isinstance(self.noise, tuple) else (self.noise,) * 2
        return Sensor(place=place, yaw=yaw, delay=self.delay, seed=self.seed)


@click.command("follow")
@click.option(
    "--duration", type=NUMBER, default="120", show_default=True, help="Until the legs stop [s]."
)
@click.option(
    "--gear", type=click.Choice(STEERED), default="forward", show_default=True,
    help="Direction of travel: along the body's x axis, or against it.",
)  # fmt: skip
@click.option("--speed", type=NUMBER, help="[m/s]; 0.8 of what the sharpest bend allows.")
@takes(
    track=TrackOptions,
    truth=TruthOptions,
    legs=LegOptions,
    robot=RobotOptions,
    ground=GroundOptions,
    damping=DampingOptions,
)
@click.option("--json", "as_json", is_flag=True, help="As JSON, SI units.")
@click.option("--save", metavar="FILE", help="What the legs did, as a gait: .json.")
@click.option("--plot", metavar="FILE", help="Path and robot's way: .png, .pdf or .svg.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
def follow_command(
    duration: float,
    gear: str,
    speed: float | None,
    track: TrackOptions,
    truth: TruthOptions,
    legs: LegOptions,
    robot: RobotOptions,
    ground: GroundOptions,
    damping: DampingOptions,
    as_json: bool,
    save: str | None,
    plot: str | None,
    quiet: bool,
) -> None:
    """Follow a path with feedback, steering once in each leg cycle from the measured pose.

    The controller believes in RRRobot on level ground; the robot that is driven may have other
    masses (--true), another damping, or stand on a slope (--ground).

    \b
    Examples:
      rrrobot follow --eight 0.5 --duration 600 --plot eight.png
      rrrobot follow --path "0,0 0.3,0 0.3,0.3" --true leg_mass=1.05 --noise 0.001,pi/360 --delay 1
      rrrobot follow --circle 0,0,0.2 --gear backward --ground slope:2
    """
    if save is not None and Path(save).suffix.lower() != ".json":
        raise OutputError(f"cannot write {save!r}: --save ends in .json.")
    targets = (
        None if save is None else check_writable(save),
        None if plot is None else checked_file("plot", plot),
    )
    parts = Parts.of(robot, ground, damping)
    believed = FullModel(parts.robot)
    real = FullModel(truth.robot(parts.robot), ground=parts.ground, damping=parts.damping)
    tell_of_compiling(quiet=quiet)
    run = follow(
        believed, track.build(), duration, truth=real, gear=gear, speed=speed,
        amplitude=legs.amplitude, angular_frequency=legs.frequency, sensor=truth.sensor(),
        progress=False if quiet else None,
    )  # fmt: skip
    written = []
    if targets[0] is not None:
        written.append(write_gait(run.gait, targets[0]))
    if targets[1] is not None:
        from rrrobot.drawing import write_figure

        written.append(write_figure(run.plot().figure, targets[1]))
    data = run.to_dict()
    rows = [
        ("path", f"{run.track.length:.4g} m{', closed' if run.track.closed else ''}"),
        ("followed", f"{data['cycles']} cycles, legs move {data['duration']:.4g} s"),
        ("rms of the mean path's error", f"{1000 * run.rms:.3f} mm"),
        ("largest", f"{1000 * (data['largest'] or math.nan):.3f} mm"),
    ]
    if run.stopped is not None:
        rows.append(("STOPPED EARLY", run.stopped))
    tell(data, aligned(rows), written, as_json=as_json)
