"""Feedback at the goal: drive, measure, learn what the robot is, and plan what is left.

Each try is an exact plan from where the robot was seen to rest. What is seen on the way tells its
masses, radius, damping and slope (`identify`), and the next plan is of the robot that explains it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.contact.ground import Plane
from rrrobot.drive.schedule import Schedule
from rrrobot.errors import PlanError, RRRobotError
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.simulation.run import simulate
from rrrobot.simulation.state import State
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.steering.identification import identify
from rrrobot.steering.measured import MeasuredRun
from rrrobot.steering.motions import motions_of
from rrrobot.steering.planner import plan
from rrrobot.steering.plans import Plan
from rrrobot.steering.robots import Sensor, stepping_of
from rrrobot.steering.shooting import gap, off
from rrrobot.steering.standing import standing

_INTERVAL = 0.1
"""Between measurements [s]."""
_LEARNT = ("damping", "leg_mass", "servo_mass", "shell_radius", "slope")
"""All that poses tell: the battery fixes the scale of the masses."""
_TRUST = {"damping": 0.5, "leg_mass": 0.1, "servo_mass": 0.1, "shell_radius": 0.05, "slope": 0.05}
"""How far the driven robot may be from the model: relative standard deviations, and a slope."""
_STEP = np.array((0.1, 0.1, 1.5))
"""That a robot rocks and turns in an interval at most [m, m, rad]."""
_STANDING = 20
"""Measurements of the resting pose that are averaged."""


class Try(NamedTuple):
    """One plan that was driven."""

    plan: Plan
    trajectory: Trajectory
    """of the true robot"""
    seen: Array
    """measured pose at rest (3,)"""
    misfit: float
    """of the robot that was learnt from it; NaN if none was"""


@dataclass(frozen=True, kw_only=True, eq=False)
class Reached:
    """A goal that was driven to.

    Attributes:
        goal: where it was at last (3,).
        tries: what was driven, in order.
        end: true pose at last (3,).
        stopped: why no more was tried, or None where the goal was seen to be reached.
    """

    goal: Array
    tries: tuple[Try, ...] = field(repr=False)
    end: Array
    stopped: str | None

    @property
    def error(self) -> Array:
        """True minus wanted pose (3,)."""
        return gap(self.end.copy(), self.goal)


def reach(
    model: Model,
    goal: ArrayLike | Callable[[float], ArrayLike],
    *,
    truth: Model | None = None,
    start: ArrayLike = (0.0, 0.0, 0.0),
    sensor: Sensor | None = None,
    within: tuple[float, float] = (3e-3, 0.015),
    tries: int = 5,
    **options: Any,
) -> Reached:
    """Drive to a pose on a robot that differs from the model, in as many plans as it needs.

    Args:
        model: what is believed at first.
        goal: (x, y, yaw) at rest; of a goal that moves, a function of the time [s]: each plan then
            leads to where the goal will be when the robot comes to rest.
        start: (x, y, yaw) at rest.
        truth: the robot that is driven, of any ground; the believed one unless given.
        sensor: noise and faults of the measured poses; none unless given. Where they stop or jump,
            the legs come to rest smoothly, and `stopped` says so.
        within: distance [m] and angle [rad] from the goal that is seen as reached.
        tries: plans at most.
        **options: of `plan`.

    Raises:
        PlanError: no plan to the goal at the first try.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> from rrrobot.steering import reach
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> other = rr.FullModel(rr.Robot.from_parameters(rr.RRRobotParameters(battery_mass=0.31)))
        >>> found = reach(model, (0.1, 0.1, 0.5), truth=other)
        >>> bool(np.hypot(*found.error[:2]) < 0.005), found.stopped
        (True, None)
    """
    seer = Sensor() if sensor is None else sensor
    finite("tries", tries, at_least=1)
    moving = goal if callable(goal) else lambda time: goal
    clock, target = 0.0, _pose(moving(0.0))
    now = vector("start", start, 3, labels=("x", "y", "yaw"))
    if options.get("motions") is None:
        how = {k: options[k] for k in ("amplitude", "angular_frequency", "store") if k in options}
        options["motions"] = motions_of(model, **how)
    done: list[Try] = []
    real, believed = truth or model, model
    true = now.copy()
    noise = np.random.default_rng(seer.seed)
    spread = np.array((seer.place, seer.place, seer.yaw))
    stopped: str | None = f"{tries} plans did not bring it there"
    for _ in range(tries):
        try:
            made = _caught(believed, moving, clock, now, options)
        except PlanError as error:
            if not done:
                raise
            stopped = str(error)
            break
        before = done[-1].trajectory if done else None
        t = _driven(real, made, made.gait, true, before)
        seen = seer.seen(clock + t.time, _poses(t), noise)
        lost = _lost(seen, spread)
        if lost is not None:
            # As the camera is later by then, the legs have gone on until it was noticed.
            at = float(t.time[lost]) + seer.delay * 2 * np.pi / made.gait.angular_frequency
            t = _driven(real, made, made.gait.halted(at), true, before)
        clock += float(t.time[-1])
        target, true = _pose(moving(clock)), _poses(t)[-1]
        if lost is not None:
            done.append(Try(made, t, np.full(3, np.nan), float("nan")))
            stopped = (
                f"the measured pose is missing or jumps at {at:.4g} s of plan {len(done)}: the "
                "legs were brought to rest; look at what measures it, and start again from there"
            )
            break
        now = seen[-_STANDING:].mean(axis=0)
        misfit = float("nan")
        reached = off(gap(now.copy(), target), within) <= 1.0
        if not reached:
            believed, misfit = _learnt(model, believed, t, seen, seer)
        done.append(Try(made, t, now, misfit))
        if reached:
            stopped = None
            break
    return Reached(goal=target, tries=tuple(done), end=true, stopped=stopped)


def _poses(t: Trajectory) -> Array:
    """(x, y, yaw) at each sample (n, 3)."""
    return np.column_stack((t.position, t.euler[:, 2]))


def _lost(seen: Array, spread: Array) -> int | None:
    """The first measurement that is missing, or further from the one before than can be."""
    step = np.abs(np.diff(seen, axis=0))
    wrong = ~np.all(step <= _STEP + 8.0 * spread, axis=1)
    return int(np.argmax(wrong)) + 1 if wrong.any() else None


def _pose(values: ArrayLike) -> Array:
    return vector("goal", values, 3, labels=("x", "y", "yaw"))


def _caught(
    believed: Model,
    moving: Callable[[float], ArrayLike],
    clock: float,
    start: Array,
    options: dict[str, Any],
) -> Plan:
    """A plan to where the goal will be when the robot rests, found by planning to where it was."""
    arrival, made = clock, None
    for _ in range(6):
        target = _pose(moving(arrival))
        if made is not None and off(gap(made.goal.copy(), target), (1e-3, 5e-3)) <= 1.0:
            break
        made = _planned(believed, target, start, options)
        arrival = clock + made.duration + _STANDING * _INTERVAL
    assert made is not None
    return made


def _planned(believed: Model, goal: Array, start: Array, options: dict[str, Any]) -> Plan:
    """A plan from the maps of the first model, and if that finds none, from the robot's own."""
    try:
        return plan(believed, goal, start=start, **options)
    except PlanError:
        own = {k: options[k] for k in ("amplitude", "angular_frequency") if k in options}
        motions = motions_of(believed, store=False, **own)
        return plan(believed, goal, start=start, **options | {"motions": motions})


