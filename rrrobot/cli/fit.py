"""`rrrobot fit`: RRRobot's masses, radius, damping and slope from a measured run."""

from __future__ import annotations

import json

import click

from rrrobot.cli.options.group import takes
from rrrobot.cli.options.robot import RobotOptions
from rrrobot.cli.report import tell
from rrrobot.cli.types import Numbers, names
from rrrobot.errors import OutputError
from rrrobot.files import check_writable, write_whole
from rrrobot.inline import aligned
from rrrobot.steering.identification import FREE, identify
from rrrobot.steering.measured import MeasuredRun


@click.command("fit")
@click.argument("run", metavar="RUN.csv")
@click.option(
    "--free", default=",".join(FREE), show_default=True, metavar="NAMES",
    help="Parameters that are fitted.",
)  # fmt: skip
@click.option(
    "--noise", type=Numbers(2), metavar="PLACE,YAW",
    help="Standard deviation of the measured poses [m, rad]; from what the fit leaves over.",
)  # fmt: skip
@takes(robot=RobotOptions)
@click.option("--out", metavar="FILE", help="The fit as JSON: .json.")
@click.option("--json", "as_json", is_flag=True, help="As JSON, SI units.")
def fit_command(
    run: str,
    free: str,
    noise: tuple[float, float] | None,
    robot: RobotOptions,
    out: str | None,
    as_json: bool,
) -> None:
    """Fit RRRobot's masses, radius, damping and slope to a measured run, each with its uncertainty.

    The run is a table with the columns time, x, y, yaw, leg_1, leg_2 [s, m, m, rad, rad, rad]; the
    robot is at rest at its start. Poses do not tell the scale of all masses: one stays as given.

    \b
    Examples:
      rrrobot fit run.csv
      rrrobot fit run.csv --free damping,leg_mass --leg-mass 0.06 --noise 0.001,0.009 --json
    """
    if out is not None and not out.lower().endswith(".json"):
        raise OutputError(f"cannot write {out!r}: --out ends in .json.")
    target = None if out is None else check_writable(out)
    if not robot.is_rrrobot:
        raise click.UsageError(
            "fit knows RRRobot's parameters only: leave --urdf and --robot away."
        )
    spread = None if noise is None else (float(noise[0]), float(noise[1]))
    found = identify(
        MeasuredRun.from_csv(run), robot.build().parameters, free=names(free) or (), noise=spread
    )
    data = found.to_dict()
    rows = [(k, f"{v:.6g} +- {found.uncertainty[k]:.2g}") for k, v in found.value.items()]
    rows += [
        ("noise", f"{1000 * found.noise[0]:.3g} mm, {found.noise[1]:.3g} rad"),
        ("misfit", f"{found.misfit:.3g} of the noise; about 1 if the model is right"),
    ]
    written = []
    if target is not None:
        written.append(write_whole(target, (json.dumps(data, indent=1) + "\n").encode()))
    tell(data, aligned(rows), written, as_json=as_json)
