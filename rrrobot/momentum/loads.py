"""Signals of a state of the engine that are forces: contact, friction, motors.

The angular acceleration follows from the moment about the pivot, which is linear in it:

    I_P alpha = damping moment - (moment that alpha = 0 would take)
"""

from __future__ import annotations

import numpy as np

from rrrobot.momentum.compiled import compiled, inner
from rrrobot.momentum.forces import sweep
from rrrobot.momentum.kernels import ANY

FRICTION, TORQUE = 1, 4
"""Rows of the signals: first the normal force; then three components of the friction force in the
body's axes; for each leg its torque, for each its rate."""


def n_signals(legs: int) -> int:
    """Number of rows."""
    return TORQUE + 2 * legs


@inner
def solve(matrix, right, out):  # type: ignore[no-untyped-def]
    """Solve a symmetric 3 x 3 system, given as (xx, yy, zz, xy, xz, yz), by its adjugate."""
    xx, yy, zz, xy, xz, yz = matrix[0], matrix[1], matrix[2], matrix[3], matrix[4], matrix[5]
    a00, a01, a02 = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    a11, a12, a22 = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    over = 1.0 / (xx * a00 + xy * a01 + xz * a02)
    out[0] = over * (a00 * right[0] + a01 * right[1] + a02 * right[2])
    out[1] = over * (a01 * right[0] + a11 * right[1] + a12 * right[2])
    out[2] = over * (a02 * right[0] + a12 * right[1] + a22 * right[2])


@inner
def pivot_inertia(c, mass, s, out):  # type: ignore[no-untyped-def]
    """I_P (xx, yy, zz, xy, xz, yz) of coefficients c (15,) about the pivot at -s."""
    whole = 2.0 * (c[0] * s[0] + c[1] * s[1] + c[2] * s[2])
    whole += mass * (s[0] * s[0] + s[1] * s[1] + s[2] * s[2])
    for a in range(3):
        out[a] = c[3 + a] + whole - (2.0 * c[a] + mass * s[a]) * s[a]
    out[3] = c[6] - c[0] * s[1] - s[0] * c[1] - mass * s[0] * s[1]
    out[4] = c[7] - c[0] * s[2] - s[0] * c[2] - mass * s[0] * s[2]
    out[5] = c[8] - c[1] * s[2] - s[1] * c[2] - mass * s[1] * s[2]


@inner
def damping_moment(w, up, parameters, out):  # type: ignore[no-untyped-def]
    """Moment of the damping on the body (3,) in its axes; `parameters` as the kernels take them."""
    if parameters[7] == 0.0:
        for a in range(3):
            out[a] = -parameters[4 + a] * w[a]
        return
    over_cos = 1.0 / np.sqrt(up[1] * up[1] + up[2] * up[2])
    sr, cr, tp = up[1] * over_cos, up[2] * over_cos, -up[0] * over_cos
    about = sr * w[1] + cr * w[2]
    on_roll = -parameters[4] * (w[0] + tp * about)
    on_pitch = -parameters[5] * (cr * w[1] - sr * w[2])
    lever = tp * on_roll - parameters[6] * about * over_cos * over_cos
    out[0], out[1], out[2] = on_roll, sr * lever + cr * on_pitch, cr * lever - sr * on_pitch


@inner
def accelerate(c, axis, s, w, right, mass, out):  # type: ignore[no-untyped-def]
    """Angular acceleration (3,) under a moment about the pivot; guides hold the locked axes.

    Args:
        c: coefficients (15,).
        axis: -1 for all, or the one that is free.
        s: from the pivot to the shell's centre (3,).
        w: scratch (6,).
        right: the moment (3,).
        mass: of the robot.
        out: filled.
    """
    pivot_inertia(c, mass, s, w)
    if axis < 0:
        solve(w, right, out)
        return
    for a in range(3):
        out[a] = right[a] / w[a] if a == axis else 0.0


@compiled()
def loads(tree, motion, c, leg, parameters, axis, b, out):  # type: ignore[no-untyped-def]
    """Signals of one state.

    Args:
        tree, parameters, axis: of the setting.
        motion: z_body and the angular velocity, both in the body's axes (3 each); where axis is
            ANY, then n, s and x_dot.
        c: coefficients (15,).
        leg: angles, rates and accelerations (3, legs).
        b: scratch, see `bodies`.
        out: filled (n_signals,).
    """
    drag, s, alpha, right, work = b.vector[6], b.vector[7], b.vector[8], b.vector[9], b.work
    force, moment = b.force[0], b.moment[0]
    up, w, high = motion[:3], motion[3:6], motion[:3]
    if axis == ANY:
        high, rate = motion[6:9], motion[12:15]
        for a in range(3):
            s[a], alpha[a] = motion[9 + a], 0.0
        # w x (w x s - x_dot); alpha is free until it is solved for.
        for a in range(3):
            d, e = (a + 1) % 3, (a + 2) % 3
            right[a] = w[d] * s[e] - w[e] * s[d] - rate[a]
        for a in range(3):
            d, e = (a + 1) % 3, (a + 2) % 3
            drag[a] = w[d] * right[e] - w[e] * right[d]
    else:
        for a in range(3):
            s[a], alpha[a], drag[a] = parameters[1] * up[a], 0.0, 0.0
    sweep(tree, leg, w, alpha, s, drag, up, parameters[3], b)
    if axis < 0:
        damping_moment(w, up, parameters, right)
    else:
        for a in range(3):
            right[a] = -parameters[4 + a] * w[a]
    for a in range(3):
        d, e = (a + 1) % 3, (a + 2) % 3
        right[a] -= moment[a] + s[d] * force[e] - s[e] * force[d]
    accelerate(c, axis, s, work, right, parameters[0], alpha)
    sweep(tree, leg, w, alpha, s, drag, up, parameters[3], b)
    out[0] = force[0] * high[0] + force[1] * high[1] + force[2] * high[2]
    for a in range(3):
        out[1 + a] = force[a] - out[0] * high[a]
    n_legs = leg.shape[1]
    for k in range(n_legs):
        out[TORQUE + k], out[TORQUE + n_legs + k] = 0.0, leg[1, k]
    for i in range(1, tree.mass.size):
        out[TORQUE + tree.leg[i]] += tree.ratio[i] * _motor(tree, i, b)


@inner
def _motor(tree, i, b):  # type: ignore[no-untyped-def]
    """Torque, or force of a prismatic joint, that moves body i and all that it carries."""
    torque = 0.0
    for a in range(3):
        d, e = (a + 1) % 3, (a + 2) % 3
        if tree.prismatic[i]:
            torque += b.axis[i, a] * b.force[i, a]
        else:
            own = b.origin[i, d] * b.force[i, e] - b.origin[i, e] * b.force[i, d]
            torque += b.axis[i, a] * (b.moment[i, a] - own)
    return torque
