"""Maps of sweeps: data, units, labels, and no trace left in pyplot."""

from __future__ import annotations

import io
import sys

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import rrrobot as rr
from rrrobot.figures import maps
from rrrobot.figures.shades import Shades
from rrrobot.studies.modulation import amplitude_modulation, pitch_yaw_phase_difference
from rrrobot.studies.sweeps.run import sweep
from tests.some import some

ROBOT = rr.Robot.from_parameters()
GRID = {"offset": np.linspace(0, np.pi, 13), "phase_difference": np.linspace(0, 2 * np.pi, 13)}


@pytest.fixture(scope="module")
def full() -> xr.Dataset:
    return sweep(rr.FullModel(ROBOT), **GRID)


@pytest.fixture(scope="module")
def pitch() -> xr.Dataset:
    return sweep(rr.PitchModel(ROBOT), **GRID)


@pytest.fixture(scope="module")
def yaw() -> xr.Dataset:
    return sweep(rr.YawModel(ROBOT), **GRID)


def drawn(figure: Figure) -> Figure:
    figure.savefig(io.BytesIO(), format="png", dpi=40)
    return figure


def mesh(ax: Axes) -> np.ma.MaskedArray:
    return ax.collections[0].get_array()


def panels(figure: Figure) -> list[Axes]:
    return [ax for ax in figure.axes if ax.get_xlabel()]


def bars(figure: Figure) -> list[str]:
    return [ax.get_ylabel() for ax in figure.axes if not ax.get_xlabel()]


def test_map_of_a_variable(full: xr.Dataset) -> None:
    ax = maps.value_map(full.speed)
    figure = drawn(ax.figure)
    np.testing.assert_array_equal(mesh(ax), 1000 * full.speed)
    assert ax.get_xlabel() == "leg phase difference [rad]"
    assert ax.get_ylabel() == "leg offset [rad]"
    assert bars(figure) == ["speed v [mm/s]"]
    assert [label.get_text() for label in ax.get_xticklabels()] == ["0", "π/2", "π", "3π/2", "2π"]
    assert [label.get_text() for label in ax.get_yticklabels()] == ["0", "π/4", "π/2", "3π/4", "π"]
    assert (ax.get_xlim(), ax.get_ylim()) == ((0, 2 * np.pi), (0, np.pi))


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("yaw_rate", r"yaw rate $\alpha$ [rad/s]"),
        ("curvature", "curvature K [1/m]"),
        ("pitch_amplitude", "pitch amplitude [deg]"),
        ("clearance", "clearance [mm]"),
        ("variation", "variation"),
        ("normal_force", "normal force [N]"),
    ],
)
def test_units_of_a_map(full: xr.Dataset, name: str, label: str) -> None:
    assert bars(drawn(maps.value_map(full[name]).figure)) == [label]


def test_contours_have_their_values(full: xr.Dataset) -> None:
    ax = maps.value_map(full.yaw_rate)
    kind = Shades.of(full.yaw_rate, full.yaw_rate.to_numpy())
    assert kind.kind == "signed"
    assert 0.0 in kind.levels()
    texts = {text.get_text() for text in ax.texts}
    assert len(texts) > 3
    assert texts <= {f"{level:g}" for level in kind.levels()}
    places = [(ax.transData - ax.transAxes).transform(text.get_position()) for text in ax.texts]
    for i, one in enumerate(places):
        for other in places[:i]:
            assert np.hypot(*(one - other)) > 0.05


def lightness(kind: str) -> np.ndarray:
    red, green, blue, _ = Shades(kind=kind, low=-1, high=1).colours()(np.linspace(0, 1, 64)).T
    return 0.299 * red + 0.587 * green + 0.114 * blue


def test_amounts_grow_darker() -> None:
    shades = lightness("amount")
    assert (np.diff(shades) < 0).all()
    assert shades[-1] > 0.3


def test_signed_values_part_from_white_at_zero(full: xr.Dataset) -> None:
    shades = lightness("signed")
    assert (np.diff(shades[:30]) > 0).all() and (np.diff(shades[-30:]) < 0).all()
    assert shades[31:33].min() > 0.95
    low, high = maps.value_map(full.yaw_rate).collections[0].get_clim()
    assert low == -high == -float(np.abs(full.yaw_rate).max())
    # A map that is negative alone is an amount; rounding below zero does not change that.
    assert Shades.of(-full.speed, -full.speed.to_numpy()).kind == "amount"
    assert Shades.of(full.speed, full.speed.to_numpy() - 1e-9).kind == "amount"


