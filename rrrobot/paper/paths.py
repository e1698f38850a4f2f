"""Figs 2, 6, 7 and 15 to 17: the paper's two gaits over thirty seconds."""

from __future__ import annotations

import numpy as np

from rrrobot.checks import Array
from rrrobot.paper import figures as paper
from rrrobot.paper.item import Item, Result, Row, about, above, below, feature, record
from rrrobot.paper.unicycle import unicycle_path
from rrrobot.paper.workshop import Workshop


def _fig_2(shop: Workshop) -> Result:
    found = shop.comparison("circular")
    state = found.states["full"]
    rows = (
        feature(
            "yaw rate", "counter-clockwise", state.yaw_rate, "rad/s", limit=above(0.001)
        ),
        record("radius of the path of the cycle means", 100 / abs(state.curvature), "cm"),
        feature(
            "pitch amplitude over roll amplitude", "the broad patch is the pitch oscillation",
            state.amplitude[1] / state.amplitude[0], limit=above(1.0),
        ),
    )  # fmt: skip
    return Result(rows=rows, figures={"fig2": paper.fig_2(found.trajectories["full"])})


def _fig_6(shop: Workshop) -> Result:
    found = shop.comparison("lateral")
    full, pivoting = found.states["full"], found.states["pivoting"]
    rows = (
        record("full model, speed", 1000 * full.speed, "mm/s"),
        record("pivoting model, speed", 1000 * pivoting.speed, "mm/s"),
        feature(
            "pivoting over full, speed", "almost identical",
            pivoting.speed / full.speed, limit=about(1, 0.05),
        ),
        feature(
            "travel across over travel along the leg axis", "sideways",
            abs(full.velocity[0] / full.velocity[1]),
            limit=below(0.01),
        ),
    )  # fmt: skip
    return Result(rows=rows, figures={"fig6": paper.fig_6(found)})


def _fig_7(shop: Workshop) -> Result:
    found = shop.comparison("circular")
    full, pivoting = found.states["full"], found.states["pivoting"]
    rows = (
        record("full model, yaw rate", full.yaw_rate, "rad/s"),
        record("pivoting model, yaw rate", pivoting.yaw_rate, "rad/s"),
        feature(
            "pivoting over full, yaw rate", "rotates significantly faster",
            pivoting.yaw_rate / full.yaw_rate, limit=above(5),
        ),
        feature(
            "pivoting over full, speed", "almost identical",
            pivoting.speed / full.speed, limit=about(1, 0.05),
            note="Almost identical on the lateral gait of Fig 6 only.",
        ),
    )  # fmt: skip
    return Result(rows=rows, figures={"fig7": paper.fig_7(found)})


def _fig_15(shop: Workshop) -> Result:
    found = shop.comparison("lateral")
    full, single = found.states["full"], found.states["decoupled"]
    off = _deviation(shop, "lateral")
    roll = full.amplitude[0] / full.amplitude[1]
    lag = float(np.rad2deg(single.phase[2] - full.phase[2]))
    rows = (
        _same("pitch", off[1]),
        feature(
            "yaw amplitude, single-axis over full", "strong match",
            single.amplitude[2] / full.amplitude[2],
            limit=about(1, 0.05),
        ),
        feature(
            "yaw phase, single-axis less full", "strong match", lag, "deg", limit=about(0.0, 5),
            note="The yaw model is undamped, the full model's yaw is damped (eq 9).",
        ),
        record("yaw, single-axis less full", off[2]),
        feature("roll amplitude over pitch amplitude", "negligible", roll, limit=below(0.05)),
        *(
            feature(f"mean {axis} over its amplitude, {model}", "oscillations about zero",
                    float(state.mean[i] / state.amplitude[i]), limit=about(0.0, 0.1))
            for model, state in (("full model", full), ("single-axis", single))
            for i, axis in ((1, "pitch"), (2, "yaw"))
        ),
        _speeds(single.speed / full.speed),
    )  # fmt: skip
    return Result(rows=rows, figures={"fig15": paper.fig_15(found)}, remarks=(_DEVIATION,))


