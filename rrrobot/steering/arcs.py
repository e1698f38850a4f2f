"""Pose to pose by few screws in the plane: the coarse plan, before the exact one.

A robot that moves along a twist (u, v, w) of its own axes for a time t goes from the pose
g = (x, y, yaw) to g exp(t (u, v, w)), on a circle or a line. `joined` finds the times of three of
them that lead to a goal, for all choices of three at once, by Newton's method.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array


class Arcs(NamedTuple):
    """Ways to a goal, the shortest first; each a row."""

    choice: Array
    """which motions (n, 3)"""
    time: Array
    """how long each (n, 3) [s]"""


def move(pose: Array, twist: Array, time: Array) -> Array:
    """Poses (..., 3) after following twists (..., 3) for times (...,)."""
    u, v, w = twist[..., 0], twist[..., 1], twist[..., 2]
    turn = w * time
    # sin(turn) / w and (1 - cos(turn)) / w, at any w.
    along = time * np.sinc(turn / np.pi)
    aside = time * np.sin(0.5 * turn) * np.sinc(0.5 * turn / np.pi)
    dx, dy = along * u - aside * v, aside * u + along * v
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    return np.stack(
        (pose[..., 0] + c * dx - s * dy, pose[..., 1] + s * dx + c * dy, pose[..., 2] + turn),
        axis=-1,
    )


def joined(
    twists: Array,
    start: Array,
    goal: Array,
    *,
    least: float,
    most: float,
    length: float = 0.1,
    tries: int = 6,
    turns: int = 1,
) -> Arcs:
    """Times of three motions from a pose to a pose.

    Args:
        twists: the motions that may be used (m, 3).
        start, goal: (x, y, yaw) [m, m, rad]; the yaw may be reached with whole turns more or less.
        least: time that each takes at least [s].
        most: that all take together at most [s].
        length: that makes an angle comparable with a distance [m].
        tries: starts of Newton's method for each choice.
        turns: whole turns more or less that are tried.

    Returns:
        those found, by their whole time.
    """
    m = len(twists)
    choice = np.array([c for c in itertools.product(range(m), repeat=3) if c[0] != c[1] != c[2]])
    whole = 2 * np.pi * np.arange(-turns, turns + 1)
    rng = np.random.default_rng(0)
    choice = np.repeat(choice, tries * whole.size, axis=0)
    aim = np.tile(whole, len(choice) // whole.size)
    goals = np.broadcast_to(goal, (len(choice), 3)) + np.column_stack((0 * aim, 0 * aim, aim))
    far = np.hypot(*(goal[:2] - start[:2])) / np.linalg.norm(twists[:, :2], axis=1).max()
    time = least + rng.exponential(max(0.5 * far, 4 * least), (len(choice), 3))
    weight = np.array((1.0, 1.0, length))
    live = np.arange(len(choice))
    for _ in range(14):
        poses, jacobian = _chain(twists[choice[live]], start, time[live])
        gap = (goals[live] - poses) * weight
        error = np.linalg.norm(gap, axis=1)
        matrix = jacobian * weight[:, None]
        # Levenberg's step keeps choices whose screws are nearly alike from running away.
        square = matrix.transpose(0, 2, 1) @ matrix
        damp = 1e-9 * np.trace(square, axis1=1, axis2=2) + 1e-3 * error**2 * 1e-2
        square += damp[:, None, None] * np.eye(3)
        right = (matrix.transpose(0, 2, 1) @ gap[:, :, None])[..., 0]
        step = np.linalg.solve(square, right[..., None])[..., 0]
        time[live] = np.clip(time[live] + np.clip(step, -20.0, 20.0), 0.0, most)
        live = live[error > 1e-9]  # those that have arrived stay
        if not live.size:
            break
    poses, _ = _chain(twists[choice], start, time)
    error = np.linalg.norm((goals - poses) * weight, axis=1)
    good = (error < 1e-6) & (time.min(axis=1) >= least) & (time.sum(axis=1) <= most)
    choice, time = choice[good], time[good]
    order = np.argsort(time.sum(axis=1), kind="stable")
    choice, time = choice[order], time[order]
    # The same way is found from several starts.
    _, first = np.unique(
        np.column_stack((choice, np.round(time / (0.01 * least)))), axis=0, return_index=True
    )
    first = np.sort(first)
    return Arcs(choice[first], time[first])


def _chain(twists: Array, start: Array, time: Array) -> tuple[Array, Array]:
    """End poses (n, 3) of chains of motions, and their derivatives by the times (n, 3, k)."""
    n, k, _ = twists.shape
    pose = np.broadcast_to(start, (n, 3))
    ends = np.empty((n, k, 3))
    for i in range(k):
        pose = move(pose, twists[:, i], time[:, i])
        ends[:, i] = pose
    c, s = np.cos(ends[..., 2]), np.sin(ends[..., 2])
    u, v, w = (twists[..., a] for a in range(3))
    away = pose[:, None, :2] - ends[..., :2]
    # Going on a little longer in one turns and carries all that follows it.
    dx = c * u - s * v - w * away[..., 1]
    dy = s * u + c * v + w * away[..., 0]
    return pose, np.stack((dx, dy, w), axis=1)


def path(twists: Array, start: Array, time: Array, spacing: float = 0.5) -> Array:
    """Poses (n, 3) along a chain of motions, about every `spacing` seconds."""
    poses = [np.asarray(start, dtype=float)[None]]
    for twist, t in zip(twists, time, strict=True):
        at = np.linspace(0.0, t, max(2, int(np.ceil(t / spacing)) + 1))[1:]
        last = np.broadcast_to(poses[-1][-1], (at.size, 3))
        poses.append(move(last, np.broadcast_to(twist, (at.size, 3)), at))
    return np.vstack(poses)
