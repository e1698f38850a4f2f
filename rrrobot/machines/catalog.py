"""All machines by name."""

from __future__ import annotations

from collections.abc import Callable

from rrrobot.errors import ModelError
from rrrobot.machines.driven import pendulum_ball, rotor_ball, sphericle
from rrrobot.machines.legged import legged_satellite, rrrobot
from rrrobot.machines.machine import Machine
from rrrobot.machines.racers import roller_racer, trikke
from rrrobot.machines.satellites import falling_cat, satellite
from rrrobot.machines.shells import (
    ball_on_slope,
    chaplygin_sphere,
    rattleback,
    rolling_disc,
    routh_sphere,
    turntable_ball,
)
from rrrobot.machines.sleighs import chaplygin_sleigh
from rrrobot.machines.snakeboards import snakeboard
from rrrobot.machines.snakes import kinematic_snake
from rrrobot.machines.submarines import submarine

MACHINES: dict[str, Callable[..., Machine]] = {
    make.__name__: make
    for make in (
        snakeboard, roller_racer, trikke, kinematic_snake, chaplygin_sleigh, rolling_disc,
        ball_on_slope, turntable_ball, chaplygin_sphere, routh_sphere, rattleback, pendulum_ball,
        rotor_ball, sphericle, satellite, legged_satellite, falling_cat, submarine, rrrobot,
    )
}  # fmt: skip
"""Each machine's function by its name."""


def all_names() -> tuple[str, ...]:
    """Names of all machines.

    Example:
        >>> import rrrobot as rr
        >>> "rattleback" in rr.machines.all_names()
        True
    """
    return tuple(MACHINES)


def by_name(name: str, **parameters: float) -> Machine:
    """A machine by its name.

    Raises:
        ModelError: no such machine, or no such parameter.

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.by_name("snakeboard", m=5.0).name
        'snakeboard'
    """
    make = MACHINES.get(name)
    if make is None:
        raise ModelError(f"there is no machine {name!r}; there are: {', '.join(MACHINES)}.")
    known = make.__kwdefaults__ or {}
    for key in parameters:
        if key not in known:
            raise ModelError(
                f"the {name} has no parameter {key!r}; it has: {', '.join(known) or 'none'}."
            )
    return make(**parameters)
