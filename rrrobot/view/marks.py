"""What a film can show beside the robot, and what its page needs to know.

The page shows or hides each layer; `film.js` reads what `page_data` says.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rrrobot.errors import ParameterError
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.view.commands import AXIS_COLOURS, css
from rrrobot.view.curves import leg_colour
from rrrobot.view.motion import FORCE, FORCE_COLOUR, force_of
from rrrobot.view.player import Play
from rrrobot.view.scene import TRACE_COLOUR, Scene, View


def page_data(
    scene: Scene,
    trajectory: Trajectory | Play,
    view: View,
    *,
    speed: float,
    loop: bool,
    show: Mapping[str, bool],
) -> dict[str, Any]:
    """What `film.js` needs: the clock, the layers with their legends, the legs' names.

    Args:
        scene: of the robot.
        trajectory: what is filmed.
        view: where from.
        speed: simulated seconds per second.
        loop: whether the film plays again and again.
        show: of each layer that there is, whether it is shown at first.

    Raises:
        ParameterError: a layer is to be shown that there is not.
    """
    layers = _layers(scene, trajectory, "trace" in show)
    for name, on in show.items():
        if on and name not in layers:
            raise ParameterError(f"{name}=True shows nothing: {_MISSING.get(name, '')}.")
    start, end = float(trajectory.time[0]), float(trajectory.time[-1])
    return {
        "start": start,
        "end": end,
        "speed": speed,
        "width": view.width,
        "loop": loop,
        "digits": 1 if end - start >= 5 else 2,
        "layers": [
            {"name": name, "on": bool(show.get(name, False)), "legend": [], **layer}
            for name, layer in layers.items()
        ],
        "names": _names(scene, trajectory),
    }


_MISSING = {
    "force": "the contact's force is not known of this motion",
    "labels": "there are no legs",
    "curves": "they are drawn of a robot's trajectory",
    "translucent": "the shell is drawn so already, or not at all",
}


def _layers(scene: Scene, trajectory: Trajectory | Play, trace: bool) -> dict[str, dict[str, Any]]:
    axes = zip(AXIS_COLOURS, ("x, roll", "y, pitch", "z, yaw"), strict=True)
    layers: dict[str, dict[str, Any]] = {
        "axes": {
            "kind": "nodes", "words": "axes", "nodes": scene.axes_paths,
            "legend": [(css(colour), words) for colour, words in axes],
        }
    }  # fmt: skip
    if trace:
        words = "path of the contact" if _rolls(trajectory) else "path over the ground"
        layers["trace"] = {"kind": "nodes", "words": words, "nodes": ["/world/ground/trace"]}
        layers["trace"]["legend"] = [(css(TRACE_COLOUR), words)]
    if force_of(trajectory) is not None:
        words = "contact force" if _rolls(trajectory) else "force of the pivot"
        layers["force"] = {"kind": "nodes", "words": words, "nodes": [FORCE]}
        layers["force"]["legend"] = [(css(FORCE_COLOUR), words)]
    if shells := scene.shell_paths:
        layers["translucent"] = {"kind": "swap", "words": "translucent shell", "others": shells}
        layers["translucent"]["nodes"] = [scene.glass_path]
    if isinstance(trajectory, Trajectory):
        if trajectory.robot.legs:
            layers["labels"] = {"kind": "element", "words": "names of legs", "element": "names"}
        if len(trajectory) > 1:
            words = "angles and torques"
            layers["curves"] = {"kind": "element", "words": words, "element": "curves"}
    layers["tree"] = {"kind": "tree", "words": "Meshcat's panel"}
    return layers


def _rolls(trajectory: Trajectory | Play) -> bool:
    return isinstance(trajectory, Trajectory) and trajectory.has_contact


def _names(scene: Scene, trajectory: Trajectory | Play) -> list[dict[str, Any]]:
    """The legs' names, each at the mass centre of the link that the joint moves."""
    if not isinstance(trajectory, Trajectory):
        return []
    model = trajectory.robot.model
    joints = [model.getJointId(leg) for leg in trajectory.robot.legs]
    return [
        {
            "node": scene.path(joint),
            "at": model.inertias[joint].lever.tolist(),
            "words": leg,
            "colour": leg_colour(i),
        }
        for i, (leg, joint) in enumerate(zip(trajectory.robot.legs, joints, strict=True))
    ]
