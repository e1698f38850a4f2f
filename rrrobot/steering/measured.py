"""A measured run: poses and leg angles at increasing times, from arrays or a table."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import OutputError, ParameterError
from rrrobot.files import read_text

COLUMNS = ("time", "x", "y", "yaw", "leg_1", "leg_2")
"""Of a run's table [s, m, m, rad, rad, rad]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredRun:
    """Poses and leg angles of a run that starts at rest.

    Attributes:
        time: increasing (n,) [s].
        pose: contact point and yaw (n, 3) [m, m, rad]; the yaw may jump by whole turns.
        leg_angle: (n, 2) [rad].

    Raises:
        ParameterError: arrays that do not fit, are not finite, or times that do not increase.
    """

    time: Array
    pose: Array
    leg_angle: Array

    def __post_init__(self) -> None:
        n = np.size(self.time)
        for name, shape in (("time", (n,)), ("pose", (n, 3)), ("leg_angle", (n, 2))):
            array = np.array(getattr(self, name), dtype=float)
            if array.shape != shape or n < 10 or not np.all(np.isfinite(array)):
                raise ParameterError(
                    f"{name} has the shape {array.shape}: it must be {shape}, finite, of at least "
                    "10 samples."
                )
            object.__setattr__(self, name, array)
        if np.any(np.diff(self.time) <= 0):
            raise ParameterError("time must increase from sample to sample.")
        self.pose[:, 2] = np.unwrap(self.pose[:, 2])

    def first(self, share: float) -> MeasuredRun:
        """The first part of it."""
        n = max(10, int(share * self.time.size))
        return MeasuredRun(time=self.time[:n], pose=self.pose[:n], leg_angle=self.leg_angle[:n])

    @classmethod
    def from_csv(cls, path: str | Path) -> MeasuredRun:
        """Read a table with the columns time, x, y, yaw, leg_1, leg_2; more are left alone.

        Raises:
            OutputError: it cannot be read, or lacks one of them.
        """
        try:
            rows = list(csv.reader(io.StringIO(read_text(path), newline="")))
            head = [name.split("[")[0].strip() for name in rows[0]]
            missing = [name for name in COLUMNS if name not in head]
            if missing:
                raise ValueError(f"it lacks the columns {', '.join(missing)}")
            table = np.array([[float(row[head.index(c)]) for c in COLUMNS] for row in rows[1:]])
        except (OSError, ValueError, IndexError) as error:
            raise OutputError(
                f"cannot read the run {str(path)!r}: {str(error).rstrip('.')}. It needs the "
                f"columns {', '.join(COLUMNS)} in s, m and rad."
            ) from None
        return cls(time=table[:, 0], pose=table[:, 1:4], leg_angle=table[:, 4:])
