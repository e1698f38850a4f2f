"""`rrrobot sweep`: grids of gaits and of robots -> a table, a netCDF file, maps."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from rrrobot.checks import Array
from rrrobot.cli_build import DECOUPLED, MODELS, Options, build_damping, build_robot
from rrrobot.cli_options import option_group, robot_options
from rrrobot.cli_report import aligned, to_json
from rrrobot.cli_types import Numbers, parse_number
from rrrobot.errors import OutputError
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.robot import Robot
from rrrobot.sweep import LARGEST
from rrrobot.sweep import sweep as run_sweep
from rrrobot.sweep_models import DecoupledModels, Swept
from rrrobot.sweep_store import STATUS

if TYPE_CHECKING:
    import xarray as xr

    _ParamType = click.ParamType[Any, Any]
else:
    _ParamType = click.ParamType

SETTLED = 0.05
"""Variation from cycle to cycle up to which a gait counts as the fastest."""
_PLANE = {
    "offset": "0:pi:40",
    "phase_difference": "0:2*pi:40",
    "amplitude": "0.3",
    "frequency": "8",
}
_GRIDS = ("offset", "phase_difference", "phase", "amplitude", "frequency")
_MOST_MODULATED = 21
"""Offsets of Fig 20; each takes a search by the yaw model."""


class Grid(_ParamType):
    """[NAME=]START:STOP:COUNT, V1,V2,... or one number -> (name or None, grid)."""

    name = "grid"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[str | None, float | Array]:
        if not isinstance(value, str):
            return value
        label, _, text = value.rpartition("=")
        try:
            return label or None, parse_grid(text)
        except ValueError as error:
            self.fail(str(error), param, ctx)


def parse_grid(text: str) -> float | Array:
    """START:STOP:COUNT with both ends, a list with commas, or a number.

    Raises:
        ValueError: anything else.

    Example:
        >>> parse_grid("0:pi:3").round(3).tolist()
        [0.0, 1.571, 3.142]
    """
    parts = text.split(":")
    if len(parts) == 1:
        values = [parse_number(entry) for entry in text.split(",")]
        return values[0] if len(values) == 1 else np.array(values)
    if len(parts) != 3 or re.fullmatch(r"\d{1,9}", parts[2].strip()) is None:
        raise ValueError(f"{text!r} is no grid: write START:STOP:COUNT, such as 0:pi:40.")
    count = int(parts[2])
    if not 1 <= count <= LARGEST:
        raise ValueError(f"{text!r} has {count} values: from 1 to {LARGEST} are allowed.")
    return np.linspace(parse_number(parts[0]), parse_number(parts[1]), count)


GRID = Grid()


def _grid_option(name: str, help_text: str) -> Callable[[Any], Any]:
    return click.option(
        f"--{name}", type=GRID, multiple=True, metavar="[NAME=]GRID", help=help_text
    )


grid_options = option_group(
    _grid_option("offset", "Centre of the swing [rad]; pi/2 is up."),
    _grid_option("phase-difference", "By which leg 2 leads leg 1 [rad]; pi/2 unless given."),
    _grid_option("phase", "Of each leg instead [rad]."),
    _grid_option("amplitude", "Of the swing [rad]; 0.3 unless given."),
    _grid_option("frequency", "Angular, of all legs [rad/s]; 8 unless given."),
    _grid_option("parameter", "RRRobot: as leg_mass=0.04:0.08:5 or shell_radius=0.1,0.12."),
    click.option(
        "--paper",
        is_flag=True,
        help="The paper's plane: offsets 0 .. pi by phase differences 0 .. 2 pi, 40 by 40, "
        "amplitude 0.3, frequency 8. Grids that are given replace these.",
    ),
)

run_options = option_group(
    click.option("--cycles", type=int, default=38, show_default=True, help="Of each gait."),
    click.option("--counted", type=int, help="Of these, at the end; those in the second half."),
    click.option("--steps", type=int, default=10, show_default=True, help="For each cycle."),
    click.option(
        "--damping",
        type=Numbers(1, 3),
        help="Viscous loss, one number or R,P,Y [N m s/rad]; 0.01 unless given, on the axes that "
        "the paper damps.",
    ),
    click.option(
        "--damping-kind",
        type=click.Choice(("euler", "body")),
        help="Of the rates of roll, pitch, yaw (the paper), or of the rates about the body's axes.",
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
    folder = None if options["figures"] is None else _folder(options["figures"], grids, parameters)
    robot = build_robot(options)
    model = _model(options["model"], robot, options)
    run = {
        "cycles": options["cycles"],
        "counted": options["counted"],
        "steps_per_cycle": options["steps"],
        "threads": options["threads"],
        "progress": False if options["quiet"] else None,
    }
    started = time.perf_counter()
    ds = run_sweep(
        model,
        **grids,
        parameters=parameters,
        store=options["out"],
        resume=options["resume"],
        **run,
    )
    data = summary(ds, time.perf_counter() - started)
    files = [] if options["out"] is None else [Path(options["out"])]
    plane = ds.speed.squeeze().dims == ("offset", "phase_difference") and not parameters
    if folder is not None and plane and options["paper"] and options["model"] == "full":
        make = partial(_model, robot=robot, options=options)
        files += _write_figures(draw_paper(ds, make, grids, run), folder)
    elif folder is not None:
        files += _write_figures(draw(ds), folder)
    data["files"] = [str(path) for path in files]
    if options["as_json"]:
        click.echo(to_json(data))
        return
    click.echo(table(data))
    for path in files:
        click.echo(f"wrote {path}")


def build_grids(options: Options) -> tuple[dict[str, Any], dict[str, Any]]:
    """Grids and robot parameters as `sweep` takes them.

    Raises:
        click.UsageError: a grid for one leg beside one for all, or one given twice.
    """
    entries = {name: list(options[name]) for name in _GRIDS}
    if options["paper"]:
        if options["phase"]:
            raise click.UsageError("--phase does not go with --paper: it has phase differences.")
        for name, text in _PLANE.items():
            entries[name] = entries[name] or [(None, parse_grid(text))]
    grids: dict[str, Any] = {}
    for name, given in entries.items():
        option, legs = f"--{name.replace('_', '-')}", [leg for leg, _ in given]
        if len(set(legs)) != len(legs) or (None in legs and len(legs) > 1):
            raise click.UsageError(f"{option}: give one grid for all legs, or one JOINT=GRID each.")
        if given:
            key = "angular_frequency" if name == "frequency" else name
            grids[key] = dict(given) if legs[0] else given[0][1]
    parameters: dict[str, Any] = {}
    for name, grid in options["parameter"]:
        if name is None or name in parameters:
            raise click.UsageError("--parameter: write NAME=GRID, each NAME once.")
        parameters[name] = np.atleast_1d(grid)
    return grids, parameters


def summary(ds: xr.Dataset, seconds: float) -> dict[str, Any]:
    """What a sweep found, as plain data in SI units."""
    status = ds.status.to_numpy()
    steady = ds.variation <= SETTLED
    return {
        "title": ds.attrs["title"],
        "gaits": status.size,
        "sizes": {str(dim): size for dim, size in ds.sizes.items() if dim in ds.speed.dims},
        "cycles": ds.attrs["cycles"],
        "counted": ds.attrs["counted"],
        "seconds": seconds,
        "status": {word: int((status == code).sum()) for code, word in STATUS.items()},
        "unsettled": int((ds.variation > SETTLED).sum()),
        "through_ground": int((ds.clearance <= 0).sum()),
        "fastest": _gait(ds, ds.speed.where(steady)),
        "fastest_turn": _gait(ds, abs(ds.yaw_rate).where(steady)),
    }


def _gait(ds: xr.Dataset, goal: xr.DataArray) -> dict[str, Any] | None:
    """The gait that has the most of something."""
    if not goal.notnull().any():
        return None
    best = ds[["speed", "velocity_y", "yaw_rate", "curvature"]].isel(goal.argmax(...))
    return {str(name): np.asarray(value).tolist() for name, value in best.variables.items()}


def table(data: dict[str, Any]) -> str:
    """The summary in lines of "name  value", in everyday units."""
    sizes = " x ".join(f"{size} {dim}" for dim, size in data["sizes"].items())
    rate = data["gaits"] / max(data["seconds"], 1e-9)
    rows = [
        ("sweep", data["title"]),
        ("gaits", f"{data['gaits']}: {sizes}" if sizes else "1"),
        ("time", f"{data['seconds']:.2f} s, {rate:.0f} gaits/s"),
        ("cycles", f"{data['cycles']}, the last {data['counted']} counted"),
    ]
    for word, count in data["status"].items():
        if count and word != "steady_state":
            rows.append(("stopped", f"{count}: {word.replace('_', ' ')}"))
    if data["unsettled"]:
        rows.append(("not settled", f"{data['unsettled']}, steps vary by more than 5 %"))
    if data["through_ground"]:
        rows.append(("through the ground", f"{data['through_ground']} gaits swing a leg there"))
    for name, label in (("fastest", "fastest"), ("fastest_turn", "fastest turn")):
        best = data[name]
        if best is not None:
            rows.append((label, f"v {1000 * best['speed']:.4f} mm/s, {best['yaw_rate']:.6f} rad/s"))
            rows.append(("  at", _place(best)))
    return aligned(rows)


def _place(best: dict[str, Any]) -> str:
    skip = ("speed", "velocity_y", "yaw_rate", "curvature", "leg")
    return ", ".join(
        f"{name.replace('_', ' ')} {value:.5g}"
        for name, value in best.items()
        if name not in skip and isinstance(value, float) and math.isfinite(value)
    )


def draw(ds: xr.Dataset) -> dict[str, Any]:
    """Figures of a sweep over two grids by file name."""
    from rrrobot.figures import maps

    figures: dict[str, Any] = {
        "translation": maps.translation(ds),
        "amplitudes": maps.amplitudes(ds),
        "inverse": maps.inverse(ds),
    }
    phase = maps.phase_difference(ds)
    if phase.notnull().any():
        figures["phase_difference"] = maps.value_map(phase).figure
    return figures


def draw_paper(
    full: xr.Dataset, make: Callable[[str], Any], grids: Options, run: Options
) -> dict[str, Any]:
    """The paper's figures by file name, with sweeps of the single-axis models.

    Args:
        full: sweep of the full model over the paper's plane.
        make: makes a model by its name.
        grids, run: of that sweep.
    """
    from rrrobot.figures import maps

    pitch, yaw = (run_sweep(make(name), **grids, **run) for name in ("pitch", "yaw"))
    decoupled = make(DECOUPLED)
    thin = slice(None, None, math.ceil(full.sizes["offset"] / _MOST_MODULATED))
    modulation = maps.amplitude_modulation(decoupled.robot, full.isel(offset=thin))
    known = modulation.dropna("offset").sortby("offset")
    everywhere = np.full(full.sizes["offset"], np.nan)
    if known.size:
        everywhere = np.interp(full.offset, known.offset, known)
    amplitude = full.offset.copy(data=everywhere)
    single = run_sweep(decoupled, **grids, **run, yaw_amplitude=amplitude)
    phases = maps.phase_difference(full), maps.phase_difference(pitch, yaw)
    return {
        "fig_11_pitch_amplitude": maps.side_by_side(
            full.pitch_amplitude, pitch.pitch_amplitude, ("full model", "pitch model")
        ),
        "fig_12_yaw_amplitude": maps.side_by_side(
            full.yaw_amplitude, yaw.yaw_amplitude, ("full model", "yaw model")
        ),
        "fig_14_phase_difference": maps.side_by_side(*phases),
        "fig_18_translation": maps.translation(full),
        "fig_19_translation_decoupled": maps.translation(single),
        "fig_20_modulation": maps.modulation(modulation).figure,
        "fig_21_inverse": maps.inverse(full),
        "fig_22_inverse_decoupled": maps.inverse(single),
    }


def _model(name: str, robot: Robot, options: Options) -> Swept:
    damping = build_damping(options)
    given: dict[str, Any] = {} if damping is None else {"damping": damping}
    if name != DECOUPLED:
        return MODELS[name](robot, **given)
    return DecoupledModels(
        robot, RollModel(robot, **given), PitchModel(robot, **given), YawModel(robot, **given)
    )


def _write_figures(figures: dict[str, Any], folder: Path) -> list[Path]:
    from rrrobot.figures.style import write_figure

    return [write_figure(figure, folder / f"{name}.png") for name, figure in figures.items()]


def _folder(name: str, grids: dict[str, Any], parameters: dict[str, Any]) -> Path:
    """Make the folder of the figures, if this sweep has any."""
    every: list[Any] = [*parameters.values()]
    for grid in grids.values():
        every += grid.values() if isinstance(grid, dict) else [grid]
    wide = sum(np.size(grid) > 1 for grid in every)
    if wide != 2:
        raise click.UsageError(f"--figures draws maps over two grids; this sweep has {wide}.")
    folder = Path(name)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder {name!r}: {error.strerror}.") from None
    return folder
