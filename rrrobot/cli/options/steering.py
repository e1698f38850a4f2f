"""Options of plans and of what stands in the way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from rrrobot.cli.options.group import Group, option
from rrrobot.cli.types import NUMBER, Numbers, parse_number
from rrrobot.errors import ParameterError
from rrrobot.steering.obstacles import Disc, Obstacle, Polygon

if TYPE_CHECKING:
    _ParamType = click.ParamType[Any, Any]
else:
    _ParamType = click.ParamType


class Points(_ParamType):
    """Points "X,Y X,Y ..." -> tuple of pairs.

    Args:
        least: how many are needed.
    """

    name = "points"

    def __init__(self, least: int) -> None:
        self.least = least

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[tuple[float, float], ...]:
        if not isinstance(value, str):
            return tuple(value)
        try:
            rows = [tuple(parse_number(x) for x in part.split(",")) for part in value.split()]
        except ValueError as error:
            self.fail(str(error), param, ctx)
        if len(rows) < self.least or any(len(row) != 2 for row in rows):
            self.fail(f'{value!r}: write {self.least} points or more, as "X,Y X,Y".', param, ctx)
        return tuple((row[0], row[1]) for row in rows)


@dataclass(frozen=True, kw_only=True)
class ObstacleOptions(Group):
    """What stands in the way."""

    disc: tuple[tuple[float, ...], ...] = option(
        "--disc", type=Numbers(3), multiple=True, metavar="X,Y,R", help="A round obstacle [m]."
    )
    polygon: tuple[Any, ...] = option(
        "--polygon", type=Points(3), multiple=True, metavar='"X,Y X,Y ..."',
        help="An obstacle with these corners, in their order [m].",
    )  # fmt: skip
    margin: float | None = option(
        "--margin", type=NUMBER,
        help="That the contact point keeps from obstacles [m]; the shell's radius unless given.",
    )  # fmt: skip

    def build(self) -> tuple[Obstacle, ...]:
        """The obstacles."""
        if any(not isinstance(d, tuple) for d in self.disc):
            raise ParameterError("--disc takes three numbers, X,Y,R.")
        return (
            *(Disc(d[:2], d[2]) for d in self.disc),
            *(Polygon(corners) for corners in self.polygon),
        )


@dataclass(frozen=True, kw_only=True)
class LegOptions(Group):
    """Bounds of the gaits that may be used."""

    amplitude: float = option(
        "--amplitude", type=NUMBER, default="0.5", show_default=True,
        help="Largest swing of the legs [rad].",
    )  # fmt: skip
    frequency: float = option(
        "--frequency", type=NUMBER, default="8", show_default=True, help="Angular [rad/s]."
    )
