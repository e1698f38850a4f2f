"""`rrrobot simulate`: one run, summed up, plotted, filmed, saved."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from rrrobot.cli.compile import tell_of_compiling
from rrrobot.cli.options.drive import GaitOptions, TorqueOptions
from rrrobot.cli.options.group import Group, option, takes
from rrrobot.cli.options.robot import (
    DECOUPLED,
    MODELS,
    DampingOptions,
    GroundOptions,
    Parts,
    RobotOptions,
)
from rrrobot.cli.options.run import RunOptions, StartOptions
from rrrobot.cli.report import summary, table, tell
from rrrobot.drive.gaits import Gait
from rrrobot.drive.torques import LegTorques
from rrrobot.errors import OutputError, SimulationError
from rrrobot.files import check_writable
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.simulation.recombined import decoupled
from rrrobot.simulation.run import simulate as run_model
from rrrobot.simulation.trajectory import Trajectory

SUFFIXES = {
    "plot": (".png", ".pdf", ".svg"),
    "html": (".html", ".htm"),
    "film": (".mp4", ".gif", ".png", ".html"),
    "save": (".npz",),
    "csv": (".csv",),
    "mat": (".mat",),
}


@dataclass(frozen=True, kw_only=True)
class OutputOptions(Group):
    """What is printed and written."""

    as_json: bool = option("--json", is_flag=True, help="Summary as JSON, SI units.")
    plot: str | None = option("--plot", metavar="FILE", help="Plots: .png, .pdf or .svg.")
    html: str | None = option(
        "--html", metavar="FILE", help="Film that plays in any browser: .html."
    )
    film: str | None = option(
        "--film", metavar="FILE", help="Film as .mp4, .gif or .html, or its end as .png."
    )
    save: str | None = option(
        "--save",
        metavar="FILE",
        help="The whole trajectory: .npz, for Trajectory.load and 'rrrobot view'. Written too if "
        "the run stops early.",
    )
    csv: str | None = option(
        "--csv", metavar="FILE", help="All samples as a table, units in its head: .csv."
    )
    mat: str | None = option("--mat", metavar="FILE", help="All samples for MATLAB: .mat.")
    quiet: bool = option("--quiet", is_flag=True, help="No progress bar.")

    def files(self) -> dict[str, Path]:
        """Checked paths of what is to be written."""
        return {key: checked_file(key, name) for key, name in self.given(*SUFFIXES).items()}


@click.command()
@click.option(
    "--model",
    type=click.Choice((*MODELS, DECOUPLED)),
    default="full",
    show_default=True,
    help="full: the robot rolls; pivoting: it turns about its centre; roll, pitch, yaw: about one "
    "axis; decoupled: these three recombined by rolling.",
)
@takes(
    robot=RobotOptions,
    ground=GroundOptions,
    gait=GaitOptions,
    torque=TorqueOptions,
    run=RunOptions,
    start=StartOptions,
    damping=DampingOptions,
    output=OutputOptions,
)
def simulate(
    model: str,
    robot: RobotOptions,
    ground: GroundOptions,
    gait: GaitOptions,
    torque: TorqueOptions,
    run: RunOptions,
    start: StartOptions,
    damping: DampingOptions,
    output: OutputOptions,
) -> None:
    """Simulate a round robot that swings its legs.

    The legs follow a gait, or are driven by constant torques.

    Prints a summary; means and amplitudes are of whole cycles in the second half of the run, after
    the ramp. The robot is RRRobot, with Table 2's masses and lengths unless told otherwise, or any
    URDF with a round belly.

    Units are SI, angles in radians. A number may be written pi, pi/2 or 3*pi/4; where an option is
    per leg, give one number for all legs or one for each, with commas between.

    \b
    Examples:
      rrrobot simulate --gait circular --plot circular.png --html circular.html
      rrrobot simulate --offset pi/2,pi/4 --amplitude 0.2 --duration 60 --json
      rrrobot simulate --ground slope:5 --csv run.csv
      rrrobot simulate --robot solo12 --shell-radius 0.3 --shell-center 0 0 0.17 --offset pi \
        --legs FL_HFE,FR_HFE,HL_HFE,HR_HFE --amplitude 0.5 --frequency 6 --phase 0,pi/2,0,pi/2 \
        --damping 0.3 --damping-kind body
    """
    files, settings = output.files(), run.settings()
    parts = Parts.of(robot, ground, damping)
    drive = torque.build(gait, parts.robot, robot)
    if settings.get("method") == "momentum" and model != DECOUPLED:
        tell_of_compiling(quiet=output.quiet, alone=True)
    try:
        settings["progress"] = False if output.quiet else None
        trajectory = _simulate(model, parts, drive, start, settings)
    except SimulationError as error:
        raise _with_partial_run(error, files.get("save")) from None
    data = summary(trajectory)
    written = write_outputs(trajectory, files)
    tell(data, table(data), written, as_json=output.as_json)


def _simulate(
    name: str,
    parts: Parts,
    drive: Gait | LegTorques,
    start: StartOptions,
    settings: dict[str, Any],
) -> Trajectory:
    if name != DECOUPLED:
        settings |= start.given("start", "euler")
        return run_model(parts.model(MODELS[name]), drive, **settings)
    if start.start != "impulsive" or start.euler is not None:
        raise click.UsageError("--start and --euler do not go with --model decoupled.")
    if not isinstance(drive, Gait):
        raise click.UsageError("--torque does not go with --model decoupled: it needs a gait.")
    if "method" in settings:
        raise click.UsageError("--method does not go with --model decoupled: it has its own.")
    return decoupled(
        parts.robot,
        drive,
        roll=parts.model(RollModel),
        pitch=parts.model(PitchModel),
        yaw=parts.model(YawModel),
        **settings,
    )


def write_outputs(trajectory: Trajectory, files: dict[str, Path]) -> list[Path]:
    """Write the trajectory, its tables, the plot and the film, as far as they are asked for."""
    written = []
    if "save" in files:
        written.append(trajectory.save(files["save"]))
    if "csv" in files:
        written.append(trajectory.to_csv(files["csv"]))
    if "mat" in files:
        written.append(trajectory.to_mat(files["mat"]))
    if "plot" in files:
        from rrrobot.drawing import write_figure

        written.append(write_figure(trajectory.plot("all"), files["plot"]))
    for key in ("html", "film"):
        if key in files:
            from rrrobot.view.films import record

            written.append(record(trajectory, files[key]))
    return written


def checked_file(key: str, name: str) -> Path:
    """Path of an output option, a key of `SUFFIXES`, that can be written.

    Raises:
        OutputError: a wrong suffix, or no place to write.
    """
    path = Path(name)
    allowed = SUFFIXES[key]
    exact = path.suffix if key == "save" else path.suffix.lower()
    if exact not in allowed:
        raise OutputError(f"cannot write {name!r}: --{key} ends in {' or '.join(allowed)}.")
    return check_writable(path)


def _with_partial_run(error: SimulationError, path: Path | None) -> SimulationError:
    """The same error, saying where the samples up to the stop are."""
    if error.trajectory is None:
        return error
    # What a script would do about it, in words of the command line.
    message = re.sub(r" The \d+ samples up to then are in .*$", "", str(error))
    message = message.replace("BodyRateDamping", "--damping-kind body")
    samples = f"the {len(error.trajectory)} samples up to then"
    if path is None:
        note = f"With --save FILE {samples} would be kept."
    else:
        try:
            note = f"{samples.capitalize()} are in {error.trajectory.save(path)}."
        except OutputError as failure:
            note = f"{samples.capitalize()} are lost: {failure}"
    return type(error)(
        f"{message} {note}", time=error.time, state=error.state, trajectory=error.trajectory
    )
