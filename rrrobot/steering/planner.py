"""From a wanted pose to leg motions: a coarse plan from the settled motions, then the exact one.

1. `motions_of`: what each gait does once settled, as a twist; `corners` are the useful ones.
2. `joined` (or `around`, where something stands in the way): few of them, one after the other, that
   lead from pose to pose.
3. Each becomes a stretch of whole cycles of a `Schedule`; `shoot` turns amplitudes, offsets and
   phases until the exact motion, with all its transients, comes to rest at the goal.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.errors import ModelError, ParameterError, PlanError
from rrrobot.models.base import Model
from rrrobot.models.recombined import DecoupledModels
from rrrobot.progress import Progress
from rrrobot.steering.limited import settled, within
from rrrobot.steering.motions import Motions, check_legs, corners, motions_of
from rrrobot.steering.obstacles import Obstacle, free_distance
from rrrobot.steering.plans import Plan
from rrrobot.steering.search import Found, Search
from rrrobot.steering.shooting import Apart
from rrrobot.steering.standing import radius_of, rest_of
from rrrobot.studies.optimisation.table import GaitLimits


def plan(
    model: Model,
    goal: ArrayLike,
    *,
    start: ArrayLike = (0.0, 0.0, 0.0),
    waypoints: Sequence[ArrayLike] = (),
    obstacles: Sequence[Obstacle] = (),
    margin: float | None = None,
    amplitude: float = 0.5,
    angular_frequency: float = 8.0,
    rest: ArrayLike | None = None,
    tolerance: tuple[float, float] = (2e-4, 7e-4),
    longest: float = 600.0,
    limits: GaitLimits | None = None,
    max_power: float | None = None,
    minimise: str = "time",
    on: str = "full",
    motions: Motions | None = None,
    store: bool = True,
    progress: Progress = None,
) -> Plan:
    """Leg motions that bring a robot from rest at a pose to rest at another.

    Args:
        model: a model that rolls and that the momentum engine knows, of a robot with two legs.
        goal: (x, y, yaw) of the contact point and the body at rest [m, m, rad].
        start: likewise, where it rests now.
        waypoints: poses to come by on the way, as (x, y, yaw); the robot rests at none of them,
            and passes them as near as the coarse plan does.
        obstacles: `Disc` and `Polygon`; the contact point keeps away from them.
        margin: by so much [m]; the shell's radius unless given.
        amplitude: the largest swing of the legs [rad].
        angular_frequency: of the legs [rad/s].
        rest: leg angles at rest (legs,) [rad]; straight up unless given.
        tolerance: of the final place [m] and yaw [rad].
        longest: time that the legs may move [s].
        limits: of torque, leg rate, friction, normal force and clearance, that the whole run keeps;
            see `Plan.demands`. None are checked unless given. The gaits are
            chosen from those that keep them when settled.
        max_power: of all motors together, at any instant of the run [W]; any unless given.
        minimise: "time", or "effort": the work of the motors, by the settled gaits' power, and
            never more than that of the quick plan; neither is proven the least.
        on: "full": the plan is exact on `model`; "decoupled": on the single-axis models, recombined
            and modulated, as the paper proposes. What that costs shows when it is executed. Of
            obstacles only the coarse plan then keeps clear.
        motions: what the gaits do, of `motions_of`: of the robot itself on level ground unless
            given; one that is like it will do, for the plan is made exact on `model`.
        store: whether the map of motions is kept in the user's cache folder.
        progress: as for `sweep`, while that map is made.

    Returns:
        the Plan; its `gait` runs in `simulate`, films and exports.

    Raises:
        ParameterError: a number out of range, or a start within an obstacle's margin.
        ModelError: no gait of the robot travels, or it never comes to rest.
        PlanError: the goal is out of reach (obstacles, time, limits), and why; its `nearest` is the
            plan that ends nearest, or None.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> p = rr.plan(model, goal=(0.2, 0.1, np.pi / 2))
        >>> bool(np.hypot(*p.error[:2]) < 1e-3 and abs(p.error[2]) < np.deg2rad(0.2))
        True
    """
    if not isinstance(model, Model) or model.rolling is None:
        raise ModelError(f"model is {model!r}: a plan needs a model that rolls, such as FullModel.")
    check_legs(model)
    stops = [
        vector(name, pose, 3, labels=("x", "y", "yaw"))
        for name, pose in (("start", start), *(("waypoint", w) for w in waypoints), ("goal", goal))
    ]
    margin = radius_of(model) if margin is None else finite("margin", margin, "m", at_least=0)
    finite("longest", longest, "s", above=0)
    if max_power is not None:
        finite("max_power", max_power, "W", above=0)
    x, y, _ = stops[0]
    distance = float(free_distance(obstacles, stops[0][None, :2])[0])
    if distance < margin:
        raise ParameterError(
            f"the start ({x:g}, {y:g}) m is {distance:.4g} m from an obstacle, and the margin is "
            f"{margin:g} m: move it, or give a smaller margin=."
        )
    legs = np.full(2, np.pi / 2) if rest is None else vector("rest", rest, 2, "rad")
    still = rest_of(model, legs, float(stops[0][2]))
    if minimise not in ("time", "effort"):
        raise ParameterError(f"minimise is {minimise!r}: known are 'time' and 'effort'.")
    if on not in ("full", "decoupled"):
        raise ParameterError(f"on is {on!r}: plans are made on 'full' or 'decoupled' models.")
    if motions is None:
        motions = motions_of(
            model, amplitude=amplitude, angular_frequency=angular_frequency, store=store,
            decoupled=on == "decoupled", progress=progress,
        )  # fmt: skip
    by = _apart(model, motions) if on == "decoupled" else model
    limited = limits is not None or max_power is not None
    found = Found(None, None, "no gait of the robot keeps the limits", False)
    arriving: list[Plan] = []
    for gaits in within(model, motions, limits, max_power) if limited else (motions,):
        for few, cost in _choices(model, gaits, minimise):
            search = Search(
                model, by, still, few, cost=cost, obstacles=obstacles, margin=margin,
                room=0.1 * radius_of(model), limits=limits, max_power=max_power,
            )  # fmt: skip
            found = search.run(stops, tolerance, longest)
            if found.plan is not None:
                arriving.append(found.plan)
        if arriving:
            return arriving[0] if len(arriving) == 1 else min(arriving, key=_work)
        if not found.too_hard:
            break
    raise PlanError(_told(stops[-1], found), nearest=found.nearest)


def _choices(model: Model, motions: Motions, minimise: str) -> Iterator[tuple[Motions, Array]]:
    """Few motions to choose from, and the cost of a second of each; in the end the quick ones."""
    if minimise == "effort":
        power = settled(model, motions)["power"]
        few = corners(motions, most=10, cost=np.where(power > 0, power, np.inf))
        yield few, settled(model, few)["power"]
    few = corners(motions, most=10)
    yield few, np.ones(few.offset.size)


def _work(found: Plan) -> float:
    return found.demands().work


def _told(goal: Array, found: Found) -> str:
    """Why there is no plan, and which is the nearest."""
    if found.nearest is None:
        return f"no plan to {goal.round(4).tolist()}: {found.why}, nor a way part of the distance."
    x, y, yaw = found.nearest.predicted
    return (
        f"no plan to {goal.round(4).tolist()}: {found.why}. The nearest that was found ends at "
        f"({x:.4g}, {y:.4g}) m with a yaw of {yaw:.4g} rad; it is in the error's .nearest."
    )


def _apart(model: Model, motions: Motions) -> Apart:
    """The robot's single-axis models with the yaw model's legs as in the motions."""
    rows = np.isclose(motions.amplitude, motions.amplitude.max())
    offset, first = np.unique(motions.offset[rows], return_index=True)
    ratio = (motions.yaw_amplitude[rows] / motions.amplitude[rows])[first]
    return Apart(DecoupledModels(model.robot), offset, ratio)
