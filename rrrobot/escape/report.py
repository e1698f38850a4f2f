"""The whole story on disk: a page that stands by itself, a film of each gait, files for the robot.

    report.html              belly, rest, modes, every gait with its margins, figures within
    NAME.html                film of a gait
    NAME.json                the gait, for `read_gait` and --gait
    NAME.csv, NAME.ros.json  set-points of one period for the joints' controllers
    NAME.npz                 the run that confirms it
    unstick.json             all numbers

NAME is the goal's, as turn_left.
"""

from __future__ import annotations

import base64
import io
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.drawing import COLOURS, FONT, line, new_figure, tidy
from rrrobot.drive.tables import gait_table, write_gait
from rrrobot.escape.belly_rows import belly_rows
from rrrobot.escape.confirming import EscapeGait
from rrrobot.escape.rolling_off import RollOff
from rrrobot.files import write_whole
from rrrobot.inline import html_table, png
from rrrobot.robot.joints import sliding

if TYPE_CHECKING:
    from rrrobot.escape.unstuck import Unstuck

_RATE = 200.0
"""Set-points a second [1/s]."""
_SHOWN = 6
"""Seconds of a film, at most, beside the ramp."""
_STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;max-width:60em;margin:2em auto;padding:0 1em}"
    "td,th{overflow-wrap:break-word;text-align:left;vertical-align:top;padding:.1em .8em .1em 0}"
    "table{border-collapse:collapse;margin:.6em 0}h1,h2{line-height:1.2}"
    ".no{color:#BB5566;font-weight:bold}img{max-width:100%}"
)


def write_report(found: Unstuck, folder: str | Path, *, films: bool = True) -> list[Path]:
    """Write everything into a folder.

    Args:
        found: of `unstick`.
        folder: made if there is none.
        films: whether to write a film of each gait.

    Returns:
        the files, the report last.

    Raises:
        OutputError: a file cannot be written.
    """
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    for goal in found.goals:
        if goal.name in found.off and found.off[goal.name].met:
            written += _off_files(found.off[goal.name], place, films=films)
        for i, gait in enumerate(found.found.get(goal.name, ())):
            name = goal.file_name + ("" if i == 0 else f"_{i + 1}")
            written += _robot_files(gait, place, name)
            if films:
                written.append(_film(gait, place / f"{name}.html"))
    page = report_html(found, films=films)
    written.append(write_whole(place / "report.html", page.encode()))
    return written


def _robot_files(gait: EscapeGait, place: Path, name: str) -> list[Path]:
    robot = gait.trajectory.robot
    table = gait_table(gait.gait, _RATE, joints=robot.legs, slides=sliding(robot.model, robot.legs))
    return [
        write_gait(gait.gait, place / f"{name}.json"),
        table.to_csv(place / f"{name}.csv"),
        table.to_ros(place / f"{name}.ros.json"),
    ]


def _off_files(way: RollOff, place: Path, *, films: bool) -> list[Path]:
    from rrrobot.view.films import record

    name, run, drive = way.goal.file_name, way.trajectory, way.drive
    table = gait_table(drive, _RATE, duration=drive.duration, joints=run.robot.legs)
    written = [
        write_gait(drive, place / f"{name}.json"),
        table.to_csv(place / f"{name}.csv"),
        table.to_ros(place / f"{name}.ros.json"),
    ]
    return [*written, record(run, place / f"{name}.html", speed=0.5)] if films else written


def _film(gait: EscapeGait, path: Path) -> Path:
    from rrrobot.view.films import record

    run = gait.trajectory
    last = gait.ramp + max(_SHOWN, 4 * (gait.gait.period or 0.0))
    n = int(np.searchsorted(run.time, last))
    arrays: dict[str, Any] = {
        key: value[:n]
        for key, value in vars(run).items()
        if isinstance(value, np.ndarray) and len(value) == len(run.time)
    }
    return record(replace(run, end=None, **arrays), path)


