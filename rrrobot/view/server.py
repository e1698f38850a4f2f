"""Serves the viewer's page, or a film, to this computer alone.

The server is a thread of the script that draws: it listens on the loopback interface and nowhere
else, takes no commands from the network, and ends with the script however that ends.
"""

from __future__ import annotations

import atexit
import contextlib
import socket
import threading
from collections.abc import Iterable
from typing import Any, NamedTuple

from rrrobot.errors import OutputError
from rrrobot.view.page import live_page, pack

LOOPBACK = "127.0.0.1"
MOST_CONNECTIONS = 64
"""Tabs take two each: one for the page, one for its commands."""
_MOST_BYTES = 65536
"""Of a request; pages ask with a few hundred, and send nothing."""


class SceneServer:
    """Shows one page in any number of browser tabs and keeps them up to date.

    Args:
        title: of the page.
        port: on the loopback interface; any free one if None.
        page: to serve instead of one that takes commands, such as a film.

    Attributes:
        url: address of the page.

    Raises:
        OutputError: the port cannot be had.
    """

    def __init__(self, title: str, port: int | None = None, page: bytes | None = None) -> None:
        import asyncio

        self._page = live_page(title) if page is None else page
        try:
            self._socket = socket.create_server((LOOPBACK, port or 0))
        except OSError as error:
            raise OutputError(
                f"cannot serve the viewer on port {port}: {error}. Name another port, or none."
            ) from None
        self.url = f"http://{LOOPBACK}:{self._socket.getsockname()[1]}/"
        self._scene: dict[_Key, bytes] = {}
        self._tabs: set[Any] = set()
        self._watched = threading.Event()
        ready = threading.Event()
        self._thread = threading.Thread(
            target=lambda: asyncio.run(self._serve(ready)), name="rrrobot viewer", daemon=True
        )
        self._thread.start()
        while not ready.wait(0.1):
            if not self._thread.is_alive():
                self._socket.close()
                raise OutputError("the viewer's server could not start; its thread says why.")
        atexit.register(self.close)

    def send(self, commands: Iterable[dict[str, Any]]) -> None:
        """Carry out commands in every tab, those opened later included."""
        if not self._thread.is_alive():
            raise OutputError("the viewer is closed: make a new Viewer to go on.")
        packed = [(_key(command), pack(command)) for command in commands]
        self._loop.call_soon_threadsafe(self._forward, packed)

    def delete(self, path: str) -> None:
        """Take a node and all below it out of the scene."""
        self.send([{"type": "delete", "path": path}])

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until a browser shows the page; False if none does within the timeout [s]."""
        return self._watched.wait(timeout)

    def close(self) -> None:
        """Stop serving; again does nothing."""
        atexit.unregister(self.close)
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._stop.set)
            self._thread.join(timeout=5.0)

    async def _serve(self, ready: threading.Event) -> None:
        import asyncio

        from tornado.httpserver import HTTPServer

        self._loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        server = _limited(HTTPServer)(
            _application(self), max_body_size=_MOST_BYTES, max_header_size=_MOST_BYTES,
            max_buffer_size=2**20, idle_connection_timeout=60, body_timeout=10,
        )  # fmt: skip
        self._socket.setblocking(False)
        server.add_socket(self._socket)
        ready.set()
        await self._stop.wait()
        server.stop()
        for tab in tuple(self._tabs):
            tab.close()
        await server.close_all_connections()

    def _forward(self, packed: list[tuple[_Key, bytes]]) -> None:
        for key, data in packed:
            _put(self._scene, key, data)
            if key.type == "delete":
                del self._scene[key]
            for tab in self._tabs:
                tab.put(key, data)

    def _opened(self, tab: Any) -> None:
        for key, data in self._scene.items():
            tab.put(key, data)
        self._tabs.add(tab)
        self._watched.set()


class _Key(NamedTuple):
    """What a command overrides: any earlier one with the same key."""

    path: str
    type: str
    property: str


def _key(command: dict[str, Any]) -> _Key:
    return _Key(command["path"], command["type"], command.get("property", ""))


def _put(commands: dict[_Key, bytes], key: _Key, data: bytes) -> None:
    """Add a command to those that it follows, without those that it makes void."""
    commands.pop(key, None)
    if key.type == "delete":
        for earlier in [k for k in commands if f"{k.path}/".startswith(f"{key.path}/")]:
            del commands[earlier]
    commands[key] = data


def _limited(kind: Any) -> Any:
    """Tornado's server with so many connections at most; one more is closed as it comes."""

    class Limited(kind):  # type: ignore[misc]
        def initialize(self, *args: Any, **options: Any) -> None:
            super().initialize(*args, **options)
            self.open: list[Any] = []

        def handle_stream(self, stream: Any, address: Any) -> None:
            self.open = [other for other in self.open if not other.closed()]
            if len(self.open) >= MOST_CONNECTIONS:
                stream.close()
                return
            self.open.append(stream)
            super().handle_stream(stream, address)

    return Limited


def _application(scene: SceneServer) -> Any:
    import asyncio

    from tornado import web, websocket

    class Page(web.RequestHandler):
        def get(self) -> None:
            self.set_header("Cache-Control", "no-store")
            self.finish(scene._page)

    class Commands(websocket.WebSocketHandler):
        """A tab. Tornado lets in only pages of this very origin; what they send is not read."""

        def open(self, *_: str) -> None:
            self.waiting: dict[_Key, bytes] = {}
            self.more = asyncio.Event()
            self.task = asyncio.create_task(self.pass_on())
            scene._opened(self)

        def put(self, key: _Key, data: bytes) -> None:
            _put(self.waiting, key, data)
            self.more.set()

        async def pass_on(self) -> None:
            # One command at a time: while a slow tab takes it, newer ones replace older ones.
            with contextlib.suppress(websocket.WebSocketClosedError):
                while await self.more.wait():
                    self.more.clear()
                    while self.waiting:
                        data = self.waiting.pop(next(iter(self.waiting)))
                        await self.write_message(data, binary=True)

        def on_message(self, _: str | bytes) -> None:
            pass

        def on_close(self) -> None:
            self.task.cancel()
            scene._tabs.discard(self)

    application = web.Application(
        log_function=lambda _: None, websocket_max_message_size=_MOST_BYTES
    )
    # Other host names are not ours: a hostile site may point one at the loopback address.
    handlers: list[Any] = [(r"/", Page), (r"/commands", Commands)]
    application.add_handlers(r"(127\.0\.0\.1|localhost)", handlers)
    return application
