"""`rrrobot reduce`: the kinematic reduction of a robot on a pivot, printed and plotted."""

from __future__ import annotations

import math
import sys
from typing import Any

import click
import numpy as np

from rrrobot.cli.build import build_robot, refuse_ground
from rrrobot.cli.options import robot_options
from rrrobot.cli.report import aligned, to_json
from rrrobot.cli.types import NUMBER, Numbers, names
from rrrobot.contact.ground import Plane
from rrrobot.drive.gaits import Gait, SinusoidalGait
from rrrobot.errors import ParameterError
from rrrobot.files import check_writable
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.reduction.checks import controllability, reducibility
from rrrobot.reduction.connection import Connection
from rrrobot.reduction.cycles import GOALS, OptimalCycle, optimal_cycle
from rrrobot.reduction.yaw import METHODS, net_yaw
from rrrobot.robot.robot import Robot
from rrrobot.simulation.run import simulate
from rrrobot.steering.yaw_planner import plan_yaw

_MODELS: tuple[type[Model], ...] = (YawModel, PitchModel, RollModel, PivotingModel, FullModel)


@click.command("reduce")
@robot_options
@click.option("--pair", metavar="J1,J2", help="Joints of the cycle; the first two unless given.")
@click.option(
    "--offset",
    type=Numbers(1, 2),
    default=5 * math.pi / 8 + 0.15,
    show_default="5 pi/8 + 0.15, trajectory A",
    help="Centre of the cycle [rad].",
)
@click.option("--amplitude", type=Numbers(1, 2), default=0.3, show_default=True, help="[rad]")
@click.option("--phase-difference", type=NUMBER, default="pi/2", show_default=True, help="[rad]")
@click.option("--models", is_flag=True, help="Also which models reduce, with and without gravity.")
@click.option("--optimal", is_flag=True, help="Also the cycles that turn the body most.")
@click.option(
    "--limits",
    type=Numbers(2),
    default="-pi,pi",
    show_default=True,
    metavar="LOW,HIGH",
    help="Of the legs: in the picture, of --optimal and of --plan [rad].",
)
@click.option(
    "--plan",
    "goal",
    type=Numbers(),
    metavar="YAW,PHI1,...",
    help="Also a plan to this goal, from yaw 0 with the legs at --offset (other legs at 0) [rad].",
)
@click.option("--out", metavar="FILE", help="Write the height function's picture here (png, svg).")
@click.option("--json", "as_json", is_flag=True, help="As JSON, SI units.")
def reduce_command(**options: Any) -> None:
    """Turn a robot on a pivot by moving its legs: connection, height function, net yaw.

    The body spins about the vertical through its shell's centre, as a satellite would; joints that
    are not in the pair stay at zero.

    \b
    Examples:
      rrrobot reduce --models --optimal --out heights.png
      rrrobot reduce --robot solo12 --shell-radius 0.3 --pair FL_HFE,FR_HFE
      rrrobot reduce --plan 1.0,1.2,1.6 --limits 0.2,2.9
    """
    target = None if options["out"] is None else check_writable(options["out"])
    refuse_ground(options)
    robot = build_robot(options)
    connection = Connection(robot)
    pair = _pair(robot, options["pair"])
    gait = _cycle(robot, pair, options)
    center = gait.offset
    data: dict[str, Any] = {
        "robot": robot.name,
        "pair": [robot.legs[i] for i in pair],
        "connection": connection(center),
        "inertia": float(connection.inertia(center)),
        "height": float(connection.height(center, pair)),
        "bracket_order": controllability(connection, center).order,
        "net_yaw": {method: net_yaw(connection, gait, method=method) for method in METHODS},
    }
    if options["models"]:
        data["models"] = _reducibility(robot)
    cycles: dict[str, Gait] = {"cycle": gait}
    if options["optimal"]:
        best = {
            goal: optimal_cycle(connection, goal=goal, limits=options["limits"], pair=pair)
            for goal in GOALS
        }
        cycles |= {f"most per {goal}": cycle.gait for goal, cycle in best.items()}
        data["optimal"] = {goal: _optimal(cycle) for goal, cycle in best.items()}
    if options["goal"] is not None:
        data["plan"] = _plan(robot, pair, center, options)
    if target is not None:
        from rrrobot.drawing import write_figure
        from rrrobot.figures.reduction import height_map

        ax: Any = height_map(connection, cycles, pair=pair, limits=options["limits"])
        kind = target.suffix.removeprefix(".").lower() or "png"
        if kind not in ("png", "svg", "pdf"):
            raise ParameterError(f"--out is {target.name!r}: its ending must be png, svg or pdf.")
        data["file"] = str(write_figure(ax.figure, target))
    click.echo(to_json(data) if options["as_json"] else _text(data))
    sys.stdout.flush()


def _pair(robot: Robot, text: str | None) -> tuple[int, int]:
    chosen = robot.legs[:2] if text is None else names(text) or ()
    missing = [name for name in chosen if name not in robot.legs]
    if missing or len(set(chosen)) != 2:
        raise ParameterError(
            f"--pair is {', '.join(chosen) or 'empty'}: it must be two of the legs "
            f"{', '.join(robot.legs) or '(none)'}."
        )
    return robot.legs.index(chosen[0]), robot.legs.index(chosen[1])


def _cycle(robot: Robot, pair: tuple[int, int], options: dict[str, Any]) -> SinusoidalGait:
    offset, amplitude, phase = np.zeros((3, robot.n_legs))
    offset[list(pair)], amplitude[list(pair)] = options["offset"], options["amplitude"]
    phase[pair[1]] = options["phase_difference"]
    return SinusoidalGait(offset=offset, amplitude=amplitude, angular_frequency=8.0, phase=phase)


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
    robot: Robot, pair: tuple[int, int], center: np.ndarray, options: dict[str, Any]
) -> dict[str, Any]:
    start = np.concatenate(([0.0], center))
    plan = plan_yaw(robot, start, np.atleast_1d(options["goal"]), limits=options["limits"],
                    pair=pair)  # fmt: skip
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
