"""What an optimised gait is: the gait, and what the general model says that it does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.drive.gaits import FourierGait, Gait, SinusoidalGait
from rrrobot.inline import html_table
from rrrobot.models.base import Model
from rrrobot.simulation.run import simulate
from rrrobot.simulation.steady import SteadyState
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.studies.optimisation.goals import Goal
from rrrobot.studies.optimisation.table import COLUMNS, GaitLimits, Table

_SAMPLES = 48
_CYCLES = 4


@dataclass(frozen=True, kw_only=True, eq=False)
class OptimisedGait:
    """The best gait that was found, as the general (KKT) model confirms it.

    Attributes:
        gait: a `SinusoidalGait`, or a `FourierGait` if there are several harmonics.
        goal: what was asked for.
        limits: what it had to respect.
        value: the goal's quantity, in `goal.unit`.
        met: whether all limits hold and a target is reached.
        shortfalls: what does not hold, in words; empty if `met`.
        steady_state: of the confirming simulation.
        measured: by column of `COLUMNS`, over the last cycles of that simulation.
        discrepancy: largest relative difference of speed, yaw rate, torque and friction between
            the engine of the search and that simulation.
        lift_off_time: first sample at which the start, before it settles, lifts off [s]; or None.
        evaluations: gaits that were simulated by the search.
        history: (k, 2) evaluations, best value so far; NaN while no gait was within the limits.
        search: bounds, seed, budget and settle time.
        trajectory: the confirming simulation.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> best = rr.optimise(model, "fastest", offset=1.5708, amplitude=0.3, frequency=8.0,
        ...                    budget=600)
        >>> best.met, round(1000 * best.value, 1)
        (True, 9.7)
    """

    gait: SinusoidalGait | FourierGait
    goal: Goal
    limits: GaitLimits
    value: float
    met: bool
    shortfalls: tuple[str, ...]
    steady_state: SteadyState
    measured: Mapping[str, float]
    discrepancy: float
    lift_off_time: float | None
    evaluations: int
    history: Array = field(repr=False)
    search: Mapping[str, Any] = field(repr=False)
    trajectory: Trajectory = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the trajectory as plain data.

        `gait_from_dict(d["gait"])` gives the gait again.
        """
        return {
            "gait": self.gait.to_dict(),
            "goal": self.goal.to_dict(),
            "value": self.value,
            "unit": self.goal.unit,
            "met": self.met,
            "shortfalls": list(self.shortfalls),
            "steady_state": self.steady_state.to_dict(),
            "measured": dict(self.measured),
            "discrepancy": self.discrepancy,
            "lift_off_time": self.lift_off_time,
            "limits": self.limits.to_dict(),
            "evaluations": self.evaluations,
            "history": [[int(n), None if np.isnan(v) else float(v)] for n, v in self.history],
            "search": dict(self.search),
            "model": self.trajectory.metadata.get("model"),
        }

    def _repr_html_(self) -> str:
        rows = {
            f"{self.goal.name}: {self.goal.quantity}": f"{self.value:.6g} {self.goal.unit}",
            "gait": self.gait,
            "speed": f"{1000 * self.steady_state.speed:.4f} mm/s",
            "curvature": f"{self.steady_state.curvature:.4g} 1/m",
            "limits and goal": "met" if self.met else f"NOT MET: {'; '.join(self.shortfalls)}",
        }
        path = self.trajectory.plot("path").figure
        return html_table("Optimised gait", rows, figure=path)

    def __repr__(self) -> str:
        state = "" if self.met else f", NOT MET: {'; '.join(self.shortfalls)}"
        return (
            f"OptimisedGait({self.goal.name}: {self.goal.quantity} {self.value:.6g} "
            f"{self.goal.unit}, speed {self.steady_state.speed:.6g} m/s, curvature "
            f"{self.steady_state.curvature:.6g} 1/m, "
            f"{self.gait!r}{state})"
        )


def confirm(model: Model, gait: Gait, settle_time: float) -> tuple[Trajectory, SteadyState, Table]:
    """Simulate a gait by the KKT system and measure it as the engine does: one row."""
    period = gait.period or 0.0
    settled = np.ceil(settle_time / period) * period
    duration = settled + _CYCLES * period
    t = simulate(model, gait, duration, period / _SAMPLES)
    state = t.steady_state(start=settled - 1e-9)
    last = slice(-2 * _SAMPLES, None)
    torque, rate = t.leg_torque[last], t.leg_rate[last]
    row = {
        "speed": state.speed,
        "yaw_rate": state.yaw_rate,
        "variation": state.variation,
        "pitch": float(np.abs(t.euler[:, 1]).max()),
        "normal_force": float(t.normal_force[last].min()),
        "friction": float(t.required_friction[last].max()) if t.has_contact else 0.0,
        "rms_torque": float(np.sqrt((torque**2).sum(axis=1).mean())),
        "peak_torque": float(np.abs(torque).max()),
        "power": float(np.abs(torque * rate).sum(axis=1).mean()),
        "clearance": _clearance(t, last),
        "status": 0.0,
    }
    values = np.array([[row[name] for name in COLUMNS]])
    motion = gait(np.linspace(0.0, period, 513))
    largest = (np.array([np.abs(x).max()]) for x in (motion.rate, motion.acceleration))
    return t, state, Table(values, *largest)


def _clearance(trajectory: Trajectory, samples: slice) -> float:
    """Least height of the legs' mass centres above the ground [m]."""
    robot = trajectory.robot
    model, data = robot.model, robot.model.createData()
    joints = [model.getJointId(name) for name in robot.legs]
    joints = [j for j in joints if model.inertias[j].mass > 0]
    lowest = np.inf
    at = zip(
        trajectory.configuration[samples],
        trajectory.ground_normal[samples],
        trajectory.position[samples],
        strict=True,
    )
    for q, normal, position in at:
        foot = trajectory.ground.point(position)
        pin.forwardKinematics(model, data, q)
        for j in joints:
            height = normal @ (data.oMi[j].act(model.inertias[j].lever) - foot)
            lowest = min(lowest, float(height))
    return lowest
