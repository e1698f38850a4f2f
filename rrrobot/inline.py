"""What a notebook shows of a result: a small table, a picture, a film. Text, without a network.

The HTML stands by itself: what is not ours in it, such as a URDF's names, is escaped; pictures and
films are inside it. Jupyter, JupyterLab, VS Code and marimo ask an object for `_repr_html_`.
"""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_CELL = "text-align:left;padding:2px 12px 2px 0"


def html_table(
    title: str,
    rows: Iterable[Sequence[object]] | Mapping[str, object],
    *,
    head: Sequence[object] = (),
    figure: Figure | None = None,
) -> str:
    """A title over rows of cells, and a picture beneath.

    Args:
        title: in bold.
        rows: of cells, or a mapping of name to value.
        head: names of the columns.
        figure: drawn as a PNG within the text.

    Example:
        >>> print(html_table("a < b", {"mass": "2 kg"}))  # doctest: +ELLIPSIS
        <div><b>a &lt; b</b><table>...mass</td><td...>2 kg</td></tr></table></div>
    """
    lines = rows.items() if isinstance(rows, Mapping) else rows
    body = "".join(_row("td", row) for row in lines)
    top = _row("th", head) if head else ""
    picture = "" if figure is None else _picture(figure)
    return f"<div><b>{escape(title)}</b><table>{top}{body}</table>{picture}</div>"


def oscillation(amplitude: float, phase: float, mean: float) -> str:
    """An angle about mean + amplitude sin(omega t + phase) [rad] in words, in degrees.

    An amplitude that is shown as zero has no phase.

    Examples:
        >>> oscillation(0.25, 1.0, 0.0)
        'amplitude 14.324 deg, phase 57.3 deg, mean 0.000 deg'
        >>> oscillation(2e-6, 1.0, 0.1)
        'amplitude 0.000 deg, phase -, mean 5.730 deg'
    """
    swing = f"{math.degrees(amplitude):.3f}"
    at = f"{math.degrees(phase):.1f} deg" if float(swing) else "-"
    return f"amplitude {swing} deg, phase {at}, mean {round(math.degrees(mean), 3) + 0.0:.3f} deg"


def percent(share: float) -> str:
    """A share as text, to two digits or whole.

    Example:
        >>> from rrrobot.inline import percent
        >>> percent(0.0012), percent(0.4321), percent(3.21)
        ('0.12 %', '43 %', '321 %')
    """
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"


def aligned(rows: Iterable[tuple[str, str]]) -> str:
    """Two columns of text.

    Example:
        >>> print(aligned([("speed", "3 mm/s"), ("yaw rate", "0 rad/s")]))
        speed     3 mm/s
        yaw rate  0 rad/s
    """
    rows = list(rows)
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {value}".rstrip() for name, value in rows)


def shows(*names: str) -> Callable[[Any], str]:
    """A `_repr_html_` that shows an object's class and these attributes of it."""

    def show(self: Any) -> str:
        return html_table(type(self).__name__, {name: getattr(self, name) for name in names})

    return show


def html_frame(page: str, *, height: int) -> str:
    """A whole page of its own within a notebook's page, as wide as the cell.

    The page has an origin of its own and may run its scripts: it cannot reach the notebook.

    Args:
        page: HTML.
        height: [px].

    Example:
        >>> html_frame("<p>here</p>", height=100).count("&lt;p&gt;here")
        1
    """
    return (
        f'<iframe srcdoc="{escape(page, quote=True)}" sandbox="allow-scripts" '
        f'style="width:100%;height:{height}px;border:0" allowfullscreen></iframe>'
    )


def png(figure: Figure, dpi: float = 100) -> bytes:
    """A figure as a PNG file."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=dpi)
    return stream.getvalue()


def _picture(figure: Figure) -> str:
    data = base64.b64encode(png(figure)).decode("ascii")
    return f'<img src="data:image/png;base64,{data}" alt="plot" style="max-width:100%">'


def _row(tag: str, cells: Sequence[Any]) -> str:
    inner = "".join(f'<{tag} style="{_CELL}">{escape(str(cell))}</{tag}>' for cell in cells)
    return f"<tr>{inner}</tr>"
