"""`rrrobot sensitivity`: what a limit cycle depends on most."""

from __future__ import annotations

from pathlib import Path

import click

from rrrobot.cli.options.drive import GaitOptions
from rrrobot.cli.options.group import takes
from rrrobot.cli.options.orbit import OrbitOptions
from rrrobot.cli.options.robot import DampingOptions, GroundOptions, RobotOptions
from rrrobot.cli.report import tell
from rrrobot.drawing import write_figure
from rrrobot.files import check_writable
from rrrobot.inline import aligned

_OUTPUTS = (
    "speed", "yaw_rate", "curvature", "roll_amplitude", "pitch_amplitude", "yaw_amplitude",
)  # fmt: skip


@click.command("sensitivity")
@takes(
    orbit=OrbitOptions,
    robot=RobotOptions,
    ground=GroundOptions,
    gait=GaitOptions,
    damping=DampingOptions,
)
@click.option(
    "--of", "output", type=click.Choice(_OUTPUTS), default="speed", show_default=True,
    help="What changes.",
)  # fmt: skip
@click.option("--count", type=click.IntRange(1), default=12, show_default=True, help="Rows shown.")
@click.option("--plot", metavar="FILE", help="Bars of the largest effects: .png, .svg.")
@click.option("--json", "as_json", is_flag=True, help="All derivatives as JSON, SI units.")
def sensitivity_command(
    orbit: OrbitOptions,
    robot: RobotOptions,
    ground: GroundOptions,
    gait: GaitOptions,
    damping: DampingOptions,
    output: str,
    count: int,
    plot: str | None,
    as_json: bool,
) -> None:
    """Print what a gait's limit cycle depends on most.

    Derivatives with respect to every parameter of gait, robot and damping, through the orbit. An
    effect is of 0.01 rad of an angle, or one percent of any other parameter.

    \b
    Examples:
      rrrobot sensitivity --gait circular --of yaw_rate --plot effects.png
      rrrobot sensitivity --json
    """
    path = None if plot is None else check_writable(Path(plot))
    cycle = orbit.build(robot, ground, gait, damping)
    from rrrobot.orbits.gradients import OUTPUTS, sensitivities

    found = sensitivities(cycle)
    effects = dict(zip(found.names, found.effects(output), strict=True))
    units = {p.name: p.unit for p in found.parameters}
    unit = OUTPUTS[output]
    rows = [(output, f"{_value(cycle, output):.6g} {unit}"), ("", f"effect [{unit}], derivative")]
    rows += [
        (name, f"{effects[name]:+.3e}  {found.of(output, name):+.6g} {unit} per {units[name]}")
        for name in found.ranked(output)[:count]
    ]
    files = []
    if path is not None:
        axes = found.plot(output, count=count)
        files.append(write_figure(axes.figure, path))
    tell(found.to_dict() | {"of": output}, aligned(rows), files, as_json=as_json)


def _value(cycle: object, output: str) -> float:
    axis = output.removesuffix("_amplitude")
    if axis == output:
        return float(getattr(cycle, output))
    return float(cycle.amplitude[("roll", "pitch", "yaw").index(axis)])  # type: ignore[attr-defined]
