"""Figs 11 to 14 and 18 to 22: maps over the plane of offset and phase difference."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rrrobot.drive.moves import out_of_phase_gait
from rrrobot.paper import figures as paper
from rrrobot.paper.item import Item, Result, Row, about, above, below, feature, record
from rrrobot.paper.workshop import HUMP, Workshop, hump, relative_rms
from rrrobot.reduction.connection import Connection
from rrrobot.reduction.yaw import net_yaw
from rrrobot.studies.modulation import pitch_yaw_phase_difference

if TYPE_CHECKING:
    import xarray as xr

_TRAVELS = 2e-3
"""Speed above which gaits are compared [m/s]."""


def _fig_11(shop: Workshop) -> Result:
    full, pitch = shop.plane("full"), shop.plane("pitch")
    off = relative_rms(full.pitch_amplitude, pitch.pitch_amplitude)
    rows = (
        feature(
            "root mean square difference of the maps, of the full model's", "represented well",
            off, limit=below(0.1),
        ),
        record("largest pitch amplitude, full model", _degrees(full.pitch_amplitude.max()), "deg"),
        record("largest pitch amplitude, pitch model", _degrees(pitch.pitch_amplitude.max()),
               "deg"),
    )  # fmt: skip
    return Result(rows=rows, figures={"fig11": paper.fig_11(full, pitch)})


def _fig_12(shop: Workshop) -> Result:
    full, yaw = shop.plane("full"), shop.plane("yaw")
    humps = {name: hump(ds.yaw_amplitude) for name, ds in (("full", full), ("yaw", yaw))}
    rows = (
        feature(
            "yaw model: amplitude at offset pi/2 over that at pi/4", "a hump", humps["yaw"],
            limit=above(HUMP),
        ),
        feature(
            "full model: the same", "no spike", humps["full"], limit=below(HUMP),
            note="It rises by a few per cent, where the yaw model falls to zero at 0 and pi.",
        ),
        feature(
            "root mean square difference of the maps, of the full model's",
            "compare favourably", relative_rms(full.yaw_amplitude, yaw.yaw_amplitude),
            limit=below(0.1),
        ),
        record("largest yaw amplitude, full model", _degrees(full.yaw_amplitude.max()), "deg"),
        record("largest yaw amplitude, yaw model", _degrees(yaw.yaw_amplitude.max()), "deg"),
    )  # fmt: skip
    return Result(rows=rows, figures={"fig12": paper.fig_12(full, yaw)})


def _fig_13(shop: Workshop) -> Result:
    connection = Connection(shop.robot)
    rows = []
    for name, offset in (("A", 5 * np.pi / 8 + 0.15), ("B", np.pi / 2)):
        gait = out_of_phase_gait(offset=offset)
        by = {method: net_yaw(connection, gait, method=method) for method in ("area", "simulate")}
        rows += [
            feature(
                f"trajectory {name}: size of the net yaw in a cycle, by area",
                "net yaw" if name == "A" else "none", abs(_degrees(by["area"])), "deg",
                limit=above(_degrees(1e-6)) if name == "A" else below(_degrees(1e-6)),
            ),
            record(f"trajectory {name}: by dynamics", _degrees(by["simulate"]), "deg"),
        ]  # fmt: skip
    return Result(rows=tuple(rows), figures={"fig13": paper.fig_13(connection)})


def _fig_14(shop: Workshop) -> Result:
    full, pitch, yaw = (shop.plane(name) for name in ("full", "pitch", "yaw"))
    apart = pitch_yaw_phase_difference(pitch, yaw) - pitch_yaw_phase_difference(full)
    wrapped = np.abs((apart.to_numpy() + np.pi) % (2 * np.pi) - np.pi)
    known = wrapped[np.isfinite(wrapped)]
    rows = (
        feature(
            "median difference of the two maps", "different", _degrees(np.median(known)), "deg",
            limit=above(5.0),
        ),
        record("largest difference", _degrees(known.max()), "deg"),
    )  # fmt: skip
    return Result(rows=rows, figures={"fig14": paper.fig_14(full, pitch, yaw)})


def _fig_18(shop: Workshop) -> Result:
    full = shop.plane("full")
    lateral = shop.comparison("lateral").states["full"]
    offset, phase = full.offset.to_numpy(), full.phase_difference.to_numpy()
    alpha = full.yaw_rate.to_numpy()
    odd = [float(np.abs(alpha + mirror).max() / np.abs(alpha).max())
           for mirror in (alpha[::-1], alpha[:, ::-1])]  # fmt: skip
    peak = np.unravel_index(int(np.argmax(full.speed.to_numpy())), full.speed.shape)
    rows = (
        record("peak speed", 1000 * float(full.speed.max()), "mm/s"),
        record("offset of the peak", float(offset[peak[0]]), "rad"),
        record("phase difference of the peak", float(phase[peak[1]]), "rad"),
        record("speed of the lateral gait by the KKT run", 1000 * lateral.speed, "mm/s"),
        record("largest yaw rate", float(np.abs(alpha).max()), "rad/s"),
        feature(
            "yaw rate plus that mirrored at offset pi/2, of the largest", "changes sign there",
            odd[0], limit=below(0.001),
        ),
        feature(
            "yaw rate plus that mirrored at phase difference pi, of the largest",
            "changes sign there", odd[1], limit=below(0.001),
        ),
    )  # fmt: skip
    return Result(rows=rows, figures={"fig18": paper.fig_18(full)})


def _fig_19(shop: Workshop) -> Result:
    full, single, plain = (shop.plane(name) for name in ("full", "modulated", "decoupled"))
    rows = _likeness(full, single, "modulated") + _likeness(full, plain, "not modulated")
    return Result(
        rows=tuple(rows),
        figures={"fig19": paper.fig_19(single)},
        remarks=(
            "Likeness is the correlation of the two maps where both travel above 2 mm/s, the ratio "
            "that of their root mean squares. The figure has the amplitude modulation of Fig 20.",
            "Next to offsets 0 and pi the full model turns the other way, up to 0.041 rad/s; no "
            "leg amplitude makes the yaw model do so, and the maps differ there.",
        ),
    )


def _fig_20(shop: Workshop) -> Result:
    curve = shop.modulation_curve
    found = curve.sel(offset=slice(np.pi / 4, 3 * np.pi / 4)).dropna("offset")
    least = found.offset[int(np.argmin(found.to_numpy()))]
    rows = (
        feature(
            "largest over smallest amplitude from offset pi/4 to 3 pi/4",
            "varies with the offset", float(found.max() / found.min()), limit=above(1.1),
        ),
        record("smallest amplitude there", float(found.min()), "rad"),
        record("offset of the smallest", float(least), "rad"),
        record("largest amplitude of all", float(curve.max()), "rad"),
        record("least offset with one", float(curve.dropna("offset").offset.min()), "rad",
               "Nearer to 0 and pi the full model turns the other way; at pi/2 nothing turns."),
    )  # fmt: skip
    return Result(rows=rows, figures={"fig20": paper.fig_20(curve)})


def _fig_21(shop: Workshop) -> Result:
    full = shop.plane("full")
    left, right = float(full.velocity_y.max()), -float(full.velocity_y.min())
    one_to_one = _one_to_one(full)
    rows = [
        *_reach(full),
        feature("reach to the right over that to the left", "both directions", right / left,
                limit=about(1.0, 1e-3)),
        feature("cells of the plane that map without a fold, share", "an inverse relationship",
                one_to_one, limit=above(0.5),
                note="Each quarter of the plane maps one to one; the folds lie between them."),
    ]  # fmt: skip
    return Result(rows=tuple(rows), figures={"fig21": paper.fig_21(full)})


def _fig_22(shop: Workshop) -> Result:
    full, single = shop.plane("full"), shop.plane("modulated")
    rows = _reach(single)
    reach = [_range(single[name]) / _range(full[name]) for name in ("velocity_y", "yaw_rate")]
    rows += [
        feature(
            "reached signed speed off the full model's, part of it", "some discrepancies",
            abs(reach[0] - 1), limit=above(0.02),
        ),
        feature(
            "reached yaw rate over the full model's", "similar", reach[1],
            limit=about(1, 0.15),
            note="The full model turns fastest at offsets 0 and pi, where the yaw model does not.",
        ),
    ]  # fmt: skip
    return Result(rows=tuple(rows), figures={"fig22": paper.fig_22(single)})


def _degrees(angle: object) -> float:
    return float(np.rad2deg(float(angle)))  # type: ignore[arg-type]


def _likeness(full: xr.Dataset, single: xr.Dataset, which: str) -> list[Row]:
    rows = []
    both = (full.speed > _TRAVELS) & (single.speed > _TRAVELS)
    for name in ("yaw_rate", "curvature"):
        a, b = (ds[name].to_numpy()[both] for ds in (full, single))
        like = float(np.corrcoef(a, b)[0, 1])
        size = float(np.sqrt(np.mean(b**2) / np.mean(a**2)))
        title = f"{which}: {name.replace('_', ' ')}"
        rows += [
            feature(f"{title}, likeness", "structure matches well", like, limit=above(0.95)),
            feature(f"{title}, ratio", "magnitude matches well", size, limit=about(1, 0.1)),
        ]
    ratio = (single.speed / full.speed).to_numpy()[both]
    low, high = np.quantile(ratio, (0.05, 0.95))
    return [
        *rows,
        feature(
            f"{which}: speed, ratio at the fifth over that at the 95th percentile",
            "structural difference", float(low / high), limit=below(0.9),
        ),
        record(f"{which}: speed, median ratio", float(np.median(ratio))),
    ]  # fmt: skip


def _range(values: xr.DataArray) -> float:
    return float(values.max() - values.min())


def _one_to_one(ds: xr.Dataset) -> float:
    """Share of the cells over which (v, yaw rate) turns one way, by the sign of the Jacobian, of
    the larger sign in each quarter of the plane."""
    v, alpha = ds.velocity_y.to_numpy(), ds.yaw_rate.to_numpy()
    v_o, v_p = np.gradient(v)
    a_o, a_p = np.gradient(alpha)
    sign = np.sign(v_o * a_p - v_p * a_o)
    half = [slice(0, n // 2) for n in sign.shape], [slice(-(n // 2), None) for n in sign.shape]
    quarters = [sign[half[i][0], half[j][1]] for i in (0, 1) for j in (0, 1)]
    return float(np.mean([max((q > 0).mean(), (q < 0).mean()) for q in quarters]))


def _reach(ds: xr.Dataset) -> list[Row]:
    v, alpha = ds.velocity_y.to_numpy(), ds.yaw_rate.to_numpy()
    return [
        record("fastest along the leg axis, to the left", 1000 * float(v.max()), "mm/s"),
        record("fastest to the right", -1000 * float(v.min()), "mm/s"),
        record("fastest turn to the left", float(alpha.max()), "rad/s"),
        record("fastest turn to the right", -float(alpha.min()), "rad/s"),
    ]


PLANES = (
    Item(
        key="fig11",
        title="Fig 11: pitch amplitude",
        shows="The pitch model represents the full model's pitch amplitudes well.",
        make=_fig_11,
    ),
    Item(
        key="fig12",
        title="Fig 12: yaw amplitude",
        shows="The yaw model's compare favourably but for a small hump near offset pi/2.",
        make=_fig_12,
    ),
    Item(
        key="fig13",
        title="Fig 13: height function of the yaw model",
        shows="Trajectory A produces net yaw, trajectory B none.",
        make=_fig_13,
    ),
    Item(
        key="fig14",
        title="Fig 14: pitch-yaw phase difference",
        shows="That of the single-axis models is different from the full model's.",
        make=_fig_14,
    ),
    Item(
        key="fig18",
        title="Fig 18: travel of the full model",
        shows="Speed, yaw rate and curvature over offset and phase difference.",
        make=_fig_18,
    ),
    Item(
        key="fig19",
        title="Fig 19: travel of the single-axis models",
        shows="Yaw rate and curvature match Fig 18 well; the speed differs in structure.",
        make=_fig_19,
    ),
    Item(
        key="fig20",
        title="Fig 20: amplitude modulation",
        shows="The leg amplitude of the yaw model as a function of the offset.",
        make=_fig_20,
    ),
    Item(
        key="fig21",
        title="Fig 21: inverse map of the full model",
        shows="Offset and phase difference for a speed and a yaw rate.",
        make=_fig_21,
    ),
    Item(
        key="fig22",
        title="Fig 22: inverse map of the single-axis models",
        shows="As Fig 21, with some discrepancies in the speed.",
        make=_fig_22,
    ),
)
