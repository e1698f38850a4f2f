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
from rrrobot.momentum.charts import put, take
from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import inner
from rrrobot.momentum.kernels import ROWS_PER_STEP, step

TOLERANCE = 1e-12
"""Largest residual of an orbit in scaled units."""
FORWARD = 1e-7
"""Step of forward differences in scaled units."""
LARGEST_STEP = 0.7
"""In scaled units: about 40 degrees."""
GROWTH = 3.0
"""By how much a step may make the residual grow before it is halved."""
HALVINGS = 6
DONE, FORETOLD, BUSY = 0, 1, 2
"""Whether a lane goes on; or will have ended when its last step is proved."""
_CLOSED = 0.03 * TOLERANCE
"""Residual at which a lane ends."""
_MISSES = 2
"""How often a lane's end may be foretold in vain."""


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
    stage: NDArray[np.int64]
    """DONE, FORETOLD or BUSY (LANES,)"""
    halved: NDArray[np.int64]
    missed: NDArray[np.int64]
    """how often what was foretold did not come true (LANES,)"""
    spent: Array
    """periods that each lane took, with the look at the end (LANES,)"""
    row: Array
    """scratch (d, 2 d)"""


def search_room(d: int) -> Search:
    """Room for d coordinates."""
    x, trial, F, new, dx, image = np.zeros((6, d, LANES))
    inverse, slope = np.zeros((2, d, d, LANES))
    stage, halved, missed = np.zeros((3, LANES), dtype=np.int64)
    size, scale, spent = np.zeros(LANES), np.ones(LANES), np.zeros(LANES)
    return Search(
        x, trial, F, new, dx, image, inverse, slope, size, scale, stage, halved, missed, spent,
        np.zeros((d, 2 * d)),
    )  # fmt: skip


@inner
def image(chart, x, table, h, axis, terrain, work, out):  # type: ignore[no-untyped-def]
    """P(x) of every lane by a table's steps, h (BLOCK,) long."""
    y = work.state[0]
    put(chart, x, work.search.scale, y, False)
    for at in range(0, len(table) - 1, ROWS_PER_STEP):
        step(y, table, at, h, work.parameters, axis, work.slopes, work.state[2], work.state[3],
             None, terrain, work.rolling)  # fmt: skip
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
def learned(s, i):  # type: ignore[no-untyped-def]
    """dP/dx of lane i = 1 + H^-1, and in place of H its inverse; one where it has none."""
    d = len(s.x)
    for a in range(d):
        for b in range(d):
            s.slope[a, b, i] = s.inverse[a, b, i] + (1.0 if a == b else 0.0)
    invert(s, i)
    for a in range(d):
        for b in range(d):
            s.slope[a, b, i] = s.inverse[a, b, i] + (1.0 if a == b else 0.0)


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
def begin(chart, table, h, axis, terrain, work):  # type: ignore[no-untyped-def]
    """The first step of every lane from x and H."""
    s = work.search
    image(chart, s.x, table, h, axis, terrain, work, s.image)
    for i in range(LANES):
        for k in range(len(s.x)):
            s.F[k, i] = s.image[k, i] - s.x[k, i]
        s.spent[i], s.halved[i], s.missed[i] = 1.0, 0, 0
        s.size[i] = largest(s.F, i)
        aim(s, i)
        s.stage[i] = BUSY
        if not np.isfinite(s.size[i]) or s.size[i] <= _CLOSED:
            _end(s, i)


@inner
def close(chart, table, h, axis, terrain, work, most):  # type: ignore[no-untyped-def]
    """Damped steps until no lane is busy; the trial is then where to look.

    The last step of a lane is left unproven where those before foretell that it ends far below the
    tolerance: it is proved beside other lanes that are busy, or else by the look.
    """
    s = work.search
    while True:
        busy = False
        for i in range(LANES):
            busy = busy or s.stage[i] == BUSY
            for k in range(len(s.x)):
                s.trial[k, i] = s.x[k, i] + (s.dx[k, i] if s.stage[i] != DONE else 0.0)
        if not busy:
            break
        image(chart, s.trial, table, h, axis, terrain, work, s.image)
        for i in range(LANES):
            if s.stage[i] != DONE:
                judge(s, i, most)


@inner
def judge(s, i, most):  # type: ignore[no-untyped-def]
    """Take the trial of lane i by its image, or halve its step; after `most` steps it is done."""
    d, before = len(s.x), s.size[i]
    s.spent[i] += 1.0
    for k in range(d):
        s.new[k, i] = s.image[k, i] - s.trial[k, i]
    now = largest(s.new, i)
    if s.stage[i] == FORETOLD:
        if now <= TOLERANCE:
            for k in range(d):
                s.x[k, i] = s.trial[k, i]
            s.size[i], s.stage[i] = now, DONE
            return
        s.stage[i] = BUSY
        s.missed[i] += 1
    last = s.spent[i] > most
    if not now <= GROWTH * before + TOLERANCE and s.halved[i] < HALVINGS and not last:
        s.halved[i] += 1
        for k in range(d):
            s.dx[k, i] *= 0.5
        return
    if not np.isfinite(now):
        _end(s, i)
        return
    learn(s, i)
    for k in range(d):
        s.x[k, i], s.F[k, i] = s.trial[k, i], s.new[k, i]
    s.size[i], s.halved[i] = now, 0
    long = aim(s, i)
    # Rounding: no smaller than before means that there is no more to gain.
    rounded = before <= TOLERANCE and now >= 0.5 * before
    if last or rounded or now <= _CLOSED or (now <= TOLERANCE and long <= TOLERANCE):
        _end(s, i)
    elif now * (now / before) ** 1.5 <= 0.1 * TOLERANCE and s.missed[i] < _MISSES:
        s.stage[i] = FORETOLD


@inner
def _end(s, i):  # type: ignore[no-untyped-def]
    """Lane i is done; the look at it is one more period."""
    s.stage[i] = DONE
    s.spent[i] += 1.0
