"""Plots of one trajectory: angles, path, energy, contact force, legs."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array
from rrrobot.drawing import (
    BLACK,
    COLOURS,
    FONT,
    GREY,
    PALE,
    legend_above,
    line,
    new_axes,
    new_figure,
    tidy,
)
from rrrobot.errors import ParameterError
from rrrobot.robot.joints import sliding
from rrrobot.simulation.steady import steady_state

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rrrobot.simulation.trajectory import Trajectory

LEG_CYCLES = 4
"""Cycles that the plot of the legs shows where a run has many more: its last ones."""
START_CYCLES = 8
"""Cycles after which a path's mean is drawn; the rocking of the start has died out in the paper's
gaits by then."""
_TIME = "time [s]"


def plot(trajectory: Trajectory, kind: str = "all", ax: Axes | None = None) -> Axes | Figure:
    """Plot one aspect of a trajectory.

    Args:
        trajectory: any.
        kind: "angles": roll, pitch, yaw [deg]; "path": the contact point [cm], with its mean
            over one period of the gait after the first eight; "energy" [J]; "force": the contact
            force along the ground's normal and in the ground plane [N], with the weight; "legs":
            angles [deg] in the upper half and motor torques [N m] in the lower half, on a twin of
            `ax`;
            "all": all of these in one figure.
        ax: where to draw; axes in a new figure if None. Not for "all".

    Returns:
        the Axes; for "all" the Figure.

    Raises:
        ParameterError: no such kind, or `ax` with "all".

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> t = rr.simulate(model, rr.gait("lateral"), duration=1.0)
        >>> t.plot("path").get_xlabel()
        'x [cm]'
    """
    if kind == "all":
        if ax is not None:
            raise ParameterError("kind 'all' makes its own figure: leave out ax, or name a kind.")
        return _all(trajectory)
    if kind not in KINDS:
        raise ParameterError(f"kind is {kind!r}: it must be one of {', '.join((*KINDS, 'all'))}.")
    if ax is None:
        ax = new_axes()
    KINDS[kind](trajectory, ax)
    return ax


def cycle_mean(time: Array, values: Array, period: float) -> tuple[Array, Array]:
    """Mean over one period around each time that has half a period on both sides.

    Args:
        time: (n,) [s].
        values: (n, k).
        period: [s].

    Returns:
        times (m,) and means (m, k); m = 0 if the run is shorter than a period.
    """
    from scipy.interpolate import make_interp_spline

    half = 0.5 * period
    middle = time[(time >= time[0] + half) & (time <= time[-1] - half)]
    if not middle.size:
        return middle, np.empty((0, values.shape[1]))
    integral = make_interp_spline(time, values, k=min(3, time.size - 1)).antiderivative()
    return middle, (integral(middle + half) - integral(middle - half)) / period


def mean_path(trajectory: Trajectory) -> tuple[Array, Array] | None:
    """Times (n,) [s] and the contact point's mean over the gait's period around each (n, 2) [m].

    Windows that would reach over an end are left out, and in a run of more than twice as many the
    first cycles too: the rocking of the start is no drift, and its mean a tangle. None if nothing
    is left.
    """
    period = trajectory.period
    if period is None or period > trajectory.time[-1]:
        return None
    time, mean = cycle_mean(trajectory.time, trajectory.position, period)
    if trajectory.time[-1] > 2 * START_CYCLES * period:
        later = time >= START_CYCLES * period
        time, mean = time[later], mean[later]
    return time, mean


def _angles(trajectory: Trajectory, ax: Axes) -> None:
    for i, name in enumerate(("roll", "pitch", "yaw")):
        ax.plot(trajectory.time, np.rad2deg(trajectory.euler[:, i]), label=name, **line(i))
    tidy(ax, _TIME, "angle [deg]")
    _whole_time(trajectory, ax)
    legend_above(ax)


def _path(trajectory: Trajectory, ax: Axes) -> None:
    x, y = 100 * trajectory.position.T
    means = mean_path(trajectory)
    path = line(0) if means is None else {"color": PALE, "linewidth": 0.9}
    ax.plot(x, y, label="contact point", **path)
    if means is not None:
        label = "mean over a cycle"
        ax.plot(*100 * means[1].T, color=COLOURS[0], linewidth=2.0, label=label)
    mark: dict[str, Any] = {"linestyle": "none", "markeredgecolor": BLACK, "zorder": 5}
    ax.plot(x[:1], y[:1], marker="o", markerfacecolor="white", label="start", **mark)
    ax.plot(x[-1:], y[-1:], marker="s", markerfacecolor=BLACK, label="end", **mark)
    tidy(ax, "x [cm]", "y [cm]")
    ax.set_aspect("equal", adjustable="datalim")
    legend_above(ax, columns=2)


def _energy(trajectory: Trajectory, ax: Axes) -> None:
    ax.plot(trajectory.time, trajectory.energy, label="kinetic + potential", **line(0))
    tidy(ax, _TIME, "energy [J]")
    _whole_time(trajectory, ax)
    _say_if_missing(trajectory.energy, ax)
    legend_above(ax)


def _force(trajectory: Trajectory, ax: Axes) -> None:
    robot = trajectory.robot
    normal = trajectory.normal_force
    tangent = trajectory.contact_force - normal[:, None] * trajectory.ground_normal
    ax.plot(trajectory.time, normal, label="normal", **line(0))
    ax.plot(trajectory.time, np.linalg.norm(tangent, axis=1), label="tangential", **line(1))
    if trajectory.has_contact:
        # Where the normal changes along the way, the weight's share along it does too.
        slope = trajectory.ground_normal[0, 2] if trajectory.ground.fixed_normal is not None else 1
        label = "m g" if slope == 1 else "m g cos(slope)"
        weight = robot.mass * trajectory.gravity * slope
        ax.axhline(weight, label=label, color=BLACK, linestyle=":", linewidth=1.4)
    tidy(ax, _TIME, "contact force [N]" if trajectory.has_contact else "force of the pivot [N]")
    _whole_time(trajectory, ax)
    _say_if_missing(normal, ax)
    if trajectory.lift_off_time is not None:
        end = trajectory.time[-1]
        ax.axvspan(
            trajectory.lift_off_time, end, color=GREY, alpha=0.3, lw=0, label="after lift-off"
        )
    legend_above(ax)


def _legs(trajectory: Trajectory, ax: Axes) -> None:
    slides = sliding(trajectory.robot.model, trajectory.robot.legs)
    scale = np.where(slides, 1000.0, 180 / np.pi)
    angle, torque = trajectory.leg_angle * scale, trajectory.leg_torque
    lower = ax.twinx()
    for i, name in enumerate(trajectory.robot.legs):
        ax.plot(trajectory.time, angle[:, i], label=name, **line(i))
        lower.plot(trajectory.time, torque[:, i], label=name, **line(i))
    tidy(ax, _TIME, _units("leg angle [deg]", "leg position [mm]", "leg [deg, mm]", slides))
    tidy(lower, _TIME, _units("torque [N m]", "force [N]", "motor [N m, N]", slides))
    lower.set_xlabel("")
    lower.grid(False)
    lower.spines["right"].set_visible(True)
    since = _last_cycles(trajectory)
    ax.set_xlim(since, trajectory.time[-1])
    shown = trajectory.time >= since
    _halve(ax, angle[shown], upper=True)
    _halve(lower, torque[shown], upper=False)
    ax.plot((0, 1), (0.5, 0.5), color=GREY, linewidth=0.8, transform=ax.transAxes)
    if trajectory.robot.legs:
        legend_above(ax)


KINDS: dict[str, Callable[[Trajectory, Any], None]] = {
    "angles": _angles,
    "path": _path,
    "energy": _energy,
    "force": _force,
    "legs": _legs,
}
"""What `plot` can draw on one Axes."""


def _all(trajectory: Trajectory) -> Figure:
    figure = new_figure(12.0, 8.4)
    panels = figure.subplot_mosaic(
        [["path", "angles"], ["path", "force"], ["energy", "legs"]],
        width_ratios=(1.0, 1.7),
    )
    for kind, draw in KINDS.items():
        draw(trajectory, panels[kind])
    figure.suptitle(_title(trajectory), fontsize=11)
    return figure


def _title(trajectory: Trajectory) -> str:
    title = f"{trajectory.robot.name}, {trajectory.model_name} model, {trajectory.time[-1]:g} s"
    try:
        state = steady_state(trajectory)
    except ParameterError:
        return title
    speed, rate = 1000 * state.speed, round(np.rad2deg(state.yaw_rate), 2) + 0.0
    if state.settled:
        return f"{title}: settled at {speed:.2f} mm/s, {rate:.2f} deg/s"
    travel, spread = 1000 * state.mean_travel, 1000 * state.spread
    return f"{title}: not settled, mean travel {travel:.2f} +- {spread:.2f} mm/s"


def _whole_time(trajectory: Trajectory, ax: Axes) -> None:
    if trajectory.time[-1] > trajectory.time[0]:
        ax.set_xlim(trajectory.time[0], trajectory.time[-1])


def _last_cycles(trajectory: Trajectory) -> float:
    """Time from which the legs are shown [s]."""
    start, end = float(trajectory.time[0]), float(trajectory.time[-1])
    if trajectory.period is None or end - start < 2 * LEG_CYCLES * trajectory.period:
        return start
    return end - LEG_CYCLES * trajectory.period


def _units(turning: str, slid: str, mixed: str, slides: NDArray[np.bool_]) -> str:
    if not slides.any():
        return turning
    return slid if slides.all() else mixed


def _halve(ax: Axes, values: Array, *, upper: bool) -> None:
    """Y limits that put the values into the upper or lower half, with ticks there only."""
    from matplotlib.ticker import MaxNLocator

    good = values[np.isfinite(values)]
    low, high = (float(good.min()), float(good.max())) if good.size else (0.0, 1.0)
    pad = 0.08 * (high - low) or 0.05 * max(abs(high), 1.0)
    low, high = low - pad, high + pad
    span = high - low
    ax.set_ylim((low - span, high) if upper else (low, high + span))
    ticks = MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    ax.set_yticks([tick for tick in ticks if low <= tick <= high])
    ax.set_ylabel(ax.get_ylabel(), fontsize=FONT, loc="top" if upper else "bottom")


def _say_if_missing(values: Array, ax: Axes) -> None:
    """Where a model does not compute a quantity, say so on the empty axes."""
    if not np.isfinite(values).any():
        note = "not computed by this model"
        ax.text(0.5, 0.5, note, transform=ax.transAxes, ha="center", va="center")
