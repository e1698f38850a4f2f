"""Options of a limit cycle, and the cycle that they stand for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from rrrobot.cli.compile import tell_of_compiling
from rrrobot.cli.options.drive import GaitOptions
from rrrobot.cli.options.group import Group, option
from rrrobot.cli.options.robot import (
    DECOUPLED,
    MODELS,
    DampingOptions,
    GroundOptions,
    Parts,
    RobotOptions,
)
from rrrobot.models.recombined import DecoupledModels
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel

if TYPE_CHECKING:
    from rrrobot.drive.gaits import Gait
    from rrrobot.orbits.limit_cycles import LimitCycle
    from rrrobot.orbits.starts import Attractors


@dataclass(frozen=True, kw_only=True)
class OrbitOptions(Group):
    """Which limit cycle."""

    model: str = option(
        "--model", type=click.Choice((*MODELS, DECOUPLED)), default="full", show_default=True
    )
    periods: int = option(
        "--periods",
        type=int,
        default=1,
        show_default=True,
        help="Of the legs, after which the motion repeats.",
    )
    steps: int | None = option(
        "--steps", type=int, help="For each cycle; as many as are needed unless given."
    )

    def build(
        self,
        robot: RobotOptions,
        ground: GroundOptions,
        gait: GaitOptions,
        damping: DampingOptions,
    ) -> LimitCycle:
        """Find the cycle."""
        model, legs = self._case(robot, ground, gait, damping)
        from rrrobot.orbits.limit_cycles import limit_cycle

        return limit_cycle(model, legs, periods=self.periods, steps_per_cycle=self.steps)

    def attractors(
        self,
        robot: RobotOptions,
        ground: GroundOptions,
        gait: GaitOptions,
        damping: DampingOptions,
        n_starts: int,
    ) -> Attractors:
        """Find what several starts come to."""
        self.refuse(("steps",), "does not go with --starts")
        model, legs = self._case(robot, ground, gait, damping)
        from rrrobot.orbits.starts import attractors

        return attractors(model, legs, n_starts=n_starts, periods=max(4, self.periods))

    def _case(
        self,
        robot: RobotOptions,
        ground: GroundOptions,
        gait: GaitOptions,
        damping: DampingOptions,
    ) -> tuple[Any, Gait]:
        """The model and the gait; Numba loads after this, so that it costs nobody who has none."""
        parts = Parts.of(robot, ground, damping)
        model: Any
        if self.model == DECOUPLED:
            kinds = (parts.model(kind) for kind in (RollModel, PitchModel, YawModel))
            model = DecoupledModels(parts.robot, *kinds)  # type: ignore[arg-type]
        else:
            model = parts.model(MODELS[self.model])
        legs = gait.build(parts.robot, robot)
        tell_of_compiling(quiet=False, alone=True)
        return model, legs
