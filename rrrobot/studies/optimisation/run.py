"""The best gait for a goal: a global search by the momentum engine, polishes, a confirmation.

The box of gaits is sampled through the engine, forces and torques included; sequential quadratic
programming starts from the best few samples; the winner is then simulated by the general KKT model,
and that is what the result reports.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, whole
from rrrobot.errors import GaitError, ModelError, ParameterError, SimulationError
from rrrobot.models.base import Model
from rrrobot.orbits.settling import between, settling_time
from rrrobot.progress import Progress, progress_of
from rrrobot.robot.chains import ties_of
from rrrobot.studies.optimisation.goals import Goal, as_goal
from rrrobot.studies.optimisation.result import OptimisedGait, confirm
from rrrobot.studies.optimisation.search import attained, search
from rrrobot.studies.optimisation.space import Space, swing_of
from rrrobot.studies.optimisation.table import GaitLimits, Table, discrepancy
from rrrobot.studies.optimisation.task import ROUNDING, TIGHT, Evaluator, Task

_LEAST_BUDGET = 100
_SETTLE_TIME, _LONGEST = 25.0, 1000.0
_LEFT = 5e-6
"""Of the slowest mode, when the counted cycles begin."""
_TIPPED = (
    "every gait within the bounds tipped the robot to a pitch of 90 degrees: lower the amplitude "
    "or keep the frequency away from the body's own oscillations."
)
_ASTRAY = (
    "no gait within the bounds has a limit cycle of its own period: lower the amplitude, keep the "
    "frequency away from the body's own oscillations, or take settle='cycles'."
)
_NOWHERE = (
    "none of the best limit cycles is one that an upright start comes to; with the best gait the "
    "robot tips over first: lower the amplitude, or take settle='cycles'."
)
_STRAYS = "an upright start does not come to its limit cycle: try settle='cycles'"


def optimise(
    model: Model,
    goal: Goal | str,
    *,
    offset: ArrayLike | None = None,
    amplitude: ArrayLike | None = None,
    angular_frequency: ArrayLike = (2.0, 14.0),
    phase_difference: ArrayLike = (0.0, 2 * np.pi),
    harmonics: int = 1,
    tied: bool = False,
    winding: ArrayLike = 0,
    limits: GaitLimits | None = None,
    settle: str = "cycles",
    settle_time: float | None = None,
    budget: int | None = None,
    seed: int = 0,
    progress: Progress = False,
) -> OptimisedGait:
    """The best gait for a goal, within bounds and limits.

    Args:
        model: `FullModel` of any shell and ground that the engine knows, or `PivotingModel`.
        goal: "fastest", "tightest", "efficient", or a `FastestTravel`, `TightestTurn`,
            `LeastEffort` or `TargetMotion`.
        offset, amplitude: a number, which is kept; bounds (low, high) for all legs; or bounds
            for each (legs, 2) [rad]. Unless either is given, within the limits of position in
            the robot's file; 0 .. pi and 0 .. 0.5 without any.
        angular_frequency: of all legs; number or bounds [rad/s].
        phase_difference: of legs 2, 3, ... from leg 1; number, bounds, or bounds for each
            (legs - 1, 2) [rad].
        harmonics: 1 for sinusoids; more give Fourier gaits whose whole swing stays within the
            largest amplitude.
        tied: whether legs that mirror each other share one offset and one amplitude, mirrored as
            their axes are. Bounds are then those of each group's first leg, phase differences
            those of the mirrored swings.
        winding: whole turns of each leg in a period, or one number for all: 1 for legs that go
            round and round, at a constant rate where the amplitude is 0.
        limits: what the gait must respect; `GaitLimits()` unless given, with what the robot's
            file allows each joint.
        settle: "cycles": simulate each gait from rest until it has settled; "orbit": find its
            limit cycle, and take gradients along the orbit: a fifth of the simulated cycles, or
            less. A gait whose orbit does not hold is outside a limit.
        settle_time: simulated before the cycles that count [s]. Unless given, 25, and more where
            the slowest mode about rest, with the legs held at the ends or the middle of their
            bounds, is not down to 5e-6 by then, which RRRobot's is; 1000 at most. A time that is
            too short shows in `OptimisedGait.discrepancy` and in the result `variation`.
        budget: gaits that may be simulated, at least 100; 20 000 for each harmonic unless given.
        seed: the same seed gives the same bits.
        progress: see `rrrobot.progress`; in gaits, of the budget.

    Returns:
        the OptimisedGait; where no gait is within the limits, or a target out of reach, it is the
        nearest, `met` is False and `shortfalls` says why.

    Raises:
        ParameterError: bounds, limits, budget or seed that are out of range; an unknown goal.
        ModelError: a model that does not travel, or that the engine cannot run.
        GaitError: every gait within the bounds ran into the vertical.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> goal = rr.studies.TargetMotion(speed=0.005, curvature=2.0)
        >>> best = rr.optimise(model, goal, budget=2000)
        >>> round(best.steady_state.speed, 5), round(best.steady_state.curvature, 3)
        (0.005, 2.0)
    """
    goal = as_goal(goal)
    legs = legs_of(model)
    ties = ties_of(model.robot) if tied else None
    space = Space(
        legs, **swing_of(model.robot.joints, offset, amplitude, ties),
        angular_frequency=angular_frequency, phase_difference=phase_difference,
        harmonics=harmonics, ties=ties, winding=winding,
    )  # fmt: skip
    limits = GaitLimits() if limits is None else limits
    budget = 20_000 * harmonics if budget is None else budget
    evaluator = prepare(model, space, limits, settle_time, budget, seed, settle)
    task = Task.of(model, goal, limits)
    with progress_of(progress, "gaits", int(budget), "gaits") as evaluator.tell:
        point = search(evaluator, task, np.random.default_rng(seed))
    if np.all(np.isnan(evaluator.archive()[1].speed)):
        raise GaitError(_TIPPED if settle == "cycles" else _ASTRAY)
    point, comes = attained(evaluator, task, point)
    settings = {"settle": settle, "settle_time": evaluator.engine.settle_time,
                "budget": int(budget), "seed": int(seed)}  # fmt: skip
    return _result(model, evaluator, task, point, settings, comes=comes)


def prepare(
    model: Model,
    space: Space,
    limits: GaitLimits,
    settle_time: float | None,
    budget: int,
    seed: int,
    settle: str,
) -> Evaluator:
    """An evaluator, after checks of everything that it needs.

    Raises:
        ParameterError, ModelError: as `optimise` raises.
    """
    if len(model.axes) != 3:
        raise ModelError(
            f"the {model.name} model does not travel: optimise the full or the pivoting model."
        )
    if model.rolling is None and limits.friction is not None:
        raise ModelError("the pivoting model has no friction to limit: use the full model.")
    if not isinstance(limits, GaitLimits):
        raise ParameterError(f"limits is {limits!r}: give GaitLimits(...).")
    if settle_time is None:
        needed = settling_time(model, between(*space.offsets()), _LEFT)
        settle_time = max(_SETTLE_TIME, min(needed, _LONGEST))
    settle_time = finite("settle_time", settle_time, "s", above=0.0)
    whole("budget", budget, at_least=_LEAST_BUDGET)
    whole("seed", seed, at_least=0)
    # Numba loads here, so that it costs nobody who does not use it.
    from rrrobot.studies.optimisation.lanes import engine_of

    engine = engine_of(model, settle_time, settle)
    if engine.setting.tree.prismatic.any() and [0.0, np.pi] in space.to_dict()["offset"]:
        raise ParameterError(
            "a leg of this robot slides: give offset= and amplitude= in metres for it, as "
            "(low, high) for each leg."
        )
    return Evaluator(engine, space, int(budget))


def legs_of(model: Model) -> int:
    """Number of legs; raises ModelError for what is no model."""
    if not isinstance(model, Model):
        raise ModelError(f"model is {type(model).__name__}: give a model, as FullModel(robot).")
    return model.n_legs


def _result(
    model: Model,
    evaluator: Evaluator,
    task: Task,
    point: Array,
    settings: dict[str, Any],
    *,
    comes: bool,
) -> OptimisedGait:
    points, table = evaluator.archive()
    gait = evaluator.space.gait(point)
    try:
        trajectory, state, measured = confirm(model, gait, settings["settle_time"])
    except SimulationError:
        if comes:
            raise
        raise GaitError(_NOWHERE) from None
    found = table.rows((points == point).all(axis=1))
    shortfalls = _shortfalls(task, measured, float(found.multiplier[0]))
    if not comes:
        shortfalls += (_STRAYS,)
    return OptimisedGait(
        gait=gait,
        goal=task.goal,
        limits=task.limits,
        value=float(task.goal.value(measured)[0]),
        met=not shortfalls,
        shortfalls=shortfalls,
        steady_state=state,
        measured=measured.to_dict(),
        discrepancy=discrepancy(found, measured),
        lift_off_time=trajectory.lift_off_time,
        evaluations=evaluator.used,
        cycles=evaluator.cycles,
        history=_history(task, table),
        search=evaluator.space.to_dict() | settings,
        trajectory=trajectory,
    )


def _shortfalls(task: Task, measured: Table, multiplier: float) -> tuple[str, ...]:
    """What the confirming simulation, or the orbit's multiplier, says does not hold, in words."""
    goal = task.goal
    slacks = task.told(measured)
    found = list(
        dict.fromkeys(text for slack, text in slacks.values() if not slack[0] >= -ROUNDING)
    )
    if measured.speed[0] < goal.min_speed:
        found.append(f"slower than {goal.min_speed:g} m/s")
    if multiplier >= 1.0:
        found.append(f"its limit cycle does not hold: a Floquet multiplier of {multiplier:.4g}")
    misses = goal.misses(measured)
    if misses is not None and np.linalg.norm(misses) > goal.tolerance:
        found.append(goal.shortfall(measured))
    return tuple(found)


def _history(task: Task, table: Table) -> Array:
    """(evaluations, best value) wherever the best improves (k, 2)."""
    task = task._replace(tolerance=max(task.goal.tolerance, TIGHT))
    scores, values = task.scores(table), task.goal.value(table)
    best = np.minimum.accumulate(scores)
    improved = np.flatnonzero(np.diff(best, prepend=np.inf) < 0)
    shown = np.where(task.valid(scores[improved]), values[improved], np.nan)
    return np.column_stack((improved + 1.0, shown))
