"""How near lanes come to the vertical, at steps and between them, and how far they tilt.

The sine of the pitch, -z_body,x, is smooth even where a lane leaps over the vertical. Its values
and slopes at three steps give a polynomial of fifth degree, so that a pitch of +-90 degrees is
seen that lies between two of them; with ten steps of a sinusoid of amplitude 1 the polynomial is
off by 1e-5.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from rrrobot.checks import Array
from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import borrowed, compiled, inner, lanes
from rrrobot.momentum.interpolation import between, interpolate

N_PAST = 3
"""Steps that are kept: the newest last."""
_HALVINGS = 40


@lanes
def watch(y, k, h, past, sides):  # type: ignore[no-untyped-def]
    """Keep the sine of the pitch of every lane, and see which lanes leapt over the vertical.

    Args:
        y: states (BLOCK,).
        k: their rates, in the first row (..., BLOCK).
        h: step of each lane (LANES, ...) [s].
        past: sines and their slopes times h (N_PAST, 2, LANES).
        sides: (sin roll, cos roll) cos pitch at the step before, then at this one, and their
            product, which is negative where the roll turned by more than a quarter: a leap
            (3, LANES).
    """
    for n in range(N_PAST - 1):
        for i in range(LANES):
            past[n, 0, i], past[n, 1, i] = past[n + 1, 0, i], past[n + 1, 1, i]
    for i in range(LANES):
        qx, qy, qz, qw = y[i], y[LANES + i], y[2 * LANES + i], y[3 * LANES + i]
        kx, ky, kz, kw = k[0, i], k[0, LANES + i], k[0, 2 * LANES + i], k[0, 3 * LANES + i]
        scale = 2.0 / (qx * qx + qy * qy + qz * qz + qw * qw)
        past[N_PAST - 1, 0, i] = scale * (qw * qy - qz * qx)
        past[N_PAST - 1, 1, i] = h[i] * scale * (kw * qy + qw * ky - kz * qx - qz * kx)
        a = scale * (qw * qx + qy * qz)
        b = 1.0 - scale * (qx * qx + qy * qy)
        sides[2, i] = a * sides[0, i] + b * sides[1, i]
        sides[0, i], sides[1, i] = a, b


@njit(inline="always")
def may_pass(past, i, known, largest):  # type: ignore[no-untyped-def]
    """Whether |sine| of lane i may have been larger within the newest step; cheap.

    Args:
        past: as `watch` leaves it.
        i: the lane.
        known: entries of `past` that are filled.
        largest: so far.
    """
    a, b, da, db = past[1, 0, i], past[2, 0, i], past[1, 1, i], past[2, 1, i]
    # No cubic with these ends goes beyond them by 8/27 of the slopes; a quintic hardly more.
    bound = max(abs(a), abs(b)) + 0.35 * max(abs(da), abs(db))
    return known > 1 and bound > largest and da * db < 0.0


@inner
def largest_between(past, i, known):  # type: ignore[no-untyped-def]
    """|sine| of lane i where its polynomial is level within the newest step."""
    f0, f1, f2 = past[0, 0, i], past[1, 0, i], past[2, 0, i]
    d0, d1, d2 = past[0, 1, i], past[1, 1, i], past[2, 1, i]
    c4, c5 = 0.0, 0.0
    if known > 2:
        # Steps at t = -1, 0, 1.
        bend = f2 + f0 - 2.0 * f1
        c4 = 0.25 * (d2 - d0) - 0.5 * bend
        c2 = 0.5 * bend - c4
        c5 = 0.25 * (d0 + d2) + d1 - 0.75 * (f2 - f0)
        c3 = 0.5 * (f2 - f0) - d1 - c5
    else:
        c2 = 3.0 * (f2 - f1) - 2.0 * d1 - d2
        c3 = d1 + d2 - 2.0 * (f2 - f1)
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        t = 0.5 * (low + high)
        slope = d1 + t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)))
        if slope * d1 > 0.0:
            low = t
        else:
            high = t
    t = 0.5 * (low + high)
    return abs(f1 + t * (d1 + t * (c2 + t * (c3 + t * (c4 + t * c5)))))


def pitch_of(sine: Array) -> Array:
    """|pitch| of the largest |sine| [rad]; the polynomial may exceed 1 by its error."""
    return np.asarray(np.arcsin(np.minimum(sine, 1.0)))


def largest_tilt(motion: Array, *, periodic: bool) -> Array:
    """Largest angle of the body's z axis from the ground's normal n over a cycle (n,) [rad].

    It is looked for between the steps, on the interpolation of n in the body's axes.

    Args:
        motion: of a cycle, as `Settled.motion` has it.
        periodic: whether it repeats.
    """
    refine, finer = between(motion.shape[1], periodic)
    weights = np.ascontiguousarray((finer @ refine).T)
    out, first = np.empty(len(motion)), 6 if motion.shape[2] > 9 else 0
    work = np.empty((4, weights.shape[1]))
    _largest_tilt(np.ascontiguousarray(motion), first, weights, periodic, work, out)
    return out


@compiled()
def _largest_tilt(motion, first, weights, periodic, work, out):  # type: ignore[no-untyped-def]
    motion, weights, work, out = (
        borrowed(motion), borrowed(weights), borrowed(work), borrowed(out),
    )  # fmt: skip
    x, y, z, lean = work[0], work[1], work[2], work[3]
    last = len(lean)
    for g in range(len(out)):
        for s in range(3):
            interpolate(weights, motion[g], first + s, work[s])
        for p in range(last):
            # Square of the tangent of half the angle.
            across = x[p] * x[p] + y[p] * y[p]
            along = z[p] + np.sqrt(across + z[p] * z[p])
            lean[p] = across / (along * along)
        k = 0
        for p in range(last):
            if lean[p] > lean[k]:
                k = p
        if periodic:
            before, after = (k - 1) % last, (k + 1) % last
        else:
            before, after = max(k - 1, 0), min(k + 1, last - 1)
        left, top, right = (
            2.0 * np.arctan(np.sqrt(lean[before])), 2.0 * np.arctan(np.sqrt(lean[k])),
            2.0 * np.arctan(np.sqrt(lean[after])),
        )  # fmt: skip
        bend = left - 2.0 * top + right
        if bend < 0.0:
            # The parabola's top is within the samples beside the largest one.
            top += min(-((left - right) ** 2) / (8.0 * bend), -bend)
        out[g] = top
