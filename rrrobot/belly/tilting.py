"""How far a belly has rolled, along a run: the tilt and its azimuth as a rolling range has them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from rrrobot.belly.found import Belly
from rrrobot.belly.placed import curvature_of
from rrrobot.checks import Array
from rrrobot.contact.ground import Ground, normals
from rrrobot.contact.shells import FlatBelly


def tilts(
    belly: Belly, configurations: Array, positions: Array, ground: Ground
) -> tuple[Array, Array]:
    """Tilt and azimuth (n,) [rad]; see `RollingRange`.

    Args:
        belly: of the robot.
        configurations: Pinocchio's q (n, nq).
        positions: of the contact, in the ground's coordinates (n, 2) [m].
        ground: what it rolls on.
    """
    turns = np.array([pin.Quaternion(q[3:7].copy()).toRotationMatrix() for q in configurations])
    if isinstance(belly.shell, FlatBelly):
        points = np.array([ground.point(p) for p in positions])
        arm = points - configurations[:, :3]
        place = np.einsum("nij,ni->nj", turns, arm) - belly.center
        return (
            np.linalg.norm(place[:, :2], axis=1) * curvature_of(ground),
            np.arctan2(place[:, 1], place[:, 0]),
        )
    down = -np.einsum("nij,ni->nj", turns, normals(ground, positions))
    across = np.linalg.norm(down[:, :2], axis=1)
    return np.arctan2(across, -down[:, 2]), np.arctan2(down[:, 1], down[:, 0])
