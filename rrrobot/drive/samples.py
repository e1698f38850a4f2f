"""A gait from samples: a smooth curve through times and angles, from a table or a .csv file."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait, LegMotion
from rrrobot.errors import GaitError
from rrrobot.files import read_text

_CLOSED = 1e-4
"""Difference of the last sample from the first, over the largest swing, that counts as none."""
_MOST = 1_000_000
_UNITS = {"s": 1.0, "ms": 1e-3}, {"rad": 1.0, "deg": np.pi / 180, "°": np.pi / 180, "m": 1.0}
"""Of times and of angles, as heads have them in brackets, and what they are in ours."""


@serial.register("sampled")
class SampledGait(Gait):
    """The cubic spline through samples of the legs' angles: twice differentiable in time.

    A periodic gait repeats over the samples' time: the last sample must be the first again, or
    whole turns away from it, for legs that go round and round. A gait that is not periodic starts
    and ends at rest, and its legs stand still before and after.

    Args:
        time: of the samples, rising (n,) [s].
        angle: at these times (n, legs) [rad], or [m] for prismatic joints.
        periodic: whether the motion repeats.

    Raises:
        GaitError: shapes that do not match, times that do not rise, entries that are not finite,
            fewer than four samples, a periodic gait whose last sample is not its first.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> known = rr.gait("lateral")
        >>> time = np.linspace(0.0, known.period, 81)
        >>> gait = rr.SampledGait(time, known(time).angle)
        >>> bool(np.abs(gait(0.123).rate - known(0.123).rate).max() < 1e-5)
        True
    """

    def __init__(self, time: ArrayLike, angle: ArrayLike, *, periodic: bool = True) -> None:
        from scipy.interpolate import CubicSpline

        t, values = _table(time, angle)
        self.time, self.angle, self.periodic = t, values, bool(periodic)
        self.n_legs = values.shape[1]
        self._start, self._end = float(t[0]), float(t[-1])
        length = self._end - self._start
        self.period = length if periodic else None
        turns = _turns(values) if periodic else np.zeros(self.n_legs)
        self._drift = 2 * np.pi * turns / length
        swing = values - np.multiply.outer(t - t[0], self._drift)
        if periodic:
            swing[-1] = swing[0]
        spline = CubicSpline(t, swing, bc_type="periodic" if periodic else "clamped")
        self._parts = (spline, spline.derivative(), spline.derivative(2))

    def __call__(self, time: ArrayLike) -> LegMotion:
        t = np.asarray(time, dtype=float)
        since = t - self._start
        if self.period is not None:
            at = self._start + np.mod(since, self.period)
            angle, rate, acceleration = (part(at) for part in self._parts)
            angle = angle + np.multiply.outer(since, self._drift)
            return LegMotion(angle, rate + self._drift, acceleration)
        angle, rate, acceleration = (
            part(np.clip(t, self._start, self._end)) for part in self._parts
        )
        still = ((t < self._start) | (t > self._end))[..., None]
        return LegMotion(angle, np.where(still, 0.0, rate), np.where(still, 0.0, acceleration))

    @classmethod
    def from_csv(cls, path: str | Path, *, periodic: bool = True) -> SampledGait:
        """Read a table: a column of times [s], then one of angles [rad] for each leg.

        In a first row of names, units in brackets count: "time [ms]", "left [deg]". Rates and
        accelerations, such as `GaitTable.to_csv` writes, are passed over: the spline has its own.
        So are lines that begin with #.

        Raises:
            GaitError: the file cannot be read, or its numbers are no gait.
        """
        try:
            text = read_text(path)
        except (OSError, ValueError) as error:
            raise GaitError(f"cannot read the gait {str(path)!r}: {error}.") from None
        lines = [line for line in text.splitlines() if line.strip() and line.strip()[0] != "#"]
        rows = list(csv.reader(lines))
        try:
            head = [] if not rows or _is_number(rows[0][0]) else rows.pop(0)
            table = np.array([[float(cell) for cell in row] for row in rows])
            if table.ndim != 2 or table.shape[1] < 2:
                raise ValueError("it has no column of angles beside that of times")
            if head:
                table = _in_our_units(head, table)
        except ValueError as error:
            raise GaitError(
                f"the gait {str(path)!r} is no table of numbers: {error}. Each row is a time [s] "
                "and one angle [rad] for each leg, with commas between."
            ) from None
        try:
            return cls(table[:, 0], table[:, 1:], periodic=periodic)
        except GaitError as error:
            raise GaitError(f"the gait {str(path)!r}: {error}") from None

    def to_dict(self) -> dict[str, Any]:
        return {
            "type": "sampled",
            "time": self.time.tolist(),
            "angle": self.angle.tolist(),
            "periodic": self.periodic,
        }

    def __repr__(self) -> str:
        kind = "periodic" if self.periodic else "once"
        return f"SampledGait({len(self.time)} samples of {self.n_legs} legs, {kind})"


def _table(time: ArrayLike, angle: ArrayLike) -> tuple[Array, Array]:
    try:
        t, values = np.array(time, dtype=float), np.array(angle, dtype=float)
    except (TypeError, ValueError) as error:
        raise GaitError(f"time and angle must hold numbers: {error}.") from None
    if t.ndim != 1 or values.ndim != 2 or len(values) != len(t):
        raise GaitError(
            f"time has shape {t.shape} and angle {values.shape}: they must be (n,) and (n, legs)."
        )
    if not 4 <= len(t) <= _MOST:
        raise GaitError(f"there are {len(t)} samples: from 4 to {_MOST} are allowed.")
    if not (np.isfinite(t).all() and np.isfinite(values).all()):
        raise GaitError("time and angle must be finite: there is a NaN or an infinity in them.")
    step = np.diff(t)
    if not (step > 0).all():
        i = int(np.flatnonzero(step <= 0)[0])
        raise GaitError(
            f"time must rise from sample to sample: after {t[i]:g} s comes {t[i + 1]:g} s."
        )
    for array in (t, values):
        array.flags.writeable = False
    return t, values


def _turns(values: Array) -> Array:
    """Whole turns that each leg makes in a cycle (legs,)."""
    gap = values[-1] - values[0]
    turns = np.round(gap / (2 * np.pi))
    rest = np.abs(gap - 2 * np.pi * turns)
    scale = max(1.0, float(np.abs(values).max()))
    if np.any(rest > _CLOSED * scale):
        i = int(rest.argmax())
        raise GaitError(
            f"leg {i + 1} ends at {values[-1, i]:.6g}, and it began at {values[0, i]:.6g}: the "
            "last sample of a periodic gait closes the cycle, so add a row with the first angles "
            "at the time of one period, or give periodic=False."
        )
    return turns


def _in_our_units(head: list[str], table: Array) -> Array:
    """The columns of times and angles, in s, rad and m."""
    if len(head) != table.shape[1]:
        raise ValueError(f"its first row has {len(head)} names for {table.shape[1]} columns")
    kept = []
    for i, name in enumerate(head):
        unit = (re.findall(r"\[([^]]*)\]", name) or [""])[-1].strip()
        known = _UNITS[min(i, 1)]
        if unit in known or not unit:
            kept.append(table[:, i] * known.get(unit, 1.0))
        elif i == 0 or "/s" not in unit:
            raise ValueError(f"the unit of {name.strip()!r} is none of {', '.join(known)}")
    return np.column_stack(kept)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
