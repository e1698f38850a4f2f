"""Where a robot is to go: goals of travel on level ground and slopes, and off a rock.

A settled gait moves by (v_x, v_y) along the body's mean heading and to its left, and turns by alpha
[m/s, rad/s]. A goal weighs these three numbers, and what else the gait does stays small beside it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from rrrobot.checks import Array, finite
from rrrobot.errors import ParameterError

ASIDE = 0.1
"""Travel across the wanted direction, over that along it; and turning over a robot's length."""


@dataclass(frozen=True)
class Escape:
    """One way to go.

    Attributes:
        name: "forward", "backward", "left", "right" (sideways), "turn left", "turn right",
            "direction:DEGREES" (from ahead, to the left), "off:DEGREES" (leaning off a rock).
        weights: of v_x, v_y and the yaw rate (3,).
        leans: whether it is the lean of the robot that counts, not its travel.

    Example:
        >>> from rrrobot.escape.goals import goal_of
        >>> goal_of("direction:90").weights
        (0.0, 1.0, 0.0)
    """

    name: str
    weights: tuple[float, float, float]
    leans: bool = False

    @property
    def turns(self) -> bool:
        """Whether the robot is to turn on the spot."""
        return self.weights[2] != 0.0

    @property
    def unit(self) -> str:
        """Of the value."""
        return "rad" if self.leans else "rad/s" if self.turns else "m/s"

    def value(self, travel: Array) -> Array:
        """What is to be largest (n,), of (v_x, v_y, yaw rate) (n, 3)."""
        return travel @ np.array(self.weights)

    def slack(self, travel: Array, length: float) -> Array:
        """How far the gaits are from going too much elsewhere (n, 4), of order one; none if (n, 0).

        Args:
            travel: (v_x, v_y, yaw rate) (n, 3).
            length: of the robot [m].
        """
        if self.turns:
            return np.empty((len(travel), 0))
        along = np.maximum(self.value(travel), 1e-9)
        x, y, _ = self.weights
        across = (x * travel[:, 1] - y * travel[:, 0]) / along
        turn = travel[:, 2] * length / along
        return np.column_stack([1 - part / ASIDE for part in (across, -across, turn, -turn)])

    @property
    def file_name(self) -> str:
        """The name as part of a file's."""
        return self.name.replace(" ", "_").replace(":", "_").replace("-", "minus")

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {"name": self.name, "weights": list(self.weights), "unit": self.unit}


_NAMED = {
    "forward": (1.0, 0.0, 0.0),
    "backward": (-1.0, 0.0, 0.0),
    "left": (0.0, 1.0, 0.0),
    "right": (0.0, -1.0, 0.0),
    "turn left": (0.0, 0.0, 1.0),
    "turn right": (0.0, 0.0, -1.0),
}
GOALS = (*_NAMED, "direction:DEGREES", "off:DEGREES")
"""How goals are written."""
USUAL = ("forward", "left", "turn left", "turn right")
"""Goals of a robot on level ground or a slope."""
ROCK = ("off:0", "off:90", "off:180", "off:270")
"""Goals of a robot on a rock: off ahead, to the left, to the back, to the right."""


def goal_of(goal: Escape | str) -> Escape:
    """A goal, or the one of this name.

    Raises:
        ParameterError: no such goal.

    Example:
        >>> goal_of("turn left").unit
        'rad/s'
    """
    if isinstance(goal, Escape):
        return goal
    name = str(goal).strip().lower().replace("-", " ")
    if name in _NAMED:
        return Escape(name, _NAMED[name])
    kind, colon, text = str(goal).strip().lower().partition(":")
    try:
        degrees = finite("degrees", float(text)) if colon else math.nan
    except (ValueError, ParameterError):
        degrees = math.nan
    if kind not in ("direction", "off") or math.isnan(degrees):
        raise ParameterError(f"goal is {goal!r}: it must be one of {', '.join(GOALS)}.")
    angle = math.radians(degrees)
    ahead, left = (round(f(angle), 15) + 0.0 for f in (math.cos, math.sin))
    return Escape(f"{kind}:{degrees:g}", (ahead, left, 0.0), leans=kind == "off")
