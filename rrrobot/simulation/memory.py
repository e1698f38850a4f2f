"""What a torque law remembers during a run: its clocks as the integrator's jumps."""

from __future__ import annotations

import numpy as np

from rrrobot.checks import Array, vector
from rrrobot.drive.laws import Memory, MotionState
from rrrobot.drive.repeated import Repeatable
from rrrobot.drive.torques import LegTorques
from rrrobot.errors import GaitError
from rrrobot.models.base import Model
from rrrobot.models.terms import Placement
from rrrobot.simulation.state import State


class Recall:
    """The law of one run with its memory; the integrator's y is (state vector, continuous memory).

    Attributes:
        law: the run's own copy.
        asked: the same, refused if it answers the same question differently.
        held: memory that changes at the instants only (k,).
    """

    def __init__(self, model: Model, drive: object, state: State) -> None:
        assert isinstance(drive, LegTorques)
        self.model, self.drive, self.size = model, drive, state.vector.size
        first = drive.law.initial_memory(drive.n_legs)
        self.goes_on = state.memory is not None and state.drive == drive.to_dict()
        memory = first
        if self.goes_on and state.memory is not None:
            memory = state.memory
            if [m.size for m in memory] != [m.size for m in first]:
                raise GaitError(
                    f"the state's memory has {memory.continuous.size} + {memory.held.size} "
                    f"numbers, and the law {drive.name!r} needs {first.continuous.size} + "
                    f"{first.held.size}: continue with the same law, or from state.at(time)."
                )
            if drive.law.hides_memory and state.law is None:
                raise GaitError(
                    f"the law {drive.name!r} remembers things in itself, so that only the end of "
                    "a run can be continued, by its final_state: write it as a TorqueLaw."
                )
        law = state.law if self.goes_on and state.law is not None else drive.law
        self.law = law.fresh()
        self.asked = Repeatable(self.law, drive.name)
        self.clocks = self.law.clocks
        self.continuous, self.held = memory

    def begin(self, state: State) -> Array:
        """The integrator's y at the start; a law that is new samples at once."""
        y = np.concatenate((state.vector, self.continuous))
        if not self.goes_on:
            for i, clock in enumerate(self.clocks):
                if clock.last(state.time) >= 0:
                    y = self._tick(state.time, y, i)
        return y

    def now(self, y: Array) -> Memory:
        """Memory at the integrator's y."""
        return Memory(y[self.size :], self.held)

    def rate(self, seen: MotionState, memory: Memory) -> Array:
        """Rate of the continuous memory (m,)."""
        if not memory.continuous.size:
            return memory.continuous
        what = f"memory_rate of {self.drive.name!r} at t = {seen.time:.6g} s"
        rate = self.law.memory_rate(seen, memory)
        return vector(what, rate, memory.continuous.size, error=GaitError)

    def next(self, time: float) -> float:
        return min(clock.instant(max(clock.last(time) + 1, 0)) for clock in self.clocks)

    def jump(self, time: float, y: Array) -> Array:
        for i, clock in enumerate(self.clocks):
            k = clock.last(time)
            # One of the clocks stands at this instant; another may come a rounding error later.
            if k >= 0 and abs(clock.instant(k) - time) <= 1e-9 * clock.period:
                y = self._tick(time, y, i)
        return y

    def _tick(self, time: float, y: Array, clock: int) -> Array:
        model = self.model
        pose, quasi, legs = model.split(y[: self.size])
        seen = seen_at(model, time, model.place(pose), quasi, legs)
        after = self.law.tick(seen, self.now(y), clock, self.clocks[clock].last(time))
        sizes = y.size - self.size, self.held.size
        continuous = vector("continuous memory", after.continuous, sizes[0], error=GaitError)
        self.held = vector("held memory", after.held, sizes[1], error=GaitError)
        return np.concatenate((y[: self.size], continuous))


def seen_at(model: Model, time: float, place: Placement, quasi: Array, legs: Array) -> MotionState:
    """What a torque law sees: copies that cannot be written."""
    n, omega = model.n_legs, model.body_velocity(place, quasi)
    parts = [np.array(part) for part in (place.rotation, omega, place.position, legs[:n], legs[n:])]
    for part in parts:
        part.flags.writeable = False
    return MotionState(time, *parts)
