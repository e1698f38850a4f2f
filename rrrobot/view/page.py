"""Meshcat's viewer page: a film as one file that needs no network, or one that takes commands.

The page holds Meshcat's own script, main.min.js, and ours, which lie beside this file: page.js
frames the robot on wide and narrow pages, film.js plays. Commands are MessagePack, as Meshcat
sends them.
"""

from __future__ import annotations

import base64
import html
import importlib.util
import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rrrobot.errors import MissingExtraError
from rrrobot.view.commands import FIELD_OF_VIEW, WIDTH

_EXTENSIONS = {"float32": 0x17, "uint32": 0x16}
_HERE = Path(__file__).parent
_CONNECT = 'viewer.connect("ws://" + location.host + "/commands");'


def pack(command: dict[str, Any]) -> bytes:
    """A command as Meshcat's viewer reads it; arrays become typed arrays of JavaScript."""
    import umsgpack

    return bytes(umsgpack.packb(_plain(command)))


def film_page(
    title: str, commands: Iterable[dict[str, Any]], film: Mapping[str, Any], curves: str = ""
) -> bytes:
    """A page that carries out the commands, in their order, and needs nothing else.

    Args:
        title: and caption; not HTML.
        commands: of Meshcat, an animation among them or none.
        film: what film.js asks for: see `rrrobot.view.marks.Marks`.
        curves: HTML of what is plotted beneath the film.
    """
    texts = ",\n".join(f'"{base64.b64encode(pack(command)).decode()}"' for command in commands)
    # In a script, "<" may begin what ends it.
    data = json.dumps(film).replace("<", "\\u003c")
    script = _part("page.js", lens=_LENS) + _part("film.js", commands=texts, film=data)
    return _page(title, script, "'none'", _part("bar.html", curves=curves))


def live_page(title: str) -> bytes:
    """A page that carries out the commands that its server sends."""
    return _page(title, _part("page.js", lens=_LENS) + _CONNECT, "ws:", "")


_LENS = json.dumps((FIELD_OF_VIEW, WIDTH))


def meshcat_script() -> str:
    """Meshcat's own script, as it is within every page."""
    spec = importlib.util.find_spec("meshcat")
    if spec is None or not spec.submodule_search_locations:
        raise MissingExtraError("the viewer needs Meshcat: pip install meshcat.")
    path = Path(spec.submodule_search_locations[0], "viewer", "dist", "main.min.js")
    return path.read_text("utf-8")


def _page(title: str, script: str, connect: str, below: str) -> bytes:
    return _part(
        "page.html", title=html.escape(title), connect=connect, style=_part("page.css"),
        below=below, meshcat=meshcat_script(), script=script,
    ).encode()  # fmt: skip


def _part(name: str, **parts: str) -> str:
    """A file beside this one with its {{marks}} filled in, all at once."""
    text = (_HERE / name).read_text("utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda mark: parts[mark[1]], text) if parts else text


def _plain(value: Any) -> Any:
    import umsgpack

    if isinstance(value, np.ndarray):
        return umsgpack.Ext(_EXTENSIONS[value.dtype.name], value.tobytes())
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    return value
