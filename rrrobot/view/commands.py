"""Commands of Meshcat's browser viewer, as dicts in its protocol.

Objects, geometries and materials are in the JSON format of three.js, version 4; arrays are
NumPy's and become typed arrays of JavaScript when they are packed. Nothing here needs Meshcat.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array

Colour = tuple[float, ...]
"""Red, green, blue and maybe opacity, 0..1."""

Geometry = dict[str, Any]
"""A geometry of three.js, without its uuid."""

Command = dict[str, Any]

FIELD_OF_VIEW = 35.0
"""Of the camera, from the bottom to the top of the picture [deg]."""

WIDTH = 1.5
"""Of the picture, in heights, that is sure to be seen."""

AXIS_COLOURS: tuple[Colour, ...] = ((0.85, 0.15, 0.15), (0.15, 0.60, 0.20), (0.15, 0.35, 0.85))


def set_mesh(
    path: str,
    geometry: Geometry,
    look: Command,
    at: pin.SE3 | None = None,
    kind: str = "Mesh",
    **options: Any,
) -> Command:
    """Put an object at a path of the tree, in place of any that was there."""
    matrix = np.eye(4) if at is None else at.homogeneous
    body = {"type": kind, "uuid": path, "geometry": f"{path} shape", "material": f"{path} look"}
    body |= options
    return set_object(
        path,
        {**body, "matrix": matrix.T.ravel().tolist()},
        geometries=[{**geometry, "uuid": body["geometry"]}],
        materials=[{**look, "uuid": body["material"]}],
    )


def material(colour: Colour, kind: str = "MeshPhongMaterial", **options: Any) -> Command:
    """A three.js material of a colour (red, green, blue[, opacity]), drawn from both sides."""
    red, green, blue = (round(255 * part) for part in colour[:3])
    opacity = colour[3] if len(colour) > 3 else 1.0
    look = {"type": kind, "color": red << 16 | green << 8 | blue, "side": 2, "opacity": opacity}
    if opacity < 1:
        look |= {"transparent": True, "depthWrite": False}
    if kind == "MeshPhongMaterial":
        look |= {"specular": 0x0C0C0C, "shininess": 25}
    return look | options


def css(colour: Colour) -> str:
    """A colour as HTML writes it.

    Example:
        >>> css((1.0, 0.5, 0.0))
        '#ff8000'
    """
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour[:3])


def set_transform(path: str, at: pin.SE3) -> Command:
    """Move a node of the tree."""
    return {"type": "set_transform", "path": path, "matrix": at.homogeneous.T.ravel().tolist()}


def set_property(path: str, name: str, value: Any) -> Command:
    """Set a property of a node."""
    return {"type": "set_property", "path": path, "property": name, "value": value}


def set_object(path: str, body: Command, **parts: Any) -> Command:
    """Put a three.js object, with the geometries and materials that it names, at a path."""
    data = {"metadata": {"version": 4.5, "type": "Object"}, **parts, "object": body}
    return {"type": "set_object", "path": path, "object": data}


def mesh(vertices: Array, faces: Array) -> Geometry:
    """Triangles: vertices (n, 3) [m], faces (m, 3) of vertex numbers."""
    return {
        "type": "BufferGeometry",
        "data": {
            "attributes": {"position": attribute(vertices)},
            "index": {"type": "Uint32Array", "array": faces.astype(np.uint32).ravel()},
        },
    }


def attribute(values: Array) -> dict[str, Any]:
    """A three.js vertex attribute of values (n, 3)."""
    array = np.asarray(values, dtype=np.float32)
    return {
        "itemSize": array.shape[1],
        "type": "Float32Array",
        "array": array.ravel(),
        "normalized": False,
    }


def ribbon_mesh(
    points: Array, width: float, lift: float, bend: Callable[[Array], Array] | None = None
) -> Geometry:
    """A ribbon along points of the plane (n, 2) [m], six indices a step.

    Each step is a rectangle by itself, longer than the step by the ribbon's width, so that sharp
    turns leave neither gaps nor twists. `bend` lays its corners (n, 3) on a curved ground.
    """
    a, b = points[:-1], points[1:]
    along = (b - a) * width / 2 / np.linalg.norm(b - a, axis=1, keepdims=True)
    across = np.column_stack((-along[:, 1], along[:, 0]))
    corners = (a - along - across, b + along - across, b + along + across, a - along + across)
    flat = np.stack(corners, axis=1).reshape(-1, 2)
    faces = 4 * np.arange(len(a))[:, None] + np.array((0, 1, 2, 0, 2, 3))
    corners_ = np.column_stack((flat, np.full(len(flat), lift)))
    return mesh(corners_ if bend is None else bend(corners_), faces)


def lens(size: float) -> Command:
    """The camera, for objects of the given size [m]. Meshcat can replace it only once."""
    body = {"type": "PerspectiveCamera", "uuid": "camera", "fov": FIELD_OF_VIEW, "aspect": WIDTH}
    return set_object("/Cameras/default/rotated", {**body, "near": size / 10, "far": size * 5000})


def sun(toward: Array, radius: float) -> Command:
    """A light whose shadows cover a ball of the given radius [m] about the camera's target."""
    place = np.eye(4)
    place[3, :3] = 3 * radius * toward / np.linalg.norm(toward)
    r = 1.1 * radius
    box = {"left": -r, "right": r, "top": r, "bottom": -r, "near": radius, "far": 5 * radius}
    shadow = {
        "mapSize": [1024, 1024],
        "bias": -0.0005,
        "normalBias": radius / 300,
        "camera": {"type": "OrthographicCamera", "uuid": "shadow", "zoom": 1, **box},
    }
    body = {"type": "DirectionalLight", "uuid": "sun", "color": 0xFFFFFF, "intensity": 0.44}
    return set_object(
        "/Lights/Sun",
        {**body, "castShadow": True, "shadow": shadow, "matrix": place.ravel().tolist()},
    )


