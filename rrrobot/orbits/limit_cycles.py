"""Limit cycles: the motion that a gait settles to, found directly, and whether it holds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait
from rrrobot.inline import html_table
from rrrobot.orbits.found import Found, find, prepared
from rrrobot.rotations import euler_rates
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True, eq=False)
class LimitCycle:
    """A motion that repeats after some periods of the legs, up to a displacement in the plane.

    The cycle starts at t = 0 of the gait, at the origin with yaw 0. On a slope its heading comes
    back too, and only the place advances; on a boulder or a bowl it is turned about the top or the
    bottom, where its contact does not start.

    Attributes:
        model, gait: whose; `yaw_gait` is the yaw model's own, if decoupled.
        periods: of the legs, after which the motion repeats.
        period: of the motion [s].
        speed: of the cycle mean of the contact point, zero or more [m/s].
        velocity: along the body's mean x and y axes (2,) [m/s]; y is the leg axis.
        yaw_rate: mean, positive to the left [rad/s].
        amplitude, phase: of the first harmonic of roll, pitch, yaw (3,) [rad], as
            `SteadyState` has them.
        mean: of roll, pitch, yaw over the cycle (3,) [rad].
        displacement: of the contact point in the cycle (2,) [m].
        turn: of the yaw in the cycle [rad]. Of a body that turns over it is known up to whole
            turns, and what rests on Euler angles (velocity, amplitude, phase, mean) is NaN.
        multipliers: Floquet multipliers of tilt and momentum over the period, complex, largest
            first; a deviation is multiplied by them in each period.
        normal_force: least over the cycle [N]; NaN for decoupled models.
        residual: largest difference of tilt and momentum after the period, in scaled units.
        steps_per_cycle: fixed steps in a period of the legs.
        iterations: periods simulated to find it.
        euler, euler_rates: roll, pitch, yaw and their rates at the start (3,) [rad], [rad/s]; the
            yaw is zero but on a slope.
        position: of the contact at the start (2,) [m]; zero but on a boulder.
        point: coordinates of the start, for a neighbour's search.

    Example:
        >>> import rrrobot as rr
        >>> c = rr.limit_cycle(rr.FullModel(rr.Robot.from_parameters()), rr.gait("circular"))
        >>> c.stable, round(c.speed, 6), round(c.yaw_rate, 6)
        (True, 0.006676, 0.020855)
    """

    model: Any
    gait: Gait
    yaw_gait: Gait | None = None
    periods: int
    period: float
    speed: float
    velocity: Array
    yaw_rate: float
    amplitude: Array
    phase: Array
    mean: Array
    displacement: Array
    turn: float
    multipliers: NDArray[np.complex128]
    normal_force: float
    residual: float
    steps_per_cycle: int
    iterations: int
    euler: Array
    euler_rates: Array
    position: Array
    point: Array
    found: Found = field(repr=False)
    """the engine's view, for sensitivities and continuation"""

    @property
    def stable(self) -> bool:
        """Whether deviations die away: every multiplier is smaller than one."""
        return bool(np.all(np.abs(self.multipliers) < 1.0))

    @property
    def curvature(self) -> float:
        """yaw_rate / speed [1/m]; infinite for a turn on the spot, zero if nothing moves."""
        if self.speed > 1e-12:
            return self.yaw_rate / self.speed
        return math.copysign(math.inf, self.yaw_rate) if abs(self.yaw_rate) > 1e-12 else 0.0

    @property
    def centre(self) -> Array:
        """Centre of the circle on which the cycle's starts lie (2,) [m]; NaN if it is straight."""
        half = 0.5 * self.turn
        if abs(math.sin(half)) < 1e-12:
            return np.full(2, np.nan)
        x, y = self.displacement
        cot = math.cos(half) / math.sin(half)
        return self.position + 0.5 * np.array((x - cot * y, y + cot * x))

    @property
    def settling_times(self) -> Array:
        """Time in which the deviation of each multiplier falls to 1/e [s]; negative if it grows."""
        with np.errstate(divide="ignore"):
            return np.asarray(-self.period / np.log(np.abs(self.multipliers)))

    @property
    def frequencies(self) -> Array:
        """At which the deviation of each multiplier turns, seen once a period [rad/s].

        From 0 to pi / period: a rocking at w looks the same as one at w + 2 pi / period.
        """
        return np.asarray(np.abs(np.angle(self.multipliers)) / self.period)

    @property
    def lifts_off(self) -> bool:
        """Whether the normal force is not positive somewhere: the real robot would jump."""
        rolls = self.model.name == "decoupled" or self.model.rolling is not None
        return bool(rolls and self.normal_force <= 0.0)

    def trajectory(
        self, duration: float | None = None, sample_interval: float = 0.01
    ) -> Trajectory:
        """The motion from the start of the cycle on, with forces and torques.

        Args:
            duration: [s]; one period unless given. An unstable cycle is left in time, as rounding
                errors grow.
            sample_interval: [s].

        Example:
            >>> import rrrobot as rr
            >>> c = rr.limit_cycle(rr.FullModel(rr.Robot.from_parameters()), rr.gait("lateral"))
            >>> bool(abs(c.trajectory(10.0).steady_state().speed / c.speed - 1) < 1e-6)
            True
        """
        duration = self.period if duration is None else duration
        step = self.period / self.periods / self.steps_per_cycle
        if self.model.name == "decoupled":
            from rrrobot.simulation.recombined import decoupled

            roll, pitch, yaw = self.model.models
            return decoupled(
                self.model.robot, self.gait, duration, sample_interval, yaw_gait=self.yaw_gait,
                roll=roll, pitch=pitch, yaw=yaw, step=step, euler=self.euler,
                start=self.euler_rates,
            )  # fmt: skip
        return simulate(
            self.model, self.gait, duration, sample_interval, euler=self.euler,
            position=self.position, start=self.euler_rates, step=step, method="momentum",
        )  # fmt: skip

    def plot(self, kind: str = "all", ax: Any = None) -> Any:
        """Plot "angles" and "legs" over the cycle, "multipliers" in the complex plane, the "path"
        of some cycles, or "all" in one figure.

        Returns:
            the Axes, or the Figure for "all".
        """
        from rrrobot.orbits.plots import plot_cycle

        return plot_cycle(self, kind, ax)

    def to_dict(self) -> dict[str, Any]:
        """All numbers as plain data, for JSON; multipliers as [real, imaginary]."""
        data: dict[str, Any] = {
            name: getattr(self, name)
            for name in (
                "periods", "period", "speed", "yaw_rate", "turn", "normal_force", "residual",
                "steps_per_cycle", "iterations", "stable", "lifts_off",
            )
        }  # fmt: skip
        for name in ("velocity", "amplitude", "phase", "mean", "displacement", "euler",
                     "euler_rates", "position", "frequencies", "settling_times"):  # fmt: skip
            data[name] = getattr(self, name).tolist()
        data["curvature"] = self.curvature if math.isfinite(self.curvature) else None
        data["multipliers"] = [[m.real, m.imag] for m in self.multipliers.tolist()]
        return data

    def _repr_html_(self) -> str:
        rows = {
            "model": self.model.name,
            "gait": self.gait,
            "period": f"{self.period:.6g} s",
            "speed": f"{1000 * self.speed:.4f} mm/s",
            "yaw rate": f"{self.yaw_rate:.6f} rad/s",
            "multipliers": ", ".join(f"{m:.4g}" for m in self.multipliers[:4]),
            "it holds": "yes" if self.stable else "NO: a disturbance grows",
        }
        if self.lifts_off:
            rows["contact"] = "it LIFTS OFF"
        return html_table("Limit cycle", rows, figure=self.plot("angles").figure)

    def __repr__(self) -> str:
        largest = abs(self.multipliers[0]) if self.multipliers.size else 0.0
        return (
            f"LimitCycle({self.model.name} model, period {self.period:.4g} s, "
            f"speed {1e3 * self.speed:.5g} mm/s, yaw rate {self.yaw_rate:.5g} rad/s, "
            f"{'stable' if self.stable else 'UNSTABLE'}, largest multiplier {largest:.4g}"
            f"{', LIFTS OFF' if self.lifts_off else ''})"
        )


