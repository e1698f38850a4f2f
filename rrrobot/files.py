"""Files: read within a size and a time, written whole or not at all."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import select
import stat
import tempfile
import time
from pathlib import Path
from typing import Any

from rrrobot.errors import OutputError

LARGEST = 1_000_000_000
"""Bytes of the largest file that is read."""
_PATIENCE = 10.0
_LONGEST = 60.0
"""Time for which a pipe may say nothing, and in which it has to end [s]."""


def read_bytes(path: str | Path, largest: int = LARGEST) -> bytes:
    """A file's bytes, at most so many and one; of a pipe, what comes while it is not silent.

    Raises:
        OSError: it is missing, a folder, cannot be read, or a pipe that says nothing for 10 s.
        ValueError: no file can have that name.
    """
    mode = os.stat(path).st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(21, "it is a folder")
    if stat.S_ISREG(mode):
        with open(path, "rb") as stream:
            return stream.read(largest + 1)
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    try:
        raw, until = b"", time.monotonic() + _LONGEST
        while len(raw) <= largest:
            ready, *_ = select.select([handle], [], [], _PATIENCE)
            if not ready:
                raise TimeoutError(0, f"nothing came from it for {_PATIENCE:g} s")
            if time.monotonic() > until:
                raise TimeoutError(0, f"it did not end within {_LONGEST:g} s")
            piece = os.read(handle, 1 << 20)
            if not piece:
                break
            raw += piece
        return raw
    finally:
        os.close(handle)


def read_text(path: str | Path, largest: int = LARGEST) -> str:
    """A file's text, UTF-8 with or without a mark.

    Raises:
        OSError: see `read_bytes`.
        ValueError: it is too large, or not UTF-8.
    """
    raw = read_bytes(path, largest)
    if len(raw) > largest:
        raise ValueError(f"it has more than {largest} bytes")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("it is not UTF-8 text") from None


def read_json(path: str | Path) -> Any:
    """What a JSON file holds.

    Raises:
        OSError: see `read_bytes`.
        ValueError: it is no JSON, or nested beyond all sense.
    """
    try:
        return json.loads(read_text(path))
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


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
        _clear_litter(target.parent)
        handle, name = tempfile.mkstemp(prefix=f"{_mark()}{os.getpid()}.", dir=target.parent)
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


def _mark() -> str:
    """How names of this machine's temporary files begin; the process comes next."""
    host = hashlib.sha256(platform.node().encode()).hexdigest()[:8]
    return f".rrrobot.{host}."


def _clear_litter(folder: Path) -> None:
    """Remove temporary files whose process was killed."""
    mark = _mark()
    with contextlib.suppress(OSError):
        for path in folder.glob(f"{mark}*"):
            process = path.name.removeprefix(mark).partition(".")[0]
            if process.isdecimal() and not _runs(int(process)):
                path.unlink(missing_ok=True)


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True
    return True


def _reason(error: Exception) -> object:
    return getattr(error, "strerror", None) or error
