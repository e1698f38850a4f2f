"""Integrate a model in time: model + gait or torques -> Trajectory.

The state is minimal (orientation, contact point, quasi-velocities), so slip and height error are
rounding errors at any step.
"""

from __future__ import annotations

import platform
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.constraints import RollingContact
from rrrobot.contact.ground import Ground
from rrrobot.drive.gaits import Gait, LegMotion
from rrrobot.drive.torques import LegTorques, MotionState
from rrrobot.errors import (
    GaitError,
    ModelError,
    ParameterError,
    SimulationError,
    SimulationInterrupted,
)
from rrrobot.integrate import (
    ATOL,
    RTOL,
    Integration,
    Progress,
    Stepping,
    integrate,
    sample_times,
)
from rrrobot.models.base import VERTICAL_PITCH, Model
from rrrobot.models.full import FullModel
from rrrobot.models.terms import Dynamics, Placement
from rrrobot.robot.robot import Robot
from rrrobot.rotations import (
    continuous_euler,
    euler_from_quaternion,
    euler_from_rotation,
    euler_rates,
    rotation_from_quaternion,
)
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.simulation.watch import watch


def simulate(
    model: Model,
    gait: Gait | LegTorques,
    duration: float = 30.0,
    sample_interval: float = 0.01,
    *,
    start: str | ArrayLike = "impulsive",
    euler: ArrayLike = (0.0, 0.0, 0.0),
    position: ArrayLike = (0.0, 0.0),
    state: ArrayLike | None = None,
    step: float | None = None,
    rtol: float = RTOL,
    atol: float = ATOL,
    method: str = "kkt",
    progress: Progress | None = None,
) -> Trajectory:
    """Simulate a model whose legs follow a gait or are driven by torques.

    Args:
        model: such as `FullModel(robot)`; or a machine's, which gives a `machines.History`.
        gait: prescribed leg motion (`Gait`), or motor torques (`LegTorques`).
        duration: [s], greater than zero.
        sample_interval: of the result [s]; the last sample is at `duration` in any case.
        start: velocity of the body at t = 0. "impulsive": zero momentum conjugate to each free
            body coordinate, as if legs at speed had just been set in motion; "rest"; or Euler
            rates (roll, pitch, yaw) (3,) [rad/s].
        euler: roll, pitch, yaw at t = 0 (3,) [rad].
        position: contact point in the ground plane at t = 0 (2,) [m].
        state: the model's whole state vector at t = 0 instead of start, euler and position, such
            as the last row of another trajectory's `state`.
        step: fixed step [s]; adaptive if None.
        rtol, atol: local error tolerances of the adaptive step, which is at most 0.04 s and a
            twelfth of the gait's period.
        method: "kkt", the general form; or "momentum", the fast form for prescribed legs on any
            shell and ground of ours, with fixed steps of at most `step` that end at the samples.
            Forces and torques are Pinocchio's in either.
        progress: called with the simulated time after each step.

    Returns:
        the Trajectory.

    Raises:
        ParameterError, GaitError, ModelError: an argument is out of range or does not fit.
        SimulationError: the pitch reached +-90 degrees where the Euler damping is singular, or a
            value was not finite. It carries the time, the state and the trajectory so far.
        SimulationInterrupted: Ctrl-C; likewise.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> t = rr.simulate(model, rr.gait("circular"), duration=3.0)
        >>> bool(t.slip.max() < 1e-12)
        True
    """
    own = getattr(model, "machine", None)
    if own is not None:
        if state is not None or step is not None or method != "kkt" or progress is not None:
            raise ModelError(
                "a machine takes no state, step, method or progress: see its simulate."
            )
        if np.any(euler) or np.any(position):
            raise ModelError("a machine's own simulate takes its pose: machine.simulate(pose=...).")
        return own.simulated(gait, duration, sample_interval, start, rtol, atol)
    if method not in ("kkt", "momentum"):
        raise ParameterError(f"method is {method!r}: it must be 'kkt' or 'momentum'.")
    times = sample_times(duration, sample_interval)
    y0 = initial_state(model, gait, start=start, euler=euler, position=position, state=state)
    stepping = Stepping(step, rtol, atol, longest_step(gait, model))
    system = _System(model, gait)
    track = EulerTrack(model, np.zeros(3) if state is not None else euler, times.size)
    if method == "momentum":
        if not isinstance(gait, Gait):
            raise GaitError("method 'momentum' needs a prescribed gait; use 'kkt' for torques.")
        # Numba loads here, so that it costs nobody who does not use it.
        from rrrobot.momentum.run import run
        from rrrobot.momentum.terrain import fineness

        longest = stepping.checked().step or stepping.max_step / fineness(model.robot.shell)
        result = run(model, gait, y0, times, longest, observer=track, progress=progress)
        stepping = stepping._replace(step=longest)
    else:
        result = integrate(system.rate, y0, times, stepping, observer=track, progress=progress)
    n = len(result.states)
    settings = {
        "method": method,
        "evaluations": result.evaluations,
        "start": start if isinstance(start, str) else np.asarray(start).tolist(),
    }
    settings |= stepping.to_dict()
    trajectory = system.trajectory(times[:n], result.states, track.angles[:n], settings)
    raise_if_stopped(result, trajectory, lambda y: _describe(model, y))
    watch(trajectory)
    return trajectory


