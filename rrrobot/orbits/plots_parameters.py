"""Plots of how orbits depend on parameters: bars of sensitivities, bifurcation diagrams."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

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
    for i in range(len(value) - 1):
        both = stable[i] and stable[i + 1]
        ax.plot(
            value[i : i + 2], height[i : i + 2], color=COLOURS[0] if both else COLOURS[1],
            linestyle="-" if both else (0, (4, 1.5)), linewidth=1.4,
        )  # fmt: skip
    shown = set()
    for kind, i in branch.special:
        label = None if kind in shown else kind
        ax.plot(value[i], height[i], _MARKS[kind], color="#000000", markersize=5, label=label)
        shown.add(kind)
    unit = data[output].attrs.get("units", "")
    name = output.replace("_", " ")
    tidy(ax, f"{branch.parameter.replace('_', ' ')} [{branch.unit}]", f"{name} [{unit}]")
    if shown:
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
