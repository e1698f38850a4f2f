"""RRRobot as a vertical unicycle: the kind of Fig 17 of the paper.

A unicycle whose wheel stands in the plane of the leg axis and the vertical moves along that axis
at v while it turns at alpha:

    x_dot = -v sin(yaw),    y_dot = v cos(yaw),    yaw_dot = alpha

It is compared with the mean motion over the gait's cycles.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drawing import BLACK, FONT, GREY, legend_above, line, new_figure, tidy
from rrrobot.paper.schematic import schematic, turn_arrow
from rrrobot.simulation.plots import cycle_mean
from rrrobot.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class UnicyclePath(NamedTuple):
    """The robot's mean path and the unicycle's that starts with it.

    Attributes:
        time: middle of each cycle (n,) [s].
        robot: contact point averaged over the cycle (n, 2) [m].
        unicycle: of the same steady speed along the leg axis, yaw rate and first yaw (n, 2) [m].
        length: of the robot's mean path [m].
        error: largest distance between the two [m].
        side_slip: angle from the leg axis to the mean velocity, that a unicycle cannot have [rad].
    """

    time: Array
    robot: Array
    unicycle: Array
    length: float
    error: float
    side_slip: float


def unicycle_path(trajectory: Trajectory) -> UnicyclePath:
    """The unicycle with the trajectory's steady state, over the counted cycles.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.paper.unicycle import unicycle_path
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> found = unicycle_path(rr.simulate(model, rr.gait("circular"), duration=30.0))
        >>> found.error < 0.02 * found.length
        True
    """
    state = trajectory.steady_state()
    values = np.column_stack((trajectory.position, trajectory.euler[:, 2]))
    time, means = cycle_mean(trajectory.time, values, state.period)
    counted = time >= state.after + 0.5 * state.period
    time, robot, yaw = time[counted], means[counted, :2], means[counted, 2]
    v, alpha = state.velocity[1], state.yaw_rate
    since = time - time[0]
    # The chord of an arc: v t sinc(alpha t / 2), half the turn ahead.
    ahead = yaw[0] + 0.5 * alpha * since
    chord = v * since * np.sinc(0.5 * alpha * since / np.pi)
    path = robot[0] + np.column_stack((-np.sin(ahead), np.cos(ahead))) * chord[:, None]
    return UnicyclePath(
        time=time,
        robot=robot,
        unicycle=path,
        length=float(np.linalg.norm(np.diff(robot, axis=0), axis=1).sum()),
        error=float(np.linalg.norm(robot - path, axis=1).max()),
        side_slip=float(-np.arctan2(state.velocity[0], abs(v)) * np.sign(v)),
    )


def unicycle(trajectories: dict[str, Trajectory]) -> Figure:
    """The robot from above beside a unicycle, and both paths for each gait: Fig 17.

    Args:
        trajectories: of one robot, by the name of the gait.
    """
    figure = new_figure(2.4 * (1 + len(trajectories)), 3.6)
    panels = figure.subplots(1, 1 + len(trajectories))
    robot = next(iter(trajectories.values())).robot
    _from_above(schematic(robot, "top", panels[0], leg_angle=np.pi / 4))
    for ax, (name, trajectory) in zip(panels[1:], trajectories.items(), strict=True):
        found = unicycle_path(trajectory)
        ax.plot(*100 * found.robot.T, label="robot, cycle mean", **line(0))
        ax.plot(*100 * found.unicycle.T, label="unicycle", **line(1))
        ax.plot(*100 * found.robot[0], "o", color=BLACK, markerfacecolor="white", markersize=5)
        ax.set_aspect("equal", adjustable="datalim")
        tidy(ax, "x [cm]", "y [cm]")
        ax.set_title(
            f"{name}: {1000 * found.error:.2f} mm off\nin {1000 * found.length:.0f} mm",
            fontsize=FONT, pad=30,
        )  # fmt: skip
        legend_above(ax, columns=1)
    return figure


def _from_above(ax: Axes) -> None:
    """A wheel with its plane along the leg axis, the velocity and the turning."""
    from matplotlib.patches import Rectangle

    reach = max(abs(v) for v in ax.dataLim.intervaly)
    ax.add_patch(Rectangle((-0.08 * reach, -0.5 * reach), 0.16 * reach, reach, facecolor="white",
                           edgecolor=GREY, hatch="////", zorder=3))  # fmt: skip
    arrow = {"arrowstyle": "-|>", "color": BLACK, "lw": 1.6}
    ax.annotate("", (0, 1.75 * reach), (0, 0.55 * reach), arrowprops=arrow)
    ax.text(0.1 * reach, 1.6 * reach, "v", fontsize=FONT + 2)
    turn_arrow(ax, (0.0, -1.75 * reach), 0.4 * reach, r"$\alpha$")
    ax.set_ylim(-2.0 * reach, 2.0 * reach)
    ax.locator_params(axis="x", nbins=3)
    ax.set_title("wheel along the leg axis", fontsize=FONT, pad=6)
