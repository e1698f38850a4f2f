"""Claims of the paper about where gaits take the robot, and what the net motion depends on."""

from __future__ import annotations

import math

import numpy as np

from rrrobot.drive.gaits import gait
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.single_axis import YawModel
from rrrobot.paper.item import Item, Result, about, above, below, feature, record
from rrrobot.paper.settled import both_legs, settled
from rrrobot.paper.workshop import Workshop
from rrrobot.studies.sweeps.run import sweep

TRAVELS, TURNS = 2e-3, 2e-3
"""Speed [m/s] and yaw rate [rad/s] above which a gait of the plane counts as one that does."""


def _leg_axis(shop: Workshop) -> Result:
    full = shop.plane("full")
    across, along = np.abs(full.velocity_x), np.abs(full.velocity_y)
    off = np.degrees(np.arctan2(across, along))
    share = float((off < 15).where(full.speed > TRAVELS).mean())
    fast = full.speed > 0.6 * full.speed.max()
    level = full.sel(offset=0.0, phase_difference=math.pi, method="nearest")
    of_gaits = [
        float(off.sel(offset=o, phase_difference=math.pi / 2, method="nearest"))
        for o in (math.pi / 2, math.pi / 4)
    ]
    rows = (
        feature(
            "lateral and circular gait, travel off the leg axis", "along it", max(of_gaits), "deg",
            limit=below(2),
        ),
        feature(
            "gaits above 6/10 of the top speed, farthest off the leg axis", "along it",
            float(off.where(fast).max()), "deg", limit=below(15),
        ),
        feature(
            "gaits above 2 mm/s, share within 15 deg of the leg axis", "predominant", share,
            limit=above(0.5),
        ),
        record(
            "opposite level legs, velocity across the leg axis", 1e3 * float(level.velocity_x),
            "mm/s", "Roll and yaw out of phase travel forwards, as pitch and yaw do sideways.",
        ),
    )  # fmt: skip
    remarks = (
        "All fast gaits travel along the leg-rotation axis. The exceptions have legs near level "
        "and nearly opposite: they roll and yaw more than they pitch, and go forwards.",
    )
    return Result(rows=rows, remarks=remarks)


def _start_independence(shop: Workshop) -> Result:
    model, circular = FullModel(shop.robot), gait("circular")
    starts: tuple[dict[str, object], ...] = (
        {"start": "rest"},
        {"euler": (0.2, -0.3, 1.0)},
        {"start": (1.0, -1.0, 2.0)},
        {"euler": (-0.4, 0.4, 0.0), "start": (0.0, 0.0, -3.0)},
    )
    reference = settled(model, circular, cycles=48).steady_state()
    found = [settled(model, circular, cycles=48, **start).steady_state() for start in starts]
    speed = max(abs(s.speed / reference.speed - 1) for s in found)
    rate = max(abs(s.yaw_rate / reference.yaw_rate - 1) for s in found)
    later = [
        settled(model, both_legs(math.pi / 4, start=s), cycles=48).steady_state() for s in (1, 2, 4)
    ]
    phases = max(abs(s.yaw_rate / reference.yaw_rate - 1) for s in later)
    phases_speed = max(abs(s.speed / reference.speed - 1) for s in later)
    lateral = gait("lateral")
    kept = settled(YawModel(shop.robot), lateral, start="rest").steady_state().yaw_rate
    pivoting = settled(PivotingModel(shop.robot), lateral, start="rest").steady_state().yaw_rate
    rows = (
        feature(
            "full model, four other starts: change of v, at worst", "limit cycle", speed,
            limit=below(1e-06),
        ),
        feature(
            "full model, four other starts: change of the yaw rate", "limit cycle", rate,
            limit=below(1e-06),
        ),
        feature(
            "full model, legs begin elsewhere in the cycle: change of the yaw rate", "limit cycle",
            phases, limit=below(1e-06),
        ),
        feature(
            "full model, legs begin elsewhere in the cycle: change of v", "limit cycle",
            phases_speed, limit=below(0.0003),
            note="What is left is where a cycle begins to count: its mean lies on a wavy path.",
        ),
        record("yaw model, lateral gait, from a body at rest: yaw rate", kept, "rad/s"),
        record("pivoting model, lateral gait, from a body at rest: yaw rate", pivoting, "rad/s"),
    )  # fmt: skip
    remarks = (
        "Damping makes the full model forget its start. The yaw and the pivoting model have no yaw "
        "damping and keep the momentum that they start with: legs that swing at t = 0 over a body "
        "at rest make them spin on the lateral gait, which has no drift. Only the impulsive start, "
        "with no momentum, gives the paper's drift.",
    )
    return Result(rows=rows, remarks=remarks)


