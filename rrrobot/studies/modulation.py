"""What follows from sweeps: phases between axes, and the leg amplitude that the yaw model needs.

The yaw model alone drifts too slowly; Fig 20 of the paper gives it larger legs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rrrobot.drive.gaits import SinusoidalGait
from rrrobot.errors import ModelError
from rrrobot.robot.robot import Robot
from rrrobot.studies.comparison import matching_yaw_amplitude

if TYPE_CHECKING:
    import xarray as xr

SMALL = 1e-3
"""Amplitude below which a phase is not known [rad]."""


def pitch_yaw_phase_difference(pitch: xr.Dataset, yaw: xr.Dataset | None = None) -> xr.DataArray:
    """Pitch phase less yaw phase in [-pi, pi), where both amplitudes are at least 0.06 deg.

    Args:
        pitch: sweep whose pitch is taken: of the full or of the pitch model.
        yaw: sweep whose yaw is taken; the same if None, for the single-axis models the yaw
            model's.
    """
    yaw = pitch if yaw is None else yaw
    found = (pitch.pitch_phase - yaw.yaw_phase + np.pi) % (2 * np.pi) - np.pi
    found = found.where((pitch.pitch_amplitude >= SMALL) & (yaw.yaw_amplitude >= SMALL))
    attrs = {"units": "rad", "long_name": "pitch phase less yaw phase"}
    return found.assign_attrs(attrs)


def amplitude_modulation(
    robot: Robot, full: xr.Dataset, *, phase_difference: float = np.pi / 2
) -> xr.DataArray:
    """Leg amplitude at which the yaw model drifts like the full model, over the offset: Fig 20.

    Args:
        robot: of the sweep, with two legs.
        full: sweep of the full model over offset and phase difference, at one amplitude and one
            frequency.
        phase_difference: taken is the grid's nearest [rad].

    Returns:
        amplitude (offset,) [rad]; NaN where the full model does not drift, or no amplitude does.
    """
    row = full.sel(phase_difference=phase_difference, method="nearest")
    found = np.full(row.sizes["offset"], np.nan)
    amplitude = float(row.amplitude)
    for i, (offset, rate) in enumerate(zip(row.offset.values, row.yaw_rate.values, strict=True)):
        if not abs(rate) > 1e-6:
            continue
        gait = SinusoidalGait(
            offset=(offset, offset),
            amplitude=amplitude,
            angular_frequency=float(row.angular_frequency),
            phase=(0.0, float(row.phase_difference)),
        )
        try:
            found[i] = amplitude * matching_yaw_amplitude(robot, gait, float(rate))
        except ModelError:
            continue
    attrs = {"units": "rad", "long_name": "leg amplitude of the yaw model"}
    return row.yaw_rate.copy(data=found).assign_attrs(attrs).rename("yaw_model_amplitude")


def filled(modulation: xr.DataArray, offset: xr.DataArray) -> xr.DataArray:
    """The result of `amplitude_modulation` at other offsets, gaps filled linearly (offset,) [rad].

    It is what `sweep` takes as `yaw_amplitude`; NaN, the gait's own amplitude, if nothing is known.
    """
    known = modulation.dropna("offset").sortby("offset")
    if not known.size:
        return offset.copy(data=np.full(offset.size, np.nan))
    return offset.copy(data=np.interp(offset, known.offset, known))
