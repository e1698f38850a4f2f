"""What an orbit does in a period: net motion as a screw, amplitudes, phases, normal force.

After a period T the robot stands as before, but turned by psi and displaced by d: x -> d + R x in
the plane. With m the mean of the contact point over the period, the speed that
`rrrobot.simulation.steady` takes from consecutive cycles is that of m under this motion,

    v = |d + (R - 1) m| / T,    alpha = psi / T,    centre c = (1 - R)^-1 d

On a boulder or a bowl it is turned about the vertical through the top or the bottom: x -> R x.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.momentum.kernels import ANY, DECOUPLED
from rrrobot.momentum.returns import Cycles, Seen, seen
from rrrobot.momentum.terrain import BOULDER
from rrrobot.rotations import turns_over

_FINER = 8


class Measures(NamedTuple):
    """Of n orbits; see `SteadyState` for what speed, velocity and phase mean."""

    speed: Array
    """(n,) [m/s]"""
    velocity: Array
    """along the body's mean axes (n, 2) [m/s]"""
    yaw_rate: Array
    """(n,) [rad/s]"""
    amplitude: Array
    """of the first harmonic of roll, pitch, yaw (n, 3) [rad]"""
    phase: Array
    """(n, 3) [rad]"""
    mean: Array
    """of roll, pitch and yaw over the period that starts with yaw 0 (n, 3) [rad]"""
    displacement: Array
    """d (n, 2) [m]"""
    turn: Array
    """psi (n,) [rad]"""
    pitch: Array
    """largest |sin pitch| (n,)"""
    normal_force: Array
    """least (n,) [N]; NaN if decoupled"""
    tumbles: NDArray[np.bool_]
    """whether the body turns over, so that the turn is known up to whole turns and what rests on
    Euler angles (velocity, amplitude, phase, mean) is NaN (n,)"""


def look(cycles: Cycles, y: Array, periods: int = 1) -> Seen:
    """A look at whole periods of the legs, one after the other, as one."""
    parts, state = [], y
    for _ in range(periods):
        parts.append(seen(cycles, state))
        state = parts[-1].end
    angles, motion, lift, push = (
        np.concatenate([part[k] for part in parts], axis=1) for k in range(3, 7)
    )
    areas = np.sum([part.areas for part in parts], axis=0)
    ground = np.min([part.ground for part in parts], axis=0)
    return Seen(y, state, areas, angles, motion, lift, push, ground)


def measures(cycles: Cycles, sight: Seen, periods: int = 1) -> Measures:
    """Measures of orbits from a look at their period."""
    period = periods * cycles.period
    turn, d = ((sight.end - sight.start)[:, k] for k in (9, slice(7, 9)))
    tumbles = turns_over(sight.motion[:, :, :3], turn)
    turn = np.where(tumbles, turn - 2 * np.pi * np.round(turn / (2 * np.pi)), turn)
    mean = sight.areas / period[:, None]
    c, s = np.cos(turn), np.sin(turn)
    m = mean[:, :2]
    terrain = cycles.setting.terrain
    # On a boulder the motion is turned about its top; elsewhere it begins at the origin.
    step = (0.0 if terrain is not None and terrain.ground == BOULDER else d) - m
    step += np.column_stack((c * m[:, 0] - s * m[:, 1], s * m[:, 0] + c * m[:, 1]))
    step /= period[:, None]
    heading = mean[:, 2] + 0.5 * turn
    c, s = np.cos(heading), np.sin(heading)
    velocity = np.column_stack((c * step[:, 0] + s * step[:, 1], -s * step[:, 0] + c * step[:, 1]))
    samples = sight.angles.shape[1]
    late = np.arange(samples) / samples
    angles = np.unwrap(sight.angles, axis=1)
    angles[:, :, 2] -= turn[:, None] * (late - 0.5)
    phase = 2 * np.pi * periods * late
    sine, cosine = (
        2 / samples * np.einsum("k,nka->na", f(phase), angles) for f in (np.sin, np.cos)
    )
    level = angles.mean(axis=1)
    setting = cycles.setting
    if setting.axis == DECOUPLED:
        pitch = np.sin(np.abs(angles[:, :, 1]).max(axis=1))
        force = np.full(len(turn), np.nan)
    else:
        value, slope = _interpolation(samples)
        pitch = np.abs(sight.motion[:, :, 0] @ value.T).max(axis=1)
        rate = (sight.lift @ slope.T) * (2 * np.pi / period)[:, None]
        if setting.axis == ANY:
            force = (rate + sight.push @ value.T).min(axis=1)
        else:
            force = setting.parameters[0] * setting.parameters[3] + rate.min(axis=1)
    amplitude, phases = np.hypot(sine, cosine), np.arctan2(cosine, sine)
    for array in (velocity, amplitude, phases, level):
        array[tumbles] = np.nan
    return Measures(
        np.hypot(step[:, 0], step[:, 1]), velocity, turn / period, amplitude, phases, level, d,
        turn, pitch, force, tumbles,
    )  # fmt: skip


@lru_cache(maxsize=8)
def _interpolation(n: int) -> tuple[Array, Array]:
    """Values and slopes, per radian of the period, of the trigonometric interpolation of n samples
    at more points (points, n)."""
    points = _FINER * n
    spectrum = np.fft.rfft(np.eye(n), axis=0)
    order = np.arange(len(spectrum))
    if n % 2 == 0:
        spectrum[-1] *= 0.5
    value = points / n * np.fft.irfft(spectrum, points, axis=0)
    slope = points / n * np.fft.irfft(1j * order[:, None] * spectrum, points, axis=0)
    return value, slope