def _driven(
    real: Model, made: Plan, gait: Schedule, pose: Array, before: Trajectory | None
) -> Trajectory:
    """The true robot's run of a plan's gait, or of one halted, from rest or on from a run."""
    how: dict[str, Any] = {
        "start": "rest", "position": pose[:2],
        "euler": standing(real, made.rest.leg_angle, float(pose[2])),
    } if before is None else {"state": State.from_array(real, before.state[-1])}  # fmt: skip
    length = made.duration + gait.duration - made.gait.duration + _STANDING * _INTERVAL
    return simulate(real, gait, length, _INTERVAL, **how, **stepping_of(real))


def _learnt(
    model: Model, believed: Model, t: Trajectory, seen: Array, seer: Sensor
) -> tuple[Model, float]:
    """The robot that explains a run, if one does; else what was believed."""
    parameters = model.robot.parameters
    if parameters is None or type(model) is not FullModel:
        return believed, float("nan")
    run = MeasuredRun(time=t.time, pose=seen, leg_angle=t.leg_angle)
    noise = (max(seer.place, 1e-4), max(seer.yaw, 1e-3))
    try:
        ground = model.ground if isinstance(model.ground, Plane) else None
        found = identify(run, parameters, free=_LEARNT, ground=ground, noise=noise, trust=_TRUST)
    except (RRRobotError, np.linalg.LinAlgError):
        return believed, float("nan")
    return found.model, found.misfit
