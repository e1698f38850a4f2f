"""The models side by side on one gait: speed, yaw rate, curvature, amplitudes, and their ratios.

Also the amplitude modulation of the paper's Fig 20: the leg amplitude at which the single-axis yaw
model drifts as fast as the full model.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rrrobot.checks import finite
from rrrobot.drive.gaits import Gait, SinusoidalGait
from rrrobot.errors import GaitError, ModelError
from rrrobot.inline import html_table
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.single_axis import YawModel
from rrrobot.progress import Progress, Tell, progress_of
from rrrobot.robot.robot import Robot
from rrrobot.simulation.recombined import decoupled
from rrrobot.simulation.run import simulate
from rrrobot.simulation.steady import SteadyState
from rrrobot.simulation.trajectory import Trajectory

MODELS = ("full", "pivoting", "decoupled", "modulated")
"""Columns of a comparison; "modulated" is decoupled with the yaw model's amplitude of Fig 20."""

_QUADRATURE = 128


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison:
    """Models side by side on one gait.

    Attributes:
        gait: the gait.
        trajectories: by model name, in the order of `MODELS`; "modulated" is missing where the
            yaw model cannot drift like the full one.
        states: steady state of each.
        yaw_amplitude_factor: leg amplitude of the modulated yaw model over the gait's, or None.

    Example:
        >>> import rrrobot as rr
        >>> c = rr.studies.compare(rr.Robot.from_parameters(), rr.gait("circular"), duration=8.0)
        >>> list(c.states)
        ['full', 'pivoting', 'decoupled', 'modulated']
    """

    gait: Gait
    trajectories: dict[str, Trajectory]
    states: dict[str, SteadyState]
    yaw_amplitude_factor: float | None

    def ratio(self, name: str, quantity: str) -> float | None:
        """A model's speed, yaw_rate or curvature over the full model's; None where that is zero."""
        reference = getattr(self.states["full"], quantity)
        scale = {"speed": 1e-7, "yaw_rate": 1e-6, "curvature": 1e-4}[quantity]
        if abs(reference) < scale:
            return None
        return float(getattr(self.states[name], quantity) / reference)

    def rows(self) -> list[dict[str, Any]]:
        """One plain dict for each model: values, and ratios to the full model."""
        quantities = ("speed", "yaw_rate", "curvature")
        return [
            {"model": name}
            | state.to_dict()
            | {f"{q}_ratio": self.ratio(name, q) for q in quantities}
            | {"pitch_yaw_phase_difference": state.pitch_yaw_phase_difference}
            for name, state in self.states.items()
        ]

    def _repr_html_(self) -> str:
        head = ("model", "speed [mm/s]", "ratio", "yaw rate [rad/s]", "ratio", "curvature [1/m]")
        rows = []
        for name, state in self.states.items():
            ratios = (self.ratio(name, quantity) for quantity in ("speed", "yaw_rate"))
            speed, turn = ("-" if r is None else f"{r:.3f}" for r in ratios)
            numbers = (f"{1000 * state.speed:.4f}", speed, f"{state.yaw_rate:.6f}", turn)
            rows.append((name, *numbers, f"{state.curvature:.4f}"))
        return html_table(f"Models on {self.gait!r}", rows, head=head)


def compare(
    robot: Robot,
    gait: Gait,
    duration: float = 30.0,
    sample_interval: float = 0.01,
    *,
    method: str = "kkt",
    progress: Progress = False,
) -> Comparison:
    """Simulate the full, pivoting and decoupled models on a gait, each with the paper's damping.

    Args:
        robot: with a spherical shell, on level ground.
        gait: with a period.
        duration: [s]; the steady state is measured over its second half.
        sample_interval: [s].
        method: of the full and the pivoting model, as for `simulate`.
        progress: see `rrrobot.progress`; in models.

    Raises:
        GaitError: the gait has no period.

    Example:
        >>> import rrrobot as rr
        >>> c = rr.studies.compare(rr.Robot.from_parameters(), rr.gait("lateral"), duration=20.0)
        >>> round(c.ratio("pivoting", "speed"), 2)
        1.01
    """
    if gait.period is None:
        raise GaitError("the gait has no period, so the models have no steady state to compare.")
    with progress_of(progress, "simulating", len(MODELS), "models") as tell:
        runs, factor = _simulated(robot, gait, duration, sample_interval, method, tell)
    states = {name: run.steady_state() for name, run in runs.items()}
    return Comparison(gait=gait, trajectories=runs, states=states, yaw_amplitude_factor=factor)


