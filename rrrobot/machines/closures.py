"""Closed kinematic loops: two frames of one robot that coincide, exact with their drift."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array
from rrrobot.constraints import Constraint, Instant
from rrrobot.errors import ConstraintError
from rrrobot.kkt import ConstraintRows

_WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class FramesCoincide(Constraint):
    """Two frames that coincide: v_2 - v_1 = 0, and w_2 - w_1 = 0 where they are welded; holonomic.

    Rows are along the world's axes. A pin leaves the frames free to turn about their common
    origin; a weld does not. Frame 0 of a Pinocchio model is the world: a link that coincides with
    it is fixed. Its force, and moment, act on frame 2 [N, N m]. Rows that a planar machine meets
    by itself depend on the others and change nothing; `along` leaves them out.

    Args:
        model: Pinocchio model.
        first, second: the frames.
        welded: whether their axes coincide too.
        along: directions in which their origins coincide (k, 3); the world's axes unless given.
        name: of the constraint.

    Raises:
        ConstraintError: the two are one frame.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.machines import FramesCoincide
        >>> model = rr.machines.snakeboard().tree.model()
        >>> rotor, board = (model.getFrameId(name) for name in ("rotor_link", "board"))
        >>> FramesCoincide(model, rotor, board, welded=True).holonomic.size
        6
    """

    def __init__(
        self,
        model: pin.Model,
        first: int,
        second: int,
        *,
        welded: bool = False,
        along: ArrayLike | None = None,
        name: str = "loop",
    ) -> None:
        if first == second:
            raise ConstraintError(f"frames {first} and {second} are one: a loop joins two.")
        self.model, self.name = model, name
        self.first, self.second, self.welded = first, second, welded
        self.along = np.eye(3) if along is None else np.atleast_2d(np.asarray(along, dtype=float))
        self.holonomic = np.ones(len(self.along) + 3 * welded, dtype=bool)

    def rows(self, at: Instant) -> ConstraintRows:
        model, data = self.model, at.data
        one, two = (
            pin.computeFrameJacobian(model, data, at.q, frame, _WORLD)
            for frame in (self.first, self.second)
        )
        start, end = (
            pin.getFrameClassicalAcceleration(model, data, frame, _WORLD).vector
            for frame in (self.first, self.second)
        )
        jacobian = self._chosen(two - one)
        return ConstraintRows(jacobian, self._chosen(end - start), jacobian @ at.v)

    def gap(self, at: Instant) -> Array:
        """How far apart they are (m,) [m, rad]."""
        one, two = (
            pin.updateFramePlacement(self.model, at.data, frame)
            for frame in (self.first, self.second)
        )
        turn = pin.log3(two.rotation @ one.rotation.T)
        return self._chosen(np.concatenate((two.translation - one.translation, turn)))

    def _chosen(self, spatial: Array) -> Array:
        """Rows of linear over angular parts (6, ...)."""
        linear = self.along @ spatial[:3]
        return np.concatenate((linear, spatial[3:])) if self.welded else linear
