"""What a saved trajectory must be: an archive within its size, whole arrays, plain metadata."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.robot.robot import Robot

_LARGE, _RATIO = 100_000_000, 100
"""Bytes from which an archive is suspicious that is packed to less than one part of so many."""
_TYPES: dict[str, type | tuple[type, ...]] = {
    "model": dict,
    "gait": dict,
    "integration": dict,
    "versions": dict,
    "has_contact": bool,
    "period": (int, float, type(None)),
}
_HEADER = 50_000_000
"""Bytes of the largest header; the robot's file is in it."""


def unpacked(raw: bytes, names: Sequence[str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Header and named arrays of an archive's bytes.

    Raises:
        Exception: almost any, of an archive that is damaged, hostile or none.
    """
    with np.load(io.BytesIO(raw), allow_pickle=False) as archive:
        members = archive.zip.infolist()
        whole = sum(member.file_size for member in members)
        if whole > _LARGE and whole > _RATIO * len(raw):
            raise ValueError(f"its {len(raw)} bytes would unpack to {whole}")
        if any(m.filename == "header.npy" and m.file_size > _HEADER for m in members):
            raise ValueError(f"its header has more than {_HEADER} bytes")
        header = json.loads(str(archive["header"]))
        if not isinstance(header, dict):
            raise ValueError("its header is no mapping")
        return header, {name: archive[name] for name in names}


def checked_metadata(data: Any) -> dict[str, Any]:
    """Metadata whose entries are of the types that `Trajectory` reads.

    Raises:
        ValueError: the entry, its value, and what it must be.
    """
    if not isinstance(data, dict):
        raise ValueError("its metadata is no mapping")
    for name, types in _TYPES.items():
        value = data.get(name)
        # True is an int, and is no period.
        wrong = not isinstance(value, types) or (types is not bool and isinstance(value, bool))
        if name in data and wrong:
            raise ValueError(f"its metadata has {name} = {str(value)[:60]!r}, of another type")
    period = data.get("period")
    if period is not None and not (math.isfinite(period) and period > 0):
        raise ValueError(f"its period is {period!r} s: it must be above zero")
    cut = data.get("integration", {}).get("continuous_memory")
    if cut is not None and not (isinstance(cut, int) and cut >= 0):
        raise ValueError(f"its metadata has continuous_memory = {str(cut)[:60]!r}")
    return data


def check_arrays(arrays: Mapping[str, Array], robot: Robot) -> None:
    """Raise ValueError unless all arrays have their shape and type, and finite values."""
    legs, model = robot.n_legs, robot.model
    columns = {
        "euler": 3,
        "euler_rates": 3,
        "position": 2,
        "leg_angle": legs,
        "leg_rate": legs,
        "contact_force": 3,
        "leg_torque": legs,
        "configuration": model.nq,
        "velocity": model.nv,
        "state": arrays["state"].shape[-1],
        "memory": arrays["memory"].shape[-1],
    }
    n = arrays["time"].size
    for name, array in arrays.items():
        shape = (n, columns[name]) if name in columns else (n,)
        if array.shape != shape or array.dtype != np.float64 or n == 0:
            raise ValueError(f"{name} has shape {array.shape} of {array.dtype}, not {shape}")
        if not np.all(np.isfinite(array)):
            raise ValueError(f"{name} has values that are not finite")
    if not np.all(np.diff(arrays["time"]) > 0):
        raise ValueError("time does not increase")
