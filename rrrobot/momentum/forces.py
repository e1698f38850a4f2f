"""Contact force and motor torques at a state of a prescribed gait, compiled, for many gaits.

Recursive Newton-Euler over the engine's tree of bodies, in the body's axes about a point C of
it, the shell's centre or the base's origin. With s the vector from the pivot to C, up = R^T z and
alpha = w_dot,

    a_C = alpha x s + w x (w x s - x_dot)            the second part is zero of a sphere on a plane
    f_i = m_i (a_i + g up),    n_i = I_i alpha_i + w_i x I_i w_i
    sum of (s + c_i) x f_i + n_i = damping moment    gives alpha

The left side is linear in alpha with the matrix I_P, so two sweeps over the bodies suffice: one
with alpha = 0 for the right side, one for the forces. The contact force is the sum of all f_i, a
motor's torque the moment about its joint's axis of all that the joint carries.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.momentum.compiled import inner


class Bodies(NamedTuple):
    """Scratch of a sweep, one row a body; vectors in the base's axes."""

    rotation: Array
    """(n, 3, 3)"""
    origin: Array
    """of the body's joint, from C (n, 3) [m]"""
    axis: Array
    """of the joint (n, 3)"""
    omega: Array
    """angular velocity (n, 3) [rad/s]"""
    alpha: Array
    """angular acceleration (n, 3) [rad/s^2]"""
    acceleration: Array
    """of the origin (n, 3) [m/s^2]"""
    force: Array
    """on the body and all that it carries (n, 3) [N]"""
    moment: Array
    """of that about C (n, 3) [N m]"""
    vector: Array
    """for what lives within one function only (10, 3); the last four are the caller's"""
    work: Array
    """likewise (6,)"""


def bodies(n: int) -> Bodies:
    """Scratch for a tree of n bodies."""
    rows = [np.zeros((n, 3)) for _ in range(7)]
    origin, axis, omega, alpha, acceleration, force, moment = rows
    return Bodies(
        np.zeros((n, 3, 3)), origin, axis, omega, alpha, acceleration, force, moment,
        np.zeros((10, 3)), np.zeros(6),
    )  # fmt: skip


