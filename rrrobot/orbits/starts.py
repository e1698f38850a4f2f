"""Several starts: which motions of a gait hold, and how many starts come to each.

Starts are drawn at random about the upright rest, carried until they have settled, and closed by
Newton's method after one period of the legs, two, and so on. What repeats after none of these goes
on otherwise: with two frequencies, without any order, or on a symmetric motion that does not hold
and is left by rounding errors alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array, finite, whole
from rrrobot.drive.gaits import Gait
from rrrobot.errors import OrbitError
from rrrobot.momentum.returns import carry, replicated
from rrrobot.orbits.found import LONGEST_STEP, prepared
from rrrobot.orbits.limit_cycles import LimitCycle, limit_cycle
from rrrobot.orbits.newton import ReturnMap, iterate

_SETTLING, _SLOW = 400, 20
"""Periods before the first look, and how many times as many where heading or place must come back,
which they do slowly."""
_SAME = 1e-6
"""Distance of two points of one motion, in scaled units."""
_MOVED = 0.1
"""How far Newton's method may lead from what a start came to."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Attractors:
    """The motions that random starts come to.

    Attributes:
        cycles: those that hold, the one that most starts come to first.
        share: of the starts that come to each (n,).
        elsewhere: share of those that go on without repeating in the periods that were tried.
        lost: share of those that tip over to the vertical or leave the numbers.
        spread: in which the starts lie, in scaled units: radians of tilt, and momentum likewise.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> gait = rr.SinusoidalGait(offset=np.pi / 2, amplitude=0.45, angular_frequency=5.2)
        >>> found = rr.orbits.attractors(model, gait, n_starts=16)
        >>> [round(c.yaw_rate, 3) for c in sorted(found.cycles, key=lambda c: c.yaw_rate)]
        [-0.216, 0.216]
    """

    cycles: list[LimitCycle]
    share: Array
    elsewhere: float
    lost: float
    spread: float

    def __len__(self) -> int:
        return len(self.cycles)

    def __iter__(self) -> Iterator[LimitCycle]:
        return iter(self.cycles)

    def to_dict(self) -> dict[str, Any]:
        """Plain data, for JSON."""
        cycles = [
            {"share": float(share)} | cycle.to_dict()
            for cycle, share in zip(self.cycles, self.share, strict=True)
        ]
        return {"cycles": cycles, "elsewhere": self.elsewhere, "lost": self.lost,
                "spread": self.spread}  # fmt: skip

    def __repr__(self) -> str:
        parts = [
            f"{100 * share:.0f} % to period {c.periods} at {1e3 * c.speed:.4g} mm/s, "
            f"{c.yaw_rate:.4g} rad/s"
            for c, share in zip(self.cycles, self.share, strict=True)
        ]
        for share, words in ((self.elsewhere, "go on without repeating"), (self.lost, "tip over")):
            if share:
                parts.append(f"{100 * share:.0f} % {words}")
        return f"Attractors({'; '.join(parts)})"


def attractors(
    model: Any,
    gait: Gait,
    *,
    n_starts: int = 32,
    spread: float = 0.5,
    periods: int = 4,
    seed: int = 0,
    yaw_gait: Gait | None = None,
) -> Attractors:
    """The motions to which a gait settles from several starts.

    Args:
        model, gait, yaw_gait: as for `limit_cycle`.
        n_starts: of them; the first is the upright impulsive start.
        spread: half the width of the box of starts in scaled units: [rad] of tilt. Headings on a
            slope are drawn from all.
        periods: of the legs, up to which a motion may take to repeat.
        seed: the same seed gives the same starts.

    Raises:
        GaitError, ModelError: as for `limit_cycle`.
        ParameterError: numbers out of range.
        OrbitError: every start tips over.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> found = rr.orbits.attractors(model, rr.gait("circular"), n_starts=8)
        >>> len(found), found.share.tolist()
        (1, [1.0])
    """
    case = prepared(model, gait, 1, yaw_gait)
    n, most = whole("n_starts", n_starts, at_least=1), whole("periods", periods, at_least=1)
    width = finite("spread", spread, above=0.0)
    P = case.map_of(max(36, int(np.ceil(case.period / LONGEST_STEP))))
    many = P._replace(cycles=replicated(P.cycles, n), scale=np.repeat(P.scale, n))
    x = width * np.random.default_rng(seed).uniform(-1, 1, (n, case.section.size))
    section = case.section
    if section.heads:
        x[:, -1] *= np.pi / width
    x[0] = 0.0
    long = _SETTLING * (_SLOW if section.heads or section.curvature else 1)
    came = section.point(carry(many.cycles, section.state(x, many.scale), long), many.scale)
    came = section.wrapped(came)
    alive = np.all(np.isfinite(came), axis=1)
    if not alive.any():
        raise OrbitError(
            f"all of {n} starts tip over under this gait: take a smaller spread= than {width:g}, "
            "or swing the legs less."
        )
    todo, cycles, counts = alive.copy(), [], []
    for count in range(1, most + 1):
        for point, members in _closed(many, came, todo, count):
            try:
                cycle = limit_cycle(model, gait, periods=count, near=point, yaw_gait=yaw_gait)
            except OrbitError:
                continue
            if cycle.stable:
                todo[members] = False
                cycles.append(cycle)
                counts.append(len(members))
    order = np.argsort(-np.array(counts, dtype=int), kind="stable")
    return Attractors(
        cycles=[cycles[i] for i in order], share=np.array(counts, dtype=float)[order] / n,
        elsewhere=float(todo.sum() / n), lost=float((~alive).sum() / n), spread=width,
    )  # fmt: skip


def _closed(
    P: ReturnMap, came: Array, todo: NDArray[np.bool_], count: int
) -> Iterator[tuple[Array, NDArray[np.int64]]]:
    """Orbits of so many periods near what starts came to: a point, and the starts that it has."""
    rows = np.flatnonzero(todo)
    if not rows.size:
        return
    some = P._replace(
        cycles=replicated(P.cycles, rows.size), scale=P.scale[rows], periods=count
    )  # fmt: skip
    roots = iterate(some, came[rows])
    near = roots.found & (np.abs(roots.point - came[rows]).max(axis=1, initial=0.0) <= _MOVED)
    left = np.flatnonzero(near)
    one = P._replace(cycles=replicated(P.cycles, 1), scale=P.scale[:1], periods=1)
    while left.size:
        point = roots.point[left[0]]
        # One motion, whichever of its periods a start has come to the beginning of.
        phases = [point]
        for _ in range(count - 1):
            phases.append(one(phases[-1][None])[0])
        apart = np.abs(roots.point[left][:, None] - np.array(phases)).max(axis=2, initial=0.0)
        same = apart.min(axis=1) <= _SAME
        same[0] = True
        yield point, rows[left[same]]
        left = left[~same]
