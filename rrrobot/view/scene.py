"""A robot on its ground, as commands of Meshcat's viewer, which draws with three.js.

A command is a dict of Meshcat's protocol: set_object, set_transform or set_property. Nothing here
needs a server or a browser: `page.py` writes the commands to a file, `viewer.py` sends them.

The tree: /world/robot/<joint> moves with a joint; /world/ground has its x and y in the ground
plane and holds shadows, grid and the contact point's trace; /world/axes are the world's. Meshcat's
camera and the light look at a fixed point, so it is /world that shifts to bring the robot there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.contact.ground import Ground, Plane, ground_basis
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.touching import touch_near
from rrrobot.robot.robot import Robot
from rrrobot.view.commands import (
    FIELD_OF_VIEW,
    WIDTH,
    Command,
    arrows,
    attribute,
    lens,
    material,
    ribbon_mesh,
    set_mesh,
    set_property,
    set_transform,
    sun,
)
from rrrobot.view.player import Figure
from rrrobot.view.shapes import robot_visuals
from rrrobot.view.shells import cap_of, shell_size, shell_visuals
from rrrobot.view.terrain import lay, surface
from rrrobot.view.visual import Visual

_CAMERA_FROM = (-0.48, -0.78, 0.40)  # along the way, to its left, up
_SUN_FROM = (0.35, -0.40, 0.90)  # towards the camera, right, up
_TOP, _BOTTOM = (0.87, 0.91, 0.95), (0.98, 0.985, 0.99)
_GRID = (0.60, 0.65, 0.70)
TRACE_COLOUR = (0.78, 0.03, 0.30)
_AXIS = 1.45  # length of the shell's axes, in shell sizes


class Pose(NamedTuple):
    """Where the robot is.

    Attributes:
        joints: placement of each joint that carries a visual.
        center: of the shell in the world (3,) [m]; of the base, if only a part of it is drawn.
        contact: contact point in the ground plane (2,) [m].
    """

    joints: dict[int, pin.SE3]
    center: Array
    contact: Array


class View(NamedTuple):
    """From where the scene is seen.

    Attributes:
        target: point that the camera looks at (3,) [m].
        camera: its place relative to the target (3,) [m].
        sun: direction towards the light (3,), of any length.
        follow: whether the target is to go with the robot.
        width: of a picture that shows all, in its heights.
    """

    target: Array
    camera: Array
    sun: Array
    follow: bool
    width: float


class Scene:
    """Draws one robot. Send `objects` once and first, then `camera`, `stage`, `place`, `trace`.

    Attributes:
        robot: the robot.
        reach: radius of a ball about the shell's centre that holds the robot's axes, and the
            robot in all poses that `hold` was told of [m].
        spacing: of the grid's lines, as the last `stage` has set it [m].
        detail: of the trace: its points may be this far from each other [m].
        height: of the robot's middle over the ground at rest [m].
        ground: what it stands on.
        normal: of the ground at the origin of its coordinates (3,).
        basis: columns span the plane that touches the ground at the origin, and its normal (3, 3).

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.view.scene import Scene
        >>> scene = Scene(rr.Robot.from_parameters())
        >>> {command["type"] for command in scene.objects()} >= {"set_object", "set_property"}
        True
        >>> scene.spacing
        0.1
    """

    def __init__(self, robot: Robot | Figure, ground: Ground | None = None) -> None:
        self.robot = robot
        self.ground: Ground = Plane() if ground is None else ground
        self._flat = isinstance(self.ground, Plane)
        self._origin = self.ground.point(np.zeros(2))
        self.normal = self.ground.normal(self._origin)
        self.basis = ground_basis(self.normal)
        self.visuals = robot_visuals(robot)
        self.joints = sorted({1, *(visual.joint for visual in self.visuals)})
        self.data = robot.model.createData()
        cap = cap_of(robot, self.visuals)
        self.size = shell_size(robot) if cap is None else cap.reach / _AXIS
        self._middle = robot.shell_placement if cap is None else pin.SE3.Identity()
        self.reach = _AXIS * self.size
        rest = self.rest()
        self.height = float((rest.center - self._origin) @ self.normal)
        self.hold([rest])
        self.detail = 0.02 * self.size
        self.spacing = _round_number(0.8 * self.size)

    def pose(self, configuration: Array) -> Pose:
        """Placements at a configuration (nq,)."""
        pin.forwardKinematics(self.robot.model, self.data, configuration)
        joints = {joint: pin.SE3(self.data.oMi[joint]) for joint in self.joints}
        shell = joints[1] * self.robot.shell_placement
        middle = joints[1].act(self._middle.translation)
        return Pose(joints, middle, self._contact(shell))

    def _contact(self, shell: pin.SE3) -> Array:
        """Coordinates of the contact of a shell at a placement (2,) [m]."""
        if self._flat:
            arm = self.robot.shell.arm(shell.rotation, self.normal)
            return self.ground.coordinates(shell.translation + arm)
        found = touch_near(self.robot.shell, self.ground, shell.rotation, shell.translation)
        return self.ground.coordinates(found.point)

    def rest(self) -> Pose:
        """Upright at the origin, each leg at its zero."""
        q = pin.neutral(self.robot.model)
        place, normal = self.robot.shell_placement, self.normal
        flat = isinstance(self.robot.shell, FlatBelly)
        arm = np.zeros(3) if flat else self.robot.shell.arm(place.rotation, normal)
        q[:3] = self._origin - place.translation - arm
        return self.pose(q)

    def hold(self, poses: Sequence[Pose]) -> None:
        """Widen `reach` to hold the robot in these poses."""
        for pose in poses[:: 1 + len(poses) // 50]:
            self.reach = max(self.reach, *(_reach(visual, pose) for visual in self.visuals))

    def objects(self, *, axes: bool = True) -> list[Command]:
        """Robot, axes, background and the camera's lens; for a page that has none of them yet."""
        commands = [
            set_property("/Background", "top_color", _TOP),
            set_property("/Background", "bottom_color", _BOTTOM),
            set_property("/Lights/AmbientLight/<object>", "intensity", 0.54),
            set_property("/Lights/FillLight/<object>", "intensity", 0.16),
            *(set_property(path, "visible", False) for path in _MESHCAT_OWN),
            set_transform(
                "/world/ground", pin.SE3(self.basis if self._flat else np.eye(3), np.zeros(3))
            ),
            lens(self.size),
        ]
        for path, visual in self._visual_paths():
            commands += _drawn(path, visual)
        return commands + self.axes(axes)

    def _visual_paths(self) -> Iterator[tuple[str, Visual]]:
        for i, visual in enumerate(self.visuals):
            yield f"{self.path(visual.joint)}/{i} {visual.name.replace('/', '_')}", visual

    @property
    def shell_paths(self) -> list[str]:
        """Nodes that draw the shell as the URDF has it, if it has."""
        return [path for path, visual in self._visual_paths() if visual.shell]

    @property
    def glass_path(self) -> str:
        """Node of the shell that `glass` draws."""
        return f"{self.path(1)}/glass"

    def glass(self) -> list[Command]:
        """The shell as one that lets light through, to be shown in place of the URDF's."""
        visuals = enumerate(shell_visuals(self.robot))
        return [c for i, visual in visuals for c in _drawn(f"{self.glass_path}/{i}", visual)]

    @property
    def axes_paths(self) -> list[str]:
        """Nodes of the axes of the world and of the shell."""
        return ["/world/axes", f"{self.path(1)}/axes"]

    def axes(self, visible: bool) -> list[Command]:
        """Arrows along the world's axes and the shell's."""
        length = _AXIS * self.size
        world, body = self.axes_paths
        commands = arrows(world, 0.8 * length, pin.SE3.Identity())
        commands += arrows(body, length, self._middle)
        return commands + [set_property(path, "visible", visible) for path in (world, body)]

    def path(self, joint: int) -> str:
        """Node of the tree that moves with a joint."""
        # Meshcat keeps nodes as properties of an object, which has some, such as "constructor".
        return f"/world/robot/{joint} {self.robot.model.names[joint].replace('/', '_')}"

    def place(self, pose: Pose) -> list[Command]:
        """Move the robot."""
        return [set_transform(self.path(joint), at) for joint, at in pose.joints.items()]

    def view(self, centers: Array, *, follow: bool = False) -> View:
        """Where the camera sees the robot at all these places of its shell (n, 3) [m].

        It stands behind and to the right of the way from the first place to the last, so that
        the robot goes to the right and away, and does not hide its trace.
        """
        seen = centers[:1] if follow else centers
        middle, _ = self._ball(seen)
        up = self.normal
        way = seen[-1] - seen[0]
        way = way - (way @ up) * up
        distance = float(np.linalg.norm(way))
        ahead = way / distance if distance > 0.2 * self.size else self.basis[:, 0]
        x, y, z = _CAMERA_FROM
        toward = x * ahead + y * np.cross(up, ahead) + z * up
        toward /= np.linalg.norm(toward)
        right = np.cross(up, toward)
        right /= np.linalg.norm(right)
        away, tall = 0.0, math.tan(math.radians(FIELD_OF_VIEW / 2))
        near = (seen - middle) @ toward
        for side, wide in ((right, WIDTH), (np.cross(toward, right), 1.0)):
            half = math.atan(wide * tall)
            aside = np.abs((seen - middle) @ side) * math.cos(half) + self.reach
            away = max(away, float(np.max(aside / math.sin(half) + near)))
        # From there, how wide the picture has to be.
        aside, ahead = np.abs((seen - middle) @ right), away - near
        half = float(
            np.max(np.arctan2(aside, ahead) + np.arcsin(self.reach / np.hypot(aside, ahead)))
        )
        x, y, z = _SUN_FROM
        sun = x * toward + y * right + z * up
        return View(middle, away * toward, sun, follow, min(WIDTH, math.tan(half) / tall))

    def camera(self, view: View) -> list[Command]:
        """Put the camera there; the mouse moves it from then on."""
        x, y, z = view.camera
        # This node has y up.
        place = set_property("/Cameras/default/rotated/<object>", "position", [x, z, -y])
        return [place, self.look_at(view.target)]

    def stage(self, centers: Array, view: View) -> list[Command]:
        """Ground, and light with shadows, for a shell that goes through centres (n, 3) [m]."""
        middle, radius = self._ball(centers)
        self.spacing = _round_number(max(0.8 * self.size, 0.15 * radius))
        away = 0.0 if view.follow else np.linalg.norm(centers - view.target, axis=1).max()
        light = sun(view.sun, 1.5 * self.reach + float(away))
        # Meshcat can replace a light only by taking it away first.
        dark: Command = {"type": "delete", "path": "/Lights/Sun"}
        if self._flat:
            floor = self._ground(self.basis[:, :2].T @ middle, radius)
        else:
            at = self.ground.coordinates(middle)
            floor = surface(self.ground, at, 3.0 * radius, self.spacing, 0.1 * self.detail)
        return [*floor, dark, light]

    def look_at(self, target: Array) -> Command:
        """Bring a point (3,) [m] to where the camera looks."""
        return set_transform("/world", pin.SE3(np.eye(3), -target))

    def _ball(self, centers: Array) -> tuple[Array, float]:
        """Centre and radius of a ball that holds the robot at all these places."""
        middle = (centers.min(axis=0) + centers.max(axis=0)) / 2
        return middle, self.reach + float(np.linalg.norm(centers - middle, axis=1).max())

    def _ground(self, middle: Array, radius: float) -> list[Command]:
        """Shadows and a grid of lines through the origin, about a point of the plane (2,)."""
        span, step = 4.0 * radius, self.spacing
        count = math.ceil(span / step)
        line, at = np.meshgrid(*2 * [np.arange(-count, count + 1.0)], indexing="ij")
        points = step * np.stack((line, at, np.zeros_like(at)), axis=-1)
        pairs = np.stack((points[:, :-1], points[:, 1:]), axis=2).reshape(-1, 3)
        lines = np.concatenate((pairs, pairs[:, [1, 0, 2]]))
        fade = np.clip(1 - np.linalg.norm(lines, axis=1) / (step * count), 0, 1)
        tint = np.column_stack((np.tile(_GRID, (len(lines), 1)), fade))
        attributes = {"position": attribute(lines), "color": attribute(tint)}
        grid = {"type": "BufferGeometry", "data": {"attributes": attributes}}
        pen = material((1, 1, 1), "LineBasicMaterial", vertexColors=True, transparent=True)
        plane = {"type": "PlaneGeometry", "width": 2 * span, "height": 2 * span}
        # Floor and shadows yield to what lies in the plane with them: grid and trace. The floor
        # has no colour and hides what is below it; from below, both are not there.
        under = {"polygonOffset": True, "polygonOffsetFactor": 1, "polygonOffsetUnits": 1}
        hide = material((0, 0, 0), "MeshBasicMaterial", colorWrite=False, **under, side=0)
        dark = material((0, 0, 0, 0.3), "ShadowMaterial", **under, side=0)
        place = pin.SE3(np.eye(3), np.array((*(step * np.round(middle / step)), 0.0)))
        return [
            set_mesh("/world/ground/floor", plane, hide, place, renderOrder=-1),
            set_mesh("/world/ground/shadows", plane, dark, place),
            set_mesh("/world/ground/grid", grid, pen, place, kind="LineSegments"),
        ]

    def trace(self, contacts: Array, view: View, path: str = "/world/ground/trace") -> Command:
        """A line along contact points in the ground plane (n, 2), no two the same [m]."""
        width = max(self.detail, 0.003 * float(np.linalg.norm(view.camera)))
        bend = None if self._flat else partial(lay, self.ground)
        ribbon = ribbon_mesh(contacts, width, lift=0.2 * self.detail, bend=bend)
        return set_mesh(path, ribbon, material(TRACE_COLOUR, "MeshBasicMaterial"))


_MESHCAT_OWN = ("/Grid", "/Axes", "/Lights/PointLightNegativeX", "/Lights/PointLightPositiveX")


def _drawn(path: str, visual: Visual) -> list[Command]:
    look = material(visual.colour, flatShading=visual.flat)
    commands = [set_mesh(path, visual.geometry, look, visual.placement)]
    if look["opacity"] < 1:  # lets the light in
        commands.append(set_property(f"{path}/<object>", "castShadow", False))
    return commands


def _reach(visual: Visual, pose: Pose) -> float:
    at = pose.joints[visual.joint].act(visual.placement.translation)
    return float(np.linalg.norm(at - pose.center)) + visual.reach


def _round_number(value: float) -> float:
    """The nearest of 1, 2 and 5 times a power of ten."""
    base = 10.0 ** math.floor(math.log10(value))
    return float(f"{base * min((1, 2, 5, 10), key=lambda m: abs(math.log(m * base / value))):g}")
