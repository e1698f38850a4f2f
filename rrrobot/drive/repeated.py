"""A torque law that is asked again what it was asked before, and refused if it answers otherwise.

The integrator asks a law at every stage of every step, back and forth in time, so that a law that
remembers anything outside of its `Memory` is wrong without a word. Such a law shows itself: after
other questions it answers an old one differently. Questions are kept from all over the run, asked
again after each step, and all of them once more at its end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array
from rrrobot.drive.laws import Memory, MotionState, TorqueLaw

_KEPT = 16
"""Questions kept from all over the run."""
_SAME = 1e-9
"""Part of the largest answer so far within which two answers are the same."""


class _Question(NamedTuple):
    state: MotionState
    memory: Memory
    answer: Array
    """torques and rates of the memory, in one vector"""


class Repeatable(TorqueLaw):
    """A law whose answers are kept and asked for again.

    Args:
        law: that is asked.
        name: of the law, for messages.
    """

    def __init__(self, law: TorqueLaw, name: str) -> None:
        self.law, self.name = law, name
        self.fault: str | None = None
        """what differed, in a sentence; None as long as nothing did"""
        self._kept: list[_Question] = []
        self._newest: _Question | None = None
        self._asked, self._stride, self._turn = 0, 1, 0
        self._largest = 0.0

    def torque(self, state: MotionState, memory: Memory) -> ArrayLike:
        value = self.law.torque(state, memory)
        if self._newest is None or self._asked % self._stride == 0:
            self._keep(state, memory, value)
        self._asked += 1
        return value

    def _keep(self, state: MotionState, memory: Memory, torque: ArrayLike) -> None:
        answer = self._joined(torque, self.law.memory_rate(state, memory))
        parts = (np.array(part) for part in memory)
        question = _Question(state, Memory(*parts), answer)
        self._largest = max(self._largest, float(np.abs(answer).max(initial=0.0)))
        if self._newest is None:
            self._newest = question
        if self._asked % self._stride == 0:
            self._kept.append(question)
        if len(self._kept) > _KEPT:
            self._kept = self._kept[::2]
            self._stride *= 2

    @staticmethod
    def _joined(*parts: ArrayLike) -> Array:
        # What is no number at all is refused where the torque is used.
        return np.concatenate([np.ravel(np.array(part, dtype=float)) for part in parts])

    def stepped(self) -> str | None:
        """Ask two old questions again, the newest step's first and another; the fault if any."""
        if self._newest is not None:
            self._again(self._newest)
            self._newest = None
        if self._kept:
            self._turn = (self._turn + 1) % len(self._kept)
            self._again(self._kept[self._turn])
        return self.fault

    def ended(self) -> str | None:
        """Ask all that is kept again; the fault if any."""
        for question in self._kept:
            self._again(question)
        return self.fault

    def _again(self, question: _Question) -> None:
        state, memory, before = question
        if self.fault is not None:
            return
        after = self._joined(self.law.torque(state, memory), self.law.memory_rate(state, memory))
        differ = before.shape != after.shape or bool(
            np.any(np.abs(after - before) > _SAME * self._largest)
        )
        if differ:
            self.fault = (
                f"the law {self.name!r} remembers: asked twice about the same state at t = "
                f"{state.time:.6g} s it answered {np.round(before, 9).tolist()} and then "
                f"{np.round(after, 9).tolist()}. The integrator asks back and forth in time, so "
                "the motion would be wrong: give sample_time= [s], and the law is called once "
                "each sample time, in order, and its output held; or write it as a TorqueLaw, "
                "which says what it remembers."
            )
