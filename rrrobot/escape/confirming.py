"""What is said of a gait: the general model's motion of it, with forces, and Coal's distances.

The gait is blended in from rest over some cycles and simulated until it has settled, by the KKT
system or, at a fifth of the cost, by the momentum form, which tells what is worth the KKT system's
time. The last cycle is run through again with a sample each millisecond.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rrrobot.belly.feasible import feasibility
from rrrobot.belly.found import Belly
from rrrobot.checks import Array
from rrrobot.drive.gaits import FourierGait, RampIn, SinusoidalGait
from rrrobot.drive.tables import gait_from_dict
from rrrobot.errors import ModelError, SimulationError, SimulationInterrupted
from rrrobot.escape.bench import Bench
from rrrobot.escape.goals import Escape, goal_of
from rrrobot.escape.limits import Rules
from rrrobot.escape.polish import Judged
from rrrobot.inline import html_table
from rrrobot.models.base import Model
from rrrobot.orbits.oscillations import equilibrium
from rrrobot.rotations import euler_from_quaternion
from rrrobot.simulation.run import simulate
from rrrobot.simulation.steady import steady_state
from rrrobot.simulation.trajectory import Trajectory

AGREE = 0.01
"""Largest relative difference of engine and KKT model that a gait may have."""
SLOWEST = 1e-3
"""Lengths of the robot in a second, or radians, below which a gait goes nowhere."""
RAMPS = (8, 24)
"""Cycles of blending in: the second where the first breaks a limit that the settled cycle keeps."""
_COUNTED = 4
_SAMPLES = 48
_FINE = 1e-3


@dataclass(frozen=True, kw_only=True, eq=False)
class EscapeGait:
    """A gait that was found for a goal, as the general (KKT) model and Coal confirm it.

    Attributes:
        goal: where it was to go.
        gait: the settled motion of the legs.
        ramp: time of blending in from rest [s].
        value: of the goal, in `goal.unit`.
        travel: v_x, v_y [m/s] along the body's mean heading, and the yaw rate [rad/s] (3,).
        met: whether all limits hold, from the first to the last instant, and engine and KKT agree.
        shortfalls: what does not hold, in words.
        binding: limits that bind.
        measured: of the settled cycle: friction, normal_force (over the weight), tilt [rad],
            clearance and separation (Coal) [m], power [W], energy_per_metre [J/m] (of a turn,
            energy_per_radian).
        torque: largest of each leg (legs,) [N m], and
        torque_share: over its limit (legs,); NaN where the file has none.
        discrepancy: relative difference of travel between the engine and the KKT model.
        trajectory: from rest through the ramp to the settled motion.
    """

    goal: Escape
    gait: SinusoidalGait | FourierGait
    ramp: float
    value: float
    travel: Array
    met: bool
    shortfalls: tuple[str, ...]
    binding: tuple[str, ...]
    measured: Mapping[str, float]
    torque: Array
    torque_share: Array
    discrepancy: float
    trajectory: Trajectory = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the trajectory as plain data; `gait` is one for `read_gait`."""
        return {
            "goal": self.goal.to_dict(),
            "gait": self.gait.to_dict(),
            "ramp": self.ramp,
            "value": self.value,
            "unit": self.goal.unit,
            "travel": self.travel.tolist(),
            "met": self.met,
            "shortfalls": list(self.shortfalls),
            "binding": list(self.binding),
            "measured": dict(self.measured),
            "torque": self.torque.tolist(),
            "torque_share": self.torque_share.tolist(),
            "discrepancy": self.discrepancy,
        }

    def _repr_html_(self) -> str:
        rows = {
            self.goal.name: f"{self.value:.4g} {self.goal.unit}",
            "gait": self.gait,
            "limits": "met" if self.met else f"NOT MET: {'; '.join(self.shortfalls)}",
            **{key: f"{value:.4g}" for key, value in self.measured.items()},
        }
        return html_table("Gait", rows)

    def __repr__(self) -> str:
        state = "" if self.met else f", NOT MET: {'; '.join(self.shortfalls)}"
        return f"EscapeGait({self.goal.name}: {self.value:.4g} {self.goal.unit}{state})"


class _Settled(NamedTuple):
    """What the last cycles of a run come to."""

    travel: Array
    value: float
    discrepancy: float


