"""Where a height function vanishes: the lines that the best leg cycles follow."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.errors import ParameterError
from rrrobot.models.single_axis import YawModel
from rrrobot.reduction.connection import Connection, as_connection
from rrrobot.robot.robot import Robot

FULL_TURN = (-np.pi, np.pi)


def height_grid(
    source: Connection | Robot | YawModel,
    *,
    pair: tuple[int, int] = (0, 1),
    angle_range: ArrayLike = FULL_TURN,
    leg_angle: ArrayLike | None = None,
    resolution: int = 61,
) -> tuple[Array, Array, Array]:
    """Height function of a pair of legs on a grid; the other legs stay.

    Args:
        source: a robot or its connection.
        pair: indices (j, k) of two legs.
        angle_range: (low, high) of both legs, or (2, 2) with a row for each [rad].
        leg_angle: where the other legs are (legs,) [rad]; zero unless given.
        resolution: values of each leg, at least 3.

    Returns:
        angles of leg j (m,) and of leg k (m,) [rad], and H[i_j, i_k] (m, m) [rad/rad^2].

    Example:
        >>> import rrrobot as rr
        >>> first, second, H = rr.reduction.height_grid(rr.Robot.from_parameters(), resolution=5)
        >>> H.shape
        (5, 5)
    """
    connection = as_connection(source)
    j, k = connection.pair(pair)
    box = pair_box(angle_range)
    if isinstance(resolution, bool) or not isinstance(resolution, int) or resolution < 3:
        raise ParameterError(f"resolution is {resolution!r}: it must be a whole number, 3 or more.")
    first, second = (np.linspace(low, high, resolution) for low, high in box)
    points = np.tile(posture(connection, leg_angle), (resolution, resolution, 1))
    points[..., j], points[..., k] = np.meshgrid(first, second, indexing="ij")
    return first, second, connection.height(points, (j, k))


def zero_set(
    source: Connection | Robot | YawModel,
    *,
    pair: tuple[int, int] = (0, 1),
    angle_range: ArrayLike = FULL_TURN,
    leg_angle: ArrayLike | None = None,
    resolution: int = 61,
) -> list[Array]:
    """Lines along which the height function of a pair of legs is zero.

    Contours of a grid, each point then moved down the gradient onto the zero; points where lines
    cross, and the gradient vanishes, stay where the grid saw them. On RRRobot the lines are
    phi_1 = 0 and pi, phi_2 = 0 and pi, phi_1 + phi_2 = pi and phi_1 - phi_2 = pi.

    Args:
        source: as for `height_grid`, as all others.
        pair, angle_range, leg_angle, resolution: as for `height_grid`.

    Returns:
        lines (points, 2) of (phi_j, phi_k) [rad]; none where the function keeps its sign.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> line, = rr.reduction.zero_set(robot, angle_range=(1.0, 2.0), resolution=12)
        >>> bool(abs(line.sum(axis=1) - np.pi).max() < 1e-12)
        True
    """
    from contourpy import contour_generator

    connection = as_connection(source)
    pair = connection.pair(pair)
    first, second, heights = height_grid(
        connection, pair=pair, angle_range=angle_range, leg_angle=leg_angle, resolution=resolution
    )
    if np.abs(heights).max() == 0:
        raise ParameterError("the height function is zero everywhere: the legs cannot turn it.")
    lines = contour_generator(first, second, heights.T).lines(0.0)
    base = posture(connection, leg_angle)
    cell = max(first[1] - first[0], second[1] - second[0])
    return [_polished(connection, pair, base, np.asarray(line), cell) for line in lines]


def posture(connection: Connection, leg_angle: ArrayLike | None) -> Array:
    """Leg angles (legs,) [rad]; zero unless given."""
    if leg_angle is None:
        return np.zeros(connection.n_legs)
    return vector("leg_angle", leg_angle, connection.n_legs, "rad", broadcast=True)


def pair_box(angle_range: ArrayLike) -> Array:
    """Limits of two legs (2, 2), one row (low, high) each [rad].

    Raises:
        ParameterError: not one or two rows of low < high.
    """
    try:
        box = np.array(np.broadcast_to(np.asarray(angle_range, dtype=float), (2, 2)))
    except (TypeError, ValueError):
        box = np.full((2, 2), np.nan)
    if not np.all(np.isfinite(box)) or np.any(box[:, 0] >= box[:, 1]):
        raise ParameterError(
            f"angle_range is {angle_range!r}: it must be (low, high) for both legs, or one such "
            "row for each of the two, with low below high [rad]."
        )
    return box


def _polished(
    connection: Connection, pair: tuple[int, int], base: Array, line: Array, cell: float
) -> Array:
    step = 1e-4
    points = np.tile(base, (len(line), 1))
    points[:, pair] = line

    def height(shift: Array) -> Array:
        moved = points.copy()
        moved[:, pair] += shift
        return connection.height(moved, pair)

    for _ in range(4):
        units = step * np.eye(2)
        slope = np.stack([height(u) - height(-u) for u in units], axis=-1) / (2 * step)
        square = np.sum(slope**2, axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            move = -(height(np.zeros(2)) / square)[:, None] * slope
        near = np.isfinite(move).all(axis=1) & (np.linalg.norm(move, axis=1) < cell / 2)
        points[np.ix_(near, pair)] += move[near]
    return np.array(points[:, pair])
