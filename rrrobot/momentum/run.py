"""One simulation by the momentum engine: prescribed legs, periodic or not, tabulated as it runs."""

from __future__ import annotations

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait
from rrrobot.errors import GaitError
from rrrobot.integrate import Dense, Integration, Observer, Progress, Watch
from rrrobot.models.base import Model
from rrrobot.models.terms import Placement
from rrrobot.momentum.batch import ROWS_PER_STEP, Setting, lower, march, stage_times
from rrrobot.momentum.coefficients import N_COEFFICIENTS, fill
from rrrobot.momentum.kernels import ANY, N_STAGES
from rrrobot.rotations import euler_from_quaternion, euler_rates

_SYMMETRIC = np.array(((3, 6, 7), (6, 4, 8), (7, 8, 5)))
"""Where the entries of I stand among the coefficients."""
_CHUNK = 500
"""Steps that are tabulated at a time."""


def run(
    model: Model,
    gait: Gait,
    y0: Array,
    times: Array,
    longest: float,
    *,
    observer: Observer,
    watch: Watch | None = None,
    progress: Progress | None = None,
    lane: Array | None = None,
) -> tuple[Integration, Array | None]:
    """Integrate a model's state by its contact momentum; the result is that of `integrate`.

    With it comes the engine's own state at the end, None after an early stop. As `lane` it lets
    another run go on to the last bit.

    Every sample interval is divided into equal steps of DOP853, none longer than `longest` [s].
    States within a step, where `watch` looks for events, are those of a shorter step to there.

    Raises:
        ModelError: the engine does not know the model, its damping, its shell or its ground.
        GaitError: the gait is not finite somewhere.
    """
    setting = lower(model)
    pieces = np.maximum(1, np.ceil(np.diff(times) / longest - 1e-9).astype(int))
    states = np.empty((times.size, y0.size))
    states[0] = y0
    observer.sampled(0, states[:1])
    if lane is None:
        lane = _lane(model, setting, gait, y0, times[0])
    filled, steps, stop, interrupted = 1, 0, None, False
    hit: float | None = None
    try:
        while filled < times.size and stop is None and hit is None:
            last = filled
            while last < times.size and pieces[filled - 1 : last].sum() < _CHUNK:
                last += 1
            last = max(last, filled + 1)
            marks = np.cumsum(pieces[filled - 1 : last - 1])
            history = _march(setting, model, gait, lane, times[filled - 1 : last], marks)
            bad = np.flatnonzero(~np.all(np.isfinite(history), axis=1))
            failure = None
            if bad.size:
                failure = (
                    "the state is not finite (the pitch came to +-90 degrees, or the step is long)"
                )
                marks = marks[marks < bad[0]]
            found = _model_states(
                model, setting, gait, history[marks], times[filled : filled + len(marks)]
            )
            if watch is not None:
                for i, mark in enumerate(marks):
                    k = filled + i
                    lanes = history[mark - pieces[k - 1] : mark]
                    hit, found[i] = _watched(
                        watch, setting, model, gait, lanes, times[k - 1 : k + 1], found[i]
                    )
                    if hit is not None:
                        times, found = np.append(times[:k], hit), found[: i + 1]
                        break
            if len(found):
                observer.sampled(filled, found)
                halt = observer.stepped(found)
                if halt is not None:
                    found, (_, stop) = found[: halt[0] + 1], halt
                states[filled : filled + len(found)] = found
                filled += len(found)
            stop = stop or failure
            lane = history[-1]
            steps += int(marks[-1]) if marks.size else 0
            if progress is not None:
                progress(float(times[filled - 1]))
    except KeyboardInterrupt:
        stop, interrupted = "the simulation was interrupted", True
    done = Integration(
        times[:filled], states[:filled], float(times[filled - 1]), states[filled - 1],
        steps * N_STAGES, stop, interrupted, hit is not None,
    )  # fmt: skip
    return done, lane if stop is None and hit is None else None


def _watched(
    watch: Watch, setting: Setting, model: Model, gait: Gait, lanes: Array, interval: Array,
    end: Array,
) -> tuple[float | None, Array]:  # fmt: skip
    """The time of an event that ends the run within a sample interval, and the state there.

    Args:
        lanes: engine states at the beginnings of the interval's steps (n, N_STATE).
        interval: its begin and end (2,) [s].
        end: the state at its end, which is returned if nothing ends the run.
    """
    nodes = np.linspace(interval[0], interval[1], len(lanes) + 1)
    for lane, first, last in zip(lanes, nodes, nodes[1:], strict=False):
        dense = _within(setting, model, gait, lane, float(first))
        hit = watch.step(float(first), float(last), dense)
        if hit is not None:
            return hit, dense(np.array((hit,)))[0]
    return None, end


def _within(setting: Setting, model: Model, gait: Gait, lane: Array, start: float) -> Dense:
    """Model states at times after an engine state, by one step to each."""

    def dense(times: Array) -> Array:
        one = np.array((1,))
        rows = [
            lane
            if t == start
            else _march(setting, model, gait, lane, np.array((start, t)), one)[-1]
            for t in times
        ]
        return _model_states(model, setting, gait, np.array(rows), times)

    return dense


