"""Plays an outcome in real time: the robot, the contact's force, the centre of mass."""

from __future__ import annotations

import math
import threading
import time
from typing import Any

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.lab.motion import Motion
from rrrobot.lab.outcome import Outcome
from rrrobot.lab.stage import Stage, wxyz
from rrrobot.view.scene import Pose, Scene

FPS = 30.0
_PATIENCE = 1.0
"""For which the end waits for what is being drawn [s]."""
_ARROW = (230, 120, 20)
_CONE, _CENTRE = (80, 130, 200), (20, 20, 20)


class Player:
    """A thread that draws one client's robot as time goes on.

    Args:
        client: of viser.
        stage: its scene.

    Attributes:
        playing: whether time goes on.
        speed: simulated seconds per second.
        follow: whether the robot stays in the middle of the picture.
        time: of the motion [s].
        lock: held while it draws.
        ghosts: motions of other models, played beside it, by the name of each.
    """

    def __init__(self, client: Any, stage: Stage) -> None:
        self.playing, self.speed, self.follow, self.time = True, 1.0, False, 0.0
        self._client, self._stage = client, stage
        self.ghosts: dict[str, Motion] = {}
        self.lock, self._end = threading.Lock(), threading.Event()
        self._outcome: Outcome | None = None
        self._scene: Scene | None = None
        self._arrow: Any = None
        self._dressed: tuple[Scene, float] | None = None
        self._followed = False
        self._thread = threading.Thread(target=self._play, name="rrrobot lab player", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def close(self) -> None:
        """End, and draw no more; again does nothing."""
        self._end.set()
        if self._thread.is_alive():
            self._thread.join(_PATIENCE)

    def show(self, outcome: Outcome, scene: Scene) -> None:
        """Play another motion, at the same phase of the legs if it has one."""
        with self.lock:
            before = self._outcome
            if before is not None and outcome.screw is not None and before.screw is not None:
                # A slider turned must not throw the robot along its path.
                phase = math.modf(self.time / before.period)[0]
                self.time = phase * outcome.period
            else:
                self.time = 0.0
            dressed = scene, outcome.knobs.friction
            self._outcome, self._scene = outcome, scene
            if dressed != self._dressed:
                self._dressed = dressed
                self._dress(outcome, scene)
        self.draw()

    def restart(self) -> None:
        """From the beginning."""
        self.time = 0.0
        self.draw()

    def draw(self) -> None:
        """Draw the robot where it is at this time."""
        with self.lock:
            if self._outcome is not None and self._scene is not None:
                self._draw(self._outcome, self._scene)

    def _play(self) -> None:
        last = time.monotonic()
        while not self._end.wait(max(0.001, 1 / FPS - (time.monotonic() - last))):
            now = time.monotonic()
            passed, last = now - last, now
            outcome = self._outcome
            if not self.playing or outcome is None:
                continue
            self.time += passed * self.speed
            lasts = outcome.knobs.horizon if outcome.screw is not None else outcome.period
            if self.time > lasts:
                self.time = 0.0
            self.draw()

    def _draw(self, outcome: Outcome, scene: Scene) -> None:
        q, shift, at = outcome.frame(self.time)
        pose = moved(scene.pose(q), shift)
        model = outcome.trajectory.robot.model
        centre = shift.act(pin.centerOfMass(model, scene.data, q))
        with self._client.atomic():
            for joint, place in pose.joints.items():
                self._stage.place(scene.path(joint), place.homogeneous)
            self._stage.place("/world/force", _at(scene.ground.point(pose.contact)))
            self._stage.place("/world/mass", _at(centre))
            self._arrow.points = self._force(outcome, scene, shift, at)
            for name, ghost in tuple(self.ghosts.items()):
                q, shift, _ = ghost.frame(self.time)
                for joint, place in moved(scene.pose(q), shift).joints.items():
                    self._stage.place(f"/world/ghost/{name}/{joint}", place.homogeneous)
            if self.follow or self._followed:
                self._followed = self.follow
                away = -pose.center if self.follow else np.zeros(3)
                self._stage.place("/world", _at(away))

    def _force(self, outcome: Outcome, scene: Scene, shift: pin.SE3, at: float) -> Array:
        trajectory = outcome.trajectory
        force = shift.rotation @ between(trajectory.contact_force, at)
        weight = trajectory.robot.mass * max(trajectory.gravity, 1e-9)
        arrow: Array = np.zeros((1, 2, 3))
        arrow[0, 1] = 1.2 * scene.size * force / weight
        return arrow

    def _dress(self, outcome: Outcome, scene: Scene) -> None:
        """Arrow, cone and centre of mass for a robot of this size."""
        size, api = scene.size, self._client.scene
        self._arrow = api.add_arrows(
            "/world/force/arrow", np.zeros((1, 2, 3)), _ARROW, shaft_radius=0.02 * size,
            head_radius=0.05 * size, head_length=0.12 * size,
        )  # fmt: skip
        self._stage.put("/world/force/arrow", self._arrow)
        points, faces = cone(outcome.knobs.friction, 0.9 * size)
        self._stage.put("/world/force/cone", api.add_mesh_simple(
            "/world/force/cone", points, faces, color=_CONE, opacity=0.25, side="double",
            cast_shadow=False, wxyz=wxyz(scene.basis),
        ))  # fmt: skip
        self._stage.put("/world/mass/ball", api.add_icosphere(
            "/world/mass/ball", radius=0.05 * size, color=_CENTRE,
        ))  # fmt: skip


def moved(pose: Pose, shift: pin.SE3) -> Pose:
    """A pose carried elsewhere on level ground."""
    joints = {joint: shift * at for joint, at in pose.joints.items()}
    contact = shift.rotation[:2, :2] @ pose.contact + shift.translation[:2]
    return Pose(joints, shift.act(pose.center), contact)


def between(rows: Array, at: float) -> Array:
    """Rows (n, k) interpolated at a sample that need not be whole (k,)."""
    i = min(int(at), len(rows) - 2)
    return np.asarray(rows[i] + (at - i) * (rows[i + 1] - rows[i]))


def cone(friction: float, height: float) -> tuple[Array, Any]:
    """Triangles of the cone of forces that friction can give, its tip at the origin, up along z."""
    n = 48
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    h = height / math.hypot(1.0, friction)
    rim = np.column_stack((friction * h * np.cos(turn), friction * h * np.sin(turn), h + 0 * turn))
    points = np.vstack((np.zeros(3), rim))
    k = np.arange(n)
    return points, np.column_stack((np.zeros(n, dtype=int), 1 + k, 1 + (k + 1) % n))


def _at(point: Array) -> Array:
    matrix = np.eye(4)
    matrix[:3, 3] = point
    return matrix
