"""Off a rock: the legs shift the centre of mass to a side until the belly rolls over its edge.

On a boulder of radius R a flat belly rests where its centre of mass, h above it and c to the side,
is over the contact: the place of that on the belly is about c R / (R - h). Where it comes to the
belly's edge the robot tips over, about an edge that is rounded, and goes on until something of it
reaches the floor, it slides off, or the rock pushes no longer. A round belly rolls on by itself.

There the run ends: what follows is a fall, and blows of which nobody knows how they end. `Landing`
tells the place, the speed and the pose in which the rock lets go, and bounds the speed below.
`Lying` is how it comes to lie if the blows take all of its energy; if that is on its belly, a gait
on level ground goes on from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin

from rrrobot.belly.clearance import clearances, gauges
from rrrobot.belly.feasible import feasibility
from rrrobot.belly.found import Belly
from rrrobot.belly.placed import floors, touches, with_shell
from rrrobot.belly.posture import Search
from rrrobot.belly.ranges import flat_end
from rrrobot.belly.swings import leaning
from rrrobot.belly.tilting import tilts
from rrrobot.checks import Array
from rrrobot.contact.boulder import Boulder, depth_of_floor, is_rock
from rrrobot.contact.ground import normals
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.surfaces import Ellipsoid
from rrrobot.drive.damping import Damping
from rrrobot.drive.gaits import CallableGait, Gait
from rrrobot.drive.moves import LegMoves, Straight
from rrrobot.errors import ModelError, SimulationError, SimulationInterrupted
from rrrobot.escape.goals import Escape
from rrrobot.escape.landing import heights, landing
from rrrobot.escape.limits import EscapeLimits
from rrrobot.escape.ways import RollOff
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.robot.joints import JointIndex
from rrrobot.robot.limits import JointEnds
from rrrobot.simulation.events import Event, Snapshot, lift_off
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory

EDGE = 0.01
"""Radius of a belly's edge [m]."""
_ROOM, _AXIS = 0.01, 1e-9
_OVER = np.deg2rad((15.0, 30.0, 45.0))
"""Tilts beyond a flat belly's edge at which limbs are to be clear, too [rad]."""
_SHORTEST = 0.5
"""Of the legs' move [s]."""
_FALL, _SAMPLE = 5.0, 0.005
_ASIDE = np.deg2rad(60.0)
_FLOOR, _ROCK, _SLIDE, _LEFT, _BACK = "floor", "rock", "slide", "lift-off", "back"
_LITTLE = 1e-3
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
    azimuth = float(np.arctan2(side[1], side[0]))
    search = _search(belly, azimuth, depth)
    passed = leaning(search, belly.posture, side)
    shift = float((_mass_center(belly, passed[-1]) - _mass_center(belly, passed[0]))[:2] @ side)
    drive = _moves(passed, limits.use * ends.velocity)
    model = FullModel(belly.robot, ground=ground, damping=damping)
    watch = _watch(belly, depth)
    rest = np.zeros(3) if belly.rest is None else belly.rest
    q = model.configuration(model.make_pose(rest, np.zeros(2)), belly.posture)
    if (low := heights(belly, q)).min() < -depth:
        link = belly.shapes.pieces[int(np.argmin(low))].link
        raise ModelError(
            f"{link} reaches the floor, {depth:g} m below the top of the rock: the robot does not "
            "hang on it. Give a higher floor=, or a posture with the legs up."
        )
    run, said = _until(model, drive, drive.duration + _FALL, watch, euler=rest, start="rest")
    own = feasibility(run, replace(limits, tilt=np.pi).of(run.robot.mass * run.gravity),
                      belly=belly)  # fmt: skip
    over, ended = float("nan"), said
    if isinstance(belly.shell, FlatBelly) and "edge of the flat belly" in said:
        over = float(run.time[-1])
        run, ended = _tipped(belly, model, drive, run, [*watch, _slide(limits.friction)])
    elif said in _GONE:
        rolled, around = tilts(belly, run.configuration[-1:], run.position[-1:], ground)
        if said != _FLOOR or rolled[0] >= belly.rolling_range.at(around)[0]:
            over = float(run.time[-1])
    link = _lowest(belly, run) if ended == _FLOOR else ""
    broken = [str(v) for v in own.violations]
    if ended == _FLOOR and np.isnan(over) and not broken:
        reason = (
            f"{link} reaches the floor while the belly still lies on the rock, rolled by "
            f"{np.rad2deg(rolled[0]):.0f} deg: legs higher with posture=, or a higher rock (floor=)"
        )
    else:
        reason = _reason(belly, run, side, shift, ended, broken)
    return RollOff(
        goal=goal, drive=drive, shift=shift, met=not reason, reason=reason, ended=ended, link=link,
        over=over, friction=own.peak_friction, landing=landing(belly, run, depth), trajectory=run,
    )  # fmt: skip


def _search(belly: Belly, azimuth: float, depth: float) -> Search:
    """Postures that are clear of rock and floor until the belly is at its edge, and over it."""
    shell, ground = belly.shell, belly.ground
    assert isinstance(ground, Boulder)
    end, over = float(belly.rolling_range.at(azimuth)), np.zeros(0)
    if isinstance(shell, FlatBelly):
        around = np.array((azimuth,))
        end = float(flat_end(shell, ground, around)[0])
        over = _OVER
    at = touches(shell, belly.center, ground, np.linspace(0.0, end, 4), np.full(4, azimuth))
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


