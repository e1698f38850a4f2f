"""What ways to get free do, in everyday units: rows of tables."""

from __future__ import annotations

import numpy as np

from rrrobot.escape.confirming import EscapeGait
from rrrobot.escape.lying import Lying
from rrrobot.escape.ways import RollOff


def shown_value(gait: EscapeGait) -> str:
    """The goal's value with everyday units."""
    if gait.goal.leans or gait.goal.turns:
        unit = "deg" if gait.goal.leans else "deg/s"
        return f"{np.rad2deg(gait.value):.1f} {unit}"
    return f"{1000 * gait.value:.1f} mm/s"


def share_text(gait: EscapeGait | RollOff) -> str:
    """Largest torque over its limit."""
    share = gait.torque_share[np.isfinite(gait.torque_share)]
    return f"{100 * share.max():.0f} %" if share.size else "no limit in the file"


def off_rows(way: RollOff) -> dict[str, str]:
    """What comes of leaning off a rock, in everyday units."""
    lacking = "short of going" if way.short > 0 else "beyond where it goes"
    rows = {
        "legs move the centre of mass": f"{1000 * way.shift:.0f} mm to that side, in "
        f"{way.drive.duration:.2f} s",
        "leaning, at the belly's edge": f"{1000 * abs(way.short):.0f} mm {lacking} over",
        "friction needed until it goes over": f"{way.friction:.2f}",
        "largest torque over its limit": share_text(way),
        "off the rock": "yes" if way.met else f"no: {way.reason}",
    }
    if np.isfinite(way.over):
        rows["the belly is at its edge"] = f"at {way.over:.2f} s"
    if way.met:
        ends = {"floor": f"{way.link} reaches the floor", "slide": "it slides off"}
        told = ends.get(way.ended, "the rock pushes no longer")
        rows["ends"] = f"at {way.duration:.2f} s: {told}"
        at = way.landing
        ahead, left = np.round(1000 * np.array((at.ahead, at.left))) + 0.0
        heading, tilt = np.round(np.rad2deg((at.heading, at.tilt))) + 0.0
        rows["there its base is"] = (
            f"{ahead:.0f} mm ahead and {left:.0f} mm left of the rock's top, faces {heading:.0f} "
            f"deg to the left and leans {tilt:.0f} deg"
        )
        rows["its centre of mass moves at"] = f"{at.speed:.2f} m/s"
        if at.room > 0:
            rows["to the floor it still falls"] = (
                f"{1000 * at.room:.0f} mm, and comes down at up to {at.impact:.2f} m/s"
            )
        rows |= _floor_rows(way)
        rows["set-points of the joints"] = (
            f"{way.goal.file_name}.csv and .ros.json end at {way.drive.duration:.2f} s, where the "
            "legs lean: they stay there until the robot lies; the postures to which they go then "
            "are in unstick.json, under lying"
        )
    return rows


def _lies(one: Lying) -> str:
    ways = ("upright", "on its side", "on its back")
    return ways[int(np.searchsorted(np.deg2rad((60.0, 120.0)), one.tilt))]


def _by_way(one: Lying) -> str:
    others = len(one.postures) - 1
    return "slowly" if not others else f"slowly, by way of {others} that they had before,"


def _floor_rows(way: RollOff) -> dict[str, str]:
    """What comes of it on the floor."""
    rows = {}
    for one, name in zip(
        way.lying, ("comes to lie on", "or, if it turns no further"), strict=False
    ):
        # Plus zero, so that nothing shows as -0.
        ahead, left = np.round(1000 * np.array((one.ahead, one.left))) + 0.0
        heading, tilt = np.round(np.rad2deg((one.heading, one.tilt))) + 0.0
        rows[name] = (
            f"{', '.join(one.links)}; {_lies(one)}, {ahead:.0f} mm ahead and {left:.0f} mm left of "
            f"the rock's top, faces {heading:.0f} deg to the left and leans {tilt:.0f} deg"
        )
    if way.lying:
        rows["assumed of that"] = (
            "it falls freely, as if the rock were no longer there, the first blow takes all of its "
            "energy, nothing slips, it tips slowly until it lies, and the legs go "
            f"{_by_way(way.lying[0])} to the posture of a robot that lies on its belly"
        )
    if way.after is None:
        rows["goes on from there"] = f"no: {way.stays}"
        return rows
    astray = np.round(np.rad2deg(way.astray))
    side = "left" if astray >= 0 else "right"
    run, gone = way.after.trajectory, way.path[-1][-1] @ np.array(way.goal.weights[:2])
    rows["goes on from there"] = (
        f"{shown_value(way.after)}, {abs(astray):.0f} deg to the {side} of that side "
        f"({way.after.goal.name} of where it faces, and it turns as it gets going), on the "
        f"belly that fit_belly finds for level ground; {run.time[-1]:.1f} s after it lies, "
        f"{1000 * gone:.0f} mm from the rock's top to that side"
    )
    return rows


def gait_rows(gait: EscapeGait) -> dict[str, str]:
    """What a gait does, in everyday units."""
    m = gait.measured
    # Plus zero, so that nothing shows as -0.0.
    ahead, left = np.round(1000 * gait.travel[:2], 1) + 0.0
    turn = np.round(np.rad2deg(gait.travel[2]), 1) + 0.0
    rows = {
        gait.goal.name: shown_value(gait),
        "ahead, to the left, turning": f"{ahead:.1f} mm/s, {left:.1f} mm/s, {turn:.1f} deg/s",
        "period": f"{gait.gait.period:.3f} s",
        "begins": f"from rest, blended in over {gait.ramp:.2f} s (RampIn); files have one period",
        "friction needed": f"{m['friction']:.3f}",
        "least normal force": f"{m['normal_force']:.2f} of the weight",
        "largest tilt": f"{np.rad2deg(m['tilt']):.1f} deg",
        "least clearance from the ground": f"{1000 * m['clearance']:.1f} mm",
        "least distance of links": f"{1000 * m['separation']:.1f} mm",
        "largest torque over its limit": share_text(gait),
        "mean power of the motors": f"{m['power']:.3g} W",
    }
    for key, unit in (("energy_per_metre", "J/m"), ("energy_per_radian", "J/rad")):
        if key in m:
            rows["energy"] = f"{m[key]:.3g} {unit}"
    rows["engine and KKT model differ by"] = f"{100 * gait.discrepancy:.2g} %"
    rows["binding"] = ", ".join(gait.binding) or "nothing"
    rows["limits"] = "met" if gait.met else "NOT MET"
    return rows
