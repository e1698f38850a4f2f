"""Messages of the package as the command line says them: options instead of Python's arguments."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import click

from rrrobot.errors import RRRobotError

ALSO = {
    "angular_frequency": "frequency",
    "phase_difference": "phase",
    "steps_per_cycle": "steps",
    "form": "belly",
    "store": "out",
    "ratio": "damping_ratio",
}
"""Python's argument -> an option of another name, for commands that have no option of its own."""

CLASSES = {"StillLegs": "--gait still"}
"""What a class of Python's is on the command line, for commands that have a gait."""

_VALUE = r"(?:'[^']*'|\"[^\"]*\"|\([^()]*\)|\[[^\]]*\]|[\w.+-]*\w)"


def in_options(message: str, command: click.Command) -> str:
    """A message in which the arguments that a command has options for are those options.

    `name=value` becomes `--name value`; a name at the beginning, and one with an underscore
    anywhere, becomes `--name`. A `name=value` that the command has no option for is left, and said
    to be Python's.

    Example:
        >>> from rrrobot.cli.simulate import simulate
        >>> in_options("angular_frequency is 0.0 rad/s: use method='kkt'.", simulate)
        '--frequency is 0.0 rad/s: use --method kkt.'
    """
    options = _options(command)

    def argument(match: re.Match[str]) -> str:
        name, value = match["name"], match["value"] or ""
        if name not in options:
            return f"{match[0]} (in Python)"
        yes, no = options[name]
        if value in ("True", "False"):
            return yes if value == "True" else no
        return f"{yes} {value.strip(chr(39) + chr(34))}".strip()

    def name(match: re.Match[str]) -> str:
        found = options.get(match[0])
        return match[0] if found is None else found[0]

    if "gait" in options:
        for kind, words in CLASSES.items():
            message = message.replace(kind, words)
    message = re.sub(
        rf"(?<![\w./'\"-])(?<!\w\()(?P<name>[a-z]\w*)=(?P<value>{_VALUE})?", argument, message
    )
    message = re.sub(r"^[a-z]\w*(?= (?:is|are|has|have|must|needs?|holds?)\b)", name, message)
    return re.sub(r"(?<![\w./'\"-])[a-z]+(?:_[a-z]+)+(?![\w.('\"=])", name, message)


def _options(command: click.Command) -> dict[str, tuple[str, str]]:
    """Python's argument -> the flags for it and against it."""
    found = {}
    for option in command.params:
        if isinstance(option, click.Option) and option.name is not None:
            yes = max(option.opts, key=len)
            flags = yes, max(option.secondary_opts, key=len, default=f"no {yes}")
            found[yes.lstrip("-").replace("-", "_")] = flags
    for argument, option_name in ALSO.items():
        if option_name in found:
            found.setdefault(argument, found[option_name])
    return found


@contextmanager
def called(names: Mapping[str, str]) -> Iterator[None]:
    """Arguments of what is done here that an option of another name gives: argument -> option.

    Example:
        >>> import rrrobot as rr
        >>> with called({"duration": "--ramp"}):
        ...     rr.RampIn(rr.gait("lateral"), 0.0)
        Traceback (most recent call last):
        rrrobot.errors.GaitError: --ramp is 0.0 s: it must be greater than zero and finite.
    """
    try:
        yield
    except RRRobotError as error:
        message = str(error)
        for argument, option in names.items():
            message = re.sub(rf"^{argument}(?= (?:is|has|must)\b)", option, message)
        raise type(error)(message) from None
