"""The flow of a model under a drive: a state at one time to the state at another.

`Flow` is the general form, by the KKT system, for any model, prescribed legs or torques.
`MomentumFlow` of `fast.py` is the fast form for prescribed legs on any shell and ground of ours.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.gaits import Gait
from rrrobot.drive.laws import Memory, MotionState, TorqueLaw
from rrrobot.drive.torques import LegTorques
from rrrobot.errors import GaitError, ModelError, ParameterError
from rrrobot.integrate import ATOL, RTOL, Integration, Stepping, Watch, integrate
from rrrobot.models.base import Model
from rrrobot.models.recombined import NEEDS_GAIT, DecoupledModels
from rrrobot.models.terms import Dynamics, Placement
from rrrobot.progress import Progress, Tell, progress_of
from rrrobot.simulation.effort import Effort
from rrrobot.simulation.events import Event, Hit, Lookout, Snapshot
from rrrobot.simulation.memory import Recall, seen_at
from rrrobot.simulation.state import State
from rrrobot.simulation.track import Track, require_rolling

Drive = Gait | LegTorques


class Evolution(NamedTuple):
    """What came of a flow."""

    state: State
    """at the end"""
    times: Array
    """of the samples (n,) [s]"""
    states: Array
    """state vectors (n, ny)"""
    euler: Array
    """roll, pitch, yaw with whole turns (n, 3) [rad]"""
    memory: Array
    """of the drive, the continuous part first (n, k)"""
    continuous: int
    """size of that part"""
    events: tuple[Hit, ...]
    """in order of time"""
    run: Integration


class Flow:
    """The flow of a model under a drive, by the KKT system.

    Args:
        model: such as `FullModel(robot)`.
        drive: prescribed leg motion (`Gait`), or motor torques (`LegTorques`).
        step: fixed step [s]; adaptive if None.
        rtol, atol: local error tolerances of the adaptive step; 1e-10 if None.
        max_step: longest adaptive step [s]; the model's, and a twelfth of the gait's period, if
            None.

    Raises:
        GaitError: the drive does not fit the robot.
        ParameterError: a number out of range, or a tolerance for fixed steps.

    Example:
        >>> import rrrobot as rr
        >>> model, gait = rr.FullModel(rr.Robot.from_parameters()), rr.gait("circular")
        >>> flow = rr.simulation.Flow(model, gait)
        >>> end = flow.evolve(0.0, gait.period, flow.start()).state
        >>> round(end.time, 6) == round(gait.period, 6)
        True
    """

    method = "kkt"

    def __init__(
        self,
        model: Model,
        drive: Drive,
        *,
        step: float | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        max_step: float | None = None,
    ) -> None:
        if not isinstance(drive, (Gait, LegTorques)):
            raise GaitError(
                f"gait is {type(drive).__name__}: it must be a Gait, such as SinusoidalGait, or "
                "LegTorques. Wrap a function in CallableGait."
            )
        if not isinstance(model, Model):
            kind = type(model).__name__
            raise ModelError(f"model is {kind}: it must be a model, such as FullModel(robot).")
        if isinstance(model, DecoupledModels) and not isinstance(drive, Gait):
            raise GaitError(NEEDS_GAIT)
        model.check_legs(drive.n_legs)
        if step is not None:
            self._refuse("step=, as fixed steps have no tolerance", rtol=rtol, atol=atol)
        self.model, self.drive = model, drive
        longest = self._longest() if max_step is None else max_step
        self.stepping = Stepping(
            step, RTOL if rtol is None else rtol, ATOL if atol is None else atol, longest
        ).checked()
        first = model.n_pose + model.n_quasi
        free = 2 * model.n_legs if isinstance(drive, LegTorques) else 0
        self._legs = slice(first, first + free)
        self.size = self._legs.stop
        """of the state vector"""

    def _longest(self) -> float:
        period = self.drive.period
        return min(self.model.max_step, np.inf if period is None else period / 12)

    @staticmethod
    def _refuse(why: str, **options: object) -> None:
        given = [name for name, value in options.items() if value is not None]
        if given:
            raise ParameterError(f"{', '.join(given)} would do nothing with {why}: leave it out.")

    def start(
        self,
        *,
        start: str | ArrayLike = "impulsive",
        euler: ArrayLike = (0.0, 0.0, 0.0),
        position: ArrayLike = (0.0, 0.0),
        time: float = 0.0,
    ) -> State:
        """State from which a run starts; arguments as for `simulate`.

        Raises:
            GaitError: the gait is not finite there.
            ModelError: motion about an axis that the model locks, a contact that does not roll.
        """
        model, drive = self.model, self.drive
        angles = vector("euler", euler, 3, "rad", labels=("roll", "pitch", "yaw"))
        _require_free(model, "euler", angles)
        point = vector("position", position, 2, "m")
        time = finite("time", time, "s")
        pose = model.make_pose(angles, point)
        require_rolling(model, pose)
        if isinstance(drive, LegTorques):
            leg, rate = drive.angle, drive.rate
            rest: tuple[Array, ...] = (leg, rate)
        else:
            leg, rate, acceleration = drive(time)
            for name, value in (("angle", leg), ("rate", rate), ("acceleration", acceleration)):
                what = f"{name} of the gait at t = {time:g} s"
                vector(what, value, drive.n_legs, error=GaitError)
            rest = ()
        quasi = _start_velocity(model, start, pose, leg, rate)
        y = np.concatenate((pose, quasi, *rest))
        return State(
            model=model.to_dict(), robot=model.robot, time=time, vector=y, euler=angles.copy()
        )

    def evolve(
        self,
        t0: float,
        t1: float,
        state: State,
        *,
        samples: ArrayLike | None = None,
        events: Sequence[Event] = (),
        progress: Progress = False,
    ) -> Evolution:
        """Evolve a state from t0 to t1.

        Args:
            t0: the state's own time [s]; `state.at(t0)` gives it another.
            t1: later [s].
            state: of this model.
            samples: further times between them at which the state is wanted (n,) [s].
            events: to look for.
            progress: see `rrrobot.progress`; in seconds from t0.

        Returns:
            the Evolution; `run.stop` says why it stopped early, if it did.

        Raises:
            ModelError: the state is of another model.
            ParameterError: times out of order.
        """
        start, end = finite("t0", t0, "s"), finite("t1", t1, "s")
        if not isinstance(state, State):
            raise ParameterError(
                f"state is {type(state).__name__}: it must be a State, such as "
                "trajectory.final_state, or State.from_array(model, array, time=...)."
            )
        if abs(start - state.time) > 1e-9 * max(1.0, abs(start)):
            raise ParameterError(
                f"t0 is {start!r} s, and the state is at {state.time!r} s: they must be the same; "
                "state.at(t0) gives the state another time."
            )
        if not end > start:
            raise ParameterError(f"t1 is {end!r} s: it must be later than t0, {start!r} s.")
        times = np.array((start, end))
        if samples is not None:
            wanted = np.asarray(samples, dtype=float)
            if wanted.size and not (wanted.min() >= start and wanted.max() <= end):
                raise ParameterError(f"samples must lie between t0 = {start} s and t1 = {end} s.")
            times = np.union1d(times, wanted)
        torque_driven = isinstance(self.drive, LegTorques)
        state.require(self.model, torque_driven=torque_driven)
        recall = Recall(self.model, self.drive, state) if torque_driven else None
        track = Track(self.model, state.euler, times.size, recall)
        with progress_of(progress, "simulating", end - start, "s") as tell:
            told = None if tell is None else partial(_since, tell, start)
            effort = Effort(self, times, told)
            result, lane, hits = self._run(state, times, recall, track, tuple(events), effort)
        if recall is not None and (fault := recall.asked.ended()) is not None:
            raise GaitError(fault)
        n = len(result.states)
        memory = np.empty((n, 0)) if recall is None else track.memory(n, result.states, self.size)
        final = replace(
            state,
            time=result.time,
            vector=result.state[: self.size].copy(),
            euler=self.model.turned(result.state[None, : self.model.n_pose], track.last)[0].copy(),
            memory=None if recall is None else recall.now(result.state),
            law=None if recall is None or not recall.law.hides_memory else recall.law.fresh(),
            drive=self.drive.to_dict(),
            lane=lane,
        )
        states = result.states[:, : self.size]
        continuous = result.states.shape[1] - self.size
        euler = track.angles[:n]
        return Evolution(final, result.times, states, euler, memory, continuous, hits, result)

    def _run(
        self,
        state: State,
        times: Array,
        recall: Recall | None,
        track: Track,
        events: tuple[Event, ...],
        effort: Effort,
    ) -> tuple[Integration, Array | None, tuple[Hit, ...]]:
        rate: Callable[[float, Array], Array] = self.rate
        y0 = state.vector
        if recall is not None:
            y0, rate = recall.begin(state), partial(self._driven, recall)
        lookout = None
        if events:
            lookout = Lookout(events, lambda t, y: self.look(t, y, recall), self.size)
        watch: Watch | None = lookout
        effort.rate = rate
        result = integrate(
            rate,
            y0,
            times,
            self.stepping,
            observer=track,
            jumps=recall if recall is not None and recall.clocks else None,
            watch=watch,
            progress=effort.progress(lambda: track.y),
        )
        return result, None, () if lookout is None else tuple(lookout.hits)

    # The right-hand side.

    def rate(self, time: float, y: Array) -> Array:
        """dy/dt under prescribed legs."""
        model = self.model
        pose, quasi, _ = model.split(y)
        place = model.place(pose)
        rate = np.empty_like(y)
        rate[: model.n_pose] = model.pose_rate(place, pose, quasi)
        rate[model.n_pose :] = model.quasi_rate(place, quasi, self.drive(time), time)  # type: ignore[operator]
        return rate

    def _driven(self, recall: Recall, time: float, y: Array) -> Array:
        """dy/dt under torques, and of the continuous memory."""
        model = self.model
        pose, quasi, rest = model.split(y[: self.size])
        place = model.place(pose)
        seen = seen_at(model, time, place, quasi, rest)
        memory = recall.now(y)
        solution = self.torque_driven(place, seen, quasi, recall.asked, memory)
        return np.concatenate(
            (
                model.pose_rate(place, pose, quasi),
                model.quasi_acceleration(solution.acceleration),
                seen.leg_rate,
                solution.acceleration[model.legs.v],
                recall.rate(seen, memory),
            )
        )

    def torque_driven(
        self, place: Placement, seen: MotionState, quasi: Array, law: TorqueLaw, memory: Memory
    ) -> Dynamics:
        """Dynamics under the drive's torques."""
        torque = self.drive.checked(law, seen, memory)  # type: ignore[union-attr]
        return self.model.dynamics(
            place,
            quasi,
            leg_angle=seen.leg_angle,
            leg_rate=seen.leg_rate,
            leg_torque=torque,
            time=seen.time,
        )

    def look(self, time: float, y: Array, recall: Recall | None = None) -> Snapshot:
        """The motion at a time, for events."""

        def solve(t: float, state: Array) -> Dynamics:
            pose, quasi, rest = self.model.split(state)
            place = self.model.place(pose)
            if recall is None:
                return self.model.dynamics(place, quasi, self.drive(t), time=t)  # type: ignore[operator]
            seen = seen_at(self.model, t, place, quasi, rest)
            return self.torque_driven(place, seen, quasi, recall.law, recall.now(y))

        return Snapshot(self.model, time, y[: self.size], solve)


