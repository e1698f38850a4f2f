"""`python -m benchmarks.report_steering`: docs/steering_study.md and its pictures."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

import rrrobot as rr
from benchmarks import decoupled, steering
from benchmarks.common import RESULTS, ROOT
from benchmarks.feedback import other
from rrrobot.drawing import PALE, legend_above, line, new_figure, tidy, write_figure

PAGE, IMAGES = ROOT / "docs" / "steering_study.md", ROOT / "docs" / "images"


def read(name: str) -> Any:
    """A result file of this folder."""
    return json.loads((RESULTS / f"{name}.json").read_text())


def column(rows: list[dict[str, Any]], key: str) -> np.ndarray:
    """A number of each row (n,), NaN where there is none."""
    return np.array([np.nan if row[key] is None else row[key] for row in rows], dtype=float)


def _exact(found: dict[str, Any]) -> str:
    rows = found["rows"]
    place, turn, cost = 1e3 * column(rows, "place"), column(rows, "turn"), column(rows, "planning")
    legs, bound = column(rows, "legs"), column(rows, "bound")
    return f"""\
| goals | {len(rows)} |
|---|---|
| at rest within 1 mm and 0.2° on the exact model | {found["met"]} |
| final place, median and worst | {np.median(place):.4f} mm, {place.max():.3f} mm |
| final yaw, median and worst | {np.rad2deg(np.median(turn)):.4f}°, {np.rad2deg(turn.max()):.4f}° |
| planning, median and worst | {np.median(cost):.2f} s, {cost.max():.2f} s of one core |
| legs move, median | {np.median(legs):.1f} s |
| that over the least time, median | {np.median(legs / bound):.2f} |"""


def _closed(found: dict[str, Any]) -> str:
    rows = found["rows"]
    place, turn = 1e3 * column(rows, "place"), np.rad2deg(column(rows, "turn"))
    blind = 1e3 * column(rows, "alone_place")
    tries = column(rows, "tries")
    legs, bound = column(rows, "legs"), column(rows, "bound")
    return f"""\
| goals, each on another robot | {len(rows)} |
|---|---|
| at rest within 10 mm and 3° | {found["within_10_mm_and_3_deg"]} |
| final place, median and worst | {np.median(place):.2f} mm, {place.max():.2f} mm |
| final yaw, median and worst | {np.median(turn):.2f}°, {turn.max():.2f}° |
| first plan alone, median and worst place | {np.median(blind):.0f} mm, {blind.max():.0f} mm |
| plans, median and most | {np.median(tries):.0f}, {tries.max():.0f} |
| legs move in all, median | {np.median(legs):.1f} s |
| that over the least time, median | {np.median(legs / bound):.2f} |"""


def _eights(found: dict[str, Any]) -> str:
    rms = 1e3 * np.array(found["rms"])
    worst = found["rows"][int(rms.argmax())]["seed"]
    share = other(worst).damping / rr.RRRobotParameters().damping
    return (
        f"Of {len(rms)} such robots, the root mean square of the cycle-mean path's distance is\n"
        f"{np.median(rms):.2f} mm in the median and {rms.max():.2f} mm at worst;\n"
        f"{int(np.sum(rms <= 5.0))} of {len(rms)} keep 5 mm.\n"
        f"The worst has {share:.2f} times the damping that the controller believes in."
    )


def _masses(found: dict[str, Any]) -> str:
    rms = 1e3 * np.array(found["rms"])
    return (
        f"With all masses off by 5 % and nothing else, {len(rms)} robots:\n"
        f"{np.median(rms):.2f} mm in the median, {rms.max():.2f} mm at worst."
    )


def _fits(found: dict[str, Any]) -> str:
    each = found["within_two_deviations"]
    lines = ["| parameter | within two stated deviations |", "|---|---|"]
    lines += [
        f"| {name.replace('_', ' ')} | {n} of {found['trials']} |" for name, n in each.items()
    ]
    together = found["within_the_95_%_ellipsoid"]
    lines.append(f"| all, within the 95 % ellipsoid | {together} of {found['trials']} |")
    return "\n".join(lines)


def page() -> str:
    """The page's text."""
    return f"""\
# Steering, measured

Written by `python -m benchmarks.report_steering` from `benchmarks/results`. To measure anew, remove
a file there and run `python -m benchmarks.steering`, `python -m benchmarks.feedback goals` (or
`eight`, `masses`, `fit`), `python -m benchmarks.decoupled`; each goes on from what its file holds.
What is measured is explained in [From a wanted motion to leg motions](theory/steering.md).

## On the exact model

Random goals within 0.5 m and any heading, amplitudes up to 0.5 rad, planned with the engine and
executed by the KKT form. The least time is that of distance and turn at the highest speed and yaw
rate of all gaits.

{_exact(read("steering"))}

![Final errors, the lines at 1 mm and 0.2°; and times beside the least](images/steering.png)

## On robots that differ

The same goals, by `reach`. Each robot's masses are off by up to 5 %, each by itself, the radius by
2 %, the damping by 50 %, and it stands on a slope of 2° in any direction. The pose is measured with
1 mm and 0.5°.

{_closed(read("feedback_goals"))}

![Final errors of the first plan alone and with feedback](images/feedback.png)

## A figure eight for ten minutes

Half a metre wide, by `follow`, on robots and slopes that differ as above, measured a cycle late.

{_eights(read("feedback_eight"))}

{_masses(read("feedback_masses"))}

## Which robot is it?

Runs of 33 s on robots and slopes that differ as above, one mass known, fitted by `identify`:

{_fits(read("feedback_fit"))}

## Planned on the decoupled models

The same goals; maps of the full or of the decoupled models, plans made exact on one or the other,
all executed on the full model.

{decoupled.table(read("decoupled"))}

![Final errors of the three kinds of plans](images/decoupled.png)
"""


def draw_closed(rows: list[dict[str, Any]]) -> None:
    """Cumulative distributions of the final errors, blind and with feedback."""
    figure = new_figure(7.5, 3.2)
    for ax, key, scale, most, label in zip(
        figure.subplots(1, 2), ("place", "turn"), (1e3, 180 / np.pi), (10.0, 3.0),
        ("final place, off by [mm]", "final yaw, off by [deg]"), strict=True,
    ):  # fmt: skip
        for k, (name, part) in enumerate((("with feedback", key), ("first plan", f"alone_{key}"))):
            values = np.sort(scale * column(rows, part))
            share = (np.arange(values.size) + 1) / len(rows)
            ax.step(values, share, where="post", label=name, **line(k))
        ax.axvline(most, color=PALE, linewidth=3, zorder=0)
        tidy(ax, label, "share of goals" if key == "place" else "")
        ax.set_xscale("log")
    legend_above(figure.axes[0])
    write_figure(figure, IMAGES / "feedback.png")


def main() -> None:
    steering.draw(read("steering")["rows"])
    draw_closed(read("feedback_goals")["rows"])
    decoupled.draw(read("decoupled"))
    PAGE.write_text(page())


if __name__ == "__main__":
    main()
