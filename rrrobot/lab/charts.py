"""Plots of a motion over one period, or over a run."""

from __future__ import annotations

from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.lab.outcome import Outcome
from rrrobot.simulation.trajectory import Trajectory

COLOURS = ("#d62728", "#2ca02c", "#1f57b4", "#222222", "#9467bd", "#8c564b")
_MOST_POINTS = 1200
_MOST_LEGS = 6
_HEIGHT = 170


class Charts:
    """Angles, legs, torques, forces and energy, one above the other.

    Args:
        gui: of a client of viser.
        legs: names of the legs.
    """

    def __init__(self, gui: Any, legs: tuple[str, ...]) -> None:
        self._gui, self._legs = gui, legs[:_MOST_LEGS]
        self._plots: dict[str, Any] = {}
        names = {
            "roll, pitch, yaw [deg]": ("roll", "pitch", "yaw"),
            "leg angles [deg]": self._legs,
            "leg torques [mN m]": self._legs,
            "contact force [N]": ("along the normal", "along the ground"),
            "energy, from its mean [mJ]": ("energy",),
        }
        still = np.array((0.0, 1.0))
        for title, lines in names.items():
            series: list[dict[str, Any]] = [{"label": "t [s]"}]
            series += [
                {"label": line, "stroke": colour, "width": 2}
                for line, colour in zip(lines, COLOURS, strict=False)
            ]
            self._plots[title] = gui.add_uplot(
                (still, *(0 * still for _ in lines)), tuple(series), title=title, height=_HEIGHT,
                scales={"x": {"time": False}, "y": {"auto": True}},
                axes=({"size": 26}, {"size": 46}),
                legend={"show": True},
            )  # fmt: skip

    def show(self, outcome: Outcome) -> None:
        """Draw the lines of a motion."""
        t = outcome.trajectory
        pick = slice(None, None, 1 + len(t) // _MOST_POINTS)
        for plot, lines in zip(self._plots.values(), curves(t), strict=True):
            kept = lines[pick]
            if kept.shape[1] > _MOST_LEGS:
                kept = kept[:, :_MOST_LEGS]
            plot.data = (t.time[pick], *np.ascontiguousarray(kept.T))


def curves(t: Trajectory) -> tuple[Array, ...]:
    """What the plots show, each (n, lines)."""
    normal = t.normal_force
    along = np.linalg.norm(t.contact_force - normal[:, None] * t.ground_normal, axis=1)
    return (
        np.rad2deg(t.euler),
        np.rad2deg(t.leg_angle),
        1e3 * t.leg_torque,
        np.column_stack((normal, along)),
        1e3 * (t.energy - t.energy.mean())[:, None],
    )
