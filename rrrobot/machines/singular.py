"""Singular shapes: where constraints of a machine in the plane come to depend on each other.

With J_b the constraints' columns of the base and of joints without a motor, the margin is the ratio
of its least singular value to its greatest. It is zero where wheels align: there the shape's motion
asks for infinite speeds, or leaves the machine a freedom that it has nowhere else.
"""

from __future__ import annotations

import numpy as np

from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait
from rrrobot.errors import ConstraintError
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.solve import decompose, dependent

_SINGULAR = 1e-6
_SAMPLES = 240


def margin(model: Mechanism, shape: Array) -> float:
    """Least over greatest singular value of J_b at a shape (n,), from 0 to 1."""
    values = np.linalg.svd(_held(model, shape), compute_uv=False)
    return float(values[-1] / values[0])


def refuse_singular(model: Mechanism, gait: Gait, duration: float) -> None:
    """Raise where a gait passes a singular shape within a duration, and say which rows align.

    Raises:
        ConstraintError: it does.
    """
    if not model.planar or not model.motors or not model.constraints:
        return
    if any(constraint.holonomic.any() for constraint in model.constraints):
        return  # a loop: what the rows are depends on more than the shape
    from scipy.optimize import minimize_scalar

    end = min(duration, gait.period or duration)
    times = np.linspace(0.0, end, _SAMPLES)

    def at(time: float) -> float:
        return margin(model, gait(time).angle)

    margins = np.array([at(t) for t in times])
    left, right = np.append(np.inf, margins[:-1]), np.append(margins[1:], np.inf)
    for i in np.flatnonzero((margins <= left) & (margins <= right)).tolist():
        around = times[max(i - 1, 0)], times[min(i + 1, _SAMPLES - 1)]
        time = float(times[i])
        if margins[i] > _SINGULAR:
            time = minimize_scalar(at, bounds=around, method="bounded", options={"xatol": 1e-9}).x
        motion = gait(time)
        if at(time) > _SINGULAR or not motion.rate.any():
            continue
        held = _held(model, motion.angle)
        _, left_vectors, values, _ = decompose(held)
        rank = int(np.sum(values > _SINGULAR * values[0]))
        shape = ", ".join(f"{x:.4g}" for x in motion.angle)
        raise ConstraintError(
            f"the gait passes a singular shape at t = {time:.4g} s, shape ({shape}): there the "
            f"constraints {dependent(left_vectors[:, rank:], model.names(None))} depend on each "
            "other, their wheels align. Keep the shape away from it."
        )


def _held(model: Mechanism, shape: Array) -> Array:
    q = model.coordinates.to_q(model.start(None, shape))
    jacobian = model.rows(q, np.zeros(model.model.nv), 0.0, None).jacobian
    return np.delete(jacobian, model.shape_v, axis=1)


def determinant(model: Mechanism, shape: Array) -> float | None:
    """Of J_b at a shape (n,): it changes sign across singular shapes; None unless J_b is square."""
    held = _held(model, shape)
    return float(np.linalg.det(held)) if held.shape[0] == held.shape[1] else None
