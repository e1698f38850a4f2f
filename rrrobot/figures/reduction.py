"""Height functions with leg cycles on them: Fig 13 of the paper, for any pair of joints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.drawing import BLACK, FONT, LINES, legend_above, new_axes, tidy
from rrrobot.drive.gaits import Gait
from rrrobot.drive.moves import out_of_phase_gait
from rrrobot.models.single_axis import YawModel
from rrrobot.reduction.connection import Connection, as_connection
from rrrobot.reduction.heights import FULL_TURN, height_grid, pair_box, zero_set
from rrrobot.reduction.yaw import leg_span, net_yaw
from rrrobot.robot.robot import Robot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D


def height_map(
    source: Connection | Robot | YawModel,
    cycles: Mapping[str, Gait] | None = None,
    ax: Axes | None = None,
    *,
    pair: tuple[int, int] = (0, 1),
    angle_range: ArrayLike = FULL_TURN,
    leg_angle: ArrayLike | None = None,
    resolution: int = 81,
    signs: bool = True,
) -> Axes:
    """Height function of two legs: shades and signs for its value, thick lines where it is zero.

    Args:
        source: a robot or its connection.
        cycles: label -> gait, drawn with an arrow and the net yaw per cycle in the legend.
        ax: where to draw; axes in a new figure if None.
        pair: indices of two legs.
        angle_range: (low, high) of both legs, or a row for each [rad].
        leg_angle: where the other legs are (legs,) [rad]; zero unless given.
        resolution: grid points of each leg.
        signs: mark regions with + and -.

    Returns:
        the Axes.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.figures.reduction import height_map
        >>> ax = height_map(rr.Robot.from_parameters(), resolution=9)
        >>> ax.figure.savefig("heights.png")
    """
    from matplotlib.lines import Line2D

    connection = as_connection(source)
    pair = connection.pair(pair)
    if ax is None:
        ax = new_axes()
        ax.figure.set_size_inches(5.8, 5.4)  # type: ignore[union-attr]
    setting = {
        "pair": pair,
        "angle_range": angle_range,
        "leg_angle": leg_angle,
        "resolution": resolution,
    }
    first, second, heights = height_grid(connection, **setting)  # type: ignore[arg-type]
    largest = float(np.abs(heights).max()) or 1.0
    shades = ax.pcolormesh(
        first, second, heights.T, cmap="RdBu_r", vmin=-1.35 * largest, vmax=1.35 * largest,
        shading="gouraud", rasterized=True,
    )  # fmt: skip
    ax.contour(
        first, second, heights.T, levels=np.array((-0.75, -0.5, -0.25, 0.25, 0.5, 0.75)) * largest,
        colors="#606060", linewidths=0.5, negative_linestyles="dashed",
    )  # fmt: skip
    handles = []
    if np.abs(heights).max() > 0:
        for zero in zero_set(connection, **setting):  # type: ignore[arg-type]
            ax.plot(*zero.T, color=BLACK, linewidth=1.6)
        handles.append(Line2D([], [], color=BLACK, linewidth=1.6, label="zero"))
    if signs:
        _mark_signs(ax, first, second, heights)
    for i, (label, gait) in enumerate((cycles or {}).items()):
        handles.append(_draw_cycle(ax, connection, pair, label, gait, i))
    bar = ax.figure.colorbar(shades, ax=ax, shrink=0.85)
    bar.set_label(r"height function [rad/rad$^2$]", fontsize=FONT)
    bar.ax.tick_params(labelsize=FONT - 1)
    names = [connection.robot.legs[i] for i in pair]
    tidy(ax, f"{names[0]} [rad]", f"{names[1]} [rad]")
    ax.grid(False)
    box = pair_box(angle_range)
    ax.set_xlim(*box[0])
    ax.set_ylim(*box[1])
    ax.set_aspect("equal")
    if handles:
        legend_above(ax, [*handles], columns=1)
    return ax


def fig_13(source: Connection | Robot | YawModel) -> Figure:
    """Fig 13: the yaw model's height function with the paper's trajectories A and B.

    Both legs at offset + 0.3 (sin, cos) 8 t: A at the offset 5 pi/8 + 0.15, which turns the body,
    B at pi/2, which does not.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.figures.reduction import fig_13
        >>> fig_13(rr.Robot.from_parameters()).savefig("fig13.png")
    """
    offsets = {"A": 5 * np.pi / 8 + 0.15, "B": np.pi / 2}
    cycles = {name: out_of_phase_gait(offset=offset) for name, offset in offsets.items()}
    ax = height_map(source, cycles, angle_range=(-0.35, np.pi + 0.35))
    return ax.figure  # type: ignore[return-value]


def _draw_cycle(
    ax: Axes, connection: Connection, pair: tuple[int, int], label: str, gait: Gait, i: int
) -> Line2D:
    from matplotlib.lines import Line2D

    yaw = net_yaw(connection, gait)
    times = np.linspace(*leg_span(connection, gait), 721)
    x, y = gait(times).angle[:, pair].T
    style = {"color": ("#3F007D", "#00441B", "#7F3B08")[i % 3], "linestyle": LINES[i % len(LINES)]}
    ax.plot(x, y, linewidth=2.0, **style)
    ax.annotate(
        "", xy=(x[95], y[95]), xytext=(x[85], y[85]),
        arrowprops={"arrowstyle": "-|>", "color": style["color"], "lw": 2.0},
    )  # fmt: skip
    if len(label) <= 3:
        ax.annotate(
            label, ((x.min() + x.max()) / 2, y.max()), (0, 4), textcoords="offset points",
            ha="center", fontsize=FONT + 1, weight="bold",
        )  # fmt: skip
    shown = "0" if abs(yaw) < 1e-10 else f"{np.rad2deg(yaw):+.4f} deg"
    return Line2D([], [], linewidth=2.0, label=f"{label}: {shown} a cycle", **style)


def _mark_signs(ax: Axes, first: np.ndarray, second: np.ndarray, heights: np.ndarray) -> None:
    """A + or - in the middle of each region of one sign that is not too small."""
    from scipy.ndimage import distance_transform_edt, label

    tiny = 1e-9 * float(np.abs(heights).max())
    for sign, mark in ((1, "+"), (-1, "\N{MINUS SIGN}")):
        labels, count = label(sign * heights > tiny)
        for i in range(1, count + 1):
            inside = np.pad(labels == i, 1)
            if inside.sum() < 0.01 * heights.size:
                continue
            depth = distance_transform_edt(inside)[1:-1, 1:-1]
            j, k = np.unravel_index(int(np.argmax(depth)), heights.shape)
            ax.text(first[j], second[k], mark, ha="center", va="center", fontsize=FONT + 9)
