"""The search for one orbit: checks, steps that are fine enough, starts, and what was found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait
from rrrobot.errors import GaitError, ModelError, OrbitError, ParameterError
from rrrobot.models.base import Model
from rrrobot.momentum.batch import Setting, decoupled_setting, lower
from rrrobot.momentum.newton import TOLERANCE
from rrrobot.momentum.returns import Cycles, Seen, carry, cycles_of_gait, replicated
from rrrobot.orbits.measures import Measures, look, measures
from rrrobot.orbits.newton import ReturnMap, derivative, descend, iterate, return_map
from rrrobot.orbits.section import Section, section_of

LONGEST_STEP = 0.025
"""Of the first try [s]."""
_LEAST_STEPS, _MOST_STEPS = 36, 40_000
_STEP_ERROR = 1e-11
"""What twice as many steps may change in scaled units."""
SETTLING = 25
"""Periods from the impulsive start before Newton's first step."""
_HEADINGS = 24
"""From which a slope is searched for one that comes back."""
_STILL = 1e-12


@dataclass(frozen=True, kw_only=True)
class Case:
    """A model and a gait, checked, in the engine's terms."""

    model: Any
    gait: Gait
    yaw_gait: Gait | None
    setting: Setting
    section: Section
    period: float
    periods: int
    steps: int | None
    """given by the user; None: as many as are needed"""

    def map_of(self, steps: int) -> ReturnMap:
        """The return map with so many steps in a period of the legs."""
        cycles = cycles_of_gait(self.setting, self.gait, self.period, steps, self.yaw_gait)
        return return_map(cycles, self.section, self.periods)


@dataclass(frozen=True, kw_only=True)
class Found:
    """An orbit in the engine's terms."""

    case: Case
    map: ReturnMap
    point: Array
    """(size,)"""
    residual: float
    monodromy: Array
    """dP/dx (size, size)"""
    sight: Seen
    measures: Measures
    steps: int
    iterations: int

    @property
    def cycles(self) -> Cycles:
        """The tabulated legs."""
        return self.map.cycles


def setting_for(model: Any) -> Setting:
    """The engine's terms of a model, or of the single-axis models that share a path."""
    if getattr(model, "name", None) == "decoupled":
        return decoupled_setting(model.robot, *model.models)
    if not isinstance(model, Model):
        raise ModelError(
            f"model is {model!r}: it must be a model, such as FullModel(robot), or DecoupledModels."
        )
    return lower(model)


def prepared(
    model: Any, gait: Gait, periods: int = 1, yaw_gait: Gait | None = None,
    steps_per_cycle: int | None = None,
) -> Case:  # fmt: skip
    """Check a model and a gait; errors as for `limit_cycle`."""
    setting = setting_for(model)
    section = section_of(setting, model.name)
    if yaw_gait is not None and model.name != "decoupled":
        raise ModelError(
            f"yaw_gait is for DecoupledModels; the {model.name} model has one gait for all."
        )
    count = model.robot.n_legs
    period = checked_period(gait, count)
    if yaw_gait is not None and not np.isclose(checked_period(yaw_gait, count), period, rtol=1e-12):
        raise GaitError(
            f"yaw_gait has a period of {yaw_gait.period} s and gait one of {period} s: they must "
            "be equal."
        )
    if isinstance(periods, bool) or not isinstance(periods, int | np.integer) or periods < 1:
        raise ParameterError(f"periods is {periods!r}: it must be a whole number, at least 1.")
    if steps_per_cycle is not None and not (
        isinstance(steps_per_cycle, int | np.integer) and 5 <= steps_per_cycle <= _MOST_STEPS
    ):
        raise ParameterError(
            f"steps_per_cycle is {steps_per_cycle!r}: it must be a whole number from 5 to "
            f"{_MOST_STEPS}."
        )
    return Case(
        model=model, gait=gait, yaw_gait=yaw_gait, setting=setting, section=section,
        period=period, periods=int(periods), steps=steps_per_cycle,
    )  # fmt: skip


