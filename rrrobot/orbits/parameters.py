"""What an orbit depends on, by name: each parameter of gait, robot, damping, ground and gravity.

A gait's entries are `offset[0]`, `amplitude[1]`, `sine[0,1]` and so on; where all legs have the
same, `offset` and `amplitude` stand for all. RRRobot's are those of `RRRobotParameters`; of other
robots the radius of a spherical shell and each link's mass, its inertia growing with it. A slope's
is its angle `slope`, downhill in the same direction, a boulder's `boulder_radius`, a bowl's
`bowl_radius`.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.contact.boulder import Boulder
from rrrobot.contact.ground import Ground, Plane
from rrrobot.drive.gaits import FourierGait, Gait, SinusoidalGait
from rrrobot.errors import GroundClearanceWarning, ParameterError
from rrrobot.momentum.kernels import ANY
from rrrobot.orbits.found import Case, setting_for
from rrrobot.orbits.section import section_of
from rrrobot.robot.robot import Robot

_UNITS = {
    "offset": "rad",
    "amplitude": "rad",
    "phase": "rad",
    "angular_frequency": "rad/s",
    "cosine": "rad",
    "sine": "rad",
    "phase_difference": "rad",
}
_LOSSES = ("damping_roll", "damping_pitch", "damping_yaw")
_BRAKES = ("damping", *_LOSSES)
_MASS, _RADII, _GRAVITY, _LOSS = 0, slice(1, 3), 3, 4


@dataclass(frozen=True)
class Parameter:
    """One number that an orbit depends on.

    Attributes:
        name, unit: its name and unit.
        value: now.
        at: the same case with another value of it.
        above: values must be greater.
    """

    name: str
    unit: str
    value: float
    at: Callable[[float], Case]
    above: float = -math.inf

    @property
    def size(self) -> float:
        """What counts as a change of order one: 1 rad of an angle, the value itself of others."""
        return 1.0 if self.unit == "rad" else abs(self.value) or 1.0

    def behind(self, goal: float) -> float:
        """As far behind the value as a goal lies before it, or near the least value."""
        return max(2 * self.value - goal, self.above + 0.01 * (self.value - self.above))

    def check(self, argument: str, value: float) -> None:
        """Raise ParameterError for a value that has no meaning."""
        if value <= self.above:
            why = ", for without it next to each orbit lie others" if self.name in _BRAKES else ""
            raise ParameterError(
                f"{argument} is {value:g} {self.unit}: {self.name} must stay above "
                f"{self.above:g}{why}."
            )


def parameters_of(case: Case) -> dict[str, Parameter]:
    """All parameters of a case by name."""
    found = [*_of_gait(case), *_of_robot(case), *_of_setting(case), *_of_ground(case)]
    return {parameter.name: parameter for parameter in found}


def parameter_of(case: Case, name: str) -> Parameter:
    """One parameter.

    Raises:
        ParameterError: there is none of this name; the message lists those that there are.
    """
    known = parameters_of(case)
    if name not in known:
        raise ParameterError(
            f"there is no parameter {name!r} here: it must be one of {', '.join(known)}."
        )
    return known[name]


def _of_gait(case: Case) -> list[Parameter]:
    gait = case.gait
    if isinstance(gait, SinusoidalGait):
        fields = {k: getattr(gait, k) for k in ("offset", "amplitude", "phase")}
        common = {"angular_frequency": gait.angular_frequency}
        make: Callable[..., Gait] = SinusoidalGait
    elif isinstance(gait, FourierGait):
        fields = {k: getattr(gait, k) for k in ("offset", "cosine", "sine")}
        common = {"angular_frequency": np.array(gait.angular_frequency)}
        make = FourierGait
    else:
        return []

    def with_gait(key: str, array: Any) -> Case:
        parts = fields | common | {key: array}
        if make is FourierGait:
            parts["angular_frequency"] = float(parts["angular_frequency"])
        new = make(**parts)
        return replace(case, gait=new, period=float(new.period or case.period))

    def entry(key: str, array: Array, place: tuple[int, ...]) -> Parameter:
        def at(value: float) -> Case:
            moved = array.copy()
            moved[place] = value
            return with_gait(key, moved)

        index = ",".join(str(i) for i in place)
        return Parameter(f"{key}[{index}]", _UNITS[key], float(array[place]), at)

    def whole(key: str, array: Array) -> Parameter:
        def at(value: float) -> Case:
            return with_gait(key, np.full_like(array, value))

        low = 0.0 if key == "angular_frequency" else -math.inf
        return Parameter(key, _UNITS[key], float(array.flat[0]), at, low)

    out = []
    for key, array in fields.items():
        if array.size > 1 and array.ndim == 1 and key != "phase" and np.ptp(array) == 0:
            out.append(whole(key, array))
        out += [entry(key, array, place) for place in np.ndindex(array.shape)]
    out += [whole(key, array) for key, array in common.items() if np.ptp(array) == 0]
    if isinstance(gait, SinusoidalGait) and gait.n_legs == 2:
        first, second = gait.phase

        def lead(value: float) -> Case:
            return with_gait("phase", np.array((first, first + value)))

        out.append(Parameter("phase_difference", "rad", float(second - first), lead))
    # A yaw model's own gait would stay as it is while the other changes.
    return out if case.yaw_gait is None else []


def _of_robot(case: Case) -> list[Parameter]:
    robot = case.model.robot
    if robot.parameters is None:
        return _of_any_robot(case)
    base = robot.parameters

    def field(key: str, leg: int | None) -> Parameter:
        given = getattr(base, key)

        def at(value: float) -> Case:
            new = value if leg is None else tuple(
                value if i == leg else old for i, old in enumerate(given)
            )  # fmt: skip
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", GroundClearanceWarning)
                made = Robot.from_parameters(replace(base, **{key: new}))
            return _with_robot(case, made)

        name = key if leg is None else f"{key}[{leg}]"
        unit = "kg" if key.endswith("mass") else "m"
        return Parameter(name, unit, float(given if leg is None else given[leg]), at, 0.0)

    out = []
    for key in ("leg_mass", "servo_mass", "battery_mass", "shell_radius", "leg_length",
                "hip_offset"):  # fmt: skip
        legs = range(2) if isinstance(getattr(base, key), tuple) else (None,)
        out += [field(key, leg) for leg in legs]
    return out


def _with_robot(case: Case, robot: Robot) -> Case:
    model = case.model
    if model.name == "decoupled":
        new: Any = type(model)(robot, *(part.remade(robot) for part in model.models))
    else:
        new = model.remade(robot)
    return replace(case, model=new, setting=setting_for(new))


def _of_any_robot(case: Case) -> list[Parameter]:
    setting, robot = case.setting, case.model.robot
    tree = setting.tree

    def radius(value: float) -> Case:
        numbers = setting.parameters.copy()
        numbers[_RADII] = np.where(numbers[_RADII] > 0, value, 0.0)
        return replace(case, setting=setting._replace(parameters=numbers))

    def mass_of(i: int) -> Parameter:
        def at(value: float) -> Case:
            ratio, mass, inertia = value / tree.mass[i], tree.mass.copy(), tree.inertia.copy()
            mass[i], inertia[i] = value, ratio * inertia[i]
            numbers = setting.parameters.copy()
            numbers[_MASS] += value - tree.mass[i]
            changed = tree._replace(mass=mass, inertia=inertia)
            return replace(case, setting=setting._replace(tree=changed, parameters=numbers))

        name = "base" if i == 0 else robot.model.names[i + 1]
        return Parameter(f"mass[{name}]", "kg", float(tree.mass[i]), at, 0.0)

    masses = [mass_of(i) for i in range(tree.mass.size) if tree.mass[i] > 0]
    if setting.axis == ANY:
        # Of a shell that is no sphere about the pivot there is no one length.
        return masses
    shell = Parameter("shell_radius", "m", float(setting.parameters[_RADII].max()), radius, 0.0)
    return [shell, *masses]


def _of_ground(case: Case) -> list[Parameter]:
    model = case.model
    if model.name == "decoupled":
        return []
    ground = model.ground

    def with_ground(new: Ground) -> Case:
        there = type(model)(model.robot, ground=new, damping=model.damping)
        setting = setting_for(there)
        section = section_of(setting, model.name)
        return replace(case, model=there, setting=setting, section=section)

    if isinstance(ground, Boulder):
        side = math.copysign(1.0, ground.radius)

        def rounded(value: float) -> Case:
            return with_ground(replace(ground, radius=side * value))

        name = "boulder_radius" if side > 0 else "bowl_radius"
        return [Parameter(name, "m", abs(ground.radius), rounded, 0.0)]
    if not case.section.heads:
        return []
    normal = ground.normal_vector
    across = math.hypot(normal[0], normal[1])

    def tilted(value: float) -> Case:
        lean = math.sin(value) / across
        there = (lean * normal[0], lean * normal[1], math.cos(value))
        return with_ground(Plane(normal=there, gravity=ground.gravity))

    return [Parameter("slope", "rad", math.atan2(across, normal[2]), tilted, 0.0)]


def _of_setting(case: Case) -> list[Parameter]:
    setting = case.setting
    numbers = setting.parameters

    def number(name: str, unit: str, places: list[int]) -> Parameter:
        def at(value: float) -> Case:
            changed = numbers.copy()
            changed[places] = value
            return replace(case, setting=setting._replace(parameters=changed))

        return Parameter(name, unit, float(numbers[places[0]]), at, 0.0)

    unit = "N m s/rad"
    losses = [_LOSS + i for i in range(3) if numbers[_LOSS + i] > 0]
    out = [number(_LOSSES[place - _LOSS], unit, [place]) for place in losses]
    if losses and np.ptp(numbers[losses]) == 0:
        out.append(number("damping", unit, losses))
    if numbers[_GRAVITY] > 0:
        out.append(number("gravity", "m/s^2", [_GRAVITY]))
    return out
