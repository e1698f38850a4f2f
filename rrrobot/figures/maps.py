"""Maps of sweeps: the kinds of Figs 11, 12, 14 and 18-22 of the paper, for any robot.

Each function takes results of `rr.sweep` with two dimensions, such as offset and phase
difference; take a slice of a larger sweep first, with `ds.sel(amplitude=0.3)`. Amounts grow darker,
signed values part from white at zero, and phases have colours that come round; contours are
labelled. Where a value is missing it is hatched.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.drawing import FONT, GREY, legend_above, line, new_axes, new_figure, tidy
from rrrobot.errors import ParameterError
from rrrobot.figures.shades import Shades

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SLOW = 2e-4
"""Speed below which a curvature is not drawn [m/s]."""
_SPOT, _CLEAR = 0.12, 0.1
"""Parts of the largest speed or yaw rate: a curve within the first is a spot and gets no label; a
label at the second from all other curves stands clear."""
_TEXT = np.array((0.32, 0.16))
"""Room of a label in the same parts."""
_SHOWN = {"m/s": ("mm/s", 1000.0), "rad": ("deg", 180 / np.pi), "m": ("mm", 1000.0), "1": ("", 1.0)}
"""Unit of the data -> unit of a colour bar, and the factor."""
_SYMBOLS = {"speed": "v", "yaw_rate": r"$\alpha$", "curvature": "K", "velocity_y": "v"}


def value_map(
    values: xr.DataArray,
    ax: Axes | None = None,
    *,
    colour_range: tuple[float, float] | None = None,
    colour_bar: bool = True,
) -> Axes:
    """A variable of a sweep over its two dimensions, with labelled contours.

    Args:
        values: such as `ds.speed`.
        ax: where to draw; axes in a new figure if None.
        colour_range: of the colours, in the data's unit; the data's own if None.
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
    table, limits = _scaled(values, colour_range)
    rows, columns = (np.asarray(table[dim]) for dim in table.dims)
    ax = new_axes() if ax is None else ax
    data = np.ma.masked_invalid(table.to_numpy())
    ax.patch.set(hatch="////", edgecolor=GREY, linewidth=0.0)
    image = Shades.of(values, table.to_numpy(), limits).draw(ax, columns, rows, data)
    if not data.count():
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
    figure, pair = new_figure(7.2, 3.3), (left, right)
    known = np.concatenate([np.ravel(values)[np.isfinite(np.ravel(values))] for values in pair])
    limits = (float(known.min()), float(known.max())) if known.size else None
    panels = list(figure.subplots(1, 2))
    for i, (values, title) in enumerate(zip(pair, titles, strict=True)):
        value_map(values, panels[i], colour_range=limits, colour_bar=False)
        panels[i].set_title(f"({'ab'[i]}) {title}", fontsize=FONT)
    panels[1].set_ylabel("")
    _bar(panels[0].collections[0], panels, left)
    return figure


def translation(ds: xr.Dataset) -> Figure:
    """Speed v, yaw rate alpha and curvature K over two dimensions: Figs 18 and 19.

    The curvature is drawn where the speed is at least 0.2 mm/s, and its colours end where nine
    tenths of it lie.
    """
    figure = new_figure(9.0, 3.2)
    curvature = ds.curvature.where(ds.speed >= SLOW)
    largest = float(np.nanquantile(np.abs(curvature), 0.9)) if curvature.notnull().any() else 1.0
    for i, values in enumerate((ds.speed, ds.yaw_rate, curvature)):
        limits = (-largest, largest) if i == 2 else None
        ax = value_map(values, figure.add_subplot(1, 3, i + 1), colour_range=limits)
        ax.set_title(f"({'abc'[i]}) {_title(values)}", fontsize=FONT)
        if i:
            ax.set_ylabel("")
    return figure


def amplitudes(ds: xr.Dataset) -> Figure:
    """Amplitudes of roll, pitch and yaw over two dimensions."""
    figure = new_figure(9.0, 3.2)
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
    figure = new_figure(7.2, 3.5)
    table = _two_dimensions(ds.velocity_y)
    for i, (dim, axis) in enumerate(zip(table.dims, (0, 1), strict=True)):
        ax = figure.add_subplot(1, 2, i + 1)
        v = 1000 * np.moveaxis(table.to_numpy(), axis, 0)
        alpha = np.moveaxis(_two_dimensions(ds.yaw_rate).to_numpy(), axis, 0)
        ax.plot(v, alpha, ".", color="#DDDDDD", markersize=1.5, zorder=1)
        _curves(ax, v, alpha, table[dim], curves)
        ax.margins(x=0.12)
        tidy(ax, "v along the leg axis [mm/s]", r"$\alpha$ [rad/s]" if not i else "")
        ax.set_title(f"({'ab'[i]}) curves of equal {_label(table[dim])}", fontsize=FONT)
    return figure


