"""What comes of the knobs: the settled motion and its numbers, or why there is none, in words.

On level ground the settled motion is a limit cycle: one period of the legs and the screw that leads
from each period to the next, which give the path over any horizon. Elsewhere it is a run from an
upright impulsive start.
"""

from __future__ import annotations

import math
import threading
import warnings
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.errors import GaitError, ModelError, OrbitError, RRRobotError, SimulationError
from rrrobot.orbits.limit_cycles import LimitCycle, limit_cycle
from rrrobot.robot.robot import Robot
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.view.lab.knobs import Knobs

STEPS = 36
"""Of the integrator, and samples, in a period."""
_LONGEST_STEP = 0.025
_RUN = 30.0
"""Longest run where nothing settles [s]."""
_SETTLED = 1e-3
LOCK = threading.Lock()
"""Python's warnings are the process's: one computation collects them at a time."""


class Refusal(Exception):
    """Knobs at which there is no motion to show, in words for whoever turned them."""


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
class Outcome:
    """A motion and its numbers.

    Attributes:
        knobs: of which.
        trajectory: one period of a motion that repeats, both ends included; else a whole run.
        screw: what a period of it does; None for a run.
        speed: of the cycle means [m/s].
        yaw_rate: [rad/s].
        friction: largest coefficient that the contact needs.
        normal_force: least [N].
        torque: largest of any leg [N m].
        multipliers: of deviations over a period, largest first; empty for a run.
        settled: whether the motion is a settled one; speed and yaw rate are means if not.
        words: what else is to be said.
        cycle: the limit cycle.
    """

    knobs: Knobs
    trajectory: Trajectory
    screw: Screw | None
    speed: float
    yaw_rate: float
    friction: float
    normal_force: float
    torque: float
    multipliers: NDArray[np.complex128]
    settled: bool
    words: tuple[str, ...]
    cycle: LimitCycle | None = None

    @property
    def curvature(self) -> float:
        """[1/m]; infinite for a turn on the spot."""
        if self.speed < 1e-9:
            return math.copysign(math.inf, self.yaw_rate) if abs(self.yaw_rate) > 1e-9 else 0.0
        return self.yaw_rate / self.speed

    @property
    def period(self) -> float:
        """Time after which playing starts anew, elsewhere if there is a screw [s]."""
        return float(self.trajectory.time[-1])

    def path(self) -> Array:
        """Contact point over the horizon (n, 2) [m]."""
        points = self.trajectory.position
        if self.screw is None:
            return points
        return screwed(points[:-1], self.screw, self._periods())

    def mean_path(self) -> Array:
        """Cycle means of the contact point over the horizon (n, 2) [m]."""
        points = self.trajectory.position
        if self.screw is None:
            per = max(1, round((self.trajectory.period or self.period) / self._interval()))
            if len(points) < 2 * per:
                return points[:1]
            sums = np.cumsum(np.vstack((np.zeros((1, 2)), points)), axis=0)
            return np.asarray((sums[per:] - sums[:-per])[::per] / per)
        mean = _mean(points)[None]
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
        return max(1, round(self.knobs.horizon / self.period))


def settle(given: Robot, knobs: Knobs, near: Outcome | None = None) -> Outcome:
    """The motion of a robot at these knobs.

    Args:
        given: the robot, before the knobs change its masses and lengths.
        knobs: where they stand.
        near: of knobs nearby, from which the search starts.

    Raises:
        Refusal: there is none that could be shown.
    """
    with LOCK, warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            found = _cycle(given, knobs, near) if knobs.settles else _run(given, knobs)
        except SimulationError as error:
            raise Refusal(f"The robot tips over: {short(error)}") from None
        except OrbitError as error:
            raise Refusal(f"No settled motion: {short(error)}") from None
        except (GaitError, ModelError, RRRobotError) as error:
            raise Refusal(short(error)) from None
        except FloatingPointError as error:
            raise Refusal(f"The numbers overflow: {error}.") from None
    more = (" ".join(str(w.message).split()) for w in told)
    return Outcome(**found | {"words": (*found["words"], *dict.fromkeys(more))}, knobs=knobs)


