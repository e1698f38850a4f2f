"""`python -m benchmarks.report`: docs/benchmarks.md and the README's table from the results.

Every measured number comes from benchmarks/results/*.json.
"""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

from benchmarks.common import RESULTS, ROOT
from benchmarks.grounds import grounds_page
from benchmarks.machines import machines_page
from benchmarks.report_peers import peers_page
from benchmarks.report_readme import readme_block, replaced
from benchmarks.report_simulators import simulators_page
from benchmarks.tables import Record, machine, number, prose, seconds, table

PAGE, README = ROOT / "docs" / "benchmarks.md", ROOT / "README.md"
FILES = ("engine", "grounds", "peers", "simulators", "machines")
HEAD = """\
# Benchmarks

Times are medians of one run, of code that is compiled and warm unless it says otherwise. What was
to be shown of the engine, and what was measured; a click on a line below opens the details.
"""
AGAIN = """\
Written by `python -m benchmarks.report` from `benchmarks/results/*.json`. To measure anew (extra
`bench`; it took {minutes:.0f} minutes):

```sh
pip install -e '.[dev,bench]'
python -m benchmarks.engine
python -m benchmarks.grounds
python -m benchmarks.peers
python -m benchmarks.simulators
python -m benchmarks.machines
python -m benchmarks.report
```
"""


def targets(e: Record) -> list[tuple[str, str, str, bool]]:
    """What was to be shown, the target, what was measured, whether that meets it."""
    grid, threads, accuracy = e["grid"], e["threads"], e["accuracy"]
    million, cold = e["million"], e["cold_start"]
    empty, full = cold["empty_cache"], cold["full_cache"]
    per_gait = [r["core_per_gait"] for r in e["linearity"]]
    march = [r["march_per_cycle"] for r in e["legs"]]
    sizes = f"{e['linearity'][0]['gaits']} to {e['linearity'][-1]['gaits']} gaits"
    legs = f"{e['legs'][0]['legs']} to {e['legs'][-1]['legs']} legs"
    sweep = f"{grid['gaits']} gaits of {grid['cycles']} cycles on one core"
    return [
        (f"{sweep}, wall", "≤ 0.25 s", seconds(grid["wall"]), grid["wall"] <= 0.25),
        (f"{sweep}, processor time", "≤ 0.25 s", seconds(grid["core"]), grid["core"] <= 0.25),
        (f"worst relative error of v against KKT, {accuracy['points']} random gaits", "≤ 1e-6",
         number(accuracy["speed_worst"], 2), accuracy["speed_worst"] <= 1e-6),
        (f"processor time per gait, {sizes}: highest over lowest", "1 (linear)",
         number(max(per_gait) / min(per_gait)), max(per_gait) / min(per_gait) < 1.2),
        (f"march of a cycle, {legs}: highest over lowest", "1 (independent)",
         number(max(march) / min(march)), max(march) / min(march) < 1.2),
        ("two threads over one, wall", "≥ 1.7 times", f"{number(threads['speed_up_median'])} times"
         f" (best of {threads['repeats']}: {number(threads['speed_up_best'])})",
         threads["speed_up_median"] >= 1.7),
        (f"{million['gaits']} gaits of {number(million['seconds_each'])} s on "
         f"{million['threads']} threads, wall", "< 3 min",
         f"{seconds(million['wall'])} ({seconds(million['core'])} of processor time)",
         million["wall"] < 180),
        ("resident memory of that process", "< 1 GB", f"{number(million['resident_mb'])} MB",
         million["resident_mb"] < 1000),
        ("new process, empty cache: first sweep", "≤ 15 s",
         f"{seconds(empty['first_sweep'])} (whole process {seconds(empty['process'])})",
         empty["first_sweep"] <= 15),
        ("new process, full cache: first sweep", "≤ 1.5 s",
         f"{seconds(full['first_sweep'])} (whole process {seconds(full['process'])})",
         full["first_sweep"] <= 1.5),
    ]  # fmt: skip


def targets_table(record: Record) -> str:
    """The engine's targets, and whether they are met."""
    found = targets(record["results"])
    rows = ((what, goal, got, "yes" if met else "**no**") for what, goal, got, met in found)
    return table(("what", "target", "measured", "met"), rows)


def engine_page(record: Record) -> str:
    """The engine's own measurements."""
    e = record["results"]
    legs = ((str(r["legs"]), seconds(r["table"]), seconds(r["march_per_cycle"])) for r in e["legs"])
    steps = (
        (str(r["steps"]), seconds(r["core"]), number(r["speed_median"], 2),
         number(r["speed_worst"], 2))
        for r in e["convergence"]
    )  # fmt: skip
    parts = [
        "## The engine\n",
        prose(f"""RRRobot of Table 2, full model, damping of 0.01 N m s/rad on each Euler rate; legs
            at offsets 0..π by phase differences 0..2π, A = 0.3 rad, 8 rad/s; 38 cycles (29.85 s)
            from an impulsive start, means over the last 19. {machine(record)}"""),
        prose("""A gait's cost is its table of leg coefficients, which grows with the legs, and the
            march through it, which does not. Processor time on random robots with full inertias,
            revolute and prismatic joints:"""),
        table(("legs", "table, each gait", "march, each gait and cycle"), legs),
        prose("""The step: 20 by 20 gaits on one thread, errors against 80 steps in a cycle where v
            exceeds 0.2 mm/s:"""),
        table(("steps in a cycle", "processor time", "error of v, median", "worst"), steps),
    ]
    return "\n".join(parts)


def folded(text: str) -> str:
    """A section that a click opens: its heading is what is seen, those in it are bold lines."""
    heading, rest = text.split("\n", 1)
    inside = re.sub(r"^#+ (.*)$", r"**\1**", rest.strip("\n"), flags=re.M)
    title = heading.lstrip("# ")
    return f"<details>\n<summary>{title}</summary>\n\n{inside}\n\n</details>\n"


def page(folder: Path) -> str:
    """The whole page from the folder's files."""
    records = {name: json.loads((folder / f"{name}.json").read_text()) for name in FILES}
    minutes = sum(float(record["machine"]["minutes"]) for record in records.values())
    parts = (
        engine_page(records["engine"]),
        grounds_page(records["grounds"]),
        peers_page(records["peers"]),
        simulators_page(records["simulators"]),
        machines_page(records["machines"]),
        f"## Measured anew\n\n{AGAIN.format(minutes=minutes)}",
    )
    return "\n".join((HEAD, targets_table(records["engine"]), *map(folded, parts)))


def readme(folder: Path, path: Path) -> str:
    """The README with its table from the folder's files."""
    record = json.loads((folder / "simulators.json").read_text())
    return replaced(path.read_text(), readme_block(record))


def main() -> None:
    """Write docs/benchmarks.md and the README's table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=Path, default=RESULTS, help="folder of the JSON files")
    parser.add_argument("--page", type=Path, default=PAGE)
    parser.add_argument("--readme", type=Path, default=README)
    arguments = parser.parse_args()
    arguments.page.write_text(page(arguments.results))
    arguments.readme.write_text(readme(arguments.results, arguments.readme))


if __name__ == "__main__":
    main()
