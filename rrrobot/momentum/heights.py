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
from rrrobot.momentum.compiled import borrowed, compiled
from rrrobot.momentum.interpolation import between
from rrrobot.momentum.legs import checked, legs_at, turns_at
from rrrobot.momentum.lowering import Setting


class Work(NamedTuple):
    """Room for one gait."""

    lanes: LaneWork
    leg: Array
    """angles, rates and accelerations (3, legs)"""
    place: Array
    """the normal in the base's axes, and s (6,)"""
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
    steps, (n, legs) = motion.shape[1], gaits.offset.shape
    refine, finer = between(steps, setting.periodic)
    instants = len(refine)
    work = Work(
        lane_work(setting.tree), np.zeros((3, legs)), np.zeros(6),
        np.zeros((setting.tree.mass.size, instants)), np.zeros(len(finer)),
    )  # fmt: skip
    out = np.empty(n)
    _lowest(
        setting.tree, setting.radius, tuple(checked(setting.tree, gaits)), motion,
        turns_at(instants, gaits.sine.shape[1]), refine, np.ascontiguousarray(finer.T), work, out,
    )  # fmt: skip
    return out


@compiled()
def _lowest(tree, radius, gaits, motion, turns, refine, finer, work, out):  # type: ignore[no-untyped-def]
    tree, gaits, motion, turns = borrowed(tree), borrowed(gaits), borrowed(motion), borrowed(turns)
    refine, finer, work, out = borrowed(refine), borrowed(finer), borrowed(work), borrowed(out)
    offset, winding, sine, cosine, omega = gaits
    lanes, place, heights, fine = work.lanes, work.place, work.heights, work.fine
    bodies, n = heights.shape
    # Where the shell is any, its own contact s = -x and the ground's normal are in the motion.
    known = motion.shape[2] > 9
    for g in range(len(out)):
        for first in range(0, n, LANES):
            last = min(first + LANES, n)
            for k in range(first, last):
                legs_at(omega[g], offset[g], winding[g], sine[g], cosine[g], turns, k, work.leg)
                for leg in range(offset.shape[1]):
                    lanes.angle[leg, k - first] = work.leg[0, leg]
            for b in range(1, bodies):
                move_lanes(tree, b, lanes.angle[tree.leg[b]], lanes.rate[tree.leg[b]], lanes.bodies)
            for k in range(first, last):
                i, above = k - first, radius
                for s in range(3):
                    place[s], place[3 + s] = 0.0, 0.0
                    for m in range(motion.shape[1]):
                        place[s] += refine[k, m] * motion[g, m, 6 + s if known else s]
                        if known:
                            place[3 + s] += refine[k, m] * motion[g, m, 9 + s]
                if known:
                    above = place[0] * place[3] + place[1] * place[4] + place[2] * place[5]
                for b in range(1, bodies):
                    own, lever, height = lanes.bodies[b], tree.lever[b], above
                    for a in range(3):
                        r = 3 * a * LANES + i
                        arm = own[r] * lever[0] + own[r + LANES] * lever[1]
                        arm += own[r + 2 * LANES] * lever[2]
                        height += place[a] * (own[(9 + a) * LANES + i] + arm)
                    heights[b, k] = height
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
