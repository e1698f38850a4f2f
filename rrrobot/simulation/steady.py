"""What a settled gait does per cycle: speed, yaw rate, curvature, amplitudes, phases.

Over whole cycles of period T that begin at multiples of T, after the motion has settled, with m_i
the mean of a quantity over cycle i,

    speed      v     = mean of |m_{i+1} - m_i| / T      of the contact point
    yaw rate   alpha = mean of (m_{i+1} - m_i) / T      of the yaw angle
    curvature  K     = alpha / v

Where the body turns over, Euler angles are no heading: alpha is then the rate at which the path
turns, that of the direction of m_{i+1} - m_i, or where that is not defined that of the body's net
rotation in a cycle, if it is about the vertical; both up to whole turns in a cycle. What rests on
Euler angles (velocity, amplitude, phase, mean) is NaN.

Means are exact integrals of a quintic spline through the samples.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any, Protocol

import numpy as np

from rrrobot.checks import Array, finite
from rrrobot.errors import ParameterError
from rrrobot.inline import aligned, html_table, oscillation, percent
from rrrobot.results import SETTLED, STILL
from rrrobot.rotations import quaternion_from_euler, turns_over


class Motion(Protocol):
    """What a steady state is measured of; a `Trajectory` is one."""

    @property
    def time(self) -> Array:
        """(n,) [s]"""

    @property
    def position(self) -> Array:
        """contact point (n, 2) [m]"""

    @property
    def euler(self) -> Array:
        """roll, pitch, yaw without jumps (n, 3) [rad]"""

    @property
    def period(self) -> float | None:
        """of the gait [s]"""


MIN_SAMPLES_PER_CYCLE = 24
_HARMONIC_POINTS = 128
_STEEP = 0.5 * np.pi - 0.02
"""Pitch above which a body is taken to tumble [rad]."""
_SPREAD = 0.05
"""Angle by which the rotations of single cycles may differ from a common one about z [rad]."""
_MOST_SAMPLES = 4000


@dataclass(frozen=True, kw_only=True, eq=False)
class SteadyState:
    """Cycle means and first harmonics of a settled motion.

    Angles are roll, pitch, yaw in this order; each is about mean + amplitude sin(omega t + phase)
    plus the drift, with omega = 2 pi / period and t the trajectory's time, so that phases compare
    with those of the gait.

    Attributes:
        speed: v [m/s], zero or more.
        velocity: mean velocity along the body's mean x and y axes (2,) [m/s]; y is the leg axis.
        yaw_rate: alpha [rad/s], positive to the left.
        amplitude: of the first harmonic (3,) [rad].
        phase: of the first harmonic, in (-pi, pi] (3,) [rad].
        mean: angle in the middle of the counted time (3,) [rad].
        period: of a cycle [s].
        after: time of the first counted cycle [s].
        cycles: number of counted cycles.
        variation: largest deviation of one cycle's step, as seen from the mean heading of that
            cycle, from the mean of these; over the mean length of a step (or over 50 um if that is
            more). Small means settled.
        net_rotation: of a cycle, R_world_body after it times its inverse before it, as a rotation
            vector in the world (3,) [rad]; about z for a motion that repeats. With the step of the
            contact point it is the screw of the cycle. The mean over the counted cycles.
        tumbles: whether the body turns over, so that Euler angles say nothing; `reason` says what
            is NaN for it.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> state = rr.simulate(model, rr.gait("circular"), duration=30.0).steady_state()
        >>> round(1 / state.curvature, 2)  # radius of the path [m]
        0.32
    """

    speed: float
    velocity: Array
    yaw_rate: float
    amplitude: Array
    phase: Array
    mean: Array
    period: float
    after: float
    cycles: int
    variation: float
    net_rotation: Array = field(default_factory=lambda: np.full(3, np.nan))
    tumbles: bool = False

    @property
    def curvature(self) -> float:
        """K = yaw_rate / speed [1/m]; infinite for a turn on the spot, zero if nothing moves."""
        if self.speed > 1e-12:
            return self.yaw_rate / self.speed
        return math.copysign(math.inf, self.yaw_rate) if abs(self.yaw_rate) > 1e-12 else 0.0

    @property
    def reason(self) -> str | None:
        """Why some of the numbers are NaN; None if none is."""
        if not self.tumbles:
            return None
        told = (
            "the body turns over, so that Euler angles are no heading: velocity, amplitude, phase "
            "and mean are NaN, and the yaw rate is that of the path"
        )
        if math.isnan(self.yaw_rate):
            told += ", which is NaN too, as the path says none (fewer than 3 cycles, or no way)"
        return f"{told}."

    @property
    def pitch_yaw_phase_difference(self) -> float:
        """Phase of the pitch minus that of the yaw, in (-pi, pi] [rad]."""
        return float(-((self.phase[2] - self.phase[1] + np.pi) % (2 * np.pi) - np.pi))

    @property
    def settled(self) -> bool:
        """Whether single cycles differ by no more than 5 %, so that the means are a steady state.

        Else the speed is a mean of something that changes: take `mean_travel` and its `spread`.
        """
        return self.variation <= SETTLED

    @property
    def mean_travel(self) -> float:
        """|velocity|, by which the robot gets away [m/s]; of a body that tumbles, the speed."""
        return self.speed if self.tumbles else float(np.linalg.norm(self.velocity))

    @property
    def spread(self) -> float:
        """How far the velocity over a single cycle is from the mean one, at most [m/s]."""
        return self.variation * max(self.speed, STILL / self.period)

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data, for JSON."""
        names = ("curvature", "reason", "settled", "mean_travel", "spread")
        data = asdict(self) | {name: getattr(self, name) for name in names}
        return {key: _plain(value) for key, value in data.items()}

    def __str__(self) -> str:
        return aligned(self._rows())

    def _repr_html_(self) -> str:
        return html_table("Steady state", self._rows())

    def _rows(self) -> list[tuple[str, str]]:
        every = zip(("roll", "pitch", "yaw"), self.amplitude, self.phase, self.mean, strict=True)
        moves = [("speed", f"{1000 * self.speed:.4f} mm/s")]
        if not self.settled:
            travel = f"{1000 * self.mean_travel:.4f} +- {1000 * self.spread:.4f} mm/s"
            moves = [("NOT SETTLED", "means of cycles that differ"), ("mean travel", travel)]
        return [
            *moves,
            ("yaw rate", f"{np.rad2deg(self.yaw_rate) + 0.0:.4f} deg/s"),
            ("curvature", f"{self.curvature + 0.0:.4g} 1/m"),
            *(
                (axis, oscillation(amplitude, phase, mean))
                for axis, amplitude, phase, mean in every
            ),
            ("counted", f"{self.cycles} cycles of {self.period:.4g} s from {self.after:.4g} s"),
            ("steps vary by", percent(self.variation)),
        ]


