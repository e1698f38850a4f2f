"""The limit cycles of many gaits at once.

Each gait is solved from a neighbour's orbit, if there is one, or from rest by maps of fewer steps
first: see `momentum.cycle_search`. What is not found so, or does not hold, is tried again from
rest, and then from what the impulsive start comes to in `SETTLING` periods. What a gait gives does
not depend on the others beside it, to the last bit.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.drive.gaits.batch import GaitBatch
from rrrobot.momentum.batch import LOADS, RESULT, Setting
from rrrobot.momentum.charts import Chart
from rrrobot.momentum.cycle_look import NO_ORBIT
from rrrobot.momentum.cycle_search import Found, search
from rrrobot.momentum.extremes import LOADS as ALL_LOADS
from rrrobot.momentum.extremes import extremes
from rrrobot.momentum.heights import clearance
from rrrobot.momentum.kernels import DECOUPLED, LIFT_OFF, NOT_FINITE, OK, TURNS_OVER
from rrrobot.momentum.vertical import largest_tilt, pitch_of
from rrrobot.orbits.section import level_section_of
from rrrobot.rotations import turns_over

UNSTABLE = 6
"""A further reason why a gait has no steady state: its orbit does not hold."""
SETTLING = 30
"""Periods of the last try."""
_MOST, _MOST_AGAIN = 12, 45
"""Broyden's steps of the other tries, and of the last."""
_SLOWEST = 1.0 - 1e-6
"""Largest |multiplier| that counts as stable; differences of the map are good to 1e-7."""
_SURE, _SURE_PERIODS = 0.9, 7
"""Largest |multiplier| by Broyden's steps that leaves no doubt, and most periods in which they came
to the orbit: so quick, they begin at differences so near to it that of 6000 gaits, many wild and
little damped, no multiplier was off by more than 0.08, from rest or from a neighbour's orbit."""
_STATUS, _VARIATION = RESULT.index("status"), RESULT.index("variation")
_YAW_RATE = RESULT.index("yaw_rate")
_PITCH, _CLEARANCE = RESULT.index("pitch"), RESULT.index("clearance")
_TILT = RESULT.index("tilt")
__all__ = ["NO_ORBIT", "UNSTABLE", "Orbits", "orbit_states", "orbits_of"]


class Orbits(NamedTuple):
    """Limit cycles of n gaits."""

    results: Array
    """(n, columns) as `RESULT`, then the loads that were asked for; of an orbit that lifts off or
    does not hold the numbers stand, of others whose status is not OK all but the residual are
    NaN"""
    point: Array
    """coordinates of the orbits' starts (n, size)"""
    slope: Array
    """derivative of the return map there (n, size, size): to 1e-7, or what Broyden's steps know of
    it where the multiplier is not exact"""
    periods: Array
    """simulated for each gait, those of fewer steps in part, those for multipliers too (n,)"""
    motion: Array
    """z_body and angular velocity at the steps of the cycle, as `Settled.motion`"""

    @property
    def multiplier(self) -> Array:
        """Largest |Floquet multiplier| (n,); NaN if it was not asked for or there is no orbit; see
        `stability`."""
        orbit = np.isfinite(self.results[:, _YAW_RATE])
        return np.where(orbit, _largest(self.slope), np.nan)


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
    found = orbits_of(setting, gaits, steps_per_cycle, yaw=yaw, loads=loads, stability="known")
    out = found.results
    for status, kept in ((LIFT_OFF, (_STATUS,)), (UNSTABLE, (_STATUS, _VARIATION))):
        rows = np.flatnonzero(out[:, _STATUS] == status)
        out[np.ix_(rows, ~np.isin(np.arange(out.shape[1]), kept))] = np.nan
    return out


