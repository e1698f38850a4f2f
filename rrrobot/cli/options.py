"""Groups of options that several commands share: robot, gait, torques, run, start.

A group is a decorator. A command receives its options as one dictionary, `**options`, and hands it
to the `build_...` functions of `build.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from rrrobot.cli.types import NUMBER, PER_LEG, Numbers

GAITS = ("lateral", "circular")


def option_group(*options: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Several options as one decorator, in the order of --help."""

    def decorate(command: Any) -> Any:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


robot_options = option_group(
    click.option("--urdf", metavar="FILE", help="Robot from a URDF; needs --shell-radius."),
    click.option(
        "--robot",
        metavar="NAME",
        help="Robot of example-robot-data, as 'rrrobot robots' lists them; needs --shell-radius.",
    ),
    click.option("--shell-radius", type=NUMBER, help="Radius of the round belly [m]."),
    click.option(
        "--shell-center",
        type=NUMBER,
        nargs=3,
        metavar="X Y Z",
        help="Its centre in the frame of its link [m]; 0 0 0 unless given.",
    ),
    click.option("--shell-link", metavar="NAME", help="Its link; the root link unless given."),
    click.option(
        "--legs",
        metavar="NAMES",
        help="Joints of the legs, as J1,J2,...; all movable joints unless given. The others are "
        "held at zero.",
    ),
    click.option("--leg-mass", type=PER_LEG, help="RRRobot: mass at each leg tip [kg]."),
    click.option("--servo-mass", type=PER_LEG, help="RRRobot: mass at each hip [kg]."),
    click.option("--battery-mass", type=NUMBER, help="RRRobot: mass at the bottom [kg]."),
    click.option("--leg-length", type=PER_LEG, help="RRRobot: length of each leg [m]."),
    click.option("--hip-offset", type=NUMBER, help="RRRobot: from the centre to each hip [m]."),
    click.option("--gravity", type=NUMBER, help="[m/s^2]; 9.81 unless given."),
    click.option(
        "--ground-normal",
        type=NUMBER,
        nargs=3,
        metavar="X Y Z",
        help="Of a slope; gravity stays along -z.",
    ),
)

gait_options = option_group(
    click.option(
        "--gait",
        type=click.Choice((*GAITS, "still")),
        help="Gait of the paper (leg 2 leads leg 1 by pi/2), or legs held still at --offset; "
        "lateral unless given. The four options below change it.",
    ),
    click.option("--offset", type=PER_LEG, help="Centre of the swing [rad]; pi/2 is up."),
    click.option("--amplitude", type=PER_LEG, help="Of the swing [rad]; 0.3 unless given."),
    click.option("--frequency", type=PER_LEG, help="Angular [rad/s]; 8 unless given."),
    click.option(
        "--phase", type=PER_LEG, help="[rad]; 0,pi/2 on two legs, 0 on more, unless given."
    ),
    click.option("--ramp", type=NUMBER, metavar="SECONDS", help="Start from rest and blend in."),
)

drive_options = option_group(
    click.option(
        "--torque",
        type=PER_LEG,
        help="Constant motor torques [N m] instead of a gait; --offset is where the legs start.",
    ),
)


run_options = option_group(
    click.option("--duration", type=NUMBER, default="30", show_default=True, help="[s]"),
    click.option(
        "--sample-interval", type=NUMBER, default="0.01", show_default=True, help="Of results [s]."
    ),
    click.option("--step", type=NUMBER, help="Fixed step of the integrator [s]."),
    click.option("--rtol", type=NUMBER, help="Relative tolerance of its adaptive step; 1e-10."),
    click.option(
        "--method",
        type=click.Choice(("kkt", "momentum")),
        help="kkt, the general form, unless given; momentum, faster, for gaits on level ground.",
    ),
)

damping_options = option_group(
    click.option(
        "--damping",
        type=Numbers(1, 3),
        help="Viscous loss, one number or R,P,Y [N m s/rad]; 0.01 unless given, on the axes that "
        "the paper damps.",
    ),
    click.option(
        "--damping-kind",
        type=click.Choice(("euler", "body")),
        help="Of the rates of roll, pitch, yaw (the paper; singular at a pitch of 90 degrees), or "
        "of the rates about the body's axes; euler unless given.",
    ),
)

start_options = option_group(
    click.option(
        "--start",
        type=Numbers(3, words=("impulsive", "rest")),
        default="impulsive",
        show_default=True,
        metavar="HOW",
        help="impulsive: the legs' speed sets the body going without momentum; rest; or the rates "
        "of roll, pitch, yaw as R,P,Y [rad/s].",
    ),
    click.option("--euler", type=Numbers(3), help="Roll, pitch, yaw at the start [rad], as R,P,Y."),
)
