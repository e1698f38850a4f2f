"""What a trajectory shows, evaluated at the samples of an evolution."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.constraints import RollingContact
from rrrobot.contact.ground import Ground
from rrrobot.drive.gaits import LegMotion
from rrrobot.drive.laws import Memory
from rrrobot.drive.torques import LegTorques
from rrrobot.models.full import FullModel
from rrrobot.robot.robot import Robot
from rrrobot.rotations import euler_rates
from rrrobot.simulation.flow import Evolution, Flow
from rrrobot.simulation.memory import seen_at
from rrrobot.simulation.trajectory import Trajectory


def trajectory_of(flow: Flow, found: Evolution, settings: dict[str, Any]) -> Trajectory:
    """Evaluate everything at the samples."""
    model, drive = flow.model, flow.drive
    times, states = found.times, found.states
    n, legs = times.size, model.n_legs
    leg_angle, leg_rate, leg_torque = (np.empty((n, legs)) for _ in range(3))
    q, v = np.empty((n, model.model.nq)), np.empty((n, model.model.nv))
    force, energy = np.empty((n, 3)), np.empty(n)
    quaternion, omega, position = np.empty((n, 4)), np.empty((n, 3)), np.empty((n, 2))
    unbalanced = 0.0
    rolling = model.rolling if isinstance(model, FullModel) else None
    residual, height = np.empty((n, 3)), np.empty(n)
    motion = None if isinstance(drive, LegTorques) else drive(times)
    for i, y in enumerate(states):
        pose, quasi, rest = model.split(y)
        place = model.place(pose)
        quaternion[i], position[i] = place.quaternion, place.position
        omega[i] = model.body_velocity(place, quasi)
        if isinstance(drive, LegTorques):
            seen = seen_at(model, float(times[i]), place, quasi, rest)
            leg_angle[i], leg_rate[i] = seen.leg_angle, seen.leg_rate
            cut = found.continuous
            memory = Memory(found.memory[i, :cut], found.memory[i, cut:])
            solution = flow.torque_driven(place, seen, quasi, drive.law, memory)
        else:
            leg = LegMotion(*(part[i] for part in motion))  # type: ignore[union-attr]
            leg_angle[i], leg_rate[i] = leg.angle[:legs], leg.rate[:legs]
            solution = model.dynamics(place, quasi, leg, time=float(times[i]))
        force[i], leg_torque[i] = solution.contact_force, solution.leg_torque
        q[i], v[i] = solution.q, solution.v
        if rolling is not None:
            residual[i], height[i] = solution.residuals[rolling.name], rolling.height(model.data)
        kinetic, potential = model.energy(solution.q, solution.v)
        energy[i] = kinetic + potential
        if "unbalanced" in solution.forces:
            moment = float(np.linalg.norm(solution.forces["unbalanced"]))
            unbalanced = max(unbalanced, moment)
    metadata = {
        "model": model.to_dict(),
        "gait": drive.to_dict(),
        "period": drive.period,
        "has_contact": model.rolling is not None,
        "integration": settings
        | ({"continuous_memory": found.continuous} if isinstance(drive, LegTorques) else {}),
        "versions": versions(),
    }
    if model.name == "decoupled":
        metadata["unbalanced_moment"] = unbalanced
    return assemble(
        model.robot,
        model.ground,
        None if rolling is None else (q, v, residual, height),
        time=times,
        euler=found.euler,
        quaternion=quaternion,
        omega_body=omega,
        position=position,
        leg_angle=leg_angle,
        leg_rate=leg_rate,
        contact_force=force,
        leg_torque=leg_torque,
        energy=energy,
        state=states.copy(),
        memory=found.memory,
        events=found.events,
        end=found.state,
        metadata=metadata,
    )


def assemble(
    robot: Robot,
    ground: Ground,
    free_flyer: tuple[Array, Array, Array, Array] | None,
    *,
    quaternion: Array,
    omega_body: Array,
    **fields: Any,
) -> Trajectory:
    """A Trajectory from body rotations (n, 4), (n, 3) and the other fields.

    Unless free-flyer q, v, slip (n, 3) and height error are given, places the robot's base so that
    its shell rolls on the ground, and measures them. They are by Pinocchio's kinematics.
    """
    configuration, velocity, residual, height = free_flyer or _rolling_motion(
        robot, ground, quaternion, omega_body, fields
    )
    return Trajectory(
        robot=robot,
        ground=ground,
        euler_rates=euler_rates(fields["euler"], omega_body),
        slip=np.linalg.norm(residual, axis=1),
        height_error=height,
        configuration=configuration,
        velocity=velocity,
        **fields,
    )


def _rolling_motion(
    robot: Robot, ground: Ground, quaternion: Array, omega_body: Array, fields: dict[str, Any]
) -> tuple[Array, Array, Array, Array]:
    """Free-flyer q (n, nq), v (n, nv), slip and height error of a robot that rolls as it turns."""
    body = FullModel(robot, ground=ground, damping=None)
    n = len(quaternion)
    rolling, data = RollingContact.of(robot, ground), robot.model.createData()
    configuration, velocity = np.empty((n, robot.model.nq)), np.empty((n, robot.model.nv))
    residual, height = np.empty((n, 3)), np.empty(n)
    for i in range(n):
        place = body.place(np.concatenate((quaternion[i], fields["position"][i])))
        configuration[i] = body.configuration(place, fields["leg_angle"][i])
        velocity[i] = body.velocity(place, omega_body[i], fields["leg_rate"][i])
        residual[i] = rolling.evaluate(data, configuration[i], velocity[i]).residual
        height[i] = rolling.height(data)
    return configuration, velocity, residual, height


def versions() -> dict[str, str]:
    """Versions of what computes the numbers, for metadata."""
    return dict(_versions())


@cache
def _versions() -> dict[str, str]:
    found = {"python": platform.python_version(), "pinocchio": str(pin.__version__)}
    for name in ("rrrobot", "numpy", "scipy"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
