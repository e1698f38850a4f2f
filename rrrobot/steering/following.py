"""Feedback: a path is followed by steering once in each leg cycle, from the measured pose.

With the cross-track distance e (left is positive), the course error c between the direction of
travel and the path's, the path's curvature k and the speed v, the yaw rate that is asked for is

    w = v (k cos c / (1 - k e)) - a v e - b c,        e'' + b e' + a v^2 e = 0 near the path.

What the robot does besides what its map says, from wrong masses, damping or a slope, is estimated
as a constant yaw rate and a constant angle of travel, and taken out.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.schedule import Schedule
from rrrobot.errors import ParameterError
from rrrobot.models.base import Model
from rrrobot.progress import Progress, checked_progress, progress_of
from rrrobot.steering.arcs import move
from rrrobot.steering.gears import Drive, Gear
from rrrobot.steering.motions import motions_of
from rrrobot.steering.robots import Driven, Sensor
from rrrobot.steering.tracks import Track

_STIFFNESS, _DAMPING = 0.08, 0.5
"""a v^2 [1/s^2] and b [1/s] of the error's equation."""
STEERED = ("forward", "backward")
"""Gears that answer within a cycle; sideways a turn of the offset takes longer to act."""
_LEARN = 0.06
"""Share of a surprise in a cycle that is taken for lasting."""
_JUMP, _PATIENCE = 0.08, 3
"""Distance from where the robot is expected that is no measurement [m], and cycles without one
until the legs are stopped."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Following:
    """A path that was followed.

    Attributes:
        track: the path.
        gait: what the legs did, as a schedule.
        time: middle of each cycle (n,) [s].
        mean: true mean pose of each cycle (n, 3) [m, m, rad].
        error: its distance from the path, positive to the left (n,) [m].
        settled: from which cycle on the robot was on the path.
        stopped: why the legs were stopped early, or None.
        start: where it rested (3,); with it the gait's simulation is the same run.
        end: where the robot is at last (3,).
    """

    track: Track = field(repr=False)
    gait: Schedule
    time: Array = field(repr=False)
    mean: Array = field(repr=False)
    error: Array = field(repr=False)
    settled: int
    stopped: str | None
    start: Array
    end: Array

    @property
    def rms(self) -> float:
        """Root of the mean squared error once on the path [m]."""
        late = self.error[self.settled :]
        return float(np.sqrt(np.mean(late**2))) if late.size else float("nan")

    def plot(self, ax: Any = None) -> Any:
        """Draw the path and the robot's way on matplotlib axes; returns them."""
        from rrrobot.steering.plots import following_panel

        return following_panel(self, ax)

    def to_dict(self) -> dict[str, Any]:
        """Numbers as plain data, without the samples."""
        late = self.error[self.settled :]
        return {
            "duration": float(self.gait.duration),
            "cycles": len(self.time),
            "rms": self.rms,
            "largest": float(np.abs(late).max()) if late.size else None,
            "stopped": self.stopped,
            "start": self.start.tolist(),
            "end": self.end.tolist(),
        }


class _Estimate:
    """Where the robot is, and what it does besides what the map says."""

    def __init__(self, start: Array) -> None:
        self.pose, self.twists = start.copy(), [np.zeros(3)]
        self.yaw_rate, self.course = 0.0, 0.0
        self.last: Array | None = None
        self.missed = 0

    def twist(self, drive: Drive) -> Array:
        """What a gait is expected to do (3,)."""
        c, s = np.cos(self.course), np.sin(self.course)
        u, v, w = drive.twist
        return np.array((c * u - s * v, s * u + c * v, w + self.yaw_rate))

    def see(self, seen: Array | None, delay: int, period: float) -> None:
        """Take a cycle's mean pose in that ended `delay` cycles ago."""
        if seen is None:
            return
        # From the middle of that cycle to now.
        now = seen.copy()
        past = self.twists[-(delay + 1) :]
        for i, twist in enumerate(past):
            now = move(now, twist, np.asarray(period * (0.5 if i == 0 else 1.0)))
        off = float(np.hypot(*(now - self.pose)[:2]))
        if not np.all(np.isfinite(now)) or off > _JUMP:
            self.missed += 1
            self.last = None
            return
        self.missed = 0
        if self.last is not None:
            way = seen - self.last
            expected = self.twists[-(delay + 2) :][:2]
            turn = 0.5 * period * sum(float(t[2]) for t in expected)
            self.yaw_rate += _LEARN * (way[2] - turn) / period
            size = float(np.hypot(way[0], way[1]))
            course = 0.5 * (self.last[2] + seen[2]) + np.arctan2(
                sum(t[1] for t in expected), sum(t[0] for t in expected)
            )
            if size > 0.3 * period * float(np.hypot(*expected[-1][:2])) > 0:
                slip = (np.arctan2(way[1], way[0]) - course + np.pi) % (2 * np.pi) - np.pi
                self.course += _LEARN * float(np.clip(slip, -0.5, 0.5))
        self.last = seen.copy()
        # The measurement is trusted as noise and rocking allow.
        self.pose = self.pose + 0.5 * (now - self.pose)

    def go(self, drive: Drive, period: float) -> None:
        twist = self.twist(drive)
        self.twists.append(twist)
        self.pose = move(self.pose, twist, np.asarray(period))


