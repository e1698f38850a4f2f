"""One client's laboratory: knobs, scene, motion. Clients share nothing but the robot."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from rrrobot.belly.found import Belly
from rrrobot.checks import Array
from rrrobot.lab.atlas import Atlas
from rrrobot.lab.bellies import collisions
from rrrobot.lab.charts import Charts
from rrrobot.lab.drawing import Drawing
from rrrobot.lab.ghosts import Ghosts
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.layout import STYLE, dock
from rrrobot.lab.outcome import Outcome, Refusal, settle
from rrrobot.lab.panel import Panel, numbers
from rrrobot.lab.player import Player
from rrrobot.lab.searches import Searches
from rrrobot.lab.tabs import home_tab, link_field, motions_tab
from rrrobot.robot.robot import Robot

_KEPT = (0.45, 0.45, 0.45)
_LATE = 1.0
"""After which the panel says that it computes [s]."""


class Session:
    """What one client sees and does.

    Args:
        client: of viser.
        robot: the laboratory's.
        knobs: where the sliders stand at first.
        url: of the page.
        near: a motion of knobs nearby, from which the first search starts.
        belly: of the robot, if it was fitted: what its limbs run into is said.

    Attributes:
        knobs: where they stand.
        outcome: the motion that is shown.
        refusal: why the knobs have none of their own, if they have not.
        latency: from the last move of a slider to the update sent [s].
        cost: processor time of that [s].
    """

    def __init__(
        self,
        client: Any,
        robot: Robot,
        knobs: Knobs,
        url: str,
        near: Outcome | None = None,
        belly: Belly | None = None,
    ) -> None:
        self.client, self.robot, self.knobs, self.belly = client, robot, knobs, belly
        self.outcome: Outcome | None = None
        self._last: Outcome | None = None
        self._near, self._url = near, url
        self.refusal: str | None = None
        self.latency = self.cost = 0.0
        self.drawing = Drawing(client)
        self.player = Player(client, self.drawing.stage)
        self._wanted: tuple[Callable[[], Outcome], float] | None = None
        self._running: Callable[[], Outcome] | None = None
        self._wake, self._closed = threading.Condition(), False
        self._build()
        self._worker = threading.Thread(target=self._work, name="rrrobot lab", daemon=True)
        self._worker.start()
        self.turn(knobs)
        self.player.start()

    def turn(self, knobs: Knobs) -> None:
        """Ask for the motion at other knobs; of several asked for at once, the last one counts."""
        self.knobs = knobs
        self.ask(lambda: settle(self.robot, knobs, self._last or self._near))

    def ask(self, job: Callable[[], Outcome]) -> None:
        """Show what a job comes to, in the place of what is waiting to be shown."""
        with self._wake:
            self._wanted = job, time.perf_counter()
            self._wake.notify_all()

    def overtaken(self) -> bool:
        """Whether something else has been asked for than what is being computed."""
        return self._closed or (self._wanted is not None and self._wanted[0] is not self._running)

    def keep(self, path: Array | None) -> None:
        """Keep a path beside those that come, in grey; None: forget it."""
        if path is None or self.drawing.scene is None:
            self.drawing.stage.remove("/world/ground/kept")
            return
        self.drawing.ribbon("/world/ground/kept", path, self.drawing.scene, _KEPT, 0.1)

    def say(self, words: str) -> None:
        """A note on the page that goes away."""
        self.client.add_notification("rrrobot", words, auto_close_seconds=10.0)

    def settled(self, timeout: float = 30.0) -> bool:
        """Wait until what was asked for is shown."""
        with self._wake:
            return self._wake.wait_for(lambda: self._wanted is None, timeout)

    def close(self) -> None:
        """End its threads."""
        with self._wake:
            self._closed = True
            self._wake.notify_all()
        self.atlas.close()
        self._searches.close()
        self.player.close()

    def _build(self) -> None:
        gui, player = self.client.gui, self.player
        dock(gui, self.client.camera.image_width)
        gui.add_html(STYLE, order=1e6)
        self._numbers = gui.add_html(numbers(None, None))
        self._panel = Panel(gui, self.robot, self.knobs, self.turn)
        buttons = gui.add_button_group("play", ("play / pause", "restart"))

        def pressed(event: Any) -> None:
            if buttons.value == "restart":
                player.restart()
            else:
                player.playing = not player.playing

        buttons.on_click(pressed)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Gait"):
            self._panel.gait_tab()
        with tabs.add_tab("Robot"):
            self._panel.robot_tab()
        with tabs.add_tab("View"):
            self._view_tab()
        with tabs.add_tab("Map"):
            self.atlas = Atlas(gui, self.robot, self.choose, self._refuse)
        with tabs.add_tab("Motions"):
            motions_tab(gui, self)
        with tabs.add_tab("Find"):
            self._searches = Searches(gui, self)
        with tabs.add_tab("Plots"):
            self._charts = Charts(gui, self.robot.legs)
        with tabs.add_tab("Save"):
            home_tab(gui, self)
        self._write_link = link_field(gui, self, self._url)

    def choose(self, knobs: Knobs) -> None:
        """Set all sliders, and ask for the motion."""
        self._panel.show(knobs)
        self.turn(knobs)

    def preset(self, name: str, knobs: Knobs) -> None:
        """Offer a gait as a preset, and choose it."""
        self._panel.offer(name, knobs)
        self.turn(knobs)

    def _view_tab(self) -> None:
        gui, player = self.client.gui, self.player
        speed = gui.add_slider("speed", 0.1, 10.0, 0.1, 1.0, hint="Simulated seconds per second.")
        follow = gui.add_checkbox("follow the robot", False)
        self._panel.horizon()
        frame = gui.add_button("look at the whole path")

        def played(event: Any) -> None:
            player.speed, player.follow = float(speed.value), bool(follow.value)
            player.draw()

        speed.on_update(played)
        follow.on_update(played)
        frame.on_click(lambda event: self.drawing.look())
        for label, paths, shown in (
            ("contact trace", ("/world/ground/trace",), True),
            ("mean path", ("/world/ground/mean",), True),
            ("contact force", ("/world/force/arrow",), True),
            ("friction cone", ("/world/force/cone",), False),
            ("centre of mass", ("/world/mass",), False),
            ("axes", ("/world/axes", "axes"), True),
        ):
            self.drawing.switch(paths, gui.add_checkbox(label, shown))
        self._ghosts = Ghosts(gui, self.drawing, player, lambda: self.turn(self.knobs))

    def _work(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._closed or self._wanted is not None)
                if self._closed:
                    return
                assert self._wanted is not None
                job, asked = self._wanted
                self._running = job
            self._answer(job, asked)
            if self._wanted[0] is job and not self._closed:
                self._judge()
                for words in self._ghosts.show(
                    self.robot, None if self.refusal is not None else self.knobs
                ):
                    self.say(words)
                self.client.flush()
            with self._wake:
                if self._wanted is not None and self._wanted[0] is job:
                    self._wanted = None
                    self._wake.notify_all()

    def _answer(self, job: Callable[[], Outcome], asked: float) -> None:
        """Compute and show; whatever goes wrong is said in the panel, and the page lives on."""
        began = time.thread_time()
        late = threading.Timer(_LATE, self._tell_of_waiting)
        late.daemon = True
        late.start()
        try:
            outcome = job()
        except Refusal as refusal:
            self._refuse(str(refusal))
            return
        except Exception as error:  # a page that stands still would say nothing
            self._refuse(f"{type(error).__name__}: {error}")
            return
        finally:
            late.cancel()
        if self._closed:  # the page was left meanwhile
            return
        self.refusal = None
        first = self.outcome is None
        # The player must not draw a robot that is being replaced.
        with self.player.lock, self.client.atomic():
            scene = self.drawing.draw(outcome)
            self._numbers.content = numbers(outcome, None)
            self._charts.show(outcome)
        self.outcome = outcome
        if outcome.cycle is not None:
            self._last = outcome
        self._write_link(outcome.knobs)
        self.client.flush()
        self.latency, self.cost = time.perf_counter() - asked, time.thread_time() - began
        self.player.show(outcome, scene)
        self.atlas.show(outcome)
        if first:
            self.drawing.show_switches()
            self.drawing.look()

    def _judge(self) -> None:
        """Say what the limbs run into."""
        now = self.outcome
        if self.belly is not None and now is not None and self.refusal is None:
            said = collisions(self.belly, now)
            if said:
                self.outcome = replace(now, words=(*said, *now.words))
                self._numbers.content = numbers(self.outcome, None)

    def _refuse(self, words: str) -> None:
        """Say why there is no motion; the last good one stays."""
        self.refusal = words
        self._numbers.content = numbers(self.outcome, words)
        self.client.flush()

    def _tell_of_waiting(self) -> None:
        self._numbers.content = numbers(self.outcome, None, waiting=True)
        self.client.flush()
