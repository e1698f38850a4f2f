"""The gaits of a sweep by number, of grids or lists of points, and the checks of its arguments."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.gaits import SinusoidalGait
from rrrobot.errors import ParameterError
from rrrobot.robot.parameters import RRRobotParameters

if TYPE_CHECKING:
    import xarray as xr

    from rrrobot.momentum.batch import Gaits

Grid = float | Sequence[Any] | Array | Mapping[str, Any]
"""A number; a list or an array: a grid for all legs; a tuple, or a mapping from joint names: one
number or grid for each leg."""
_PER_LEG = ("offset", "amplitude", "phase")
_LABELS = {
    "offset": ("rad", "leg offset"),
    "amplitude": ("rad", "leg amplitude"),
    "phase": ("rad", "leg phase"),
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


class _Source(NamedTuple):
    """Where the value of a quantity comes from."""

    dim: str | None
    """dimension along which it changes; None: it does not"""
    values: Array
    """(size of the dimension,), or ()"""


class Plan:
    """The gaits of a sweep by number; made in chunks, for a million of them are large.

    Attributes:
        sizes: dimension -> size, the robot's parameters first.
        coords: as `Layout` takes them.
    """

    def __init__(self, legs: tuple[str, ...]) -> None:
        if not legs:
            raise ParameterError("the robot has no legs, so it has no gaits to sweep over.")
        self.legs = legs
        self.sizes: dict[str, int] = {}
        self.coords: dict[str, tuple[tuple[str, ...], Any, dict[str, str]]] = {}
        self._of_robot: tuple[str, ...] = ()
        self._sources: dict[str, list[_Source]] = {}
        self._yaw: tuple[tuple[str, ...], Array] | None = None

    @property
    def gait_sizes(self) -> dict[str, int]:
        """Dimensions of the gaits of one robot."""
        return {dim: size for dim, size in self.sizes.items() if dim not in self._of_robot}

    def add_parameters(self, parameters: Mapping[str, ArrayLike]) -> None:
        known = [field.name for field in fields(RRRobotParameters)]
        for name, values in parameters.items():
            if name not in known:
                raise ParameterError(
                    f"RRRobotParameters has no {name!r}; it has {', '.join(known)}."
                )
            self._axis(name, values)
        self._of_robot = tuple(self.sizes)

    def add_points(self, points: Mapping[str, ArrayLike] | Sequence[SinusoidalGait]) -> None:
        given = points if isinstance(points, Mapping) else _point_arrays(points)
        allowed = (*_PER_LEG, "phase_difference", "angular_frequency")
        wrong = [repr(name) for name in given if name not in allowed]
        if wrong or not given:
            raise ParameterError(
                f"points has {', '.join(wrong) or 'no entry'}: it must map some of "
                f"{', '.join(allowed)} to arrays, or be a sequence of SinusoidalGait."
            )
        arrays = {name: self._table(name, values) for name, values in given.items()}
        sizes = {name: len(array) for name, array in arrays.items()}
        if len(set(sizes.values())) != 1:
            raise ParameterError(f"points has arrays of different lengths: {sizes}.")
        self.sizes["gait"] = next(iter(sizes.values()))
        for name, array in arrays.items():
            dims = ("gait", "leg")[: array.ndim]
            if array.ndim == 2:
                self.coords["leg"] = (("leg",), np.array(self.legs), {"long_name": "leg joint"})
            self.coords[name] = (dims, array, _attributes(name))
            self._sources[name] = [_Source("gait", column) for column in np.atleast_2d(array.T)]

    def add(self, name: str, grid: Grid | None, default: float | None = None) -> None:
        """Add a quantity, unless the points have it."""
        if name in self._sources:
            if grid is not None:
                raise ParameterError(f"points has {name} already: leave out {name}=.")
            return
        grid = default if grid is None else grid
        if grid is None:
            raise ParameterError(f"{name} is missing: give a number, a grid, or points=.")
        entries = self._entries(name, grid)
        if entries is None:
            self._sources[name] = [self._axis(name, grid)]
            return
        if name not in _PER_LEG:
            raise ParameterError(f"{name} is one for all legs: give a number, a list or an array.")
        self._sources[name] = [self._axis(name, entry, leg) for leg, entry in entries.items()]

    def add_phases(self, difference: Grid | None, phase: Grid | None) -> None:
        grids = {"phase_difference": difference, "phase": phase}
        given = [n for n, grid in grids.items() if grid is not None or n in self._sources]
        if len(given) > 1:
            raise ParameterError("phase and phase_difference are both given: leave out one.")
        two = len(self.legs) == 2
        name = given[0] if given else "phase_difference" if two else "phase"
        if name == "phase":
            self.add(name, phase, 0.0)
            return
        if not two:
            raise ParameterError(
                f"phase_difference is for robots with two legs, this one has {len(self.legs)}: "
                "give the phase of each leg by phase=."
            )
        self.add(name, difference, math.pi / 2)
        self._sources["phase"] = [_Source(None, np.array(0.0)), *self._sources.pop(name)]

    def add_yaw_amplitude(self, values: float | xr.DataArray) -> None:
        import xarray as xr

        name = "yaw_amplitude"
        dims: tuple[str, ...] = ()
        if not isinstance(values, xr.DataArray):
            table = np.array(finite(name, values, "rad"))
        else:
            table, dims = np.asarray(values, dtype=float), tuple(map(str, values.dims))
            sizes = dict(zip(dims, table.shape, strict=True))
            if not sizes.items() <= self.gait_sizes.items():
                raise ParameterError(
                    f"{name} has the dimensions {sizes}: they must be of the sweep's gaits, "
                    f"{self.gait_sizes}."
                )
            for dim in dims:
                if dim in values.coords and not np.array_equal(values[dim], self.coords[dim][1]):
                    raise ParameterError(f"{name} has other values of {dim} than the sweep.")
            if np.isinf(table).any():
                raise ParameterError(f"{name} has an infinite value: give numbers, or NaN.")
        self._yaw = dims, table
        self.coords["yaw_model_amplitude"] = (dims, table, _attributes(name))

    def gaits(self, first: int, last: int) -> tuple[Gaits, Array | None]:
        """Gaits first, ..., last - 1 of one robot, and yaw amplitudes, as the engine takes them."""
        from rrrobot.momentum.batch import Gaits

        sizes, number = self.gait_sizes, np.arange(first, last)
        along = np.unravel_index(number, tuple(sizes.values())) if sizes else ()
        place = dict(zip(sizes, along, strict=True))

        def table(name: str, columns: int) -> Array:
            out = np.empty((number.size, columns))
            sources = self._sources[name]
            for k in range(columns):
                dim, values = sources[min(k, len(sources) - 1)]
                out[:, k] = values if dim is None else values[place[dim]]
            return out

        legs = len(self.legs)
        frequency = table("angular_frequency", 1).ravel()
        offset, amplitude, phase = (table(name, legs) for name in _PER_LEG)
        gaits = Gaits(offset, amplitude, phase, frequency)
        if self._yaw is None:
            return gaits, None
        dims, values = self._yaw
        yaw = np.broadcast_to(values[tuple(place[dim] for dim in dims)], number.shape)[:, None]
        return gaits, np.where(np.isnan(yaw), gaits.amplitude, yaw)

    def _axis(self, quantity: str, grid: Any, leg: str = "") -> _Source:
        """Make a dimension of a grid, a scalar coordinate of a number."""
        unit = _LABELS[quantity][0]
        name = f"{quantity}_{re.sub(r'[^A-Za-z0-9_]', '_', leg)}" if leg else quantity
        if name in self.coords:
            raise ParameterError(f"two grids would be called {name}: rename a joint.")
        above = 0 if quantity == "angular_frequency" else None
        size = _size(name, grid)
        if size is None:
            value = np.array(finite(name, grid, unit, above=above))
            self.coords[name] = ((), value, _attributes(quantity, leg))
            return _Source(None, value)
        values = vector(name, grid, size, unit)
        _not_empty(name, values, above)
        self.sizes[name] = size
        self.coords[name] = ((name,), values, _attributes(quantity, leg))
        return _Source(name, values)

    def _entries(self, name: str, grid: Grid) -> dict[str, Any] | None:
        """A grid's entry for each leg; None if it is for all."""
        legs = ", ".join(self.legs)
        if isinstance(grid, Mapping):
            if set(grid) != set(self.legs):
                raise ParameterError(
                    f"{name} is given for {', '.join(map(str, grid)) or 'no leg'}: give it for "
                    f"each of {legs}."
                )
            return {leg: grid[leg] for leg in self.legs}
        if not isinstance(grid, tuple):
            return None
        if len(grid) != len(self.legs):
            raise ParameterError(
                f"{name} is a tuple of {len(grid)}: a tuple holds a number or a grid for each leg, "
                f"and the legs are {legs}. For a grid, give a list or an array."
            )
        return dict(zip(self.legs, grid, strict=True))

    def _table(self, name: str, values: ArrayLike) -> Array:
        """An array of points (n,) or (n, legs), checked."""
        legs, label = len(self.legs), f"points[{name!r}]"
        try:
            shape = np.shape(values)
        except ValueError:
            shape = ()
        if shape[1:] not in ((), (legs,)) or not shape or (shape[1:] and name not in _PER_LEG):
            rule = f"(n,) or (n, {legs})" if name in _PER_LEG else "(n,)"
            raise ParameterError(f"{label} has shape {shape}: it must be {rule}.")
        flat = vector(label, np.ravel(values), math.prod(shape), _LABELS[name][0])
        _not_empty(label, flat, 0 if name == "angular_frequency" else None)
        return flat.reshape(shape)


