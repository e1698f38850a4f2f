"""Small gaits: travel as Hermitian forms of the legs' complex amplitudes, and the best of them.

About a posture and at a frequency w let the legs move as phi_j = offset_j + Im(a_j exp(i w t)).
A settled cycle on level ground does not know when it began, so to second order

    (v_x, v_y, yaw rate)_k = a^H H_k a,      roll = Im(R_roll a exp(i w t)),  pitch likewise

with H_k Hermitian: n^2 cycles of the engine give all three for n joints. With M Hermitian and
positive, which weighs the swings against their room and the rocking against the tilt allowed, the
best small gait of a goal with weights c is the eigenvector of the largest eigenvalue of

    (sum_k c_k H_k) a = lambda M a

and the next eigenvectors are other ways to go there. They are exact for small gaits; how far they
reach is for the engine to say.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.drive.gaits import GaitBatch
from rrrobot.escape.bench import Bench
from rrrobot.momentum.kernels import OK

Complex = NDArray[np.complex128]
SMALL = 0.03
"""Amplitude of the cycles from which the forms are taken [rad]."""
_FREEST = 1e-3


class SmallGaits(NamedTuple):
    """Travel and rocking of small gaits about a posture at a frequency."""

    offset: Array
    """(legs,) [rad]"""
    omega: float
    """[rad/s]"""
    travel: Complex
    """H of v_x, v_y [m/s per rad^2] and the yaw rate [rad/s per rad^2] (3, legs, legs)"""
    rocking: Complex
    """R of roll and pitch [rad per rad] (2, legs)"""


def small_gaits(bench: Bench, offset: Array, omegas: Array) -> list[SmallGaits]:
    """The forms about a posture (legs,) at frequencies, without those where nothing settles."""
    legs = offset.size
    pairs = [(j, k) for j in range(legs) for k in range(j + 1, legs)]
    first, second = (np.array(pairs, dtype=int).reshape(-1, 2)[:, i] for i in (0, 1))
    eye = np.eye(legs, dtype=complex)
    units = np.concatenate((eye, eye[first] + eye[second], eye[first] + 1j * eye[second]))
    swing = SMALL * np.tile(units, (len(omegas), 1))
    gaits = GaitBatch(
        np.tile(offset, (len(swing), 1)), np.zeros(swing.shape), swing.real[:, None].copy(),
        swing.imag[:, None].copy(), np.repeat(omegas, len(units)),
    )  # fmt: skip
    found = bench(gaits, forces=False, clearance=False)
    out, m = [], len(pairs)
    for i, omega in enumerate(omegas):
        here = slice(i * len(units), (i + 1) * len(units))
        if np.any(found.status[here] != OK):
            continue
        value = found.travel[here] / SMALL**2
        single, inphase, quarter = value[:legs], value[legs : legs + m], value[legs + m :]
        own = single[first] + single[second]
        form = np.zeros((3, legs, legs), dtype=complex)
        form[:, np.arange(legs), np.arange(legs)] = single.T
        # |a_j + a_k|: 2 Re H_jk; with a_k = i: 2 Re(i H_jk) = -2 Im H_jk.
        mixed = 0.5 * (inphase - own) - 0.5j * (quarter - own)
        form[:, first, second], form[:, second, first] = mixed.T, mixed.conj().T
        rocking: Complex = found.rocking[here][:legs].T / SMALL
        out.append(SmallGaits(offset, float(omega), form, rocking))
    return out


def cost(small: SmallGaits, room: Array, tilt: float) -> Complex:
    """M: a gait of a^H M a = 1 uses up about what room and tilt there is.

    Args:
        small: the forms.
        room: largest swing of each leg (legs,) [rad].
        tilt: allowed [rad].
    """
    size = np.diag(1.0 / np.maximum(room, _FREEST) ** 2).astype(complex)
    rocking = small.rocking.conj().T @ small.rocking / tilt**2
    return np.asarray(0.25 * size + rocking)


def best_small(
    form: Complex, metric: Complex, basis: Array, count: int
) -> list[tuple[float, Complex]]:
    """Largest eigenvalues and their amplitudes (legs,) with a^H M a = 1, within a space of gaits.

    Args:
        form: Hermitian (legs, legs).
        metric: M (legs, legs).
        basis: columns span the real space of gaits (legs, m).
        count: at most.
    """
    inner = basis.T @ form @ basis
    weight = basis.T @ metric @ basis
    values, vectors = scipy.linalg.eigh(inner, weight)
    found = []
    for value, z in list(zip(values, vectors.T, strict=True))[::-1][:count]:
        if value > 0:
            found.append((float(value), basis @ z))
    return found


def straight(form: Complex, aside: Sequence[Complex], metric: Complex) -> tuple[float, Complex]:
    """The best small gait that does nothing aside, or next to nothing, and its value.

    The greatest a^H H a with a^H H_i a = 0 and a^H M a = 1 is the least of the largest eigenvalues
    of H + sum_i mu_i H_i over mu, a convex function: for one such condition exactly (Toeplitz and
    Hausdorff), for two from three joints on.
    """
    from scipy.optimize import minimize

    root = np.linalg.inv(np.linalg.cholesky(metric))
    whole, *others = (root @ part @ root.conj().T for part in (form, *aside))
    scale = [np.linalg.norm(whole) / max(float(np.linalg.norm(part)), 1e-300) for part in others]

    def mixed(mu: Array) -> Complex:
        parts = zip(mu, scale, others, strict=True)
        return np.asarray(whole + sum(m * s * part for m, s, part in parts))

    options: Any = {"maxiter": 80, "xatol": 1e-3, "fatol": 1e-12}

    def largest(mu: Array) -> float:
        return float(np.linalg.eigvalsh(mixed(mu))[-1])

    found = minimize(
        largest, np.zeros(len(others)),
        method="Nelder-Mead", options=options,
    )  # fmt: skip
    values, vectors = np.linalg.eigh(mixed(found.x))
    return float(values[-1]), np.asarray(root.conj().T @ vectors[:, -1])


def leaning(small: SmallGaits, metric: Complex, ahead: float, left: float) -> Complex:
    """Amplitudes (legs,) with a^H M a = 1 that lean most ahead and to the left; zero if none do."""
    # Ahead is pitch, to the left is minus roll.
    response = ahead * small.rocking[1] - left * small.rocking[0]
    a = np.linalg.solve(metric, response.conj())
    size = np.sqrt(np.real(a.conj() @ metric @ a))
    return np.asarray(a / size if size > 0 else a)