def orbits_of(
    setting: Setting,
    gaits: GaitBatch,
    steps: int,
    *,
    yaw: GaitBatch | None = None,
    loads: bool = False,
    stability: str = "exact",
    near: Orbits | None = None,
) -> Orbits:
    """Limit cycles of n gaits of any harmonics, of the legs' period.

    Args:
        setting: the model, with damping.
        gaits: one row a gait.
        steps: in a period.
        yaw: gaits of the yaw model alone, if decoupled.
        loads: whether to have torques and friction too.
        stability: "exact": find the multipliers, and give UNSTABLE to what does not hold; "known":
            do so where Broyden's steps leave a doubt, and take theirs else, which are good to a few
            hundredths; "none".
        near: a neighbour's orbit, of one gait, from which all start.

    Raises:
        ModelError: nothing brakes the model, or the ground is not level.
    """
    section = level_section_of(setting, "swept")
    chart = Chart(
        np.array(section.angles, dtype=np.int64), np.array(section.momenta, dtype=np.int64),
        section.tilted, section.level,
    )  # fmt: skip
    steps *= setting.fineness
    moves = setting.axis != DECOUPLED
    n = gaits.n
    start = None
    if near is not None and near.results[0, _STATUS] in (OK, LIFT_OFF, UNSTABLE):
        start = np.repeat(near.point, n, axis=0), np.repeat(near.slope, n, axis=0)

    def closed(rows: NDArray[np.int64], way: str, begin: Any, slopes: bool) -> Found:
        settled = way == "settled"
        return search(
            setting, chart, gaits.rows(rows), steps, yaw=None if yaw is None else yaw.rows(rows),
            start=begin, settling=SETTLING * settled, most=_MOST_AGAIN if settled else _MOST,
            slopes=slopes,
        )  # fmt: skip

    def searched(rows: NDArray[np.int64], way: str) -> Found:
        begin = None if start is None or way != "near" else tuple(x[rows] for x in start)
        found = closed(rows, way, begin, stability == "exact")
        status, periods, slope = found.results[:, _STATUS], found.periods, found.slope
        orbit = (status != NO_ORBIT) & np.isfinite(found.results[:, 0])
        quick = periods <= _SURE_PERIODS
        periods += found.before
        if stability == "exact":
            periods += found.point.shape[1]
        elif stability == "none":
            slope[:] = np.nan
        else:
            doubtful = np.flatnonzero(orbit & ~(quick & _below(slope, _SURE)))
            if doubtful.size:
                there = found.point[doubtful], slope[doubtful]
                more = closed(rows[doubtful], "near", there, True)
                slope[doubtful] = more.slope
                periods[doubtful] += more.periods + found.point.shape[1]
        if stability != "none":
            status[orbit & ~_below(slope, _SLOWEST)] = UNSTABLE
        if moves:
            turn = found.results[:, _YAW_RATE] * 2 * np.pi / gaits.angular_frequency[rows]
            goes_on = np.isin(status, (OK, LIFT_OFF, UNSTABLE))
            status[goes_on & turns_over(found.motion[:, :, :3], turn)] = TURNS_OVER
        return found

    ways = ["near"] * (start is not None) + ["rest", "settled"]
    found = searched(np.arange(n), ways[0])
    for way in ways[1:]:
        again = np.flatnonzero(np.isin(found.results[:, _STATUS], (UNSTABLE, NO_ORBIT, NOT_FINITE)))
        if not again.size:
            break
        spent = found.periods[again]
        more = searched(again, way)
        more.periods[:] += spent
        found.periods[again] = more.periods
        # One that was found and does not hold says more than none.
        better = found.results[again, _STATUS] != UNSTABLE
        better |= np.isin(more.results[:, _STATUS], (OK, LIFT_OFF))
        for name in ("results", "point", "slope", "motion"):
            getattr(found, name)[again[better]] = getattr(more, name)[better]
    results = found.results
    results[:, _PITCH] = pitch_of(results[:, _PITCH])
    results[:, _CLEARANCE] = clearance(setting, gaits, np.nan_to_num(found.motion))
    if moves:
        results[:, _TILT] = largest_tilt(found.motion, periodic=setting.periodic)
    failed = np.flatnonzero(~np.isin(results[:, _STATUS], (OK, LIFT_OFF, UNSTABLE)))
    kept = np.isin(np.arange(results.shape[1]), (_STATUS, _VARIATION))
    results[np.ix_(failed, ~kept)] = np.nan
    if loads:
        results = np.column_stack((results, _loads(setting, gaits, found.motion, failed)))
    return Orbits(results, found.point, found.slope, found.periods, found.motion)


def _largest(slope: Array) -> Array:
    """Largest |multiplier| of each orbit (n,) by dP/dx (n, size, size); NaN where there is none."""
    out = np.full(len(slope), np.nan)
    usable = np.all(np.isfinite(slope), axis=(1, 2))
    out[usable] = np.abs(np.linalg.eigvals(slope[usable])).max(axis=1, initial=0.0)
    return out


def _below(slope: Array, limit: float) -> NDArray[np.bool_]:
    """Whether all multipliers are at most a limit (n,): by |M^16| where that will do."""
    power = slope
    # Of what grows fast the powers may overflow: it is not below.
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(4):
            power = power @ power
        found = np.asarray((power**2).sum(axis=(1, 2)) <= limit**32)
    rest = np.flatnonzero(~found)
    found[rest] = _largest(slope[rest]) <= limit
    return found


def _loads(setting: Setting, gaits: GaitBatch, motion: Array, failed: NDArray[np.int64]) -> Array:
    if setting.axis == DECOUPLED:
        return np.full((gaits.n, len(LOADS)), np.nan)
    chosen = [ALL_LOADS.index(name) for name in LOADS]
    out = extremes(setting, gaits, np.ascontiguousarray(np.nan_to_num(motion)))[:, chosen]
    out[failed] = np.nan
    return np.asarray(out)
