"""A run held against every limit: forces, joints, tilt, and distances of the links by Coal."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.belly.distances import coal_shape, geometry_model
from rrrobot.belly.found import Belly
from rrrobot.checks import Array
from rrrobot.contact.boulder import Boulder
from rrrobot.contact.ground import Plane
from rrrobot.errors import ModelError
from rrrobot.escape.bodies import placed_on
from rrrobot.escape.limits import Rules
from rrrobot.robot.limits import beyond
from rrrobot.simulation.trajectory import Trajectory

_TOUCH = 1e-4
"""Depth up to which neighbours that rest against each other count as apart [m]."""


class Held(NamedTuple):
    """How near a run comes to its limits, and what it breaks."""

    normal_force: float
    """least, over the weight"""
    friction: float
    """coefficient needed"""
    tilt: float
    """largest [rad]"""
    clearance: float
    """least distance of a limb from the ground [m]; infinite without limbs"""
    separation: float
    """least distance of two links that count [m]; infinite without pairs"""
    broken: tuple[str, ...]
    """each limit that is broken: what, by how much, when"""


def held(run: Trajectory, rules: Rules, belly: Belly) -> Held:
    """Hold a run against the limits of its rules.

    Raises:
        ModelError: a ground to which Coal has no distances: it is a plane or a boulder.
    """
    limits, time = rules.limits, run.time
    weight = run.robot.mass * run.gravity
    normal, friction = run.normal_force / weight, run.required_friction
    up = np.cos(run.euler[:, 0]) * np.cos(run.euler[:, 1])
    tilt = np.arccos(np.clip(up, -1.0, 1.0))
    clear, apart, who, pair = distances(run, belly)
    told = []
    cases = (
        ("normal force", -normal, -limits.normal_force, "of the weight", "", -1.0),
        ("friction needed", friction, limits.friction, "", "", 1.0),
        ("tilt", np.rad2deg(tilt), np.rad2deg(rules.tilt), "deg", "", 1.0),
        ("clearance", -1000 * clear, 0.0, "mm", who, -1.0),
        ("separation", -1000 * apart, 1000 * _TOUCH, "mm", pair, -1.0),
    )
    for what, values, most, unit, names, sign in cases:
        worst = int(np.argmax(values))
        if values[worst] > most:
            whose = f" of {names[worst]}" if names else ""
            first = time[np.flatnonzero(values > most)[0]]
            told.append(
                f"{what}{whose} {sign * values[worst]:.3g} {unit}".rstrip()
                + f" at t = {time[worst]:.3f} s (limit {sign * most + 0.0:.3g}, first at "
                f"{first:.3f} s)"
            )
    joints = run.robot.joints._replace(effort=rules.ends.effort)
    told += beyond(joints, run.robot.legs, time, run.leg_angle, run.leg_rate, run.leg_torque)
    return Held(
        float(normal.min()), float(friction.max()), float(tilt.max()), float(clear.min()),
        float(apart.min()), tuple(told),
    )  # fmt: skip


def distances(run: Trajectory, belly: Belly) -> tuple[Array, Array, list[str], list[str]]:
    """Least distance from the ground and of links (n,) [m] through a run; which link, which pair.

    The belly itself, the base and the links that the shell holds have none from the ground.
    """
    robot, ground = run.robot, run.ground
    pieces = placed_on(robot, belly.shapes)
    free = [
        i for i, piece in enumerate(pieces) if piece.joint > 1 and piece.link not in belly.covered
    ]
    geometry = geometry_model(pieces, belly.shapes.pairs)
    model = robot.model
    rock, fixed = None, ground.fixed_normal
    ground_normal = np.zeros(3) if fixed is None else fixed
    if isinstance(ground, Boulder) and ground.radius > 0:
        rock = _Rock(ground, [coal_shape(pieces[i]) for i in free])
    elif not isinstance(ground, Plane):
        raise ModelError(
            f"distances from {ground!r} are not known: gaits are confirmed on planes and boulders."
        )
    data, apart = model.createData(), geometry.createData()
    n = len(run.time)
    clear, near = np.full(n, np.inf), np.full(n, np.inf)
    who, pair = [""] * n, [""] * n
    for k, q in enumerate(run.configuration):
        pin.forwardKinematics(model, data, q)
        places = [data.oMi[pieces[i].joint] for i in free]
        if rock is not None:
            gaps = rock.gaps(places)
        else:
            gaps = [
                float((pieces[i].points @ at.rotation.T + at.translation).dot(
                    ground_normal).min()) - pieces[i].radius
                for i, at in zip(free, places, strict=True)
            ]  # fmt: skip
        if gaps:
            least = int(np.argmin(gaps))
            clear[k], who[k] = gaps[least], pieces[free[least]].link
        if belly.shapes.pairs:
            pin.computeDistances(model, data, geometry, apart, q)
            gaps = [result.min_distance for result in apart.distanceResults]
            least = int(np.argmin(gaps))
            near[k] = gaps[least]
            pair[k] = " and ".join(pieces[i].link for i in belly.shapes.pairs[least])
    return clear, near, who, pair


class _Rock:
    """Distances of pieces from a boulder."""

    def __init__(self, ground: Boulder, shapes: list[tuple[object, pin.SE3]]) -> None:
        import coal

        self._coal, self._shapes = coal, shapes
        self._ball = coal.Sphere(ground.radius)
        self._at = coal.Transform3s(np.eye(3), np.array((0.0, 0.0, -ground.radius)))

    def gaps(self, places: list[pin.SE3]) -> list[float]:
        coal, found = self._coal, []
        for (shape, own), place in zip(self._shapes, places, strict=True):
            at, result = place * own, coal.DistanceResult()
            here = coal.Transform3s(at.rotation, at.translation)
            coal.distance(shape, here, self._ball, self._at, coal.DistanceRequest(), result)
            found.append(float(result.min_distance))
        return found
