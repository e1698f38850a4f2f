"""What a report says of a belly, its rest and its ground."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rrrobot.contact.boulder import Boulder, is_rock
from rrrobot.contact.graph import Graph
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.surfaces import Ellipsoid, Sphere, Surface

if TYPE_CHECKING:
    from rrrobot.escape.unstuck import Unstuck


def _sizes(shell: Surface) -> str:
    """Radii or half lengths of a shell, in words."""
    if isinstance(shell, FlatBelly):
        sides = [f"{2000 * x:.0f} mm" for x in (shell.half_length, shell.half_width) if x]
        return f", {' by '.join(sides)}" if sides else ""
    if isinstance(shell, Sphere):
        return f" of radius {1000 * shell.radius:.0f} mm"
    if isinstance(shell, Ellipsoid):
        return f" of semi-axes {', '.join(f'{1000 * a:.0f}' for a in shell.semi_axes)} mm"
    return ""


def _ground(ground: Ground) -> str:
    """A ground in words."""
    if isinstance(ground, Boulder):
        return f"a {'boulder' if is_rock(ground) else 'bowl'} of radius {abs(ground.radius):g} m"
    if isinstance(ground, Plane):
        steep = np.rad2deg(np.arccos(np.clip(ground.normal(np.zeros(3))[2], -1.0, 1.0)))
        return f"a slope of {steep:.1f} deg" if steep > 1e-6 else "level"
    if isinstance(ground, Graph):
        return f"uneven, known within {ground.reach:g} m"
    return repr(ground)


def belly_rows(found: Unstuck) -> dict[str, str]:
    """Belly, rest, modes and limits, in everyday units."""
    belly = found.belly
    rest = (
        "none"
        if belly.rest is None
        else ", ".join(f"{x:.2f}" for x in np.round(np.rad2deg(belly.rest), 2) + 0.0)
    )
    rows = {
        "underside": f"{belly.kind}: {belly.form}{_sizes(belly.shell)}",
        "largest gap of the shell": f"{1000 * belly.error:.1f} mm",
        "dome to be added": f"{1000 * belly.thickness:.1f} mm",
        "centre of mass": f"{1000 * belly.height:.0f} mm high, "
        f"{1000 * belly.margin[0]:.0f} mm (roll) and {1000 * belly.margin[1]:.0f} mm (pitch) "
        "below the centre of curvature",
        "rest: roll, pitch, yaw": f"{rest} deg",
        "rolls to": f"{np.rad2deg(belly.rolling_range.least):.1f} deg",
        "ground": _ground(belly.ground),
    }
    for mode in belly.modes:
        if np.isfinite(mode.period) and mode.period < 1e3:
            rows[f"mode: {mode.axis}"] = f"{mode.period:.3f} s, {2 * np.pi / mode.period:.2f} rad/s"
    if found.damping is not None:
        # Of the legs' rates too, if there is any.
        numbers = [f"{key} {v:.3g}" for key, v in found.damping.items()
                   if isinstance(v, float) and (v or key != "legs")]  # fmt: skip
        rows["damping of the rocking (assumed unless given)"] = f"{', '.join(numbers)} N m s/rad"
    limits = found.limits
    rows["limits"] = (
        f"friction {limits.friction:g}, normal force {limits.normal_force:g} of the weight"
    )
    if found.unlimited:
        rows["effort limits that are none"] = ", ".join(found.unlimited)
    for text in belly.missing:
        rows["not read"] = text
    return rows
