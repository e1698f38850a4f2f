"""The Pareto front of speed against motor torque, and the gaits along it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rrrobot.checks import Array
from rrrobot.drawing import GREY, PALE, legend_above, line, new_figure, tidy
from rrrobot.studies.optimisation.pareto import ParetoFront

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LABELS = {"torque": "rms motor torque [mN m]", "power": "mean motor power [mW]"}


def pareto(front: ParetoFront) -> Figure:
    """The front with all gaits that were tried, above the gaits along it.

    Args:
        front: of `rrrobot.pareto_front`.
    """
    figure = new_figure(6.4, 7.0)
    grid = figure.add_gridspec(4, 1, height_ratios=(2.6, 1, 1, 1))
    top = front_panel(front, figure.add_subplot(grid[0]))
    top.set_xlabel("")
    top.tick_params(labelbottom=False)
    frequency, amplitude, curvature = (
        figure.add_subplot(grid[row], sharex=top) for row in (1, 2, 3)
    )
    speed = 1000 * front.speed
    omega = [2 * np.pi / (gait.period or np.inf) for gait in front.gaits]
    frequency.plot(speed, omega, **line(0), marker="o", markersize=4)
    tidy(frequency, "", "frequency\n[rad/s]")
    for leg, swing in enumerate(_swings(front).T):
        amplitude.plot(
            speed, swing, **line(leg), marker="os^v"[leg % 4], markersize=4, label=f"leg {leg + 1}"
        )
    tidy(amplitude, "", "swing\n[rad]")
    amplitude.set_ylim(0, 1.15 * float(_swings(front).max()))
    if front.gaits[0].n_legs <= 4:
        legend_above(amplitude)
    curvature.plot(speed, np.abs(front.columns["curvature"]), **line(0), marker="o", markersize=4)
    tidy(curvature, "speed [mm/s]", "|curvature|\n[1/m]")
    for ax in (frequency, amplitude):
        ax.tick_params(labelbottom=False)
    figure.align_ylabels()
    return figure


def front_panel(front: ParetoFront, ax: Axes) -> Axes:
    """Cost over speed on one axes: the front dark, what lost pale."""
    speed, cost = 1000 * front.tried.T
    ax.plot(speed, cost, ".", color=PALE, markersize=2.5, label="gaits that were tried", zorder=1)
    ax.plot(
        1000 * front.speed,
        1000 * front.cost,
        **line(0),
        marker="o",
        markersize=5,
        label="Pareto front",
        zorder=3,
    )
    tidy(ax, "speed [mm/s]", _LABELS[front.cost_name])
    ax.set_xlim(left=0)
    ax.set_ylim(0, 1000 * float(front.cost.max()) * 1.25)
    # A ray from the origin that touches the front is the least cost of a metre.
    best = int(np.argmin(front.cost / front.speed))
    ratio = front.cost[best] / front.speed[best]
    reach = 1000 * np.array((0.0, min(front.speed[-1], 1.25 * front.cost.max() / ratio)))
    ax.plot(reach, ratio * reach, color=GREY, linewidth=0.9, linestyle=":", zorder=2,
            label="least of the front per metre")  # fmt: skip
    legend_above(ax, columns=3)
    return ax


def _swings(front: ParetoFront) -> Array:
    """Half the range of each leg's swing (n, legs) [rad]."""
    ranges = []
    for gait in front.gaits:
        angle = gait(np.linspace(0.0, gait.period or 1.0, 257)).angle
        ranges.append(0.5 * np.ptp(angle, axis=0))
    return np.array(ranges)
