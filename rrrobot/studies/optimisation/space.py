"""What an optimiser may vary: bounds on a gait's numbers <-> points of a box <-> gaits.

A family of gaits has one frequency, and for each leg k

    phi_k = offset_k + winding_k w t + amplitude_k sin(u_k) + sum over j = 2 .. harmonics of
            sine_jk sin(j u_k) + cosine_jk cos(j u_k),    u_k = w t + phase_k,    phase_1 = 0,

and where that swings farther from the offset than the upper bound of the amplitude, it is scaled
down to it.

A point of the box holds those of these numbers whose bounds differ, each scaled to 0 .. 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.gaits import FourierGait, GaitBatch, SinusoidalGait
from rrrobot.drive.gaits.base import check_turns
from rrrobot.errors import ParameterError
from rrrobot.robot.chains import Ties
from rrrobot.robot.limits import LegJoints

MAX_HARMONICS = 6


class Space:
    """A box of gaits.

    Args:
        legs: of the robot.
        offset, amplitude, phase_difference: a number, which is kept; bounds (low, high) for all
            legs; or an array (legs, 2) of bounds for each [rad]. Phase differences are those of
            legs 2, 3, ... from leg 1.
        angular_frequency: number or bounds [rad/s].
        harmonics: 1 for sinusoids; more for Fourier gaits, whose whole swing stays within the
            largest amplitude.
        ties: legs that share one offset and one swing, mirrored as their axes are; None for none.
            Bounds of offset and amplitude are then those of each group's first leg, and phase
            differences those of the mirrored swings.
        winding: whole turns of each leg in a period (legs,), or one number for all; kept.

    Attributes:
        lower, upper: bounds of every number (m,).
        free: indices of those that may vary (n,).
        largest_swing: upper bounds of the amplitudes (legs,) [rad].

    Raises:
        ParameterError: bounds that are reversed, out of range, or of the wrong shape.
    """

    def __init__(
        self,
        legs: int,
        *,
        offset: ArrayLike,
        amplitude: ArrayLike,
        angular_frequency: ArrayLike,
        phase_difference: ArrayLike,
        harmonics: int = 1,
        ties: Ties | None = None,
        winding: ArrayLike = 0,
    ) -> None:
        if isinstance(harmonics, bool) or harmonics not in range(1, MAX_HARMONICS + 1):
            raise ParameterError(
                f"harmonics is {harmonics!r}: it must be a whole number from 1 to {MAX_HARMONICS}."
            )
        if legs < 1:
            raise ParameterError("the robot has no legs, so there is no gait to optimise.")
        self.legs, self.harmonics, self.tied = legs, int(harmonics), ties is not None
        ties = ties or Ties(np.arange(legs), np.ones(legs))
        self._group, self._sign = ties
        self.winding = vector("winding", winding, legs, broadcast=True)
        check_turns("winding", self.winding)
        each = int(self._group.max()) + 1
        swing = bounds("amplitude", amplitude, each, "rad", at_least=0.0)
        # No harmonic of a swing within +-a is larger than a square wave's first one, 4 a / pi.
        square = 4 / np.pi * swing[:, 1]
        higher = np.concatenate([square / j for j in range(2, harmonics + 1)] or [np.zeros(0)])
        first = swing.copy()
        if harmonics > 1:
            first[:, 1] = np.where(swing[:, 1] > swing[:, 0], square, swing[:, 1])
        parts = {
            "offset": bounds("offset", offset, each, "rad"),
            "amplitude": first,
            "phase": bounds("phase_difference", phase_difference, legs - 1, "rad"),
            "sine": np.column_stack((-higher, higher)),
            "cosine": np.column_stack((-higher, higher)),
            "angular_frequency": bounds(
                "angular_frequency", angular_frequency, 1, "rad/s", at_least=0.02, at_most=200.0
            ),
        }
        self._sizes = {name: len(part) for name, part in parts.items()}
        self.lower, self.upper = np.concatenate(list(parts.values())).T
        self.free = np.flatnonzero(self.upper > self.lower)
        self.largest_swing = swing[self._group, 1]
        self._given = {
            "offset": parts["offset"],
            "amplitude": swing,
            "phase_difference": parts["phase"],
            "angular_frequency": parts["angular_frequency"],
        }
        start = self._sizes["offset"] + self._sizes["amplitude"]
        phases = np.arange(start, start + self._sizes["phase"])
        self._whole_turns = phases[(self.upper - self.lower)[phases] > 2 * np.pi - 1e-9]

    @property
    def n(self) -> int:
        """Numbers that may vary."""
        return self.free.size

    def offsets(self) -> tuple[Array, Array]:
        """Bounds of each leg's offset (legs,), (legs,) [rad]."""
        low, high = (self._given["offset"] * np.ones((self.legs, 1))).T
        return low, high

    def box(self) -> tuple[Array, Array]:
        """Bounds of points for a local search (n,), (n,); a full turn of phase has no ends."""
        low, high = np.zeros(self.lower.size), np.ones(self.lower.size)
        low[self._whole_turns], high[self._whole_turns] = -1.0, 2.0
        return low[self.free], high[self.free]

    def sinusoidal(self) -> NDArray[np.bool_]:
        """Which coordinates (n,) are not those of higher harmonics, which vanish at 0.5."""
        at = self._sizes["offset"] + self._sizes["amplitude"] + self._sizes["phase"]
        return np.asarray((self.free < at) | (self.free == self.lower.size - 1))

    def population(self, points: Array) -> GaitBatch:
        """Gaits of points (s, n)."""
        values = np.tile(self.lower, (len(points), 1))
        values[:, self.free] += points * (self.upper - self.lower)[self.free]
        edges = np.cumsum(list(self._sizes.values()))[:-1]
        offset, amplitude, phase, sine, cosine, omega = np.split(values, edges, axis=1)
        s, legs, rest = len(points), self.legs, self.harmonics - 1
        turn = np.column_stack((np.zeros(s), phase))[:, None] * np.arange(1, rest + 2)[:, None]
        group, sign, shape = self._group, self._sign, (s, rest, self._sizes["offset"])
        own_sine = np.zeros((s, rest + 1, legs))
        own_cosine = own_sine.copy()
        own_sine[:, 0] = sign * amplitude[:, group]
        own_sine[:, 1:] = sign * sine.reshape(shape)[:, :, group]
        own_cosine[:, 1:] = sign * cosine.reshape(shape)[:, :, group]
        gaits = GaitBatch(
            np.ascontiguousarray(sign * offset[:, group]),
            np.tile(self.winding, (s, 1)),
            own_sine * np.cos(turn) - own_cosine * np.sin(turn),
            own_sine * np.sin(turn) + own_cosine * np.cos(turn),
            omega[:, 0].copy(),
        )
        return gaits.within(self.largest_swing) if rest else gaits

    def gait(self, point: Array) -> SinusoidalGait | FourierGait:
        """The gait of one point (n,)."""
        return self.population(point[None]).gait(0)

    def to_dict(self) -> dict[str, Any]:
        """Bounds as plain data."""
        named = {name: pairs.tolist() for name, pairs in self._given.items()}
        turns = [int(turn) for turn in self.winding]
        return named | {"harmonics": self.harmonics, "tied": self.tied, "winding": turns}


