"""The search for one plan: coarse ways of settled motions, made exact one after the other."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.schedule import Schedule, stretch
from rrrobot.models.base import Model
from rrrobot.steering.arcs import joined, path
from rrrobot.steering.lattice import around
from rrrobot.steering.motions import Motions
from rrrobot.steering.obstacles import Obstacle, free_distance
from rrrobot.steering.plans import Plan
from rrrobot.steering.shooting import Apart, Knobs, Shot, final_poses, gap, off, shoot
from rrrobot.steering.standing import Rest
from rrrobot.studies.optimisation.table import GaitLimits

CYCLES_OF_BLEND = 2
_CANDIDATES, _SHOTS = 48, 6


class Found(NamedTuple):
    """What a search comes to."""

    plan: Plan | None
    """it arrives, and keeps everything"""
    nearest: Plan | None
    """else the one that ends nearest, if there is any"""
    why: str
    """there is no plan"""
    too_hard: bool
    """whether one arrives that asks for more than the limits"""


class _Way(NamedTuple):
    """A coarse plan."""

    choice: list[int]
    """which motions"""
    time: list[float]
    """how long each [s]"""


class Search:
    """Of one plan.

    Args:
        model: on which plans are executed.
        by: on which they are made exact.
        rest: how the robot stands at the start.
        motions: few, to choose from.
        obstacles, margin: what the contact point keeps away from, and how far [m].
        room: what the margin is widened by [m]: the exact motion leaves the coarse path by about
            a centimetre where gaits change.
        limits, max_power: that the whole run keeps.
        cost: of a second of each motion (n,); of plans the cheapest come first.
    """

    def __init__(
        self,
        model: Model,
        by: Model | Apart,
        rest: Rest,
        motions: Motions,
        *,
        obstacles: Sequence[Obstacle],
        margin: float,
        room: float,
        limits: GaitLimits | None,
        max_power: float | None,
        cost: Array,
    ) -> None:
        self.model, self.by, self.rest, self.motions = model, by, rest, motions
        self.obstacles, self.margin, self.room = tuple(obstacles), margin, margin + room
        self.limits, self.max_power = limits, max_power
        self.cost = cost / cost.min()
        self.period = 2 * np.pi / motions.angular_frequency
        self.blend = CYCLES_OF_BLEND * self.period

    def free(self, points: Array) -> Array:
        """Which points (n, 2) keep the margin, and room to rock."""
        return np.asarray(free_distance(self.obstacles, points) >= self.room)

    def run(self, stops: list[Array], tolerance: tuple[float, float], longest: float) -> Found:
        """A plan from the first pose past the others to the last, in `longest` seconds."""
        ends = np.array([stop[:2] for stop in stops])
        away = free_distance(self.obstacles, ends)
        self.room = min(self.room, float(away[away >= self.margin].min()))
        # The way to rest takes a blend more than the coarse plan says.
        ways, end = self._ways(stops, longest - 1.2 * self.blend)
        goal = stops[-1] if end is None else end
        start, tail = stops[0], self.rest.settling
        knobs = [self._knobs(way) for way in ways]
        times = np.array([k.make(x).duration for k, x in knobs])
        keep = np.flatnonzero(times <= longest)
        ways, knobs, times = [ways[i] for i in keep], [knobs[i] for i in keep], times[keep]
        if not ways:
            return Found(None, None, self._no_way(stops, longest), False)
        # Where the robot rocks about a little later is near enough to choose by.
        rough = final_poses(
            self.by, [k.make(x) for k, x in knobs], start, self.rest, tail=0.15 * tail
        )
        away = np.abs(gap(rough, goal) / (0.05, 0.05, 0.3)).max(axis=1)
        price = np.array([sum(self.cost[way.choice] * way.time) for way in ways])
        # Far off and costly are both bad; those that fail in the rough are left out.
        order = np.argsort(np.where(np.isfinite(away), away + price / 15.0, np.inf), kind="stable")
        nearest: Plan | None = None
        blocked, too_hard = "", 0
        for i in order[:_SHOTS]:
            shot = shoot(
                self.by, knobs[i][0], knobs[i][1], start, goal, self.rest, tolerance=tolerance,
                tail=tail,
            )  # fmt: skip
            if not np.all(np.isfinite(shot.error)):
                continue
            found = self._made(shot, stops, ways[i])
            arrives = off(shot.error, tolerance) <= 1.0
            if arrives or end is not None:
                if why := self._nearer_than_margin(found):
                    blocked = why
                    continue
                if why := self._too_hard(found):
                    blocked, too_hard = why, too_hard + 1
                elif arrives and end is None:
                    return Found(found, None, "", False)
            if nearest is None or off(found.error, tolerance) < off(nearest.error, tolerance):
                nearest = found
            if too_hard == 2:  # other ways of the same gaits ask for as much
                break
        if end is not None:
            return Found(None, nearest, self._no_way(stops, longest), too_hard > 0)
        why = blocked or "the exact motion could not be brought to the goal"
        return Found(None, nearest, why, too_hard > 0)

    def _no_way(self, stops: list[Array], longest: float) -> str:
        for stop in stops[1:]:
            near = float(free_distance(self.obstacles, stop[None, :2])[0])
            if near < self.margin:
                return (
                    f"({stop[0]:g}, {stop[1]:g}) m is {near:.4g} m from an obstacle, and the "
                    f"margin is {self.margin:g} m"
                )
        quick = sum(_bound(self.motions.twist, a, b) for a, b in itertools.pairwise(stops))
        if quick > longest:
            return f"the legs have {longest:g} s, and no way there takes less than {quick:.4g} s"
        apart = f" and keeps {self.margin:g} m from the obstacles" if self.obstacles else ""
        return f"no way was found that takes {longest:g} s at most{apart}"

    def _ways(self, stops: list[Array], longest: float) -> tuple[list[_Way], Array | None]:
        """Coarse plans, the cheapest first, and where they end if that is not the goal."""
        twists, least = self.motions.twist, 0.5 * self.blend
        heads = [_Way([], [])]
        for number, (a, b) in enumerate(itertools.pairwise(stops)):
            last, left = number == len(stops) - 2, longest - sum(heads[0].time)
            legs: list[_Way] = []
            found = joined(twists, a, b, least=least, most=max(left, least))
            price = np.sum(self.cost[found.choice] * found.time, axis=1)
            for i in np.argsort(price, kind="stable")[:400]:
                choice, time = found.choice[i], found.time[i]
                if not self.obstacles or np.all(self.free(path(twists[choice], a, time)[:, :2])):
                    legs.append(_Way(choice.tolist(), time.tolist()))
                if len(legs) == (_CANDIDATES if last else 1):
                    break
            quick, end = _bound(twists, a, b), None
            if not legs or (self.obstacles and sum(legs[0].time) > 2 * quick):
                way = around(
                    twists, a, b, self.free, piece=4 * self.period, least=least, most=left,
                    blend=0.5 * self.blend, expansions=4000 if self.obstacles else 1000,
                )  # fmt: skip
                if way.arrives:
                    legs = sorted([_Way(way.choice, way.time), *legs], key=lambda w: sum(w.time))
                elif not legs:
                    legs, end = [_Way(way.choice, way.time)], way.end
            head = heads[0]
            heads = [_Way(head.choice + m, head.time + t) for m, t in legs]
            if end is not None:
                return _shortened(heads[0]), end
        return heads, None

    def _knobs(self, way: _Way) -> tuple[Knobs, Array]:
        """A schedule of whole cycles whose gaits can be varied, and where to begin."""
        m, k, period = self.motions, len(way.choice), self.period
        lasting = np.array(way.time, dtype=float)
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
                    for n, j, a, o, p in zip(
                        cycles, way.choice, amplitude, offset, phase, strict=True
                    )
                ],
                angular_frequency=m.angular_frequency,
                rest=self.rest.leg_angle,
                blend=self.blend,
            )

        low = np.concatenate((np.full(k, 0.4), np.full(2 * k, -0.4)))
        high = np.concatenate((np.ones(k), np.full(2 * k, 0.4)))
        unit = np.concatenate((np.full(k, 0.1), np.full(2 * k, 0.2)))
        return Knobs(make, low, high, unit), np.concatenate((share, np.zeros(2 * k)))

    def _made(self, shot: Shot, stops: list[Array], way: _Way) -> Plan:
        twists, (start, goal) = self.motions.twist, (stops[0], stops[-1])
        return Plan(
            model=self.model,
            gait=shot.schedule,
            duration=shot.schedule.duration + self.rest.settling,
            start=start,
            goal=goal,
            predicted=shot.pose,
            path=path(twists[way.choice], start, np.array(way.time)),
            lower_bound=_bound(twists, start, goal),
            obstacles=self.obstacles,
            margin=self.margin,
            rest=self.rest,
            on="decoupled" if isinstance(self.by, Apart) else "full",
        )

    def _nearer_than_margin(self, found: Plan) -> str | None:
        """Whether the exact motion, though it arrives, comes too near to an obstacle."""
        if not self.obstacles or isinstance(self.by, Apart):
            return None
        t = found.execute(method="momentum", sample_interval=self.period / 8)
        kernel = np.full(8, 1 / 8)
        means = np.column_stack([np.convolve(c, kernel, mode="valid") for c in t.position.T])
        if np.any(free_distance(self.obstacles, means) < self.margin):
            return "the exact motion comes nearer to an obstacle than the margin"
        return None

    def _too_hard(self, found: Plan) -> str | None:
        """What a plan asks for beyond the limits."""
        if self.limits is None and self.max_power is None:
            return None
        limits = GaitLimits(min_normal_force=0.0) if self.limits is None else self.limits
        passed = found.demands().beyond(limits, found.model.robot, self.max_power)
        return f"it takes a {', a '.join(passed)}" if passed else None


def _shortened(way: _Way) -> list[_Way]:
    """A way that does not arrive, and its beginnings: the exact motion may not have its room."""
    return [
        _Way(way.choice[: k + 1], [*way.time[:k], share * way.time[k]])
        for k in range(len(way.choice))
        for share in (0.6, 1.0)
    ][: -_SHOTS - 1 : -1]


def _bound(twists: Array, start: Array, goal: Array) -> float:
    """Time of the distance and the turn at the highest speed and yaw rate [s]."""
    turn = abs(gap(start.copy(), goal)[2])
    far = float(np.hypot(*(goal[:2] - start[:2])))
    speed, rate = np.linalg.norm(twists[:, :2], axis=1).max(), np.abs(twists[:, 2]).max()
    return float(max(far / speed, turn / rate))
