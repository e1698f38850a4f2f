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

LANES = 16
"""Lanes of a block."""
N_STATE = 10
N_PARAMETER = 8
"""mass, rolling radius (0 if pivoted), contact radius, gravity, damping of roll, pitch, yaw, and
whether that is on the Euler rates (1) or the body rates (0)."""
N_STAGES = 12
BLOCK = N_STATE * LANES

_A = np.ascontiguousarray(DOP853.A[:N_STAGES, :N_STAGES])
_B = np.ascontiguousarray(DOP853.B)
NODES = np.unique(DOP853.C[:N_STAGES])
"""Distinct instants of the stages within a step, from 0 to 1; the last is the next step's first."""
_NODE = np.searchsorted(NODES, DOP853.C[:N_STAGES])

DECOUPLED = 3
"""The `axis` of three single-axis models that share a path."""
OK, VERTICAL, NOT_FINITE, LIFT_OFF = 0, 1, 2, 3
"""Why a lane has no steady state: it has one; a pitch of +-90 degrees; a number that is not finite;
the settled motion would lift off the ground."""


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _rates(y, c, par, k):  # type: ignore[no-untyped-def]
    """k = dy/dt for every lane."""
    for i in range(LANES):
        qx, qy, qz, qw = y[i], y[1 * LANES + i], y[2 * LANES + i], y[3 * LANES + i]
        scale = 1.0 / (qx * qx + qy * qy + qz * qz + qw * qw)
        # z_body = R^T z, and the first two rows of R.
        zx = 2.0 * scale * (qx * qz - qw * qy)
        zy = 2.0 * scale * (qy * qz + qw * qx)
        zz = 1.0 - 2.0 * scale * (qx * qx + qy * qy)
        m0, m1, m2 = c[i], c[1 * LANES + i], c[2 * LANES + i]
        p0, p1, p2 = c[9 * LANES + i], c[10 * LANES + i], c[11 * LANES + i]
        mass, r, radius, g = par[i], par[1 * LANES + i], par[2 * LANES + i], par[3 * LANES + i]
        s0, s1, s2 = r * zx, r * zy, r * zz
        # K less its part from the legs' own motion.
        b0 = y[4 * LANES + i] - c[12 * LANES + i] - (s1 * p2 - s2 * p1)
        b1 = y[5 * LANES + i] - c[13 * LANES + i] - (s2 * p0 - s0 * p2)
        b2 = y[6 * LANES + i] - c[14 * LANES + i] - (s0 * p1 - s1 * p0)
        # I_P = I + (2 s.mc + M s.s) 1 - (mc s^T + s mc^T) - M s s^T.
        ms = m0 * s0 + m1 * s1 + m2 * s2
        whole = 2.0 * ms + mass * (s0 * s0 + s1 * s1 + s2 * s2)
        i00 = c[3 * LANES + i] + whole - (2.0 * m0 + mass * s0) * s0
        i11 = c[4 * LANES + i] + whole - (2.0 * m1 + mass * s1) * s1
        i22 = c[5 * LANES + i] + whole - (2.0 * m2 + mass * s2) * s2
        i01 = c[6 * LANES + i] - m0 * s1 - s0 * m1 - mass * s0 * s1
        i02 = c[7 * LANES + i] - m0 * s2 - s0 * m2 - mass * s0 * s2
        i12 = c[8 * LANES + i] - m1 * s2 - s1 * m2 - mass * s1 * s2
        # Solve the symmetric 3 x 3 system by its adjugate.
        a00 = i11 * i22 - i12 * i12
        a01 = i02 * i12 - i01 * i22
        a02 = i01 * i12 - i02 * i11
        a11 = i00 * i22 - i02 * i02
        a12 = i01 * i02 - i00 * i12
        a22 = i00 * i11 - i01 * i01
        over = 1.0 / (i00 * a00 + i01 * a01 + i02 * a02)
        w0 = over * (a00 * b0 + a01 * b1 + a02 * b2)
        w1 = over * (a01 * b0 + a11 * b1 + a12 * b2)
        w2 = over * (a02 * b0 + a12 * b1 + a22 * b2)
        v0, v1, v2 = w1 * s2 - w2 * s1, w2 * s0 - w0 * s2, w0 * s1 - w1 * s0
        p0 += mass * v0 + w1 * m2 - w2 * m1
        p1 += mass * v1 + w2 * m0 - w0 * m2
        p2 += mass * v2 + w0 * m1 - w1 * m0
        k0, k1, k2 = y[4 * LANES + i], y[5 * LANES + i], y[6 * LANES + i]
        f0 = -(w1 * k2 - w2 * k1) - g * (m1 * zz - m2 * zy) - (v1 * p2 - v2 * p1)
        f1 = -(w2 * k0 - w0 * k2) - g * (m2 * zx - m0 * zz) - (v2 * p0 - v0 * p2)
        f2 = -(w0 * k1 - w1 * k0) - g * (m0 * zy - m1 * zx) - (v0 * p1 - v1 * p0)
        # Euler rates, from sin pitch = -zx and cos pitch (sin roll, cos roll) = (zy, zz).
        cos2 = zy * zy + zz * zz
        over_cos = 1.0 / np.sqrt(cos2)
        sr, cr = zy * over_cos, zz * over_cos
        tp = -zx * over_cos
        about = sr * w1 + cr * w2
        yaw_rate = about * over_cos
        on_roll = -par[4 * LANES + i] * (w0 + tp * about)
        on_pitch = -par[5 * LANES + i] * (cr * w1 - sr * w2)
        on_yaw = -par[6 * LANES + i] * yaw_rate
        lever = tp * on_roll + on_yaw * over_cos
        euler = par[7 * LANES + i]
        body = 1.0 - euler
        f0 += euler * on_roll - body * par[4 * LANES + i] * w0
        f1 += euler * (sr * lever + cr * on_pitch) - body * par[5 * LANES + i] * w1
        f2 += euler * (cr * lever - sr * on_pitch) - body * par[6 * LANES + i] * w2
        k[i] = 0.5 * (qw * w0 + qy * w2 - qz * w1)
        k[1 * LANES + i] = 0.5 * (qw * w1 + qz * w0 - qx * w2)
        k[2 * LANES + i] = 0.5 * (qw * w2 + qx * w1 - qy * w0)
        k[3 * LANES + i] = -0.5 * (qx * w0 + qy * w1 + qz * w2)
        k[4 * LANES + i], k[5 * LANES + i], k[6 * LANES + i] = f0, f1, f2
        # Contact point of a sphere: r (Omega_y, -Omega_x).
        ox = (1.0 - 2.0 * scale * (qy * qy + qz * qz)) * w0 + 2.0 * scale * (
            (qx * qy - qw * qz) * w1 + (qx * qz + qw * qy) * w2
        )
        oy = (
            2.0 * scale * ((qx * qy + qw * qz) * w0 + (qy * qz - qw * qx) * w2)
            + (1.0 - 2.0 * scale * (qx * qx + qz * qz)) * w1
        )
        k[7 * LANES + i] = radius * oy
        k[8 * LANES + i] = -radius * ox
        k[9 * LANES + i] = yaw_rate


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _axis_rates(y, c, par, k, axis):  # type: ignore[no-untyped-def]
    """k = dy/dt for every lane when the body turns about one of its axes only.

    The axis is then the same line in the body and in the world: K_dot = -g (mc x z) - v x p along
    it, and the other entries of K stay zero.
    """
    for e in range(BLOCK):
        k[e] = 0.0
    for i in range(LANES):
        qx, qy, qz, qw = y[i], y[LANES + i], y[2 * LANES + i], y[3 * LANES + i]
        scale = 1.0 / (qx * qx + qy * qy + qz * qz + qw * qw)
        zx = 2.0 * scale * (qx * qz - qw * qy)
        zy = 2.0 * scale * (qy * qz + qw * qx)
        zz = 1.0 - 2.0 * scale * (qx * qx + qy * qy)
        m0, m1, m2 = c[i], c[LANES + i], c[2 * LANES + i]
        p0, p1, p2 = c[9 * LANES + i], c[10 * LANES + i], c[11 * LANES + i]
        mass, r, radius, g = par[i], par[LANES + i], par[2 * LANES + i], par[3 * LANES + i]
        s0, s1, s2 = r * zx, r * zy, r * zz
        whole = 2.0 * (m0 * s0 + m1 * s1 + m2 * s2) + mass * (s0 * s0 + s1 * s1 + s2 * s2)
        w0, w1, w2 = 0.0, 0.0, 0.0
        if axis == 0:
            inertia = c[3 * LANES + i] + whole - (2.0 * m0 + mass * s0) * s0
            w0 = (y[4 * LANES + i] - c[12 * LANES + i] - (s1 * p2 - s2 * p1)) / inertia
        elif axis == 1:
            inertia = c[4 * LANES + i] + whole - (2.0 * m1 + mass * s1) * s1
            w1 = (y[5 * LANES + i] - c[13 * LANES + i] - (s2 * p0 - s0 * p2)) / inertia
        else:
            inertia = c[5 * LANES + i] + whole - (2.0 * m2 + mass * s2) * s2
            w2 = (y[6 * LANES + i] - c[14 * LANES + i] - (s0 * p1 - s1 * p0)) / inertia
        v0, v1, v2 = w1 * s2 - w2 * s1, w2 * s0 - w0 * s2, w0 * s1 - w1 * s0
        p0 += mass * v0 + w1 * m2 - w2 * m1
        p1 += mass * v1 + w2 * m0 - w0 * m2
        p2 += mass * v2 + w0 * m1 - w1 * m0
        k[i] = 0.5 * (qw * w0 + qy * w2 - qz * w1)
        k[LANES + i] = 0.5 * (qw * w1 + qz * w0 - qx * w2)
        k[2 * LANES + i] = 0.5 * (qw * w2 + qx * w1 - qy * w0)
        k[3 * LANES + i] = -0.5 * (qx * w0 + qy * w1 + qz * w2)
        damping = par[(4 + axis) * LANES + i]
        if axis == 0:
            k[4 * LANES + i] = -g * (m1 * zz - m2 * zy) - (v1 * p2 - v2 * p1) - damping * w0
            k[8 * LANES + i] = -radius * w0
        elif axis == 1:
            k[5 * LANES + i] = -g * (m2 * zx - m0 * zz) - (v2 * p0 - v0 * p2) - damping * w1
            k[7 * LANES + i] = radius * w1
        else:
            k[6 * LANES + i] = -g * (m0 * zy - m1 * zx) - (v0 * p1 - v1 * p0) - damping * w2
            k[9 * LANES + i] = w2


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _decoupled_rates(y, c, par, k):  # type: ignore[no-untyped-def]
    """k = dy/dt for every lane of three single-axis models that share a path.

    Their state is (roll, pitch, -, -, K of each, x, y, yaw): the roll and pitch models roll, the
    yaw model is pivoted without gravity, and eqs (2)-(3) move the contact point. Entries 5 and 14
    of the coefficients are the yaw model's own.
    """
    for i in range(LANES):
        roll, pitch, yaw = y[i], y[LANES + i], y[9 * LANES + i]
        sr, cr, sp, cp = np.sin(roll), np.cos(roll), np.sin(pitch), np.cos(pitch)
        sy, cy = np.sin(yaw), np.cos(yaw)
        m0, m1, m2 = c[i], c[LANES + i], c[2 * LANES + i]
        p0, p1, p2 = c[9 * LANES + i], c[10 * LANES + i], c[11 * LANES + i]
        mass, r, g = par[i], par[LANES + i], par[3 * LANES + i]
        # Roll: z_body = (0, sr, cr), s = r z_body.
        s1, s2 = r * sr, r * cr
        inertia = c[3 * LANES + i] + 2.0 * (m1 * s1 + m2 * s2) + mass * r * r
        w0 = (y[4 * LANES + i] - c[12 * LANES + i] - (s1 * p2 - s2 * p1)) / inertia
        v1, v2 = -w0 * s2, w0 * s1
        f0 = -g * (m1 * cr - m2 * sr) - par[4 * LANES + i] * w0
        f0 -= v1 * (p2 + mass * v2 + w0 * m1) - v2 * (p1 + mass * v1 - w0 * m2)
        # Pitch: z_body = (-sp, 0, cp).
        s0, s2 = -r * sp, r * cp
        inertia = c[4 * LANES + i] + 2.0 * (m0 * s0 + m2 * s2) + mass * r * r
        w1 = (y[5 * LANES + i] - c[13 * LANES + i] - (s2 * p0 - s0 * p2)) / inertia
        v0, v2 = w1 * s2, -w1 * s0
        f1 = -g * (-m2 * sp - m0 * cp) - par[5 * LANES + i] * w1
        f1 -= v2 * (p0 + mass * v0 + w1 * m2) - v0 * (p2 + mass * v2 - w1 * m0)
        w2 = (y[6 * LANES + i] - c[14 * LANES + i]) / c[5 * LANES + i]
        k[i], k[LANES + i], k[2 * LANES + i], k[3 * LANES + i] = w0, w1, 0.0, 0.0
        k[4 * LANES + i], k[5 * LANES + i] = f0, f1
        k[6 * LANES + i] = -par[6 * LANES + i] * w2
        k[7 * LANES + i] = r * (cp * sy * w0 + cy * w1)
        k[8 * LANES + i] = r * (sy * w1 - cp * cy * w0)
        k[9 * LANES + i] = w2


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _add_slopes(slopes, weights, count, total):  # type: ignore[no-untyped-def]
    """total = sum of weights[j] slopes[j] over j < count, for every lane."""
    for e in range(BLOCK):
        total[e] = 0.0
    for j in range(count):
        a = weights[j]
        if a != 0.0:
            row = slopes[j]
            for e in range(BLOCK):
                total[e] += a * row[e]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _advance(y, total, h, out):  # type: ignore[no-untyped-def]
    """out = y + h total."""
    for s in range(N_STATE):
        for i in range(LANES):
            out[s * LANES + i] = y[s * LANES + i] + h[i] * total[s * LANES + i]


