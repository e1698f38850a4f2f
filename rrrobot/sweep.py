"""Sweeps: grids or lists of gaits, and of robots -> one labelled dataset of steady states.

The gaits phi_k(t) = offset_k + amplitude_k sin(omega t + phase_k) of a sweep are numbered. Chunks
of them are made, simulated by the momentum engine on threads or on any executor, and stored. A
gait's result depends on nothing but the gait, so neither the chunks nor who computes them change
a bit of it.
"""

from __future__ import annotations

import json
import math
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, fields, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.errors import GroundClearanceWarning, ModelError, ParameterError, RRRobotError
from rrrobot.gaits import SinusoidalGait
from rrrobot.models.base import Model
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.parameters import RRRobotParameters
from rrrobot.robot import Robot
from rrrobot.simulate import versions
from rrrobot.surfaces import Sphere
from rrrobot.sweep_store import NOT_COMPUTED, Layout, ResultsFile, curvature, pending
from rrrobot.urdf import LEGS
from rrrobot.urdf_reader import parse_urdf

if TYPE_CHECKING:
    import xarray as xr

    from rrrobot.momentum.batch import Gaits

Grid = float | Sequence[Any] | Array | Mapping[str, Any]
"""A number; a list or an array: a grid for all legs; a tuple, or a mapping from joint names: one
number or grid for each leg."""
Tell = Callable[[int], None]

AMPLITUDE, ANGULAR_FREQUENCY = 0.3, 8.0
"""The paper's, where a sweep names no other [rad], [rad/s]."""
LARGEST = 50_000_000
"""Most gaits of a sweep; their results take 7 GB."""
_CHUNK = 4096
_LANES = 16
"""Gaits that the engine takes at once: chunks are multiples of it."""
_IN_FLIGHT = 32
"""Chunks that an executor is given at once, so that a long queue takes no memory."""
_STILL = 1e-9
"""Amplitude up to which an axis has no phase [rad]."""
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


class SweepInterrupted(RRRobotError, KeyboardInterrupt):
    """Ctrl-C during a sweep; `dataset` holds what was computed, the rest of it is NaN."""

    def __init__(self, message: str, dataset: xr.Dataset) -> None:
        super().__init__(message)
        self.dataset = dataset


@dataclass(frozen=True)
class DecoupledModels:
    """The single-axis models of one robot, recombined by rolling as `rrrobot.decoupled` does.

    Args:
        robot: with a spherical shell about the root link's origin, on level ground.
        roll, pitch, yaw: the models, with other dampings than the paper's.

    Raises:
        ModelError: the robot has another shell or ground, or a model is of another robot.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> from rrrobot.sweep import DecoupledModels
        >>> models = DecoupledModels(rr.Robot.from_parameters())
        >>> round(float(rr.sweep(models, offset=np.pi / 4).yaw_rate), 5)
        0.01355
    """

    robot: Robot
    roll: RollModel | None = None
    pitch: PitchModel | None = None
    yaw: YawModel | None = None
    name = "decoupled"

    def __post_init__(self) -> None:
        for kind, cls in (("roll", RollModel), ("pitch", PitchModel), ("yaw", YawModel)):
            model = getattr(self, kind)
            if model is None:
                model = cls(self.robot)
                object.__setattr__(self, kind, model)
            if not isinstance(model, cls) or model.robot != self.robot:
                raise ModelError(f"{kind} is {model!r}: it must be a {cls.__name__} of the robot.")

    @property
    def models(self) -> tuple[RollModel, PitchModel, YawModel]:
        """The roll, the pitch and the yaw model."""
        return self.roll, self.pitch, self.yaw  # type: ignore[return-value]

    def to_dict(self) -> dict[str, Any]:
        """What the models are, as plain data for metadata."""
        return {"name": self.name} | {model.name: model.to_dict() for model in self.models}


Swept = Model | DecoupledModels


class Engine(Protocol):
    """Computes steady states: the columns `momentum.batch.RESULT` of gaits (n, N_RESULT)."""

    def __call__(
        self,
        setting: Any,
        gaits: Gaits,
        *,
        cycles: int,
        counted: int,
        steps_per_cycle: int,
        yaw_amplitude: Array | None = None,
    ) -> Array: ...


