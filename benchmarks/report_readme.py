"""The README's table of rrrobot beside other software, from the same results as the page."""

from __future__ import annotations

from typing import NamedTuple

from benchmarks.report_simulators import pick, worst
from benchmarks.tables import Record, error, prose, seconds, table

BEGIN = "<!-- written by python -m benchmarks.report -->\n"
END = "<!-- end -->\n"


class Offer(NamedTuple):
    """What a piece of software has for a ball that rolls, and what it is made for.

    Attributes:
        rolling: its way to roll without slipping.
        first: beginning of the line of results that its documentation leads to.
        best: beginning of the lines among which the best is shown.
        besides: what else it offers.
    """

    rolling: str
    first: str
    best: str
    besides: str


OFFERS = {
    "rrrobot": Offer(
        "exact constraint, on Pinocchio", "simulate, KKT", "simulate, momentum",
        "gaits, the paper's simplified models, sweeps, optimal gaits, kinematic reduction, films; "
        "no other contacts, no impacts",
    ),
    "Pinocchio": Offer(
        "none: a script of one's own", "no drift", "CONTACT_3D",
        "rigid-body algorithms and their derivatives for any tree",
    ),
    "MuJoCo": Offer(
        "friction", "defaults", "",
        "contacts and impacts of any shapes, actuators, many robots at once",
    ),
    "Drake": Offer(
        "friction", "point contact, defaults", "",
        "contacts of any shapes, optimisation, planning, control",
    ),
    "Exudyn": Offer(
        "friction, or a constraint of one's own", "penalty contact, ball on triangle", "",
        "flexible bodies, joints of many kinds",
    ),
    "Jiminy": Offer(
        "exact constraint, `SphereConstraint`", "SphereConstraint, defaults", "",
        "contacts, motors and sensors of real robots, learning",
    ),
    "SymPy": Offer(
        "exact constraint, equations of one's own", "KanesMethod, rolling as constraint", "",
        "the equations as formulas",
    ),
}  # fmt: skip


def readme_block(record: Record) -> str:
    """The part of the README between BEGIN and END."""
    lines = record["results"]["lines"]
    versions = {line["simulator"]: line["version"] for line in lines}
    bulk = next(x for x in lines if x["model"].startswith("engine, one of"))
    rows = [
        (f"{name} {versions[name]}", offer.rolling, shown(first(lines, name, offer.first)),
         shown(pick(lines, name, offer.best)), offer.besides)
        for name, offer in OFFERS.items()
    ]  # fmt: skip
    cycles = record["results"]["cycles"] * record["results"]["period"]
    text = prose(f"""The paper's lateral and circular gait for {cycles:.0f} s: the largest of three
        relative errors (v of both, yaw rate of the circular one) and the processor time of one
        gait. In bulk the momentum engine takes {seconds(bulk["core"])} a gait, at an error of
        {error(worst(bulk))}. Measured {record["machine"]["date"]} on one machine;
        [docs/benchmarks.md](docs/benchmarks.md) has settings, steps and more lines.""")
    head = ("", "a ball that rolls", "first try", "best that we found", "besides")
    return f"{BEGIN}\n{text}\n{table(head, rows)}\n{END}"


def first(lines: list[Record], simulator: str, model: str) -> Record:
    """The first line of a simulator whose model begins so."""
    return next(x for x in lines if x["simulator"] == simulator and x["model"].startswith(model))


def shown(line: Record) -> str:
    """Error and time."""
    step = line["time_step_ms"]
    at = "" if step is None else f", step {step:.2g} ms"
    return f"{error(worst(line))} in {seconds(line['core'])}{at}"


def replaced(text: str, block: str) -> str:
    """A text with the part from BEGIN to END exchanged."""
    before, rest = text.split(BEGIN)
    return before + block + rest.split(END)[1]
