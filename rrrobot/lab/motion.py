"""A motion to be played: one period and the screw that leads to the next, or a whole run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.view.film import thin


class Screw(NamedTuple):
    """What a period does: x -> d + R(turn) x in the ground plane."""

    turn: float
    """[rad]"""
    displacement: Array
    """d (2,) [m]"""

    def power(self, k: NDArray[np.int64] | int) -> tuple[Array, Array]:
        """Turns (n,) [rad] and displacements (n, 2) [m] of k periods."""
        count = np.atleast_1d(np.asarray(k, dtype=float))
        d = complex(*self.displacement)
        one = np.exp(1j * self.turn)
        if abs(one - 1) < 1e-9:
            moved = count * d
        else:
            moved = d * (np.exp(1j * self.turn * count) - 1) / (one - 1)
        return self.turn * count, np.column_stack((moved.real, moved.imag))


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """What can be drawn and played.

    Attributes:
        trajectory: one period of a motion that repeats, both ends included; else a whole run.
        screw: what a period of it does; None for a run.
        horizon: time over which the path is drawn [s].
    """

    trajectory: Trajectory
    screw: Screw | None
    horizon: float

    @property
    def period(self) -> float:
        """Time after which playing starts anew, elsewhere if there is a screw [s]."""
        return float(self.trajectory.time[-1])

    def path(self, detail: float = 0.0) -> Array:
        """Contact point over the horizon (n, 2) [m]; about one for each `detail` [m] if given."""
        points = self.trajectory.position
        if self.screw is None:
            return points[thin(points, detail)] if detail > 0 else points
        kept = thin(points, detail) if detail > 0 else np.arange(len(points))
        # The last point is the first of the next period.
        if len(kept) > 1 and np.linalg.norm(points[kept[-1]] - points[-1]) <= detail:
            kept = kept[:-1]
        path = screwed(points[kept], self.screw, self._periods())
        return path[thin(path, detail)] if len(kept) == 1 else path

    def end(self) -> Array:
        """Last point of the path (2,) [m]."""
        points = self.trajectory.position
        if self.screw is None:
            return points[-1]
        turns, moved = self.screw.power(self._periods() - 1)
        c, s = math.cos(turns[0]), math.sin(turns[0])
        return np.array(((c, -s), (s, c))) @ points[-2] + moved[0]

    def mean_path(self) -> Array:
        """Cycle means of the contact point over the horizon (n, 2) [m]."""
        points = self.trajectory.position
        if self.screw is None:
            per = max(1, round((self.trajectory.period or self.period) / self._interval()))
            if len(points) < 2 * per:
                return points[:1]
            sums = np.cumsum(np.vstack((np.zeros((1, 2)), points)), axis=0)
            return np.asarray((sums[per:] - sums[:-per])[::per] / per)
        mean = period_mean(points)[None]
        return screwed(mean, self.screw, self._periods())

    def frame(self, time: float) -> tuple[Array, pin.SE3, float]:
        """Configuration (nq,), where to put it, and the sample it is near, at a time [s]."""
        t = self.trajectory.time
        laps, late = divmod(time, self.period)
        at = min(late / self._interval(), len(t) - 1.000001)
        i = int(at)
        model = self.trajectory.robot.model
        q = self.trajectory.configuration
        now = pin.interpolate(model, q[i], q[i + 1], at - i)
        if self.screw is None:
            return now, pin.SE3.Identity(), at
        turns, moved = self.screw.power(int(laps))
        c, s = math.cos(turns[0]), math.sin(turns[0])
        turn = np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
        return now, pin.SE3(turn, np.array((*moved[0], 0.0))), at

    def _interval(self) -> float:
        t = self.trajectory.time
        return float(t[1] - t[0])

    def _periods(self) -> int:
        return max(1, round(self.horizon / self.period))


def screwed(points: Array, screw: Screw, laps: int) -> Array:
    """Points (n, 2) of one period, and where each of the next periods puts them."""
    turns, moved = screw.power(np.arange(laps))
    z = points[:, 0] + 1j * points[:, 1]
    out = np.exp(1j * turns)[:, None] * z + (moved[:, 0] + 1j * moved[:, 1])[:, None]
    return np.column_stack((out.real.ravel(), out.imag.ravel()))


def period_mean(points: Array) -> Array:
    """Mean over a period of even samples, both ends included."""
    return np.asarray(0.5 * (points[:-1] + points[1:]).mean(axis=0))
