"""Line drawings of a robot from its own model: the kinds of Figs 1, 3-5 and 8-10 of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array
from rrrobot.drawing import BLACK, FONT, GREY, PALE, new_axes
from rrrobot.errors import ParameterError
from rrrobot.models.full import FullModel
from rrrobot.robot.robot import Robot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

VIEWS = {
    "side": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), ("x", "z")),
    "front": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), ("y", "z")),
    "top": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), ("x", "y")),
}
"""World axes that point right and up on the page, and their names. Pitch is seen from the side,
roll from the front, yaw from above."""
_LARGEST_DOT = 15.0
"""Diameter of the heaviest point's dot [pt]; the areas are as the masses."""


class MassPoint(NamedTuple):
    """A link's mass.

    Attributes:
        name: of the link, or of the joint that carries it.
        joint: index of that joint in Pinocchio's model; 1 is the base.
        position: of its mass centre in the world (3,) [m].
        mass: [kg].
    """

    name: str
    joint: int
    position: Array
    mass: float


def mass_points(robot: Robot, configuration: Array) -> list[MassPoint]:
    """The masses of a robot at Pinocchio's q (nq,), links that are fixed to others by themselves.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.paper.schematic import mass_points
        >>> robot = rr.Robot.from_parameters()
        >>> q = rr.FullModel(robot).configuration([0, 0, 0, 1, 0, 0], [1.57, 1.57])
        >>> [point.name for point in mass_points(robot, q)]
        ['battery_mount', 'servo_1_mount', 'servo_2_mount', 'leg_1', 'leg_2']
    """
    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(model, data, configuration)
    points, rest = [], [pin.Inertia(inertia) for inertia in model.inertias]
    for frame in model.frames:
        if frame.inertia.mass > 0:
            own = frame.placement.act(frame.inertia)
            rest[frame.parentJoint] -= own
            at = data.oMi[frame.parentJoint].act(own.lever)
            points.append(MassPoint(frame.name, frame.parentJoint, at, own.mass))
    for joint, inertia in enumerate(rest):
        if inertia.mass > 1e-9 * robot.mass:
            at = data.oMi[joint].act(inertia.lever)
            points.append(MassPoint(model.names[joint], joint, at, inertia.mass))
    return points


def schematic(
    robot: Robot,
    view: str = "side",
    ax: Axes | None = None,
    *,
    leg_angle: ArrayLike = np.pi / 2,
    euler: ArrayLike = (0.0, 0.0, 0.0),
    pivoted: bool = False,
    pale: bool = False,
    names: bool = False,
) -> Axes:
    """The outline of the shell, the legs as lines from their joints and the masses as dots.

    Args:
        robot: any.
        view: "side" along y, "front" along x, "top" along z.
        ax: where to draw; axes in a new figure if None.
        leg_angle: of the legs (legs,) or of all [rad].
        euler: roll, pitch, yaw (3,) [rad]. The robot rolls without slipping from the origin.
        pivoted: hold the shell's centre by a pivot instead of the ground.
        pale: draw it faintly, as one of several positions.
        names: write each mass's name and value beside it.

    Returns:
        the Axes, in metres of equal length.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.paper.schematic import schematic
        >>> schematic(rr.Robot.from_parameters(), "front", names=True).get_xlabel()
        'y [m]'
    """
    if view not in VIEWS:
        raise ParameterError(f"view is {view!r}: it must be one of {', '.join(VIEWS)}.")
    ax = new_axes() if ax is None else ax
    right, up, labels = VIEWS[view]
    project = np.array((right, up))
    turned = np.broadcast_to(np.asarray(euler, dtype=float), (3,))
    model = FullModel(robot, damping=None)
    legs = np.broadcast_to(np.asarray(leg_angle, dtype=float), (robot.n_legs,))
    q = model.configuration(model.make_pose(turned, _rolled(robot, turned, pivoted)), legs)
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    shell = data.oMi[1] * robot.shell_placement
    edge = GREY if pale else BLACK
    _outline(ax, robot, shell, project, edge, 0.8 if pale else 1.4)
    _legs(ax, robot, data, project, edge, 1.0 if pale else 2.2)
    _dots(ax, mass_points(robot, q), project, edge, names)
    centre = project @ shell.translation
    if pivoted:
        ax.plot(*centre, marker="^", color=edge, markersize=9, markerfacecolor="white", zorder=5)
    elif view != "top":
        contact = project @ (shell.translation + robot.shell.arm(shell.rotation, _Z))
        ax.axhline(contact[1], color=BLACK, linewidth=1.0, zorder=0)
        ax.plot(*contact, marker="o", color=edge, markersize=3, zorder=6)
    ax.set_aspect("equal")
    ax.set_xlabel(f"{labels[0]} [m]", fontsize=FONT)
    ax.set_ylabel(f"{labels[1]} [m]", fontsize=FONT)
    ax.tick_params(labelsize=FONT - 1)
    ax.spines[["top", "right"]].set_visible(False)
    ax.margins(0.12)
    ax.locator_params(nbins=6)
    return ax


