"""RRRobot as a machine: on the ground, and afloat as a satellite with two legs."""

from __future__ import annotations

from math import pi

import numpy as np

from rrrobot.constraints import RollingContact
from rrrobot.contact.surfaces import Sphere
from rrrobot.drive.damping import EulerRateDamping
from rrrobot.drive.gaits import gait
from rrrobot.machines.looks import BLUE, DARK, ORANGE, Look, ball, box, rod
from rrrobot.machines.machine import Machine
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.tree import Joint, Link, Tree
from rrrobot.robot.parameters import RRRobotParameters

_LEGS = ("leg_1", "leg_2")


def rrrobot(parameters: RRRobotParameters | None = None, *, damping: float = 0.0) -> Machine:
    """RRRobot, by the machines' equations: a second formulation of `FullModel`.

    Args:
        parameters: Table 2 unless given.
        damping: of each Euler rate [N m s/rad].

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.machines.rrrobot()
        >>> robot.simulate(robot.gaits["lateral"], 1.0).multipliers["contact"].shape
        (101, 3)
    """
    p = parameters or RRRobotParameters()
    tree = _tree(p)
    model = tree.model(p.gravity)
    contact = RollingContact(model, model.getFrameId("shell"), Sphere(p.shell_radius))
    loss = EulerRateDamping(damping, damping, damping) if damping else None
    return Machine(
        name="rrrobot",
        title="RRRobot: a ball that its two legs roll",
        tree=tree,
        model=Mechanism(model, (contact,), motors=_LEGS, damping=loss),
        gaits={name: gait(name) for name in ("circular", "lateral")},
        shape=(pi / 4, pi / 4),
    )


def legged_satellite(parameters: RRRobotParameters | None = None) -> Machine:
    """RRRobot afloat: a shell whose two legs turn it, momentum zero; the paper's gaits.

    Args:
        parameters: Table 2 unless given.

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.legged_satellite().model.motors
        ('leg_1', 'leg_2')
    """
    tree = _tree(parameters or RRRobotParameters())
    return Machine(
        name="legged_satellite",
        title="satellite with two legs: RRRobot afloat",
        tree=tree,
        model=Mechanism(tree.model(0.0), motors=_LEGS),
        gaits={name: gait(name) for name in ("circular", "lateral")},
        shape=(pi / 4, pi / 4),
    )


def _tree(p: RRRobotParameters) -> Tree:
    parts = [(p.battery_mass, (0.0, 0.0, -p.shell_radius))]
    hips = (-p.hip_offset, p.hip_offset)
    parts += [(m, (0.0, y, 0.0)) for m, y in zip(p.servo_masses, hips, strict=True)]
    looks = [
        (rod("x", 0.008, length, (length / 2, 0, 0), c), ball(0.018, (length, 0, 0), c))
        for length, c in zip(p.leg_lengths, (ORANGE, BLUE), strict=True)
    ]
    legs = [
        Joint(
            f"leg_{i + 1}",
            "shell",
            Link(f"tip_{i + 1}", m, 0.0, (length, 0, 0), looks[i]),
            (0, y, 0),
            "-y",
        )
        for i, (m, length, y) in enumerate(zip(p.leg_masses, p.leg_lengths, hips, strict=True))
    ]
    battery = box((0.08, 0.05, 0.03), (0, 0, -0.85 * p.shell_radius), DARK)
    return Tree(_of_points("shell", parts, battery), legs, skin=Sphere(p.shell_radius))


def _of_points(
    name: str, parts: list[tuple[float, tuple[float, float, float]]], look: Look
) -> Link:
    """A link of point masses."""
    masses = np.array([m for m, _ in parts])
    places = np.array([x for _, x in parts])
    centre = masses @ places / masses.sum()
    apart = places - centre
    inertia = sum(
        m * (x @ x * np.eye(3) - np.outer(x, x)) for m, x in zip(masses, apart, strict=True)
    )
    return Link(name, float(masses.sum()), inertia, centre, (look,))
