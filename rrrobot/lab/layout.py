"""Where the panel is, and where the camera must stand so that it hides nothing.

On a wide page the panel is docked to the right of the picture; on a phone it is a sheet that covers
the picture's foot.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.view.commands import FIELD_OF_VIEW
from rrrobot.view.scene import View

_PHONE = 576
"""Widest page on which viser has the panel below the picture [px]."""
_TABLET = 1000
"""Widest page on which the panel is to be narrow [px]."""
_SHEET = 0.48
"""Share of the page's height that the panel may cover there."""

STYLE = (
    "<style>"
    ".rr-numbers td{padding:0 1em 0 0;line-height:1.6}"
    ".rr-numbers b{font-weight:600}"
    "[role=tablist] [role=tab]{padding:.7em .5em;font-size:.85em}"
    f"@media(max-width:{_PHONE}px){{"
    # The sheet is the one fixed sheet of paper that is as wide as viser makes it.
    '.mantine-Paper-root[style*="width: 20em"]{width:100%!important;'
    f"max-height:{100 * _SHEET:.0f}%!important}}"
    '.mantine-Paper-root[style*="width: 20em"] div[style*="width: 20em"]{width:100%!important}'
    ".rr-numbers tbody{display:grid;grid-template-columns:1fr 1fr;column-gap:1em}"
    ".rr-numbers tr{display:flex;flex-direction:column}"
    ".rr-numbers td{line-height:1.3;padding:0;font-size:12px}"
    ".rr-numbers td:last-child{padding-bottom:.35em}"
    "}</style>"
)
"""Of the page, as HTML that shows nothing."""


class Framing(NamedTuple):
    """Where the camera stands and what it looks at, each (3,) [m]."""

    position: Array
    look_at: Array


def dock(gui: Any, width: int) -> None:
    """Put the panel beside the picture of a page that is so wide [px]."""
    gui.configure_theme(
        show_logo=False, show_share_button=False,
        control_width="medium" if width <= _TABLET else "large",
    )  # fmt: skip
    gui.main_panel.dock_right()


def framing(view: View, up: Array, size: tuple[int, int]) -> Framing:
    """Where the camera sees the whole of a view in a picture of some width and height [px].

    A view that is w heights wide, in a picture that is a heights wide and whose lower share c is
    covered, needs a camera

        m = max(1 / (1 - c), w / a)

    times as far away. The middle of what is free is c / 2 of the height above the middle of the
    picture, so camera and target go down by c m d tan(field / 2), d being the view's distance.

    Args:
        view: in a picture without a panel.
        up: upward direction of the picture (3,).
        size: of the picture.
    """
    wide, high = (max(1, part) for part in size)
    covered = _SHEET if wide <= _PHONE else 0.0
    camera = max(1 / (1 - covered), view.width * high / wide) * view.camera
    distance = float(np.linalg.norm(camera))
    toward = camera / distance
    upward = up - (up @ toward) * toward
    upward = upward / np.linalg.norm(upward)
    down = covered * distance * math.tan(math.radians(FIELD_OF_VIEW / 2)) * upward
    return Framing(view.target + camera - down, view.target - down)
