"""RRRobot as a unicycle: the mean motion of a cycle without any dynamics (Fig 17 of the paper).

A gait that has settled moves the cycle-mean pose along a twist (u, v, w) of the body's mean axes. A
unicycle has the gait of the moment's twist at once, at the start, between gaits and at the end too:

    x_dot = u cos(yaw) - v sin(yaw),    y_dot = u sin(yaw) + v cos(yaw),    yaw_dot = w.

The paper's wheel stands in the plane of the leg axis, so it has u = 0; with u it slips sideways as
the robot does. Where the legs' offset changes the body leans, and rolls by its radius times (pitch,
-roll) of the lean, there and back. (u, v, w) go with the squared amplitude: r (c0 + c1 r) at each
offset and phase difference, r the product of both legs' amplitudes over the largest squared.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline, RectBivariateSpline

from rrrobot.checks import Array
from rrrobot.drive.schedule import Schedule
from rrrobot.errors import ModelError, ParameterError
from rrrobot.models.base import Model
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.steering.arcs import move
from rrrobot.steering.gears import grid
from rrrobot.steering.motions import Motions, motions_of
from rrrobot.steering.plots import cycle_means
from rrrobot.steering.standing import radius_of, rest_of, standing

_PER_CYCLE, _LEANS = 16, 61


class UnicycleRun(NamedTuple):
    """A unicycle beside the robot that does the same gaits."""

    time: Array
    """middle of each counted cycle (n,) [s]"""
    robot: Array
    """mean pose of the cycle (n, 3) [m, m, rad]"""
    unicycle: Array
    """likewise"""
    length: float
    """of the robot's mean path [m]"""
    distance: float
    """largest between the two [m]"""
    turn: float
    """largest difference of the yaws [rad]"""