def _accessibility(shop: Workshop) -> Result:
    full = shop.plane("full")
    bold = (full.speed > TRAVELS) & (np.abs(full.yaw_rate) > TURNS)
    signs = [
        int((bold & (a * full.velocity_y > 0) & (b * full.yaw_rate > 0)).sum())
        for a in (1, -1)
        for b in (1, -1)
    ]
    tightest = float(np.abs(full.curvature).where(bold).max())
    small = sweep(
        FullModel(shop.robot), offset=0.0, phase_difference=[0.02, 0.04, 0.08], progress=False
    )
    bends = np.abs(small.curvature.to_numpy())
    growth = float(np.ptp(bends) / bends.max())
    rows = (
        feature(
            "gaits of the plane that travel and turn, fewest of the four pairs of signs",
            "straight and curved, either way", min(signs), limit=above(0),
            note="A unicycle that goes and turns either way reaches any place and heading.",
        ),
        record("highest speed of the plane", 1e3 * float(full.speed.max()), "mm/s"),
        feature(
            "level legs nearly in phase, change of K as v goes to zero", "bounded curvature",
            growth, limit=below(0.1),
        ),
        record("smallest radius of a gait that travels above 2 mm/s", 1e3 / tightest, "mm"),
        record("smallest radius of all, where v goes to zero",
               1e3 / float(bends.max()), "mm"),
    )  # fmt: skip
    return Result(rows=rows)


def _second_order(shop: Workshop) -> Result:
    ds = sweep(
        FullModel(shop.robot), offset=math.pi / 4, phase_difference=math.pi / 2,
        amplitude=[0.05, 0.1], cycles=60, progress=False,
    )  # fmt: skip
    names = ("roll_amplitude", "pitch_amplitude", "speed", "yaw_rate")
    power = {name: float(np.log2(ds[name][1] / ds[name][0])) for name in names}
    rows = tuple(
        feature(
            f"circular gait, {name.replace('_', ' ')}: power of the legs' amplitude", words,
            power[name], limit=about(want, 0.05),
        )
        for name, words, want in (
            ("roll_amplitude", "linear", 1),
            ("pitch_amplitude", "linear", 1),
            ("speed", "coupled", 2),
            ("yaw_rate", "inherently nonlinear", 2),
        )
    )  # fmt: skip
    remarks = (
        "Between leg amplitudes of 0.05 and 0.1 rad. A linear model's drift would be zero; travel "
        "and turning are products of two oscillations.",
    )
    return Result(rows=rows, remarks=remarks)


REACH_CLAIMS = (
    Item(
        key="claim-leg-axis",
        title="Travel is along the leg-rotation axis",
        shows="The predominant translation is along the leg-rotation axis (sec. 5).",
        make=_leg_axis,
    ),
    Item(
        key="claim-start",
        title="The settled motion does not depend on the start",
        shows="Oscillations settle into a limit cycle because of friction, so that the net motion "
        "per cycle can be mapped against the gait (sec. 4.2.1, sec. 5).",
        make=_start_independence,
    ),
    Item(
        key="claim-accessibility",
        title="Gaits reach every place in the plane",
        shows="Straight and curved gaits give planar accessibility, with bounded speed and bounded "
        "net curvature (sec. 1, sec. 5).",
        make=_accessibility,
    ),
    Item(
        key="claim-second-order",
        title="Pitch and roll are nearly linear, travel and turning are not",
        shows="Pitch and roll oscillations can be taken as linear; the yaw dynamics is inherently "
        "nonlinear, and without that there is no curved translation (sec. 2.2).",
        make=_second_order,
    ),
)
