"""Height functions of machines over two of their motors, with cycles and singular shapes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array
from rrrobot.drawing import BLACK, FONT, new_figure, tidy
from rrrobot.errors import ConstraintError, ParameterError
from rrrobot.figures.shades import Shades
from rrrobot.machines.cycles import COMPONENTS, MachineCycle, plane_of
from rrrobot.machines.machine import Machine
from rrrobot.machines.reduced import Reduction
from rrrobot.machines.singular import determinant

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NEAR = 0.06
"""Margin below which a height is not shown: it grows without bound towards a singular shape."""
_MOST = 92
"""Percentile of the heights at which colours end."""
_NAMES = {"theta": "θ", "rx": "turn about x", "ry": "turn about y", "rz": "turn about z"}


def curvature_maps(
    machine: Machine,
    components: Sequence[str],
    *,
    shape_range: ArrayLike,
    pair: tuple[int, int] = (0, 1),
    shape: ArrayLike | None = None,
    cycles: Mapping[str, MachineCycle] | None = None,
    resolution: int = 41,
) -> Figure:
    """Height functions, -DA, of components of the body's motion over two motors.

    A small counter-clockwise cycle moves the machine by its area times the height, along the body's
    own axes. Thick lines are zeros; red dashed lines and crosses are singular shapes, where wheels
    align, and what is white about them is beyond the colours.

    Args:
        machine: planar, or afloat.
        components: "x", "y", "theta"; in space "x", "y", "z", "rx", "ry", "rz"; one panel each.
        shape_range: (low, high) of both motors, or a row for each (2, 2) [rad or m].
        pair: indices of the two motors.
        shape: where the others stay (n,).
        cycles: component -> a cycle, drawn on its panel with what it moves.
        resolution: values of each motor, 5 or more.

    Raises:
        ModelError: the machine has no connection over its shape.
        ParameterError: an argument out of range.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.figures.machines import curvature_maps
        >>> body = rr.machines.satellite()
        >>> figure = curvature_maps(body, ["theta"], shape_range=(-1.5, 1.5), resolution=9)
        >>> figure.savefig("satellite.png")
    """
    reduction = Reduction(machine)
    names = COMPONENTS[reduction.group]
    unknown = [c for c in components if c not in names]
    if unknown or not components:
        raise ParameterError(f"components is {components!r}: each must be of {', '.join(names)}.")
    if isinstance(resolution, bool) or not isinstance(resolution, int) or resolution < 5:
        raise ParameterError(f"resolution is {resolution!r}: it must be a whole number, 5 or more.")
    box, base = plane_of(reduction, shape_range, pair, shape)
    axes = [np.linspace(low, high, resolution) for low, high in box]
    heights, margins, signs = _grids(reduction, axes, pair, base)
    figure = new_figure(0.6 + 3.6 * len(components), 3.5)
    panels = figure.subplots(1, len(components), squeeze=False)[0]
    labels = [f"{machine.model.motors[i]} [{_unit(machine, i)}]" for i in pair]
    for ax, component in zip(panels, components, strict=True):
        data = np.ma.masked_invalid(heights[:, :, names.index(component)].T)
        data = np.ma.masked_where(margins.T < _NEAR, data)
        limit = float(np.percentile(np.abs(data.compressed()), _MOST)) or 1.0
        image = Shades(kind="signed", low=-limit, high=limit).draw(ax, axes[0], axes[1], data)
        bar = ax.figure.colorbar(image, ax=ax, shrink=0.85)
        bar.ax.tick_params(labelsize=FONT - 2)
        _draw_singular(ax, axes, margins, signs)
        cycle = (cycles or {}).get(component)
        title = _NAMES.get(component, component)
        if cycle is not None:
            _draw_cycle(ax, cycle, pair)
            unit = "m" if component in ("x", "y", "z") else "rad"
            title += f": {cycle.gain:.4g} {unit} a cycle"
        ax.set_title(title, fontsize=FONT)
        tidy(ax, labels[0], labels[1])
        ax.grid(False)
        ax.set_xlim(*box[0])
        ax.set_ylim(*box[1])
    return figure


def _grids(
    reduction: Reduction, axes: list[Array], pair: tuple[int, int], base: Array
) -> tuple[Array, Array, Array | None]:
    """Heights (m, m, nb), margins (m, m), and the determinants (m, m) where there are."""
    size = axes[0].size
    heights = np.full((size, size, reduction.model.n_base), np.nan)
    margins, signs = np.ones((2, size, size))
    square = determinant(reduction.model, base) if reduction.model.constraints else None
    for i, j in np.ndindex(size, size):
        shape = base.copy()
        shape[list(pair)] = axes[0][i], axes[1][j]
        margins[i, j] = reduction.margin(shape)
        if square is not None:
            signs[i, j] = determinant(reduction.model, shape) or 0.0
        if margins[i, j] > 0.5 * _NEAR:
            try:
                heights[i, j] = -reduction.curvature(shape, pair[0], pair[1])[
                    : reduction.model.n_base
                ]
            except ConstraintError:
                continue
    return heights, margins, None if square is None else signs


def _draw_singular(ax: Axes, axes: list[Array], margins: Array, signs: Array | None) -> None:
    """Lines where a square J_b loses rank; crosses at the least of small margins otherwise."""
    style: dict[str, Any] = {"colors": "#BB0000", "linewidths": 1.4, "linestyles": "--"}
    if signs is not None:
        if signs.min() < 0 < signs.max():
            ax.contour(axes[0], axes[1], signs.T, [0.0], **style)
        return
    inner = margins[1:-1, 1:-1]
    around = [margins[1 + i : len(margins) - 1 + i, 1 + j : margins.shape[1] - 1 + j]
              for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]  # fmt: skip
    low = (inner < _NEAR) & np.all([inner <= other for other in around], axis=0)
    for i, j in np.argwhere(low) + 1:
        ax.plot(axes[0][i], axes[1][j], "x", color="#BB0000", markersize=7, markeredgewidth=2)


def _draw_cycle(ax: Axes, cycle: MachineCycle, pair: tuple[int, int]) -> None:
    times = np.linspace(0, 2 * np.pi / float(np.max(cycle.gait.angular_frequency)), 721)
    x, y = cycle.gait(times).angle[:, list(pair)].T
    ax.plot(x, y, color=BLACK, linewidth=2.0, linestyle=(0, (5, 1.5)))
    ax.annotate(
        "", xy=(x[95], y[95]), xytext=(x[85], y[85]),
        arrowprops={"arrowstyle": "-|>", "color": BLACK, "lw": 2.0},
    )  # fmt: skip


def _unit(machine: Machine, motor: int) -> str:
    name = machine.model.motors[motor]
    slides = {joint.name for joint in machine.tree.joints if joint.kind == "slide"}
    return "m" if name in slides else "rad"
