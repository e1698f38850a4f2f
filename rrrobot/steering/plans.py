"""A plan: leg motions that lead a robot from a resting pose to another, and what to do with it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.schedule import Schedule
from rrrobot.models.base import Model
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.steering.obstacles import Obstacle
from rrrobot.steering.shooting import Rest, gap


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """Leg motions that lead a robot from a resting pose to another.

    Attributes:
        model: that it was planned for.
        gait: the schedule, a `Gait` like any other.
        duration: until the body is at rest [s]; the legs are it at `gait.duration`.
        start, goal: (x, y, yaw) [m, m, rad].
        predicted: where the exact motion ends (3,).
        path: the coarse plan, poses (n, 3).
        lower_bound: time that no plan of these gaits can beat: distance and turn at the highest
            speed and yaw rate [s].
        obstacles, margin: what was kept clear, and how far [m].
        rest: how the body stands at the start.

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
        progress: Any = None,
    ) -> Trajectory:
        """Simulate it from rest on the model it was planned for, or on another.

        Args:
            model: such as one with other masses; the plan's own unless given.
            method, sample_interval, progress: as for `simulate`.
        """
        model = self.model if model is None else model
        return simulate(
            model, self.gait, self.duration, sample_interval, start="rest", method=method,
            euler=self.rest.euler + np.array((0.0, 0.0, self.start[2])), position=self.start[:2],
            progress=progress,
        )  # fmt: skip

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
        }