def modulation(values: xr.DataArray, ax: Axes | None = None) -> Axes:
    """What `studies.amplitude_modulation` gives over the offset, with the gait's own amplitude.

    Where the full model does not turn, the amplitude has a limit between its neighbours: an open
    circle. Toward the ends, where no amplitude does, the ground of the plot is grey.
    """
    ax = new_axes() if ax is None else ax
    known = values.dropna("offset").sortby("offset")
    offset, amplitude = known.offset.to_numpy(), known.to_numpy()
    ax.plot(offset, amplitude, label="yaw model", **line(0))
    if known.size:
        ends = (float(values.offset.min()), offset[0], offset[-1], float(values.offset.max()))
        for label, low, high in (("no amplitude does", *ends[:2]), (None, *ends[2:])):
            ax.axvspan(low, high, color="#E6E6E6", zorder=0, label=label)
        between = [
            float(at) for at in values.offset[values.isnull()] if offset[0] < at < offset[-1]
        ]
        ax.plot(between, np.interp(between, offset, amplitude), "o", markersize=5,
                markerfacecolor="white", markeredgecolor=line(0)["color"], linestyle="none",
                label="limit: no turning")  # fmt: skip
    own = float(values.amplitude)
    ax.axhline(own, color=GREY, linestyle="--", linewidth=1.0, label="full model")
    tidy(ax, _label(values.offset), "leg amplitude [rad]")
    legend_above(ax)
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
) -> tuple[xr.DataArray, tuple[float, float] | None]:
    """Values and limits in the unit that is shown."""
    table = _two_dimensions(values)
    factor = _SHOWN.get(values.attrs.get("units", ""), ("", 1.0))[1]
    table = (factor * table).where(np.isfinite(table))
    return table, None if limits is None else (factor * limits[0], factor * limits[1])


def _curves(ax: Axes, v: Array, alpha: Array, values: xr.DataArray, curves: int) -> None:
    """Some rows of (v, alpha) as smooth lines, each with its value where no other one is near."""
    from matplotlib.patheffects import withStroke
    from scipy.spatial.distance import cdist

    numbers = np.unique(np.linspace(0, len(v) - 1, min(curves, len(v))).round().astype(int))
    scale = [np.nanmax(np.abs(part), initial=0.0) or 1.0 for part in (v, alpha)]
    smooth = [_smooth(np.column_stack((v[i], alpha[i]))) for i in numbers]
    taken: list[Array] = []
    for k, (i, curve) in enumerate(zip(numbers.tolist(), smooth, strict=True)):
        ax.plot(*curve.T, zorder=2, **line(k))
        unit = curve / scale
        out = np.hypot(*unit.T)
        if not np.nanmax(out, initial=0.0) > _SPOT:
            # The robot hardly moves, and all such curves lie on one spot.
            continue
        # Far out, clear of other labels, then of other curves.
        far = np.flatnonzero(out > 0.6 * np.nanmax(out))
        others = np.concatenate([other / scale for j, other in enumerate(smooth) if j != k])
        others = others[np.isfinite(others).all(axis=1)]
        alone = cdist(unit[far], others).min(axis=1, initial=_CLEAR)
        apart = cdist(unit[far] / _TEXT, np.reshape(taken, (-1, 2)) / _TEXT, "chebyshev")
        crowded = apart.min(axis=1, initial=1.0) < 1
        at = far[np.argmax(alone + 0.05 * out[far] - crowded)]
        taken.append(unit[at])
        side = -1 if unit[at, 0] < -0.02 else 1
        ax.annotate(_multiple_of_pi(float(values[i])), tuple(curve[at]), (3 * side, 3),
                    textcoords="offset points", fontsize=FONT - 2, zorder=3,
                    ha="right" if side < 0 else "left",
                    path_effects=[withStroke(linewidth=2.0, foreground="white")])  # fmt: skip


def _smooth(curve: Array) -> Array:
    """The points (n, 2) of a curve with ten between each two, by Akima's spline over their
    number; unknown points stay gaps."""
    from scipy.interpolate import Akima1DInterpolator

    known = np.flatnonzero(np.all(np.isfinite(curve), axis=1))
    parts = []
    for part in np.split(known, np.flatnonzero(np.diff(known) > 1) + 1):
        if part.size > 2:
            at = np.linspace(part[0], part[-1], 10 * (part.size - 1) + 1)
            parts += [Akima1DInterpolator(part, curve[part])(at), np.full((1, 2), np.nan)]
        else:
            parts += [curve[part], np.full((1, 2), np.nan)]
    return np.concatenate(parts) if parts else curve


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
