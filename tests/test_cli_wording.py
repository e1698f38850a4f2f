"""Errors and warnings of the command line name options, not arguments of Python."""

from __future__ import annotations

import click
import pytest

from rrrobot.cli.main import cli
from rrrobot.cli.sweep import sweep_command
from rrrobot.cli.wording import in_options
from tests.some import some
from tests.test_cli import run

NAMES = cli.list_commands(click.Context(cli))
EVERY = [
    (name, option)
    for name, command in sorted(cli.commands.items())
    for option in command.params
    if isinstance(option, click.Option)
]


@pytest.mark.parametrize("name", NAMES)
def test_every_option_of_every_command_is_called_by_its_flag(name):
    for _, option in (entry for entry in EVERY if entry[0] == name):
        flag = max(option.opts, key=len)
        argument = flag.lstrip("-").replace("-", "_")
        said = in_options(
            f"{argument} is 0: give {argument}=1, not '{argument}'.", cli.commands[name]
        )
        assert said == f"{flag} is 0: give {flag} 1, not '{argument}'."


def test_what_is_no_option_is_said_to_be_pythons():
    sweep = cli.commands["sweep"]
    assert in_options("Use method='kkt'.", sweep) == "Use method='kkt' (in Python)."
    assert in_options("begin anew with resume=False.", sweep) == "begin anew with --no-resume."
    for kept in ("leg_1 is a joint", "cannot read 'max_torque.json'", "ds.sel(amplitude=0.3)"):
        assert in_options(kept, cli.commands["optimise"]) == kept


CASES = [
    (("simulate", "--frequency", "0"), "--frequency is [0.0, 0.0] rad/s: it must be greater than "
     "zero; use --gait still for"),
    (("simulate", "--sample-interval", "0"), "--sample-interval is 0.0 s"),
    (("simulate", "--ramp", "0"), "--ramp is 0.0 s"),
    (("sweep", "--offset", "1", "--steps", "1"), "--steps is 1"),
    (("sweep", "--offset", "1", "--frequency", "0"), "--frequency is 0.0 rad/s"),
    (("sweep",), "--offset is missing"),
    (("optimise", "--budget", "0"), "--budget is 0"),
    (("plan", "--goal", "0,0,0", "--margin=-1"), "--margin is -1.0 m"),
    (("continue", "--in", "phase_difference", "--to", "1", "--step", "0"), "--step is 0.0"),
    (("lab", "--port", "0"), "--port is 0"),
    (("view", "--fps", "0"), "--fps is 0.0 1/s"),
    (("machines", "snakeboard", "--duration", "0"), "--duration is 0.0 s"),
    (("periods", "--leg-length=-1"), "--leg-length is -1.0 m"),
    (("compare", "--duration", "0"), "--duration is 0.0 s"),
    (("unstick", "legged:2", "--damping-ratio=-1"), "--damping-ratio is -1.0"),
]  # fmt: skip


DEFAULT = ("simulate --frequency 0", "simulate --ramp 0", "sweep", "lab --port 0")


@pytest.mark.parametrize(
    ("args", "says"), some(CASES, by_default=DEFAULT, name=lambda case: " ".join(case[0]))
)
def test_bad_numbers_are_said_by_their_options(args, says):
    result = run(*args)
    assert result.exit_code == 1
    error = result.stderr.splitlines()[-1]  # compiling may be told of before
    assert error.startswith("Error: ") and says in error


def test_warnings_too():
    result = run("simulate", "--duration", "0.1", "--leg-length", "0.2", "--json")
    assert result.stderr.startswith("Warning: --leg-length is 0.2 m")


def test_arguments_in_brackets_are_named_as_options():
    short = ("sweep", "--offset", "1", "--cycles", "8", "--damping", "0", "--quiet")
    said = run(*short).stderr
    assert "(--cycles)" in said and "(--settle orbit)" in said
    assert in_options("robot(mass=2) of a file (store=)", sweep_command) == (
        "robot(mass=2) of a file (--out)"
    )
