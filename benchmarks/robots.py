"""Every robot that `rrrobot unstick` is tried on: its belly and its best gaits, measured.

    python -m benchmarks.robots [NAME ...]

writes benchmarks/results/robots.json, robot by robot, and from it the table of docs/robots.md.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import rrrobot as rr
from rrrobot.cli.robots import GENERATED
from rrrobot.cli.unstick import robot_of
from rrrobot.errors import RRRobotError
from rrrobot.files import write_whole
from rrrobot.robot.examples import UNSTICK

HERE = Path(__file__).parent
RESULTS = HERE / "results" / "robots.json"
PAGE = HERE.parent / "docs" / "robots.md"
GOALS = ("forward", "turn left")
BUDGET, POSTURES = 12000, 6
BEGIN, END = "<!-- robots -->", "<!-- end -->"


def measure(name: str) -> dict[str, Any]:
    """A robot's belly and its gaits for every goal, with the processor time of each."""
    start = time.process_time()
    try:
        belly = rr.fit_belly(robot_of(name))
    except RRRobotError as error:
        return {"reason": str(error)}
    out: dict[str, Any] = {
        "mass": belly.robot.mass,
        "joints": belly.robot.n_legs,
        "belly": f"{belly.kind}, {belly.form}",
        "thickness": belly.thickness,
        "margin": belly.margin.tolist(),
        "modes": [2 * np.pi / mode.period for mode in belly.modes if mode.period < 100],
        "fit_seconds": time.process_time() - start,
        "budget": BUDGET,
        "goals": {},
    }
    start = time.process_time()
    found = rr.unstick(belly, goals=GOALS, budget=BUDGET, postures=POSTURES)
    out["seconds"] = time.process_time() - start
    for goal in found.goals:
        entry: dict[str, Any] = {"reason": found.reasons.get(goal.name, "")}
        if goal.name in found.found:
            best = found.best(goal.name)
            entry |= {"value": best.value, "met": best.met, "discrepancy": best.discrepancy}
            entry |= dict(best.measured)
            share = best.torque_share[np.isfinite(best.torque_share)]
            entry["torque_share"] = float(share.max()) if share.size else None
        out["goals"][goal.name] = entry
    return out


def table(results: dict[str, Any]) -> str:
    """The table of the page, in Markdown."""
    lines = [
        "| robot | joints | mass [kg] | belly | dome [mm] | forward [mm/s] | turn [deg/s] | "
        "friction | torque of limit | clearance [mm] | KKT and engine | gaits a goal | "
        "search [s] |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    order = [*UNSTICK, *GENERATED]
    for name in sorted(results, key=order.index):
        row = results[name]
        if "goals" not in row:
            lines.append(f"| {name} | | | {row['reason']} | | | | | | | | | |")
            continue
        ahead, turn = (row["goals"].get(goal, {}) for goal in GOALS)
        both = [entry for entry in (ahead, turn) if entry.get("met")]
        share = [entry["torque_share"] for entry in both if entry["torque_share"] is not None]
        cells = [
            name, str(row["joints"]), f"{row['mass']:.1f}", row["belly"],
            f"{1000 * row['thickness']:.0f}", _value(ahead, 1000.0),
            _value(turn, float(np.rad2deg(1.0))),
            f"{max(e['friction'] for e in both):.2f}" if both else "",
            f"{100 * max(share):.0f} %" if share else "no limit" if both else "",
            f"{1000 * min(e['clearance'] for e in both):.0f}" if both else "",
            f"{max(e['discrepancy'] for e in both):.0e}" if both else "",
            str(row["budget"]), f"{row['seconds']:.0f}" if both else "",
        ]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _value(entry: dict[str, Any], scale: float) -> str:
    return f"{scale * entry['value']:.1f}" if entry.get("met") else "none feasible"


def reasons(results: dict[str, Any]) -> str:
    """Why there is no gait, where there is none."""
    lines = []
    for name, row in results.items():
        whys: dict[str, list[str]] = {}
        for goal, entry in row.get("goals", {}).items():
            if not entry.get("met"):
                whys.setdefault(entry["reason"], []).append(goal)
        lines += [f"- {name}, {' and '.join(goals)}: {why}" for why, goals in whys.items()]
    return "\n".join(lines) or "- every goal of every robot above has a feasible gait."


def write_page(results: dict[str, Any]) -> None:
    """Put the table and the reasons between the marks of the page."""
    before, _, rest = PAGE.read_text().partition(BEGIN)
    after = rest.partition(END)[2]
    made = f"{table(results)}\n\nWhere there is none, and why:\n\n{reasons(results)}"
    write_whole(PAGE, f"{before}{BEGIN}\n{made}\n{END}{after}".encode())


def main(names: list[str]) -> None:
    """Measure robots and write what came out."""
    warnings.simplefilter("ignore")
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    for name in names:
        results[name] = measure(name)
        print(name, results[name], flush=True)
        text = json.dumps(results, indent=1) + "\n"
        write_whole(RESULTS, text.encode())
    write_page(results)


if __name__ == "__main__":
    main(sys.argv[1:] or [*UNSTICK, *GENERATED])
