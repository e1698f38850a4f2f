"""`rrrobot compare`: the models beside each other and beside the paper."""

from __future__ import annotations

import math
from pathlib import Path

import click
import numpy as np

from rrrobot.checks import finite
from rrrobot.cli.options.drive import GaitOptions
from rrrobot.cli.options.group import takes
from rrrobot.cli.options.robot import RobotOptions
from rrrobot.cli.report import grid, tell, to_json
from rrrobot.cli.types import NUMBER
from rrrobot.files import make_folder
from rrrobot.paper.table4 import PAPER, Table4, table_4
from rrrobot.robot.robot import Robot
from rrrobot.simulation.steady import SteadyState
from rrrobot.studies.comparison import MODELS, Comparison, compare

_AXES = ("roll", "pitch", "yaw")


@click.command("compare")
@takes(robot=RobotOptions, gait=GaitOptions)
@click.option("--duration", type=NUMBER, default="30", show_default=True, help="[s]")
@click.option("--json", "as_json", is_flag=True, help="As JSON, SI units.")
@click.option("--out", metavar="DIR", help="Also write paths.png, angles.png and rolling.png here.")
@click.option(
    "--plane",
    is_flag=True,
    help="Table 4: instead of one gait, all offsets 0 .. pi/2 by phase differences.",
)
@click.option(
    "--grid",
    type=(int, int),
    default=(7, 11),
    show_default=True,
    metavar="M N",
    help="Offsets and phase differences of --plane.",
)
@click.option("--quiet", is_flag=True, help="No progress bar.")
def compare_command(
    robot: RobotOptions,
    gait: GaitOptions,
    duration: float,
    as_json: bool,
    out: str | None,
    plane: bool,
    grid: tuple[int, int],
    quiet: bool,
) -> None:
    """Set the full, the pivoting and the single-axis models side by side on a gait.

    The table gives speed, yaw rate, curvature, amplitudes and phases, and the ratios of the first
    three to the full model's. "modulated" is the single-axis models with the leg amplitude of the
    yaw model changed so that it drifts as the full model does (the paper's Fig 20).

    \b
    Examples:
      rrrobot compare --gait circular --out figures
      rrrobot compare --plane --grid 13 23
    """
    finite("duration", duration, "s", above=0)
    body = robot.build_level()
    if plane:
        table = _plane(body, grid)
        click.echo(to_json(table.to_dict()) if as_json else _table_4(table))
        return
    folder = None if out is None else make_folder(out)
    legs = gait.build(body, robot)
    found = compare(body, legs, duration, progress=False if quiet else None)
    files = [] if folder is None else _figures(found, folder)
    data = {"models": found.rows(), "yaw_amplitude_factor": found.yaw_amplitude_factor}
    tell(data, _side_by_side(found), files, as_json=as_json)


def _side_by_side(found: Comparison) -> str:
    head = ("", *found.states)
    rows = [
        ("speed v [mm/s]", *(f"{1000 * s.speed:.4f}" for s in found.states.values())),
        ("  ratio", *(_ratio(found.ratio(m, "speed")) for m in found.states)),
        ("yaw rate [rad/s]", *(f"{s.yaw_rate:.6f}" for s in found.states.values())),
        ("  ratio", *(_ratio(found.ratio(m, "yaw_rate")) for m in found.states)),
        ("curvature [1/m]", *(_number(s.curvature) for s in found.states.values())),
        ("  ratio", *(_ratio(found.ratio(m, "curvature")) for m in found.states)),
    ]
    states = list(found.states.values())
    for i, axis in enumerate(_AXES):
        for key in ("amplitude", "phase", "mean"):
            rows.append((f"{axis} {key} [deg]", *(_degrees(s, key, i) for s in states)))
    text = grid(head, rows)
    if found.yaw_amplitude_factor is not None:
        text += (
            f"\nmodulated: the yaw model's leg amplitude times {found.yaw_amplitude_factor:.4f} "
            "(Fig 20)."
        )
    return text


def _degrees(state: SteadyState, key: str, axis: int) -> str:
    """An angle's amplitude, phase or mean [deg]; what does not oscillate has no phase."""
    if key == "phase" and not round(math.degrees(state.amplitude[axis]), 3):
        return "-"
    return f"{math.degrees(getattr(state, key)[axis]):.3f}"


def _plane(robot: Robot, grid: tuple[int, int]) -> Table4:
    rows, columns = grid
    return table_4(
        robot,
        offsets=np.linspace(0, np.pi / 2, rows),
        phase_differences=2 * np.pi * np.arange(1, columns + 1) / (columns + 1),
    )


def _table_4(table: Table4) -> str:
    head = ("ratio to the full model", "paper", "lowest", "median", "highest", "gaits")
    rows = []
    for quantity in ("speed", "curvature"):
        for model in MODELS[1:]:
            s = table.spread(model, quantity)
            paper = PAPER.get(model, {}).get(quantity)
            shown = "" if paper is None else f"{paper:g}"
            numbers = (f"{v:.3f}" for v in s[:3]) if s.gaits else ("-",) * 3
            rows.append((f"{quantity}, {model}", shown, *numbers, str(s.gaits)))
    return (
        f"{grid(head, rows)}\nOver {table.speed['full'].size} gaits; those count where the full "
        "model travels above 6 mm/s and, for curvature, turns above 5 mrad/s."
    )


def _figures(found: Comparison, folder: Path) -> list[Path]:
    from rrrobot.drawing import write_figure
    from rrrobot.figures.comparison import contact_paths, rolling_shell, single_axis

    figures = {
        "paths.png": contact_paths(found, tuple(found.trajectories)[:3]),
        "angles.png": single_axis(found),
        "rolling.png": rolling_shell(found.trajectories["full"]),
    }
    return [write_figure(figure, folder / name) for name, figure in figures.items()]


def _ratio(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


def _number(value: float) -> str:
    return f"{value:.4f}" if math.isfinite(value) else "infinite"
