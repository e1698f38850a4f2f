"""A store belongs to one run at a time, and a run knows whether its store is still its own.

The lock is the system's on the open file: it ends with the process, however that ends.
"""

from __future__ import annotations

import os
from io import FileIO
from pathlib import Path

from rrrobot.errors import OutputError

try:
    import fcntl
except ImportError:  # there are no such locks on Windows
    fcntl = None  # type: ignore[assignment]


def hold(stream: FileIO, path: Path) -> None:
    """Lock an open store.

    Raises:
        OutputError: another run holds it.
    """
    if fcntl is None:
        return
    try:
        fcntl.flock(stream.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OutputError(
            f"another run is writing {str(path)!r}: wait until it ends, or name another file."
        ) from None
    except OSError:
        return  # a file system without locks


def refuse_held(path: Path) -> None:
    """Raise OutputError if another run holds a file that is to be replaced."""
    try:
        with path.open("rb", buffering=0) as stream:
            hold(stream, path)
    except OutputError:
        raise
    except OSError:
        return


def refuse_replaced(stream: FileIO, path: Path) -> None:
    """Raise OutputError if the name is no longer that of the open store."""
    ours = os.fstat(stream.fileno())
    try:
        there = os.stat(path)
    except OSError:
        there = None
    if there is None or (ours.st_dev, ours.st_ino) != (there.st_dev, there.st_ino):
        what = "removed" if there is None else "replaced"
        raise OutputError(f"{str(path)!r} was {what} by another program while the sweep ran.")