def report_html(found: Unstuck, *, films: bool = True) -> str:
    """The report as one page of HTML, without network and scripts."""
    belly = found.belly
    parts = [
        f"<h1>Getting {escape(belly.robot.name)} free</h1>",
        _summary(found, films=films),
        "<h2>The belly</h2>",
        _picture(_png_of(belly.plot())),
        html_table("Belly and rest", belly_rows(found)),
    ]
    for goal in found.goals:
        parts.append(f"<h2>{escape(goal.name)}</h2>")
        if goal.name in found.reasons:
            parts.append(f'<p class="no">{escape(found.reasons[goal.name])}</p>')
        if goal.name in found.off:
            parts.append(html_table("Rolling off the rock", off_rows(found.off[goal.name])))
        for gait in found.found.get(goal.name, ()):
            parts.append(html_table("Settled cycle", gait_rows(gait)))
            parts.append(html_table("Joints", _joint_rows(gait), head=_JOINT_HEAD))
            parts.append(_picture(png(gait_figure(gait))))
    title = f"{belly.robot.name}: ways to get free"
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width"><title>{escape(title)}</title>'
        f"<style>{_STYLE}</style></head><body>{''.join(parts)}</body></html>\n"
    )


def _summary(found: Unstuck, *, films: bool) -> str:
    rows = []
    for goal in found.goals:
        way = found.off.get(goal.name)
        if way is not None and way.met:
            rows.append((goal.name, f"off in {way.duration:.2f} s", f"{way.friction:.2f}", "", ""))
            continue
        if goal.name not in found.found:
            rows.append((goal.name, "none feasible", "", "", ""))
            continue
        best = found.best(goal.name)
        rows.append((
            goal.name, shown_value(best) if goal.name not in found.reasons else "none feasible",
            f"{best.measured['friction']:.2f}", share_text(best),
            f"{1000 * best.measured['clearance']:.0f} mm",
        ))  # fmt: skip
    head = ("goal", "what comes of it", "friction needed", "torque over limit", "clearance")
    links = []
    if films:
        links = [
            f'<a href="{goal.file_name}.html">film: {escape(goal.name)}</a>'
            for goal in found.goals
            if goal.name in found.found or (goal.name in found.off and found.off[goal.name].met)
        ]
    return html_table("Ways", rows, head=head) + "<p>" + " · ".join(links) + "</p>"


def shown_value(gait: EscapeGait) -> str:
    """The goal's value with everyday units."""
    if gait.goal.leans or gait.goal.turns:
        unit = "deg" if gait.goal.leans else "deg/s"
        return f"{np.rad2deg(gait.value):.1f} {unit}"
    return f"{1000 * gait.value:.1f} mm/s"


def share_text(gait: EscapeGait) -> str:
    """Largest torque over its limit."""
    share = gait.torque_share[np.isfinite(gait.torque_share)]
    return f"{100 * share.max():.0f} %" if share.size else "no limit in the file"


def off_rows(way: RollOff) -> dict[str, str]:
    """What comes of leaning off a rock, in everyday units."""
    rows = {
        "legs move the centre of mass": f"{1000 * way.shift:.0f} mm to that side, in "
        f"{way.drive.duration:.2f} s",
        "friction needed until it goes over": f"{way.friction:.2f}",
        "off the rock": "yes" if way.met else f"no: {way.reason}",
    }
    if np.isfinite(way.over):
        rows["goes over"] = f"at {way.over:.2f} s"
    if way.met:
        ends = {"floor": f"{way.link} reaches the floor", "slide": "it slides off"}
        told = ends.get(way.ended, "the rock pushes no longer")
        rows["ends"] = f"at {way.duration:.2f} s: {told}"
        at, deg = way.landing, np.rad2deg
        rows["there its base is"] = (
            f"{1000 * at.ahead:.0f} mm ahead and {1000 * at.left:.0f} mm left of the rock's top, "
            f"faces {deg(at.heading):.0f} deg to the left and leans {deg(at.tilt):.0f} deg"
        )
        rows["its centre of mass moves at"] = f"{at.speed:.2f} m/s"
        if at.room > 0:
            rows["to the floor it still falls"] = (
                f"{1000 * at.room:.0f} mm, and comes down at up to {at.impact:.2f} m/s"
            )
        rows["from the floor on"] = (
            "how it comes to lie is not computed; gaits of a robot that lies on its belly there: "
            "the same command without --ground"
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
        "friction needed": f"{m['friction']:.3f}",
        "least normal force": f"{m['normal_force']:.2f} of the weight",
        "largest tilt": f"{np.rad2deg(m['tilt']):.1f} deg",
        "least clearance from the ground": f"{1000 * m['clearance']:.1f} mm",
        "least distance of links": f"{1000 * m['separation']:.1f} mm",
        "largest torque over its limit": share_text(gait),
        "mean power of the motors": f"{m['power']:.2f} W",
    }
    for key, unit in (("energy_per_metre", "J/m"), ("energy_per_radian", "J/rad")):
        if key in m:
            rows["energy"] = f"{m[key]:.3g} {unit}"
    rows["engine and KKT model differ by"] = f"{100 * gait.discrepancy:.2g} %"
    rows["binding"] = ", ".join(gait.binding) or "nothing"
    rows["limits"] = "met" if gait.met else "NOT MET"
    return rows


