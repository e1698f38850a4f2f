"""The tab of maps of one client: drawn once the sliders rest, on a thread of its own."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Any

from rrrobot.lab.knobs import Knobs
from rrrobot.lab.maps import MotionMap, inverse, map_key, mappable, motion_map, placed
from rrrobot.lab.outcome import Outcome, Refusal
from rrrobot.lab.pictures import Picture, map_picture, plane_picture, present
from rrrobot.robot.robot import Robot

_REST = 0.6
"""For which the sliders must have been still [s]."""
_RAD = math.pi / 180
_WAIT = (
    '<p style="padding:.4em .8em">The map is drawn for two legs on level ground with losses.</p>'
)


class Atlas:
    """Pictures to click, and fields to type in.

    Args:
        gui: of a client of viser.
        robot: the laboratory's.
        chosen: called with new knobs after a choice.
        refused: called with words after one that cannot be.
    """

    def __init__(
        self,
        gui: Any,
        robot: Robot,
        chosen: Callable[[Knobs], None],
        refused: Callable[[str], None],
    ) -> None:
        self._robot, self._chosen, self._refused = robot, chosen, refused
        self._what = gui.add_button_group("colours", ("speed", "yaw rate"))
        self._map = gui.add_html(_WAIT)
        where = gui.add_text(
            "offset, phase", "", hint="In degrees; a click on the map writes them here."
        )
        self._plane = gui.add_html("")
        motion = gui.add_text(
            "curvature, speed", "", hint="In 1/m and mm/s; the gait that does it is sought."
        )
        self.chart: MotionMap | None = None
        self._pictures: tuple[Picture, Picture] | None = None
        self._outcome: Outcome | None = None
        self._key: object = None
        self._wake, self._closed = threading.Condition(), False
        self._what.on_click(lambda event: self._recolour())
        where.on_update(lambda event: self._place(where.value))
        motion.on_update(lambda event: self._seek(motion.value))
        threading.Thread(target=self._work, name="rrrobot lab map", daemon=True).start()

    def show(self, outcome: Outcome) -> None:
        """Put the point where the motion is; ask for a new map if it has changed."""
        with self._wake:
            self._outcome = outcome
            self._wake.notify_all()
        self._draw()

    def close(self) -> None:
        """End the thread."""
        with self._wake:
            self._closed = True
            self._wake.notify_all()

    def drawn(self, timeout: float = 60.0) -> bool:
        """Wait until the map is the present motion's."""
        with self._wake:
            return self._wake.wait_for(lambda: not self._stale(), timeout)

    def _stale(self) -> bool:
        outcome = self._outcome
        if outcome is None or not mappable(self._robot, outcome.knobs):
            return False
        return self._key != map_key(outcome.knobs)

    def _work(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._closed or self._stale())
                while not self._closed and self._wake.wait(_REST):
                    pass
                if self._closed:
                    return
                assert self._outcome is not None
                knobs = self._outcome.knobs
            if not mappable(self._robot, knobs):
                continue
            chart = motion_map(self._robot, knobs)
            with self._wake:
                if self._closed:  # the page was left meanwhile
                    return
                self.chart, self._key = chart, map_key(knobs)
            self._recolour()
            with self._wake:
                self._wake.notify_all()

    def _recolour(self) -> None:
        chart = self.chart
        if chart is not None:
            self._pictures = map_picture(chart, self._what.value), plane_picture(chart)
            self._draw()

    def _draw(self) -> None:
        outcome, pictures = self._outcome, self._pictures
        if outcome is None or pictures is None or self._closed:
            return
        if not mappable(self._robot, outcome.knobs):
            self._map.content, self._plane.content = _WAIT, ""
            return
        on_map, on_plane = present(outcome)
        self._map.content = pictures[0].html(*on_map)
        self._plane.content = pictures[1].html(*on_plane)

    def _place(self, text: str) -> None:
        numbers = numbers_in(text, 2)
        if numbers is not None and self._outcome is not None:
            if self._robot.n_legs != 2:
                self._refused("The map is for two legs.")
                return
            self._chosen(placed(self._outcome.knobs, numbers[0] * _RAD, numbers[1] * _RAD))

    def _seek(self, text: str) -> None:
        numbers, chart, outcome = numbers_in(text, 2), self.chart, self._outcome
        if numbers is None or chart is None or outcome is None:
            return
        curvature, speed = numbers
        try:
            found = inverse(self._robot, outcome.knobs, chart, 1e-3 * speed, curvature)
        except Refusal as refusal:
            self._refused(str(refusal))
            return
        self._chosen(found)


def numbers_in(text: str, count: int) -> tuple[float, ...] | None:
    """So many finite numbers, or None while they are being typed."""
    try:
        numbers = tuple(float(word) for word in text.replace(",", " ").split())
    except ValueError:
        return None
    if len(numbers) != count or not all(abs(number) < 1e6 for number in numbers):
        return None
    return numbers
