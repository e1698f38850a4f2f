"""Newton and Broyden steps on the return maps of a block of gaits side by side, in Numba.

With P the map of coordinates x of a state to those one period of the legs later, an orbit is a root
of F(x) = P(x) - x. Each lane keeps an approximate inverse H of dF/dx, at first from differences of
the map, then by Broyden's updates, so that a step costs one period of simulation:

    dx = -H F,      H += (dx - H dF) (dx^T H) / (dx^T H dF)

Nothing in a lane depends on the others; a block goes on until the last of its lanes is done.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import inner
from rrrobot.momentum.kernels import BLOCK, ROWS_PER_STEP, TILT, step

TOLERANCE = 1e-12
"""Largest residual of an orbit in scaled units."""
FORWARD = 1e-7
"""Step of forward differences in scaled units."""
LARGEST_STEP = 0.7
"""In scaled units: about 40 degrees."""
GROWTH = 3.0
"""By how much a step may make the residual grow before it is halved."""
HALVINGS = 6
_K = 4


class Chart(NamedTuple):
    """What must come back after a period; see `rrrobot.orbits.section`."""

    angles: NDArray[np.int64]
    """entries of (roll, pitch)' that are free"""
    momenta: NDArray[np.int64]
    """entries of K that are free"""
    tilted: bool
    """whether the state is a quaternion; else it is the angles themselves"""
    level: bool
    """whether the momentum about the vertical is held at zero"""


class Search(NamedTuple):
    """Room for the iterations of LANES lanes; d is the number of coordinates."""

    x: Array
    """(d, LANES)"""
    trial: Array
    F: Array
    new: Array
    dx: Array
    image: Array
    inverse: Array
    """H, (d, d, LANES)"""
    slope: Array
    """dP/dx, (d, d, LANES)"""
    size: Array
    """largest entry of |F| (LANES,)"""
    scale: Array
    """of K (LANES,)"""
    todo: NDArray[np.bool_]
    halved: NDArray[np.int64]
    spent: Array
    """periods that each lane took, those of fewer steps in part (LANES,)"""
    row: Array
    """scratch (d, 2 d)"""


def search_room(d: int) -> Search:
    """Room for d coordinates."""
    x, trial, F, new, dx, image = np.zeros((6, d, LANES))
    inverse, slope = np.zeros((2, d, d, LANES))
    todo, halved = np.zeros(LANES, dtype=np.bool_), np.zeros(LANES, dtype=np.int64)
    size, scale, spent = np.zeros(LANES), np.ones(LANES), np.zeros(LANES)
    return Search(
        x, trial, F, new, dx, image, inverse, slope, size, scale, todo, halved, spent,
        np.zeros((d, 2 * d)),
    )  # fmt: skip


@inner
def put(chart, x, scale, y, ahead):  # type: ignore[no-untyped-def]
    """States y of coordinates x, at the origin; with yaw zero if `ahead`, else with any."""
    n = len(chart.angles)
    for e in range(BLOCK):
        y[e] = 0.0
    for i in range(LANES):
        roll, pitch = 0.0, 0.0
        for k in range(n):
            if chart.angles[k] == 0:
                roll = x[k, i]
            else:
                pitch = x[k, i]
        for k in range(len(chart.momenta)):
            y[(_K + chart.momenta[k]) * LANES + i] = x[n + k, i] * scale[i]
        if not chart.tilted:
            y[i], y[LANES + i] = roll, pitch
            continue
        a, b = 0.5 * roll, 0.5 * pitch
        # (a, b, 0, 1) has the tilt; a turn about the vertical takes its yaw away.
        s, c = 0.0, 1.0
        if ahead:
            half = -0.5 * np.arctan2(2.0 * a * b, 1.0 + a * a - b * b)
            s, c = np.sin(half), np.cos(half)
        y[i], y[LANES + i] = c * a - s * b, c * b + s * a
        y[2 * LANES + i], y[3 * LANES + i] = s, c
        if chart.level:
            # K . z = 0, with z in the ratio (-2b, 2a, 1 - a^2 - b^2).
            along = 2.0 * (b * y[_K * LANES + i] - a * y[(_K + 1) * LANES + i])
            y[(_K + 2) * LANES + i] = along / (1.0 - a * a - b * b)


