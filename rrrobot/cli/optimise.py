"""`rrrobot optimise`: the best gait for a goal, or the Pareto front of speed against torque."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import click
import numpy as np

from rrrobot.cli.compile import tell_of_compiling
from rrrobot.cli.options.group import Group, option, takes
from rrrobot.cli.options.robot import (
    MODELS,
    DampingOptions,
    GroundOptions,
    Parts,
    PerLeg,
    RobotOptions,
)
from rrrobot.cli.report import to_json
from rrrobot.cli.types import NUMBER, PER_LEG
from rrrobot.errors import OutputError
from rrrobot.files import check_writable, write_whole
from rrrobot.inline import aligned, percent
from rrrobot.studies.optimisation.goals import COSTS, GOALS, RATES, Goal, as_goal
from rrrobot.studies.optimisation.pareto import ParetoFront, pareto_front
from rrrobot.studies.optimisation.result import OptimisedGait
from rrrobot.studies.optimisation.run import optimise
from rrrobot.studies.optimisation.table import GaitLimits

_PLOTS = (".png", ".pdf", ".svg")

_TARGETS = ("speed", "curvature", "yaw_rate", "min_speed")


@dataclass(frozen=True, kw_only=True)
class GoalOptions(Group):
    """One goal, or the Pareto front instead."""

    goal: str | None = option(
        "--goal",
        type=click.Choice(tuple(GOALS)),
        help="fastest travel; tightest turn of at least --min-speed; efficient: least --cost of a "
        "metre at least as fast as that; target: --speed with --curvature or --yaw-rate, at the "
        "least torque. fastest unless given.",
    )
    speed: float | None = option("--speed", type=NUMBER, help="Of the target [m/s].")
    curvature: float | None = option(
        "--curvature", type=NUMBER, help="Of the target [1/m]; positive to the left."
    )
    yaw_rate: float | None = option("--yaw-rate", type=NUMBER, help="Of the target [rad/s].")
    min_speed: float | None = option("--min-speed", type=NUMBER, help="[m/s]; 0.001 unless given.")
    cost: str | None = option(
        "--cost",
        type=click.Choice(tuple(dict.fromkeys((*COSTS, *RATES)))),
        help="With efficient: effort (integral of squared torque), torque (rms, over the speed) "
        "or work (integral of |power|), per metre; effort unless given. With --pareto: torque "
        "(rms) or power; torque unless given.",
    )
    pareto: str | None = option(
        "--pareto",
        metavar="FILE",
        help="Instead of one goal: least torque for every speed, as a plot, .png, .pdf or .svg.",
    )
    n_points: int | None = option(
        "--n-points", type=int, help="Of the Pareto front; 16 unless given."
    )

    def build(self) -> Goal | None:
        """The goal, or None for the Pareto front.

        Raises:
            click.UsageError: options that do not go together.
        """
        if self.pareto is not None:
            self.refuse(("goal", *_TARGETS), "do not go with --pareto")
            return None
        self.refuse(("n_points",), "go with --pareto only")
        name = self.goal or "fastest"
        keys = {
            "fastest": (),
            "tightest": ("min_speed",),
            "efficient": ("min_speed", "cost"),
            "target": ("speed", "curvature", "yaw_rate"),
        }[name]
        others = tuple(key for key in (*_TARGETS, "cost") if key not in keys)
        self.refuse(others, f"do not go with --goal {name}")
        given = self.given(*keys)
        if name == "target" and "speed" not in given:
            raise click.UsageError("--goal target needs --speed, and --curvature or --yaw-rate.")
        return as_goal(GOALS[name](**given))


@dataclass(frozen=True, kw_only=True)
class BoundOptions(Group):
    """The box of gaits that is searched."""

    offset: PerLeg = option(
        "--offset", type=PER_LEG, help="Centre of the swing [rad]; 0,pi unless given."
    )
    amplitude: PerLeg = option(
        "--amplitude", type=PER_LEG, help="Of the swing [rad]; 0,0.5 unless given."
    )
    frequency: PerLeg = option(
        "--frequency", type=PER_LEG, help="Angular [rad/s]; 2,14 unless given."
    )
    phase: PerLeg = option(
        "--phase", type=PER_LEG, help="Of other legs from leg 1 [rad]; 0,2*pi unless given."
    )
    harmonics: int = option(
        "--harmonics", type=int, default=1, show_default=True, help="Of the gait."
    )
    tied: bool = option(
        "--tied", is_flag=True, help="One offset and one amplitude for legs that mirror."
    )

    def settings(self) -> dict[str, Any]:
        """Keywords of `optimise`."""
        bounds = self.given("offset", "amplitude", "frequency", "phase")
        for short, name in (("phase", "phase_difference"), ("frequency", "angular_frequency")):
            if short in bounds:
                bounds[name] = bounds.pop(short)
        found = {name: _pairs(value) for name, value in bounds.items()}
        return found | {"harmonics": self.harmonics, "tied": self.tied}


@dataclass(frozen=True, kw_only=True)
class LimitOptions(Group):
    """What every gait must respect."""

    friction: float | None = option(
        "--friction", type=NUMBER, help="Coefficient that the ground offers."
    )
    max_curvature: float | None = option("--max-curvature", type=NUMBER, help="Of the path [1/m].")
    max_torque: float | None = option(
        "--max-torque", type=NUMBER, help="Of each motor [N m]; the file's unless given."
    )
    max_leg_rate: float | None = option(
        "--max-leg-rate", type=NUMBER, help="[rad/s]; the file's unless given."
    )
    max_leg_acceleration: float | None = option(
        "--max-leg-acceleration", type=NUMBER, help="[rad/s^2]"
    )
    max_tilt: float | None = option(
        "--max-tilt", type=NUMBER,
        help="Of the body's z axis from the ground's normal [rad]; 1.2 unless given.",
    )  # fmt: skip
    min_normal_force: float | None = option(
        "--min-normal-force", type=NUMBER, help="Over the weight; 0.05 unless given."
    )
    min_clearance: float | None = option(
        "--min-clearance", type=NUMBER, help="Of the legs' masses [m]; 0 unless given."
    )
    max_variation: float | None = option(
        "--max-variation", type=NUMBER, help="Of the step between cycles; 0.01 unless given."
    )

    def build(self) -> GaitLimits:
        """The limits."""
        return GaitLimits(**self.given(*(f.name for f in fields(self))))


@dataclass(frozen=True, kw_only=True)
class SearchOptions(Group):
    """How each gait settles, for how long, and from which seed."""

    settle: str = option(
        "--settle",
        type=click.Choice(("cycles", "orbit")),
        default="cycles",
        show_default=True,
        help="cycles: simulate them; orbit: find each gait's limit cycle directly, and gradients "
        "along it.",
    )
    settle_time: float | None = option(
        "--settle-time",
        type=NUMBER,
        help="Simulated before the cycles that count [s]; 25 unless given, and more where the "
        "robot's slowest decay needs more.",
    )
    budget: int | None = option(
        "--budget",
        type=int,
        help="Gaits to simulate; 20000 a harmonic, 30000 for a front, unless given.",
    )
    seed: int = option(
        "--seed", type=int, default=0, show_default=True, help="Same seed, same bits."
    )


@click.command("optimise")
@click.option("--model", type=click.Choice(("full", "pivoting")), default="full", show_default=True)
@takes(
    goal=GoalOptions,
    bounds=BoundOptions,
    limits=LimitOptions,
    robot=RobotOptions,
    ground=GroundOptions,
    damping=DampingOptions,
    search=SearchOptions,
)
@click.option("--json", "as_json", is_flag=True, help="As JSON, SI units.")
@click.option("--out", metavar="FILE", help="Also write that JSON here: .json.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
def optimise_command(
    model: str,
    goal: GoalOptions,
    bounds: BoundOptions,
    limits: LimitOptions,
    robot: RobotOptions,
    ground: GroundOptions,
    damping: DampingOptions,
    search: SearchOptions,
    as_json: bool,
    out: str | None,
    quiet: bool,
) -> None:
    """Find the best gait for a goal, and confirm it by a simulation with forces.

    A bound is one number, which is kept, or LOW,HIGH for all legs, or LOW,HIGH for each leg in
    turn, with commas between; a number may be written pi/2.

    If no gait is within the limits, or a target is out of reach, the nearest is printed and the
    exit code is 1. The file of --out is a gait for --gait of other commands.

    \b
    Examples:
      rrrobot optimise --goal fastest --max-curvature 0.01
      rrrobot optimise --goal target --speed 0.005 --curvature 2 --out gait.json
      rrrobot optimise --pareto front.png
    """
    files = _files(out, goal.pareto)
    wanted = goal.build()
    body = Parts.of(robot, ground, damping).model(MODELS[model])
    settings = bounds.settings() | search.given("settle", "settle_time", "seed", "budget")
    settings["limits"] = limits.build()
    tell_of_compiling(quiet=quiet, loads=True)
    settings["progress"] = False if quiet else None
    if wanted is None:
        front = goal.given("cost", "n_points")
        found: ParetoFront | OptimisedGait = pareto_front(body, **settings, **front)
    else:
        found = optimise(body, wanted, **settings)
    _report(found, files, as_json=as_json)
    if isinstance(found, OptimisedGait) and not found.met:
        raise click.ClickException(f"the nearest gait falls short: {'; '.join(found.shortfalls)}.")


def _pairs(value: Any) -> Any:
    """One number, (low, high), or such pairs for each leg."""
    if isinstance(value, tuple) and len(value) > 2 and len(value) % 2 == 0:
        return np.reshape(value, (-1, 2))
    return value


def _files(out: str | None, pareto: str | None) -> dict[str, Path]:
    """Checked paths of --out and --pareto."""
    found = {}
    for key, name, suffixes in (("out", out, (".json",)), ("pareto", pareto, _PLOTS)):
        if name is not None:
            if Path(name).suffix.lower() not in suffixes:
                raise OutputError(
                    f"cannot write {name!r}: --{key} ends in {' or '.join(suffixes)}."
                )
            found[key] = check_writable(name)
    return found


def _report(found: ParetoFront | OptimisedGait, files: dict[str, Path], *, as_json: bool) -> None:
    """Write the files and print the result."""
    text = to_json(found.to_dict())
    if isinstance(found, ParetoFront):
        from rrrobot.drawing import write_figure
        from rrrobot.figures.fronts import pareto

        write_figure(pareto(found), files["pareto"])
    if "out" in files:
        write_whole(files["out"], (text + "\n").encode())
    if as_json:
        click.echo(text)
        return
    click.echo(_front_table(found) if isinstance(found, ParetoFront) else _table(found))
    for path in files.values():
        click.echo(f"wrote {path}")


def _table(found: OptimisedGait) -> str:
    m, state, gait = found.measured, found.steady_state, found.gait.to_dict()
    period = found.gait.period or 0.0
    rows = [
        (f"{found.goal.name}: {found.goal.quantity}", f"{found.value:.6g} {found.goal.unit}"),
        *((f"  {key}", _numbers(value)) for key, value in gait.items() if key != "type"),
        ("period", f"{period:.4g} s"),
        ("speed v", f"{1000 * state.speed:.4f} mm/s, steps vary by {percent(state.variation)}"),
        ("yaw rate", f"{state.yaw_rate:.6g} rad/s"),
        ("curvature", f"{state.curvature:.6g} 1/m"),
        ("motor torque", f"{m['rms_torque']:.4g} N m rms of all, {m['peak_torque']:.4g} N m peak"),
        ("motor power", f"{m['power']:.4g} W"),
        ("least normal force", f"{m['normal_force']:.4g} N"),
        ("friction needed", f"{m['friction']:.3g}"),
        ("largest tilt", f"{np.rad2deg(m['tilt']):.1f} deg"),
        ("legs' least height", f"{1000 * m['clearance']:.1f} mm"),
        ("confirmed", f"by the KKT model to {found.discrepancy:.1g}"),
        ("searched", _searched(found)),
    ]
    if none := found.trajectory.robot.joints.unlimited:
        rows.append(("no effort limit", f"{', '.join(none)}: the file's are placeholders"))
    if found.lift_off_time is not None:
        rows.append(("LIFTS OFF", f"at {found.lift_off_time:.3g} s: blend in, as --ramp does"))
    return aligned(rows)


def _searched(found: OptimisedGait) -> str:
    way = {"cycles": "simulated", "orbit": "simulated to find orbits"}[found.search["settle"]]
    return (
        f"{found.evaluations} gaits, {found.cycles:.0f} cycles {way}, seed {found.search['seed']}"
    )


def _front_table(front: ParetoFront) -> str:
    unit = {"torque": "mN m", "power": "mW"}[front.cost_name]
    head = f"{'speed [mm/s]':>12}  {front.cost_name + ' [' + unit + ']':>14}  {'K [1/m]':>9}  gait"
    lines = [head]
    for i, gait in enumerate(front.gaits):
        shown = ", ".join(f"{k} {_numbers(v)}" for k, v in gait.to_dict().items() if k != "type")
        speed, cost = 1000 * front.speed[i], 1000 * front.cost[i]
        # Plus zero, so that nothing shows as -0.000.
        curvature = round(float(front.columns["curvature"][i]), 3) + 0.0
        lines.append(f"{speed:12.4f}  {cost:14.4f}  {curvature:9.3f}  {shown}")
    return "\n".join(lines)


def _numbers(value: Any) -> str:
    """Numbers of a gait with four decimals; what is the same for all legs once."""
    if isinstance(value, list):
        shown = [_numbers(entry) for entry in value]
        if not isinstance(value[0], list) and len(set(shown)) == 1:
            return shown[0]
        return f"({', '.join(shown)})"
    return f"{value + 0.0:.4f}"
