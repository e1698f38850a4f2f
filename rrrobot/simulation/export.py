"""A trajectory for other tools: xarray, pandas, CSV and MATLAB, with units, frames and words.

`Trajectory.save` keeps everything for `Trajectory.load`; these are for programs that do not know
rrrobot. Numbers are written so that they read back to the last bit.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import OutputError
from rrrobot.files import write_whole
from rrrobot.robot.joints import sliding

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from rrrobot.simulation.trajectory import Trajectory

_ANGLES = ("roll", "pitch", "yaw")
_POSE = ("base_x", "base_y", "base_z", "base_qx", "base_qy", "base_qz", "base_qw")


class Quantity(NamedTuple):
    """One array of a trajectory.

    Attributes:
        dims: after "time".
        units: SI; "leg", "leg/s" and "leg N" depend on whether a leg turns or slides.
        frame: in which the numbers are, or "".
        description: in words.
    """

    dims: tuple[str, ...]
    units: str
    frame: str
    description: str


QUANTITIES: dict[str, Quantity] = {
    "euler": Quantity(("angle",), "rad", "world", "roll, pitch, yaw of the body, without jumps"),
    "euler_rates": Quantity(("angle",), "rad/s", "world", "rates of roll, pitch, yaw"),
    "position": Quantity(("ground_axis",), "m", "ground", "contact point"),
    "leg_angle": Quantity(("leg",), "leg", "", "coordinate of each leg joint"),
    "leg_rate": Quantity(("leg",), "leg/s", "", "rate of each leg joint"),
    "contact_force": Quantity(
        ("axis",), "N", "world", "of the ground, or of the pivot, on the robot"
    ),
    "leg_torque": Quantity(("leg",), "leg N", "", "of the motor of each leg joint"),
    "energy": Quantity((), "J", "", "kinetic plus potential"),
    "normal_force": Quantity((), "N", "ground", "contact force along the ground's normal"),
    "slip": Quantity((), "m/s", "", "speed of the shell's material point at the contact"),
    "height_error": Quantity((), "m", "", "distance of the shell's lowest point from the ground"),
    "configuration": Quantity(
        ("q",),
        "m, 1, rad",
        "world",
        "Pinocchio's q: position of the base, quaternion (x, y, z, w), joints",
    ),
    "velocity": Quantity(
        ("v",), "m/s, rad/s", "base", "Pinocchio's v: linear, angular, both in the base, joints"
    ),
    "state": Quantity(("y",), "", "", "the model's own state vector; its last row goes on"),
}
"""All that goes out, besides the time [s]."""


def to_dataset(trajectory: Trajectory) -> xr.Dataset:
    """An xarray.Dataset over "time" with units, frames and descriptions as attributes.

    What made the motion (robot, model, gait, integration, versions) is in its attributes as text,
    so that it can go to netCDF.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> ds = rr.simulate(model, rr.gait("lateral"), duration=1.0).to_dataset()
        >>> ds.euler.sel(angle="yaw").attrs["units"]
        'rad'
    """
    import xarray as xr

    robot = trajectory.robot
    units = _leg_units(trajectory)
    found: dict[str, Any] = {}
    for name, quantity in QUANTITIES.items():
        texts = {"units": quantity.units, "description": quantity.description}
        if quantity.units in units:
            texts["units"] = ", ".join(dict.fromkeys(units[quantity.units])) or "1"
        if quantity.frame:
            texts["frame"] = quantity.frame
        found[name] = (("time", *quantity.dims), getattr(trajectory, name), texts)
    coords = {
        "time": ("time", trajectory.time, {"units": "s", "description": "from the start"}),
        "angle": list(_ANGLES),
        "axis": ["x", "y", "z"],
        "ground_axis": ["x", "y"],
        "leg": ("leg", np.array(robot.legs, dtype="U"), {"description": "joint of the robot"}),
    }
    return xr.Dataset(found, coords, attrs=_attributes(trajectory))


def to_pandas(trajectory: Trajectory) -> pd.DataFrame:
    """A pandas.DataFrame over the time [s], one column for each number.

    Its `attrs["units"]` has the unit of each column. The base's pose is its place [m] and
    quaternion in the world; Pinocchio's q, v and the model's state are in `to_dataset`.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> frame = rr.simulate(model, rr.gait("lateral"), duration=1.0).to_pandas()
        >>> frame.attrs["units"]["leg_1_torque"]
        'N m'
    """
    import pandas as pd

    columns = {name: values for name, _, values in table(trajectory)}
    frame = pd.DataFrame(columns, index=pd.Index(trajectory.time, name="time"))
    frame.attrs["units"] = {"time": "s"} | {name: unit for name, unit, _ in table(trajectory)}
    return frame


def to_csv(trajectory: Trajectory, path: str | Path) -> Path:
    """Write the columns of `to_pandas`, headed "name [unit]", whole or not at all.

    Raises:
        OutputError: the file cannot be written, or its name does not end in .csv.

    Example:
        >>> import tempfile, rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> t = rr.simulate(model, rr.gait("lateral"), duration=1.0)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     t.to_csv(folder + "/run.csv").read_text().split(",")[:3]
        ['time [s]', 'roll [rad]', 'pitch [rad]']
    """
    target = _target(path, ".csv", "a table")
    columns = [("time", "s", trajectory.time), *table(trajectory)]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([f"{name} [{unit}]" for name, unit, _ in columns])
    # Python's float writes itself with as many digits as bring it back.
    writer.writerows(np.column_stack([values for *_, values in columns]).tolist())
    return write_whole(target, stream.getvalue().encode())


def to_mat(trajectory: Trajectory, path: str | Path) -> Path:
    """Write all arrays as a MATLAB file (version 5), whole or not at all.

    It holds `time` and each array under its name as in `Trajectory`, samples down the rows; the
    structs `units`, `frame` and `description` with an entry for each; the legs' names `legs` as a
    cell, and what made the motion as the struct `about`. SciPy, MATLAB and Octave read it.

    Raises:
        OutputError: the file cannot be written, or its name does not end in .mat.

    Example:
        >>> import tempfile, rrrobot as rr
        >>> from scipy.io import loadmat
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> t = rr.simulate(model, rr.gait("lateral"), duration=1.0)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     str(loadmat(t.to_mat(folder + "/run.mat"))["units"]["energy"].item()[0])
        'J'
    """
    from scipy.io import savemat

    target = _target(path, ".mat", "a MATLAB file")
    ds = to_dataset(trajectory)
    data: dict[str, Any] = {"time": ds.time.to_numpy()}
    data |= {name: ds[name].to_numpy() for name in QUANTITIES}
    every = {"time": ds.time.attrs, **{name: ds[name].attrs for name in QUANTITIES}}
    for key, entry in (("units", "units"), ("frame", "frame"), ("description", "description")):
        data[key] = {name: texts.get(entry, "") for name, texts in every.items()}
    data["legs"] = np.array(trajectory.robot.legs, dtype=object)
    data["about"] = dict(ds.attrs)
    stream = io.BytesIO()
    # SciPy takes any stream, and its stubs a name only.
    savemat(stream, data, oned_as="column", do_compression=True)  # type: ignore[arg-type]
    return write_whole(target, stream.getvalue())


def table(trajectory: Trajectory) -> Iterator[tuple[str, str, Array]]:
    """Name, unit and values (n,) of each column, without the time."""
    t, units = trajectory, _leg_units(trajectory)
    for name, angle in zip(_ANGLES, t.euler.T, strict=True):
        yield name, "rad", angle
    for name, rate in zip(_ANGLES, t.euler_rates.T, strict=True):
        yield f"{name}_rate", "rad/s", rate
    for name, place in zip("xy", t.position.T, strict=True):
        yield f"contact_{name}", "m", place
    for i, leg in enumerate(t.robot.legs):
        yield f"{leg}_angle", units["leg"][i], t.leg_angle[:, i]
        yield f"{leg}_rate", units["leg/s"][i], t.leg_rate[:, i]
        yield f"{leg}_torque", units["leg N"][i], t.leg_torque[:, i]
    for name, force in zip("xyz", t.contact_force.T, strict=True):
        yield f"force_{name}", "N", force
    for name in ("energy", "normal_force", "slip", "height_error"):
        yield name, QUANTITIES[name].units, getattr(t, name)
    for i, name in enumerate(_POSE):
        yield name, "m" if i < 3 else "1", t.configuration[:, i]


def _leg_units(trajectory: Trajectory) -> dict[str, list[str]]:
    slides = sliding(trajectory.robot.model, trajectory.robot.legs)
    return {
        "leg": ["m" if s else "rad" for s in slides],
        "leg/s": ["m/s" if s else "rad/s" for s in slides],
        "leg N": ["N" if s else "N m" for s in slides],
    }


def _attributes(trajectory: Trajectory) -> dict[str, str]:
    """What made the motion, as texts."""
    robot = trajectory.robot
    made = {key: value for key, value in trajectory.metadata.items() if value is not None}
    texts = {
        key: value if isinstance(value, str) else json.dumps(value, sort_keys=True)
        for key, value in made.items()
    }
    return {
        "title": f"{robot.name}, {trajectory.model_name} model, {trajectory.time[-1]:g} s",
        "robot": robot.name,
        "robot_mass": f"{robot.mass!r} kg",
        **texts,
    }


def _target(path: str | Path, suffix: str, what: str) -> Path:
    target = Path(path)
    if target.suffix.lower() != suffix:
        raise OutputError(f"cannot write {str(target)!r}: {what}'s file ends in {suffix}.")
    return target
