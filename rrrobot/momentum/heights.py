"""Clearance: the least distance of any leg to the ground over a cycle of the settled motion.

A leg is where its links' masses are: on RRRobot, whose legs are bars with a mass at the tip, that
is its lowest point. The distance is that along the ground's normal to the tangent plane at the
contact, which on a plane is the ground itself. It is looked for between the engine's steps, on the
interpolation of the last cycle. What a link's own shape adds is geometry, not motion: it has no
place here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits.batch import GaitBatch
from rrrobot.momentum.coefficients import LANES, LaneWork, lane_work, move_lanes
from rrrobot.momentum.compiled import borrowed, compiled, inner
from rrrobot.momentum.interpolation import between, interpolate
from rrrobot.momentum.legs import checked, turns_at
from rrrobot.momentum.lowering import Setting


class Work(NamedTuple):
    """Room for one gait."""

    lanes: LaneWork
    place: Array
    """the normal in the base's axes, and s (6, instants)"""
    above: Array
    """height of the base's origin over the contact (instants,) [m]"""
    heights: Array
    """of each body at the instants (bodies, instants) [m]"""
    fine: Array
    """of one body between them (points,) [m]"""


def clearance(setting: Setting, gaits: GaitBatch, motion: Array) -> Array:
    """Least distance of any leg's masses to the ground (n,) [m]; infinite if no leg has a mass.

    Args:
        setting: the model.
        gaits: one row a gait.
        motion: of a cycle that begins at phase zero, as `extremes` takes it.
    """
    steps = motion.shape[1]
    refine, finer = between(steps, setting.periodic)
    instants = len(refine)
    work = Work(
        lane_work(setting.tree), np.zeros((6, instants)), np.zeros(instants),
        np.zeros((setting.tree.mass.size, instants)), np.zeros(len(finer)),
    )  # fmt: skip
    out = np.empty(gaits.n)
    _lowest(
        setting.tree, setting.radius, tuple(checked(setting.tree, gaits)), motion,
        turns_at(instants, gaits.sine.shape[1]), np.ascontiguousarray(refine.T),
        np.ascontiguousarray(finer.T), work, out,
    )  # fmt: skip
    return out


@compiled()
def _lowest(tree, radius, gaits, motion, turns, refine, finer, work, out):  # type: ignore[no-untyped-def]
    tree, gaits, motion, turns = borrowed(tree), borrowed(gaits), borrowed(motion), borrowed(turns)
    refine, finer, work, out = borrowed(refine), borrowed(finer), borrowed(work), borrowed(out)
    offset, winding, sine, cosine, _ = gaits
    lanes, place, above, heights, fine = (
        work.lanes, work.place, work.above, work.heights, work.fine,
    )  # fmt: skip
    bodies, n = heights.shape
    # Where the shell is any, its own contact s = -x and the ground's normal are in the motion.
    known = motion.shape[2] > 9
    for g in range(len(out)):
        for s in range(6 if known else 3):
            # z_body, or the normal, then s.
            interpolate(refine, motion[g], 6 + s if known else s, place[s])
        for k in range(n):
            above[k] = radius
        if known:
            for k in range(n):
                above[k] = (
                    place[0, k] * place[3, k]
                    + place[1, k] * place[4, k]
                    + place[2, k] * place[5, k]
                )
        for first in range(0, n, LANES):
            last = min(first + LANES, n)
            for leg in range(offset.shape[1]):
                for k in range(first, last):
                    angle = offset[g, leg] + winding[g, leg] * turns[2, k, 0]
                    for j in range(sine.shape[1]):
                        angle += (
                            sine[g, j, leg] * turns[0, k, j] + cosine[g, j, leg] * turns[1, k, j]
                        )
                    lanes.angle[leg, k - first] = angle
            for b in range(1, bodies):
                move_lanes(tree, b, lanes.angle[tree.leg[b]], lanes.rate[tree.leg[b]], lanes.bodies)
                _heights(lanes.bodies[b], tree.lever[b], place, above, first, heights[b])
        least = np.inf
        for b in range(1, bodies):
            if tree.mass[b] == 0.0:
                continue
            for p in range(len(fine)):
                fine[p] = 0.0
            for k in range(n):
                height = heights[b, k]
                for p in range(len(fine)):
                    fine[p] += finer[k, p] * height
            for p in range(len(fine)):
                here = fine[p]
                least = min(least, here)
                if p == 0 or p == len(fine) - 1:
                    continue
                # The lowest point of the parabola through a valley's three.
                left, right = fine[p - 1], fine[p + 1]
                bend = left - 2.0 * here + right
                if here <= left and here < right and bend > 0.0:
                    least = min(least, here - (left - right) ** 2 / (8.0 * bend))
        out[g] = least


@inner
def _heights(own, lever, place, above, first, out):  # type: ignore[no-untyped-def]
    """Of a body at the instants from the first on, one in each lane."""
    for i in range(min(LANES, len(out) - first)):
        height = above[first + i]
        for a in range(3):
            r = 3 * a * LANES + i
            arm = own[r] * lever[0] + own[r + LANES] * lever[1] + own[r + 2 * LANES] * lever[2]
            height += place[a, first + i] * (own[(9 + a) * LANES + i] + arm)
        out[first + i] = height
