"""Figures that a notebook shows however pyplot was imported, or was not.

IPython knows how to draw matplotlib's figures only once pyplot has told it. These say it
themselves: a cell that ends in a figure, or in axes of ours, shows the picture.
"""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rrrobot.inline import png


class InlineAxes(Axes):
    """Axes that show the figure that they are in."""

    def _repr_png_(self) -> bytes | None:
        figure = self.get_figure(root=True)
        return None if figure is None else png(figure)


class InlineFigure(Figure):
    """A figure that shows itself; its axes do too."""

    def add_subplot(self, *args: Any, **kwargs: Any) -> Any:
        if not {"projection", "polar", "axes_class"} & set(kwargs):
            kwargs["axes_class"] = InlineAxes
        return super().add_subplot(*args, **kwargs)

    def _repr_png_(self) -> bytes:
        return png(self)
