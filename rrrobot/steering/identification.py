"""Which masses, lengths and damping explain a measured run, and how surely.

The run starts at rest. With p the free parameters and (x_0, y_0, yaw_0) the pose at the start, the
engine predicts the poses; the least sum of squared misses, in units of the noise, is found by
Gauss and Newton's method with Levenberg's damping, and

    covariance of p = (J^T J)^-1,    J = d(predicted / noise) / dp.

A pose does not tell the scale of all masses and the damping together: one mass must stay known.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from rrrobot.checks import Array, finite
from rrrobot.errors import OutputError, ParameterError, RRRobotError
from rrrobot.files import read_text
from rrrobot.inline import html_table
from rrrobot.models.full import FullModel
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.robot import Robot
from rrrobot.rotations import quaternion_from_euler
from rrrobot.steering.shooting import rest_of

COLUMNS = ("time", "x", "y", "yaw", "leg_1", "leg_2")
"""Of a run's table [s, m, m, rad, rad, rad]."""
FREE = ("damping", "leg_mass", "battery_mass", "shell_radius")
_PER_LEG = ("leg_mass", "servo_mass", "leg_length")
_LONGEST_STEP = 0.066


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredRun:
    """Poses and leg angles of a run that starts at rest.

    Attributes:
        time: increasing (n,) [s].
        pose: contact point and yaw (n, 3) [m, m, rad]; the yaw may jump by whole turns.
        leg_angle: (n, 2) [rad].

    Raises:
        ParameterError: arrays that do not fit, are not finite, or times that do not increase.
    """

    time: Array
    pose: Array
    leg_angle: Array

    def __post_init__(self) -> None:
        n = np.size(self.time)
        for name, shape in (("time", (n,)), ("pose", (n, 3)), ("leg_angle", (n, 2))):
            array = np.array(getattr(self, name), dtype=float)
            if array.shape != shape or n < 10 or not np.all(np.isfinite(array)):
                raise ParameterError(
                    f"{name} has the shape {array.shape}: it must be {shape}, finite, of at least "
                    "10 samples."
                )
            object.__setattr__(self, name, array)
        if np.any(np.diff(self.time) <= 0):
            raise ParameterError("time must increase from sample to sample.")
        self.pose[:, 2] = np.unwrap(self.pose[:, 2])

    @classmethod
    def from_csv(cls, path: str | Path) -> MeasuredRun:
        """Read a table with the columns time, x, y, yaw, leg_1, leg_2; more are left alone.

        Raises:
            OutputError: it cannot be read, or lacks one of them.
        """
        try:
            rows = list(csv.reader(io.StringIO(read_text(path), newline="")))
            head = [name.split("[")[0].strip() for name in rows[0]]
            missing = [name for name in COLUMNS if name not in head]
            if missing:
                raise ValueError(f"it lacks the columns {', '.join(missing)}")
            table = np.array([[float(row[head.index(c)]) for c in COLUMNS] for row in rows[1:]])
        except (OSError, ValueError, IndexError) as error:
            raise OutputError(
                f"cannot read the run {str(path)!r}: {str(error).rstrip('.')}. It needs the "
                f"columns {', '.join(COLUMNS)} in s, m and rad."
            ) from None
        return cls(time=table[:, 0], pose=table[:, 1:4], leg_angle=table[:, 4:])


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """Parameters that explain a run.

    Attributes:
        parameters: the robot's, those that were not free as given.
        value: of each free parameter, by name; legs apart as leg_mass_1, leg_mass_2.
        uncertainty: standard deviation of each.
        covariance: (k, k), in the order of `value`.
        misfit: root of the mean squared miss, in units of the noise; about 1 if the model is right.
        noise: of place [m] and yaw [rad], as given or found.
    """

    parameters: RRRobotParameters
    value: Mapping[str, float]
    uncertainty: Mapping[str, float]
    covariance: Array = field(repr=False)
    misfit: float
    noise: tuple[float, float]

    def to_dict(self) -> dict[str, Any]:
        """Plain data, SI units."""
        return {
            "parameters": self.parameters.to_dict(),
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
    noise: tuple[float, float] | None = None,
    rounds: int = 40,
) -> Fit:
    """Fit RRRobot's parameters to a measured run.

    Args:
        run: that starts at rest; the more the gaits in it differ, the more it tells.
        guess: to begin with; Table 2 unless given.
        free: names of parameters that are fitted, such as "damping", "leg_mass", "servo_mass",
            "battery_mass", "shell_radius", "leg_length", "hip_offset".
        noise: standard deviation of place [m] and yaw [rad]; from the misses unless given.
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
    start = RRRobotParameters() if guess is None else guess
    names = _names(free)
    if noise is not None:
        noise = (
            finite("noise of the place", noise[0], "m", above=0),
            finite("noise of the yaw", noise[1], "rad", above=0),
        )
    drive = _Legs(run)
    p = np.array([_get(start, name) for name in names])
    first = run.pose[0].copy()
    scale = (1e-3, 1e-2) if noise is None else noise
    damp = 1e-6
    best, jacobian = _misses(drive, run, start, names, p, first, scale)
    for _ in range(rounds):
        square = jacobian.T @ jacobian
        right = -jacobian.T @ best
        size = np.diag(square).copy()
        step = np.linalg.solve(square + damp * np.diag(size + 1e-300), right)
        k = len(names)
        trial = p * np.exp(np.clip(step[:k], -0.3, 0.3))
        try:
            misses, slopes = _misses(drive, run, start, names, trial, first + step[k:], scale)
            better = bool(np.sum(misses**2) < np.sum(best**2))
        except RRRobotError:
            better = False
        if not better:
            damp *= 10.0
            if damp > 1e6:
                break
            continue
        done = np.sum(best**2) - np.sum(misses**2) < 1e-9 * np.sum(best**2)
        p, first, best, jacobian, damp = trial, first + step[k:], misses, slopes, damp / 10.0
        if done:
            break
    k = len(names)
    if noise is None:
        # The noise of places and yaws is what is left of each.
        left = best.reshape(-1, 3)
        found = np.sqrt((np.mean(left[:, :2] ** 2), np.mean(left[:, 2] ** 2)))
        found = np.maximum(found, 1e-12)
        jacobian = (jacobian.reshape(-1, 3, k + 3) / found[[0, 0, 1], None]).reshape(-1, k + 3)
        best = (left / found[[0, 0, 1]]).ravel()
        scale = (scale[0] * float(found[0]), scale[1] * float(found[1]))
    square = jacobian.T @ jacobian
    if np.linalg.cond(square / np.sqrt(np.outer(np.diag(square), np.diag(square)))) > 1e12:
        raise ParameterError(
            f"the run does not tell {', '.join(names)} apart: fit fewer of them (free=), or drive "
            "gaits that differ more."
        )
    covariance = np.linalg.inv(square)[:k, :k] * np.outer(p, p)
    return Fit(
        parameters=_put(start, names, p),
        value=dict(zip(names, p.tolist(), strict=True)),
        uncertainty=dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True)),
        covariance=np.asarray(covariance, dtype=float),
        misfit=float(np.sqrt(np.mean(best**2))),
        noise=scale,
    )


class _Legs:
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

    def poses(self, parameters: RRRobotParameters) -> Array:
        """Poses (n, 3) of a robot that starts at rest at the origin."""
        from rrrobot.momentum.batch import march
        from rrrobot.momentum.coefficients import coefficients
        from rrrobot.momentum.lowering import lower

        model = FullModel(Robot.from_parameters(parameters))
        rest = rest_of(model, self.rest)
        table = coefficients(model.robot, self.angle, self.rate)
        lane = np.concatenate((quaternion_from_euler(rest.euler), np.zeros(6)))
        states = march(lower(model), table[:, :, None], self.steps, lane[None])
        found = np.asarray(states[self.marks, 0, 7:10])
        if not np.all(np.isfinite(found)):
            raise ParameterError("with these parameters the run's motion is not finite.")
        return found


def _misses(
    drive: _Legs,
    run: MeasuredRun,
    start: RRRobotParameters,
    names: Sequence[str],
    p: Array,
    first: Array,
    scale: tuple[float, float],
) -> tuple[Array, Array]:
    """Misses (3 n,) in units of the noise, and their slopes by log p and the start's pose."""
    unit = np.array((scale[0], scale[0], scale[1]))

    def placed(poses: Array) -> Array:
        c, s = np.cos(first[2]), np.sin(first[2])
        x, y, yaw = poses.T
        return np.column_stack((first[0] + c * x - s * y, first[1] + s * x + c * y, first[2] + yaw))

    here = placed(drive.poses(_put(start, names, p)))
    miss = ((here - run.pose) / unit).ravel()
    columns = []
    for i in range(len(names)):
        pair = []
        for sign in (-1, 1):
            near = p.copy()
            near[i] *= np.exp(sign * 1e-4)
            pair.append(placed(drive.poses(_put(start, names, near))))
        columns.append(((pair[1] - pair[0]) / 2e-4 / unit).ravel())
    for axis in range(3):
        change = np.zeros_like(here)
        change[:, axis] = 1.0
        if axis == 2:
            change[:, 0], change[:, 1] = first[1] - here[:, 1], here[:, 0] - first[0]
        columns.append((change / unit).ravel())
    return miss, np.column_stack(columns)


def _names(free: Sequence[str]) -> list[str]:
    known = (*_PER_LEG, "battery_mass", "shell_radius", "hip_offset", "damping")
    bad = [name for name in free if name not in known]
    if bad or not free:
        raise ParameterError(
            f"free is {', '.join(free) or '(nothing)'}: known are {', '.join(known)}."
        )
    return [n for f in free for n in ((f"{f}_1", f"{f}_2") if f in _PER_LEG else (f,))]


def _get(parameters: RRRobotParameters, name: str) -> float:
    stem, _, leg = name.rpartition("_")
    if stem in _PER_LEG:
        return float(np.broadcast_to(getattr(parameters, stem), 2)[int(leg) - 1])
    return float(getattr(parameters, name))


def _put(parameters: RRRobotParameters, names: Sequence[str], p: ArrayLike) -> RRRobotParameters:
    values: dict[str, Any] = {}
    for name, x in zip(names, np.asarray(p).tolist(), strict=True):
        stem, _, leg = name.rpartition("_")
        if stem in _PER_LEG:
            pair = values.setdefault(stem, [0.0, 0.0])
            pair[int(leg) - 1] = x
        else:
            values[name] = x
    pairs: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in values.items()}
    return replace(parameters, **pairs)
