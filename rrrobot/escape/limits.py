"""What a gait must keep within, as slacks of order one: positive inside, negative outside."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from rrrobot.belly.feasible import MotionLimits
from rrrobot.checks import Array, finite
from rrrobot.drive.gaits import GaitBatch
from rrrobot.escape.bench import Outcome
from rrrobot.escape.goals import Escape
from rrrobot.robot.limits import placeholders
from rrrobot.robot.robot import Robot

_VARIATION = 0.01
LENGTH = 0.1
"""Length that makes a slack of one [m]."""
TOUCH = 1e-4
"""Depth up to which neighbours that rest against each other count as apart [m]."""


@dataclass(frozen=True, kw_only=True)
class EscapeLimits:
    """What a gait must keep within beside the joint limits of the robot's file.

    Attributes:
        friction: coefficient that the ground offers.
        normal_force: least normal force over the weight.
        tilt: largest tilt of the base [rad]; the belly's rolling range unless given.
        clearance: least distance of limbs and base from the ground, but for the belly [m].
        separation: least distance of links from each other [m].
        use: part of the joints' limits of velocity and effort, and of the tilt, that may be used.

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
            clearance=0.0, separation=-TOUCH,
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)


class JointEnds(NamedTuple):
    """What the joints can do; infinite where the file has no limit that binds."""

    lower: Array
    """(legs,) [rad]"""
    upper: Array
    velocity: Array
    """[rad/s]"""
    effort: Array
    """[N m]"""
    unlimited: tuple[str, ...]
    """joints whose effort limit is none"""


def joint_ends(robot: Robot) -> JointEnds:
    """Joint limits of a robot that are limits."""
    joints, none = robot.joints, placeholders(robot)
    return JointEnds(
        np.maximum(joints.lower, -2 * np.pi), np.minimum(joints.upper, 2 * np.pi),
        joints.velocity, np.where(np.isin(robot.legs, none), np.inf, joints.effort), none,
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
        low, high, rate = extent(gaits)
        parts: list[tuple[str, Array]] = [
            ("normal force", (out.normal - limits.normal_force)[:, None]),
            ("friction", _below(out.friction, limits.friction)[:, None]),
            ("tilt", _below(out.most_tilt, limits.use * self.tilt)[:, None]),
            ("clearance", (out.height[:, :-1] - limits.clearance) / LENGTH),
            ("separation", (out.apart - limits.separation)[:, None] / LENGTH),
            ("position", low - ends.lower),
            ("position", ends.upper - high),
            ("velocity", _below(rate, limits.use * ends.velocity)),
            ("effort", _below(out.torque, limits.use * ends.effort)),
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


def _below(value: Array, most: Any) -> Array:
    """Slack of a positive value below a limit, infinite ones included."""
    with np.errstate(invalid="ignore"):
        ratio = np.minimum(value, 1e9) / most
    return np.asarray((1.0 - ratio) / (1.0 + ratio))


def extent(gaits: GaitBatch) -> tuple[Array, Array, Array]:
    """Least and greatest position and greatest rate of each leg, each (n, legs)."""
    swing, rate = gaits.extent()
    if gaits.sine.shape[1] == 1:
        return gaits.offset - swing, gaits.offset + swing, rate
    motion = gaits.swing()[0]
    return gaits.offset + motion.min(axis=1), gaits.offset + motion.max(axis=1), rate
