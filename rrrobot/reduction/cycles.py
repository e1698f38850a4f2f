"""Leg cycles that turn the body most: per cycle, or per radian that the legs travel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite
from rrrobot.drive.gaits import FourierGait
from rrrobot.errors import ModelError, ParameterError
from rrrobot.inline import html_table
from rrrobot.models.single_axis import YawModel
from rrrobot.reduction.connection import Connection, as_connection
from rrrobot.reduction.heights import FULL_TURN, height_grid, pair_box, posture
from rrrobot.reduction.yaw import net_yaw
from rrrobot.robot.robot import Robot

PER = ("cycle", "travel")
_SAMPLES = 64


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
    if per not in PER:
        raise ParameterError(f"per is {per!r}: it must be one of {', '.join(PER)}.")
    if not isinstance(harmonics, int) or harmonics not in range(1, 21):
        raise ParameterError(f"harmonics is {harmonics!r}: it must be a whole number 1 to 20.")
    omega = finite("angular_frequency", angular_frequency, "rad/s", above=0)
    connection = as_connection(source)
    pair = connection.pair(pair)
    box, base = pair_box(angle_range), posture(connection, leg_angle)
    region_yaw, middle, spread = _region(connection, pair, box, base)
    search = _Search(connection, pair, box, base, harmonics, per, np.sign(region_yaw))
    series = search.run(middle, spread)
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
    from scipy.ndimage import label

    n = 121
    edges = [np.linspace(low, high, n + 1) for low, high in box]
    centers = np.array([(edge[:-1] + edge[1:]) / 2 for edge in edges])
    inner = np.column_stack((centers[:, 0], centers[:, -1]))
    first, second, heights = height_grid(
        connection, pair=pair, angle_range=inner, leg_angle=base, resolution=n
    )
    cell = float(np.prod((box[:, 1] - box[:, 0]) / n))
    tiny = 1e-10 * np.abs(connection.derivative(base)).max()
    best = 0.0, np.zeros(2), np.zeros(2)
    for sign in (1, -1):
        labels, count = label(sign * heights > tiny)
        for i in range(1, count + 1):
            inside = labels == i
            yaw = float(heights[inside].sum() * cell)
            if abs(yaw) > abs(best[0]):
                weight = np.abs(np.where(inside, heights, 0.0))
                weight /= weight.sum()
                grid = np.stack(np.meshgrid(first, second, indexing="ij"))
                middle = np.sum(grid * weight, axis=(1, 2))
                deviation = grid - middle[:, None, None]
                best = yaw, middle, np.sqrt(np.sum(deviation**2 * weight, axis=(1, 2)))
    if best[0] == 0:
        raise ModelError(
            f"the height function of legs {pair} is zero within {box.tolist()} rad: no cycle of "
            "the two turns the body."
        )
    return best


class _Search:
    """Sequential quadratic programming over paths that go round once, as seen from their middle.

        phi(t) = middle + rho(t) (w_j cos t, w_k sin t),   rho > 0 a Fourier series

    is a Fourier series with one harmonic more than rho. Free series would find paths that cross
    themselves to wind again and again, each time for more yaw.
    """

    def __init__(
        self,
        connection: Connection,
        pair: tuple[int, int],
        box: Array,
        base: Array,
        harmonics: int,
        per: str,
        sign: float,
    ) -> None:
        self.connection, self.pair, self.box, self.base = connection, list(pair), box, base
        self.harmonics, self.per, self.sign = harmonics, per, sign
        self.scale = 1.0

    def value(self, x: Array) -> tuple[float, Array]:
        """What is minimised, with its gradient."""
        path, rate = (np.reshape(part @ x, (-1, 2)) for part in (self.place, self.tangent))
        points, along = np.tile(self.base, (len(path), 1)), np.zeros((len(path), self.base.size))
        points[:, self.pair], along[:, self.pair] = path, rate
        weight = 2 * np.pi / len(path)
        yaw = -weight * float(np.sum(self.connection(points) * along))
        height = self.connection.height(points, (self.pair[0], self.pair[1]))
        normal = np.column_stack((rate[:, 1], -rate[:, 0])) * height[:, None]
        slope = weight * self.place.T @ normal.ravel()
        if self.per == "travel":
            speed = np.sqrt(np.sum(rate**2, axis=1) + 1e-12)
            travel = weight * float(speed.sum())
            stretch = weight * self.tangent.T @ (rate / speed[:, None]).ravel()
            yaw, slope = yaw / travel, (slope - yaw / travel * stretch) / travel
        return -self.sign * yaw / self.scale, -self.sign * slope / self.scale

    def run(self, middle: Array, spread: Array) -> Array:
        """The best series (1 + 2 harmonics, 2), rows 1, cos, sin."""
        from scipy.optimize import minimize

        room = np.minimum(middle - self.box[:, 0], self.box[:, 1] - middle)
        width = np.minimum(1.2 * spread, 0.95 * room)
        self.place, self.tangent, round_about = _polar(width, _SAMPLES, self.harmonics)
        start = np.zeros(self.place.shape[1])
        start[:2], start[2] = middle, 1.0
        self.scale = abs(self.value(start)[0]) or 1.0
        # Both legs within limits at all samples, and rho above zero: linear in the coefficients.
        matrix = np.vstack((self.place, -self.place, round_about))
        low, high = (np.tile(side, _SAMPLES) for side in self.box.T)
        bound = np.concatenate((low, -high, np.full(_SAMPLES, 0.05)))
        constraint: Any = {
            "type": "ineq",
            "fun": lambda x: matrix @ x - bound,
            "jac": lambda x: matrix,
        }
        found = minimize(
            self.value,
            start,
            jac=True,
            method="SLSQP",
            constraints=[constraint],
            options={"maxiter": 100, "ftol": 1e-8},
        )
        if not np.all(np.isfinite(found.x)):
            raise ModelError(f"the search for a cycle failed: {found.message}.")
        # The samples are more than the series has terms, so this is exact.
        path = np.reshape(self.place @ found.x, (-1, 2))
        series = np.linalg.lstsq(_series(_SAMPLES, self.harmonics), path, rcond=None)[0]
        return self._inside(np.asarray(series, dtype=float))

    def _inside(self, series: Array) -> Array:
        """Shrunk about the middle of the limits where the path is outside between its samples."""
        path = _series(2048, self.harmonics) @ series
        center, half = self.box.mean(axis=1), np.ptp(self.box, axis=1) / 2
        factor = min(1.0, float((half / np.abs(path - center).max(axis=0)).min()) * (1 - 1e-12))
        moved = factor * series
        moved[0] += (1 - factor) * center
        return moved


def _polar(width: Array, samples: int, harmonics: int) -> tuple[Array, Array, Array]:
    """Path and tangent (2 samples, coefficients), and rho (samples, coefficients), each linear."""
    t = 2 * np.pi * np.arange(samples) / samples
    rho = _series(samples, harmonics - 1)
    j = np.arange(1, harmonics)
    slope = np.hstack((0 * t[:, None], -j * np.sin(np.outer(t, j)), j * np.cos(np.outer(t, j))))
    ray = np.column_stack((np.cos(t), np.sin(t)))[:, :, None] * width[:, None]
    turn = np.column_stack((-np.sin(t), np.cos(t)))[:, :, None] * width[:, None]
    path = ray * rho[:, None]
    tangent = turn * rho[:, None] + ray * slope[:, None]
    middle = np.tile(np.eye(2), (samples, 1))
    n = rho.shape[1]
    return (
        np.hstack((middle, path.reshape(-1, n))),
        np.hstack((0 * middle, tangent.reshape(-1, n))),
        np.hstack((np.zeros((samples, 2)), rho)),
    )


def _series(samples: int, harmonics: int) -> Array:
    """Values (samples, 1 + 2 harmonics) of 1, cos j t, sin j t over one turn."""
    t = 2 * np.pi * np.arange(samples) / samples
    angle = np.outer(t, np.arange(1, harmonics + 1))
    return np.hstack((np.ones((samples, 1)), np.cos(angle), np.sin(angle)))
