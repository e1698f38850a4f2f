"""The strip of curves beneath a film: the body's angles, the legs', and what their motors give."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from rrrobot.checks import Array
from rrrobot.drawing import COLOURS
from rrrobot.robot.joints import sliding
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.view.commands import AXIS_COLOURS, css

_POINTS = 1500  # of a curve: as many as a screen shows
_WIDE, _HIGH = 1000, 100  # of a plot, in its own units


def leg_colour(i: int) -> str:
    """Colour of the i-th leg's curves and name."""
    return COLOURS[i % len(COLOURS)]


def curves_html(trajectory: Trajectory) -> str:
    """Plots, as HTML, of the body's angles, the legs' angles and motor torques over the time."""
    legs = trajectory.robot.legs
    slides = sliding(trajectory.robot.model, legs)
    scale = np.where(slides, 1000.0, 180 / np.pi)
    units = ("[mm]", "[N]") if slides.all() else ("[deg]", "[N m]")
    if slides.any() and not slides.all():
        units = ("[deg, mm]", "[N m, N]")
    axes = [css(colour) for colour in AXIS_COLOURS]
    ours = [leg_colour(i) for i in range(len(legs))]
    time = trajectory.time
    plots = [
        _plot("body [deg]", time, np.rad2deg(trajectory.euler), ("roll", "pitch", "yaw"), axes)
    ]
    if legs:
        plots.append(_plot(f"legs {units[0]}", time, trajectory.leg_angle * scale, legs, ours))
        plots.append(_plot(f"motors {units[1]}", time, trajectory.leg_torque, legs, ours))
    return "".join(plots)


def _plot(
    title: str, time: Array, values: Array, names: Sequence[str], colours: Sequence[str]
) -> str:
    """Curves of values (n, k), the greatest and the least of them, and zero where it is between."""
    if not np.isfinite(values).all():
        return f"<section><b>{escape(title)}: not known of this run</b></section>"
    low, high = float(values.min()), float(values.max())
    span = high - low or 1.0

    def down(value: Array | float) -> Array:
        return np.asarray(_HIGH * (high - value) / span)

    x = _WIDE * (time - time[0]) / ((time[-1] - time[0]) or 1.0)
    drawn = np.unique(np.linspace(0, len(time) - 1, min(len(time), _POINTS)).round().astype(int))
    lines = []
    if low < 0 < high:
        zero = f"{float(down(0.0)):.1f}"
        lines.append(f'<line x1="0" x2="{_WIDE}" y1="{zero}" y2="{zero}"/>')
    for column, colour in zip(values.T, colours, strict=True):
        at = zip(x[drawn], down(column[drawn]), strict=True)
        dots = " ".join(f"{a:.1f},{b:.1f}" for a, b in at)
        lines.append(f'<polyline stroke="{colour}" points="{dots}"/>')
    keys = "".join(
        f'<span><i style="background:{colour}"></i>{escape(name)}</span>'
        for name, colour in zip(names, colours, strict=True)
    )
    return (
        f"<section><b>{escape(title)} {low:.3g} .. {high:.3g}{keys}</b>"
        f'<svg viewBox="0 0 {_WIDE} {_HIGH}" preserveAspectRatio="none">{"".join(lines)}</svg>'
        "</section>"
    )
