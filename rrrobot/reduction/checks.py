"""What kinematic reduction promises: whether a model has one, and where its legs can steer it.

A model reduces to kinematics if the law quasi = -A(pose, phi) phi_dot of zero momentum is kept by
its dynamics whatever the legs do and however fast they do it: free of drift, velocities as inputs.
Along that law, at the leg rates lambda phi_dot and accelerations lambda^2 phi_ddot, the dynamics
leave the residual (body's acceleration minus that of the law)

    r(lambda) = r_0 + r_1 lambda + r_2 lambda^2

in which r_0 is gravity, r_1 damping, and r_2 the inertia terms: the part of the symmetric products
of the leg fields, by Christoffel's symbols, that leaves their span. All three vanish at all
postures, or there is no reduction (F. Bullo and A. Lewis, Geometric Control of Mechanical Systems,
2005, ch. 8).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.drive.gaits import LegMotion
from rrrobot.errors import ModelError, ParameterError
from rrrobot.models.base import Model
from rrrobot.models.single_axis import YawModel
from rrrobot.reduction.connection import Connection, as_connection
from rrrobot.robot.robot import Robot

_STEP = 2e-3
_TOLERANCE = 1e-8


@dataclass(frozen=True, kw_only=True)
class Reducibility:
    """Verdict of `reducibility`, with the largest body accelerations [rad/s^2] that break the law.

    Attributes:
        model: name of the model.
        reducible: whether it admits a kinematic reduction with all leg velocities as inputs.
        gravity: r_0, with the legs still.
        damping: r_1, at leg rates of about 1 rad/s.
        inertia: r_2, at leg rates of about 1 rad/s and accelerations of about 1 rad/s^2.
        reasons: in words.

    Example:
        >>> import rrrobot as rr
        >>> verdict = rr.reduction.reducibility(rr.YawModel(rr.Robot.from_parameters()))
        >>> verdict.model, verdict.reducible
        ('yaw', True)
    """

    model: str
    reducible: bool
    gravity: float
    damping: float
    inertia: float
    reasons: tuple[str, ...]


def reducibility(
    model: Model, *, samples: int = 12, rng: np.random.Generator | int = 0
) -> Reducibility:
    """Test whether a model admits a kinematic reduction, and say why not.

    Without gravity and damping every model keeps its path when the legs go uniformly faster; here
    they may also hurry and linger. The residual is taken at random postures, leg rates and
    accelerations, with each model's own equations of motion.

    On RRRobot: yaw does; pitch, roll, pivoting and full do not, because of gravity and damping.
    Without both, pivoting does (momentum is conserved about every axis) and pitch, roll and full
    still do not: a body that rolls has another inertia at another angle, and the ground's force
    changes its momentum.

    Args:
        model: any model.
        samples: how many postures, at least 1.
        rng: generator, or seed, of the postures.

    Raises:
        ParameterError: samples below 1.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> rr.reduction.reducibility(rr.YawModel(robot)).reducible
        True
        >>> rr.reduction.reducibility(rr.PitchModel(robot, damping=None)).reasons[0]
        'gravity moves the body while the legs are still (up to 30 rad/s^2)'
    """
    if isinstance(samples, bool) or not isinstance(samples, int) or samples < 1:
        raise ParameterError(f"samples is {samples!r}: it must be a whole number, 1 or more.")
    generator = np.random.default_rng(rng)
    found = np.array([_residual(model, generator) for _ in range(samples)])
    *sizes, scale = found.max(axis=0).tolist()
    broken = [size > _TOLERANCE * max(scale, 1.0) for size in sizes]
    words = (
        "gravity moves the body while the legs are still (up to {:.2g} rad/s^2)",
        "damping makes the body's path depend on the legs' speed (up to {:.2g} rad/s^2 at 1 rad/s)",
        "the body's momentum is not conserved: its inertia changes with its own attitude as it "
        "rolls (up to {:.2g} rad/s^2 at 1 rad/s)",
    )
    reasons = [
        text.format(size) for text, size, bad in zip(words, sizes, broken, strict=True) if bad
    ]
    if not reasons:
        reasons = ["its momentum is conserved and zero: the legs' velocities alone set the body's"]
    return Reducibility(
        model=model.name,
        reducible=not any(broken),
        gravity=sizes[0],
        damping=sizes[1],
        inertia=sizes[2],
        reasons=tuple(reasons),
    )


def _residual(model: Model, rng: np.random.Generator) -> Array:
    """Sizes of (r_0, r_1, r_2, the law's own acceleration) at one random posture (4,)."""
    n = model.n_legs
    euler = np.zeros(3)
    euler[list(model.axes)] = rng.uniform(-0.6, 0.6, len(model.axes))
    pose = model.make_pose(euler, np.zeros(2))
    angle, rate, acceleration = rng.uniform(-1.5, 1.5, n), rng.normal(size=n), rng.normal(size=n)

    def drive(speed: float) -> tuple[Array, Array]:
        motion = LegMotion(angle, speed * rate, speed**2 * acceleration)
        quasi = model.impulsive_start(pose, angle, motion.rate)
        place = model.place(pose)
        pose_rate = model.pose_rate(place, pose, quasi)

        def law(time: float) -> Array:
            # Any curve with this tangent will do: the law depends on posture and leg rate alone.
            return model.impulsive_start(
                pose + time * pose_rate,
                angle + time * motion.rate,
                motion.rate + time * motion.acceleration,
            )

        h = _STEP
        kept = (8 * (law(h) - law(-h)) - (law(2 * h) - law(-2 * h))) / (12 * h)
        actual = model.quasi_acceleration(model.dynamics(place, quasi, motion).acceleration)
        return actual - kept, kept

    (still, _), (forth, kept), (back, _) = drive(0.0), drive(1.0), drive(-1.0)
    parts = (still, (forth - back) / 2, (forth + back) / 2 - still, kept)
    return np.array([np.abs(part).max() for part in parts])


@dataclass(frozen=True, kw_only=True)
class Controllability:
    """What the legs can steer from one posture, by Lie brackets.

    Attributes:
        dimension: of (theta, phi): one more than the legs.
        rank: of the leg fields and their brackets.
        order: how many fields the first bracket that turns the body has: 2 where a height function
            is not zero, 3 where its gradient is not, and so on; None if there is none up to the
            highest order that was asked for.
        controllable: whether the rank is full: every configuration near by can be reached by short
            leg motions (Chow), as the reduced system has no drift.

    Example:
        >>> import rrrobot as rr
        >>> rr.reduction.controllability(rr.Robot.from_parameters(), (0.8, 0.8)).rank
        3
    """

    dimension: int
    rank: int
    order: int | None
    controllable: bool


def controllability(
    source: Connection | Robot | YawModel, leg_angle: ArrayLike, *, highest_order: int = 6
) -> Controllability:
    """Lie-bracket rank condition of the yaw model at a posture of the legs.

    The fields are X_k = d/d phi_k - A_k d/d theta. Their brackets turn the body alone,

        [X_j, X_k] = H_jk d/d theta,    [X_i, [X_j, X_k]] = d_i H_jk d/d theta,    ...

    so the order is two more than that to which all height functions vanish at the posture. It is
    read from polynomials fitted to H along straight lines in random directions.

    Args:
        source: a robot or its connection.
        leg_angle: (legs,) [rad].
        highest_order: of the brackets, 2 to 8.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> [rr.reduction.controllability(robot, phi).order
        ...  for phi in ((0.8, 0.8), (np.pi / 2, np.pi / 2), (0, 0), (0, np.pi))]
        [2, 3, 4, 6]
    """
    connection = as_connection(source)
    phi = vector("leg_angle", leg_angle, connection.n_legs, "rad")
    if not isinstance(highest_order, int) or highest_order not in range(2, 9):
        raise ParameterError(f"highest_order is {highest_order!r}: it must be a number 2 to 8.")
    n = connection.n_legs
    order = _first_bracket(connection, phi, highest_order) if n > 1 else None
    # One leg alone turns the body, but only forth and back along one line.
    rank = n + (order is not None)
    return Controllability(dimension=n + 1, rank=rank, order=order, controllable=rank == n + 1)


def _first_bracket(connection: Connection, phi: Array, highest: int) -> int | None:
    # Polynomials of degree 13 over +-0.3 rad, in powers of the distance over that reach.
    reach, degree = 0.3, 13
    times = np.cos(np.pi * (np.arange(degree + 5) + 0.5) / (degree + 5))
    powers = np.zeros((degree + 1, degree + 1))
    for i, unit in enumerate(np.eye(degree + 1)):
        powers[: i + 1, i] = np.polynomial.chebyshev.cheb2poly(unit[: i + 1])
    rng = np.random.default_rng(7)
    sizes = np.zeros(degree + 1)
    for _ in range(4):
        direction = rng.normal(size=phi.size)
        direction *= reach / np.linalg.norm(direction)
        heights = connection.curvature(phi + times[:, None] * direction).reshape(times.size, -1)
        fit = powers @ np.polynomial.chebyshev.chebfit(times, heights, degree)
        sizes = np.maximum(sizes, np.abs(fit).max(axis=1))
    # H is made of A's slopes, whose rounding is what can hide a zero.
    scale = np.abs(connection.derivative(phi)).max() + float(sizes.max())
    for power in range(highest - 1):
        if sizes[power] > 1e-9 * scale:
            return power + 2
    return None


def path_controllability(
    source: Connection | Robot | YawModel, leg_angles: ArrayLike, *, highest_order: int = 6
) -> tuple[Controllability, ...]:
    """`controllability` at each posture (n, legs) of a path of the legs.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> path = np.column_stack((np.linspace(0.5, 2.5, 5), np.full(5, np.pi / 2)))
        >>> [c.order for c in rr.reduction.path_controllability(rr.Robot.from_parameters(), path)]
        [2, 2, 2, 2, 2]
    """
    connection = as_connection(source)
    path = np.asarray(leg_angles, dtype=float)
    if path.ndim != 2 or len(path) == 0:
        raise ModelError(f"leg_angles has shape {path.shape}: it must be (postures, legs).")
    return tuple(controllability(connection, phi, highest_order=highest_order) for phi in path)
