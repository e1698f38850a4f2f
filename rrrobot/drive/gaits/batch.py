"""Many periodic gaits side by side: what sweeps, optimisers and the engine take.

There is no other form of a batch: every periodic gait has one row here, see `Gait.harmonics`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array
from rrrobot.drive.gaits.base import Gait
from rrrobot.drive.gaits.fourier import FourierGait
from rrrobot.drive.gaits.sinusoidal import SinusoidalGait
from rrrobot.errors import GaitError

_POINTS = 256
# NumPy's own loops may round an entry by where it stands in an array.
_COS, _SIN = (np.frompyfunc(f, 1, 1) for f in (math.cos, math.sin))


class GaitBatch(NamedTuple):
    """Gaits, one a row, with u = omega t:

    phi = offset + winding u + sum over j = 1, 2, ... of sine_j sin(j u) + cosine_j cos(j u).
    """

    offset: Array
    """(n, legs) [rad]"""
    winding: Array
    """whole turns of each leg in a period (n, legs)"""
    sine: Array
    """(n, harmonics, legs) [rad]"""
    cosine: Array
    """(n, harmonics, legs) [rad]"""
    angular_frequency: Array
    """omega (n,) [rad/s]"""

    @classmethod
    def sinusoidal(
        cls,
        offset: Array,
        amplitude: Array,
        phase: Array,
        angular_frequency: Array,
        winding: Array | None = None,
    ) -> GaitBatch:
        """phi = offset + winding u + amplitude sin(u + phase); each array (n, legs)."""
        sine = amplitude * np.asarray(_COS(phase), dtype=float)
        cosine = amplitude * np.asarray(_SIN(phase), dtype=float)
        turns = np.zeros_like(offset) if winding is None else winding
        return cls(offset, turns, sine[:, None], cosine[:, None], angular_frequency)

    @classmethod
    def of(cls, gaits: Sequence[Gait]) -> GaitBatch:
        """Periodic gaits of any kind, side by side.

        Raises:
            GaitError: no gait, other numbers of legs, one that does not repeat.
        """
        if not len(gaits):
            raise GaitError("there is no gait: give at least one.")
        rows = []
        for i, gait in enumerate(gaits):
            if not isinstance(gait, Gait):
                raise GaitError(f"gait {i} is {gait!r}: it must be a Gait.")
            if gait.n_legs != gaits[0].n_legs:
                raise GaitError(f"gait {i} has {gait.n_legs} legs, gait 0 {gaits[0].n_legs}.")
            try:
                rows.append(gait.harmonics())
            except GaitError as error:
                raise GaitError(f"gait {i}: {error}") from None
        most = max(len(row.sine) for row in rows)

        def filled(part: Array) -> Array:
            return np.vstack((part, np.zeros((most - len(part), part.shape[1]))))

        return cls(
            np.array([row.offset for row in rows]),
            np.array([row.winding for row in rows], dtype=float),
            np.array([filled(row.sine) for row in rows]),
            np.array([filled(row.cosine) for row in rows]),
            np.array([row.angular_frequency for row in rows]),
        )

    @property
    def n(self) -> int:
        """Number of gaits; `len` is that of the tuple."""
        return len(self.offset)

    @property
    def order(self) -> int:
        """The highest harmonic of the motion; a leg that goes round k times in a period has k."""
        return max(self.sine.shape[1], int(np.abs(self.winding).max(initial=0.0)))

    def rows(self, which: Any) -> GaitBatch:
        """Some of the gaits: indices, a slice or a mask."""
        return GaitBatch(*(part[which] for part in self))

    def contiguous(self) -> GaitBatch:
        """The same, as compiled code takes it."""
        return GaitBatch(*(np.ascontiguousarray(part, dtype=np.float64) for part in self))

    def gait(self, row: int) -> SinusoidalGait | FourierGait:
        """The gait of a row; sinusoidal if that is all it is."""
        offset, omega = self.offset[row], float(self.angular_frequency[row])
        sine, cosine, winding = self.sine[row], self.cosine[row], self.winding[row]
        if len(sine) > 1 or np.any(winding):
            return FourierGait(
                offset=offset, cosine=cosine, sine=sine, angular_frequency=omega, winding=winding
            )
        return SinusoidalGait(
            offset=offset,
            amplitude=np.hypot(sine[0], cosine[0]),
            angular_frequency=omega,
            phase=np.arctan2(cosine[0], sine[0]) % (2 * np.pi),
        )

    def swing(self) -> tuple[Array, Array, Array]:
        """Swings about the legs' even course, with their rates and accelerations, through a
        period, each (n, points, legs)."""
        harmonic = np.arange(1, self.sine.shape[1] + 1)[:, None]
        turn = 2 * np.pi * np.arange(_POINTS) / _POINTS * harmonic
        s, c = np.sin(turn).T, np.cos(turn).T
        w = self.angular_frequency[:, None, None] * harmonic
        swing, rate = s @ self.sine + c @ self.cosine, c @ (w * self.sine) - s @ (w * self.cosine)
        return swing, rate, -(s @ (w * w * self.sine) + c @ (w * w * self.cosine))

    def fastest(self) -> tuple[Array, Array]:
        """Largest rate and acceleration of any leg, each (n,) [rad/s], [rad/s^2]."""
        rate = self.extent()[1].max(axis=1)
        if self.sine.shape[1] == 1:
            swing = np.hypot(self.sine, self.cosine)[:, 0].max(axis=1)
            return rate, swing * self.angular_frequency**2
        return rate, np.abs(self.swing()[2]).max(axis=(1, 2))

    def extent(self) -> tuple[Array, Array]:
        """How far each leg swings to a side of its offset, and its largest rate, each (n, legs).

        [rad], [rad/s]; infinitely far if it goes round.
        """
        omega, goes = (
            self.angular_frequency[:, None],
            self.winding * self.angular_frequency[:, None],
        )
        if self.sine.shape[1] == 1:
            swing = np.hypot(self.sine, self.cosine)[:, 0]
            fastest = np.abs(goes) + swing * omega
        else:
            motion = self.swing()
            swing = np.abs(motion[0]).max(axis=1)
            fastest = np.abs(motion[1] + goes[:, None]).max(axis=1)
        return np.where(self.winding != 0, np.inf, swing), fastest

    def reach(self) -> tuple[Array, Array, Array]:
        """Least and greatest position and greatest rate of each leg, each (n, legs)."""
        swing, rate = self.extent()
        if self.sine.shape[1] == 1:
            return self.offset - swing, self.offset + swing, rate
        motion, goes = self.swing()[0], self.winding != 0
        low, high = motion.min(axis=1), motion.max(axis=1)
        return (
            np.where(goes, -np.inf, self.offset + low), np.where(goes, np.inf, self.offset + high),
            rate,
        )  # fmt: skip

    def within(self, swing: ArrayLike) -> GaitBatch:
        """The gaits, those legs scaled down that swing more than (legs,) to a side."""
        largest = np.abs(self.swing()[0]).max(axis=1)
        factor = swing / np.maximum(largest, np.maximum(swing, 1e-300))
        return self._replace(sine=self.sine * factor[:, None], cosine=self.cosine * factor[:, None])
