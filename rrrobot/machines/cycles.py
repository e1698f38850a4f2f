"""Cycles of two motors that move a machine most: per cycle, or per length of the path in shape.

A closed path r(t) moves the machine by G, the ordered product of exp(-A dr). Moving the path by
delta(t) changes it by dG = W G, g(t) being the motion so far and DA the curvature,

    W = - integral of Ad_g DA(delta, r_dot) dt + (1 - Ad_G) A delta(0),

the last term because the machine is seen from where it begins. So any component of the pose has an
exact gradient; A and DA come from splines over the plane of the two, and the result from the
ordered integral along the path that is found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.gaits import FourierGait
from rrrobot.errors import ConstraintError, ModelError, ParameterError
from rrrobot.machines.machine import Machine
from rrrobot.machines.reduced import Reduction, bracket
from rrrobot.reduction.paths import PathSearch, check_search, largest_region

COMPONENTS = {"SE(2)": ("x", "y", "theta"), "SE(3)": ("x", "y", "z", "rx", "ry", "rz")}
"""Of a net motion: position [m]; angle, or rotation vector [rad]."""
_CLEAR = 1e-3
_DEGREE = 5


@dataclass(frozen=True, kw_only=True, eq=False)
class MachineCycle:
    """A closed path of two motors that moves a machine most.

    Attributes:
        gait: the cycle; other motors stay.
        component: which of the net motion is greatest.
        moved: net motion by component, seen from the pose at the start [m, rad].
        travel: length of the path in shape [rad or m].
        per: "cycle" or "travel".

    Example:
        >>> import rrrobot as rr
        >>> body = rr.machines.satellite()
        >>> best = rr.machines.optimal_cycle(body, "theta", shape_range=(0.2, 1.2), harmonics=3)
        >>> best.gain == best.moved["theta"] > 0
        True
    """

    gait: FourierGait
    component: str
    moved: dict[str, float]
    travel: float
    per: str

    @property
    def gain(self) -> float:
        """The component that was asked for."""
        return self.moved[self.component]


class ShapePlane:
    """Connection and curvature over a plane of two motors, the others held, as splines.

    Args:
        reduction: of a machine.
        shape_range: (low, high) of both, or a row for each (2, 2).
        pair: indices of the two.
        shape: where the others are (n,); the machine's own unless given.
        resolution: values of each.

    Raises:
        ConstraintError: a singular shape in the range.
        ParameterError: an argument out of range.
    """

    def __init__(
        self,
        reduction: Reduction,
        shape_range: ArrayLike,
        pair: tuple[int, int] = (0, 1),
        shape: ArrayLike | None = None,
        resolution: int = 41,
    ) -> None:
        from scipy.interpolate import RectBivariateSpline

        self.reduction, self.pair = reduction, list(pair)
        self.box, self.base = plane_of(reduction, shape_range, pair, shape)
        axes = [np.linspace(low, high, resolution) for low, high in self.box]
        table = np.empty((resolution, resolution, reduction.model.n_base, 2))
        for i, j in np.ndindex(resolution, resolution):
            at = self.at(float(axes[0][i]), float(axes[1][j]))
            if reduction.margin(at) < _CLEAR:
                raise ConstraintError(
                    f"shape_range is {self.box.tolist()}: the shape {np.round(at, 4).tolist()} "
                    "within it is as good as singular. Keep away from where wheels align."
                )
            table[i, j] = reduction.connection(at)[: reduction.model.n_base, self.pair]
        self._splines = [
            [
                RectBivariateSpline(axes[0], axes[1], table[:, :, row, k], kx=_DEGREE, ky=_DEGREE)
                for k in range(2)
            ]
            for row in range(reduction.model.n_base)
        ]

    def at(self, first: float, second: float) -> Array:
        """The whole shape (n,)."""
        shape = self.base.copy()
        shape[self.pair] = first, second
        return shape

    def connection(self, points: Array) -> Array:
        """A (n, nb, 2) at points (n, 2)."""
        found = [[s.ev(points[:, 0], points[:, 1]) for s in row] for row in self._splines]
        return np.moveaxis(np.array(found), 2, 0)

    def curvature(self, points: Array) -> Array:
        """DA (n, nb) at points (n, 2)."""
        x, y = points.T
        flat = np.array([two.ev(x, y, dx=1) - one.ev(x, y, dy=1) for one, two in self._splines]).T
        A = self.connection(points)
        return flat - [bracket(a[:, 0], a[:, 1]) for a in A]


def plane_of(
    reduction: Reduction, shape_range: ArrayLike, pair: tuple[int, int], shape: ArrayLike | None
) -> tuple[Array, Array]:
    """Limits (2, 2) of two motors, and the shape (n,) of all."""
    n = reduction.model.n_shape
    if len(pair) != 2 or pair[0] == pair[1] or not all(i in range(n) for i in pair):
        raise ParameterError(f"pair is {pair!r}: it must be two of the {n} motors, from 0.")
    try:
        box = np.array(np.broadcast_to(np.asarray(shape_range, dtype=float), (2, 2)))
    except (TypeError, ValueError):
        box = np.full((2, 2), np.nan)
    if not np.all(np.isfinite(box)) or np.any(box[:, 0] >= box[:, 1]):
        raise ParameterError(
            f"shape_range is {shape_range!r}: it must be (low, high) of both motors, or a row for "
            "each, low below high."
        )
    return box, vector("shape", reduction.machine.shape if shape is None else shape, n).copy()


def optimal_cycle(
    machine: Machine | Reduction,
    component: str,
    *,
    shape_range: ArrayLike,
    per: str = "cycle",
    pair: tuple[int, int] = (0, 1),
    shape: ArrayLike | None = None,
    harmonics: int = 6,
    angular_frequency: float = 1.0,
) -> MachineCycle:
    """The cycle of two motors with most net motion along a component, going round once.

    Kinematic machines, and those whose momentum is kept, from rest. The search starts from the
    region of one sign of the component's curvature that holds most, and is local.

    Args:
        machine: or its reduction.
        component: of the net motion; "x", "y", "theta" in the plane, "x", "y", "z", "rx", "ry",
            "rz" (rotation vector) in space.
        shape_range: (low, high) of both motors, or a row for each (2, 2) [rad or m].
        per: "cycle", or "travel": per length of the path.
        pair: indices of the two motors.
        shape: where the others stay (n,).
        harmonics: of the gait, 1 to 20.
        angular_frequency: of the gait [rad/s]; the motion does not depend on it.

    Raises:
        ModelError: the machine is mixed, or no cycle moves it along the component.
        ConstraintError: a singular shape in the range.
        ParameterError: an argument out of range.

    Example:
        >>> import rrrobot as rr
        >>> snake = rr.machines.kinematic_snake()
        >>> best = rr.machines.optimal_cycle(snake, "x", shape_range=(0.4, 1.4), harmonics=2)
        >>> bool(abs(best.moved["x"]) > abs(best.moved["theta"]) / 10)
        True
    """
    reduction = machine if isinstance(machine, Reduction) else Reduction(machine)
    names = COMPONENTS[reduction.group]
    if component not in names:
        raise ParameterError(f"component is {component!r}: it must be one of {', '.join(names)}.")
    check_search(per, harmonics)
    omega = finite("angular_frequency", angular_frequency, "rad/s", above=0)
    if reduction.kind == "mixed":
        raise ModelError(
            f"the {reduction.machine.name} is mixed: its shape alone moves it nowhere."
        )
    plane = ShapePlane(reduction, shape_range, pair, shape)
    row = names.index(component)
    n = 61
    edges = [np.linspace(low, high, n + 1) for low, high in plane.box]
    first, second = ((edge[:-1] + edge[1:]) / 2 for edge in edges)
    grid = np.stack(np.meshgrid(first, second, indexing="ij"), axis=-1).reshape(-1, 2)
    heights = plane.curvature(grid)[:, row].reshape(n, n)
    whole, middle, spread = largest_region(first, second, heights, 1e-9)
    if whole == 0:
        raise ModelError(
            f"the curvature of the {reduction.machine.name} along {component} is zero within "
            f"{plane.box.tolist()}: no small cycle moves it that way."
        )
    sense = -int(np.sign(whole))
    search = PathSearch(_Gain(plane, row, sense), plane.box, harmonics, per)
    series = search.run(middle, spread)
    cosine, sine = np.zeros((2, harmonics, plane.base.size))
    base = plane.base.copy()
    base[plane.pair] = series[0]
    cosine[:, plane.pair], sine[:, plane.pair] = (
        series[1 : 1 + harmonics], sense * series[1 + harmonics :]
    )  # fmt: skip
    gait = FourierGait(offset=base, cosine=cosine, sine=sine, angular_frequency=omega)
    pose = reduction.line(gait)
    if reduction.group == "SE(3)":
        turn = pin.log3(pin.Quaternion(pose[3:]).toRotationMatrix())
        pose = np.concatenate((pose[:3], turn))
    times = np.arange(2048) * (2 * np.pi / omega) / 2048
    travel = float(np.linalg.norm(gait(times).rate, axis=1).mean() * 2 * np.pi / omega)
    moved = dict(zip(names, pose.tolist(), strict=True))
    return MachineCycle(gait=gait, component=component, moved=moved, travel=travel, per=per)


class _Gain:
    """A component of the net motion of a path of samples, and its change with each sample."""

    def __init__(self, plane: ShapePlane, row: int, sense: int) -> None:
        self.plane, self.sense = plane, sense
        planar = plane.reduction.group == "SE(2)"
        self.place = [0, 1, 5] if planar else list(range(6))
        self.row = self.place[row]

    def __call__(self, path: Array, rate: Array) -> tuple[float, Array]:
        n = len(path)
        # The other way round, from the same sample on.
        order = np.arange(n) if self.sense > 0 else -np.arange(n) % n
        path, rate = path[order], self.sense * rate[order]
        A = self.plane.connection(path)
        step = 2 * np.pi / n
        xi, bend = np.zeros((2, n, 6))
        xi[:, self.place] = -np.einsum("nbk,nk->nb", A, rate)
        bend[:, self.place] = -self.plane.curvature(path)
        halves = [pin.exp6(pin.Motion(0.5 * step * x)) for x in xi]
        g, moved = pin.SE3.Identity(), np.empty((n + 1, 6))
        for i in range(n):
            moved[i] = g.action @ bend[i]
            g = g * halves[i] * halves[(i + 1) % n]
        moved[n] = g.action @ bend[0]
        moved[0] = 0.5 * (moved[0] + moved[n])
        value, slope = _component(g, self.row)
        along = step * (moved[:n] @ slope)
        change = along[:, None] * np.column_stack((rate[:, 1], -rate[:, 0]))
        first = np.zeros((6, 2))
        first[self.place] = A[0]
        change[0] += slope @ (first - g.action @ first)
        back = np.empty_like(change)
        back[order] = change
        return value, back


def _component(g: pin.SE3, row: int) -> tuple[float, Array]:
    """x, y, z or an entry of the rotation vector of a motion, and its change (6,) with W of
    dg = W g."""
    if row < 3:
        turn = np.cross(g.translation, np.eye(3)[row])
        return float(g.translation[row]), np.concatenate((np.eye(3)[row], turn))
    slope = pin.Jlog3(g.rotation)[row - 3] @ g.rotation.T
    return float(pin.log3(g.rotation)[row - 3]), np.concatenate((np.zeros(3), slope))
