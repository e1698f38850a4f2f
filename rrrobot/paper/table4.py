"""Table 4: how far the simplified models' travel and curvature are from the full model's.

Over a plane of leg offset and phase difference every model is simulated by the momentum engine, and
the ratios of speed and curvature to the full model's are collected where the full model really
travels and turns.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.gaits import SinusoidalGait
from rrrobot.errors import ModelError, ParameterError
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.robot.robot import Robot
from rrrobot.studies.comparison import MODELS, matching_yaw_amplitude

PAPER = {
    "pivoting": {"speed": 1.01, "curvature": 10.0},
    "decoupled": {"speed": 1.25, "curvature": 0.9},
}
"""Table 4 as the paper prints it: over- and underprediction in its worst cases."""

_CYCLES, _COUNTED, _STEPS = 38, 18, 12
"""As `Trajectory.steady_state` counts the cycles of a 30 s run at 8 rad/s."""


class Spread(NamedTuple):
    """Ratios of a model to the full model over the plane."""

    lowest: float
    median: float
    highest: float
    gaits: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Table4:
    """Ratios of travel and of curvature, by model, and the maps behind them.

    Attributes:
        offsets: of both legs (m,) [rad].
        phase_differences: by which leg 2 leads leg 1 (n,) [rad].
        speed: model -> speed (m, n) [m/s]; NaN where a model stopped, or, for "modulated", where
            the yaw model cannot drift as the full one does.
        yaw_rate: model -> yaw rate (m, n) [rad/s]; likewise.
        yaw_amplitude: leg amplitude of the modulated yaw model (m, n) [rad]; likewise.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> table = rr.paper.table_4(robot, offsets=[1.2], phase_differences=[1.57])
        >>> round(table.spread("pivoting", "speed").median, 2)
        1.08
    """

    offsets: Array
    phase_differences: Array
    speed: dict[str, Array]
    yaw_rate: dict[str, Array]
    yaw_amplitude: Array

    def ratio(self, name: str, quantity: str) -> Array:
        """A model's "speed" or "curvature" over the full model's (m, n)."""
        speed = self.speed[name] / self.speed["full"]
        if quantity == "speed":
            return speed
        if quantity != "curvature":
            raise ParameterError(f"quantity is {quantity!r}: it must be 'speed' or 'curvature'.")
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.yaw_rate[name] / self.yaw_rate["full"] / speed)

    def spread(
        self, name: str, quantity: str, *, min_speed: float = 6e-3, min_yaw_rate: float = 5e-3
    ) -> Spread:
        """Extremes of a ratio where the full model is faster than both thresholds.

        Args:
            name: of the model, "pivoting", "decoupled" or "modulated".
            quantity: "speed" or "curvature".
            min_speed: [m/s].
            min_yaw_rate: [rad/s]; for curvature only.
        """
        counted = self.speed["full"] > min_speed
        if quantity == "curvature":
            counted &= np.abs(self.yaw_rate["full"]) > min_yaw_rate
        ratios = self.ratio(name, quantity)[counted]
        ratios = ratios[np.isfinite(ratios)]
        if not ratios.size:
            return Spread(np.nan, np.nan, np.nan, 0)
        return Spread(
            float(ratios.min()), float(np.median(ratios)), float(ratios.max()), ratios.size
        )

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data, for JSON."""
        return {
            "offsets": self.offsets,
            "phase_differences": self.phase_differences,
            "speed": self.speed,
            "yaw_rate": self.yaw_rate,
            "yaw_amplitude": self.yaw_amplitude,
            "spread": {
                f"{quantity}, {model}": self.spread(model, quantity)._asdict()
                for quantity in ("speed", "curvature")
                for model in MODELS[1:]
            },
        }


def table_4(
    robot: Robot,
    *,
    offsets: ArrayLike,
    phase_differences: ArrayLike,
    amplitude: float = 0.3,
    angular_frequency: float = 8.0,
) -> Table4:
    """Compare the models over a plane of gaits, each with the paper's damping.

    Args:
        robot: RRRobot, or another with two legs and a spherical shell.
        offsets: of both legs (m,) [rad].
        phase_differences: by which leg 2 leads leg 1 (n,) [rad].
        amplitude: of both legs [rad].
        angular_frequency: [rad/s].

    Returns:
        the maps over the last 18 of 38 cycles, and ratios.

    Raises:
        ParameterError: an empty list, or a number out of range.
        ModelError: the robot does not have two legs, or is not what the pivoting model needs.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> table = rr.paper.table_4(rr.Robot.from_parameters(), offsets=[np.pi / 2],
        ...                    phase_differences=[np.pi / 2])
        >>> table.ratio("pivoting", "speed").round(2).tolist()
        [[1.01]]
    """
    from rrrobot.drive.gaits import GaitBatch
    from rrrobot.momentum.batch import decoupled_setting, lower, steady_states

    rows = vector("offsets", offsets, np.size(offsets), "rad")
    columns = vector("phase_differences", phase_differences, np.size(phase_differences), "rad")
    if not rows.size or not columns.size:
        raise ParameterError("offsets and phase_differences must each hold at least one angle.")
    if robot.n_legs != 2:
        raise ModelError(f"Table 4 is of robots with two legs; this one has {robot.n_legs}.")
    swing = finite("amplitude", amplitude, "rad", above=0)
    omega = finite("angular_frequency", angular_frequency, "rad/s", above=0)
    offset, phase = (a.ravel() for a in np.meshgrid(rows, columns, indexing="ij"))
    centre, phases = np.column_stack((offset, offset)), np.column_stack((0 * phase, phase))
    frequency = np.full(offset.size, omega)
    gaits = GaitBatch.sinusoidal(centre, np.full((offset.size, 2), swing), phases, frequency)
    single = decoupled_setting(robot)
    run = partial(
        steady_states, gaits=gaits, cycles=_CYCLES, counted=_COUNTED, steps_per_cycle=_STEPS
    )
    found = {
        "full": run(lower(FullModel(robot))),
        "pivoting": run(lower(PivotingModel(robot))),
        "decoupled": run(single),
    }
    amplitudes = np.array(
        [
            _matching(robot, o, swing, omega, p, target)
            for o, p, target in zip(offset, phase, found["full"][:, 3], strict=True)
        ]
    )
    known = np.isfinite(amplitudes)
    modulated = np.where(known, amplitudes, swing)[:, None] * np.ones(2)
    own = GaitBatch.sinusoidal(centre, modulated, phases, frequency)
    found["modulated"] = run(single, yaw=own)
    found["modulated"][~known] = np.nan
    shape = (rows.size, columns.size)
    return Table4(
        offsets=rows,
        phase_differences=columns,
        speed={name: table[:, 0].reshape(shape) for name, table in found.items()},
        yaw_rate={name: table[:, 3].reshape(shape) for name, table in found.items()},
        yaw_amplitude=amplitudes.reshape(shape),
    )


def _matching(
    robot: Robot, offset: float, amplitude: float, omega: float, phase: float, target: float
) -> float:
    """Leg amplitude at which the yaw model drifts at the target [rad]; NaN if there is none."""
    if not abs(target) > 1e-6:
        return np.nan
    gait = SinusoidalGait(
        offset=(offset, offset),
        amplitude=amplitude,
        angular_frequency=omega,
        phase=(0.0, phase),
    )
    try:
        return amplitude * matching_yaw_amplitude(robot, gait, target)
    except ModelError:
        return np.nan
