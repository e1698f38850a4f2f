"""The part of docs/benchmarks.md on other simulators and the paper's two gaits."""

from __future__ import annotations

from benchmarks.tables import Record, error, machine, number, prose, seconds, table

SUNK = 0.01
"""Heights that stray more than this are told [m]."""


def simulators_page(record: Record) -> str:
    """The whole part."""
    r = record["results"]
    lines, seconds_each = r["lines"], r["cycles"] * r["period"]
    parts = [
        "## Other simulators\n",
        prose(f"""The paper's two gaits, lateral (offset π/2) and circular (offset π/4), by whatever
            each simulator has for a ball that rolls without slipping: first what it does without
            being asked, then the best that we found. The robot, the damping of 0.01 N m s/rad on
            the Euler rates, the impulsive start and the means over the last {r["counted"]} of
            {r["cycles"]} cycles are the same for all. {machine(record)}"""),
        results(lines),
        prose(f"""Errors are relative and signed, against the KKT system with tolerances of 1e-12:
            v {number(1e3 * r["true_answer"]["speed"][0], 6)} mm/s in the lateral gait,
            {number(1e3 * r["true_answer"]["speed"][1], 6)} mm/s in the circular one, which turns
            by {number(r["true_answer"]["yaw_rate"][1], 6)} rad/s; the lateral gait does not turn.
            Times are processor time for {number(seconds_each, 4)} s of one gait, mean of both,
            without the building of the model and without compilation. To measure anew:
            `python -m benchmarks.simulators`, which puts Drake, Exudyn and Jiminy into
            environments of their own in `.venv-peers/`."""),
        "### What each says of rolling\n",
        prose("After a setting's name: the largest of its three errors, and the time."),
        "".join(prose(f"- {text}") for text in said(lines)),
        "### How each was set\n",
        "".join(prose(f"- {text}") for text in settings(lines)),
    ]
    return "\n".join(parts)


def signed(x: float) -> str:
    """A relative error with its sign, with a digit more where it is large."""
    text = f"{number(100 * abs(x))} %" if abs(x) > 0.1 else error(abs(x))
    return f"{'+' if x > 0 else '-'}{text}"


def results(lines: list[Record]) -> str:
    """One line a case."""
    rows = []
    for line in lines:
        step = line["time_step_ms"]
        rows.append(
            (f"{line['simulator']} {line['version']}", line["model"] + sunk(line),
             "varies" if step is None else f"{number(step)} ms", seconds(line["core"]),
             *map(signed, line["speed_error"]), signed(line["circular_yaw_rate_error"]))
        )  # fmt: skip
    return table(
        ("simulator", "contact or rolling", "step", "time for 30 s", "v, lateral", "v, circular",
         "yaw rate, circular"),
        rows,
    )  # fmt: skip


def sunk(line: Record) -> str:
    """What is to be told of the centre's height, if anything."""
    low = line["radius"] - line["height"][0] if "height" in line else 0.0
    return f"; sinks by {number(low, 2)} m" if low > SUNK else ""


def pick(lines: list[Record], simulator: str, model: str = "") -> Record:
    """The most accurate line of a simulator whose model begins so."""
    own = (x for x in lines if x["simulator"] == simulator and x["model"].startswith(model))
    return min(own, key=worst)


def worst(line: Record) -> float:
    """Largest of a line's three errors."""
    return float(max(*map(abs, line["speed_error"]), abs(line["circular_yaw_rate_error"])))


def best(line: Record) -> str:
    """A line in words."""
    step = "" if line["time_step_ms"] is None else f" at {number(line['time_step_ms'])} ms"
    return f"{line['model']}{step}: {error(worst(line))} in {seconds(line['core'])}"


