"""Leg cycles that turn the body most: per cycle, or per radian that the legs travel."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite
from rrrobot.drive.gaits import FourierGait
from rrrobot.errors import ModelError
from rrrobot.inline import html_table
from rrrobot.models.single_axis import YawModel
from rrrobot.reduction.connection import Connection, as_connection
from rrrobot.reduction.heights import FULL_TURN, height_grid, pair_box, posture
from rrrobot.reduction.paths import PathSearch, check_search, largest_region
from rrrobot.reduction.yaw import net_yaw
from rrrobot.robot.robot import Robot


@dataclass(frozen=True, kw_only=True, eq=False)
class OptimalCycle:
    """A closed leg path that turns the body most, as a gait.

    Attributes:
        gait: the cycle; legs outside of the pair stay.
        net_yaw: per cycle, positive [rad].
        travel: length of the legs' path, integral of sqrt(phi_j_dot^2 + phi_k_dot^2) dt [rad].
        per_travel: net yaw per travel [rad/rad].
        region_yaw: integral of the height function over the part of the limits in which it has
            one sign: what no path that goes round once can exceed, and what a path along the
            region's edge reaches [rad].
        angle_range: of the pair (2, 2) [rad].
        pair: which legs move.
        per: "cycle" or "travel".

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> best = rr.reduction.optimal_cycle(robot, angle_range=(0.3, 1.5), harmonics=4)
        >>> best.per, best.pair, best.gait.period == rr.gait("lateral").period
        ('cycle', (0, 1), True)
    """

    gait: FourierGait
    net_yaw: float
    travel: float
    per_travel: float
    region_yaw: float
    angle_range: Array
    pair: tuple[int, int]
    per: str

    def _repr_html_(self) -> str:
        return html_table(
            f"Leg cycle with most turn per {self.per}",
            {
                "net turn": f"{np.rad2deg(self.net_yaw):.4f} deg a cycle",
                "travel of the legs": f"{np.rad2deg(self.travel):.2f} deg a cycle",
                "turn of its region": f"{np.rad2deg(self.region_yaw):.4f} deg",
                "legs": f"{self.pair[0] + 1} and {self.pair[1] + 1}",
                "gait": self.gait,
            },
        )


def optimal_cycle(
    source: Connection | Robot | YawModel,
    *,
    per: str = "cycle",
    angle_range: ArrayLike = FULL_TURN,
    pair: tuple[int, int] = (0, 1),
    leg_angle: ArrayLike | None = None,
    harmonics: int = 10,
    angular_frequency: float = 8.0,
) -> OptimalCycle:
    """The leg cycle with most net yaw within leg limits, going round once.

    "cycle" has most net yaw per cycle: as the net yaw is the integral of the height function over
    what the path encloses, the best path runs along the height function's zero set and the limits,
    and the gait follows it as closely as its harmonics allow. "travel" has most net yaw per radian
    of leg travel: where the limits do not bind, its curvature is the height function over the
    ratio that it reaches. The gradient is exact: moving the path by delta changes the yaw by the
    integral of H (delta_j phi_k_dot - delta_k phi_j_dot) dt.

    Args:
        source: a robot or its connection.
        per: "cycle" or "travel".
        angle_range: (low, high) of both legs, or a row for each (2, 2) [rad].
        pair: indices of the two legs that move.
        leg_angle: where the other legs stay (legs,) [rad]; zero unless given.
        harmonics: of the gait, 1 to 20.
        angular_frequency: of the gait [rad/s]; the yaw does not depend on it.

    Returns:
        the OptimalCycle; its direction is that of positive yaw.

    Raises:
        ParameterError: an argument out of range.
        ModelError: the height function is zero all over the limits, or the search fails.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> best = rr.reduction.optimal_cycle(robot, angle_range=(0.3, 1.5), harmonics=4)
        >>> bool(0.8 < best.net_yaw / best.region_yaw <= 1)
        True
    """
    check_search(per, harmonics)
    omega = finite("angular_frequency", angular_frequency, "rad/s", above=0)
    connection = as_connection(source)
    pair = connection.pair(pair)
    box, base = pair_box(angle_range), posture(connection, leg_angle)
    region_yaw, middle, spread = _region(connection, pair, box, base)
    gain = partial(_yaw, connection, list(pair), base, float(np.sign(region_yaw)))
    series = PathSearch(gain, box, harmonics, per).run(middle, spread)
    if region_yaw < 0:
        # The other way round.
        series[1 + harmonics :] *= -1
    cosine, sine = np.zeros((2, harmonics, connection.n_legs))
    base[list(pair)] = series[0]
    cosine[:, pair], sine[:, pair] = series[1 : 1 + harmonics], series[1 + harmonics :]
    gait = FourierGait(offset=base, cosine=cosine, sine=sine, angular_frequency=omega)
    yaw = net_yaw(connection, gait)
    times = np.arange(2048) * (2 * np.pi / omega) / 2048
    travel = float(np.linalg.norm(gait(times).rate, axis=1).mean() * 2 * np.pi / omega)
    return OptimalCycle(
        gait=gait,
        net_yaw=yaw,
        travel=travel,
        per_travel=yaw / travel,
        region_yaw=abs(region_yaw),
        angle_range=box,
        pair=pair,
        per=per,
    )


def _region(
    connection: Connection, pair: tuple[int, int], box: Array, base: Array
) -> tuple[float, Array, Array]:
    """Yaw, centre (2,) and spread (2,) of the region of one sign that holds most yaw."""
    n = 121
    edges = [np.linspace(low, high, n + 1) for low, high in box]
    centers = np.array([(edge[:-1] + edge[1:]) / 2 for edge in edges])
    inner = np.column_stack((centers[:, 0], centers[:, -1]))
    first, second, heights = height_grid(
        connection, pair=pair, angle_range=inner, leg_angle=base, resolution=n
    )
    best = largest_region(first, second, heights, 1e-10 * np.abs(connection.derivative(base)).max())
    if best[0] == 0:
        raise ModelError(
            f"the height function of legs {pair} is zero within {box.tolist()} rad: no cycle of "
            "the two turns the body."
        )
    return best


def _yaw(
    connection: Connection, pair: list[int], base: Array, sign: float, path: Array, rate: Array
) -> tuple[float, Array]:
    """Yaw of a path (n, 2) times a sign, and its change with each of the points."""
    points, along = np.tile(base, (len(path), 1)), np.zeros((len(path), base.size))
    points[:, pair], along[:, pair] = path, rate
    weight = 2 * np.pi / len(path)
    yaw = -weight * float(np.sum(connection(points) * along))
    height = connection.height(points, (pair[0], pair[1]))
    normal = np.column_stack((rate[:, 1], -rate[:, 0])) * height[:, None]
    return sign * yaw, sign * weight * normal
