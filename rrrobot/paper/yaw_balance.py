"""The yaw that a given roll and pitch would bring about, its mechanisms one by one.

With roll, pitch and legs given over a cycle the momentum about the vertical through the contact is
linear in the yaw rate W, and so is its balance:

    P = A W + B,      dP/dt = a + b W - kappa W,      a + b W = -z . (v x p)

A is the yaw inertia, B the momentum of roll, pitch and legs, v the velocity of the contact point
and p the robot's momentum. A body on a pivot has v = 0: without damping P stays zero, W = -B / A.
On the ground v is not zero; in the mean -z . (v x p) is the moment of the ground's friction about
the centre of mass, and in a settled motion

    kappa (mean of W) = mean of a + b W .
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait
from rrrobot.paper.settled import last_cycle
from rrrobot.robot.robot import Robot
from rrrobot.rotations import body_rates_matrix, rotation_from_euler
from rrrobot.simulation.trajectory import Trajectory

_SYMMETRIC = np.array(((3, 6, 7), (6, 4, 8), (7, 8, 5)))
"""Where the entries of I stand among the momentum engine's coefficients."""


class Attitude(NamedTuple):
    """Roll and pitch over one cycle at even times, each (n,)."""

    time: Array
    """[s]"""
    roll: Array
    pitch: Array
    roll_rate: Array
    pitch_rate: Array

    def without_roll(self) -> Attitude:
        """The pitch alone."""
        return self._replace(roll=0 * self.roll, roll_rate=0 * self.roll)

    def tilted(self) -> Attitude:
        """The mean pitch alone, held."""
        mean = np.full_like(self.pitch, self.pitch.mean())
        return self.without_roll()._replace(pitch=mean, pitch_rate=0 * mean)

    def level(self) -> Attitude:
        """Neither, as the yaw model has it."""
        return self.tilted()._replace(pitch=0 * self.pitch)


def attitude(trajectory: Trajectory) -> Attitude:
    """Roll and pitch over the last cycle of a settled motion."""
    cycle = last_cycle(trajectory)
    angles, rates = trajectory.euler[cycle], trajectory.euler_rates[cycle]
    return Attitude(trajectory.time[cycle], angles[:, 0], angles[:, 1], rates[:, 0], rates[:, 1])


class YawBalance(NamedTuple):
    """A, B, a and b over one cycle; a and b in two parts, of rolling forwards and sideways."""

    period: float
    """[s]"""
    inertia: Array
    """A (n,) [kg m^2]"""
    momentum: Array
    """B (n,) [kg m^2/s]"""
    moment: Array
    """a (n, 2) [N m]"""
    moment_per_rate: Array
    """b (n, 2) [N m s/rad]"""

    def free_rate(self) -> Array:
        """Yaw rate at which P is zero (n,) [rad/s]."""
        return -self.momentum / self.inertia

    def settled_rate(self, damping: float) -> Array:
        """Yaw rate of the settled motion with a damping above zero [N m s/rad] (n,) [rad/s]."""
        n = self.inertia.size
        wave = 2j * np.pi / self.period * np.fft.fftfreq(n, 1 / n)
        wave[n // 2] = 0.0
        derivative = np.fft.ifft(wave[:, None] * np.fft.fft(np.eye(n), axis=0), axis=0).real
        gain = (self.moment_per_rate.sum(axis=1) - damping) / self.inertia
        forcing = self.moment.sum(axis=1) - gain * self.momentum
        momentum = np.linalg.solve(derivative - np.diag(gain), forcing)
        return np.asarray((momentum - self.momentum) / self.inertia)

    def mean_moment(self, rate: Array) -> Array:
        """Means of a + b W, of rolling forwards and sideways (2,) [N m]."""
        return np.asarray((self.moment + self.moment_per_rate * rate[:, None]).mean(axis=0))


def yaw_balance(robot: Robot, gait: Gait, given: Attitude, *, rolls: bool) -> YawBalance:
    """The balance of a robot with a sphere about its base's origin, on the ground or on a pivot.

    Args:
        robot: the robot.
        gait: of its legs.
        given: roll and pitch over one of the gait's cycles.
        rolls: on the ground; otherwise on a pivot at its centre.
    """
    from rrrobot.momentum.coefficients import coefficients

    legs = gait(given.time)
    table = coefficients(robot, legs.angle, legs.rate)
    radius = robot.shell.radius if rolls else 0.0  # type: ignore[attr-defined]
    rows = [_at(radius, *row) for row in zip(table, *given[1:], strict=True)]
    inertia, momentum, moment, per_rate = (np.array(part) for part in zip(*rows, strict=True))
    period = given.time.size * float(given.time[1] - given.time[0])
    return YawBalance(period, inertia, momentum, moment, per_rate)


def _at(
    radius: float, c: Array, roll: float, pitch: float, roll_rate: float, pitch_rate: float
) -> tuple[float, float, Array, Array]:
    """A, B, a and b at one instant, in axes that turn with the heading."""
    rotation = rotation_from_euler((roll, pitch, 0.0))
    inertia = rotation @ c[_SYMMETRIC] @ rotation.T
    lever, own, own_spin = (rotation @ c[i : i + 3] for i in (0, 9, 12))
    omega = rotation @ body_rates_matrix(roll, pitch) @ (roll_rate, pitch_rate, 0.0)
    up = np.array((0.0, 0.0, 1.0))
    velocity = np.cross(omega, radius * up)
    momentum = inertia @ omega + own_spin + np.cross(lever, velocity)
    # -z . (v x p) = -v_x p_y + v_y p_x; M v adds nothing, being along v.
    turn = velocity[:2] * (-1.0, 1.0)
    moment = turn * (np.cross(omega, lever) + own)[1::-1]
    return inertia[2, 2], momentum[2], moment, turn * np.cross(up, lever)[1::-1]