def test_zero_lines_are_straight_where_the_mechanics_is_mirrored(full: xr.Dataset) -> None:
    """Legs at offset pi/2, or swinging against each other, do not turn the robot."""
    lines = [c for c in maps.value_map(full.yaw_rate).collections[1:] if c.get_linewidth()[0] > 1.5]
    points = np.concatenate([path.vertices for line in lines for path in line.get_paths()])
    middle = points[np.abs(points[:, 1] - np.pi / 2) < 0.3]
    on_row = np.abs(middle[:, 1] - np.pi / 2) < 1e-5
    on_column = np.abs(middle[:, 0] - np.pi) < 1e-5
    assert on_row.any() and on_column.any() and (on_row | on_column).all()
    assert np.ptp(middle[on_row, 0]) > 0.8 * 2 * np.pi


def test_angles_come_round() -> None:
    kind = Shades(kind="angle", low=-180.0, high=180.0)
    ends = kind.colours()([0.0, 1.0])
    np.testing.assert_allclose(ends[0], ends[1], atol=0.02)


def test_missing_values_are_hatched(full: xr.Dataset) -> None:
    holes = full.speed.where(full.offset > 1.0)
    ax = maps.value_map(holes)
    drawn(ax.figure)
    np.testing.assert_array_equal(np.ma.getmaskarray(mesh(ax)), holes.isnull())
    assert ax.patch.get_hatch()
    infinite = full.speed.where(full.offset > 1.0, np.inf)
    assert np.ma.getmaskarray(mesh(maps.value_map(infinite))).sum() == holes.isnull().sum()


def test_given_axes_are_used(full: xr.Dataset) -> None:
    ax = Figure().add_subplot()
    assert maps.value_map(full.speed, ax) is ax


@pytest.mark.slow
def test_any_two_dimensions(full: xr.Dataset) -> None:
    ds = sweep(
        rr.FullModel(ROBOT),
        offset=1.0,
        amplitude=[0.1, 0.2, 0.3],
        parameters={"leg_mass": [0.05, 0.06]},
        cycles=4,
    )
    ax = maps.value_map(ds.speed)
    assert (ax.get_xlabel(), ax.get_ylabel()) == (
        "leg amplitude [rad]",
        "mass at each leg tip [kg]",
    )
    for figure in (maps.translation(ds), maps.amplitudes(ds), maps.inverse(ds)):
        drawn(figure)
    one = sweep(rr.FullModel(ROBOT), **GRID, amplitude=[0.3], cycles=4)
    assert mesh(maps.value_map(one.speed)).shape == (13, 13)


def test_grids_in_any_order(full: xr.Dataset) -> None:
    shuffled = full.isel(offset=[3, 0, 7, 12], phase_difference=slice(None, None, -1))
    ax = maps.value_map(shuffled.speed)
    drawn(ax.figure)
    np.testing.assert_array_equal(mesh(ax), 1000 * full.speed[[0, 3, 7, 12]])
    drawn(maps.inverse(shuffled))


@pytest.mark.parametrize(
    "cut", [{"offset": 3}, {"offset": [3]}, {"offset": 3, "phase_difference": 1}]
)
def test_not_two_dimensions(full: xr.Dataset, cut: dict) -> None:
    with pytest.raises(rr.ParameterError, match="needs two dimensions"):
        maps.value_map(full.isel(cut).speed)
    with pytest.raises(rr.ParameterError, match="needs two dimensions"):
        maps.inverse(full.isel(cut))


def test_nothing_to_draw_is_said(full: xr.Dataset) -> None:
    nothing = full.speed * np.nan
    for figure in (maps.value_map(nothing).figure, maps.side_by_side(nothing, nothing)):
        texts = [text.get_text() for ax in panels(drawn(figure)) for text in ax.texts]
        assert set(texts) == {"no value"}