def raise_if_stopped(
    result: Integration, trajectory: Trajectory, describe: Callable[[Array], str]
) -> None:
    """Raise the SimulationError of an integration that stopped early."""
    if result.stop is None:
        return
    kind = SimulationInterrupted if result.interrupted else SimulationError
    raise kind(
        f"{result.stop}, at t = {result.time:.6g} s. State: {describe(result.state)}. "
        f"The {len(trajectory)} samples up to then are in the error's .trajectory.",
        time=result.time,
        state=result.state,
        trajectory=trajectory,
    )


def initial_state(
    model: Model,
    gait: Gait | LegTorques,
    *,
    start: str | ArrayLike = "impulsive",
    euler: ArrayLike = (0.0, 0.0, 0.0),
    position: ArrayLike = (0.0, 0.0),
    state: ArrayLike | None = None,
) -> Array:
    """State vector of a model at t = 0; arguments as for `simulate`.

    Raises:
        GaitError: the gait does not fit the robot.
        ModelError: the start asks for motion about an axis that the model locks.
    """
    if not isinstance(gait, (Gait, LegTorques)):
        raise GaitError(
            f"gait is {type(gait).__name__}: it must be a Gait, such as SinusoidalGait, or "
            "LegTorques. Wrap a function in CallableGait."
        )
    model.check_legs(gait.n_legs)
    torque_driven = isinstance(gait, LegTorques)
    if state is not None:
        size = model.n_pose + model.n_quasi + 2 * model.n_legs * torque_driven
        return vector("state", state, size)
    angles = vector("euler", euler, 3, "rad", labels=("roll", "pitch", "yaw"))
    model.require_free("euler", angles)
    point = vector("position", position, 2, "m")
    pose = model.make_pose(angles, point)
    if isinstance(gait, LegTorques):
        leg, rate = gait.angle, gait.rate
    else:
        leg, rate, acceleration = gait(0.0)
        for name, value in (("angle", leg), ("rate", rate), ("acceleration", acceleration)):
            vector(f"{name} of the gait at t = 0 s", value, model.n_legs, error=GaitError)
    quasi = model.start_velocity(start, pose, leg, rate)
    rest = (leg, rate) if torque_driven else ()
    return np.concatenate((pose, quasi, *rest))


class _System:
    """A model and its drive as an ordinary differential equation, and its samples as a result."""

    def __init__(self, model: Model, drive: Gait | LegTorques) -> None:
        self.model = model
        self.drive = drive

    def rate(self, time: float, y: Array) -> Array:
        """dy/dt."""
        model = self.model
        pose, quasi, rest = model.split(y)
        place = model.place(pose)
        if not isinstance(self.drive, LegTorques):
            solution = model.dynamics(place, quasi, self.drive(time))
            rate = np.empty_like(y)
            rate[: model.n_pose] = model.pose_rate(place, pose, quasi)
            rate[model.n_pose :] = model.quasi_acceleration(solution.acceleration)
            return rate
        solution = self._torque_driven(time, place, quasi, rest)
        body = model.quasi_acceleration(solution.acceleration)
        legs = rest[model.n_legs :], solution.acceleration[model.legs.v]
        return np.concatenate((model.pose_rate(place, pose, quasi), body, *legs))

    def _torque_driven(self, time: float, place: Placement, quasi: Array, legs: Array) -> Dynamics:
        model, drive = self.model, self.drive
        angle, rate = legs[: model.n_legs], legs[model.n_legs :]
        omega = model.body_velocity(place, quasi)
        state = MotionState(time, place.rotation, omega, place.position, angle, rate)
        torque = drive.torque(state)  # type: ignore[union-attr]
        return model.dynamics(place, quasi, leg_angle=angle, leg_rate=rate, leg_torque=torque)

    def trajectory(
        self, times: Array, states: Array, euler: Array, settings: dict[str, Any]
    ) -> Trajectory:
        """Evaluate everything at the samples."""
        model, n, legs = self.model, times.size, self.model.n_legs
        leg_angle, leg_rate, leg_torque = (np.empty((n, legs)) for _ in range(3))
        q, v = np.empty((n, model.model.nq)), np.empty((n, model.model.nv))
        force, energy = np.empty((n, 3)), np.empty(n)
        quaternion, omega, position = np.empty((n, 4)), np.empty((n, 3)), np.empty((n, 2))
        motion = None if isinstance(self.drive, LegTorques) else self.drive(times)
        for i, y in enumerate(states):
            pose, quasi, rest = model.split(y)
            place = model.place(pose)
            quaternion[i], position[i] = place.quaternion, place.position
            omega[i] = model.body_velocity(place, quasi)
            if motion is None:
                leg_angle[i], leg_rate[i] = rest[:legs], rest[legs:]
                solution = self._torque_driven(times[i], place, quasi, rest)
            else:
                leg = LegMotion(*(part[i] for part in motion))
                leg_angle[i], leg_rate[i] = leg.angle, leg.rate
                solution = model.dynamics(place, quasi, leg)
            force[i], leg_torque[i] = solution.contact_force, solution.leg_torque
            q[i], v[i] = solution.q, solution.v
            kinetic, potential = model.energy(solution.q, solution.v)
            energy[i] = kinetic + potential
        free_flyer = (q, v) if isinstance(model, FullModel) else None
        return assemble(
            model.robot,
            model.ground,
            free_flyer,
            time=times,
            euler=euler,
            quaternion=quaternion,
            omega_body=omega,
            position=position,
            leg_angle=leg_angle,
            leg_rate=leg_rate,
            contact_force=force,
            leg_torque=leg_torque,
            energy=energy,
            state=states.copy(),
            metadata={
                "model": model.to_dict(),
                "gait": self.drive.to_dict(),
                "period": self.drive.period,
                "has_contact": model.rolling is not None,
                "integration": settings,
                "versions": versions(),
            },
        )