@inner
def take(chart, y, scale, x):  # type: ignore[no-untyped-def]
    """Coordinates x of states y."""
    n = len(chart.angles)
    for i in range(LANES):
        roll, pitch = y[i], y[LANES + i]
        if chart.tilted:
            a, b, z, w = roll, pitch, y[2 * LANES + i], y[3 * LANES + i]
            over = 2.0 / (z * z + w * w)
            roll, pitch = over * (b * z + w * a), over * (w * b - a * z)
        for k in range(n):
            x[k, i] = roll if chart.angles[k] == 0 else pitch
        for k in range(len(chart.momenta)):
            x[n + k, i] = y[(_K + chart.momenta[k]) * LANES + i] / scale[i]


@inner
def image(chart, x, table, h, axis, terrain, work, out):  # type: ignore[no-untyped-def]
    """P(x) of every lane by a table's steps, h (BLOCK,) long."""
    y = work.state[0]
    put(chart, x, work.search.scale, y, False)
    for at in range(0, len(table) - 1, ROWS_PER_STEP):
        step(y, table, at, h, work.parameters, axis, work.slopes, work.state[2], work.state[3],
             work.areas, terrain, work.rolling, TILT)  # fmt: skip
    take(chart, y, work.search.scale, out)


@inner
def differentiate(chart, x, base, table, h, axis, terrain, work):  # type: ignore[no-untyped-def]
    """dP/dx of every lane by forward differences from P(x) = base."""
    s = work.search
    d = len(x)
    for j in range(d):
        for k in range(d):
            for i in range(LANES):
                s.trial[k, i] = x[k, i]
        for i in range(LANES):
            s.trial[j, i] += FORWARD
        image(chart, s.trial, table, h, axis, terrain, work, s.image)
        for k in range(d):
            for i in range(LANES):
                s.slope[k, j, i] = (s.image[k, i] - base[k, i]) / FORWARD


@inner
def invert(s, i):  # type: ignore[no-untyped-def]
    """H of lane i from dP/dx; zero, so that steps are none, where there is no inverse."""
    d, m = len(s.x), s.row
    for a in range(d):
        for b in range(d):
            m[a, b] = s.slope[a, b, i] - (1.0 if a == b else 0.0)
            m[a, d + b] = 1.0 if a == b else 0.0
    good = True
    for c in range(d):
        best = c
        for a in range(c + 1, d):
            if abs(m[a, c]) > abs(m[best, c]):
                best = a
        pivot = m[best, c]
        if not abs(pivot) > 1e-12:
            good = False
            break
        for b in range(2 * d):
            m[best, b], m[c, b] = m[c, b], m[best, b] / pivot
        for a in range(d):
            if a != c:
                factor = m[a, c]
                for b in range(2 * d):
                    m[a, b] -= factor * m[c, b]
    for a in range(d):
        for b in range(d):
            s.inverse[a, b, i] = m[a, d + b] if good else 0.0


@inner
def aim(s, i):  # type: ignore[no-untyped-def]
    """dx = -H F of lane i, no longer than LARGEST_STEP; its largest entry."""
    d, long = len(s.x), 0.0
    for a in range(d):
        total = 0.0
        for b in range(d):
            total -= s.inverse[a, b, i] * s.F[b, i]
        s.dx[a, i] = total
        long = max(long, abs(total))
    if long > LARGEST_STEP:
        for a in range(d):
            s.dx[a, i] *= LARGEST_STEP / long
    return long


@inner
def learn(s, i):  # type: ignore[no-untyped-def]
    """Broyden's update of H after dx led from F to new; H stays where its divisor is small."""
    d, divisor, square = len(s.x), 0.0, 0.0
    for a in range(d):
        moved, left = 0.0, 0.0
        for b in range(d):
            moved += s.inverse[a, b, i] * (s.new[b, i] - s.F[b, i])
            left += s.dx[b, i] * s.inverse[b, a, i]
        s.row[a, 0], s.row[a, 1] = moved, left
        divisor += s.dx[a, i] * moved
        square += s.dx[a, i] * s.dx[a, i]
    if not abs(divisor) > 0.05 * square:
        return
    for a in range(d):
        over = (s.dx[a, i] - s.row[a, 0]) / divisor
        for b in range(d):
            s.inverse[a, b, i] += over * s.row[b, 1]


