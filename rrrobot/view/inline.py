"""A film within a notebook."""

from __future__ import annotations

from typing import Any

from rrrobot.checks import finite
from rrrobot.inline import html_frame
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.view.films import film_html


class InlineFilm:
    """A film that a notebook plays where it is shown.

    Attributes:
        page: the whole page, as `record` writes it.
        height: of the frame [px].
    """

    def __init__(self, page: bytes, height: int) -> None:
        self.page, self.height = page, height

    def _repr_html_(self) -> str:
        return html_frame(self.page.decode(), height=self.height)

    def __repr__(self) -> str:
        return f"InlineFilm({len(self.page) / 1e6:.1f} MB): the last line of a notebook's cell"


def show(trajectory: Trajectory, *, height: int = 480, **options: Any) -> InlineFilm:
    """A trajectory as a film that plays inline in Jupyter, JupyterLab, VS Code or marimo.

    The page is within the notebook; it needs no network and no server.

    Args:
        trajectory: what to show.
        height: of the frame [px].
        **options: fps, speed, trace, axes, follow, as for `record`.

    Raises:
        ParameterError: as `record` raises.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> film = rr.show(rr.simulate(model, rr.gait("lateral"), duration=1.0))
        >>> film._repr_html_()[:7]
        '<iframe'
    """
    pixels = round(finite("height", height, "px", above=0))
    return InlineFilm(film_html(trajectory, **options), pixels)
