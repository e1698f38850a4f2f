"""The limit cycles of many gaits at once, each from its neighbours'.

A few gaits are solved from rest. The others follow in stages from what an interpolation of the
solved ones foretells, orbit and derivative of the return map, so that most need three or four
periods of simulation. What is not found so, or is found unstable, is tried again from what the
impulsive start comes to.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.momentum.batch import LOADS, RESULT, FourierGaits, Gaits, Setting, fourier
from rrrobot.momentum.extremes import LOADS as ALL_LOADS
from rrrobot.momentum.extremes import extremes
from rrrobot.momentum.kernels import DECOUPLED, LIFT_OFF, NOT_FINITE, OK, TURNS_OVER, VERTICAL
from rrrobot.momentum.returns import carry, cycles_of
from rrrobot.orbits.measures import look, measures
from rrrobot.orbits.newton import (
    TOLERANCE,
    ReturnMap,
    Roots,
    iterate,
    return_map,
    rough_derivative,
)
from rrrobot.orbits.section import Section, section_of

UNSTABLE, NO_ORBIT = 6, 7
"""Further reasons why a gait has no steady state: its orbit does not hold; none was found."""
_FIRST = 48
"""Gaits that are solved from rest, at least, and the part of all that is:"""
_FIRST_PART = 1 / 24
_STAGE = 4
"""By how much the number of solved gaits grows in a stage."""
_KNOWN = 320
"""Most solutions that an interpolation takes."""
_SETTLING = 30
"""Periods of the second try."""
_CHUNK = 2048
_SLOWEST = 1.0 - 1e-6
"""Largest |multiplier| that counts as stable; differences of the map are good to 1e-7."""
_RESULTS = len(RESULT)


class Orbits(NamedTuple):
    """Limit cycles of n gaits."""

    results: Array
    """(n, columns) as `RESULT`, then the loads that were asked for; NaN unless the status is OK"""
    multiplier: Array
    """largest |Floquet multiplier| (n,); NaN if it was not asked for or there is no orbit"""
    point: Array
    """coordinates of the orbits' starts (n, size)"""
    periods: NDArray[np.int64]
    """simulated for each gait's search, without multipliers (n,)"""


class _Solved(NamedTuple):
    point: Array
    slope: Array
    """dP/dx (n, size, size)"""
    inverse: Array
    found: NDArray[np.bool_]
    periods: NDArray[np.int64]


def orbit_states(
    setting: Setting,
    gaits: Gaits,
    *,
    steps_per_cycle: int,
    yaw_amplitude: Array | None = None,
    loads: bool = False,
) -> Array:
    """Steady states of many gaits by their limit cycles (n, columns), as `steady_states` has them.

    `variation` is the residual of the orbit. Status UNSTABLE: the orbit of one period that was
    found does not hold, so that the gait settles to something else, or never; NO_ORBIT: none was
    found.
    """
    yaw = None if yaw_amplitude is None else fourier(gaits._replace(amplitude=yaw_amplitude))
    return orbits_of(setting, fourier(gaits), steps_per_cycle, yaw=yaw, loads=loads).results


