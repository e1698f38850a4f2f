"""`rrrobot sweep`: grids of gaits and of robots -> a table, a netCDF file, maps."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import click

from rrrobot.cli.compile import tell_of_compiling
from rrrobot.cli.options.group import Group, option, takes
from rrrobot.cli.options.robot import (
    DECOUPLED,
    MODELS,
    DampingOptions,
    GroundOptions,
    Parts,
    RobotOptions,
)
from rrrobot.cli.report import tell
from rrrobot.cli.sweep_grids import GridOptions
from rrrobot.cli.sweep_report import (
    draw,
    draw_paper,
    folder_of,
    slices,
    summary,
    table,
    write_figures,
)
from rrrobot.errors import ParameterError
from rrrobot.models.base import Model
from rrrobot.models.recombined import DecoupledModels
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.studies.sweeps.run import sweep as run_sweep


@dataclass(frozen=True, kw_only=True)
class CountOptions(Group):
    """How each gait is simulated."""

    cycles: int | None = option(
        "--cycles",
        type=int,
        help="Of each gait; 38 unless given, and more where the robot's slowest decay needs more.",
    )
    counted: int | None = option(
        "--counted", type=int, help="Of these, at the end; 18, or with --cycles the second half."
    )
    steps: int = option("--steps", type=int, default=10, show_default=True, help="For each cycle.")
    loads: bool = option(
        "--loads",
        is_flag=True,
        help="Also the motors' torques and power and the friction needed, in the last cycle; best "
        "with --steps 20.",
    )
    settle: str = option(
        "--settle",
        type=click.Choice(("cycles", "orbit")),
        default="cycles",
        show_default=True,
        help="cycles: simulate them; orbit: find each gait's limit cycle directly.",
    )
    threads: int | None = option("--threads", type=int, help="One for each core unless given.")

    def settings(self, *, quiet: bool) -> dict[str, Any]:
        """Keywords of `sweep`, without the loads."""
        return {
            "cycles": self.cycles,
            "counted": self.counted,
            "steps_per_cycle": self.steps,
            "settle": self.settle,
            "threads": self.threads,
            "progress": False if quiet else None,
        }


@dataclass(frozen=True, kw_only=True)
class SweepOutput(Group):
    """What is printed and written."""

    out: str | None = option(
        "--out", metavar="FILE", help="Dataset: .nc. Each chunk is written as it is finished."
    )
    resume: bool = option(
        "--resume/--no-resume",
        default=True,
        help="Go on with FILE if it is there (default), or replace it.",
    )
    figures: str | None = option(
        "--figures",
        metavar="DIR",
        help="Maps over two grids as .png, slices of more grids; with --paper and the full model "
        "also those beside the single-axis models.",
    )
    as_json: bool = option("--json", is_flag=True, help="Summary as JSON, SI units.")
    quiet: bool = option("--quiet", is_flag=True, help="No progress bar.")


@click.command("sweep")
@click.option("--model", type=click.Choice((*MODELS, DECOUPLED)), default="full", show_default=True)
@takes(
    grids=GridOptions,
    robot=RobotOptions,
    ground=GroundOptions,
    count=CountOptions,
    damping=DampingOptions,
    output=SweepOutput,
)
def sweep_command(
    model: str,
    grids: GridOptions,
    robot: RobotOptions,
    ground: GroundOptions,
    count: CountOptions,
    damping: DampingOptions,
    output: SweepOutput,
) -> None:
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
    axes, parameters = grids.build()
    folder = None if output.figures is None else folder_of(output.figures, axes, parameters)
    parts = Parts.of(robot, ground, damping)
    swept = _model(model, parts)
    run = count.settings(quiet=output.quiet)
    if count.loads and model == DECOUPLED:
        raise ParameterError(
            "--loads is given with --model decoupled: models side by side have no common torques; "
            "choose one model, such as full."
        )
    tell_of_compiling(quiet=output.quiet, loads=count.loads)
    started = time.perf_counter()
    ds = run_sweep(
        swept,
        **axes,
        parameters=parameters,
        store=output.out,
        resume=output.resume,
        loads=count.loads,
        **run,
    )
    data = summary(ds, time.perf_counter() - started)
    files = [] if output.out is None else [Path(output.out)]
    plane = ds.speed.squeeze().dims == ("offset", "phase_difference") and not parameters
    if folder is not None and plane and grids.paper and model == "full":
        files += write_figures(draw_paper(ds, partial(_model, parts=parts), axes, run), folder)
    elif folder is not None:
        parts_of, note = slices(ds)
        for suffix, part in parts_of.items():
            files += write_figures(draw(part, suffix), folder)
        if note is not None:
            click.echo(note, err=True)
    tell(data, table(data), files, as_json=output.as_json)


def _model(name: str, parts: Parts) -> Model:
    if name != DECOUPLED:
        return parts.model(MODELS[name])
    return DecoupledModels(
        parts.robot, parts.model(RollModel), parts.model(PitchModel), parts.model(YawModel)
    )
