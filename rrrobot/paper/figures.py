"""The paper's figures, one short function each: data of any robot with two legs -> a figure.

`rrrobot reproduce` calls these with RRRobot of Table 2. The schematic ones are drawn from the
robot's own model; those of sweeps take two dimensions, offset and phase difference. Each returns a
matplotlib `Figure`: `fig_18(ds).savefig("fig18.png")`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rrrobot.drawing import FONT, legend_above, line, new_figure, tidy
from rrrobot.figures import maps
from rrrobot.figures.comparison import contact_paths, rolling_shell, single_axis
from rrrobot.figures.reduction import fig_13 as fig_13
from rrrobot.paper.labels import dimensions, leg_angles, lettered
from rrrobot.paper.schematic import schematic, turn_arrow
from rrrobot.paper.unicycle import unicycle
from rrrobot.robot.robot import Robot
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.studies.comparison import Comparison
from rrrobot.studies.modulation import pitch_yaw_phase_difference

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WINDOW = (0.0, 12.0)
"""Times of the angles of Figs 15 and 16 [s]: longer, the cycles of two models run together."""
_SWING = 0.5
"""Angle of the pale positions of the schematic figures [rad]."""


def fig_1(robot: Robot) -> Figure:
    """The robot with its masses, lettered as in the paper, its lengths and its leg angles."""
    figure = new_figure(7.2, 4.0)
    left, right = figure.subplots(1, 2)
    angles = np.linspace(0.25, 0.6, robot.n_legs) * np.pi
    schematic(robot, "front", left)
    schematic(robot, "side", right, leg_angle=angles)
    lettered(robot, left)
    dimensions(robot, left)
    leg_angles(robot, right, angles)
    _label(left, "(a) from the front, legs up")
    _label(right, "(b) from the side, legs apart")
    return figure


def fig_2(trajectory: Trajectory) -> Figure:
    """The path of a gait and the robot at its start and end."""
    return rolling_shell(trajectory, trajectory.time[[0, -1]])


def fig_3(robot: Robot) -> Figure:
    """The pivoting model in two parts: (a) the pivoted robot, (b) the shell rolling on a plane."""
    figure = new_figure(7.2, 3.1)
    left, right = figure.subplots(1, 2)
    for i, pitch in enumerate((-_SWING, _SWING, 0.0)):
        schematic(robot, "side", left, euler=(0, pitch, 0), pivoted=True, pale=i < 2)
        schematic(robot, "side", right, euler=(0, pitch, 0), pale=i < 2)
    _label(left, "(a) dynamics: pivoted at the centre")
    _label(right, "(b) kinematics: rolling on the plane")
    return figure


def fig_4(swings: Sequence[Trajectory], period: float) -> Figure:
    """A rolling wheel with an eccentric mass: its positions, and swings beside a cosine.

    Args:
        swings: of one robot, from rest at growing pitch angles, undamped.
        period: of small oscillations, eq (7) [s].
    """
    return _pendulum(swings, period, pivoted=False)


def fig_5(swings: Sequence[Trajectory], period: float) -> Figure:
    """A simple pendulum: its positions, and swings beside a cosine; see `fig_4` and eq (8)."""
    return _pendulum(swings, period, pivoted=True)


def fig_6(comparison: Comparison) -> Figure:
    """Contact paths of the lateral gait by the full and the pivoting model."""
    return contact_paths(comparison)


def fig_7(comparison: Comparison) -> Figure:
    """Contact paths of the circular gait by the full and the pivoting model."""
    return contact_paths(comparison)


def fig_8(robot: Robot) -> Figure:
    """The roll freedom."""
    return _freedom(robot, "front", 0, r"roll $\theta_r$")


def fig_9(robot: Robot) -> Figure:
    """The pitch freedom."""
    return _freedom(robot, "side", 1, r"pitch $\theta_p$")


def fig_10(robot: Robot) -> Figure:
    """The yaw freedom: (a) from above, (b) pivoted at the centre."""
    figure = new_figure(7.2, 3.1)
    left, right = figure.subplots(1, 2)
    for i, yaw in enumerate((-_SWING, _SWING, 0.0)):
        schematic(robot, "top", left, leg_angle=np.pi / 4, euler=(0, 0, yaw), pale=i < 2)
    schematic(robot, "front", right, leg_angle=np.pi / 4, pivoted=True)
    _label(left, r"(a) from above: yaw $\theta_y$")
    _label(right, "(b) from the front, pivoted")
    return figure


def fig_11(full: xr.Dataset, pitch: xr.Dataset) -> Figure:
    """Pitch amplitude over the plane of gaits: full and pitch model."""
    titles = ("full model", "pitch model")
    return maps.side_by_side(full.pitch_amplitude, pitch.pitch_amplitude, titles)


def fig_12(full: xr.Dataset, yaw: xr.Dataset) -> Figure:
    """Yaw amplitude over the plane of gaits: full and yaw model."""
    return maps.side_by_side(full.yaw_amplitude, yaw.yaw_amplitude, ("full model", "yaw model"))


def fig_14(full: xr.Dataset, pitch: xr.Dataset, yaw: xr.Dataset) -> Figure:
    """Pitch phase less yaw phase over the plane: full model, and pitch and yaw models."""
    return maps.side_by_side(
        pitch_yaw_phase_difference(full), pitch_yaw_phase_difference(pitch, yaw)
    )


def fig_15(comparison: Comparison) -> Figure:
    """Body angles and contact path of the lateral gait: full and single-axis models."""
    return single_axis(comparison, window=_WINDOW)


def fig_16(comparison: Comparison) -> Figure:
    """Body angles and contact path of the circular gait: full and single-axis models."""
    return single_axis(comparison, window=_WINDOW)


def fig_17(trajectories: dict[str, Trajectory]) -> Figure:
    """The robot as a unicycle."""
    return unicycle(trajectories)


def fig_18(full: xr.Dataset) -> Figure:
    """Speed, yaw rate and curvature over the plane of gaits, full model."""
    return maps.translation(full)


def fig_19(single_axis_models: xr.Dataset) -> Figure:
    """Speed, yaw rate and curvature over the plane of gaits, single-axis models."""
    return maps.translation(single_axis_models)


def fig_20(modulation: xr.DataArray) -> Figure:
    """Leg amplitude of the yaw model over the offset; see `studies.amplitude_modulation`."""
    return maps.modulation(modulation).figure  # type: ignore[return-value]


def fig_21(full: xr.Dataset) -> Figure:
    """Offset and phase difference over the plane of speed and yaw rate, full model."""
    return maps.inverse(full)


def fig_22(single_axis_models: xr.Dataset) -> Figure:
    """Offset and phase difference over the plane of speed and yaw rate, single-axis models."""
    return maps.inverse(single_axis_models)


def _freedom(robot: Robot, view: str, axis: int, name: str) -> Figure:
    figure = new_figure(5.2, 4.2)
    ax = figure.add_subplot()
    for i, angle in enumerate((-_SWING, _SWING, 0.0)):
        euler = np.zeros(3)
        euler[axis] = angle
        schematic(robot, view, ax, euler=euler, pale=i < 2)
    top = ax.dataLim.y1
    turn_arrow(ax, (0.0, top), 0.25 * top, name)
    ax.set_ylim(top=1.4 * top)
    return figure


def _pendulum(swings: Sequence[Trajectory], period: float, *, pivoted: bool) -> Figure:
    figure = new_figure(7.2, 2.9)
    left, right = figure.subplots(1, 2, width_ratios=(1.1, 1.5))
    for i, pitch in enumerate((-_SWING, _SWING, 0.0)):
        schematic(swings[0].robot, "side", left, euler=(0, pitch, 0), pivoted=pivoted, pale=i < 2)
    left.locator_params(axis="x", nbins=5)
    for i, swing in enumerate(swings):
        angle = swing.euler[:, 1]
        label = f"from {np.rad2deg(angle[0]):.2g} deg"
        right.plot(swing.time / period, angle / angle[0], label=label, **line(i))
    time = swings[0].time / period
    right.plot(time, np.cos(2 * np.pi * time), label="cosine", **line(len(swings)))
    tidy(right, "time / period of small swings", "pitch / first pitch")
    legend_above(right)
    return figure


def _label(ax: Axes, text: str) -> None:
    ax.set_title(text, fontsize=FONT + 1)
    ax.locator_params(axis="x", nbins=5)
