"""The results of a sweep: a labelled dataset, and a netCDF file that is readable at every instant.

The file is classic netCDF with 64-bit offsets, which is laid out once, whole, and then never grows:
first every gait is marked "not computed", then each chunk of results is written into its place,
values before marks. So whatever stops the process leaves a valid file with exactly the chunks that
were finished, and a disk that is too small is noticed at the start.
"""

from __future__ import annotations

import json
import math
import os
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.errors import OutputError
from rrrobot.files import check_writable, write_whole
from rrrobot.results import COLUMNS, NOT_COMPUTED, STATUS, names
from rrrobot.studies.sweeps.hold import hold, refuse_held, refuse_replaced
from rrrobot.studies.sweeps.netcdf import begins, checksums, on_disk

if TYPE_CHECKING:
    import xarray as xr

_CHECKSUM = "checksum"
"""Variable of the file alone: CRC-32 of each gait's numbers, its status among them."""
_BITS = ("rrrobot", "numpy", "numba", "pinocchio", "cpu", "engine")
"""Of the versions, those that the last bits of a result depend on."""
_SHOWN = 60


class Layout(NamedTuple):
    """Everything of a dataset but its results."""

    sizes: dict[str, int]
    """dimension -> size, in order"""
    coords: dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]
    """name -> (dimensions, values, attributes)"""
    attrs: dict[str, Any]
    """numbers and JSON text; `loads` says whether those are among the variables"""

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of the variables but the status."""
        return names(loads=bool(self.attrs.get("loads")))

    @property
    def size(self) -> int:
        """Number of gaits."""
        return math.prod(self.sizes.values())

    def dataset(self, columns: Mapping[str, NDArray[Any]]) -> xr.Dataset:
        """The dataset of flat columns (size,), which are not copied."""
        import xarray as xr

        shape = tuple(self.sizes.values())
        variables = {
            name: (tuple(self.sizes), column.reshape(shape), _attributes(name))
            for name, column in columns.items()
        }
        return xr.Dataset(variables, self.coords, self.attrs)

    def empty(self, *, virtual: bool = False) -> dict[str, NDArray[Any]]:
        """Columns of a sweep of which nothing is computed.

        Args:
            virtual: read-only columns that take no memory.
        """
        blank: dict[str, Any] = dict.fromkeys(self.variables, np.array(np.nan))
        blank["status"] = np.array(NOT_COMPUTED, dtype=np.int8)
        make = np.broadcast_to if virtual else lambda value, size: np.full(size, value)
        return {name: make(value, self.size) for name, value in blank.items()}


def _attributes(name: str) -> dict[str, Any]:
    if name == "status":
        return {
            "long_name": "whether and why a gait was stopped",
            "flag_values": np.array(list(STATUS), dtype=np.int8),
            "flag_meanings": " ".join(STATUS.values()),
        }
    return {"long_name": COLUMNS[name].text, "units": COLUMNS[name].unit}


class ResultsFile:
    """The netCDF file of one sweep.

    Use it in a `with` statement.

    Args:
        path: ends in .nc; made if it does not exist.
        layout: of the sweep.
        resume: go on with an existing file; otherwise replace it.

    Raises:
        OutputError: no place to write, no space, another sweep's file, or another run's now.
    """

    def __init__(self, path: str | Path, layout: Layout, *, resume: bool = True) -> None:
        self.path = Path(path)
        self.layout = layout
        if self.path.suffix != ".nc":
            raise OutputError(f"cannot write {str(path)!r}: a sweep is stored as netCDF, .nc.")
        if resume and self.path.exists():
            self._refuse_others()
        else:
            refuse_held(self.path)
            blank = layout.dataset(layout.empty(virtual=True))
            blank[_CHECKSUM] = tuple(layout.sizes), np.zeros(tuple(layout.sizes.values()), np.int32)
            content: Any = blank.to_netcdf(engine="scipy", format="NETCDF3_64BIT")
            write_whole(self.path, content)
        check_writable(self.path)
        try:
            self._stream = self.path.open("r+b", buffering=0)
        except OSError as error:
            raise self._failure(error) from error
        try:
            hold(self._stream, self.path)
        except OutputError:
            self._stream.close()
            raise
        try:
            self._begin = begins(self._stream)
            missing = {*layout.empty(virtual=True), _CHECKSUM} - self._begin.keys()
            if missing:
                raise ValueError(", ".join(sorted(missing)))
        except (OSError, ValueError, KeyError, OverflowError) as error:
            self._stream.close()
            raise OutputError(
                f"the head of {str(self.path)!r} is damaged ({type(error).__name__}). Name another "
                "file, or begin anew with resume=False."
            ) from None

    def __enter__(self) -> ResultsFile:
        return self

    def __exit__(self, *_: object) -> None:
        self._stream.close()

    def read_into(self, columns: Mapping[str, NDArray[Any]]) -> None:
        """Fill columns with what the file holds; a gait whose checksum is wrong is not computed.

        Warns:
            UserWarning: how many gaits are damaged.

        Raises:
            OutputError: the file ends too early.
        """
        for name, column in columns.items():
            column[:] = self._get(name, column)
        status = columns["status"]
        done = np.flatnonzero(status != NOT_COMPUTED)
        kept = self._get(_CHECKSUM, np.empty(status.size, np.int32))
        wrong = kept[done] != checksums({name: column[done] for name, column in columns.items()})
        bad = done[wrong | ~np.isin(status[done], list(STATUS))]
        if bad.size:
            for name, column in columns.items():
                column[bad] = NOT_COMPUTED if name == "status" else np.nan
            warnings.warn(
                f"{bad.size} of {done.size} gaits in {str(self.path)!r} are damaged: their "
                "checksums do not fit. They are computed again.",
                stacklevel=2,
            )

    def _get(self, name: str, column: NDArray[Any]) -> NDArray[Any]:
        self._stream.seek(self._begin[name])
        found = np.fromfile(self._stream, on_disk(column), column.size)
        if found.size != column.size:
            raise OutputError(f"{str(self.path)!r} ends within {name}: it is not whole; delete it.")
        return found

    def write(self, first: int, columns: Mapping[str, NDArray[Any]]) -> None:
        """Put a chunk's columns (n,) into the places first, first + 1, ...; status last.

        Raises:
            OutputError: the file cannot be written, or another has taken its place.
        """
        refuse_replaced(self._stream, self.path)
        try:
            for name, column in columns.items():
                if name != "status":
                    self._put(name, first, column)
            self._put(_CHECKSUM, first, checksums(columns))
            os.fsync(self._stream.fileno())
            self._put("status", first, columns["status"])
            os.fsync(self._stream.fileno())
        except OSError as error:
            raise self._failure(error) from error

    def _put(self, name: str, first: int, column: NDArray[Any]) -> None:
        kind = on_disk(column)
        self._stream.seek(self._begin[name] + first * kind.itemsize)
        rest = memoryview(column.astype(kind).tobytes())
        while rest:
            rest = rest[self._stream.write(rest) :]

    def _failure(self, error: OSError) -> OutputError:
        return OutputError(f"cannot write {str(self.path)!r}: {error.strerror or error}.")

    def _refuse_others(self) -> None:
        """Raise OutputError unless the file is of this sweep."""
        import xarray as xr

        shown = repr(str(self.path))
        try:
            with xr.open_dataset(self.path, engine="scipy") as found:
                differ = list(_differences(found, self.layout))
                if _CHECKSUM not in found:
                    differ.append("its variables: it has no checksums")
        except (OSError, ValueError, TypeError, KeyError, IndexError) as error:
            raise OutputError(
                f"{shown} is not the netCDF file of a sweep ({type(error).__name__}). Name another "
                "file, or delete it."
            ) from None
        if differ:
            more = f", and {len(differ) - 5} more" if len(differ) > 5 else ""
            raise OutputError(
                f"{shown} holds another sweep. It differs in {'; '.join(differ[:5])}{more}. Name "
                "another file, or begin anew with resume=False."
            )


def _differences(found: xr.Dataset, layout: Layout) -> Iterator[str]:
    """How another file's sweep differs from this one, in words."""
    ours = layout.dataset(layout.empty(virtual=True))
    for name in layout.attrs:
        if name not in ("title", "Conventions"):
            there, here = (_plain(ds.attrs.get(name)) for ds in (found, ours))
            yield from _unequal(name, there, here)
    sizes = {str(dim): size for dim, size in found["status"].sizes.items()}
    if list(sizes.items()) != list(layout.sizes.items()):
        yield f"its dimensions ({_shown(sizes)} there, {_shown(layout.sizes)} here)"
        return
    for coord in sorted(map(str, found.coords.keys() | ours.coords.keys())):
        if (coord in found.coords) != (coord in ours.coords):
            yield f"{coord} (only {'there' if coord in found.coords else 'here'})"
            continue
        a, b = (np.asarray(ds[coord]) for ds in (found, ours))
        if a.shape != b.shape or not np.all((a == b) | ((a != a) & (b != b))):
            yield f"{coord} ({_shown(a.tolist())} there, {_shown(b.tolist())} here)"
    if missing := sorted(map(str, ours.data_vars.keys() - found.data_vars.keys())):
        yield f"its variables: it has no {', '.join(missing)}"


