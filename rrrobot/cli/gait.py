"""`rrrobot gait`: a gait as a file, or as set-points for a robot's joints."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from rrrobot.cli.options.drive import GaitOptions
from rrrobot.cli.options.group import takes
from rrrobot.cli.options.robot import RobotOptions
from rrrobot.cli.report import gait_words, tell
from rrrobot.cli.types import NUMBER
from rrrobot.drive.tables import gait_table, write_gait
from rrrobot.errors import OutputError
from rrrobot.files import check_writable
from rrrobot.robot.joints import sliding

_SUFFIXES = (".json", ".csv", ".yaml", ".yml")


@click.command("gait")
@takes(robot=RobotOptions, gait=GaitOptions)
@click.option(
    "--out",
    metavar="FILE",
    help="Write .json: the gait, for --gait of every command; .csv: set-points of the joints; "
    ".yaml: a ROS 2 message trajectory_msgs/JointTrajectory.",
)
@click.option(
    "--rate", type=NUMBER, default="50", show_default=True, help="Set-points a second [1/s]."
)
@click.option(
    "--duration",
    type=NUMBER,
    help="Of the set-points [s]; one period unless given, at the nearest rate that divides it.",
)
@click.option("--json", "as_json", is_flag=True, help="As JSON.")
def gait_command(
    robot: RobotOptions,
    gait: GaitOptions,
    out: str | None,
    rate: float,
    duration: float | None,
    as_json: bool,
) -> None:
    """Write a gait as a file, or as set-points for the joints of a real robot.

    \b
    Examples:
      rrrobot gait --gait circular --amplitude 0.2 --out mine.json
      rrrobot gait --gait mine.json --rate 100 --out joints.csv
      rrrobot gait --gait recorded.csv --duration 10 --out joints.yaml
    """
    target = None if out is None else check_writable(out)
    if target is not None and target.suffix.lower() not in _SUFFIXES:
        raise OutputError(f"cannot write {out!r}: --out ends in {' or '.join(_SUFFIXES)}.")
    body = robot.build_level()
    legs = gait.build(body, robot)
    written: list[Path] = []
    data: dict[str, Any] = {"gait": legs.to_dict(), "period": legs.period, "legs": list(body.legs)}
    period = "no period" if legs.period is None else f"period {legs.period:.6g} s"
    text = f"{gait_words(data['gait'])}, {period}"
    if target is not None and target.suffix.lower() == ".json":
        written.append(write_gait(legs, target))
    elif target is not None:
        table = gait_table(legs, rate, duration=duration, joints=body.legs,
                           slides=sliding(body.model, body.legs))  # fmt: skip
        write = table.to_csv if target.suffix.lower() == ".csv" else table.to_ros
        written.append(write(target))
        data |= {"set_points": len(table.time), "rate": table.rate_hz}
        text += f"\n{len(table.time)} set-points at {table.rate_hz:.6g} 1/s"
    tell(data, text, written, as_json=as_json)
