"""What is wrong with gaits of a sweep, told: not settled, legs in the ground, limits passed."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.errors import GroundClearanceWarning, LimitWarning, UnsettledWarning
from rrrobot.inline import percent
from rrrobot.results import SETTLED
from rrrobot.robot.robot import Robot
from rrrobot.studies.sweeps.grid import Plan

_AT_ONCE = 100_000
_ROUNDING = 1e-9
_MOST = 8


def warn_of_gaits(robot: Robot, plan: Plan, columns: Mapping[str, NDArray[Any]]) -> None:
    """Warn of gaits that have not settled, or that the robot's file or the ground stands against.

    Positions and rates are those of the swing about the offset; who goes round passes every limit.
    Efforts are known of a sweep with loads: the largest torque over what the file allows its joint.

    Warns:
        UnsettledWarning: how many gaits still change from cycle to cycle, and by how much.
        GroundClearanceWarning: how many gaits swing a leg through the ground.
        LimitWarning: each joint and limit, how many gaits pass it, and by how much at most.
    """
    # Of a gait that was stopped, or has no orbit that holds, the status speaks.
    counted = columns["status"] == 0
    changes = columns["variation"][counted & (columns["variation"] > SETTLED)]
    if changes.size:
        warnings.warn(
            f"{changes.size} of {columns['variation'].size} gaits have not settled: their single "
            f"cycles are up to {percent(float(changes.max()))} from the mean that is given. "
            "Simulate more cycles (cycles=), or find limit cycles (settle='orbit').",
            UnsettledWarning,
            stacklevel=3,
        )
    heights = columns["clearance"]
    touching = int(np.count_nonzero(heights <= 0))
    if touching:
        warnings.warn(
            f"{touching} of {heights.size} gaits swing a leg through the ground, which the models "
            "know nothing of; their 'clearance' is zero or less.",
            GroundClearanceWarning,
            stacklevel=3,
        )
    if not robot.joints.limited:
        return
    told = [
        f"{leg}: {what} in {count}, by up to {excess:.3g} {unit} beyond {limit:.4g}"
        for (leg, what, unit, limit), (count, excess) in _passed(robot, plan).items()
    ]
    if "torque_share" in columns:
        over = columns["torque_share"] > 1 + _ROUNDING
        if np.any(over):
            most = float(np.nanmax(columns["torque_share"]))
            told.append(
                f"a motor's effort in {np.count_nonzero(over)}, up to {most:.3g} times what the "
                "file allows its joint"
            )
    if told:
        more = f"; and {len(told) - _MOST} more" if len(told) > _MOST else ""
        warnings.warn(
            f"of {heights.size} gaits, some pass limits of {robot.name}'s file, which stop nothing "
            f"here: {'; '.join(told[:_MOST])}{more}.",
            LimitWarning,
            stacklevel=3,
        )


def _passed(robot: Robot, plan: Plan) -> dict[tuple[str, str, str, float], tuple[int, float]]:
    """(leg, what, unit, limit) -> number of gaits beyond it, and the largest excess."""
    joints, found = robot.joints, dict[tuple[str, str, str, float], tuple[int, float]]()
    size = math.prod(plan.gait_sizes.values())
    # The robots of a sweep over parameters have the same joints.
    times = math.prod(plan.sizes.values()) // max(size, 1)
    for first in range(0, size, _AT_ONCE):
        gaits, _ = plan.gaits(first, min(first + _AT_ONCE, size))
        swing, rate = gaits.extent()
        for k, leg in enumerate(robot.legs):
            cases: tuple[tuple[str, str, float, Array], ...] = (
                ("position", "rad", joints.lower[k],
                 joints.lower[k] - (gaits.offset - swing)[:, k]),
                ("position", "rad", joints.upper[k],
                 (gaits.offset + swing)[:, k] - joints.upper[k]),
                ("rate", "rad/s", joints.velocity[k], rate[:, k] - joints.velocity[k]),
            )  # fmt: skip
            for what, unit, limit, excess in cases:
                over = excess > _ROUNDING * max(1.0, abs(limit))
                if math.isfinite(limit) and np.any(over):
                    key = (leg, what, unit, float(limit))
                    count, most = found.get(key, (0, 0.0))
                    more = times * int(np.count_nonzero(over))
                    found[key] = count + more, max(most, float(excess.max()))
    return found
