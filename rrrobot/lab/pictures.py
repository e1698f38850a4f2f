"""The map and the (speed, curvature) plane as pictures that can be clicked.

A click writes two numbers into the text field that follows the picture, which viser tells of; the
numbers may be typed there as well.
"""

from __future__ import annotations

import base64
import io
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.lab.maps import MotionMap
from rrrobot.lab.outcome import Outcome

_W, _H = 340, 210
_LEFT, _TOP, _WIDE, _HIGH = 42, 18, 280, 156
_BINS = 140, 78
_FINE = 128
"""Pixels of the map along each side."""
_DEG = 180 / math.pi
_CURVED = 16.0
"""Curvatures that the plane shows [1/m]."""
_TYPE = (
    "const b=this.getBoundingClientRect(),u=(event.clientX-b.left)/b.width,"
    "v=1-(event.clientY-b.top)/b.height,d=this.closest('.rr-map').dataset;"
    "const at=(lo,hi,f)=>(+lo+f*(hi-lo)).toFixed(3);"
    "const field=this.closest('.rr-map').parentElement.nextElementSibling.querySelector('input');"
    "Object.getOwnPropertyDescriptor(HTMLInputElement.prototype,'value').set.call(field,"
    "at(d.left,d.right,u)+' '+at(d.bottom,d.top,v));"
    "field.dispatchEvent(new Event('input',{bubbles:true}))"
)
"""React hears of a field's value only if it is set as by hand."""


class Picture(NamedTuple):
    """A picture with axes; only the point on it changes with the gait."""

    name: str
    image: str
    x: tuple[float, float, str]
    """from, to, label"""
    y: tuple[float, float, str]
    note: str

    def html(self, x: float, y: float) -> str:
        """The picture with a point on it."""
        (left, right, along), (bottom, top, up) = self.x, self.y
        u, v = (x - left) / (right - left), (y - bottom) / (top - bottom)
        inside = 0 <= u <= 1 and 0 <= v <= 1
        px, py = _LEFT + _WIDE * u, _TOP + _HIGH * (1 - v)
        point = (
            f'<circle cx="{px:.1f}" cy="{py:.1f}" r="5" fill="none" stroke="#000" '
            f'stroke-width="3"/><circle cx="{px:.1f}" cy="{py:.1f}" r="5" fill="none" '
            'stroke="#fff" stroke-width="1.4"/>'
            if inside
            else ""
        )
        ticks = "".join(
            f'<text x="{_LEFT + _WIDE * k / 4:.0f}" y="{_TOP + _HIGH + 14}" '
            f'text-anchor="middle">{left + (right - left) * k / 4:g}</text>'
            for k in range(5)
        ) + "".join(
            f'<text x="{_LEFT - 4}" y="{_TOP + _HIGH * (1 - k / 4) + 4:.0f}" '
            f'text-anchor="end">{bottom + (top - bottom) * k / 4:.3g}</text>'
            for k in range(5)
        )
        return (
            f'<div class="rr-map" data-name="{self.name}" data-left="{left}" data-right="{right}" '
            f'data-bottom="{bottom}" data-top="{top}" style="padding:2px 8px">'
            f'<svg viewBox="0 0 {_W} {_H}" style="width:100%;font:10px sans-serif">'
            f'<text x="{_LEFT}" y="11">{up}: {self.note}</text>'
            f'<image href="{self.image}" x="{_LEFT}" y="{_TOP}" width="{_WIDE}" height="{_HIGH}" '
            f'preserveAspectRatio="none"/>{ticks}'
            f'<text x="{_LEFT + _WIDE / 2:.0f}" y="{_H - 4}" text-anchor="middle">{along}</text>'
            f'{point}<rect x="{_LEFT}" y="{_TOP}" width="{_WIDE}" height="{_HIGH}" '
            f'fill="transparent" stroke="#999" style="cursor:crosshair" onclick="{_TYPE}"/>'
            "</svg></div>"
        )


def map_picture(chart: MotionMap, what: str) -> Picture:
    """The map of "speed" or "yaw rate"; offset to the right, phase difference up."""
    if what == "speed":
        shown, colours, low = 1e3 * chart.speed, "viridis", 0.0
        high = float(np.nanmax(shown, initial=1e-9))
        unit = "mm/s"
    else:
        shown, colours = _DEG * chart.yaw_rate, "RdBu"
        high = float(np.nanmax(np.abs(shown), initial=1e-9))
        low, unit = -high, "°/s"
    share = (shown - low) / (high - low)
    # The last column of phases is the first again.
    whole = _finer(np.column_stack((share, share[:, :1])))
    image = _png(_coloured(whole.T[::-1], colours))
    note = f"{what} from {low:.3g} to {high:.3g} {unit}"
    edge = (-180.0, 180.0)
    return Picture("map", image, (*edge, "offset [deg]"), (*edge, "phase difference [deg]"), note)


def plane_picture(chart: MotionMap) -> Picture:
    """All motions of the map as points: curvature to the right, speed up."""
    speed = 1e3 * chart.speed.ravel()
    with np.errstate(divide="ignore", invalid="ignore"):
        curvature = (chart.yaw_rate / chart.speed).ravel()
    good = np.isfinite(speed) & np.isfinite(curvature) & (np.abs(curvature) < _CURVED)
    top = 1.1 * float(speed[good].max(initial=1e-3))
    m, n = _BINS
    i = ((curvature[good] + _CURVED) / (2 * _CURVED) * (m - 1)).astype(int)
    j = (speed[good] / top * (n - 1)).astype(int)
    pixels = np.full((n, m, 3), 246, dtype=np.uint8)
    for du in (0, 1):
        for dv in (0, 1):
            pixels[np.minimum(j + dv, n - 1), np.minimum(i + du, m - 1)] = (60, 110, 160)
    x = (-_CURVED, _CURVED, "curvature [1/m], left is positive")
    note = "gaits of this amplitude"
    return Picture("plane", _png(pixels[::-1]), x, (0.0, top, "speed [mm/s]"), note)


def present(outcome: Outcome) -> tuple[tuple[float, float], tuple[float, float]]:
    """Where a motion stands on the map and on the plane."""
    k = outcome.knobs
    turn = (k.phase[-1] - k.phase[0] + math.pi) % (2 * math.pi) - math.pi
    offset = (k.offset[0] + math.pi) % (2 * math.pi) - math.pi
    return (_DEG * offset, _DEG * turn), (outcome.curvature, 1e3 * outcome.speed)


def _finer(table: Array) -> Array:
    """A table (m, n) at the pixels of a picture, linear between its entries."""
    for _ in range(2):
        at = np.linspace(0, len(table) - 1, _FINE)
        i = np.minimum(at.astype(int), len(table) - 2)
        late = (at - i)[:, None]
        table = ((1 - late) * table[i] + late * table[i + 1]).T
    return table


def _coloured(share: Array, colours: str) -> NDArray[np.uint8]:
    import matplotlib

    found = matplotlib.colormaps[colours](np.clip(np.nan_to_num(share), 0, 1))[..., :3]
    found[~np.isfinite(share)] = 0.75
    return (255 * found).astype(np.uint8)


def _png(pixels: NDArray[np.uint8]) -> str:
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(stream, "PNG")
    return f"data:image/png;base64,{base64.b64encode(stream.getvalue()).decode()}"
