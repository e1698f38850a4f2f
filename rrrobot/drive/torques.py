"""Torque-driven legs: what the motors do when no leg trajectory is prescribed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.errors import GaitError


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


class LegTorques:
    """Motor torques tau on the leg joints, in N m (N for prismatic joints).

    Args:
        torque: constant (legs,); or `function(time)` -> (legs,); or, with `feedback=True`,
            `function(state: MotionState)` -> (legs,).
        angle: leg angles at the start (legs,) [rad].
        rate: leg rates at the start (legs,) [rad/s].
        feedback: whether the function takes the state instead of the time.
        name: for metadata.

    Raises:
        GaitError: wrong sizes, values that are not finite (while simulating too, with the time).

    Example:
        >>> import rrrobot as rr
        >>> spring = rr.LegTorques(lambda s: -0.1 * (s.leg_angle - 1.5) - 0.01 * s.leg_rate,
        ...                        angle=(1.2, 1.8), feedback=True)
        >>> spring.n_legs
        2
    """

    period: float | None = None

    def __init__(
        self,
        torque: ArrayLike | Callable[[Any], ArrayLike],
        *,
        angle: ArrayLike,
        rate: ArrayLike = 0.0,
        feedback: bool = False,
        name: str | None = None,
    ) -> None:
        # One angle for all legs leaves their number to the torques.
        sized = torque if np.ndim(angle) == 0 and not callable(torque) else angle
        self.n_legs = max(int(np.size(sized)), 1)
        self.angle = vector("angle", angle, self.n_legs, "rad", broadcast=True, error=GaitError)
        self.rate = vector("rate", rate, self.n_legs, "rad/s", broadcast=True, error=GaitError)
        self.feedback = feedback
        self.constant: Array | None = None
        self.function: Callable[[Any], ArrayLike] | None = None
        if callable(torque):
            self.function = torque
            self.name = name or getattr(torque, "__name__", type(torque).__name__)
        elif feedback:
            raise GaitError("torque is a constant, but feedback=True needs a function of the state")
        else:
            self.constant = vector(
                "torque", torque, self.n_legs, "N m", broadcast=True, error=GaitError
            )
            self.name = name or "constant"

    def torque(self, state: MotionState) -> Array:
        """Torques (legs,) [N m] at a state."""
        if self.function is None:
            return self.constant if self.constant is not None else np.zeros(self.n_legs)
        value = self.function(state if self.feedback else state.time)
        return vector(
            f"torque {self.name!r} at t = {state.time:.6g} s",
            value,
            self.n_legs,
            "N m",
            error=GaitError,
        )

    def to_dict(self) -> dict[str, Any]:
        """What the drive is, as plain data for metadata."""
        constant = None if self.constant is None else self.constant.tolist()
        return {
            "type": "torques",
            "name": self.name,
            "constant": constant,
            "feedback": self.feedback,
            "angle": self.angle.tolist(),
            "rate": self.rate.tolist(),
        }
