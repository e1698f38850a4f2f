"""The paper's second simplification: three single-axis models, recombined by rolling.

The roll, pitch and yaw models run side by side under the same gait; their angles together make the
body's rotation, and eqs (2)-(3) the path of the contact point. All are one system of equations for
the integrator, so the path is as accurate as the angles.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.contact.ground import Ground
from rrrobot.contact.kinematics import sphere_contact_rate
from rrrobot.drive.gaits import Gait, LegMotion
from rrrobot.errors import GaitError, ModelError
from rrrobot.integrate import ATOL, RTOL, Progress, Stepping, integrate, sample_times
from rrrobot.models.full import FullModel
from rrrobot.models.reduced import pivot_radius
from rrrobot.models.single_axis import PitchModel, RollModel, SingleAxisModel, YawModel
from rrrobot.robot.robot import Robot
from rrrobot.rotations import body_rates_matrix, body_rates_matrix_rate, quaternion_from_euler
from rrrobot.simulation.run import assemble, initial_state, longest_step, raise_if_stopped, versions
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.simulation.watch import watch


def decoupled(
    robot: Robot,
    gait: Gait,
    duration: float = 30.0,
    sample_interval: float = 0.01,
    *,
    yaw_gait: Gait | None = None,
    roll: RollModel | None = None,
    pitch: PitchModel | None = None,
    yaw: YawModel | None = None,
    state: ArrayLike | None = None,
    step: float | None = None,
    rtol: float = RTOL,
    atol: float = ATOL,
    progress: Progress | None = None,
) -> Trajectory:
    """Simulate the single-axis models and superpose them into one rolling motion.

    theta(t) = (roll, pitch, yaw) of the three models, each from an impulsive start; the contact
    point follows by eqs (2)-(3).

    The motion does not obey the full equations. Its `contact_force` and `leg_torque` are what they
    demand of it (Pinocchio's inverse dynamics of the whole robot along it), `energy` is the whole
    robot's, and metadata["unbalanced_moment"] is the largest moment about the contact point [N m]
    that nothing supplies: zero for the full model, here the size of what decoupling neglects.

    Args:
        robot: with a spherical shell about the root link's origin, on level ground.
        gait: leg motion.
        duration, sample_interval: [s].
        yaw_gait: leg motion of the yaw model alone, such as the gait with the amplitude that
            `matching_yaw_amplitude` gives (the paper's Fig 20); `gait` if None.
        roll, pitch, yaw: the models, with other dampings than the paper's.
        state: roll, pitch, yaw, their rates and the contact point at t = 0 (8,), instead of an
            impulsive start.
        step, rtol, atol, progress: as for `simulate`.

    Raises:
        ModelError, GaitError, ParameterError, SimulationError: as for `simulate`.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> rr.decoupled(robot, rr.gait("lateral"), duration=2.0)
        Trajectory(decoupled model of rrrobot, 201 samples, 0 .. 2 s, contact travelled 30.3 cm)
    """
    if not isinstance(gait, Gait) or not isinstance(yaw_gait, Gait | None):
        raise GaitError(
            "decoupled models need a prescribed gait: under given torques each single-axis model "
            "would move its legs differently."
        )
    models: tuple[SingleAxisModel, ...] = (
        roll or RollModel(robot),
        pitch or PitchModel(robot),
        yaw or YawModel(robot),
    )
    gaits = (gait, gait, yaw_gait or gait)
    for model in models:
        if model.robot != robot:
            raise ModelError(
                f"the {model.name} model is of {model.robot!r}, not of {robot!r}: make it from "
                "the same robot."
            )
    times = sample_times(duration, sample_interval)
    starts = [initial_state(m, g) for m, g in zip(models, gaits, strict=True)]
    y0 = np.array([*(s[0] for s in starts), *(s[3] for s in starts), 0.0, 0.0])
    if state is not None:
        y0 = vector("state", state, 8)
    longest = min(longest_step(g, *models[:2]) for g in gaits)
    stepping = Stepping(step, rtol, atol, longest)
    radius = models[0].radius

    def accelerations(t: float, y: Array) -> Array:
        return np.array([_acceleration(m, g(t), y) for m, g in zip(models, gaits, strict=True)])

    def rate(t: float, y: Array) -> Array:
        contact = sphere_contact_rate(radius, y[:3], y[3:6])
        return np.concatenate((y[3:6], accelerations(t, y), contact))

    result = integrate(rate, y0, times, stepping, progress=progress)
    states, times = result.states, times[: len(result.states)]
    angular = np.array([accelerations(t, y) for t, y in zip(times, states, strict=True)])
    metadata = {
        "model": {"type": "decoupled"} | {m.name: m.to_dict() for m in models},
        "gait": gait.to_dict(),
        "yaw_gait": gaits[2].to_dict(),
        "period": gait.period,
        "has_contact": True,
        "integration": {"evaluations": result.evaluations} | stepping.to_dict(),
        "versions": versions(),
    }
    trajectory = _recombine(robot, models[0].ground, times, states, angular, gait(times), metadata)
    raise_if_stopped(result, trajectory, lambda y: f"roll, pitch, yaw = {y[:3].tolist()} rad")
    watch(trajectory)
    return trajectory


def _acceleration(model: SingleAxisModel, leg: LegMotion, y: Array) -> float:
    pose = np.array((y[model.axis], 0.0, 0.0))
    solution = model.dynamics(pose, y[3 + model.axis : 4 + model.axis], leg)
    return float(model.quasi_acceleration(solution.acceleration)[0])


def _recombine(
    robot: Robot,
    ground: Ground,
    times: Array,
    states: Array,
    angular: Array,
    legs: LegMotion,
    metadata: dict[str, Any],
) -> Trajectory:
    """Trajectory of the whole robot with this rotation, rolling, by inverse dynamics."""
    n, body = len(times), FullModel(robot, ground=ground)
    radius = pivot_radius(robot, "decoupled", ground)
    quaternion, omega = quaternion_from_euler(states[:, :3]), np.empty((n, 3))
    force, energy = np.empty((n, 3)), np.empty(n)
    torque = np.empty((n, robot.n_legs))
    unbalanced = 0.0
    for i in range(n):
        euler, rates = states[i, :3], states[i, 3:6]
        place = body.place(np.concatenate((quaternion[i], states[i, 6:])))
        matrix = body_rates_matrix(euler[0], euler[1])
        omega[i] = matrix @ rates
        q = body.configuration(place, legs.angle[i])
        v = body.velocity(place, omega[i], legs.rate[i])
        alpha = matrix @ angular[i] + body_rates_matrix_rate(euler, rates) @ rates
        a = body.velocity(place, alpha, legs.acceleration[i])
        # The base moves with x cross omega, where x = -r R^T n is the contact point in the base
        # frame and so x_dot = x cross omega.
        x = -radius * place.rotation[2]
        a[:3] += np.cross(np.cross(x, omega[i]), omega[i])
        tau = pin.rnea(body.model, body.data, q, v, a)
        force[i] = place.rotation @ tau[:3]
        torque[i] = tau[body.legs.v]
        missing = tau[3:6] - np.cross(x, tau[:3]) - body.damping_force(place, omega[i])[3:]
        unbalanced = max(unbalanced, float(np.linalg.norm(missing)))
        energy[i] = sum(body.energy(q, v))
    return assemble(
        robot,
        ground,
        None,
        time=times,
        euler=states[:, :3].copy(),
        quaternion=quaternion,
        omega_body=omega,
        position=states[:, 6:].copy(),
        leg_angle=legs.angle,
        leg_rate=legs.rate,
        contact_force=force,
        leg_torque=torque,
        energy=energy,
        state=states.copy(),
        metadata=metadata | {"unbalanced_moment": unbalanced},
    )
