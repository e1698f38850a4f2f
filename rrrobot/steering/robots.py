"""The robot that is driven: simulated cycle by cycle, and seen through a camera with faults."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite
from rrrobot.drive.gaits import Gait, LegMotion
from rrrobot.drive.schedule import Schedule, Stretch
from rrrobot.errors import ModelError
from rrrobot.models.base import Model
from rrrobot.simulation.run import simulate
from rrrobot.simulation.state import State
from rrrobot.steering.standing import rest_of

SAMPLES = 8
"""Poses that are measured in a cycle."""
_JUMP = 0.3
"""Of a sensor that sees another robot, along x [m]."""


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """How the pose is measured.

    Attributes:
        place: standard deviation of x and y [m].
        yaw: [rad].
        delay: whole cycles until a measurement arrives.
        fails_after: time after which nothing is measured any more [s].
        jumps_after: time after which it is off by 0.3 m [s], as if another robot were seen.
        seed: of the noise.
    """

    place: float = 0.0
    yaw: float = 0.0
    delay: int = 0
    fails_after: float = np.inf
    jumps_after: float = np.inf
    seed: int = 0

    def seen(self, time: Array, poses: Array, noise: np.random.Generator) -> Array:
        """Poses (n, 3) at times (n,) as they are measured, NaN where they are not.

        Args:
            time: [s].
            poses: (x, y, yaw) [m, m, rad].
            noise: where the noise comes from.
        """
        out = poses + noise.normal(size=poses.shape) * (self.place, self.place, self.yaw)
        out[:, 0] += np.where(time >= self.jumps_after, _JUMP, 0.0)
        out[time >= self.fails_after] = np.nan
        return np.asarray(out)

    def __post_init__(self) -> None:
        finite("place", self.place, "m", at_least=0)
        finite("yaw", self.yaw, "rad", at_least=0)
        finite("delay", self.delay, "cycles", at_least=0)


class _From(Gait):
    """A gait from a later time on."""

    def __init__(self, gait: Gait, time: float) -> None:
        self.gait, self.time = gait, time
        self.n_legs = gait.n_legs

    def __call__(self, time: ArrayLike) -> LegMotion:
        return self.gait(np.asarray(time, dtype=float) + self.time)

    def to_dict(self) -> dict[str, Any]:
        return {"type": "from", "gait": self.gait.to_dict(), "time": self.time}


class Driven:
    """A model as the robot that is driven, one leg cycle after the other.

    Args:
        model: the true one, of any ground; the KKT form where the momentum engine does not know it.
        start: (x, y, yaw) at rest.
        rest: leg angles there (legs,) [rad].
        angular_frequency: of the legs [rad/s].
        sensor: how it is seen.
    """

    def __init__(
        self, model: Model, start: Array, rest: Array, angular_frequency: float, sensor: Sensor
    ) -> None:
        self.model, self.sensor = model, sensor
        self.period = 2 * np.pi / angular_frequency
        self.frequency, self.rest = angular_frequency, rest
        standing = rest_of(model, rest, float(start[2]))
        self.settling = standing.settling
        still = Stretch(self.period, rest, np.zeros((1, rest.size)), np.zeros((1, rest.size)))
        self.stretches = [still]
        self._euler = standing.euler
        self._yaw, self._state = float(start[2]), None
        self._start = start
        self._noise = np.random.default_rng(sensor.seed)
        self._seen: list[Array] = []
        self.means: list[Array] = [np.asarray(start, dtype=float)]
        self._stepping = stepping_of(model)

    def cycle(self, offset: float, amplitude: float, phase_difference: float) -> None:
        """One more leg cycle, in which the gait is blended to this one."""
        a, o = amplitude, np.full(2, offset)
        phase = np.array((0.0, phase_difference))
        now = Stretch(self.period, o, (a * np.cos(phase))[None], (a * np.sin(phase))[None])
        self._go(now)

    def stand(self) -> None:
        """One more cycle, in which the legs come to rest or stay there."""
        zero = np.zeros((1, self.rest.size))
        self._go(Stretch(self.period, self.rest, zero, zero))

    def _go(self, now: Stretch) -> None:
        # The blend of the last stretch is over; this one begins where it was.
        last = self.stretches[-1]
        pair = Schedule(
            [last, now], angular_frequency=self.frequency, rest=self.rest, blend=self.period
        )
        how: dict[str, Any] = (
            {"start": "rest", "euler": self._euler, "position": self._start[:2]}
            if self._state is None
            else {"state": State.from_array(self.model, self._state)}
        )
        t = simulate(
            self.model, _From(pair, self.period), self.period, self.period / SAMPLES,
            **self._stepping, **how,
        )  # fmt: skip
        self._state = t.state[-1]
        yaw = np.unwrap(np.concatenate(([self._yaw], t.euler[:, 2])))[1:]
        self._yaw = float(yaw[-1])
        poses = np.column_stack((t.position, yaw))
        self.stretches.append(now)
        # The trapezoid rule over a period.
        self.means.append(0.5 * (poses[:-1] + poses[1:]).mean(axis=0))
        self._seen.append(self._measured(poses[1:]))

    def _measured(self, poses: Array) -> Array:
        time = np.full(len(poses), len(self._seen) * self.period)
        return np.asarray(self.sensor.seen(time, poses, self._noise).mean(axis=0))

    @property
    def pose(self) -> Array:
        """(x, y, yaw) now, as nobody but the simulation knows it."""
        return (
            np.array((*self._state[self.model.n_pose - 2 : self.model.n_pose], self._yaw))
            if (self._state is not None)
            else np.asarray(self._start, dtype=float)
        )

    @property
    def seen(self) -> Array | None:
        """Mean pose of the last cycle whose measurement has arrived (3,); None before the first."""
        late = len(self._seen) - 1 - self.sensor.delay
        return self._seen[late] if late >= 0 else None

    @property
    def schedule(self) -> Schedule:
        """All that the legs have done, as a gait."""
        return Schedule(
            self.stretches[1:], angular_frequency=self.frequency, rest=self.rest, blend=self.period
        )


def stepping_of(model: Model) -> dict[str, Any]:
    """Options of `simulate`: the fast method where the engine knows the model."""
    from rrrobot.momentum.lowering import lower

    try:
        lower(model)
    except ModelError:
        return {"method": "kkt", "rtol": 1e-8, "atol": 1e-10}
    return {"method": "momentum"}
