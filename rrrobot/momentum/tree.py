"""A robot's joints and bodies as plain arrays, for compiled code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.robot.mimics import Coupling
from rrrobot.robot.robot import Robot


class Tree(NamedTuple):
    """A robot's joints and bodies as plain arrays; row 0 is the base."""

    parent: NDArray[np.int64]
    """row of the parent body (n,)"""
    rotation: Array
    """of the joint's frame in its parent's (n, 3, 3)"""
    translation: Array
    """(n, 3) [m]"""
    axis: Array
    """unit axis in the joint's frame (n, 3)"""
    prismatic: NDArray[np.bool_]
    """(n,)"""
    leg: NDArray[np.int64]
    """which leg coordinate moves the joint (n,); -1 for the base"""
    ratio: Array
    """of the joint's coordinate to the leg's (n,); 1 unless it mimics a leg"""
    shift: Array
    """of the joint's coordinate where the leg's is zero (n,) [rad or m]"""
    mass: Array
    """(n,) [kg]"""
    lever: Array
    """centre of mass in the body's frame (n, 3) [m]"""
    inertia: Array
    """about the centre of mass (n, 3, 3) [kg m^2]"""
    point: NDArray[np.bool_]
    """whether that is zero (n,)"""


def tree_of(robot: Robot, origin: Array | None = None) -> Tree:
    """Arrays of a robot's Pinocchio model.

    Args:
        robot: any robot.
        origin: of the base's positions, in the base's frame (3,) [m]; the shell's centre if None.
    """
    about = robot.shell_placement.translation if origin is None else origin
    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model), np.zeros(model.nv))
    n = model.njoints - 1
    tree = Tree(
        np.zeros(n, dtype=np.int64),
        np.tile(np.eye(3), (n, 1, 1)),
        np.zeros((n, 3)),
        np.zeros((n, 3)),
        np.zeros(n, dtype=np.bool_),
        np.full(n, -1, dtype=np.int64),
        np.ones(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros((n, 3)),
        np.zeros((n, 3, 3)),
        np.zeros(n, dtype=np.bool_),
    )
    for i in range(n):
        joint = i + 1
        body = model.inertias[joint]
        tree.mass[i], tree.lever[i], tree.inertia[i] = body.mass, body.lever, body.inertia
        tree.point[i] = not np.any(tree.inertia[i])
        if i == 0:
            tree.translation[0] = -about
            continue
        placement = model.jointPlacements[joint]
        tree.parent[i] = model.parents[joint] - 1
        tree.rotation[i], tree.translation[i] = placement.rotation, placement.translation
        subspace = np.asarray(data.joints[joint].S).reshape(6)
        tree.prismatic[i] = np.any(subspace[:3] != 0)
        tree.axis[i] = subspace[:3] if tree.prismatic[i] else subspace[3:]
        leg, tree.ratio[i], tree.shift[i] = robot.couplings.get(
            model.names[joint], Coupling(model.names[joint], 1.0, 0.0)
        )
        # Pinocchio's axis of a mimic joint is per unit of the leg's coordinate.
        tree.axis[i] /= tree.ratio[i]
        tree.leg[i] = robot.legs.index(leg)
    return tree
