"""Models in the engine's terms: a tree of bodies, eight numbers, the axes that are free."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.contact.ground import Plane
from rrrobot.contact.surfaces import Sphere
from rrrobot.drive.damping import BodyRateDamping, Damping, EulerRateDamping
from rrrobot.errors import ModelError
from rrrobot.models.base import VERTICAL_PITCH, Model
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.momentum.coefficients import Tree, tree_of
from rrrobot.momentum.kernels import DECOUPLED
from rrrobot.robot.robot import Robot

VERTICAL = float(np.sin(VERTICAL_PITCH))
"""Sine of the pitch at which a lane stops whose model is singular at the vertical."""
_ANY_PITCH = 2.0
MODELS: tuple[type[Model], ...] = (FullModel, PivotingModel, RollModel, PitchModel, YawModel)
"""What the engine computes."""


class Setting(NamedTuple):
    """A model in the engine's terms."""

    tree: Tree
    parameters: Array
    """(N_PARAMETER,), as the kernels take them"""
    axis: int
    """-1 for all axes, 0-2 for the one that is free, DECOUPLED for three models side by side"""
    limit: float
    """of the sine of the pitch, where a lane stops; above 1 for models without a singularity"""
    leg_damping: float
    """of the leg joints [N m s/rad], which the motors overcome"""


def lower(model: Model) -> Setting:
    """A model in the engine's terms, if the engine has the very same equations.

    A class of one's own that derives from one of ours, a model, a damping, a shell or a ground, may
    have other equations, so it is not taken for the one that it derives from.

    Raises:
        ModelError: the engine does not know the model, its damping, its shell or its ground.
    """
    robot, shell = model.robot, model.robot.shell
    if type(model) not in MODELS:
        raise ModelError(
            f"the momentum engine does not know {type(model).__qualname__}: it computes exactly "
            f"{', '.join(kind.__name__ for kind in MODELS)}. Use method='kkt'."
        )
    if type(shell) is not Sphere or type(model.ground) is not Plane or not model.ground.is_level:
        raise ModelError(
            f"the momentum engine needs a spherical shell on level ground; here are {shell} on "
            f"{model.ground!r}. Use method='kkt'."
        )
    rolls = model.rolling is not None
    travels = type(model) is not YawModel
    radius = shell.radius
    numbers = (
        robot.mass,
        radius * rolls,
        radius * travels,
        model.gravity,
        *_damping(model.damping),
    )
    axis = model.axes[0] if len(model.axes) == 1 else -1
    limit = VERTICAL if model.singular_at_vertical else _ANY_PITCH
    legs = model.damping.leg_coefficient
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
    first = lower(models[0])
    parameters = first.parameters.copy()
    parameters[4:7] = losses
    return Setting(first.tree, parameters, DECOUPLED, _ANY_PITCH, 0.0)


def _damping(damping: Damping) -> tuple[float, float, float, float]:
    if type(damping) is EulerRateDamping:
        return damping.roll, damping.pitch, damping.yaw, 1.0
    if type(damping) is BodyRateDamping:
        return damping.x, damping.y, damping.z, 0.0
    raise ModelError(
        f"the momentum engine does not know the damping {type(damping).__qualname__}: it computes "
        "exactly EulerRateDamping and BodyRateDamping. Use method='kkt'."
    )
