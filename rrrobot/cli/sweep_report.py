"""What `rrrobot sweep` prints and draws."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from rrrobot.cli.options.robot import DECOUPLED
from rrrobot.files import make_folder
from rrrobot.inline import aligned
from rrrobot.results import COLUMNS, SETTLED, STATUS, load_names
from rrrobot.studies.modulation import amplitude_modulation, filled, pitch_yaw_phase_difference
from rrrobot.studies.sweeps.run import sweep as run_sweep

if TYPE_CHECKING:
    import xarray as xr

_MOST_SLICES = 8
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
        ("time", f"{data['seconds']:.2f} s, {rate:{'.0f' if rate >= 10 else '.2g'}} gaits/s"),
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


def slices(ds: xr.Dataset) -> tuple[dict[str, xr.Dataset], str | None]:
    """Maps of a sweep over more than two grids: slices over its two longest, at values of the rest.

    Returns:
        what is added to the names of a slice's files -> slice, and a note if there is more than
        one: at most `_MOST_SLICES` are drawn, at even steps of the rest's values.
    """
    gaits = ds.speed.squeeze(drop=True)
    wide = sorted(gaits.dims, key=lambda dim: -gaits.sizes[dim])
    plane, rest = wide[:2], [str(dim) for dim in gaits.dims if dim not in wide[:2]]
    if not rest:
        return {"": ds}, None
    every = list(np.ndindex(*(gaits.sizes[dim] for dim in rest)))
    drawn = np.unique(np.linspace(0, len(every) - 1, min(len(every), _MOST_SLICES)).round())
    found = {}
    for number in drawn.astype(int):
        at = dict(zip(rest, every[number], strict=True))
        part = ds.isel(at)
        values = (f"_{dim}_{_value(part, dim, index)}" for dim, index in at.items())
        found["".join(values)] = part
    note = (
        f"Note: {len(found)} of {len(every)} maps over {' and '.join(map(str, plane))}, at values "
        f"of {', '.join(rest)}."
    )
    return found, note


def _value(part: xr.Dataset, dim: str, index: int) -> str:
    """A slice's value of a dimension, short enough for a file's name."""
    known = part.coords.get(dim)
    return str(index) if known is None or known.dtype.kind not in "fi" else f"{float(known):.4g}"


def draw(ds: xr.Dataset, suffix: str = "") -> dict[str, Any]:
    """Figures of a sweep over two grids by file name, to which the suffix is added."""
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
    return {name + suffix: figure for name, figure in figures.items()}


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
    if wide < 2:
        raise click.UsageError(
            f"--figures draws maps over two grids or more; this sweep has {wide}."
        )
    return make_folder(name)
