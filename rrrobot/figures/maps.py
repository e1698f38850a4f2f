"""Maps of sweeps: the kinds of Figs 11, 12, 14 and 18-22 of the paper, for any robot.

Each function takes results of `rr.sweep` with two dimensions, such as offset and phase
difference; take a slice of a larger sweep first, with `ds.sel(amplitude=0.3)`. Colours grow darker
with the value and contours are labelled, so that a map reads the same in grey; where a value is
missing it is hatched.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.drawing import BLACK, FONT, GREY, line, new_axes, new_figure, tidy
from rrrobot.errors import ParameterError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS, DARKEST = "YlGnBu", 0.72
"""From light yellow to blue, no darker than black contours on it can bear."""
SLOW = 2e-4
"""Speed below which a curvature is not drawn [m/s]."""
_APART = 0.06
"""Least distance of two contour labels, as a part of the axes."""
_SHOWN = {"m/s": ("mm/s", 1000.0), "rad": ("deg", 180 / np.pi), "m": ("mm", 1000.0), "1": ("", 1.0)}
"""Unit of the data -> unit of a colour bar, and the factor."""
_SYMBOLS = {"speed": "v", "yaw_rate": r"$\alpha$", "curvature": "K", "velocity_y": "v"}


def value_map(
    values: xr.DataArray,
    ax: Axes | None = None,
    *,
    limits: tuple[float, float] | None = None,
    colour_bar: bool = True,
) -> Axes:
    """A variable of a sweep over its two dimensions, with labelled contours.

    Args:
        values: such as `ds.speed`.
        ax: where to draw; axes in a new figure if None.
        limits: of the colours, in the data's unit; the data's own if None.
        colour_bar: draw one.

    Returns:
        the Axes.

    Raises:
        ParameterError: not two dimensions of at least two values each.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> from rrrobot.figures.maps import value_map
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> ds = rr.sweep(model, offset=[0.5, 1.0, 1.5], phase_difference=[1.0, 2.0, 3.0])
        >>> value_map(ds.speed).get_xlabel()
        'leg phase difference [rad]'
    """
    table, (low, high) = _scaled(values, limits)
    rows, columns = (np.asarray(table[dim]) for dim in table.dims)
    ax = new_axes() if ax is None else ax
    data = np.ma.masked_invalid(table.to_numpy())
    shading: Any = "nearest" if data.mask.any() else "gouraud"
    image = ax.pcolormesh(
        columns, rows, data, cmap=_colours(), vmin=low, vmax=high, shading=shading, rasterized=True
    )
    ax.patch.set(hatch="////", edgecolor=GREY, linewidth=0.0)
    if values.attrs.get("units") == "rad":
        _mask_jumps(data, 180.0)
    if data.count():
        _contours(ax, columns, rows, data, (low, high))
    else:
        ax.text(0.5, 0.5, "no value", transform=ax.transAxes, ha="center", va="center",
                backgroundcolor="white")  # fmt: skip
    ax.set_xlim(columns.min(), columns.max())
    ax.set_ylim(rows.min(), rows.max())
    tidy(ax, _label(table[table.dims[1]]), _label(table[table.dims[0]]))
    ax.grid(False)
    ax.spines[:].set_visible(True)
    for axis, dim in ((ax.xaxis, table.dims[1]), (ax.yaxis, table.dims[0])):
        _ticks_of_pi(axis, table[dim])
    if colour_bar:
        _bar(image, [ax], values)
    return ax


def side_by_side(
    left: xr.DataArray, right: xr.DataArray, titles: tuple[str, str] = ("full model", "single-axis")
) -> Figure:
    """The same variable by two models with the same colours: Figs 11, 12 and 14.

    Args:
        left, right: such as `full.pitch_amplitude` and `pitch.pitch_amplitude`.
        titles: of the panels.
    """
    figure, pair = new_figure(8.4, 3.7), (left, right)
    known = np.concatenate([np.ravel(values)[np.isfinite(np.ravel(values))] for values in pair])
    limits = (float(known.min()), float(known.max())) if known.size else None
    panels = list(figure.subplots(1, 2))
    for i, (values, title) in enumerate(zip(pair, titles, strict=True)):
        value_map(values, panels[i], limits=limits, colour_bar=False)
        panels[i].set_title(f"({'ab'[i]}) {title}", fontsize=FONT)
    panels[1].set_ylabel("")
    _bar(panels[0].collections[0], panels, left)
    return figure


def translation(ds: xr.Dataset) -> Figure:
    """Speed v, yaw rate alpha and curvature K over two dimensions: Figs 18 and 19.

    The curvature is drawn where the speed is at least 0.2 mm/s, and its colours end where nine
    tenths of it lie.
    """
    figure = new_figure(11.4, 3.5)
    curvature = ds.curvature.where(ds.speed >= SLOW)
    largest = float(np.nanquantile(np.abs(curvature), 0.9)) if curvature.notnull().any() else 1.0
    for i, values in enumerate((ds.speed, ds.yaw_rate, curvature)):
        limits = (-largest, largest) if i == 2 else None
        ax = value_map(values, figure.add_subplot(1, 3, i + 1), limits=limits)
        ax.set_title(f"({'abc'[i]}) {_title(values)}", fontsize=FONT)
        if i:
            ax.set_ylabel("")
    return figure


def amplitudes(ds: xr.Dataset) -> Figure:
    """Amplitudes of roll, pitch and yaw over two dimensions."""
    figure = new_figure(11.4, 3.5)
    for i, axis in enumerate(("roll", "pitch", "yaw")):
        ax = value_map(ds[f"{axis}_amplitude"], figure.add_subplot(1, 3, i + 1))
        ax.set_title(f"({'abc'[i]}) {axis} amplitude", fontsize=FONT)
        if i:
            ax.set_ylabel("")
    return figure


def inverse(ds: xr.Dataset, *, curves: int = 9) -> Figure:
    """Offset and phase difference over the plane of speed and yaw rate: Figs 21 and 22.

    Each curve of panel (a) has one offset, and phase differences along it; of panel (b) the other
    way round. The speed is signed: along the leg axis, positive to the left.

    Args:
        ds: over two dimensions.
        curves: at most this many in each panel.
    """
    figure = new_figure(9.6, 4.4)
    table = _two_dimensions(ds.velocity_y)
    for i, (dim, axis) in enumerate(zip(table.dims, (0, 1), strict=True)):
        ax = figure.add_subplot(1, 2, i + 1)
        v = 1000 * np.moveaxis(table.to_numpy(), axis, 0)
        alpha = np.moveaxis(_two_dimensions(ds.yaw_rate).to_numpy(), axis, 0)
        ax.plot(v, alpha, ".", color="#CCCCCC", markersize=1.5, zorder=1)
        _curves(ax, v, alpha, table[dim], curves)
        tidy(ax, "v along the leg axis [mm/s]", r"$\alpha$ [rad/s]" if not i else "")
        ax.set_title(f"({'ab'[i]}) curves of equal {_label(table[dim])}", fontsize=FONT)
    return figure


def modulation(values: xr.DataArray, ax: Axes | None = None) -> Axes:
    """What `studies.amplitude_modulation` gives over the offset, with the gait's own amplitude."""
    ax = new_axes() if ax is None else ax
    known = values.dropna("offset")
    ax.plot(known.offset, known, marker="o", markersize=3, label="yaw model", **line(0))
    own = float(values.amplitude)
    ax.axhline(own, color=GREY, linestyle="--", linewidth=1.0)
    ax.annotate("full model", (0.99, own), (-4, 3), ("axes fraction", "data"), "offset points",
                ha="right", fontsize=FONT - 1)  # fmt: skip
    tidy(ax, _label(values.offset), "leg amplitude [rad]")
    _ticks_of_pi(ax.xaxis, values.offset)
    ax.set_xlim(float(values.offset.min()), float(values.offset.max()))
    ax.set_ylim(0.0, 1.1 * max(own, float(known.max()) if known.size else own))
    return ax


