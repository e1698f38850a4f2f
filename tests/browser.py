"""A headless browser for tests: that of films, and pictures of a film's page.

As a program: python -m tests.browser film.html picture.png [time in s]
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from rrrobot.view.chromium import Browser, find_browser

__all__ = ["Browser", "find_browser", "screenshot_html"]


def screenshot_html(
    path_html: str | Path,
    png: str | Path,
    *,
    at_time: float | None = None,
    size: tuple[int, int] = (1280, 720),
    caption: bool = False,
) -> Path:
    """Picture of a film that `rrrobot.view.films.record` wrote.

    Args:
        path_html: the film.
        png: the picture.
        at_time: of the film [s]; its end if None.
        size: width and height in pixels.
        caption: whether the film's caption is in the picture.

    Returns:
        the picture's path.
    """
    with Browser(size) as browser:
        browser.open(Path(path_html).resolve().as_uri())
        browser.run(f"document.getElementById('caption').hidden = {json.dumps(not caption)}")
        browser.seek(browser.run("viewer.animator.duration") if at_time is None else at_time)
        Path(png).write_bytes(browser.png())
    return Path(png)


if __name__ == "__main__":
    when = float(sys.argv[3]) if len(sys.argv) > 3 else None
    print(screenshot_html(sys.argv[1], sys.argv[2], at_time=when))
