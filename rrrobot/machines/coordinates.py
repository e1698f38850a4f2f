"""Coordinates of a machine's state: what is integrated, and Pinocchio's q of it.

Planar roots and turning joints are kept as angles that count full turns, (x, y, theta) and phi, and
bodies in space as quaternions (x, y, z, w), which no orientation makes singular. v is Pinocchio's
own: body components of a root's and of a spherical joint's velocity.
"""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.rotations import quaternion_rate, rotation_from_quaternion


class Coordinates:
    """Coordinates z (nz,) of a Pinocchio model.

    Attributes:
        size: nz.
        neutral: z of Pinocchio's neutral configuration.

    Example:
        >>> import pinocchio as pin
        >>> from rrrobot.machines.coordinates import Coordinates
        >>> model = pin.Model()
        >>> _ = model.addJoint(0, pin.JointModelPlanar(), pin.SE3.Identity(), "root_joint")
        >>> Coordinates(model).to_q([1.0, 2.0, 0.0]).tolist()
        [1.0, 2.0, 1.0, 0.0]
    """

    def __init__(self, model: pin.Model) -> None:
        self._blocks: list[tuple[str, int, int, int]] = []
        self.joint: dict[str, slice] = {}
        z, parts = 0, []
        for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
            kind = joint.shortname().removeprefix("JointModel")
            if kind == "Planar":
                start = np.zeros(3)
            elif kind == "FreeFlyer":
                start = np.array((0, 0, 0, 0, 0, 0, 1.0))
            elif kind == "Spherical":
                start = np.array((0, 0, 0, 1.0))
            else:
                kind = "Turns" if joint.nq == 2 else "One"
                start = np.zeros(1)
            self._blocks.append((kind, z, joint.idx_q, joint.idx_v))
            self.joint[name] = slice(z, z + start.size)
            z += start.size
            parts.append(start)
        self.size, self._nq = z, model.nq
        self.neutral = np.concatenate(parts)

    def to_q(self, z: Array) -> Array:
        """Pinocchio's configuration (nq,)."""
        q = np.empty(self._nq)
        for kind, at, to, _ in self._blocks:
            if kind == "One":
                q[to] = z[at]
            elif kind == "Turns":
                q[to], q[to + 1] = cos(z[at]), sin(z[at])
            elif kind == "Planar":
                q[to : to + 2] = z[at : at + 2]
                q[to + 2], q[to + 3] = cos(z[at + 2]), sin(z[at + 2])
            else:
                first = 3 if kind == "FreeFlyer" else 0
                quaternion = z[at + first : at + first + 4]
                q[to : to + first] = z[at : at + first]
                q[to + first : to + first + 4] = quaternion / sqrt(quaternion @ quaternion)
        return q

    def rate(self, z: Array, v: Array) -> Array:
        """z_dot (nz,) of Pinocchio's velocity (nv,)."""
        rate = np.empty(self.size)
        for kind, at, _, of in self._blocks:
            if kind in ("One", "Turns"):
                rate[at] = v[of]
            elif kind == "Planar":
                c, s = cos(z[at + 2]), sin(z[at + 2])
                rate[at] = c * v[of] - s * v[of + 1]
                rate[at + 1] = s * v[of] + c * v[of + 1]
                rate[at + 2] = v[of + 2]
            elif kind == "FreeFlyer":
                quaternion = z[at + 3 : at + 7]
                rate[at : at + 3] = rotation_from_quaternion(quaternion) @ v[of : of + 3]
                rate[at + 3 : at + 7] = quaternion_rate(quaternion, v[of + 3 : of + 6])
            else:
                rate[at : at + 4] = quaternion_rate(z[at : at + 4], v[of : of + 3])
        return rate

    def normalise(self, z: Array) -> None:
        """Give the quaternions unit length, in place."""
        for kind, at, _, _ in self._blocks:
            if kind in ("FreeFlyer", "Spherical"):
                first = at + (3 if kind == "FreeFlyer" else 0)
                part = z[first : first + 4]
                part /= sqrt(part @ part)
