"""Gaits as files: read one of any kind, and write set-points of the joints for a real robot."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rrrobot import serial
from rrrobot.checks import Array, finite
from rrrobot.drive.gaits import Gait
from rrrobot.drive.moves import LegMoves  # noqa: F401 (so that it is registered)
from rrrobot.drive.samples import SampledGait
from rrrobot.drive.schedule import Schedule  # noqa: F401 (so that it is registered)
from rrrobot.errors import GaitError, OutputError, ParameterError
from rrrobot.files import read_json, write_whole

_MOST = 1_000_000
_FIELDS = ("positions", "velocities", "accelerations")


@dataclass(frozen=True, kw_only=True, eq=False)
class GaitTable:
    """Set-points of the joints at even times, from 0.

    Attributes:
        time: (n,) [s].
        angle, rate, acceleration: (n, legs) [rad, rad/s, rad/s^2], or [m ...] of sliding joints.
        rate_hz: set-points a second [1/s].
        joints: names of the joints (legs,).
        slides: which of them slide (legs,).
    """

    time: Array
    angle: Array
    rate: Array
    acceleration: Array
    rate_hz: float
    joints: tuple[str, ...]
    slides: tuple[bool, ...]

    @property
    def columns(self) -> dict[str, Array]:
        """Each column (n,) by its name and unit: "time [s]", "leg_1_angle [rad]", ..."""
        out = {"time [s]": self.time}
        for part, per in (("angle", ""), ("rate", "/s"), ("acceleration", "/s^2")):
            for joint, slides, values in zip(
                self.joints, self.slides, getattr(self, part).T, strict=True
            ):
                out[f"{joint}_{part} [{'m' if slides else 'rad'}{per}]"] = values
        return out

    def to_csv(self, path: str | Path) -> Path:
        """Write time, angles, rates and accelerations as a .csv file, whole or not at all.

        The head of each column has its unit: "time [s]", "leg_1_angle [rad]".

        `SampledGait.from_csv` reads the angles again, and leaves rates and accelerations.

        Raises:
            OutputError: the file cannot be written, or its name does not end in .csv.
        """
        target = _target(path, (".csv",))
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows(np.column_stack(list(self.columns.values())).tolist())
        return write_whole(target, stream.getvalue().encode())

    def to_json(self, path: str | Path) -> Path:
        """Write the same columns as a .json file: an object of lists by name and unit.

        Raises:
            OutputError: the file cannot be written, or its name does not end in .json.
        """
        target = _target(path, (".json",))
        data = {name: values.tolist() for name, values in self.columns.items()}
        return write_whole(target, (json.dumps(data, indent=1) + "\n").encode())

    def joint_trajectory(self) -> dict[str, Any]:
        """The ROS 2 message trajectory_msgs/msg/JointTrajectory, as plain data."""
        points = []
        for time, *motion in zip(self.time, self.angle, self.rate, self.acceleration, strict=True):
            point: dict[str, Any] = {
                name: part.tolist() for name, part in zip(_FIELDS, motion, strict=True)
            }
            point["effort"] = []
            nanoseconds = round(float(time) * 1e9)
            point["time_from_start"] = {
                "sec": nanoseconds // 10**9,
                "nanosec": nanoseconds % 10**9,
            }
            points.append(point)
        header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
        return {"header": header, "joint_names": list(self.joints), "points": points}

    def to_ros(self, path: str | Path) -> Path:
        """Write `joint_trajectory` as .yaml, as `ros2 topic pub` takes it, or as .json.

        Raises:
            OutputError: the file cannot be written, or its name ends otherwise.
        """
        target = _target(path, (".yaml", ".yml", ".json"))
        message = self.joint_trajectory()
        if target.suffix.lower() == ".json":
            return write_whole(target, (json.dumps(message, indent=1) + "\n").encode())
        # What JSON writes in one line is YAML's flow style.
        lines = [f"{key}: {json.dumps(message[key])}" for key in ("header", "joint_names")]
        lines.append("points:")
        for point in message["points"]:
            entries = [f"{key}: {json.dumps(value)}" for key, value in point.items()]
            lines += [f"- {entries[0]}", *(f"  {entry}" for entry in entries[1:])]
        return write_whole(target, ("\n".join(lines) + "\n").encode())


def gait_table(
    gait: Gait,
    rate: float,
    *,
    duration: float | None = None,
    joints: Sequence[str] | None = None,
    slides: Sequence[bool] | NDArray[np.bool_] | None = None,
) -> GaitTable:
    """Set-points of a gait at a rate, for a robot's joint controllers.

    Args:
        gait: any.
        rate: set-points a second [1/s]. For one period it is moved to the nearest at which the
            period has whole steps, so that the table can be played over and over; the result's
            `rate_hz` says which.
        duration: from 0 [s]; one period, both ends, unless given.
        joints: names of the joints, such as `robot.legs`; leg_1, leg_2, ... unless given.
        slides: which of them slide, so that their unit is m; none unless given.

    Raises:
        GaitError: no duration for a gait without a period.
        ParameterError: a number out of range, the wrong number of names.

    Example:
        >>> import rrrobot as rr
        >>> table = rr.gait_table(rr.gait("lateral"), rate=50.0)
        >>> table.joints, len(table.time), round(table.rate_hz, 2)
        (('leg_1', 'leg_2'), 40, 49.66)
    """
    wanted = finite("rate", rate, "1/s", above=0)
    names = tuple(joints) if joints is not None else tuple(
        f"leg_{i + 1}" for i in range(gait.n_legs)
    )  # fmt: skip
    if len(names) != gait.n_legs:
        raise ParameterError(
            f"joints are {', '.join(names) or '(none)'}: the gait moves {gait.n_legs} legs."
        )
    if duration is not None:
        length = finite("duration", duration, "s", above=0)
        steps = math.floor(length * wanted * (1 + 1e-12))
    elif gait.period is None:
        raise GaitError("the gait has no period to make a table of: give duration= in seconds.")
    else:
        steps = max(1, round(gait.period * wanted))
        wanted = steps / gait.period
    if steps >= _MOST:
        raise ParameterError(f"the table has {steps} rows: at most {_MOST} are allowed.")
    time = np.arange(steps + 1) / wanted
    angle, velocity, acceleration = gait(time)
    return GaitTable(
        time=time, angle=angle, rate=velocity, acceleration=acceleration,
        rate_hz=wanted, joints=names,
        slides=(False,) * len(names) if slides is None else tuple(bool(s) for s in slides),
    )  # fmt: skip


def write_gait(gait: Gait, path: str | Path) -> Path:
    """Write a gait as a .json file, `to_dict`; `read_gait` is the inverse.

    Raises:
        OutputError: the file cannot be written, or its name does not end in .json.
    """
    target = _target(path, (".json",))
    return write_whole(target, (json.dumps(gait.to_dict(), indent=1) + "\n").encode())


def gait_from_dict(data: Mapping[str, Any]) -> Gait:
    """The gait that `to_dict` wrote, of any registered kind; see `rrrobot.register`.

    Raises:
        GaitError: no such kind, or numbers that are missing or out of range.

    Example:
        >>> import rrrobot as rr
        >>> rr.gait_from_dict(rr.gait("lateral").to_dict()).period == rr.gait("lateral").period
        True
    """
    try:
        gait: Gait = serial.from_dict(data, Gait, "gait")  # type: ignore[type-abstract]
    except ParameterError as error:
        raise error if isinstance(error, GaitError) else GaitError(str(error)) from None
    except (TypeError, KeyError) as error:
        lacks = isinstance(error, KeyError) or "missing" in str(error)
        names = ", ".join(re.findall(r"'(\w+)'", str(error))) or str(error)
        raise GaitError(
            f"the {data['type']} gait {'lacks' if lacks else 'does not know'} the entry {names}."
        ) from None
    return gait


def read_gait(path: str | Path) -> Gait:
    """The gait of a file.

    Args:
        path: .json, what `write_gait` or `Gait.to_dict` wrote, or the result of `rrrobot
            optimise` or `plan`, whose entry "gait" is one; or .csv, a periodic `SampledGait`.

    Raises:
        GaitError: the file cannot be read, or is no gait.

    Example:
        >>> import tempfile, rrrobot as rr
        >>> from rrrobot.drive import write_gait
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     rr.read_gait(write_gait(rr.gait("lateral"), folder + "/lateral.json")).n_legs
        2
    """
    source = Path(path)
    if source.suffix.lower() == ".csv":
        return SampledGait.from_csv(source)
    try:
        data = read_json(source)
        if isinstance(data, dict) and "type" not in data and "gait" in data:
            data = data["gait"]
        made = gait_from_dict(data)
    except (OSError, ValueError, GaitError) as error:
        raise GaitError(
            f"cannot read the gait {str(path)!r}: {str(error).rstrip('.')}. It is a .json file "
            "that a gait's to_dict wrote, or a .csv table of times and angles."
        ) from None
    return made


def _target(path: str | Path, suffixes: tuple[str, ...]) -> Path:
    target = Path(path)
    if target.suffix.lower() not in suffixes:
        raise OutputError(f"cannot write {str(target)!r}: it must end in {' or '.join(suffixes)}.")
    return target