def _moves(passed: list[Array], rate: Array) -> LegMoves:
    """The legs' moves from posture to posture, each from rest to rest."""
    moves = []
    for a, b in pairwise(passed if len(passed) > 1 else passed * 2):
        duration = max(_SHORTEST, float((2.0 * np.abs(b - a) / rate).max()))
        moves.append(Straight(start=a, end=b, duration=duration))
    return LegMoves(moves)


def _mass_center(belly: Belly, leg_angle: Array) -> Array:
    model = belly.robot.model
    q = pin.neutral(model)
    JointIndex(model, belly.robot.legs).write(q, leg_angle)
    return np.array(pin.centerOfMass(model, model.createData(), q))


def _until(
    model: Model, drive: Gait, duration: float, events: Sequence[Event], **start: Any
) -> tuple[Trajectory, str]:
    """A run until something ends it, and what that was; empty if nothing did."""
    try:
        run = simulate(model, drive, duration, _SAMPLE, events=events, **start)
    except SimulationInterrupted:
        raise
    except SimulationError as error:
        if error.trajectory is None:
            raise
        return error.trajectory, str(error).partition(". State")[0]
    return run, run.events[-1].name if run.time[-1] < duration * (1 - 1e-9) else ""


def _tipped(
    belly: Belly, model: Model, drive: Gait, run: Trajectory, watch: Sequence[Event]
) -> tuple[Trajectory, str]:
    """A run to a flat belly's edge, and how it goes on about that edge."""
    shell, at = belly.shell, float(run.time[-1])
    assert isinstance(shell, FlatBelly)
    turn = pin.Quaternion(run.configuration[-1, 3:7].copy()).toRotationMatrix()
    arm = run.ground.point(run.position[-1]) - run.configuration[-1, :3]
    place = turn.T @ arm
    across = np.abs(place - belly.center)[:2] / (shell.half_length or np.inf,
                                                 shell.half_width or np.inf)  # fmt: skip
    along = int(np.argmin(across))
    long = max(EDGE, (shell.half_length, shell.half_width)[along] or EDGE)
    edge = Ellipsoid((long, EDGE, EDGE) if along == 0 else (EDGE, long, EDGE))
    robot = with_shell(belly.robot, edge, place + np.array((0.0, 0.0, EDGE)))
    outward = np.zeros(3)
    outward[1 - along] = np.sign((place - belly.center)[1 - along])

    def beyond(at: Snapshot) -> float:
        """How far its normal at the contact is beyond the flat face's, and a little."""
        normal = normals(at.model.ground, at.position[None])[0]
        return _LITTLE - float(normal @ at.R_world_body @ outward)

    def later(time: float) -> tuple[Array, Array, Array]:
        motion = drive(at + time)
        return motion.angle, motion.rate, motion.acceleration

    gait = CallableGait(later, n_legs=robot.n_legs, check_span=(0.0, 0.1), name="leg_moves")
    over = FullModel(robot, ground=model.ground, damping=model.damping)
    more, said = _until(
        over, gait, _FALL, [*watch, Event(beyond, True, -1, _BACK)], euler=run.euler[-1],
        start=run.euler_rates[-1], position=run.position[-1],
    )  # fmt: skip
    arrays: dict[str, Any] = {"time": np.append(run.time, at + more.time[1:])}
    for name, value in vars(run).items():
        after = getattr(more, name)
        if isinstance(value, np.ndarray) and name not in ("time", "state", "memory"):
            arrays[name] = np.concatenate((value, after[1:]))
    # One state stands for both: the first model's has no place for the edge.
    still = np.zeros((len(arrays["time"]), 0))
    return replace(run, state=still, memory=still, end=None, events=more.events, **arrays), said


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
    belly: Belly, run: Trajectory, side: Array, shift: float, ended: str, broken: list[str]
) -> str:
    """Why a robot did not get off to a side; empty if it did."""
    if broken:
        return f"on the way {'; '.join(broken)}"
    if ended in _GONE:
        # The base's z axis leans to where it fell.
        turn = pin.Quaternion(run.configuration[-1, 3:7].copy()).toRotationMatrix()
        lean = -turn[2, :2]
        went = float(np.arccos(np.clip(lean @ side / max(np.linalg.norm(lean), 1e-12), -1, 1)))
        if went <= _ASIDE:
            return ""
        return f"it goes over {np.rad2deg(went):.0f} deg away from that side"
    if ended == _ROCK:
        return "a limb touches the rock on the way: legs higher with posture=, or a smaller rock"
    if ended == _BACK:
        return (
            f"the legs move the centre of mass {1000 * shift:.0f} mm to that side; the belly rocks "
            "to its edge and back: a smaller rock would let it go"
        )
    if ended:
        return ended
    last = run.ground.point(run.position[-1]) - run.configuration[-1, :3]
    turn = pin.Quaternion(run.configuration[-1, 3:7].copy()).toRotationMatrix()
    place = float((turn.T @ last - belly.center)[:2] @ side)
    return (
        f"the legs move the centre of mass {1000 * shift:.0f} mm to that side, which rolls the "
        f"belly {1000 * place:.0f} mm, and it stays on the rock: a smaller rock would let it go"
    )
