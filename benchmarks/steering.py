"""Random goals: how near exact plans come, how long they take, and what planning costs.

    python -m benchmarks.steering [goals]

Writes benchmarks/results/steering.json and docs/images/steering.png.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import rrrobot as rr
from rrrobot.drawing import COLOURS, PALE, line, new_figure, tidy, write_figure
from rrrobot.errors import PlanError


def goals(n: int, radius: float = 0.5) -> np.ndarray:
    """Poses within a disc, any heading (n, 3)."""
    rng = np.random.default_rng(2026)
    r, a = radius * np.sqrt(rng.random(n)), rng.uniform(0, 2 * np.pi, n)
    return np.column_stack((r * np.cos(a), r * np.sin(a), rng.uniform(-np.pi, np.pi, n)))


OUT = Path("benchmarks/results/steering.json")


def trial(model: rr.FullModel, goal: np.ndarray) -> dict[str, Any]:
    """One goal: planned, and executed on the exact model by the KKT form."""
    started, why = time.process_time(), None
    try:
        plan = rr.plan(model, goal)
    except PlanError as error:
        if error.nearest is None:
            raise
        plan, why = error.nearest, str(error)
    cost = time.process_time() - started
    run = plan.execute(sample_interval=0.1)
    place = float(np.hypot(*(run.position[-1] - goal[:2])))
    turn = float(abs((run.euler[-1, 2] - goal[2] + np.pi) % (2 * np.pi) - np.pi))
    return {
        "goal": goal.tolist(), "place": place, "turn": turn, "legs": plan.gait.duration,
        "bound": plan.lower_bound, "planning": cost, "why": why,
    }  # fmt: skip


def draw(rows: list[dict[str, Any]]) -> None:
    """Errors, and times beside the bound that the gaits' speeds set."""
    place, turn, legs, bound = (
        np.array([row[key] for row in rows]) for key in ("place", "turn", "legs", "bound")
    )
    figure = new_figure(9.0, 3.2)
    axes = figure.subplots(1, 3)
    for ax, values, label, most in (
        (axes[0], 1e3 * place, "final place, off by [mm]", 1.0),
        (axes[1], np.rad2deg(turn), "final yaw, off by [deg]", 0.2),
    ):
        ax.hist(np.log10(np.maximum(values, 1e-7)), bins=20, color=PALE)
        ax.axvline(np.log10(most), **line(1))
        tidy(ax, label, "goals" if ax is axes[0] else "")
        ax.xaxis.set_major_formatter(lambda x, _: f"$10^{{{x:g}}}$")
    top = 1.05 * legs.max()
    axes[2].plot(bound, legs, "o", color=COLOURS[0], markersize=3)
    axes[2].plot((0, top), (0, top), **line(1))
    tidy(axes[2], "least time by the speed limits [s]", "legs move for [s]")
    axes[2].set(xlim=(0, 1.05 * bound.max()), ylim=(0, top))
    write_figure(figure, Path("docs/images/steering.png"))


def main(n: int) -> None:
    model = rr.FullModel(rr.Robot.from_parameters())
    rr.plan(model, (0.1, 0.1, 0.1))  # maps and compiled code
    # What was done before goes on; remove the file to begin anew.
    rows = json.loads(OUT.read_text())["rows"] if OUT.exists() else []
    for goal in goals(n)[len(rows) :]:
        rows.append(trial(model, goal))
        OUT.write_text(json.dumps({"met": _met(rows), "rows": rows}, indent=1))
    place, turn, legs, bound, cost = (
        np.array([row[key] for row in rows])
        for key in ("place", "turn", "legs", "bound", "planning")
    )
    print(f"{_met(rows)} of {len(rows)} within 1 mm and 0.2 deg on the exact model (KKT)")
    print(f"worst {1e3 * place.max():.3f} mm, {np.rad2deg(turn.max()):.4f} deg")
    print(f"planning {np.median(cost):.2f} s median, {cost.max():.2f} s worst, one core")
    print(f"legs move {np.median(legs):.1f} s median; over the bound {np.median(legs / bound):.2f}")
    draw(rows)


def _met(rows: list[dict[str, Any]]) -> int:
    return int(sum(r["place"] < 1e-3 and r["turn"] < np.deg2rad(0.2) for r in rows))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