def orbits_of(
    setting: Setting,
    gaits: FourierGaits,
    steps: int,
    *,
    yaw: FourierGaits | None = None,
    loads: bool = False,
    stability: bool = True,
) -> Orbits:
    """Limit cycles of n gaits of any harmonics, of the legs' period.

    Args:
        setting: the model, with damping.
        gaits: one row a gait.
        steps: in a period.
        yaw: gaits of the yaw model alone, if decoupled.
        loads: whether to have torques and friction too.
        stability: whether to find the multipliers, and to give UNSTABLE to what does not hold.

    Raises:
        ModelError: nothing brakes the model.
    """
    section = section_of(setting, "swept")
    steps *= setting.fineness
    parts = [
        _chunk(setting, section, _some(gaits, here), steps, _some(yaw, here), loads, stability)
        for here in np.array_split(
            np.arange(len(gaits.offset)), max(1, -(-len(gaits.offset) // _CHUNK))
        )
    ]
    return Orbits(*(np.concatenate([part[k] for part in parts]) for k in range(4)))


def _some(gaits: FourierGaits | None, here: NDArray[np.int64]) -> FourierGaits | None:
    return None if gaits is None else FourierGaits(*(part[here] for part in gaits))


def _chunk(
    setting: Setting,
    section: Section,
    gaits: FourierGaits | None,
    steps: int,
    yaw: FourierGaits | None,
    loads: bool,
    stability: bool,
) -> Orbits:
    assert gaits is not None
    n, d = len(gaits.offset), section.size
    points = _features(gaits, yaw)
    order = np.random.default_rng(0).permutation(n)
    out = Orbits(
        np.full((n, _RESULTS + len(LOADS) * loads), np.nan), np.full(n, np.nan),
        np.full((n, d), np.nan), np.zeros(n, dtype=np.int64),
    )  # fmt: skip
    near: Array | None
    inverse, good = np.zeros((n, d, d)), np.zeros(n, dtype=bool)
    done, size = 0, min(n, max(_FIRST, int(n * _FIRST_PART)))
    with np.errstate(all="ignore"):
        while done < n:
            here = np.sort(order[done : done + size])
            solved = order[:done][good[order[:done]]]
            some, own = _some(gaits, here), _some(yaw, here)
            P = return_map(cycles_of(setting, some, steps, own), section)  # type: ignore[arg-type]
            if solved.size > points.shape[1] + 1:
                solved = solved[:: -(-solved.size // _KNOWN)]
                values = np.concatenate((out.point[solved, None], inverse[solved]), axis=1)
                foretold = _guess(points[solved], points[here], values)
                start, near = foretold[:, 0], foretold[:, 1:]
            else:
                start, near = np.zeros((here.size, d)), None
            roots = iterate(P, start, near, trusting=True)
            found = _described(P, roots, some, loads, stability, out, here)
            inverse[here], good[here] = found.inverse, found.found
            done, size = done + len(here), (_STAGE - 1) * (done + len(here))
        again = np.flatnonzero(~good)
        if again.size:
            some, own = _some(gaits, again), _some(yaw, again)
            P = return_map(cycles_of(setting, some, steps, own), section)  # type: ignore[arg-type]
            settled = carry(P.cycles, section.state(np.zeros((again.size, d)), P.scale), _SETTLING)
            roots = iterate(P, section.point(settled, P.scale), limit=45)
            roots = roots._replace(iterations=roots.iterations + _SETTLING)
            spent = out.periods[again]
            _described(P, roots, some, loads, stability, out, again)
            out.periods[again] += spent
    return out


def _features(gaits: FourierGaits, yaw: FourierGaits | None) -> Array:
    """What tells the gaits apart, each column from 0 to 1 (n, m)."""
    parts = [*gaits, *(yaw[1:3] if yaw is not None else ())]
    flat = np.column_stack([part.reshape(len(part), -1) for part in parts])
    span = np.ptp(flat, axis=0)
    varying = span > 1e-12 * (1.0 + np.abs(flat).max(axis=0, initial=0.0))
    return np.asarray((flat[:, varying] - flat[:, varying].min(axis=0)) / span[varying])


def _guess(known: Array, wanted: Array, values: Array) -> Array:
    """Values (k, ...) at known places (k, m), carried to wanted ones (n, ...) by radial functions.

    A sum of |x - x_i|^3 and a plane through the known values.
    """
    from scipy.spatial.distance import cdist

    k, m = known.shape
    flat = values.reshape(k, -1)
    corner = np.column_stack((np.ones(k), known))
    system = np.zeros((k + m + 1, k + m + 1))
    system[:k, :k] = cdist(known, known) ** 3
    system[:k, k:], system[k:, :k] = corner, corner.T
    # Places may lie in a plane, or coincide.
    system[np.arange(k + m + 1), np.arange(k + m + 1)] += 1e-11
    right = np.concatenate((flat, np.zeros((m + 1, flat.shape[1]))))
    weights = np.linalg.solve(system, right)
    found = cdist(wanted, known) ** 3 @ weights[:k]
    found += np.column_stack((np.ones(len(wanted)), wanted)) @ weights[k:]
    return np.asarray(found.reshape(len(wanted), *values.shape[1:]))


def _described(
    P: ReturnMap,
    roots: Roots,
    gaits: FourierGaits | None,
    loads: bool,
    stability: bool,
    out: Orbits,
    here: NDArray[np.int64],
) -> _Solved:
    """Write what gaits come to into out[here]."""
    setting, x, d = P.cycles.setting, roots.point, P.section.size
    sight = look(P.cycles, P.section.state(x, P.scale))
    residual = _residual(P, sight.end, x)
    unproven = (roots.residual <= TOLERANCE) & ~(residual <= TOLERANCE)
    if unproven.any():
        more = iterate(P, x, roots.inverse, wanted=unproven)
        x = np.where(unproven[:, None], more.point, x)
        roots = roots._replace(iterations=roots.iterations + more.iterations)
        sight = look(P.cycles, P.section.state(x, P.scale))
        residual = _residual(P, sight.end, x)
    roots = Roots(x, residual, roots.inverse, roots.iterations + 1)
    found = roots.found
    m = measures(P.cycles, sight)
    slope, inverse = np.zeros((len(x), d, d)), roots.inverse
    largest = np.full(len(x), np.nan)
    if stability:
        slope = rough_derivative(P, x, P.section.point(sight.end, P.scale), found)
        usable = found & np.all(np.isfinite(slope), axis=(1, 2))
        largest[usable] = np.abs(np.linalg.eigvals(slope[usable])).max(axis=1, initial=0.0)
        if d:
            gap = slope[usable] - np.eye(d)
            regular = np.abs(np.linalg.det(gap)) > 1e-9
            inverse[np.flatnonzero(usable)[regular]] = np.linalg.inv(gap[regular])
    status = np.full(len(x), OK)
    rolls = setting.axis != DECOUPLED and setting.parameters[1] > 0.0
    if rolls:
        status[m.normal_force <= 0.0] = LIFT_OFF
    if stability:
        status[~(largest <= _SLOWEST)] = UNSTABLE
    status[m.pitch > setting.limit] = VERTICAL
    status[m.tumbles] = TURNS_OVER
    status[~found] = np.where(np.isfinite(roots.residual[~found]), NO_ORBIT, NOT_FINITE)
    columns = np.column_stack(
        (m.speed, m.velocity, m.yaw_rate, m.amplitude, m.phase, m.mean, roots.residual,
         m.normal_force, status)
    )  # fmt: skip
    if loads:
        columns = np.column_stack((columns, _loads(setting, gaits, sight.motion)))
    failed = np.flatnonzero(status != OK)
    columns[np.ix_(failed, np.arange(columns.shape[1]) != _RESULTS - 1)] = np.nan
    out.results[here], out.multiplier[here] = columns, largest
    out.point[here], out.periods[here] = x, roots.iterations
    return _Solved(x, slope, inverse, found & (status != UNSTABLE), roots.iterations)


def _residual(P: ReturnMap, end: Array, x: Array) -> Array:
    residual = np.abs(P.section.point(end, P.scale) - x).max(axis=1, initial=0.0)
    return np.asarray(np.where(np.isfinite(residual), residual, np.inf))


def _loads(setting: Setting, gaits: FourierGaits | None, motion: Array) -> Array:
    if setting.axis == DECOUPLED or gaits is None:
        return np.full((len(motion), len(LOADS)), np.nan)
    chosen = [ALL_LOADS.index(name) for name in LOADS]
    motion = np.ascontiguousarray(np.nan_to_num(motion))
    whole = FourierGaits(*(np.ascontiguousarray(part) for part in gaits))
    return extremes(setting, whole, motion)[:, chosen]
