"""The force along the ground's normal, and what is needed for it, of a lane on any ground.

With p the momentum in the base's axes and n_b the normal there,

    N = n.force = d(n_b.p)/dt - n_dot.p + M g n_z,        n_dot = B P_dot
"""

from __future__ import annotations

import numpy as np

from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import inner
from rrrobot.momentum.lane import N, P, R, S, U, X
from rrrobot.momentum.summary import N_MOTION, between
from rrrobot.momentum.terrain import BOULDER, GRAPH

N_ANY_MOTION = N_MOTION + 12
"""Entries of a lane's motion on any ground: z_body and angular velocity as everywhere, then n, s,
x_dot and n_dot in the base's axes (3 each)."""


@inner
def contact_motion(terrain, b, i, now):  # type: ignore[no-untyped-def]
    """Fill the entries from n on, from the scratch of an evaluation."""
    for a in range(3):
        now[6 + a], now[9 + a], now[12 + a] = (
            b[(N + a) * LANES + i],
            b[(S + a) * LANES + i],
            b[(X + a) * LANES + i],
        )
        now[15 + a] = 0.0
    if terrain.ground == BOULDER:
        for a in range(3):
            now[15 + a] = terrain.curvature * b[(X + a) * LANES + i]
    elif terrain.ground == GRAPH:
        x = (
            b[R * LANES + i] * b[X * LANES + i]
            + b[(R + 1) * LANES + i] * b[(X + 1) * LANES + i]
            + b[(R + 2) * LANES + i] * b[(X + 2) * LANES + i]
        )
        y = (
            b[(R + 3) * LANES + i] * b[X * LANES + i]
            + b[(R + 4) * LANES + i] * b[(X + 1) * LANES + i]
            + b[(R + 5) * LANES + i] * b[(X + 2) * LANES + i]
        )
        bend_x = -(b[(U + 2) * LANES + i] * x + b[(U + 3) * LANES + i] * y)
        bend_y = -(b[(U + 3) * LANES + i] * x + b[(U + 4) * LANES + i] * y)
        along = 0.0
        for a in range(3):
            now[15 + a] = b[(R + a) * LANES + i] * bend_x + b[(R + 3 + a) * LANES + i] * bend_y
            along += b[(N + a) * LANES + i] * now[15 + a]
        for a in range(3):
            now[15 + a] -= along * b[(N + a) * LANES + i]


@inner
def push(b, now, par, i):  # type: ignore[no-untyped-def]
    """n_b.p, and M g n_z - n_dot.p."""
    lift, rest = 0.0, 0.0
    weight = par[i] * par[3 * LANES + i]
    for a in range(3):
        lift += b[(N + a) * LANES + i] * b[(P + a) * LANES + i]
        rest += weight * b[(N + a) * LANES + i] * now[a] - now[15 + a] * b[(P + a) * LANES + i]
    return lift, rest


@inner
def least_sum(slope_of, lift, h, value_of, rest, out, sums):  # type: ignore[no-untyped-def]
    """Least of the rate of `lift` plus `rest` of every lane, between the samples of a cycle."""
    rate, value, steps = sums[0], sums[1], len(lift)
    for i in range(len(out)):
        out[i] = np.inf
    for m in range(len(slope_of)):
        between(slope_of[m], lift, rate)
        between(value_of[m], rest, value)
        for i in range(len(out)):
            out[i] = min(out[i], rate[i] / (h[i] * steps) + value[i])
