"""A machine's history as the viewer takes it: a body on a free flyer, with looks, over a ground."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.contact.discs import Torus
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.surfaces import Sphere, Surface
from rrrobot.machines.history import History
from rrrobot.machines.tree import ROOT, Tree

_AFLOAT = 1.3
"""How high over the ground what floats is drawn, in its sizes."""


class Figure(NamedTuple):
    """What a scene asks of a robot."""

    name: str
    model: pin.Model
    urdf: str
    package_dirs: tuple[str, ...]
    shell: Surface
    shell_placement: pin.SE3
    shows_shell: bool
    """whether the shell is drawn, and not only gives the size and the contact"""


class Play(NamedTuple):
    """What a film asks of a trajectory."""

    robot: Figure
    ground: Ground
    time: Array
    configuration: Array
    position: Array
    model_name: str


def play_of(history: History) -> Play:
    """A history as a film's trajectory: planar machines at their height, floating ones aloft."""
    tree, model = history.tree, history.model
    contact = model.rolling
    bare = Tree(tree.base, tree.joints)
    skin = tree.skin if contact is None else contact.surface
    shell = Sphere(_size(tree)) if skin is None else skin
    place = pin.SE3.Identity()
    if contact is not None:
        place = model.model.frames[contact.frame_id].placement
    drawn = skin is not None and not isinstance(skin, Torus)
    urdf = bare.urdf(history.name, balls="floating")
    figure = Figure(history.name, bare.model(), urdf, (), shell, place, drawn)
    ground = Plane() if contact is None else contact.ground
    q = _configurations(history)
    if model.planar:
        q[:, 2] = tree.height
    elif contact is None:
        size = max(_size(tree), max(shell.support(u) for u in np.eye(3)))
        q[:, 2] += _AFLOAT * size - min(0.0, float(q[:, 2].min()))
    return Play(figure, ground, history.time, q, _path(history, ground), "whole")


def _configurations(history: History) -> Array:
    """q (n, nq) of the tree on a free flyer."""
    model = history.model
    cut = history.states[:, : model.coordinates.size]
    if not model.planar:
        return np.array([model.coordinates.to_q(z) for z in cut])
    root = model.coordinates.joint[ROOT]
    rest = np.array([model.coordinates.to_q(z)[4:] for z in cut])
    pose = cut[:, root]
    zero = np.zeros((len(pose), 1))
    return np.hstack((pose[:, :2], zero, history.quaternion, rest))


def _path(history: History, ground: Ground) -> Array:
    contact = history.model.rolling
    if contact is None:
        return history.pose[:, :2]
    frame = history.model.model.frames[contact.frame_id].placement.translation
    found = []
    for q, x in zip(history.quaternion, history.pose[:, :3], strict=True):
        R = pin.Quaternion(q).toRotationMatrix()
        centre = x + R @ frame
        normal = ground.normal(centre)
        found.append(ground.coordinates(centre + contact.surface.arm(R, normal)))
    return np.array(found)


def _size(tree: Tree) -> float:
    """How far the tree's parts are from its base's origin, stretched out [m]."""
    far = {tree.base.name: 0.0}
    for joint in tree.joints:
        far[joint.child.name] = far[joint.parent] + float(np.linalg.norm(joint.at))
    links = (tree.base, *(joint.child for joint in tree.joints))
    return max(
        (
            far[link.name] + float(np.linalg.norm(look.at)) + max(look.size) / 2
            for link in links
            for look in link.looks
        ),
        default=0.1,
    )