def follow(
    model: Model,
    track: Track,
    duration: float,
    *,
    truth: Model | None = None,
    start: ArrayLike | None = None,
    gear: str = "forward",
    speed: float | None = None,
    amplitude: float = 0.5,
    angular_frequency: float = 8.0,
    rest: ArrayLike | None = None,
    sensor: Sensor | None = None,
    store: bool = True,
    progress: Progress = False,
) -> Following:
    """Follow a path, steering once in each leg cycle from the measured mean pose.

    Args:
        model: what the controller believes; rolls, and the momentum engine knows it.
        track: the path.
        duration: after which the legs are stopped [s]; at the end of an open path before.
        truth: the robot that is driven, of any ground; the believed one unless given.
        start: (x, y, yaw) at rest; on the path, along it, unless given.
        gear: direction of travel in the body's axes: "forward" (x) or "backward".
        speed: [m/s]; 0.8 of the highest at the path's sharpest bend unless given.
        amplitude, angular_frequency, rest: as for `plan`.
        sensor: noise and delay of the measured pose; none unless given.
        store: whether the map of motions is kept in the user's cache folder.
        progress: see `rrrobot.progress`; in simulated seconds.

    Returns:
        the Following. Where measurements stop or jump, the legs come to rest smoothly and its
        `stopped` says why.

    Raises:
        ParameterError: a number out of range.
        ModelError: no gait of the robot travels, or it never rests.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.steering import Track, follow
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> run = follow(model, Track([(0, 0), (0.2, 0)]), duration=60.0)
        >>> run.rms < 0.005, run.stopped
        (True, None)
    """
    finite("duration", duration, "s", above=0)
    checked_progress(progress)
    if gear not in STEERED:
        raise ParameterError(f"gear is {gear!r}: a path is followed in {' or '.join(STEERED)}.")
    seer = Sensor() if sensor is None else sensor
    legs = np.full(2, np.pi / 2) if rest is None else vector("rest", rest, 2, "rad")
    motions = motions_of(
        model, amplitude=amplitude, angular_frequency=angular_frequency, store=store
    )
    box = Gear(motions, gear)
    first = track.nearest(track.points[0])
    bends = [track.nearest(p).curvature for p in track.points[:: max(1, len(track.points) // 200)]]
    sharp = float(np.clip(np.percentile(np.abs(bends), 95), 0, 0.8 * box.brisk[1]))
    fast = 0.8 * box.fastest(sharp) if speed is None else finite("speed", speed, "m/s", above=0)
    straight = box.drive(fast, first.curvature)
    begin = (
        np.array((*track.points[0], first.course - straight.course))
        if start is None
        else vector("start", start, 3, labels=("x", "y", "yaw"))
    )
    robot = Driven(truth or model, begin, legs, angular_frequency, seer)
    known = _Estimate(begin)
    along, stopped, period = first.along if start is None else None, None, robot.period
    cycles = int(np.ceil(duration / period))
    with progress_of(progress, "following", duration, "s") as tell:
        for number in range(cycles):
            known.see(robot.seen, seer.delay, period)
            if known.missed >= _PATIENCE:
                stopped = (
                    f"no measurement that makes sense for {known.missed} cycles, at "
                    f"{number * period:.4g} s: the pose is missing, or more than {_JUMP:g} m from "
                    "where the robot can be"
                )
                break
            near = track.nearest(known.pose[:2], along)
            along = near.along
            if not track.closed and track.length - along < 0.5 * fast * period:
                break
            drive = _steer(known, near, box, fast)
            robot.cycle(drive.offset, drive.amplitude, drive.phase_difference)
            known.go(drive, period)
            if tell is not None:
                tell(min((number + 1) * period, duration))
    driven = len(robot.means)
    robot.stand()
    for _ in range(int(np.ceil(robot.settling / period))):
        robot.stand()
    return _result(track, robot, driven, stopped, begin)


def _steer(known: _Estimate, near: Any, gear: Gear, speed: float) -> Drive:
    """The gait of the next cycle."""
    guess = gear.drive(speed, float(np.clip(near.curvature, *gear.brisk)))
    course = known.pose[2] + guess.course + known.course
    off = (course - near.course + np.pi) % (2 * np.pi) - np.pi
    bend = near.curvature * np.cos(off) / max(1.0 - near.curvature * near.aside, 0.3)
    pull = float(np.clip(_STIFFNESS / speed * near.aside, -0.8 * _DAMPING, 0.8 * _DAMPING))
    turn = speed * bend - pull - _DAMPING * float(np.clip(off, -1.2, 1.2))
    # Sharper bends than these it would creep round, and never end.
    return gear.drive(speed, float(np.clip((turn - known.yaw_rate) / speed, *gear.brisk)))


def _result(
    track: Track, robot: Driven, driven: int, stopped: str | None, start: Array
) -> Following:
    mean = np.array(robot.means[1:driven]).reshape(-1, 3)
    error, along = np.empty(len(mean)), None
    for i, pose in enumerate(mean):
        near = track.nearest(pose[:2], along)
        error[i], along = near.aside, near.along
    began = abs(track.nearest(start[:2]).aside) > 0.01
    settled = 0
    if began and error.size:
        settled = int(np.argmax(np.abs(error) < 0.01))
    return Following(
        track=track,
        gait=robot.schedule,
        time=np.asarray((np.arange(len(mean)) + 0.5) * robot.period, dtype=float),
        mean=mean,
        error=error,
        settled=settled,
        stopped=stopped,
        start=start,
        end=robot.pose,
    )
