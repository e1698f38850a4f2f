"""How links look: boxes, rods, balls and axles, as a URDF's visuals. They weigh nothing."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from math import pi
from typing import Literal

Triple = tuple[float, float, float]

STEEL: Triple = (0.45, 0.48, 0.52)
BLUE: Triple = (0.0, 0.45, 0.7)
ORANGE: Triple = (0.84, 0.37, 0.0)
DARK: Triple = (0.2, 0.2, 0.22)
SAND: Triple = (0.83, 0.76, 0.62)
_TURNS: dict[str, Triple] = {"x": (0, pi / 2, 0), "y": (-pi / 2, 0, 0), "z": (0, 0, 0)}


@dataclass(frozen=True)
class Look:
    """A shape in its link's frame.

    Attributes:
        kind: "box" of sides (x, y, z), "cylinder" of (radius, length) along its own z, or "sphere"
            of (radius,) [m].
        size: as the kind has it [m].
        at, rpy: place [m], and roll, pitch, yaw [rad].
        colour: red, green, blue, 0..1.
    """

    kind: Literal["box", "cylinder", "sphere"]
    size: tuple[float, ...]
    at: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)
    colour: Triple = STEEL

    def write(self, link: ET.Element) -> None:
        """Add the `<visual>` to a URDF's link."""
        visual = ET.SubElement(link, "visual")
        ET.SubElement(visual, "origin", xyz=_words(self.at), rpy=_words(self.rpy))
        geometry = ET.SubElement(visual, "geometry")
        if self.kind == "box":
            ET.SubElement(geometry, "box", size=_words(self.size))
        elif self.kind == "cylinder":
            radius, length = map(repr, map(float, self.size))
            ET.SubElement(geometry, "cylinder", radius=radius, length=length)
        else:
            ET.SubElement(geometry, "sphere", radius=_words(self.size))
        name = "_".join(f"{round(255 * part):02x}" for part in self.colour)
        material = ET.SubElement(visual, "material", name=name)
        ET.SubElement(material, "color", rgba=_words((*self.colour, 1.0)))


def box(size: Triple, at: Triple = (0.0, 0.0, 0.0), colour: Triple = SAND) -> Look:
    """A box of sides (x, y, z) about a point."""
    return Look("box", size, at, colour=colour)


def rod(
    axis: str, radius: float, length: float, at: Triple = (0.0, 0.0, 0.0), colour: Triple = STEEL
) -> Look:
    """A cylinder along x, y or z about a point: a rod, a wheel, a rotor."""
    return Look("cylinder", (radius, length), at, _TURNS[axis], colour)


def ball(radius: float, at: Triple = (0.0, 0.0, 0.0), colour: Triple = ORANGE) -> Look:
    """A ball about a point."""
    return Look("sphere", (radius,), at, colour=colour)


def axle(x: float, track: float, radius: float) -> tuple[Look, ...]:
    """An axle along y at (x, 0, 0), and a wheel at each end."""
    wheels = (rod("y", radius, 0.4 * radius, (x, y, 0.0), DARK) for y in (-track, track))
    return (rod("y", 0.15 * radius, 2 * track, (x, 0.0, 0.0)), *wheels)


def rotor(axis: str, radius: float, at: Triple = (0.0, 0.0, 0.0)) -> tuple[Look, ...]:
    """A flywheel about an axis through a point, with a stripe that shows its turning."""
    i = "xyz".index(axis)
    sides = [1.9 * radius, 0.3 * radius, 0.3 * radius]
    sides[i], sides[(i + 1) % 3], sides[(i + 2) % 3] = 0.3 * radius, 1.9 * radius, 0.3 * radius
    stripe = box((sides[0], sides[1], sides[2]), at, ORANGE)
    return (rod(axis, radius, 0.2 * radius, at, BLUE), stripe)


def _words(values: tuple[float, ...]) -> str:
    return " ".join(repr(float(v)) for v in values)
