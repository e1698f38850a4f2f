"""Sphinx: runs the code of every page, and puts what it prints, draws and films into the page.

After each block stands what it printed. `![caption](name)` alone on a line shows a picture (.png,
.svg) or plays a film (.html) that a block of the page wrote, or a picture beside the page. A block
with `hide` after its language runs, and is not shown.
"""

from __future__ import annotations

import html
import re
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from page_code import FENCE, PageError, Ran, is_kept, is_run, run_page
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

from rrrobot.view.page import meshcat_script

_SHOW = re.compile(r"^!\[([^\]]*)\]\(([\w./-]+)\)$", flags=re.M)


def _run_all(app: Sphinx) -> None:
    """Run every page before Sphinx reads the first, two at a time."""
    kept = Path(app.config.pages_cache) if app.config.pages_cache else None
    names = sorted(app.project.discover(app.config.exclude_patterns))
    work = {
        name: (Path(app.srcdir, f"{name}.md"), _folder(app, name), kept)
        for name in names
    }
    slow = [name for name in names if not is_kept(work[name][0], kept)]
    ran: dict[str, Ran] = {}
    if slow:
        print(f"running the code of {len(slow)} pages", file=sys.stderr)
    try:
        if len(slow) > 1:
            # New processes: a page may change what a process has (its folder, what it imported).
            with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
                for name, found in zip(
                    slow, pool.map(run_page, *_columns(work, slow)), strict=True
                ):
                    ran[name] = found
        for name in names:
            if name not in ran:
                ran[name] = run_page(*work[name])
    except PageError as error:
        raise ExtensionError(str(error)) from None
    for name in names:
        for film in _folder(app, name).glob("*.html"):
            _share_script(film)
    app.pages_ran = ran  # type: ignore[attr-defined]


def _columns(work: dict[str, Any], names: list[str]) -> list[list[Any]]:
    return [
        list(column) for column in zip(*(work[name] for name in names), strict=True)
    ]


def _share_script(film: Path) -> None:
    """Take Meshcat's script, most of a film, out of it into one file for all films."""
    script, page = meshcat_script(), film.read_text()
    shared = film.parent.parent / "meshcat.js"
    if not shared.exists():
        shared.write_text(script)
    inside, outside = "script-src 'unsafe-inline'", " file: http: https:"
    page = page.replace(inside, inside + outside, 1)
    tag = '<script src="../meshcat.js"></script>'
    film.write_text(page.replace(f"<script>{script}</script>", tag, 1))


def _folder(app: Sphinx, name: str) -> Path:
    return Path(app.outdir) / "_made" / name.replace("/", "-")


def _insert(app: Sphinx, name: str, source: list[str]) -> None:
    ran = app.pages_ran[name]  # type: ignore[attr-defined]
    output, text = iter(ran.output), source[0]
    up = "../" * name.count("/")
    parts, at, shown = [], 0, []
    source_folder = Path(app.srcdir, name).parent

    def show(match: re.Match[str]) -> str:
        caption, file = match[1], match[2]
        if file not in ran.files:
            if (source_folder / file).exists():
                return f"```{{figure}} {file}\n:alt: {caption}\n\n{caption}\n```\n"
            # The code that draws it was skipped: something optional is not installed.
            return f"*Not drawn here: {caption}.*"
        shown.append(file)
        return _figure(caption, f"{up}_made/{name.replace('/', '-')}/{file}")

    for block in FENCE.finditer(text):
        parts.append(_SHOW.sub(show, text[at : block.start()]))
        at = block.end()
        words = block[2].split()
        if "hide" not in words:
            if is_run(block[2]):
                parts.append(block[0].replace(block[2], words[0], 1))
            else:  # a box of text may show pictures, code may not
                box = block[1].startswith(":")
                parts.append(_SHOW.sub(show, block[0]) if box else block[0])
        if is_run(block[2]):
            said = next(output)
            if said and "hide" not in words:
                parts.append(
                    f"\n\n````{{code-block}} text\n:class: output\n\n{said}\n````\n"
                )
    parts.append(_SHOW.sub(show, text[at:]))
    unseen = sorted(set(ran.files) - set(shown))
    if unseen:
        raise ExtensionError(
            f"{name}: no one sees {', '.join(unseen)}, which its code writes."
        )
    source[0] = "".join(parts)


def _figure(caption: str, url: str) -> str:
    words = html.escape(caption)
    inside = (
        f'<iframe src="{url}" loading="lazy" title="{words}"></iframe>'
        if url.endswith(".html")
        else f'<a href="{url}"><img src="{url}" alt="{words}" loading="lazy"></a>'
    )
    kind = "film" if url.endswith(".html") else "picture"
    figure = f'<figure class="made {kind}">{inside}<figcaption>{words}</figcaption></figure>'
    return f"\n```{{raw}} html\n{figure}\n```\n"


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to Sphinx."""
    app.add_config_value("pages_cache", "", "")
    app.connect("builder-inited", _run_all)
    app.connect("source-read", _insert, priority=400)
    return {"version": "1", "parallel_read_safe": False}
