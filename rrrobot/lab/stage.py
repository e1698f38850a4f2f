"""The scene's commands, which Meshcat draws with three.js, drawn by viser for one client."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.view.commands import Command, Geometry

_AROUND = 48
_PAPER = np.array((247.0, 249.0, 251.0))
"""What is behind the ground's lines."""


class Stage:
    """Carries out commands of `rrrobot.view.commands` in a scene of viser.

    Cameras, lights and backgrounds are viser's own.

    Args:
        scene: of a client or a server of viser.
    """

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self._nodes: dict[str, Any] = {}
        self._meshes: dict[str, Command] = {}
        """looks of the nodes that are meshes: of the same look, only the triangles are sent anew"""

    def send(self, commands: Iterable[Command]) -> None:
        """Carry out commands in their order."""
        for command in commands:
            if not command["path"].startswith("/world"):
                continue
            kind = command["type"]
            if kind == "set_object":
                self._put(command["path"], command["object"])
            elif kind == "set_transform":
                self.place(command["path"], np.reshape(command["matrix"], (4, 4)).T)
            elif kind == "set_property" and command["property"] == "visible":
                self.show(command["path"], bool(command["value"]))
            elif kind == "delete":
                self.remove(command["path"])

    def place(self, path: str, matrix: Array) -> None:
        """Move a node by a homogeneous matrix (4, 4)."""
        node = self._group(path)
        node.wxyz, node.position = wxyz(matrix[:3, :3]), matrix[:3, 3]

    def show(self, path: str, visible: bool) -> None:
        """Show or hide a node and all below it."""
        self._group(path).visible = visible

    def remove(self, path: str) -> None:
        """Take a node and all below it away."""
        if path not in self._nodes:
            return
        for name in [n for n in self._nodes if f"{n}/".startswith(f"{path}/")]:
            del self._nodes[name]
            self._meshes.pop(name, None)
        self._scene.remove_by_name(path)

    def put(self, path: str, node: Any) -> Any:
        """Remember a node that was added to the scene by other means."""
        self._nodes[path] = node
        return node

    def parent(self, path: str) -> None:
        """Make sure that all above a path is there."""
        above = path.rsplit("/", 1)[0]
        if above:
            self._group(above)

    def _group(self, path: str) -> Any:
        if path not in self._nodes:
            self.parent(path)
            self._nodes[path] = self._scene.add_frame(path, show_axes=False)
        return self._nodes[path]

    def _put(self, path: str, data: Any) -> None:
        body, look, shape = data["object"], data["materials"][0], data["geometries"][0]
        matrix = np.reshape(body["matrix"], (4, 4)).T
        self.parent(path)
        at = {"wxyz": wxyz(matrix[:3, :3]), "position": matrix[:3, 3]}
        if look["type"] == "ShadowMaterial":
            node = self._scene.add_grid(
                path, shape["width"], shape["height"], cell_thickness=0.0, section_thickness=0.0,
                shadow_opacity=0.7 * look["opacity"], **at,
            )  # fmt: skip
        elif look.get("colorWrite") is False:
            return
        elif body["type"] == "LineSegments":
            points, tint = _lines(shape, look)
            node = self._scene.add_line_segments(
                path, points, tint, thickness=1.0, thickness_units="screen", **at
            )
        else:
            vertices, faces = triangles(shape)
            if self._meshes.get(path) == look:
                node = self._nodes[path]
                node.vertices, node.faces = vertices, faces
                node.wxyz, node.position = at["wxyz"], at["position"]
                return
            opacity = look["opacity"]
            flat = look["type"] == "MeshBasicMaterial"
            node = self._scene.add_mesh_simple(
                path, vertices, faces, color=rgb(look["color"]), side="double",
                opacity=None if opacity >= 1 else opacity,
                flat_shading=bool(look.get("flatShading", False)),
                material="toon3" if flat else "standard",
                cast_shadow=opacity >= 1 and not flat, receive_shadow=not flat, **at,
            )  # fmt: skip
            self._meshes[path] = look
        self._nodes[path] = node


