"""Shapes that a URDF gives its links: their numbers and places; mesh files and their triangles.

Files are read in a process of their own, within a time: a damaged or hostile one can stop the
library that reads it, but not what the user computed.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.errors import UrdfError

FORMATS = (".stl", ".obj", ".dae")
_SECONDS = 60.0
_LARGEST = 500_000_000
_READ = """
import sys, numpy as np, coal
out, *words = sys.argv[1:]
found = {}
for i in range(0, len(words), 4):
    try:
        scale = np.array(words[i + 1 : i + 4], dtype=float)
        loaded = coal.MeshLoader().load(words[i], scale)
        corners = [loaded.tri_indices(k) for k in range(loaded.num_tris)]
        faces = np.array([(f[0], f[1], f[2]) for f in corners], dtype=np.int64).reshape(-1, 3)
        vertices = np.array(loaded.vertices(), dtype=float).reshape(-1, 3)
        found |= {f"vertices{i // 4}": vertices, f"faces{i // 4}": faces}
    except Exception as error:
        found[f"error{i // 4}"] = np.array(str(error) or type(error).__name__)
np.savez(out, **found)
"""
Mesh = tuple[Array, NDArray[Any]]
"""Vertices (n, 3) [m] and triangles (m, 3)."""


class MeshError(Exception):
    """A mesh that cannot be read, and why."""


def numbers(element: ET.Element, name: str, count: int) -> list[float]:
    """An attribute of a shape's element: so many finite numbers.

    Raises:
        UrdfError: they are not that.
    """
    text = element.get(name, "")
    try:
        found = [float(word) for word in text.split()]
    except ValueError:
        found = []
    if len(found) != count or not all(map(math.isfinite, found)):
        raise UrdfError(
            f"<{element.tag} {name}={text!r}> of a shape must be {count} finite "
            f"number{'s' * (count > 1)}."
        )
    return found


def origin_of(element: ET.Element) -> pin.SE3:
    """Where a <visual> or <collision> has its shape in its link."""
    origin = element.find("origin")
    if origin is None:
        return pin.SE3.Identity()
    xyz = numbers(origin, "xyz", 3) if origin.get("xyz") else [0.0] * 3
    rpy = numbers(origin, "rpy", 3) if origin.get("rpy") else [0.0] * 3
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(xyz))


def find_mesh(name: str, package_dirs: Sequence[str]) -> Path:
    """Path of a mesh named in a URDF.

    Looked for, in this order, with `package://`, `model://` or `file://` taken off:

    1. as an absolute path, or of `file://`;
    2. relative to each of the folders, the URDF file's own first;
    3. of `package://NAME/rest`, rest in a parent folder of those that is called NAME, then in
       the folders themselves;
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
        for folder in folders:
            yield folder / rest
    for entry in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        if entry:
            yield Path(entry) / bare
            if separator and Path(entry).name == package:
                yield Path(entry) / rest
    yield Path(bare)


def read_mesh(path: Path, scale: Sequence[float]) -> Mesh:
    """Vertices (n, 3) [m] and triangles (m, 3) of a mesh file, each axis scaled.

    Raises:
        MeshError: it cannot be read, is empty, or its reader was stopped by it.
    """
    (found,) = read_meshes([(path, scale)])
    if isinstance(found, MeshError):
        raise found
    return found


def read_meshes(wanted: Sequence[tuple[Path, Sequence[float]]]) -> list[Mesh | MeshError]:
    """Several mesh files with their scales, by one reader; of each, the mesh or what is wrong.

    Where one of them stops the reader, each is read by a reader of its own.
    """
    small = [path.stat().st_size <= _LARGEST for path, _ in wanted]
    some = [one for one, ok in zip(wanted, small, strict=True) if ok]
    read = iter(_read_together(some) if some else [])
    return [next(read) if ok else MeshError(f"it has more than {_LARGEST} bytes") for ok in small]


def _read_together(wanted: Sequence[tuple[Path, Sequence[float]]]) -> list[Mesh | MeshError]:
    with tempfile.TemporaryDirectory(prefix="rrrobot") as folder:
        out = Path(folder, "mesh.npz")
        words = [w for path, scale in wanted for w in (str(path.resolve()), *map(repr, scale))]
        command = [sys.executable, "-c", _READ, str(out), *words]
        stopped = None
        try:
            done = subprocess.run(command, capture_output=True, timeout=_SECONDS, check=False)
        except subprocess.TimeoutExpired:
            stopped = f"reading it takes more than {_SECONDS:g} s"
        else:
            if done.returncode < 0:
                stopped = "its reader was stopped by it: the file is damaged"
            elif done.returncode or not out.is_file():
                said = done.stderr.decode(errors="replace").strip().splitlines()
                stopped = (said or ["no reason given"])[-1][:200]
        if stopped is not None:
            if len(wanted) == 1:
                return [MeshError(stopped)]
            return [found for one in wanted for found in _read_together([one])]
        with np.load(out) as archive:
            return [_checked(archive, i) for i in range(len(wanted))]


def _checked(archive: Any, i: int) -> Mesh | MeshError:
    if f"error{i}" in archive:
        # Coal tells its own source file first.
        return MeshError(str(archive[f"error{i}"]).rpartition("message: ")[2][:200].strip())
    vertices, faces = archive[f"vertices{i}"], archive[f"faces{i}"]
    if not faces.size:
        return MeshError("it has no triangles")
    if not np.all(np.isfinite(vertices)):
        return MeshError("it has vertices that are not finite")
    return vertices, faces


def short(name: str) -> str:
    """A file's name for a message."""
    return repr(name if len(name) <= 100 else f"{name[:97]}...")
