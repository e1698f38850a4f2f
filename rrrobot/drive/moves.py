"""Leg motions from rest to rest: straight moves and loops, one after the other, in smooth time.

Yaw follows from the path of the legs alone, not from its timing, so a motion is a list of curves
phi(s), 0 <= s <= 1, and each is run through with the time scaling of `ease`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import Array, finite, vector
from rrrobot.drive.gaits import Gait, LegMotion, SinusoidalGait
from rrrobot.errors import GaitError


def ease(x: ArrayLike, ramp: float = 0.5) -> tuple[Array, Array, Array]:
    """Time scaling s(x) from rest to rest with its first and second derivative, x = t / T.

    The speed rises as 10 y^3 - 15 y^4 + 6 y^5 over the first `ramp` of the time, is constant, and
    falls likewise; its peak is 1 / (1 - ramp). s is three times continuously differentiable, so
    motor torques have no kinks.

    Example:
        >>> from rrrobot.drive.moves import ease
        >>> [float(part) for part in ease(0.5)]
        [0.5, 2.0, 0.0]
    """
    time = np.clip(np.asarray(x, dtype=float), 0.0, 1.0)
    early = np.minimum(time, 1 - time)
    y = np.minimum(early / ramp, 1.0)
    peak = 1 / (1 - ramp)
    gone = peak * (ramp * y**4 * (2.5 - 3 * y + y**2) + np.maximum(early - ramp, 0.0))
    rate = peak * y**3 * (10 - 15 * y + 6 * y**2)
    bend = peak / ramp * 30 * (y * (1 - y)) ** 2
    late = time > 0.5
    return np.where(late, 1 - gone, gone), rate, np.where(late, -bend, bend)


class Move:
    """A curve phi(s), 0 <= s <= 1, that the legs run through from rest to rest."""

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The move of the entries that `to_dict` wrote."""
        return cls(**{k: np.array(v) if isinstance(v, list) else v for k, v in data.items()})


@serial.register("straight")
@dataclass(frozen=True, kw_only=True, eq=False)
class Straight(Move):
    """phi(s) = start + s (end - start), in `duration` seconds."""

    start: Array
    end: Array
    duration: float
    ramp: float = 0.5

    def at(self, s: Array) -> LegMotion:
        """phi (n, legs) and its derivatives by s."""
        way = self.end - self.start
        rate = np.tile(way, (s.size, 1))
        return LegMotion(self.start + s[:, None] * way, rate, np.zeros_like(rate))

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "type": "straight",
            "start": self.start.tolist(),
            "end": self.end.tolist(),
            "duration": self.duration,
            "ramp": self.ramp,
        }


@serial.register("loops")
@dataclass(frozen=True, kw_only=True, eq=False)
class Loops(Move):
    """phi_k(s) = center_k + amplitude_k sin(2 pi turns s + phase_k), in `duration` seconds."""

    center: Array
    amplitude: Array
    phase: Array
    turns: int
    duration: float
    ramp: float = 0.5

    def at(self, s: Array) -> LegMotion:
        """phi (n, legs) and its derivatives by s."""
        speed = 2 * np.pi * self.turns
        # Whole turns are dropped before the sine, so that each is the same to the last digit.
        angle = 2 * np.pi * np.mod(self.turns * s, 1.0)[:, None] + self.phase
        swing = self.amplitude * np.sin(angle)
        rate = speed * self.amplitude * np.cos(angle)
        return LegMotion(self.center + swing, rate, -(speed**2) * swing)

    @property
    def start(self) -> Array:
        """Where the loops start and end (legs,) [rad]."""
        return np.asarray(self.center + self.amplitude * np.sin(self.phase))

    @property
    def end(self) -> Array:
        """The same posture."""
        return self.start

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        numbers = {key: getattr(self, key).tolist() for key in ("center", "amplitude", "phase")}
        timing = {"duration": self.duration, "ramp": self.ramp}
        return {"type": "loops", "turns": self.turns} | numbers | timing