@inner
def _cross(a, b, out):  # type: ignore[no-untyped-def]
    """out = a x b; out is neither a nor b."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@inner
def _add_cross(a, b, out, scale):  # type: ignore[no-untyped-def]
    """Add scale a x b to out; out is neither a nor b."""
    out[0] += scale * (a[1] * b[2] - a[2] * b[1])
    out[1] += scale * (a[2] * b[0] - a[0] * b[2])
    out[2] += scale * (a[0] * b[1] - a[1] * b[0])


@inner
def sweep(tree, leg, w, alpha, s, drag, up, gravity, b):  # type: ignore[no-untyped-def]
    """Fill the scratch b for legs (3, legs): angles, rates, accelerations.

    `drag` is w x (w x s - x_dot).
    """
    n = tree.mass.size
    for a in range(3):
        for e in range(3):
            b.rotation[0, a, e] = tree.rotation[0, a, e]
        b.origin[0, a], b.omega[0, a], b.alpha[0, a] = tree.translation[0, a], w[a], alpha[a]
    turning = b.vector[0]
    _cross(alpha, s, b.acceleration[0])
    for a in range(3):
        b.acceleration[0, a] += drag[a]
    _cross(w, b.origin[0], turning)
    _add_cross(w, turning, b.acceleration[0], 1.0)
    _add_cross(alpha, b.origin[0], b.acceleration[0], 1.0)
    _load(tree, 0, b, up, gravity)
    for i in range(1, n):
        _place(tree, i, leg, b)
        _accelerate(tree, i, leg, b)
        _load(tree, i, b, up, gravity)
    for i in range(n - 1, 0, -1):
        p = tree.parent[i]
        for a in range(3):
            b.force[p, a] += b.force[i, a]
            b.moment[p, a] += b.moment[i, a]


@inner
def _place(tree, i, leg, b):  # type: ignore[no-untyped-def]
    """Rotation, axis and origin of body i."""
    p, q = tree.parent[i], tree.ratio[i] * leg[0, tree.leg[i]] + tree.shift[i]
    x, y, z = tree.axis[i, 0], tree.axis[i, 1], tree.axis[i, 2]
    t = tree.translation[i]
    prismatic = tree.prismatic[i]
    c, s = (1.0, 0.0) if prismatic else (np.cos(q), np.sin(q))
    for a in range(3):
        r0, r1, r2 = b.rotation[p, a, 0], b.rotation[p, a, 1], b.rotation[p, a, 2]
        turn = tree.rotation[i]
        t0 = r0 * turn[0, 0] + r1 * turn[1, 0] + r2 * turn[2, 0]
        t1 = r0 * turn[0, 1] + r1 * turn[1, 1] + r2 * turn[2, 1]
        t2 = r0 * turn[0, 2] + r1 * turn[1, 2] + r2 * turn[2, 2]
        along = t0 * x + t1 * y + t2 * z
        b.axis[i, a] = along
        # Rodrigues' formula.
        d = (1.0 - c) * along
        b.rotation[i, a, 0] = c * t0 + d * x + s * (t1 * z - t2 * y)
        b.rotation[i, a, 1] = c * t1 + d * y + s * (t2 * x - t0 * z)
        b.rotation[i, a, 2] = c * t2 + d * z + s * (t0 * y - t1 * x)
        b.origin[i, a] = b.origin[p, a] + r0 * t[0] + r1 * t[1] + r2 * t[2]
        if prismatic:
            b.origin[i, a] += q * along


@inner
def _accelerate(tree, i, leg, b):  # type: ignore[no-untyped-def]
    """Velocities and accelerations of body i, carried by its parent and moved by its joint."""
    p, lever, turning = tree.parent[i], b.vector[0], b.vector[1]
    k, ratio = tree.leg[i], tree.ratio[i]
    rate, acceleration = ratio * leg[1, k], ratio * leg[2, k]
    axis, w, alpha, a_origin = b.axis[i], b.omega[i], b.alpha[i], b.acceleration[i]
    for a in range(3):
        lever[a] = b.origin[i, a] - b.origin[p, a]
        w[a], alpha[a], a_origin[a] = b.omega[p, a], b.alpha[p, a], b.acceleration[p, a]
    carried = b.omega[p]
    _cross(carried, lever, turning)
    _add_cross(carried, turning, a_origin, 1.0)
    _add_cross(b.alpha[p], lever, a_origin, 1.0)
    if tree.prismatic[i]:
        _add_cross(carried, axis, a_origin, 2.0 * rate)
        for a in range(3):
            a_origin[a] += acceleration * axis[a]
    else:
        _add_cross(carried, axis, alpha, rate)
        for a in range(3):
            w[a] += rate * axis[a]
            alpha[a] += acceleration * axis[a]


@inner
def _load(tree, i, b, up, gravity):  # type: ignore[no-untyped-def]
    """Force and moment about C that move body i."""
    arm, turning, centre, force = b.vector[0], b.vector[1], b.vector[2], b.force[i]
    r, lever, w, mass = b.rotation[i], tree.lever[i], b.omega[i], tree.mass[i]
    for a in range(3):
        arm[a] = r[a, 0] * lever[0] + r[a, 1] * lever[1] + r[a, 2] * lever[2]
        force[a] = b.acceleration[i, a] + gravity * up[a]
        centre[a] = b.origin[i, a] + arm[a]
    _cross(w, arm, turning)
    _add_cross(w, turning, force, 1.0)
    _add_cross(b.alpha[i], arm, force, 1.0)
    for a in range(3):
        force[a] *= mass
    _cross(centre, force, b.moment[i])
    if not tree.point[i]:
        _add_rotation(tree.inertia[i], r, w, b.alpha[i], b.moment[i], b.vector)


@inner
def _add_rotation(inertia, r, w, alpha, moment, vector):  # type: ignore[no-untyped-def]
    """Add I alpha + w x I w; `inertia` is about the mass centre in the link's own axes."""
    own, turned = vector[3], vector[4]
    for source, twice in ((alpha, False), (w, True)):
        for d in range(3):
            own[d] = r[0, d] * source[0] + r[1, d] * source[1] + r[2, d] * source[2]
        for a in range(3):
            turned[a] = 0.0
        for d in range(3):
            spin = inertia[d, 0] * own[0] + inertia[d, 1] * own[1] + inertia[d, 2] * own[2]
            for a in range(3):
                turned[a] += r[a, d] * spin
        if twice:
            _add_cross(w, turned, moment, 1.0)
        else:
            for a in range(3):
                moment[a] += turned[a]
