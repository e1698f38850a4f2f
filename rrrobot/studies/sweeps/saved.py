"""Sweeps from files: the dataset again, checked, and the model that was swept."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rrrobot.errors import OutputError
from rrrobot.models import model_from_dict
from rrrobot.models.base import Model
from rrrobot.results import NOT_COMPUTED
from rrrobot.robot.robot import Robot
from rrrobot.studies.sweeps.netcdf import checksums

if TYPE_CHECKING:
    import xarray as xr

_CHECKSUM = "checksum"


def load_sweep(path: str | Path) -> xr.Dataset:
    """Read the dataset that `sweep(store=...)` or `rrrobot sweep --out` wrote.

    Gaits whose checksums do not fit, and those that an interrupted sweep has not reached, are NaN
    with the status -1.

    Raises:
        OutputError: the file is missing, damaged, or no sweep.

    Warns:
        UserWarning: how many gaits are damaged.

    Example:
        >>> import tempfile, numpy as np, rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     made = rr.sweep(model, offset=[1.0, 1.5], store=folder + "/two.nc")
        ...     again = rr.studies.load_sweep(folder + "/two.nc")
        >>> bool((again.speed == made.speed).all()), rr.studies.model_of(again).name
        (True, 'full')
    """
    import xarray as xr

    shown = repr(str(path))
    try:
        ds = xr.load_dataset(path, engine="scipy")
        kept, status = ds[_CHECKSUM], ds["status"]
        columns = {
            str(name): values.to_numpy().ravel()
            for name, values in ds.data_vars.items()
            if name != _CHECKSUM
        }
        json.loads(ds.attrs["model"])
    except FileNotFoundError:
        raise OutputError(f"there is no file {shown}: check the path.") from None
    except (OSError, ValueError, TypeError, KeyError, IndexError) as error:
        raise OutputError(
            f"{shown} is not the netCDF file of a sweep ({type(error).__name__})."
        ) from None
    wrong = checksums(columns) != kept.to_numpy().ravel()
    wrong &= columns["status"] != NOT_COMPUTED
    ds = ds.drop_vars(_CHECKSUM)
    if wrong.any():
        warnings.warn(
            f"{int(wrong.sum())} of {wrong.size} gaits in {shown} are damaged: their checksums do "
            "not fit. They are NaN.",
            stacklevel=2,
        )
        bad = wrong.reshape(status.shape)
        for name in columns:
            values = ds[name].to_numpy().copy()
            values[bad] = NOT_COMPUTED if name == "status" else np.nan
            ds[name] = ds[name].copy(data=values)
    return ds


def model_of(dataset: xr.Dataset) -> Model:
    """The model of a sweep, of the robot with its own parameters where they were swept.

    Raises:
        OutputError: the dataset is not of a sweep, or of a class that is not registered.
    """
    try:
        robot = Robot.from_dict(json.loads(dataset.attrs["robot"]))
        data = json.loads(dataset.attrs["model"])
        return model_from_dict(data, robot)
    except (KeyError, ValueError, TypeError) as error:
        raise OutputError(f"the dataset does not hold a sweep's model: {error}") from None
