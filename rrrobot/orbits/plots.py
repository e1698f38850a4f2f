"""Plots of a limit cycle: angles and legs over the cycle, multipliers, path."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

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

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rrrobot.orbits.limit_cycles import LimitCycle

_SAMPLES = 200
_PATH_PERIODS = 12


def plot_cycle(cycle: LimitCycle, kind: str = "all", ax: Axes | None = None) -> Any:
    """One aspect of a limit cycle; see `LimitCycle.plot`.

    Raises:
        ParameterError: no such kind, or `ax` with "all".
    """
    kinds = {"angles": _angles, "legs": _legs, "multipliers": _multipliers, "path": _path}
    if kind == "all":
        if ax is not None:
            raise ParameterError("kind 'all' makes a figure of its own: leave ax out.")
        figure = new_figure(9.0, 6.4)
        for place, draw in zip(figure.subplots(2, 2).ravel(), kinds.values(), strict=True):
            draw(cycle, place)
        state = "stable" if cycle.stable else "unstable"
        figure.suptitle(
            f"{state} limit cycle: {1e3 * cycle.speed:.4g} mm/s, {cycle.yaw_rate:.4g} rad/s",
            fontsize=FONT + 1,
        )
        return figure
    if kind not in kinds:
        raise ParameterError(f"kind is {kind!r}: it must be one of {', '.join(kinds)}, all.")
    ax = ax or new_axes()
    kinds[kind](cycle, ax)
    return ax


def _angles(cycle: LimitCycle, ax: Axes) -> None:
    angles = np.unwrap(cycle.found.sight.angles[0], axis=0)
    # The end is the start, turned.
    end = np.where(np.isfinite(cycle.mean), angles[0] + (0.0, 0.0, cycle.turn), np.nan)
    angles = np.rad2deg(np.vstack((angles, end)))
    time = np.linspace(0.0, cycle.period, len(angles))
    for i, name in enumerate(("roll", "pitch", "yaw")):
        ax.plot(time, angles[:, i], label=name, **line(i))
    tidy(ax, "time in the cycle [s]", "angle [deg]")
    legend_above(ax)


def _legs(cycle: LimitCycle, ax: Axes) -> None:
    t = cycle.trajectory(cycle.period, cycle.period / _SAMPLES)
    for i, name in enumerate(cycle.model.robot.legs):
        ax.plot(t.time, t.leg_torque[:, i], label=name, **line(i))
    tidy(ax, "time in the cycle [s]", "motor torque [N m]")
    if len(cycle.model.robot.legs) <= 4:
        legend_above(ax)


def _multipliers(cycle: LimitCycle, ax: Axes) -> None:
    turn = np.linspace(0, 2 * np.pi, 200)
    ax.plot(np.cos(turn), np.sin(turn), color=GREY, linewidth=0.8)
    inside = np.abs(cycle.multipliers) < 1
    for chosen, colour, mark in ((inside, COLOURS[0], "o"), (~inside, COLOURS[1], "X")):
        some = cycle.multipliers[chosen]
        ax.plot(some.real, some.imag, mark, color=colour, markersize=6)
    tidy(ax, "real part of the multipliers", "imaginary part")
    ax.set_aspect("equal", "datalim")


def _path(cycle: LimitCycle, ax: Axes) -> None:
    periods = _PATH_PERIODS if cycle.stable else 3
    duration = periods * cycle.period
    t = cycle.trajectory(duration, cycle.period / 48)
    ax.plot(*(100 * t.position.T), color=PALE, linewidth=1.0)
    starts, step = [cycle.position], cycle.displacement
    c, s = np.cos(cycle.turn), np.sin(cycle.turn)
    for _ in range(periods):
        starts.append(starts[-1] + step)
        step = np.array(((c, -s), (s, c))) @ step
    ax.plot(*(100 * np.array(starts).T), ".", color=BLACK, markersize=5, label="start of a cycle")
    tidy(ax, "x [cm]", "y [cm]")
    ax.set_aspect("equal", "datalim")
    legend_above(ax)
