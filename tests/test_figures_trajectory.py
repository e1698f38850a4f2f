"""Plots of a trajectory: units, data, and no trace left in pyplot."""

from __future__ import annotations

import dataclasses
import io
import sys

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import rrrobot as rr
from rrrobot.drawing import COLOURS, LINES, line
from rrrobot.simulation.plots import KINDS, cycle_mean, plot


@pytest.fixture(scope="module")
def run() -> rr.Trajectory:
    model = rr.FullModel(rr.Robot.from_parameters())
    return rr.simulate(model, rr.gait("circular"), duration=8.0)


@pytest.fixture(scope="module")
def pivoted() -> rr.Trajectory:
    model = rr.PivotingModel(rr.Robot.from_parameters())
    return rr.simulate(model, rr.StillLegs((1.5, 1.6)), duration=0.3)


def curve(ax: Axes, label: str) -> np.ndarray:
    (found,) = [artist for artist in ax.get_lines() if artist.get_label() == label]
    return np.array(found.get_data(), dtype=float)


def twin(ax: Axes) -> Axes:
    (other,) = [a for a in ax.figure.axes if a is not ax and a.bbox.bounds == ax.bbox.bounds]
    return other


@pytest.mark.parametrize(
    ("kind", "x", "y"),
    [
        ("angles", "time [s]", "angle [deg]"),
        ("path", "x [cm]", "y [cm]"),
        ("energy", "time [s]", "energy [J]"),
        ("force", "time [s]", "contact force [N]"),
        ("legs", "time [s]", "leg angle [deg]"),
    ],
)
def test_labels_have_units(run: rr.Trajectory, kind: str, x: str, y: str) -> None:
    ax = run.plot(kind)
    assert (ax.get_xlabel(), ax.get_ylabel()) == (x, y)
    assert ax.get_legend() is not None


def test_motor_torque_has_its_own_axis(run: rr.Trajectory) -> None:
    ax = run.plot("legs")
    assert twin(ax).get_ylabel() == "torque [N m]"
    # The two halves do not meet.
    low, high = ax.get_ylim()
    angle = np.rad2deg(run.leg_angle)
    assert angle.min() > (low + high) / 2
    low, high = twin(ax).get_ylim()
    assert run.leg_torque[run.time > run.time[-1] - 3.0].max() < (low + high) / 2


def test_data_of_the_curves(run: rr.Trajectory) -> None:
    for i, name in enumerate(("roll", "pitch", "yaw")):
        expected = (run.time, np.rad2deg(run.euler[:, i]))
        np.testing.assert_array_equal(curve(run.plot("angles"), name), expected)
    path = run.plot("path")
    np.testing.assert_array_equal(curve(path, "contact point"), 100 * run.position.T)
    np.testing.assert_array_equal(curve(path, "start")[:, 0], 100 * run.position[0])
    np.testing.assert_array_equal(curve(path, "end")[:, 0], 100 * run.position[-1])
    assert path.get_aspect() == 1.0
    energy = curve(run.plot("energy"), "kinetic + potential")
    np.testing.assert_array_equal(energy, (run.time, run.energy))
    force = run.plot("force")
    np.testing.assert_array_equal(curve(force, "normal")[1], run.contact_force[:, 2])
    tangential = np.hypot(*run.contact_force[:, :2].T)
    np.testing.assert_allclose(curve(force, "tangential")[1], tangential, rtol=1e-12)
    weight = 0.52 * 9.81
    np.testing.assert_allclose(curve(force, "m g")[1], weight, rtol=1e-12)
    legs = run.plot("legs")
    np.testing.assert_array_equal(curve(legs, "leg_2")[1], np.rad2deg(run.leg_angle[:, 1]))
    np.testing.assert_array_equal(curve(twin(legs), "leg_2")[1], run.leg_torque[:, 1])


def test_cycle_mean_of_a_drifting_oscillation() -> None:
    time = np.linspace(0.0, 10.0, 2001)
    values = np.column_stack((0.3 * time + np.sin(8 * time), np.cos(8 * time) - 2.0))
    middle, means = cycle_mean(time, values, np.pi / 4)
    assert middle[0] == pytest.approx(np.pi / 8, abs=0.005)
    np.testing.assert_allclose(means[:, 0], 0.3 * middle, atol=1e-4)
    np.testing.assert_allclose(means[:, 1], -2.0, atol=1e-4)
    assert cycle_mean(time[:50], values[:50], np.pi / 4)[1].shape == (0, 2)


