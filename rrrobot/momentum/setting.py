"""Models in the engine's terms: a tree of bodies, eight numbers, the axes that are free."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.contact.surfaces import Sphere
from rrrobot.drive.damping import BodyRateDamping, Damping, EulerRateDamping
from rrrobot.errors import ModelError
from rrrobot.models.base import VERTICAL_PITCH, Model
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.momentum.coefficients import Tree, tree_of
from rrrobot.momentum.kernels import DECOUPLED
from rrrobot.robot.robot import Robot

VERTICAL = float(np.sin(VERTICAL_PITCH))
"""Sine of the pitch at which a lane stops whose model is singular at the vertical."""
_ANY_PITCH = 2.0


class Setting(NamedTuple):
    """A model in the engine's terms."""

    tree: Tree
    parameters: Array
    """(N_PARAMETER,), as the kernels take them"""
    axis: int
    """-1 for all axes, 0-2 for the one that is free, DECOUPLED for three models side by side"""
    limit: float
    """of the sine of the pitch, where a lane stops; above 1 for models without a singularity"""
    leg_loss: Array
    """damping [N m s/rad] and friction [N m] of the leg joints (2, legs), motors overcome both"""


def setting_of(model: Model) -> Setting:
    """The engine's terms of a model.

    Raises:
        ModelError: the shell is no sphere, or the ground not level.
    """
    robot = model.robot
    if not isinstance(robot.shell, Sphere) or robot.ground_normal[2] != 1.0:
        raise ModelError(
            f"the momentum engine needs a spherical shell on level ground; this robot has "
            f"{robot.shell} on a ground of normal {robot.ground_normal.tolist()}. Use "
            "method='kkt'."
        )
    rolls = model.rolling is not None
    radius = robot.shell.radius
    gravity = -float(model.model.gravity.linear[2])
    travels = model.name != "yaw"
    numbers = (robot.mass, radius * rolls, radius * travels, gravity, *_damping(model.damping))
    axis = model.axes[0] if len(model.axes) == 1 else -1
    limit = VERTICAL if model.singular_at_vertical else _ANY_PITCH
    joints = robot.joints
    legs = np.array((joints.damping + model.damping.leg_coefficient, joints.friction))
    return Setting(tree_of(robot), np.array(numbers), axis, limit, legs)


def decoupled_setting(
    robot: Robot,
    roll: RollModel | None = None,
    pitch: PitchModel | None = None,
    yaw: YawModel | None = None,
) -> Setting:
    """The engine's terms of the single-axis models, recombined by rolling; the paper's dampings."""
    models = (roll or RollModel(robot), pitch or PitchModel(robot), yaw or YawModel(robot))
    losses = [_damping(m.damping)[m.axis] for m in models]
    first = setting_of(models[0])
    parameters = first.parameters.copy()
    parameters[4:7] = losses
    return Setting(first.tree, parameters, DECOUPLED, _ANY_PITCH, np.zeros((2, robot.n_legs)))


def _damping(damping: Damping) -> tuple[float, float, float, float]:
    if isinstance(damping, EulerRateDamping):
        return damping.roll, damping.pitch, damping.yaw, 1.0
    if isinstance(damping, BodyRateDamping):
        return damping.x, damping.y, damping.z, 0.0
    raise ModelError(f"the momentum engine knows no {type(damping).__name__}; use method='kkt'.")
