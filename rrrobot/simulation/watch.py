"""What a motion does that no model knows of: limits passed, legs under the ground.

Every `Trajectory` that is simulated passes `watch`, whatever made it.
"""

from __future__ import annotations

import warnings

import numpy as np

from rrrobot.contact.ground import Plane
from rrrobot.errors import GroundClearanceWarning, LimitWarning
from rrrobot.robot.limits import beyond
from rrrobot.simulation.heights import leg_heights
from rrrobot.simulation.trajectory import Trajectory

_MOST = 8
_FINE = 1e-6
"""Depth up to which a leg is not under the ground [m]."""


def watch(trajectory: Trajectory) -> None:
    """Warn of limits of the robot's file that a motion passes, and of legs under the ground.

    Warns:
        LimitWarning: each joint, by how much and when.
        GroundClearanceWarning: the lowest point of a leg's mass, and when.
    """
    robot = trajectory.robot
    if robot.joints.limited:
        told = beyond(
            robot.joints, robot.legs, trajectory.time, trajectory.leg_angle, trajectory.leg_rate,
            trajectory.leg_torque,
        )  # fmt: skip
        if told:
            more = f"; and {len(told) - _MOST} more" if len(told) > _MOST else ""
            warnings.warn(
                f"joints of {robot.name} pass limits of its file, which stop nothing here: "
                f"{'; '.join(told[:_MOST])}{more}.",
                LimitWarning,
                stacklevel=3,
            )
    if not isinstance(trajectory.ground, Plane):
        return
    height = leg_heights(trajectory)
    if height.size and float(height.min()) < -_FINE:
        i, k = np.unravel_index(int(np.argmin(height)), height.shape)
        warnings.warn(
            f"the centre of mass of leg {_names(trajectory)[k]} is "
            f"{-float(height[i, k]):.3g} m under the ground at t = {trajectory.time[i]:.4g} s, "
            "which the models know nothing of: this motion means nothing if the leg is real there.",
            GroundClearanceWarning,
            stacklevel=3,
        )


def _names(trajectory: Trajectory) -> list[str]:
    return list(trajectory.robot.model.names)[2:]
