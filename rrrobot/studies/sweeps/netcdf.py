"""Classic netCDF as bytes: where variables begin, how numbers stand, and their checksums."""

from __future__ import annotations

import os
import zlib
from collections.abc import Mapping
from io import FileIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 4, 6: 8}
"""Bytes of the types of classic netCDF."""


def checksums(columns: Mapping[str, NDArray[Any]]) -> NDArray[np.int32]:
    """CRC-32 of each gait's numbers, as they stand in the file (n,)."""
    rows = np.concatenate(
        [
            np.ascontiguousarray(column, on_disk(column))
            .view(np.uint8)
            .reshape(len(column), column.itemsize)
            for _, column in sorted(columns.items())
        ],
        axis=1,
    )
    found = (zlib.crc32(row) for row in rows)
    return np.fromiter(found, np.uint32, len(rows)).view(np.int32)


def on_disk(column: NDArray[Any]) -> np.dtype[Any]:
    """A column's type in the file: the same, with its first byte the highest."""
    return column.dtype.newbyteorder(">")


def begins(stream: FileIO) -> dict[str, int]:
    """Where the values of each variable begin in a classic netCDF file [bytes]."""

    def number(size: int = 4) -> int:
        return int.from_bytes(stream.read(size), "big")

    def skip(size: int) -> None:
        stream.seek(size + -size % 4, os.SEEK_CUR)

    def name() -> str:
        size = number()
        text = stream.read(size).decode()
        stream.seek(-size % 4, os.SEEK_CUR)
        return text

    def skip_attributes() -> None:
        number()
        for _ in range(number()):
            name()
            skip(_SIZES[number()] * number())

    stream.seek(8)
    number()
    for _ in range(number()):
        name(), number()
    skip_attributes()
    number()
    found = {}
    for _ in range(number()):
        variable = name()
        skip(4 * number())
        skip_attributes()
        skip(8)
        found[variable] = number(8)
    return found