def _cycle(given: Robot, knobs: Knobs, near: Outcome | None) -> dict[str, Any]:
    model, gait = knobs.model(given), knobs.gait()
    steps = _steps(knobs)
    cycle = None
    if near is not None and near.cycle is not None:
        try:
            cycle = limit_cycle(model, gait, near=near.cycle.point, steps_per_cycle=steps)
        except (OrbitError, ModelError, RRRobotError):
            cycle = None
    if cycle is None or not cycle.stable or cycle.lifts_off:
        cycle = limit_cycle(model, gait, steps_per_cycle=steps)
    if cycle.lifts_off:
        raise Refusal(
            f"The robot lifts off: the least normal force would be {cycle.normal_force:.3g} N. "
            "Swing the legs less or more slowly."
        )
    words: tuple[str, ...] = ()
    if not cycle.stable:
        words = (
            "This motion does not hold: a deviation grows by "
            f"{abs(cycle.multipliers[0]):.3g} in each period.",
        )
    trajectory = cycle.trajectory(sample_interval=cycle.period / steps)
    return {
        **forces(trajectory),
        "trajectory": trajectory,
        "screw": Screw(cycle.turn, cycle.displacement),
        "speed": cycle.speed,
        "yaw_rate": cycle.yaw_rate,
        "normal_force": cycle.normal_force,
        "multipliers": cycle.multipliers,
        "settled": cycle.stable,
        "words": words,
        "cycle": cycle,
    }


def ghost(given: Robot, knobs: Knobs, name: str) -> Array:
    """Path of another model over the horizon (n, 2) [m]: "pivoting" or "decoupled".

    Raises:
        Refusal: it has none.
    """
    if not knobs.settles:
        raise Refusal("Other models are shown where the motion repeats.")
    with LOCK, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            model = knobs.other(given, name)
            cycle = limit_cycle(model, knobs.gait(), steps_per_cycle=_steps(knobs))
            points = cycle.trajectory(sample_interval=cycle.period / STEPS).position
        except RRRobotError as error:
            raise Refusal(f"The {name} model: {short(error)}") from None
    laps = max(1, round(knobs.horizon / cycle.period))
    return screwed(points[:-1], Screw(cycle.turn, cycle.displacement), laps)


def _steps(knobs: Knobs) -> int:
    return max(STEPS, math.ceil(2 * math.pi / knobs.frequency / _LONGEST_STEP))


def _run(given: Robot, knobs: Knobs) -> dict[str, Any]:
    model, gait = knobs.model(given), knobs.gait()
    moves = bool(np.any(knobs.amplitude) or np.any(knobs.overtone))
    period = gait.period or 1.0
    interval = period / 24
    laps = max(2, round(min(knobs.horizon, _RUN) / period))
    trajectory = simulate(model, gait, laps * period, interval, method="momentum")
    if trajectory.lift_off_time is not None:
        raise Refusal(
            f"The robot lifts off after {trajectory.lift_off_time:.3g} s: this motion means "
            "nothing from there."
        )
    found = forces(trajectory)
    state = trajectory.steady_state()
    settled = bool(state.variation < _SETTLED) or not moves
    words = () if settled else (
        f"Not settled: consecutive cycles of the {trajectory.time[-1]:.3g} s differ by "
        f"{100 * state.variation:.2g} %.",
    )  # fmt: skip
    return {
        **found,
        "trajectory": trajectory,
        "screw": None,
        "speed": state.speed,
        "yaw_rate": state.yaw_rate,
        "normal_force": float(trajectory.normal_force.min()),
        "multipliers": np.empty(0, dtype=np.complex128),
        "settled": settled,
        "words": words,
    }


def forces(trajectory: Trajectory) -> dict[str, float]:
    """Largest needed friction and largest torque."""
    torque = np.abs(trajectory.leg_torque)
    return {
        "friction": float(trajectory.required_friction.max()),
        "torque": float(torque.max(initial=0.0)),
    }


def screwed(points: Array, screw: Screw, laps: int) -> Array:
    """Points (n, 2) of one period, and where each of the next periods puts them."""
    turns, moved = screw.power(np.arange(laps))
    z = points[:, 0] + 1j * points[:, 1]
    out = np.exp(1j * turns)[:, None] * z + (moved[:, 0] + 1j * moved[:, 1])[:, None]
    return np.column_stack((out.real.ravel(), out.imag.ravel()))


def _mean(points: Array) -> Array:
    """Mean over a period of even samples, both ends included."""
    return np.asarray(0.5 * (points[:-1] + points[1:]).mean(axis=0))


def short(error: Exception) -> str:
    """An error's first sentence."""
    text = " ".join(str(error).split())
    end = text.find(". ")
    return text if end < 0 else text[: end + 1]