def limit_cycle(
    model: Any,
    gait: Gait,
    *,
    periods: int = 1,
    near: LimitCycle | ArrayLike | None = None,
    yaw_gait: Gait | None = None,
    steps_per_cycle: int | None = None,
) -> LimitCycle:
    """The motion that repeats under a gait, and whether it holds.

    Newton's method on the map of tilt and momentum over a period of the legs; the cycle may be
    unstable.

    Args:
        model: any of the five models, or `DecoupledModels`, with damping, on level ground, a
            slope, a boulder or a bowl. On a slope the cycle is one whose heading comes back, if
            there is any: one that holds, nearest to yaw zero.
        gait: that repeats.
        periods: of the legs, after which the motion repeats; 2 after a period doubling. A cycle
            that repeats sooner is one too, and may be what is found.
        near: a neighbour's cycle, or the coordinates of a start (its `point`); what the impulsive
            upright start comes to in 25 periods if None.
        yaw_gait: of the yaw model alone, for `DecoupledModels`.
        steps_per_cycle: of the fixed-step DOP853; as many as leave an error below 1e-11 if None.

    Raises:
        GaitError: the gait does not repeat, its legs do not move, or it does not fit the robot.
        ModelError: the model has no damping, or is none that the engine runs, or its ground is no
            two places alike.
        OrbitError: none was found, no heading comes back on the slope, or the cycle passes through
            the vertical where the damping is singular. The message says how the search ended.
        ParameterError: periods or steps out of range.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> c = rr.limit_cycle(model, rr.gait("lateral"))
        >>> abs(c.multipliers).round(3).tolist()
        [0.674, 0.674, 0.575, 0.575, 0.09]
    """
    case = prepared(model, gait, periods, yaw_gait, steps_per_cycle)
    at = near.point if isinstance(near, LimitCycle) else near
    return cycle_of(find(case, None if at is None else np.asarray(at, dtype=float)))


def cycle_of(found: Found) -> LimitCycle:
    """The public view of what the engine found."""
    m, case = found.measures, found.case
    angle, omega = found.sight.angles[0, 0], found.sight.motion[0, 0, 3:6]
    rates = omega if case.model.name == "decoupled" else euler_rates(angle, omega)
    multipliers = np.linalg.eigvals(found.monodromy).astype(np.complex128)
    order = np.lexsort((-multipliers.imag, -np.abs(multipliers).round(12)))
    return LimitCycle(
        model=case.model, gait=case.gait, yaw_gait=case.yaw_gait, periods=case.periods,
        period=case.periods * case.period, speed=float(m.speed[0]), velocity=m.velocity[0],
        yaw_rate=float(m.yaw_rate[0]), amplitude=m.amplitude[0], phase=m.phase[0], mean=m.mean[0],
        displacement=m.displacement[0], turn=float(m.turn[0]), multipliers=multipliers[order],
        normal_force=float(m.normal_force[0]), residual=found.residual,
        steps_per_cycle=found.steps, iterations=found.iterations,
        euler=angle.copy(), euler_rates=rates, position=found.sight.start[0, 7:9].copy(),
        point=found.point,
        found=found,
    )  # fmt: skip
