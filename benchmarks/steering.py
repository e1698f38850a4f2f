"""Random goals: how near exact plans come, how long they take, and what planning costs.

    python -m benchmarks.steering [goals]

Writes benchmarks/results/steering.json and docs/images/steering.png.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np

import rrrobot as rr
from rrrobot.drawing import new_figure, tidy, write_figure
from rrrobot.errors import PlanError


def goals(n: int, radius: float = 0.5) -> np.ndarray:
    """Poses within a disc, any heading (n, 3)."""
    rng = np.random.default_rng(2026)
    r, a = radius * np.sqrt(rng.random(n)), rng.uniform(0, 2 * np.pi, n)
    return np.column_stack((r * np.cos(a), r * np.sin(a), rng.uniform(-np.pi, np.pi, n)))


def main(n: int) -> None:
    model = rr.FullModel(rr.Robot.from_parameters())
    rr.plan(model, (0.1, 0.1, 0.1))  # maps and compiled code
    rows = []
    for goal in goals(n):
        started = time.process_time()
        try:
            plan = rr.plan(model, goal)
        except PlanError as error:
            print("failed:", goal.round(3), error)
            plan = error.nearest
        cost = time.process_time() - started
        run = plan.execute(sample_interval=0.1)  # the KKT form
        place = float(np.hypot(*(run.position[-1] - goal[:2])))
        turn = float(abs((run.euler[-1, 2] - goal[2] + np.pi) % (2 * np.pi) - np.pi))
        rows.append(
            {"goal": goal.tolist(), "place": place, "turn": turn, "legs": plan.gait.duration,
             "bound": plan.lower_bound, "planning": cost}
        )  # fmt: skip
    place, turn, legs, bound, cost = (
        np.array([row[key] for row in rows])
        for key in ("place", "turn", "legs", "bound", "planning")
    )
    met = int(np.sum((place < 1e-3) & (turn < np.deg2rad(0.2))))
    print(f"{met} of {n} within 1 mm and 0.2 deg on the exact model (KKT)")
    print(f"worst {1e3 * place.max():.3f} mm, {np.rad2deg(turn.max()):.4f} deg")
    print(f"planning {np.median(cost):.2f} s median, {cost.max():.2f} s worst, one core")
    print(f"legs move {np.median(legs):.1f} s median; over the bound {np.median(legs / bound):.2f}")
    out = Path("benchmarks/results/steering.json")
    out.write_text(json.dumps({"met": met, "rows": rows}, indent=1))
    figure = new_figure(9.0, 3.0)
    for i, (values, label) in enumerate(
        ((1e3 * place, "final place, off by [mm]"), (np.rad2deg(turn), "final yaw, off by [deg]"),
         (legs, "legs move for [s]"))
    ):  # fmt: skip
        ax = figure.add_subplot(1, 3, i + 1)
        ax.hist(values, bins=20, color="0.5")
        tidy(ax, label, "goals" if i == 0 else "")
    figure.tight_layout()
    write_figure(figure, Path("docs/images/steering.png"))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