def checked_period(gait: Gait, legs: int) -> float:
    """Period of a gait that repeats, moves its legs, and has as many as the robot.

    Raises:
        GaitError: it does not.
    """
    if not isinstance(gait, Gait):
        raise GaitError(f"gait is {type(gait).__name__}: a limit cycle is of a prescribed Gait.")
    if gait.n_legs != legs:
        raise GaitError(
            f"the gait moves {gait.n_legs} leg joint{'s' * (gait.n_legs != 1)}, but the robot has "
            f"{legs}. Give one entry for each."
        )
    try:
        rates = gait(np.linspace(0.0, gait.period or 1.0, 65)).rate
    except GaitError:
        rates = np.ones((1, 1))
    if not np.any(np.abs(rates) > _STILL):
        raise GaitError(
            "the legs do not move, so there is no cycle: see equilibrium and modes in rr.orbits "
            "for rest and the oscillations about it, or give the gait an amplitude."
        )
    if gait.period is None:
        raise GaitError(
            f"{type(gait).__name__} does not repeat (its period is None), so no motion does: give "
            "it a period, or frequencies whose ratios are small fractions."
        )
    start, end = gait(0.0), gait(gait.period)
    moved, rates = (b - a for a, b in zip(start[:2], end[:2], strict=True))
    # Legs may have gone round.
    moved = moved - 2 * np.pi * np.round(moved / (2 * np.pi))
    gap = max(float(np.max(np.abs(part), initial=0.0)) for part in (moved, rates))
    if gap > 1e-9 * (1.0 + float(np.max(np.abs(start.rate), initial=0.0))):
        raise GaitError(
            f"the gait says that it repeats after {gait.period:.6g} s, but then its angles or "
            f"rates differ by {gap:.3g} from those at the start. Only legs that repeat have a "
            "limit cycle; a RampIn does not, its .gait does."
        )
    return float(gait.period)


def find(case: Case, start: Array | None = None) -> Found:
    """The orbit of a case near a start (size,), or near what the impulsive start comes to.

    Raises:
        OrbitError: see `limit_cycle`.
    """
    if start is not None and start.shape != (case.section.size,):
        raise ParameterError(
            f"near has shape {start.shape}: this model's cycles have {case.section.size} "
            "coordinates; give another cycle of the same model, or its point."
        )
    steps = case.steps or max(_LEAST_STEPS, int(np.ceil(case.period / LONGEST_STEP)))
    P = case.map_of(steps)
    x, inverse, spent = _searched(case, P, start)
    while case.steps is None:
        finer = case.map_of(2 * steps)
        change = np.abs(finer(x) - P(x)).max(initial=0.0)
        if change <= _STEP_ERROR or 2 * steps > _MOST_STEPS:
            break
        steps, P = 2 * steps, finer
        again = iterate(P, x, inverse)
        if not again.found[0]:
            again = iterate(P, x)
        x, inverse, spent = again.point, again.inverse, spent + int(again.iterations[0])
        if not again.found[0]:
            raise _refusal(case, float(again.residual[0]), spent)
    return described(case, P, x[0], spent)


def described(
    case: Case, P: ReturnMap, x: Array, spent: int = 0, monodromy: Array | None = None
) -> Found:
    """All about the orbit at coordinates x (size,); monodromy: dP/dx where it is known."""
    cycles = P.cycles
    y = case.section.state(x[None], P.scale)
    sight = look(cycles, y, case.periods)
    m = measures(cycles, sight, case.periods)
    if not m.pitch[0] <= case.setting.limit:
        raise OrbitError(
            f"the orbit of the {case.model.name} model reaches a pitch of "
            f"{np.rad2deg(np.arcsin(min(m.pitch[0], 1))):.1f} degrees, where the damping on Euler "
            "rates is singular: use BodyRateDamping, or swing the legs less."
        )
    if np.any(sight.ground < 0.0):
        why = (
            "its contact passes the equator" if sight.ground[0, 0] < 0.0
            else "the ground curves tighter than the shell, which touches it twice"
        )  # fmt: skip
        raise OrbitError(
            f"the orbit of the {case.model.name} model is none: {why}. Give a larger radius, or "
            "swing the legs less."
        )
    residual = float(np.abs(case.section.point(sight.end, P.scale) - x).max(initial=0.0))
    if monodromy is None:
        monodromy = derivative(P, x[None])[0]
    return Found(
        case=case, map=P, point=x, residual=residual, monodromy=monodromy,
        sight=sight, measures=m, steps=cycles.steps, iterations=spent,
    )  # fmt: skip


