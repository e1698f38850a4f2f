"""One client's laboratory: knobs, scene, motion. Clients share nothing but the robot."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.robot.robot import Robot
from rrrobot.view.commands import FIELD_OF_VIEW, Colour, material, ribbon_mesh, set_mesh
from rrrobot.view.film import thin
from rrrobot.view.lab.atlas import Atlas
from rrrobot.view.lab.charts import Charts
from rrrobot.view.lab.knobs import Knobs
from rrrobot.view.lab.layout import STYLE, Framing, dock, framing
from rrrobot.view.lab.outcome import Outcome, Refusal, ghost, settle
from rrrobot.view.lab.panel import Panel, numbers
from rrrobot.view.lab.player import Player
from rrrobot.view.lab.stage import Stage
from rrrobot.view.lab.tabs import home_tab, link_field, motions_tab
from rrrobot.view.scene import Scene

_MEAN = (0.10, 0.35, 0.75)
_KEPT = (0.45, 0.45, 0.45)
GHOSTS = {"pivoting": (0.10, 0.60, 0.30), "decoupled": (0.95, 0.60, 0.10)}
"""Other models, and the colours of their paths."""
_LATE = 1.0
"""After which the panel says that it computes [s]."""
_MOST_POINTS = 6000
"""Of the path; a longer one is drawn more coarsely."""
_LAYING_OUT = 3.0
"""For which a browser may still be settling where the panel is [s]."""


class Session:
    """What one client sees and does.

    Args:
        client: of viser.
        robot: the laboratory's.
        knobs: where the sliders stand at first.
        url: of the page.
        near: a motion of knobs nearby, from which the first search starts.

    Attributes:
        knobs: where they stand.
        outcome: the motion that is shown.
        refusal: why the knobs have none of their own, if they have not.
        latency: from the last move of a slider to the update sent [s].
        cost: processor time of that [s].
    """

    def __init__(
        self, client: Any, robot: Robot, knobs: Knobs, url: str, near: Outcome | None = None
    ) -> None:
        self.client, self.robot, self.knobs = client, robot, knobs
        self.outcome: Outcome | None = None
        self._last: Outcome | None = None
        self._near, self._url = near, url
        self.refusal: str | None = None
        self.latency = self.cost = 0.0
        self._stage = Stage(client.scene)
        self.player = Player(client, self._stage)
        self._scene: Scene | None = None
        self._staged = 0.0
        self._framed: tuple[Framing, tuple[int, int], float] | None = None
        self._wanted: tuple[Callable[[], Outcome], float] | None = None
        self._running: Callable[[], Outcome] | None = None
        self._wake, self._closed = threading.Condition(), False
        self._build()
        client.camera.on_update(self._resized)
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
        if path is None or self._scene is None:
            self._stage.remove("/world/ground/kept")
            return
        self._ribbon("/world/ground/kept", path, self._scene, _KEPT, 0.1)

    def say(self, words: str) -> None:
        """A note on the page that goes away."""
        self.client.add_notification("rrrobot", words, auto_close_seconds=10.0)

    def settled(self, timeout: float = 30.0) -> bool:
        """Wait until what was asked for is shown."""
        with self._wake:
            return self._wake.wait_for(lambda: self._wanted is None, timeout)

    def close(self) -> None:
        """End its threads."""
        self.player.close()
        self.atlas.close()
        with self._wake:
            self._closed = True
            self._wake.notify_all()

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
        with tabs.add_tab("Plots"):
            self._charts = Charts(gui, self.robot.legs)
        with tabs.add_tab("Take home"):
            home_tab(gui, self)
        self._write_link = link_field(gui, self, self._url)

    def choose(self, knobs: Knobs) -> None:
        """Set all sliders, and ask for the motion."""
        self._panel.show(knobs)
        self.turn(knobs)

    def _view_tab(self) -> None:
        gui, player, stage = self.client.gui, self.player, self._stage
        speed = gui.add_slider("speed", 0.1, 10.0, 0.1, 1.0, hint="Simulated seconds per second.")
        follow = gui.add_checkbox("follow the robot", False)
        self._panel.horizon()
        frame = gui.add_button("look at the whole path")

        def played(event: Any) -> None:
            player.speed, player.follow = float(speed.value), bool(follow.value)
            player.draw()

        speed.on_update(played)
        follow.on_update(played)
        frame.on_click(lambda event: self._look())
        for label, paths, shown in (
            ("contact trace", ("/world/ground/trace",), True),
            ("mean path", ("/world/ground/mean",), True),
            ("contact force", ("/world/force/arrow",), True),
            ("friction cone", ("/world/force/cone",), False),
            ("centre of mass", ("/world/mass",), False),
            ("axes", ("/world/axes", "axes"), True),
        ):
            self._switch(label, paths, shown, stage)
        self._ghosts = {
            "pivoting": gui.add_checkbox("pivoting model (green)", False),
            "decoupled": gui.add_checkbox("single-axis models (orange)", False),
        }
        for box in self._ghosts.values():
            box.on_update(lambda event: self.turn(self.knobs))

    def _switch(self, label: str, paths: tuple[str, ...], shown: bool, stage: Stage) -> None:
        box = self.client.gui.add_checkbox(label, shown)
        self._hidden: dict[str, Any] = getattr(self, "_hidden", {})
        self._hidden.update(dict.fromkeys(paths, box))
        box.on_update(lambda event: self._show_switches())

    def _show_switches(self) -> None:
        for path, box in self._hidden.items():
            if path == "axes" and self._scene is not None:
                path = f"{self._scene.path(1)}/axes"
            self._stage.show(path, bool(box.value))

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
            if self._wanted[0] is job:
                self._show_ghosts(self.knobs)
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
        self.refusal = None
        first = self.outcome is None
        with self.client.atomic():
            scene = self._scene_for(outcome)
            self._numbers.content = numbers(outcome, None)
            self._draw_path(outcome, scene)
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
            self._show_switches()
            self._look()

    def _refuse(self, words: str) -> None:
        """Say why there is no motion; the last good one stays."""
        self.refusal = words
        self._numbers.content = numbers(self.outcome, words)
        self.client.flush()

    def _tell_of_waiting(self) -> None:
        self._numbers.content = numbers(self.outcome, None, waiting=True)
        self.client.flush()

    def _scene_for(self, outcome: Outcome) -> Scene:
        """The scene of this motion's robot and ground; drawn anew where they are others."""
        robot, ground = outcome.trajectory.robot, outcome.trajectory.ground
        scene, level = self._scene, ground.normal(np.zeros(3))
        # Another gravity or other losses look the same.
        if (
            scene is not None
            and np.array_equal(scene.normal, level)
            and (scene.robot is robot or scene.robot.urdf == robot.urdf)
        ):
            return scene
        new = Scene(robot, ground)
        if scene is not None:
            self._stage.remove("/world/robot")
        self._stage.send(new.objects())
        self._scene, self._staged = new, 0.0
        if scene is not None:
            self._show_switches()
        return new

    def _draw_path(self, outcome: Outcome, scene: Scene) -> None:
        points = outcome.path()
        points = points[:: 1 + len(points) // _MOST_POINTS]
        kept = points[thin(points, scene.detail)]
        centers = _lifted(kept, scene)
        view = scene.view(centers)
        radius = float(np.linalg.norm(centers - centers.mean(axis=0), axis=1).max()) + scene.reach
        if not 0.3 * self._staged < radius <= self._staged:
            self._staged = 1.5 * radius
            far = centers.mean(axis=0) + self._staged * np.array(((-1, -1, 0), (1, 1, 0))) / 2
            self._stage.send(c for c in scene.stage(far, view) if c["path"] != "/Lights/Sun")
        if len(kept) > 1:
            self._stage.send([scene.trace(kept, view)])
        mean = outcome.mean_path()
        mean = mean[thin(mean, scene.detail)] if len(mean) else mean
        if len(mean) > 1:
            width = max(scene.detail, 0.0015 * float(np.linalg.norm(view.camera)))
            ribbon = ribbon_mesh(mean, width, lift=0.4 * scene.detail)
            self._stage.send(
                [set_mesh("/world/ground/mean", ribbon, material(_MEAN, "MeshBasicMaterial"))]
            )
        self._view = view
        self._show_path_switches()

    def _show_ghosts(self, knobs: Knobs) -> None:
        """Paths of other models, after the motion itself is shown."""
        for name, box in self._ghosts.items():
            path = f"/world/ground/{name}"
            scene = self._scene
            if not box.value or scene is None or self.refusal is not None:
                self._stage.show(path, False)
                continue
            try:
                points = ghost(self.robot, knobs, name)
            except Refusal as refusal:
                self._stage.show(path, False)
                self.say(str(refusal))
                continue
            self._ribbon(path, points, scene, GHOSTS[name], 0.15)
        self.client.flush()

    def _ribbon(self, path: str, points: Array, scene: Scene, colour: Colour, lift: float) -> None:
        """A line on the ground; `lift` in the trace's details, so that lines do not flicker."""
        points = points[thin(points, scene.detail)]
        if len(points) > 1:
            ribbon = ribbon_mesh(points, scene.detail, lift=lift * scene.detail)
            look = material(colour, "MeshBasicMaterial")
            self._stage.send([set_mesh(path, ribbon, look)])

    def _show_path_switches(self) -> None:
        for path in ("/world/ground/trace", "/world/ground/mean"):
            self._stage.show(path, bool(self._hidden[path].value))

    def _look(self) -> None:
        """Put the camera where it sees the whole path."""
        camera = self.client.camera
        size = camera.image_width, camera.image_height
        at = framing(self._view, np.array((0.0, 0.0, 1.0)), size)
        self._framed = at, size, time.monotonic()
        with self.client.atomic():
            camera.fov = np.deg2rad(FIELD_OF_VIEW)
            camera.up_direction = (0.0, 0.0, 1.0)
            camera.position = at.position
            camera.look_at = at.look_at

    def _resized(self, camera: Any) -> None:
        """Look again when the picture has another size, unless the person has turned the camera."""
        if self._framed is None or self._framed[1] == (camera.image_width, camera.image_height):
            return
        at, _, when = self._framed
        far = 1e-3 * np.linalg.norm(at.position - at.look_at)
        still = np.allclose(camera.position, at.position, rtol=0, atol=far)
        if still or time.monotonic() - when < _LAYING_OUT:
            self._look()


def _lifted(points: Array, scene: Scene) -> Array:
    """Centres of the shell over contact points (n, 2) of a plane (n, 3)."""
    return np.asarray(points @ scene.basis[:, :2].T + scene.size * scene.normal)
