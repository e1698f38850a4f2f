"""Plots of how orbits depend on parameters: bars of sensitivities."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rrrobot.drawing import COLOURS, FONT, new_axes, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rrrobot.orbits.sensitivities import Sensitivities


def plot_effects(found: Sensitivities, output: str, ax: Axes | None, count: int) -> Any:
    """Bars of the largest effects on an output; see `Sensitivities.plot`."""
    from rrrobot.orbits.sensitivities import OUTPUTS

    names, effects = found.ranked(output)[:count], found.effects(output)
    values = np.array([effects[found.names.index(name)] for name in names])
    ax = ax or new_axes()
    rows = np.arange(len(names))[::-1]
    ax.barh(rows, values, color=[COLOURS[0] if v >= 0 else COLOURS[1] for v in values], height=0.7)
    ax.axvline(0.0, color="#000000", linewidth=0.8)
    label = output.replace("_", " ")
    tidy(ax, f"change of {label} by 0.01 rad or 1 % [{OUTPUTS[output]}]", "")
    ax.set_yticks(rows, names, fontsize=FONT - 1)
    return ax
