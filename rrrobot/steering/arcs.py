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
    error = np.full(len(choice), np.inf)
    live, axes = np.arange(len(choice)), twists[choice].transpose(1, 2, 0)
    for number in range(15):
        pose, slope = _chain(axes, start, time[live].T)
        x, y, turn = (goals[live].T - pose) * np.array(((1.0,), (1.0,), (length,)))
        size = np.sqrt(x * x + y * y + turn * turn)
        error[live] = size
        going = size > 1e-9  # those that have arrived stay
        if number == 14 or not going.any():
            break
        # Levenberg's step keeps choices whose screws are nearly alike from running away.
        (ax, bx, cx), (ay, by, cy), (aw, bw, cw) = slope
        aw, bw, cw = length * aw, length * bw, length * cw
        damp = 1e-5 * size**2
        aa, bb, cc = (
            ax * ax + ay * ay + aw * aw,
            bx * bx + by * by + bw * bw,
            (cx * cx + cy * cy + cw * cw),
        )
        damp += 1e-9 * (aa + bb + cc)
        aa, bb, cc = aa + damp, bb + damp, cc + damp
        ab, bc, ca = (
            ax * bx + ay * by + aw * bw,
            bx * cx + by * cy + bw * cw,
            (cx * ax + cy * ay + cw * aw),
        )
        p, q, r = (
            ax * x + ay * y + aw * turn,
            bx * x + by * y + bw * turn,
            (cx * x + cy * y + cw * turn),
        )
        # The symmetric system by its adjugate.
        i00, i01, i02 = bb * cc - bc * bc, ca * bc - ab * cc, ab * bc - ca * bb
        i11, i12, i22 = aa * cc - ca * ca, ab * ca - aa * bc, aa * bb - ab * ab
        over = 1.0 / (aa * i00 + ab * i01 + ca * i02)
        step = over * np.stack(
            (i00 * p + i01 * q + i02 * r, i01 * p + i11 * q + i12 * r, i02 * p + i12 * q + i22 * r)
        )
        time[live] = np.clip(time[live] + np.clip(step.T, -20.0, 20.0), 0.0, most)
        live, axes = live[going], axes[:, :, going]
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


def _chain(axes: Array, start: Array, time: Array) -> tuple[Array, Array]:
    """End poses (3, n) of chains of motions, and their derivatives by the times (3, k, n).

    Args:
        axes: the motions (k, 3, n).
        start: pose (3,).
        time: (k, n).
    """
    k, n = time.shape
    x, y, yaw = (np.full(n, value) for value in start)
    c, s = np.cos(yaw), np.sin(yaw)
    ends, slope = [], np.empty((3, k, n))
    for (u, v, w), t in zip(axes, time, strict=True):
        half = 0.5 * w * t
        sine, cosine = np.sin(half), np.cos(half)
        small = np.abs(half) < 1e-9
        # The chord: 2 sin(half) / w, in the direction that is half turned.
        chord = np.where(small, t, sine * t / np.where(small, 1.0, half))
        along, aside = chord * (cosine * u - sine * v), chord * (sine * u + cosine * v)
        x, y, yaw = x + c * along - s * aside, y + s * along + c * aside, yaw + w * t
        turned, aslant = cosine * cosine - sine * sine, 2.0 * sine * cosine
        c, s = c * turned - s * aslant, s * turned + c * aslant
        ends.append((x, y, c, s))
    for i, ((u, v, w), (xi, yi, ci, si)) in enumerate(zip(axes, ends, strict=True)):
        # Going on a little longer in one turns and carries all that follows it.
        slope[0, i] = ci * u - si * v - w * (y - yi)
        slope[1, i] = si * u + ci * v + w * (x - xi)
        slope[2, i] = w
    return np.stack((x, y, yaw)), slope


def path(twists: Array, start: Array, time: Array, spacing: float = 0.5) -> Array:
    """Poses (n, 3) along a chain of motions, about every `spacing` seconds."""
    poses = [np.asarray(start, dtype=float)[None]]
    for twist, t in zip(twists, time, strict=True):
        at = np.linspace(0.0, t, max(2, int(np.ceil(t / spacing)) + 1))[1:]
        last = np.broadcast_to(poses[-1][-1], (at.size, 3))
        poses.append(move(last, np.broadcast_to(twist, (at.size, 3)), at))
    return np.vstack(poses)
