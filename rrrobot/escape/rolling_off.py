"""Off a rock: the legs shift the centre of mass to a side until the belly rolls over its edge.

On a boulder of radius R a flat belly rests where its centre of mass, h above it and c to the side,
is over the contact: the place of that on the belly is about c R / (R - h). With the contact at the
belly's edge, e to the side, the robot leans by e / R, and goes over by leaning alone if

    (c - e) cos(e / R) + h sin(e / R) >= 0,

so legs lean to the side, and up; what lacks there only speed makes up for. It tips over about an
edge that is rounded, comes back to its face and rocks on, or goes on until something of it reaches
the floor, it slides off, or the rock pushes no longer. A round belly rolls on by itself.

There the run ends: what follows is a fall, and blows of which nobody knows how they end. `Landing`
tells the place, the speed and the pose in which the rock lets go, and bounds the speed below.
`Lying` is how it comes to lie if the blows take all of its energy; if that is on its belly, a gait
on level ground goes on from there.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pinocchio as pin

from rrrobot.belly.clearance import clearances, gauges
from rrrobot.belly.feasible import feasibility
from rrrobot.belly.found import Belly
from rrrobot.belly.placed import floors, touches
from rrrobot.belly.posture import Search
from rrrobot.belly.ranges import flat_end
from rrrobot.belly.swings import farthest, leaning
from rrrobot.belly.tilting import tilts
from rrrobot.checks import Array
from rrrobot.contact.boulder import Boulder, depth_of_floor, is_rock
from rrrobot.contact.ground import normals
from rrrobot.contact.shells import FlatBelly
from rrrobot.drive.damping import Damping
from rrrobot.drive.moves import LegMoves, Straight
from rrrobot.errors import ModelError
from rrrobot.escape.edges import BACK, FALL, OVER, back_on, joined, place_of, tipped, until
from rrrobot.escape.goals import Escape
from rrrobot.escape.landing import goes_over, heights, landing
from rrrobot.escape.limits import EscapeLimits
from rrrobot.escape.ways import RollOff
from rrrobot.models.full import FullModel
from rrrobot.robot.joints import JointIndex
from rrrobot.robot.limits import JointEnds
from rrrobot.simulation.events import Event, Snapshot, lift_off
from rrrobot.simulation.trajectory import Trajectory

_ROOM, _AXIS = 0.01, 1e-9
_TOUCHES = 4
"""From the rest to the belly's edge, over which limbs are to be clear."""
_SHORTEST = (0.5, 1.0, 2.0)
"""Least times of each of the legs' moves, tried one after the other [s]."""
_ASIDE = np.deg2rad(60.0)
_FLOOR, _ROCK, _SLIDE, _LEFT = "floor", "rock", "slide", "lift-off"
_EDGE = "edge of the flat belly"
_TIMES = 20
"""That a belly comes to its edge and back, at most."""
_GONE = (_FLOOR, _SLIDE, _LEFT)


def roll_off(
    belly: Belly, goal: Escape, limits: EscapeLimits, ends: JointEnds, *,
    damping: Damping | float | None, floor: float | None = None,
) -> RollOff:  # fmt: skip
    """Shift the centre of mass to a side, and see what comes of it.

    Args:
        belly: on a boulder.
        goal: one that leans.
        limits: that hold until the belly is at its edge.
        ends: of the joints.
        damping: of the rocking.
        floor: height of the boulder's top over the floor [m]; its radius unless given.

    Raises:
        ModelError: the ground is no boulder.
    """
    ground = belly.ground
    if not is_rock(ground):
        raise ModelError(f"{goal.name} needs a rock: the ground is {ground!r}, not a Boulder.")
    depth = depth_of_floor(ground, floor)
    assert depth is not None
    side = np.array(goal.weights[:2])
    model = FullModel(belly.robot, ground=ground, damping=damping)
    rest = np.zeros(3) if belly.rest is None else belly.rest
    q = model.configuration(model.make_pose(rest, np.zeros(2)), belly.posture)
    if (low := heights(belly, q)).min() < -depth:
        link = belly.shapes.pieces[int(np.argmin(low))].link
        raise ModelError(
            f"{link} reaches the floor, {depth:g} m below the top of the rock: the robot does not "
            "hang on it. Give a higher floor=, or a posture with the legs up."
        )
    rate, (leans, least) = limits.use * ends.velocity, lean(belly, side, depth)
    best: RollOff | None = None
    for shortest, (passed, short) in product(_SHORTEST, leans):
        if short > 0 and shortest > _SHORTEST[0]:
            # What does not go over by leaning alone needs its speed.
            continue
        drive = _moves(passed, rate, shortest)
        way = _attempt(belly, goal, limits, model, depth, (short, least), drive)
        if best is None or (way.met, not way.link) > (best.met, not best.link):
            best = way
        if way.met and not way.link:
            break
    assert best is not None
    return best


