"""Robots of other models, which go their own way beside the one that is shown."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

from rrrobot.errors import RRRobotError
from rrrobot.lab.drawing import Drawing
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.motion import Motion, Screw
from rrrobot.lab.outcome import LOCK, Refusal, short, steps_of
from rrrobot.lab.player import Player
from rrrobot.orbits.limit_cycles import limit_cycle
from rrrobot.robot.robot import Robot
from rrrobot.view.commands import css, material, set_mesh
from rrrobot.view.scene import Scene

GHOSTS = {
    "pivoting": ("pivoting model (green)", (0.10, 0.60, 0.30)),
    "decoupled": ("single-axis models (orange)", (0.95, 0.60, 0.10)),
}
"""Other models: what their switches say, and their colours."""
_GLASS = 0.3


def ghost(given: Robot, knobs: Knobs, name: str) -> Motion:
    """The settled motion of another model, "pivoting" or "decoupled".

    Raises:
        Refusal: it has none.
    """
    if not knobs.settles:
        raise Refusal("Other models are shown where the motion repeats.")
    with LOCK, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            model, steps = knobs.other(given, name), steps_of(knobs)
            cycle = limit_cycle(model, knobs.gait(), steps_per_cycle=steps)
            trajectory = cycle.trajectory(sample_interval=cycle.period / steps)
        except RRRobotError as error:
            raise Refusal(f"The {name} model: {short(error)}") from None
    screw = Screw(cycle.turn, cycle.displacement)
    return Motion(trajectory=trajectory, screw=screw, horizon=knobs.horizon)


class Ghosts:
    """Switches for the other models, and what they show.

    Args:
        gui: of a client of viser.
        drawing: of the client.
        player: of the client.
        turned: called when a switch is turned.
    """

    def __init__(
        self, gui: Any, drawing: Drawing, player: Player, turned: Callable[[], None]
    ) -> None:
        self._drawing, self._player = drawing, player
        self._drawn: dict[str, Scene] = {}
        self._boxes = {}
        for name, (label, colour) in GHOSTS.items():
            box = gui.add_checkbox(label, False, hint=f"Path and robot in {css(colour)}.")
            box.on_update(lambda event: turned())
            self._boxes[name] = box

    def show(self, robot: Robot, knobs: Knobs | None) -> list[str]:
        """Show the motions of those that are switched on; None: of none.

        Returns:
            what is to be said of those that have none.
        """
        told: list[str] = []
        for name, box in self._boxes.items():
            scene = self._drawing.scene
            motion = None
            if box.value and scene is not None and knobs is not None:
                try:
                    motion = ghost(robot, knobs, name)
                except Refusal as refusal:
                    told.append(str(refusal))
            with self._player.lock:
                self._draw(name, motion, scene)
        return told

    def _draw(self, name: str, motion: Motion | None, scene: Scene | None) -> None:
        stage = self._drawing.stage
        top, path = f"/world/ghost/{name}", f"/world/ground/{name}"
        if motion is None or scene is None:
            self._player.ghosts.pop(name, None)
            if name in self._drawn:
                stage.show(top, False)
                stage.show(path, False)
            return
        colour = GHOSTS[name][1]
        self._drawing.ribbon(path, motion.path(), scene, colour, 0.15)
        if self._drawn.get(name) is not scene:
            stage.remove(top)
            look = material((*colour, _GLASS))
            for k, visual in enumerate(scene.visuals):
                at = f"{top}/{visual.joint}"
                stage.send([set_mesh(f"{at}/{k}", visual.geometry, look, visual.placement)])
            self._drawn[name] = scene
        stage.show(top, True)
        stage.show(path, True)
        self._player.ghosts[name] = motion