def steady_state(
    trajectory: Motion, *, after: float | None = None, period: float | None = None
) -> SteadyState:
    """Steady state of a trajectory; see the module for the definitions.

    Args:
        trajectory: sampled at least 24 times per cycle.
        after: counted cycles begin at the first multiple of the period from here on [s]; the
            middle of the run by default.
        period: of a cycle [s]; the gait's by default.

    Raises:
        ParameterError: no period, too few cycles after `after`, too few samples per cycle.
    """
    from scipy.interpolate import make_interp_spline

    time = trajectory.time
    duration = float(time[-1])
    if period is None:
        period = trajectory.period
    if period is None:
        raise ParameterError(
            "the gait has no period, so a steady state has no cycle: give period= in seconds."
        )
    period = finite("period", period, "s", above=0)
    middle = 0.5 * float(time[0] + time[-1])
    after = finite("after", middle if after is None else after, "s", at_least=0)
    after = max(after, float(time[0]))
    # On a curved path the cycle mean depends on where in the gait a cycle begins (circular gait:
    # 2e-4 of the speed), so cycles begin at whole multiples of the period.
    after = period * math.ceil(after / period - 1e-9)
    cycles = math.floor((duration - after) / period + 1e-9)
    if cycles < 2:
        raise ParameterError(
            f"only {max(cycles, 0)} whole cycles of {period:.4g} s fit between {after:.4g} s and "
            f"{duration:.4g} s: a steady state needs 2. Simulate longer, or count from an earlier "
            "time (after=)."
        )
    spacing = float(np.diff(time).max())
    if period / spacing < MIN_SAMPLES_PER_CYCLE - 1e-6:
        raise ParameterError(
            f"the trajectory has {period / spacing:.3g} samples per cycle: a steady state needs "
            f"{MIN_SAMPLES_PER_CYCLE}. Simulate with sample_interval <= "
            f"{period / MIN_SAMPLES_PER_CYCLE:.4g} s."
        )
    motion = np.column_stack((trajectory.position, trajectory.euler))
    inside = np.flatnonzero(time >= after - 8 * spacing)
    spline = make_interp_spline(time[inside], motion[inside], k=5)
    edges: Array = after + period * np.arange(cycles + 1, dtype=np.float64)
    means = np.diff(spline.antiderivative()(edges), axis=0) / period
    steps = np.diff(means, axis=0) / period
    lengths = np.linalg.norm(steps[:, :2], axis=1)
    speed = float(lengths.mean())
    floor = max(speed, STILL / period)
    drift = steps.mean(axis=0)
    middle = 0.5 * (edges[0] + edges[-1])
    net, upright = _net_rotation(time, trajectory.euler, edges)
    if _tumbles(trajectory.euler, time, edges, float(drift[4]) * period):
        nothing = np.full(3, np.nan)
        turn = _turn(steps[:, :2], lengths)
        ahead: Array = turn * np.arange(cycles - 1, dtype=np.float64)
        if math.isnan(turn):
            turn = float(net[2]) if upright else math.nan
            ahead = np.arctan2(steps[:, 1], steps[:, 0])
        return SteadyState(
            speed=speed,
            velocity=nothing[:2],
            yaw_rate=turn / period,
            amplitude=nothing,
            phase=nothing,
            mean=nothing,
            period=period,
            after=after,
            cycles=cycles,
            variation=_deviation(_seen_from(ahead, steps)) / floor,
            net_rotation=net,
            tumbles=True,
        )
    grid = np.linspace(edges[0], edges[-1], _HARMONIC_POINTS * cycles, endpoint=False)
    angles = spline(grid)[:, 2:] - np.outer(grid - middle, drift[2:])
    omega = 2 * np.pi / period
    sine, cosine = (2 * (f(omega * grid) @ angles) / grid.size for f in (np.sin, np.cos))
    heading = means[:, 4]
    along = _seen_from(0.5 * (heading[1:] + heading[:-1]), steps)
    return SteadyState(
        speed=speed,
        velocity=along.mean(axis=0),
        yaw_rate=float(drift[4]),
        amplitude=np.hypot(sine, cosine),
        phase=np.arctan2(cosine, sine),
        mean=means.mean(axis=0)[2:],
        period=period,
        after=after,
        cycles=cycles,
        variation=_deviation(along) / floor,
        net_rotation=net,
    )


