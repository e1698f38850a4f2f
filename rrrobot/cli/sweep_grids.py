"""Grids of gaits and of robots on the command line."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from rrrobot.checks import Array
from rrrobot.cli.options.group import Group, option
from rrrobot.cli.types import parse_number
from rrrobot.studies.sweeps.run import LARGEST

if TYPE_CHECKING:
    _ParamType = click.ParamType[Any, Any]
else:
    _ParamType = click.ParamType

_PLANE = {
    "offset": "0:pi:40",
    "phase_difference": "0:2*pi:40",
    "amplitude": "0.3",
    "frequency": "8",
}
_GRIDS = (
    "offset", "phase_difference", "phase", "amplitude", "frequency", "start_roll", "start_pitch",
)  # fmt: skip


class Grid(_ParamType):
    """[NAME=]START:STOP:COUNT, V1,V2,... or one number -> (name or None, grid)."""

    name = "grid"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[str | None, float | Array]:
        if not isinstance(value, str):
            return value
        label, _, text = value.rpartition("=")
        try:
            return label or None, parse_grid(text)
        except ValueError as error:
            self.fail(str(error), param, ctx)


def parse_grid(text: str) -> float | Array:
    """START:STOP:COUNT with both ends, a list with commas, or a number.

    Raises:
        ValueError: anything else.

    Example:
        >>> parse_grid("0:pi:3").round(3).tolist()
        [0.0, 1.571, 3.142]
    """
    parts = text.split(":")
    if len(parts) == 1:
        values = [parse_number(entry) for entry in text.split(",")]
        return values[0] if len(values) == 1 else np.array(values)
    if len(parts) != 3 or re.fullmatch(r"\d{1,9}", parts[2].strip()) is None:
        raise ValueError(f"{text!r} is no grid: write START:STOP:COUNT, such as 0:pi:40.")
    count = int(parts[2])
    if not 1 <= count <= LARGEST:
        raise ValueError(f"{text!r} has {count} values: from 1 to {LARGEST} are allowed.")
    return np.linspace(parse_number(parts[0]), parse_number(parts[1]), count)


GRID = Grid()


def _grid(name: str, help_text: str) -> Any:
    return option(f"--{name}", type=GRID, multiple=True, metavar="[NAME=]GRID", help=help_text)


Entries = tuple[tuple[str | None, float | Array], ...]


@dataclass(frozen=True, kw_only=True)
class GridOptions(Group):
    """Grids of gaits and of robots."""

    offset: Entries = _grid("offset", "Centre of the swing [rad]; pi/2 is up.")
    phase_difference: Entries = _grid(
        "phase-difference", "By which leg 2 leads leg 1 [rad]; pi/2 unless given."
    )
    phase: Entries = _grid("phase", "Of each leg instead [rad].")
    amplitude: Entries = _grid("amplitude", "Of the swing [rad]; 0.3 unless given.")
    frequency: Entries = _grid("frequency", "Angular, of all legs [rad/s]; 8 unless given.")
    start_roll: Entries = _grid("start-roll", "Roll of the body at the start [rad]; 0.")
    start_pitch: Entries = _grid("start-pitch", "Its pitch [rad]; 0.")
    parameter: Entries = _grid(
        "parameter",
        "RRRobot: as leg_mass=0.04:0.08:5 or shell_radius=0.1,0.12. Other robots: LINK.mass, "
        "shell.radius and what else `rr.robot.varied` takes.",
    )
    paper: bool = option(
        "--paper",
        is_flag=True,
        help="The paper's plane: offsets 0 .. pi by phase differences 0 .. 2 pi, 40 by 40, "
        "amplitude 0.3, frequency 8. Grids that are given replace these.",
    )

    def build(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Grids and robot parameters as `sweep` takes them.

        Raises:
            click.UsageError: a grid for one leg beside one for all, or one given twice.
        """
        entries: dict[str, list[Any]] = {name: list(getattr(self, name)) for name in _GRIDS}
        if self.paper:
            if self.phase:
                raise click.UsageError(
                    "--phase does not go with --paper: it has phase differences."
                )
            for name, text in _PLANE.items():
                entries[name] = entries[name] or [(None, parse_grid(text))]
        grids: dict[str, Any] = {}
        for name, given in entries.items():
            legs = [leg for leg, _ in given]
            if len(set(legs)) != len(legs) or (None in legs and len(legs) > 1):
                raise click.UsageError(
                    f"--{name.replace('_', '-')}: give one grid for all legs, or one JOINT=GRID "
                    "each."
                )
            if given:
                key = "angular_frequency" if name == "frequency" else name
                grids[key] = dict(given) if legs[0] else given[0][1]
        parameters: dict[str, Any] = {}
        for label, grid in self.parameter:
            if label is None or label in parameters:
                raise click.UsageError("--parameter: write NAME=GRID, each NAME once.")
            parameters[label] = np.atleast_1d(grid)
        return grids, parameters
