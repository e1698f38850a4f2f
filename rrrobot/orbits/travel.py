"""Travel to second order: speed and turning of small gaits as quadratic forms.

Let the legs move as phi_k = offset_k + s_k sin(w t) + c_k cos(w t), and gather u = (s, c). Half a
period later all deviations of a small motion have the opposite sign, so that what a cycle leaves
behind is even in u:

    (v_x, v_y, alpha)_i = u^T Q_i u + O(|u|^4)

The v are the quadratic part of the rolling contact,

    v_x = r cos(pitch_0) <yaw roll'>,    v_y = r <yaw pitch'> + r sin(pitch_0) <pitch roll'>,

means of products of the linear response, so that with first harmonics a sin(w t + p)

    v_y = r w a_yaw a_pitch sin(p_yaw - p_pitch) / 2

on an upright robot: it travels as far as yaw and pitch are out of phase. The yaw rate needs the
equations of motion to second order as well. Q is taken from exact limit cycles of amplitude
`SMALL` and twice that, for all pairs of coefficients, freed of the fourth order by Richardson's
rule; it holds for any robot that the engine runs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.gaits import Gait, GaitBatch, SinusoidalGait
from rrrobot.errors import GaitError, OrbitError
from rrrobot.momentum.batch import RESULT
from rrrobot.momentum.kernels import OK
from rrrobot.orbits.found import LONGEST_STEP, setting_for
from rrrobot.orbits.many import orbits_of

SMALL = 0.02
"""Amplitude of the cycles from which the forms are taken [rad]."""
_COLUMNS = [RESULT.index(name) for name in ("velocity_x", "velocity_y", "yaw_rate")]
_STEPS = 24


class Travel(NamedTuple):
    """What is predicted of a gait."""

    speed: float
    """[m/s]"""
    velocity: Array
    """along the body's mean x and y axes (2,) [m/s]"""
    yaw_rate: float
    """[rad/s]"""

    @property
    def curvature(self) -> float:
        """yaw_rate / speed [1/m]."""
        return self.yaw_rate / self.speed if self.speed > 1e-15 else 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class TravelForm:
    """Quadratic forms of travel for one offset and frequency.

    Attributes:
        offset: of the legs (legs,) [rad].
        angular_frequency: [rad/s].
        matrix: Q of v_x, v_y [m/s per rad^2] and the yaw rate [rad/s per rad^2]
            (3, 2 legs, 2 legs), symmetric; sines of all legs first, then cosines.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> form = rr.orbits.travel_form(model, offset=np.pi / 2, angular_frequency=8.0)
        >>> small = rr.gait("lateral", amplitude=0.03)
        >>> exact = rr.limit_cycle(model, small).speed
        >>> bool(abs(form.predict(small).speed / exact - 1) < 2e-3)
        True
    """

    offset: Array
    angular_frequency: float
    matrix: Array

    def predict(self, gait: Gait) -> Travel:
        """Travel of a gait of this offset and frequency, in microseconds.

        Raises:
            GaitError: it has another offset or frequency, or higher harmonics.
        """
        return self.of(*_first_harmonic(gait, self.offset, self.angular_frequency))

    def of(self, sine: Array, cosine: Array) -> Travel:
        """Travel of the legs' coefficients, each (legs,) [rad]."""
        u = np.concatenate((sine, cosine))
        x, y, turning = (self.matrix @ u) @ u
        return Travel(float(np.hypot(x, y)), np.array((x, y)), float(turning))

    def best(self) -> tuple[SinusoidalGait, Travel]:
        """The gait of amplitude norm 1 rad in u that is fastest along the leg axis, and its travel.

        Scale its amplitudes by A: the speed goes with A^2.
        """
        values, vectors = np.linalg.eigh(self.matrix[1])
        u = vectors[:, np.argmax(np.abs(values))]
        sine, cosine = np.split(u, 2)
        gait = SinusoidalGait(
            offset=self.offset,
            amplitude=np.hypot(sine, cosine),
            angular_frequency=self.angular_frequency,
            phase=np.arctan2(cosine, sine),
        )
        return gait, self.of(sine, cosine)


def travel_form(model: Any, *, offset: ArrayLike, angular_frequency: float) -> TravelForm:
    """The quadratic forms of travel of a model about an offset at a frequency.

    Args:
        model: with damping, as for `limit_cycle`.
        offset: of all legs or of each [rad].
        angular_frequency: [rad/s].

    Raises:
        OrbitError: small cycles about this offset do not hold: the robot tips over there.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> rr.orbits.travel_form(model, offset=0.9, angular_frequency=8.0).matrix.shape
        (3, 4, 4)
    """
    legs = model.robot.n_legs
    centre = vector("offset", offset, legs, "rad", broadcast=True, error=GaitError)
    omega = finite("angular_frequency", angular_frequency, "rad/s", above=0, error=GaitError)
    n = 2 * legs
    pairs = [(i, j) for i in range(n) for j in range(i, n)]
    units = np.array([np.eye(n)[i] + (i != j) * np.eye(n)[j] for i, j in pairs])
    u = np.concatenate((SMALL * units, 2 * SMALL * units))
    gaits = GaitBatch(
        np.tile(centre, (len(u), 1)), np.zeros((len(u), legs)), u[:, None, :legs],
        u[:, None, legs:], np.full(len(u), omega),
    )  # fmt: skip
    steps = max(_STEPS, int(np.ceil(2 * np.pi / omega / LONGEST_STEP)))
    found = orbits_of(setting_for(model), gaits, steps).results
    if np.any(found[:, -1] != OK):
        raise OrbitError(
            f"small cycles about the offset {centre.tolist()} rad at {omega:g} rad/s do not hold, "
            "so there is no travel to second order: choose another offset or more damping."
        )
    small, twice = np.split(found[:, _COLUMNS], 2)
    values = (4 * small / SMALL**2 - twice / (2 * SMALL) ** 2) / 3
    matrix = np.zeros((3, n, n))
    for (i, j), value in zip(pairs, values, strict=True):
        if i == j:
            matrix[:, i, i] = value
    for (i, j), value in zip(pairs, values, strict=True):
        if i != j:
            part = 0.5 * (value - matrix[:, i, i] - matrix[:, j, j])
            matrix[:, i, j] = matrix[:, j, i] = part
    return TravelForm(offset=centre, angular_frequency=omega, matrix=matrix)


def _first_harmonic(gait: Gait, offset: Array, omega: float) -> tuple[Array, Array]:
    found = gait.harmonics()
    if np.any(found.sine[1:]) or np.any(found.cosine[1:]) or np.any(found.winding):
        raise GaitError("travel to second order is of gaits with one harmonic: sinusoidal ones.")
    frequency, centre = found.angular_frequency, found.offset
    same = np.allclose(frequency, omega, rtol=1e-9) and np.shape(centre) == offset.shape
    if not same or not np.allclose(centre, offset, rtol=0, atol=1e-9):
        raise GaitError(
            f"the gait has offset {centre.tolist()} rad and {frequency:g} rad/s; this form is of "
            f"{offset.tolist()} rad and {omega:g} rad/s: make another with travel_form."
        )
    return found.sine[0], found.cosine[0]
