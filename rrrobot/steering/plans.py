"""A plan: leg motions that lead a robot from rest at a pose to rest at another."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.schedule import Schedule
from rrrobot.errors import OutputError
from rrrobot.files import read_json, write_whole
from rrrobot.inline import html_table
from rrrobot.models import model_from_dict
from rrrobot.models.base import Model
from rrrobot.progress import Progress
from rrrobot.robot.robot import Robot
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.steering.demands import Demands, demands_of
from rrrobot.steering.obstacles import Obstacle, obstacle_from_dict
from rrrobot.steering.shooting import gap
from rrrobot.steering.standing import Rest, standing

FORMAT = "rrrobot plan 1"


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """Leg motions that lead a robot from a resting pose to another.

    Attributes:
        model: that it was planned for.
        gait: the schedule, a `Gait` like any other.
        duration: until the body is at rest [s]; the legs are it at `gait.duration`.
        start, goal: (x, y, yaw) [m, m, rad].
        predicted: where the exact motion ends (3,), on the model that `on` says.
        path: the coarse plan, poses (n, 3).
        lower_bound: time that no plan of these gaits can beat: distance and turn at the highest
            speed and yaw rate [s].
        obstacles, margin: what was kept clear, and how far [m].
        rest: how the body stands at the start.
        on: the model it was planned on: "full", or the "decoupled" ones.

    Example:
        >>> import rrrobot as rr
        >>> p = rr.plan(rr.FullModel(rr.Robot.from_parameters()), goal=(0.0, 0.2, 0.0))
        >>> bool(p.lower_bound < p.gait.duration < p.duration)
        True
    """

    model: Model = field(repr=False)
    gait: Schedule
    duration: float
    start: Array
    goal: Array
    predicted: Array
    path: Array = field(repr=False)
    lower_bound: float
    obstacles: tuple[Obstacle, ...] = field(default=(), repr=False)
    margin: float = 0.0
    rest: Rest = field(repr=False)
    on: str = "full"

    @property
    def error(self) -> Array:
        """Predicted minus wanted pose (3,), the angle between -pi and pi."""
        return gap(self.predicted.copy(), self.goal)

    def execute(
        self,
        model: Model | None = None,
        *,
        method: str = "kkt",
        sample_interval: float = 0.02,
        progress: Progress = False,
    ) -> Trajectory:
        """Simulate it from rest on the model it was planned for, or on another.

        Args:
            model: such as one with other masses; the plan's own unless given.
            method, sample_interval, progress: as for `simulate`.
        """
        model = self.model if model is None else model
        return simulate(
            model, self.gait, self.duration, sample_interval, start="rest", method=method,
            euler=standing(model, self.rest.leg_angle, float(self.start[2])),
            position=self.start[:2], progress=progress,
        )  # fmt: skip

    def demands(self, trajectory: Trajectory | None = None) -> Demands:
        """What the whole run asks of motors, ground and legs.

        Args:
            trajectory: of `execute`; simulated in 30 samples a leg cycle unless given.
        """
        if trajectory is None:
            often = 2 * np.pi / self.gait.angular_frequency / 30
            trajectory = self.execute(method="momentum", sample_interval=often)
        return demands_of(trajectory)

    def to_dict(self) -> dict[str, Any]:
        """Schedule, poses and times as plain data."""
        return {
            "gait": self.gait.to_dict(),
            "duration": self.duration,
            "start": self.start.tolist(),
            "goal": self.goal.tolist(),
            "predicted": self.predicted.tolist(),
            "error": self.error.tolist(),
            "lower_bound": self.lower_bound,
            "obstacles": [o.to_dict() for o in self.obstacles],
            "margin": self.margin,
            "on": self.on,
        }

    def plot(self, trajectory: Trajectory | None = None, ax: Any = None) -> Any:
        """Draw the coarse path, the exact one, obstacles and margins.

        Args:
            trajectory: the exact motion; simulated unless given.
            ax: matplotlib axes; new ones unless given.

        Returns:
            the Axes.
        """
        from rrrobot.steering.plots import plan_panel

        return plan_panel(self, trajectory, ax)

    def save(self, path: str | Path) -> Path:
        """Write the plan with its robot and model as a .json file; `load` is the inverse.

        The file is a gait's too: `read_gait` and `--gait` of every command take its schedule.

        Raises:
            OutputError: the file cannot be written, or its name does not end in .json.
        """
        target = Path(path)
        if target.suffix.lower() != ".json":
            raise OutputError(f"cannot write {str(target)!r}: a plan's file ends in .json.")
        data = {
            "format": FORMAT,
            "robot": self.model.robot.to_dict(),
            "model": self.model.to_dict(),
            "path": self.path.tolist(),
            "rest": {key: np.asarray(x).tolist() for key, x in self.rest._asdict().items()},
            **self.to_dict(),
        }
        return write_whole(target, (json.dumps(data, indent=1) + "\n").encode())

    @classmethod
    def load(cls, path: str | Path) -> Plan:
        """Read what `save` wrote; it runs as it did, to the last bit.

        Raises:
            OutputError: the file is missing, damaged, or no plan.
        """
        try:
            data = read_json(path)
            if data["format"] != FORMAT:
                raise ValueError(f"its format is {data['format']!r}, not {FORMAT!r}")
            rest = Rest(
                np.array(data["rest"]["leg_angle"]),
                np.array(data["rest"]["euler"]),
                float(data["rest"]["settling"]),
            )
            parts: dict[str, Any] = {
                key: np.array(data[key]) for key in ("start", "goal", "predicted", "path")
            }
            parts |= {key: float(data[key]) for key in ("duration", "lower_bound", "margin")}
            return cls(
                model=model_from_dict(data["model"], Robot.from_dict(data["robot"])),
                gait=Schedule.from_dict(data["gait"]),
                obstacles=tuple(obstacle_from_dict(o) for o in data["obstacles"]),
                rest=rest,
                on=data["on"],
                **parts,
            )
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise OutputError(
                f"{str(path)!r} is not a plan that rrrobot saved: {str(error).rstrip('.')}."
            ) from None

    def _repr_html_(self) -> str:
        metres, degrees = np.linalg.norm(self.error[:2]), np.rad2deg(abs(self.error[2]))
        rows = {
            "from": _pose(self.start),
            "to": _pose(self.goal),
            "missed by": f"{1000 * metres:.3g} mm, {degrees:.2g} deg",
            "duration": f"{self.duration:.4g} s, of which {self.gait.duration:.4g} s moving",
            "no gait of these is faster than": f"{self.lower_bound:.4g} s",
            "planned on": f"the {self.on} model",
        }
        return html_table("Plan", rows, figure=self.plot().figure)

    def __repr__(self) -> str:
        return f"Plan({_pose(self.start)} to {_pose(self.goal)}, {self.duration:.4g} s)"


def _pose(pose: Array) -> str:
    x, y, yaw = pose.tolist()
    return f"({x:.4g} m, {y:.4g} m, {np.rad2deg(yaw) + 0.0:.4g} deg)"
