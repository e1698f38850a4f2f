"""Torque-driven legs: what the motors do when no leg trajectory is prescribed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.drive.laws import Constant, Function, Held, Memory, MotionState, TorqueLaw
from rrrobot.errors import GaitError


class LegTorques:
    """Motor torques tau on the leg joints, in N m (N for prismatic joints).

    Args:
        torque: constant (legs,); or `function(time)` -> (legs,); or, with `feedback=True`,
            `function(state: MotionState)` -> (legs,); or a `TorqueLaw`, such as `PID`.
        angle: leg angles at the start (legs,) [rad].
        rate: leg rates at the start (legs,) [rad/s].
        feedback: whether the function takes the state instead of the time.
        sample_time: the function is called once each `sample_time`, in order, at 0, sample_time,
            2 sample_time, ..., and its output is held in between [s]. An attribute of this name
            on the function does the same.
        name: for metadata.

    Without a sample time the function is called at every stage of every step, back and forth in
    time, and at the samples again after the run: it must depend on its argument alone. One that
    later answers an old question differently is refused. A controller that remembers (an integral,
    a filter, a delay) has a sample time, or is a `TorqueLaw`, which says what it remembers; both
    are right to the integrator's tolerance. An object with a sample time may keep its memory in
    itself: every run calls a copy of it, so that each starts alike.

    Raises:
        GaitError: wrong sizes, values that are not finite (while simulating too, with the time); a
            function that remembers and has no sample time (while simulating).

    Example:
        >>> import rrrobot as rr
        >>> spring = rr.LegTorques(lambda s: -0.1 * (s.leg_angle - 1.5) - 0.01 * s.leg_rate,
        ...                        angle=(1.2, 1.8), feedback=True)
        >>> spring.n_legs
        2
        >>> class Integral:  # as in a microcontroller, at 100 Hz
        ...     sample_time = 0.01
        ...     sum = 0.0
        ...     def __call__(self, state):
        ...         self.sum += (1.5 - state.leg_angle) * self.sample_time
        ...         return 0.1 * (1.5 - state.leg_angle) + 0.3 * self.sum
        >>> rr.LegTorques(Integral(), angle=(1.2, 1.8), feedback=True).law.sample_time
        0.01
    """

    period: float | None = None

    def __init__(
        self,
        torque: ArrayLike | Callable[[Any], ArrayLike] | TorqueLaw,
        *,
        angle: ArrayLike,
        rate: ArrayLike = 0.0,
        feedback: bool = False,
        sample_time: float | None = None,
        name: str | None = None,
    ) -> None:
        constant = not callable(torque) and not isinstance(torque, TorqueLaw)
        # One angle for all legs leaves their number to the torques.
        sized = torque if np.ndim(angle) == 0 and constant else angle
        self.n_legs = max(int(np.size(sized)), 1)  # type: ignore[arg-type]
        self.angle = vector("angle", angle, self.n_legs, "rad", broadcast=True, error=GaitError)
        self.rate = vector("rate", rate, self.n_legs, "rad/s", broadcast=True, error=GaitError)
        self.feedback = feedback or isinstance(torque, TorqueLaw)
        self.constant: Array | None = None
        self.law: TorqueLaw
        if isinstance(torque, TorqueLaw):
            if feedback or sample_time is not None:
                raise GaitError(
                    "feedback and sample_time are for functions: a TorqueLaw sees the state in any "
                    "case and has a sample_time of its own."
                )
            self.law = torque
            self.name = name or type(torque).__name__
        elif callable(torque):
            if sample_time is None:
                sample_time = getattr(torque, "sample_time", None)
            if sample_time is None:
                self.law = Function(torque, feedback)
            else:
                self.law = Held(torque, feedback, sample_time)
            self.name = name or str(getattr(torque, "__name__", type(torque).__name__))
        elif feedback or sample_time is not None:
            asked = "feedback=True" if feedback else "sample_time"
            raise GaitError(f"torque is a constant, but {asked} needs a function of the state")
        else:
            self.constant = vector(
                "torque", torque, self.n_legs, "N m", broadcast=True, error=GaitError
            )
            self.law = Constant(self.constant)
            self.name = name or "constant"

    def torque(self, state: MotionState, memory: Memory | None = None) -> Array:
        """Torques (legs,) [N m] at a state, with the law's memory; its initial one if None."""
        if self.constant is not None:
            return self.constant
        return self.checked(self.law, state, memory or self.law.initial_memory(self.n_legs))

    def checked(self, law: TorqueLaw, state: MotionState, memory: Memory) -> Array:
        """Torques (legs,) [N m] of this drive's law, or of its copy for a run."""
        if self.constant is not None:
            return self.constant
        return vector(
            f"torque {self.name!r} at t = {state.time:.6g} s",
            law.torque(state, memory),
            self.n_legs,
            "N m",
            error=GaitError,
        )

    def to_dict(self) -> dict[str, Any]:
        """What the drive is, as plain data for metadata."""
        constant = None if self.constant is None else self.constant.tolist()
        data: dict[str, Any] = {
            "type": "torques",
            "name": self.name,
            "constant": constant,
            "feedback": self.feedback,
            "angle": self.angle.tolist(),
            "rate": self.rate.tolist(),
        }
        if isinstance(self.law, Constant | Function):
            return data
        return data | {"law": self.law.to_dict()}
