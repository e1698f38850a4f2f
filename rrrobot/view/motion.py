"""The motion of a film: an animation of Meshcat, a clip for each node that moves."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.view.commands import Colour, Command, arrow, clip, material, track
from rrrobot.view.film import Film
from rrrobot.view.player import Play
from rrrobot.view.scene import Pose, Scene

FORCE_COLOUR: Colour = (0.90, 0.47, 0.08)
WEIGHT = 1.2
"""Length of an arrow of force that is the robot's weight, in shell sizes."""

FORCE = "/world/force"
"""Node of that arrow."""

_LEAST = 1e-4  # a scale of zero has no inverse
_STEPPED = 2300  # three.js: InterpolateDiscrete
_UP = np.array((0.0, 0.0, 1.0))


def animation(
    scene: Scene,
    poses: Sequence[Pose],
    fps: float,
    *,
    follow: bool,
    grown: NDArray[np.int64] | None,
    more: Sequence[Command] = (),
) -> Command:
    """Play the poses again and again.

    Args:
        scene: of the robot.
        poses: a frame each.
        fps: frames per second [1/s].
        follow: whether the camera goes with the robot.
        grown: number of steps of the trace to show in each frame (n,); None for no trace or
            for the whole.
        more: clips of other nodes, at the same pace.
    """
    times = np.arange(len(poses))
    clips = [*more]
    for joint in scene.joints:
        at = [pose.joints[joint] for pose in poses]
        turns = np.array([pin.Quaternion(placement.rotation).coeffs() for placement in at])
        moves = np.array([placement.translation for placement in at])
        tracks = (
            track(".position", "vector3", times, moves),
            track(".quaternion", "quaternion", times, turns),
        )
        clips.append(clip(scene.path(joint), fps, *tracks))
    if follow:
        centers = np.array([pose.center for pose in poses])
        clips.append(clip("/world", fps, track(".position", "vector3", times, -centers)))
    if grown is not None:
        # How many of the ribbon's indices are drawn, six for each step.
        grow = track(".geometry[drawRange].count", "number", times, 6 * grown)
        grow["interpolation"] = _STEPPED
        clips.append(clip("/world/ground/trace/<object>", fps, grow))
    options = {"play": True, "repetitions": math.inf}
    return {"type": "set_animation", "animations": clips, "options": options, "path": ""}


def force_of(trajectory: Trajectory | Play) -> Array | None:
    """The contact's force in shares of the robot's weight (n, 3), if it is known."""
    if not isinstance(trajectory, Trajectory) or not trajectory.gravity > 0:
        return None
    force = trajectory.contact_force / (trajectory.robot.mass * trajectory.gravity)
    return force if np.isfinite(force).all() else None


def force_objects() -> list[Command]:
    """An arrow of unit length along z, seen through the robot."""
    # Transparent things are drawn last.
    look = material(FORCE_COLOUR, "MeshBasicMaterial", depthTest=False, transparent=True)
    return arrow(f"{FORCE}/arrow", _UP, 1.0, look, width=0.025, renderOrder=9)


def force_clip(
    scene: Scene, trajectory: Trajectory, force: Array, film: Film, poses: Sequence[Pose]
) -> Command:
    """The motion of that arrow: it stands where the force acts, as long as the force is large.

    Args:
        scene: of the robot.
        trajectory: what is filmed.
        force: at its samples, in shares of the robot's weight (n, 3).
        film: its frames.
        poses: one for each.
    """
    shown = np.column_stack([np.interp(film.time, trajectory.time, column) for column in force.T])
    turns = [pin.Quaternion.FromTwoVectors(_UP, f if f.any() else _UP).coeffs() for f in shown]
    if trajectory.has_contact:
        places = [scene.ground.point(pose.contact) for pose in poses]
    else:
        places = [pose.center for pose in poses]  # the pivot's
    size = np.maximum(WEIGHT * scene.size * np.linalg.norm(shown, axis=1), _LEAST)
    frames = np.arange(len(poses))
    return clip(
        FORCE, film.fps,
        track(".position", "vector3", frames, places),
        track(".quaternion", "quaternion", frames, turns),
        track(".scale", "vector3", frames, np.repeat(size[:, None], 3, axis=1)),
    )  # fmt: skip
