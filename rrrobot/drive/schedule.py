"""A schedule: several gaits after each other, joined smoothly, from legs at rest to legs at rest.

All stretches have one base frequency w. In each the legs have constant coefficients, and between
two the coefficients are blended by the quintic q(u) = 6 u^5 - 15 u^4 + 10 u^3, whose first and
second derivatives are zero at both ends:

    phi(t) = o(t) + sum over j = 1, 2, ... of s_j(t) sin(j w t) + c_j(t) cos(j w t),

so angle, rate and acceleration are continuous everywhere. Sines and cosines are blended instead of
amplitudes and phases: a gait that is turned round passes through legs that do not swing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import Array, finite, vector
from rrrobot.drive.gaits import Gait, LegMotion
from rrrobot.errors import GaitError


class Stretch(NamedTuple):
    """A time with one gait; its coefficients are reached after the blend at its beginning."""

    duration: float
    """with the blend [s]"""
    offset: Array
    """(legs,) [rad]"""
    sine: Array
    """s_j (harmonics, legs) [rad]"""
    cosine: Array
    """c_j (harmonics, legs) [rad]"""


def stretch(
    duration: float, *, offset: ArrayLike, amplitude: ArrayLike = 0.0, phase: ArrayLike = 0.0
) -> Stretch:
    """A stretch of a sinusoidal gait: offset + amplitude sin(w t + phase) of each leg [rad].

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.drive.schedule import stretch
        >>> stretch(5.0, offset=(1.5, 1.5), amplitude=0.3, phase=(0.0, 1.57)).sine.shape
        (1, 2)
    """
    o, a, p = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (offset, amplitude, phase)))
    return Stretch(duration, o.copy(), (a * np.cos(p))[None], (a * np.sin(p))[None])


@serial.register("schedule")
class Schedule(Gait):
    """Stretches of gaits after each other; before the first and after the last the legs rest.

    Args:
        stretches: in their order; the last is followed by a blend to rest.
        angular_frequency: w of all stretches [rad/s].
        rest: leg angles before and after (legs,) [rad].
        blend: how long a blend takes [s]; no stretch may be shorter.

    Attributes:
        duration: until the legs are at rest again [s].
        levels: offset, sines and cosines before, in and after the stretches
            (stretches + 2, 1 + 2 harmonics, legs) [rad].
        begins: when the blend to each but the first begins (stretches + 1,) [s].

    Raises:
        GaitError: no stretch, arrays of different sizes, values that are not finite, a stretch
            that is shorter than the blend.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> from rrrobot.drive.schedule import Schedule, stretch
        >>> go = stretch(6.0, offset=(1.5, 1.5), amplitude=0.3, phase=(0.0, np.pi / 2))
        >>> gait = Schedule([go], angular_frequency=8.0, rest=(np.pi / 2, np.pi / 2), blend=2.0)
        >>> gait.duration, gait(0.0).rate.tolist(), gait(8.0).angle.round(4).tolist()
        (8.0, [0.0, 0.0], [1.5708, 1.5708])
    """

    def __init__(
        self,
        stretches: Sequence[Stretch],
        *,
        angular_frequency: float,
        rest: ArrayLike,
        blend: float,
    ) -> None:
        if not stretches:
            raise GaitError("a schedule needs at least one stretch.")
        self.rest = vector("rest", rest, np.size(rest), "rad", error=GaitError)
        self.n_legs = self.rest.size
        self.angular_frequency = finite("angular_frequency", angular_frequency, "rad/s", above=0)
        self.blend = finite("blend", blend, "s", above=0)
        self.stretches = tuple(self._checked(i, s) for i, s in enumerate(stretches))
        lengths = [s.duration for s in self.stretches]
        self.begins = np.concatenate(([0.0], np.cumsum(lengths)))
        self.duration = float(self.begins[-1] + self.blend)
        n = max(len(s.sine) for s in self.stretches)
        flat = [self._flat(s, n) for s in self.stretches]
        still = np.zeros_like(flat[0])
        still[0] = self.rest
        self.levels = np.array([still, *flat, still])
        self._orders = np.arange(1, n + 1)

    def _checked(self, i: int, s: Stretch) -> Stretch:
        length = finite(f"duration of stretch {i}", s.duration, "s", at_least=0)
        if length < self.blend * (1 - 1e-12):
            raise GaitError(
                f"stretch {i} takes {length:.6g} s: it must be at least the blend, "
                f"{self.blend:.6g} s."
            )
        offset = vector(f"offset of stretch {i}", s.offset, self.n_legs, "rad", error=GaitError)
        sine, cosine = (np.atleast_2d(np.asarray(x, dtype=float)) for x in (s.sine, s.cosine))
        if sine.shape != cosine.shape or sine.shape[1] != self.n_legs or sine.ndim != 2:
            raise GaitError(
                f"sine and cosine of stretch {i} have the shapes {sine.shape} and {cosine.shape}: "
                f"both must be (harmonics, {self.n_legs})."
            )
        if not (np.all(np.isfinite(sine)) and np.all(np.isfinite(cosine))):
            raise GaitError(f"sine and cosine of stretch {i} must be finite.")
        return Stretch(length, offset, sine, cosine)

    def _flat(self, s: Stretch, harmonics: int) -> Array:
        rows = np.zeros((1 + 2 * harmonics, self.n_legs))
        rows[0] = s.offset
        rows[1 : 1 + len(s.sine)] = s.sine
        rows[1 + harmonics : 1 + harmonics + len(s.cosine)] = s.cosine
        return rows

    def __call__(self, time: ArrayLike) -> LegMotion:
        t = np.asarray(time, dtype=float)
        parts = self._parts(np.atleast_1d(t), 3)
        return LegMotion(*(part[0] if t.ndim == 0 else part for part in parts))

    def angle_and_rate(self, time: Array) -> tuple[Array, Array]:
        """Leg angles [rad] and rates [rad/s] at many times (n,), each (n, legs)."""
        angle, rate = self._parts(time, 2)
        return angle, rate

    def _parts(self, time: Array, count: int) -> list[Array]:
        """Angle and its derivatives, `count` in all, each (n, legs)."""
        order = None
        if np.any(time[1:] < time[:-1]):
            order = np.argsort(time, kind="stable")
            time = time[order]
        w = self.angular_frequency * self._orders
        turn = np.multiply.outer(time, w)
        sine, cosine = np.sin(turn), np.cos(turn)
        # Sines and cosines, and their derivatives.
        waves = [np.hstack((sine, cosine)), np.hstack((w * cosine, -w * sine))]
        waves += [-np.hstack((w * w * sine, w * w * cosine))] if count > 2 else []
        out = [np.empty((time.size, self.n_legs)) for _ in range(count)]
        edges = np.searchsorted(time, self.begins[1:])
        ends = (*edges.tolist(), time.size)
        first = 0
        for i, last in enumerate(ends):
            if last > first:
                here = slice(first, last)
                self._blended(i, time[here], [wave[here] for wave in waves], out, here)
                first = last
        if order is not None:
            for part in out:
                part[order] = part.copy()
        return out

    def _blended(
        self, i: int, time: Array, waves: list[Array], out: list[Array], here: slice
    ) -> None:
        """What the legs do from the start of stretch i on: b + q c, c the change from b."""
        before, change = self.levels[i], self.levels[i + 1] - self.levels[i]
        u = np.clip((time - self.begins[i]) / self.blend, 0.0, 1.0)[:, None]
        q = u * u * u * (10.0 + u * (6.0 * u - 15.0))
        q1 = 30.0 * (u * (1.0 - u)) ** 2 / self.blend
        b, c = ([wave @ level[1:] for wave in waves] for level in (before, change))
        b[0], c[0] = b[0] + before[0], c[0] + change[0]
        out[0][here] = b[0] + q * c[0]
        out[1][here] = b[1] + q * c[1] + q1 * c[0]
        if len(out) > 2:
            q2 = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / self.blend**2
            out[2][here] = b[2] + q * c[2] + 2 * q1 * c[1] + q2 * c[0]

    def coefficients(self, time: float) -> Stretch:
        """The gait of an instant: offset, sines and cosines as they are blended there."""
        i = int(np.clip(np.searchsorted(self.begins, time, side="right") - 1, 0, None))
        u = float(np.clip((time - self.begins[i]) / self.blend, 0.0, 1.0))
        q = u * u * u * (10.0 + u * (6.0 * u - 15.0))
        level = (1.0 - q) * self.levels[i] + q * self.levels[i + 1]
        n = self._orders.size
        return Stretch(self.blend, level[0], level[1 : 1 + n], level[1 + n :])

    def halted(self, time: float) -> Schedule:
        """The same up to a time, and from there to rest in one blend.

        A blend that has begun is ended first, so the legs rest two blends after the time at most.

        Args:
            time: [s], zero or more.

        Example:
            >>> from rrrobot.drive.schedule import Schedule, stretch
            >>> go = stretch(6.0, offset=(1.5, 1.5), amplitude=0.3)
            >>> gait = Schedule([go], angular_frequency=8.0, rest=(1.5, 1.5), blend=2.0)
            >>> gait.halted(3.0).duration, gait.halted(0.5).duration, gait.halted(7.0).duration
            (5.0, 4.0, 8.0)
        """
        finite("time", time, "s", at_least=0)
        if time >= self.begins[-1]:
            return self
        last = int(np.searchsorted(self.begins, time, side="right")) - 1
        left = max(time - self.begins[last], self.blend)
        stretches = (*self.stretches[:last], self.stretches[last]._replace(duration=left))
        return Schedule(
            stretches, angular_frequency=self.angular_frequency, rest=self.rest, blend=self.blend
        )

    def to_dict(self) -> dict[str, Any]:
        return {
            "type": "schedule",
            "angular_frequency": self.angular_frequency,
            "rest": self.rest.tolist(),
            "blend": self.blend,
            "stretches": [
                {
                    "duration": s.duration,
                    "offset": s.offset.tolist(),
                    "sine": s.sine.tolist(),
                    "cosine": s.cosine.tolist(),
                }
                for s in self.stretches
            ],
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Schedule:
        """The schedule that `to_dict` wrote."""
        parts = [
            Stretch(s["duration"], *(np.asarray(s[key]) for key in ("offset", "sine", "cosine")))
            for s in data["stretches"]
        ]
        others = {key: data[key] for key in ("angular_frequency", "rest", "blend")}
        return cls(parts, **others)

    def __repr__(self) -> str:
        return (
            f"Schedule({len(self.stretches)} stretches, {self.duration:.6g} s, "
            f"angular_frequency={self.angular_frequency:g})"
        )
