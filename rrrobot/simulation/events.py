"""Events of a motion: what is looked for, and where it was found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.contact.ground import normals
from rrrobot.errors import ModelError, ParameterError
from rrrobot.integrate import Dense
from rrrobot.models.base import VERTICAL_PITCH, Model
from rrrobot.models.terms import Dynamics
from rrrobot.rotations import euler_from_quaternion

_PARTS = np.array((0.25, 0.5, 0.75))
"""Where events are looked for within a step, besides its end."""


class Snapshot:
    """A motion at one time; forces are computed when they are asked for.

    Attributes:
        time: [s].
        state: state vector (ny,).
        R_world_body, omega_body, position: as in `MotionState`.
        euler: roll, pitch, yaw within half a turn (3,) [rad].
    """

    def __init__(
        self, model: Model, time: float, state: Array, solve: Callable[[float, Array], Dynamics]
    ) -> None:
        self.model, self.time, self.state, self._solve = model, time, state, solve
        pose, quasi, _ = model.split(state)
        place = model.place(pose)
        self.R_world_body, self.position = place.rotation, place.position
        self.omega_body = model.body_velocity(place, quasi)
        self.euler = euler_from_quaternion(place.quaternion)

    @cached_property
    def dynamics(self) -> Dynamics:
        """Accelerations and forces."""
        return self._solve(self.time, self.state)

    @property
    def normal_force(self) -> float:
        """Contact force along the ground's normal [N]."""
        if self.model.rolling is None:
            raise ModelError(f"the {self.model.name} model is pivoted: it has no contact force.")
        normal = normals(self.model.ground, self.position[None])[0]
        return float(self.dynamics.contact_force @ normal)


@dataclass(frozen=True)
class Event:
    """A zero of a function of the motion.

    Args:
        function: of a `Snapshot`, continuous -> number.
        terminal: whether the motion ends there.
        direction: 1 where the function grows through zero, -1 where it falls, 0 for both.
        name: of the event.

    Raises:
        ParameterError: a direction that is none of these.

    Example:
        >>> import rrrobot as rr
        >>> upright = rr.simulation.Event(lambda at: at.euler[0], direction=1, name="upright")
        >>> model = rr.FullModel(rr.Robot.from_parameters(), damping=None)
        >>> t = rr.simulate(model, rr.StillLegs((1.57, 1.57)), 2.0, euler=(-0.1, 0, 0),
        ...                 start="rest", events=[upright])
        >>> [round(hit.time, 3) for hit in t.events]
        [0.324, 1.618]
    """

    function: Callable[[Snapshot], float]
    terminal: bool = False
    direction: int = 0
    name: str = "event"

    def __post_init__(self) -> None:
        if self.direction not in (-1, 0, 1):
            raise ParameterError(f"direction is {self.direction!r}: it must be -1, 0 or 1.")


def lift_off(*, terminal: bool = True) -> Event:
    """The normal force falls through zero: the robot leaves the ground."""
    return Event(lambda at: at.normal_force, terminal, -1, "lift-off")


def vertical(*, terminal: bool = True, pitch: float = VERTICAL_PITCH) -> Event:
    """The pitch comes up to +-`pitch` [rad], near to where Euler angles are singular."""
    limit = np.sin(pitch)
    return Event(lambda at: limit - abs(at.R_world_body[2, 0]), terminal, -1, "vertical")


class Hit(NamedTuple):
    """An event that was found."""

    name: str
    time: float
    """[s]"""
    state: Array
    """state vector (ny,)"""


class Lookout:
    """Finds events within steps, to the accuracy of what `dense` gives."""

    def __init__(
        self, events: Sequence[Event], look: Callable[[float, Array], Snapshot], columns: int
    ) -> None:
        for event in events:
            if not isinstance(event, Event):
                raise ParameterError(f"events has {event!r}: give Event(function, ...).")
        self.events, self._look, self._columns = events, look, columns
        self.hits: list[Hit] = []
        self._last: Array | None = None

    def _values(self, time: float, y: Array) -> Array:
        at = self._look(time, y)
        return np.array([float(event.function(at)) for event in self.events])

    def step(self, start: float, end: float, dense: Dense) -> float | None:
        times = np.concatenate(([start], start + (end - start) * _PARTS, [end]))
        states = dense(times)
        values = [self._values(t, y) for t, y in zip(times[1:], states[1:], strict=True)]
        if self._last is None:
            self._last = self._values(start, states[0])
        rows = np.array([self._last, *values])
        self._last = rows[-1]
        found: list[tuple[float, int]] = []
        for i, event in enumerate(self.events):
            for j in range(len(times) - 1):
                low, high = rows[j, i], rows[j + 1, i]
                # A zero at the end of a piece is found as the beginning of the next one.
                rises, falls = low <= 0 < high, low >= 0 > high
                if (rises and event.direction >= 0) or (falls and event.direction <= 0):
                    found.append((self._root(i, times[j], times[j + 1], low, dense), i))
        for time, i in sorted(found):
            self.hits.append(Hit(self.events[i].name, time, self._state(time, dense)))
            if self.events[i].terminal:
                return time
        return None

    def _state(self, time: float, dense: Dense) -> Array:
        return dense(np.array([time]))[0, : self._columns].copy()

    def _root(self, i: int, low: float, high: float, at_low: float, dense: Dense) -> float:
        from scipy.optimize import brentq

        if at_low == 0.0:
            return low

        def value(time: float) -> float:
            y: Any = dense(np.array([time]))[0]
            return float(self.events[i].function(self._look(time, y)))

        return float(brentq(value, low, high, xtol=1e-13, rtol=1e-14))
