"""A trajectory as the frames of a film, at even times, and the path that the contact point drew."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.checks import Array, finite
from rrrobot.errors import ParameterError
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.view.player import Play

_MAX_FRAMES = 200_000


class Film(NamedTuple):
    """A trajectory in k frames at even times.

    Attributes:
        time: of the motion (k,) [s].
        configuration: (k, nq).
        fps: frames per second [1/s].
        path: contact points in the ground plane (m, 2) [m], as many as show the path well.
        reached: number of these points that each frame has behind it (k,), from 1.
    """

    time: Array
    configuration: Array
    fps: float
    path: Array
    reached: NDArray[np.int64]


def make_film(trajectory: Trajectory | Play, *, fps: float, speed: float, detail: float) -> Film:
    """Frames from the trajectory's start to its end.

    Configurations between samples are interpolated along the shortest motion.

    Args:
        trajectory: what to film.
        fps: frames per second [1/s]; the film's is the nearest that fits the duration.
        speed: simulated seconds per second.
        detail: least distance of two points of the path [m].

    Raises:
        ParameterError: fps or speed not greater than zero, or too many frames.
    """
    fps = finite("fps", fps, "1/s", above=0)
    speed = finite("speed", speed, above=0)
    times, q = trajectory.time, trajectory.configuration
    duration = float(times[-1] - times[0])
    wanted = duration * fps / speed
    if wanted > _MAX_FRAMES:
        raise ParameterError(
            f"{duration:g} s at fps = {fps:g} and speed = {speed:g} are {wanted:.3g} frames: "
            f"the limit is {_MAX_FRAMES}; lower fps or raise speed."
        )
    kept = thin(trajectory.position, detail)
    if duration == 0:
        return Film(times[:1], q[:1], fps, trajectory.position[:1], np.ones(1, dtype=np.int64))
    steps = max(1, round(wanted))
    at = np.linspace(times[0], times[-1], steps + 1)
    index = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    share = (at - times[index]) / (times[index + 1] - times[index])
    model = trajectory.robot.model
    frames = [pin.interpolate(model, q[i], q[i + 1], s) for i, s in zip(index, share, strict=True)]
    reached = np.searchsorted(times[kept], at, side="right")
    shown = trajectory.position[kept]
    return Film(at, np.array(frames), steps * speed / duration, shown, reached)


def thin(points: Array, detail: float) -> NDArray[np.int64]:
    """Indices of points (n, 2), the first and then each that is far enough from the one before."""
    kept, near = [0], detail**2
    last_x, last_y = points[0].tolist()
    for i, (x, y) in enumerate(points.tolist()):
        if (x - last_x) ** 2 + (y - last_y) ** 2 > near:
            kept.append(i)
            last_x, last_y = x, y
    return np.array(kept)
