"""From a wanted pose to leg motions: a coarse plan from the settled motions, then the exact one.

1. `motions_of`: what each gait does once settled, as a twist; `corners` are the useful ones.
2. `joined` (or `around`, where something stands in the way): few of them, one after the other, that
   lead from pose to pose.
3. Each becomes a stretch of whole cycles of a `Schedule`; `shoot` turns amplitudes, offsets and
   phases until the exact motion, with all its transients, comes to rest at the goal.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.schedule import Schedule, stretch
from rrrobot.errors import ModelError, ParameterError, PlanError
from rrrobot.models.base import Model
from rrrobot.models.recombined import DecoupledModels
from rrrobot.progress import Progress
from rrrobot.steering.arcs import joined, path
from rrrobot.steering.lattice import around
from rrrobot.steering.motions import Motions, corners, motions_of
from rrrobot.steering.obstacles import Obstacle, free_distance
from rrrobot.steering.plans import Plan
from rrrobot.steering.shooting import Apart, Knobs, Shot, final_poses, gap, off, shoot
from rrrobot.steering.standing import Rest, rest_of
from rrrobot.studies.optimisation.table import GaitLimits

CYCLES_OF_BLEND = 2
_CANDIDATES, _SHOTS = 48, 6
_LENGTH = 0.1
"""That makes an angle comparable with a distance [m]."""


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
        longest: time that it may take [s].
        limits: of torque, leg rate, friction, normal force and clearance, that the whole run keeps;
            see `Plan.demands`. None are checked unless given.
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
        ParameterError: a number out of range, or a start or goal within an obstacle's margin.
        ModelError: no gait of the robot travels, or it never comes to rest.
        PlanError: nothing was found; its `nearest` is the plan that ends nearest, or None.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> p = rr.plan(model, goal=(0.2, 0.1, np.pi / 2))
        >>> bool(np.hypot(*p.error[:2]) < 1e-3 and abs(p.error[2]) < np.deg2rad(0.2))
        True
    """
    if not isinstance(model, Model) or model.rolling is None:
        raise ModelError(f"model is {model!r}: a plan needs a model that rolls, such as FullModel.")
    stops = [
        vector(name, pose, 3, labels=("x", "y", "yaw"))
        for name, pose in (("start", start), *(("waypoint", w) for w in waypoints), ("goal", goal))
    ]
    margin = _radius(model) if margin is None else finite("margin", margin, "m", at_least=0)
    for name, pose in (("start", stops[0]), ("goal", stops[-1])):
        distance = float(free_distance(obstacles, pose[None, :2])[0])
        if distance < margin:
            raise ParameterError(
                f"the {name} ({pose[0]:g}, {pose[1]:g}) m is {distance:.4g} m from an obstacle, "
                f"and the margin is {margin:g} m: move it, or give a smaller margin=."
            )
    legs = np.full(2, np.pi / 2) if rest is None else vector("rest", rest, 2, "rad")
    still = rest_of(model, legs, float(stops[0][2]))
    if on not in ("full", "decoupled"):
        raise ParameterError(f"on is {on!r}: plans are made on 'full' or 'decoupled' models.")
    if motions is None:
        motions = motions_of(
            model, amplitude=amplitude, angular_frequency=angular_frequency, store=store,
            decoupled=on == "decoupled", progress=progress,
        )  # fmt: skip
    by = _apart(model, motions) if on == "decoupled" else model
    drive = _Drive(model, by, still, corners(motions, most=10), tuple(obstacles), margin)
    drive.limits = limits
    return drive.plan(stops, tolerance, longest)


