"""What a gait must keep within, as slacks of order one: positive inside, negative outside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rrrobot.belly.feasible import MotionLimits
from rrrobot.checks import Array, finite
from rrrobot.drive.gaits import GaitBatch
from rrrobot.escape.bench import Outcome
from rrrobot.escape.goals import Escape
from rrrobot.robot.limits import JointEnds, JointLimits, below

_VARIATION = 0.01
_GRIP = 0.96
"""Part of the friction that the search uses: of stiff rocking its few steps see the peaks less."""
LENGTH = 0.1
"""Length that makes a slack of one [m]."""
TOUCH = 1e-4
"""Depth up to which neighbours that rest against each other count as apart [m]."""


@dataclass(frozen=True, kw_only=True)
class EscapeLimits(JointLimits):
    """What a gait must keep within.

    Attributes:
        friction: coefficient that the ground offers.
        normal_force: least normal force over the weight.
        tilt: largest angle of the base's z axis from the ground's normal, roll and pitch together
            [rad]; the belly's rolling range unless given.
        clearance: least distance of limbs and base from the ground, but for the belly [m].
        separation: least distance of links from each other [m].
        use: part of the joints' limits of rate and torque, and of the tilt, that may be used.
        max_torque, max_leg_rate, leg_range: of the joints, those of the robot's file unless given;
            see `JointLimits`.

    Raises:
        ParameterError: a number out of range.

    Example:
        >>> import rrrobot as rr
        >>> rr.escape.EscapeLimits(friction=0.3).clearance
        0.005
    """

    friction: float = 0.5
    normal_force: float = 0.1
    tilt: float | None = None
    clearance: float = 0.005
    separation: float = 0.005
    use: float = 0.95

    def __post_init__(self) -> None:
        super().__post_init__()
        finite("friction", self.friction, above=0)
        finite("normal_force", self.normal_force, at_least=0)
        if self.tilt is not None:
            finite("tilt", self.tilt, "rad", above=0)
        finite("clearance", self.clearance, "m")
        finite("separation", self.separation, "m")
        finite("use", self.use, above=0)

    def of(self, weight: float) -> MotionLimits:
        """What a run of a robot of this weight [N] is held against; links may touch."""
        return MotionLimits(
            normal_force=self.normal_force * weight, friction=self.friction, tilt=self.tilt,
            clearance=0.0, separation=-TOUCH, max_torque=self.max_torque,
            max_leg_rate=self.max_leg_rate, leg_range=self.leg_range,
        )  # fmt: skip


class Rules(NamedTuple):
    """Limits for one robot and one goal."""

    goal: Escape
    limits: EscapeLimits
    ends: JointEnds
    tilt: float
    """[rad]"""
    length: float
    """of the robot [m]"""

    def slacks(self, gaits: GaitBatch, out: Outcome) -> tuple[tuple[str, ...], Array]:
        """Names, and how far inside each limit the gaits are (n, k)."""
        limits, ends = self.limits, self.ends
        low, high, rate = gaits.reach()
        parts: list[tuple[str, Array]] = [
            ("normal force", (out.normal - limits.normal_force)[:, None]),
            ("friction", below(out.friction, _GRIP * limits.friction)[:, None]),
            ("tilt", below(out.most_tilt, limits.use * self.tilt)[:, None]),
            ("clearance", (out.height[:, :-1] - limits.clearance) / LENGTH),
            ("separation", (out.apart - limits.separation)[:, None] / LENGTH),
            ("position", low - ends.lower),
            ("position", ends.upper - high),
            ("velocity", below(rate, limits.use * ends.velocity)),
            ("effort", below(out.torque, limits.use * ends.effort)),
        ]
        if not self.goal.leans:
            parts.append(("direction", self.goal.slack(out.travel, self.length)))
        names = tuple(name for name, part in parts for _ in range(part.shape[1]))
        whole = np.column_stack([np.minimum(part, 1.0) for _, part in parts])
        return names, np.nan_to_num(whole, nan=-9.0, neginf=-9.0)

    def value(self, out: Outcome) -> Array:
        """What is to be largest (n,); of gaits that stopped or do not settle, minus infinity."""
        if self.goal.leans:
            ahead, left, _ = self.goal.weights
            found = _top(out.tilt @ np.array((ahead, left)))
            steady = np.isfinite(found)
        else:
            found = self.goal.value(out.travel)
            speed = np.hypot(out.travel[:, 0], out.travel[:, 1])
            moving = np.maximum(speed, np.abs(out.travel[:, 2]) * self.length)
            steady = out.variation * np.maximum(speed, 1e-6) <= _VARIATION * moving
        return np.where(steady & np.isfinite(found), found, -np.inf)


def _top(values: Array) -> Array:
    """Largest value of periodic samples (n, m): of the parabola through the largest of them."""
    n, k = np.arange(len(values)), values.argmax(axis=1)
    left, here, right = (values[n, (k + i) % values.shape[1]] for i in (-1, 0, 1))
    bend = left - 2.0 * here + right
    with np.errstate(invalid="ignore", divide="ignore"):
        more = np.where(bend < 0, -((left - right) ** 2) / (8.0 * bend), 0.0)
    return np.asarray(here + more)
