"""Derivatives of a limit cycle with respect to everything that it depends on.

With P(x, p) the return map, an orbit x(p) obeys x = P(x, p), so that by the implicit function
theorem

    dx/dp = (1 - dP/dx)^-1 dP/dp,

and any measure m(x, p) of the cycle changes by dm/dp + dm/dx dx/dp: its derivative along that
tangent. A multiplier mu with left and right vectors l, r changes by l (dM/dp) r / (l r), M being
dP/dx along the tangent. Everything is a derivative of the flow over one period; no settled motions
are subtracted from each other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.errors import ParameterError
from rrrobot.orbits.found import Case
from rrrobot.orbits.limit_cycles import LimitCycle
from rrrobot.orbits.measures import look, measures
from rrrobot.orbits.newton import STENCIL, ReturnMap, derivative
from rrrobot.orbits.parameters import Parameter, parameter_of, parameters_of

OUTPUTS = {
    "speed": "m/s",
    "yaw_rate": "rad/s",
    "curvature": "1/m",
    "roll_amplitude": "rad",
    "pitch_amplitude": "rad",
    "yaw_amplitude": "rad",
}
"""What is differentiated, with its unit."""
_STEP = 2e-3
"""Of the stencil, in a parameter's size."""
SMALL = 0.01
"""The change that an effect is of: 0.01 rad of an angle, one percent of other parameters."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensitivities:
    """How a limit cycle changes with each parameter.

    Attributes:
        cycle: the limit cycle.
        parameters: what it depends on.
        derivatives: of each of `OUTPUTS` with respect to each parameter (n,), SI units.
        multipliers: d mu / dp, complex, in the order of the cycle's multipliers (n, m). NaN
            where two multipliers coincide, which have no derivative.
        points: dx/dp of the cycle's coordinates (n, size).

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> s = rr.orbits.sensitivities(
        ...     rr.limit_cycle(model, rr.gait("circular")), ["leg_mass", "damping"]
        ... )
        >>> s.names
        ('leg_mass', 'damping')
    """

    cycle: LimitCycle
    parameters: tuple[Parameter, ...]
    derivatives: dict[str, Array]
    multipliers: NDArray[np.complex128]
    points: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        return tuple(p.name for p in self.parameters)

    def of(self, output: str, parameter: str) -> float:
        """The derivative of one output with respect to one parameter.

        Raises:
            ParameterError: there is no such output or parameter.
        """
        values = self._values(output)
        if parameter not in self.names:
            raise ParameterError(
                f"there is no parameter {parameter!r} here: it must be one of "
                f"{', '.join(self.names)}."
            )
        return float(values[self.names.index(parameter)])

    def effects(self, output: str) -> Array:
        """Change of an output by 0.01 rad of each angle, one percent of each other (n,)."""
        return np.array([p.size * SMALL for p in self.parameters]) * self._values(output)

    def ranked(self, output: str) -> list[str]:
        """Names of the parameters, that with the largest effect on an output first."""
        order = np.argsort(-np.abs(self.effects(output)), kind="stable")
        return [self.names[i] for i in order]

    def _values(self, output: str) -> Array:
        if output not in self.derivatives:
            raise ParameterError(
                f"output is {output!r}: it must be one of {', '.join(self.derivatives)}."
            )
        return self.derivatives[output]

    def plot(self, output: str = "speed", ax: Any = None, count: int = 12) -> Any:
        """Bars of the largest effects on an output; returns the Axes."""
        from rrrobot.orbits.plots_parameters import plot_effects

        self._values(output)
        return plot_effects(self, output, OUTPUTS[output], ax, count)

    def to_dict(self) -> dict[str, Any]:
        """Plain data, for JSON."""
        return {
            "parameters": [
                {"name": p.name, "value": p.value, "unit": p.unit}
                | {f"d_{k}": float(v[i]) for k, v in self.derivatives.items()}
                | {"d_multipliers": [[m.real, m.imag] for m in self.multipliers[i].tolist()]}
                for i, p in enumerate(self.parameters)
            ]
        }


def sensitivities(cycle: LimitCycle, parameters: Sequence[str] | None = None) -> Sensitivities:
    """Derivatives of a limit cycle with respect to parameters of gait, robot and damping.

    Args:
        cycle: from `limit_cycle`.
        parameters: names, as `offset[0]`, `amplitude`, `leg_mass`, `damping_roll`; all if None.

    Raises:
        ParameterError: a parameter that does not exist; the cycle has a multiplier of one, so it
            is the end of a branch (a fold) and has no derivative.
    """
    case = cycle.found.case
    if parameters is None:
        chosen = tuple(parameters_of(case).values())
    else:
        chosen = tuple(parameter_of(case, name) for name in parameters)
    gap = np.eye(case.section.size) - cycle.found.monodromy
    if case.section.size and np.linalg.cond(gap) > 1e12:
        raise ParameterError(
            "a multiplier is one: the cycle is at a fold of its branch, where it has no derivative."
        )
    rows = [_along(cycle, parameter, gap) for parameter in chosen]
    names = tuple(OUTPUTS)
    return Sensitivities(
        cycle=cycle,
        parameters=chosen,
        derivatives={k: np.array([row[0][i] for row in rows]) for i, k in enumerate(names)},
        multipliers=np.array([row[1] for row in rows]).reshape(len(rows), -1),
        points=np.array([row[2] for row in rows]).reshape(len(rows), -1),
    )


def _along(
    cycle: LimitCycle, parameter: Parameter, gap: Array
) -> tuple[Array, NDArray[np.complex128], Array]:
    """Derivatives of the outputs and the multipliers, and dx/dp."""
    found, x = cycle.found, cycle.point
    step = _STEP * parameter.size

    def map_at(k: int) -> tuple[Case, ReturnMap]:
        case = parameter.at(parameter.value + k * step)
        # One chart for all, so that points compare.
        return case, case.map_of(found.steps)._replace(scale=found.map.scale)

    maps = {k: map_at(k) for k, _ in STENCIL}
    by_parameter = _stencil(lambda k: maps[k][1](x[None])[0]) / step
    tangent = np.asarray(np.linalg.solve(gap, by_parameter), dtype=float) if x.size else x

    def outputs(k: int) -> Array:
        case, P = maps[k]
        y = case.section.state((x + k * step * tangent)[None], P.scale)
        m = measures(P.cycles, look(P.cycles, y, case.periods), case.periods)
        return np.array((m.speed[0], m.yaw_rate[0], *m.amplitude[0]))

    def monodromy(k: int) -> Array:
        return derivative(maps[k][1], (x + k * step * tangent)[None])[0]

    slopes = _stencil(outputs) / step
    change = _stencil(monodromy) / step
    v, alpha = cycle.speed, cycle.yaw_rate
    curving = (slopes[1] - alpha / v * slopes[0]) / v if v > 1e-12 else np.nan
    return (
        np.array((slopes[0], slopes[1], curving, *slopes[2:])),
        _eigenvalue_slopes(cycle, change),
        tangent,
    )


def _stencil(f: Callable[[int], Array]) -> Array:
    return np.asarray(sum(weight * f(k) for k, weight in STENCIL))


def _eigenvalue_slopes(cycle: LimitCycle, change: Array) -> NDArray[np.complex128]:
    out = np.full(cycle.multipliers.size, np.nan, dtype=np.complex128)
    if not out.size:
        return out
    values, right = np.linalg.eig(cycle.found.monodromy)
    left = np.linalg.inv(right) if np.linalg.cond(right) < 1e12 else None
    for i, multiplier in enumerate(cycle.multipliers):
        j = int(np.argmin(np.abs(values - multiplier)))
        others = np.delete(values, j)
        if left is not None and np.all(np.abs(others - values[j]) > 1e-7):
            out[i] = left[j] @ change @ right[:, j]
    return out