def _march(
    setting: Setting, model: Model, gait: Gait, lane: Array, times: Array, marks: Array
) -> Array:
    """States of the one lane after each step over the sample intervals (steps + 1, N_STATE)."""
    counts = np.diff(marks, prepend=0).astype(int)
    lengths = np.repeat(np.diff(times) / counts, counts)
    rows = [
        stage_times(start, (end - start) / n, n)[: n * ROWS_PER_STEP]
        for start, end, n in zip(times, times[1:], counts, strict=False)
    ]
    instants = np.append(np.concatenate(rows), times[-1])
    table = _coefficients(setting, gait, instants)
    return march(setting, table[:, :, None], lengths, lane[None])[:, 0]


def _coefficients(setting: Setting, gait: Gait, instants: Array) -> Array:
    motion = gait(instants)
    if not (np.all(np.isfinite(motion.angle)) and np.all(np.isfinite(motion.rate))):
        bad = ~np.all(np.isfinite(motion.angle) & np.isfinite(motion.rate), axis=1)
        raise GaitError(f"the gait is not finite at t = {instants[bad][0]:.6g} s.")
    table = np.empty((len(instants), N_COEFFICIENTS))
    angle, rate = np.ascontiguousarray(motion.angle), np.ascontiguousarray(motion.rate)
    fill(setting.tree, angle, rate, table)
    return table


def _inertia(setting: Setting, c: Array, s: Array) -> tuple[Array, Array]:
    """I_P (n, 3, 3) about the pivot and the legs' own K (n, 3), for states with that s (n, 3)."""
    mass, mc = setting.parameters[0], c[:, :3]
    inertia = c[:, _SYMMETRIC]
    whole = 2 * np.sum(s * mc, axis=1) + mass * np.sum(s * s, axis=1)
    inertia += whole[:, None, None] * np.eye(3)
    cross = s[:, :, None] * mc[:, None, :]
    inertia -= cross + cross.transpose(0, 2, 1) + mass * s[:, :, None] * s[:, None, :]
    return inertia, c[:, 12:15] + np.cross(s, c[:, 9:12])


def _lane(model: Model, setting: Setting, gait: Gait, y0: Array, time: float) -> Array:
    """Engine state (N_STATE,) of a model's state vector."""
    pose, quasi, _ = model.split(y0)
    place = model.place(pose)
    c = _coefficients(setting, gait, np.array([time]))
    if setting.axis == ANY:
        s, position = _from_contact(place), pose[4:]
    else:
        s, position = setting.parameters[1] * place.rotation[2], place.position
    inertia, own = _inertia(setting, c, s[None])
    momentum = inertia[0] @ model.body_velocity(place, quasi) + own[0]
    if setting.axis >= 0:
        # Along locked axes the guides hold whatever momentum there is.
        momentum[np.arange(3) != setting.axis] = 0.0
    yaw = euler_from_quaternion(place.quaternion)[2]
    return np.concatenate((place.quaternion, momentum, position, [yaw]))


def _from_contact(place: Placement) -> Array:
    """s, from the contact to the base's origin in the base (3,); the basis holds -[s]."""
    return np.array((place.basis[1, 2], place.basis[2, 0], place.basis[0, 1]))


def _model_states(model: Model, setting: Setting, gait: Gait, lanes: Array, times: Array) -> Array:
    """Model's state vectors (n, ny) of engine states (n, N_STATE)."""
    quaternion = lanes[:, :4] / np.linalg.norm(lanes[:, :4], axis=1, keepdims=True)
    if setting.axis == ANY:
        poses = np.column_stack((quaternion, lanes[:, 7:9]))
        s = np.array([_from_contact(model.place(pose)) for pose in poses]).reshape(-1, 3)
    else:
        x, y, z, w = quaternion.T
        up = np.column_stack((2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))
        s = setting.parameters[1] * up
    inertia, own = _inertia(setting, _coefficients(setting, gait, times), s)
    free = lanes[:, 4:7] - own
    if setting.axis >= 0:
        a = setting.axis
        omega: Array = np.zeros((len(lanes), 3))
        omega[:, a] = free[:, a] / inertia[:, a, a]
    else:
        omega = np.asarray(np.linalg.solve(inertia, free[:, :, None]))[:, :, 0]
    if model.name == "full":
        return np.column_stack((quaternion, lanes[:, 7:9], omega))
    euler = euler_from_quaternion(quaternion)
    # The turns that the quaternion does not count.
    euler[:, 2] += 2 * np.pi * np.round((lanes[:, 9] - euler[:, 2]) / (2 * np.pi))
    rates = euler_rates(euler, omega)
    states = np.empty((len(lanes), model.n_pose + model.n_quasi))
    for i in range(len(lanes)):
        pose = model.make_pose(euler[i], lanes[i, 7:9])
        states[i] = np.concatenate((pose, model.quasi_from_euler_rates(pose, rates[i])))
    return states
