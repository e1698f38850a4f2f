"""Colours and contours of a map, by what its values are.

Amounts grow darker (sequential), signed values part from white at zero (diverging, with equal
limits on both sides), angles that come round return to their first colour (cyclic). Contours are
labelled, dashed below zero and thick at zero, so that a map reads the same in grey.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from rrrobot.checks import Array
from rrrobot.drawing import BLACK, FONT

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

Kind = Literal["amount", "signed", "angle"]
_COLOURS: dict[Kind, tuple[str, float, float, float]] = {
    "amount": ("YlGnBu", 0.0, 0.72, 0.0),
    "signed": ("RdBu_r", 0.1, 0.9, 0.0),
    "angle": ("twilight_shifted", 0.0, 1.0, 0.35),
}
"""Matplotlib's map, the part of it that is taken, and how far it is mixed with white: no darker
than black contours on it can bear."""
_BOTH_SIDES = 0.02
"""Values are signed if the lesser side is more than this part of the larger."""
_HALF_TURN = 180.0
_APART = 0.09
"""Least distance of two contour labels, as a part of the axes."""
_ROUNDING = 1e-6
"""Part of the largest value below which a difference is of the integration alone."""
_FINER = 8
"""Cells of a picture of angles for each interval of the grid."""


@dataclass(frozen=True, kw_only=True)
class Shades:
    """The kind of values and the limits of their colours, in the unit that is shown."""

    kind: Kind
    low: float
    high: float

    @classmethod
    def of(
        cls, values: xr.DataArray, shown: Array, limits: tuple[float, float] | None = None
    ) -> Shades:
        """What fits values, of which `shown` is in the unit of the colour bar.

        A phase that a sweep calls so is an angle; other values are signed where both signs count.
        """
        name = str(values.name or values.attrs.get("long_name"))
        if values.attrs.get("units") == "rad" and "phase" in name:
            return cls(kind="angle", low=-_HALF_TURN, high=_HALF_TURN)
        known = shown[np.isfinite(shown)]
        low, high = limits or ((known.min(), known.max()) if known.size else (0.0, 1.0))
        if min(-low, high) <= _BOTH_SIDES * max(-low, high):
            return cls(kind="amount", low=float(low), high=float(high))
        largest = float(max(-low, high))
        return cls(kind="signed", low=-largest, high=largest)

    def colours(self) -> Any:
        """The Matplotlib colour map."""
        from matplotlib import colormaps
        from matplotlib.colors import ListedColormap

        name, start, stop, white = _COLOURS[self.kind]
        rows = colormaps[name](np.linspace(start, stop, 256))
        rows[:, :3] = (1 - white) * rows[:, :3] + white
        return ListedColormap(rows)

    def levels(self) -> Array:
        """Values that get a contour; zero is one of them where it is between the limits.

        An amount that touches zero from above has none there: it would be rounding's.
        """
        from matplotlib.ticker import MaxNLocator

        if self.kind == "angle":
            return np.arange(-150.0, _HALF_TURN + 1.0, 30.0)
        scale = max(abs(self.low), abs(self.high), 1e-12)
        if self.high - self.low < 1e-9 * scale:
            return np.empty(0)
        ticks = MaxNLocator(10, steps=[1, 2, 2.5, 5, 10]).tick_values(self.low, self.high)
        levels: Array = np.where(np.abs(ticks) < 1e-9 * scale, 0.0, ticks)
        return levels[levels > self.low + _ROUNDING * scale] if self.kind == "amount" else levels

    def draw(self, ax: Axes, x: Array, y: Array, data: Any) -> Any:
        """Colours and contours of masked data (rows, columns); returns the image for a bar."""
        if self.kind == "angle":
            x, y, data = _refined_angles(x, y, data)
        smooth = self.kind != "angle" and not data.mask.any()
        image = ax.pcolormesh(
            x, y, data, cmap=self.colours(), vmin=self.low, vmax=self.high,
            shading="gouraud" if smooth else "nearest", rasterized=True,
        )  # fmt: skip
        above = _about if self.kind == "angle" else _above
        drawn = [
            (level, ax.contour(x, y, difference, [0.0], colors=BLACK,
                               linewidths=1.6 if level == 0 else 0.8,
                               linestyles="--" if level < 0 else "-"))
            for level in (self.levels() if data.count() else ())
            if (difference := above(data, level)).min() < 0 < difference.max()
        ]  # fmt: skip
        _label(ax, drawn)
        return image


def _about(data: Any, level: float) -> Any:
    """The angle from a level to the data in degrees, masked where it is beyond a quarter turn."""
    angle = (data - level + _HALF_TURN) % (2 * _HALF_TURN) - _HALF_TURN
    return np.ma.masked_where(np.abs(angle) > _HALF_TURN / 2, angle)


def _above(data: Any, level: float) -> Any:
    """Masked data less a level; differences of rounding alone take a side by rule.

    Where a map has one value along a line, by symmetry, rounding gives either sign: a contour
    would wind along the border, or step aside where two such lines cross. On the border the side
    is the inner neighbour's, inside it is that of the value a little farther along both axes.
    """
    difference = np.array(data - level)
    rounding = np.abs(difference) < _ROUNDING * np.abs(data).max()
    along = sum(np.gradient((data - level).filled(0.0)))
    difference[rounding] = _ROUNDING**2 * along[rounding]
    for table, noise in ((difference, rounding), (difference.T, rounding.T)):
        for edge, inner in ((0, 1), (-1, -2)):
            table[edge][noise[edge]] = _ROUNDING**2 * table[inner][noise[edge]]
    return np.ma.array(difference, mask=np.ma.getmaskarray(data))


def _refined_angles(x: Array, y: Array, data: Any) -> tuple[Array, Array, Any]:
    """Angles in degrees on a finer grid: bilinear in their unit vectors, which know no jump."""
    from scipy.interpolate import RegularGridInterpolator

    fine = [np.interp(np.arange(_FINER * (v.size - 1) + 1) / _FINER, np.arange(v.size), v)
            for v in (y, x)]  # fmt: skip
    unit = np.exp(1j * np.deg2rad(data.filled(np.nan)))
    grid = np.stack(np.meshgrid(*fine, indexing="ij"), axis=-1)
    angle = np.rad2deg(np.angle(RegularGridInterpolator((y, x), unit)(grid)))
    return fine[1], fine[0], np.ma.masked_invalid(angle)


def _label(ax: Axes, drawn: list[tuple[float, Any]]) -> None:
    """Write each level on its contours, where no other label is near."""
    from matplotlib.patheffects import withStroke

    kept: list[Any] = []
    for level, lines in drawn:
        text = f"{level + 0.0:g}"
        for label in ax.clabel(lines, inline=False, fontsize=FONT - 2, fmt=lambda _, t=text: t):
            label.set_path_effects([withStroke(linewidth=2.6, foreground="white")])
            at = (ax.transData - ax.transAxes).transform(label.get_position())
            if all(math.dist(at, other) > _APART for other in kept) and 0.02 < at[0] < 0.98:
                kept.append(at)
            else:
                label.remove()