def test_constant_values_are_drawn(full: xr.Dataset) -> None:
    ax = maps.value_map(full.speed * 0.0)
    drawn(ax.figure)
    assert not ax.texts


def test_side_by_side_shares_colours(full: xr.Dataset, pitch: xr.Dataset, yaw: xr.Dataset) -> None:
    figure = drawn(maps.side_by_side(full.yaw_amplitude, yaw.yaw_amplitude, ("full", "yaw")))
    left, right = panels(figure)
    assert [ax.get_title() for ax in (left, right)] == ["(a) full", "(b) yaw"]
    assert left.collections[0].get_clim() == right.collections[0].get_clim()
    np.testing.assert_allclose(mesh(right), np.rad2deg(yaw.yaw_amplitude))
    assert bars(figure) == ["yaw amplitude [deg]"]
    drawn(maps.side_by_side(full.pitch_amplitude, pitch.pitch_amplitude))


@pytest.mark.slow
def test_phase_differences(full: xr.Dataset, pitch: xr.Dataset, yaw: xr.Dataset) -> None:
    own = pitch_yaw_phase_difference(full)
    known = own.notnull()
    np.testing.assert_allclose(
        own.values[known], full.pitch_yaw_phase_difference.values[known], atol=1e-12
    )
    swing = (full.pitch_amplitude > 0.1) & (full.yaw_amplitude > 0.03)
    assert known.where(swing, True).all()
    assert not known[:, 0].any()
    single = pitch_yaw_phase_difference(pitch, yaw)
    assert float(np.abs(single).max()) <= np.pi
    drawn(maps.side_by_side(pitch_yaw_phase_difference(full), single))
    at = single.sel(offset=np.pi / 4, phase_difference=np.pi / 2, method="nearest")
    run = rr.decoupled(ROBOT, rr.gait("circular"), 9.0, 0.03).steady_state()
    apart = float(at) - run.pitch_yaw_phase_difference
    assert np.exp(1j * apart) == pytest.approx(1.0, abs=2e-2)


def test_contours_of_angles_know_no_jump() -> None:
    y, x = np.mgrid[-1:1:21j, -1:1:21j]
    angle = xr.DataArray(
        np.arctan2(y, x), dims=("a", "b"), attrs={"units": "rad"}, name="roll_phase"
    )
    angle = angle.assign_coords(a=y[:, 0], b=x[0])
    ax = maps.value_map(angle)
    paths = [path for lines in ax.collections[1:] for path in lines.get_paths()]
    points = np.concatenate([path.vertices for path in paths])
    assert len(ax.collections) > 10
    # Each contour is a ray from the middle, of 30 degrees each.
    points = points[np.hypot(*points.T) > 0.3]
    angle = np.rad2deg(np.arctan2(points[:, 1], points[:, 0]))
    assert np.abs((angle + 15) % 30 - 15).max() < 0.5


def test_translation(full: xr.Dataset) -> None:
    figure = drawn(maps.translation(full))
    assert bars(figure) == [
        "speed v [mm/s]",
        r"yaw rate $\alpha$ [rad/s]",
        "curvature K [1/m]",
    ]
    curvature = panels(figure)[2]
    hidden = np.ma.getmaskarray(mesh(curvature))
    np.testing.assert_array_equal(hidden, full.speed < maps.SLOW)
    low, high = curvature.collections[0].get_clim()
    assert low == -high
    assert 0.85 < (np.abs(mesh(curvature)) <= high).mean() < 0.95


@pytest.mark.parametrize("name", some(("roll", "pitch", "yaw"), {"roll"}))
def test_models_that_stay_in_one_place(name: str, pitch: xr.Dataset, yaw: xr.Dataset) -> None:
    ds = {"pitch": pitch, "yaw": yaw}.get(name)
    ds = sweep(rr.RollModel(ROBOT), **GRID) if ds is None else ds
    *_, curvature = panels(drawn(maps.translation(ds)))
    assert [text.get_text() for text in curvature.texts] == ["no value"]
    for figure in (maps.amplitudes(ds), maps.inverse(ds)):
        drawn(figure)


def test_amplitudes(full: xr.Dataset) -> None:
    figure = drawn(maps.amplitudes(full))
    assert bars(figure) == [f"{axis} amplitude [deg]" for axis in ("roll", "pitch", "yaw")]