@inner
def largest(v, i):  # type: ignore[no-untyped-def]
    """Largest entry of |v| of lane i; infinite if one is not finite."""
    most = 0.0
    for a in range(len(v)):
        if not np.isfinite(v[a, i]):
            return np.inf
        most = max(most, abs(v[a, i]))
    return most


@inner
def approach(chart, table, h, axis, terrain, work, more):  # type: ignore[no-untyped-def]
    """Newton's step from x by differences, then so many of Broyden's; whatever they come to."""
    s = work.search
    d = len(s.x)
    image(chart, s.x, table, h, axis, terrain, work, s.new)
    differentiate(chart, s.x, s.new, table, h, axis, terrain, work)
    for k in range(d):
        for i in range(LANES):
            s.F[k, i] = s.new[k, i] - s.x[k, i]
    for i in range(LANES):
        invert(s, i)
    for n in range(more + 1):
        if n > 0:
            image(chart, s.x, table, h, axis, terrain, work, s.new)
        for i in range(LANES):
            if n > 0:
                for k in range(d):
                    s.new[k, i] -= s.x[k, i]
                learn(s, i)
                for k in range(d):
                    s.F[k, i] = s.new[k, i]
            aim(s, i)
            for k in range(d):
                s.x[k, i] += s.dx[k, i]
    for i in range(LANES):
        if not np.isfinite(largest(s.x, i)):
            for k in range(d):
                s.x[k, i] = 0.0


@inner
def close(chart, table, h, axis, terrain, work, most):  # type: ignore[no-untyped-def]
    """Damped steps of the lanes that are to do, until F is small or `most` are made.

    The last step is left unproven where the steps before foretell that it ends far below the
    tolerance; `size` is then what is foretold, and the caller has to look.
    """
    s = work.search
    d = len(s.x)
    image(chart, s.x, table, h, axis, terrain, work, s.image)
    for i in range(LANES):
        if s.todo[i]:
            for k in range(d):
                s.F[k, i] = s.image[k, i] - s.x[k, i]
            s.spent[i] += 1.0
            s.size[i] = largest(s.F, i)
            s.halved[i] = 0
            aim(s, i)
            s.todo[i] = np.isfinite(s.size[i])
    for _ in range(most):
        busy = False
        for i in range(LANES):
            if s.todo[i] and s.size[i] <= 0.03 * TOLERANCE:
                s.todo[i] = False
            busy = busy or s.todo[i]
            for k in range(d):
                s.trial[k, i] = s.x[k, i] + (s.dx[k, i] if s.todo[i] else 0.0)
        if not busy:
            break
        image(chart, s.trial, table, h, axis, terrain, work, s.image)
        for i in range(LANES):
            if s.todo[i]:
                _judge(s, i)


@inner
def _judge(s, i):  # type: ignore[no-untyped-def]
    """Take the trial of lane i, or halve its step."""
    d, before = len(s.x), s.size[i]
    s.spent[i] += 1.0
    for k in range(d):
        s.new[k, i] = s.image[k, i] - s.trial[k, i]
    now = largest(s.new, i)
    if not now <= GROWTH * before + TOLERANCE and s.halved[i] < HALVINGS:
        s.halved[i] += 1
        for k in range(d):
            s.dx[k, i] *= 0.5
        return
    if not np.isfinite(now):
        s.todo[i] = False
        return
    learn(s, i)
    for k in range(d):
        s.x[k, i], s.F[k, i] = s.trial[k, i], s.new[k, i]
    s.size[i], s.halved[i] = now, 0
    long = aim(s, i)
    # Rounding: no smaller than before means that there is no more to gain.
    if (before <= TOLERANCE and now >= 0.5 * before) or (now <= TOLERANCE and long <= TOLERANCE):
        s.todo[i] = False
        return
    foretold = now * (now / max(before, 1e-300)) ** 1.5
    if foretold <= 0.1 * TOLERANCE and now > 0.03 * TOLERANCE:
        for k in range(d):
            s.x[k, i] += s.dx[k, i]
        s.size[i] = foretold
        s.todo[i] = False
