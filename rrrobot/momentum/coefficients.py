"""How the legs enter: fifteen numbers, functions of (phi, phi_dot), for any tree of joints.

About the shell's centre, in the base's axes, with the sums over all bodies of the robot and u their
velocities relative to the base,

    mc    = sum of m c                      first moment of mass (3)
    I     = sum of the inertias             (xx, yy, zz, xy, xz, yz)
    p_rel = sum of m u                      linear momentum relative to the base (3)
    L_rel = sum of I_c omega + m c x u      angular momentum relative to the base (3)

They are what `pin.crba` holds: with B = M[:6, :6], mc = (-B[2,4], -B[0,5], -B[1,3]), I = B[3:, 3:],
(p_rel, L_rel) = M[:6, 6:] phi_dot. Here they are computed for many leg states at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numba import njit
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.robot import Robot

N_COEFFICIENTS = 15


class Tree(NamedTuple):
    """A robot's joints and bodies as plain arrays; row 0 is the base."""

    parent: NDArray[np.int64]
    """row of the parent body (n,)"""
    rotation: Array
    """of the joint's frame in its parent's (n, 3, 3)"""
    translation: Array
    """(n, 3) [m]"""
    axis: Array
    """unit axis in the joint's frame (n, 3)"""
    prismatic: NDArray[np.bool_]
    """(n,)"""
    leg: NDArray[np.int64]
    """which leg coordinate moves the joint (n,); -1 for the base"""
    mass: Array
    """(n,) [kg]"""
    lever: Array
    """centre of mass in the body's frame (n, 3) [m]"""
    inertia: Array
    """about the centre of mass (n, 3, 3) [kg m^2]"""
    point: NDArray[np.bool_]
    """whether that is zero (n,)"""


def tree_of(robot: Robot) -> Tree:
    """Arrays of a robot's Pinocchio model; positions are relative to the shell's centre."""
    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model), np.zeros(model.nv))
    n = model.njoints - 1
    tree = Tree(
        np.zeros(n, dtype=np.int64),
        np.tile(np.eye(3), (n, 1, 1)),
        np.zeros((n, 3)),
        np.zeros((n, 3)),
        np.zeros(n, dtype=np.bool_),
        np.full(n, -1, dtype=np.int64),
        np.zeros(n),
        np.zeros((n, 3)),
        np.zeros((n, 3, 3)),
        np.zeros(n, dtype=np.bool_),
    )
    for i in range(n):
        joint = i + 1
        body = model.inertias[joint]
        tree.mass[i], tree.lever[i], tree.inertia[i] = body.mass, body.lever, body.inertia
        tree.point[i] = not np.any(tree.inertia[i])
        if i == 0:
            tree.translation[0] = -robot.shell_placement.translation
            continue
        placement = model.jointPlacements[joint]
        tree.parent[i] = model.parents[joint] - 1
        tree.rotation[i], tree.translation[i] = placement.rotation, placement.translation
        subspace = np.asarray(data.joints[joint].S).reshape(6)
        tree.prismatic[i] = np.any(subspace[:3] != 0)
        tree.axis[i] = subspace[:3] if tree.prismatic[i] else subspace[3:]
        tree.leg[i] = robot.legs.index(model.names[joint])
    return tree


