"""A group of options: a frozen dataclass, and the decorator that fills it for a command.

@dataclass(frozen=True, kw_only=True)
class Run(Group):
    duration: float = option("--duration", type=NUMBER, default="30", help="[s]")

@click.command()
@takes(run=Run)
def simulate(run: Run) -> None: ...
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Any

import click


def option(*flags: str, **attributes: Any) -> Any:
    """A field of a group: flags and attributes as `click.option` takes them."""
    return field(metadata={"flags": flags, "attributes": attributes})


@dataclass(frozen=True, kw_only=True)
class Group:
    """What the groups have in common."""

    def given(self, *names: str) -> dict[str, Any]:
        """Those of the named options that the command line gave, by name."""
        every = {name: getattr(self, name) for name in names}
        return {name: value for name, value in every.items() if value is not None and value != ()}

    def refuse(self, names: tuple[str, ...], why: str) -> None:
        """Refuse options where they mean nothing.

        Raises:
            click.UsageError: one of them was given.
        """
        found = [f"--{name.replace('_', '-')}" for name in self.given(*names)]
        if found:
            raise click.UsageError(f"{', '.join(found)}: such options {why}.")


def takes(**groups: type[Group]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Give a command the options of groups, and its function one argument for each group.

    Args:
        **groups: argument's name -> dataclass, in the order of --help.
    """

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(command)
        def call(**values: Any) -> Any:
            made = {
                key: group(**{f.name: values.pop(f.name) for f in fields(group)})
                for key, group in groups.items()
            }
            return command(**made, **values)

        every = [f for group in groups.values() for f in fields(group)]
        for f in reversed(every):
            call = click.option(*f.metadata["flags"], f.name, **f.metadata["attributes"])(call)
        return call

    return decorate
