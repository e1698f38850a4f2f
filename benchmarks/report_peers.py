"""The part of docs/benchmarks.md that compares rrrobot with other software."""

from __future__ import annotations

import numpy as np

from benchmarks.common import STEPS
from benchmarks.tables import Record, error, machine, number, prose, seconds, share, table

WANTED = 100
"""How many times faster than the best peer the engine is meant to be."""
CORE = "processor time"


def peers_page(record: Record) -> str:
    """The whole part."""
    p = record["results"]
    lines, sweep = p["lines"], p["sweep"]
    gaits, rows = sweep["rows"] ** 2, sweep["rows"]
    parts = [
        "## Peers side by side\n",
        prose(f"""The same robot and {gaits} gaits, {rows} offsets 0..π by {rows} phase differences
            0..2π, {sweep["cycles"]} cycles each, by three kinds of software. {machine(record)}"""),
        comparison(lines, p["ratios"], gaits),
        *(verdict(peer, lines, p["ratios"]) for peer in ("MuJoCo", "SymPy")),
        "".join(notes(lines, sweep, gaits)),
        "### Error for time\n",
        prose(f"One thread, {gaits} gaits; each method at several steps in a cycle:"),
        work(p["work_precision"]),
        equal_error(p["work_precision"]),
        "### What the contact does\n",
        prose("""MuJoCo on the paper's two gaits, over the true values, and the energy that a free
            rocking loses in 30 s: no damping, legs straight up, let go at 0.3 rad, energy from the
            amplitude of the last swing. (rrrobot's is from its energy.)"""),
        contact(p["contact"]),
        "### The true answer\n",
        prose("""The engine with 40 steps in a cycle, and three ways to doubt it: 80 steps, the KKT
            system on Pinocchio's dynamics (tolerances 1e-12), and the tests' derivation by hand
            from five point masses (`tests/derivations.py`), which shares no code with the
            library."""),
        truth(p["true_answer"]),
    ]
    return "\n".join(parts)


def comparison(lines: list[Record], ratios: Record, gaits: int) -> str:
    """Time and errors of every line."""
    rows = []
    for r in lines:
        scale = gaits / r["gaits"]
        faster = "" if r["peer"] == "rrrobot" else number(ratios[key_of(r)]["core"])
        ran = "" if r["gaits"] == gaits else f" ({r['gaits']} gaits run)"
        rows.append(
            (f"{r['peer']}: {r['name']}{ran}", r["damping"], str(r["threads"]),
             seconds(scale * r["wall"]), seconds(scale * r["core"]), faster,
             error(r["speed_median"]), error(r["speed_worst"]), error(r["yaw_rate_median"]),
             error(r["yaw_rate_worst"]))
        )  # fmt: skip
    return table(
        ("", "damping of", "threads", "wall", CORE, f"our {CORE}: times less", "v, median",
         "v, worst", "yaw rate, median", "worst"),
        rows,
    )  # fmt: skip


def key_of(line: Record) -> str:
    """A line's key in the ratios."""
    return f"{line['peer']}, {line['name']}, {line['damping']}"


def verdict(peer: str, lines: list[Record], ratios: Record) -> str:
    """A peer's fastest and most accurate lines against the target, in words."""
    ours = next(r for r in lines if r["peer"] == "rrrobot")
    own = [r for r in lines if r["peer"] == peer and r["damping"] == ours["damping"]]
    best = min(own, key=lambda r: r["core"] / r["gaits"])
    closest = min(own, key=lambda r: r["speed_median"] + r["yaw_rate_median"])
    quick, near = ratios[key_of(best)], ratios[key_of(closest)]
    met = "met" if quick["core"] >= WANTED else "**not met**"
    text = f"""Against the fastest {peer} line ({best["name"]}) the engine needs
        {number(quick["core"])} times less {CORE} (target {WANTED}: {met}; wall clock with our two
        threads {number(quick["wall_two_threads"])} times less), and its median errors are smaller
        {number(quick["speed_error_ratio"], 2)} times in v and
        {number(quick["yaw_rate_error_ratio"], 2)} times in the yaw rate."""
    if closest["name"] != best["name"]:
        text += f""" Against the most accurate line ({closest["name"]}) it needs
            {number(near["core"])} times less {CORE}, with median errors smaller
            {number(near["speed_error_ratio"], 2)} and
            {number(near["yaw_rate_error_ratio"], 2)} times."""
    others = [r for r in own if r is not best]
    if peer == "SymPy" and others:
        as_shown = ratios[key_of(others[0])]
        text += f""" Against the form of SymPy's documentation ({others[0]["name"]}):
            {number(as_shown["core"])} times less {CORE}, {number(as_shown["wall_two_threads"])}
            times less wall clock with our two threads."""
    return prose(text)


