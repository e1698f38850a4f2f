"""The gaits of a sweep by number, of grids or lists of points, and the checks of its arguments."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.gaits import Gait, GaitBatch, SinusoidalGait
from rrrobot.errors import ParameterError
from rrrobot.models.base import Model
from rrrobot.models.recombined import DecoupledModels
from rrrobot.studies.sweeps.quantities import (
    attributes,
    check_filled,
    check_whole,
    label_of,
    size_of,
)

if TYPE_CHECKING:
    import xarray as xr

Grid = float | Sequence[Any] | Array | Mapping[str, Any]
"""A number; a list or an array: a grid for all legs; a tuple, or a mapping from joint names: one
number or grid for each leg."""
_PER_LEG = ("offset", "amplitude", "phase", "winding")


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
        self._batch: GaitBatch | None = None

    @property
    def gait_sizes(self) -> dict[str, int]:
        """Dimensions of the gaits of one robot."""
        return {dim: size for dim, size in self.sizes.items() if dim not in self._of_robot}

    def add_parameters(self, parameters: Mapping[str, ArrayLike]) -> None:
        """Add dimensions of the robot; `Variants` knows whether it has such parameters."""
        for name, values in parameters.items():
            self._axis(name, values)
        self._of_robot = tuple(self.sizes)

    @property
    def steps(self) -> int:
        """Steps of a cycle that are enough for the highest harmonic of any gait."""
        if self._batch is None:
            turns = [source.values for source in self._sources["winding"]]
            order = int(max(np.abs(values).max(initial=0.0) for values in turns))
        else:
            goes_round = bool(np.any(self._batch.winding))
            order = self._batch.order if self._batch.sine.shape[1] > 1 or goes_round else 0
        return 8 + 8 * order if order else 10

    @property
    def offsets(self) -> Array:
        """Least and largest offset of each leg (2, legs) [rad]."""
        if self._batch is not None:
            offset = self._batch.offset
            return np.array((offset.min(axis=0), offset.max(axis=0)))
        given = [source.values for source in self._sources["offset"]]
        ends = [[f(values) for values in given] for f in (np.min, np.max)]
        return np.broadcast_to(np.asarray(ends, float), (2, len(self.legs)))

    @property
    def highest_frequency(self) -> float:
        """Of all gaits [rad/s]."""
        if self._batch is not None:
            return float(self._batch.angular_frequency.max())
        (rate,) = (source.values for source in self._sources["angular_frequency"])
        return float(np.max(rate))

    def add_points(self, points: Mapping[str, ArrayLike] | Sequence[Gait]) -> None:
        """Gaits one by one: of any kind, or arrays of numbers of sinusoidal ones."""
        if not isinstance(points, Mapping) and not all(_simple(gait) for gait in points):
            self._add_batch(GaitBatch.of(points))
            return
        given = points if isinstance(points, Mapping) else _point_arrays(points)
        allowed = (*_PER_LEG, "phase_difference", "angular_frequency")
        wrong = [repr(name) for name in given if name not in allowed]
        if wrong or not given:
            raise ParameterError(
                f"points has {', '.join(wrong) or 'no entry'}: it must map some of "
                f"{', '.join(allowed)} to arrays, or be a sequence of gaits."
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
            self.coords[name] = (dims, array, attributes(name))
            self._sources[name] = [_Source("gait", column) for column in np.atleast_2d(array.T)]

    def _add_batch(self, batch: GaitBatch) -> None:
        legs = len(self.legs)
        if batch.offset.shape[1] != legs:
            raise ParameterError(
                f"points has gaits of {batch.offset.shape[1]} legs, and the robot has {legs}."
            )
        self._batch = batch
        self.sizes["gait"] = batch.n
        self.coords["leg"] = (("leg",), np.array(self.legs), {"long_name": "leg joint"})
        order = np.arange(1, batch.sine.shape[1] + 1)
        self.coords["harmonic"] = (("harmonic",), order, {"long_name": "harmonic", "units": "1"})
        for name, values in batch._asdict().items():
            dims = (
                ("gait", "harmonic", "leg") if values.ndim == 3 else ("gait", "leg")[: values.ndim]
            )
            self.coords[name] = (dims, values, attributes(name))
        # What a gait is leaves nothing for a grid.
        for name in (*_PER_LEG, "phase_difference", "angular_frequency"):
            self._sources[name] = []

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
        if self._batch is not None:
            self.add("phase_difference", difference)
            self.add("phase", phase)
            return
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

    def add_winding(self, grid: Grid | None) -> None:
        """Add the legs' whole turns; where nobody speaks of them there are none."""
        if grid is None:
            self._sources.setdefault("winding", [_Source(None, np.array(0.0))])
        else:
            self.add("winding", grid)

    def add_start(self, model: Model, **grids: Grid | None) -> None:
        """Add roll and pitch of the start, where they are given.

        Raises:
            ParameterError: the model locks that axis, or the pitch is not within +-90 degrees.
        """
        for number, (name, grid) in enumerate(grids.items()):
            if grid is None:
                continue
            if isinstance(model, DecoupledModels) or number not in model.axes:
                raise ParameterError(
                    f"{name} is given, and the {model.name} model starts without: leave it out."
                )
            self._sources[name] = [source := self._axis(name, grid)]
            if number == 1 and np.any(np.abs(source.values) >= math.pi / 2):
                raise ParameterError(f"{name} reaches the vertical: keep within +-pi/2.")

    def starts(self, first: int, last: int) -> Array | None:
        """Roll and pitch (n, 2) [rad] in which gaits first, ..., last - 1 start; None: upright."""
        names = ("start_roll", "start_pitch")
        if not any(name in self._sources for name in names):
            return None
        place = self._place(first, last)
        tilt = np.zeros((last - first, 2))
        for k, name in enumerate(names):
            for dim, values in self._sources.get(name, ()):
                tilt[:, k] = values if dim is None else values[place[dim]]
        return tilt

    def _place(self, first: int, last: int) -> dict[str, Any]:
        """Where gaits first, ..., last - 1 of one robot are along each dimension."""
        sizes = self.gait_sizes
        along = np.unravel_index(np.arange(first, last), tuple(sizes.values())) if sizes else ()
        return dict(zip(sizes, along, strict=True))

    def add_yaw_amplitude(self, values: float | xr.DataArray) -> None:
        import xarray as xr

        name = "yaw_amplitude"
        if self._batch is not None:
            raise ParameterError("yaw_amplitude is for sinusoidal gaits: leave it out.")
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
        self.coords["yaw_model_amplitude"] = (dims, table, attributes(name))

    def gaits(self, first: int, last: int) -> tuple[GaitBatch, GaitBatch | None]:
        """Gaits first, ..., last - 1 of one robot, and those of the yaw model alone if it has."""
        place = self._place(first, last)
        if self._batch is not None:
            return self._batch.rows(place["gait"]), None

        def table(name: str, columns: int) -> Array:
            out = np.empty((last - first, columns))
            sources = self._sources[name]
            for k in range(columns):
                dim, values = sources[min(k, len(sources) - 1)]
                out[:, k] = values if dim is None else values[place[dim]]
            return out

        legs = len(self.legs)
        frequency = table("angular_frequency", 1).ravel()
        offset, amplitude, phase, winding = (table(name, legs) for name in _PER_LEG)
        gaits = GaitBatch.sinusoidal(offset, amplitude, phase, frequency, winding)
        if self._yaw is None:
            return gaits, None
        dims, values = self._yaw
        yaw = np.broadcast_to(values[tuple(place[dim] for dim in dims)], (last - first,))[:, None]
        own = np.where(np.isnan(yaw), amplitude, yaw)
        return gaits, GaitBatch.sinusoidal(offset, own, phase, frequency, winding)

    def _axis(self, quantity: str, grid: Any, leg: str = "") -> _Source:
        """Make a dimension of a grid, a scalar coordinate of a number."""
        unit = label_of(quantity)[0]
        name = f"{quantity}_{re.sub(r'[^A-Za-z0-9_]', '_', leg)}" if leg else quantity
        if name in self.coords:
            raise ParameterError(f"two grids would be called {name}: rename a joint.")
        above = 0 if quantity == "angular_frequency" else None
        size = size_of(name, grid)
        if size is None:
            value = np.array(finite(name, grid, unit, above=above))
            check_whole(quantity, value)
            self.coords[name] = ((), value, attributes(quantity, leg))
            return _Source(None, value)
        values = vector(name, grid, size, unit)
        check_filled(name, values, above)
        check_whole(quantity, values)
        self.sizes[name] = size
        self.coords[name] = ((name,), values, attributes(quantity, leg))
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
        flat = vector(label, np.ravel(values), math.prod(shape), label_of(name)[0])
        check_filled(label, flat, 0 if name == "angular_frequency" else None)
        check_whole(name, flat)
        return flat.reshape(shape)


def _simple(gait: object) -> bool:
    """Whether four numbers for each leg are a gait: a sinusoid of one frequency."""
    return isinstance(gait, SinusoidalGait) and not np.ptp(gait.angular_frequency)


def _point_arrays(gaits: Sequence[Any]) -> dict[str, Array]:
    """Points of sinusoidal gaits of one frequency each."""
    GaitBatch.of(gaits)
    names = ("offset", "amplitude", "phase")
    found = {name: np.array([getattr(gait, name) for gait in gaits]) for name in names}
    return found | {"angular_frequency": np.array([gait.angular_frequency[0] for gait in gaits])}
