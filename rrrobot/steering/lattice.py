"""A way around obstacles: A* over poses that short pieces of the motions lead to.

The poses that were reached are kept in cells of place and heading, the nearest to the start in
each. From time to time the search asks whether three motions lead from where it stands straight to
the goal.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.steering.arcs import joined, move, path

CELL, SECTOR = 0.03, np.pi / 12
"""Size of a cell [m], and of a sector of headings [rad]."""


_LENGTH = 0.1
"""That makes an angle comparable with a distance [m]."""


class Around(NamedTuple):
    """A way through free ground."""

    choice: list[int]
    """which motions"""
    time: list[float]
    """how long each [s]"""
    end: Array
    """where it leads (3,): to the goal, or to the pose nearest to it that was reached"""
    arrives: bool
    """whether that is the goal"""


def around(
    twists: Array,
    start: Array,
    goal: Array,
    free: Callable[[Array], Array],
    *,
    piece: float,
    least: float,
    most: float,
    blend: float,
    expansions: int = 4000,
) -> Around:
    """Motions and times that lead from a pose to a pose through free ground.

    Args:
        twists: the motions (m, 3).
        start, goal: (x, y, yaw).
        free: which of points (n, 2) are free.
        piece: length of a piece [s].
        least: shortest time of a motion [s].
        most: longest whole time [s].
        blend: cost of a change of motion [s].
        expansions: poses that are looked at, at most.

    Returns:
        the first way that was found; if there is none, the one that ends nearest.
    """
    fastest = np.linalg.norm(twists[:, :2], axis=1).max()
    turning = max(np.abs(twists[:, 2]).max(), 1e-12)

    def to_go(pose: Array) -> float:
        turn = abs((goal[2] - pose[2] + np.pi) % (2 * np.pi) - np.pi)
        return float(max(np.hypot(*(goal[:2] - pose[:2])) / fastest, turn / turning))

    def cell(pose: Array) -> tuple[int, int, int]:
        x, y = np.floor(pose[:2] / CELL)
        return int(x), int(y), int(np.floor((pose[2] % (2 * np.pi)) / SECTOR))

    def away(pose: Array) -> float:
        turn = abs((goal[2] - pose[2] + np.pi) % (2 * np.pi) - np.pi)
        return float(np.hypot(*(goal[:2] - pose[:2])) + _LENGTH * turn)

    m, checks = len(twists), np.linspace(0.0, piece, 5)[1:]
    heap: list[tuple[float, int, float, Array, int, int]] = [(to_go(start), 0, 0.0, start, -1, -1)]
    known: list[tuple[int, int]] = []
    closed: set[tuple[int, int, int]] = set()
    asked_at, count = np.inf, 0
    nearest, end = 0, np.asarray(start, dtype=float)
    while heap and len(known) < expansions:
        _, _, cost, pose, motion, parent = heapq.heappop(heap)
        key = cell(pose)
        if key in closed:
            continue
        closed.add(key)
        known.append((motion, parent))
        me = len(known) - 1
        if away(pose) < away(end):
            nearest, end = me, pose
        near = to_go(pose)
        if me == 0 or near < 0.8 * asked_at or me % 150 == 0:
            asked_at = min(asked_at, near)
            last = joined(twists, pose, goal, least=least, most=most - cost, tries=2, turns=0)
            for choice, time in zip(last.choice[:200], last.time[:200], strict=True):
                if np.all(free(path(twists[choice], pose, time)[:, :2])):
                    way = _merged(known, me, piece, choice, time)
                    return Around(*way, np.asarray(goal, dtype=float), True)
        # All pieces from here at once, each checked at a few points.
        ends = move(np.broadcast_to(pose, (m, 4, 3)), twists[:, None], checks[None, :])
        clear = free(ends[:, :, :2].reshape(-1, 2)).reshape(m, 4).all(axis=1)
        for k in np.flatnonzero(clear):
            if cell(ends[k, -1]) in closed:
                continue
            spent = cost + piece + (blend if k != motion else 0.0)
            if spent > most:
                continue
            count += 1
            total = spent + to_go(ends[k, -1])
            heapq.heappush(heap, (total, count, spent, ends[k, -1], int(k), me))
    return Around(*_merged(known, nearest, piece, np.empty(0, int), np.empty(0)), end, False)


def _merged(
    known: list[tuple[int, int]], at: int, piece: float, choice: Array, time: Array
) -> tuple[list[int], list[float]]:
    """Motions in their order, the same ones after each other as one."""
    way: list[int] = []
    while known[at][1] >= 0:
        way.append(known[at][0])
        at = known[at][1]
    motions: list[int] = []
    times: list[float] = []
    steps = [(k, piece) for k in reversed(way)]
    steps += list(zip(choice.tolist(), time.tolist(), strict=True))
    for k, t in steps:
        if motions and motions[-1] == k:
            times[-1] += t
        else:
            motions.append(k)
            times.append(t)
    return motions, times
