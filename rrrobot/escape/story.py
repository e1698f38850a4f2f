"""Get a robot free: belly, rest, modes, and the best gaits for each goal, confirmed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from rrrobot.belly.clearance import clearances
from rrrobot.belly.fit import fit_belly
from rrrobot.belly.found import Belly
from rrrobot.contact.boulder import depth_of_floor, is_rock
from rrrobot.contact.ground import Ground, Plane
from rrrobot.drive.damping import Damping
from rrrobot.errors import GaitError, ModelError, ParameterError, ShellError
from rrrobot.escape.atlas import Atlas
from rrrobot.escape.bench import Bench
from rrrobot.escape.bodies import base_length, capsules_of, with_legs
from rrrobot.escape.confirming import EscapeGait, confirm, why_not
from rrrobot.escape.finding import SAME, UNLIKE, find_gaits, gap
from rrrobot.escape.goals import ROCK, USUAL, Escape, goal_of
from rrrobot.escape.landing import heights
from rrrobot.escape.limits import TOUCH, EscapeLimits, Rules
from rrrobot.escape.loss import RATIO, rocking_damping, rocking_modes
from rrrobot.escape.lying import Lying, comes_to_lie
from rrrobot.escape.polish import Judged
from rrrobot.escape.rolling_off import roll_off
from rrrobot.escape.spaces import GROUPS
from rrrobot.escape.stances import stances
from rrrobot.escape.unstuck import Unstuck
from rrrobot.escape.ways import RollOff
from rrrobot.models.full import FullModel
from rrrobot.progress import Progress, Tell, checked_progress, progress_of
from rrrobot.robot.robot import Robot

_TRIED = 12
"""Gaits that are held against all limits for a goal until enough are confirmed, at most."""

_BY_WAY = 2
"""Postures over which the legs of a robot that has fallen go to its belly's, at most."""
_AIMS, _UNLIKE_WAYS = 3, 3
"""Directions of the gait on the floor that are searched, and gaits in each that are confirmed."""
_STRAIGHT = float(np.deg2rad(20.0))
"""Angle from the wanted side up to which a gait's way is taken at once [rad]."""
_NEAR = 5.0
"""Of directions [deg]: those so near are one."""


def unstick(
    robot: Robot | Belly | str | Path,
    *,
    goals: Sequence[str | Escape] | None = None,
    ground: Ground | None = None,
    joints: Sequence[str] | None = None,
    groups: Sequence[str] = GROUPS,
    limits: EscapeLimits | None = None,
    damping: Damping | None = None,
    damping_ratio: float = RATIO,
    postures: int = 6,
    harmonics: int = 1,
    solutions: int = 1,
    budget: int = 12000,
    floor: float | None = None,
    folder: str | Path | None = None,
    progress: Progress = False,
) -> Unstuck:
    """Find how a robot that lies on its belly can move, and show that nothing breaks.

    The belly is fitted, gaits near its rocking modes are searched for each goal, and the best are
    confirmed by the general model with forces and by distances of the links' shapes.

    Args:
        robot: a Robot, the name of an example, the path of a URDF, or a `Belly` that is fitted.
        goals: "forward", "left" (sideways), "turn left", "direction:30", ... see
            `rrrobot.escape.goals`. The usual ones unless given. For "off:90" (off a rock, to the
            left) the legs lean to that side until the belly rolls over its edge; where it does
            not, the gait that rocks farthest to it is searched. On the floor below it comes to
            lie as `rrrobot.escape.lying` says, and if that is on its belly, the gait that goes on
            to that side is searched as on level ground.
        ground: level ground unless given.
        joints: that move, the others are held in the belly's posture; all unless given.
        groups: ways in which limbs may move together; see `rrrobot.escape.spaces`.
        limits: `EscapeLimits()` unless given, with what the file allows each joint.
        damping: of the rocking. Unless given, roll and pitch have
        damping_ratio: this one, an assumption that the report names.
        postures: at most, to search about.
        harmonics: of the gaits.
        solutions: unlike gaits wanted for each goal.
        budget: gaits that may be simulated for a goal.
        floor: of goals off a rock: height of its top over the floor [m]; its radius unless given.
        folder: where results are kept as they come; a run that was interrupted goes on from there.
        progress: in gaits of the goals' budgets; see `rrrobot.progress`.

    Returns:
        an `Unstuck`. Where no gait is feasible it says why.

    Raises:
        ParameterError: a goal, joint or group that does not exist, a number out of range.
        ShellError, UrdfError: as `fit_belly` raises.

    Example:
        >>> import rrrobot as rr
        >>> found = rr.unstick("solo12", goals=["forward"])  # doctest: +SKIP
        >>> found.best("forward").met, found.best("forward").value > 0.03  # doctest: +SKIP
        (True, True)
    """
    limits = EscapeLimits() if limits is None else limits
    for name, number, most in (
        ("postures", postures, 20), ("harmonics", harmonics, 4), ("solutions", solutions, 5),
    ):  # fmt: skip
        if isinstance(number, bool) or number not in range(1, most + 1):
            raise ParameterError(f"{name} is {number!r}: it must be a whole number, 1 to {most}.")
    if isinstance(budget, bool) or not isinstance(budget, int | np.integer) or budget < 1:
        raise ParameterError(f"budget is {budget!r}: it must be a whole number, 1 at least.")
    checked_progress(progress)
    if isinstance(robot, Belly):
        belly = robot
        floor = depth_of_floor(belly.ground, floor)
    else:
        floor = depth_of_floor(Plane() if ground is None else ground, floor)
        belly = fit_belly(robot, ground=ground, floor=floor)
    if goals is None:
        goals = ROCK if is_rock(belly.ground) else USUAL
    wanted = [goal_of(goal) for goal in goals]
    asked: dict[str, Any] = {
        "joints": None if joints is None else list(joints), "groups": list(groups),
        "damping": damping_ratio if damping is None else damping.to_dict(), "floor": floor,
        "postures": int(postures), "harmonics": int(harmonics), "solutions": int(solutions),
        "budget": int(budget),
    }  # fmt: skip
    found = Unstuck.begun(belly, limits, wanted, folder, asked)
    left = [goal for goal in wanted if goal.name not in found.done]
    if not left:
        return found
    if not belly.stable or belly.rolling_range.least <= 0:
        return found.stopped(belly.reason)
    work: _Work | None = None
    with progress_of(progress, "postures", budget * len(left), "gaits") as told:
        tell = told or (lambda done, part="": None)
        for i, goal in enumerate(left):
            try:
                if work is None:
                    work = _Work(
                        belly, limits, joints, tuple(groups), damping, damping_ratio, postures
                    )
                    found = found.known(work.model)
                search = (budget, harmonics, solutions, partial(_add, tell, i * budget))
                if goal.leans:
                    way = work.off(goal, floor)
                    found = found.rolled(goal, work.onward(way, *search) if way.met else way)
                    if way.met:
                        continue
                gaits = work.gaits(goal, *search)
            except (GaitError, ModelError) as error:
                found = found.failed(goal, str(error))
            else:
                found = found.reached(goal, gaits)
            tell((i + 1) * budget)
    return found


