"""Simulate a model in time: model + gait or torques -> Trajectory.

The state is minimal (orientation, contact point, quasi-velocities), so slip and height error are
rounding errors at any step.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait
from rrrobot.drive.torques import LegTorques
from rrrobot.errors import ModelError, ParameterError, SimulationError, SimulationInterrupted
from rrrobot.integrate import ATOL, RTOL, sample_times
from rrrobot.models.base import Model
from rrrobot.progress import Progress
from rrrobot.rotations import euler_from_quaternion
from rrrobot.simulation.evaluate import trajectory_of
from rrrobot.simulation.events import Event
from rrrobot.simulation.fast import FLOWS
from rrrobot.simulation.flow import Evolution, Flow
from rrrobot.simulation.state import State
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
    state: State | None = None,
    step: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str = "kkt",
    events: Sequence[Event] = (),
    progress: Progress = False,
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
        state: a `State` to go on from, such as another trajectory's `final_state`, instead of
            start, euler and position: time, phase of the gait, whole turns and what the drive
            remembers go on.
        step: fixed step [s]; adaptive if None.
        rtol, atol: local error tolerances of the adaptive step, 1e-10 if None, which is at most
            0.04 s and a twelfth of the gait's period; for adaptive steps only.
        method: "kkt", the general form; or "momentum", the fast form for prescribed legs on any
            shell and ground of ours, with fixed steps of at most `step` that end at the samples.
            Forces and torques are Pinocchio's in either.
        events: to look for, such as `lift_off()`; those that are found are the trajectory's
            `events`. It ends at one that is terminal.
        progress: see `rrrobot.progress`; in simulated seconds.

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
        if state is not None or events or step is not None or method != "kkt" or progress:
            raise ModelError(
                "a machine takes no state, step, method, events or progress: see its simulate."
            )
        if np.any(euler) or np.any(position):
            raise ModelError("a machine's own simulate takes its pose: machine.simulate(pose=...).")
        tolerances = (RTOL if rtol is None else rtol, ATOL if atol is None else atol)
        return own.simulated(gait, duration, sample_interval, start, *tolerances)
    if method not in FLOWS:
        raise ParameterError(f"method is {method!r}: it must be 'kkt' or 'momentum'.")
    sample_times(duration, sample_interval)
    flow = FLOWS[method](model, gait, step=step, rtol=rtol, atol=atol)
    if state is None:
        state = flow.start(start=start, euler=euler, position=position)
        begun: Any = start if isinstance(start, str) else np.asarray(start).tolist()
    else:
        state = _continued(state, start=start, euler=euler, position=position)
        begun = "continued"
    times = sample_times(duration, sample_interval, state.time)
    found = flow.evolve(
        state.time, times[-1], state, samples=times, events=events, progress=progress
    )
    settings = {"method": method, "evaluations": found.run.evaluations, "start": begun}
    trajectory = trajectory_of(flow, found, settings | flow.stepping.to_dict())
    raise_if_stopped(flow, found, trajectory)
    watch(trajectory)
    return trajectory


def _continued(state: Any, **others: ArrayLike) -> State:
    if not isinstance(state, State):
        raise ParameterError(
            f"state is {type(state).__name__}: it must be a State, such as trajectory.final_state, "
            "or State.from_array(model, array, time=...)."
        )
    usual: dict[str, Any] = {"start": "impulsive", "euler": (0.0, 0.0, 0.0), "position": (0.0, 0.0)}
    given = [key for key, value in others.items() if not np.array_equal(value, usual[key])]
    if given:
        raise ParameterError(f"{', '.join(given)} would do nothing with state=: leave it out.")
    return state


def raise_if_stopped(flow: Flow, found: Evolution, trajectory: Trajectory) -> None:
    """Raise the SimulationError of an evolution that stopped early."""
    result = found.run
    if result.stop is None:
        return
    kind = SimulationInterrupted if result.interrupted else SimulationError
    raise kind(
        f"{result.stop}, at t = {result.time:.6g} s. State: "
        f"{_describe(flow.model, found.state.vector)}. "
        f"The {len(trajectory)} samples up to then are in the error's .trajectory.",
        time=result.time,
        state=found.state,
        trajectory=trajectory,
    )


def _describe(model: Model, y: Array) -> str:
    pose, quasi, rest = model.split(y)
    place = model.place(pose)
    degrees = np.rad2deg(euler_from_quaternion(place.quaternion))
    text = (
        f"roll, pitch, yaw = {np.round(degrees, 3).tolist()} deg, contact point = "
        f"{np.round(place.position, 5).tolist()} m, velocities = {np.round(quasi, 5).tolist()}"
    )
    return text + (f", legs = {np.round(rest, 5).tolist()}" if rest.size else "")