def bounds(
    name: str,
    value: ArrayLike,
    n: int,
    unit: str,
    *,
    at_least: float | None = None,
    at_most: float | None = None,
) -> Array:
    """Bounds (n, 2) from a number, which is kept, a pair for all, or one pair for each.

    Raises:
        ParameterError: with the name, the value and the rule.
    """
    each = f", or {n} such pairs" if n > 1 else ""
    rule = f"it must be one number, which is kept, or bounds (low, high){each} [{unit}]"
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iuf":
            raise TypeError
        array = array.astype(float)
    except (TypeError, ValueError):
        raise ParameterError(f"{name} is {value!r}: {rule}.") from None
    if array.ndim == 0:
        array = np.full((n, 2), float(array))
    elif array.shape == (2,):
        array = np.tile(array, (n, 1))
    if array.shape != (n, 2):
        raise ParameterError(f"{name} has shape {array.shape}: {rule}.")
    for low, high in array.tolist():
        finite(f"lower bound of {name}", low, unit, at_least=at_least)
        finite(f"upper bound of {name}", high, unit)
        if at_most is not None and high > at_most:
            raise ParameterError(f"{name} is up to {high:g} {unit}: the most is {at_most:g}.")
        if high < low:
            raise ParameterError(
                f"{name} has the bounds {low:g} and {high:g} {unit}: the lower one comes first."
            )
    return array


OFFSET, AMPLITUDE = (0.0, np.pi), (0.0, 0.5)
"""Bounds where neither a caller nor the robot's file names others [rad]."""


def swing_of(
    joints: LegJoints, offset: ArrayLike | None, amplitude: ArrayLike | None, ties: Ties | None
) -> dict[str, ArrayLike]:
    """Bounds of offset and amplitude as `Space` takes them: those given, or the file's."""
    if offset is None and amplitude is None:
        offset, amplitude = _file_bounds(joints, ties)
    return {
        "offset": OFFSET if offset is None else offset,
        "amplitude": AMPLITUDE if amplitude is None else amplitude,
    }


def _file_bounds(joints: LegJoints, ties: Ties | None) -> tuple[Array, Array]:
    """Bounds of offset and amplitude (legs, 2), or (groups, 2), all within the file's limits.

    A leg between lo and hi swings by at most a = min(0.5, (hi - lo) / 4) about lo + a ... hi - a.
    """
    low, high = joints.lower.copy(), joints.upper.copy()
    if ties is not None:
        turned = ties.sign < 0
        low, high = np.where(turned, -high, low), np.where(turned, -low, high)
        of = [ties.group == group for group in range(ties.group.max() + 1)]
        low = np.array([low[legs].max() for legs in of])
        high = np.array([high[legs].min() for legs in of])
    low, high = (np.where(np.abs(end) < 1e6, end, np.nan) for end in (low, high))
    room = np.where(np.isfinite(high - low), high - low, np.inf)
    swing = np.minimum(AMPLITUDE[1], room / 4)
    first = np.where(np.isfinite(low), low + swing, np.minimum(OFFSET[0], high - np.pi))
    last = np.where(np.isfinite(high), high - swing, np.maximum(OFFSET[1], low + np.pi))
    first = np.where(np.isfinite(first), first, OFFSET[0])
    last = np.where(np.isfinite(last), last, OFFSET[1])
    return np.column_stack((first, last)), np.column_stack((0 * swing, swing))
