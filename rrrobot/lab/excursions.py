"""Motions beside the settled one: pushed, left to rock, driven by torques, sent to a place."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait, StillLegs
from rrrobot.drive.laws import MotionState
from rrrobot.drive.torques import LegTorques
from rrrobot.errors import RRRobotError
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.outcome import Outcome, Refusal, forces, short
from rrrobot.robot.robot import Robot
from rrrobot.simulation.run import simulate
from rrrobot.simulation.steady import steady_state
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.steering.planner import plan

_SHORTEST, _LONGEST = 4.0, 20.0
"""Of a motion after a push [s]."""
_ROCKING, _DRIVEN = 10.0, 4.0
_SAMPLES = 36


def pushed(given: Robot, outcome: Outcome, push: Sequence[float]) -> Outcome:
    """The settled motion after a push that adds to the rates of roll, pitch and yaw (3,) [rad/s].

    Raises:
        Refusal: the motion does not repeat, or the push tips the robot over.
    """
    cycle = outcome.cycle
    if cycle is None:
        raise Refusal("A push is shown where the motion repeats.")
    lasts = 6.0 * float(np.max(cycle.settling_times, initial=0.0))
    period = cycle.period
    laps = math.ceil(min(max(lasts, _SHORTEST), _LONGEST) / period)

    def run() -> Trajectory:
        return simulate(
            cycle.model, cycle.gait, laps * period, period / _SAMPLES, method="momentum",
            euler=cycle.euler, start=cycle.euler_rates + np.asarray(push, dtype=float),
        )  # fmt: skip

    words = (
        f"Pushed by {np.rad2deg(push).round(1).tolist()} deg/s about roll, pitch, yaw. Its slowest "
        f"deviation falls to 1/e in {float(np.max(cycle.settling_times)):.3g} s.",
    )
    return of_run(outcome.knobs, run, words)


def rocking(given: Robot, knobs: Knobs, tilt: Sequence[float]) -> Outcome:
    """Let go at a roll and a pitch (2,) [rad], the legs held at their offsets."""

    def run() -> Trajectory:
        return simulate(
            knobs.model(given), StillLegs(knobs.offset), _ROCKING, 0.02, method="momentum",
            start="rest", euler=(*tilt, 0.0),
        )  # fmt: skip

    roll, pitch = np.rad2deg(tilt)
    words = (f"Let go at a roll of {roll:.3g} and a pitch of {pitch:.3g} deg, the legs held.",)
    return of_run(knobs, run, words)


def driven(
    given: Robot,
    knobs: Knobs,
    stiffness: float,
    damping: float,
    overtaken: Callable[[], bool] = lambda: False,
) -> Outcome:
    """Motors that pull the legs after the gait by torques.

    tau = stiffness (phi_gait - phi) + damping (phi_dot_gait - phi_dot)

    Args:
        given, knobs: as for `settle`.
        stiffness: [N m/rad].
        damping: [N m s/rad].
        overtaken: whether the run is to end, as something else is asked for.
    """
    gait = knobs.gait()
    begin = gait(0.0)
    motors = LegTorques(
        _following(gait, stiffness, damping), angle=begin.angle, rate=begin.rate, feedback=True
    )
    laps = max(4, round(_DRIVEN / (2 * math.pi / knobs.frequency)))
    period = 2 * math.pi / knobs.frequency

    def watch(*_: float) -> None:
        if overtaken():
            raise KeyboardInterrupt

    def run() -> Trajectory:
        model = knobs.model(given)
        return simulate(model, motors, laps * period, period / _SAMPLES, progress=watch)

    words = (f"Driven by torques: {stiffness:g} N m/rad, {damping:g} N m s/rad.",)
    return of_run(knobs, run, words, period=period)


def _following(gait: Gait, stiffness: float, damping: float) -> Callable[[MotionState], Array]:
    def torque(state: MotionState) -> Array:
        wanted = gait(state.time)
        return np.asarray(
            stiffness * (wanted.angle - state.leg_angle) + damping * (wanted.rate - state.leg_rate)
        )

    return torque


def sent(given: Robot, knobs: Knobs, pose: Sequence[float]) -> Outcome:
    """Planned from rest at the origin to rest at (x, y, heading) (3,) [m, m, rad], and driven."""

    def run() -> Trajectory:
        found = plan(
            knobs.model(given), pose, amplitude=max(0.1, *knobs.amplitude),
            angular_frequency=knobs.frequency, progress=False,
        )  # fmt: skip
        return found.execute(method="momentum", sample_interval=0.02)

    x, y, heading = pose
    words = (f"Planned to ({x:.3g}, {y:.3g}) m, heading {np.rad2deg(heading):.3g} deg.",)
    made = of_run(knobs, run, words)
    end = made.trajectory
    off = float(np.hypot(*(end.position[-1] - np.asarray(pose[:2]))))
    turned = (end.euler[-1, 2] - heading + math.pi) % (2 * math.pi) - math.pi
    reached = f"It arrives {1e3 * off:.2g} mm and {np.rad2deg(abs(turned)):.2g} deg off."
    return replace(made, words=(*made.words, reached))


def of_run(
    knobs: Knobs,
    run: Callable[[], Trajectory],
    words: tuple[str, ...],
    *,
    period: float | None = None,
) -> Outcome:
    """An outcome of a run; its speed and yaw rate are those of its second half, as means."""
    # Long: it holds no lock, so that nobody waits for it, and its warnings go where they go.
    try:
        t = run()
    except RRRobotError as error:
        raise Refusal(short(error)) from None
    if t.lift_off_time is not None:
        raise Refusal(f"The robot lifts off after {t.lift_off_time:.3g} s.")
    half = len(t) // 2
    lasts = float(t.time[-1] - t.time[half])
    speed = float(np.linalg.norm(t.position[-1] - t.position[half])) / lasts
    yaw_rate = float(t.euler[-1, 2] - t.euler[half, 2]) / lasts
    if period is not None:
        state = steady_state(t, period=period)
        speed, yaw_rate = state.speed, state.yaw_rate
    found = forces(t)
    return Outcome(
        friction=found["friction"], torque=found["torque"], knobs=knobs, trajectory=t,
        screw=None, horizon=knobs.horizon, speed=speed, yaw_rate=yaw_rate,
        normal_force=float(t.normal_force.min()),
        multipliers=np.empty(0, dtype=np.complex128), settled=False, words=words,
    )  # fmt: skip