_Z = np.array((0.0, 0.0, 1.0))


def turn_arrow(ax: Axes, centre: tuple[float, float], radius: float, text: str) -> None:
    """A round double arrow above a point, with the name of the angle."""
    from matplotlib.patches import FancyArrowPatch

    ends = [(centre[0] + s * radius * 0.7, centre[1] + 0.7 * radius) for s in (-1.0, 1.0)]
    ax.add_patch(
        FancyArrowPatch(
            *ends, arrowstyle="<|-|>", connectionstyle="arc3,rad=-0.4", mutation_scale=10,
            color=BLACK, linewidth=1.2,
        )
    )  # fmt: skip
    ax.text(centre[0], centre[1] + 1.12 * radius, text, ha="center", va="bottom", fontsize=FONT)


def _rolled(robot: Robot, euler: Array, pivoted: bool) -> Array:
    """Contact point after rolling from the upright pose (2,) [m]; a pivoted shell stays."""
    radius = robot.shell.arm(np.eye(3), _Z)[2]
    if pivoted:
        return np.zeros(2)
    return np.array((-radius * euler[1], radius * euler[0]))


def _outline(
    ax: Axes, robot: Robot, shell: pin.SE3, project: Array, colour: str, width: float
) -> None:
    # The outline has the normals that lie in the page; a convex body's is traced by them.
    turn = np.linspace(0, 2 * np.pi, 181)
    normals = np.outer(np.cos(turn), project[0]) + np.outer(np.sin(turn), project[1])
    points = [shell.act(robot.shell.contact(shell.rotation.T @ n)) for n in normals]
    outline = np.array(points) @ project.T
    ax.fill(*outline.T, facecolor=PALE, alpha=0.25, edgecolor="none", zorder=1)
    ax.plot(*outline.T, color=colour, linewidth=width, zorder=2)
    # A line across shows how far the shell has turned.
    across = shell.rotation @ np.array((0.0, 0.0, 1.0))
    if np.hypot(*(project @ across)) > 0.1:
        ends = [shell.act(robot.shell.contact(s * np.array((0.0, 0.0, 1.0)))) for s in (-1, 1)]
    else:
        ends = [shell.act(robot.shell.contact(s * np.array((1.0, 0.0, 0.0)))) for s in (-1, 1)]
    ax.plot(*(np.array(ends) @ project.T).T, color=colour, linewidth=0.6, linestyle=":", zorder=2)


def _legs(
    ax: Axes, robot: Robot, data: pin.Data, project: Array, colour: str, width: float
) -> None:
    model = robot.model
    for joint in range(2, model.njoints):
        start = data.oMi[joint].translation
        ends = [
            data.oMi[j].translation for j in range(2, model.njoints) if model.parents[j] == joint
        ]
        if model.inertias[joint].mass > 0 and not ends:
            ends = [data.oMi[joint].act(model.inertias[joint].lever)]
        for end in ends:
            ax.plot(
                *(np.array((start, end)) @ project.T).T, color=colour, linewidth=width, zorder=3
            )
        ax.plot(
            *(project @ start), "o", color=colour, markersize=4, markerfacecolor="white", zorder=4
        )


def _dots(ax: Axes, points: list[MassPoint], project: Array, colour: str, names: bool) -> None:
    heaviest = max((point.mass for point in points), default=1.0)
    seen: dict[tuple[float, float], list[str]] = {}
    for point in points:
        at = project @ point.position
        size = _LARGEST_DOT * (point.mass / heaviest) ** 0.5
        ax.plot(*at, "o", color=colour, markersize=size, zorder=5)
        text = f"{point.name.removesuffix('_mount')}, {point.mass:g} kg"
        seen.setdefault((round(at[0], 6), round(at[1], 6)), []).append(text)
    for place, texts in seen.items():
        if names:
            ax.annotate(
                "\n".join(texts),
                place,
                (9, 5),
                textcoords="offset points",
                fontsize=FONT - 1,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8},
            )
