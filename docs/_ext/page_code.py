"""Runs the code of a page: its python blocks in order, and the `$ rrrobot` lines of its consoles.

All blocks of a page share one namespace and one folder. What a block prints and the files it writes
are what the page shows; an error in a block is an error of the page. Site and tests use this alike.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import re
import shlex
import shutil
import sys
import tempfile
import traceback
import warnings
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

FENCE = re.compile(r"^(`{3,}|:{3,})([^\n`]*)\n(.*?)^\1[ \t]*$", flags=re.M | re.S)
"""A fenced block: fence, info string, content."""
SHOWN = (".png", ".svg", ".html")


class PageError(Exception):
    """A block of a page failed."""


class Block(NamedTuple):
    """A block that runs."""

    language: str
    """python or console"""
    code: str
    line: int
    """of its first line in the page"""


class Ran(NamedTuple):
    """What came of a page."""

    output: list[str]
    """of each block"""
    files: list[str]
    """pictures and films, in the page's folder"""


def is_run(info: str) -> bool:
    """Whether a block with this info string is one that runs."""
    return info.split()[:1] in (["python"], ["console"])


def blocks_of(text: str) -> list[Block]:
    """The blocks of a page that run."""
    return [
        Block(match[2].split()[0], match[3], text.count("\n", 0, match.start()) + 2)
        for match in FENCE.finditer(text)
        if is_run(match[2])
    ]


def run_page(path: Path, folder: Path, kept: Path | None = None) -> Ran:
    """Run a page and leave its pictures and films in a folder.

    Args:
        path: of the page, Markdown.
        folder: made if it is not there.
        kept: where results are kept until the page's code or the package changes; None: nowhere.

    Raises:
        PageError: a block failed.
    """
    blocks = blocks_of(path.read_text())
    folder.mkdir(parents=True, exist_ok=True)
    if not blocks:
        return Ran([], [])
    if kept is None:
        return _run(path.name, blocks, folder)
    home = _home(path, kept)
    if not (home / "ran.json").exists():
        for old in kept.glob(f"{_name(path)}-*"):
            shutil.rmtree(old, ignore_errors=True)
        with tempfile.TemporaryDirectory() as fresh:
            ran = _run(path.name, blocks, Path(fresh))
            home.mkdir(parents=True, exist_ok=True)
            for name in ran.files:
                shutil.copy(Path(fresh) / name, home / name)
        (home / "ran.json").write_text(json.dumps(ran))
    ran = Ran(*json.loads((home / "ran.json").read_text()))
    for name in ran.files:
        shutil.copy(home / name, folder / name)
    return ran


def is_kept(path: Path, kept: Path | None) -> bool:
    """Whether a page need not be run anew."""
    nothing = not blocks_of(path.read_text())
    return nothing or (
        kept is not None and (_home(path, kept) / "ran.json").exists()
    )


def _home(path: Path, kept: Path) -> Path:
    said = json.dumps([*blocks_of(path.read_text()), _digest()])
    return kept / f"{_name(path)}-{hashlib.sha256(said.encode()).hexdigest()[:24]}"


def _name(path: Path) -> str:
    """Of a page among others: pages of two folders may have one name."""
    return f"{path.parent.name}-{path.stem}"


def _run(page: str, blocks: list[Block], folder: Path) -> Ran:
    names: dict[str, Any] = {"__name__": "__main__"}
    output, before = [], Path.cwd()
    with tempfile.TemporaryDirectory() as work:
        os.chdir(work)
        try:
            for block in blocks:
                run = _python if block.language == "python" else _console
                output.append(run(page, block, names).strip("\n"))
        finally:
            os.chdir(before)
        files = sorted(p.name for p in Path(work).iterdir() if p.suffix in SHOWN)
        for name in files:
            shutil.copy(Path(work) / name, folder / name)
    return Ran(output, files)


def _python(page: str, block: Block, names: dict[str, Any]) -> str:
    said = io.StringIO()
    # Blank lines before the code, so that a traceback names the page's own lines.
    code = "\n" * (block.line - 1) + block.code
    with contextlib.redirect_stdout(said), warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            exec(compile(code, page, "exec"), names)
        except Exception:
            raise PageError(
                f"{page}, block at line {block.line}:\n{traceback.format_exc()}"
            ) from None
    return said.getvalue()


def _console(page: str, block: Block, names: dict[str, Any]) -> str:
    from click.testing import CliRunner

    from rrrobot.cli.main import cli

    said = []
    for command in re.sub(r"\\\n\s*", "", block.code).splitlines():
        words = shlex.split(command.removeprefix("$ "), comments=True)
        if not command.startswith("$ rrrobot "):
            raise PageError(
                f"{page}, line {block.line}: a console block is '$ rrrobot ...' only."
            )
        result = CliRunner().invoke(cli, words[1:], prog_name="rrrobot")
        if result.exit_code != 0:
            raise PageError(
                f"{page}, line {block.line}: {command}\n{result.output}"
            )
        said.append(result.stdout.strip("\n"))
    return "\n".join(said)


@cache
def _digest() -> str:
    """Of the package's source and of Python's version."""
    import rrrobot

    source = hashlib.sha256(sys.version.encode())
    for path in sorted(Path(rrrobot.__file__).parent.rglob("*")):
        if path.suffix in (".py", ".js", ".css", ".html"):
            source.update(path.read_bytes())
    source.update(Path(__file__).read_bytes())
    return source.hexdigest()
