"""Which masses, lengths, damping and slope explain a measured run, and how surely.

The run starts at rest. With p the free parameters and (x_0, y_0, yaw_0) the pose at the start, the
engine predicts the poses; the least sum of squared misses, in units of the noise, is found by
Gauss and Newton's method with Levenberg's damping, and

    covariance of p = (J^T J)^-1,    J = d(predicted / noise) / dp.

A pose does not tell the scale of all masses and the damping together: one mass must stay known.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rrrobot.checks import Array, finite
from rrrobot.contact.ground import Plane
from rrrobot.errors import ParameterError, RRRobotError
from rrrobot.inline import html_table
from rrrobot.models.full import FullModel
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.robot import Robot
from rrrobot.steering.hypothesis import SLOPES, Hypothesis, Replay, parameter_names
from rrrobot.steering.measured import MeasuredRun

FREE = ("damping", "leg_mass", "battery_mass", "shell_radius", "slope")
_PREFIXES = (0.1, 0.2, 0.4)
"""Of the run, fitted first: what a long one comes to from a wrong guess may tell nothing."""
_VAGUE = 0.5
"""Trust in the guess while only a prefix is fitted."""
_NUDGE = 1e-4
"""Of a parameter's logarithm, a slope or a yaw, for derivatives."""
_LEVEL = 1e-7
"""A slope from which the search starts: none that the eye sees, but the equations of a slope."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """Parameters that explain a run.

    Attributes:
        parameters: the robot's, those that were not free as given.
        ground: on which it ran.
        value: of each free parameter, by name; legs apart as leg_mass_1, leg_mass_2, and the
            ground's rise per metre along x and y as slope_x, slope_y.
        uncertainty: standard deviation of each.
        covariance: (k, k), in the order of `value`.
        misfit: root of the mean squared miss, in units of the noise; about 1 if the model is right.
        noise: of place [m] and yaw [rad], as given or found.
    """

    parameters: RRRobotParameters
    ground: Plane
    value: Mapping[str, float]
    uncertainty: Mapping[str, float]
    covariance: Array = field(repr=False)
    misfit: float
    noise: tuple[float, float]

    @property
    def model(self) -> FullModel:
        """The full model of what was found."""
        return FullModel(Robot.from_parameters(self.parameters), ground=self.ground)

    def to_dict(self) -> dict[str, Any]:
        """Plain data, SI units."""
        return {
            "parameters": self.parameters.to_dict(),
            "ground": self.ground.to_dict(),
            "value": dict(self.value),
            "uncertainty": dict(self.uncertainty),
            "covariance": self.covariance.tolist(),
            "misfit": self.misfit,
            "noise": list(self.noise),
        }

    def _repr_html_(self) -> str:
        rows = [(k, f"{v:.6g}", f"{self.uncertainty[k]:.2g}") for k, v in self.value.items()]
        return html_table("Fit", rows, head=("parameter", "value", "standard deviation"))


def identify(
    run: MeasuredRun,
    guess: RRRobotParameters | None = None,
    *,
    free: Sequence[str] = FREE,
    ground: Plane | None = None,
    noise: tuple[float, float] | None = None,
    trust: Mapping[str, float] | None = None,
    rounds: int = 40,
) -> Fit:
    """Fit RRRobot's parameters, and the slope it stands on, to a measured run.

    Args:
        run: that starts at rest; the more the gaits in it differ, the more it tells.
        guess: to begin with; Table 2 unless given.
        free: names of parameters that are fitted, such as "damping", "leg_mass", "servo_mass",
            "battery_mass", "shell_radius", "leg_length", "hip_offset", and "slope".
        ground: on which it ran, or the slope to begin with; level unless given.
        noise: standard deviation of place [m] and yaw [rad]; from the misses unless given.
        trust: how surely the guess is known: relative standard deviations by name, of a slope
            itself. What is named is drawn to the guess as one measurement of it would; a run that
            tells little then does no harm.
        rounds: of Newton's method at most.

    Raises:
        ParameterError: unknown names, or a run that does not tell them apart.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> from rrrobot.steering import MeasuredRun, identify
        >>> heavy = rr.RRRobotParameters(battery_mass=0.32, damping=0.013)
        >>> gait = rr.RampIn(rr.gait("circular"), 4.0)
        >>> model = rr.FullModel(rr.Robot.from_parameters(heavy))
        >>> t = rr.simulate(model, gait, 20.0, 0.05, start="rest")
        >>> pose = np.column_stack((t.position, t.euler[:, 2]))
        >>> run = MeasuredRun(time=t.time, pose=pose, leg_angle=t.leg_angle)
        >>> fit = identify(run, free=("damping", "battery_mass"))
        >>> {name: round(x, 3) for name, x in fit.value.items()}
        {'damping': 0.013, 'battery_mass': 0.32}
    """
    names = parameter_names(free)
    if noise is not None:
        noise = (
            finite("noise of the place", noise[0], "m", above=0),
            finite("noise of the yaw", noise[1], "rad", above=0),
        )
    n = (Plane() if ground is None else ground).normal_vector
    slope = -n[:2] / n[2]
    if "slope" in free:
        slope = np.where(np.abs(slope) < _LEVEL, _LEVEL, slope)
    start = Hypothesis(RRRobotParameters() if guess is None else guess, slope)
    p = guessed = np.array([start.get(name) for name in names])
    scale = (1e-3, 1e-2) if noise is None else noise
    k, first = len(names), run.pose[0].copy()
    vague = _Prior(names, guessed, dict.fromkeys(names, _VAGUE) | dict(trust or {}))
    for share in _PREFIXES:
        part = run.first(share)
        if part.time.size >= 100:
            p, first, *_ = _solved(part, start, names, p, first, scale, vague, 6)
    prior = _Prior(names, guessed, trust or {})
    p, first, best, jacobian = _solved(run, start, names, p, first, scale, prior, rounds)
    if noise is None:
        # The noise of places and yaws is what is left of each.
        best, jacobian = best[: run.pose.size], jacobian[: run.pose.size]
        left = best.reshape(-1, 3)
        found = np.sqrt((np.mean(left[:, :2] ** 2), np.mean(left[:, 2] ** 2)))
        found = np.maximum(found, 1e-12)
        jacobian = (jacobian.reshape(-1, 3, k + 3) / found[[0, 0, 1], None]).reshape(-1, k + 3)
        best, jacobian = prior.joined(p, (left / found[[0, 0, 1]]).ravel(), jacobian)
        scale = (scale[0] * float(found[0]), scale[1] * float(found[1]))
    square = jacobian.T @ jacobian
    if np.linalg.cond(square / np.sqrt(np.outer(np.diag(square), np.diag(square)))) > 1e12:
        raise ParameterError(
            f"the run does not tell {', '.join(names)} apart: fit fewer of them (free=), or drive "
            "gaits that differ more."
        )
    per_step = np.where([name in SLOPES for name in names], 1.0, p)
    covariance = np.linalg.inv(square)[:k, :k] * np.outer(per_step, per_step)
    final = start.put(names, p)
    return Fit(
        parameters=final.parameters,
        ground=final.ground,
        value=dict(zip(names, p.tolist(), strict=True)),
        uncertainty=dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True)),
        covariance=np.asarray(covariance, dtype=float),
        misfit=float(np.sqrt(np.mean(best[: run.pose.size] ** 2))),
        noise=scale,
    )


def _solved(
    run: MeasuredRun,
    start: Hypothesis,
    names: Sequence[str],
    p: Array,
    first: Array,
    scale: tuple[float, float],
    prior: _Prior,
    rounds: int,
) -> tuple[Array, Array, Array, Array]:
    """Parameters, first pose, misses and their slopes, after Gauss and Newton's method."""
    legs, k, damp = Replay(run), len(names), 1e-6

    def misses_at(p: Array, first: Array) -> tuple[Array, Array]:
        return prior.joined(p, *_misses(legs, run, start, names, p, first, scale))

    best, jacobian = misses_at(p, first)
    for _ in range(rounds):
        square = jacobian.T @ jacobian
        size = np.diag(square) + 1e-300
        step = np.linalg.solve(square + damp * np.diag(size), -jacobian.T @ best)
        trial = _moved(names, p, np.clip(step[:k], -0.3, 0.3))
        try:
            misses, slopes = misses_at(trial, first + step[k:])
            better = bool(np.sum(misses**2) < np.sum(best**2))
        except RRRobotError:
            better = False
        if not better:
            damp *= 10.0
            if damp > 1e6:
                break
            continue
        done = np.sum(best**2) - np.sum(misses**2) < 1e-6 * np.sum(best**2)
        p, first, best, jacobian, damp = trial, first + step[k:], misses, slopes, damp / 10.0
        if done:
            break
    return p, first, best, jacobian


