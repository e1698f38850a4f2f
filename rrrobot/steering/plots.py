"""Plans, runs and paths in the plane, drawn with what stands in the way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.drawing import BLACK, GREY, PALE, legend_above, line, new_axes, tidy
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.steering.obstacles import Disc, Obstacle

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rrrobot.steering.following import Following
    from rrrobot.steering.plans import Plan
    from rrrobot.steering.unicycle import UnicycleRun


def plan_panel(plan: Plan, trajectory: Trajectory | None = None, ax: Axes | None = None) -> Axes:
    """The coarse plan, the contact point's exact path, obstacles, margins, start and goal.

    Args:
        plan: of `rrrobot.plan`.
        trajectory: the exact motion; simulated by the plan's model unless given.
        ax: new ones unless given.
    """
    axes = new_axes() if ax is None else ax
    if trajectory is None:
        trajectory = plan.execute(method="momentum", sample_interval=0.04)
    draw_obstacles(axes, plan.obstacles, plan.margin)
    axes.plot(*trajectory.position.T, color=PALE, linewidth=0.7, label="contact point")
    axes.plot(*plan.path[:, :2].T, **line(1), label="coarse plan")
    period = 2 * np.pi / plan.gait.angular_frequency
    axes.plot(*cycle_means(trajectory, period)[:, 1:3].T, **line(0), label="mean of a cycle")
    reach = 0.06 * max(np.ptp(trajectory.position, axis=0).max(), 0.05)
    draw_pose(axes, plan.start, reach, "o", "start")
    draw_pose(axes, plan.goal, reach, "s", "goal")
    frame(axes)
    return axes


def cycle_means(trajectory: Trajectory, period: float) -> Array:
    """Means over the last period (time, x, y, yaw) at every sample from the first whole one."""
    time = trajectory.time
    motion = np.column_stack((trajectory.position, trajectory.euler[:, 2]))
    step = np.diff(time)[:, None]
    area = np.vstack((np.zeros(3), np.cumsum(0.5 * step * (motion[1:] + motion[:-1]), axis=0)))
    late = time >= time[0] + period
    before = np.column_stack([np.interp(time[late] - period, time, a) for a in area.T])
    return np.column_stack((time[late] - 0.5 * period, (area[late] - before) / period))


def draw_obstacles(ax: Axes, obstacles: Sequence[Obstacle], margin: float) -> None:
    """Obstacles filled, and the line that the contact point keeps to."""
    from matplotlib.patches import Circle
    from matplotlib.patches import Polygon as Patch

    for number, obstacle in enumerate(obstacles):
        label = "obstacle" if number == 0 else None
        if isinstance(obstacle, Disc):
            x, y = obstacle.center
            ax.add_patch(Circle((x, y), obstacle.radius, color=GREY, label=label))
            low, high = obstacle.center - obstacle.radius, obstacle.center + obstacle.radius
        else:
            ax.add_patch(Patch(obstacle.corners, color=GREY, label=label))
            low, high = obstacle.corners.min(axis=0), obstacle.corners.max(axis=0)
        if margin > 0:
            x, y = (
                np.linspace(a - 1.2 * margin, b + 1.2 * margin, 120)
                for a, b in zip(low, high, strict=True)
            )
            grid = np.stack(np.meshgrid(x, y), axis=-1)
            away = obstacle.distance(grid.reshape(-1, 2)).reshape(grid.shape[:2])
            ax.contour(
                x, y, away, levels=[margin], colors=GREY, linewidths=0.8, linestyles="dotted"
            )


def draw_pose(ax: Axes, pose: Array, reach: float, marker: str, label: str | None = None) -> None:
    """A place with an arrow along the body's x axis."""
    x, y, yaw = pose
    ax.plot([x], [y], marker, color=BLACK, markersize=5, linestyle="none", label=label)
    ax.annotate(
        "", xy=(x + reach * np.cos(yaw), y + reach * np.sin(yaw)), xytext=(x, y),
        arrowprops={"arrowstyle": "->", "color": BLACK, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip


def frame(ax: Axes, **labels: Any) -> None:
    """Axes of a plane seen from above."""
    tidy(ax, labels.get("x", "x [m]"), labels.get("y", "y [m]"))
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08)
    legend_above(ax, columns=3)


def following_panel(run: Following, ax: Axes | None = None) -> Axes:
    """The path, and the robot's mean way along it.

    Args:
        run: of `follow`.
        ax: new ones unless given.
    """
    axes = new_axes() if ax is None else ax
    points = run.track.points
    ring = np.vstack((points, points[:1])) if run.track.closed else points
    axes.plot(*ring.T, **line(1), label="path")
    axes.plot(*run.mean[:, :2].T, **line(0), label="mean of a cycle")
    axes.plot(*run.end[:2], "s", color=BLACK, markersize=5, linestyle="none", label="end")
    frame(axes)
    return axes


def unicycle_panel(run: UnicycleRun, ax: Axes | None = None) -> Axes:
    """A unicycle's path beside the robot's.

    Args:
        run: of `Unicycle.compared`.
        ax: new ones unless given.
    """
    axes = new_axes() if ax is None else ax
    axes.plot(*run.robot[:, :2].T, label="robot, mean of a cycle", **line(0))
    axes.plot(*run.unicycle[:, :2].T, label="unicycle", **line(1))
    axes.plot(*run.robot[0, :2], "o", color=BLACK, markersize=5, linestyle="none", label="start")
    frame(axes)
    return axes
