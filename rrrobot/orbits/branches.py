"""Branches of limit cycles as labelled data: made, saved, resumed, switched, drawn."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rrrobot.checks import Array, finite
from rrrobot.errors import BranchInterrupted, OutputError, ParameterError
from rrrobot.files import check_writable, write_whole
from rrrobot.orbits.continuation import CROSSING, DOUBLING, KINDS, Curve, Point, Walk
from rrrobot.orbits.limit_cycles import LimitCycle, cycle_of
from rrrobot.orbits.parameters import parameter_of
from rrrobot.progress import Progress, progress_of

if TYPE_CHECKING:
    import xarray as xr

_STEP, _LONGEST, _SHORTEST = 0.02, 0.1, 1e-5
_MOST = 500
_SWITCH_STEP = 0.01
_COLUMNS = {
    "speed": "m/s",
    "yaw_rate": "rad/s",
    "roll_amplitude": "rad",
    "pitch_amplitude": "rad",
    "yaw_amplitude": "rad",
    "roll_mean": "rad",
    "pitch_mean": "rad",
    "normal_force": "N",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Branch:
    """Limit cycles along one parameter.

    Attributes:
        parameter, unit: which.
        value: of the parameter at each point, in the order of the branch (n,).
        cycles: the limit cycle at each point.
        special: (kind, index of the point) of each event: "fold", "period doubling", "torus",
            "branch point".
        ended: why it goes no further, as a sentence.

    Example:
        >>> import rrrobot as rr
        >>> c = rr.limit_cycle(rr.FullModel(rr.Robot.from_parameters()), rr.gait("circular"))
        >>> b = rr.orbits.branch(c, "amplitude", to=0.35)
        >>> b.special, round(b.value[-1], 2), b.stable.all()
        ([], np.float64(0.35), np.True_)
    """

    parameter: str
    unit: str
    value: Array
    cycles: list[LimitCycle] = field(repr=False)
    special: list[tuple[str, int]]
    ended: str
    points: list[Point] = field(repr=False)

    @property
    def stable(self) -> Any:
        """Whether each cycle holds (n,)."""
        return np.array([cycle.stable for cycle in self.cycles])

    def at(self, kind: str) -> list[LimitCycle]:
        """The cycles at events of a kind."""
        return [self.cycles[i] for k, i in self.special if k == kind]

    def switched(
        self, kind: str = DOUBLING, number: int = 0, *, length: float = 0.05
    ) -> LimitCycle:
        """A cycle on the branch that leaves this one at a period doubling or a branch point.

        After a period doubling it repeats after twice the period.

        Args:
            kind: "period doubling" or "branch point".
            number: which of the branch's events of this kind.
            length: how far from it, in scaled units; negative: to the other side.

        Raises:
            ParameterError: there is no such event.
            OrbitError: Newton's method did not converge: take another length.
        """
        if kind not in (DOUBLING, CROSSING):
            raise ParameterError(f"kind is {kind!r}: it must be {DOUBLING!r} or {CROSSING!r}.")
        places = [i for name, i in self.special if name == kind]
        if not 0 <= number < len(places):
            raise ParameterError(
                f"number is {number!r}: this branch has {len(places)} events {kind!r}."
            )
        point = self.points[places[number]]
        found = point.found
        values, vectors = np.linalg.eig(point.monodromy)
        sign = -1.0 if kind == DOUBLING else 1.0
        direction = vectors[:, np.argmin(np.abs(values - sign))].real
        tangent = np.append(direction / np.linalg.norm(direction), 0.0)
        periods = found.case.periods * (2 if kind == DOUBLING else 1)
        case = replace(found.case, periods=periods)
        curve = Curve(case, parameter_of(case, self.parameter), found.steps, found.map.scale)
        start = np.append(found.point, curve.parameter.value / curve.parameter.size)
        # In small steps: near the event the parameter hardly changes, and Newton might leap.
        steps = max(1, math.ceil(abs(length) / _SWITCH_STEP))
        tangent *= math.copysign(1.0, length)
        away = curve.corrected(start + abs(length) / steps * tangent, tangent)
        for _ in range(steps - 1):
            away = curve.step(away, abs(length) / steps)
        return cycle_of(away.found)

    def to_dataset(self) -> xr.Dataset:
        """Numbers of all points, labelled, with units."""
        import xarray as xr

        n = len(self.cycles)
        angles = ("roll", "pitch", "yaw")
        values: dict[str, Any] = {
            "speed": [c.speed for c in self.cycles],
            "yaw_rate": [c.yaw_rate for c in self.cycles],
            "normal_force": [c.normal_force for c in self.cycles],
        }
        for i, name in enumerate(angles):
            values[f"{name}_amplitude"] = [c.amplitude[i] for c in self.cycles]
        for i, name in enumerate(angles[:2]):
            values[f"{name}_mean"] = [c.mean[i] for c in self.cycles]
        variables: dict[str, Any] = {
            name: ("point", np.array(values[name]), {"units": unit})
            for name, unit in _COLUMNS.items()
        }
        multipliers = np.array([c.multipliers for c in self.cycles])
        kinds = np.full(n, "", dtype="<U16")
        for kind, i in self.special:
            kinds[i] = kind
        variables |= {
            "stable": ("point", self.stable.astype(np.int8)),
            "event": ("point", kinds.astype("S16")),
            "multiplier_real": (("point", "multiplier"), multipliers.real),
            "multiplier_imag": (("point", "multiplier"), multipliers.imag),
            "z": (("point", "coordinate"), np.array([p.z for p in self.points])),
            "tangent": (("point", "coordinate"), np.array([p.tangent for p in self.points])),
        }
        coords = {self.parameter: ("point", self.value, {"units": self.unit})}
        first = self.cycles[0]
        attrs = {
            "parameter": self.parameter,
            "ended": self.ended,
            "case": _label(first, self.parameter),
            "steps": first.steps_per_cycle,
            "scale": float(first.found.map.scale[0]),
        }
        return xr.Dataset(variables, coords, attrs)

    def save(self, path: str | Path) -> Path:
        """Write the dataset to a netCDF file, whole or not at all; `store=` resumes from one."""
        return write_whole(Path(path), bytes(self.to_dataset().to_netcdf(engine="scipy")))

    def plot(self, output: str = "speed", ax: Any = None) -> Any:
        """Bifurcation diagram: stable parts solid, unstable ones dashed, events marked."""
        from rrrobot.orbits.plots_parameters import plot_branch

        return plot_branch(self, output, ax)

    def _repr_html_(self) -> str:
        from rrrobot.orbits.plots_parameters import branch_html

        return branch_html(self)

    def __repr__(self) -> str:
        events = ", ".join(
            f"{kind} at {self.value[i]:.9g}" for kind, i in self.special
        )  # fmt: skip
        low, high = self.value.min(), self.value.max()
        return (
            f"Branch({self.parameter} from {low:.4g} to {high:.4g} {self.unit}, "
            f"{len(self.cycles)} points{', ' + events if events else ''}; {self.ended})"
        )


def branch(
    cycle: LimitCycle,
    parameter: str,
    to: float,
    *,
    back: float | None = None,
    step: float | None = None,
    n_points: int = _MOST,
    store: str | Path | None = None,
    progress: Progress = False,
) -> Branch:
    """Follow a limit cycle as one parameter of gait, robot, damping, ground or gravity changes.

    Args:
        cycle: where to start.
        parameter: its name, such as `amplitude`, `offset[0]`, `angular_frequency`, `leg_mass`,
            `damping`, `slope`, `boulder_radius`; a wrong one is answered with the list.
        to: value towards which to go, where the branch ends [the parameter's unit].
        back: value at which it ends if a fold turns it round; as far again behind the start if
            None.
        step: largest step along the branch in scaled units: 1 rad of angles, the value itself of
            other parameters, order one of the state; 0.1 if None.
        n_points: at most so many.
        store: a netCDF file (.nc) that keeps the branch: written at the end and when interrupted.
            If it holds the start of this branch, it is gone on from there.
        progress: see `rrrobot.progress`; in points, of the most.

    Raises:
        ParameterError: there is no such parameter; `to` is where the cycle is; numbers out of
            range, such as a damping that is not above zero.
        OrbitError: not even the first step is possible.
        OutputError: the store is another branch's, or cannot be written.
        BranchInterrupted: Ctrl-C; `.branch` holds the points so far.

    Example:
        >>> import rrrobot as rr
        >>> c = rr.limit_cycle(rr.FullModel(rr.Robot.from_parameters()), rr.gait("circular"))
        >>> line = rr.orbits.branch(c, "leg_mass", to=0.06)
        >>> round(float(line.value[-1]), 6), line.special
        (0.06, [])
    """
    case = cycle.found.case
    chosen = parameter_of(case, parameter)
    goal = finite("to", to, chosen.unit)
    if goal == chosen.value:
        raise ParameterError(f"to is {to!r} {chosen.unit}: that is where the cycle is already.")
    behind = chosen.behind(goal) if back is None else finite("back", back, chosen.unit)
    chosen.check("to", goal)
    chosen.check("back", behind)
    longest = _LONGEST if step is None else finite("step", step, above=0)
    if isinstance(n_points, bool) or not isinstance(n_points, int) or n_points < 1:
        raise ParameterError(f"n_points is {n_points!r}: it must be a whole number, at least 1.")
    low, high = min(goal, behind), max(goal, behind)
    curve = Curve(case, chosen, cycle.steps_per_cycle, cycle.found.map.scale)
    first = curve.start(cycle.point)
    if goal < chosen.value:
        first = replace(first, tangent=-first.tangent, crossing=-first.crossing)
    made: list[Point] = [first]
    special: list[tuple[str, int]] = []
    path = None if store is None else check_writable(Path(store))
    if path is not None and path.exists():
        made, special = _read(path, curve, cycle, parameter)
    walk = Walk(curve, min(_STEP, longest), longest, _SHORTEST)
    try:
        with progress_of(progress, "points", n_points, "points", len(made) - 1) as tell:
            for point, kind in walk.points(
                made[-1], lambda value: low <= value <= high, n_points - len(made) + 1
            ):
                if kind == "end":
                    point = _at_end(curve, made[-1], point, goal, behind)
                elif kind:
                    special.append((kind, len(made)))
                made.append(point)
                if tell is not None:
                    tell(len(made) - 1)
    except KeyboardInterrupt:
        walk.ended = "interrupted"
        kept = _made(curve, parameter, made, special, walk.ended, path)
        raise BranchInterrupted(
            f"the branch was interrupted after {len(made)} points; the error's .branch holds them"
            f"{'' if path is None else f', and so does {str(path)!r}'}.",
            kept,
        ) from None
    return _made(curve, parameter, made, special, walk.ended, path)


def _at_end(curve: Curve, last: Point, beyond: Point, goal: float, behind: float) -> Point:
    """The point where the parameter has the value at which the branch ends."""
    from scipy.optimize import brentq

    over = curve.value(beyond.z)
    inside = curve.value(last.z)
    bound = goal if (over - goal) * (inside - goal) <= 0 else behind
    if inside == bound:
        return beyond
    length = float(last.tangent @ (beyond.z - last.z))
    root = brentq(
        lambda s: curve.value(curve.step(last, s).z) - bound, 0.0, length, xtol=1e-9, rtol=1e-12
    )
    # Newton at the parameter's value itself.
    near = curve.step(last, float(root))
    z = np.append(near.z[:-1], bound / curve.parameter.size)
    straight = np.append(np.zeros(z.size - 1), 1.0)
    return curve.corrected(z, straight, near.tangent)


def _made(
    curve: Curve, parameter: str, made: list[Point], special: list[tuple[str, int]], ended: str,
    path: Path | None,
) -> Branch:  # fmt: skip
    result = Branch(
        parameter=parameter,
        unit=curve.parameter.unit,
        value=np.array([curve.value(point.z) for point in made]),
        cycles=[cycle_of(point.found) for point in made],
        special=special,
        ended=ended,
        points=made,
    )
    if path is not None:
        result.save(path)
    return result


def _label(cycle: LimitCycle, parameter: str) -> str:
    """What a branch is of, apart from the parameter that changes along it."""
    gait = cycle.gait.to_dict()
    model = json.dumps(cycle.model.to_dict(), sort_keys=True)
    return json.dumps([parameter, cycle.periods, gait.get("type"), hash_of(model)])


def hash_of(text: str) -> str:
    """A short mark of a text."""
    import hashlib

    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _read(
    path: Path, curve: Curve, cycle: LimitCycle, parameter: str
) -> tuple[list[Point], list[tuple[str, int]]]:
    """Points of a file, made anew from their coordinates."""
    import xarray as xr

    try:
        with xr.open_dataset(path, engine="scipy") as file:
            data = file.load()
        same = data.attrs["parameter"] == parameter and data.z.shape[1] == cycle.point.size + 1
        start = data.z.values[0]
    except Exception as error:  # a damaged file raises almost anything
        raise OutputError(f"{str(path)!r} is not a branch that rrrobot saved: {error}.") from error
    here = np.append(cycle.point, curve.parameter.value / curve.parameter.size)
    if not same or not np.allclose(start, here, atol=1e-7):
        raise OutputError(
            f"{str(path)!r} holds another branch (in {data.attrs['parameter']}, from another "
            "cycle): give another file, or remove it."
        )
    made = []
    for z, tangent in zip(data.z.values, data.tangent.values, strict=True):
        made.append(replace(curve.corrected(z, tangent), tangent=tangent))
    kinds = [bytes(kind).decode().strip("\0") for kind in data.event.values]
    special = [(kind, i) for i, kind in enumerate(kinds) if kind in KINDS]
    if math.isclose(made[-1].z[-1], made[0].z[-1]) and len(made) > 1:
        made = made[:1]
    return made, special