def engine_of(model: Swept) -> tuple[Engine, Any]:
    """The engine of a model, and the model in its terms.

    Raises:
        ModelError: there is none.
    """
    from rrrobot.momentum.batch import decoupled_setting, setting_of, steady_states

    if isinstance(model, DecoupledModels):
        return steady_states, decoupled_setting(model.robot, *model.models)
    if not isinstance(model, Model):
        raise ModelError(
            f"model is {model!r}: it must be a model, such as FullModel(robot), or DecoupledModels."
        )
    return steady_states, setting_of(model)


def remade(model: Swept, robot: Robot) -> Swept:
    """The same model of another robot."""
    if isinstance(model, DecoupledModels):
        return DecoupledModels(robot, *(remade(part, robot) for part in model.models))  # type: ignore[arg-type]
    return type(model)(robot, damping=model.damping)  # type: ignore[call-arg]


def sweep(
    model: Swept,
    *,
    offset: Grid | None = None,
    phase_difference: Grid | None = None,
    phase: Grid | None = None,
    amplitude: Grid | None = None,
    angular_frequency: Grid | None = None,
    yaw_amplitude: float | xr.DataArray | None = None,
    points: Mapping[str, ArrayLike] | Sequence[SinusoidalGait] | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
    cycles: int = 38,
    counted: int | None = None,
    steps_per_cycle: int = 10,
    store: str | Path | None = None,
    resume: bool = True,
    chunk: int | None = None,
    executor: Executor | None = None,
    threads: int | None = None,
    progress: bool | Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Steady states of a model under all gaits of a grid, or under a list of gaits.

    Each of the first five arguments is a number, a grid for all legs (a list or an array), or one
    number or grid for each leg (a tuple, or a mapping from joint names). Every grid becomes a
    dimension of the result, every number a coordinate.

    Args:
        model: any of the five models, or `DecoupledModels`, on a spherical shell and level
            ground.
        offset: centre of the legs' swing [rad].
        phase_difference: by which leg 2 leads leg 1, on robots with two legs [rad]; pi/2 unless
            given.
        phase: of each leg instead, on any robot [rad]; 0 unless given.
        amplitude: of the swing [rad]; 0.3 unless given.
        angular_frequency: of all legs [rad/s]; 8 unless given.
        yaw_amplitude: of the legs in the yaw model alone of `DecoupledModels`, the paper's Fig 20
            [rad]: a number, or a DataArray over some of the gaits' dimensions, such as
            `figures.maps.amplitude_modulation` gives; where it is NaN, as the other models'.
        points: gaits instead of a grid: `SinusoidalGait`s, or a mapping from the names above to
            arrays (n,) or, one column a leg, (n, legs). What it does not name may still be a grid.
        parameters: grids of `RRRobotParameters` by name, for the model of a robot that
            `Robot.from_parameters` made; the model is made anew for each value.
        cycles: simulated, from an upright impulsive start; 38 last 30 s at 8 rad/s.
        counted: cycles at the end over which means are taken; those in the second half unless
            given, as `Trajectory.steady_state` has it: the last 18 of 38.
        steps_per_cycle: of the fixed-step DOP853; 10 give the speed to 3e-7 on RRRobot.
        store: a netCDF file (.nc) that takes each chunk as it is finished. If it is there, what
            it holds of this sweep is not computed again.
        resume: False: replace that file.
        chunk: gaits computed at once; by default enough to keep every thread busy, at most 4096.
        executor: runs the chunks: threads, processes, or a Dask cluster's
            `Client.get_executor()`.
        threads: of our own, without an executor; one for each usable core unless given.
        progress: a bar on stderr with rate and time left (True), none (False), one if stderr is a
            terminal (None), or a function called with (gaits done, gaits in all).

    Returns:
        a Dataset with the variables of `sweep_store.VARIABLES` and `status`, which says why a gait
        was stopped (its results are NaN). Each variable's attributes hold its unit, the dataset's
        the model, the robot and the versions as JSON.

    Raises:
        ParameterError: a grid that is empty or not finite, a wrong number of legs, other numbers
            out of range.
        ModelError: a model that the engine does not know.
        OutputError: the store is another sweep's, or cannot be written.
        SweepInterrupted: Ctrl-C.

    Warns:
        GroundClearanceWarning: a gait swings a leg through the ground, `clearance` <= 0.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> ds = rr.sweep(model, offset=[np.pi / 4, np.pi / 2], phase_difference=[np.pi / 2])
        >>> dict(ds.sizes), round(float(ds.speed[1, 0]), 6)
        ({'offset': 2, 'phase_difference': 1}, 0.009656)
    """
    engine_of(model)
    run = _run_settings(cycles, counted, steps_per_cycle)
    threads = _cores() if threads is None else _whole("threads", threads, at_least=1)
    plan = _Plan(model.robot.legs)
    plan.add_parameters(parameters or {})
    if points is not None:
        plan.add_points(points)
    plan.add("offset", offset)
    plan.add_phases(phase_difference, phase)
    plan.add("amplitude", amplitude, AMPLITUDE)
    plan.add("angular_frequency", angular_frequency, ANGULAR_FREQUENCY)
    if yaw_amplitude is not None:
        if not isinstance(model, DecoupledModels):
            raise ParameterError("yaw_amplitude is for DecoupledModels: leave it out.")
        plan.add_yaw_amplitude(yaw_amplitude)
    variants = _Variants(model, {name: plan.coords[name][1] for name in parameters or {}})
    layout = Layout(plan.sizes, plan.coords, _attrs(model, variants.base, run))
    if layout.size > LARGEST:
        raise ParameterError(
            f"the sweep has {layout.size} gaits, the limit is {LARGEST}: make the grids coarser, "
            "or sweep in parts."
        )
    if chunk is None:
        chunk = min(_CHUNK, _LANES * math.ceil(layout.size / (4 * threads * _LANES)))
    chunk = _whole("chunk", chunk, at_least=1)
    with ExitStack() as stack:
        file = None
        if store is not None:
            file = stack.enter_context(ResultsFile(store, layout, resume=resume))
        job = _Job(plan, variants, run, layout, file)
        tell = stack.enter_context(
            _progress(progress, f"{model.name} model", layout.size, job.done)
        )
        try:
            if executor is None:
                with ThreadPoolExecutor(threads) as pool:
                    job.compute(pool, chunk, tell, threads + 1)
            else:
                job.compute(executor, chunk, tell, _IN_FLIGHT)
        except KeyboardInterrupt:
            raise job.interrupted() from None
    _warn_of_ground(job.columns["clearance"])
    return layout.dataset(job.columns)


class _Source(NamedTuple):
    """Where the value of a quantity comes from."""

    dim: str | None
    """dimension along which it changes; None: it does not"""
    values: Array
    """(size of the dimension,), or ()"""


class _Plan:
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


class _Variants:
    """The model with each combination of the swept parameters.

    Attributes:
        base: the robot's own parameters; None if it is no RRRobot.
    """

    def __init__(self, model: Swept, grids: Mapping[str, ArrayLike]) -> None:
        self._model = model
        self._grids = {name: np.atleast_1d(np.asarray(grid)) for name, grid in grids.items()}
        self._last: tuple[int, tuple[Engine, Any, Robot]] | None = None
        self.base = parameters_of(model.robot)
        if grids and self.base is None:
            raise ParameterError(
                f"parameters= are RRRobot's, and the model's robot is {model.robot!r}: make it "
                "with Robot.from_parameters."
            )
        for name, values in self._grids.items():
            for value in values.tolist():
                self._parameters({name: value})

    def at(self, number: int) -> tuple[Engine, Any, Robot]:
        """Engine, setting and robot of a combination."""
        if self._last is None or self._last[0] != number:
            model = self._model
            if self._grids:
                shape = tuple(grid.size for grid in self._grids.values())
                place = np.unravel_index(number, shape)
                pairs = zip(self._grids.items(), place, strict=True)
                values = {name: float(grid[i]) for (name, grid), i in pairs}
                model = remade(model, Robot.from_parameters(self._parameters(values)))
            self._last = number, (*engine_of(model), model.robot)
        return self._last[1]

    def _parameters(self, values: dict[str, Any]) -> RRRobotParameters:
        with warnings.catch_warnings():
            # What counts is whether a gait swings a leg through the ground.
            warnings.simplefilter("ignore", GroundClearanceWarning)
            return replace(self.base or RRRobotParameters(), **values)


def parameters_of(robot: Robot) -> RRRobotParameters | None:
    """Parameters of a robot that `Robot.from_parameters` made; None of another."""
    root = parse_urdf(robot.urdf)
    links = {element.get("name"): element for element in root.iter("link")}
    joints = {element.get("name"): element for element in root.iter("joint")}

    def number(element: Any, path: str, key: str, entry: int = 0) -> float:
        return float(element.find(path).get(key).split()[entry])

    def both(names: Sequence[str], path: str, key: str) -> Any:
        one, two = (number(links[name], path, key) for name in names)
        return one if one == two else (one, two)

    try:
        tips, servos = [f"{leg}_link" for leg in LEGS], ("servo_1", "servo_2")
        values = {
            "leg_mass": both(tips, "inertial/mass", "value"),
            "servo_mass": both(servos, "inertial/mass", "value"),
            "battery_mass": number(links["battery"], "inertial/mass", "value"),
            "shell_radius": robot.shell.radius,  # type: ignore[attr-defined]
            "leg_length": both(tips, "inertial/origin", "xyz"),
            "hip_offset": number(joints[LEGS[1]], "origin", "xyz", 1),
            "gravity": robot.gravity,
        }
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GroundClearanceWarning)
            found = RRRobotParameters(**values)
        same = Robot.from_parameters(found, ground_normal=robot.ground_normal) == robot
    except (KeyError, AttributeError, IndexError, ValueError):
        return None
    return found if same else None


class _Job:
    """What is computed of a sweep, and how the rest is.

    Attributes:
        columns: results, flat (gaits,).
    """

    def __init__(
        self,
        plan: _Plan,
        variants: _Variants,
        run: dict[str, Any],
        layout: Layout,
        file: ResultsFile | None,
    ) -> None:
        self._plan, self._variants, self._run = plan, variants, run
        self._layout, self._file = layout, file
        self.columns = layout.empty()
        if file is not None:
            file.read_into(self.columns)

    @property
    def done(self) -> int:
        """Gaits whose results are in the columns, and in the file if there is one."""
        return int(np.count_nonzero(self.columns["status"] != NOT_COMPUTED))

    def compute(self, executor: Executor, chunk: int, tell: Tell, at_once: int) -> None:
        """Run what is missing in chunks, at most `at_once` of them at a time."""
        size = math.prod(self._plan.gait_sizes.values())
        running: dict[Future[Array], tuple[int, Array]] = {}
        try:
            for first, last in pending(self.columns["status"], size, chunk):
                engine, setting, robot = self._variants.at(first // size)
                gaits, yaw = self._plan.gaits(first % size, (last - 1) % size + 1)
                more: dict[str, Any] = {} if yaw is None else {"yaw_amplitude": yaw}
                future = executor.submit(partial(engine, setting, gaits, **self._run, **more))
                running[future] = first, clearance(robot, gaits)
                while len(running) >= at_once:
                    self._collect(running, tell)
            while running:
                self._collect(running, tell)
        except BaseException:
            self._stop(running)
            raise

    def interrupted(self) -> SweepInterrupted:
        """The error of a Ctrl-C."""
        kept = "the error's .dataset holds them."
        if self._file is not None:
            kept = f"{str(self._file.path)!r} keeps them, and the same sweep goes on from there."
        return SweepInterrupted(
            f"the sweep was interrupted after {self.done} of {self._layout.size} gaits; {kept}",
            self._layout.dataset(self.columns),
        )

    def _collect(self, running: dict[Future[Array], tuple[int, Array]], tell: Tell) -> None:
        """Wait for a chunk, and keep all that are finished."""
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            first, height = running.pop(future)
            self._keep(first, future.result(), height)
        tell(self.done)

    def _stop(self, running: dict[Future[Array], tuple[int, Array]]) -> None:
        """Call off what waits, and keep what is finished or under way."""
        for future in wait([future for future in running if not future.cancel()]).done:
            if future.exception() is None:
                first, height = running[future]
                self._keep(first, future.result(), height)

    def _keep(self, first: int, result: Array, height: Array) -> None:
        from rrrobot.momentum.batch import RESULT

        found = dict(zip(RESULT, result.T, strict=True))
        found["clearance"] = height
        found["curvature"] = curvature(found["speed"], found["yaw_rate"])
        turn = found["yaw_phase"] - found["pitch_phase"] + np.pi
        swings = (found["pitch_amplitude"] > _STILL) & (found["yaw_amplitude"] > _STILL)
        turn = np.where(swings, -(turn % (2 * np.pi) - np.pi), np.nan)
        found["pitch_yaw_phase_difference"] = turn
        part = {name: found[name].astype(column.dtype) for name, column in self.columns.items()}
        if self._file is not None:
            self._file.write(first, part)
        for name, column in self.columns.items():
            column[first : first + len(result)] = part[name]


def clearance(robot: Robot, gaits: Gaits) -> Array:
    """Least height of the legs' centres of mass over the ground in a swing (n,) [m].

    The body is upright. On RRRobot these are the leg tips, at r + l sin(phi). NaN where a leg hangs
    on another leg, or a joint slides.
    """
    from rrrobot.momentum.coefficients import tree_of

    tree, lowest = tree_of(robot), np.full(len(gaits.offset), np.inf)
    if not isinstance(robot.shell, Sphere) or tree.parent[1:].any() or tree.prismatic.any():
        return np.full_like(lowest, np.nan)
    for i in range(1, tree.mass.size):
        # Rodrigues' formula: the height is fixed + c cos(phi) + s sin(phi).
        up, axis, lever = tree.rotation[i, 2], tree.axis[i], tree.lever[i]
        along = axis * (axis @ lever)
        c, s = up @ (lever - along), up @ np.cross(axis, lever)
        fixed = tree.translation[0, 2] + tree.translation[i, 2] + up @ along
        # From the lowest angle to the swing's centre, and to the nearest angle of the swing.
        turn = gaits.offset[:, tree.leg[i]] - math.atan2(-s, -c)
        away = np.abs((turn + np.pi) % (2 * np.pi) - np.pi)
        nearest = np.maximum(away - np.abs(gaits.amplitude[:, tree.leg[i]]), 0.0)
        lowest = np.minimum(lowest, fixed - math.hypot(c, s) * np.cos(nearest))
    return robot.shell.radius + lowest


def _warn_of_ground(heights: Array) -> None:
    touching = np.count_nonzero(heights <= 0)
    if touching:
        warnings.warn(
            f"{touching} of {heights.size} gaits swing a leg through the ground, which the models "
            "know nothing of; their 'clearance' is zero or less.",
            GroundClearanceWarning,
            stacklevel=3,
        )


def _attrs(model: Swept, base: RRRobotParameters | None, run: dict[str, int]) -> dict[str, Any]:
    """What a dataset says of itself."""
    from llvmlite import binding  # type: ignore[import-untyped, unused-ignore]

    used = versions() | {name: version(name) for name in ("numba", "xarray")}
    return {
        "title": f"steady states of gaits: {model.name} model of {model.robot.name}",
        "Conventions": "CF-1.8",
        "model": json.dumps(model.to_dict()),
        "parameters": json.dumps(None if base is None else base.to_dict()),
        "robot": json.dumps(model.robot.to_dict()),
        **run,
        "versions": json.dumps(used | {"cpu": binding.get_host_cpu_name()}),
    }


def _attributes(quantity: str, leg: str = "") -> dict[str, str]:
    unit, long_name = _LABELS[quantity]
    return {"long_name": f"{long_name}, {leg}" if leg else long_name, "units": unit}


def _run_settings(cycles: int, counted: int | None, steps: int) -> dict[str, int]:
    cycles = _whole("cycles", cycles, at_least=2, at_most=100_000)
    steps = _whole("steps_per_cycle", steps, at_least=4, at_most=1000)
    if counted is None:
        counted = max(2, cycles - math.ceil(cycles / 2) - 1)
    most = min(cycles, 200_000 // steps)
    counted = _whole("counted", counted, at_least=2, at_most=most)
    return {"cycles": cycles, "counted": counted, "steps_per_cycle": steps}


def _whole(name: str, value: object, *, at_least: int, at_most: int | None = None) -> int:
    rule = f"at least {at_least}" if at_most is None else f"from {at_least} to {at_most}"
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not whole or value < at_least or (at_most is not None and value > at_most):  # type: ignore[operator]
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


def _cores() -> int:
    usable = getattr(os, "sched_getaffinity", None)
    return len(usable(0)) if usable else os.cpu_count() or 1


@contextmanager
def _progress(
    wish: bool | Callable[[int, int], None] | None, what: str, total: int, done: int
) -> Iterator[Tell]:
    """A function that is told the number of gaits done."""
    if callable(wish):
        wish(done, total)
        yield lambda now: wish(now, total)
        return
    if not (sys.stderr.isatty() if wish is None else wish):
        yield lambda now: None
        return
    from tqdm import tqdm

    with tqdm(
        total=total,
        initial=done,
        desc=what,
        unit=" gaits",
        unit_scale=total > 10_000,
        delay=1.0 if wish is None else 0.0,
        leave=bool(wish),
        file=sys.stderr,
    ) as bar:
        yield lambda now: bar.update(now - bar.n)
