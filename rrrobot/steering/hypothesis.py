"""A supposed robot and slope, and the poses that they predict for a measured run's leg motion."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from rrrobot.checks import Array
from rrrobot.contact.ground import Plane
from rrrobot.errors import GroundClearanceWarning, ParameterError
from rrrobot.models.full import FullModel
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.robot import Robot
from rrrobot.rotations import quaternion_from_euler
from rrrobot.steering.measured import MeasuredRun
from rrrobot.steering.shooting import table_of
from rrrobot.steering.standing import standing

PER_LEG = ("leg_mass", "servo_mass", "leg_length")
SLOPES = ("slope_x", "slope_y")
_LONGEST_STEP = 0.066


class Hypothesis(NamedTuple):
    """A robot and the rise of its ground along x and y (2,)."""

    parameters: RRRobotParameters
    slope: Array

    @property
    def ground(self) -> Plane:
        return Plane(normal=(-self.slope[0], -self.slope[1], 1.0))

    def get(self, name: str) -> float:
        if name in SLOPES:
            return float(self.slope[SLOPES.index(name)])
        stem, _, leg = name.rpartition("_")
        if stem in PER_LEG:
            return float(np.broadcast_to(getattr(self.parameters, stem), 2)[int(leg) - 1])
        return float(getattr(self.parameters, name))

    def put(self, names: Sequence[str], p: ArrayLike) -> Hypothesis:
        values: dict[str, Any] = {}
        slope = self.slope.copy()
        for name, x in zip(names, np.asarray(p).tolist(), strict=True):
            stem, _, leg = name.rpartition("_")
            if name in SLOPES:
                slope[SLOPES.index(name)] = x
            elif stem in PER_LEG:
                values.setdefault(stem, [0.0, 0.0])[int(leg) - 1] = x
            else:
                values[name] = x
        pairs: dict[str, Any] = {
            key: tuple(v) if isinstance(v, list) else v for key, v in values.items()
        }
        with warnings.catch_warnings():  # what is only tried needs no advice
            warnings.simplefilter("ignore", GroundClearanceWarning)
            return Hypothesis(replace(self.parameters, **pairs), slope)


class Replay:
    """Leg angles and rates of a run at the engine's instants."""

    def __init__(self, run: MeasuredRun) -> None:
        from rrrobot.momentum.batch import ROWS_PER_STEP, stage_times

        gaps = np.diff(run.time)
        count = np.maximum(1, np.ceil(gaps / _LONGEST_STEP)).astype(int)
        self.steps = np.repeat(gaps / count, count)
        self.marks = np.concatenate(([0], np.cumsum(count)))
        rows = [
            stage_times(t, gap / n, n)[: n * ROWS_PER_STEP]
            for t, gap, n in zip(run.time, gaps, count, strict=False)
        ]
        instants = np.append(np.concatenate(rows), run.time[-1])
        spline = make_interp_spline(run.time, run.leg_angle, k=5)
        self.angle, self.rate = spline(instants), spline.derivative()(instants)
        self.rest = run.leg_angle[0]

    def poses(self, guess: Hypothesis, start: Array) -> Array:
        """Poses (n, 3) of a robot that starts at rest at a pose (3,)."""
        from rrrobot.momentum.batch import march
        from rrrobot.momentum.lowering import lower

        with warnings.catch_warnings():  # what is only tried needs no advice
            warnings.simplefilter("ignore", GroundClearanceWarning)
            robot = Robot.from_parameters(guess.parameters)
        model = FullModel(robot, ground=guess.ground)
        euler = standing(model, self.rest, float(start[2]))
        setting = lower(model)
        table = table_of(setting, self.angle, self.rate)
        lane = np.concatenate((quaternion_from_euler(euler), np.zeros(3), start))
        states = march(setting, table[:, :, None], self.steps, lane[None])
        found = np.asarray(states[self.marks, 0, 7:10])
        if not np.all(np.isfinite(found)):
            raise ParameterError("with these parameters the run's motion is not finite.")
        return found


def parameter_names(free: Sequence[str]) -> list[str]:
    """Names of single numbers, legs and directions apart.

    Raises:
        ParameterError: none, or unknown ones.
    """
    known = (*PER_LEG, "battery_mass", "shell_radius", "hip_offset", "damping", "slope")
    bad = [name for name in free if name not in known]
    if bad or not free:
        raise ParameterError(
            f"free is {', '.join(free) or '(nothing)'}: known are {', '.join(known)}."
        )
    names: list[str] = []
    for name in free:
        if name == "slope":
            names += SLOPES
        else:
            names += (f"{name}_1", f"{name}_2") if name in PER_LEG else (name,)
    return names