def _gains(way: RollOff) -> float:
    """Speed of a way's gait on the floor to the wanted side [m/s]; none loses to any."""
    return -np.inf if way.after is None else way.after.value * float(np.cos(way.astray))


def _add(tell: Tell, before: float, done: float, part: str) -> None:
    tell(before + done, part)


class _Work:
    """What all goals of a robot have in common."""

    def __init__(
        self,
        belly: Belly,
        limits: EscapeLimits,
        joints: Sequence[str] | None,
        groups: tuple[str, ...],
        damping: Any,
        ratio: float,
        postures: int,
    ) -> None:
        if joints is not None:
            belly = with_legs(belly, tuple(joints))
        self.belly, self.limits = belly, limits
        self.again = partial(_Work, limits=limits, joints=None, groups=groups, damping=damping,
                             ratio=ratio, postures=postures)  # fmt: skip
        robot, posture = belly.robot, belly.posture
        bare = FullModel(robot, ground=belly.ground, damping=None)
        loss = rocking_damping(bare, posture, ratio) if damping is None else damping
        self.model = FullModel(robot, ground=belly.ground, damping=loss)
        self.length = base_length(belly.shapes)
        self.ends = limits.ends(robot)
        self.tilt = float(belly.rolling_range.least if limits.tilt is None else limits.tilt)
        rocking = rocking_modes(self.model, posture)
        decay = min((mode.decay_rate for mode in rocking), default=0.0)
        if decay <= 0:
            raise ModelError(
                "the rocking about the rest does not decay, so no gait settles: give a damping."
            )
        capsules, limbs = capsules_of(belly.shapes, belly.covered)
        ground = belly.ground
        level = ground.normal(ground.point(np.zeros(2)))[2] > 1.0 - 1e-12
        rest = None if level or belly.rest is None else belly.rest[:2]
        self.bench = Bench(self.model, capsules, limbs, decay, rest)
        shapes, least = belly.shapes, limits.separation
        about = stances(shapes, self.bench, posture, self.ends, limits, postures)
        benches = [self.bench.near(shapes, offset[None], least) for offset in about]
        self.atlas = Atlas(self.model, about, benches, self.ends, self.tilt, groups)

    def gaits(
        self, goal: Escape, budget: int, harmonics: int, solutions: int, tell: Tell
    ) -> list[EscapeGait]:
        """Confirmed gaits, the best first; if none is, the nearest."""
        rules = Rules(goal, self.limits, self.ends, self.tilt, self.length)
        found = find_gaits(
            self.bench, self.atlas, rules, budget=budget, harmonics=harmonics,
            nearer=self._nearer, tell=lambda done: tell(done, f"searching {goal.name}"),
        )  # fmt: skip
        confirmed: list[EscapeGait] = []
        good: list[Judged] = []
        bad: list[Judged] = []
        for one in found:
            if len(good) == solutions or len(good) + len(bad) == _TRIED:
                break
            near = min((gap(one, other) for other in good), default=np.inf) <= UNLIKE
            if near or min((gap(one, other) for other in bad), default=np.inf) <= SAME:
                continue
            tell(budget, f"confirming {goal.name}")
            gait = self._confirm(rules, one, method="momentum")
            if gait.met:
                cycles = round(gait.ramp / (gait.gait.period or 1.0))
                gait = self._confirm(rules, one, ramps=(cycles,))
            if gait.met:
                confirmed.append(gait)
            (good if gait.met else bad).append(one)
        return confirmed or [self._confirm(rules, bad[0])]

    def _confirm(self, rules: Rules, one: Judged, **options: Any) -> EscapeGait:
        return confirm(self.model, self.bench, rules, one, self.belly, **options)

    def off(self, goal: Escape, floor: float | None) -> RollOff:
        """What comes of the legs' leaning to a side of a rock."""
        return roll_off(
            self.belly, goal, self.limits, self.ends, damping=self.model.damping, floor=floor
        )

    @cached_property
    def below(self) -> _Work:
        """The same robot on the floor."""
        form = "auto" if self.belly.kind == "flat" else self.belly.form
        belly = fit_belly(self.belly.robot, form=form)
        if not belly.stable or belly.rolling_range.least <= 0:
            raise ModelError(f"on the floor, {belly.reason}")
        return self.again(belly)

    def onward(self, way: RollOff, *search: Any) -> RollOff:
        """How it comes to lie on the floor, and the gait that goes on from there.

        Args:
            way: off the rock.
            search: as for `gaits`, but for the goal.
        """
        if way.link:
            said = f"it stands between the rock and {way.link}, and what follows is not computed"
            return replace(way, stays=said)
        run, shapes = way.trajectory, self.belly.shapes
        q = run.configuration[-1]
        floor = float(heights(self.belly, q).min()) - way.landing.room
        fall = partial(comes_to_lie, shapes, q, run.velocity[-1], floor, gravity=run.gravity)
        try:
            belly = self.below.belly
        except (ModelError, ShellError) as error:
            return replace(way, lying=fall(postures=[self.belly.posture]), stays=str(error))
        base = {piece.link for piece in shapes.on_joint(1)} | set(belly.covered)

        def down_of(lying: Sequence[Lying]) -> list[bool]:
            return [base.issuperset(one.links) and one.tilt < belly.rolling_range.least
                    for one in lying]  # fmt: skip

        # To the belly's posture at once, or by way of others that the legs have been in.
        known = (belly.posture, self.belly.posture, way.drive(way.drive.duration).angle)
        tried = [fall(postures=[belly.posture])]
        for first in (one for n in range(1, _BY_WAY + 1) for one in product(known, repeat=n)):
            if all(down_of(tried[-1])):
                break
            tried.append(fall(postures=[*first, belly.posture]))
        lying = tried[-1] if all(down_of(tried[-1])) else tried[0]
        way, down = replace(way, lying=lying), down_of(lying)
        if len(lying) > 1 and any(down):
            return replace(way, stays="whether it lies on its belly depends on how it falls")
        if not down[0]:
            return replace(way, stays="it does not lie on its belly")
        ahead, left, _ = way.goal.weights
        side = float(np.rad2deg(np.arctan2(left, ahead) - lying[0].heading))
        # Along an axis of the robot, where gaits are symmetric and fast, if that is near.
        axis = 90.0 * round(side / 90.0)
        side = axis if abs(side - axis) < _NEAR else side
        budget, harmonics, _, tell = search
        best, said = way, ""
        for _ in range(_AIMS):
            try:
                gaits = self.below.gaits(
                    goal_of(f"direction:{side:.0f}"), budget, harmonics, _UNLIKE_WAYS, tell
                )
            except (GaitError, ModelError) as error:
                said = said or str(error)
                break
            ways = [replace(way, after=gait) for gait in gaits if gait.met]
            if not ways:
                said = said or why_not(gaits[0])
                break
            here = max(ways, key=_gains)
            best = max(best, here, key=_gains)
            if abs(best.astray) <= _STRAIGHT:
                break
            # Where it turns as it gets going, it is to begin beside the wanted side.
            side -= float(np.rad2deg(here.astray))
        return best if best.after is not None else replace(way, stays=said)

    def _nearer(self, bench: Bench, one: Judged) -> Bench | None:
        """None where links stay off the ground and each other; else a bench that knows better."""
        (every,) = bench.configurations(one.gait)
        shapes, covered = self.belly.shapes, self.belly.covered
        found = clearances(shapes, every, self.belly.ground)
        base = {piece.link for piece in shapes.on_joint(1)} | set(covered)
        limbs = [i for i, link in enumerate(found.links) if link not in base]
        height = found.ground[:, limbs].min(initial=np.inf)
        if height >= 0 and found.between.min() >= -TOUCH:
            return None
        return bench.near(shapes, bench.cycle(one.gait), self.limits.separation)
