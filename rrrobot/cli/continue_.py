"""`rrrobot continue`: a branch of limit cycles in one parameter."""

from __future__ import annotations

from pathlib import Path

import click

from rrrobot.cli.options.drive import GaitOptions
from rrrobot.cli.options.group import takes
from rrrobot.cli.options.orbit import OrbitOptions
from rrrobot.cli.options.robot import DampingOptions, GroundOptions, RobotOptions
from rrrobot.cli.report import tell
from rrrobot.cli.types import NUMBER
from rrrobot.drawing import write_figure
from rrrobot.files import check_writable
from rrrobot.inline import aligned


@click.command("continue")
@takes(
    orbit=OrbitOptions,
    robot=RobotOptions,
    ground=GroundOptions,
    gait=GaitOptions,
    damping=DampingOptions,
)
@click.option(
    "--in", "parameter", required=True, metavar="NAME",
    help="Parameter: amplitude, offset[0], angular_frequency, leg_mass, damping ... A wrong name "
    "lists all.",
)  # fmt: skip
@click.option("--to", "goal", type=NUMBER, required=True, help="Its value at the end.")
@click.option("--step", type=NUMBER, help="Largest step along the branch; 0.1 unless given.")
@click.option("--n-points", type=click.IntRange(1), default=500, show_default=True, help="At most.")
@click.option("--out", metavar="FILE", help="Dataset: .nc. If it is there, it is gone on from.")
@click.option("--plot", metavar="FILE", help="Bifurcation diagram of --of: .png, .svg.")
@click.option("--of", "output", default="speed", show_default=True, help="What is drawn.")
@click.option("--json", "as_json", is_flag=True, help="As JSON, SI units.")
def continue_command(
    orbit: OrbitOptions,
    robot: RobotOptions,
    ground: GroundOptions,
    gait: GaitOptions,
    damping: DampingOptions,
    parameter: str,
    goal: float,
    step: float | None,
    n_points: int,
    out: str | None,
    plot: str | None,
    output: str,
    as_json: bool,
) -> None:
    """Follow a limit cycle as one parameter changes, through folds.

    Folds, period doublings, torus bifurcations and branch points are located and listed.

    \b
    Examples:
      rrrobot continue --offset pi/2 --amplitude 0.2 --frequency 5.2 --phase 0 --in amplitude \
        --to 0.7 --of pitch_amplitude --plot branch.png
      rrrobot continue --gait circular --in leg_mass --to 0.08 --out branch.nc
    """
    path = None if plot is None else check_writable(Path(plot))
    cycle = orbit.build(robot, ground, gait, damping)
    from rrrobot.orbits.branches import branch

    line = branch(cycle, parameter, goal, step=step, n_points=n_points, store=out)
    files = [] if out is None else [Path(out)]
    if path is not None:
        files.append(write_figure(line.plot(output).figure, path))
    rows = [
        (parameter, f"{line.value.min():.6g} .. {line.value.max():.6g} {line.unit}"),
        ("points", f"{len(line.cycles)}, {int(line.stable.sum())} stable"),
        *((kind, f"{line.value[i]:.10g} {line.unit}") for kind, i in line.special),
        ("ended", line.ended),
    ]
    data = {
        "parameter": parameter,
        "value": line.value,
        "stable": line.stable,
        "speed": [c.speed for c in line.cycles],
        "yaw_rate": [c.yaw_rate for c in line.cycles],
        "special": [{"kind": kind, "value": line.value[i]} for kind, i in line.special],
        "ended": line.ended,
    }
    tell(data, aligned(rows), files, as_json=as_json)
