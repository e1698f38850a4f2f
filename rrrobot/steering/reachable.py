"""What the gears reach: speeds and curvatures with their boundary, and the legs that give them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from rrrobot.drawing import BLACK, FONT, GREY, PALE, legend_above, line, new_figure, tidy
from rrrobot.errors import ModelError
from rrrobot.steering.gears import Gear
from rrrobot.steering.motions import Motions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PAIRS = (("forward", "backward", "along the body's x axis"), ("left", "right", "along the legs"))
_SHARES = (0.4, 0.6, 0.8)


def reachable_set(motions: Motions | Mapping[str, Motions]) -> Figure:
    """Speed over curvature in all four directions of travel, with the boundary (Figs 21, 22).

    Pale is what the first map reaches; thin lines are gaits of 0.4, 0.6 and 0.8 of the largest
    amplitude; the other maps' boundaries are drawn as lines.

    Args:
        motions: of `motions_of`; of several models by name.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.steering.motions import motions_of
        >>> maps = motions_of(rr.FullModel(rr.Robot.from_parameters()))
        >>> len(rr.steering.reachable_set(maps).axes)
        2
    """
    maps = {"": motions} if isinstance(motions, Motions) else dict(motions)
    figure = new_figure(8.4, 4.0)
    for ax, (ahead, back, title) in zip(figure.subplots(1, 2), _PAIRS, strict=True):
        for number, (name, found) in enumerate(maps.items()):
            for direction, sign in ((ahead, 1.0), (back, -1.0)):
                try:
                    gear = Gear(found, direction)
                except ModelError:
                    if number == 0:
                        raise
                    continue  # a simpler model may lack a direction
                label = name if sign > 0 and name else None
                _boundary(ax, gear, sign, number, label)
        ax.axhline(0.0, color=GREY, linewidth=0.8)
        tidy(ax, "curvature [1/m]", f"speed, {ahead} above, {back} below [mm/s]")
        ax.set_title(title, fontsize=FONT, pad=20 if len(maps) > 1 else 6)
        if len(maps) > 1:
            legend_above(ax)
    return figure


def _boundary(ax: Axes, gear: Gear, sign: float, number: int, label: str | None) -> None:
    curvature, slow, fast = gear.boundary(401)
    if number == 0:
        ax.fill_between(
            curvature, 1e3 * sign * slow, 1e3 * sign * fast, color=PALE, alpha=0.35, linewidth=0
        )
        for share in _SHARES:
            bend, speed = gear.curve(share**2)
            ax.plot(bend, 1e3 * sign * speed, color=BLACK, linewidth=0.5)
    above = np.where(slow > 0.01 * fast.max(), slow, np.nan)  # elsewhere down to zero
    around = np.concatenate((curvature, curvature[::-1]))
    ax.plot(around, 1e3 * sign * np.concatenate((fast, above[::-1])), label=label, **line(number))
