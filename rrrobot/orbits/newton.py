"""Newton and Broyden steps on a return map that was tabulated for a search.

With P the map of a state to that one period later, an orbit is a root of F(x) = P(x) - x. Each
lane keeps an approximate inverse H of dF/dx: the difference quotients of the flow over one period
at first, or a neighbour's, then Broyden's updates, so that a step costs one period of simulation:

    dx = -H F,      H += (dx - H dF) (dx^T H) / (dx^T H dF)

A step that makes the residual grow much is halved; where these go astray, `descend` takes no step
that does not lead down. Orbits are found whether they are stable or not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.momentum.newton import FORWARD, GROWTH, HALVINGS, LARGEST_STEP, TOLERANCE
from rrrobot.momentum.returns import Cycles, carry, replicated
from rrrobot.orbits.section import Section, momentum_scale

_CENTRAL = 2e-3
_DESCENTS, _LEAST_PART, _NEAR = 15, 1e-3, 1e-4
"""Most steps that lead down, the least part of one that is tried, and the residual at which
Broyden's steps are safe again."""


class ReturnMap(NamedTuple):
    """P of n gaits: the state's coordinates one period (or some) of the legs later."""

    cycles: Cycles
    section: Section
    scale: Array
    periods: int

    def __call__(self, x: Array) -> Array:
        """P(x) (n, size)."""
        y = carry(self.cycles, self.section.state(x, self.scale), self.periods)
        return self.section.point(y, self.scale)


class Roots(NamedTuple):
    """How the iterations ended."""

    point: Array
    """(n, size)"""
    residual: Array
    """largest entry of |P(x) - x| (n,)"""
    inverse: Array
    """approximate inverse of dF/dx (n, size, size)"""
    iterations: NDArray[np.int64]
    """periods that each gait took (n,)"""

    @property
    def found(self) -> NDArray[np.bool_]:
        """Which are orbits (n,)."""
        return self.residual <= TOLERANCE


def return_map(cycles: Cycles, section: Section, periods: int = 1) -> ReturnMap:
    """The return map of gaits."""
    return ReturnMap(cycles, section, momentum_scale(cycles), periods)


def _rough_derivative(P: ReturnMap, x: Array, image: Array) -> Array:
    """dP/dx (n, size, size) by forward differences; to about 1e-7."""
    return _differences(P, x, ((0, -1.0), (1, 1.0)), FORWARD, image)


def derivative(P: ReturnMap, x: Array) -> Array:
    """dP/dx (n, size, size) by central differences of sixth order of the flow; to about 1e-11.

    The map is one of fixed steps, so it is smooth to the last digits and differences of high order
    lose none but the last three.
    """
    return _differences(P, x, STENCIL, _CENTRAL)


def _differences(
    P: ReturnMap,
    x: Array,
    stencil: tuple[tuple[int, float], ...],
    step: float,
    image: Array | None = None,
) -> Array:
    n, d = x.shape
    moved = np.array([x + k * step * e for e in np.eye(d) for k, _ in stencil if k != 0])
    if n == 1:
        # All starts of one gait fill the lanes.
        many = P._replace(
            cycles=replicated(P.cycles, len(moved)), scale=np.repeat(P.scale, len(moved))
        )
        images = many(moved[:, 0])[:, None] if len(moved) else moved
    else:
        images = np.array([P(some) for some in moved])
    out, place = np.zeros((n, d, d)), 0
    for j in range(d):
        for k, weight in stencil:
            if k == 0:
                out[:, :, j] += weight / step * image  # type: ignore[operator]
                continue
            out[:, :, j] += weight / step * images[place]
            place += 1
    return out


STENCIL = tuple((k, w / 60) for k, w in ((-3, -1), (-2, 9), (-1, -45), (1, 45), (2, -9), (3, 1)))
"""Points, in steps, and weights of the central difference of sixth order."""


