"""What a sweep simulates: models, their engine, and the models of other robots.

`Variants` stands for a model with each combination of the swept robot parameters.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array
from rrrobot.errors import GroundClearanceWarning, ModelError, ParameterError
from rrrobot.models.base import Model
from rrrobot.models.recombined import DecoupledModels
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.robot import Robot
from rrrobot.robot.variation import varied

Engine = Callable[..., Array]
"""Computes steady states of (setting, gaits, **run): the columns `RESULT` of `momentum.batch`, then
`LOADS` if asked."""


def engine_of(model: Model, settle: str = "cycles") -> tuple[Engine, Any]:
    """The engine of a model, and the model in its terms.

    Args:
        model: any.
        settle: "cycles": simulate so many; "orbit": find the limit cycle.

    Raises:
        ModelError: there is none, or nothing brakes a model whose limit cycles are wanted.
        ParameterError: no such way to settle.
    """
    from rrrobot.momentum.batch import decoupled_setting, lower, steady_states
    from rrrobot.orbits.many import orbit_states
    from rrrobot.orbits.section import level_section_of

    if settle not in ("cycles", "orbit"):
        raise ParameterError(f"settle is {settle!r}: it must be 'cycles' or 'orbit'.")
    if settle == "orbit":
        setting = engine_of(model)[1]
        level_section_of(setting, model.name)
        return orbit_states, setting
    if isinstance(model, DecoupledModels):
        return steady_states, decoupled_setting(model.robot, *model.models)  # type: ignore[arg-type]
    if not isinstance(model, Model):
        raise ModelError(
            f"model is {model!r}: it must be a model, such as FullModel(robot), or DecoupledModels."
        )
    return steady_states, lower(model)


class Variants:
    """The model with each combination of the swept parameters.

    Attributes:
        base: the robot's own parameters; None if it is no RRRobot.
    """

    def __init__(
        self, model: Model, grids: Mapping[str, ArrayLike], settle: str = "cycles"
    ) -> None:
        self._model, self._settle = model, settle
        self._grids = {name: np.atleast_1d(np.asarray(grid)) for name, grid in grids.items()}
        self._last: tuple[int, tuple[Engine, Any]] | None = None
        self.base = model.robot.parameters
        known = [field.name for field in fields(RRRobotParameters)]
        for name, values in self._grids.items():
            if self.base is not None and name not in known:
                raise ParameterError(
                    f"RRRobotParameters has no {name!r}; it has {', '.join(known)}."
                )
            for value in values.tolist():
                self._robot({name: value})

    def at(self, number: int) -> tuple[Engine, Any]:
        """Engine and setting of a combination."""
        if self._last is None or self._last[0] != number:
            model = self._model
            if self._grids:
                shape = tuple(grid.size for grid in self._grids.values())
                place = np.unravel_index(number, shape)
                pairs = zip(self._grids.items(), place, strict=True)
                values = {name: float(grid[i]) for (name, grid), i in pairs}
                model = model.remade(self._robot(values))
            self._last = number, engine_of(model, self._settle)
        return self._last[1]

    def ends(self) -> list[Model | DecoupledModels]:
        """The model with the first and with the last values of all parameters."""
        if not self._grids:
            return [self._model]
        ends = [{name: float(grid[i]) for name, grid in self._grids.items()} for i in (0, -1)]
        return [self._model.remade(self._robot(values)) for values in ends]

    def _robot(self, values: dict[str, Any]) -> Robot:
        if self.base is None:
            return varied(self._model.robot, values)
        with warnings.catch_warnings():
            # What counts is whether a gait swings a leg through the ground.
            warnings.simplefilter("ignore", GroundClearanceWarning)
            return Robot.from_parameters(replace(self.base, **values))
