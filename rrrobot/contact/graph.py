"""Smooth uneven ground as a graph z = f(x, y), by formula or from a grid of heights."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot import serial
from rrrobot.checks import Array, finite
from rrrobot.contact.ground import Ground, checked_gravity
from rrrobot.contact.splines import Surface2, fit
from rrrobot.errors import ModelError, ParameterError

_PROBES = 7
_STEP = 1e-4
_AGREE = 1e-6
_MARGIN = 40
"""Cells beyond the reach; what the spline's ends do wrong dies out by a factor of 2.3 in each."""
_FINEST = 700
_UNEVEN = 1e-3
"""Of a step: how far an entry of an axis may be from its place, as tables are rounded."""
_ERROR = 1e-9
"""Of the tabulated second derivatives [1/m]."""


@serial.register("graph")
class Graph(Ground):
    """Ground z = f(x, y): n = (-f_x, -f_y, 1)/W, B = -(1 - n n^T) diag(f'', 0)/W, W = |(grad, 1)|.

    Ground coordinates are the world's (x, y).

    Args:
        height: f(x, y) [m].
        gradient: (f_x, f_y) of (x, y).
        hessian: ((f_xx, f_xy), (f_xy, f_yy)) of (x, y) [1/m].
        reach: the fast form of the equations tabulates the square |x|, |y| <= reach [m].
        gravity: see `Ground`.

    Raises:
        ParameterError: the derivatives are not those of the height, or something is not finite.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> ridge = rr.Graph(
        ...     lambda x, y: 0.1 * x * y,
        ...     lambda x, y: (0.1 * y, 0.1 * x),
        ...     lambda x, y: ((0.0, 0.1), (0.1, 0.0)),
        ... )
        >>> ridge.point(np.array([0.5, 0.2])).round(9).tolist()
        [0.5, 0.2, 0.01]
    """

    def __init__(
        self,
        height: Callable[[float, float], float],
        gradient: Callable[[float, float], ArrayLike],
        hessian: Callable[[float, float], ArrayLike],
        *,
        reach: float = 1.0,
        gravity: float | None = None,
    ) -> None:
        self.height, self.gradient, self.hessian = height, gradient, hessian
        self.reach = finite("reach", reach, "m", above=0)
        self.gravity = checked_gravity(gravity)
        self._grid: Surface2 | None = None
        self._table: Surface2 | None = None
        self._check()

    @classmethod
    def from_grid(
        cls, x: ArrayLike, y: ArrayLike, heights: ArrayLike, *, gravity: float | None = None
    ) -> Graph:
        """The quintic spline through a grid of heights.

        Args:
            x, y: equally spaced to a thousandth of a step, increasing (nx,), (ny,) [m], at least 6
                each.
            heights: f(x_i, y_j) (nx, ny) [m].
            gravity: see `Ground`.

        Raises:
            ParameterError: no numbers, fewer, not equally spaced, not finite, or another shape.

        Example:
            >>> import numpy as np, rrrobot as rr
            >>> x = y = np.linspace(-1, 1, 41)
            >>> ground = rr.Graph.from_grid(x, y, 0.1 * np.multiply.outer(x, y))
            >>> ground.curvature(ground.point(np.zeros(2)))[0, 1].round(9)
            np.float64(-0.1)
        """
        axes = [_even(name, values) for name, values in (("x", x), ("y", y))]
        grid = _numbers("heights", heights)
        if grid.shape != (axes[0].size, axes[1].size):
            raise ParameterError(
                f"heights has shape {grid.shape}: it must be ({axes[0].size}, {axes[1].size}), one "
                "for each x and y."
            )
        if (holes := np.argwhere(~np.isfinite(grid))).size:
            i, j = holes[0]
            raise ParameterError(
                f"{len(holes)} of the {grid.size} heights are not finite, the first at x = "
                f"{axes[0][i]:g} m, y = {axes[1][j]:g} m: fill them from their neighbours, or cut "
                "the grid down to where it is whole."
            )
        corner = np.array([a[0] for a in axes])
        spacing = np.array([(a[-1] - a[0]) / (a.size - 1) for a in axes])
        return cls._of(fit(corner, spacing, grid), gravity)

    @classmethod
    def from_file(cls, path: str | Path, *, gravity: float | None = None) -> Graph:
        """The grid of heights in a table of numbers parted by commas.

        The first row holds y and the first column x, both increasing and equally spaced [m]; the
        entry below a y and right of an x is the height there [m]. The first entry of all does not
        count.

        Args:
            path: of the file.
            gravity: see `Ground`.

        Raises:
            ParameterError: no such file, no such table, or as `from_grid` raises.

        Example:
            >>> import pathlib, rrrobot as rr
            >>> rows = ["x/y," + ",".join(f"{0.1 * j}" for j in range(6))]
            >>> rows += [f"{0.1 * i}" + ",0.02" * 6 for i in range(6)]
            >>> _ = pathlib.Path("heights.csv").write_text("\\n".join(rows))
            >>> rr.Graph.from_file("heights.csv")
            Graph.from_grid(x=0 .. 0.5, y=0 .. 0.5)
        """
        try:
            table = np.genfromtxt(path, delimiter=",", ndmin=2)
        except (OSError, ValueError) as error:
            raise ParameterError(
                f"no grid of heights can be read from {str(path)!r}: {str(error).rstrip('.')}. It "
                "must be a table parted by commas, y in its first row and x in its first column."
            ) from None
        try:
            return cls.from_grid(table[1:, 0], table[0, 1:], table[1:, 1:], gravity=gravity)
        except ParameterError as error:
            raise ParameterError(f"{str(path)!r}: {error}") from None

    @classmethod
    def _of(cls, grid: Surface2, gravity: float | None) -> Graph:
        made = cls.__new__(cls)
        made.gravity = checked_gravity(gravity)
        made._grid = made._table = grid
        made.reach = float(np.abs((*grid.corner, *grid.upper)).max())
        made.height = lambda x, y: grid.value(np.array((x, y)))
        made.gradient = lambda x, y: grid.gradient(np.array((x, y)))
        made.hessian = lambda x, y: grid.hessian(np.array((x, y)))
        return made

    def _check(self) -> None:
        for at in self.reach * np.random.default_rng(0).uniform(-0.9, 0.9, (_PROBES, 2)):
            x, y = at
            h = _STEP * self.reach
            try:
                slope, bend = self._slope(x, y), self._bend(x, y)
                value = float(self.height(x, y))
                steps = ((h, 0.0), (0.0, h))
                by_height = [
                    (self.height(x + a, y + b) - self.height(x - a, y - b)) / (2 * h)
                    for a, b in steps
                ]
                by_slope = [
                    (self._slope(x + a, y + b) - self._slope(x - a, y - b)) / (2 * h)
                    for a, b in steps
                ]
            except (TypeError, ValueError) as error:
                raise ParameterError(
                    f"the graph's functions take x and y and return a number, 2 numbers and 2 x 2 "
                    f"numbers; at ({x:.3g}, {y:.3g}) m: {error}."
                ) from None
            size = (
                1.0
                + abs(value) / self.reach
                + np.abs(slope).max()
                + self.reach * np.abs(bend).max()
            )
            for what, found, expected in (
                ("gradient is not that of height", slope, by_height),
                (
                    "hessian is not that of gradient",
                    self.reach * bend,
                    self.reach * np.array(by_slope),
                ),
            ):
                error_size = float(np.abs(found - expected).max())
                if not error_size <= _AGREE * size:
                    raise ParameterError(
                        f"the graph's {what} at ({x:.3g}, {y:.3g}) m: {np.asarray(found).tolist()} "
                        f"against {np.asarray(expected).tolist()} by differences."
                    )

    def _slope(self, x: float, y: float) -> Array:
        return np.asarray(self.gradient(x, y), dtype=float).reshape(2)

    def _bend(self, x: float, y: float) -> Array:
        return np.asarray(self.hessian(x, y), dtype=float).reshape(2, 2)

    def point(self, coordinates: Array) -> Array:
        x, y = coordinates.tolist()
        return np.array((x, y, float(self.height(x, y))))

    def coordinate_rates(self, point: Array, velocity: Array) -> Array:
        return velocity[:2]

    def normal(self, point: Array) -> Array:
        fx, fy = self._slope(point[0], point[1]).tolist()
        return np.array((-fx, -fy, 1.0)) / sqrt(1.0 + fx * fx + fy * fy)

    def curvature(self, point: Array) -> Array:
        n = self.normal(point)
        bend = np.zeros((3, 3))
        bend[:2, :2] = self._bend(point[0], point[1])
        tangent = np.eye(3) - np.outer(n, n)
        # Symmetric, and the same on tangent vectors.
        return -n[2] * tangent @ bend @ tangent

    def distance(self, point: Array) -> float:
        return float((point[2] - self.point(point[:2])[2]) * self.normal(point)[2])

    def distances(self, points: Array) -> Array:
        spline = self._grid if self._grid is not None else self._table
        if spline is None or (self._grid is None and not spline.holds(points[:, :2])):
            return super().distances(points)
        height, slope = spline.values(points[:, :2])
        return np.asarray((points[:, 2] - height) / np.sqrt(1.0 + np.sum(slope**2, axis=1)))

    def leaves(self, coordinates: Array) -> str | None:
        if self._grid is None or self._grid.holds(coordinates):
            return None
        return "the contact is at the edge of the grid of heights"

    def table(self) -> Surface2:
        """The ground as a quintic spline within its reach, for the fast form.

        Raises:
            ModelError: it is too rough for that: 1e-9 of the second derivatives are not reached.
        """
        if self._table is None:
            self._table = self._tabulated()
        return self._table

    def _tabulated(self) -> Surface2:
        probes = self.reach * np.random.default_rng(1).uniform(-1, 1, (200, 2))
        exact = np.array([self._bend(*at) for at in probes])
        cells = 50
        while True:
            spacing = 2 * self.reach / cells
            ticks = spacing * (np.arange(cells + 1 + 2 * _MARGIN) - _MARGIN) - self.reach
            values = np.array([[float(self.height(x, y)) for y in ticks] for x in ticks.tolist()])
            if not np.all(np.isfinite(values)):
                raise ModelError(
                    f"the graph's height is not finite everywhere within {-ticks[0]:.3g} m of the "
                    "origin: give it a smaller reach."
                )
            found = fit(np.full(2, ticks[0]), np.full(2, spacing), values)
            error = float(np.abs([found.hessian(at) for at in probes] - exact).max())
            if error <= _ERROR * max(1.0, float(np.abs(exact).max())):
                return found
            if 2 * cells > _FINEST:
                raise ModelError(
                    f"the graph is too rough for the fast form: with cells of {spacing:.2g} m its "
                    f"second derivatives are off by {error:.2g} 1/m. Give a smaller reach= (it is "
                    f"{self.reach:g} m), or use method='kkt'."
                )
            cells *= 2

    def to_dict(self) -> dict[str, Any]:
        data: dict[str, Any] = {"type": "graph", "gravity": self.gravity, "reach": self.reach}
        if self._grid is None:
            data["formula"] = getattr(self.height, "__qualname__", repr(self.height))
        else:
            data |= {name: part.tolist() for name, part in self._grid._asdict().items()}
        return data

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Graph:
        """The graph that `to_dict` wrote, if it was a grid.

        Raises:
            ParameterError: it was a formula, which is not in the data.
        """
        if "table" not in data:
            raise ParameterError(
                f"the ground was a graph by the function {str(data.get('formula'))[:80]!r}, which "
                "is not in the file. Save a Graph.from_grid, or register a class of your own."
            )
        parts = (np.asarray(data[name], dtype=float) for name in Surface2._fields)
        return cls._of(Surface2(*parts), data["gravity"])

    def __reduce__(self) -> tuple[Any, ...]:
        if self._grid is not None:
            return (Graph._of, (self._grid, self.gravity))
        parts = (self.height, self.gradient, self.hessian, self.reach, self.gravity)
        return (_remake, parts)

    def __repr__(self) -> str:
        if self._grid is not None:
            low, high = self._grid.corner.tolist(), self._grid.upper.tolist()
            return f"Graph.from_grid(x={low[0]:g} .. {high[0]:g}, y={low[1]:g} .. {high[1]:g})"
        return f"Graph({getattr(self.height, '__qualname__', self.height)})"


