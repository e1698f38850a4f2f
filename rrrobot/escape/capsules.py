"""Links as capsules: their heights above the ground and distances through many gaits at once.

A capsule is the set of points within a radius of a segment. With the ground's unit normal n at the
contact P and s from P to the base's origin, all in the base's axes, a point p of the base is

    n.(p + s)   above a plane,      |p + s + n/k| - 1/k   above a boulder of curvature k

and (1/|k| - |p + s + n/k|) above a bowl. Distances of two capsules are those of their segments less
both radii. Both are bounds for the links that the capsules enclose, and cheap; what is shown is
confirmed with the links' own shapes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.momentum.tree import Tree

_TINY = 1e-30


class Capsules(NamedTuple):
    """Capsules on the bodies of a tree."""

    body: NDArray[np.int64]
    """row of the tree (m,); 0 is the base"""
    ends: Array
    """of the segments, in the body's frame (m, 2, 3) [m]"""
    radius: Array
    """(m,) [m]"""
    limb: NDArray[np.int64]
    """which limb it belongs to (m,); the number of limbs for the base"""
    pairs: NDArray[np.int64]
    """rows of those that may meet (k, 2)"""
    extra: Array
    """by which the links of each pair are farther apart than their capsules (k,) [m]"""


def clearances(
    tree: Tree, capsules: Capsules, limbs: int, angle: Array, normal: Array, s: Array, k: float
) -> tuple[Array, Array]:
    """Least heights of each limb and of the base (n, limbs + 1), least separations (n,) [m].

    Infinite where there is nothing. Holds no interpreter lock while it computes.

    Args:
        tree: the robot; the base's origin is where it says.
        capsules: of its links.
        limbs: how many.
        angle: of the legs at instants (n, instants, legs) [rad or m].
        normal, s: in the base's axes (n, instants, 3).
        k: curvature of the ground [1/m]; 0 for a plane.
    """
    n = len(angle)
    height, apart = np.full((n, limbs + 1), np.inf), np.full(n, np.inf)
    _clearances(
        tree.parent, tree.rotation, tree.translation, tree.axis, tree.prismatic, tree.leg,
        tree.ratio, tree.shift, np.ascontiguousarray(angle), np.ascontiguousarray(normal),
        np.ascontiguousarray(s), k, *capsules, height, apart,
    )  # fmt: skip
    return height, apart


@njit(cache=True, nogil=True, error_model="numpy")
def _clearances(  # type: ignore[no-untyped-def]
    parent, rotation, translation, axis, prismatic, leg, ratio, shift, angle, normal, s, k,
    body, ends, radius, limb, pairs, extra, height, apart,
):  # fmt: skip
    bodies, m = parent.size, body.size
    turn, at = np.empty((bodies, 3, 3)), np.empty((bodies, 3))
    turn[0], at[0] = rotation[0], translation[0]
    frame, place = np.empty((3, 3)), np.empty((m, 2, 3))
    for g in range(angle.shape[0]):
        for t in range(angle.shape[1]):
            for i in range(1, bodies):
                _move(
                    turn[parent[i]], at[parent[i]], rotation[i], translation[i], axis[i],
                    prismatic[i], ratio[i] * angle[g, t, leg[i]] + shift[i], frame, turn[i], at[i],
                )  # fmt: skip
            for c in range(m):
                b = body[c]
                for e in range(2):
                    for a in range(3):
                        place[c, e, a] = at[b, a] + (
                            turn[b, a, 0] * ends[c, e, 0]
                            + turn[b, a, 1] * ends[c, e, 1]
                            + turn[b, a, 2] * ends[c, e, 2]
                        )
                high = _height(place[c], normal[g, t], s[g, t], k) - radius[c]
                if high < height[g, limb[c]]:
                    height[g, limb[c]] = high
            for p in range(pairs.shape[0]):
                i, j = pairs[p, 0], pairs[p, 1]
                near = _apart(place[i], place[j]) - radius[i] - radius[j] + extra[p]
                if near < apart[g]:
                    apart[g] = near


@njit(inline="always")
def _move(turned, origin, rotation, translation, axis, slides, moved, frame, turn, at):  # type: ignore[no-untyped-def]
    """Place a body after its joint's motion."""
    for a in range(3):
        at[a] = origin[a]
        for b in range(3):
            at[a] += turned[a, b] * translation[b]
            frame[a, b] = (
                turned[a, 0] * rotation[0, b]
                + turned[a, 1] * rotation[1, b]
                + turned[a, 2] * rotation[2, b]
            )
    if slides:
        for a in range(3):
            for b in range(3):
                turn[a, b] = frame[a, b]
                at[a] += frame[a, b] * axis[b] * moved
        return
    sine, cosine = np.sin(moved), np.cos(moved)
    x, y, z = axis[0], axis[1], axis[2]
    for a in range(3):
        f0, f1, f2 = frame[a, 0], frame[a, 1], frame[a, 2]
        along = (1.0 - cosine) * (f0 * x + f1 * y + f2 * z)
        # A row times Rodrigues' rotation: cos f + (1 - cos)(f.u) u + sin (f x u).
        turn[a, 0] = cosine * f0 + along * x + sine * (f1 * z - f2 * y)
        turn[a, 1] = cosine * f1 + along * y + sine * (f2 * x - f0 * z)
        turn[a, 2] = cosine * f2 + along * z + sine * (f0 * y - f1 * x)


@njit(inline="always")
def _height(ends, normal, s, k):  # type: ignore[no-untyped-def]
    """Distance of a segment's nearest point from the ground."""
    if k == 0.0:
        first = second = 0.0
        for a in range(3):
            first += normal[a] * (ends[0, a] + s[a])
            second += normal[a] * (ends[1, a] + s[a])
        return min(first, second)
    square = along = length = far = 0.0
    for a in range(3):
        start = ends[0, a] + s[a] + normal[a] / k
        step = ends[1, a] - ends[0, a]
        square += start * start
        along += start * step
        length += step * step
        far += (start + step) ** 2
    if k < 0.0:
        return -1.0 / k - np.sqrt(max(square, far))
    share = min(1.0, max(0.0, -along / max(length, _TINY)))
    return np.sqrt(max(0.0, square + share * (2.0 * along + share * length))) - 1.0 / k


@njit(inline="always")
def _apart(one, other):  # type: ignore[no-untyped-def]
    """Distance of two segments."""
    uu = vv = uv = ur = vr = rr = 0.0
    for a in range(3):
        u, v, r = one[1, a] - one[0, a], other[1, a] - other[0, a], one[0, a] - other[0, a]
        uu += u * u
        vv += v * v
        uv += u * v
        ur += u * r
        vr += v * r
        rr += r * r
    uu, vv = max(uu, _TINY), max(vv, _TINY)
    det = uu * vv - uv * uv
    first = 0.0
    if det > 1e-12 * uu * vv:
        first = min(1.0, max(0.0, (uv * vr - ur * vv) / det))
    second = (uv * first + vr) / vv
    if second < 0.0:
        second = 0.0
        first = min(1.0, max(0.0, -ur / uu))
    elif second > 1.0:
        second = 1.0
        first = min(1.0, max(0.0, (uv - ur) / uu))
    square = rr + first * (2.0 * ur + first * uu) + second * (second * vv - 2.0 * vr)
    return np.sqrt(max(0.0, square - 2.0 * first * second * uv))
