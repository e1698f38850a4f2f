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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rrrobot.errors import GaitError, ModelError, OrbitError, RRRobotError, SimulationError
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.motion import Motion, Screw
from rrrobot.orbits.limit_cycles import LimitCycle, limit_cycle
from rrrobot.robot.robot import Robot
from rrrobot.simulation.run import simulate
from rrrobot.simulation.steady import steady_state
from rrrobot.simulation.trajectory import Trajectory

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


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome(Motion):
    """A motion and its numbers.

    Attributes:
        knobs: of which.
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
    steps = steps_of(knobs)
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
        "horizon": knobs.horizon,
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


def steps_of(knobs: Knobs) -> int:
    """Of the integrator, and samples, in a period."""
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
    state = steady_state(trajectory)
    settled = bool(state.variation < _SETTLED) or not moves
    words = () if settled else (
        f"Not settled: consecutive cycles of the {trajectory.time[-1]:.3g} s differ by "
        f"{100 * state.variation:.2g} %.",
    )  # fmt: skip
    return {
        **found,
        "horizon": knobs.horizon,
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


def short(error: Exception) -> str:
    """An error's first sentence."""
    text = " ".join(str(error).split())
    end = text.find(". ")
    return text if end < 0 else text[: end + 1]