def confirm(
    model: Model, bench: Bench, rules: Rules, one: Judged, belly: Belly, *,
    ramps: Sequence[int] = RAMPS, method: str = "kkt",
) -> EscapeGait:  # fmt: skip
    """Simulate a gait and hold it against every limit.

    Args:
        model: the robot on its ground.
        bench: whose settle time counts.
        rules: goal and limits.
        one: the gait, and what the engine says of it.
        belly: of the model's robot.
        ramps: cycles of blending in, tried one after the other.
        method: of `simulate`.
    """
    gait = one.gait.gait(0)
    period = gait.period or 0.0
    for ramp in ramps:
        drive = RampIn(gait, ramp * period)
        start = np.ceil(bench.settle_time / period + ramp) * period
        problems: list[str] = []
        settled = _Settled(np.full(3, np.nan), math.nan, math.inf)
        try:
            run = last = simulate(
                model, drive, start + _COUNTED * period, period / _SAMPLES, start="rest",
                euler=_rest(model, drive(0.0).angle), method=method,
            )  # fmt: skip
        except SimulationInterrupted:
            raise
        except SimulationError as error:
            if error.trajectory is None:
                raise
            run = last = error.trajectory
            problems.append(str(error).partition(". State")[0])
        else:
            settled = _settled(run, start, one, rules)
            steps = max(_SAMPLES, math.ceil(period / _FINE))
            last = simulate(
                model, drive, period, period / steps, state=run.final_state, method=method
            )
        weight = run.robot.mass * run.gravity
        limits = rules.limits.of(weight)
        whole, fine = (feasibility(part, limits, belly=belly) for part in (run, last))
        if problems or not fine.feasible or whole.feasible:
            break
    problems += [str(one) for one in (*whole.violations, *fine.violations)]
    least = SLOWEST if rules.goal.turns or rules.goal.leans else SLOWEST * rules.length
    if settled.value < least and not problems:
        problems.append(f"it all but stands, with {settled.value:.2g} {rules.goal.unit}")
    if settled.discrepancy > AGREE and not problems:
        problems.append(
            f"engine and KKT model differ by {100 * settled.discrepancy:.2g} %: the motion is not "
            "settled, or not stable"
        )
    torque = np.abs(last.leg_torque).max(axis=0)
    power = float(np.abs(last.leg_torque * last.leg_rate).sum(axis=1).mean())
    per = "energy_per_radian" if rules.goal.turns else "energy_per_metre"
    measured = {
        "friction": fine.peak_friction,
        "normal_force": fine.least_force / weight,
        "tilt": fine.peak_tilt,
        "clearance": fine.clearance,
        "separation": fine.separation,
        "power": power,
        per: power / settled.value if settled.value > 0 else math.nan,
    }
    return EscapeGait(
        goal=rules.goal, gait=gait, ramp=drive.duration, value=settled.value,
        travel=settled.travel, met=not problems, shortfalls=tuple(dict.fromkeys(problems)),
        binding=one.binding, measured=measured, torque=torque,
        torque_share=np.where(np.isfinite(rules.ends.effort), torque / rules.ends.effort, np.nan),
        discrepancy=settled.discrepancy, trajectory=run,
    )  # fmt: skip


def _rest(model: Model, leg_angle: Array) -> Array:
    """Roll, pitch, yaw of the rest with the legs held, or upright where there is none."""
    try:
        pose = equilibrium(model, leg_angle)
    except ModelError:
        return np.zeros(3)
    return euler_from_quaternion(model.place(pose).quaternion)


def _settled(run: Trajectory, start: float, one: Judged, rules: Rules) -> _Settled:
    state = steady_state(run, after=start - 1e-9)
    travel = np.append(state.velocity, state.yaw_rate)
    scale = np.array((1.0, 1.0, rules.length))
    if rules.goal.leans:
        lean = leaning_to(run.euler[run.time >= start - 1e-9], rules.goal)
        return _Settled(travel, lean, abs(lean - one.value) / max(abs(lean), 1e-9))
    gap = np.linalg.norm(scale * (travel - one.outcome.travel[0]))
    size = max(float(np.linalg.norm(scale * travel)), 1e-9)
    return _Settled(travel, float(rules.goal.value(travel[None])[0]), float(gap) / size)


def leaning_to(euler: Array, goal: Escape) -> float:
    """Largest lean of the base's z axis to the goal's side through a run (n, 3) [rad]."""
    roll, pitch = euler[:, 0], euler[:, 1]
    up = np.column_stack((-np.sin(pitch), np.sin(roll) * np.cos(pitch)))
    size = np.linalg.norm(up, axis=1)
    tilt = np.arccos(np.clip(np.cos(roll) * np.cos(pitch), -1, 1))
    lean = -up * (tilt / np.maximum(size, 1e-12))[:, None]
    return float((lean @ np.array(goal.weights[:2])).max())


def gait_of(entry: Mapping[str, Any], run: Path) -> EscapeGait:
    """The gait of `to_dict`, with the trajectory that a file holds."""

    def numbers(values: Any) -> Any:
        return np.array([np.nan if v is None else v for v in values], dtype=float)

    measured = {k: np.nan if v is None else float(v) for k, v in entry["measured"].items()}
    gait: Any = gait_from_dict(entry["gait"])
    return EscapeGait(
        goal=goal_of(entry["goal"]["name"]), gait=gait, ramp=entry["ramp"], value=entry["value"],
        travel=numbers(entry["travel"]), met=entry["met"], shortfalls=tuple(entry["shortfalls"]),
        binding=tuple(entry["binding"]), measured=measured, torque=numbers(entry["torque"]),
        torque_share=numbers(entry["torque_share"]), discrepancy=entry["discrepancy"],
        trajectory=Trajectory.load(run),
    )  # fmt: skip


def why_not(gait: EscapeGait) -> str:
    """What the nearest gait breaks, and what to try."""
    ways = {
        "friction": "smaller swings, or ground with more friction (limits.friction)",
        "clearance": "a smaller limits.tilt, or legs held higher (posture=)",
        "separation": "other joints (joints=), or legs spread wider (posture=)",
        "tilt": "a belly that rolls further (fit_belly(tilt=...))",
        "stands": "other groups= or more joints=, or another goal",
        "engine": "another damping, or frequencies away from twice a rocking mode",
    }
    said = "; ".join(gait.shortfalls)
    tries = [way for word, way in ways.items() if word in said.lower()]
    return f"the nearest gait breaks a limit: {said}. Try {'; '.join(tries) or 'a larger budget'}."
