"""What a simulator in an environment of its own is asked, and how it answers: JSON, NumPy, no more.

A peer is run as `python -m benchmarks.drake_peer`, with a job on standard input, by the Python of
its environment, which has neither rrrobot nor Pinocchio. It writes its answer as the last line.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Job:
    """One gait of the robot of Table 2, and how to simulate it.

    Attributes:
        settings: of the simulator; each peer knows its own.
        steps: time steps in a cycle.
        offset: of both legs [rad].
        phase: by which leg 2 leads leg 1 [rad].
        amplitude: of both legs [rad].
        omega: angular frequency of the legs [rad/s].
        start: body's angular velocity at the impulsive start, upright, (3,) [rad/s].
        radius: of the shell; the hips lie on it [m].
        leg: length [m].
        battery: mass at the bottom of the shell [kg].
        servo: mass at each hip [kg].
        tip: mass at each leg's tip [kg].
        gravity: [m/s^2].
        damping: on each rate of the body [N m s/rad].
        cycles: simulated.
        counted: at the end, which the means are taken of.
    """

    settings: dict[str, Any]
    steps: int
    offset: float
    phase: float
    amplitude: float
    omega: float
    start: tuple[float, float, float]
    radius: float
    leg: float
    battery: float
    servo: float
    tip: float
    gravity: float
    damping: float
    cycles: int
    counted: int

    @property
    def period(self) -> float:
        """Of the gait [s]."""
        return float(2 * np.pi / self.omega)

    @property
    def step(self) -> float:
        """Time step [s]."""
        return self.period / self.steps

    @property
    def mass(self) -> float:
        """Of the whole robot [kg]."""
        return self.battery + 2 * self.servo + 2 * self.tip

    def legs(self, t: float | Array) -> tuple[Array, Array, Array]:
        """Angles, rates and accelerations of both legs, each (2,) or (2, times)."""
        turn = np.stack((self.omega * np.asarray(t), self.omega * np.asarray(t) + self.phase))
        sine = self.amplitude * np.sin(turn)
        rate = self.amplitude * self.omega * np.cos(turn)
        return self.offset + sine, rate, -(self.omega**2) * sine

    def body(self) -> tuple[float, float, Array]:
        """Mass of battery and servos, height of their centre, and its inertia there (3,)."""
        mass = self.battery + 2 * self.servo
        z = -self.battery * self.radius / mass
        low = self.battery * self.radius**2 - mass * z**2
        wide = 2 * self.servo * self.radius**2
        return mass, z, np.array((low + wide, low, wide))

    def centre_start(self) -> Array:
        """Velocity of the sphere's centre at the start (3,) [m/s]."""
        return self.radius * np.cross(self.start, (0.0, 0.0, 1.0))

    def summed_acceleration(self) -> float:
        """Factor on the legs' acceleration that makes symplectic Euler pass through the gait."""
        turn = self.omega * self.step
        return float((2 - 2 * np.cos(turn)) / turn**2)


def euler_rates_map(pitch: float, yaw: float) -> Array:
    """E of omega_world = E (roll', pitch', yaw'), shape (3, 3)."""
    cy, sy, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    return np.array(((cy * cp, -sy, 0.0), (sy * cp, cy, 0.0), (-sp, 0.0, 1.0)))


def euler_of_quaternions(xyzw: Array) -> Array:
    """Roll, pitch, yaw (n, 3) of unit quaternions (n, 4)."""
    x, y, z, w = xyzw.T
    return np.stack(
        (
            np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
            np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0)),
            np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
        ),
        axis=1,
    )


def motion(places: Array, job: Job) -> dict[str, float]:
    """Speed and yaw rate by cycle means, from x, y, yaw at even times (cycles * k + 1, 3)."""
    per_cycle = (len(places) - 1) // job.cycles
    if len(places) != per_cycle * job.cycles + 1 or per_cycle < 8:
        raise ValueError(f"{len(places)} samples are no {job.cycles} cycles of eight or more")
    places = np.column_stack((places[:, :2], np.unwrap(places[:, 2])))
    trapezoid = 0.5 * (places[:-1] + places[1:])
    means = trapezoid.reshape(job.cycles, per_cycle, 3).mean(axis=1)[-job.counted :]
    change = np.diff(means, axis=0) / job.period
    return {
        "speed": float(np.hypot(change[:, 0], change[:, 1]).mean()),
        "yaw_rate": float(change[:, 2].mean()),
    }


def timed(function: Callable[[], Any]) -> tuple[Any, dict[str, float]]:
    """What the function returns, and its time on the wall and on the processor [s]."""
    wall, core = time.perf_counter(), time.process_time()
    found = function()
    return found, {"wall": time.perf_counter() - wall, "core": time.process_time() - core}


def answer(simulate: Callable[[Job], dict[str, Any]], package: str) -> None:
    """Read a job, simulate it, and write what came out with the package's version."""
    from importlib.metadata import version

    found = simulate(Job(**json.load(sys.stdin)))
    print(json.dumps({**found, "version": version(package)}))


def as_json(job: Job) -> str:
    """The job as it is sent."""
    return json.dumps(asdict(job))
