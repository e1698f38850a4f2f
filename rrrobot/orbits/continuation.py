"""Branches of limit cycles in one parameter, by pseudo-arclength, through folds.

With lambda the parameter in units of its size, a point z = (x, lambda) of a branch obeys
F(z) = P(x, lambda) - x = 0. From a point with unit tangent t a step of length s goes to the root of

    F(z) = 0,    t . (z - z_0) = s,

by Newton's method on central differences of the flow over one period. Between two points an event
is where a test function changes sign; it is located by bracketing in s:

    fold               the tangent's part along lambda
    period doubling    det(M + 1), M = dP/dx
    torus              |mu|^2 - 1 of the largest complex pair
    branch point       det of dF/dz with t below it: a second branch crosses, as where a symmetric
                       motion loses its symmetry
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import OrbitError, RRRobotError
from rrrobot.momentum.newton import TOLERANCE
from rrrobot.orbits.found import LONGEST_STEP, Case, Found, described
from rrrobot.orbits.newton import STENCIL, ReturnMap, derivative
from rrrobot.orbits.parameters import Parameter

_PARAMETER_STEP = 1e-3
_NEWTON = 12
_SHRINK, _GROW = 0.5, 1.4
_EASY = 4
"""Newton steps up to which the next step may be longer."""
_LOCATED = 1e-11
_STEEP = 0.98
"""Sine of the pitch beyond which a branch is lost at the vertical."""
FOLD, DOUBLING, TORUS, CROSSING = "fold", "period doubling", "torus", "branch point"
KINDS = (FOLD, DOUBLING, TORUS, CROSSING)


@dataclass(frozen=True, kw_only=True)
class Point:
    """A point of a branch: coordinates, parameter, tangent, derivative, what was found."""

    z: Array
    """x, then lambda (size + 1,)"""
    tangent: Array
    """(size + 1,)"""
    monodromy: Array
    found: Found
    crossing: float
    """test function of a branch point"""
    newton: int
    """Newton steps that it took"""

    def tests(self) -> dict[str, float]:
        """Test functions of the events."""
        mu = np.linalg.eigvals(self.monodromy)
        pairs = [
            (mu[i] * mu[j] - 1).real
            for i in range(mu.size)
            for j in range(i)
            if abs(mu[i].imag) > 1e-9 and abs(mu[i] - mu[j].conj()) < 1e-9
        ]
        return {
            FOLD: float(self.tangent[-1]),
            DOUBLING: float(np.prod(mu + 1.0).real) if mu.size else 1.0,
            TORUS: float(max(pairs, default=-1.0)),
            CROSSING: self.crossing,
        }


class Curve:
    """Points of a branch of orbits of a case, as one of its parameters changes."""

    def __init__(self, case: Case, parameter: Parameter, steps: int, scale: Array) -> None:
        self.case, self.parameter, self.steps, self._scale = case, parameter, steps, scale
        self._maps: dict[float, tuple[Case, ReturnMap]] = {}

    def value(self, z: Array) -> float:
        """Of the parameter at a point."""
        return float(z[-1] * self.parameter.size)

    def start(self, x: Array) -> Point:
        """The point at the parameter's own value; the tangent points to larger ones."""
        z = np.append(x, self.parameter.value / self.parameter.size)
        towards = np.append(np.zeros(x.size), 1.0)
        return self.corrected(z, towards, towards)

    def corrected(self, z: Array, tangent: Array, orientation: Array | None = None) -> Point:
        """The point of the branch in the plane through z across a tangent.

        Raises:
            OrbitError: Newton's method does not converge.
        """
        anchor, size, last = z.copy(), np.inf, np.inf
        for n in range(_NEWTON):
            case, P = self._map(z[-1])
            F = P(z[None, :-1])[0] - z[:-1]
            last, size = size, float(np.abs(F).max(initial=0.0))
            slope = self._slope(z, P)
            if size <= TOLERANCE or (size <= 20 * TOLERANCE and size > 0.3 * last):
                unit = self._tangent(slope, tangent if orientation is None else orientation)
                monodromy = slope[:, :-1] + np.eye(F.size)
                found = described(case, P, z[:-1], monodromy=monodromy)
                crossing = float(np.linalg.det(np.vstack((slope, unit))))
                return Point(
                    z=z, tangent=unit, monodromy=monodromy, found=found, crossing=crossing, newton=n
                )
            if not np.isfinite(size) or size > 10.0 or not np.all(np.isfinite(slope)):
                break
            whole = np.vstack((slope, tangent))
            z = z - np.linalg.lstsq(whole, np.append(F, tangent @ (z - anchor)), rcond=1e-14)[0]
        raise OrbitError(
            f"the branch was lost at {self.parameter.name} = {self.value(z):.6g} "
            f"{self.parameter.unit}: Newton's method ended with a residual of {size:.2g} in scaled "
            "units. Take a smaller step=."
        )

    @staticmethod
    def _tangent(slope: Array, along: Array) -> Array:
        """Unit null vector of dF/dz that is nearest to a direction."""
        whole = np.vstack((slope, along))
        if np.linalg.cond(whole) > 1e9:
            # At a branch point two directions are null; the branch keeps its own.
            null = np.linalg.svd(slope)[2][-2:]
            unit = null.T @ (null @ along)
        else:
            unit = np.linalg.solve(whole, np.append(np.zeros(len(slope)), 1.0))
        return np.asarray(unit / np.linalg.norm(unit))

    def step(self, point: Point, length: float) -> Point:
        """The point a step further along the branch."""
        return self.corrected(point.z + length * point.tangent, point.tangent)

    def located(self, point: Point, length: float, kind: str) -> Point:
        """The event between a point and the step after it."""
        from scipy.optimize import brentq

        cache: dict[float, Point] = {0.0: point}

        def test(s: float) -> float:
            if s not in cache:
                cache[s] = self.step(point, s)
            return cache[s].tests()[kind]

        root = float(brentq(test, 0.0, length, xtol=_LOCATED, rtol=1e-13, maxiter=60))
        test(root)
        return cache[root]

    def _map(self, place: float) -> tuple[Case, ReturnMap]:
        if place not in self._maps:
            if len(self._maps) > 8:
                self._maps.clear()
            case = self.parameter.at(place * self.parameter.size)
            steps = max(self.steps, int(np.ceil(case.period / LONGEST_STEP)))
            # One chart for the whole branch, so that its points compare.
            self._maps[place] = case, case.map_of(steps)._replace(scale=self._scale)
        return self._maps[place]

    def _slope(self, z: Array, P: ReturnMap) -> Array:
        """dF/dz (size, size + 1)."""
        x = z[:-1]
        by_parameter = sum(
            weight * self._map(z[-1] + k * _PARAMETER_STEP)[1](x[None])[0] for k, weight in STENCIL
        )
        by_state = derivative(P, x[None])[0] - np.eye(x.size)
        return np.column_stack((by_state, np.asarray(by_parameter) / _PARAMETER_STEP))


