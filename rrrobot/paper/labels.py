"""Letters, lengths and angles on the line drawings: what makes Fig 1 of the paper readable."""

from __future__ import annotations

from itertools import groupby
from string import ascii_uppercase
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array
from rrrobot.drawing import BLACK, FONT, GREY
from rrrobot.models.full import FullModel
from rrrobot.paper.schematic import mass_points
from rrrobot.robot.robot import Robot

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def lettered(robot: Robot, ax: Axes) -> None:
    """Letters A, B, ... at the masses of a robot seen from the front, and below what they are.

    They go from the top of the robot's right, over its bottom, to the top of its left, as in the
    paper: there A and E are the legs, B and D the servos, C the battery.
    """
    points = mass_points(robot, _upright(robot))
    points.sort(key=lambda p: (round(p.position[1], 9), np.sign(p.position[1]) * p.position[2]))
    words = []
    for letter, point in zip(ascii_uppercase, points, strict=False):
        _, y, z = point.position
        ax.annotate(
            letter, (y, z), (-12 if y < 0 else 12, 6), textcoords="offset points", ha="center",
            va="center", fontsize=FONT + 2, fontweight="bold", zorder=9,
        )  # fmt: skip
        words.append((letter, f"{_plain(point.name)}, {1000 * point.mass:.3g} g"))
    words.sort(key=lambda word: word[1])
    lines = [
        f"{', '.join(letter for letter, _ in same)}: {text}"
        for text, same in ((t, list(g)) for t, g in groupby(words, key=lambda word: word[1]))
    ]
    # Below the axis' own label, so that the layout keeps room for both.
    ax.set_xlabel(f"{ax.get_xlabel()}\n{'    '.join(lines)}", fontsize=FONT)


def dimensions(robot: Robot, ax: Axes) -> None:
    """Radius, hip offset and leg length of a robot with a sphere, seen from the front."""
    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(model, data, _upright(robot))
    centre = data.oMi[1].act(robot.shell_placement.translation)[1:]
    radius = robot.shell.support(np.array((0.0, 1.0, 0.0)))
    tilt = np.array((np.cos(-0.7), np.sin(-0.7)))
    _length(ax, centre, centre + radius * tilt, f"r = {radius:g} m", tilt)
    joint = model.getJointId(robot.legs[-1])
    hip = data.oMi[joint].translation[1:]
    tip = data.oMi[joint].act(model.inertias[joint].lever)[1:]
    aside = np.array((0.022, 0.0)) * (1 if hip[0] >= 0 else -1)
    side = 1 if hip[0] >= 0 else -1
    _length(ax, hip + aside, tip + aside, "", np.zeros(2))
    ax.annotate(
        f"l = {np.linalg.norm(tip - hip):.3g} m", (hip + tip) / 2 + aside, (4 * side, 0),
        textcoords="offset points", rotation=90, fontsize=FONT - 1, va="center",
        ha="left" if side > 0 else "right",
    )  # fmt: skip
    up = np.array((0.0, 0.02))
    level = np.array((centre[0], hip[1]))
    _length(ax, level + up, hip + up, f"b = {abs(hip[0] - centre[0]):g} m", np.zeros(2))


def leg_angles(robot: Robot, ax: Axes, angles: ArrayLike) -> None:
    """The angle of each leg from the horizontal, seen from the side."""
    from matplotlib.patches import Arc

    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(model, data, _upright(robot))
    for i, (name, angle) in enumerate(zip(robot.legs, np.asarray(angles), strict=True)):
        joint = model.getJointId(name)
        x, _, z = data.oMi[joint].translation
        size = (0.35 + 0.3 * i) * float(np.linalg.norm(model.inertias[joint].lever))
        arc = Arc((x, z), 2 * size, 2 * size, theta1=0, theta2=np.rad2deg(angle), color=BLACK)
        ax.add_patch(arc)
        middle = 0.5 * angle if i else 0.35 * angle
        ax.text(
            x + 1.3 * size * np.cos(middle), z + 1.3 * size * np.sin(middle),
            rf"$\phi_{i + 1}$", fontsize=FONT + 1, ha="center", va="center",
        )  # fmt: skip
    radius = robot.shell.support(np.array((1.0, 0.0, 0.0)))
    ax.plot((x, x + 0.8 * radius), (z, z), color=GREY, linewidth=0.8, linestyle="--", zorder=2)


def _upright(robot: Robot) -> Array:
    model = FullModel(robot, damping=None)
    return model.configuration(
        model.make_pose(np.zeros(3), np.zeros(2)), np.full(robot.n_legs, np.pi / 2)
    )


def _plain(name: str) -> str:
    """A link's name without its number and without what says that it is fixed."""
    name = name.removesuffix("_mount")
    return name.rstrip("0123456789").rstrip("_")


def _length(ax: Axes, start: Array, end: Array, text: str, along: Array) -> None:
    ax.annotate(
        "", xy=(end[0], end[1]), xytext=(start[0], start[1]), zorder=8,
        arrowprops={"arrowstyle": "<|-|>", "color": GREY, "lw": 0.9, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip
    middle = 0.5 * (start + end)
    upright = abs(end[0] - start[0]) < abs(end[1] - start[1]) and not along.any()
    ax.text(
        middle[0], middle[1], text, fontsize=FONT - 1, color=BLACK, zorder=9,
        ha="left" if upright else "center", va="center" if upright else "bottom",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.8},
    )  # fmt: skip
