"""What is read off lanes: angles, motion, lift, and the figures of a steady state, in Numba.

Over the counted cycles of period T, with m_i the mean of a quantity over cycle i, the definitions
are those of `rrrobot.simulation.steady`.
"""

from __future__ import annotations

import numpy as np

from rrrobot.momentum.coefficients import LANES
from rrrobot.momentum.compiled import inner, lanes
from rrrobot.momentum.kernels import DECOUPLED, ROWS_PER_STEP
from rrrobot.momentum.trigonometry import arc_tangent
from rrrobot.results import STILL

RESULT = (
    "speed", "velocity_x", "velocity_y", "yaw_rate", "roll_amplitude", "pitch_amplitude",
    "yaw_amplitude", "roll_phase", "pitch_phase", "yaw_phase", "roll_mean", "pitch_mean",
    "yaw_mean", "variation", "normal_force", "pitch", "clearance", "tilt", "status",
)  # fmt: skip
"""Entries of a lane's steady state, see `rrrobot.results`."""
N_RESULT = len(RESULT)
N_MOTION = 6
"""Entries of a lane's motion at an instant: z_body (3), angular velocity in the body frame (3)."""


@inner
def motion_of(y, k, i, out):  # type: ignore[no-untyped-def]
    """z_body and angular velocity of lane i, the latter from the rates k of the quaternion."""
    qx, qy, qz, qw = y[i], y[LANES + i], y[2 * LANES + i], y[3 * LANES + i]
    kx, ky, kz, kw = k[0, i], k[0, LANES + i], k[0, 2 * LANES + i], k[0, 3 * LANES + i]
    scale = 2.0 / (qx * qx + qy * qy + qz * qz + qw * qw)
    out[0] = scale * (qx * qz - qw * qy)
    out[1] = scale * (qy * qz + qw * qx)
    out[2] = 1.0 - scale * (qx * qx + qy * qy)
    out[3] = scale * (qw * kx - kw * qx - (qy * kz - qz * ky))
    out[4] = scale * (qw * ky - kw * qy - (qz * kx - qx * kz))
    out[5] = scale * (qw * kz - kw * qz - (qx * ky - qy * kx))


@inner
def tilt_of(y, i, out):  # type: ignore[no-untyped-def]
    """z_body of lane i of decoupled models, the other entries of its motion zero."""
    roll, pitch = y[i], y[LANES + i]
    for s in range(len(out)):
        out[s] = 0.0
    out[0], out[1] = -np.sin(pitch), np.cos(pitch) * np.sin(roll)
    out[2] = np.cos(pitch) * np.cos(roll)


@inner
def lift(now, c, row, i):  # type: ignore[no-untyped-def]
    """Vertical momentum relative to the centre of lane i: z (w x mc + p_rel)."""
    m0, m1, m2 = c[row, i], c[row, LANES + i], c[row, 2 * LANES + i]
    w0, w1, w2 = now[3], now[4], now[5]
    return (
        now[0] * (w1 * m2 - w2 * m1 + c[row, 9 * LANES + i])
        + now[1] * (w2 * m0 - w0 * m2 + c[row, 10 * LANES + i])
        + now[2] * (w0 * m1 - w1 * m0 + c[row, 11 * LANES + i])
    )


@lanes
def angles(y, axis, out):  # type: ignore[no-untyped-def]
    """Roll, pitch and yaw of every lane (3 LANES,)."""
    for i in range(LANES):
        out[2 * LANES + i] = y[9 * LANES + i]
    if axis == DECOUPLED:
        for i in range(2 * LANES):
            out[i] = y[i]
        return
    for i in range(LANES):
        qx, qy, qz, qw = y[i], y[LANES + i], y[2 * LANES + i], y[3 * LANES + i]
        across = 2.0 * (qw * qx + qy * qz)
        along = qw * qw - qx * qx - qy * qy + qz * qz
        out[i] = arc_tangent(across, along)
        cosine = np.sqrt(across * across + along * along)
        out[LANES + i] = arc_tangent(2.0 * (qw * qy - qz * qx), cosine)


@inner
def drift(means, period, i, out):  # type: ignore[no-untyped-def]
    """Speed, velocity, yaw rate and variation from cycle means (counted, 3 LANES)."""
    steps = len(means) - 1
    speed, along_x, along_y = 0.0, 0.0, 0.0
    for k in range(steps):
        dx = (means[k + 1, i] - means[k, i]) / period
        dy = (means[k + 1, LANES + i] - means[k, LANES + i]) / period
        yaw = 0.5 * (means[k + 1, 2 * LANES + i] + means[k, 2 * LANES + i])
        speed += np.hypot(dx, dy)
        along_x += np.cos(yaw) * dx + np.sin(yaw) * dy
        along_y += -np.sin(yaw) * dx + np.cos(yaw) * dy
    out[0], out[1], out[2] = speed / steps, along_x / steps, along_y / steps
    out[3] = (means[steps, 2 * LANES + i] - means[0, 2 * LANES + i]) / (steps * period)
    worst = 0.0
    for k in range(steps):
        dx = (means[k + 1, i] - means[k, i]) / period
        dy = (means[k + 1, LANES + i] - means[k, LANES + i]) / period
        yaw = 0.5 * (means[k + 1, 2 * LANES + i] + means[k, 2 * LANES + i])
        ahead = np.cos(yaw) * dx + np.sin(yaw) * dy - out[1]
        aside = -np.sin(yaw) * dx + np.cos(yaw) * dy - out[2]
        worst = max(worst, np.hypot(ahead, aside))
    out[13] = worst / max(out[0], STILL / period)


@inner
def harmonic(angles, turns, counted, a, drift, i, out):  # type: ignore[no-untyped-def]
    """Amplitude, phase and mean of an angle a that drifts by so much in a cycle."""
    n_steps, sine, cosine, mean = len(angles), 0.0, 0.0, 0.0
    for n in range(n_steps):
        # Time of the summed samples from the middle of the counted cycles, in periods.
        late = counted * (n / n_steps - 0.5)
        whole = angles[n, a * LANES + i] - drift * late
        sine += turns[0, n * ROWS_PER_STEP, 0] * whole
        cosine += turns[1, n * ROWS_PER_STEP, 0] * whole
        mean += whole
    scale = 2.0 / (counted * n_steps)
    out[4 + a] = scale * np.hypot(sine, cosine)
    out[7 + a] = np.arctan2(cosine, sine)
    out[10 + a] = 0.5 * scale * mean


@inner
def least(slope_of, values, out, sums):  # type: ignore[no-untyped-def]
    """Least slope of a periodic quantity (steps, LANES) of every lane, times the period."""
    now = sums[0]
    for i in range(len(out)):
        out[i] = np.inf
    for m in range(len(slope_of)):
        between(slope_of[m], values, now)
        for i in range(len(out)):
            out[i] = min(out[i], now[i])


@inner
def between(weights, values, out):  # type: ignore[no-untyped-def]
    """A weighted sum of samples (steps, LANES) in every lane."""
    # Of a number of lanes that the compiler is not told it makes vector code.
    for i in range(len(out)):
        out[i] = 0.0
    for n in range(len(values)):
        for i in range(len(out)):
            out[i] += weights[n] * values[n, i]