class _Prior:
    """What is known of parameters beforehand, as one more miss of each."""

    def __init__(self, names: Sequence[str], guess: Array, trust: Mapping[str, float]) -> None:
        known = [trust.get(name, trust.get(name.rpartition("_")[0], np.inf)) for name in names]
        self._weight = 1.0 / np.array(
            [finite(f"trust in {n}", t, above=0) if t != np.inf else t
             for n, t in zip(names, known, strict=True)]
        )  # fmt: skip
        self._plain = np.array([name in SLOPES for name in names])
        self._guess = guess.copy()

    def joined(self, p: Array, misses: Array, slopes: Array) -> tuple[Array, Array]:
        """Misses and slopes with those of the guess below."""
        with np.errstate(divide="ignore", invalid="ignore"):
            away = np.where(self._plain, p - self._guess, np.log(p / self._guess))
        rows = np.zeros((p.size, slopes.shape[1]))
        rows[:, : p.size] = np.diag(self._weight)
        return np.append(misses, self._weight * away), np.vstack((slopes, rows))


def _misses(
    legs: Replay,
    run: MeasuredRun,
    start: Hypothesis,
    names: Sequence[str],
    p: Array,
    first: Array,
    scale: tuple[float, float],
) -> tuple[Array, Array]:
    """Misses (3 n,) in units of the noise, and their slopes by steps of p and the start's pose."""
    unit = np.array((scale[0], scale[0], scale[1]))
    here = legs.poses(start.put(names, p), first)
    columns = []
    for step in _NUDGE * np.eye(len(names)):
        near = legs.poses(start.put(names, _moved(names, p, step)), first)
        columns.append((near - here) / _NUDGE)
    columns += [np.broadcast_to(row, here.shape) for row in np.eye(3)[:2]]
    near = legs.poses(start.put(names, p), first + _NUDGE * np.eye(3)[2])
    columns.append((near - here) / _NUDGE)
    return ((here - run.pose) / unit).ravel(), np.column_stack(
        [(c / unit).ravel() for c in columns]
    )


def _moved(names: Sequence[str], p: Array, step: Array) -> Array:
    """Parameters after a step: of the logarithm, of slopes themselves."""
    plain = np.array([name in SLOPES for name in names])
    return np.where(plain, p + step, p * np.exp(step))
