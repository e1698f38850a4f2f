"""How the legs enter: fifteen numbers, functions of (phi, phi_dot), for any tree of joints.

About one point of the base, in its axes, with the sums over all bodies of the robot and u their
velocities relative to the base,

    mc    = sum of m c                      first moment of mass (3)
    I     = sum of the inertias             (xx, yy, zz, xy, xz, yz)
    p_rel = sum of m u                      linear momentum relative to the base (3)
    L_rel = sum of I_c omega + m c x u      angular momentum relative to the base (3)

They are what `pin.crba` holds: with B = M[:6, :6], mc = (-B[2,4], -B[0,5], -B[1,3]), I = B[3:, 3:],
(p_rel, L_rel) = M[:6, 6:] phi_dot. Here they are computed for many leg states at once.

What a body adds that turns on the base and carries no other is a sum of second harmonics of its
joint's angle a, times a's rate in p_rel and L_rel: five factors of 1, cos a, sin a, cos 2a, sin 2a
for each number, taken once from sixteen angles. Those that are not zero are added four at a time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.momentum.compiled import borrowed, compiled, inner, lanes
from rrrobot.momentum.tree import Tree, tree_of
from rrrobot.momentum.trigonometry import sine_cosine
from rrrobot.robot.robot import Robot

LANES = 16
"""Leg states, and gaits, that are worked on side by side, so that the compiler uses vectors."""
N_COEFFICIENTS = 15
_MOVING = 9
"""Where the numbers begin that are proportional to the joints' rates."""
_WAVES = 9
N_PLACEMENT = 18
"""Numbers that place a body: rotation (9), position, angular velocity and velocity (3 each)."""


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


class LaneWork(NamedTuple):
    """Room for some rows of LANES leg states of a tree each."""

    angle: Array
    """(legs, rows LANES) [rad or m]"""
    rate: Array
    """(legs, rows LANES) [rad/s or m/s]"""
    bodies: Array
    """placement of each body, then one joint's motion (n + 1, N_PLACEMENT LANES)"""
    base: Array
    """the part of the coefficients that is the same for all (15 LANES,)"""
    swinging: NDArray[np.bool_]
    """whether a body turns on the base and carries no other (n,)"""
    waves: Array
    """of each such body cos, sin, cos 2 and sin 2 of its joint's angle, its rate, and these times
    its rate (9 n, rows LANES)"""
    first: NDArray[np.int64]
    """where in the following those of each of the fifteen numbers begin, and the last end (16,)"""
    term: NDArray[np.int64]
    """which four rows of the waves are added (m, 4)"""
    weight: Array
    """their factors (m, 4)"""


def lane_work(tree: Tree, rows: int = 1) -> LaneWork:
    """Room for rows of LANES leg states of a tree, with what the base contributes."""
    legs, n = int(tree.leg.max(initial=-1)) + 1, tree.mass.size
    places = np.zeros((n + 1, N_PLACEMENT, LANES))
    places[0, :9], places[0, 9:12] = tree.rotation[0].reshape(9, 1), tree.translation[0][:, None]
    turns = (tree.parent == 0) & ~tree.prismatic & ~np.isin(np.arange(n), tree.parent[1:])
    turns[0] = False
    bodies, base = places.reshape(n + 1, -1), np.zeros(N_COEFFICIENTS * LANES)
    _add_body(tree, 0, bodies, base)
    swings = np.zeros((N_COEFFICIENTS, n, _WAVES))
    for i in np.flatnonzero(turns):
        factors = _swing_of(tree, int(i), bodies)
        base[: _MOVING * LANES] += np.repeat(factors[:_MOVING, 0], LANES)
        swings[:_MOVING, i, :4] = factors[:_MOVING, 1:]
        swings[_MOVING:, i, 4:] = factors[_MOVING:]
    width = rows * LANES
    return LaneWork(
        np.zeros((legs, width)), np.zeros((legs, width)), bodies, base, turns,
        np.zeros((_WAVES * n, width)), *_in_fours(swings.reshape(N_COEFFICIENTS, -1)),
    )  # fmt: skip


