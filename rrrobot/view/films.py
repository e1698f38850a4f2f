"""`record`: a motion as a film, in one file: .html, .mp4, .gif, or .png of some instants."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import vector
from rrrobot.errors import OutputError, ParameterError
from rrrobot.files import check_writable, write_whole
from rrrobot.machines.history import History
from rrrobot.progress import Progress, progress_of
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.view.commands import WIDTH
from rrrobot.view.curves import curves_html
from rrrobot.view.film import make_film
from rrrobot.view.frames import checked_size, film_times, frames, gif, strip, video
from rrrobot.view.marks import page_data
from rrrobot.view.motion import animation, force_clip, force_objects, force_of
from rrrobot.view.page import film_page
from rrrobot.view.player import Play, play_of
from rrrobot.view.scene import Scene

Trace: TypeAlias = bool | Literal["whole"]

FILMS = (".htm", ".html", ".mp4", ".gif", ".png")
"""Suffixes of what `record` writes."""


def record(
    trajectory: Trajectory | History,
    path: str | Path,
    *,
    fps: float = 30.0,
    speed: float = 1.0,
    trace: Trace = True,
    axes: bool = True,
    labels: bool = False,
    force: bool = False,
    translucent: bool = False,
    curves: bool = False,
    follow: bool = False,
    size: tuple[int, int] = (960, 540),
    camera: ArrayLike | None = None,
    caption: bool | str = True,
    at: ArrayLike | None = None,
    progress: Progress = False,
) -> Path:
    """Write a trajectory as a film, or as a picture of it; the file's suffix says which.

    .html plays in any browser, over and over, without a network. Its page has a clock, play and
    pause, a speed, and switches for what `axes` to `curves` and `trace` show; the mouse turns,
    shifts and zooms the camera. .mp4, .gif and .png are drawn from the same page by a headless
    Chromium or Chrome, which must be installed; .mp4 needs the extra `media`. The grid gives the
    scale.

    Args:
        trajectory: what to show; or a machine's history.
        path: of the file, ending in .html, .mp4, .gif or .png.
        fps: frames per second of the film [1/s]; the page interpolates between them.
        speed: simulated seconds per second of the film.
        trace: of the contact point: True grows with the motion, "whole" is there from the start,
            False is none.
        axes: whether to draw the axes of the world and of the shell: x red, y green, z blue.
        labels: whether the legs' names stand beside them.
        force: whether to draw the contact's force: an arrow, 1.2 shell radii long for the weight.
        translucent: whether the shell lets through what it hides.
        curves: whether the body's and the legs' angles and the motor torques are plotted beneath.
        follow: whether the camera goes with the robot; else the whole path is in view.
        size: width and height of .mp4, .gif and .png, even numbers [px].
        camera: place of the camera relative to what it looks at (3,) [m]; where it sees all unless
            given.
        caption: the text at the bottom; True says robot, model, duration and grid.
        at: times of a .png [s], one or several side by side; the end unless given.
        progress: see `rrrobot.progress`; in seconds of the film.

    Returns:
        the path.

    Raises:
        ParameterError: fps, speed, size, camera or at out of range, or too many frames.
        OutputError: the file cannot be written, its suffix is another, or there is no browser.
        MissingExtraError: an .mp4 without imageio-ffmpeg.

    Warns:
        UserWarning: meshes of the URDF that are missing are left out.

    Example:
        >>> import tempfile, rrrobot as rr
        >>> from rrrobot.view.films import record
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> t = rr.simulate(model, rr.gait("lateral"), duration=1.0)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     record(t, folder + "/lateral.html").name
        'lateral.html'
    """
    target = check_writable(path)
    kind = target.suffix.lower()
    if kind not in FILMS:
        raise OutputError(
            f"cannot write {str(target)!r}: a film's file ends in {', '.join(FILMS[1:])}."
        )
    pixels = checked_size(size)
    if at is not None and kind != ".png":
        raise ParameterError("at would do nothing but for a .png: leave it out.")
    instants = _instants(trajectory, at) if kind == ".png" else None
    page = film_html(
        trajectory, fps=fps, speed=speed, trace=trace, axes=axes, labels=labels, force=force,
        translucent=translucent, curves=curves, follow=follow, camera=camera, caption=caption,
    )  # fmt: skip
    if kind in (".html", ".htm"):
        return write_whole(target, page)
    duration = float(trajectory.time[-1] - trajectory.time[0])
    with progress_of(progress, "drawing", duration / speed, "s") as tell:
        if instants is not None:
            late = [(t - float(trajectory.time[0])) / speed for t in instants]
            return write_whole(target, strip(frames(page, pixels, late, progress=tell)))
        pictures = frames(page, pixels, film_times(duration / speed, fps), progress=tell)
        content = video(pictures, pixels, fps) if kind == ".mp4" else gif(pictures, fps)
    return write_whole(target, content)


def _instants(trajectory: Trajectory | History, at: ArrayLike | None) -> list[float]:
    """Times of a picture, within the trajectory [s]."""
    first, last = float(trajectory.time[0]), float(trajectory.time[-1])
    if at is None:
        return [last]
    times = vector("at", np.atleast_1d(np.asarray(at, dtype=float)), np.size(at), "s")
    if not times.size or times.min() < first or times.max() > last:
        raise ParameterError(
            f"at is {times.tolist()} s: times of a picture lie between {first:g} and {last:g} s."
        )
    return [float(t) for t in times]


def film_html(
    trajectory: Trajectory | History,
    *,
    fps: float = 30.0,
    speed: float = 1.0,
    trace: Trace = True,
    axes: bool = True,
    labels: bool = False,
    force: bool = False,
    translucent: bool = False,
    curves: bool = False,
    follow: bool = False,
    camera: ArrayLike | None = None,
    caption: bool | str = True,
    loop: bool = True,
) -> bytes:
    """The page that `record` writes, with the same options."""
    _check_trace(trace)
    show = {"axes": axes, "labels": labels, "force": force, "translucent": translucent}
    show["curves"] = curves
    played = play_of(trajectory) if isinstance(trajectory, History) else trajectory
    scene = Scene(played.robot, played.ground)
    film = make_film(played, fps=fps, speed=speed, detail=scene.detail)
    poses = [scene.pose(q) for q in film.configuration]
    scene.hold(poses)
    centers = np.array([pose.center for pose in poses])
    view = scene.view(centers, follow=follow)
    if camera is not None:
        place = vector("camera", camera, 3, "m")
        if not np.linalg.norm(place) > scene.size:
            raise ParameterError(f"camera is {place.tolist()} m: that is within the shell.")
        view = view._replace(camera=place, width=WIDTH)
    commands = scene.objects(axes=axes) + (scene.glass() if scene.shell_paths else [])
    commands += scene.camera(view) + scene.stage(centers, view) + scene.place(poses[0])
    ribbon = bool(trace) and len(film.path) > 1
    if ribbon:
        commands.append(scene.trace(film.path, view))
        show["trace"] = True
    data = page_data(scene, played, view, speed=speed, loop=loop, show=show)
    pushed = force_of(played)
    if len(poses) > 1:
        grown = film.reached - 1 if ribbon and trace is True else None
        more = []
        if pushed is not None and isinstance(played, Trajectory):
            commands += force_objects()
            more.append(force_clip(scene, played, pushed, film, poses))
        commands.append(animation(scene, poses, film.fps, follow=follow, grown=grown, more=more))
    words = _caption(played, scene, speed) if caption is True else caption or ""
    plots = curves_html(played) if isinstance(played, Trajectory) else ""
    return film_page(words, commands, data, plots)


def _check_trace(trace: Trace) -> None:
    if trace not in (True, False, "whole"):
        raise ParameterError(f"trace is {trace!r}: it must be True, False or 'whole'.")


def _caption(trajectory: Trajectory | Play, scene: Scene, speed: float) -> str:
    duration = trajectory.time[-1] - trajectory.time[0]
    parts = [
        f"{trajectory.robot.name}, {trajectory.model_name} model, {duration:.3g} s",
        *([f"{speed:g} x speed"] if speed != 1 else []),
        f"grid {scene.spacing:g} m",
    ]
    return ", ".join(parts)
