"""Searches that take a while: the best gait for a goal, and a way to get free."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from rrrobot.belly.found import Belly
from rrrobot.drive.gaits import SinusoidalGait
from rrrobot.errors import RRRobotError
from rrrobot.escape.confirming import EscapeGait
from rrrobot.escape.story import unstick
from rrrobot.escape.unstuck import Unstuck
from rrrobot.lab.excursions import of_run
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.outcome import Outcome, Refusal, short
from rrrobot.robot.robot import Robot
from rrrobot.studies.optimisation.run import optimise

GOALS = {
    "fastest": "fastest",
    "tightest turn": "tightest",
    "least effort": "efficient",
}
"""What the gait is to be best at, as the page and as `optimise` say it."""
WAYS = ("forward", "backward", "left", "right", "turn left", "turn right")
_LARGEST = 0.5
"""Amplitude [rad]."""
_GAITS, _WAYS = 600, 2000
"""Budgets."""
Tell = Callable[[float, float], object]


class Desk(Protocol):
    """What the tab needs of a session."""

    robot: Robot
    belly: Belly | None
    knobs: Knobs

    def ask(self, job: Callable[[], Outcome]) -> None:
        """Show what a job comes to."""

    def preset(self, name: str, knobs: Knobs) -> None:
        """Offer a gait as a preset, and choose it."""

    def say(self, words: str) -> None:
        """Tell the person."""


def best_gait(given: Robot, knobs: Knobs, goal: str, tell: Tell) -> tuple[Knobs, str]:
    """The best gait of the robot with these masses, losses and this ground, by its limit cycles.

    Args:
        given, knobs: as for `settle`.
        goal: one of `GOALS`.
        tell: told of what is done, and of how much.

    Returns:
        the knobs of it, and what is to be said of it.

    Raises:
        Refusal: there is none.
    """
    if not knobs.damping > 0:
        raise Refusal("Gaits are optimised with losses: raise the damping.")
    try:
        best = optimise(
            knobs.model(given), GOALS[goal], amplitude=(0.0, _LARGEST), settle="orbit",
            budget=_GAITS, progress=tell,
        )  # fmt: skip
    except RRRobotError as error:
        raise Refusal(short(error)) from None
    gait = best.gait
    assert isinstance(gait, SinusoidalGait)
    still = ((0.0,) * given.n_legs,) * len(knobs.overtone)
    found = replace(
        knobs,
        offset=_wrapped(gait.offset),
        amplitude=tuple(gait.amplitude.tolist()),
        phase=_wrapped(gait.phase),
        frequency=float(gait.angular_frequency[0]),
        overtone=still,
        overtone_phase=still,
    )
    words = f"{goal}: {best.value:.4g} {best.goal.unit}, of {best.evaluations} gaits."
    if not best.met:
        words += f" It is the nearest: {'; '.join(best.shortfalls)}."
    return found, words


def way_free(given: Robot | Belly, goal: str, tell: Tell) -> Unstuck:
    """Gaits that get the robot, lying on its belly on level ground, to go somewhere.

    Args:
        given: the robot, whose own shell is the belly where it has no meshes; or its fitted belly.
        goal: one of `WAYS`.
        tell: told of what is done, and of how much.

    Raises:
        Refusal: there is none, with the reason.
    """
    try:
        found = unstick(given, goals=[goal], budget=_WAYS, postures=1, progress=tell)
    except RRRobotError as error:
        raise Refusal(short(error)) from None
    if goal not in found.found:
        raise Refusal(f"No way {goal}: {found.reasons[goal]}")
    return found


def played(knobs: Knobs, way: EscapeGait) -> Outcome:
    """A way to get free as it is confirmed: from rest through the ramp to the settled motion."""
    unit = way.goal.unit
    words = [f"Get it free, {way.goal.name}: {way.value:.3g} {unit}, from rest."]
    if not way.met:
        words.append(f"It is only the nearest: {'; '.join(way.shortfalls)}.")
    return of_run(knobs, lambda: way.trajectory, tuple(words), period=way.gait.period)


class Searches:
    """The tab of searches of one client.

    Args:
        gui: of a client of viser.
        desk: its session.
    """

    def __init__(self, gui: Any, desk: Desk) -> None:
        self._desk, self._closed = desk, False
        with gui.add_folder("best gait"):
            goal = gui.add_dropdown("for", tuple(GOALS))
            self._search(gui, "optimise", lambda tell: self._optimise(goal.value, tell))
        with gui.add_folder("get it free"):
            gui.add_html(
                '<p style="margin:.3em .8em;font-size:13px">The robot lies on its belly on level '
                "ground; gaits are sought that move it, and confirmed with all forces.</p>"
            )
            way = gui.add_dropdown("way", WAYS)
            self._search(gui, "find a way", lambda tell: self._free(way.value, tell))
            self._found = gui.add_dropdown("found", ("-",))
            again = gui.add_button("play it")
        self._ways: dict[str, EscapeGait] = {}
        again.on_click(lambda event: self._play(self._found.value))

    def close(self) -> None:
        """Stop what is searched."""
        self._closed = True

    def _optimise(self, goal: str, tell: Tell) -> None:
        desk = self._desk
        knobs, words = best_gait(desk.robot, desk.knobs, goal, tell)
        desk.preset(f"{goal} (found)", replace(desk.knobs, **_gait_of(knobs)))
        desk.say(words)

    def _free(self, way: str, tell: Tell) -> None:
        found = way_free(self._desk.belly or self._desk.robot, way, tell)
        self._ways[way] = found.best(way)
        self._found.options = tuple(self._ways)
        self._found.value = way
        self._play(way)

    def _play(self, name: str) -> None:
        way = self._ways.get(name)
        if way is not None:
            knobs = self._desk.knobs
            self._desk.ask(lambda: played(knobs, way))

    def _search(self, gui: Any, label: str, work: Callable[[Tell], None]) -> None:
        """A button that runs a search on a thread of its own, its progress, and a way to end it."""
        start, bar = gui.add_button(label), gui.add_progress_bar(0.0, visible=False)
        stop = gui.add_button("stop", visible=False)
        stopped = threading.Event()

        def tell(done: float, total: float) -> None:
            if stopped.is_set() or self._closed:
                raise _Stopped
            bar.value = float(np.clip(100 * done / max(total, 1.0), 0.0, 100.0))

        def run() -> None:
            try:
                work(tell)
            except _Stopped:
                pass
            except Refusal as refusal:
                self._desk.say(str(refusal))
            except Exception as error:  # a bar that stands still would say nothing
                self._desk.say(f"{type(error).__name__}: {error}")
            finally:
                if not self._closed:
                    start.disabled, bar.visible, stop.visible = False, False, False

        def begin(event: Any) -> None:
            stopped.clear()
            start.disabled, bar.value, bar.visible, stop.visible = True, 0.0, True, True
            threading.Thread(target=run, name="rrrobot lab search", daemon=True).start()

        start.on_click(begin)
        stop.on_click(lambda event: stopped.set())


class _Stopped(Exception):
    """The person, or the end of the page, has stopped a search."""


def _gait_of(knobs: Knobs) -> dict[str, Any]:
    names = ("offset", "amplitude", "phase", "frequency", "overtone", "overtone_phase")
    return {name: getattr(knobs, name) for name in names}


def _wrapped(angle: Any) -> tuple[float, ...]:
    """Angles from -pi to pi."""
    return tuple(((np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi).tolist())
