"""Options of one simulation: how long, by which steps, from which start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import click

from rrrobot.checks import finite
from rrrobot.cli.options.group import Group, option
from rrrobot.cli.types import NUMBER, Numbers


@dataclass(frozen=True, kw_only=True)
class RunOptions(Group):
    """Duration and integrator."""

    duration: float = option("--duration", type=NUMBER, default="30", show_default=True, help="[s]")
    sample_interval: float = option(
        "--sample-interval", type=NUMBER, default="0.01", show_default=True, help="Of results [s]."
    )
    step: float | None = option("--step", type=NUMBER, help="Fixed step of the integrator [s].")
    rtol: float | None = option(
        "--rtol", type=NUMBER, help="Relative tolerance of its adaptive step; 1e-10."
    )
    method: str | None = option(
        "--method",
        type=click.Choice(("kkt", "momentum")),
        help="kkt, the general form, unless given; momentum, faster, for gaits on level ground.",
    )

    def settings(self) -> dict[str, Any]:
        """Keywords of `simulate`.

        Raises:
            click.UsageError: both --step and --rtol.
            ParameterError: a duration that is not above zero.
        """
        if self.step is not None and self.rtol is not None:
            raise click.UsageError(
                "--step is a fixed step, --rtol rules an adaptive one: give one."
            )
        finite("duration", self.duration, "s", above=0)
        return self.given("duration", "sample_interval", "step", "rtol", "method")


@dataclass(frozen=True, kw_only=True)
class StartOptions(Group):
    """Rates and angles at the start."""

    start: str | tuple[float, ...] = option(
        "--start",
        type=Numbers(3, words=("impulsive", "rest")),
        default="impulsive",
        show_default=True,
        metavar="HOW",
        help="impulsive: the legs' speed sets the body going without momentum; rest; or the rates "
        "of roll, pitch, yaw as R,P,Y [rad/s].",
    )
    euler: tuple[float, ...] | None = option(
        "--euler", type=Numbers(3), help="Roll, pitch, yaw at the start [rad], as R,P,Y."
    )
