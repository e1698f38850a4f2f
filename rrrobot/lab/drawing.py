"""What one client's scene shows of a motion: robot and ground, paths, and the camera's place."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.lab.layout import Framing, framing
from rrrobot.lab.outcome import Outcome
from rrrobot.lab.stage import Stage
from rrrobot.view.commands import FIELD_OF_VIEW, Colour, material, ribbon_mesh, set_mesh
from rrrobot.view.film import thin
from rrrobot.view.scene import Scene, View

_MEAN = (0.10, 0.35, 0.75)
_MOST_POINTS = 6000
"""Of the path; a longer one is drawn more coarsely."""
_LAYING_OUT = 3.0
"""For which a browser may still be settling where the panel is [s]."""
_REACH = 1.5
"""How much farther or nearer the camera must be for it to move of itself."""


class Drawing:
    """Draws motions for one client.

    Args:
        client: of viser.

    Attributes:
        stage: the client's scene.
        scene: robot and ground that are shown; None before the first motion.
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        self.stage = Stage(client.scene)
        self.scene: Scene | None = None
        self._staged = 0.0
        self._view: View | None = None
        self._framed: tuple[Framing, tuple[int, int], float, float] | None = None
        self._hidden: dict[str, Any] = {}
        client.camera.on_update(self._look_again)

    def switch(self, paths: tuple[str, ...], box: Any) -> None:
        """Let a checkbox show and hide nodes; "axes" stands for those of the robot."""
        self._hidden.update(dict.fromkeys(paths, box))
        box.on_update(lambda event: self.show_switches())

    def show_switches(self) -> None:
        """Show and hide what the checkboxes say."""
        for path, box in self._hidden.items():
            if path == "axes":
                if self.scene is None:
                    continue
                path = f"{self.scene.path(1)}/axes"
            self.stage.show(path, bool(box.value))

    def draw(self, outcome: Outcome) -> Scene:
        """Draw robot, ground and paths of a motion."""
        scene = self._scene_for(outcome)
        self._draw_path(outcome, scene)
        self._look_again(self._client.camera)
        return scene

    def ribbon(self, path: str, points: Array, scene: Scene, colour: Colour, lift: float) -> None:
        """A line on the ground; `lift` in the trace's details, so that lines do not flicker."""
        points = points[thin(points, scene.detail)]
        if len(points) > 1:
            ribbon = ribbon_mesh(points, scene.detail, lift=lift * scene.detail)
            look = material(colour, "MeshBasicMaterial")
            self.stage.send([set_mesh(path, ribbon, look)])

    def look(self) -> None:
        """Put the camera where it sees the whole path."""
        view = self._view
        if view is None:
            return
        camera = self._client.camera
        size = camera.image_width, camera.image_height
        at = framing(view, np.array((0.0, 0.0, 1.0)), size)
        self._framed = at, size, _away(view), time.monotonic()
        with self._client.atomic():
            camera.fov = np.deg2rad(FIELD_OF_VIEW)
            camera.up_direction = (0.0, 0.0, 1.0)
            camera.position = at.position
            camera.look_at = at.look_at

    def _look_again(self, camera: Any) -> None:
        """Look again when picture or path have another size, unless the person moved the camera."""
        if self._framed is None or self._view is None:
            return
        at, size, away, when = self._framed
        now = camera.image_width, camera.image_height
        if now == size and away / _REACH < _away(self._view) < away * _REACH:
            return
        far = 1e-3 * np.linalg.norm(at.position - at.look_at)
        still = np.allclose(camera.position, at.position, rtol=0, atol=far)
        if still or (now != size and time.monotonic() - when < _LAYING_OUT):
            self.look()

    def _scene_for(self, outcome: Outcome) -> Scene:
        """The scene of this motion's robot and ground; drawn anew where they are others."""
        robot, ground = outcome.trajectory.robot, outcome.trajectory.ground
        scene, level = self.scene, ground.normal(np.zeros(3))
        # Another gravity or other losses look the same.
        if (
            scene is not None
            and np.array_equal(scene.normal, level)
            and (scene.robot is robot or scene.robot.urdf == robot.urdf)
        ):
            return scene
        new = Scene(robot, ground)
        if scene is not None:
            self.stage.remove("/world/robot")
        self.stage.send(new.objects())
        self.scene, self._staged = new, 0.0
        if scene is not None:
            self.show_switches()
        return new

    def _draw_path(self, outcome: Outcome, scene: Scene) -> None:
        kept = outcome.path(scene.detail)
        kept = kept[:: 1 + len(kept) // _MOST_POINTS]
        centers = _lifted(kept, scene)
        view = scene.view(centers)
        radius = float(np.linalg.norm(centers - centers.mean(axis=0), axis=1).max()) + scene.reach
        if not 0.3 * self._staged < radius <= self._staged:
            self._staged = 1.5 * radius
            far = centers.mean(axis=0) + self._staged * np.array(((-1, -1, 0), (1, 1, 0))) / 2
            self.stage.send(c for c in scene.stage(far, view) if c["path"] != "/Lights/Sun")
        if len(kept) > 1:
            self.stage.send([scene.trace(kept, view)])
        mean = outcome.mean_path()
        mean = mean[thin(mean, scene.detail)] if len(mean) else mean
        if len(mean) > 1:
            width = max(scene.detail, 0.0015 * float(np.linalg.norm(view.camera)))
            ribbon = ribbon_mesh(mean, width, lift=0.4 * scene.detail)
            self.stage.send(
                [set_mesh("/world/ground/mean", ribbon, material(_MEAN, "MeshBasicMaterial"))]
            )
        self._view = view


def _lifted(points: Array, scene: Scene) -> Array:
    """Middles of the robot over contact points (n, 2) of a plane (n, 3)."""
    return np.asarray(points @ scene.basis[:, :2].T + scene.height * scene.normal)


def _away(view: View) -> float:
    return float(np.linalg.norm(view.camera))
