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
from rrrobot.momentum.compiled import inner, lanes
from rrrobot.momentum.interpolation import between

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
    normal = motion[:, :, 6:9] if motion.shape[2] > 9 else motion[:, :, :3]
    size = np.square(np.einsum("pm,nms->nps", finer @ refine, normal[:, :, :2])).sum(axis=2)
    # Roll and pitch below a quarter turn or beyond: the sine alone does not tell.
    along = np.einsum("pm,nm->np", finer @ refine, normal[:, :, 2])
    tilt = np.arctan2(np.sqrt(size), along)
    rows, k = np.arange(len(tilt)), np.nan_to_num(tilt).argmax(axis=1)
    last = tilt.shape[1]
    left, right = (
        tilt[rows, (k + i) % last if periodic else np.clip(k + i, 0, last - 1)] for i in (-1, 1)
    )
    top = tilt[rows, k]
    bend = left - 2.0 * top + right
    with np.errstate(invalid="ignore", divide="ignore"):
        more = np.where(bend < 0, -((left - right) ** 2) / (8.0 * bend), 0.0)
    # The parabola's top is within the samples beside the largest one.
    return np.asarray(top + np.minimum(more, np.abs(bend)))