def coefficients(robot: Robot, leg_angle: Array, leg_rate: Array) -> Array:
    """The fifteen numbers (mc, I, p_rel, L_rel) for many leg states (n, 15), SI units.

    Args:
        robot: any robot.
        leg_angle: (n, legs) [rad or m].
        leg_rate: (n, legs) [rad/s or m/s].

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> from rrrobot.momentum.coefficients import coefficients
        >>> up = np.full((1, 2), np.pi / 2)
        >>> coefficients(rr.Robot.from_parameters(), up, 0 * up)[0, 2].round(6)
        np.float64(-0.0246)
    """
    out = np.empty((len(leg_angle), N_COEFFICIENTS))
    fill(tree_of(robot), np.ascontiguousarray(leg_angle), np.ascontiguousarray(leg_rate), out)
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def fill(tree, angle, rate, out):  # type: ignore[no-untyped-def]
    """Write the coefficients of leg states (n, legs) into out (n, 15)."""
    n = tree.mass.size
    rot, pos = np.empty((n, 3, 3)), np.empty((n, 3))
    omega, vel = np.empty((n, 3)), np.empty((n, 3))
    turn = np.empty((3, 3))
    rot[0], pos[0], omega[0], vel[0] = tree.rotation[0], tree.translation[0], 0.0, 0.0
    # The base's own part is the same for all.
    base = np.zeros((1, N_COEFFICIENTS))
    _add_body(tree, 0, rot, pos, omega, vel, base, 0)
    for k in range(angle.shape[0]):
        for c in range(N_COEFFICIENTS):
            out[k, c] = base[0, c]
        for i in range(1, n):
            leg = tree.leg[i]
            _move(tree, i, angle[k, leg], rate[k, leg], rot, pos, omega, vel, turn)
            _add_body(tree, i, rot, pos, omega, vel, out, k)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _move(tree, i, q, dq, rot, pos, omega, vel, turn):  # type: ignore[no-untyped-def]
    """Placement and relative velocity of body i after its joint's motion."""
    p = tree.parent[i]
    x, y, z = tree.axis[i, 0], tree.axis[i, 1], tree.axis[i, 2]
    if p == 0:
        # The base has its own axes and no velocity relative to itself.
        for a in range(3):
            pos[i, a] = pos[0, a] + tree.translation[i, a]
            for b in range(3):
                turn[a, b] = tree.rotation[i, a, b]
    else:
        for a in range(3):
            # Row a of (parent's rotation)(joint's fixed rotation).
            r0, r1, r2 = rot[p, a, 0], rot[p, a, 1], rot[p, a, 2]
            for b in range(3):
                turn[a, b] = (
                    r0 * tree.rotation[i, 0, b]
                    + r1 * tree.rotation[i, 1, b]
                    + r2 * tree.rotation[i, 2, b]
                )
            pos[i, a] = (
                pos[p, a]
                + r0 * tree.translation[i, 0]
                + r1 * tree.translation[i, 1]
                + r2 * tree.translation[i, 2]
            )
    if tree.prismatic[i]:
        for a in range(3):
            pos[i, a] += q * (turn[a, 0] * x + turn[a, 1] * y + turn[a, 2] * z)
            rot[i, a, 0], rot[i, a, 1], rot[i, a, 2] = turn[a, 0], turn[a, 1], turn[a, 2]
    else:
        # Rodrigues' formula.
        c, s = np.cos(q), np.sin(q)
        d = 1.0 - c
        for a in range(3):
            t0, t1, t2 = turn[a, 0], turn[a, 1], turn[a, 2]
            along = d * (t0 * x + t1 * y + t2 * z)
            rot[i, a, 0] = c * t0 + along * x + s * (t1 * z - t2 * y)
            rot[i, a, 1] = c * t1 + along * y + s * (t2 * x - t0 * z)
            rot[i, a, 2] = c * t2 + along * z + s * (t0 * y - t1 * x)
    if p == 0:
        vel[i, 0], vel[i, 1], vel[i, 2] = 0.0, 0.0, 0.0
    else:
        dx, dy, dz = pos[i, 0] - pos[p, 0], pos[i, 1] - pos[p, 1], pos[i, 2] - pos[p, 2]
        w0, w1, w2 = omega[p, 0], omega[p, 1], omega[p, 2]
        vel[i, 0] = vel[p, 0] + w1 * dz - w2 * dy
        vel[i, 1] = vel[p, 1] + w2 * dx - w0 * dz
        vel[i, 2] = vel[p, 2] + w0 * dy - w1 * dx
    for a in range(3):
        along = dq * (turn[a, 0] * x + turn[a, 1] * y + turn[a, 2] * z)
        omega[i, a] = omega[p, a]
        if tree.prismatic[i]:
            vel[i, a] += along
        else:
            omega[i, a] += along


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _add_body(tree, i, rot, pos, omega, vel, out, k):  # type: ignore[no-untyped-def]
    """Add body i's mass, inertia and momentum to row k."""
    m = tree.mass[i]
    l0, l1, l2 = tree.lever[i, 0], tree.lever[i, 1], tree.lever[i, 2]
    d0 = rot[i, 0, 0] * l0 + rot[i, 0, 1] * l1 + rot[i, 0, 2] * l2
    d1 = rot[i, 1, 0] * l0 + rot[i, 1, 1] * l1 + rot[i, 1, 2] * l2
    d2 = rot[i, 2, 0] * l0 + rot[i, 2, 1] * l1 + rot[i, 2, 2] * l2
    c0, c1, c2 = pos[i, 0] + d0, pos[i, 1] + d1, pos[i, 2] + d2
    w0, w1, w2 = omega[i, 0], omega[i, 1], omega[i, 2]
    p0 = m * (vel[i, 0] + w1 * d2 - w2 * d1)
    p1 = m * (vel[i, 1] + w2 * d0 - w0 * d2)
    p2 = m * (vel[i, 2] + w0 * d1 - w1 * d0)
    out[k, 0] += m * c0
    out[k, 1] += m * c1
    out[k, 2] += m * c2
    out[k, 3] += m * (c1 * c1 + c2 * c2)
    out[k, 4] += m * (c0 * c0 + c2 * c2)
    out[k, 5] += m * (c0 * c0 + c1 * c1)
    out[k, 6] -= m * c0 * c1
    out[k, 7] -= m * c0 * c2
    out[k, 8] -= m * c1 * c2
    out[k, 9] += p0
    out[k, 10] += p1
    out[k, 11] += p2
    out[k, 12] += c1 * p2 - c2 * p1
    out[k, 13] += c2 * p0 - c0 * p2
    out[k, 14] += c0 * p1 - c1 * p0
    if not tree.point[i]:
        for d in range(3):
            for e in range(3):
                # One product of inertia j_de e_d e_e^T, turned into the base's axes.
                j = tree.inertia[i, d, e]
                a0, a1, a2 = j * rot[i, 0, d], j * rot[i, 1, d], j * rot[i, 2, d]
                b0, b1, b2 = rot[i, 0, e], rot[i, 1, e], rot[i, 2, e]
                out[k, 3] += a0 * b0
                out[k, 4] += a1 * b1
                out[k, 5] += a2 * b2
                out[k, 6] += a0 * b1
                out[k, 7] += a0 * b2
                out[k, 8] += a1 * b2
                turning = b0 * w0 + b1 * w1 + b2 * w2
                out[k, 12] += a0 * turning
                out[k, 13] += a1 * turning
                out[k, 14] += a2 * turning
