"""Loops of two legs through a posture, sized to a yaw: what the yaw planner is made of."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.moves import LegMoves, Loops, Straight
from rrrobot.errors import GaitError
from rrrobot.reduction.connection import Connection
from rrrobot.reduction.yaw import Span, integral, yaw_rates

_REACH = 1.2
"""Largest amplitude of a loop where no limits are given [rad]."""
_SHORTEST = 0.25
"""Time that the shortest move of one leg takes [s]."""
_FEW = 40
"""Cycles that are accepted without moving the legs to a better place first."""


class _Family(NamedTuple):
    """Loops of two legs through one posture: ellipses of one shape and growing size."""

    base: Array
    direction: float
    """where on the ellipse the posture is [rad]"""
    reach: Array
    """largest amplitudes of the two legs [rad]"""

    def loops(self, pair: tuple[int, int], size: float, sense: int, turns: int) -> Loops:
        amplitude, phase = np.zeros((2, self.base.size))
        amplitude[list(pair)] = size * self.reach
        # phi = center + amplitude (cos, sin) of (direction + sense angle), both as sines.
        if sense > 0:
            phase[list(pair)] = self.direction + np.pi / 2, self.direction
        else:
            phase[list(pair)] = np.pi / 2 - self.direction, np.pi - self.direction
        center = self.base - amplitude * np.sin(phase)
        return Loops(center=center, amplitude=amplitude, phase=phase, turns=turns, duration=1.0)


class _Best(NamedTuple):
    family: _Family
    size: float
    yaw: float


class Planner:
    """Moves from one posture to another that turn the body by a given yaw; see `plan_yaw`."""

    def __init__(
        self,
        connection: Connection,
        pair: tuple[int, int],
        box: Array,
        start: Array,
        goal: Array,
        speed: float,
    ) -> None:
        self.connection, self.pair, self.box = connection, pair, box
        self.start, self.goal, self.speed = start, goal, speed
        self.yaw_rate = yaw_rates(connection.robot)

    def moves(self, turn: float, max_cycles: int) -> tuple[LegMoves, int, float, float]:
        """The motion, its cycles, the yaw of each, and the yaw of the straight moves."""
        base, straight = self.start, self.straight_yaw(self.start)
        best = None
        if abs(turn - straight) > 1e-12:
            best = self.best(base)
            if _cycles(turn - straight, best) > _FEW:
                base, best = self.better_base(turn, best)
                straight = self.straight_yaw(base)
        lacking = turn - straight
        cycles = 0 if best is None else _cycles(lacking, best)
        if best is not None and cycles > max_cycles:
            low, high = self.box.T
            raise GaitError(
                f"the yaw of {turn:.4g} rad cannot be reached within max_cycles = {max_cycles}: "
                f"within the leg limits {low.tolist()} .. {high.tolist()} rad the best loop gives "
                f"{abs(best.yaw):.2g} rad a cycle. Widen the limits, allow more cycles, or ask for "
                "less yaw."
            )
        parts: list[Straight | Loops] = self.one_by_one(self.start, base)
        if best is not None and cycles:
            parts.append(self.loops(best, lacking / cycles, cycles))
        parts += self.one_by_one(base, self.goal)
        if not parts:
            parts = [Straight(start=self.start, end=self.goal, duration=1.0)]
        return LegMoves(parts), cycles, lacking / cycles if cycles else 0.0, straight

    def one_by_one(self, start: Array, end: Array) -> list[Straight | Loops]:
        """First gait: each leg in turn."""
        moves: list[Straight | Loops] = []
        here = start
        for leg in np.flatnonzero(start != end):
            there = here.copy()
            there[leg] = end[leg]
            time = 2 * abs(there[leg] - here[leg]) / self.speed
            moves.append(Straight(start=here, end=there, duration=max(float(time), _SHORTEST)))
            here = there
        return moves

    def straight_yaw(self, base: Array) -> float:
        """Net yaw of the moves from the start to a posture and on to the goal."""
        moves = self.one_by_one(self.start, base) + self.one_by_one(base, self.goal)
        return sum(
            integral(lambda s, at=move.at: self.yaw_rate(*at(s)[:2]), Span(0.0, 1.0))  # type: ignore[misc]
            for move in moves
        )

    def loop_yaw(self, family: _Family, size: float, *, rough: bool = False) -> float:
        """Net yaw of one loop, counter-clockwise, by the trapezoidal rule: exact on a loop."""
        path = family.loops(self.pair, size, 1, 1)
        last = np.inf
        for n in (24,) if rough else (48, 96, 192, 384, 768):
            motion = path.at(np.arange(n) / n)
            yaw = float(self.yaw_rate(motion.angle, motion.rate).mean())
            if abs(yaw - last) < 1e-14:
                break
            last = yaw
        return yaw

    def best(self, base: Array, directions: int = 16) -> _Best:
        """The loop through a posture that turns the body most."""
        j, k = self.pair
        found = _Best(_Family(base, 0.0, np.zeros(2)), 0.0, 0.0)
        for direction in 2 * np.pi * (np.arange(directions) + 0.5) / directions:
            way = np.array((np.cos(direction), np.sin(direction)))
            room_up = (self.box[[j, k], 1] - base[[j, k]]) / (1 - way)
            room_down = (base[[j, k]] - self.box[[j, k], 0]) / (1 + way)
            reach = np.clip(np.minimum(room_up, room_down), 0.0, _REACH)
            if reach.min() <= 1e-6:
                continue
            family = _Family(base, float(direction), reach)
            for size in (1.0, 0.6):
                yaw = self.loop_yaw(family, size, rough=True)
                if abs(yaw) > abs(found.yaw):
                    found = _Best(family, size, yaw)
        return found if found.size == 0 else found._replace(yaw=self.loop_yaw(*found[:2]))

    def better_base(self, turn: float, best: _Best) -> tuple[Array, _Best]:
        """A posture with fewer cycles than the start's, if there is one."""
        fewest = _cycles(turn - self.straight_yaw(self.start), best)
        chosen = self.start, best
        low, high = np.clip(self.box, self.start[:, None] - 1.5, self.start[:, None] + 1.5).T
        for x in (0.2, 0.5, 0.8):
            for y in (0.2, 0.5, 0.8):
                base = self.start.copy()
                j, k = self.pair
                base[j], base[k] = low[j] + x * (high - low)[j], low[k] + y * (high - low)[k]
                other = self.best(base, 8)
                cycles = _cycles(turn - self.straight_yaw(base), other)
                if cycles < fewest:
                    fewest, chosen = cycles, (base, other)
        return chosen

    def loops(self, best: _Best, yaw: float, cycles: int) -> Loops:
        """The family's loop with exactly this yaw a cycle."""
        from scipy.optimize import brentq

        sense = 1 if yaw * best.yaw > 0 else -1
        size = best.size
        if abs(yaw) < abs(best.yaw):
            size = brentq(
                lambda s: self.loop_yaw(best.family, s) - sense * yaw if s > 0 else -sense * yaw,
                0.0, best.size, xtol=1e-15, rtol=1e-14,
            )  # fmt: skip
        path = best.family.loops(self.pair, float(size), sense, cycles)
        ramp = min(0.5, 0.5 / cycles)
        fastest = 2 * np.pi * cycles * float(path.amplitude.max()) / (1 - ramp)
        return Loops(
            center=path.center,
            amplitude=path.amplitude,
            phase=path.phase,
            turns=cycles,
            duration=fastest / self.speed,
            ramp=ramp,
        )


def _cycles(lacking: float, best: _Best) -> int:
    """How many loops a yaw takes; a huge number where loops give nothing."""
    if abs(lacking) <= 1e-12:
        return 0
    if abs(best.yaw) < 1e-9:
        return 10**12
    return int(np.ceil(abs(lacking / best.yaw) * (1 - 1e-12)))
