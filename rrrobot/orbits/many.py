"""The limit cycles of many gaits at once.

Each gait is solved from rest, by maps of fewer steps first: see `momentum.cycle_search`. What is
not found so, or does not hold, is tried again from what the impulsive start comes to in `SETTLING`
periods. What a gait gives does not depend on the others beside it, to the last bit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.drive.gaits.batch import GaitBatch
from rrrobot.momentum.batch import LOADS, RESULT, Setting
from rrrobot.momentum.cycle_look import NO_ORBIT
from rrrobot.momentum.cycle_search import Found, search
from rrrobot.momentum.extremes import LOADS as ALL_LOADS
from rrrobot.momentum.extremes import extremes
from rrrobot.momentum.heights import clearance
from rrrobot.momentum.kernels import DECOUPLED, LIFT_OFF, NOT_FINITE, OK, TURNS_OVER
from rrrobot.momentum.newton import Chart
from rrrobot.momentum.vertical import pitch_of
from rrrobot.orbits.section import section_of
from rrrobot.rotations import turns_over

UNSTABLE = 6
"""A further reason why a gait has no steady state: its orbit does not hold."""
SETTLING = 30
"""Periods of the second try."""
_MOST, _MOST_AGAIN = 12, 45
"""Broyden's steps of the two tries."""
_SLOWEST = 1.0 - 1e-6
"""Largest |multiplier| that counts as stable; differences of the map are good to 1e-7."""
_STATUS, _VARIATION = RESULT.index("status"), RESULT.index("variation")
_YAW_RATE = RESULT.index("yaw_rate")
_PITCH, _CLEARANCE = RESULT.index("pitch"), RESULT.index("clearance")
__all__ = ["NO_ORBIT", "UNSTABLE", "Orbits", "orbit_states", "orbits_of"]


class Orbits(NamedTuple):
    """Limit cycles of n gaits."""

    results: Array
    """(n, columns) as `RESULT`, then the loads that were asked for; of an orbit that lifts off the
    numbers stand, of others whose status is not OK all but the residual are NaN"""
    multiplier: Array
    """largest |Floquet multiplier| (n,); NaN if it was not asked for or there is no orbit"""
    point: Array
    """coordinates of the orbits' starts (n, size)"""
    slope: Array
    """derivative of the return map there (n, size, size); NaN without `stability`"""
    periods: Array
    """simulated for each gait's search, those of fewer steps in part, without multipliers (n,)"""
    motion: Array
    """z_body and angular velocity at the steps of the cycle, as `Settled.motion`"""


def orbit_states(
    setting: Setting,
    gaits: GaitBatch,
    *,
    steps_per_cycle: int,
    yaw: GaitBatch | None = None,
    loads: bool = False,
) -> Array:
    """Steady states of many gaits by their limit cycles (n, columns), as `steady_states` has them.

    `variation` is the residual of the orbit. Status UNSTABLE: the orbit of one period that was
    found does not hold, so that the gait settles to something else, or never; NO_ORBIT: none was
    found.
    """
    out = orbits_of(setting, gaits, steps_per_cycle, yaw=yaw, loads=loads).results
    jumping = np.flatnonzero(out[:, _STATUS] == LIFT_OFF)
    out[np.ix_(jumping, np.arange(out.shape[1]) != _STATUS)] = np.nan
    return out