def said(lines: list[Record]) -> list[str]:
    """What the simulators can and cannot say, the worst of three errors in numbers."""
    hydro = [line for line in lines if line["model"].startswith("hydroelastic")]
    stuck = pick(lines, "Jiminy", "ball on ground, defaults")
    plain = next(x for x in lines if x["model"] == "SphereConstraint, defaults")
    pinocchio = [x for x in lines if x["simulator"] == "Pinocchio"]
    free = next(x for x in pinocchio if x["model"] == "CONTACT_3D below the centre")
    wrong = [x for x in pinocchio if x["model"].startswith("no drift")]
    slow = [f"{number(-100 * x['circular_yaw_rate_error'])} %" for x in wrong]
    steps = [f"{number(x['time_step_ms'], 2)} ms" for x in wrong]
    still = [f"{number(-100 * x['speed_error'][1], 3)} %" for x in hydro]
    return [
        f"""**Pinocchio** has no rolling constraint. `CONTACT_3D` holds a point of the body; put
        below the centre before each step, it leaves out that the contact moves over the body, so
        the ball sinks ({number(free["radius"] - free["height"][0], 2)} m) unless a Baumgarte
        correction holds it up, at the price of an error that the correction's frequency sets. Best:
        {best(pick(lines, "Pinocchio", "CONTACT"))}. With the rows of rolling but no drift, and the
        centre's velocity overwritten after each step, the circular gait turns {" and ".join(slow)}
        too slowly at {" and ".join(steps)}: a smaller step does not help. rrrobot's KKT system is
        Pinocchio's dynamics with the right drift.""",
        f"""**MuJoCo** has friction, not rolling. Best: {best(pick(lines, "MuJoCo"))}; with its
        defaults the circular gait turns
        {number(-100 * pick(lines, "MuJoCo", "defaults")["circular_yaw_rate_error"], 2)} % too
        slowly. What contact does to energy is told above.""",
        f"""**Drake** has friction, not rolling. Its point contact is good without tuning
        ({best(pick(lines, "Drake", "point contact, defaults"))}); its error falls with the
        first order of the step. Best: {best(pick(lines, "Drake"))}. In its hydroelastic contact the
        ball is a polyhedron that touches over a patch: the circular gait travels
        {" and ".join(still)} too slowly.""",
        f"""**Exudyn** has a rolling disc, not a ball. Written by the user as a velocity constraint
        of its kinematic tree, rolling converges to the truth with second order:
        {best(pick(lines, "Exudyn", "rolling"))}. Its penalty contact of a ball is the most accurate
        contact here: {best(pick(lines, "Exudyn", "penalty"))}.""",
        f"""**Jiminy** has the constraint itself, `SphereConstraint`, and is right with it:
        {best(pick(lines, "Jiminy"))}. Without Baumgarte correction, which is its default, the
        regularised constraint lets the ball sink ({number(plain["radius"] - plain["height"][0], 2)}
        m); RK4's error falls with second order. A ball that is given as a collision body is another
        matter: the default contact holds the ball's frame where it touched, so it does not travel
        ({signed(stuck["speed_error"][1])} in v).""",
        f"""**SymPy** derives the equations, the user writes the rest; compiled, they are right and
        fast for one gait at a time: {best(pick(lines, "SymPy"))}. Deriving and compiling is not
        counted.""",
        f"""**rrrobot**: {best(pick(lines, "rrrobot", "simulate, KKT"))};
        {best(pick(lines, "rrrobot", "simulate, momentum"))}, both with whole trajectories;
        {best(next(x for x in lines if x["model"] == "engine, one gait"))}, speed and yaw rate
        only.""",
    ]


def settings(lines: list[Record]) -> list[str]:
    """How legs, damping and contact were set."""
    legs = {
        name: number(max(x["leg_error"] for x in lines if x["simulator"] == name), 1)
        for name in ("Drake", "Exudyn", "Jiminy", "Pinocchio")
    }
    cenic = next(x for x in lines if "accuracy 1e-7" in x["model"])
    fixed = max(
        x["leg_error"] for x in lines if x["simulator"] == "Drake" and "accuracy" not in x["model"]
    )
    return [
        f"""Drake: base of slides and hinges with joint damping; legs by a rotor inertia of
        1e7 kg m² (within {number(fixed, 1)} rad of the gait at the end; where CENIC chooses its
        steps also by feedback, {number(cenic["leg_error"], 1)} rad); friction 10. "Defaults" are
        those of `MultibodyPlantConfig` (lagged approximation; the step is ours). SAP, TAMSI and
        CENIC: point stiffness 1e6 N/m. CENIC: stiction tolerance 1e-5 m/s, fixed steps unless an
        accuracy is given. Continuous: stiffness 1e5 N/m, Hunt-Crossley dissipation 1000 s/m,
        stiction tolerance 3e-4 m/s. Hydroelastic: rigid ball on a compliant half space of
        1e7 Pa.""",
        f"""Exudyn: `ObjectKinematicTree` of eight coordinates with damping on three; legs by
        `CoordinateConstraint` (within {legs["Exudyn"]} rad); `TrapezoidalIndex2`. Penalty:
        `ObjectContactSphereTriangle`, stiffness 1e5 N/m (stiff: 1e6), damping 300 N s/m, friction
        10, proportional below 1 mm/s (stiff: 0.1 mm/s). The user functions are in Python.""",
        f"""Jiminy: free flyer; legs by `JointConstraint` whose reference is moved in continuous
        time (within {legs["Jiminy"]} rad); damping as internal dynamics; both in Python.
        Baumgarte 20 Hz unless it says defaults; with RK4 and with the tolerance
        of 1e-11 a regularisation of 1e-12 instead of 1e-3. "Steep friction": coefficient 10,
        transition velocity 1e-4 m/s.""",
        f"""Pinocchio: symplectic Euler in Python; legs by an armature of 1e7 kg m² or by a row of
        their own (within {legs["Pinocchio"]} rad); damping as a generalised force.""",
        """MuJoCo and SymPy: as above, on one thread; "stiffer" has `solref='0.0005 1'`. rrrobot:
        `simulate` with its defaults, warm, and the engine with 10 steps in a cycle.""",
    ]
