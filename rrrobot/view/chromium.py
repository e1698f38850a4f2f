"""Headless Chromium, driven through its DevTools pipe: opens pages, runs script, takes pictures.

It draws Meshcat's page as any browser does, without a display or a graphics card, so that a film
looks the same in a file and on the page.
"""

from __future__ import annotations

import base64
import io
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rrrobot.errors import OutputError

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",  # WebGL without a graphics card
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-extensions",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--mute-audio",
    "--remote-debugging-pipe",
)

# DevTools speaks through file descriptors 3 and 4; these may be taken by the two themselves.
_ONTO_3_AND_4 = """
import fcntl, os, sys
high = [fcntl.fcntl(int(end), fcntl.F_DUPFD, 10) for end in sys.argv[1:3]]
for number, end in zip((3, 4), high):
    os.dup2(end, number)
    os.close(end)
os.execv(sys.argv[3], sys.argv[3:])
"""


def find_browser() -> str | None:
    """Path of Chromium or Chrome, if there is one."""
    names = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
    return next(filter(None, map(shutil.which, names)), None)


class Browser:
    """One page of a headless browser.

    Args:
        size: of the page (width, height), in the pixels of its layout.
        timeout: longest wait for an answer [s].
        scale: pixels of the picture for each of these; few are drawn fast.

    Attributes:
        requests: addresses that the page has asked for since `open`.
        problems: what the page has complained about on its console since `open`.
    """

    def __init__(
        self, size: tuple[int, int] = (640, 360), timeout: float = 60.0, scale: float = 1.0
    ) -> None:
        executable = find_browser()
        if executable is None:
            raise OutputError(
                "there is no Chromium or Chrome on the PATH, which draws the frames of .mp4, .gif "
                "and .png: install one, or write the film as .html, which needs none."
            )
        self.timeout = timeout
        self.requests: list[str] = []
        self.problems: list[str] = []
        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        to_browser, self._write = os.pipe()
        self._read, from_browser = os.pipe()
        ends = [str(to_browser), str(from_browser)]
        flags = [*FLAGS, f"--user-data-dir={self._profile.name}", "about:blank"]
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-c", _ONTO_3_AND_4, *ends, executable, *flags],
            pass_fds=(to_browser, from_browser),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_browser)
        os.close(from_browser)
        self._unread, self._number, self._session = b"", 0, ""
        try:
            self._attach(size, scale)
        except BaseException:
            self.close()
            raise

    def _attach(self, size: tuple[int, int], scale: float) -> None:
        pages = self.call("Target.getTargets")["targetInfos"]
        target = next(page["targetId"] for page in pages if page["type"] == "page")
        answer = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = answer["sessionId"]
        for domain in ("Page", "Network", "Runtime", "Log"):
            self.call(f"{domain}.enable")
        screen = {"width": size[0], "height": size[1], "deviceScaleFactor": scale, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **screen)

    def open(self, url: str, ready: str = "typeof viewer == 'object'") -> None:
        """Open a page and wait until Meshcat has drawn on it, or until `ready` is true."""
        self.requests.clear()
        self.problems.clear()
        self.call("Page.navigate", url=url)
        self.wait_for(f"document.readyState == 'complete' && ({ready})")

    def wait_for(self, condition: str) -> None:
        """Wait until a JavaScript expression is true."""
        end = time.monotonic() + self.timeout
        while not self.run(condition):
            if time.monotonic() > end:
                raise TimeoutError(f"never true: {condition}; page said {self.problems}")
            time.sleep(0.05)

    def run(self, script: str) -> Any:
        """Value of a JavaScript expression, as JSON carries it."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{script}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def seek(self, at_time: float) -> None:
        """Hold the film at a time [s]."""
        hold = f"viewer.animator.pause(); viewer.animator.seek({at_time})"
        self.run(f"{hold}; page.draw(); viewer.render()")

    def png(self) -> bytes:
        """The page as it looks now, without its controls."""
        was = json.dumps(self.run("page.still"))
        self.run("page.hold(true); if (viewer.needs_render) viewer.render()")
        answer = self.call("Page.captureScreenshot", format="png", optimizeForSpeed=True)
        self.run(f"page.hold({was})")
        return base64.b64decode(answer["data"])

    def picture(self) -> NDArray[np.int64]:
        """The same as pixels (height, width, 3), 0..255."""
        from PIL import Image

        with Image.open(io.BytesIO(self.png())) as image:
            return np.asarray(image.convert("RGB"), dtype=np.int64)

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send one DevTools command and wait for its answer."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self._note(answer)

    def _next(self) -> dict[str, Any]:
        end = time.monotonic() + self.timeout
        while b"\0" not in self._unread:
            ready, _, _ = select.select([self._read], [], [], max(0.0, end - time.monotonic()))
            part = os.read(self._read, 1 << 20) if ready else b""
            if not part:
                raise TimeoutError("the browser does not answer")
            self._unread += part
        message, self._unread = self._unread.split(b"\0", 1)
        return json.loads(message)

    def _note(self, event: dict[str, Any]) -> None:
        method, parameters = event.get("method"), event.get("params", {})
        if method == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])
        elif method == "Network.webSocketCreated":
            self.requests.append(parameters["url"])
        elif method == "Runtime.exceptionThrown":
            self.problems.append(str(parameters["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "assert"):
            self.problems.append(str(parameters["args"]))
        elif method == "Log.entryAdded" and parameters["entry"]["level"] == "error":
            self.problems.append(parameters["entry"]["text"])

    def close(self) -> None:
        """End the browser."""
        for end in (self._write, self._read):
            os.close(end)
        try:
            self._process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._profile.cleanup()

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
