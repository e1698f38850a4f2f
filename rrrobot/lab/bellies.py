"""Where a robot with a fitted belly starts: at rest on it, its legs clear of ground and body."""

from __future__ import annotations

import contextlib
import math
from dataclasses import replace
from typing import Any

import numpy as np

from rrrobot.belly.feasible import MotionLimits, feasibility
from rrrobot.belly.found import Belly
from rrrobot.checks import Array
from rrrobot.contact.ground import Plane
from rrrobot.errors import ModelError
from rrrobot.escape.loss import rocking_damping
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.outcome import Outcome, Refusal, settle
from rrrobot.robot.chains import leg_chains, symmetry_of
from rrrobot.robot.robot import Robot

_SWINGS = 0.3, 0.2, 0.15, 0.1, 0.05
"""Amplitudes that are tried at first [rad]."""
_FREQUENCY = 10.0
_SHARE = 0.9
"""Of what a joint's limits leave."""
_MOST = 200
"""Samples of a motion that is judged on the spot."""
_LIMITS = MotionLimits(friction=None, normal_force=None)


def check_belly(belly: Belly) -> None:
    """Refuse a belly that was fitted for other ground than the page has.

    Raises:
        ModelError: it was.
    """
    if not (isinstance(belly.ground, Plane) and belly.ground.is_level):
        raise ModelError(
            f"the belly of {belly.robot.name} lies on {type(belly.ground).__name__}: the "
            "laboratory has level ground that may be tilted; fit it without ground=."
        )


def swaying(robot: Robot, posture: Array, swing: float) -> dict[str, Any]:
    """Legs that sway about a posture: entries of the knobs.

    In each limb a joint moves a quarter of a cycle before the next, hind limbs a quarter before
    fore ones, and limbs that mirror each other from left to right half a cycle apart.

    Args:
        robot: any.
        posture: legs (legs,) [rad].
        swing: amplitude where the limits of the joints leave as much [rad].
    """
    phase, limb_of = np.zeros(robot.n_legs), {}
    for limb, chain in enumerate(leg_chains(robot)):
        for place, leg in enumerate(chain):
            limb_of[leg] = limb
            phase[leg] = 0.5 * math.pi * place
    mirror = symmetry_of(robot, "left-right")
    first: list[int] = []
    for leg, limb in limb_of.items():
        other = leg if mirror is None else int(np.flatnonzero(mirror.source == leg)[0])
        if limb_of.get(other, limb) in first and limb not in first:
            assert mirror is not None
            phase[leg] = phase[other] + (math.pi if mirror.sign[leg] > 0 else 0.0)
            continue
        if limb not in first:
            first.append(limb)
        phase[leg] += 0.5 * math.pi * first.index(limb)
    room = np.minimum(posture - robot.joints.lower, robot.joints.upper - posture)
    amplitude = np.clip(_SHARE * room, 0.0, swing)
    turned = (phase + math.pi) % (2 * math.pi) - math.pi
    return {
        "offset": tuple(posture.tolist()), "amplitude": tuple(amplitude.tolist()),
        "phase": tuple(turned.tolist()), "frequency": _FREQUENCY,
    }  # fmt: skip


def begin(belly: Belly) -> tuple[Knobs, Outcome | None]:
    """Where the sliders stand at first, and the motion there.

    The legs sway about the belly's posture by the largest of a few amplitudes at which they touch
    neither the ground nor the body; the rocking has a damping ratio of a tenth.
    """
    robot = belly.robot
    knobs = Knobs.of(robot)
    with contextlib.suppress(ModelError):
        lossy = rocking_damping(belly.model(damping=None), belly.posture)
        knobs = replace(knobs, damping=max(lossy.x, lossy.y))
    found: Outcome | None = None
    for swing in _SWINGS:
        knobs = replace(knobs, **swaying(robot, belly.posture, swing))
        try:
            found = settle(robot, knobs)
        except Refusal:
            continue
        if not collisions(belly, found):
            break
    return knobs, found


def collisions(belly: Belly, outcome: Outcome) -> tuple[str, ...]:
    """What a motion that repeats runs into, in words."""
    if outcome.trajectory.robot is not belly.robot or len(outcome.trajectory) > _MOST:
        return ()
    said = []
    for one in feasibility(outcome.trajectory, _LIMITS, belly=belly).violations:
        if one.what == "clearance":
            said.append(f"{one.where} is {1e3 * one.amount:.2g} mm in the ground.")
        elif one.what == "separation":
            said.append(f"{one.where} are {1e3 * one.amount:.2g} mm in each other.")
        elif one.what == "tilt":
            said.append(
                f"It tilts by {np.rad2deg(one.value):.3g} degrees, and the belly ends at "
                f"{np.rad2deg(one.limit):.3g}."
            )
    return tuple(said)