def _in_fours(factors: Array) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Terms that are not zero of rows (15, terms), as `LaneWork` has them."""
    first, term, weight = [0], [], []
    for row in factors:
        used = np.flatnonzero(row)
        for k in range(0, used.size, 4):
            # What fills four up has weight zero.
            some = np.resize(used[k : k + 4], 4)
            term.append(some)
            weight.append(np.where(np.arange(4) < used.size - k, row[some], 0.0))
        first.append(len(term))
    shape = (len(term), 4)
    return (
        np.array(first, dtype=np.int64), np.array(term, dtype=np.int64).reshape(shape),
        np.array(weight, dtype=float).reshape(shape),
    )  # fmt: skip


def _swing_of(tree: Tree, i: int, bodies: Array) -> Array:
    """Factors of what body i adds (15, 5), its joint turning at 1 rad/s."""
    turn = 2 * np.pi / LANES * np.arange(LANES)
    values = np.zeros(N_COEFFICIENTS * LANES)
    angle, rate = (turn - tree.shift[i]) / tree.ratio[i], np.full(LANES, 1 / tree.ratio[i])
    _add_turned(tree, i, angle, rate, bodies, values)
    rows = values.reshape(-1, LANES)
    waves = np.array((0.5 + 0 * turn, *(f(k * turn) for k in (1, 2) for f in (np.cos, np.sin))))
    factors = 2 / LANES * rows @ waves.T
    for first, last in ((0, 3), (3, 9), (9, 12), (12, 15)):
        # What is zero by symmetry stays so.
        some = factors[first:last]
        some[np.abs(some) < 1e-15 * np.abs(rows[first:last]).max()] = 0.0
    return factors


def fill(tree: Tree, angle: Array, rate: Array, out: Array) -> None:
    """Write the coefficients of leg states (n, legs) into out (n, 15)."""
    _fill(tree, angle, rate, lane_work(tree), np.empty((1, N_COEFFICIENTS * LANES)), out)


@compiled()
def _fill(tree, angle, rate, work, row, out):  # type: ignore[no-untyped-def]
    tree, work, row = borrowed(tree), borrowed(work), borrowed(row)
    n, legs = angle.shape
    for first in range(0, n, LANES):
        last = min(first + LANES, n)
        for k in range(first, last):
            for leg in range(legs):
                work.angle[leg, k - first] = angle[k, leg]
                work.rate[leg, k - first] = rate[k, leg]
        fill_lanes(tree, work, row, 0)
        for k in range(first, last):
            for c in range(N_COEFFICIENTS):
                out[k, c] = row[0, c * LANES + k - first]


@inner
def fill_lanes(tree, work, table, at):  # type: ignore[no-untyped-def]
    """Coefficients of rows of LANES leg states side by side; nothing in one depends on another.

    Args:
        tree: the robot.
        work: see `LaneWork`; angle and rate are given.
        table: entry c of lane i in row r goes to [at + r, c LANES + i].
    """
    for i in range(1, tree.mass.size):
        if work.swinging[i]:
            leg = tree.leg[i]
            _turn(tree.ratio[i], tree.shift[i], work.angle[leg], work.rate[leg], work.waves, i)
    _add_waves(work.base, work.first, work.term, work.weight, work.waves, table, at)
    # Bodies that carry others, or slide, come after; swinging ones carry none.
    for r in range(work.angle.shape[1] // LANES):
        here, out = slice(r * LANES, (r + 1) * LANES), table[at + r]
        for i in range(1, tree.mass.size):
            leg = tree.leg[i]
            if not work.swinging[i]:
                move_lanes(tree, i, work.angle[leg][here], work.rate[leg][here], work.bodies)
                _add_body(tree, i, work.bodies, out)


@lanes
def _turn(ratio, shift, angle, rate, waves, i):  # type: ignore[no-untyped-def]
    """Waves of body i that turns on the base, in every lane."""
    first = _WAVES * i
    cosine, sine, cosine2, sine2 = (
        waves[first],
        waves[first + 1],
        waves[first + 2],
        waves[first + 3],
    )
    turning, cosine_t, sine_t, cosine2_t, sine2_t = (
        waves[first + 4], waves[first + 5], waves[first + 6], waves[first + 7], waves[first + 8],
    )  # fmt: skip
    for k in range(len(angle)):
        s, c = sine_cosine(ratio * angle[k] + shift)
        s2, c2, w = 2.0 * s * c, c * c - s * s, ratio * rate[k]
        cosine[k], sine[k], cosine2[k], sine2[k] = c, s, c2, s2
        turning[k], cosine_t[k], sine_t[k], cosine2_t[k], sine2_t[k] = (
            w,
            w * c,
            w * s,
            w * c2,
            w * s2,
        )


@lanes
def _add_waves(base, first, term, weight, waves, table, at):  # type: ignore[no-untyped-def]
    """What is the same for all, and what all bodies add that turn on the base, in every lane."""
    # Of a number of lanes that the compiler is not told, it makes vector code; else it unrolls all.
    lanes = len(base) // N_COEFFICIENTS
    rows = waves.shape[1] // lanes
    for n in range(N_COEFFICIENTS):
        if first[n] == first[n + 1]:
            for r in range(rows):
                for k in range(lanes):
                    table[at + r, n * LANES + k] = base[n * LANES + k]
        for m in range(first[n], first[n + 1]):
            a, b, c, d = waves[term[m, 0]], waves[term[m, 1]], waves[term[m, 2]], waves[term[m, 3]]
            e, f, g, h = weight[m, 0], weight[m, 1], weight[m, 2], weight[m, 3]
            for r in range(rows):
                out, here = table[at + r], r * LANES
                before = base if m == first[n] else out
                for k in range(lanes):
                    sums = (e * a[here + k] + f * b[here + k]) + (g * c[here + k] + h * d[here + k])
                    out[n * LANES + k] = before[n * LANES + k] + sums


@compiled()
def _add_turned(tree, i, angle, rate, bodies, out):  # type: ignore[no-untyped-def]
    move_lanes(tree, i, angle, rate, bodies)
    _add_body(tree, i, bodies, out)


@lanes
def move_lanes(tree, i, angle, rate, work):  # type: ignore[no-untyped-def]
    """Placement and relative velocity of body i after its joint's motion."""
    joint, parent, own = work[tree.mass.size], work[tree.parent[i]], work[i]
    ratio, shift = tree.ratio[i], tree.shift[i]
    # cos, sin, sliding, turning rate and sliding rate of the joint.
    if tree.prismatic[i]:
        for k in range(LANES):
            joint[k], joint[LANES + k] = 1.0, 0.0
            joint[2 * LANES + k] = ratio * angle[k] + shift
            joint[3 * LANES + k], joint[4 * LANES + k] = 0.0, ratio * rate[k]
    else:
        for k in range(LANES):
            joint[LANES + k], joint[k] = sine_cosine(ratio * angle[k] + shift)
            joint[2 * LANES + k] = 0.0
            joint[3 * LANES + k], joint[4 * LANES + k] = ratio * rate[k], 0.0
    x, y, z = tree.axis[i, 0], tree.axis[i, 1], tree.axis[i, 2]
    f00, f01, f02 = tree.rotation[i, 0, 0], tree.rotation[i, 0, 1], tree.rotation[i, 0, 2]
    f10, f11, f12 = tree.rotation[i, 1, 0], tree.rotation[i, 1, 1], tree.rotation[i, 1, 2]
    f20, f21, f22 = tree.rotation[i, 2, 0], tree.rotation[i, 2, 1], tree.rotation[i, 2, 2]
    s0, s1, s2 = tree.translation[i, 0], tree.translation[i, 1], tree.translation[i, 2]
    for a in range(3):
        # Row a of the rotation, entry a of the vectors.
        r0, r1, r2 = 3 * a * LANES, (3 * a + 1) * LANES, (3 * a + 2) * LANES
        at, spin = (9 + a) * LANES, (12 + a) * LANES
        for k in range(LANES):
            p0, p1, p2 = parent[r0 + k], parent[r1 + k], parent[r2 + k]
            # (Parent's rotation)(joint's fixed rotation).
            t0 = p0 * f00 + p1 * f10 + p2 * f20
            t1 = p0 * f01 + p1 * f11 + p2 * f21
            t2 = p0 * f02 + p1 * f12 + p2 * f22
            along = t0 * x + t1 * y + t2 * z
            # Rodrigues' formula.
            c, s = joint[k], joint[LANES + k]
            d = (1.0 - c) * along
            own[r0 + k] = c * t0 + d * x + s * (t1 * z - t2 * y)
            own[r1 + k] = c * t1 + d * y + s * (t2 * x - t0 * z)
            own[r2 + k] = c * t2 + d * z + s * (t0 * y - t1 * x)
            lever = p0 * s0 + p1 * s1 + p2 * s2
            own[at + k] = parent[at + k] + lever + joint[2 * LANES + k] * along
            own[spin + k] = parent[spin + k] + joint[3 * LANES + k] * along
            # The slide's own part of the velocity; the parent's follows.
            own[(15 + a) * LANES + k] = joint[4 * LANES + k] * along
    for k in range(LANES):
        dx = own[9 * LANES + k] - parent[9 * LANES + k]
        dy = own[10 * LANES + k] - parent[10 * LANES + k]
        dz = own[11 * LANES + k] - parent[11 * LANES + k]
        w0, w1, w2 = parent[12 * LANES + k], parent[13 * LANES + k], parent[14 * LANES + k]
        own[15 * LANES + k] += parent[15 * LANES + k] + (w1 * dz - w2 * dy)
        own[16 * LANES + k] += parent[16 * LANES + k] + (w2 * dx - w0 * dz)
        own[17 * LANES + k] += parent[17 * LANES + k] + (w0 * dy - w1 * dx)


