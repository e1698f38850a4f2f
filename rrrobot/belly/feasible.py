"""Can the real robot do this? Every limit along a run: what is passed, when and by how much.

Of each sample: normal force and the friction that the contact needs; the tilt against the belly's
rolling range; the distance of every link from the ground and from every other; position, rate and
effort of each joint against the limits of the robot's file; mechanical power of the motors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

import numpy as np

from rrrobot.belly.clearance import Clearances, clearances
from rrrobot.belly.found import Belly
from rrrobot.belly.ranges import TOUCH
from rrrobot.belly.shapes import Shapes
from rrrobot.belly.tilting import tilts
from rrrobot.checks import Array, finite
from rrrobot.contact.ground import Ground, normals
from rrrobot.robot.limits import JointLimits
from rrrobot.robot.robot import Robot
from rrrobot.simulation.events import Event, Snapshot
from rrrobot.simulation.trajectory import Trajectory

_SHOWN = {"tilt": (float(np.rad2deg(1.0)), " deg"), "clearance": (1e3, " mm"),
          "separation": (1e3, " mm"), "normal force": (1.0, " N"), "power": (1.0, " W"),
          "friction": (1.0, "")}  # fmt: skip
"""Factor and unit in which a violation is told; of joints that turn or slide, SI."""
_ROUNDING = 1e-9


@dataclass(frozen=True, kw_only=True)
class MotionLimits(JointLimits):
    """What a motion must keep to; None leaves a quantity out, but of joints takes the file's.

    Attributes:
        normal_force: least force along the ground's normal [N].
        friction: largest friction coefficient that the contact may need.
        tilt: largest tilt of the belly [rad]; that of its rolling range unless given.
        clearance: least distance of a limb's link from the ground [m].
        separation: least distance of two links that count [m].
        max_torque, max_leg_rate, leg_range: of the joints, those of the robot's file unless given;
            see `JointLimits`.
        power: largest sum of the motors' |torque x rate| [W].

    Raises:
        ParameterError: a number that is not finite, or a friction, power or tilt below zero.

    Example:
        >>> import rrrobot as rr
        >>> rr.belly.MotionLimits(friction=0.5).clearance
        0.0
    """

    normal_force: float | None = 0.0
    friction: float | None = None
    tilt: float | None = None
    clearance: float | None = 0.0
    separation: float | None = 0.0
    power: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, least in (("friction", 0.0), ("power", 0.0), ("tilt", 0.0)):
            if getattr(self, name) is not None:
                finite(name, getattr(self, name), at_least=least)
        for name in ("normal_force", "clearance", "separation"):
            if getattr(self, name) is not None:
                finite(name, getattr(self, name))


class Violation(NamedTuple):
    """A limit that a motion passes."""

    what: str
    """"normal force", "friction", "tilt", "clearance", "separation", "position", "rate", "effort",
    "power" """
    where: str
    """joint, link or pair of links; the body for what is of all"""
    time: float
    """when it is passed first [s]"""
    worst: float
    """when it is passed by most [s]"""
    value: float
    """then"""
    limit: float
    amount: float
    """by which it is passed then, above zero"""

    def __str__(self) -> str:
        scale, unit = _SHOWN.get(self.what, (1.0, ""))
        return (
            f"{self.what} of {self.where}: {scale * self.value:.4g}{unit} against "
            f"{scale * self.limit:.4g}{unit} at {self.worst:.4g} s, "
            f"{scale * self.amount:.3g}{unit} too far (first at {self.time:.4g} s)"
        )


class Row(NamedTuple):
    """A quantity along a run, against its limit: the margin is what is left (n,)."""

    what: str
    where: str
    value: Array
    limit: Array
    margin: Array


@dataclass(frozen=True, eq=False)
class Feasibility:
    """What `feasibility` finds.

    Attributes:
        violations: limits that are passed, the worst of each.
        margins: what is left of each limit over the run, least of all; below zero if passed.
        peak_friction, peak_tilt, peak_power, least_force: of the run [-, rad, W, N]; the tilt is
            NaN without a belly.
        clearance, separation: least distances of the run [m]; of limbs from the ground, but for
            links that the belly holds, and of links from each other.
        unlimited: joints whose effort limit is far beyond what could ever act, so none.
        distances: from the ground and between links, see `clearances`; None if not asked for.
    """

    violations: tuple[Violation, ...]
    margins: dict[str, float]
    peak_friction: float
    peak_tilt: float
    peak_power: float
    least_force: float
    clearance: float
    separation: float
    unlimited: tuple[str, ...]
    distances: Clearances | None = field(repr=False, default=None)

    @property
    def feasible(self) -> bool:
        """Whether no limit is passed."""
        return not self.violations

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        out = {k: v for k, v in asdict(self).items() if k not in ("distances", "violations")}
        out["violations"] = [one._asdict() for one in self.violations]
        return out | {"feasible": self.feasible}

    def __str__(self) -> str:
        told = [str(one) for one in self.violations] or ["all limits are kept"]
        if self.unlimited:
            told.append(f"no effort limit worth the name: {', '.join(self.unlimited)}")
        return "; ".join(told)


class Samples(NamedTuple):
    """What is known of some moments of a motion; n rows."""

    time: Array
    configuration: Array
    leg_angle: Array
    leg_rate: Array
    leg_torque: Array
    force: Array
    """of the ground on the robot (n, 3) [N]"""
    position: Array
    """of the contact, in the ground's coordinates (n, 2) [m]"""


