"""Settled motions for the claims: a run of whole cycles, its last cycle, and what it swings by."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait, SinusoidalGait
from rrrobot.errors import GaitError
from rrrobot.models.base import Model
from rrrobot.paper.workshop import AMPLITUDE, CYCLES, FREQUENCY
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory

SAMPLES = 32
"""Samples in each cycle of `settled`."""


def both_legs(
    offset: ArrayLike,
    phase_difference: float = math.pi / 2,
    *,
    amplitude: ArrayLike = AMPLITUDE,
    start: float = 0.0,
) -> SinusoidalGait:
    """Both legs in the paper's sinusoids; leg 2 leads by a phase difference, leg 1 by `start`."""
    return SinusoidalGait(
        offset=offset,
        amplitude=amplitude,
        angular_frequency=FREQUENCY,
        phase=(start, start + phase_difference),
    )


def settled(model: Model, gait: Gait, *, cycles: int = CYCLES, **start: Any) -> Trajectory:
    """The motion over whole cycles of a gait, `SAMPLES` in each; `start` as for `simulate`."""
    if gait.period is None:
        raise GaitError("the gait has no period, so its motion never settles.")
    return simulate(
        model, gait, cycles * gait.period, gait.period / SAMPLES, method="momentum", **start
    )


def last_cycle(trajectory: Trajectory) -> slice:
    """The samples of the last whole cycle of a `settled` motion, its end left out."""
    return slice(len(trajectory) - 1 - SAMPLES, len(trajectory) - 1)


def swing(trajectory: Trajectory) -> Array:
    """Half the range of roll, pitch and yaw over the last cycle, less their drift (3,) [rad]."""
    euler = trajectory.euler[-1 - SAMPLES :]
    straight = np.linspace(0.0, 1.0, SAMPLES + 1)[:, None] * (euler[-1] - euler[0])
    return np.asarray(np.ptp(euler - straight, axis=0) / 2)


def distortion(trajectory: Trajectory, axis: int) -> float:
    """Total harmonic distortion of an angle: its higher harmonics over the first, by their rms."""
    harmonics = np.abs(np.fft.rfft(trajectory.euler[last_cycle(trajectory), axis]))
    return float(np.linalg.norm(harmonics[2:]) / harmonics[1])


def cycle_points(trajectory: Trajectory, start: float = 0.5) -> Array:
    """Mean contact points of whole cycles, from a share of a `settled` motion on (n, 2) [m]."""
    cycles = (len(trajectory) - 1) // SAMPLES
    means = trajectory.position[: cycles * SAMPLES].reshape(cycles, SAMPLES, 2).mean(axis=1)
    return np.asarray(means[math.ceil(start * cycles) :])


class Circle(NamedTuple):
    """A circle fitted to points."""

    radius: float
    """[m]"""
    misfit: float
    """rms distance of the points from it [m]"""


def fitted_circle(points: Array) -> Circle:
    """Least-squares circle through points (n, 2), by Kasa's linear fit."""
    x, y = points.T
    a, b, c = np.linalg.lstsq(
        np.column_stack((2 * x, 2 * y, np.ones_like(x))), x**2 + y**2, rcond=None
    )[0]
    radius = math.sqrt(c + a * a + b * b)
    distance = np.hypot(x - a, y - b) - radius
    return Circle(radius, float(np.sqrt(np.mean(distance**2))))


def off_line(points: Array) -> float:
    """Largest distance of points (n, 2) from the straight line that fits them best [m]."""
    centred = points - points.mean(axis=0)
    normal = np.linalg.svd(centred)[2][1]
    return float(np.abs(centred @ normal).max())


def degrees(angle: float) -> float:
    """An angle [rad] in degrees, between -180 and 180."""
    return math.degrees(math.remainder(angle, 2 * math.pi))
