"""What is followed from step to step: whole turns, the drive's memory, and the vertical."""

from __future__ import annotations

import numpy as np

from rrrobot.checks import Array
from rrrobot.models.base import VERTICAL_PITCH, Model
from rrrobot.models.full import FullModel
from rrrobot.rotations import euler_from_rotation, rotation_from_quaternion
from rrrobot.simulation.memory import Recall


class Track:
    """Follows roll, pitch and yaw without jumps from step to step, and stops at the vertical.

    Attributes:
        angles: of the samples (n, 3) [rad].
    """

    def __init__(self, model: Model, euler: Array, n: int, recall: Recall | None) -> None:
        self.model = model
        self.last = np.array(euler, dtype=float)
        self.angles = np.empty((n, 3))
        self.y: Array | None = None
        self._recall = recall
        self._held: list[Array] = []

    def sampled(self, first: int, states: Array) -> None:
        poses = states[:, : self.model.n_pose]
        self.angles[first : first + len(states)] = self.model.turned(poses, self.last)
        if self._recall is not None:
            self._held += [self._recall.held] * len(states)

    def memory(self, n: int, states: Array, size: int) -> Array:
        """Memory at the samples (n, k)."""
        return np.column_stack((states[:n, size:], np.reshape(self._held[:n], (n, -1))))

    def stepped(self, y: Array) -> str | None:
        self.y = y
        if self._recall is not None and (fault := self._recall.asked.stepped()) is not None:
            return fault
        pose = y[: self.model.n_pose]
        self.last = self.model.turned(pose[None], self.last)[0]
        if self.model.singular_at_vertical:
            quaternion = self.model.quaternions(pose[None])[0]
            pitch = euler_from_rotation(rotation_from_quaternion(quaternion))[1]
            if abs(pitch) > VERTICAL_PITCH or abs(self.last[1]) > VERTICAL_PITCH:
                return (
                    "the pitch reached +-90 degrees, where the Euler rates, and with them this "
                    "model's damping or coordinates, are singular; swing the legs less, or use the "
                    "full model with BodyRateDamping"
                )
        model = self.model
        return model.trouble(pose) if isinstance(model, FullModel) else None
