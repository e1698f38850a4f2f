"""What is followed from step to step: whole turns, the drive's memory, and the vertical."""

from __future__ import annotations

from math import sin

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import ModelError
from rrrobot.models.base import VERTICAL_PITCH, Model
from rrrobot.models.full import FullModel
from rrrobot.simulation.memory import Recall

VERTICAL = (
    "the pitch reached +-90 degrees, where the Euler rates, and with them this model's damping or "
    "coordinates, are singular; swing the legs less, or use the full model with BodyRateDamping"
)


def require_rolling(model: Model, pose: Array) -> None:
    """Raise ModelError where a pose (n_pose,) has no contact that rolls."""
    if isinstance(model, FullModel) and (trouble := model.trouble(pose)) is not None:
        raise ModelError(
            f"the robot cannot start at the position {pose[4:].tolist()} m: {trouble}. Start "
            "elsewhere with position=."
        )


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

    def stepped(self, ends: Array) -> tuple[int, str] | None:
        self.y = ends[-1]
        if self._recall is not None and (fault := self._recall.asked.stepped()) is not None:
            return 0, fault
        model, poses = self.model, ends[:, : self.model.n_pose]
        angles = model.turned(poses, self.last)
        self.last = angles[-1]
        stop = None
        if model.singular_at_vertical:
            pitch = angles[:, 1]
            # A step may have gone over it.
            near = np.abs(np.sin(pitch)) > sin(VERTICAL_PITCH)
            bad = np.flatnonzero(near | (np.abs(pitch) > VERTICAL_PITCH))
            if bad.size:
                stop = int(bad[0]), VERTICAL
        if isinstance(model, FullModel):
            for i, pose in enumerate(poses[: None if stop is None else stop[0]]):
                if (trouble := model.trouble(pose)) is not None:
                    return i, trouble
        return stop