def _point_arrays(gaits: Sequence[SinusoidalGait]) -> dict[str, Array]:
    """Points of sinusoidal gaits."""
    for i, gait in enumerate(gaits):
        if not isinstance(gait, SinusoidalGait):
            raise ParameterError(f"points[{i}] is {gait!r}: it must be a SinusoidalGait.")
        if gait.n_legs != gaits[0].n_legs:
            raise ParameterError(
                f"points[{i}] has {gait.n_legs} legs, points[0] {gaits[0].n_legs}."
            )
        if np.ptp(gait.angular_frequency):
            raise ParameterError(
                f"points[{i}] has the frequencies {gait.angular_frequency.tolist()} rad/s: in a "
                "sweep all legs of a gait share one."
            )
    if not len(gaits):
        raise ParameterError("points is empty: give at least one gait.")
    found = {name: np.array([getattr(gait, name) for gait in gaits]) for name in _PER_LEG}
    return found | {"angular_frequency": np.array([gait.angular_frequency[0] for gait in gaits])}


def _attributes(quantity: str, leg: str = "") -> dict[str, str]:
    unit, long_name = _LABELS[quantity]
    return {"long_name": f"{long_name}, {leg}" if leg else long_name, "units": unit}


def run_settings(cycles: int, counted: int | None, steps: int) -> dict[str, int]:
    """The numbers of cycles and steps of a run, checked."""
    cycles = whole("cycles", cycles, at_least=2, at_most=100_000)
    steps = whole("steps_per_cycle", steps, at_least=4, at_most=1000)
    if counted is None:
        counted = max(2, cycles - math.ceil(cycles / 2) - 1)
    most = min(cycles, 200_000 // steps)
    counted = whole("counted", counted, at_least=2, at_most=most)
    return {"cycles": cycles, "counted": counted, "steps_per_cycle": steps}


def whole(name: str, value: object, *, at_least: int, at_most: int | None = None) -> int:
    """A whole number in a range, checked."""
    rule = f"at least {at_least}" if at_most is None else f"from {at_least} to {at_most}"
    integer = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not integer or value < at_least or (at_most is not None and value > at_most):  # type: ignore[operator]
        raise ParameterError(f"{name} is {value!r}: it must be a whole number, {rule}.")
    return int(value)  # type: ignore[call-overload]


def _size(name: str, grid: Any) -> int | None:
    """Number of values of a grid; None of a number."""
    try:
        return np.size(grid) if np.ndim(grid) else None
    except ValueError:
        raise ParameterError(f"{name} is {grid!r}: its entries must be numbers.") from None


def _not_empty(name: str, values: Array, above: float | None) -> None:
    if not values.size:
        raise ParameterError(f"{name} is empty: give at least one value.")
    if above is not None and not np.all(values > above):
        raise ParameterError(f"{name} has the value {values.min()}: all must be above {above}.")
