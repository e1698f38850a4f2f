"""Sphinx: `{cli}` is the help of the command line, of every command of the group."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import click
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from rrrobot.cli.main import cli


def helps(
    command: click.Command = cli, name: str = "rrrobot"
) -> Iterator[tuple[str, str]]:
    """(command, its help) of a command and all below it."""
    context = click.Context(
        command, info_name=name, max_content_width=80, terminal_width=80
    )
    yield name, command.get_help(context)
    if isinstance(command, click.Group):
        for below in command.list_commands(context):
            found = command.get_command(context, below)
            if found is not None and not found.hidden:
                yield from helps(found, f"{name} {below}")


class _Cli(SphinxDirective):
    """The help of every command, a section each."""

    def run(self) -> list[nodes.Node]:
        out: list[nodes.Node] = []
        for name, text in helps():
            section = nodes.section(ids=[nodes.make_id(name)], names=[name])
            section += nodes.title("", "", nodes.literal(text=name))
            block = nodes.literal_block(text, text, language="text")
            block["classes"].append("help")
            section += block
            self.state.document.note_explicit_target(section, section)
            out.append(section)
        return out


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to Sphinx."""
    app.add_directive("cli", _Cli)
    return {"version": "1", "parallel_read_safe": True}
