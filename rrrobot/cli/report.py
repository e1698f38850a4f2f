"""What a run is summed up in: plain data for JSON, a table for people."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import ParameterError
from rrrobot.inline import aligned, oscillation, percent
from rrrobot.simulation.steady import steady_state
from rrrobot.simulation.trajectory import Trajectory

_AXES = ("roll", "pitch", "yaw")


def to_json(data: object) -> str:
    """JSON text without NaN and infinity, which JSON does not know: they become null."""
    return json.dumps(_plain(data), indent=2, allow_nan=False)


def tell(data: Mapping[str, Any], text: str, files: Sequence[Path], *, as_json: bool) -> None:
    """Print a result, as JSON or as text, and which files were written."""
    if as_json:
        click.echo(to_json({**data, "files": [str(path) for path in files]}))
        return
    click.echo(text)
    for path in files:
        click.echo(f"wrote {path}")


def grid(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table for people: the first column to the left, the others to the right."""
    widths = [max(len(r[i]) for r in (head, *rows)) for i in range(len(head))]
    lines = []
    for row in (head, *rows):
        first, *others = row
        cells = [f"{first:<{widths[0]}}"]
        cells += [f"{c:>{w}}" for c, w in zip(others, widths[1:], strict=True)]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def summary(trajectory: Trajectory) -> dict[str, Any]:
    """Plain data in SI units; "steady_state" is None, with the reason, where there is none."""
    t = trajectory
    settled, reason = _steady_state(t)
    contact = t.has_contact
    return {
        "robot": {"name": t.robot.name, "mass": t.robot.mass, "legs": list(t.robot.legs)},
        "model": t.metadata.get("model"),
        "gait": t.metadata.get("gait"),
        "duration": float(t.time[-1]),
        "samples": len(t),
        "end": {"euler": t.euler[-1], "position": t.position[-1], "leg_angle": t.leg_angle[-1]},
        "steady_state": settled,
        "no_steady_state_because": reason,
        "slip": float(t.slip.max()) if contact else None,
        "height_error": float(np.abs(t.height_error).max()),
        "energy": {"start": float(t.energy[0]), "end": float(t.energy[-1]), **_range(t.energy)},
        "has_contact": contact,
        "normal_force": _range(t.normal_force),
        "required_friction": float(t.required_friction.max()) if contact else None,
        "leg_torque": [_range(column) for column in t.leg_torque.T],
        "lift_off_time": t.lift_off_time,
        "integration": t.metadata.get("integration"),
        "versions": t.metadata.get("versions"),
    }


def table(data: Mapping[str, Any]) -> str:
    """The summary in lines of "name  value", in everyday units."""
    rows: list[tuple[str, str]] = [
        ("robot", f"{data['robot']['name']}, {data['robot']['mass']:.4g} kg"),
        ("model", str(data["model"]["type"])),
        ("gait", gait_words(data["gait"])),
        ("duration", f"{data['duration']:g} s, {data['samples']} samples"),
        *_settled_rows(data),
        ("contact point at the end", _list(data["end"]["position"], "mm", 1000.0)),
        ("roll, pitch, yaw at the end", _list(data["end"]["euler"], "deg", 180 / math.pi)),
        ("energy", _span(data["energy"], "J")),
        ("motor torques", _span(_joined(data["leg_torque"]), "N m")),
    ]
    if data["has_contact"]:
        friction = data["required_friction"]
        needed = f"{friction:.3g}" if math.isfinite(friction) else "none would do: it lifts off"
        rows += [
            ("normal force", _span(data["normal_force"], "N")),
            ("friction needed", needed),
            ("largest slip", f"{1000 * data['slip']:.1e} mm/s"),
            ("largest height error", f"{1000 * data['height_error']:.1e} mm"),
        ]
    else:
        rows.append(("vertical force of the pivot", _span(data["normal_force"], "N")))
    if data["lift_off_time"] is not None:
        time = f"at {data['lift_off_time']:.4g} s; from then on this motion means nothing"
        rows.append(("LIFTS OFF", time))
    return aligned(rows)