def _fig_16(shop: Workshop) -> Result:
    found = shop.comparison("circular")
    full, single = found.states["full"], found.states["decoupled"]
    off = _deviation(shop, "circular")
    tilt = float(np.rad2deg(full.mean[1]))
    rows = (
        _same("pitch", off[1]),
        feature(
            "roll amplitude over pitch amplitude", "small roll oscillations",
            full.amplitude[0] / full.amplitude[1],
            limit=below(0.5),
        ),
        feature(
            "size of the mean pitch, full model", "tilts from the vertical", abs(tilt), "deg",
            limit=above(1.0),
        ),
        record("mean pitch, pitch model", float(np.rad2deg(single.mean[1])), "deg"),
        feature(
            "net yaw in a cycle, single-axis over full", "both turn",
            single.yaw_rate / full.yaw_rate, limit=above(0.1),
        ),
        _speeds(single.speed / full.speed),
    )  # fmt: skip
    return Result(rows=rows, figures={"fig16": paper.fig_16(found)}, remarks=(_DEVIATION,))


def _fig_17(shop: Workshop) -> Result:
    gaits = {name: shop.comparison(name).trajectories["full"] for name in ("lateral", "circular")}
    rows: list[Row] = []
    for name, trajectory in gaits.items():
        found = unicycle_path(trajectory)
        part = found.error / found.length
        rows += [
            feature(
                f"{name}: largest distance from the unicycle over the length of the path",
                "similar to a unicycle", part, limit=below(0.02),
            ),
            record(f"{name}: the distance", 1000 * found.error, "mm"),
            record(f"{name}: the length", 1000 * found.length, "mm"),
            record(f"{name}: side slip", float(np.rad2deg(found.side_slip)), "deg"),
        ]  # fmt: skip
    return Result(
        rows=tuple(rows),
        figures={"fig17": paper.fig_17(gaits)},
        remarks=(
            "The unicycle has the robot's steady speed along the leg axis, its yaw rate and its "
            "yaw at the start of the counted cycles. What is left is the side slip of the mean "
            "motion, which a wheel cannot have.",
        ),
    )


_DEVIATION = (
    "Deviations are root mean squares over the steady half of the run, the mean yaw drift taken "
    "out, over the full model's."
)


def _same(axis: str, off: float) -> Row:
    return feature(f"{axis}, single-axis less full", "strong match", off, limit=below(0.1))


def _speeds(ratio: float) -> Row:
    return feature("single-axis over full, speed", "match closely", ratio,
                   limit=about(1, 0.05))  # fmt: skip


def _deviation(shop: Workshop, gait: str) -> Array:
    """Single-axis less full model, relative, of roll, pitch and yaw (3,)."""
    from scipy.signal import detrend

    runs = shop.comparison(gait).trajectories
    full, single = runs["full"], runs["decoupled"]
    half = full.time >= full.time[-1] / 2
    ours, theirs = (detrend(run.euler[half], axis=0) for run in (full, single))
    size = np.sqrt(np.mean(ours**2, axis=0))
    off = np.sqrt(np.mean((theirs - ours) ** 2, axis=0)) / np.maximum(size, 1e-9)
    return np.asarray(off, dtype=float)


PATHS = (
    Item(
        key="fig2",
        title="Fig 2: the path of a gait",
        shows="Counter-clockwise travel by roll, pitch and yaw oscillations.",
        make=_fig_2,
    ),
    Item(
        key="fig6",
        title="Fig 6: the lateral gait, full and pivoting model",
        shows="Both travel sideways, almost equally far.",
        make=_fig_6,
    ),
    Item(
        key="fig7",
        title="Fig 7: the circular gait, full and pivoting model",
        shows="Both circle counter-clockwise; the pivoting model turns much faster.",
        make=_fig_7,
    ),
    Item(
        key="fig15",
        title="Fig 15: the lateral gait, full and single-axis models",
        shows="A strong match of the rotations; roll is negligible.",
        make=_fig_15,
    ),
    Item(
        key="fig16",
        title="Fig 16: the circular gait, full and single-axis models",
        shows="Pitch and yaw oscillations, small roll, a tilted mean pitch and net yaw in both.",
        make=_fig_16,
    ),
    Item(
        key="fig17",
        title="Fig 17: the robot as a unicycle",
        shows="Its mean motion is like that of a vertical unicycle along the leg axis.",
        make=_fig_17,
    ),
)
