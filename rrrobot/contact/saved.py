"""The way back from `to_dict` for shells and grounds; all of the room are registered here."""

from __future__ import annotations

from typing import Any

from rrrobot import serial
from rrrobot.contact.boulder import Boulder
from rrrobot.contact.discs import Torus
from rrrobot.contact.graph import Graph
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.shells import EllipsoidSum, FlatBelly
from rrrobot.contact.surfaces import Ellipsoid, Sphere, Surface

REGISTERED = (Sphere, Ellipsoid, EllipsoidSum, FlatBelly, Torus, Plane, Boulder, Graph)
"""What loads with this module."""


def surface_from_dict(data: dict[str, Any]) -> Surface:
    """The shell that `to_dict` wrote.

    Raises:
        ParameterError: no such type is registered.
    """
    return serial.from_dict(data, Surface, "shell")  # type: ignore[type-abstract]


def ground_from_dict(data: dict[str, Any]) -> Ground:
    """The ground that `to_dict` wrote.

    Raises:
        ParameterError: no such type is registered, or a graph by formula.
    """
    return serial.from_dict(data, Ground, "ground")  # type: ignore[type-abstract]
