"""`rrrobot reduce`: the kinematic reduction of a robot on a pivot, printed and plotted."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import Any

import click
import numpy as np

from rrrobot.checks import Array
from rrrobot.cli.options.group import Group, option, takes
from rrrobot.cli.options.robot import RobotOptions
from rrrobot.cli.report import to_json
from rrrobot.cli.types import NUMBER, Numbers, names
from rrrobot.contact.ground import Plane
from rrrobot.drive.gaits import Gait, SinusoidalGait
from rrrobot.errors import ParameterError
from rrrobot.files import check_writable
from rrrobot.inline import aligned
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.reduction.checks import controllability, reducibility
from rrrobot.reduction.connection import Connection
from rrrobot.reduction.cycles import OptimalCycle, optimal_cycle
from rrrobot.reduction.paths import PER
from rrrobot.reduction.yaw import METHODS, net_yaw
from rrrobot.robot.robot import Robot
from rrrobot.simulation.run import simulate
from rrrobot.steering.yaw_planner import plan_yaw

_MODELS: tuple[type[Model], ...] = (YawModel, PitchModel, RollModel, PivotingModel, FullModel)


Pair = float | tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class CycleOptions(Group):
    """A cycle of two joints."""

    pair: str | None = option(
        "--pair", metavar="J1,J2", help="Joints of the cycle; the first two unless given."
    )
    offset: Pair = option(
        "--offset",
        type=Numbers(1, 2),
        default=5 * math.pi / 8 + 0.15,
        show_default="5 pi/8 + 0.15, trajectory A",
        help="Centre of the cycle [rad].",
    )
    amplitude: Pair = option(
        "--amplitude", type=Numbers(1, 2), default=0.3, show_default=True, help="[rad]"
    )
    phase_difference: float = option(
        "--phase-difference", type=NUMBER, default="pi/2", show_default=True, help="[rad]"
    )
    angle_range: tuple[float, float] = option(
        "--angle-range",
        type=Numbers(2),
        default="-pi,pi",
        show_default=True,
        metavar="LOW,HIGH",
        help="Of the legs: in the picture, of --optimal and of --plan [rad].",
    )

    def joints(self, robot: Robot) -> tuple[int, int]:
        """Where the pair is among the legs."""
        chosen = robot.legs[:2] if self.pair is None else names(self.pair) or ()
        missing = [name for name in chosen if name not in robot.legs]
        if missing or len(set(chosen)) != 2:
            raise ParameterError(
                f"--pair is {', '.join(chosen) or 'empty'}: it must be two of the legs "
                f"{', '.join(robot.legs) or '(none)'}."
            )
        return robot.legs.index(chosen[0]), robot.legs.index(chosen[1])

    def build(self, robot: Robot, pair: tuple[int, int]) -> SinusoidalGait:
        """The cycle as a gait; other legs rest at zero."""
        offset, amplitude, phase = np.zeros((3, robot.n_legs))
        offset[list(pair)], amplitude[list(pair)] = self.offset, self.amplitude
        phase[pair[1]] = self.phase_difference
        return SinusoidalGait(
            offset=offset, amplitude=amplitude, angular_frequency=8.0, phase=phase
        )


@click.command("reduce")
@takes(robot=RobotOptions, cycle=CycleOptions)
@click.option("--models", is_flag=True, help="Also which models reduce, with and without gravity.")
@click.option("--optimal", is_flag=True, help="Also the cycles that turn the body most.")
@click.option(
    "--plan",
    "goal",
    type=Numbers(),
    metavar="YAW,PHI1,...",
    help="Also a plan to this goal, from yaw 0 with the legs at --offset (other legs at 0) [rad].",
)
@click.option("--out", metavar="FILE", help="Write the height function's picture here (png, svg).")
@click.option("--json", "as_json", is_flag=True, help="As JSON, SI units.")
def reduce_command(
    robot: RobotOptions,
    cycle: CycleOptions,
    models: bool,
    optimal: bool,
    goal: Pair | None,
    out: str | None,
    as_json: bool,
) -> None:
    """Turn a robot on a pivot by moving its legs: connection, height function, net yaw.

    The body spins about the vertical through its shell's centre, as a satellite would; joints that
    are not in the pair stay at zero.

    \b
    Examples:
      rrrobot reduce --models --optimal --out heights.png
      rrrobot reduce --robot solo12 --shell-radius 0.3 --pair FL_HFE,FR_HFE
      rrrobot reduce --plan 1.0,1.2,1.6 --angle-range 0.2,2.9
    """
    target = None if out is None else check_writable(out)
    body = robot.build_level()
    connection = Connection(body)
    pair = cycle.joints(body)
    gait = cycle.build(body, pair)
    center = gait.offset
    data: dict[str, Any] = {
        "robot": body.name,
        "pair": [body.legs[i] for i in pair],
        "connection": connection(center),
        "inertia": float(connection.inertia(center)),
        "height": float(connection.height(center, pair)),
        "bracket_order": controllability(connection, center).order,
        "net_yaw": {method: net_yaw(connection, gait, method=method) for method in METHODS},
    }
    if models:
        data["models"] = _reducibility(body)
    cycles: dict[str, Gait] = {"cycle": gait}
    if optimal:
        best = {
            name: optimal_cycle(connection, per=name, angle_range=cycle.angle_range, pair=pair)
            for name in PER
        }
        cycles |= {f"most per {name}": found.gait for name, found in best.items()}
        data["optimal"] = {name: _optimal(found) for name, found in best.items()}
    if goal is not None:
        data["plan"] = _plan(body, pair, center, goal, cycle.angle_range)
    if target is not None:
        from rrrobot.drawing import write_figure
        from rrrobot.figures.reduction import height_map

        ax: Any = height_map(connection, cycles, pair=pair, angle_range=cycle.angle_range)
        kind = target.suffix.removeprefix(".").lower() or "png"
        if kind not in ("png", "svg", "pdf"):
            raise ParameterError(f"--out is {target.name!r}: its ending must be png, svg or pdf.")
        data["file"] = str(write_figure(ax.figure, target))
    click.echo(to_json(data) if as_json else _text(data))
    sys.stdout.flush()


def _reducibility(robot: Robot) -> list[dict[str, Any]]:
    rows = []
    for gravity, ground in ((True, Plane()), (False, Plane(gravity=0.0))):
        for kind in _MODELS:
            found = reducibility(kind(robot, ground=ground, damping=None))  # type: ignore[call-arg]
            rows.append(
                {
                    "model": found.model,
                    "gravity": gravity,
                    "reducible": found.reducible,
                    "reasons": found.reasons,
                }
            )
    return rows


def _optimal(cycle: OptimalCycle) -> dict[str, Any]:
    keys = ("net_yaw", "travel", "per_travel", "region_yaw")
    return {key: getattr(cycle, key) for key in keys} | {"gait": cycle.gait.to_dict()}


def _plan(
    robot: Robot,
    pair: tuple[int, int],
    center: Array,
    goal: Pair,
    limits: tuple[float, float],
) -> dict[str, Any]:
    start = np.concatenate(([0.0], center))
    plan = plan_yaw(robot, start, np.atleast_1d(goal), angle_range=limits, pair=pair)
    interval = plan.duration / 200
    run = simulate(YawModel(robot), plan.gait, plan.duration, sample_interval=interval)
    return {
        "cycles": plan.cycles,
        "duration": plan.duration,
        "arrival_error": float(abs(run.euler[-1, 2] - plan.goal[0])),
        "highest_torque": np.abs(run.leg_torque).max(axis=0),
        "gait": plan.gait.to_dict(),
    }


def _text(data: dict[str, Any]) -> str:
    yaw = data["net_yaw"]
    order = data["bracket_order"]
    rows = [
        ("robot", f"{data['robot']}, legs {data['pair'][0]} and {data['pair'][1]}"),
        ("connection A", ", ".join(f"{value:.6g}" for value in data["connection"])),
        ("inertia", f"{data['inertia']:.6g} kg m^2"),
        ("height function", f"{data['height']:.6g} rad/rad^2 at the cycle's centre"),
        ("Lie brackets", "no turn" if order is None else f"full rank with brackets of {order}"),
        ("net yaw, line", f"{yaw['line']:.10g} rad a cycle"),
        ("net yaw, area", f"{yaw['area']:.10g} rad"),
        ("net yaw, dynamics", f"{yaw['simulate']:.10g} rad"),
    ]
    for row in data.get("models", ()):
        label = f"{row['model']}, {'gravity' if row['gravity'] else 'no gravity'}"
        verdict = "reduces" if row["reducible"] else "does not reduce"
        rows.append((label, f"{verdict}: {'; '.join(row['reasons'])}"))
    for goal, best in data.get("optimal", {}).items():
        rows.append(
            (
                f"most per {goal}",
                f"{best['net_yaw']:.6g} rad a cycle, {best['per_travel']:.5g} per rad of leg "
                f"travel; the region holds {best['region_yaw']:.6g} rad",
            )
        )
    if "plan" in data:
        plan = data["plan"]
        rows.append(
            (
                "plan",
                f"{plan['cycles']} cycles, {plan['duration']:.4g} s, arrives within "
                f"{plan['arrival_error']:.1e} rad, torques up to "
                f"{plan['highest_torque'].max():.3g} N m",
            )
        )
    if "file" in data:
        rows.append(("wrote", data["file"]))
    return aligned(rows)
