"""A state of a model at a time: all that a run needs to go on."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.laws import Memory, TorqueLaw
from rrrobot.errors import ModelError
from rrrobot.models.base import Model
from rrrobot.robot.robot import Robot
from rrrobot.rotations import euler_from_quaternion


@dataclass(frozen=True, kw_only=True, eq=False)
class State:
    """A model's state vector, when it was, how often the body had turned, what the drive knew.

    Attributes:
        model: what the model is, as `Model.to_dict` says.
        robot: the robot.
        time: [s].
        vector: (pose, quasi-velocities), and (leg angles, leg rates) of torque-driven legs (ny,).
        euler: roll, pitch, yaw with whole turns (3,) [rad].
        memory: of the torque law, if it has one.
        drive: what the drive is, as its `to_dict` says; its memory goes on in the same drive only.
        law: the law's own copy, where it remembers things outside of its `memory`.

    Example:
        >>> import rrrobot as rr
        >>> model, gait = rr.FullModel(rr.Robot.from_parameters()), rr.gait("circular")
        >>> first = rr.simulate(model, gait, duration=1.0)
        >>> second = rr.simulate(model, gait, duration=1.0, state=first.final_state)
        >>> float(second.time[0]), float(second.time[-1])
        (1.0, 2.0)
    """

    model: dict[str, Any]
    robot: Robot = field(repr=False)
    time: float
    vector: Array
    euler: Array
    memory: Memory | None = None
    drive: dict[str, Any] | None = field(default=None, repr=False)
    law: TorqueLaw | None = field(default=None, repr=False)
    lane: Array | None = field(default=None, repr=False)
    """of the momentum form, whose own variables they are: they go on to the last bit"""

    @classmethod
    def from_array(
        cls,
        model: Model,
        array: ArrayLike,
        *,
        time: float = 0.0,
        euler: ArrayLike | None = None,
    ) -> State:
        """A state of a model from its vector (ny,), such as a row of `Trajectory.state`.

        Args:
            model: whose state it is.
            array: (pose, quasi-velocities), with (leg angles, leg rates) for torque-driven legs.
            time: [s].
            euler: roll, pitch, yaw with whole turns (3,) [rad]; within half a turn if None.

        Raises:
            ParameterError: numbers that are not finite, or of another size.
        """
        size = model.n_pose + model.n_quasi
        if np.size(array) != size:
            size += 2 * model.n_legs
        y = vector("state", array, size)
        pose = y[None, : model.n_pose]
        near = np.atleast_2d(euler_from_quaternion(model.quaternions(pose)))[0]
        angles = model.turned(pose, near)[0]
        if euler is not None:
            angles = vector("euler", euler, 3, "rad", labels=("roll", "pitch", "yaw"))
        return cls(
            model=model.to_dict(),
            robot=model.robot,
            time=finite("time", time, "s"),
            vector=y,
            euler=angles,
        )

    def at(self, time: float) -> State:
        """The same state at another time [s]; the drive starts anew."""
        return replace(self, time=finite("time", time, "s"), memory=None, drive=None, law=None)

    def require(self, model: Model, *, torque_driven: bool) -> None:
        """Raise ModelError unless a model can go on from this state.

        Its robot, its kind and its ground must be those of the state; its damping may differ.
        """
        mine, its = dict(self.model), model.to_dict()
        for key in mine.keys() | its.keys():
            if key != "damping" and mine.get(key) != its.get(key):
                raise ModelError(
                    f"the state is of a model whose {key} is {mine.get(key)!r}, and this model's "
                    f"is {its.get(key)!r}: continue it with a model of the same kind, or make a "
                    "state of this model by State.from_array."
                )
        if self.robot != model.robot:
            raise ModelError(
                f"the state is of {self.robot!r}, and this model of {model.robot!r}: continue it "
                "with the same robot."
            )
        size = model.n_pose + model.n_quasi
        has_legs = self.vector.size > size
        if has_legs != torque_driven:
            held = "moved by torques" if has_legs else "prescribed"
            raise ModelError(
                f"the legs of the state were {held}, so its vector has {self.vector.size} numbers, "
                f"and this drive needs {size + 2 * model.n_legs * torque_driven}: continue with a "
                "drive of the same kind, or make a state by State.from_array."
            )

    def __repr__(self) -> str:
        name = self.model.get("type", self.model.get("name"))
        return f"State({name} model of {self.robot.name} at {self.time:g} s)"
