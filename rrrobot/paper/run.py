"""Make the tables, figures and claims of the paper, and the report."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from difflib import get_close_matches
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from rrrobot.errors import OutputError, ParameterError, RRRobotError
from rrrobot.files import make_folder, read_json, write_whole
from rrrobot.paper.claims import CLAIMS
from rrrobot.paper.errata import ERRATA
from rrrobot.paper.item import Item, row_from_data, rows_to_data
from rrrobot.paper.paths import PATHS
from rrrobot.paper.planes import PLANES
from rrrobot.paper.report import About, Section, markdown, page
from rrrobot.paper.schematics import SCHEMATICS
from rrrobot.paper.tables import TABLES
from rrrobot.paper.workshop import Workshop
from rrrobot.progress import Progress, progress_of

_FIGURES = sorted((*SCHEMATICS, *PATHS, *PLANES), key=lambda item: int(item.key[3:]))
ITEMS: tuple[Item, ...] = (*TABLES, *_FIGURES, *CLAIMS, *ERRATA)
"""All of the paper, in the order of the report."""
_PACKAGES = ("rrrobot", "pin", "numpy", "scipy", "numba", "matplotlib")


class Reproduction(NamedTuple):
    """What was made.

    Attributes:
        sections: of the report, one an item.
        report: the HTML page.
        kept: keys of items that an earlier run had finished.
    """

    sections: list[Section]
    report: Path
    kept: list[str]


def reproduce(
    out: str | Path,
    *,
    only: Sequence[str] | str | None = None,
    quick: bool = False,
    resume: bool = True,
    progress: Progress = False,
) -> Reproduction:
    """Make the paper's tables, figures and claims anew, and a report that sets them beside it.

    Each finished item leaves `<key>.json` and its pictures in the folder, so that an interrupted
    run goes on where it stopped. What another version of the code made is made again.

    Args:
        out: folder, made if it is missing; it takes report.html, report.md, pictures and data.
        only: keys of items, such as ["fig18", "table3"] or "fig18,table3"; all if None. The report
            holds these and what is finished already.
        quick: coarse grids for the maps, and the momentum method.
        resume: False: make what is finished anew.
        progress: see `rrrobot.progress`; in items.

    Returns:
        the sections and the report.

    Raises:
        ParameterError: a key that is not one of `ITEMS`.
        OutputError: the folder cannot be made or written, or a quick run would replace a full one.
        KeyboardInterrupt: Ctrl-C; the message says how much is finished and kept.

    Example:
        >>> import rrrobot as rr
        >>> found = rr.paper.reproduce("paper", only=["table3"])
        >>> found.sections[0].rows[0]["verdict"]
        'agrees'
    """
    chosen = _chosen(only)
    folder = make_folder(out)
    mark = _fingerprint(quick)
    if quick and any(_finished(folder, item, _fingerprint(False)) for item in ITEMS):
        raise OutputError(
            f"{str(folder)!r} holds a full run, which a quick one would replace: name another "
            "folder."
        )
    finished = {item.key: found for item in ITEMS if (found := _finished(folder, item, mark))}
    kept = [item.key for item in chosen if item.key in finished] if resume else []
    shop = Workshop(quick=quick)
    todo = [item for item in chosen if item.key not in kept]
    try:
        with progress_of(progress, "items", len(todo), "items") as tell:
            for i, item in enumerate(todo):
                if tell is not None:
                    tell(i, item.key)
                finished[item.key] = _make(item, shop, folder, mark)
            if tell is not None:
                tell(len(todo))
    except KeyboardInterrupt:
        _report(folder, finished, quick)
        done = sum(item.key in finished for item in chosen)
        raise KeyboardInterrupt(
            f"{done} of {len(chosen)} items are in {str(folder)!r}; the same call goes on there."
        ) from None
    report = _report(folder, finished, quick)
    asked = [finished[item.key] for item in chosen]
    return Reproduction(asked, report, kept)


def _report(folder: Path, finished: dict[str, Section], quick: bool) -> Path:
    sections = [finished[item.key] for item in ITEMS if item.key in finished]
    missing = [item.key for item in ITEMS if item.key not in finished]
    about = About({name: version(name) for name in _PACKAGES}, quick, missing)
    write_whole(folder / "report.md", markdown(sections, about).encode())
    return write_whole(folder / "report.html", page(sections, about).encode())


def _chosen(only: Sequence[str] | str | None) -> list[Item]:
    if only is None:
        return list(ITEMS)
    known = [item.key for item in ITEMS]
    keys = only.split(",") if isinstance(only, str) else only
    wrong = [key for key in keys if key not in known]
    if wrong or not keys:
        near = [n for key in wrong for n in get_close_matches(key, known, 2, 0.5)]
        hint = f" Did you mean {' or '.join(near)}?" if near else ""
        raise ParameterError(
            f"no item {', '.join(map(repr, wrong)) or 'is named'}.{hint} `rrrobot reproduce "
            "--list` lists all keys, from table1 to fig22, the claims and the errata."
        )
    return [item for item in ITEMS if item.key in keys]


def _make(item: Item, shop: Workshop, folder: Path, mark: str) -> Section:
    from rrrobot.drawing import write_figure

    found = item.make(shop)
    for row in found.rows:
        if not isinstance(row.ours, str) and not math.isfinite(row.ours):
            raise RRRobotError(
                f"{item.key}: {row.quantity!r} came out as {row.ours}; nothing of it was written. "
                "Please report this."
            )
    files = [
        write_figure(figure, folder / f"{name}.png").name for name, figure in found.figures.items()
    ]
    # Written last: where it is, the pictures are whole.
    section = Section(
        item.key, item.title, item.shows, rows_to_data(found.rows), list(found.remarks), files
    )
    data = section._asdict() | {"made_by": mark}
    text = json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False)
    write_whole(folder / f"{item.key}.json", (text + "\n").encode())
    return section


def _finished(folder: Path, item: Item, mark: str) -> Section | None:
    """What an earlier run of the same code made, if it is whole."""
    try:
        data: dict[str, Any] = read_json(folder / f"{item.key}.json")
        if data.pop("made_by") != mark:
            return None
        section = Section(**data)
        for row in section.rows:
            if rows_to_data((row_from_data(row),)) != [row]:
                return None
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None
    return section if all((folder / name).is_file() for name in section.files) else None


def _fingerprint(quick: bool) -> str:
    """Of the code, what it builds on, and the grids."""
    digest = hashlib.sha256()
    root = Path(__file__).parent.parent
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    digest.update(repr(([version(name) for name in _PACKAGES], quick)).encode())
    return digest.hexdigest()[:16]