def test_mean_path_is_drawn_where_there_is_a_period(
    run: rr.Trajectory, pivoted: rr.Trajectory
) -> None:
    assert run.period is not None
    _, means = cycle_mean(run.time, 100 * run.position, run.period)
    drawn = curve(run.plot("path"), "mean over a cycle")
    np.testing.assert_allclose(drawn, means.T, rtol=1e-12)
    labels = [artist.get_label() for artist in pivoted.plot("path").get_lines()]
    assert labels == ["contact point", "start", "end"]


def test_given_axes_are_used(run: rr.Trajectory) -> None:
    ax = Figure().add_subplot()
    for kind in KINDS:
        ax = Figure().add_subplot()
        assert plot(run, kind, ax) is ax
        assert ax.get_lines()


def test_all_is_one_figure_with_every_kind(run: rr.Trajectory) -> None:
    figure = run.plot("all")
    assert isinstance(figure, Figure)
    assert len(figure.axes) == len(KINDS) + 1
    drawn = {ax.get_ylabel() for ax in figure.axes}
    assert drawn == {
        *("angle [deg]", "y [cm]", "energy [J]", "contact force [N]"),
        *("leg angle [deg]", "torque [N m]"),
    }
    for kind in ("png", "svg"):
        stream = io.BytesIO()
        figure.savefig(stream, format=kind)
        assert stream.tell() > 10_000


def test_nothing_of_a_panel_overlaps_another(run: rr.Trajectory) -> None:
    figure = run.plot("all")
    figure.savefig(io.BytesIO(), format="png")
    pairs = {ax.bbox.bounds: [] for ax in figure.axes}
    for ax in figure.axes:
        pairs[ax.bbox.bounds].append(ax.get_tightbbox())
    boxes = [type(group[0]).union(group) for group in pairs.values()]
    for i, one in enumerate(boxes):
        for other in boxes[:i]:
            assert type(one).intersection(one, other) is None


def test_pyplot_is_left_alone(run: rr.Trajectory) -> None:
    run.plot("all").savefig(io.BytesIO(), format="png")
    pyplot = sys.modules.get("matplotlib.pyplot")
    assert pyplot is None or pyplot.get_fignums() == []


def test_pivot_force_is_called_so(pivoted: rr.Trajectory) -> None:
    ax = pivoted.plot("force")
    assert ax.get_ylabel() == "force of the pivot [N]"
    assert "m g" not in [artist.get_label() for artist in ax.get_lines()]


def test_lift_off_is_marked(run: rr.Trajectory) -> None:
    force = run.contact_force.copy()
    force[500:, 2] = -1.0
    lifted = dataclasses.replace(run, contact_force=force)
    ax = lifted.plot("force")
    (span,) = ax.patches
    assert span.get_label() == "after lift-off"
    assert span.get_x() == lifted.lift_off_time


def test_missing_quantity_is_said(run: rr.Trajectory) -> None:
    empty = dataclasses.replace(run, energy=np.full(len(run), np.nan))
    (text,) = empty.plot("energy").texts
    assert text.get_text() == "not computed by this model"


def test_slope_and_sliding_legs() -> None:
    urdf = rr.Robot.from_parameters().urdf.replace("continuous", "prismatic")
    urdf = urdf.replace('type="revolute"', 'type="prismatic"')
    robot = rr.Robot.from_urdf(urdf, shell=rr.Sphere(0.12))
    gait = rr.SinusoidalGait(offset=0.0, amplitude=0.01, angular_frequency=8.0)
    model = rr.FullModel(robot, ground=rr.Plane((0, 0.1, 1)), damping=0.01)
    t = rr.simulate(model, gait, duration=0.3)
    ax = t.plot("legs")
    assert (ax.get_ylabel(), twin(ax).get_ylabel()) == ("leg position [mm]", "force [N]")
    np.testing.assert_array_equal(curve(ax, "leg_1")[1], 1000 * t.leg_angle[:, 0])
    weight = curve(t.plot("force"), "m g cos(slope)")[1]
    np.testing.assert_allclose(weight, 0.52 * 9.81 / np.hypot(0.1, 1.0), rtol=1e-12)


@pytest.mark.parametrize("kind", ["", "speed", "Angles"])
def test_unknown_kind(run: rr.Trajectory, kind: str) -> None:
    with pytest.raises(rr.ParameterError, match="angles, path, energy, force, legs, all"):
        run.plot(kind)
    with pytest.raises(rr.ParameterError, match="makes its own figure"):
        run.plot("all", Figure().add_subplot())


def test_curves_differ_in_colour_and_line() -> None:
    styles = [line(i) for i in range(len(COLOURS) * len(LINES))]
    assert len({(s["color"], str(s["linestyle"])) for s in styles}) == len(styles)
    assert len({str(s["linestyle"]) for s in styles[: len(LINES)]}) == len(LINES)
