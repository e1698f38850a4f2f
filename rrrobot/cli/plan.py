"""`rrrobot plan`: leg motions to a wanted pose, printed, drawn, filmed and saved."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np

from rrrobot.cli.compile import tell_of_compiling
from rrrobot.cli.options.group import Group, option, takes
from rrrobot.cli.options.robot import DampingOptions, GroundOptions, Parts, RobotOptions
from rrrobot.cli.options.steering import LegOptions, ObstacleOptions
from rrrobot.cli.report import tell
from rrrobot.cli.simulate import checked_file
from rrrobot.cli.types import NUMBER, Numbers
from rrrobot.drive.tables import gait_table
from rrrobot.errors import OutputError, ParameterError
from rrrobot.files import check_writable
from rrrobot.inline import aligned
from rrrobot.models.full import FullModel
from rrrobot.robot.joints import sliding
from rrrobot.steering.demands import Demands
from rrrobot.steering.planner import plan as make_plan
from rrrobot.steering.plans import Plan
from rrrobot.studies.optimisation.table import GaitLimits


@dataclass(frozen=True, kw_only=True)
class PlanOutput(Group):
    """What is printed and written."""

    as_json: bool = option("--json", is_flag=True, help="As JSON, SI units.")
    save: str | None = option(
        "--save", metavar="FILE",
        help="The plan: .json, for Plan.load and for --gait of every command.",
    )  # fmt: skip
    csv: str | None = option(
        "--csv", metavar="FILE", help="Set-points of the joints over the whole plan: .csv."
    )
    rate: float = option(
        "--rate", type=NUMBER, default="50", show_default=True, help="Of the set-points [1/s]."
    )
    plot: str | None = option(
        "--plot", metavar="FILE", help="The path with obstacles: .png, .pdf or .svg."
    )
    html: str | None = option("--html", metavar="FILE", help="Film for any browser: .html.")
    quiet: bool = option("--quiet", is_flag=True, help="No progress bar.")

    def files(self) -> dict[str, Path]:
        """Checked paths of what is to be written."""
        names = self.given("csv", "plot", "html")
        files = {key: checked_file(key, name) for key, name in names.items()}
        if self.save is not None:
            if Path(self.save).suffix.lower() != ".json":
                raise OutputError(f"cannot write {self.save!r}: --save ends in .json.")
            files["save"] = check_writable(self.save)
        return files


@click.command("plan")
@click.option(
    "--goal", type=Numbers(3), required=True, metavar="X,Y,YAW",
    help="Where the robot shall rest [m, m, rad].",
)  # fmt: skip
@click.option(
    "--start", type=Numbers(3), default="0,0,0", show_default=True, metavar="X,Y,YAW",
    help="Where it rests now.",
)  # fmt: skip
@click.option(
    "--waypoint", type=Numbers(3), multiple=True, metavar="X,Y,YAW",
    help="A pose to come by on the way.",
)  # fmt: skip
@click.option("--max-torque", type=NUMBER, help="That each motor can give [N m].")
@click.option("--max-leg-rate", type=NUMBER, help="That each motor can turn at [rad/s].")
@click.option("--max-power", type=NUMBER, help="Of all motors together [W].")
@click.option(
    "--minimise", type=click.Choice(("time", "effort")), default="time", show_default=True,
    help="Which plans come first: the quick ones, or those of little motor work.",
)  # fmt: skip
@click.option("--friction", type=NUMBER, help="Coefficient that the ground offers.")
@click.option(
    "--longest",
    type=NUMBER,
    default="600",
    show_default=True,
    help="Time that the legs may move [s].",
)
@takes(
    obstacles=ObstacleOptions,
    legs=LegOptions,
    robot=RobotOptions,
    ground=GroundOptions,
    damping=DampingOptions,
    output=PlanOutput,
)
def plan_command(
    goal: tuple[float, ...],
    start: tuple[float, ...],
    waypoint: tuple[tuple[float, ...], ...],
    max_torque: float | None,
    max_leg_rate: float | None,
    max_power: float | None,
    minimise: str,
    friction: float | None,
    longest: float,
    obstacles: ObstacleOptions,
    legs: LegOptions,
    robot: RobotOptions,
    ground: GroundOptions,
    damping: DampingOptions,
    output: PlanOutput,
) -> None:
    """Plan leg motions that bring the robot from rest at a pose to rest at another.

    The plan is exact: the full model, with all its transients, comes to rest at the goal. What the
    robot's gaits can do is computed once for each robot and kept in the user's cache folder.

    \b
    Examples:
      rrrobot plan --goal 0.3,0.2,pi/2 --plot plan.png --html plan.html
      rrrobot plan --goal -0.05,0.5,0 --disc 0.3,0.1,0.03 --margin 0.08 \\
        --polygon "-0.3,0.2 0.15,0.2 0.15,0.25 -0.3,0.25" --save plan.json
      rrrobot simulate --gait plan.json --start rest --duration 60
    """
    files = output.files()
    for name, (*_, yaw) in (
        ("goal", goal),
        ("start", start),
        *(("waypoint", w) for w in waypoint),
    ):
        if abs(yaw) > 2 * math.pi:
            raise ParameterError(
                f"the yaw of --{name} is {yaw:g} rad, more than a turn: angles are in rad, such "
                "as pi/4."
            )
    parts = Parts.of(robot, ground, damping)
    model = parts.model(FullModel)
    tell_of_compiling(quiet=output.quiet)
    given: dict[str, Any] = {
        "max_torque": max_torque,
        "max_leg_rate": max_leg_rate,
        "friction": friction,
    }
    limits = GaitLimits(**given) if any(v is not None for v in given.values()) else None
    found = make_plan(
        model, goal, start=start, waypoints=waypoint, obstacles=obstacles.build(),
        margin=obstacles.margin, amplitude=legs.amplitude, angular_frequency=legs.frequency,
        longest=longest, limits=limits, max_power=max_power, minimise=minimise,
        progress=False if output.quiet else None,
    )  # fmt: skip
    asked = found.demands()
    data, rows = found.to_dict() | {"demands": asked._asdict()}, table(found, asked)
    tell(data, rows, _write(found, files, output.rate), as_json=output.as_json)


def _write(plan: Plan, files: dict[str, Path], rate: float) -> list[Path]:
    written = []
    if "save" in files:
        written.append(plan.save(files["save"]))
    if "csv" in files:
        joints = gait_table(
            plan.gait, rate, duration=plan.gait.duration, joints=plan.model.robot.legs,
            slides=sliding(plan.model.robot.model, plan.model.robot.legs),
        )  # fmt: skip
        written.append(joints.to_csv(files["csv"]))
    if "plot" in files or "html" in files:
        trajectory = plan.execute(method="momentum")
        if "plot" in files:
            from rrrobot.drawing import write_figure

            written.append(write_figure(plan.plot(trajectory).figure, files["plot"]))
        if "html" in files:
            from rrrobot.view.films import record

            written.append(record(trajectory, files["html"]))
    return written


def table(plan: Plan, asked: Demands) -> str:
    """The schedule in lines, with where it ends and what it asks for."""
    rows = [
        ("from", pose(plan.start)),
        ("to", pose(plan.goal)),
        ("ends at", pose(plan.predicted)),
        (
            "off by",
            f"{1000 * np.hypot(*plan.error[:2]):.3f} mm, {math.degrees(plan.error[2]):.4f} deg",
        ),
        ("legs move", f"{plan.gait.duration:.2f} s, at least {plan.lower_bound:.2f} s are needed"),
        ("at rest after", f"{plan.duration:.2f} s"),
        ("frequency", f"{plan.gait.angular_frequency:g} rad/s, blends of {plan.gait.blend:.3f} s"),
    ]
    begin = 0.0
    for s in plan.gait.stretches:
        swing = np.hypot(s.sine[0], s.cosine[0])
        phase = np.arctan2(s.cosine[0], s.sine[0])
        lead = (phase[1] - phase[0]) % (2 * np.pi)
        rows.append((
            f"  {begin:7.2f} s",
            f"offset {_few(s.offset)}, amplitude {_few(swing)}, leg 2 leads by {lead:.4f} rad, "
            f"for {s.duration:.2f} s",
        ))  # fmt: skip
        begin += s.duration
    rows.append((
        "asks for",
        f"{asked.torque:.3g} N m, {asked.leg_rate:.3g} rad/s, {asked.power:.3g} W, "
        f"{asked.work:.3g} J, friction {asked.friction:.3g}; "
        f"normal force at least {asked.normal_force:.3g} of the weight, "
        f"legs {100 * asked.clearance:.3g} cm above the ground",
    ))  # fmt: skip
    rows.insert(-1, (f"  {begin:7.2f} s", f"to rest at {_few(plan.gait.rest)} rad"))
    return aligned(rows)


def pose(values: np.ndarray) -> str:
    """A pose in words."""
    x, y, yaw = values
    return f"x {x:.4f} m, y {y:.4f} m, yaw {math.degrees(yaw):.2f} deg"


def _few(values: np.ndarray) -> str:
    texts = [f"{value:.4f}" for value in values]
    return texts[0] if len(set(texts)) == 1 else ", ".join(texts)
