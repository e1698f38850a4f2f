"""What is found of a way off a rock: the run, how the robot comes to lie, and how it goes on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.moves import LegMoves
from rrrobot.drive.tables import gait_from_dict
from rrrobot.escape.confirming import EscapeGait, gait_of
from rrrobot.escape.goals import Escape, goal_of
from rrrobot.escape.landing import Landing
from rrrobot.escape.lying import Lying, lying_of
from rrrobot.simulation.trajectory import Trajectory

_CYCLES = 4
"""Of a settled gait, that tell where it leads."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RollOff:
    """How a robot gets off a rock, or why it does not.

    Attributes:
        goal: the side.
        drive: of the legs, from the belly's posture to the one that leans.
        shift: of the centre of mass to that side by the legs [m].
        short: how far, with the belly at its edge, the centre of mass is then from being over the
            contact [m]; below zero it goes over by leaning alone, else only with the speed that
            it has there.
        least: the same of the posture that leans most if nothing is in the legs' way [m].
        met: whether the robot goes over, to that side, within the limits until it does.
        reason: why not, empty if it does.
        ended: what ended it: "floor", "slide" (more friction would be needed than there is),
            "lift-off", ...
        link: that reaches the floor, if one does.
        over: when the belly is at its edge [s]; NaN if it never is.
        friction: largest coefficient needed until then.
        landing: where, how fast and which way up it is at the end of the run.
        trajectory: all of it, at rest first.
        lying: how it then comes to lie on the floor: one way, two if its turning decides, or none
            if it is not `met` or the rock still holds it.
        after: the gait that goes on from there, on level ground, see `astray`; or None,
        stays: and why there is none.

    Example:
        >>> import rrrobot as rr
        >>> belly = rr.fit_belly("anymal", ground=rr.Boulder(0.2))  # doctest: +SKIP
        >>> rr.unstick(belly, goals=["off:90"], floor=0.6).off["off:90"].ended  # doctest: +SKIP
        'slide'
    """

    goal: Escape
    drive: LegMoves
    shift: float
    short: float
    least: float
    met: bool
    reason: str
    ended: str
    link: str
    over: float
    friction: float
    landing: Landing
    trajectory: Trajectory = field(repr=False)
    lying: tuple[Lying, ...] = ()
    after: EscapeGait | None = None
    stays: str = ""

    @property
    def duration(self) -> float:
        """Until the rock lets go [s]."""
        return float(self.trajectory.time[-1])

    @property
    def torque_share(self) -> Array:
        """Largest torque over its limit, of each leg (legs,); NaN where the file has none."""
        limit = self.trajectory.robot.joints.effort
        largest = np.abs(self.trajectory.leg_torque).max(axis=0)
        return np.where(np.isfinite(limit), largest / limit, np.nan)

    @property
    def after_name(self) -> str:
        """Of the files of the gait that goes on."""
        return f"{self.goal.file_name}_floor"

    @property
    def path(self) -> tuple[Array, ...]:
        """The base's origin on the rock, as it comes to lie, and on the floor (n, 2) each [m].

        Ahead and left of the rock's top. The gait begins where the robot lies.
        """
        parts = [self.trajectory.configuration[:, :2]]
        parts += [np.array(one.path) for one in self.lying[:1]]
        if self.after is not None:
            begin, run = self.lying[0], self.after.trajectory
            angle = begin.heading - run.euler[0, 2]
            turn = np.array(((np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))))
            gone = run.configuration[:, :2] - run.configuration[0, :2]
            parts.append(np.array((begin.ahead, begin.left)) + gone @ turn.T)
        return tuple(parts)

    @property
    def astray(self) -> float:
        """Angle from the wanted side to where the settled gait leads, to the left [rad].

        A robot may turn while it gets going. NaN if it does not go on.
        """
        if self.after is None:
            return float("nan")
        time, places = self.after.trajectory.time, self.path[-1]
        last = time[-1] - _CYCLES * (self.after.gait.period or 1.0)
        gone = places[-1] - places[int(np.searchsorted(time, last - 1e-9))]
        ahead, left, _ = self.goal.weights
        return float(np.arctan2(ahead * gone[1] - left * gone[0], ahead * gone[0] + left * gone[1]))

    def to_dict(self) -> dict[str, Any]:
        """Everything but the trajectory as plain data."""
        return {
            "goal": self.goal.to_dict(), "drive": self.drive.to_dict(), "shift": self.shift,
            "short": self.short, "least": self.least,
            "met": self.met, "reason": self.reason, "ended": self.ended, "link": self.link,
            "over": self.over, "friction": self.friction, "duration": self.duration,
            "landing": self.landing._asdict(), "stays": self.stays,
            "lying": [one._asdict() for one in self.lying],
            "after": None if self.after is None else self.after.to_dict(),
        }  # fmt: skip

    def __repr__(self) -> str:
        told = f"{self.ended} {self.link}".strip() if self.met else f"NOT MET: {self.reason}"
        return f"RollOff({self.goal.name}: {self.duration:.3g} s, {told})"


def way_of(entry: Mapping[str, Any], folder: Path, run: str) -> RollOff:
    """The way of `to_dict`, with the trajectories that a folder holds."""
    drive: Any = gait_from_dict(entry["drive"])
    same = ("shift", "short", "least", "met", "reason", "ended", "link", "friction", "stays")
    numbers = {key: entry[key] for key in same}
    over = float("nan") if entry["over"] is None else float(entry["over"])
    way = RollOff(
        goal=goal_of(entry["goal"]["name"]), drive=drive, over=over,
        landing=Landing(**entry["landing"]),
        lying=tuple(lying_of(one) for one in entry["lying"]),
        trajectory=Trajectory.load(folder / run), **numbers,
    )  # fmt: skip
    if entry["after"] is None:
        return way
    return replace(way, after=gait_of(entry["after"], folder / f"{way.after_name}.npz"))