class Unicycle:
    """The mean motion of a robot by the map of its settled motions alone.

    Args:
        model: of a robot with a spherical shell.
        motions: of `motions_of`, for the full or the decoupled models; the model's own unless
            given.
        slips: whether it has the robot's velocity across the leg axis too; the paper's has not.
        leans: whether the contact point moves as the body leans; the paper's does not.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> from rrrobot.drive.schedule import Schedule, stretch
        >>> wheel = rr.steering.Unicycle(rr.FullModel(rr.Robot.from_parameters()))
        >>> speed = wheel.twist(np.pi / 2, 0.3, np.pi / 2)[1]  # of the lateral gait, to the right
        >>> round(float(speed), 4)
        -0.0097
    """

    def __init__(
        self,
        model: Model,
        motions: Motions | None = None,
        *,
        slips: bool = True,
        leans: bool = True,
    ) -> None:
        motions = motions_of(model) if motions is None else motions
        self.model, self.slips = model, slips
        self.angular_frequency = motions.angular_frequency
        self._largest = float(motions.amplitude.max())
        offsets, phases, (low, high) = grid(motions)
        share = (float(motions.amplitude.min()) / self._largest) ** 2
        c1 = (high - low / share) / (1.0 - share)
        # Three columns more on each side: splines have no period here.
        around = np.concatenate((phases[-3:] - 2 * np.pi, phases, phases[:3] + 2 * np.pi))
        self._range = (float(offsets[0]), float(offsets[-1]))
        self._splines = [
            [
                RectBivariateSpline(offsets, around, np.hstack((c[:, -3:], c, c[:, :3])), s=0)
                for c in np.moveaxis(table, 2, 0)
            ]
            for table in (high - c1, c1)
        ]

        at = np.linspace(*self._range, _LEANS)
        shift = np.zeros((_LEANS, 2))
        if leans:
            euler = np.array([standing(model, np.full(2, o)) for o in at])
            shift = radius_of(model) * np.column_stack((euler[:, 1], -euler[:, 0]))
        self._lean = CubicSpline(at, shift)

    def twist(
        self, offset: Array | float, amplitude: Array | float, phase_difference: Array | float
    ) -> Array:
        """(u, v, yaw rate) of gaits of both legs (..., 3) [m/s, m/s, rad/s].

        Args:
            offset: (...,) [rad], within the map's.
            amplitude: root of the product of both legs' (...,) [rad].
            phase_difference: of leg 2 from leg 1 (...,) [rad].
        """
        o, a, p = np.broadcast_arrays(offset, amplitude, np.mod(phase_difference, 2 * np.pi))
        if np.any((o < self._range[0] - 1e-9) | (o > self._range[1] + 1e-9)):
            raise ParameterError(
                f"offset goes from {o.min():.4g} to {o.max():.4g} rad: the map of motions has "
                f"those from {self._range[0]:.4g} to {self._range[1]:.4g}."
            )
        r = (a / self._largest) ** 2
        c0, c1 = (np.stack([f.ev(o, p) for f in part], axis=-1) for part in self._splines)
        out = r[..., None] * (c0 + c1 * r[..., None])
        return out if self.slips else out * np.array((0.0, 1.0, 1.0))

    def poses(self, gait: Schedule, time: Array, start: Array) -> Array:
        """Poses (n, 3) at rising times (n,) from zero on, by the twists of the moment.

        Args:
            gait: of two legs with one offset.
            time: [s].
            start: pose at time zero (3,).
        """
        if gait.n_legs != 2 or gait.levels.shape[1] != 3:
            raise ModelError("a unicycle takes schedules of two legs, each a single sine.")
        pose, now, out = np.asarray(start, dtype=float), 0.0, []
        for t in np.asarray(time, dtype=float).tolist():
            n = max(1, int(np.ceil((t - now) * self.angular_frequency / 2.0)))
            for i in range(n):  # on a circle in each piece, by the twist of its middle
                length = (t - now) / n
                twist = self._at(gait, now + (i + 0.5) * length)
                rolled = self._leant(gait, now + (i + 1) * length) - self._leant(
                    gait, now + i * length
                )
                middle = pose[2] + 0.5 * length * twist[2]
                c, s = np.cos(middle), np.sin(middle)
                pose = move(pose, twist, np.asarray(length))
                pose[:2] += c * rolled[0] - s * rolled[1], s * rolled[0] + c * rolled[1]
            out.append(pose)
            now = t
        return np.array(out).reshape(-1, 3)

    def _leant(self, gait: Schedule, time: float) -> Array:
        """How far the lean of an instant has rolled the body along its axes (2,)."""
        offset = gait.coefficients(time).offset.mean()
        return np.asarray(self._lean(np.clip(offset, *self._range)))

    def _at(self, gait: Schedule, time: float) -> Array:
        _, offset, sine, cosine = gait.coefficients(time)
        swing = sine[0] + 1j * cosine[0]
        both = float(np.sqrt(np.abs(swing).prod()))
        if both < 1e-12:
            return np.zeros(3)
        lead = float(np.angle(swing[1] / swing[0]))
        return self.twist(float(np.clip(offset.mean(), *self._range)), both, lead)

    def compared(self, gait: Schedule, trajectory: Trajectory | None = None) -> UnicycleRun:
        """How far it is from the model that does a schedule from rest to rest.

        Args:
            gait: see `poses`.
            trajectory: the model's run of it from rest; simulated unless given.
        """
        model = self.model
        period = 2 * np.pi / gait.angular_frequency
        if trajectory is None:
            rest = rest_of(model, gait.rest)
            trajectory = simulate(
                model, gait, gait.duration + rest.settling, period / _PER_CYCLE, start="rest",
                euler=rest.euler, method="momentum",
            )  # fmt: skip
        means = cycle_means(trajectory, period)[::_PER_CYCLE]
        time, robot = means[:, 0], means[:, 1:]
        start = np.array((*trajectory.position[0], trajectory.euler[0, 2]))
        mine = self.poses(gait, time, start)
        away = np.linalg.norm(robot[:, :2] - mine[:, :2], axis=1)
        return UnicycleRun(
            time, robot, mine, float(np.linalg.norm(np.diff(robot[:, :2], axis=0), axis=1).sum()),
            float(away.max()), float(np.abs(robot[:, 2] - mine[:, 2]).max()),
        )  # fmt: skip