def _steady_state(trajectory: Trajectory) -> tuple[dict[str, Any] | None, str | None]:
    if trajectory.period is None:
        return None, "the motion of the legs has no period"
    ramp = trajectory.metadata.get("gait", {})
    blended = ramp["duration"] if ramp.get("type") == "ramp_in" else 0.0
    start = max(blended, float(trajectory.time[-1]) / 2)
    try:
        return steady_state(trajectory, after=start).to_dict(), None
    except ParameterError as error:
        return None, str(error).rstrip(".")


def _settled_rows(data: Mapping[str, Any]) -> list[tuple[str, str]]:
    settled = data["steady_state"]
    if settled is None:
        return [("no steady state", str(data["no_steady_state_because"]))]
    last = settled["after"] + settled["cycles"] * settled["period"]
    curvature = settled["curvature"]
    counted = (
        f"means of {settled['cycles']} cycles of {settled['period']:.4g} s, "
        f"{settled['after']:.4g} .. {last:.4g} s, steps vary by {percent(settled['variation'])}"
    )
    travel, spread = 1000 * settled["mean_travel"], 1000 * settled["spread"]
    rows = [
        ("steady state" if settled["settled"] else "NOT SETTLED", counted),
        ("  speed v", f"{1000 * settled['speed']:.4f} mm/s")
        if settled["settled"]
        else ("  mean travel", f"{travel:.4f} +- {spread:.4f} mm/s in single cycles"),
        ("  yaw rate", f"{_rounded(settled['yaw_rate'])} rad/s"),
        (
            "  curvature",
            "infinite: it turns on the spot"
            if curvature is None
            else f"{_rounded(curvature, 4)} 1/m",
        ),
    ]
    for i, name in enumerate(_AXES):
        angles = (settled[key][i] for key in ("amplitude", "phase", "mean"))
        rows.append((f"  {name}", oscillation(*angles)))
    return rows


def gait_words(gait: Mapping[str, Any]) -> str:
    """A gait's `to_dict` in one line."""
    kind = gait.get("type")
    if kind == "sinusoidal":
        return (
            f"offset {_list(gait['offset'])} + {_list(gait['amplitude'])} rad, "
            f"{_list(gait['angular_frequency'])} rad/s, phase {_list(gait['phase'])} rad"
        )
    if kind == "ramp_in":
        return f"{gait_words(gait['gait'])}, blended in over {gait['duration']:g} s"
    if kind == "still":
        return f"legs held at {_list(gait['angle'])} rad"
    if kind == "torques":
        start = f"legs from {_list(gait['angle'])} rad"
        return f"torques {_list(gait['constant'] or [])} N m, {start}"
    return str(kind)


def _range(values: Array) -> dict[str, float]:
    return {"min": float(values.min()), "max": float(values.max())}


def _joined(ranges: list[dict[str, float]]) -> dict[str, float]:
    if not ranges:
        return {"min": 0.0, "max": 0.0}
    return {"min": min(r["min"] for r in ranges), "max": max(r["max"] for r in ranges)}


def _span(limits: Mapping[str, float], unit: str) -> str:
    return f"{limits['min']:.5g} .. {limits['max']:.5g} {unit}"


def _list(values: Any, unit: str = "", scale: float = 1.0) -> str:
    entries = [_rounded(scale * value, 4) for value in np.atleast_1d(values)]
    if len(set(entries)) == 1 and not unit:
        return entries[0]
    return f"{', '.join(entries)} {unit}".rstrip()


def _rounded(value: float, digits: int = 7) -> str:
    """Fixed decimals, without trailing zeros and without a minus before zero."""
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _plain(data: object) -> Any:
    if isinstance(data, Mapping):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, np.ndarray):
        return _plain(data.tolist())
    if isinstance(data, (list, tuple)):
        return [_plain(value) for value in data]
    if isinstance(data, float):
        return float(data) if math.isfinite(data) else None
    return data
