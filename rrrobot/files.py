"""Output files that are written whole or not at all."""

from __future__ import annotations

import os
import stat
import tempfile
from pathlib import Path

from rrrobot.errors import OutputError


def check_writable(path: str | Path) -> Path:
    """Return the path if a file can be written there; meant for before a long computation.

    Raises:
        OutputError: the folder is missing or not writable, or the path is a folder.
    """
    target = Path(path)
    folder = target.parent
    if not os.path.isdir(folder):
        raise OutputError(f"cannot write {str(target)!r}: there is no folder {str(folder)!r}.")
    try:
        mode = os.stat(target).st_mode
    except FileNotFoundError:
        mode = stat.S_IFREG
    except (OSError, ValueError) as error:
        raise OutputError(f"cannot write {str(target)!r}: {_reason(error)}.") from error
    if stat.S_ISDIR(mode):
        raise OutputError(f"cannot write {str(target)!r}: it is a folder; name a file in it.")
    if not stat.S_ISREG(mode):
        raise OutputError(f"cannot write {str(target)!r}: it is a device or a pipe, not a file.")
    if not os.access(folder, os.W_OK):
        raise OutputError(f"cannot write {str(target)!r}: the folder is not writable.")
    return target


def make_folder(path: str | Path) -> Path:
    """Return the path as a folder, made with its parents if it is missing.

    Raises:
        OutputError: it cannot be made, or is a file.
    """
    folder = Path(path)
    if not str(path):
        raise OutputError("cannot make a folder without a name: name one, or '.' for this one.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise OutputError(f"cannot make the folder {str(path)!r}: {_reason(error)}.") from None
    return folder


def write_whole(path: str | Path, content: bytes) -> Path:
    """Write a file through a temporary neighbour and a rename, so that no reader sees half of it.

    Raises:
        OutputError: the file cannot be written; an earlier file of that name is untouched.
    """
    target = check_writable(path)
    name = ""
    try:
        handle, name = tempfile.mkstemp(prefix=".rrrobot.", dir=target.parent)
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(name, 0o666 & ~mask)
        os.replace(name, target)
    except OSError as error:
        raise OutputError(f"cannot write {str(target)!r}: {_reason(error)}.") from error
    finally:
        # Gone after the rename; still there after a failure or Ctrl-C.
        if name and os.path.exists(name):
            os.unlink(name)
    return target


def _reason(error: Exception) -> object:
    return getattr(error, "strerror", None) or error
