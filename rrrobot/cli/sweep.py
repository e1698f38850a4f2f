"""`rrrobot sweep`: grids of gaits and of robots -> a table, a netCDF file, maps."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path
from typing import Any

import click

from rrrobot.cli.build import DECOUPLED, MODELS, Options, build_model, build_robot
from rrrobot.cli.compile import tell_of_compiling
from rrrobot.cli.options import damping_options, option_group, robot_options
from rrrobot.cli.report import tell
from rrrobot.cli.sweep_grids import build_grids, grid_options
from rrrobot.cli.sweep_report import draw, draw_paper, folder_of, summary, table, write_figures
from rrrobot.errors import ParameterError
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.robot.robot import Robot
from rrrobot.studies.sweeps.run import sweep as run_sweep
from rrrobot.studies.sweeps.variants import DecoupledModels, Swept

run_options = option_group(
    click.option("--cycles", type=int, default=38, show_default=True, help="Of each gait."),
    click.option("--counted", type=int, help="Of these, at the end; those in the second half."),
    click.option("--steps", type=int, default=10, show_default=True, help="For each cycle."),
    damping_options,
    click.option(
        "--loads",
        is_flag=True,
        help="Also the motors' torques and power and the friction needed, in the last cycle; best "
        "with --steps 20.",
    ),
    click.option("--threads", type=int, help="One for each core unless given."),
)

output_options = option_group(
    click.option(
        "--out", metavar="FILE", help="Dataset: .nc. Each chunk is written as it is finished."
    ),
    click.option(
        "--resume/--no-resume",
        default=True,
        help="Go on with FILE if it is there (default), or replace it.",
    ),
    click.option(
        "--figures",
        metavar="DIR",
        help="Maps over two grids as .png; with --paper and the full model also those beside the "
        "single-axis models.",
    ),
    click.option("--json", "as_json", is_flag=True, help="Summary as JSON, SI units."),
    click.option("--quiet", is_flag=True, help="No progress bar."),
)


@click.command("sweep")
@click.option("--model", type=click.Choice((*MODELS, DECOUPLED)), default="full", show_default=True)
@grid_options
@robot_options
@run_options
@output_options
def sweep_command(**options: Any) -> None:
    """Simulate grids of gaits, and of robots, to their steady states.

    A GRID is START:STOP:COUNT with both ends, a list with commas, or one number; numbers may be
    written pi, pi/2 or 2*pi. It holds for all legs; for one leg write JOINT=GRID, once for each.

    Prints a summary. With --out the results go to a netCDF file, which an interrupted sweep goes on
    from: give the same command again.

    \b
    Examples:
      rrrobot sweep --paper --out plane.nc --figures maps
      rrrobot sweep --offset pi/2 --amplitude 0.1:0.5:41 --frequency 6:10:41 --figures maps
      rrrobot sweep --offset leg_1=0:pi:60 --offset leg_2=0:pi:60 --model pivoting --json
      rrrobot sweep --offset pi/4 --parameter leg_mass=0.03:0.09:25
    """
    grids, parameters = build_grids(options)
    folder = (
        None if options["figures"] is None else folder_of(options["figures"], grids, parameters)
    )
    robot = build_robot(options)
    model = _model(options["model"], robot, options)
    run = {
        "cycles": options["cycles"],
        "counted": options["counted"],
        "steps_per_cycle": options["steps"],
        "threads": options["threads"],
        "progress": False if options["quiet"] else None,
    }
    if options["loads"] and options["model"] == DECOUPLED:
        raise ParameterError(
            "--loads is given with --model decoupled: models side by side have no common torques; "
            "choose one model, such as full."
        )
    tell_of_compiling(quiet=options["quiet"], loads=options["loads"])
    started = time.perf_counter()
    ds = run_sweep(
        model,
        **grids,
        parameters=parameters,
        store=options["out"],
        resume=options["resume"],
        loads=options["loads"],
        **run,
    )
    data = summary(ds, time.perf_counter() - started)
    files = [] if options["out"] is None else [Path(options["out"])]
    plane = ds.speed.squeeze().dims == ("offset", "phase_difference") and not parameters
    if folder is not None and plane and options["paper"] and options["model"] == "full":
        make = partial(_model, robot=robot, options=options)
        files += write_figures(draw_paper(ds, make, grids, run), folder)
    elif folder is not None:
        files += write_figures(draw(ds), folder)
    tell(data, table(data), files, as_json=options["as_json"])


def _model(name: str, robot: Robot, options: Options) -> Swept:
    if name != DECOUPLED:
        return build_model(MODELS[name], options, robot)
    parts = (build_model(kind, options, robot) for kind in (RollModel, PitchModel, YawModel))
    return DecoupledModels(robot, *parts)  # type: ignore[arg-type]
