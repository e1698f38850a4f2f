"""Torques, power and friction that a settled gait takes, from the motion of its last cycle.

The motion (z_body and the angular velocity) is periodic in the body's axes, and known at the
engine's steps. Trigonometric interpolation gives it at twice as many instants, where forces and
torques follow from the equations of motion; these are interpolated in turn, and their extremes are
polished on the interpolant.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits.batch import GaitBatch
from rrrobot.momentum.coefficients import LANES, N_COEFFICIENTS, LaneWork, fill_lanes, lane_work
from rrrobot.momentum.compiled import borrowed, compiled, inner
from rrrobot.momentum.forces import Bodies, bodies
from rrrobot.momentum.interpolation import between
from rrrobot.momentum.legs import checked, legs_at, turns_at
from rrrobot.momentum.loads import FRICTION, TORQUE, loads, n_signals
from rrrobot.momentum.lowering import Setting
from rrrobot.momentum.normal import N_ANY_MOTION
from rrrobot.robot.limits import CREEP

LOADS = ("normal_force", "friction", "rms_torque", "peak_torque", "power", "torque_share")
"""Least normal force [N]; largest friction coefficient that is needed, infinite if the normal force
is not positive, NaN of a pivoted model; root of the mean sum of squared motor torques; largest
|motor torque| of any leg [N m]; mean of the sum of |torque x rate| [W]; largest |motor torque| over
what the file allows, 0 where it limits none. Torques of a prismatic leg are forces [N]."""
_NEAR = 0.02
"""Local extremes that are this near to the largest, relative, are polished too."""
_PARTS = 8
_HALVINGS = 30


class Work(NamedTuple):
    """Room for one gait."""

    lanes: LaneWork
    bodies: Bodies
    table: Array
    """coefficients of LANES instants (1, 15 LANES)"""
    coefficients: Array
    """of one (15,)"""
    motion: Array
    """z_body, angular velocity and, on any ground, the contact's at an instant (N_ANY_MOTION,)"""
    leg: Array
    """angles, rates and accelerations (3, legs)"""
    signals: Array
    """(instants, signals)"""
    fine: Array
    """(points, signals)"""
    values: Array
    """(points,)"""
    there: Array
    """signals at any instant (signals,)"""
    tops: Array
    """largest value of each kind, see `_value` (2 + legs,)"""


def extremes(
    setting: Setting, gaits: GaitBatch, motion: Array, peaks: Array | None = None
) -> Array:
    """Loads of gaits (n, len(LOADS)) in the cycle of which the motion is given.

    Holds no interpreter lock while it computes. What a gait gives does not depend on the others.

    Args:
        setting: of a model; not decoupled ones.
        gaits: one row a gait.
        motion: z_body and angular velocity in the body's axes at equal steps of a cycle that
            begins at phase zero, and the contact's where the axis is ANY (n, steps, entries).
            Where the motion does not repeat, its last interval is left out.
        peaks: filled with the largest |motor torque| of each leg (n, legs) [N m], if given.
    """
    steps, (n, legs) = motion.shape[1], gaits.offset.shape
    refine, finer = between(steps, setting.periodic)
    instants, points, rows = len(refine), len(finer), n_signals(legs)
    work = Work(
        lane_work(setting.tree), bodies(setting.tree.mass.size),
        np.zeros((1, N_COEFFICIENTS * LANES)),
        np.zeros(N_COEFFICIENTS), np.zeros(N_ANY_MOTION), np.zeros((3, legs)),
        np.zeros((instants, rows)),
        np.zeros((points, rows)), np.zeros(points), np.zeros(rows),
        np.zeros(2 + legs),
    )  # fmt: skip
    out = np.empty((n, len(LOADS)))
    peaks = np.empty((n, legs)) if peaks is None else peaks
    evaluate(
        setting.tree, setting.parameters, setting.axis, setting.leg_loss,
        tuple(checked(setting.tree, gaits)), motion, turns_at(instants, gaits.sine.shape[1]),
        refine, finer, setting.periodic, work, out, peaks,
    )  # fmt: skip
    limited = np.isfinite(setting.effort)
    share = np.divide(peaks, setting.effort, out=np.zeros_like(peaks), where=limited)
    out[:, -1] = share.max(axis=1, initial=0.0)
    return out


