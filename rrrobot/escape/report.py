"""The whole story on disk: a page that stands by itself, a film of each gait, files for the robot.

    report.html              belly, rest, modes, every gait with its margins, figures within
    NAME.html                film of a gait
    NAME.json                the gait, for `read_gait` and --gait
    NAME.csv, NAME.ros.json  set-points of one period for the joints' controllers
    NAME.npz                 the run that confirms it
    NAME_floor.*             of the gait that goes on from below a rock
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
from rrrobot.escape.way_rows import gait_rows, off_rows, share_text, shown_value
from rrrobot.escape.ways import RollOff
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
    ".plot{overflow-x:auto}.plot img{min-width:600px}"
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
    legs = run.robot.legs
    slides = sliding(run.robot.model, legs)
    table = gait_table(drive, _RATE, duration=drive.duration, joints=legs, slides=slides)
    written = [
        write_gait(drive, place / f"{name}.json"),
        table.to_csv(place / f"{name}.csv"),
        table.to_ros(place / f"{name}.ros.json"),
    ]
    if films:
        written.append(record(run, place / f"{name}.html", speed=0.5))
    if way.after is not None:
        written += _robot_files(way.after, place, way.after_name)
        if films:
            written.append(_film(way.after, place / f"{way.after_name}.html"))
    return written


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
            way = found.off[goal.name]
            parts.append(html_table("Rolling off the rock", off_rows(way)))
            if way.met:
                parts.append(_picture(png(path_figure(way))))
            if way.after is not None:
                parts.append(html_table("Settled cycle on the floor", gait_rows(way.after)))
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
            told = f"off in {way.duration:.2f} s", f"{way.friction:.2f}", share_text(way), "-"
            rows.append((goal.name, *told))
            continue
        if goal.name not in found.found:
            rows.append((goal.name, "none feasible", "-", "-", "-"))
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
        links += [
            f'<a href="{way.after_name}.html">film: {escape(name)}, on from the floor</a>'
            for name, way in found.off.items()
            if way.after is not None
        ]
    return html_table("Ways", rows, head=head) + "<p>" + " · ".join(links) + "</p>"


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


def path_figure(way: RollOff) -> Any:
    """The base's path from the top of the rock on, seen from above."""
    figure = new_figure(5.0, 3.6)
    axes = figure.subplots()
    names = ("on the rock", "coming to lie", "on the floor")
    for k, (part, name) in enumerate(zip(way.path, names, strict=False)):
        axes.plot(100 * part[:, 1], 100 * part[:, 0], label=name, **line(k))
    axes.plot(0.0, 0.0, "o", color=COLOURS[1], markersize=4)
    axes.set_aspect("equal", adjustable="datalim")
    axes.invert_xaxis()
    tidy(axes, "to the left of the rock's top [cm]", "ahead [cm]")
    axes.legend(fontsize=FONT - 1, frameon=False)
    return figure


def _png_of(axes: Any) -> bytes:
    stream = io.BytesIO()
    # Axes of equal scales leave room above and below.
    figure = np.ravel(np.array(axes, dtype=object))[0].figure
    figure.savefig(stream, format="png", dpi=100, bbox_inches="tight")
    return stream.getvalue()


def _picture(data: bytes) -> str:
    text = base64.b64encode(data).decode("ascii")
    return f'<div class="plot"><img src="data:image/png;base64,{text}" alt="plot"></div>'
