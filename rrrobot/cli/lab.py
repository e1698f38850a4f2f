"""`rrrobot lab`: a gait under your hands."""

from __future__ import annotations

import click

from rrrobot.cli.compile import tell_of_compiling
from rrrobot.cli.options.group import takes
from rrrobot.cli.options.robot import RobotOptions


@click.command("lab")
@takes(robot=RobotOptions)
@click.option("--port", type=int, help="Of the page; any free one unless given.")
@click.option("--no-browser", is_flag=True, help="Print the address, open no browser.")
def lab_command(robot: RobotOptions, port: int | None, no_browser: bool) -> None:
    """Open the laboratory: every move of a slider redraws the robot's whole path.

    Prints the address of the page, which only this computer can open, and serves it until Ctrl-C.
    Needs viser: pip install 'rrrobot[lab]'.

    \b
    Examples:
      rrrobot lab
      rrrobot lab --leg-mass 0.08 --port 8080
      rrrobot lab --robot solo12 --shell-radius 0.3 --shell-center 0 0 0.17 \
        --legs FL_HFE,FR_HFE,HL_HFE,HR_HFE
    """
    made = robot.build()
    # Numba and viser load here, so that they cost nobody who does not use them.
    from rrrobot.lab.server import laboratory

    tell_of_compiling(quiet=False, alone=True)
    with laboratory(made, port=port, open_browser=not no_browser) as lab:
        click.echo(f"{lab.url}  (Ctrl-C ends)")
        try:
            lab.wait()
        except KeyboardInterrupt:
            click.echo("closed", err=True)
