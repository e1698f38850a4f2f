"""What the options stand for: robot, gait or torques, damping, integrator; and the progress bar."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import click

from rrrobot.checks import finite
from rrrobot.cli.options import GAITS
from rrrobot.cli.types import names
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.surfaces import Sphere
from rrrobot.drive.damping import BodyRateDamping, DampingLike, EulerRateDamping
from rrrobot.drive.gaits import Gait, RampIn, SinusoidalGait, StillLegs
from rrrobot.drive.gaits import gait as named_gait
from rrrobot.drive.torques import LegTorques
from rrrobot.integrate import Progress
from rrrobot.models.base import OWN, Model
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.robot import Robot

Options = dict[str, Any]

M = TypeVar("M", bound=Model)

MODELS: dict[str, type[Model]] = {
    "full": FullModel,
    "pivoting": PivotingModel,
    "roll": RollModel,
    "pitch": PitchModel,
    "yaw": YawModel,
}
DECOUPLED = "decoupled"
"""Not one model but three, recombined: `rrrobot.simulation.recombined`."""
_DEFAULT_ROBOT = "rrrobot"
_TABLE_2 = (
    "leg_mass",
    "servo_mass",
    "battery_mass",
    "leg_length",
    "hip_offset",
)


def build_robot(options: Options) -> Robot:
    """The robot of `robot_options`.

    Raises:
        click.UsageError: options that do not go together.
        RRRobotError: as `Robot` raises.
    """
    common: Options = {}
    radius = options["shell_radius"]
    urdf, name = options["urdf"], options["robot"]
    if urdf is not None and name is not None:
        raise click.UsageError("give --urdf or --robot, not both.")
    if _is_rrrobot(options):
        _refuse(options, ("shell_center", "shell_link", "legs"), "need --urdf or --robot")
        values = {key: options[key] for key in _TABLE_2 if _given(options, key)}
        if radius is not None:
            values["shell_radius"] = radius
        if _given(options, "gravity"):
            values["gravity"] = options["gravity"]
        return Robot.from_parameters(RRRobotParameters(**values))
    _refuse(options, _TABLE_2, "are RRRobot's: the URDF says the masses and lengths")
    if radius is None:
        raise click.UsageError(
            "--shell-radius is missing: the radius of the robot's round belly [m]."
        )
    common |= {k: options[k] for k in ("shell_center", "shell_link") if _given(options, k)}
    common |= {"shell": Sphere(radius), "legs": names(options["legs"])}
    if urdf is not None:
        return Robot.from_urdf(Path(urdf), **common)
    return Robot.from_example(name, **common)


def build_ground(options: Options) -> Ground:
    """The ground of `robot_options`, with its gravity unless that is RRRobot's own."""
    normal = options["ground_normal"] if _given(options, "ground_normal") else (0.0, 0.0, 1.0)
    return Plane(normal, gravity=None if _is_rrrobot(options) else options["gravity"])


def refuse_ground(options: Options) -> None:
    """Refuse the options of a ground where a command's models know level ground only."""
    _refuse(options, ("ground_normal",), "do not go with this command: it needs level ground")
    if not _is_rrrobot(options):
        _refuse(options, ("gravity",), "are RRRobot's with this command")


def build_model(kind: type[M], options: Options, robot: Robot) -> M:
    """A model of a robot, with the ground and the damping of the options."""
    return kind(robot, ground=build_ground(options), damping=build_damping(options))  # type: ignore[call-arg]


def build_gait(options: Options, robot: Robot) -> Gait:
    """The prescribed gait of `gait_options`.

    Raises:
        click.UsageError: options that do not go together.
        GaitError: numbers that do not fit the robot's legs.
    """
    name, n = options["gait"], robot.n_legs
    if name == "still":
        _refuse(options, ("amplitude", "frequency", "phase", "ramp"), "do not go with --gait still")
        return StillLegs(_start_angle(options), n_legs=n)
    two = n == 2
    if not two and not _given(options, "offset"):
        raise click.UsageError(
            f"--offset is missing: the gaits of the paper are for two legs, and {robot.name} has "
            f"{n} leg joint{'s' * (n != 1)}; name two with --legs, or give --offset."
        )
    default = named_gait(name or GAITS[0])
    gait: Gait = SinusoidalGait(
        offset=options["offset"] if _given(options, "offset") else default.offset,
        amplitude=_or(options["amplitude"], 0.3),
        angular_frequency=_or(options["frequency"], 8.0),
        phase=_or(options["phase"], (0.0, math.pi / 2) if two else 0.0),
        n_legs=n,
    )
    return gait if options["ramp"] is None else RampIn(gait, options["ramp"])


def build_drive(options: Options, robot: Robot) -> Gait | LegTorques:
    """The torques of `drive_options` if they are given, else the gait of `gait_options`."""
    torque = options["torque"]
    if torque is None:
        return build_gait(options, robot)
    _refuse(options, ("gait", "amplitude", "frequency", "phase", "ramp"), "do not go with --torque")
    angle = _start_angle(options)
    angles = angle if isinstance(angle, tuple) else (angle,) * robot.n_legs
    return LegTorques(torque, angle=angles)


def build_damping(options: Options) -> DampingLike:
    """The damping of --damping and --damping-kind; without them the robot's own."""
    value, kind = options["damping"], options["damping_kind"]
    if value is None and kind is None:
        return OWN
    numbers = (value,) * 3 if isinstance(value, float) else value or (0.01,) * 3
    return (BodyRateDamping if kind == "body" else EulerRateDamping)(*numbers)


def build_run(options: Options) -> Options:
    """duration, sample_interval, step, rtol and method as `simulate` takes them.

    Raises:
        click.UsageError: both --step and --rtol.
        ParameterError: a duration that is not above zero.
    """
    if options["step"] is not None and options["rtol"] is not None:
        raise click.UsageError("--step is a fixed step, --rtol rules an adaptive one: give one.")
    finite("duration", options["duration"], "s", above=0)
    keys = ("duration", "sample_interval", "step", "rtol", "method")
    return {key: options[key] for key in keys if options[key] is not None}


@contextmanager
def progress_bar(duration: float, *, quiet: bool = False) -> Iterator[Progress | None]:
    """A progress meter on stderr, if that is a terminal and the run takes more than a second."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    form = "{desc} {percentage:3.0f}% |{bar}| {n:.3g} of {total:.3g} s, {remaining} left"
    with tqdm(
        total=duration, desc="simulating", bar_format=form, leave=False, delay=1.0, file=sys.stderr
    ) as bar:
        yield lambda time: bar.update(time - bar.n)


def _given(options: Options, key: str) -> bool:
    return options[key] is not None and options[key] != ()


def _or(value: Any, default: Any) -> Any:
    return default if value is None else value


def _refuse(options: Options, keys: tuple[str, ...], why: str) -> None:
    found = [f"--{key.replace('_', '-')}" for key in keys if _given(options, key)]
    if found:
        raise click.UsageError(f"{', '.join(found)}: such options {why}.")


def _is_rrrobot(options: Options) -> bool:
    return options["urdf"] is None and options["robot"] in (None, _DEFAULT_ROBOT)


def _start_angle(options: Options) -> Any:
    """--offset, or upright legs on RRRobot and 0 on others."""
    if _given(options, "offset"):
        return options["offset"]
    return math.pi / 2 if _is_rrrobot(options) else 0.0
