"""`rrrobot robots`."""

from __future__ import annotations

from typing import Any

import click

from rrrobot.cli.report import to_json
from rrrobot.errors import MissingExtraError
from rrrobot.robot.examples import UNSTICK, example_robots
from rrrobot.robot.robot import Robot

GENERATED = {"legged:6": "six legs of three joints", "legged:1x3": "one leg of three joints"}
"""Robots made from parameters, as `rrrobot unstick` takes them; any other numbers do too."""


@click.command()
@click.option("--json", "as_json", is_flag=True, help="As JSON.")
def robots(as_json: bool) -> None:
    """List the robots that --robot takes.

    RRRobot is built in, and so are robots of N legs with J joints each, legged:NxJ. The others come
    with example-robot-data (extra 'robots'): any of them rolls on the belly that --shell-radius
    gives it. Those with a star are tried with 'rrrobot unstick', which finds their bellies itself.

    \b
    Example:
      rrrobot robots
      rrrobot unstick solo12
      rrrobot simulate --robot solo12 --shell-radius 0.3 --shell-center 0 0 0.17 --offset pi \
        --legs FL_HFE,FR_HFE,HL_HFE,HR_HFE --amplitude 0.5 --frequency 6 --phase 0,pi/2,0,pi/2 \
        --damping 0.3 --damping-kind body
    """
    rrrobot = Robot.from_parameters()
    found: list[dict[str, Any]] = [
        {"name": "rrrobot", "source": "built in: Table 2 of the paper", "legs": [*rrrobot.legs]}
    ]
    found += [
        {"name": name, "source": f"generated: {text}", "unstick": True}
        for name, text in GENERATED.items()
    ]
    missing = None
    try:
        found += [
            {"name": n, "source": "example-robot-data", "unstick": n in UNSTICK}
            for n in example_robots()
        ]
    except MissingExtraError as error:
        missing = str(error)
    if as_json:
        click.echo(to_json(found))
    else:
        width = max(len(robot["name"]) for robot in found)
        for robot in found:
            star = "*" if robot.get("unstick") else " "
            click.echo(f"{star} {robot['name']:<{width}}  {robot['source']}")
    if missing is not None:
        click.echo(f"Note: {missing}", err=True)