class _Drive:
    """The search for one plan."""

    def __init__(
        self,
        model: Model,
        by: Model | Apart,
        rest: Rest,
        motions: Motions,
        obstacles: tuple[Obstacle, ...],
        margin: float,
    ) -> None:
        self.model, self.by, self.rest, self.motions = model, by, rest, motions
        self.obstacles, self.margin = obstacles, margin
        self.limits: GaitLimits | None = None
        self.period = 2 * np.pi / motions.angular_frequency
        self.blend = CYCLES_OF_BLEND * self.period
        # The exact motion leaves the coarse path by about a centimetre where gaits change.
        self.room = margin + 0.1 * _radius(model)

    def free(self, points: Array) -> Array:
        """Which points (n, 2) keep the margin, and room to rock."""
        return np.asarray(free_distance(self.obstacles, points) >= self.room)

    def plan(self, stops: list[Array], tolerance: tuple[float, float], longest: float) -> Plan:
        """See `plan`."""
        ends = np.array([stop[:2] for stop in stops])
        self.room = min(self.room, float(free_distance(self.obstacles, ends).min()))
        ways = self._ways(stops, longest)
        if not ways:
            raise PlanError(
                f"no way from {stops[0].round(4).tolist()} to {stops[-1].round(4).tolist()} was "
                f"found within {longest:g} s that keeps {self.margin:g} m from the obstacles: "
                "give more time (longest=), a smaller margin=, or another goal.",
                nearest=None,
            )
        knobs = [self._knobs(choice, time) for choice, time in ways]
        start, goal = stops[0], stops[-1]
        tail = self.rest.settling
        # Where the robot rocks about a little later is near enough to choose by.
        rough = final_poses(
            self.by, [k.make(x) for k, x in knobs], start, self.rest, tail=0.15 * tail
        )
        away = np.abs(gap(rough, goal) / (0.05, 0.05, 0.3)).max(axis=1)
        times = np.array([k.make(x).duration for k, x in knobs])
        # Far off and long are both bad; those that fail in the rough are left out.
        order = np.argsort(np.where(np.isfinite(away), away + times / 15.0, np.inf), kind="stable")
        nearest: Plan | None = None
        blocked: str | None = None
        for i in order[:_SHOTS]:
            shot = shoot(
                self.by, knobs[i][0], knobs[i][1], start, goal, self.rest, tolerance=tolerance,
                tail=tail,
            )  # fmt: skip
            if not np.all(np.isfinite(shot.error)):
                continue
            found = self._made(shot, stops, ways[i])
            if off(shot.error, tolerance) <= 1.0:
                blocked = self._blocked(found)
                if blocked is None:
                    return found
                nearest = nearest or found
            elif nearest is None or off(found.error, tolerance) < off(nearest.error, tolerance):
                nearest = found
        why = blocked or "the exact motion could not be brought to the goal"
        raise PlanError(
            f"no plan to {goal.round(4).tolist()}: {why}. The nearest that was found is in the "
            "error's .nearest; try another amplitude=, margin= or waypoints=.",
            nearest=nearest,
        )

    def _ways(self, stops: list[Array], longest: float) -> list[tuple[list[int], list[float]]]:
        """Coarse plans: motions and their times, the shortest first."""
        twists, least = self.motions.twist, 0.5 * self.blend
        heads: list[tuple[list[int], list[float]]] = [([], [])]
        for number, (a, b) in enumerate(itertools.pairwise(stops)):
            last = number == len(stops) - 2
            found = joined(twists, a, b, least=least, most=longest)
            legs: list[tuple[list[int], list[float]]] = []
            for choice, time in zip(found.choice[:400], found.time[:400], strict=True):
                if not self.obstacles or np.all(self.free(path(twists[choice], a, time)[:, :2])):
                    legs.append((choice.tolist(), time.tolist()))
                if len(legs) == (_CANDIDATES if last else 1):
                    break
            quick = _bound(twists, a, b)
            if self.obstacles and (not legs or sum(legs[0][1]) > 2 * quick):
                way = around(
                    twists, a, b, self.free, piece=4 * self.period, least=least, most=longest,
                    blend=0.5 * self.blend,
                )  # fmt: skip
                legs = legs if way is None else sorted([way, *legs], key=lambda w: sum(w[1]))
            if not legs:
                return []
            head_motions, head_times = heads[0]
            heads = [(head_motions + m, head_times + t) for m, t in legs]
        return [way for way in heads if sum(way[1]) <= longest]

    def _knobs(self, choice: Sequence[int], time: Sequence[float]) -> tuple[Knobs, Array]:
        """A schedule of whole cycles whose gaits can be varied, and where to begin."""
        m, k, period = self.motions, len(choice), self.period
        lasting = np.array(time, dtype=float)
        # While amplitudes grow from zero less is travelled, while they fall to it something more.
        lasting[0] += 0.6 * self.blend
        lasting[-1] = max(lasting[-1] - 0.4 * self.blend, 0.0)
        cycles = np.maximum(np.ceil(lasting / period - 1e-9), CYCLES_OF_BLEND)
        # Travel grows as the square of the amplitude.
        share = np.sqrt(np.clip(lasting / (cycles * period), 0.25, 1.0))

        def make(x: Array) -> Schedule:
            amplitude, offset, phase = x[:k], x[k : 2 * k], x[2 * k :]
            return Schedule(
                [
                    stretch(
                        float(n * period),
                        offset=(m.offset[j] + o,) * 2,
                        amplitude=m.amplitude[j] * a,
                        phase=(0.0, m.phase_difference[j] + p),
                    )
                    for n, j, a, o, p in zip(cycles, choice, amplitude, offset, phase, strict=True)
                ],
                angular_frequency=m.angular_frequency,
                rest=self.rest.leg_angle,
                blend=self.blend,
            )

        low = np.concatenate((np.full(k, 0.4), np.full(2 * k, -0.4)))
        high = np.concatenate((np.ones(k), np.full(2 * k, 0.4)))
        unit = np.concatenate((np.full(k, 0.1), np.full(2 * k, 0.2)))
        return Knobs(make, low, high, unit), np.concatenate((share, np.zeros(2 * k)))

    def _made(self, shot: Shot, stops: list[Array], way: tuple[list[int], list[float]]) -> Plan:
        twists, (start, goal) = self.motions.twist, (stops[0], stops[-1])
        return Plan(
            model=self.model,
            gait=shot.schedule,
            duration=shot.schedule.duration + self.rest.settling,
            start=start,
            goal=goal,
            predicted=shot.pose,
            path=path(twists[way[0]], start, np.array(way[1])),
            lower_bound=_bound(twists, start, goal),
            obstacles=self.obstacles,
            margin=self.margin,
            rest=self.rest,
            on="decoupled" if isinstance(self.by, Apart) else "full",
        )

    def _blocked(self, found: Plan) -> str | None:
        """Why the exact motion will not do, though it arrives; or None."""
        if isinstance(self.by, Apart):
            return None
        if self.obstacles:
            t = found.execute(method="momentum", sample_interval=self.period / 8)
            kernel = np.full(8, 1 / 8)
            means = np.column_stack([np.convolve(c, kernel, mode="valid") for c in t.position.T])
            if np.any(free_distance(self.obstacles, means) < self.margin):
                return "the exact motion comes nearer to an obstacle than the margin"
        passed = [] if self.limits is None else found.demands().beyond(self.limits)
        return f"it takes a {', a '.join(passed)}" if passed else None


def _apart(model: Model, motions: Motions) -> Apart:
    """The robot's single-axis models with the yaw model's legs as in the motions."""
    rows = np.isclose(motions.amplitude, motions.amplitude.max())
    offset, first = np.unique(motions.offset[rows], return_index=True)
    ratio = (motions.yaw_amplitude[rows] / motions.amplitude[rows])[first]
    return Apart(DecoupledModels(model.robot), offset, ratio)


def _radius(model: Model) -> float:
    """Half the shell's width [m]."""
    shell = model.robot.shell
    return max(shell.support(np.array(u)) for u in ((1.0, 0, 0), (0, 1.0, 0)))


def _bound(twists: Array, start: Array, goal: Array) -> float:
    """Time of the distance and the turn at the highest speed and yaw rate [s]."""
    turn = abs(gap(start.copy(), goal)[2])
    far = float(np.hypot(*(goal[:2] - start[:2])))
    speed, rate = np.linalg.norm(twists[:, :2], axis=1).max(), np.abs(twists[:, 2]).max()
    return float(max(far / speed, turn / rate))
