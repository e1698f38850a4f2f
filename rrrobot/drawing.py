"""The look of every plot: colours and lines that differ in grey too, legends beside the data.

Figures are made without pyplot, so nothing is registered globally and no window opens:
`figure.savefig("name.png")` writes one, a notebook shows it.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rrrobot.files import write_whole

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#004488", "#BB5566", "#000000", "#DDAA33")
"""Blue, red, black, yellow of P. Tol's high-contrast scheme: safe for the colour-blind, and far
apart in lightness."""
LINES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)))
BLACK = "#000000"
GREY = "#808080"
PALE = "#A6B8D0"
"""For what lies under a mean."""

FONT = 9
"""Size of axis labels [pt]; ticks and legends are one smaller."""


def line(i: int) -> dict[str, Any]:
    """Colour and line style of the i-th curve of a plot."""
    n = len(COLOURS)
    return {"color": COLOURS[i % n], "linestyle": LINES[(i + i // n) % n], "linewidth": 1.3}


def new_figure(width: float = 6.4, height: float = 4.2) -> Figure:
    """An empty figure [inch] whose layout keeps labels and legends apart."""
    from rrrobot.canvas import InlineFigure

    return InlineFigure(figsize=(width, height), layout="constrained")


def write_figure(figure: Figure, path: Path) -> Path:
    """Write a figure as its suffix says (.png, .pdf, .svg; png without), whole or not at all."""
    stream = io.BytesIO()
    figure.savefig(stream, format=path.suffix.lower().removeprefix(".") or "png", dpi=150)
    return write_whole(path, stream.getvalue())


def new_axes() -> Axes:
    """Axes alone in a new figure."""
    axes: Axes = new_figure().add_subplot()
    return axes


def tidy(ax: Axes, xlabel: str, ylabel: str) -> None:
    """Label the axes (units in brackets) and give them the common look."""
    ax.set_xlabel(xlabel, fontsize=FONT)
    ax.set_ylabel(ylabel, fontsize=FONT)
    ax.tick_params(labelsize=FONT - 1)
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)
    ax.ticklabel_format(useOffset=False)


def legend_above(ax: Axes, handles: list[Artist] | None = None, columns: int = 4) -> None:
    """A legend in rows above the axes, where it covers no data."""
    if handles is None:
        handles = ax.get_legend_handles_labels()[0]
    ax.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=min(len(handles), columns),
        frameon=False,
        fontsize=FONT - 1,
        borderaxespad=0.2,
        handlelength=2.6,
        columnspacing=1.4,
    )