def _searched(case: Case, P: ReturnMap, start: Array | None) -> tuple[Array, Array, int]:
    """An orbit's coordinates (1, size), the inverse there, and the periods spent."""
    if start is not None:
        starts, spent = [start[None]], 0
    elif case.section.heads:
        starts, spent = _returning(case, P), _HEADINGS * (SETTLING + 1)
    else:
        at_rest = np.zeros((1, case.section.size))
        settled = carry(P.cycles, case.section.state(at_rest, P.scale), SETTLING)
        point = case.section.point(settled, P.scale)
        starts, spent = [point, at_rest] if np.all(np.isfinite(point)) else [at_rest], SETTLING
    worst = np.inf
    for x in starts:
        roots = iterate(P, x)
        spent += int(roots.iterations[0])
        if not roots.found[0] and np.isfinite(roots.residual[0]):
            # Broyden's matrix has lost its way: steps that always lead down, then once more.
            below, periods = descend(P, x)
            roots = iterate(P, below)
            spent += periods + int(roots.iterations[0])
        if roots.found[0]:
            return roots.point, roots.inverse, spent
        worst = min(worst, float(roots.residual[0]))
    raise _refusal(case, worst, spent)


def _returning(case: Case, P: ReturnMap) -> list[Array]:
    """Starts (1, size) near headings that come back on a slope: those that hold, nearest to yaw
    zero, first.

    Robots that have settled facing all sides turn a little in each period; between
    two that turn towards each other, or away from each other, one does not.
    """
    n, section = _HEADINGS, case.section
    many = P._replace(cycles=replicated(P.cycles, n), scale=np.repeat(P.scale, n))
    x = np.zeros((n, section.size))
    x[:, -1] = np.linspace(-np.pi, np.pi, n, endpoint=False)
    x = section.point(carry(many.cycles, section.state(x, many.scale), SETTLING), many.scale)
    x = section.wrapped(x)
    turn = (many(x) - x)[:, -1]
    alive = np.isfinite(turn)
    if not alive.any():
        raise OrbitError(
            f"the {case.model.name} model tips over on its slope whatever its heading: take a "
            "gentler slope, or swing the legs less."
        )
    order = np.argsort(x[alive, -1])
    x, turn = x[alive][order], turn[alive][order]
    after, turned = np.roll(x, -1, axis=0), np.roll(turn, -1)
    after[-1, -1] += 2 * np.pi
    found = np.flatnonzero(turn * turned <= 0.0)
    if not found.size:
        raise OrbitError(
            f"no heading comes back on this slope: in each period the {case.model.name} model "
            f"turns by {np.rad2deg(turn.min()):.3g} to {np.rad2deg(turn.max()):.3g} degrees, "
            "whatever its heading. Only a gait that can go straight has a limit cycle there."
        )
    part = (turn / np.where(turn == turned, 1.0, turn - turned))[found, None]
    near = x[found] + part * (after[found] - x[found])
    leaves = turn[found] <= turned[found]
    return [near[i : i + 1] for i in np.lexsort((np.abs(near[:, -1]), leaves))]


def _refusal(case: Case, residual: float, spent: int) -> OrbitError:
    reached = (
        "the motion left the numbers (the pitch came to +-90 degrees, or the robot fell over)"
        if not np.isfinite(residual)
        else f"the smallest residual was {residual:.2g} in scaled units, {TOLERANCE:g} is wanted"
    )
    return OrbitError(
        f"no orbit of {case.periods} period{'s' * (case.periods > 1)} was found for the "
        f"{case.model.name} model: after {spent} simulated periods {reached}. Start from a "
        "neighbour's cycle (near=), follow a branch from a smaller amplitude with "
        "rr.orbits.branch, or try periods=2."
    )
