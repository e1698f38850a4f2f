"""What a shell looks like that the URDF does not draw, from its support function.

It is translucent, with three bands that show its rotation. Of a shell far larger than the robot's
base, such as the dome of a flat belly, only the part below is drawn.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.surfaces import Surface
from rrrobot.robot.robot import Robot
from rrrobot.view.commands import Colour, Geometry, mesh
from rrrobot.view.player import Figure
from rrrobot.view.visual import Visual

BAND_COLOURS: tuple[Colour, ...] = ((0.84, 0.37, 0.0), (0.0, 0.45, 0.7), (0.25, 0.25, 0.25))
_SHELL_NAMES = ("shell", "band_x", "band_y", "band_z")
SHELL_COLOUR: Colour = (0.93, 0.91, 0.86, 0.4)
_LARGE, _CAP = 1.6, 1.5
"""Size of a shell, over the reach of its base's visuals, from which it is drawn as a cap, and that
cap's."""
_THIN, _WIDE = 2e-3, 0.2
"""Thickness of a flat belly's plate, and its half length where it has none [m]."""


class Cap(NamedTuple):
    """The part of a shell that is drawn."""

    angle: float
    """of its normals from straight down [rad]"""
    reach: float
    """of its points from the lowest [m]"""


def cap_of(robot: Robot | Figure, visuals: Iterable[Visual]) -> Cap | None:
    """The part below of a shell that is far larger than the base's visuals; else None."""
    base = [v for v in visuals if v.joint == 1 and v.name not in _SHELL_NAMES]
    reach = max((float(np.linalg.norm(v.placement.translation)) + v.reach for v in base), default=0)
    drawn = any(v.shell for v in visuals) or isinstance(robot.shell, FlatBelly)
    if drawn or not 0 < _LARGE * reach < shell_size(robot):
        return None
    angles = np.linspace(0, math.pi / 2, 46)[1:]
    far = [np.linalg.norm(_below(robot, angle), axis=-1).max() for angle in angles]
    k = max(0, int(np.searchsorted(far, _CAP * reach)) - 1)
    return Cap(float(angles[k]), float(far[k]))


def _below(robot: Robot | Figure, angle: float) -> Array:
    """Points of a shell with normals at an angle from straight down, from the lowest (n, 3) [m]."""
    shell, turn = robot.shell, robot.shell_placement.rotation.T
    rim = directions(np.array((angle - math.pi / 2,)), around(16))[0] @ turn.T
    lowest = shell.contact(-turn[:, 2])
    return np.array([shell.contact(u) for u in rim]) - lowest


def shell_size(robot: Robot | Figure) -> float:
    """The shell's largest half-width along its axes [m]."""
    if isinstance(robot.shell, FlatBelly):
        return max(_plate(robot.shell))
    return max(robot.shell.support(u) for u in np.vstack((np.eye(3), -np.eye(3))))


def _plate(belly: FlatBelly) -> tuple[float, float]:
    """Half lengths of a flat belly that are shown [m]."""
    return belly.half_length or _WIDE, belly.half_width or _WIDE


def shell_visuals(robot: Robot | Figure, cap: Cap | None = None) -> list[Visual]:
    """A translucent shell with a band around each of its three axes; of a flat belly, a plate."""
    place, shell = robot.shell_placement, robot.shell
    if cap is not None:
        return _cap_visuals(robot, cap)
    if isinstance(shell, FlatBelly):
        x, y = _plate(shell)
        plate = {"type": "BoxGeometry", "width": 2 * x, "height": 2 * y, "depth": _THIN}
        return [Visual("shell", 1, place, plate, SHELL_COLOUR, math.hypot(x, y))]
    latitude, longitude = np.linspace(-math.pi / 2, math.pi / 2, 33), around(64)
    reach = max(float(np.linalg.norm(shell.contact(u))) for u in np.vstack((np.eye(3), -np.eye(3))))
    body = _round_mesh(shell, latitude, longitude, np.eye(3))
    visuals = [Visual("shell", 1, place, body, SHELL_COLOUR, reach)]
    for i, colour in enumerate(BAND_COLOURS):
        axes = np.roll(np.eye(3), 2 - i, axis=1)  # the i-th is the last
        band = _round_mesh(shell, np.array((-0.05, 0.0, 0.05)), longitude, axes, 1.004 + 0.002 * i)
        visuals.append(Visual(f"band_{'xyz'[i]}", 1, place, band, colour, reach))
    return visuals


def _cap_visuals(robot: Robot | Figure, cap: Cap) -> list[Visual]:
    """The part below, arcs below the base's x and y axes, and the rim."""
    shell, turn = robot.shell, robot.shell_placement.rotation.T
    lowest, low = shell.contact(-turn[:, 2]), -math.pi / 2
    place = robot.shell_placement * pin.SE3(np.eye(3), lowest)
    wide = 0.06 * cap.angle * np.array((-1.0, 0.0, 1.0))
    arc = np.linspace(-cap.angle, cap.angle, 33)
    parts = [
        ("shell", SHELL_COLOUR, low + np.linspace(0, cap.angle, 13), around(64), np.eye(3), 1.0),
        # Of the axes, the third is along which the arc is narrow.
        ("band_x", BAND_COLOURS[0], wide, arc + low, np.eye(3)[:, [1, 2, 0]], 1.0005),
        ("band_y", BAND_COLOURS[1], wide, arc + math.pi, np.eye(3)[:, [2, 0, 1]], 1.001),
        ("band_z", BAND_COLOURS[2], low + cap.angle + wide, around(64), np.eye(3), 1.0015),
    ]  # fmt: skip
    return [
        Visual(name, 1, place, _round_mesh(shell, up, along, turn @ axes, scale, lowest), colour,
               cap.reach)
        for name, colour, up, along, axes, scale in parts
    ]  # fmt: skip


def around(count: int) -> Array:
    """Angles of a whole turn, both ends included (count + 1,) [rad]."""
    return np.linspace(0, 2 * math.pi, count + 1)


def directions(latitude: Array, longitude: Array) -> Array:
    """Unit vectors (latitudes, longitudes, 3) about z."""
    up, round_ = np.meshgrid(latitude, longitude, indexing="ij")
    flat = np.cos(up)
    return np.stack((flat * np.cos(round_), flat * np.sin(round_), np.sin(up)), axis=-1)


def _round_mesh(
    shell: Surface,
    latitude: Array,
    longitude: Array,
    axes: Array,
    scale: float = 1.0,
    origin: Array | float = 0.0,
) -> Geometry:
    """Part of a shell: its points whose normals are directions about the third of the axes."""
    normals = directions(latitude, longitude) @ axes.T
    points = np.array([[shell.contact(u) for u in row] for row in normals])
    return lattice(scale * points - origin)


def lattice(points: Array) -> Geometry:
    """Triangles between neighbours of a lattice of points (m, n, 3)."""
    m, n, _ = points.shape
    corner = (np.arange(m - 1)[:, None] * n + np.arange(n - 1)).ravel()
    a, b, c, d = corner, corner + 1, corner + n + 1, corner + n
    faces = np.concatenate((np.stack((a, b, c), axis=1), np.stack((a, c, d), axis=1)))
    return mesh(points.reshape(-1, 3), faces)
