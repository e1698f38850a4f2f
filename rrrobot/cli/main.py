"""The command line: `rrrobot simulate`, `sweep`, `compare`, `optimise` and the others.

An error that rrrobot raises on purpose becomes one line on stderr and exit code 1, wrong usage
exit code 2, Ctrl-C 130; warnings are one line each on stderr. A command is a file of this folder:
what it defines with `click.command` is found here.
"""

from __future__ import annotations

import importlib
import pkgutil
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

import rrrobot.cli
from rrrobot.cli.wording import in_options
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
            with _warnings_as_lines(ctx):
                return super().invoke(ctx)
        except KeyboardInterrupt as error:
            raise _Interrupt(_one_line(error) or "stopped.") from None
        except RRRobotError as error:
            raise click.ClickException(_said(error, ctx)) from None


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


def _commands() -> Iterator[click.Command]:
    """The commands of every file beside this one."""
    for info in pkgutil.iter_modules(rrrobot.cli.__path__, "rrrobot.cli."):
        if info.name == __name__ or info.ispkg:
            continue
        module = importlib.import_module(info.name)
        for item in vars(module).values():
            if isinstance(item, click.Command) and item.callback.__module__ == info.name:
                yield item


for _command in _commands():
    cli.add_command(_command)


@contextmanager
def _warnings_as_lines(ctx: click.Context) -> Iterator[None]:
    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        click.echo(f"Warning: {_said(message, ctx)}", err=True)

    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = show
        yield


def _said(message: object, ctx: click.Context) -> str:
    """One line, with the options of the command that runs instead of Python's arguments."""
    text = _one_line(message)
    commands = ctx.command.commands if isinstance(ctx.command, click.Group) else {}
    command = commands.get(ctx.invoked_subcommand or "")
    return text if command is None else in_options(text, command)


def _one_line(message: object) -> str:
    return shortened(" ".join(str(message).split()))