def _seen_from(heading: Array, steps: Array) -> Array:
    """Steps in the plane (n, 2) along and across headings (n,) [rad]."""
    c, s = np.cos(heading), np.sin(heading)
    x, y = steps[:, 0], steps[:, 1]
    return np.column_stack((c * x + s * y, c * y - s * x))


def _deviation(steps: Array) -> float:
    """Of one step from the mean, at most."""
    return float(np.linalg.norm(steps - steps.mean(axis=0), axis=1).max())


def _tumbles(euler: Array, time: Array, edges: Array, turn: float) -> bool:
    """Whether the body turns over in the counted cycles; `turn` is the yaw of one [rad]."""
    counted = euler[(time >= edges[0] - 1e-9) & (time <= edges[-1] + 1e-9)]
    if bool(np.any(np.abs(counted[:, 1]) > _STEEP)):
        return True
    # Few samples of each cycle are enough, and all cycles count: a body may turn over slowly.
    if abs(counted[-1, 0] - counted[0, 0]) >= np.pi:
        return True
    return bool(turns_over(_up(counted[:_MOST_SAMPLES]), turn))


def _up(euler: Array) -> Array:
    """Vertical in the body frame (n, 3)."""
    (sr, sp, _), (cr, cp, _) = np.sin(euler).T, np.cos(euler).T
    return np.column_stack((-sp, sr * cp, cr * cp))


def _net_rotation(time: Array, euler: Array, edges: Array) -> tuple[Array, bool]:
    """Mean rotation vector of a cycle in the world (3,) [rad], and whether each is this, about z.

    R_world_body after the cycle times its inverse before it.
    """
    from scipy.interpolate import make_interp_spline
    from scipy.spatial.transform import Rotation

    quaternion = quaternion_from_euler(euler)
    flips = np.cumprod(np.where(np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0, -1.0, 1.0))
    quaternion[1:] *= flips[:, None]
    at = Rotation.from_quat(make_interp_spline(time, quaternion, k=5)(edges))
    net = at[1:] * at[:-1].inv()
    vectors = net.mean().as_rotvec()
    spread = float((net * Rotation.from_rotvec(vectors).inv()).magnitude().max())
    return vectors, max(spread, float(np.hypot(vectors[0], vectors[1]))) < _SPREAD


def _turn(steps: Array, lengths: Array) -> float:
    """Mean angle by which the path turns from one cycle's step to the next [rad].

    NaN where it is not defined: fewer than three cycles, or a body that stays where it is.
    """
    if len(steps) < 2 or lengths.min() < 1e-9:
        return math.nan
    x, y = steps.T
    turns = np.arctan2(x[:-1] * y[1:] - y[:-1] * x[1:], x[:-1] * x[1:] + y[:-1] * y[1:])
    return float(turns.mean())


def _plain(value: Any) -> Any:
    """Arrays as lists, and None for what is no number, which JSON has no word for."""
    if isinstance(value, np.ndarray):
        return [_plain(part) for part in value.tolist()]
    return None if isinstance(value, float) and not math.isfinite(value) else value
