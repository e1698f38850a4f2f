"""A picture of a belly: the shell over the robot's pieces, from the side and from the front."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rrrobot.belly.placed import curvature_of, placed
from rrrobot.checks import Array
from rrrobot.contact.shells import FlatBelly
from rrrobot.drawing import COLOURS, legend_above, new_figure, tidy
from rrrobot.robot.joints import JointIndex

if TYPE_CHECKING:
    from rrrobot.belly.found import Belly

_BASE, _LEGS, _SHELL = "#9A9A9A", "#E0E0E0", COLOURS[0]
_VIEWS = (("x", 0, "from the left"), ("y", 1, "from the front"))


def sections(belly: Belly, axes: Any = None) -> Any:
    """Draw the shell over outlines of the pieces, upright, in the belly's posture.

    Args:
        belly: the fit.
        axes: two Axes, for x and z and for y and z; a new figure's unless given.

    Returns:
        the two Axes.
    """
    if axes is None:
        axes = new_figure(9.0, 4.4).subplots(1, 2)
    pieces = placed(belly.robot, belly.shapes.pieces, belly.posture)
    for ax, (name, i, view) in zip(axes, _VIEWS, strict=True):
        for part in sorted(pieces, key=lambda p: p.joint == 1):
            outline = _outline(part.points[:, [i, 2]], part.radius)
            base = part.joint == 1
            ax.fill(*outline.T, facecolor=_BASE if base else _LEGS, edgecolor="0.35", lw=0.5,
                    zorder=2 if base else 1)  # fmt: skip
        limits = ax.axis()
        _draw_shell(ax, belly, i)
        low = belly.center[2] - belly.shell_depth
        ax.plot(*_center_of_mass(belly)[[i, 2]], "ko", ms=6, zorder=6, label="centre of mass")
        pad = 0.06 * (limits[1] - limits[0])
        ax.set_xlim(limits[0] - pad, limits[1] + pad)
        ax.set_ylim(min(limits[2], low) - 2 * pad, limits[3] + pad)
        ax.set_aspect("equal")
        tidy(ax, f"{name} of the base [m], {view}", "z of the base [m]")
    legend_above(axes[0])
    return axes


def _draw_shell(ax: Any, belly: Belly, i: int) -> None:
    """Shell and ground, upright."""
    width = np.ptp(ax.get_xlim())
    if isinstance(belly.shell, FlatBelly):
        half = (belly.shell.half_length, belly.shell.half_width)[i] or width
        ends = belly.center[i] + np.array((-half, half))
        ax.plot(ends, [belly.center[2]] * 2, color=_SHELL, lw=3, zorder=4, label="belly")
    else:
        reach = belly.rolling_range.at(np.array((0.0, np.pi)) + i * np.pi / 2)
        tilt = np.linspace(-reach[1], reach[0], 121)
        points = _arc(belly, i, tilt)
        far = _arc(belly, i, np.linspace(-np.pi / 2, np.pi / 2, 181))
        ax.plot(*far.T, color=_SHELL, lw=0.8, ls="--", zorder=4)
        ax.plot(*points.T, color=_SHELL, lw=3, zorder=4, label="shell within the rolling range")
    k, low = curvature_of(belly.ground), belly.center[2] - belly.shell_depth
    across = np.linspace(-1, 1, 201) * min(2 * width, 0.98 / abs(k) if k else np.inf)
    below = low - k * across**2 / (1 + np.sqrt(1 - (k * across) ** 2))
    ax.plot(belly.center[i] + across, below, color="0.2", lw=1, zorder=3)


def _arc(belly: Belly, i: int, tilt: Array) -> Array:
    normal = np.zeros((len(tilt), 3))
    normal[:, i], normal[:, 2] = np.sin(tilt), -np.cos(tilt)
    return np.array([belly.center + belly.shell.contact(u) for u in normal])[:, [i, 2]]


def _center_of_mass(belly: Belly) -> Array:
    import pinocchio as pin

    model, q = belly.robot.model, pin.neutral(belly.robot.model)
    JointIndex(model, belly.robot.legs).write(q, belly.posture)
    return np.array(pin.centerOfMass(model, model.createData(), q))


def _outline(points: Array, radius: float) -> Array:
    """Corners of the hull of points in a plane (n, 2), with a radius around them."""
    from scipy.spatial import ConvexHull, QhullError

    turn = np.linspace(0, 2 * np.pi, 33)
    ring = radius * np.column_stack((np.cos(turn), np.sin(turn)))
    every = (points[:, None, :] + ring).reshape(-1, 2) if radius else points
    try:
        return every[ConvexHull(every).vertices]
    except (QhullError, ValueError):
        return every
