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
from rrrobot.momentum.kernels import ANY, DECOUPLED
from rrrobot.momentum.terrain import LEVEL, Terrain, fineness, terrain_of
from rrrobot.momentum.tree import Tree, tree_of
from rrrobot.robot.robot import Robot

VERTICAL = float(np.sin(VERTICAL_PITCH))
"""Sine of the pitch at which a lane stops whose model is singular at the vertical."""
_ANY_PITCH = 2.0
_LARGE = 1.0
"""Radius [m] from which on numbers about a sphere's centre would lose digits that those about the
base's origin keep."""
MODELS: tuple[type[Model], ...] = (FullModel, PivotingModel, RollModel, PitchModel, YawModel)
"""What the engine computes."""


class Setting(NamedTuple):
    """A model in the engine's terms."""

    tree: Tree
    parameters: Array
    """(N_PARAMETER,), as the kernels take them"""
    axis: int
    """-1 for all axes, 0-2 for the one that is free, DECOUPLED for three models side by side, ANY
    for a body with any shell on any ground"""
    limit: float
    """of the sine of the pitch, where a lane stops; above 1 for models without a singularity"""
    leg_loss: Array
    """damping [N m s/rad] and friction [N m] of the leg joints (2, legs), motors overcome both"""
    terrain: Terrain | None
    """the shell on the ground, where the axis is ANY; else None, and the engine is compiled
    without what it would need"""
    fineness: int
    """how many times the steps of a sphere the shell needs"""
    effort: Array
    """largest of each motor that the file allows (legs,); infinite without limit"""
    radius: float
    """height of a sphere's centre over the level ground [m]; where the axis is ANY, not used"""

    @property
    def periodic(self) -> bool:
        """Whether a settled motion repeats in the body's axes wherever it has come to."""
        return self.terrain is None or bool(self.terrain.ground == LEVEL)


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
    limit = VERTICAL if model.singular_at_vertical else _ANY_PITCH
    joints, losses = robot.joints, _damping(model.damping)
    legs = np.array((joints.damping + model.damping.leg_coefficient, joints.friction))
    frame = robot.shell_placement
    level = type(model.ground) is Plane and model.ground.is_level
    if type(shell) is Sphere and level and shell.radius <= _LARGE:
        rolls, travels = model.rolling is not None, type(model) is not YawModel
        radii = (shell.radius * rolls, shell.radius * travels)
        axis = model.axes[0] if len(model.axes) == 1 else -1
        numbers = np.array((robot.mass, *radii, model.gravity, *losses))
        return Setting(tree_of(robot), numbers, axis, limit, legs, None, 1, joints.effort,
                       shell.radius)  # fmt: skip
    terrain = terrain_of(shell, (frame.translation, frame.rotation), model.ground)
    numbers = np.array((robot.mass, 1.0, 0.0, model.gravity, *losses))
    tree = tree_of(robot, np.zeros(3))
    return Setting(tree, numbers, ANY, limit, legs, terrain, fineness(shell), joints.effort, 0.0)


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
    none = np.zeros_like(first.leg_loss)
    return first._replace(parameters=parameters, axis=DECOUPLED, limit=_ANY_PITCH, leg_loss=none)


def _damping(damping: Damping) -> tuple[float, float, float, float]:
    if type(damping) is EulerRateDamping:
        return damping.roll, damping.pitch, damping.yaw, 1.0
    if type(damping) is BodyRateDamping:
        return damping.x, damping.y, damping.z, 0.0
    raise ModelError(
        f"the momentum engine does not know the damping {type(damping).__qualname__}: it computes "
        "exactly EulerRateDamping and BodyRateDamping. Use method='kkt'."
    )
