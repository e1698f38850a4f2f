"""Mimic joints: which coordinates follow which leg, value = ratio * leg + offset.

Pinocchio reduces M, h and the Jacobians to the legs' coordinates by itself, M_legs = S^T M S with
S the matrix of the ratios; it needs each joint after the one that it follows, and one coordinate
of one kind in both, which is arranged here.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from graphlib import CycleError, TopologicalSorter
from typing import NamedTuple
from xml.etree.ElementTree import Element

import pinocchio as pin

from rrrobot.errors import UrdfError
from rrrobot.robot.faults import MOVING
from rrrobot.robot.tree import path_down


class Coupling(NamedTuple):
    """How a mimic joint moves: value = ratio * (coordinate of `leg`) + offset."""

    leg: str
    """the joint that it follows, itself no mimic"""
    ratio: float
    offset: float
    """[rad or m]"""


def couplings(robot: Element, held: Collection[str] = ()) -> dict[str, Coupling]:
    """Every mimic joint of a URDF and what it follows in the end; `held` joints follow nothing.

    A mimic of a joint that moves not, or is not there, is a joint like any other.

    Raises:
        UrdfError: a ratio or an offset of a chain of mimics is not finite.
    """
    joints = {str(j.get("name")): j for j in robot.findall("joint") if j.get("type") in MOVING}
    found: dict[str, Coupling] = {}
    for name in joints:
        here, ratio, offset = name, 1.0, 0.0
        while here not in held and (mimic := joints[here].find("mimic")) is not None:
            if str(mimic.get("joint")) not in joints:
                break
            offset += ratio * float(mimic.get("offset", "0"))
            ratio *= float(mimic.get("multiplier", "1"))
            here = str(mimic.get("joint"))
        if here != name:
            if not (math.isfinite(ratio) and math.isfinite(offset)):
                raise UrdfError(f"joint {name!r} follows {here!r} by a ratio that is not finite.")
            found[name] = Coupling(here, ratio, offset)
    return found


def couple(robot: Element, follow: Mapping[str, Coupling]) -> dict[str, str]:
    """Write couplings as Pinocchio takes them, in place; no other joint is a mimic afterwards.

    Returns:
        new name -> name of the joints that had to be renamed, so that they come in order.

    Raises:
        UrdfError: a joint follows one that hangs on it, or each of two must come first.
    """
    coupled = follow.keys() | {coupling.leg for coupling in follow.values()}
    for joint in robot.findall("joint"):
        name = str(joint.get("name"))
        for mimic in joint.findall("mimic"):
            joint.remove(mimic)
        if name in coupled and joint.get("type") == "continuous":
            # Its coordinate as (cos, sin) cannot be multiplied.
            joint.set("type", "revolute")
            if joint.find("limit") is None:
                limits = {"effort": "0", "velocity": "0", "lower": "0", "upper": "0"}
                joint.append(Element("limit", limits))
        if name in follow:
            leg, ratio, offset = follow[name]
            entries = {"joint": leg, "multiplier": repr(ratio), "offset": repr(offset)}
            joint.append(Element("mimic", entries))
    return _in_order(robot, follow)


def _in_order(robot: Element, follow: Mapping[str, Coupling]) -> dict[str, str]:
    joints = {str(joint.get("name")): joint for joint in robot.findall("joint")}
    before: dict[str, dict[str, set[str]]] = {}
    late = set()
    for name, coupling in follow.items():
        mine, other = (
            [str(j.get("name")) for j in path_down(robot, str(joints[n].find("child").get("link")))]  # type: ignore[union-attr]
            for n in (name, coupling.leg)
        )
        same = next((i for i, (a, b) in enumerate(zip(mine, other, strict=False)) if a != b), None)
        if same is None and len(mine) > len(other):
            continue
        if same is None:
            raise UrdfError(
                f"joint {name!r} mimics {coupling.leg!r}, which hangs on it: let the one that is "
                "farther from the shell follow the other, with 1/multiplier."
            )
        parent = str(joints[mine[same]].find("parent").get("link"))  # type: ignore[union-attr]
        before.setdefault(parent, {}).setdefault(mine[same], set()).add(other[same])
        if other[same] > mine[same]:
            late.add(parent)
    renamed = {}
    for parent in late:
        siblings = sorted(
            n for n, j in joints.items() if j.find(f"parent[@link='{parent}']") is not None
        )
        graph = {n: before[parent].get(n, set()) for n in siblings}
        try:
            order = list(TopologicalSorter(graph).static_order())
        except CycleError:
            raise UrdfError(
                f"mimic joints under link {parent!r} follow each other crosswise: lock one side."
            ) from None
        for i, name in enumerate(order):
            joints[name].set("name", f"{i:04d} {name}")
            renamed[f"{i:04d} {name}"] = name
    back = {name: new for new, name in renamed.items()}
    for joint in joints.values():
        for mimic in joint.findall("mimic"):
            mimic.set("joint", back.get(str(mimic.get("joint")), str(mimic.get("joint"))))
    return renamed


def restore_names(model: pin.Model, renamed: Mapping[str, str]) -> None:
    """Give joints and their frames the URDF's names again."""
    if not renamed:
        return
    for i, name in enumerate(model.names.tolist()):
        model.names[i] = renamed.get(name, name)
    for frame in model.frames:
        frame.name = renamed.get(frame.name, frame.name)
