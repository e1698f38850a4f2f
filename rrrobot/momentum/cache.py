# mypy: disable-error-code="no-untyped-call"
"""Where compiled code is kept, and when it is still valid.

Numba's own cache knows when the file of a function changes, and not when that of one that it calls
does; and it trusts its files. Here every entry is of one hash over all sources of this folder, and
carries a checksum: after any edit, sync or pull all is compiled anew, and a damaged file is as good
as none. Where no folder can be written, code is kept for this process alone.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import pickle
import shutil
import tempfile
import warnings
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from numba.core import caching

_FOLDER = Path(__file__).parent
_CONSTANTS = (_FOLDER.parent / "results.py",)
"""Sources of constants from outside that compiled code has."""


@cache
def engine_hash() -> str:
    """Hash of all sources of the engine; also of what a store was computed with."""
    digest = hashlib.sha256()
    for path in (*sorted(_FOLDER.glob("*.py")), *_CONSTANTS):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:32]


def _folders() -> Iterator[Path]:
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(given, "rrrobot_" + hashlib.sha256(str(_FOLDER).encode()).hexdigest()[:16])
    yield _FOLDER / "__pycache__"
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:
        return
    yield home / "rrrobot" / hashlib.sha256(str(_FOLDER).encode()).hexdigest()[:16]


@cache
def cache_folder() -> Path:
    """The first folder that can be written, or one that ends with this process."""
    for folder in _folders():
        try:
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError:
            continue
        return folder
    folder = Path(tempfile.mkdtemp(prefix="rrrobot_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    warnings.warn(
        "neither the package's folder nor the home's cache can be written: the engine is compiled "
        "anew in each process, which takes about a minute. Name a folder by NUMBA_CACHE_DIR.",
        stacklevel=2,
    )
    return folder


class _Locator(caching._CacheLocator):  # type: ignore[misc, unused-ignore]
    """Tells Numba the folder and the stamp."""

    def __init__(self, py_func: Any) -> None:
        self._line = py_func.__code__.co_firstlineno

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> _Locator:
        return cls(py_func)

    def get_cache_path(self) -> str:
        return str(cache_folder())

    def get_source_stamp(self) -> str:
        return engine_hash()

    def get_disambiguator(self) -> str:
        return str(self._line)


class _Implementation(caching.CompileResultCacheImpl):  # type: ignore[misc, unused-ignore]
    _locator_classes = [_Locator]  # type: ignore[list-item, unused-ignore]


class _File(caching.IndexDataCacheFile):  # type: ignore[misc, unused-ignore]
    """Numba's files, each sealed by a checksum over its name and content.

    Whatever is damaged, or lies under another's name, is not there.
    """

    def _load_index(self) -> Any:
        try:
            version, stamp, overloads = pickle.loads(self._opened(self._index_name))
        except Exception:  # no index, another version's, or damage, which raises almost anything
            return {}
        fresh = (version, stamp) == (self._version, self._source_stamp)
        return overloads if fresh else {}

    def _save_index(self, overloads: Any) -> None:
        whole = self._version, self._source_stamp, overloads
        self._seal(self._index_name, self._dump(whole))

    def _load_data(self, name: str) -> Any:
        return pickle.loads(self._opened(name))

    def _save_data(self, name: str, data: Any) -> None:
        self._seal(name, self._dump(data))

    def _opened(self, name: str) -> bytes:
        raw = Path(self._data_path(name)).read_bytes()
        if _digest(name, raw[32:]) != raw[:32]:
            raise OSError(f"{name} is damaged")
        return raw[32:]

    def _seal(self, name: str, raw: bytes) -> None:
        with self._open_for_write(self._data_path(name)) as stream:
            stream.write(_digest(name, raw) + raw)


def _digest(name: str, raw: bytes) -> bytes:
    return hashlib.sha256(name.encode() + b"\0" + raw).digest()


class EngineCache(caching.FunctionCache):  # type: ignore[misc, unused-ignore]
    """What `compiled` gives a function instead of Numba's cache."""

    _impl_class = _Implementation

    def __init__(self, py_func: Any) -> None:
        super().__init__(py_func)
        self._cache_file = _File(
            cache_path=self._cache_path,
            filename_base=self._impl.filename_base,
            source_stamp=engine_hash(),
        )