@compiled(fastmath={"contract", "nsz"})
def _add_body(tree, i, work, out):  # type: ignore[no-untyped-def]
    """Add body i's mass, inertia and momentum in every lane."""
    own = work[i]
    m = tree.mass[i]
    l0, l1, l2 = tree.lever[i, 0], tree.lever[i, 1], tree.lever[i, 2]
    for k in range(LANES):
        d0 = own[k] * l0 + own[LANES + k] * l1 + own[2 * LANES + k] * l2
        d1 = own[3 * LANES + k] * l0 + own[4 * LANES + k] * l1 + own[5 * LANES + k] * l2
        d2 = own[6 * LANES + k] * l0 + own[7 * LANES + k] * l1 + own[8 * LANES + k] * l2
        c0, c1, c2 = own[9 * LANES + k] + d0, own[10 * LANES + k] + d1, own[11 * LANES + k] + d2
        w0, w1, w2 = own[12 * LANES + k], own[13 * LANES + k], own[14 * LANES + k]
        p0 = m * (own[15 * LANES + k] + w1 * d2 - w2 * d1)
        p1 = m * (own[16 * LANES + k] + w2 * d0 - w0 * d2)
        p2 = m * (own[17 * LANES + k] + w0 * d1 - w1 * d0)
        out[k] += m * c0
        out[LANES + k] += m * c1
        out[2 * LANES + k] += m * c2
        out[3 * LANES + k] += m * (c1 * c1 + c2 * c2)
        out[4 * LANES + k] += m * (c0 * c0 + c2 * c2)
        out[5 * LANES + k] += m * (c0 * c0 + c1 * c1)
        out[6 * LANES + k] -= m * c0 * c1
        out[7 * LANES + k] -= m * c0 * c2
        out[8 * LANES + k] -= m * c1 * c2
        out[9 * LANES + k] += p0
        out[10 * LANES + k] += p1
        out[11 * LANES + k] += p2
        out[12 * LANES + k] += c1 * p2 - c2 * p1
        out[13 * LANES + k] += c2 * p0 - c0 * p2
        out[14 * LANES + k] += c0 * p1 - c1 * p0
    if tree.point[i]:
        return
    for d in range(3):
        for e in range(3):
            # One product of inertia j e_d e_e^T, turned into the base's axes.
            j = tree.inertia[i, d, e]
            for k in range(LANES):
                a0, a1, a2 = own[d * LANES + k], own[(3 + d) * LANES + k], own[(6 + d) * LANES + k]
                b0, b1, b2 = own[e * LANES + k], own[(3 + e) * LANES + k], own[(6 + e) * LANES + k]
                a0, a1, a2 = j * a0, j * a1, j * a2
                turning = b0 * own[12 * LANES + k] + b1 * own[13 * LANES + k]
                turning += b2 * own[14 * LANES + k]
                out[3 * LANES + k] += a0 * b0
                out[4 * LANES + k] += a1 * b1
                out[5 * LANES + k] += a2 * b2
                out[6 * LANES + k] += a0 * b1
                out[7 * LANES + k] += a0 * b2
                out[8 * LANES + k] += a1 * b2
                out[12 * LANES + k] += a0 * turning
                out[13 * LANES + k] += a1 * turning
                out[14 * LANES + k] += a2 * turning
