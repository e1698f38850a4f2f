"""What `rrrobot sweep` prints and draws."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from rrrobot.cli.options.robot import DECOUPLED
from rrrobot.cli.report import aligned
from rrrobot.files import make_folder
from rrrobot.results import COLUMNS, STATUS, load_names
from rrrobot.studies.modulation import amplitude_modulation, filled, pitch_yaw_phase_difference
from rrrobot.studies.sweeps.run import sweep as run_sweep

if TYPE_CHECKING:
    import xarray as xr

SETTLED = 0.05
"""Variation from cycle to cycle up to which a gait counts as the fastest."""
_MOST_MODULATED = 21
"""Offsets of Fig 20; each takes a search by the yaw model."""


def summary(ds: xr.Dataset, seconds: float) -> dict[str, Any]:
    """What a sweep found, as plain data in SI units."""
    status = ds.status.to_numpy()
    steady = ds.variation <= SETTLED
    return {
        "title": ds.attrs["title"],
        "gaits": status.size,
        "sizes": {str(dim): size for dim, size in ds.sizes.items() if dim in ds.speed.dims},
        "settle": ds.attrs.get("settle", "cycles"),
        "cycles": ds.attrs.get("cycles"),
        "counted": ds.attrs.get("counted"),
        "seconds": seconds,
        "status": {word: int((status == code).sum()) for code, word in STATUS.items()},
        "unsettled": int((ds.variation > SETTLED).sum()),
        "through_ground": int((ds.clearance <= 0).sum()),
        "loads": _loads(ds, steady) if ds.attrs["loads"] else None,
        "fastest": _gait(ds, ds.speed.where(steady)),
        "fastest_turn": _gait(ds, abs(ds.yaw_rate).where(steady)),
    }


def _loads(ds: xr.Dataset, steady: xr.DataArray) -> dict[str, list[float]]:
    """Least and largest of each load over the settled gaits; none where it means nothing."""
    known = {name: ds[name].where(steady) for name in load_names()}
    return {
        name: [float(values.min()), float(values.max())]
        for name, values in known.items()
        if values.notnull().any()
    }


def _gait(ds: xr.Dataset, goal: xr.DataArray) -> dict[str, Any] | None:
    """The gait that has the most of something."""
    if not goal.notnull().any():
        return None
    names = [
        "speed",
        "velocity_y",
        "yaw_rate",
        "curvature",
        *(load_names() if ds.attrs["loads"] else ()),
    ]
    best = ds[names].isel(goal.argmax(...))
    return {str(name): np.asarray(value).tolist() for name, value in best.variables.items()}


def table(data: dict[str, Any]) -> str:
    """The summary in lines of "name  value", in everyday units."""
    sizes = " x ".join(f"{size} {dim}" for dim, size in data["sizes"].items())
    rate = data["gaits"] / max(data["seconds"], 1e-9)
    rows = [
        ("sweep", data["title"]),
        ("gaits", f"{data['gaits']}: {sizes}" if sizes else "1"),
        ("time", f"{data['seconds']:.2f} s, {rate:.0f} gaits/s"),
        ("settled by", "their limit cycles")
        if data["settle"] == "orbit"
        else ("cycles", f"{data['cycles']}, the last {data['counted']} counted"),
    ]
    for word, count in data["status"].items():
        if count and word != "steady_state":
            rows.append(("stopped", f"{count}: {word.replace('_', ' ')}"))
    if data["unsettled"]:
        rows.append(("not settled", f"{data['unsettled']}, steps vary by more than 5 %"))
    if data["through_ground"]:
        rows.append(("through the ground", f"{data['through_ground']} gaits swing a leg there"))
    for name, ends in (data["loads"] or {}).items():
        unit = COLUMNS[name].unit.removeprefix("1")
        rows.append((name.replace("_", " "), f"{ends[0]:.4g} .. {ends[1]:.4g} {unit}"))
    for name, label in (("fastest", "fastest"), ("fastest_turn", "fastest turn")):
        best = data[name]
        if best is not None:
            rows.append((label, f"v {1000 * best['speed']:.4f} mm/s, {best['yaw_rate']:.6f} rad/s"))
            rows.append(("  at", _place(best)))
    return aligned(rows)


def _place(best: dict[str, Any]) -> str:
    skip = ("speed", "velocity_y", "yaw_rate", "curvature", "leg", *load_names())
    return ", ".join(
        f"{name.replace('_', ' ')} {value:.5g}"
        for name, value in best.items()
        if name not in skip and isinstance(value, float) and math.isfinite(value)
    )


def draw(ds: xr.Dataset) -> dict[str, Any]:
    """Figures of a sweep over two grids by file name."""
    from rrrobot.figures import maps

    figures: dict[str, Any] = {
        "translation": maps.translation(ds),
        "amplitudes": maps.amplitudes(ds),
        "inverse": maps.inverse(ds),
    }
    phase = pitch_yaw_phase_difference(ds)
    if phase.notnull().any():
        figures["phase_difference"] = maps.value_map(phase).figure
    for name in load_names():
        if name in ds and ds[name].notnull().any():
            figures[name] = maps.value_map(ds[name]).figure
    return figures


def draw_paper(
    full: xr.Dataset, make: Callable[[str], Any], grids: dict[str, Any], run: dict[str, Any]
) -> dict[str, Any]:
    """The paper's figures by file name, with sweeps of the single-axis models.

    Args:
        full: sweep of the full model over the paper's plane.
        make: makes a model by its name.
        grids, run: of that sweep.
    """
    from rrrobot.paper import figures as paper

    pitch, yaw = (run_sweep(make(name), **grids, **run) for name in ("pitch", "yaw"))
    decoupled = make(DECOUPLED)
    thin = slice(None, None, math.ceil(full.sizes["offset"] / _MOST_MODULATED))
    modulation = amplitude_modulation(decoupled.robot, full.isel(offset=thin))
    amplitude = filled(modulation, full.offset)
    single = run_sweep(decoupled, **grids, **run, yaw_amplitude=amplitude)
    return {
        "fig_11_pitch_amplitude": paper.fig_11(full, pitch),
        "fig_12_yaw_amplitude": paper.fig_12(full, yaw),
        "fig_14_phase_difference": paper.fig_14(full, pitch, yaw),
        "fig_18_translation": paper.fig_18(full),
        "fig_19_translation_decoupled": paper.fig_19(single),
        "fig_20_modulation": paper.fig_20(modulation),
        "fig_21_inverse": paper.fig_21(full),
        "fig_22_inverse_decoupled": paper.fig_22(single),
    }


def write_figures(figures: dict[str, Any], folder: Path) -> list[Path]:
    """Write figures as .png into a folder."""
    from rrrobot.drawing import write_figure

    return [write_figure(figure, folder / f"{name}.png") for name, figure in figures.items()]


def folder_of(name: str, grids: dict[str, Any], parameters: dict[str, Any]) -> Path:
    """Make the folder of the figures, if this sweep has any."""
    every: list[Any] = [*parameters.values()]
    for grid in grids.values():
        every += grid.values() if isinstance(grid, dict) else [grid]
    wide = sum(np.size(grid) > 1 for grid in every)
    if wide != 2:
        raise click.UsageError(f"--figures draws maps over two grids; this sweep has {wide}.")
    return make_folder(name)
