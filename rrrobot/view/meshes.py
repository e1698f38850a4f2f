"""Mesh files that a URDF names: where they lie, and their triangles.

A file is read in a process of its own, within a time: a damaged or hostile one can stop the
library that reads it, but not what the user computed.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array

FORMATS = (".stl", ".obj", ".dae")
_SECONDS = 60.0
_LARGEST = 500_000_000
_READ = """
import sys, numpy as np, coal
path, out, *scale = sys.argv[1:]
loaded = coal.MeshLoader().load(path, np.array(scale, dtype=float))
corners = [loaded.tri_indices(i) for i in range(loaded.num_tris)]
faces = np.array([(f[0], f[1], f[2]) for f in corners], dtype=np.int64).reshape(-1, 3)
vertices = np.array(loaded.vertices(), dtype=float).reshape(-1, 3)
np.savez(out, vertices=vertices, faces=faces)
"""


class MeshError(Exception):
    """A mesh that cannot be drawn, and why."""


def find_mesh(name: str, package_dirs: Sequence[str]) -> Path:
    """Path of a mesh named in a URDF.

    Looked for, in this order, with `package://`, `model://` or `file://` taken off:

    1. as an absolute path, or of `file://`;
    2. relative to each of the folders, the URDF file's own first;
    3. of `package://NAME/rest`, rest in a parent folder of those that is called NAME;
    4. in the folders of ROS_PACKAGE_PATH;
    5. relative to the working directory.

    Raises:
        MeshError: it is in none of them, or of a format that is not read.
    """
    if not name.lower().endswith(FORMATS):
        raise MeshError(f"{short(name)} is none of {', '.join(FORMATS)}")
    try:
        for path in _candidates(name, package_dirs):
            if path.is_file():
                return path
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise MeshError(f"{short(name)} is no file's name ({reason})") from None
    shown = ", ".join(package_dirs) or "none"
    raise MeshError(f"{short(name)} is not found (package_dirs: {shown})")


def _candidates(name: str, package_dirs: Sequence[str]) -> Iterator[Path]:
    scheme, separator, bare = name.partition("://")
    if not separator:
        bare = name
    elif scheme == "file":
        yield Path(unquote(bare))
    if not separator and Path(bare).is_absolute():
        yield Path(bare)
        return
    folders = [Path(folder) for folder in package_dirs]
    for folder in folders:
        yield folder / bare
    package, _, rest = bare.partition("/")
    if separator:
        for folder in folders:
            for parent in (folder, *folder.parents):
                if parent.name == package:
                    yield parent / rest
    for entry in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        if entry:
            yield Path(entry) / bare
            if separator and Path(entry).name == package:
                yield Path(entry) / rest
    yield Path(bare)


def read_mesh(path: Path, scale: Sequence[float]) -> tuple[Array, NDArray[Any]]:
    """Vertices (n, 3) [m] and triangles (m, 3) of a mesh file, each axis scaled.

    Raises:
        MeshError: it cannot be read, is empty, or its reader was stopped by it.
    """
    if path.stat().st_size > _LARGEST:
        raise MeshError(f"it has more than {_LARGEST} bytes")
    with tempfile.TemporaryDirectory(prefix="rrrobot") as folder:
        out = Path(folder, "mesh.npz")
        words = [sys.executable, "-c", _READ, str(path.resolve()), str(out), *map(repr, scale)]
        try:
            done = subprocess.run(words, capture_output=True, timeout=_SECONDS, check=False)
        except subprocess.TimeoutExpired:
            raise MeshError(f"reading it takes more than {_SECONDS:g} s") from None
        if done.returncode < 0:
            raise MeshError("its reader was stopped by it: the file is damaged")
        if done.returncode or not out.is_file():
            said = done.stderr.decode(errors="replace").strip().splitlines() or ["no reason given"]
            raise MeshError(said[-1][:200])
        with np.load(out) as archive:
            vertices, faces = archive["vertices"], archive["faces"]
    if not faces.size:
        raise MeshError("it has no triangles")
    if not np.all(np.isfinite(vertices)):
        raise MeshError("it has vertices that are not finite")
    return vertices, faces


def short(name: str) -> str:
    """A file's name for a message."""
    return repr(name if len(name) <= 100 else f"{name[:97]}...")