def lean(belly: Belly, side: Array, depth: float) -> tuple[list[tuple[list[Array], float]], float]:
    """Postures over which the legs go to lean to a side, and how far short that is of going over.

    Args:
        belly: on a boulder.
        side: unit vector (2,).
        depth: of the floor below the boulder's top [m].

    Returns:
        of each way to lean, its postures (legs,) [rad], and how far the centre of mass is then
        from being over the contact with the belly at its edge [m]; and that number of the legs
        that lean most if nothing is in their way.
    """
    search = _search(belly, float(np.arctan2(side[1], side[0])), depth)
    found: list[tuple[list[Array], float]] = []
    for rise in _rises(search):
        passed = leaning(search, belly.posture, side, rise)
        if not any(np.array_equal(passed[-1], other[-1]) for other, _ in found):
            found.append((passed, _short(belly, search, passed[-1], side)))
    return found, _short(belly, search, farthest(search, belly.posture), side)


def _attempt(
    belly: Belly, goal: Escape, limits: EscapeLimits, model: FullModel, depth: float,
    short: tuple[float, float], drive: LegMoves,
) -> RollOff:  # fmt: skip
    """What comes of some moves of the legs."""
    ground, side = model.ground, np.array(goal.weights[:2])
    rest = np.zeros(3) if belly.rest is None else belly.rest
    watch = _watch(belly, depth)
    end = drive.moves[-1].end
    shift = float((_mass_center(belly, end) - _mass_center(belly, belly.posture))[:2] @ side)
    run, said = until(model, drive, drive.duration + FALL, watch, euler=rest, start="rest")
    held = replace(limits, tilt=np.pi).of(run.robot.mass * run.gravity)
    parts = [feasibility(run, held, belly=belly)]
    over, ended, flat = float("nan"), said, isinstance(belly.shell, FlatBelly)
    for _ in range(_TIMES):
        at = float(run.time[-1])
        if flat and _EDGE in ended:
            over = at
            run, ended = tipped(belly, model, drive, run, [*watch, _slide(limits.friction)])
        elif ended == BACK and at < drive.duration + FALL:
            on, ended = back_on(belly, model, drive, run, watch, drive.duration + FALL - at)
            parts.append(feasibility(on, held, belly=belly))
            run = joined(run, on)
        else:
            break
    if not flat and said in _GONE:
        rolled, around = tilts(belly, run.configuration[-1:], run.position[-1:], ground)
        if said != _FLOOR or rolled[0] >= belly.rolling_range.at(around)[0]:
            over = float(run.time[-1])
    elif ended not in (*_GONE, _ROCK, BACK):
        over = float("nan")
    link = _lowest(belly, run) if ended == _FLOOR else ""
    broken = list(dict.fromkeys(str(v) for part in parts for v in part.violations))
    if ended == _FLOOR and np.isnan(over) and not broken:
        rolled, _ = tilts(belly, run.configuration[-1:], run.position[-1:], ground)
        reason = (
            f"{link} reaches the floor while the belly still lies on the rock, rolled by "
            f"{np.rad2deg(rolled[0]):.0f} deg: legs higher with posture=, or a higher rock (floor=)"
        )
    else:
        reason = _reason(belly, run, side, shift, short, ended, broken)
    friction = max(part.peak_friction for part in parts)
    return RollOff(
        goal=goal, drive=drive, shift=shift, short=short[0], least=short[1], met=not reason,
        reason=reason, ended=ended, link=link, over=over, friction=friction,
        landing=landing(belly, run, depth), trajectory=run,
    )  # fmt: skip


def _search(belly: Belly, azimuth: float, depth: float) -> Search:
    """Postures that are clear of rock and floor until the belly is at its edge, and over it."""
    shell, ground = belly.shell, belly.ground
    assert isinstance(ground, Boulder)
    end, over = float(belly.rolling_range.at(azimuth)), np.zeros(0)
    if isinstance(shell, FlatBelly):
        around = np.array((azimuth,))
        end = float(flat_end(shell, ground, around)[0])
        over = OVER
    at = touches(
        shell, belly.center, ground, np.linspace(0.0, end, _TOUCHES), np.full(_TOUCHES, azimuth)
    )
    side = np.array((np.cos(azimuth), np.sin(azimuth)))
    past = np.column_stack((np.sin(over)[:, None] * side, -np.cos(over)))
    at = at._replace(
        point=np.vstack((at.point, np.tile(at.point[-1], (len(over), 1)))),
        normal=np.vstack((at.normal, past)),
    )
    floor = floors(at, depth, np.full(len(at.point), azimuth))
    kinds = [kind for kind, out in zip(("left-right", "front-back"), side[::-1], strict=True)
             if abs(out) < _AXIS]  # fmt: skip
    return Search(belly.shapes, at, np.zeros(2), _ROOM, frozenset(belly.covered), floor, kinds)


