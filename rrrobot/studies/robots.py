"""Sweeps and searches over the parameters of any robot, by the names of its file or by a function.

Each combination is a model of its own, made anew; what is then asked of it is a sweep, an optimum,
a limit cycle or any function.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite
from rrrobot.errors import ModelError, ParameterError, RRRobotError
from rrrobot.models.base import Model
from rrrobot.robot.variation import varied
from rrrobot.studies.sweeps.run import sweep

if TYPE_CHECKING:
    import xarray as xr

Make = Callable[..., Model]
"""Makes a model of the parameters' values, which it takes by their names."""


def robots_of(
    model: Model, parameters: Mapping[str, ArrayLike], make: Make | None = None
) -> list[tuple[dict[str, float], Model]]:
    """The model with each combination of parameters, the last of them changing fastest.

    Args:
        model: of a robot from a URDF.
        parameters: name -> values; names as `robot.varied` takes them, or those of `make`.
        make: of the values by name, for parameters that no file has; it may change the ground,
            the damping or the pose of the shell as well.

    Raises:
        ParameterError: no values, or a name that the robot lacks.
        ModelError: `make` gave no model.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_urdf(rr.urdf_path("rrrobot"), shell=rr.Sphere(0.12))
        >>> made = rr.studies.robots_of(rr.FullModel(robot), {"leg_1_link.mass": [0.05, 0.06]})
        >>> [round(m.robot.mass, 3) for _, m in made]
        [0.513, 0.523]
    """
    if not parameters:
        raise ParameterError("parameters is empty: name at least one.")
    grids = {
        name: np.atleast_1d(np.asarray(grid, dtype=float)) for name, grid in parameters.items()
    }
    for name, grid in grids.items():
        if grid.ndim != 1 or not grid.size or not np.all(np.isfinite(grid)):
            raise ParameterError(f"{name} is {grid.tolist()}: give finite values, at least one.")
    found = []
    for values in itertools.product(*(grid.tolist() for grid in grids.values())):
        named = dict(zip(grids, values, strict=True))
        found.append((named, _made(model, named, make)))
    return found


def _made(model: Model, values: dict[str, float], make: Make | None) -> Model:
    made = model.remade(varied(model.robot, values)) if make is None else make(**values)
    if not isinstance(made, Model):
        raise ModelError(f"make gave {type(made).__name__} for {values}: it must give a model.")
    return made


def sweep_robots(
    model: Model, parameters: Mapping[str, ArrayLike], *, make: Make | None = None, **options: Any
) -> xr.Dataset:
    """A sweep of each robot that a function makes, in one dataset; without one, `sweep`.

    The dataset's first dimensions are the parameters.

    Args:
        model, parameters, make: see `robots_of`.
        **options: of `sweep`; with `make`, but for store and resume.

    Raises:
        ParameterError: as `robots_of` and `sweep` raise.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_urdf(rr.urdf_path("rrrobot"), shell=rr.Sphere(0.12))
        >>> model = rr.FullModel(robot, damping=rr.EulerRateDamping(0.01, 0.01, 0.01))
        >>> ds = rr.studies.sweep_robots(model, {"shell.radius": [0.11, 0.12]}, offset=[0.7, 1.5])
        >>> dict(ds.sizes)
        {'shell.radius': 2, 'offset': 2}
    """
    import xarray as xr

    if make is None:
        return sweep(model, parameters=parameters, **{"progress": False} | options)
    for name in ("store", "resume"):
        if name in options:
            raise ParameterError(f"{name} is of one robot's sweep: leave it out.")
    robots = robots_of(model, parameters, make)
    parts = [sweep(each, **{"progress": False} | options) for _, each in robots]
    names = list(robots[0][0])
    joined = [part.expand_dims({name: [values[name]] for name in names})
              for (values, _), part in zip(robots, parts, strict=True)]  # fmt: skip
    found = xr.combine_by_coords(joined, combine_attrs="drop_conflicts")
    assert isinstance(found, xr.Dataset)
    return found


class BestRobot(NamedTuple):
    """What a search over robots found."""

    values: dict[str, float]
    """of the parameters"""
    model: Model
    score: float
    """the least"""
    tried: Array
    """values and score of every robot that was tried (n, parameters + 1); inf of refused ones"""


def best_robot(
    model: Model,
    bounds: Mapping[str, tuple[float, float]],
    score: Callable[[Model], float],
    *,
    make: Make | None = None,
    budget: int = 60,
) -> BestRobot:
    """The robot with the least score within bounds of its parameters, by Nelder and Mead's simplex.

    Args:
        model, make: see `robots_of`.
        bounds: name -> (low, high).
        score: of a model, such as `lambda m: -rr.optimise(m, goal, budget=400).value`.
        budget: robots that are tried.

    Raises:
        ParameterError: bounds out of order.
        ModelError: every robot that was tried was refused.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_urdf(rr.urdf_path("rrrobot"), shell=rr.Sphere(0.12))
        >>> best = rr.studies.best_robot(rr.FullModel(robot), {"shell.radius": (0.1, 0.2)},
        ...                              lambda m: (m.robot.shell.radius - 0.15) ** 2)
        >>> round(best.values["shell.radius"], 3)
        0.15
    """
    from scipy.optimize import minimize

    if not bounds:
        raise ParameterError("bounds is empty: name at least one parameter.")
    low, high = (np.array([finite(n, b[k]) for n, b in bounds.items()]) for k in (0, 1))
    if not np.all(low < high):
        raise ParameterError(f"bounds is {dict(bounds)}: each must be (low, high), low < high.")
    tried: list[list[float]] = []
    reason = "none was tried"

    def at(x: Array) -> dict[str, float]:
        return dict(zip(bounds, (low + np.clip(x, 0, 1) * (high - low)).tolist(), strict=True))

    def cost(x: Array) -> float:
        nonlocal reason
        values = at(x)
        try:
            number = float(score(_made(model, values, make)))
        except RRRobotError as error:
            number, reason = math.inf, str(error)
        number = number if math.isfinite(number) else math.inf
        tried.append([*values.values(), number])
        return number

    minimize(
        cost, np.full(low.size, 0.5), method="Nelder-Mead", bounds=[(0.0, 1.0)] * low.size,
        options={
            "maxfev": budget, "xatol": 1e-4, "fatol": 1e-12,
            "initial_simplex": _simplex(low.size),
        },
    )  # fmt: skip
    table = np.array(tried)
    best = table[int(np.argmin(table[:, -1]))]
    if not math.isfinite(best[-1]):
        raise ModelError(f"every robot that was tried was refused, the last as: {reason}")
    values = dict(zip(bounds, best[:-1].tolist(), strict=True))
    return BestRobot(values, _made(model, values, make), float(best[-1]), table)


def _simplex(n: int) -> Array:
    """Points about the middle of a unit box (n + 1, n)."""
    return np.vstack((np.full(n, 0.4), np.full((n, n), 0.4) + 0.3 * np.eye(n)))
