"""All that can be set in the laboratory, as one value: sliders, a link and a file say the same."""

from __future__ import annotations

import base64
import binascii
import json
import math
import zlib
from dataclasses import asdict, dataclass, fields, replace
from functools import lru_cache
from typing import Any

import numpy as np

from rrrobot.checks import finite
from rrrobot.contact.ground import Plane
from rrrobot.drive.damping import BodyRateDamping, Damping, EulerRateDamping
from rrrobot.drive.gaits import FourierGait, Gait, SinusoidalGait
from rrrobot.errors import ParameterError
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.recombined import DecoupledModels
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.robot import Robot

PerLeg = tuple[float, ...]

OVERTONES = (2, 3)
"""Harmonics beside the first."""
BODY = ("leg_mass", "servo_mass", "battery_mass", "leg_length", "shell_radius")
"""Of RRRobot's parameters, those that can be set; a pair stands where it is given as a pair."""


@dataclass(frozen=True, kw_only=True)
class Knobs:
    """Where everything stands.

    phi_k(t) = offset_k + amplitude_k sin(omega t + phase_k) + sum over j = 2, 3 of
    overtone_jk sin(j omega t + overtone_phase_jk)

    Attributes:
        offset, amplitude, phase: of each leg [rad].
        frequency: omega [rad/s].
        overtone, overtone_phase: of harmonics 2 and 3, one row each, of each leg [rad].
        damping: on each of the three rates of the body [N m s/rad].
        damping_kind: "euler" rates, as the paper, or "body" rates.
        gravity: [m/s^2].
        slope: of the ground, which rises along x [rad].
        body: masses and lengths of RRRobot, in the order of `BODY`; empty for any other robot.
        friction: that the ground has; it decides nothing but what is said of it.
        horizon: time over which the path is drawn [s].
    """

    offset: PerLeg
    amplitude: PerLeg
    phase: PerLeg
    frequency: float = 8.0
    overtone: tuple[PerLeg, ...] = ()
    overtone_phase: tuple[PerLeg, ...] = ()
    damping: float = 0.01
    damping_kind: str = "euler"
    gravity: float = 9.81
    slope: float = 0.0
    body: tuple[float, ...] = ()
    friction: float = 0.3
    horizon: float = 60.0

    @classmethod
    def of(cls, robot: Robot) -> Knobs:
        """Where they stand at first: the paper's second gait, or as much for any robot."""
        n, p = robot.n_legs, robot.parameters
        still = (0.0,) * n
        return cls(
            offset=((math.pi / 4 if p is not None else 0.0),) * n,
            amplitude=(0.3,) * n,
            phase=tuple(0.5 * math.pi * (k % 2) for k in range(n)),
            overtone=(still,) * len(OVERTONES),
            overtone_phase=(still,) * len(OVERTONES),
            damping=p.damping if p is not None else 0.02 * robot.mass,
            damping_kind="euler" if p is not None else "body",
            gravity=robot.gravity,
            body=() if p is None else tuple(_mean(getattr(p, name)) for name in BODY),
        )

    def gait(self) -> Gait:
        """The legs' motion."""
        if not np.any(self.overtone):
            return SinusoidalGait(
                offset=self.offset,
                amplitude=self.amplitude,
                angular_frequency=self.frequency,
                phase=self.phase,
            )
        size = np.array((self.amplitude, *self.overtone))
        turn = np.array((self.phase, *self.overtone_phase))
        return FourierGait(
            offset=self.offset,
            cosine=size * np.sin(turn),
            sine=size * np.cos(turn),
            angular_frequency=self.frequency,
        )

    def robot(self, given: Robot) -> Robot:
        """The given robot with these masses and lengths; gravity is the ground's."""
        p = given.parameters
        if p is None:
            return given
        changed = {
            name: value
            for name, value in zip(BODY, self.body, strict=True)
            if not math.isclose(value, _mean(getattr(p, name)), rel_tol=1e-9)
        }
        if not changed:
            return given
        if "shell_radius" in changed:
            changed["hip_offset"] = p.hip_offset / p.shell_radius * changed["shell_radius"]
        return _made(replace(p, **changed))

    def losses(self, axes: tuple[int, int, int] = (1, 1, 1)) -> Damping | None:
        """The damping of these axes; None if there is none."""
        if self.damping == 0.0 or not any(axes):
            return None
        kind = BodyRateDamping if self.damping_kind == "body" else EulerRateDamping
        return kind(*(self.damping * free for free in axes))

    def ground(self) -> Plane:
        """The plane below."""
        normal = (-math.sin(self.slope), 0.0, math.cos(self.slope))
        return Plane(normal, gravity=self.gravity)

    def model(self, given: Robot) -> Model:
        """The full model of the given robot."""
        return FullModel(self.robot(given), ground=self.ground(), damping=self.losses())

    def other(self, given: Robot, name: str) -> Model:
        """The "pivoting" model, or the single-axis ones "decoupled", damped where the paper does.

        Raises:
            ModelError: the robot has no such model.
        """
        robot, ground = self.robot(given), self.ground()
        if name == "pivoting":
            return PivotingModel(robot, ground=ground, damping=self.losses(PivotingModel.damped))
        parts = (
            kind(robot, ground=ground, damping=self.losses(kind.damped))
            for kind in (RollModel, PitchModel, YawModel)
        )
        return DecoupledModels(robot, *parts)  # type: ignore[arg-type]

    @property
    def settles(self) -> bool:
        """Whether a motion can repeat: on level ground, with losses, legs that move."""
        moves = bool(np.any(self.amplitude) or np.any(self.overtone))
        return self.slope == 0.0 and self.damping > 0.0 and moves

    def text(self) -> str:
        """All of it in letters that a link may hold."""
        data = json.dumps(asdict(self), separators=(",", ":")).encode()
        return base64.urlsafe_b64encode(zlib.compress(data, 9)).decode().rstrip("=")

    def read(self, text: str) -> Knobs:
        """What `text` wrote, for the robot that these knobs are of.

        Raises:
            ParameterError: it is none, or of another robot.
        """
        try:
            raw = base64.b64decode(text + "=" * (-len(text) % 4), altchars=b"-_", validate=True)
            # A few hundred bytes, whatever the link claims.
            packed = zlib.decompressobj()
            data = packed.decompress(raw, 65536)
            if not packed.eof:
                raise ValueError("it is cut short")
            return self._checked(json.loads(data))
        except (binascii.Error, zlib.error, UnicodeError, ValueError, TypeError, KeyError) as error:
            raise ParameterError(
                f"the link's state cannot be read ({error}): copy the whole link."
            ) from None

    def _checked(self, data: Any) -> Knobs:
        """Knobs of plain data: the same names, the same shapes, finite numbers."""
        if not isinstance(data, dict) or data.keys() != {f.name for f in fields(self)}:
            raise ValueError("it has other entries")
        found: dict[str, Any] = {}
        for name, now in asdict(self).items():
            value = data[name]
            if isinstance(now, str):
                if value not in ("euler", "body"):
                    raise ValueError(f"{name} is {value!r}")
                found[name] = value
                continue
            array, like = np.asarray(value, dtype=float), np.asarray(now, dtype=float)
            if array.shape != like.shape or not np.all(np.isfinite(array)):
                raise ValueError(f"{name} is of another robot or no number")
            found[name] = _tuples(array.tolist())
        for name in ("frequency", "horizon", "gravity"):
            finite(name, found[name], above=0)
        return Knobs(**found)


@lru_cache(maxsize=8)
def _made(parameters: RRRobotParameters) -> Robot:
    return Robot.from_parameters(parameters)


def _mean(value: float | tuple[float, float]) -> float:
    return float(np.mean(value))


def _tuples(value: Any) -> Any:
    return tuple(_tuples(part) for part in value) if isinstance(value, list) else value