@serial.register("leg_moves")
class LegMoves(Gait):
    """Moves one after the other, each from rest to rest; the legs stay where the last one ends.

    Args:
        moves: `Straight` and `Loops`, each starting where the one before ends; at least one.

    Attributes:
        duration: of all moves [s].
        knots: instants between which the motion is smooth [s].

    Raises:
        GaitError: no move, or moves that do not join.

    Example:
        >>> import rrrobot as rr
        >>> gait = rr.drive.one_leg_gait((1.2, 1.5), leg=1, target=2.0)
        >>> gait(gait.duration).angle.tolist()
        [1.2, 2.0]
    """

    def __init__(self, moves: Sequence[Straight | Loops]) -> None:
        self.moves = tuple(moves)
        if not self.moves:
            raise GaitError("moves is empty: give at least one move.")
        for one, two in zip(self.moves, self.moves[1:], strict=False):
            if one.end.shape != two.start.shape or np.abs(one.end - two.start).max() > 1e-12:
                raise GaitError(
                    f"a move ends at {one.end.tolist()} rad and the next one starts at "
                    f"{two.start.tolist()} rad: they must join."
                )
        self.n_legs = self.moves[0].start.size
        self._starts = np.cumsum([0.0, *(move.duration for move in self.moves)])
        self.duration = float(self._starts[-1])
        self.knots = tuple(
            float(begin + part * move.duration)
            for begin, move in zip(self._starts, self.moves, strict=False)
            for part in sorted({0.0, move.ramp, 1 - move.ramp})
        )

    def __call__(self, time: ArrayLike) -> LegMotion:
        times = np.atleast_1d(np.asarray(time, dtype=float))
        which = np.searchsorted(self._starts[1:-1], times, side="right")
        out = np.empty((3, times.size, self.n_legs))
        for i in np.unique(which):
            move, mine = self.moves[i], np.flatnonzero(which == i)
            x = (times[mine] - self._starts[i]) / move.duration
            s, rate, bend = ease(x, move.ramp)
            path = move.at(s)
            rate, bend = rate[:, None] / move.duration, bend[:, None] / move.duration**2
            out[0, mine] = path.angle
            out[1, mine] = path.rate * rate
            out[2, mine] = path.rate * bend + path.acceleration * rate**2
        shape = (*np.shape(time), self.n_legs)
        return LegMotion(*(part.reshape(shape) for part in out))

    def to_dict(self) -> dict[str, Any]:
        return {"type": "leg_moves", "moves": [move.to_dict() for move in self.moves]}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> LegMoves:
        """The moves that `to_dict` wrote."""
        return cls([serial.from_dict(move, Move, "move") for move in data["moves"]])  # type: ignore[misc]


def one_leg_gait(start: ArrayLike, *, leg: int, target: float, max_rate: float = 2.4) -> LegMoves:
    """The paper's first gait: one leg moves from rest to rest, the others stay; acyclic.

    Its net yaw is -(integral of A_leg d phi_leg), which `net_yaw` gives; on RRRobot, leg 1,

        integral of M_l l b sin phi_1 / g11(phi_1, phi_2) d phi_1 .

    Args:
        start: leg angles (legs,) [rad].
        leg: index of the leg that moves.
        target: where it ends [rad].
        max_rate: its highest rate [rad/s].

    Raises:
        GaitError: no such leg, or it is there already; numbers out of range.

    Example:
        >>> import rrrobot as rr
        >>> gait = rr.drive.one_leg_gait((1.2, 1.5), leg=0, target=2.0)
        >>> round(rr.reduction.net_yaw(rr.Robot.from_parameters(), gait), 4)
        0.1664
    """
    first = vector("start", start, np.size(start), "rad", error=GaitError)
    speed = finite("max_rate", max_rate, "rad/s", above=0, error=GaitError)
    if (
        not isinstance(leg, (int, np.integer))
        or isinstance(leg, bool)
        or leg not in range(first.size)
    ):
        raise GaitError(f"leg is {leg!r}: it must be a number 0 .. {first.size - 1}.")
    last = first.copy()
    last[leg] = finite("target", target, "rad", error=GaitError)
    way = abs(last[leg] - first[leg])
    if way == 0:
        raise GaitError(f"leg {leg} is at {target} rad already: use StillLegs.")
    return LegMoves([Straight(start=first, end=last, duration=2 * way / speed)])


def out_of_phase_gait(
    *,
    offset: ArrayLike,
    amplitude: ArrayLike = 0.3,
    phase_difference: float = np.pi / 2,
    angular_frequency: float = 8.0,
) -> SinusoidalGait:
    """The paper's second gait: both legs in sinusoids, leg 2 ahead by a phase difference; cyclic.

    Its net yaw per cycle is the area integral of the height function over its ellipse, which
    `net_yaw` gives. Fig 13's trajectories are offset 5 pi/8 + 0.15 (A) and pi/2 (B).

    Args:
        offset: centre of both legs, or of each (2,) [rad].
        amplitude: likewise [rad].
        phase_difference: [rad].
        angular_frequency: [rad/s].

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> A = rr.drive.out_of_phase_gait(offset=5 * np.pi / 8 + 0.15)
        >>> round(rr.reduction.net_yaw(rr.Robot.from_parameters(), A), 8)
        -0.01299623
    """
    return SinusoidalGait(
        offset=offset,
        amplitude=amplitude,
        angular_frequency=angular_frequency,
        phase=(0.0, finite("phase_difference", phase_difference, "rad", error=GaitError)),
    )
