"""What an optimised gait is: the gait, and what the general model says that it does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait
from rrrobot.inline import html_table
from rrrobot.models.base import Model
from rrrobot.simulation.measures import measured
from rrrobot.simulation.run import simulate
from rrrobot.simulation.steady import SteadyState, steady_state
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.studies.optimisation.goals import Goal
from rrrobot.studies.optimisation.saved import read_result, reading, write_result
from rrrobot.studies.optimisation.table import GaitLimits, Joints, Table, columns

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
        measured: every result by name (`rrrobot.results`), over the last cycles of that
            simulation.
        discrepancy: largest relative difference of speed, yaw rate, torque and friction between
            the engine of the search and that simulation.
        lift_off_time: first sample at which the start, before it settles, lifts off [s]; or None.
        evaluations: gaits that the search tried.
        cycles: of legs that it simulated for them.
        history: (k, 2) evaluations, best value so far; NaN while no gait was within the limits.
        search: bounds, seed, budget and settle time.
        trajectory: the confirming simulation.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> best = rr.optimise(model, "fastest", offset=1.5708, amplitude=0.3,
        ...                    angular_frequency=8.0, budget=600)
        >>> best.met, round(1000 * best.value, 1)
        (True, 9.7)
    """

    gait: Gait
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
    cycles: float
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
            "measured": {k: v if np.isfinite(v) else None for k, v in self.measured.items()},
            "discrepancy": self.discrepancy,
            "lift_off_time": self.lift_off_time,
            "limits": self.limits.to_dict(),
            "evaluations": self.evaluations,
            "cycles": self.cycles,
            "history": [[int(n), None if np.isnan(v) else float(v)] for n, v in self.history],
            "search": dict(self.search),
            "model": self.trajectory.metadata.get("model"),
            "robot": self.trajectory.robot.to_dict(),
        }

    def save(self, path: str | Path) -> Path:
        """Write everything but the trajectory to a .json file, which `read_gait` reads too.

        Raises:
            OutputError: the file cannot be written, or its name does not end in .json.
        """
        return write_result(path, self.to_dict())

    @classmethod
    def load(cls, path: str | Path) -> OptimisedGait:
        """Read what `save`, or `rrrobot optimise --out`, wrote; the gait is simulated anew.

        Raises:
            OutputError: the file is missing, damaged, or of something else.
        """
        with reading(path):
            data = read_result(path)
            goal, gait = data["goal"], data["gait"]
            trajectory, state, row = confirm(data["model"], gait, data["search"]["settle_time"])
            history = [(n, np.nan if value is None else value) for n, value in data["history"]]
            return cls(
                gait=gait, goal=goal, limits=data["limits"], value=float(goal.value(row)[0]),
                met=data["met"], shortfalls=tuple(data["shortfalls"]), steady_state=state,
                measured=row.to_dict(), discrepancy=data["discrepancy"],
                lift_off_time=trajectory.lift_off_time, evaluations=data["evaluations"],
                cycles=data["cycles"],
                history=np.array(history, dtype=float).reshape(-1, 2), search=data["search"],
                trajectory=trajectory,
            )  # fmt: skip

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
    state = steady_state(t, after=settled - 1e-9)
    last = slice(-2 * _SAMPLES, None)
    row = measured(t, state, last)
    values = np.array([[float(row[name][0]) for name in columns()]])
    motion = gait(np.linspace(0.0, period, 513))
    torque = np.abs(t.leg_torque[last]).max(axis=0)
    rate, acceleration = np.abs(motion.rate).max(axis=0), np.abs(motion.acceleration).max()
    ends = motion.angle.min(axis=0)[None], motion.angle.max(axis=0)[None]
    joints = Joints(*ends, rate[None], np.array([acceleration]), torque[None])
    return t, state, Table(values, joints)
