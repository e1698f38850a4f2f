"""Torque laws and what they remember.

A law is a pure function of what it sees and of its memory, and says how the memory changes:

    tau = torque(state, memory),   d/dt memory.continuous = memory_rate(state, memory),
    memory <- tick(state, memory)  at the instants of its clocks.

The continuous memory is integrated together with the body; the integration stops at every instant
of a clock, so a law that is sampled and held is right to the integrator's tolerance. What a law
remembers is an array that travels with the state of a run, so a run can be continued.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.errors import GaitError

_SAME_INSTANT = 1e-9
"""Part of a clock's period within which two times are the same instant."""


@dataclass(frozen=True, slots=True)
class MotionState:
    """What a feedback law sees; arrays must not be changed.

    Example:
        >>> import rrrobot as rr
        >>> def hold(state: rr.drive.MotionState):
        ...     return -0.5 * (state.leg_angle - 1.57) - 0.02 * state.leg_rate
        >>> rr.LegTorques(hold, angle=(1.4, 1.7), feedback=True).name
        'hold'
    """

    time: float
    """[s]"""
    R_world_body: Array
    """(3, 3)"""
    omega_body: Array
    """body's angular velocity in the body frame (3,) [rad/s]"""
    position: Array
    """contact point in the ground plane (2,) [m]"""
    leg_angle: Array
    """(legs,) [rad]"""
    leg_rate: Array
    """(legs,) [rad/s]"""


class Memory(NamedTuple):
    """What a law remembers."""

    continuous: Array = np.empty(0)
    """changes by `memory_rate` (m,)"""
    held: Array = np.empty(0)
    """changes at the instants of the clocks only (k,)"""

    def join(self) -> Array:
        """Both in one vector (m + k,)."""
        return np.concatenate((self.continuous, self.held))


class Clock(NamedTuple):
    """Instants offset + k period, k = 0, 1, 2, ... [s]."""

    period: float
    offset: float = 0.0

    def last(self, time: float) -> int:
        """k of the last instant that is not later than a time; negative before the first."""
        return int(np.floor((time - self.offset) / self.period + _SAME_INSTANT))

    def instant(self, k: int) -> float:
        """Its time [s]."""
        return self.offset + k * self.period


class TorqueLaw(ABC):
    """Torques of the legs by a law that may have a memory; see the module for the equations.

    A subclass gives `torque`; with a memory `initial_memory`, and `memory_rate` or `tick`.

    Attributes:
        sample_time: of a law that is sampled [s]; None for one that is continuous.
        hides_memory: whether it remembers things outside of its `Memory`, so that only the end of
            a run can be continued.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> class Smooth(rr.drive.TorqueLaw):  # a motor with a lag of 50 ms
        ...     def initial_memory(self, n_legs):
        ...         return rr.drive.Memory(continuous=np.zeros(n_legs))
        ...     def memory_rate(self, state, memory):
        ...         return (-0.5 * (state.leg_angle - 1.5) - memory.continuous) / 0.05
        ...     def torque(self, state, memory):
        ...         return memory.continuous - 0.02 * state.leg_rate
        >>> motors = rr.LegTorques(Smooth(), angle=(1.2, 1.8))
        >>> t = rr.simulate(rr.FullModel(rr.Robot.from_parameters()), motors, duration=0.5)
        >>> t.memory.shape
        (51, 2)
    """

    sample_time: float | None = None
    hides_memory: bool = False

    @abstractmethod
    def torque(self, state: MotionState, memory: Memory) -> ArrayLike:
        """Torques (legs,) [N m]."""

    def initial_memory(self, n_legs: int) -> Memory:
        """Memory at the start, before the first tick."""
        return Memory()

    def memory_rate(self, state: MotionState, memory: Memory) -> ArrayLike:
        """Rate of `memory.continuous` (m,) [1/s]."""
        return np.zeros(memory.continuous.size)

    def tick(self, state: MotionState, memory: Memory, clock: int, k: int) -> Memory:
        """Memory after the k-th instant of a clock; clock 0 is the one of `sample_time`."""
        return memory

    @property
    def clocks(self) -> tuple[Clock, ...]:
        """When `tick` is called."""
        if self.sample_time is None:
            return ()
        period = finite("sample_time", self.sample_time, "s", above=0, error=GaitError)
        return (Clock(period),)

    def fresh(self) -> TorqueLaw:
        """The law for one run; a copy if it hides a memory."""
        return copy.deepcopy(self) if self.hides_memory else self

    def to_dict(self) -> dict[str, Any]:
        """What the law is, as plain data for metadata."""
        data: dict[str, Any] = {"type": "law", "name": type(self).__name__}
        return data if self.sample_time is None else data | {"sample_time": self.sample_time}


class Constant(TorqueLaw):
    """The same torques at any time (legs,) [N m]."""

    def __init__(self, value: Array) -> None:
        self.value = value

    def torque(self, state: MotionState, memory: Memory) -> Array:
        return self.value


class Function(TorqueLaw):
    """A function of the state, or of the time; called at every evaluation, out of order."""

    def __init__(self, function: Callable[[Any], ArrayLike], feedback: bool) -> None:
        self.function = function
        self.feedback = feedback

    def torque(self, state: MotionState, memory: Memory) -> ArrayLike:
        return self.function(state if self.feedback else state.time)


class Held(TorqueLaw):
    """A function that is called once every sample time, in order, and its output held between.

    The function may be an object that remembers; each run then calls a copy of its own.
    """

    def __init__(
        self, function: Callable[[Any], ArrayLike], feedback: bool, sample_time: float
    ) -> None:
        self.function = function
        self.feedback = feedback
        self.sample_time = finite("sample_time", sample_time, "s", above=0, error=GaitError)
        self.hides_memory = not isinstance(function, FunctionType)

    def initial_memory(self, n_legs: int) -> Memory:
        return Memory(held=np.zeros(n_legs))

    def tick(self, state: MotionState, memory: Memory, clock: int, k: int) -> Memory:
        value = self.function(state if self.feedback else state.time)
        what = f"held torque at t = {state.time:.6g} s"
        return Memory(held=vector(what, value, memory.held.size, "N m", error=GaitError).copy())

    def torque(self, state: MotionState, memory: Memory) -> Array:
        return memory.held

    def fresh(self) -> TorqueLaw:
        if not self.hides_memory:
            return self
        try:
            return Held(copy.deepcopy(self.function), self.feedback, float(self.sample_time or 0))
        except Exception as error:
            raise GaitError(
                f"the controller {type(self.function).__name__} cannot be copied ({error}), and "
                "each run needs a copy of its own, as it may remember: give it a __deepcopy__, or "
                "write it as a TorqueLaw."
            ) from error
