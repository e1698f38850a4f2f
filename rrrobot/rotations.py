"""Rotations: roll-pitch-yaw angles, quaternions (x, y, z, w), and their rates.

R_world_body = Rz(yaw) Ry(pitch) Rx(roll). All angles in rad, rates in rad/s.
"""

from __future__ import annotations

from math import asin, atan2, cos, sin

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rrrobot.checks import Array

_UPRIGHT = 0.7072
"""Vertical part of a body's axis from which on it leans by less than an eighth of a turn."""


def skew(a: Array) -> Array:
    """Matrix [a] with [a] b = a x b, shape (3, 3)."""
    x, y, z = a.tolist()
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


def rotation_from_euler(euler: ArrayLike) -> Array:
    """R_world_body (3, 3) of (roll, pitch, yaw)."""
    r, p, y = np.asarray(euler, dtype=float).tolist()
    cr, sr, cp, sp, cy, sy = cos(r), sin(r), cos(p), sin(p), cos(y), sin(y)
    return np.array(
        (
            (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
            (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
            (-sp, cp * sr, cp * cr),
        )
    )


def quaternion_from_euler(euler: ArrayLike) -> Array:
    """Unit quaternion (x, y, z, w) of (roll, pitch, yaw); vectorised: (..., 3) -> (..., 4)."""
    half = 0.5 * np.asarray(euler, dtype=float).T
    (cr, cp, cy), (sr, sp, sy) = np.cos(half), np.sin(half)
    return np.array(
        (
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        )
    ).T.copy()


def rotation_from_quaternion(quaternion: ArrayLike) -> Array:
    """R_world_body of a quaternion (x, y, z, w) of any length but zero."""
    x, y, z, w = np.asarray(quaternion, dtype=float).tolist()
    s = 2.0 / (x * x + y * y + z * z + w * w)
    xs, ys, zs = x * s, y * s, z * s
    return np.array(
        (
            (1.0 - y * ys - z * zs, x * ys - w * zs, x * zs + w * ys),
            (x * ys + w * zs, 1.0 - x * xs - z * zs, y * zs - w * xs),
            (x * zs - w * ys, y * zs + w * xs, 1.0 - x * xs - y * ys),
        )
    )


def quaternion_rate(quaternion: Array, omega_body: Array) -> Array:
    """Rate of a quaternion: q_dot = q (omega_body, 0) / 2, shape (4,) [1/s]."""
    x, y, z, w = quaternion.tolist()
    a, b, c = (0.5 * omega_body).tolist()
    return np.array(
        (
            w * a + y * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y * a,
            -x * a - y * b - z * c,
        )
    )


def euler_from_quaternion(quaternion: ArrayLike) -> Array:
    """(roll, pitch, yaw) with |pitch| <= pi/2; vectorised: (..., 4) -> (..., 3)."""
    q = np.asarray(quaternion, dtype=float)
    x, y, z, w = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    norm2 = x * x + y * y + z * z + w * w
    sine = 2.0 * (w * y - z * x) / norm2
    euler = np.empty((*q.shape[:-1], 3))
    euler[..., 0] = np.arctan2(2.0 * (w * x + y * z), w * w - x * x - y * y + z * z)
    euler[..., 1] = np.arcsin(np.minimum(np.maximum(sine, -1.0), 1.0))
    euler[..., 2] = np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return euler


def euler_from_rotation(rotation: Array) -> tuple[float, float, float]:
    """(roll, pitch, yaw) of R_world_body, with |pitch| <= pi/2 [rad]."""
    (a, _, _), (b, _, _), (c, y, z) = rotation.tolist()
    return atan2(y, z), asin(max(-1.0, min(1.0, -c))), atan2(b, a)


def continuous_euler(euler: ArrayLike, start: ArrayLike) -> Array:
    """The (roll, pitch, yaw) history (n, 3) without jumps, beginning nearest to `start` (3,).

    Every rotation has two families of angles, (r, p, y) and (r + pi, pi - p, y + pi), each up to
    full turns; each sample takes the member that is nearest to the sample before it.
    """
    history = np.array(euler, dtype=float)
    before = np.asarray(start, dtype=float)
    full_turn = 2.0 * np.pi
    near = history + full_turn * np.round((before - history) / full_turn)
    if np.all(np.abs(near - before) < 1.0):
        return near
    for i, angles in enumerate(history):
        twin = np.array((angles[0] + np.pi, np.pi - angles[1], angles[2] + np.pi))
        near = angles + full_turn * np.round((before - angles) / full_turn)
        twin += full_turn * np.round((before - twin) / full_turn)
        if np.abs(twin - before).sum() < np.abs(near - before).sum():
            near = twin
        history[i] = before = near
    return history


def body_rates_matrix(roll: float, pitch: float) -> Array:
    """B with omega_body = B (roll_rate, pitch_rate, yaw_rate), shape (3, 3)."""
    cr, sr, cp, sp = cos(roll), sin(roll), cos(pitch), sin(pitch)
    return np.array(((1.0, 0.0, -sp), (0.0, cr, cp * sr), (0.0, -sr, cp * cr)))


def body_rates_matrix_rate(euler: ArrayLike, rates: ArrayLike) -> Array:
    """Rate of `body_rates_matrix` for (roll, pitch, yaw) and their rates, (3, 3) [1/s]."""
    roll, pitch, _ = np.asarray(euler, dtype=float).tolist()
    roll_rate, pitch_rate, _ = np.asarray(rates, dtype=float).tolist()
    cr, sr, cp, sp = cos(roll), sin(roll), cos(pitch), sin(pitch)
    return np.array(
        (
            (0.0, 0.0, -cp * pitch_rate),
            (0.0, -sr * roll_rate, -sp * sr * pitch_rate + cp * cr * roll_rate),
            (0.0, -cr * roll_rate, -sp * cr * pitch_rate - cp * sr * roll_rate),
        )
    )


def euler_rates(euler: ArrayLike, omega_body: ArrayLike) -> Array:
    """(roll, pitch, yaw) rates of a body angular velocity; vectorised over leading axes [rad/s].

    Singular at pitch = +-90 degrees.
    """
    roll, pitch, _ = np.moveaxis(np.asarray(euler, dtype=float), -1, 0)
    wx, wy, wz = np.moveaxis(np.asarray(omega_body, dtype=float), -1, 0)
    about = wy * np.sin(roll) + wz * np.cos(roll)
    return np.stack(
        (
            wx + about * np.tan(pitch),
            wy * np.cos(roll) - wz * np.sin(roll),
            about / np.cos(pitch),
        ),
        axis=-1,
    )


def turns_over(up: Array, turn: ArrayLike) -> NDArray[np.bool_]:
    """Whether bodies turn over in a cycle, so that Euler angles are no heading and no swing.

    A body that rolls over comes back with a yaw that counts whole turns of the body beside its
    heading, or with a roll of whole turns, or leaps past the vertical: exactly one of these shows.

    Args:
        up: vertical in the body frame at instants of a whole cycle (..., n, 3).
        turn: by how much the continuous yaw grows in the cycle (...) [rad].

    Returns:
        booleans (...).
    """
    # Within an eighth of a turn about upright nothing turns over.
    out = np.asarray(~(up[..., 2].min(axis=-1) > _UPRIGHT))
    if out.any():
        out[out] = _turns_over(up[out], np.broadcast_to(turn, out.shape)[out])
    return out


def _turns_over(up: Array, turn: Array) -> NDArray[np.bool_]:
    roll = np.arctan2(up[..., 1], up[..., 2])
    leaps = np.diff(roll, axis=-1, append=roll[..., :1])
    leaps -= 2 * np.pi * np.round(leaps / (2 * np.pi))
    wound = np.abs(leaps.sum(axis=-1)) > np.pi
    leaps = np.abs(leaps).max(axis=-1) > np.pi / 2
    wide = np.einsum("...ik,...jk->...ij", up, up).min(axis=(-1, -2)) < 0.0
    return np.asarray(wound | leaps | (wide & (np.abs(turn) >= np.pi)))