def feasibility(
    trajectory: Trajectory,
    limits: MotionLimits | None = None,
    *,
    belly: Belly | None = None,
    shapes: Shapes | None = None,
) -> Feasibility:
    """Check a run against every limit.

    Args:
        trajectory: of a rolling model: of `simulate`, or of a gait that a sweep or the optimiser
            found, simulated over its cycle.
        limits: `MotionLimits()` unless given.
        belly: of the robot, whose rolling range the tilt must keep to.
        shapes: of the robot, to read its meshes once for many runs; the belly's unless given.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> t = rr.simulate(model, rr.gait("lateral"), duration=2.0)
        >>> found = rr.belly.feasibility(t, rr.belly.MotionLimits(friction=0.02))
        >>> [one.what for one in found.violations]
        ['friction']
    """
    limits = limits or MotionLimits()
    t = trajectory
    samples = Samples(
        t.time, t.configuration, t.leg_angle, t.leg_rate, t.leg_torque, t.contact_force, t.position
    )
    shapes = shapes or (Shapes.of(t.robot) if belly is None else belly.shapes)
    asked = limits.clearance is not None or limits.separation is not None
    distances = clearances(shapes, t.configuration, t.ground) if asked else None
    rows = _rows(t.robot, t.ground, samples, limits, belly, shapes, distances)
    margins: dict[str, float] = {}
    for row in rows:
        margins[row.what] = min(margins.get(row.what, np.inf), float(row.margin.min()))
    normal, friction = _contact(samples, t.ground)
    limb, tilt = np.inf, np.nan
    if distances is not None:
        limb = float(_limbs(distances, shapes, belly).min(initial=np.inf))
    if belly is not None:
        tilt = float(max(row.value.max() for row in rows if row.what == "tilt"))
    return Feasibility(
        tuple(v for row in rows for v in _violation(row, t.time)),
        margins,
        float(friction.max()),
        tilt,
        float(_power(samples).max()),
        float(normal.min()),
        limb,
        np.inf if distances is None else float(distances.between.min()),
        t.robot.joints.unlimited,
        distances,
    )


def limit_event(
    belly: Belly, limits: MotionLimits | None = None, *, terminal: bool = True
) -> Event:
    """An event for `simulate`: the first limit is reached; the run stops there if terminal.

    `feasibility` of the trajectory then says in `margins` which it was.

    Args:
        belly: of the robot that is simulated.
        limits: `MotionLimits()` unless given.
        terminal: whether the run ends.

    Example:
        >>> import rrrobot as rr
        >>> belly = rr.fit_belly(rr.Robot.from_parameters(), posture=(1.57, 1.57))
        >>> stop = rr.belly.limit_event(belly, rr.belly.MotionLimits(friction=0.02))
        >>> t = rr.simulate(belly.model(), rr.gait("lateral"), duration=1.0, events=[stop])
        >>> t.events[0].name, bool(t.time[-1] < 1.0)
        ('limit', True)
    """
    wanted, shapes = limits or MotionLimits(), belly.shapes
    asked = wanted.clearance is not None or wanted.separation is not None

    def least(at: Snapshot) -> float:
        found, model = at.dynamics, at.model
        q, v = found.q, found.v
        one = Samples(
            np.array([at.time]), q[None], model.legs.read(q)[None], v[model.legs.v][None],
            np.asarray(found.leg_torque)[None], np.asarray(found.contact_force)[None],
            at.position[None],
        )  # fmt: skip
        distances = clearances(shapes, q[None], model.ground) if asked else None
        rows = _rows(model.robot, model.ground, one, wanted, belly, shapes, distances)
        return min(float(row.margin[0]) for row in rows)

    return Event(least, terminal, -1, "limit")


