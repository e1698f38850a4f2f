"""What is taken home: the motion as Python, as files, as a link."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from pathlib import Path

from rrrobot.lab.knobs import BODY, Knobs
from rrrobot.lab.outcome import Outcome
from rrrobot.robot.robot import Robot
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.view.films import film_html

_SAVED = "trajectory.npz"
_FILM = 20.0
"""Of a motion that repeats [s]."""
FILES: dict[str, tuple[str, Callable[[Outcome], bytes]]]


def code(given: Robot, knobs: Knobs) -> str:
    """A script that does what the page shows.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.lab.home import code
        >>> from rrrobot.lab.knobs import Knobs
        >>> robot = rr.Robot.from_parameters()
        >>> print(code(robot, Knobs.of(robot)).splitlines()[0])
        import rrrobot as rr
    """
    if given.parameters is None:
        made = [
            "# The page's trajectory, saved beside this script, has the robot in it.",
            f'robot = rr.Trajectory.load("{_SAVED}").robot',
        ]
    else:
        robot = knobs.robot(given)
        p = robot.parameters
        entries = "".join(
            f"    {name}={getattr(p, name)!r},\n" for name in (*BODY, "hip_offset", "gravity")
        )
        made = [f"robot = rr.Robot.from_parameters(rr.RRRobotParameters(\n{entries}))"]
    losses = "None"
    if knobs.losses() is not None:
        kind = "Body" if knobs.damping_kind == "body" else "Euler"
        losses = f"rr.{kind}RateDamping({', '.join([repr(knobs.damping)] * 3)})"
    n = knobs.ground().normal_vector
    normal = f"({float(n[0])!r}, {float(n[1])!r}, {float(n[2])!r})"
    gait = {key: value for key, value in knobs.gait().to_dict().items() if key != "type"}
    kind = type(knobs.gait()).__name__
    legs = "".join(f"    {key}={value!r},\n" for key, value in gait.items())
    lines = [
        "import rrrobot as rr",
        "",
        *made,
        f"ground = rr.Plane({normal}, gravity={knobs.gravity!r})",
        f"model = rr.FullModel(robot, ground=ground, damping={losses})",
        f"gait = rr.{kind}(\n{legs})",
        "t = rr.simulate(model, gait, duration=30.0)",
        "print(t.steady_state())",
        *(["print(rr.limit_cycle(model, gait))"] if knobs.settles else []),
    ]
    return "\n".join(lines) + "\n"


def shown(outcome: Outcome) -> Trajectory:
    """The motion as one trajectory: a run as it is, twenty seconds of one that repeats."""
    cycle = outcome.cycle
    if cycle is None:
        return outcome.trajectory
    return simulate(
        cycle.model, cycle.gait, _FILM, cycle.period / 36, method="momentum",
        euler=cycle.euler, start=cycle.euler_rates,
    )  # fmt: skip


def _gait(outcome: Outcome) -> bytes:
    return json.dumps(outcome.knobs.gait().to_dict(), indent=2).encode()


def _trajectory(outcome: Outcome) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        return shown(outcome).save(Path(folder, "lab.npz")).read_bytes()


def _film(outcome: Outcome) -> bytes:
    return film_html(shown(outcome))


FILES = {
    "gait (.json)": ("gait.json", _gait),
    "trajectory (.npz)": (_SAVED, _trajectory),
    "film (.html)": ("film.html", _film),
}
"""Label of the button -> name of the file, and what is in it."""
