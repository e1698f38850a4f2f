"""`rrrobot orbit`: the limit cycle of a gait, and whether it holds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rrrobot.cli.options.drive import GaitOptions
from rrrobot.cli.options.group import takes
from rrrobot.cli.options.orbit import OrbitOptions
from rrrobot.cli.options.robot import DampingOptions, GroundOptions, RobotOptions
from rrrobot.cli.report import tell
from rrrobot.drawing import write_figure
from rrrobot.files import check_writable
from rrrobot.inline import aligned, oscillation

if TYPE_CHECKING:
    from rrrobot.orbits.limit_cycles import LimitCycle
    from rrrobot.orbits.starts import Attractors


@click.command("orbit")
@takes(
    orbit=OrbitOptions,
    robot=RobotOptions,
    ground=GroundOptions,
    gait=GaitOptions,
    damping=DampingOptions,
)
@click.option(
    "--starts", type=click.IntRange(1), help="Instead: what so many random starts come to."
)
@click.option("--plot", metavar="FILE", help="Angles, torques, multipliers and path: .png, .svg.")
@click.option("--json", "as_json", is_flag=True, help="As JSON, SI units.")
def orbit_command(
    orbit: OrbitOptions,
    robot: RobotOptions,
    ground: GroundOptions,
    gait: GaitOptions,
    damping: DampingOptions,
    starts: int | None,
    plot: str | None,
    as_json: bool,
) -> None:
    """Find the motion that a gait settles to, and whether it holds.

    The limit cycle is found by Newton's method on the map of tilt and momentum over one period of
    the legs, stable or not. Multipliers below one in size: deviations die away.

    \b
    Examples:
      rrrobot orbit --gait circular --plot cycle.png
      rrrobot orbit --offset pi/2 --amplitude 0.5 --frequency 5.2 --phase 0 --json
      rrrobot orbit --offset pi/2 --amplitude 0.7 --frequency 5.4 --phase 0 --starts 64
    """
    if starts is not None:
        if plot is not None:
            raise click.UsageError("--plot draws one cycle: it does not go with --starts.")
        found = orbit.attractors(robot, ground, gait, damping, starts)
        tell(found.to_dict(), _attractors(found), [], as_json=as_json)
        return
    path = None if plot is None else check_writable(Path(plot))
    cycle = orbit.build(robot, ground, gait, damping)
    files = [] if path is None else [write_figure(cycle.plot("all"), path)]
    tell(cycle.to_dict() | {"model": cycle.model.name}, _table(cycle), files, as_json=as_json)


def _attractors(found: Attractors) -> str:
    rows = [
        (f"{100 * share:.0f} %", f"period {c.periods}, {1e3 * c.speed:.6f} mm/s, "
         f"{c.yaw_rate:.6f} rad/s, largest multiplier {abs(c.multipliers[0]):.4f}")
        for c, share in zip(found.cycles, found.share, strict=True)
    ]  # fmt: skip
    for share, words in ((found.elsewhere, "do not repeat"), (found.lost, "tip over")):
        if share:
            rows.append((f"{100 * share:.0f} %", words))
    return aligned(rows)


def _table(cycle: LimitCycle) -> str:
    rows = [
        ("model", str(cycle.model.name)),
        ("period", f"{cycle.period:.6g} s, {cycle.periods} of the legs"),
        ("stable", "yes" if cycle.stable else "NO: deviations grow"),
        ("speed v", f"{1e3 * cycle.speed:.6f} mm/s"),
        ("yaw rate", f"{cycle.yaw_rate:.8f} rad/s"),
        ("curvature", f"{cycle.curvature:.5g} 1/m"),
    ]
    for i, name in enumerate(("roll", "pitch", "yaw")):
        angles = (cycle.amplitude[i], cycle.phase[i], cycle.mean[i])
        rows.append((name, oscillation(*angles)))
    for m, time, rate in zip(
        cycle.multipliers, cycle.settling_times, cycle.frequencies, strict=True
    ):
        rows.append(
            (
                "multiplier",
                f"{m.real:+.6f} {m.imag:+.6f}i, size {abs(m):.6f}, 1/e in {time:.3g} s, "
                f"{rate:.4g} rad/s",
            )
        )
    if cycle.lifts_off:
        rows.append(("LIFTS OFF", f"normal force down to {cycle.normal_force:.4g} N"))
    rows.append(("residual", f"{cycle.residual:.1e}, {cycle.steps_per_cycle} steps a cycle"))
    return aligned(rows)