def _remake(height: Any, gradient: Any, hessian: Any, reach: float, gravity: float | None) -> Graph:
    return Graph(height, gradient, hessian, reach=reach, gravity=gravity)


def _numbers(name: str, values: ArrayLike) -> Array:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"{name} must be an array of numbers: {error}.") from None


def _even(name: str, values: ArrayLike) -> Array:
    axis = _numbers(name, values)
    steps = np.diff(axis) if axis.ndim == 1 else np.zeros(0)
    if axis.ndim != 1 or axis.size < 6:
        fault = f"it has shape {axis.shape}"
    elif not np.all(np.isfinite(axis)):
        fault = f"{axis[~np.isfinite(axis)][0]} is no place"
    elif not np.all(steps > 0):
        k = int(np.argmin(steps > 0))
        fault = f"{axis[k + 1]:g} comes after {axis[k]:g}. Sort it, and the heights with it"
    elif np.abs(axis - np.linspace(axis[0], axis[-1], axis.size)).max() > _UNEVEN * steps.mean():
        fault = (
            f"its steps are from {steps.min():.6g} to {steps.max():.6g}. Resample the heights onto "
            "an even grid"
        )
    else:
        return axis
    raise ParameterError(
        f"{name} must hold at least 6 increasing, equally spaced numbers [m]: {fault}."
    )
