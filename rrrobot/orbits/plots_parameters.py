"""Plots of how orbits depend on parameters: bars of sensitivities, bifurcation diagrams."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.drawing import COLOURS, FONT, legend_above, new_axes, tidy
from rrrobot.errors import ParameterError
from rrrobot.inline import html_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rrrobot.orbits.branches import Branch
    from rrrobot.orbits.gradients import Sensitivities


def plot_effects(found: Sensitivities, output: str, unit: str, ax: Axes | None, count: int) -> Any:
    """Bars of the largest effects on an output; see `Sensitivities.plot`."""
    names, effects = found.ranked(output)[:count], found.effects(output)
    values = np.array([effects[found.names.index(name)] for name in names])
    ax = ax or new_axes()
    rows = np.arange(len(names))[::-1]
    ax.barh(rows, values, color=[COLOURS[0] if v >= 0 else COLOURS[1] for v in values], height=0.7)
    ax.axvline(0.0, color="#000000", linewidth=0.8)
    label = output.replace("_", " ")
    tidy(ax, f"change of {label} by 0.01 rad or 1 % [{unit}]", "")
    ax.set_yticks(rows, names, fontsize=FONT - 1)
    return ax


_FINE = 12
"""Parts of an interval of a branch that are drawn."""
_MARKS = {"fold": "s", "period doubling": "D", "torus": "o", "branch point": "^"}


def plot_branch(branch: Branch, output: str, ax: Axes | None) -> Any:
    """A bifurcation diagram; see `Branch.plot`."""
    data = branch.to_dataset()
    if output not in data or data[output].dims != ("point",):
        raise ParameterError(
            f"output is {output!r}: it must be speed, yaw_rate, an amplitude such as "
            "roll_amplitude, roll_mean, pitch_mean or normal_force."
        )
    ax = ax or new_axes()
    value, height = branch.value, data[output].values
    stable = branch.stable
    holds = stable[:-1] & stable[1:]
    for both, colour, dash, words in (
        (True, COLOURS[0], "-", "stable"), (False, COLOURS[1], (0, (4, 1.5)), "unstable"),
    ):  # fmt: skip
        for i, (x, y) in enumerate(_runs(value, height, holds == both)):
            ax.plot(
                x, y, color=colour, linestyle=dash, linewidth=1.4, label=None if i else words
            )  # fmt: skip
    shown = set()
    for kind, i in branch.special:
        label = None if kind in shown else kind
        ax.plot(value[i], height[i], _MARKS[kind], color="#000000", markersize=5, label=label)
        shown.add(kind)
    unit = data[output].attrs.get("units", "")
    name = output.replace("_", " ")
    tidy(ax, f"{branch.parameter.replace('_', ' ')} [{branch.unit}]", f"{name} [{unit}]")
    if shown or not holds.all():
        legend_above(ax)
    return ax


def branch_html(branch: Branch) -> str:
    """What a notebook shows of a branch."""
    low, high = branch.value.min(), branch.value.max()
    rows = {
        f"{branch.parameter} [{branch.unit}]": f"{low:.6g} .. {high:.6g}",
        "points": f"{len(branch.cycles)}, {int(branch.stable.sum())} of them hold",
        **{f"{kind} at": f"{branch.value[i]:.9g}" for kind, i in branch.special},
        "ended": branch.ended,
    }
    picture = plot_branch(branch, "speed", None).figure
    return html_table("Branch of limit cycles", rows, figure=picture)


def _runs(x: Array, y: Array, wanted: NDArray[np.bool_]) -> Iterator[tuple[Array, Array]]:
    """Smooth curves through the points of a branch, of the intervals (n - 1,) that are wanted.

    Akima's interpolation over the chord's length, which does not swing beyond the points.
    """
    if len(x) < 2:
        return
    size = [np.ptp(part) or 1.0 for part in (x, y)]
    chord = np.hypot(np.diff(x) / size[0], np.diff(y) / size[1])
    s = np.concatenate(([0.0], np.cumsum(np.maximum(chord, 1e-12))))
    from scipy.interpolate import Akima1DInterpolator, make_interp_spline

    points = np.column_stack((x, y))
    through = Akima1DInterpolator(s, points) if len(s) > 3 else make_interp_spline(s, points, k=1)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], wanted, [False])).astype(int)))
    for first, last in edges.reshape(-1, 2):
        fine = np.linspace(0.0, 1.0, _FINE + 1)[:-1]
        at = (s[first:last, None] + np.diff(s[first : last + 1])[:, None] * fine).ravel()
        yield tuple(np.asarray(through(np.append(at, s[last]))).T)
