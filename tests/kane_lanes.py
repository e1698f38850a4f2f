"""Kane's equations of `derivations.full_model` for many gaits side by side, in fixed steps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate._ivp import dop853_coefficients as dop853

from tests.derivations import PointMassRobot, _derive

Array = NDArray[np.float64]
_STAGES = dop853.N_STAGES
BACK = [0, 1, 3, 4, 5]
"""Of a state (roll, pitch, yaw, their rates, x, y, areas of x and y), what repeats."""


class Gaits(NamedTuple):
    """phi = offset + amplitude sin(omega t + phase); (n, 2) each but omega (n,)."""

    offset: Array
    amplitude: Array
    phase: Array
    omega: Array

    def rows(self, which: NDArray[np.int64]) -> Gaits:
        """Some of them, or some several times."""
        return Gaits(*(part[which] for part in self))


def _rate(gaits: Gaits, t: Array, y: Array, robot: PointMassRobot, damping: float) -> Array:
    """dy/dt (n, 10)."""
    n, w = len(y), gaits.omega[:, None]
    turn = w * t[:, None] + gaits.phase
    swing = gaits.amplitude * np.sin(turn)
    phi = gaits.offset + swing
    phi_dot, phi_ddot = gaits.amplitude * w * np.cos(turn), -w * w * swing
    q, u = np.column_stack((y[:, :3], phi)), np.column_stack((y[:, 3:6], phi_dot))
    _, partial, remainder, _, _ = _derive("full", "numpy")(list(q.T), list(u.T), *robot.lengths)
    P = np.empty((n, 15, 5))
    for i, row in enumerate(partial):
        for j, entry in enumerate(row):
            P[:, i, j] = entry
    b = np.empty((n, 15))
    for i, entry in enumerate(remainder):
        b[:, i] = entry
    m = np.repeat(robot.masses, 3)
    mP = m[:, None] * P[:, :, :3]
    M = np.einsum("nik,nij->nkj", mP, P)
    g = np.tile((0.0, 0.0, -robot.gravity), 5)
    f = np.einsum("nik,ni->nk", mP, g - b) - damping * y[:, 3:6]
    f -= np.einsum("nkj,nj->nk", M[:, :, 3:], phi_ddot)
    accelerations = np.linalg.solve(M[:, :, :3], f[:, :, None])[:, :, 0]
    pitch, yaw = y[:, 1], y[:, 2]
    along, across = np.cos(pitch) * y[:, 3], y[:, 4]
    path = robot.shell_radius * np.column_stack((
        np.sin(yaw) * along + np.cos(yaw) * across, -np.cos(yaw) * along + np.sin(yaw) * across
    ))  # fmt: skip
    return np.column_stack((y[:, 3:6], accelerations, path, y[:, 6:8]))


def carried(
    gaits: Gaits, y: Array, periods: int, steps: int, damping: float = 0.01
) -> tuple[Array, Array]:
    """States (n, 10) at the end and one period before it, by DOP853 in fixed steps."""
    robot, h = PointMassRobot(), 2 * np.pi / gaits.omega / steps
    slopes, before = np.empty((_STAGES, *y.shape)), y
    for k in range(periods * steps):
        if k == (periods - 1) * steps:
            before = y
        for s in range(_STAGES):
            at = y + h[:, None] * np.tensordot(dop853.A[s, :s], slopes[:s], 1) if s else y
            # Of the phase within a period, so that it does not lose digits.
            slopes[s] = _rate(gaits, h * (k % steps + dop853.C[s]), at, robot, damping)
        y = y + h[:, None] * np.tensordot(dop853.B, slopes, 1)
    return y, before


def monodromies(
    gaits: Gaits, y: Array, steps: int, damping: float = 0.01, step: float = 2e-3
) -> Array:
    """Derivatives (n, 5, 5) of what repeats over a period, by central differences of order six."""
    n, weights = len(y), {1: 45 / 60, 2: -9 / 60, 3: 1 / 60}
    moves = [(j, sign * k, sign * w) for j in range(5) for k, w in weights.items()
             for sign in (1, -1)]  # fmt: skip
    moved = np.repeat(y[None], len(moves), axis=0)
    for some, (j, k, _) in zip(moved, moves, strict=True):
        some[:, BACK[j]] += k * step
    lanes = gaits.rows(np.tile(np.arange(n), len(moves)))
    end = carried(lanes, moved.reshape(-1, y.shape[1]), 1, steps, damping)[0][:, BACK]
    out = np.zeros((n, 5, 5))
    for (j, _, weight), part in zip(moves, end.reshape(len(moves), n, 5), strict=True):
        out[:, :, j] += weight / step * part
    return out


def sorted_by_size(values: Array) -> Array:
    """Eigenvalues, the largest first, of a pair that with the positive imaginary part."""
    return values[np.lexsort((-values.imag, -np.abs(values).round(8)))]