@njit(cache=True, nogil=True, error_model="numpy")
def step(y, table, at, h, par, axis, slopes, total, work, areas):  # type: ignore[no-untyped-def]
    """One step of every lane, in place; adds the integrals of x, y and yaw to areas (3 LANES,).

    Args:
        y: states (BLOCK,): entry s of lane i stands at s LANES + i, here as everywhere.
        table: coefficients (nodes, 15 LANES), `at` the row where this step begins.
        h: step of each lane (LANES,) [s].
        par: parameters (N_PARAMETER LANES,).
        axis: -1 all axes; 0-2 that body axis only; 3 the three single-axis models.
        slopes, total, work: scratch (N_STAGES, BLOCK), (BLOCK,), (BLOCK,).
    """
    for stage in range(N_STAGES):
        _add_slopes(slopes, _A[stage], stage, total)
        _advance(y, total, h, work)
        b = _B[stage]
        if b != 0.0:
            for s in range(3):
                for i in range(LANES):
                    areas[s * LANES + i] += b * h[i] * work[(7 + s) * LANES + i]
        row = table[at + _NODE[stage]]
        if axis < 0:
            _rates(work, row, par, slopes[stage])
        elif axis < DECOUPLED:
            _axis_rates(work, row, par, slopes[stage], axis)
        else:
            _decoupled_rates(work, row, par, slopes[stage])
    _add_slopes(slopes, _B, N_STAGES, total)
    _advance(y, total, h, y)