@compiled()
def evaluate(  # type: ignore[no-untyped-def]
    tree,
    parameters,
    axis,
    leg_loss,
    gaits,
    motion,
    turns,
    refine,
    finer,
    periodic,
    work,
    out,
    peaks,
):
    """Loads of gaits; see `extremes`."""
    tree, parameters, gaits = borrowed(tree), borrowed(parameters), borrowed(gaits)
    motion, turns, refine = borrowed(motion), borrowed(turns), borrowed(refine)
    finer, work, out = borrowed(finer), borrowed(work), borrowed(out)
    peaks = borrowed(peaks)
    n_legs = work.leg.shape[1]
    for g in range(len(out)):
        _signals(tree, parameters, axis, gaits, g, motion, turns, refine, work)
        _product(finer, work.signals, work.fine)
        for leg in range(n_legs):
            if leg_loss[0, leg] == 0.0 and leg_loss[1, leg] == 0.0:
                continue
            for k in range(len(work.fine)):
                # The motors also overcome the damping and the friction of their joints.
                x = work.fine[k]
                rate = x[TORQUE + n_legs + leg]
                x[TORQUE + leg] += leg_loss[0, leg] * rate + leg_loss[1, leg] * np.tanh(
                    rate / CREEP
                )
            for k in range(len(work.signals)):
                x = work.signals[k]
                rate = x[TORQUE + n_legs + leg]
                x[TORQUE + leg] += leg_loss[0, leg] * rate + leg_loss[1, leg] * np.tanh(
                    rate / CREEP
                )
        for kind in range(2 + n_legs):
            work.tops[kind] = _top(work, kind, periodic)
        row = out[g]
        row[0], row[1] = -work.tops[0], np.nan
        if parameters[1] > 0.0:
            # No friction would do where the ground does not push.
            row[1] = work.tops[1] if row[0] > 0.0 else np.inf
        square, row[3], row[4] = 0.0, 0.0, 0.0
        for leg in range(n_legs):
            row[3] = max(row[3], work.tops[2 + leg])
            peaks[g, leg] = work.tops[2 + leg]
            for k in range(len(work.fine)):
                x = work.fine[k]
                square += x[TORQUE + leg] * x[TORQUE + leg]
                work.values[k] = x[TORQUE + leg] * x[TORQUE + n_legs + leg]
            row[4] += _mean_size(work.values)
        row[2] = np.sqrt(square / len(work.fine))


@inner
def _signals(tree, parameters, axis, gaits, g, motion, turns, refine, work):  # type: ignore[no-untyped-def]
    """Signals of gait g at the instants."""
    offset, winding, sine, cosine, omega = gaits
    n, legs, lanes = len(work.signals), offset.shape[1], work.lanes
    for first in range(0, n, LANES):
        for k in range(first, min(first + LANES, n)):
            legs_at(omega[g], offset[g], winding[g], sine[g], cosine[g], turns, k, work.leg)
            for leg in range(legs):
                lanes.angle[leg, k - first] = work.leg[0, leg]
                lanes.rate[leg, k - first] = work.leg[1, leg]
        fill_lanes(tree, lanes, work.table, 0)
        for k in range(first, min(first + LANES, n)):
            for c in range(N_COEFFICIENTS):
                work.coefficients[c] = work.table[0, c * LANES + k - first]
            for s in range(motion.shape[2]):
                work.motion[s] = 0.0
                for m in range(motion.shape[1]):
                    work.motion[s] += refine[k, m] * motion[g, m, s]
            legs_at(omega[g], offset[g], winding[g], sine[g], cosine[g], turns, k, work.leg)
            loads(tree, work.motion, work.coefficients, work.leg, parameters, axis, work.bodies,
                  work.signals[k])  # fmt: skip


@inner
def _product(matrix, source, out):  # type: ignore[no-untyped-def]
    """out = matrix source."""
    for k in range(len(out)):
        for r in range(out.shape[1]):
            out[k, r] = 0.0
        for m in range(len(source)):
            for r in range(out.shape[1]):
                out[k, r] += matrix[k, m] * source[m, r]