def _rises(search: Search) -> list[float]:
    """How far aside counts as much as a metre up for what is to go over the belly's edge [m].

    As it is with the belly at its edge and, if that is flat, tipped a little about it.
    """
    assert search.floor is not None
    ups = search.floor.up[_TOUCHES - 1 : _TOUCHES + 1]
    return [float(np.linalg.norm(up[:2]) / up[2]) for up in ups]


def _short(belly: Belly, search: Search, leg_angle: Array, side: Array) -> float:
    """How far the centre of mass is from being over the contact with the belly at its edge [m]."""
    assert search.floor is not None
    up = search.floor.up[_TOUCHES - 1]
    across = np.append(side * up[2], np.linalg.norm(up[:2]))
    return float((search.at.point[_TOUCHES - 1] - _mass_center(belly, leg_angle)) @ across)


def _moves(passed: list[Array], rate: Array, shortest: float) -> LegMoves:
    """The legs' moves from posture to posture, each from rest to rest."""
    moves = []
    for a, b in pairwise(passed if len(passed) > 1 else passed * 2):
        duration = max(shortest, float((2.0 * np.abs(b - a) / rate).max()))
        moves.append(Straight(start=a, end=b, duration=duration))
    return LegMoves(moves)


def _mass_center(belly: Belly, leg_angle: Array) -> Array:
    model = belly.robot.model
    q = pin.neutral(model)
    JointIndex(model, belly.robot.legs).write(q, leg_angle)
    return np.array(pin.centerOfMass(model, model.createData(), q))


def _watch(belly: Belly, depth: float) -> list[Event]:
    """What ends a run: something reaches the floor, a limb the rock, or the rock pushes no more."""
    shapes, base = belly.shapes, {piece.link for piece in belly.shapes.on_joint(1)}
    base |= set(belly.covered)

    def height(at: Snapshot) -> float:
        return float(heights(belly, at.dynamics.q).min()) + depth

    def room(at: Snapshot) -> float:
        found = clearances(alone, at.dynamics.q[None], belly.ground, known=known)
        limbs = [i for i, link in enumerate(found.links) if link not in base]
        return float(found.ground[0, limbs].min(initial=1.0))

    # Without pairs: links were looked at before.
    alone = replace(shapes)
    alone.__dict__["pairs"] = []
    known = gauges(shapes, belly.ground)
    return [Event(height, True, -1, _FLOOR), Event(room, True, -1, _ROCK), lift_off()]


def _slide(friction: float) -> Event:
    """The contact needs more friction than the rock offers."""

    def left(at: Snapshot) -> float:
        normal = normals(at.model.ground, at.position[None])[0]
        force = np.asarray(at.dynamics.contact_force)
        along = float(force @ normal)
        return friction * along - float(np.linalg.norm(force - along * normal))

    return Event(left, True, -1, _SLIDE)


def _lowest(belly: Belly, run: Trajectory) -> str:
    lowest = int(np.argmin(heights(belly, run.configuration[-1])))
    return belly.shapes.pieces[lowest].link


def _reason(
    belly: Belly, run: Trajectory, side: Array, shift: float, short: tuple[float, float],
    ended: str, broken: list[str],
) -> str:  # fmt: skip
    """Why a robot did not get off to a side; empty if it did."""
    if broken:
        return f"on the way {'; '.join(broken)}"
    if ended in _GONE:
        # The base's z axis leans to where it fell.
        turn = pin.Quaternion(run.configuration[-1, 3:7].copy()).toRotationMatrix()
        down = -turn[2, :2]
        went = float(np.arccos(np.clip(down @ side / max(np.linalg.norm(down), 1e-12), -1, 1)))
        if went > _ASIDE:
            return f"it goes over {np.rad2deg(went):.0f} deg away from that side"
        if ended != _FLOOR and not goes_over(belly, run, side):
            return "it slips at its edge before it is sure to go over it"
        return ""
    moved = f"the legs move the centre of mass {1000 * shift:.0f} mm to that side"
    if ended == _ROCK:
        return (
            f"{moved}, and a limb touches the rock on the way: legs higher with posture=, or a "
            "smaller rock"
        )
    if ended not in ("", BACK):
        return ended
    place = float((place_of(run) - belly.center)[:2] @ side)
    done = f"{moved}, which rolls the belly {1000 * place:.0f} mm, and it stays on the rock"
    return f"{done}: {lacks(*short)}"


def lacks(short: float, least: float) -> str:
    """What the centre of mass lacks with the belly at its edge [m], and what would help."""
    if short <= 0:
        return "a slower lean, or a smaller rock would let it go"
    text = f"with the belly at its edge it is {1000 * short:.0f} mm short of going over"
    if least <= 0:
        return f"{text}, which legs could do that nothing is in the way of"
    return f"{text}, {1000 * least:.0f} mm if nothing were in the way of the legs"
