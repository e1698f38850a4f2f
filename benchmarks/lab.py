"""The laboratory: time from the move of a slider to the update sent, without a browser.

A client of viser's protocol opens the page's socket on this computer, moves a slider, and waits for
the new numbers; what it measures therefore holds the way there and back. Meant for one core:

    taskset -c 0 python -m benchmarks.lab
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from typing import Any

import numpy as np

import rrrobot as rr

MOVES = 60
FREQUENCY = "frequency [rad/s]"


class Page:
    """What a browser says and hears, without drawing anything.

    Args:
        url: of the laboratory.
    """

    def __init__(self, url: str) -> None:
        import viser
        from websockets.sync.client import connect

        self._socket = connect(
            url.replace("http", "ws"), subprotocols=[f"viser-v{viser.__version__}"],
            max_size=None, compression=None,
        )  # fmt: skip
        self.uuid: dict[str, str] = {}
        """of each labelled control"""
        self.numbers: str | None = None
        """uuid of the panel's numbers"""
        self.bytes = 0
        self.say({
            "type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0),
            "position": (1.0, 1.0, 1.0), "fov": 0.6, "near": 0.01, "far": 1000.0,
            "image_height": 400, "image_width": 600, "look_at": (0.0, 0.0, 0.0),
            "up_direction": (0.0, 0.0, 1.0),
        })  # fmt: skip

    def say(self, message: dict[str, Any]) -> None:
        """Send a message."""
        import msgspec.msgpack

        self._socket.send(msgspec.msgpack.encode(message))

    def hear(self, timeout: float = 60.0) -> list[dict[str, Any]]:
        """The next messages."""
        import msgspec.msgpack
        import zstandard

        raw = self._socket.recv(timeout=timeout)
        assert isinstance(raw, bytes)
        self.bytes += len(raw)
        size = int.from_bytes(raw[8:16], "little")
        plain = zstandard.ZstdDecompressor().decompress(
            raw[16 : 16 + size], max_output_size=int.from_bytes(raw[:8], "little")
        )
        found = list(msgspec.msgpack.decode(plain)["messages"])
        for message in found:
            props = message.get("props") or {}
            if isinstance(props, dict) and props.get("label"):
                self.uuid[props["label"]] = message["uuid"]
            if 'class="rr-numbers"' in str(props.get("content", "")) and self.numbers is None:
                self.numbers = message["uuid"]
        return found

    def wait_for_numbers(self) -> None:
        """Hear until the panel has new numbers; they may come with the panel itself."""
        while True:
            for message in self.hear():
                if message.get("uuid") == self.numbers and "data-speed" in str(message):
                    return

    def move(self, label: str, value: float) -> float:
        """Move a slider; time until the new numbers are here [s]."""
        start = time.perf_counter()
        self.say({
            "type": "GuiUpdateMessage", "uuid": self.uuid[label], "updates": {"value": value}
        })  # fmt: skip
        self.wait_for_numbers()
        return time.perf_counter() - start

    def close(self) -> None:
        """Leave."""
        self._socket.close()


def measure(moves: int = MOVES, *, playing: bool = True) -> dict[str, float]:
    """Latencies over moves of three sliders, the robot playing meanwhile [ms]."""
    rng = np.random.default_rng(0)
    start = time.perf_counter()
    with rr.laboratory(rr.Robot.from_parameters()) as lab:
        page = Page(lab.url)
        page.wait_for_numbers()
        opened = time.perf_counter() - start
        (session,) = lab.sessions.values()
        session.player.playing = playing
        session.atlas.close()
        sliders = {
            FREQUENCY: (6.0, 9.0),
            "damping [mN m s]": (8.0, 14.0),
            "gravity [m/s²]": (8, 11),
        }
        each, cost = [], []
        for k in range(moves):
            label = list(sliders)[k % 3]
            each.append(page.move(label, round(float(rng.uniform(*sliders[label])), 3)))
            assert session.settled() and session.refusal is None
            cost.append(session.cost)
        page.close()
    kept = sorted(each[3:])
    return {
        "page opens, with the engine compiled [s]": opened,
        "median [ms]": 1e3 * statistics.median(kept),
        "95 % [ms]": 1e3 * kept[int(0.95 * len(kept))],
        "largest [ms]": 1e3 * kept[-1],
        "processor time from event to update, median [ms]": 1e3 * statistics.median(cost),
        "processor time from event to update, 95 % [ms]": 1e3 * sorted(cost)[int(0.95 * moves)],
        "sent a move [kB]": page.bytes / 1e3 / moves,
    }


if __name__ == "__main__":
    json.dump({name: round(value, 2) for name, value in measure().items()}, sys.stdout, indent=2)
    print()