@inner
def _value(x, kind):  # type: ignore[no-untyped-def]
    """What is to be largest, of signals x: 0 minus the normal force, 1 friction, 2 + leg torque."""
    if kind == 0:
        return -x[0]
    if kind == 1:
        a, b, c = x[FRICTION], x[FRICTION + 1], x[FRICTION + 2]
        return np.sqrt(a * a + b * b + c * c) / x[0]
    return abs(x[TORQUE + kind - 2])


@inner
def _top(work, kind, periodic):  # type: ignore[no-untyped-def]
    """Largest value over a cycle."""
    values, n = work.values, len(work.values)
    best = -np.inf
    for k in range(n):
        values[k] = _value(work.fine[k], kind)
        best = max(best, values[k])
    if not periodic:
        return best
    least = best - _NEAR * abs(best)
    for k in range(n):
        left, here, right = values[(k + n - 1) % n], values[k], values[(k + 1) % n]
        if here >= least and here >= left and here > right:
            best = max(best, _polished(work, kind, k, left, here, right))
    return best


@inner
def _polished(work, kind, k, left, here, right):  # type: ignore[no-untyped-def]
    """Largest value near point k: two parabolas, the second through points of the interpolant."""
    width = 2.0 * np.pi / len(work.values)
    at, best = width * (k + _vertex(left, here, right)), here
    width /= _PARTS
    move = 0.0
    for n in range(4):
        found = _at(work, kind, at + move)
        best = max(best, found)
        if n == 0:
            middle, move = found, -width
        elif n == 1:
            left, move = found, width
        else:
            move = width * _vertex(left, middle, found)
    return best


@inner
def _vertex(left, here, right):  # type: ignore[no-untyped-def]
    """Where the parabola through three points a unit apart is level, from the middle one."""
    bend = left - 2.0 * here + right
    return max(-1.0, min(1.0, 0.5 * (left - right) / bend)) if bend < 0.0 else 0.0


@inner
def _at(work, kind, angle):  # type: ignore[no-untyped-def]
    """Value of the interpolant at a phase [rad], by the signals that it takes."""
    n = len(work.signals)
    first, last = 0, 1 + kind * (TORQUE - 1)
    if kind > 1:
        first, last = TORQUE + kind - 2, TORQUE + kind - 1
    for r in range(first, last):
        work.there[r] = 0.0
    for m in range(n):
        # Dirichlet's kernel.
        turn = 0.5 * (angle - 2.0 * np.pi * m / n)
        sine = np.sin(turn)
        weight = 1.0
        if abs(sine) > 1e-9:
            weight = np.sin(n * turn) / (n * sine)
            if n % 2 == 0:
                weight *= np.cos(turn)
        for r in range(first, last):
            work.there[r] += weight * work.signals[m, r]
    return _value(work.there, kind)


@inner
def _mean_size(values):  # type: ignore[no-untyped-def]
    """Mean of |f| over a period, by cubics through f's points; each side of a zero on its own."""
    n, total = len(values), 0.0
    for k in range(n):
        a, b, c, d = values[(k + n - 1) % n], values[k], values[(k + 1) % n], values[(k + 2) % n]
        whole = (13.0 * (b + c) - a - d) / 24.0
        if b * c >= 0.0:
            total += abs(whole)
            continue
        # f = b + t (c1 + t (c2 + t c3)) for 0 < t < 1.
        c2, c3 = 0.5 * (a + c) - b, (d - a) / 6.0 + 0.5 * (b - c)
        c1 = c - b - c2 - c3
        low, high = 0.0, 1.0
        for _ in range(_HALVINGS):
            t = 0.5 * (low + high)
            if (b + t * (c1 + t * (c2 + t * c3))) * b > 0.0:
                low = t
            else:
                high = t
        before = low * (b + low * (c1 / 2.0 + low * (c2 / 3.0 + low * c3 / 4.0)))
        total += abs(before) + abs(whole - before)
    return total / n