def _rows(
    robot: Robot,
    ground: Ground,
    at: Samples,
    limits: MotionLimits,
    belly: Belly | None,
    shapes: Shapes,
    distances: Clearances | None,
) -> list[Row]:
    """All quantities that have a limit."""
    rows: list[Row] = []

    def add(what: str, where: str, value: Array, limit: Any, sign: float) -> None:
        bound = np.broadcast_to(np.asarray(limit, dtype=float), value.shape)
        rows.append(Row(what, where, value, bound, sign * (bound - value)))

    normal, friction = _contact(at, ground)
    if limits.normal_force is not None:
        add("normal force", robot.name, normal, limits.normal_force, -1)
    if limits.friction is not None:
        add("friction", robot.name, friction, limits.friction, 1)
    if limits.power is not None:
        add("power", robot.name, _power(at), limits.power, 1)
    if belly is not None:
        tilt, azimuth = tilts(belly, at.configuration, at.position, ground)
        most = belly.rolling_range.at(azimuth) if limits.tilt is None else limits.tilt
        add("tilt", robot.name, tilt, most, 1)
    if distances is not None and limits.clearance is not None:
        covered = () if belly is None else belly.covered
        base = {piece.link for piece in shapes.on_joint(1)}
        for i, link in enumerate(distances.links):
            if link not in base:
                least = min(limits.clearance, -TOUCH) if link in covered else limits.clearance
                add("clearance", link, distances.ground[:, i], least, -1)
    if distances is not None and limits.separation is not None and shapes.pairs:
        for which in np.unique(distances.pair):
            here = distances.pair == which
            apart = np.where(here, distances.between, np.inf)
            i, j = shapes.pairs[int(which)]
            names = f"{shapes.pieces[i].link} and {shapes.pieces[j].link}"
            add("separation", names, apart, limits.separation, -1)
    ends = limits.ends(robot)
    for k, leg in enumerate(robot.legs):
        add("position", leg, at.leg_angle[:, k], ends.upper[k], 1)
        add("position", leg, at.leg_angle[:, k], ends.lower[k], -1)
        add("rate", leg, np.abs(at.leg_rate[:, k]), ends.velocity[k], 1)
        add("effort", leg, np.abs(at.leg_torque[:, k]), ends.effort[k], 1)
    return rows


def _contact(at: Samples, ground: Ground) -> tuple[Array, Array]:
    """Normal force (n,) [N] and the friction coefficient that is needed (n,)."""
    up = normals(ground, at.position)
    normal = np.sum(at.force * up, axis=1)
    along = np.linalg.norm(at.force - normal[:, None] * up, axis=1)
    return normal, np.divide(along, normal, out=np.full(len(along), np.inf), where=normal > 0)


def _power(at: Samples) -> Array:
    return np.asarray(np.abs(at.leg_torque * at.leg_rate).sum(axis=1))


def _limbs(distances: Clearances, shapes: Shapes, belly: Belly | None) -> Array:
    base = {piece.link for piece in shapes.on_joint(1)}
    base |= set(() if belly is None else belly.covered)
    return distances.ground[:, [i for i, link in enumerate(distances.links) if link not in base]]


def _violation(row: Row, time: Array) -> Sequence[Violation]:
    passed = np.flatnonzero(row.margin < -_ROUNDING * (1 + np.abs(np.nan_to_num(row.limit))))
    if not passed.size:
        return ()
    worst = int(np.argmin(row.margin))
    return (
        Violation(
            row.what, row.where, float(time[passed[0]]), float(time[worst]),
            float(row.value[worst]), float(row.limit[worst]), -float(row.margin[worst]),
        ),
    )  # fmt: skip