def assemble(
    robot: Robot,
    ground: Ground,
    free_flyer: tuple[Array, Array] | None,
    *,
    quaternion: Array,
    omega_body: Array,
    **fields: Any,
) -> Trajectory:
    """A Trajectory from body rotations (n, 4), (n, 3) and the other fields.

    Unless free-flyer (q, v) are given, places the robot's base so that its shell rolls on the
    ground; in either case measures slip and height error by Pinocchio's kinematics.
    """
    configuration, velocity = free_flyer or _rolling_motion(
        robot, ground, quaternion, omega_body, fields
    )
    rolling = RollingContact.of(robot, ground)
    data = robot.model.createData()
    residual, height = np.empty((len(quaternion), 3)), np.empty(len(quaternion))
    for i, (q, v) in enumerate(zip(configuration, velocity, strict=True)):
        residual[i] = rolling.evaluate(data, q, v).residual
        height[i] = rolling.height(data)
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
) -> tuple[Array, Array]:
    """Free-flyer q (n, nq) and v (n, nv) of the robot that rolls with the given rotation."""
    body = FullModel(robot, ground=ground, damping=None)
    n = len(quaternion)
    configuration, velocity = np.empty((n, robot.model.nq)), np.empty((n, robot.model.nv))
    for i in range(n):
        place = body.place(np.concatenate((quaternion[i], fields["position"][i])))
        configuration[i] = body.configuration(place, fields["leg_angle"][i])
        velocity[i] = body.velocity(place, omega_body[i], fields["leg_rate"][i])
    return configuration, velocity


def longest_step(gait: Gait | LegTorques, *models: Model) -> float:
    """Longest step of the adaptive integrator [s]: the models', and a twelfth of the period."""
    steps = [model.max_step for model in models]
    return min(steps if gait.period is None else [*steps, gait.period / 12])


class EulerTrack:
    """Follows roll, pitch and yaw without jumps from step to step, and stops at the vertical.

    Attributes:
        angles: of the samples (n, 3) [rad].
    """

    def __init__(self, model: Model, euler: ArrayLike, n: int) -> None:
        self.model = model
        self.now = np.asarray(euler, dtype=float)
        self.angles = np.empty((n, 3))

    def sampled(self, first: int, states: Array) -> None:
        quaternions = self.model.quaternions(states[:, : self.model.n_pose])
        found = continuous_euler(euler_from_quaternion(quaternions), self.now)
        self.angles[first : first + len(states)] = found

    def stepped(self, y: Array) -> str | None:
        quaternion = self.model.quaternions(y[None, : self.model.n_pose])[0]
        euler = euler_from_rotation(rotation_from_quaternion(quaternion))
        self.now = continuous_euler([euler], self.now)[0]
        if self.model.singular_at_vertical and abs(self.now[1]) > VERTICAL_PITCH:
            return (
                "the pitch reached +-90 degrees, where the Euler rates, and with them this "
                "model's damping or coordinates, are singular; swing the legs less, or use the "
                "full model with BodyRateDamping"
            )
        model = self.model
        return model.trouble(y[: model.n_pose]) if isinstance(model, FullModel) else None


def _describe(model: Model, y: Array) -> str:
    pose, quasi, rest = model.split(y)
    place = model.place(pose)
    degrees = np.rad2deg(euler_from_quaternion(place.quaternion))
    text = (
        f"roll, pitch, yaw = {np.round(degrees, 3).tolist()} deg, contact point = "
        f"{np.round(place.position, 5).tolist()} m, velocities = {np.round(quasi, 5).tolist()}"
    )
    return text + (f", legs = {np.round(rest, 5).tolist()}" if rest.size else "")


def versions() -> dict[str, str]:
    """Versions of what computes the numbers, for metadata."""
    found = {"python": platform.python_version(), "pinocchio": str(pin.__version__)}
    for name in ("rrrobot", "numpy", "scipy"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