def _two_dimensions(values: xr.DataArray) -> xr.DataArray:
    table = values.squeeze(drop=True)
    if table.ndim != 2 or min(table.shape) < 2:
        raise ParameterError(
            f"a map needs two dimensions of two values or more; this is {dict(values.sizes)}: take "
            "a slice, such as ds.sel(amplitude=0.3)."
        )
    return table.sortby(list(table.dims))


def _scaled(
    values: xr.DataArray, limits: tuple[float, float] | None
) -> tuple[xr.DataArray, tuple[float, float]]:
    """Values and limits in the unit that is shown."""
    table = _two_dimensions(values)
    factor = _SHOWN.get(values.attrs.get("units", ""), ("", 1.0))[1]
    table = (factor * table).where(np.isfinite(table))
    if limits is None:
        known = table.to_numpy()[np.isfinite(table)]
        return table, (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    return table, (factor * limits[0], factor * limits[1])


def _contours(ax: Axes, x: Array, y: Array, data: Any, limits: tuple[float, float]) -> None:
    from matplotlib.patheffects import withStroke
    from matplotlib.ticker import MaxNLocator

    levels = MaxNLocator(10, steps=[1, 2, 2.5, 5, 10]).tick_values(*limits)
    if limits[1] - limits[0] < 1e-9 * max(abs(v) for v in (*limits, 1e-12)):
        return
    thick = [1.6 if level == 0 else 0.8 for level in levels]
    lines = ax.contour(x, y, data, levels, colors=BLACK, linewidths=thick, negative_linestyles="--")
    labels = ax.clabel(lines, inline=False, fontsize=FONT - 2, fmt=lambda v: f"{v + 0.0:g}")
    kept: list[Any] = []
    for label in labels:
        label.set_path_effects([withStroke(linewidth=2.6, foreground="white")])
        at = (ax.transData - ax.transAxes).transform(label.get_position())
        if all(math.dist(at, other) > _APART for other in kept) and 0.02 < at[0] < 0.98:
            kept.append(at)
        else:
            label.remove()


def _mask_jumps(data: Any, jump: float) -> None:
    """Mask, in place, the values on both sides of a step that is larger than `jump`."""
    for axis in (0, 1):
        wide = np.moveaxis(np.abs(np.diff(data, axis=axis)).filled(0.0) > jump, axis, 0)
        table = np.moveaxis(data, axis, 0)
        table[:-1][wide] = np.ma.masked
        table[1:][wide] = np.ma.masked


def _colours() -> Any:
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    return ListedColormap(colormaps[COLOURS](np.linspace(0.0, DARKEST, 256)))


def _curves(ax: Axes, v: Array, alpha: Array, values: xr.DataArray, curves: int) -> None:
    """Some rows of (v, alpha) as lines, each with its value where it is farthest out."""
    numbers = np.unique(np.linspace(0, len(v) - 1, min(curves, len(v))).round().astype(int))
    scale = [np.nanmax(np.abs(part), initial=0.0) or 1.0 for part in (v, alpha)]
    for k, i in enumerate(numbers.tolist()):
        style = line(k)
        ax.plot(v[i], alpha[i], zorder=2, **style)
        out = np.hypot(v[i] / scale[0], alpha[i] / scale[1])
        if not np.nanmax(out, initial=0.0) > 0.05:
            # The robot hardly moves, and all such curves lie on one spot.
            continue
        at = int(np.nanargmax(out))
        text = _multiple_of_pi(float(values[i]))
        ax.annotate(text, (v[i, at], alpha[i, at]), (2, 2), textcoords="offset points",
                    fontsize=FONT - 2, zorder=3)  # fmt: skip


def _bar(image: Any, panels: list[Axes], values: xr.DataArray) -> None:
    data, norm = image.get_array().compressed(), image.norm
    below, above = bool((data < norm.vmin).any()), bool((data > norm.vmax).any())
    extend = "both" if below and above else "min" if below else "max" if above else "neither"
    bar = panels[0].figure.colorbar(image, ax=panels, pad=0.02, aspect=25, extend=extend)
    unit = values.attrs.get("units", "")
    unit = _SHOWN.get(unit, (unit, 1.0))[0]
    bar.set_label(f"{_title(values)} [{unit}]" if unit else _title(values), fontsize=FONT)
    bar.ax.tick_params(labelsize=FONT - 1)


def _title(values: xr.DataArray) -> str:
    name = str(values.name or values.attrs.get("long_name", "")).replace("_", " ")
    symbol = _SYMBOLS.get(str(values.name))
    return f"{name} {symbol}" if symbol else name


def _name(coordinate: xr.DataArray) -> str:
    return str(coordinate.attrs.get("long_name", coordinate.name))


def _label(coordinate: xr.DataArray) -> str:
    unit = coordinate.attrs.get("units")
    return f"{_name(coordinate)} [{unit}]" if unit else _name(coordinate)


def _ticks_of_pi(axis: Any, coordinate: xr.DataArray) -> None:
    """Ticks at multiples of pi / 4 or pi / 2 on an axis of wide angles."""
    span = float(coordinate.max() - coordinate.min())
    if coordinate.attrs.get("units") != "rad" or span < 1.5:
        return
    step = np.pi / 4 if span < 4 else np.pi / 2
    first = math.ceil(float(coordinate.min()) / step - 1e-9)
    last = math.floor(float(coordinate.max()) / step + 1e-9)
    ticks = step * np.arange(first, last + 1)
    axis.set_ticks(ticks, [_multiple_of_pi(tick) for tick in ticks])


def _multiple_of_pi(value: float) -> str:
    """A number as a fraction of pi if it is a plain one."""
    for divisor in (1, 2, 3, 4, 6, 8):
        times = value * divisor / np.pi
        if abs(times - round(times)) < 1e-9:
            whole = round(times)
            over = f"/{divisor}" if divisor > 1 else ""
            return (
                "0"
                if whole == 0
                else f"{'' if whole == 1 else '-' if whole == -1 else whole}π{over}"
            )
    return f"{value:.3g}"
