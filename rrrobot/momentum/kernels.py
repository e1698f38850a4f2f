"""The right-hand side of the contact momentum, and DOP853 over lanes of gaits, in Numba.

State of a lane: quaternion (x, y, z, w) of R_world_body, momentum K about the contact or the pivot
in the body frame, contact point (x, y), yaw. With s = r z_body the vector from the pivot to the
centre (r = 0 when pivoted), v = w x s, and mc, I, p_rel, L_rel of `coefficients.py`,

    K     = I_P w + L_rel + s x p_rel
    p     = M v + w x mc + p_rel
    K_dot = -w x K - g (mc x z_body) - v x p + damping
    I_P w = I w + mc x (w x s) + s x (M (w x s) + w x mc)

Lanes run side by side through each stage, so that the compiler uses vector instructions; nothing
there depends on another lane.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.integrate import DOP853

from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.common_pairs import (
    ellipsoid_on_plane,
    round_on_boulder,
    round_on_plane,
    three_on_level,
)
from rrrobot.momentum.compiled import lanes
from rrrobot.momentum.lane import brake, omega
from rrrobot.momentum.rolling import evaluate_lanes
from rrrobot.momentum.terrain import BOULDER, ELLIPSOIDS, LEVEL, ROUND, SLOPE
from rrrobot.momentum.trigonometry import sine_cosine

N_STATE = 10
N_PARAMETER = 8
"""mass, rolling radius (0 if pivoted), contact radius, gravity, damping of roll, pitch, yaw, and
whether that is on the Euler rates (1) or the body rates (0)."""
N_STAGES = 12
BLOCK = N_STATE * LANES
TILT = 7 * LANES
"""Entries of a block that do not depend on heading and place on level ground."""

_B = np.ascontiguousarray(DOP853.B)
NODES = np.unique(DOP853.C[:N_STAGES])
"""Distinct instants of the stages within a step, from 0 to 1; the last is the next step's first."""
_NODE = np.searchsorted(NODES, DOP853.C[:N_STAGES])
ROWS_PER_STEP = NODES.size - 1
"""Rows of a coefficient table for each step: its distinct stage times, the last being the next
step's first."""

ANY, DECOUPLED = -2, 3
"""The `axis` of a body that rolls with any shell on any ground, and of three single-axis models
that share a path; -1 is all axes of a sphere on level ground or a pivot."""
OK, VERTICAL, NOT_FINITE, LIFT_OFF, GROUND_END, TIGHT, TURNS_OVER = 0, 1, 2, 3, 4, 5, 8
"""Why a lane has no steady state: it has one; a pitch of +-90 degrees; a number that is not finite;
the settled motion would lift off the ground; the contact came to a boulder's equator, a belly's
edge or a graph's last cell; the ground curves tighter than the shell, which touches it twice; the
body turns over, so that its angles are no heading. 6 and 7 are for orbits."""


_FOUR = 4


