"""Torque laws with a memory: PID, a delay, a random disturbance, and sums of laws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.gaits import Gait
from rrrobot.drive.laws import Clock, Memory, MotionState, TorqueLaw
from rrrobot.errors import GaitError


class PID(TorqueLaw):
    """tau = kp e + ki integral(e) + kd e_dot with e = setpoint - angle; continuous, or sampled.

    Continuous, the integral is a state beside the legs. Sampled at t_k, the sum
    s_k = s_(k-1) + T e_k (s_(-1) = 0) stands for it, and tau is held from t_k to t_(k+1).

    Args:
        setpoint: angles (legs,) [rad], or a `Gait` to follow.
        kp: [N m/rad], one number or one per leg.
        ki: [N m/(rad s)].
        kd: [N m s/rad].
        sample_time: T [s]; None for continuous.

    Raises:
        GaitError: numbers that are not finite, a sample time that is not above zero.

    Example:
        >>> import rrrobot as rr
        >>> law = rr.drive.PID((1.5, 1.5), kp=2.0, ki=4.0, kd=0.1)
        >>> motors = rr.LegTorques(law, angle=(1.2, 1.8))
        >>> t = rr.simulate(rr.FullModel(rr.Robot.from_parameters()), motors, duration=3.0)
        >>> bool(abs(t.leg_angle[-1] - 1.5).max() < 0.1)
        True
    """

    def __init__(
        self,
        setpoint: ArrayLike | Gait,
        *,
        kp: ArrayLike,
        ki: ArrayLike = 0.0,
        kd: ArrayLike = 0.0,
        sample_time: float | None = None,
    ) -> None:
        self.setpoint = (
            setpoint if isinstance(setpoint, Gait) else _numbers("setpoint", setpoint, "rad")
        )
        self.kp = _numbers("kp", kp, "N m/rad")
        self.ki = _numbers("ki", ki, "N m/(rad s)")
        self.kd = _numbers("kd", kd, "N m s/rad")
        if sample_time is not None:
            sample_time = finite("sample_time", sample_time, "s", above=0, error=GaitError)
        self.sample_time = sample_time

    def _errors(self, state: MotionState) -> tuple[Array, Array]:
        """e and its rate (legs,)."""
        if isinstance(self.setpoint, Gait):
            angle, rate, _ = self.setpoint(state.time)
            return angle - state.leg_angle, rate - state.leg_rate
        return self.setpoint - state.leg_angle, -state.leg_rate

    def _output(self, state: MotionState, integral: Array) -> Array:
        error, rate = self._errors(state)
        return np.asarray(self.kp * error + self.ki * integral + self.kd * rate)

    def initial_memory(self, n_legs: int) -> Memory:
        for name in ("setpoint", "kp", "ki", "kd"):
            value = getattr(self, name)
            size = value.n_legs if isinstance(value, Gait) else value.size
            if size not in ((n_legs,) if isinstance(value, Gait) else (1, n_legs)):
                raise GaitError(f"{name} of the PID has {size} entries for {n_legs} legs.")
        if self.sample_time is None:
            return Memory(continuous=np.zeros(n_legs))
        return Memory(held=np.zeros(2 * n_legs))

    def memory_rate(self, state: MotionState, memory: Memory) -> Array:
        return self._errors(state)[0] if memory.continuous.size else memory.continuous

    def tick(self, state: MotionState, memory: Memory, clock: int, k: int) -> Memory:
        total = (
            memory.held[: state.leg_angle.size]
            + float(self.sample_time or 0.0) * (self._errors(state)[0])
        )
        return Memory(held=np.concatenate((total, self._output(state, total))))

    def torque(self, state: MotionState, memory: Memory) -> Array:
        if self.sample_time is None:
            return self._output(state, memory.continuous)
        return memory.held[state.leg_angle.size :]

    def to_dict(self) -> dict[str, Any]:
        setpoint = (
            self.setpoint.to_dict() if isinstance(self.setpoint, Gait) else self.setpoint.tolist()
        )
        gains = {name: getattr(self, name).tolist() for name in ("kp", "ki", "kd")}
        return {"type": "pid", "setpoint": setpoint, "sample_time": self.sample_time} | gains


class Delayed(TorqueLaw):
    """A sampled law whose output reaches the motors `delay` later; no torque before the first.

    The law is sampled at k T, and its torques act from k T + delay to (k + 1) T + delay.

    Args:
        law: sampled, with one clock.
        delay: zero or more, of any size [s].

    Raises:
        GaitError: the law is not sampled, or the delay is negative.

    Example:
        >>> import rrrobot as rr
        >>> pid = rr.drive.PID((1.5, 1.5), kp=0.5, kd=0.05, sample_time=0.01)
        >>> law = rr.drive.Delayed(pid, delay=0.025)
        >>> [clock.offset for clock in law.clocks]
        [0.0, 0.025]
    """

    def __init__(self, law: TorqueLaw, delay: float) -> None:
        if len(law.clocks) != 1:
            raise GaitError(
                f"Delayed needs a law with one sample time, and {type(law).__name__} has "
                f"{len(law.clocks)}: give it a sample_time."
            )
        self.law = law
        self.delay = finite("delay", delay, "s", at_least=0, error=GaitError)
        self.sample_time = law.sample_time
        self.hides_memory = law.hides_memory
        period = law.clocks[0].period
        self._waiting = int(np.ceil(self.delay / period - 1e-9)) + 1

    @property
    def clocks(self) -> tuple[Clock, ...]:
        (clock,) = self.law.clocks
        return clock, Clock(clock.period, clock.offset + self.delay)

    # Held are the outputs that wait, newest first, then the one that acts, then the law's memory.

    def _split(self, held: Array, n: int) -> tuple[Array, Array]:
        cut = (self._waiting + 1) * n
        return held[:cut].reshape(-1, n), held[cut:]

    def initial_memory(self, n_legs: int) -> Memory:
        inner = self.law.initial_memory(n_legs)
        queue = np.zeros((self._waiting + 1) * n_legs)
        return Memory(inner.continuous, np.concatenate((queue, inner.held)))

    def memory_rate(self, state: MotionState, memory: Memory) -> ArrayLike:
        inner = self._split(memory.held, state.leg_angle.size)[1]
        return self.law.memory_rate(state, Memory(memory.continuous, inner))

    def tick(self, state: MotionState, memory: Memory, clock: int, k: int) -> Memory:
        queue, held = self._split(memory.held, state.leg_angle.size)
        queue = queue.copy()
        inner = Memory(memory.continuous, held)
        if clock == 0:
            inner = self.law.tick(state, inner, 0, k)
            queue[1:-1] = queue[:-2]
            queue[0] = self.law.torque(state, inner)
        else:
            # Outputs that were sampled since this one, which is sample k.
            queue[-1] = queue[self.law.clocks[0].last(self.clocks[1].instant(k)) - k]
        return Memory(inner.continuous, np.concatenate((queue.ravel(), inner.held)))

    def torque(self, state: MotionState, memory: Memory) -> Array:
        queue, _ = self._split(memory.held, state.leg_angle.size)
        return np.asarray(queue[-1])

    def fresh(self) -> TorqueLaw:
        return Delayed(self.law.fresh(), self.delay) if self.hides_memory else self

    def to_dict(self) -> dict[str, Any]:
        return {"type": "delayed", "law": self.law.to_dict(), "delay": self.delay}


class RandomTorques(TorqueLaw):
    """Torques from a normal distribution, drawn anew each sample time and held; a disturbance.

    The k-th draw depends on the seed and on k alone: the same at every run, however it is cut
    into pieces, and whatever the integrator's steps.

    Args:
        standard_deviation: of each leg's torque [N m], one number or one per leg.
        sample_time: [s].
        seed: zero or more.

    Example:
        >>> import rrrobot as rr
        >>> push = rr.drive.RandomTorques(0.01, sample_time=0.02, seed=3)
        >>> pid = rr.drive.PID((1.5, 1.5), kp=0.5, kd=0.05)
        >>> motors = rr.LegTorques(rr.drive.SumOfLaws(pid, push), angle=(1.5, 1.5))
        >>> motors.name
        'SumOfLaws'
    """

    def __init__(self, standard_deviation: ArrayLike, *, sample_time: float, seed: int) -> None:
        self.standard_deviation = _numbers("standard_deviation", standard_deviation, "N m")
        if np.any(self.standard_deviation < 0):
            raise GaitError(
                f"standard_deviation is {self.standard_deviation.tolist()} N m: it must be zero "
                "or more."
            )
        self.sample_time = finite("sample_time", sample_time, "s", above=0, error=GaitError)
        if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
            raise GaitError(f"seed is {seed!r}: it must be a whole number, zero or more.")
        self.seed = int(seed)

    def initial_memory(self, n_legs: int) -> Memory:
        if self.standard_deviation.size not in (1, n_legs):
            raise GaitError(
                f"standard_deviation has {self.standard_deviation.size} entries for {n_legs} legs."
            )
        return Memory(held=np.zeros(n_legs))

    def tick(self, state: MotionState, memory: Memory, clock: int, k: int) -> Memory:
        draw = np.random.default_rng((self.seed, k)).standard_normal(memory.held.size)
        return Memory(held=self.standard_deviation * draw)

    def torque(self, state: MotionState, memory: Memory) -> Array:
        return memory.held

    def to_dict(self) -> dict[str, Any]:
        return {
            "type": "random torques",
            "standard_deviation": self.standard_deviation.tolist(),
            "sample_time": self.sample_time,
            "seed": self.seed,
        }


class SumOfLaws(TorqueLaw):
    """The sum of laws, each with its own clock and memory.

    Args:
        laws: at least one.

    Example:
        >>> import rrrobot as rr
        >>> both = rr.drive.SumOfLaws(rr.drive.PID(1.5, kp=0.5, kd=0.05, sample_time=0.01),
        ...                     rr.drive.RandomTorques(0.01, sample_time=0.02, seed=3))
        >>> [clock.period for clock in both.clocks]
        [0.01, 0.02]
    """

    def __init__(self, *laws: TorqueLaw) -> None:
        if not laws or not all(isinstance(law, TorqueLaw) for law in laws):
            raise GaitError(f"laws are {laws!r}: give at least one TorqueLaw, and nothing else.")
        self.laws = laws
        self.hides_memory = any(law.hides_memory for law in laws)
        self._sizes: dict[int, Sequence[tuple[int, int]]] = {}

    @property
    def clocks(self) -> tuple[Clock, ...]:
        return tuple(clock for law in self.laws for clock in law.clocks)

    def _parts(self, memory: Memory, n_legs: int) -> list[Memory]:
        if n_legs not in self._sizes:
            first = [law.initial_memory(n_legs) for law in self.laws]
            self._sizes[n_legs] = [(m.continuous.size, m.held.size) for m in first]
        parts, m, k = [], 0, 0
        for more_m, more_k in self._sizes[n_legs]:
            parts.append(Memory(memory.continuous[m : m + more_m], memory.held[k : k + more_k]))
            m, k = m + more_m, k + more_k
        return parts

    def initial_memory(self, n_legs: int) -> Memory:
        return _joined([law.initial_memory(n_legs) for law in self.laws])

    def memory_rate(self, state: MotionState, memory: Memory) -> Array:
        parts = self._parts(memory, state.leg_angle.size)
        rates = [law.memory_rate(state, m) for law, m in zip(self.laws, parts, strict=True)]
        return np.concatenate(rates)

    def tick(self, state: MotionState, memory: Memory, clock: int, k: int) -> Memory:
        parts = self._parts(memory, state.leg_angle.size)
        for i, law in enumerate(self.laws):
            n = len(law.clocks)
            if clock < n:
                parts[i] = law.tick(state, parts[i], clock, k)
                break
            clock -= n
        return _joined(parts)

    def torque(self, state: MotionState, memory: Memory) -> Array:
        parts = self._parts(memory, state.leg_angle.size)
        torques = [
            np.asarray(law.torque(state, m)) for law, m in zip(self.laws, parts, strict=True)
        ]
        return np.asarray(sum(torques[1:], torques[0]))

    def fresh(self) -> TorqueLaw:
        return SumOfLaws(*(law.fresh() for law in self.laws)) if self.hides_memory else self

    def to_dict(self) -> dict[str, Any]:
        return {"type": "sum", "laws": [law.to_dict() for law in self.laws]}


def _joined(parts: Sequence[Memory]) -> Memory:
    return Memory(
        np.concatenate([part.continuous for part in parts]),
        np.concatenate([part.held for part in parts]),
    )


def _numbers(name: str, value: ArrayLike, unit: str) -> Array:
    return vector(name, value, max(int(np.size(value)), 1), unit, broadcast=True, error=GaitError)
