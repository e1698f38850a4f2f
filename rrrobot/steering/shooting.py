"""Schedules simulated exactly, many side by side, and their lengths corrected until they arrive."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.schedule import Schedule
from rrrobot.models.base import Model
from rrrobot.models.recombined import DecoupledModels
from rrrobot.rotations import quaternion_from_euler
from rrrobot.steering.standing import Rest

if TYPE_CHECKING:
    from rrrobot.momentum.blends import Blends
    from rrrobot.momentum.lowering import Setting

STEPS_PER_CYCLE = 12


class Apart(NamedTuple):
    """The single-axis models side by side, as a simpler model that plans are made on."""

    models: DecoupledModels
    offset: Array
    """rising (n,) [rad]"""
    ratio: Array
    """of the yaw model's leg amplitude to the gait's, at these offsets (n,)"""

    def of_yaw(self, schedule: Schedule) -> Schedule:
        """The yaw model's own legs in a schedule."""
        parts = []
        for s in schedule.stretches:
            ratio = float(np.interp(s.offset.mean(), self.offset, self.ratio))
            parts.append(s._replace(sine=ratio * s.sine, cosine=ratio * s.cosine))
        return Schedule(
            parts, angular_frequency=schedule.angular_frequency, rest=schedule.rest,
            blend=schedule.blend,
        )  # fmt: skip


def final_poses(
    model: Model | Apart, schedules: Sequence[Schedule], start: Array, rest: Rest, *, tail: float
) -> Array:
    """Resting poses (x, y, yaw) after schedules from rest (n, 3) [m, m, rad]; NaN where one fails.

    Args:
        model: that the momentum engine knows, or single-axis models.
        schedules: all of one frequency and one blend.
        start: pose at rest (x, y, yaw) (3,).
        rest: how it stands there.
        tail: time after the longest schedule [s].
    """
    from rrrobot.momentum.blends import final_states
    from rrrobot.momentum.lowering import decoupled_setting, lower

    yaw = None
    if isinstance(model, Apart):
        parts = model.models
        setting = decoupled_setting(parts.robot, *parts.models)  # type: ignore[arg-type]
        yaw = joined_legs([model.of_yaw(s) for s in schedules])
        lane = np.concatenate((rest.euler[:2], np.zeros(5), start))
    else:
        setting = lower(model)
        lane = np.concatenate((quaternion_from_euler(rest.euler), np.zeros(3), start))
    with np.errstate(all="ignore"):
        end = final_states(
            setting, joined_legs(schedules), lane, yaw=yaw, steps_per_cycle=STEPS_PER_CYCLE,
            duration=max(s.duration for s in schedules) + tail,
        )  # fmt: skip
    return end[:, 7:10]


def joined_legs(schedules: Sequence[Schedule]) -> Blends:
    """Schedules of one frequency and one blend as the engine takes them."""
    from rrrobot.momentum.blends import Blends

    first = schedules[0]
    parts = max(s.levels.shape[0] for s in schedules)
    rows = max(s.levels.shape[1] for s in schedules)
    harmonics = (rows - 1) // 2
    levels = np.zeros((len(schedules), parts, rows, first.n_legs))
    begins = np.full((len(schedules), parts - 1), np.inf)
    for i, s in enumerate(schedules):
        n, own = len(s.levels), (s.levels.shape[1] - 1) // 2
        levels[i, :n, 0] = s.levels[:, 0]
        levels[i, :n, 1 : 1 + own] = s.levels[:, 1 : 1 + own]
        levels[i, :n, 1 + harmonics : 1 + harmonics + own] = s.levels[:, 1 + own :]
        levels[i, n:, 0] = s.rest
        begins[i, : n - 1] = s.begins
    return Blends(levels, begins, first.blend, first.angular_frequency)


def table_of(setting: Setting, leg_angle: Array, leg_rate: Array) -> Array:
    """How the legs enter, at many instants (n, 15), about the point that the engine's form takes.

    Args:
        setting: of a model.
        leg_angle, leg_rate: (n, legs) [rad, rad/s].
    """
    from rrrobot.momentum.coefficients import N_COEFFICIENTS, fill

    out = np.empty((len(leg_angle), N_COEFFICIENTS))
    fill(setting.tree, np.ascontiguousarray(leg_angle), np.ascontiguousarray(leg_rate), out)
    return out


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
    model: Model | Apart,
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
        model: as for `final_poses`.
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