def _packed(weights: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Stages and weights of sums of slopes, without the zero ones, four at a time.

    Returns:
        which stages (sums, groups, 4), -1 first in a group that a sum does not have; their weights.
    """
    groups = max(-(-np.count_nonzero(row) // _FOUR) for row in weights)
    which = np.full((len(weights), groups * _FOUR), -1)
    values = np.zeros(which.shape)
    for n, row in enumerate(weights):
        used = np.flatnonzero(row)
        filled = -(-used.size // _FOUR) * _FOUR
        # What fills a group up has weight zero.
        which[n, :filled] = np.append(used, np.full(filled - used.size, used[:1]))
        values[n, : used.size] = row[used]
    shape = (len(weights), groups, _FOUR)
    return which.reshape(shape), values.reshape(shape)


_WHICH, _WEIGHT = _packed([*DOP853.A[:N_STAGES, :N_STAGES], DOP853.B])
"""Of the state at each stage, and of the next step's."""


@njit(inline="always")
def _rates(y, c, row, par, k, stage, travels):  # type: ignore[no-untyped-def]
    """k = dy/dt for every lane; that of the contact point only if it `travels`."""
    for i in range(LANES):
        qx, qy, qz, qw = y[i], y[1 * LANES + i], y[2 * LANES + i], y[3 * LANES + i]
        scale = 1.0 / (qx * qx + qy * qy + qz * qz + qw * qw)
        # z_body = R^T z, and the first two rows of R.
        zx = 2.0 * scale * (qx * qz - qw * qy)
        zy = 2.0 * scale * (qy * qz + qw * qx)
        zz = 1.0 - 2.0 * scale * (qx * qx + qy * qy)
        m0, m1, m2 = c[row, i], c[row, 1 * LANES + i], c[row, 2 * LANES + i]
        p0, p1, p2 = c[row, 9 * LANES + i], c[row, 10 * LANES + i], c[row, 11 * LANES + i]
        mass, r, radius, g = par[i], par[1 * LANES + i], par[2 * LANES + i], par[3 * LANES + i]
        s0, s1, s2 = r * zx, r * zy, r * zz
        w0, w1, w2 = omega(y, c, row, i, mass, m0, m1, m2, p0, p1, p2, s0, s1, s2)
        v0, v1, v2 = w1 * s2 - w2 * s1, w2 * s0 - w0 * s2, w0 * s1 - w1 * s0
        t0, t1, t2 = mass * s0 + m0, mass * s1 + m1, mass * s2 + m2
        p0 += w1 * t2 - w2 * t1
        p1 += w2 * t0 - w0 * t2
        p2 += w0 * t1 - w1 * t0
        k0, k1, k2 = y[4 * LANES + i], y[5 * LANES + i], y[6 * LANES + i]
        f0 = -(w1 * k2 - w2 * k1) - g * (m1 * zz - m2 * zy) - (v1 * p2 - v2 * p1)
        f1 = -(w2 * k0 - w0 * k2) - g * (m2 * zx - m0 * zz) - (v2 * p0 - v0 * p2)
        f2 = -(w0 * k1 - w1 * k0) - g * (m0 * zy - m1 * zx) - (v0 * p1 - v1 * p0)
        brake(y, par, k, stage, i, zx, zy, zz, w0, w1, w2, f0, f1, f2)
        if not travels:
            continue
        # Contact point of a sphere: r (Omega_y, -Omega_x).
        ox = (1.0 - 2.0 * scale * (qy * qy + qz * qz)) * w0 + 2.0 * scale * (
            (qx * qy - qw * qz) * w1 + (qx * qz + qw * qy) * w2
        )
        oy = (
            2.0 * scale * ((qx * qy + qw * qz) * w0 + (qy * qz - qw * qx) * w2)
            + (1.0 - 2.0 * scale * (qx * qx + qz * qz)) * w1
        )
        k[stage, 7 * LANES + i] = radius * oy
        k[stage, 8 * LANES + i] = -radius * ox


@lanes
def _axis_rates(y, c, row, par, k, stage, axis):  # type: ignore[no-untyped-def]
    """k = dy/dt for every lane when the body turns about one of its axes only.

    The axis is then the same line in the body and in the world: K_dot = -g (mc x z) - v x p along
    it, and the other entries of K stay zero.
    """
    for e in range(BLOCK):
        k[stage, e] = 0.0
    for i in range(LANES):
        qx, qy, qz, qw = y[i], y[LANES + i], y[2 * LANES + i], y[3 * LANES + i]
        scale = 1.0 / (qx * qx + qy * qy + qz * qz + qw * qw)
        zx = 2.0 * scale * (qx * qz - qw * qy)
        zy = 2.0 * scale * (qy * qz + qw * qx)
        zz = 1.0 - 2.0 * scale * (qx * qx + qy * qy)
        m0, m1, m2 = c[row, i], c[row, LANES + i], c[row, 2 * LANES + i]
        p0, p1, p2 = c[row, 9 * LANES + i], c[row, 10 * LANES + i], c[row, 11 * LANES + i]
        mass, r, radius, g = par[i], par[LANES + i], par[2 * LANES + i], par[3 * LANES + i]
        s0, s1, s2 = r * zx, r * zy, r * zz
        whole = 2.0 * (m0 * s0 + m1 * s1 + m2 * s2) + mass * (s0 * s0 + s1 * s1 + s2 * s2)
        w0, w1, w2 = 0.0, 0.0, 0.0
        if axis == 0:
            inertia = c[row, 3 * LANES + i] + whole - (2.0 * m0 + mass * s0) * s0
            w0 = (y[4 * LANES + i] - c[row, 12 * LANES + i] - (s1 * p2 - s2 * p1)) / inertia
        elif axis == 1:
            inertia = c[row, 4 * LANES + i] + whole - (2.0 * m1 + mass * s1) * s1
            w1 = (y[5 * LANES + i] - c[row, 13 * LANES + i] - (s2 * p0 - s0 * p2)) / inertia
        else:
            inertia = c[row, 5 * LANES + i] + whole - (2.0 * m2 + mass * s2) * s2
            w2 = (y[6 * LANES + i] - c[row, 14 * LANES + i] - (s0 * p1 - s1 * p0)) / inertia
        v0, v1, v2 = w1 * s2 - w2 * s1, w2 * s0 - w0 * s2, w0 * s1 - w1 * s0
        p0 += mass * v0 + w1 * m2 - w2 * m1
        p1 += mass * v1 + w2 * m0 - w0 * m2
        p2 += mass * v2 + w0 * m1 - w1 * m0
        k[stage, i] = 0.5 * (qw * w0 + qy * w2 - qz * w1)
        k[stage, LANES + i] = 0.5 * (qw * w1 + qz * w0 - qx * w2)
        k[stage, 2 * LANES + i] = 0.5 * (qw * w2 + qx * w1 - qy * w0)
        k[stage, 3 * LANES + i] = -0.5 * (qx * w0 + qy * w1 + qz * w2)
        damping = par[(4 + axis) * LANES + i]
        if axis == 0:
            k[stage, 4 * LANES + i] = -g * (m1 * zz - m2 * zy) - (v1 * p2 - v2 * p1) - damping * w0
            k[stage, 8 * LANES + i] = -radius * w0
        elif axis == 1:
            k[stage, 5 * LANES + i] = -g * (m2 * zx - m0 * zz) - (v2 * p0 - v0 * p2) - damping * w1
            k[stage, 7 * LANES + i] = radius * w1
        else:
            k[stage, 6 * LANES + i] = -g * (m0 * zy - m1 * zx) - (v0 * p1 - v1 * p0) - damping * w2
            k[stage, 9 * LANES + i] = w2


@lanes
def _decoupled_rates(y, c, row, par, k, stage):  # type: ignore[no-untyped-def]
    """k = dy/dt for every lane of three single-axis models that share a path.

    Their state is (roll, pitch, -, -, K of each, x, y, yaw): the roll and pitch models roll, the
    yaw model is pivoted without gravity, and eqs (2)-(3) move the contact point. Entries 5 and 14
    of the coefficients are the yaw model's own.
    """
    for i in range(LANES):
        roll, pitch, yaw = y[i], y[LANES + i], y[9 * LANES + i]
        sr, cr = sine_cosine(roll)
        sp, cp = sine_cosine(pitch)
        sy, cy = sine_cosine(yaw)
        m0, m1, m2 = c[row, i], c[row, LANES + i], c[row, 2 * LANES + i]
        p0, p1, p2 = c[row, 9 * LANES + i], c[row, 10 * LANES + i], c[row, 11 * LANES + i]
        mass, r, g = par[i], par[LANES + i], par[3 * LANES + i]
        # Roll: z_body = (0, sr, cr), s = r z_body.
        s1, s2 = r * sr, r * cr
        inertia = c[row, 3 * LANES + i] + 2.0 * (m1 * s1 + m2 * s2) + mass * r * r
        w0 = (y[4 * LANES + i] - c[row, 12 * LANES + i] - (s1 * p2 - s2 * p1)) / inertia
        v1, v2 = -w0 * s2, w0 * s1
        f0 = -g * (m1 * cr - m2 * sr) - par[4 * LANES + i] * w0
        f0 -= v1 * (p2 + mass * v2 + w0 * m1) - v2 * (p1 + mass * v1 - w0 * m2)
        # Pitch: z_body = (-sp, 0, cp).
        s0, s2 = -r * sp, r * cp
        inertia = c[row, 4 * LANES + i] + 2.0 * (m0 * s0 + m2 * s2) + mass * r * r
        w1 = (y[5 * LANES + i] - c[row, 13 * LANES + i] - (s2 * p0 - s0 * p2)) / inertia
        v0, v2 = w1 * s2, -w1 * s0
        f1 = -g * (-m2 * sp - m0 * cp) - par[5 * LANES + i] * w1
        f1 -= v2 * (p0 + mass * v0 + w1 * m2) - v0 * (p2 + mass * v2 - w1 * m0)
        w2 = (y[6 * LANES + i] - c[row, 14 * LANES + i]) / c[row, 5 * LANES + i]
        k[stage, i], k[stage, LANES + i], k[stage, 2 * LANES + i], k[stage, 3 * LANES + i] = (
            w0,
            w1,
            0.0,
            0.0,
        )
        k[stage, 4 * LANES + i], k[stage, 5 * LANES + i] = f0, f1
        k[stage, 6 * LANES + i] = -par[6 * LANES + i] * w2
        k[stage, 7 * LANES + i] = r * (cp * sy * w0 + cy * w1)
        k[stage, 8 * LANES + i] = r * (sy * w1 - cp * cy * w0)
        k[stage, 9 * LANES + i] = w2


@njit(inline="always")
def _advance(y, slopes, which, weights, n, h, size, total, out):  # type: ignore[no-untyped-def]
    """out = y + h (sum of weighted slopes) of `size` entries; total is scratch."""
    for g in range(which.shape[1]):
        j0, j1, j2, j3 = which[n, g, 0], which[n, g, 1], which[n, g, 2], which[n, g, 3]
        a0, a1, a2, a3 = weights[n, g, 0], weights[n, g, 1], weights[n, g, 2], weights[n, g, 3]
        if j0 < 0:
            break
        if g == 0:
            for e in range(size):
                total[e] = (a0 * slopes[j0, e] + a1 * slopes[j1, e]) + (
                    a2 * slopes[j2, e] + a3 * slopes[j3, e]
                )
        else:
            for e in range(size):
                total[e] += (a0 * slopes[j0, e] + a1 * slopes[j1, e]) + (
                    a2 * slopes[j2, e] + a3 * slopes[j3, e]
                )
    for e in range(size):
        out[e] = y[e] + h[e] * total[e]


@lanes
def step(  # type: ignore[no-untyped-def]
    y, table, at, h, par, axis, slopes, total, work, areas, terrain, rolling
):
    """One step of every lane, in place; adds the integrals of x, y and yaw to areas (3 LANES,).

    Args:
        y: states (BLOCK,): entry s of lane i stands at s LANES + i, here as everywhere.
        table: coefficients (nodes, 15 LANES), `at` the row where this step begins.
        h: step of each lane, the same for each entry of its state (BLOCK,) [s].
        par: parameters (N_PARAMETER LANES,).
        axis: -1 all axes; 0-2 that body axis only; 3 the three single-axis models; ANY.
        slopes: scratch (N_STAGES, BLOCK); its first row then holds the rates at the step's start.
        total, work: scratch (BLOCK,), (BLOCK,).
        areas: None: x, y and yaw, on which the rest does not depend, are not carried on.
        terrain, rolling: shell and ground, and scratch for them, where axis is ANY; else None.
    """
    for stage in range(N_STAGES + 1):
        if stage == 0:
            for e in range(BLOCK):
                work[e] = y[e]
        else:
            # Each with a constant size, which makes faster loops. Numba leaves out the branches
            # that the types of areas and terrain rule out.
            if areas is None:
                _advance(y, slopes, _WHICH, _WEIGHT, stage, h, TILT, total, work)
            else:
                _advance(y, slopes, _WHICH, _WEIGHT, stage, h, BLOCK, total, work)
        if stage == N_STAGES:
            break
        if areas is not None:
            b = _B[stage]
            if b != 0.0:
                for e in range(3 * LANES):
                    areas[e] += b * h[e] * work[7 * LANES + e]
        row = at + _NODE[stage]
        if terrain is None:
            if axis < 0:
                if areas is None:
                    _rates(work, table, row, par, slopes, stage, False)
                else:
                    _rates(work, table, row, par, slopes, stage, True)
            elif axis < DECOUPLED:
                _axis_rates(work, table, row, par, slopes, stage, axis)
            else:
                _decoupled_rates(work, table, row, par, slopes, stage)
        else:
            # Written out: an inlined function would count references to each array of the terrain.
            if terrain.shell == ROUND and terrain.ground == LEVEL:
                round_on_plane(
                    work, table, row, par, slopes, stage, terrain.center, terrain.radius, None
                )
            elif terrain.shell == ROUND and terrain.ground == SLOPE:
                round_on_plane(
                    work, table, row, par, slopes, stage, terrain.center, terrain.radius,
                    terrain.plane,
                )  # fmt: skip
            elif terrain.shell == ROUND and terrain.ground == BOULDER:
                round_on_boulder(
                    work, table, row, par, slopes, stage, terrain.center, terrain.radius,
                    terrain.curvature, terrain.limit, rolling,
                )  # fmt: skip
            elif (
                terrain.shell == ELLIPSOIDS and terrain.ground == LEVEL and len(terrain.terms) == 1
            ):
                ellipsoid_on_plane(
                    work, table, row, par, slopes, stage, terrain.center, terrain.terms, None
                )
            elif (
                terrain.shell == ELLIPSOIDS and terrain.ground == SLOPE and len(terrain.terms) == 1
            ):
                ellipsoid_on_plane(
                    work, table, row, par, slopes, stage, terrain.center, terrain.terms,
                    terrain.plane,
                )  # fmt: skip
            elif (
                terrain.shell == ELLIPSOIDS and terrain.ground == LEVEL and len(terrain.terms) == 3
            ):
                three_on_level(work, table, row, par, slopes, stage, terrain.center, terrain.terms)
            else:
                evaluate_lanes(work, table, row, par, slopes, stage, terrain, rolling)
    if areas is None:
        for e in range(TILT):
            y[e] = work[e]
    else:
        for e in range(BLOCK):
            y[e] = work[e]