def notes(lines: list[Record], sweep: Record, gaits: int) -> list[str]:
    """How each was measured."""
    legs = max(r["leg_error"] for r in lines if "leg_error" in r)
    set_up = " and ".join(f"{number(r['set_up'], 2)} s" for r in lines if "set_up" in r)
    step = next(r["time_step_ms"] for r in lines if "set_up" in r)
    no_slip = settings(lines, "no-slip settings, 1 ms")
    stiff = settings(lines, "no-slip and stiff contact, 1 ms")["contact"]
    stiff = stiff[stiff.index("solref") :]
    return [
        prose(f"""- Errors are relative to the true answer (below), of v where it exceeds
            0.2 mm/s, of the yaw rate where it exceeds 1 mrad/s. Times are for all {gaits} gaits,
            scaled up in proportion where fewer were run, on the processor time of all threads and
            on the wall clock, without compilation. Ours are medians of
            {sweep["engine_repeats"]} sweeps in between the others', MuJoCo's are its median
            cycle times the number of cycles, SymPy's the median of three sweeps."""),
        prose(f"""- **MuJoCo** runs `mujoco.rollout`. Its robot is a massless sphere geom on a plane
            that carries the five point masses; damping is its own joint damping, on slides and yaw,
            pitch, roll hinges for the Euler rates, on a free joint for the body rates. It cannot
            prescribe joints, so each leg joint gets an armature of 1e4 kg m² (which does not react
            on the body) and the torque armature times wanted acceleration; the legs stay within
            {number(legs, 2)} rad of the gait. The start is our impulsive one. "No-slip
            settings" are what its documentation gives against slip:
            `{no_slip["option"]} {no_slip["contact"]}`. "Stiff contact" adds `{stiff}`, the best
            that we found. `condim 4` adds torsional friction, which this robot must not have.
            The default integrator, of first order, has an error of its own at 1 ms; what is
            left with RK4 comes from the compliance of the contact."""),
        prose(f"""- **SymPy**: `KanesMethod`, `lambdify` with common subexpressions, Numba, RK4 at
            {number(step)} ms, one loop over gaits. "Rolling as constraint" is the form of its
            documentation: two dependent speeds, `velocity_constraints`, `numpy.linalg.solve` of
            5 by 5. "Rolling as kinematics" writes the centre's velocity from the angular velocity
            and solves 3 by 3 in closed form, the fastest that we could make of it. Deriving and
            compiling took {set_up}."""),
    ]


def settings(lines: list[Record], name: str) -> Record:
    """MJCF attributes of a case."""
    return dict(next(r["settings"] for r in lines if r["name"] == name))


def work(lines: list[Record]) -> str:
    """Error against time."""
    return table(
        ("method", "steps in a cycle", CORE, "v, median", "v, worst", "yaw rate, median", "worst"),
        (
            (f"{r['peer']}: {r['name']}", str(r["steps"]), seconds(r["core"]),
             error(r["speed_median"]), error(r["speed_worst"]), error(r["yaw_rate_median"]),
             error(r["yaw_rate_worst"]))
            for r in lines
        ),
    )  # fmt: skip


def equal_error(lines: list[Record]) -> str:
    """What the others need for the engine's usual error, in words."""
    ours = next(r for r in lines if r["peer"] == "rrrobot" and r["steps"] == STEPS)
    found = []
    for name in dict.fromkeys(r["name"] for r in lines if r["peer"] != "rrrobot"):
        own = [r for r in lines if r["name"] == name]
        times = [
            np.exp(np.interp(-np.log(ours[key]), [-np.log(r[key]) for r in own],
                             [np.log(r["core"]) for r in own]))
            for key in ("speed_median", "yaw_rate_median")
        ]  # fmt: skip
        found.append(f"{name}: {number(max(times) / ours['core'])} times")
    return prose(f"""Processor time to reach the median errors of the engine at {STEPS} steps in a
        cycle, both of them, over the engine's (interpolated): {"; ".join(found)}.""")


def contact(lines: list[Record]) -> str:
    """Paper's gaits and free rocking."""
    keys = ("lateral_speed_ratio", "circular_speed_ratio", "circular_yaw_rate_ratio")
    return table(
        ("", "lateral: v", "circular: v", "circular: yaw rate", "energy lost in roll", "in pitch"),
        (
            (r["name"], *(f"{r[k]:.4f}" for k in keys),
             *(share(r[f"energy_lost_{axis}"]) for axis in ("roll", "pitch")))
            for r in lines
        ),
    )  # fmt: skip


def truth(lines: list[Record]) -> str:
    """Four ways to the same numbers."""

    def cells(way: str) -> list[str]:
        own = {r["gait"]: r for r in lines if r["way"] == way}
        return [
            text
            for gait in ("lateral", "circular")
            for text in (f"{1e3 * own[gait]['speed']:.9f}", f"{own[gait]['yaw_rate']:.10f}")
        ]

    return table(
        ("", "lateral: v [mm/s]", "yaw rate [rad/s]", "circular: v [mm/s]", "yaw rate [rad/s]"),
        ((way, *cells(way)) for way in dict.fromkeys(r["way"] for r in lines)),
    )
