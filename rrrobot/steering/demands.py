"""What a plan asks of motors, ground and legs over its whole run."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.contact.ground import normals
from rrrobot.robot.robot import Robot
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.studies.optimisation.table import GaitLimits


class Demands(NamedTuple):
    """The largest and least of a run."""

    torque: float
    """of a motor [N m]"""
    leg_rate: float
    """[rad/s]"""
    power: float
    """of all motors, the sum of |torque x rate| [W]"""
    work: float
    """of all motors, the integral of the sum of |torque x rate| [J]"""
    friction: float
    """coefficient that the contact needs"""
    normal_force: float
    """least, over the weight"""
    clearance: float
    """least height of a leg's centre of mass above the ground [m]"""

    def beyond(self, limits: GaitLimits, robot: Robot, power: float | None = None) -> list[str]:
        """What passes the limits, in words; empty if all are kept.

        Args:
            limits: those of torque, leg rate, friction, normal force and clearance count; of
                torques and rates the least of any joint, for all.
            robot: whose file limits the joints too.
            power: of all motors [W]; any unless given.
        """
        told, ends = [], limits.ends(robot)
        for name, value, most, unit in (
            ("torque", self.torque, ends.effort.min(), " N m"),
            ("leg_rate", self.leg_rate, ends.velocity.min(), " rad/s"),
            ("power", self.power, power, " W"),
            ("friction", self.friction, limits.friction, ""),
        ):
            if most is not None and value > most:
                told.append(f"{name} of {value:.4g}{unit}, above {most:g}")
        if self.normal_force < limits.min_normal_force:
            told.append(
                f"normal force of {self.normal_force:.4g} of the weight, below "
                f"{limits.min_normal_force:g}"
            )
        if self.clearance < limits.min_clearance:
            told.append(f"clearance of {self.clearance:.4g} m, below {limits.min_clearance:g}")
        return told


def demands_of(trajectory: Trajectory) -> Demands:
    """What a run of a rolling model asks for.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.steering.demands import demands_of
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> asked = demands_of(rr.simulate(model, rr.gait("circular"), duration=10.0))
        >>> asked.beyond(rr.GaitLimits(friction=0.02), model.robot)[0].split(",")[1]
        ' above 0.02'
    """
    t = trajectory
    normal = normals(t.ground, t.position)
    push = np.einsum("ni,ni->n", t.contact_force, normal)
    aside = np.linalg.norm(t.contact_force - push[:, None] * normal, axis=1)
    weight = t.robot.mass * t.robot.gravity
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.where(push > 0, aside / push, np.inf)
    power = np.abs(t.leg_torque * t.leg_rate).sum(axis=1)
    return Demands(
        torque=float(np.abs(t.leg_torque).max()),
        leg_rate=float(np.abs(t.leg_rate).max()),
        power=float(power.max()),
        work=float(np.trapezoid(power, t.time)),
        friction=float(needed.max()),
        normal_force=float(push.min() / weight),
        clearance=float(_heights(t).min()),
    )


def _heights(trajectory: Trajectory) -> Array:
    """Heights of all moving links' centres of mass above the ground (n, links) [m]."""
    t, model = trajectory, trajectory.robot.model
    data = model.createData()
    out = np.empty((len(t.time), model.njoints - 2))
    for i, q in enumerate(t.configuration):
        pin.forwardKinematics(model, data, q)
        for k in range(2, model.njoints):
            point = data.oMi[k].act(model.inertias[k].lever)
            out[i, k - 2] = t.ground.distance(point)
    return out