def _since(tell: Tell, start: float, now: float) -> None:
    tell(now - start)


def _start_velocity(
    model: Model, start: str | ArrayLike, pose: Array, leg_angle: Array, leg_rate: Array
) -> Array:
    """Quasi-velocities of a start: "impulsive", "rest", or Euler rates (3,) [rad/s]."""
    if isinstance(start, str):
        if start == "impulsive":
            return model.impulsive_start(pose, leg_angle, leg_rate)
        if start == "rest":
            return np.zeros(model.n_quasi)
        raise ModelError(f"start is {start!r}: it must be 'impulsive', 'rest' or Euler rates.")
    rates = vector("start", start, 3, "rad/s", labels=("roll", "pitch", "yaw"))
    _require_free(model, "start", rates)
    return model.quasi_from_euler_rates(pose, rates)


def _require_free(model: Model, name: str, values: Array) -> None:
    """Raise ModelError where a value is not zero on an axis that a model locks."""
    locked = [i for i in range(3) if i not in model.axes and values[i] != 0]
    if locked:
        names = ("roll", "pitch", "yaw")
        raise ModelError(
            f"{name} is {values.tolist()} (roll, pitch, yaw): the {model.name} model locks "
            f"{', '.join(names[i] for i in locked)}, so that entry must be zero."
        )
