"""Small pictures of the gallery, for the front page: python docs/_ext/posters.py

Runs the code of docs/gallery.md, and writes a picture of each film and figure in docs/images/gallery.
It needs Chromium; the pictures are kept with the pages, which are built without it.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from page_code import run_page
from PIL import Image

from rrrobot.view.chromium import Browser

DOCS = Path(__file__).parent.parent
OUT = DOCS / "images" / "gallery"
SIZE = (480, 300)
MOMENTS = {"forces": 4.0, "drive": 4.0, "bowl": 2.0, "board": 14.0}
"""Of each film [s]."""


def main() -> None:
    """Write all pictures."""
    OUT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        run_page(DOCS / "gallery.md", Path(work))
        with Browser(SIZE, timeout=120.0) as browser:
            for name, moment in MOMENTS.items():
                browser.open(Path(work, f"{name}.html").as_uri())
                browser.run(
                    "for (const id of ['words', 'names', 'curves'])"
                    " document.getElementById(id).hidden = true; page.hold(true)"
                )
                browser.seek(moment)
                _write(Image.fromarray(browser.picture().astype("uint8")), name)
        for path in Path(work).glob("*.png"):
            picture = Image.open(path).convert("RGB")
            picture.thumbnail(SIZE)
            card = Image.new("RGB", SIZE, "white")
            card.paste(
                picture,
                ((SIZE[0] - picture.width) // 2, (SIZE[1] - picture.height) // 2),
            )
            _write(card, path.stem)


def _write(picture: Image.Image, name: str) -> None:
    few = picture.convert("P", palette=Image.Palette.ADAPTIVE, colors=96)
    few.save(OUT / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