def _unequal(name: str, there: Any, here: Any) -> Iterator[str]:
    if isinstance(there, dict) and isinstance(here, dict):
        for key in _BITS if name == "versions" else sorted(there.keys() | here.keys()):
            if name == "robot" and key == "package_dirs":
                continue  # where the meshes lie is no part of what a robot is
            yield from _unequal(f"{name}.{key}", there.get(key), here.get(key))
    elif there != here:
        yield f"{name} ({_shown(there)} there, {_shown(here)} here)"


def _plain(value: Any) -> Any:
    """An attribute's value: JSON text as what it stands for."""
    if isinstance(value, str):
        try:
            return json.loads(value)
        except ValueError:
            return value
    return value.item() if isinstance(value, np.generic) else value


def _shown(value: Any) -> str:
    text = "nothing" if value is None else str(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def pending(status: NDArray[np.int8], block: int, chunk: int) -> Iterator[tuple[int, int]]:
    """Runs first, ..., last - 1 of gaits that are not computed.

    Args:
        status: (n,).
        block: no run reaches over a multiple of it.
        chunk: longest run.
    """
    todo = np.flatnonzero(np.diff(np.pad(status == NOT_COMPUTED, 1).astype(np.int8)))
    for first, last in todo.reshape(-1, 2).tolist():
        while first < last:
            end = min(last, first + chunk, (first // block + 1) * block)
            yield first, end
            first = end