def wxyz(rotation: Array) -> Array:
    """Unit quaternion (4,) of a rotation matrix (3, 3)."""
    # Of rows one after the other, eigenpy makes a copy that it never frees.
    x, y, z, w = pin.Quaternion(np.asfortranarray(rotation)).coeffs()
    return np.array((w, x, y, z))


def rgb(colour: int) -> tuple[int, int, int]:
    """0xRRGGBB as three numbers."""
    return colour >> 16 & 255, colour >> 8 & 255, colour & 255


def triangles(shape: Geometry) -> tuple[Array, Any]:
    """Vertices (n, 3) and faces (m, 3) of a geometry of three.js."""
    kind = shape["type"]
    if kind == "BufferGeometry":
        data = shape["data"]
        points = data["attributes"]["position"]["array"].reshape(-1, 3)
        return points, data["index"]["array"].reshape(-1, 3)
    if kind == "BoxGeometry":
        size = np.array((shape["width"], shape["height"], shape["depth"]))
        return _box(size)
    turn = np.linspace(0, 2 * np.pi, _AROUND + 1)
    if kind == "SphereGeometry":
        up = np.linspace(0, np.pi, _AROUND // 2 + 1)
        ring = np.sin(up)[:, None]
        points = np.stack(
            (ring * np.cos(turn), ring * np.sin(turn), np.cos(up)[:, None] + 0 * ring * turn),
            axis=-1,
        )
        return _lattice(shape["radius"] * points)
    if kind == "CylinderGeometry":
        # Along y; each rim twice, so that its edge stays sharp.
        half = shape["height"] / 2
        profile = (
            (0.0, half), (shape["radiusTop"], half), (shape["radiusTop"], half),
            (shape["radiusBottom"], -half), (shape["radiusBottom"], -half), (0.0, -half),
        )  # fmt: skip
        rings = [
            np.stack((r * np.sin(turn), np.full_like(turn, y), r * np.cos(turn)), axis=-1)
            for r, y in profile
        ]
        parts = [_lattice(np.array(rings[i : i + 2])) for i in (0, 2, 4)]
        return _joined(parts)
    raise ValueError(f"no triangles are known of a {kind}")


def _box(size: Array) -> tuple[Array, Any]:
    parts = []
    for axis in range(3):
        for side in (-0.5, 0.5):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            corners = np.zeros((2, 2, 3))
            corners[..., axis] = side * size[axis]
            corners[1, :, u], corners[0, :, u] = size[u] / 2, -size[u] / 2
            corners[:, 1, v], corners[:, 0, v] = size[v] / 2, -size[v] / 2
            parts.append(_lattice(corners if side > 0 else corners[::-1]))
    return _joined(parts)


def _joined(parts: list[tuple[Array, Any]]) -> tuple[Array, Any]:
    starts = np.cumsum([0, *(len(points) for points, _ in parts)])
    faces = [part + start for (_, part), start in zip(parts, starts, strict=False)]
    return np.concatenate([points for points, _ in parts]), np.concatenate(faces)


def _lattice(points: Array) -> tuple[Array, Any]:
    m, n, _ = points.shape
    corner = (np.arange(m - 1)[:, None] * n + np.arange(n - 1)).ravel()
    a, b, c, d = corner, corner + 1, corner + n + 1, corner + n
    faces = np.concatenate((np.stack((a, d, c), axis=1), np.stack((a, c, b), axis=1)))
    return points.reshape(-1, 3), faces


def _lines(shape: Geometry, look: Command) -> tuple[Array, Any]:
    """Ends (n, 2, 3) and their colours (n, 2, 3), faded where three.js has them transparent."""
    attributes = shape["data"]["attributes"]
    points = attributes["position"]["array"].reshape(-1, 2, 3)
    if "color" not in attributes:
        return points, np.array(rgb(look["color"]), dtype=np.uint8)
    tint = attributes["color"]["array"].reshape(-1, 2, 4)
    colours = tint[..., 3:] * 255 * tint[..., :3] + (1 - tint[..., 3:]) * _PAPER
    seen = tint[..., 3].max(axis=1) > 0.02
    return points[seen], colours[seen].astype(np.uint8)
