"""Figures that set the models side by side: the kinds of Figs 2, 6, 7, 15 and 16 of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rrrobot.checks import Array, vector
from rrrobot.contact.surfaces import Sphere
from rrrobot.drawing import BLACK, FONT, GREY, PALE, legend_above, line, new_figure, tidy
from rrrobot.errors import ModelError
from rrrobot.rotations import rotation_from_quaternion
from rrrobot.simulation.plots import mean_path
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.studies.comparison import Comparison

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLES = {
    "full": "full model",
    "pivoting": "pivoting model",
    "decoupled": "single-axis models",
    "modulated": "single-axis, yaw amplitude modulated",
}


def contact_paths(
    comparison: Comparison,
    models: tuple[str, ...] = ("full", "pivoting"),
    *,
    marks: tuple[float, ...] = (0.0, 10.0, 20.0, 30.0),
) -> Figure:
    """Paths of the contact point on one scale, a panel a model, times marked: Figs 6 and 7.

    Args:
        comparison: of `rrrobot.studies.comparison`.
        models: which.
        marks: times at which the place is marked [s].
    """
    figure = new_figure(3.6 * len(models), 3.6)
    for i, name in enumerate(models):
        ax = figure.add_subplot(1, len(models), i + 1)
        path_panel(ax, comparison.trajectories[name], marks)
        ax.set_title(TITLES[name], fontsize=FONT + 1)
    _same_scale(figure.axes)
    return figure


def _same_scale(panels: list[Axes]) -> None:
    """Give panels of one shape limits of one width and height, each about its own middle."""
    spans = [np.array((ax.dataLim.intervalx, ax.dataLim.intervaly)) for ax in panels]
    half = 0.55 * max(float(np.ptp(span, axis=1).max()) for span in spans)
    for ax, span in zip(panels, spans, strict=True):
        x, y = span.mean(axis=1)
        ax.set_aspect("equal", adjustable="box")
        ax.set_xlim(x - half, x + half)
        ax.set_ylim(y - half, y + half)


def path_panel(ax: Axes, trajectory: Trajectory, marks: tuple[float, ...]) -> Axes:
    """The contact point's path on one axes: oscillation pale, cycle mean solid, times marked."""
    x, y = 100 * trajectory.position.T
    ax.plot(x, y, color=PALE, linewidth=0.7)
    mean = mean_path(trajectory)
    if mean is not None:
        mx, my = 100 * mean[1].T
        ax.plot(mx, my, color=BLACK, linewidth=1.4)
        ax.annotate(
            "",
            xy=(mx[-1], my[-1]),
            xytext=(mx[-3], my[-3]),
            arrowprops={"arrowstyle": "-|>", "color": BLACK, "lw": 1.4},
        )
    for mark in marks:
        if mark <= trajectory.time[-1] + 1e-9:
            at = tuple(100 * _place(trajectory, mean, mark))
            ax.plot(*at, "o", color=BLACK, markersize=4, markerfacecolor="white")
            ax.annotate(
                f"{mark:g} s", at, (8, 6), textcoords="offset points", fontsize=FONT - 1,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.75},
            )  # fmt: skip
    ax.set_aspect("equal", adjustable="datalim")
    tidy(ax, "x [cm]", "y [cm]")
    return ax


def _place(trajectory: Trajectory, mean: tuple[Array, Array] | None, mark: float) -> Array:
    """Of the mean at a time, or of its end; of the contact point before the mean begins."""
    times, places = trajectory.time, trajectory.position
    if mean is not None and mark >= mean[0][0]:
        times, places = mean
    place: Array = places[int(np.argmin(np.abs(times - mark)))]
    return place


def single_axis(
    comparison: Comparison,
    models: tuple[str, ...] = ("full", "decoupled"),
    *,
    window: tuple[float, float] | None = None,
) -> Figure:
    """Body angles and contact paths of the full and the single-axis models: Figs 15 and 16.

    Args:
        comparison: of `rrrobot.studies.comparison`.
        models: which, the first on top.
        window: times of the angle panels [s]; the whole run if None.
    """
    figure = new_figure(7.2, 5.2)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.25, 1))
    for axis, label in enumerate(("roll", "pitch", "yaw")):
        ax = figure.add_subplot(grid[axis, 0])
        for i, name in enumerate(models):
            t = comparison.trajectories[name]
            inside = (
                slice(None) if window is None else (t.time >= window[0]) & (t.time <= window[1])
            )
            angle = np.rad2deg(t.euler[inside, axis])
            ax.plot(t.time[inside], angle, label=TITLES[name], **line(i))
        tidy(ax, "time [s]" if axis == 2 else "", f"{label} [deg]")
        if np.ptp(ax.get_ylim()) < 0.2:
            ax.set_ylim(-0.5, 0.5)
        if axis == 0:
            legend_above(ax)
    ax = figure.add_subplot(grid[:, 1])
    for i, name in enumerate(models):
        t = comparison.trajectories[name]
        style = line(i)
        ax.plot(*100 * t.position.T, color=style["color"], linewidth=0.4, alpha=0.35)
        mean = mean_path(t)
        if mean is not None:
            ax.plot(*100 * mean[1].T, **(style | {"linewidth": 2.0}))
    ax.set_aspect("equal", adjustable="datalim")
    tidy(ax, "x [cm]", "y [cm]")
    ax.set_title("contact point; thick: mean of a cycle", fontsize=FONT)
    return figure