def arrow(
    path: str,
    direction: Array,
    length: float,
    look: Command,
    at: pin.SE3 | None = None,
    width: float = 0.012,
    **options: Any,
) -> list[Command]:
    """An arrow of a length [m] along a direction (3,) of a frame, its shaft and its tip.

    Args:
        path: of the shaft; the tip's is the same with " tip".
        direction: of unit length.
        length: from the frame's origin to the tip [m].
        look: a material.
        at: the frame.
        width: half of the shaft's, in lengths.
        **options: of both objects.
    """
    frame = pin.SE3.Identity() if at is None else at
    # three.js has a cylinder's axis along y.
    turn = pin.Quaternion.FromTwoVectors(np.array((0.0, 1.0, 0.0)), direction).matrix()
    commands = []
    for name, top, bottom, start, end in (
        ("", width, width, 0.0, 0.9),
        (" tip", 0, 2.9 * width, 0.9, 1),
    ):
        tall, middle = (end - start) * length, (start + end) / 2 * length
        shape = {"type": "CylinderGeometry", "radialSegments": 16, "height": tall}
        shape |= {"radiusTop": top * length, "radiusBottom": bottom * length}
        place = frame * pin.SE3(turn, middle * direction)
        commands.append(set_mesh(f"{path}{name}", shape, look, place, **options))
    return commands


def arrows(path: str, length: float, at: pin.SE3) -> list[Command]:
    """Arrows of a length [m] along the axes of a frame: x red, y green, z blue."""
    return [
        command
        for name, to, colour in zip("xyz", np.eye(3), AXIS_COLOURS, strict=True)
        for command in arrow(f"{path}/{name}", to, length, material(colour), at)
    ]


def track(name: str, kind: str, times: ArrayLike, values: ArrayLike) -> Command:
    """Key frames of a property: times (k,) in frames, values (k,) or (k, m)."""
    return {
        "name": name,
        "type": kind,
        "times": np.asarray(times, dtype=np.float32),
        "values": np.asarray(values, dtype=np.float32).ravel(),
    }


def clip(path: str, fps: float, *tracks: Command) -> Command:
    """The motion of one node in an animation."""
    return {"path": path, "clip": {"fps": fps, "name": path, "tracks": list(tracks)}}
