"""What it costs to plan on the decoupled models, as the paper proposes: same goals, three plans.

    python -m benchmarks.decoupled [goals]

Full maps made exact on the full model; decoupled maps made exact on the full model; decoupled maps
made exact on the decoupled models. All are executed on the full model by the engine, whose ends are
the KKT form's to micrometres (`benchmarks.steering`). Writes benchmarks/results/decoupled.json and
docs/images/decoupled.png.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import rrrobot as rr
from benchmarks.steering import goals
from rrrobot.drawing import legend_above, line, new_figure, tidy, write_figure
from rrrobot.errors import PlanError
from rrrobot.steering.motions import motions_of
from rrrobot.steering.shooting import gap

OUT = Path("benchmarks/results/decoupled.json")


def kinds(model: rr.FullModel) -> dict[str, dict[str, Any]]:
    """Options of `plan` for each kind of plan."""
    apart = motions_of(model, decoupled=True)
    return {
        "full maps, full model": {},
        "decoupled maps, full model": {"motions": apart},
        "decoupled maps, decoupled models": {"on": "decoupled"},
    }


def trial(model: rr.FullModel, goal: np.ndarray, options: dict[str, Any]) -> dict[str, float]:
    started, found = time.process_time(), 1.0
    try:
        plan = rr.plan(model, goal, **options)
    except PlanError as error:
        plan, found = error.nearest, 0.0
    cost = time.process_time() - started
    if plan is None:
        return {"found": 0.0, "place": np.nan, "turn": np.nan, "legs": np.nan, "cost": cost}
    run = plan.execute(method="momentum", sample_interval=0.1)
    off = gap(np.array((*run.position[-1], run.euler[-1, 2])), np.asarray(goal))
    return {
        "found": found, "place": float(np.hypot(*off[:2])), "turn": float(abs(off[2])),
        "legs": plan.gait.duration, "cost": cost,
    }  # fmt: skip


def table(rows: dict[str, list[dict[str, float]]]) -> str:
    """Medians and 90th percentiles as a Markdown table."""
    lines = [
        "| maps, made exact on | plans found | place off, median / 90 % [mm] "
        "| yaw off, median / 90 % [deg] | legs move, median [s] |",
        "|---|---|---|---|---|",
    ]
    for kind, found in rows.items():
        place, turn, legs = (np.array([r[k] for r in found]) for k in ("place", "turn", "legs"))
        mm, deg = 1e3 * place, np.rad2deg(turn)
        lines.append(
            f"| {kind} | {int(sum(r['found'] for r in found))} of {len(found)} "
            f"| {np.nanmedian(mm):.2g} / {np.nanpercentile(mm, 90):.2g} "
            f"| {np.nanmedian(deg):.2g} / {np.nanpercentile(deg, 90):.2g} "
            f"| {np.nanmedian(legs):.1f} |"
        )
    return "\n".join(lines)


def draw(rows: dict[str, list[dict[str, float]]]) -> None:
    """How far from the goal the robot comes to rest: cumulative distributions."""
    figure = new_figure(7.5, 3.2)
    for i, (key, unit, label) in enumerate(
        (("place", 1e3, "final place, off by [mm]"), ("turn", 180 / np.pi, "yaw, off by [deg]"))
    ):
        ax = figure.add_subplot(1, 2, i + 1)
        for k, (kind, found) in enumerate(rows.items()):
            values = np.sort([unit * max(r[key], 1e-7) for r in found])
            share = (np.arange(len(values)) + 1) / len(values)
            ax.step(values, share, where="post", label=kind, **line(k))
        tidy(ax, label, "share of goals" if i == 0 else "")
        ax.set_xscale("log")
        if i == 0:
            legend_above(ax, columns=1)
    write_figure(figure, Path("docs/images/decoupled.png"))


def main(n: int) -> None:
    model = rr.FullModel(rr.Robot.from_parameters())
    options = kinds(model)
    # What was done before goes on; remove the file to begin anew.
    rows: dict[str, list[dict[str, float]]] = (
        json.loads(OUT.read_text()) if OUT.exists() else {kind: [] for kind in options}
    )
    for goal in goals(n)[min(len(found) for found in rows.values()) :]:
        for kind, how in options.items():
            rows[kind].append(trial(model, goal, how))
        OUT.write_text(json.dumps(rows, indent=1))
    print(table(rows))
    draw(rows)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 50)