def iterate(P: ReturnMap, x: Array, inverse: Array | None = None, *, limit: int = 30) -> Roots:
    """Roots of P(x) - x from starts x (n, size); see the module.

    Args:
        P: of n gaits.
        x: starts.
        inverse: of dF/dx (n, size, size); by differences at x if None.
        limit: most steps.
    """
    n, d = x.shape
    x = x.copy()
    F = P(x) - x
    count = np.ones(n, dtype=np.int64)
    if inverse is None:
        H = _inverses(_rough_derivative(P, x, F + x) - np.eye(d))
        count += d
    else:
        H = inverse.copy()
    size = _size(F)
    halved = np.zeros(n, dtype=np.int64)
    dx = _step(H, F)
    todo = np.isfinite(size)
    for _ in range(limit):
        todo &= ~((size <= 0.03 * TOLERANCE) | ((size <= TOLERANCE) & (_size(dx) <= TOLERANCE)))
        if not todo.any():
            break
        trial = np.where(todo[:, None], x + dx, x)
        new = P(trial) - trial
        count[todo] += 1
        new_size = _size(new)
        worse = todo & ~(new_size <= GROWTH * size + TOLERANCE) & (halved < HALVINGS)
        fine = todo & ~worse & np.isfinite(new_size)
        # Rounding: neither smaller nor larger means there is no more to gain.
        floor = fine & (new_size >= 0.5 * size) & (size <= TOLERANCE)
        H[fine] = _updated(H[fine], dx[fine], (new - F)[fine])
        x[fine], F[fine], size[fine] = trial[fine], new[fine], new_size[fine]
        halved[fine] = 0
        halved[worse] += 1
        todo &= (fine | worse) & ~floor
        dx = np.where(worse[:, None], 0.5 * dx, _step(H, F))
    return Roots(x, np.where(np.isfinite(size), size, np.inf), H, count)


def descend(P: ReturnMap, x: Array) -> tuple[Array, int]:
    """Nearer to a root of F = P(x) - x from a start x (1, size), and the periods that it took.

    Newton's steps with a new derivative at each, halved until |F| is less by a tenth of the part
    that is taken: slower than `iterate`, and where that goes astray it does not. They end near a
    root, or where no step leads down.
    """
    F = P(x) - x
    count = 1
    for _ in range(_DESCENTS):
        dx = _step(_inverses(_rough_derivative(P, x, F + x) - np.eye(x.shape[1])), F)
        count += 1 + x.shape[1]
        part, before = 1.0, np.linalg.norm(F)
        while part > _LEAST_PART:
            trial = x + part * dx
            new = P(trial) - trial
            count += 1
            if np.linalg.norm(new) < (1.0 - 0.1 * part) * before:
                break
            part *= 0.5
        else:
            break
        x, F = trial, new
        if _size(F)[0] < _NEAR:
            break
    return x, count


def _size(F: Array) -> Array:
    return np.abs(F).max(axis=1, initial=0.0)


def _step(H: Array, F: Array) -> Array:
    dx = -np.einsum("nij,nj->ni", H, F)
    long = _size(dx)
    return np.asarray(dx * np.minimum(1.0, LARGEST_STEP / np.maximum(long, 1e-300))[:, None])


def _inverses(matrices: Array) -> Array:
    """Inverses, or zero where there is none; a step is then none, and the lane stays unfound."""
    out = np.zeros_like(matrices)
    good = np.all(np.isfinite(matrices), axis=(1, 2))
    with np.errstate(all="ignore"):
        try:
            out[good] = np.linalg.inv(matrices[good])
        except np.linalg.LinAlgError:
            out[good] = np.linalg.pinv(matrices[good])
    return out


def _updated(H: Array, dx: Array, dF: Array) -> Array:
    """Broyden's update of inverses; where its divisor is too small, H as it was."""
    Hy = np.einsum("nij,nj->ni", H, dF)
    left = np.einsum("ni,nij->nj", dx, H)
    divisor = np.einsum("ni,ni->n", dx, Hy)
    usable = np.abs(divisor) > 0.05 * np.einsum("ni,ni->n", dx, dx)
    over = np.where(usable, 1.0, 0.0) / np.where(usable, divisor, 1.0)
    return np.asarray(H + np.einsum("ni,nj->nij", (dx - Hy) * over[:, None], left))
