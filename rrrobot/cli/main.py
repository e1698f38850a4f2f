"""The command line: `rrrobot simulate`, `sweep`, `compare`, `optimise` and the others.

An error that rrrobot raises on purpose becomes one line on stderr and exit code 1, wrong usage
exit code 2, Ctrl-C 130; warnings are one line each on stderr. A command is the file of its name in
this folder.
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
    """A group whose commands are files beside this one, each loaded when it is first asked for.

    It turns what they raise into one line and an exit code.
    """

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        for file in (name, f"{name}_"):
            if file in _files():
                self._load(file)
        if name not in self.commands:
            # Whoever mistypes is told of all.
            self.list_commands(ctx)
        return super().get_command(ctx, name)

    def list_commands(self, ctx: click.Context) -> list[str]:
        for file in _files():
            self._load(file)
        return super().list_commands(ctx)

    def _load(self, file: str) -> None:
        module = importlib.import_module(f"rrrobot.cli.{file}")
        for item in vars(module).values():
            if isinstance(item, click.Command) and item.callback.__module__ == module.__name__:
                self.add_command(item)

    def make_context(self, *args: Any, **kwargs: Any) -> click.Context:
        try:
            return super().make_context(*args, **kwargs)
        except KeyboardInterrupt:
            raise _Interrupt("stopped.") from None

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


def _files() -> list[str]:
    """Those beside this one."""
    found = pkgutil.iter_modules(rrrobot.cli.__path__)
    return [info.name for info in found if info.name != "main" and not info.ispkg]


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
    name = ctx.invoked_subcommand
    group = ctx.command if isinstance(ctx.command, click.Group) else None
    command = group.get_command(ctx, name) if group and name else None
    return text if command is None else in_options(text, command)


def _one_line(message: object) -> str:
    return shortened(" ".join(str(message).split()))