def test_inverse_map(full: xr.Dataset) -> None:
    figure = drawn(maps.inverse(full, curves=5))
    first, second = figure.axes
    assert first.get_xlabel() == "v along the leg axis [mm/s]"
    assert first.get_ylabel() == r"$\alpha$ [rad/s]"
    assert second.get_title() == "(b) curves of equal leg phase difference [rad]"
    lines = [line for line in first.get_lines() if line.get_linestyle() != "None"]
    assert len(lines) == 5
    # Through every point of the sweep, with ten between each two.
    np.testing.assert_allclose(lines[1].get_xdata()[:-1:10], 1000 * full.velocity_y[3], atol=1e-12)
    np.testing.assert_allclose(lines[1].get_ydata()[:-1:10], full.yaw_rate[3], atol=1e-14)
    texts = {text.get_text(): text.xy for text in first.texts}
    assert set(texts) == {"0", "π/4", "π/2", "3π/4", "π"}
    assert tuple(texts["π/4"]) in set(zip(*lines[1].get_data(), strict=True))
    # With legs in phase, or against each other, the robot stays in one place.
    assert {text.get_text() for text in second.texts} == {"π/2", "3π/2"}


def test_modulation(full: xr.Dataset) -> None:
    few = full.isel(offset=[0, 3, 6])
    found = amplitude_modulation(ROBOT, few)
    assert found.dims == ("offset",)
    factor = rr.studies.matching_yaw_amplitude(
        ROBOT, rr.gait("circular"), float(few.yaw_rate.sel(phase_difference=np.pi / 2)[1])
    )
    assert float(found[1]) == pytest.approx(0.3 * factor, rel=1e-9)
    assert float(found[1]) == pytest.approx(0.377, abs=1e-3)
    assert np.isnan(found[2])
    ax = maps.modulation(found)
    drawn(ax.figure)
    assert ax.get_ylabel() == "leg amplitude [rad]"
    np.testing.assert_array_equal(ax.get_lines()[0].get_ydata(), found.dropna("offset"))


@pytest.mark.parametrize("make", ["translation", "amplitudes", "inverse", "side"])
def test_nothing_overlaps(full: xr.Dataset, make: str) -> None:
    figure = (
        maps.side_by_side(full.speed, full.speed) if make == "side" else getattr(maps, make)(full)
    )
    boxes = [ax.get_tightbbox() for ax in drawn(figure).axes]
    for i, one in enumerate(boxes):
        for other in boxes[:i]:
            assert type(one).intersection(one, other) is None
    width, height = figure.get_size_inches() * figure.dpi
    for box in boxes:
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (np.pi, "π"), (-np.pi, "-π"), (np.pi / 2, "π/2"), (3 * np.pi / 8, "3π/8"),
     (-5 * np.pi / 3, "-5π/3"), (2 * np.pi, "2π"), (1.0, "1"), (0.123456, "0.123")],
)  # fmt: skip
def test_multiples_of_pi(value: float, text: str) -> None:
    assert maps._multiple_of_pi(value) == text


def test_pyplot_is_left_alone(full: xr.Dataset) -> None:
    drawn(maps.translation(full))
    pyplot = sys.modules.get("matplotlib.pyplot")
    assert pyplot is None or pyplot.get_fignums() == []


def test_an_amount_has_no_line_where_it_touches_zero(full: xr.Dataset) -> None:
    """Opposite legs do not pitch: no contour of rounding's along them, those above are drawn."""
    pitch = full.pitch_amplitude
    assert float(pitch.sel(phase_difference=np.pi, method="nearest").max()) < 1e-6
    shown = np.rad2deg(pitch.to_numpy())
    levels = Shades.of(pitch, shown).levels()
    assert levels.min() > 0 and levels.max() > 0.8 * shown.max()


def test_labels_of_the_inverse_map_stand_apart(full: xr.Dataset) -> None:
    figure = drawn(maps.inverse(full))
    for ax in figure.axes:
        boxes = [text.get_window_extent() for text in ax.texts]
        assert len(boxes) > 3
        pairs = [(a, b) for i, a in enumerate(boxes) for b in boxes[:i]]
        assert not any(a.overlaps(b) for a, b in pairs)
