"""`rrrobot unstick`: how a robot that lies on its belly can move, from URDF to report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rrrobot.cli.compile import tell_of_compiling
from rrrobot.cli.options.robot import GROUNDS, GroundChoice, GroundType
from rrrobot.cli.report import tell
from rrrobot.cli.types import NUMBER, names
from rrrobot.contact.boulder import depth_of_floor
from rrrobot.contact.surfaces import Sphere
from rrrobot.errors import ParameterError
from rrrobot.inline import aligned
from rrrobot.robot.legged import legged_urdf
from rrrobot.robot.robot import Robot

if TYPE_CHECKING:
    from rrrobot.escape.unstuck import Unstuck

_LEGGED = "legged"
_FORMS = ("auto", "sphere", "ellipsoid", "box", "flat")


@click.command("unstick")
@click.argument("robot", metavar="ROBOT_OR_URDF")
@click.option(
    "--ground",
    type=GroundType(),
    default="level",
    show_default=True,
    metavar="|".join(kind.form for kind in GROUNDS.values()),
    help="Where it lies. A slope rises along x; on a boulder the robot starts on its top; a grid "
    "is a .csv file of heights [m], y in its first row and x in its first column.",
)
@click.option(
    "--goal",
    "goals",
    multiple=True,
    metavar="GOAL",
    help="forward, backward, left, right, 'turn left', 'turn right', direction:DEGREES (from "
    "ahead, to the left), off:DEGREES (off a rock); once for each. forward, left and both turns "
    "unless given, off to four sides on a boulder.",
)
@click.option(
    "--package-dirs", multiple=True, metavar="FOLDER",
    help="Where the meshes of a URDF lie, beside its own folder; once for each.",
)  # fmt: skip
@click.option("--out", metavar="FOLDER", help="Report, films and gaits here; goes on from there.")
@click.option("--no-films", is_flag=True, help="Write no films.")
@click.option("--belly", "form", type=click.Choice(_FORMS), default="auto", show_default=True)
@click.option(
    "--tilt",
    type=NUMBER,
    help="To which the belly is fitted and may roll [rad]; 0.26 unless given.",
)
@click.option(
    "--floor", type=NUMBER, help="Of a rock: its top over the floor [m]; its radius unless given."
)
@click.option("--joints", metavar="NAMES", help="That move, as J1,J2,...; all unless given.")
@click.option("--group", "groups", multiple=True, metavar="GROUP",
              help="Ways in which limbs move together: all, alike, mirrored, opposite, front-back, "
              "diagonal, 'one leg'; once for each, every one unless given.")  # fmt: skip
@click.option("--friction", type=NUMBER, help="Coefficient that the ground offers; 0.5.")
@click.option(
    "--clearance", type=NUMBER, help="Least distance of limbs from the ground [m]; 0.005."
)
@click.option(
    "--damping-ratio", type=NUMBER, default="0.1", show_default=True,
    help="Of the rocking: what rolling costs. An assumption, named in the report.",
)  # fmt: skip
@click.option("--harmonics", type=int, default=1, show_default=True, help="Of the gaits.")
@click.option("--postures", type=int, default=6, show_default=True, help="To search about.")
@click.option("--solutions", type=int, default=1, show_default=True, help="Unlike gaits a goal.")
@click.option(
    "--budget", type=int, default=12000, show_default=True, help="Gaits to simulate a goal."
)
@click.option("--json", "as_json", is_flag=True, help="As JSON, SI units.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
def unstick_command(
    robot: str,
    ground: GroundChoice,
    goals: tuple[str, ...],
    package_dirs: tuple[str, ...],
    out: str | None,
    no_films: bool,
    form: str,
    tilt: float | None,
    floor: float | None,
    joints: str | None,
    groups: tuple[str, ...],
    friction: float | None,
    clearance: float | None,
    damping_ratio: float,
    harmonics: int,
    postures: int,
    solutions: int,
    budget: int,
    as_json: bool,
    quiet: bool,
) -> None:
    """Get a robot free that lies on its belly.

    ROBOT_OR_URDF is a name of 'rrrobot robots', legged:N or legged:NxJ (N generated legs of J
    joints), or the path of a URDF. The belly is fitted, the best gaits are searched for each goal,
    and confirmed with forces and distances. With --out, a run that was stopped goes on.

    If a goal is out of reach, the reason is printed and the exit code is 1.

    \b
    Examples:
      rrrobot unstick solo12 --out free
      rrrobot unstick go2 --goal forward --goal 'turn left' --friction 0.4
      rrrobot unstick my_robot.urdf --ground boulder:0.4
    """
    from rrrobot.belly.fit import fit_belly
    from rrrobot.escape.limits import EscapeLimits
    from rrrobot.escape.spaces import GROUPS
    from rrrobot.escape.story import unstick

    given: dict[str, Any] = {"friction": friction, "clearance": clearance}
    limits = EscapeLimits(**{key: value for key, value in given.items() if value is not None})
    place = GROUNDS[ground.kind].make(ground.numbers, None)
    floor = depth_of_floor(place, floor)
    fit: dict[str, Any] = {"form": form, "ground": place, "floor": floor}
    if tilt is not None:
        fit["tilt"] = tilt
    tell_of_compiling(quiet=quiet, loads=True)
    found = unstick(
        fit_belly(robot_of(robot, package_dirs), **fit), goals=goals or None, joints=names(joints),
        groups=groups or GROUPS, limits=limits, damping_ratio=damping_ratio, harmonics=harmonics,
        postures=postures, solutions=solutions, budget=budget, floor=floor, folder=out,
        progress=False if quiet else None,
    )  # fmt: skip
    files: list[Path] = []
    if out is not None:
        files = found.save(out, films=not no_films)
    tell(found.to_dict(), _table(found), files, as_json=as_json)
    if not found.met:
        told = [f"{name}: {why}" for name, why in found.reasons.items()]
        raise click.ClickException(" ".join(told))


def robot_of(name: str, package_dirs: tuple[str, ...] = ()) -> Any:
    """What `fit_belly` takes for a name on the command line.

    Raises:
        ParameterError: legged: with no whole numbers.
        UrdfError: package_dirs and no URDF.
    """
    if package_dirs:
        return Robot.from_urdf(Path(name), shell=Sphere(1.0), package_dirs=package_dirs)
    if name == "rrrobot":
        return Robot.from_parameters()
    kind, colon, text = name.partition(":")
    if kind != _LEGGED or not colon:
        return name
    try:
        legs, _, each = text.partition("x")
        numbers = int(legs), int(each or "3")
    except ValueError:
        raise ParameterError(
            f"robot is {name!r}: write legged:N or legged:NxJ, such as legged:6 or legged:6x2."
        ) from None
    return legged_urdf(numbers[0], n_joints=numbers[1])


def _table(found: Unstuck) -> str:
    from rrrobot.escape.way_rows import gait_rows, off_rows

    rows = [("belly", repr(found.belly))]
    for mode in found.belly.modes:
        if mode.period < 1e3:
            rows.append((f"mode: {mode.axis}", f"{mode.period:.3f} s"))
    if found.unlimited:
        rows.append(("no effort limit", ", ".join(found.unlimited)))
    for goal in found.goals:
        if goal.name in found.off:
            rows += [("", ""), (goal.name, ""), *off_rows(found.off[goal.name]).items()]
        if goal.name in found.found:
            for gait in found.found[goal.name]:
                rows.append(("", ""))
                rows += list(gait_rows(gait).items())
    return aligned(rows)
