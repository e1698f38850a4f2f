"""The (offset, phase difference) map of two legs that swing alike, and its inverse."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits import GaitBatch
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.outcome import Outcome, Refusal, settle
from rrrobot.momentum.batch import RESULT
from rrrobot.robot.robot import Robot
from rrrobot.studies.sweeps.variants import engine_of

_OFFSETS, _PHASES = 37, 36
_STEPS = 10
_TRIES = 8
_STEP = 1e-3
"""Of the inverse's differences [rad]."""


class MotionMap(NamedTuple):
    """Settled motions over offsets and phase differences, both in [-pi, pi]."""

    offset: Array
    """(m,) [rad]"""
    phase: Array
    """of leg 2 before leg 1 (n,) [rad]"""
    speed: Array
    """(m, n) [m/s]; NaN where no cycle that holds was found, or the robot lifts off"""
    yaw_rate: Array
    """(m, n) [rad/s]"""


def mappable(given: Robot, knobs: Knobs) -> bool:
    """Whether the map says something of these knobs."""
    return given.n_legs == 2 and knobs.settles and not np.any(knobs.overtone)


def map_key(knobs: Knobs) -> tuple[object, ...]:
    """What the map depends on."""
    k = knobs
    return k.amplitude, k.frequency, k.damping, k.damping_kind, k.gravity, k.slope, k.body


def motion_map(given: Robot, knobs: Knobs) -> MotionMap:
    """The map at these amplitudes, frequency, masses and losses, by limit cycles.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.lab.knobs import Knobs
        >>> from rrrobot.lab.maps import motion_map
        >>> robot = rr.Robot.from_parameters()
        >>> motion_map(robot, Knobs.of(robot)).speed.shape
        (37, 36)
    """
    offset = np.linspace(-np.pi, np.pi, _OFFSETS)
    phase = np.linspace(-np.pi, np.pi, _PHASES, endpoint=False)
    a, p = (part.ravel() for part in np.meshgrid(offset, phase, indexing="ij"))
    n = a.size
    gaits = GaitBatch.sinusoidal(
        np.column_stack((a, a)),
        np.tile(np.array(knobs.amplitude), (n, 1)),
        np.column_stack((0 * p, p)),
        np.full(n, knobs.frequency),
    )
    engine, setting = engine_of(knobs.model(given), "orbit")
    found = engine(setting, gaits, steps_per_cycle=_STEPS)
    speed, yaw = (found[:, RESULT.index(name)] for name in ("speed", "yaw_rate"))
    shape = offset.size, phase.size
    return MotionMap(offset, phase, speed.reshape(shape), yaw.reshape(shape))


def placed(knobs: Knobs, offset: float, phase: float) -> Knobs:
    """Both legs at that offset, leg 2 that much before leg 1 [rad]."""
    first = knobs.phase[0]
    return replace(knobs, offset=(offset, offset), phase=(first, _wrapped(first + phase)))


def inverse(given: Robot, knobs: Knobs, chart: MotionMap, speed: float, curvature: float) -> Knobs:
    """Offset and phase difference whose motion is nearest to a speed [m/s] and curvature [1/m].

    From the nearest gait of the map by Newton's method on the limit cycles themselves. Where a
    motion is out of reach, the nearest that was met.

    Raises:
        Refusal: the map is empty.
    """
    wanted = np.array((speed, speed * curvature))
    scale = np.array((np.nanmax(chart.speed), np.nanmax(np.abs(chart.yaw_rate))))
    if not np.all(np.isfinite(scale)) or np.any(scale == 0):
        raise Refusal("No gait of this map travels.")
    away = np.hypot((chart.speed - wanted[0]) / scale[0], (chart.yaw_rate - wanted[1]) / scale[1])
    i, j = np.unravel_index(int(np.nanargmin(away)), away.shape)
    x = np.array((chart.offset[i], chart.phase[j]))
    best, least, near = placed(knobs, *x), np.inf, None
    for _ in range(_TRIES):
        try:
            here = settle(given, placed(knobs, *x), near)
            rows = [settle(given, placed(knobs, *(x + d)), here) for d in _STEP * np.eye(2)]
        except Refusal:
            break
        near = here
        now = _of(here)
        miss = (wanted - now) / scale
        size = float(np.linalg.norm(miss))
        if size < least:
            best, least = placed(knobs, *x), size
        if size < 1e-6:
            break
        slope = np.column_stack([(_of(row) - now) / _STEP for row in rows]) / scale[:, None]
        dx = np.linalg.lstsq(slope, miss, rcond=1e-3)[0]
        x = x + dx * min(1.0, 0.5 / max(float(np.linalg.norm(dx)), 1e-12))
    return best


def _of(outcome: Outcome) -> Array:
    return np.array((outcome.speed, outcome.yaw_rate))


def _wrapped(angle: float) -> float:
    return (angle + math.pi) % (2 * math.pi) - math.pi
