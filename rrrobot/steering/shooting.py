"""Schedules simulated exactly, many side by side, and their lengths corrected until they arrive."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.schedule import Schedule
from rrrobot.errors import ModelError
from rrrobot.models.base import Model
from rrrobot.orbits.oscillations import equilibrium, modes
from rrrobot.rotations import euler_from_quaternion, quaternion_from_euler

STEPS_PER_CYCLE = 12
_CHUNK = 400
_FADED = 12.0
"""Time constants after which a rocking has faded to 6e-6 of itself."""


class Rest(NamedTuple):
    """A robot at rest with its legs held."""

    leg_angle: Array
    """(legs,) [rad]"""
    euler: Array
    """roll and pitch at rest, yaw 0 (3,) [rad]"""
    settling: float
    """how long the body rocks on once the legs are still [s]"""


def rest_of(model: Model, leg_angle: Array) -> Rest:
    """Where the body stands with these legs, and how long it takes to come to it.

    Raises:
        ModelError: it tips over, or its rocking never fades.
    """
    pose = equilibrium(model, leg_angle)
    euler = euler_from_quaternion(model.place(pose).quaternion)
    rocking = [m for m in modes(model, leg_angle) if np.isfinite(m.period)]
    slowest = min((m.decay_rate for m in rocking), default=0.0)
    if slowest <= 1e-3:
        raise ModelError(
            f"with the legs at {np.round(leg_angle, 4).tolist()} rad the robot's rocking does not "
            "fade (its damping is none, or it tips over), so it never rests: give the model a "
            "damping, or choose other legs with rest=."
        )
    return Rest(np.asarray(leg_angle, dtype=float), euler * (1, 1, 0), _FADED / slowest)


def final_poses(
    model: Model, schedules: Sequence[Schedule], start: Array, rest: Rest, *, tail: float
) -> Array:
    """Resting poses (x, y, yaw) after schedules from rest (n, 3) [m, m, rad]; NaN where one fails.

    Args:
        model: that the momentum engine knows.
        schedules: all of one frequency.
        start: pose at rest (x, y, yaw) (3,).
        rest: how it stands there.
        tail: time after the longest schedule [s].
    """
    from rrrobot.momentum.batch import march, stage_times
    from rrrobot.momentum.coefficients import coefficients
    from rrrobot.momentum.lowering import lower
    from rrrobot.momentum.summary import ROWS_PER_STEP

    setting, n = lower(model), len(schedules)
    step = 2 * np.pi / schedules[0].angular_frequency / STEPS_PER_CYCLE
    steps = int(np.ceil((max(s.duration for s in schedules) + tail) / step))
    quaternion = quaternion_from_euler(rest.euler + np.array((0.0, 0.0, start[2])))
    lane = np.concatenate((quaternion, np.zeros(3), start))
    state = np.tile(lane, (n, 1))
    with np.errstate(all="ignore"):
        for first in range(0, steps, _CHUNK):
            count = min(_CHUNK, steps - first)
            times = stage_times(first * step, step, count)
            tables = np.empty((count * ROWS_PER_STEP + 1, 15, n))
            for i, schedule in enumerate(schedules):
                motion = schedule(times)
                tables[:, :, i] = coefficients(model.robot, motion.angle, motion.rate)
            state = march(setting, tables, np.full(count, step), state)[-1]
    return state[:, 7:10]


class Shot(NamedTuple):
    """A schedule that arrives."""

    schedule: Schedule
    pose: Array
    """where it ends (x, y, yaw) (3,)"""
    error: Array
    """from the goal (dx, dy, dyaw) (3,)"""
    rounds: int
    """of Newton's method"""


class Knobs(NamedTuple):
    """What is turned to make a schedule arrive: numbers, how far they may go, and what they do."""

    make: Callable[[Array], Schedule]
    low: Array
    """(k,)"""
    high: Array
    """(k,)"""
    unit: Array
    """a change of each that counts alike (k,)"""


def shoot(
    model: Model,
    knobs: Knobs,
    guess: Array,
    start: Array,
    goal: Array,
    rest: Rest,
    *,
    tolerance: tuple[float, float],
    tail: float,
    rounds: int = 12,
) -> Shot:
    """Turn the knobs of a schedule until it ends at the goal.

    Newton's method on the exact motion, with derivatives from runs side by side in which each knob
    is a little off; of all changes that would do, the least. A step that does not help is halved.

    Args:
        model: that the momentum engine knows.
        knobs: the schedule as a function of k numbers, k at least three.
        guess: to begin with (k,).
        start, goal: resting poses (x, y, yaw) (3,) [m, m, rad].
        rest: how the robot stands there.
        tolerance: of the place [m] and the yaw [rad].
        tail: see `final_poses`.
        rounds: at most.

    Returns:
        the best that was found, whether it is within the tolerance or not.
    """
    best, share = None, 1.0
    scale = 1.0 / np.array((tolerance[0], tolerance[0], tolerance[1]))
    now = np.clip(guess, knobs.low, knobs.high)
    for number in range(1, rounds + 1):
        nudge = 1e-3 * knobs.unit * np.where(now + 1e-3 * knobs.unit > knobs.high, -1.0, 1.0)
        trials = [now, *(now + np.diag(nudge))]
        found = final_poses(model, [knobs.make(x) for x in trials], start, rest, tail=tail)
        error = gap(found[0], goal)
        size = off(error, tolerance)
        if not np.isfinite(size):
            share *= 0.5
            if best is None or share < 0.05:
                break
        elif best is None or size < off(best.error, tolerance):
            best = Shot(knobs.make(now), found[0], error, number)
            kept, slope = now, (found[1:] - found[0]).T / nudge * knobs.unit
            share = min(1.0, 2.0 * share)
        else:
            share *= 0.4
        if size < 1.0 or share < 0.05:
            break
        # Knobs that stand at their limit and would go beyond it are left out, one after the other.
        free = np.ones(now.size, dtype=bool)
        for _ in range(now.size):
            change = np.zeros(now.size)
            part = slope[:, free] * scale[:, None]
            change[free] = np.linalg.lstsq(part, -best.error * scale, rcond=1e-6)[0]
            size_of = float(np.abs(change).max())
            change *= share * min(1.0, 1.0 / size_of if size_of else 1.0)
            next_ = kept + change * knobs.unit
            below = (next_ < knobs.low - 1e-12) & (kept <= knobs.low + 1e-12)
            above = (next_ > knobs.high + 1e-12) & (kept >= knobs.high - 1e-12)
            stuck = free & (below | above)
            if not stuck.any() or free.sum() - stuck.sum() < 3:
                break
            free &= ~stuck
        now = np.clip(next_, knobs.low, knobs.high)
    if best is None:
        nowhere = np.full(3, np.nan)
        return Shot(knobs.make(now), nowhere, nowhere, rounds)
    return best


def off(error: Array, tolerance: tuple[float, float]) -> float:
    """Distance and angle of an error (3,), the larger in units of its tolerance."""
    return float(max(np.hypot(error[0], error[1]) / tolerance[0], abs(error[2]) / tolerance[1]))


def gap(pose: Array, goal: Array) -> Array:
    """Difference of poses (..., 3), the angle between -pi and pi."""
    out = pose - goal
    out[..., 2] = (out[..., 2] + np.pi) % (2 * np.pi) - np.pi
    return out