_JOINT_HEAD = ("joint", "from [deg]", "to [deg]", "rate [rad/s]", "torque [N m]", "of its limit")


def _joint_rows(gait: EscapeGait) -> list[tuple[str, ...]]:
    motion = gait.gait(np.linspace(0, gait.gait.period or 0.0, 200))
    low, high = np.rad2deg(motion.angle.min(axis=0)), np.rad2deg(motion.angle.max(axis=0))
    rate = np.abs(motion.rate).max(axis=0)
    return [
        (name, f"{low[k]:.1f}", f"{high[k]:.1f}", f"{rate[k]:.2f}", f"{gait.torque[k]:.3g}",
         "-" if np.isnan(gait.torque_share[k]) else f"{100 * gait.torque_share[k]:.0f} %")
        for k, name in enumerate(gait.trajectory.robot.legs)
    ]  # fmt: skip


def gait_figure(gait: EscapeGait) -> Any:
    """Path of the contact, and the body's angles and the legs through the last cycles."""
    run, period = gait.trajectory, gait.gait.period or 1.0
    figure = new_figure(9.0, 3.2)
    path, body, legs = figure.subplots(1, 3)
    path.plot(100 * run.position[:, 0], 100 * run.position[:, 1], color=COLOURS[0], linewidth=1.0)
    path.plot(*(100 * run.position[0]), "o", color=COLOURS[1], markersize=4)
    path.set_aspect("equal", adjustable="datalim")
    tidy(path, "x [cm]", "y [cm]")
    path.set_title("contact point, from the dot", fontsize=FONT)
    last = run.time >= run.time[-1] - 2 * period
    time = run.time[last] - run.time[last][0]
    for k, name in enumerate(("roll", "pitch")):
        body.plot(time, np.rad2deg(run.euler[last, k]), label=name, **line(k))
    tidy(body, "time [s]", "[deg]")
    body.legend(fontsize=FONT - 1, frameon=False)
    body.set_title("body", fontsize=FONT)
    swing: Array = np.rad2deg(run.leg_angle[last] - run.leg_angle[last].mean(axis=0))
    most = np.argsort(-np.abs(swing).max(axis=0), kind="stable")[:4]
    for i, k in enumerate(most):
        legs.plot(time, swing[:, k], label=run.robot.legs[k], **line(i))
    tidy(legs, "time [s]", "from the mean [deg]")
    low, high = legs.get_ylim()
    legs.set_ylim(low, high + 0.35 * (high - low))
    legs.legend(fontsize=FONT - 2, frameon=False, ncols=2, loc="upper center")
    legs.set_title("joints that swing most", fontsize=FONT)
    return figure


def _png_of(axes: Any) -> bytes:
    stream = io.BytesIO()
    # Axes of equal scales leave room above and below.
    figure = np.ravel(np.array(axes, dtype=object))[0].figure
    figure.savefig(stream, format="png", dpi=100, bbox_inches="tight")
    return stream.getvalue()


def _picture(data: bytes) -> str:
    text = base64.b64encode(data).decode("ascii")
    return f'<img src="data:image/png;base64,{text}" alt="plot">'
