"""Postures to search gaits about: beside the belly's own, others that are clear, low and unlike."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from rrrobot.belly.shapes import Shapes
from rrrobot.checks import Array
from rrrobot.escape.bench import Bench
from rrrobot.escape.limits import EscapeLimits
from rrrobot.escape.spaces import symmetric
from rrrobot.robot.joints import JointIndex
from rrrobot.robot.limits import JointEnds
from rrrobot.robot.robot import Robot

_TRIED = 1024
_WIDEST = 1.6
"""Of the deviations from the first posture, before images are averaged [rad]."""
_WIDER = 0.03
"""By which capsules may overlap where links do not touch [m]."""
_UNLIKE = 0.35
"""Root mean square distance of postures from each other [rad]."""


def stances(
    shapes: Shapes, bench: Bench, first: Array, ends: JointEnds, limits: EscapeLimits, count: int,
    seed: int = 0,
) -> Array:  # fmt: skip
    """The first posture and others (k, legs), at most `count`: by turns clear and low ones.

    Each is its own image under the robot's symmetries, has room to swing, and keeps the limbs clear
    of the ground and of each other in the upright pose, the latter as Coal has it.
    """
    robot = shapes.robot
    rng = np.random.default_rng(seed)
    tried = np.vstack((
        first + rng.uniform(-_WIDEST, _WIDEST, (_TRIED // 2, robot.n_legs)),
        rng.uniform(np.maximum(ends.lower, -np.pi), np.minimum(ends.upper, np.pi),
                    (_TRIED // 2, robot.n_legs)),
    ))  # fmt: skip
    room = np.minimum(0.15, (ends.upper - ends.lower) / 4)
    tried = np.clip(symmetric(robot, tried), ends.lower + room, ends.upper - room)
    height, apart = bench.still(np.vstack((first, tried)))
    # A first posture that is nearer than the limits sets them.
    clear = height[1:, :-1].min(axis=1, initial=np.inf) >= min(
        2 * limits.clearance, height[0, :-1].min(initial=np.inf)
    )
    clear &= apart[1:] >= min(2 * limits.separation, apart[0]) - _WIDER
    least = 2 * limits.separation
    tried, room_below = tried[clear], height[1:, :-1].min(axis=1, initial=1.0)[clear]
    orders = [
        np.argsort(center_heights(robot, tried), kind="stable"),
        np.argsort(-room_below, kind="stable"),
    ]
    found = [first]
    while len(found) < count and any(order.size for order in orders):
        order = orders[len(found) % 2]
        gaps = np.min([np.sqrt(np.mean((tried - one) ** 2, axis=1)) for one in found], axis=0)
        unlike = (tried[i] for i in order[gaps[order] > _UNLIKE])
        new = next(
            (one for one in unlike if bench.exact(shapes, one[None]).min(initial=np.inf) >= least),
            None,
        )
        if new is None:
            break
        found.append(new)
    return np.array(found)


def center_heights(robot: Robot, offsets: Array) -> Array:
    """Heights of the centre of mass in the base's frame (n,) [m]."""
    model, data = robot.model, robot.model.createData()
    index, q = JointIndex(model, robot.legs), pin.neutral(model)
    found = np.empty(len(offsets))
    for i, row in enumerate(offsets):
        index.write(q, row)
        found[i] = pin.centerOfMass(model, data, q)[2]
    return found
