"""A shape of a robot, as three.js draws it."""

from __future__ import annotations

from typing import NamedTuple

import pinocchio as pin

from rrrobot.view.commands import Colour, Geometry


class Visual(NamedTuple):
    """A coloured shape that moves with a joint.

    Attributes:
        name: of its link.
        joint: index of the joint in the robot's Pinocchio model.
        placement: in the joint's frame.
        geometry: three.js geometry.
        colour: red, green, blue and maybe opacity, 0..1.
        reach: distance of its farthest point from the placement's origin [m].
        flat: whether each triangle is shaded by itself, as the edges of a mesh demand.
        shell: whether it is of the URDF's link that draws the shell itself.
    """

    name: str
    joint: int
    placement: pin.SE3
    geometry: Geometry
    colour: Colour
    reach: float
    flat: bool = False
    shell: bool = False
