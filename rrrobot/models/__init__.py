"""Models: a robot, a ground, constraints and damping, each a file of its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rrrobot import serial
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.recombined import DecoupledModels
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.robot.robot import Robot

__all__ = [
    "DecoupledModels",
    "FullModel",
    "Model",
    "PitchModel",
    "PivotingModel",
    "RollModel",
    "YawModel",
    "model_from_dict",
]


def model_from_dict(data: Mapping[str, Any], robot: Robot) -> Model:
    """The model that `to_dict` wrote, of a robot.

    Example:
        >>> import rrrobot as rr

        >>> robot = rr.Robot.from_parameters()
        >>> rr.models.model_from_dict(rr.YawModel(robot).to_dict(), robot).name
        'yaw'
    """
    return serial.from_dict({**data, "robot": robot}, Model, "model")  # type: ignore[type-abstract]