def rolling_shell(
    trajectory: Trajectory,
    times: Any = None,
    *,
    view: tuple[float, float] = (38.0, -60.0),
) -> Figure:
    """The shell and legs in space at some times, with the path of the contact point: Fig 2.

    Args:
        trajectory: of a robot with a spherical shell.
        times: instants (k,) [s]; the start, two thirds of the way round and the end if None.
        view: elevation and azimuth [deg].

    Raises:
        ModelError: the shell is no sphere.
    """
    if not isinstance(trajectory.robot.shell, Sphere):
        raise ModelError(f"rolling_shell draws a sphere; this robot has {trajectory.robot.shell}.")
    instants = np.linspace(0, trajectory.time[-1], 3) if times is None else times
    instants = vector("times", instants, np.size(instants), "s")
    figure = new_figure(6.4, 5.0)
    ax: Any = figure.add_subplot(projection="3d", computed_zorder=False)
    for instant in instants:
        sample = int(np.argmin(np.abs(trajectory.time - instant)))
        top = _draw_robot(ax, trajectory, sample)
        ax.text(*top, f"{trajectory.time[sample]:g} s", fontsize=FONT, ha="center", zorder=10)
    # Over the shells, as if they were of glass.
    x, y = 100 * trajectory.position.T
    ax.plot(x, y, 0 * x, color="#BB5566", linewidth=0.7, zorder=8)
    mean = mean_path(trajectory)
    if mean is not None:
        ax.plot(*100 * mean[1].T, 0, color=BLACK, linewidth=2.0, zorder=9)
        ax.plot(*100 * mean[1][-1][:, None], 0, "o", color=BLACK, markersize=4, zorder=9)
    ax.set_aspect("equal")
    ax.view_init(*view)
    for label, which in (("x [cm]", "x"), ("y [cm]", "y"), ("z [cm]", "z")):
        getattr(ax, f"set_{which}label")(label, fontsize=FONT)
    ax.tick_params(labelsize=FONT - 2)
    return figure


def _draw_robot(ax: Any, trajectory: Trajectory, i: int) -> Array:
    """Three great circles turn with the body; legs from their joints to their links' masses.

    Returns:
        a place above it (3,) [cm].
    """
    import pinocchio as pin

    robot = trajectory.robot
    q = trajectory.configuration[i]
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    rotation = rotation_from_quaternion(q[3:7])
    center = data.oMi[1].act(robot.shell_placement.translation)
    radius = robot.shell.radius  # type: ignore[attr-defined]
    u, w = np.mgrid[0 : 2 * np.pi : 25j, 0 : np.pi : 13j]
    ball = np.stack((np.cos(u) * np.sin(w), np.sin(u) * np.sin(w), np.cos(w)))
    surface = 100 * (center[:, None, None] + radius * ball)
    ax.plot_surface(*surface, color="#E8E4DA", alpha=0.16, linewidth=0, shade=True)
    turn = np.linspace(0, 2 * np.pi, 73)
    for axis, colour in enumerate(("#D55E00", "#0072B2", "#404040")):
        circle = np.zeros((3, turn.size))
        circle[(axis + 1) % 3], circle[(axis + 2) % 3] = np.cos(turn), np.sin(turn)
        ring = 100 * (center[:, None] + radius * rotation @ circle)
        ax.plot(*ring, color=colour, linewidth=0.9, alpha=0.7, zorder=5)
    for name in robot.legs:
        joint = robot.model.getJointId(name)
        hip = 100 * data.oMi[joint].translation
        tip = 100 * data.oMi[joint].act(robot.model.inertias[joint].lever)
        ax.plot(*np.column_stack((hip, tip)), color=BLACK, linewidth=2.2)
        ax.plot(*tip[:, None], "o", color=BLACK, markersize=5)
    ax.plot(*100 * trajectory.position[i][:, None], 0, "x", color=GREY, markersize=5)
    above: Array = 100 * (center + np.array((0.0, 0.0, 1.2 * radius)))
    return above
