"""The command line: `rrrobot simulate`, `sweep`, `compare`, `optimise` and the others.

An error that rrrobot raises on purpose becomes one line on stderr and exit code 1, wrong usage
exit code 2, Ctrl-C 130; warnings are one line each on stderr.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

from rrrobot.cli.compare import compare_command, periods
from rrrobot.cli.continue_ import continue_command
from rrrobot.cli.fit import fit_command
from rrrobot.cli.follow import follow_command
from rrrobot.cli.gait import gait_command
from rrrobot.cli.lab import lab_command
from rrrobot.cli.machines import machines
from rrrobot.cli.optimise import optimise_command
from rrrobot.cli.orbit import orbit_command
from rrrobot.cli.plan import plan_command
from rrrobot.cli.reduce import reduce_command
from rrrobot.cli.reproduce import reproduce_command
from rrrobot.cli.sensitivity import sensitivity_command
from rrrobot.cli.simulate import simulate
from rrrobot.cli.sweep import sweep_command
from rrrobot.cli.unstick import unstick_command
from rrrobot.cli.view import robots, view
from rrrobot.errors import RRRobotError, shortened

INTERRUPTED = 130


class _Interrupt(click.ClickException):
    """Ctrl-C, as one line."""

    exit_code = INTERRUPTED

    def show(self, file: Any = None) -> None:
        click.echo(f"Interrupted: {self.message}", err=True)


class _Group(click.Group):
    """A group that turns what its commands raise into one line and an exit code."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            with _warnings_as_lines():
                return super().invoke(ctx)
        except KeyboardInterrupt as error:
            raise _Interrupt(_one_line(error) or "stopped.") from None
        except RRRobotError as error:
            raise click.ClickException(_one_line(error)) from None


@click.group(cls=_Group)
@click.version_option(package_name="rrrobot")
def cli() -> None:
    """Legless locomotion: round robots that roll without slipping because their legs swing.

    \b
    Examples:
      rrrobot simulate --gait circular --html circular.html
      rrrobot compare --gait circular
      rrrobot view --gait lateral --loop
    """


for _command in (
    simulate,
    sweep_command,
    compare_command,
    periods,
    reduce_command,
    reproduce_command,
    optimise_command,
    plan_command,
    follow_command,
    fit_command,
    gait_command,
    machines,
    orbit_command,
    continue_command,
    sensitivity_command,
    lab_command,
    unstick_command,
    view,
    robots,
):
    cli.add_command(_command)


@contextmanager
def _warnings_as_lines() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = _show_warning
        yield


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    click.echo(f"Warning: {_one_line(message)}", err=True)


def _one_line(message: object) -> str:
    return shortened(" ".join(str(message).split()))
