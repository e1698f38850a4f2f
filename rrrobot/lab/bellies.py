"""Where a robot with a fitted belly starts: at rest on it, its legs clear of ground and body."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from rrrobot.belly.feasible import MotionLimits, feasibility
from rrrobot.belly.found import Belly
from rrrobot.contact.ground import Plane
from rrrobot.errors import ModelError
from rrrobot.escape.atlas import rocking_frequencies
from rrrobot.escape.bench import Bench
from rrrobot.escape.bodies import capsules_of
from rrrobot.escape.loss import rocking_damping, rocking_modes
from rrrobot.escape.small import cost, small_gaits, straight
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.outcome import Outcome, Refusal, settle
from rrrobot.models.full import FullModel
from rrrobot.robot.limits import JointLimits

_NEAR = 0.9, 1.0, 1.1
"""Frequencies over those of the rocking modes."""
_LARGEST = 0.5
"""Amplitude [rad]."""
_SHARE = 0.9
"""Of what a joint's limits leave."""
_SIZES = 1.0, 0.7, 0.5, 0.35, 0.25, 0.15
"""Of a small gait, over what the linear forms allow."""
_WAYS = 3
"""That are tried."""
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


def begin(belly: Belly) -> tuple[Knobs, Outcome | None]:
    """Where the sliders stand at first, and the motion there.

    The legs sway about the belly's posture by a small gait that goes straight, near a rocking mode,
    as far as they touch neither the ground nor the body and nothing slips; if no gait that is tried
    does that, by the last of them. The rocking has a damping ratio of a tenth.
    """
    robot = belly.robot
    still = (0.0,) * robot.n_legs
    knobs = replace(Knobs.of(robot), offset=tuple(belly.posture.tolist()), amplitude=still)
    try:
        lossy = rocking_damping(belly.model(damping=None), belly.posture)
        knobs = replace(knobs, damping=max(lossy.x, lossy.y))
        ways = travelling(belly, knobs)
    except ModelError:
        ways = []
    begun: tuple[Knobs, Outcome] | None = None
    for way in ways:
        for size in _SIZES:
            swing = tuple(size * part for part in way["amplitude"])
            tried = replace(knobs, **way | {"amplitude": swing})
            try:
                found = settle(robot, tried)
            except Refusal:
                continue
            begun = tried, found
            if found.friction <= tried.friction and not collisions(belly, found):
                return begun
    if begun is not None:
        return begun
    # Held still, it rests on its belly or the page says why not.
    try:
        return knobs, settle(robot, knobs)
    except Refusal:
        return knobs, None


def travelling(belly: Belly, knobs: Knobs) -> list[dict[str, Any]]:
    """Small gaits about the belly's posture that go straight: entries of the knobs, the best first.

    They are what `rrrobot.escape.small` finds near the rocking modes, as large as the limits of the
    joints and the belly's rolling range allow by its linear forms.

    Raises:
        ModelError: the robot does not rock about a stable rest, or nothing settles there.
    """
    robot, posture = belly.robot, belly.posture
    model = knobs.model(robot)
    assert isinstance(model, FullModel)
    omegas = rocking_frequencies(model, posture)
    decays = [mode.decay_rate for mode in rocking_modes(model, posture)]
    if not decays or min(decays) <= 0:
        raise ModelError(f"{robot.name} does not rock to rest in its posture.")
    bench = Bench(model, *capsules_of(belly.shapes, belly.covered), min(decays))
    ends = JointLimits().ends(robot)
    sides = np.minimum(posture - ends.lower, ends.upper - posture)
    found = []
    for small in small_gaits(bench, posture, np.outer(omegas, _NEAR).ravel()):
        room = _SHARE * np.minimum(sides, ends.velocity / small.omega)
        room = np.clip(room, 1e-6, _LARGEST)
        metric = cost(small, room, belly.rolling_range.least)
        x, y, turn = small.travel
        for form, aside in ((x, y), (-x, y), (y, x), (-y, x)):
            value, swing = straight(form, (aside, turn), metric)
            # The metric holds the joints' limits together; travel goes with the square.
            over = max(1.0, float((np.abs(swing) / room).max()))
            found.append((value / over**2, small.omega, swing / over))
    found.sort(key=lambda one: -one[0])
    return [
        {
            "amplitude": tuple(np.abs(swing).tolist()), "phase": tuple(np.angle(swing).tolist()),
            "frequency": omega,
        }
        for _, omega, swing in found[:_WAYS]
    ]  # fmt: skip


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