def _simulated(
    robot: Robot,
    gait: Gait,
    duration: float,
    sample_interval: float,
    method: str,
    tell: Tell | None,
) -> tuple[dict[str, Trajectory], float | None]:
    """The trajectories by model, and the factor of the modulated yaw model."""
    tell = tell or (lambda done, part="": None)
    runs: dict[str, Trajectory] = {}
    tell(0, "full")
    runs["full"] = simulate(FullModel(robot), gait, duration, sample_interval, method=method)
    tell(1, "pivoting")
    pivoting = PivotingModel(robot)
    runs["pivoting"] = simulate(pivoting, gait, duration, sample_interval, method=method)
    tell(2, "decoupled")
    runs["decoupled"] = decoupled(robot, gait, duration, sample_interval)
    factor = None
    target = runs["full"].steady_state().yaw_rate
    if isinstance(gait, SinusoidalGait) and abs(target) > 1e-6:
        try:
            factor = matching_yaw_amplitude(robot, gait, target)
        except ModelError:
            factor = None
    if factor is not None:
        tell(3, "modulated")
        yaw_gait = scaled(gait, factor)  # type: ignore[arg-type]
        runs["modulated"] = decoupled(robot, gait, duration, sample_interval, yaw_gait=yaw_gait)
    tell(4)
    return runs, factor


def yaw_drift(robot: Robot, gait: Gait) -> float:
    """Mean yaw rate of the yaw model over a cycle [rad/s], without simulating it.

    With zero momentum the yaw rate is -(g12 phi_1_dot + g13 phi_2_dot) / g11, eq (14), a function
    of the legs alone; its mean over the period is a periodic quadrature.

    Raises:
        GaitError: the gait has no period.

    Example:
        >>> import rrrobot as rr
        >>> round(rr.studies.yaw_drift(rr.Robot.from_parameters(), rr.gait("circular")), 6)
        0.013552
    """
    YawModel(robot).check_legs(gait.n_legs)
    return _drift(robot, gait)


def matching_yaw_amplitude(robot: Robot, gait: SinusoidalGait, yaw_rate: float) -> float:
    """Factor on the leg amplitude at which the yaw model drifts at a given rate (Fig 20).

    Args:
        robot: the robot.
        gait: whose amplitude is scaled.
        yaw_rate: the full model's [rad/s].

    Returns:
        the factor, above zero, at most that of a swing of pi/2.

    Raises:
        ModelError: the yaw model drifts the other way, or too slowly at any amplitude up to pi/2.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> factor = rr.studies.matching_yaw_amplitude(robot, rr.gait("circular"), 0.0208547)
        >>> round(0.3 * factor, 3)
        0.377
    """
    from scipy.optimize import brentq

    target = finite("yaw_rate", yaw_rate, "rad/s")
    YawModel(robot).check_legs(gait.n_legs)
    largest = float(np.pi / 2 / np.abs(gait.amplitude).max())

    def excess(factor: float) -> float:
        return _drift(robot, scaled(gait, factor)) - target

    # The drift grows with the square of a small amplitude, so the first crossing is wanted.
    factors = np.linspace(0.0, largest, 41)
    values = [-target, *(excess(f) for f in factors[1:])]
    for low, high, a, b in zip(factors, factors[1:], values, values[1:], strict=False):
        if a * b < 0:
            return float(brentq(excess, low, high, xtol=1e-13, rtol=1e-12))
    raise ModelError(
        f"no leg amplitude up to pi/2 makes the yaw model drift at {target:.4g} rad/s; with this "
        f"gait's own amplitude it drifts at {_drift(robot, gait):.4g} rad/s."
    )


def scaled(gait: SinusoidalGait, factor: float) -> SinusoidalGait:
    """The gait with its amplitudes times a factor."""
    return SinusoidalGait(
        offset=gait.offset,
        amplitude=gait.amplitude * factor,
        angular_frequency=gait.angular_frequency,
        phase=gait.phase,
    )


def _drift(robot: Robot, gait: Gait) -> float:
    from rrrobot.momentum.coefficients import coefficients

    if gait.period is None:
        raise GaitError("the gait has no period, so its drift per cycle is undefined.")
    motion = gait(np.linspace(0.0, gait.period, _QUADRATURE, endpoint=False))
    found = coefficients(robot, motion.angle, motion.rate)
    # K = I_zz w + L_z = 0.
    return float(np.mean(-found[:, 14] / found[:, 5]))
