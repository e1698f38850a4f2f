"""The command `rrrobot`, also as `python -m rrrobot`: whatever happens, one line and an exit code.

Nothing but this loads before it, so that Ctrl-C while the others load is one line too.
"""

from __future__ import annotations

import os
import sys
from typing import NoReturn

INTERRUPTED = 130
_LONGEST = 300


def main() -> NoReturn:
    """Run the command line.

    Set RRROBOT_TRACEBACK=1 to see where an error that nobody expected comes from.
    """
    # What the terminal cannot show is written as an escape.
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        from rrrobot.cli.main import cli

        cli(prog_name="rrrobot", standalone_mode=True)
        code: object = 0
    except SystemExit as end:
        code = end.code
    except KeyboardInterrupt:
        code = _say("Interrupted: stopped.", INTERRUPTED)
    except Exception as error:
        if os.environ.get("RRROBOT_TRACEBACK"):
            raise
        code = _say(f"Error: {_described(error)}", 1)
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:
        _drop_output()
        code = _say(f"Error: cannot write standard output: {error.strerror or error}.", 1)
    raise SystemExit(code)


def _described(error: Exception) -> str:
    text = " ".join(str(error).split())
    text = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
    if isinstance(error, OSError) and error.filename is None:
        # Every file that rrrobot opens is named in an error of its own.
        _drop_output()
        return f"cannot write standard output: {error.strerror or text}."
    if isinstance(error, OSError | MemoryError | ImportError):
        return f"{text or type(error).__name__}."
    return (
        f"{type(error).__name__}: {text or 'no reason given'}. Nobody expected this: please "
        "report it; RRROBOT_TRACEBACK=1 shows where it comes from."
    )


def _drop_output() -> None:
    """What is left in the buffer goes nowhere, so that the interpreter's end stays silent."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    except OSError:
        sys.stdout = None


def _say(line: str, code: int) -> int:
    try:
        print(line, file=sys.stderr)
    except OSError:
        return code
    return code


if __name__ == "__main__":
    main()
