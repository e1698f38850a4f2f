"""`rrrobot lab`: a gait under your hands."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import click

from rrrobot.cli.compile import tell_of_compiling
from rrrobot.cli.options.group import takes
from rrrobot.cli.options.robot import RobotOptions

if TYPE_CHECKING:
    from rrrobot.belly.found import Belly
    from rrrobot.robot.robot import Robot


@click.command("lab")
@takes(robot=RobotOptions)
@click.option("--port", type=int, help="Of the page; any free one unless given.")
@click.option("--no-browser", is_flag=True, help="Print the address, open no browser.")
def lab_command(robot: RobotOptions, port: int | None, no_browser: bool) -> None:
    """Open the laboratory: every move of a slider redraws the robot's whole path.

    Prints the address of the page, which only this computer can open, and serves it until Ctrl-C.
    Needs viser: pip install 'rrrobot[lab]'. Without --shell-radius the belly of a robot other than
    RRRobot is fitted to its meshes, and it lies on that with its legs clear of the ground.

    \b
    Examples:
      rrrobot lab
      rrrobot lab --leg-mass 0.08 --port 8080
      rrrobot lab --robot solo12
      rrrobot lab --robot solo12 --shell-radius 0.3 --shell-center 0 0 0.17 \
        --legs FL_HFE,FR_HFE,HL_HFE,HR_HFE
    """
    own = robot.is_rrrobot or robot.shell_radius is not None
    made = robot.build_level() if own else _fitted(robot)
    # Numba and viser load here, so that they cost nobody who does not use them.
    from rrrobot.lab.server import laboratory

    tell_of_compiling(quiet=False, alone=True)
    with laboratory(made, port=port, open_browser=not no_browser) as lab:
        click.echo(f"{lab.url}  (Ctrl-C ends)")
        try:
            lab.wait()
        except KeyboardInterrupt:
            click.echo("closed", err=True)


def _fitted(robot: RobotOptions) -> Belly:
    """The belly of the options' robot, which say nothing of a shell."""
    from rrrobot.belly.fit import fit_belly

    robot.refuse(("shell_center", "shell_link"), "need --shell-radius")
    bare: Robot = replace(robot, shell_radius=1.0).build_level()
    click.echo(f"fitting the belly of {bare.name}", err=True)
    belly = fit_belly(bare)
    if belly.reason:
        click.echo(f"Note: {belly.reason}", err=True)
    return belly