def orbits_of(
    setting: Setting,
    gaits: GaitBatch,
    steps: int,
    *,
    yaw: GaitBatch | None = None,
    loads: bool = False,
    stability: bool = True,
    near: Orbits | None = None,
) -> Orbits:
    """Limit cycles of n gaits of any harmonics, of the legs' period.

    Args:
        setting: the model, with damping.
        gaits: one row a gait.
        steps: in a period.
        yaw: gaits of the yaw model alone, if decoupled.
        loads: whether to have torques and friction too.
        stability: whether to find the multipliers, and to give UNSTABLE to what does not hold.
        near: a neighbour's orbit, of one gait, from which all start; found with `stability`.

    Raises:
        ModelError: nothing brakes the model, or the ground is not level.
    """
    section = section_of(setting, "swept")
    chart = Chart(
        np.array(section.angles, dtype=np.int64), np.array(section.momenta, dtype=np.int64),
        section.tilted, section.level,
    )  # fmt: skip
    steps *= setting.fineness
    moves = setting.axis != DECOUPLED
    n = gaits.n
    start = None
    if near is not None and near.results[0, _STATUS] in (OK, LIFT_OFF):
        start = np.repeat(near.point, n, axis=0), np.repeat(near.slope, n, axis=0)

    def searched(some: GaitBatch, own: GaitBatch | None, again: bool) -> tuple[Found, Array]:
        found = search(
            setting, chart, some, steps, yaw=own, start=None if again else start,
            settling=SETTLING * again, most=_MOST_AGAIN if again else _MOST, slopes=stability,
        )  # fmt: skip
        largest = _largest(found) if stability else np.full(len(found.point), np.nan)
        if stability:
            weak = (found.results[:, _STATUS] != NO_ORBIT) & ~(largest <= _SLOWEST)
            found.results[weak & np.isfinite(found.results[:, 0]), _STATUS] = UNSTABLE
        if moves:
            status = found.results[:, _STATUS]
            turn = found.results[:, _YAW_RATE] * 2 * np.pi / some.angular_frequency
            goes_on = np.isin(status, (OK, LIFT_OFF, UNSTABLE))
            status[goes_on & turns_over(found.motion[:, :, :3], turn)] = TURNS_OVER
        return found, largest

    found, largest = searched(gaits, yaw, False)
    again = np.flatnonzero(np.isin(found.results[:, _STATUS], (UNSTABLE, NO_ORBIT, NOT_FINITE)))
    if again.size:
        spent = found.periods[again]
        more, size = searched(gaits.rows(again), None if yaw is None else yaw.rows(again), True)
        more.periods[:] += spent
        found.periods[again] = more.periods
        # One that was found and does not hold says more than none.
        better = found.results[again, _STATUS] != UNSTABLE
        better |= np.isin(more.results[:, _STATUS], (OK, LIFT_OFF))
        for whole, part in zip((*found, largest), (*more, size), strict=True):
            if len(whole):
                whole[again[better]] = part[better]
    results = found.results
    results[:, _PITCH] = pitch_of(results[:, _PITCH])
    results[:, _CLEARANCE] = clearance(setting, gaits, np.nan_to_num(found.motion))
    failed = np.flatnonzero(~np.isin(results[:, _STATUS], (OK, LIFT_OFF)))
    kept = np.isin(np.arange(results.shape[1]), (_STATUS, _VARIATION))
    results[np.ix_(failed, ~kept)] = np.nan
    if loads:
        results = np.column_stack((results, _loads(setting, gaits, found.motion, failed)))
    return Orbits(results, largest, found.point, found.slope, found.periods, found.motion)


def _largest(found: Found) -> Array:
    """Largest |multiplier| of each orbit (n,), NaN where there is none."""
    out = np.full(len(found.point), np.nan)
    usable = np.isfinite(found.results[:, 0]) & np.all(np.isfinite(found.slope), axis=(1, 2))
    values = np.linalg.eigvals(found.slope[usable])
    out[usable] = np.abs(values).max(axis=1, initial=0.0)
    return out


def _loads(setting: Setting, gaits: GaitBatch, motion: Array, failed: NDArray[np.int64]) -> Array:
    if setting.axis == DECOUPLED:
        return np.full((gaits.n, len(LOADS)), np.nan)
    chosen = [ALL_LOADS.index(name) for name in LOADS]
    out = extremes(setting, gaits, np.ascontiguousarray(np.nan_to_num(motion)))[:, chosen]
    out[failed] = np.nan
    return np.asarray(out)