@dataclass
class Walk:
    """How a walk along a branch goes on, and how it ended."""

    curve: Curve
    step: float
    longest: float
    shortest: float
    ended: str = ""

    def points(
        self, point: Point, inside: Callable[[float], bool], most: int
    ) -> Iterator[tuple[Point, str]]:
        """Points after the first, and events between them by kind ("" for a plain point)."""
        parameter = self.curve.parameter
        for _ in range(most):
            try:
                new = self._stepped(point)
            except RRRobotError as error:
                self.ended = self._why(point, error)
                return
            before, after = point.tests(), new.tests()
            for kind in KINDS:
                if before[kind] * after[kind] < 0:
                    if kind == TORUS and min(before[kind], after[kind]) <= -1.0:
                        continue
                    try:
                        yield self.curve.located(point, self._taken, kind), kind
                    except (RRRobotError, ValueError):
                        continue
            if not inside(self.curve.value(new.z)):
                self.ended = f"{parameter.name} came to the end of its range"
                yield new, "end"
                return
            yield new, ""
            force = new.found.measures.normal_force[0]
            if force <= 0.0 and new.found.case.setting.parameters[1] > 0.0:
                self.ended = (
                    f"the normal force reaches zero near {parameter.name} = "
                    f"{self.curve.value(new.z):.6g} {parameter.unit}: from there on the robot "
                    "would lift off"
                )
                return
            point = new
        self.ended = f"{most} points were made"

    def _why(self, point: Point, error: RRRobotError) -> str:
        """Why there is no next point."""
        if point.found.case.setting.limit >= 1.0 or point.found.measures.pitch[0] < _STEEP:
            return str(error)
        parameter = self.curve.parameter
        return (
            f"the pitch reaches 90 degrees near {parameter.name} = "
            f"{self.curve.value(point.z):.6g} {parameter.unit}, where the damping on Euler rates "
            "is singular: go on with BodyRateDamping"
        )

    def _stepped(self, point: Point) -> Point:
        while True:
            try:
                new = self.curve.step(point, self.step)
                if new.tangent @ point.tangent > 0.8 or self.step <= 2 * self.shortest:
                    break
            except RRRobotError:
                if self.step <= 2 * self.shortest:
                    raise
            self.step *= _SHRINK
        self._taken = self.step
        if new.newton <= _EASY and new.tangent @ point.tangent > 0.97:
            self.step = min(self.longest, _GROW * self.step)
        return new
