"""Quantities of a sweep by name: their units, and the checks of their values."""

from __future__ import annotations

from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits.base import check_turns
from rrrobot.errors import ParameterError

LABELS = {
    "offset": ("rad", "leg offset"),
    "amplitude": ("rad", "leg amplitude"),
    "phase": ("rad", "leg phase"),
    "winding": ("1", "whole turns of the legs in a period"),
    "start_roll": ("rad", "roll at the start"),
    "start_pitch": ("rad", "pitch at the start"),
    "sine": ("rad", "sine of each harmonic"),
    "cosine": ("rad", "cosine of each harmonic"),
    "phase_difference": ("rad", "leg phase difference"),
    "yaw_amplitude": ("rad", "leg amplitude of the yaw model"),
    "angular_frequency": ("rad/s", "angular frequency"),
    "leg_mass": ("kg", "mass at each leg tip"),
    "servo_mass": ("kg", "mass at each hip"),
    "battery_mass": ("kg", "mass at the bottom"),
    "shell_radius": ("m", "shell radius"),
    "leg_length": ("m", "leg length"),
    "hip_offset": ("m", "distance from the centre to each hip"),
    "gravity": ("m/s^2", "gravity"),
}


_OF_URDF = {
    "mass": ("kg", "mass"),
    "length": ("m", "distance from the parent's origin"),
    "radius": ("m", "radius"),
    "damping": ("N m s/rad", "damping"),
    "friction": ("N m", "friction"),
}


def label_of(quantity: str) -> tuple[str, str]:
    """Unit and name of a quantity, or of a parameter of a URDF such as LINK.mass."""
    owner, _, of = quantity.rpartition(".")
    if quantity in LABELS or not owner:
        return LABELS.get(quantity, ("", quantity))
    unit, name = _OF_URDF.get(of, ("kg m^2", f"inertia {of}"))
    return unit, f"{name} of {owner}"


def attributes(quantity: str, leg: str = "") -> dict[str, str]:
    """Name and unit of a coordinate."""
    unit, long_name = label_of(quantity)
    return {"long_name": f"{long_name}, {leg}" if leg else long_name, "units": unit}


def size_of(name: str, grid: Any) -> int | None:
    """Number of values of a grid; None of a number."""
    try:
        return np.size(grid) if np.ndim(grid) else None
    except ValueError:
        raise ParameterError(f"{name} is {grid!r}: its entries must be numbers.") from None


def check_whole(quantity: str, values: Array) -> None:
    """Refuse turns that are not whole."""
    if quantity == "winding":
        check_turns(quantity, values)


def check_filled(name: str, values: Array, above: float | None) -> None:
    """Refuse no values, and values that are not above a bound."""
    if not values.size:
        raise ParameterError(f"{name} is empty: give at least one value.")
    if above is not None and not np.all(values > above):
        raise ParameterError(f"{name} has the value {values.min()}: all must be above {above}.")
