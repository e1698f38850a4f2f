"""From any yaw and leg angles at rest to any other: loops of both legs, then one leg at a time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.drive.moves import LegMoves
from rrrobot.errors import GaitError, ModelError, ParameterError
from rrrobot.models.single_axis import YawModel
from rrrobot.reduction.connection import Connection
from rrrobot.reduction.loops import Planner
from rrrobot.robot.robot import Robot


@dataclass(frozen=True, kw_only=True, eq=False)
class YawPlan:
    """A leg motion that brings the yaw model from one configuration at rest to another.

    Attributes:
        robot: the robot.
        start, goal: (theta, phi_1, ..., phi_n) [rad]; the goal's theta as it is reached.
        gait: the motion, for `simulate`, with its `duration` and `moves`.
        cycles: turns of the second gait.
        cycle_yaw: net yaw of each [rad].
        straight_yaw: net yaw of all moves of single legs [rad].

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> plan = rr.steering.plan_yaw(robot, (0.0, 1.2, 1.6), (0.3, 1.8, 1.0))
        >>> round(plan.cycles * plan.cycle_yaw + plan.straight_yaw, 9)
        0.3
    """

    robot: Robot
    start: Array
    goal: Array
    gait: LegMoves
    cycles: int
    cycle_yaw: float
    straight_yaw: float

    @property
    def duration(self) -> float:
        """[s]"""
        return self.gait.duration

    @property
    def euler(self) -> tuple[float, float, float]:
        """Roll, pitch, yaw at the start [rad], for `simulate(..., euler=plan.euler)`."""
        return (0.0, 0.0, float(self.start[0]))

    @cached_property
    def _tracker(self) -> tuple[YawModel, Connection, Any]:
        model = YawModel(self.robot)
        return model, Connection(model), model.model.createData()

    def torque(self, time: ArrayLike) -> Array:
        """Motor torques that track the plan (..., legs) [N m], by inverse dynamics.

        tau = legs' rows of M q_ddot + C q_dot of the yaw model, eq (13), with the yaw of eq (14).
        """
        model, connection, data = self._tracker
        out = []
        for t in np.ravel(time):
            angle, rate, acceleration = self.gait(float(t))
            value = connection(angle)
            turn = -value @ rate
            bend = -value @ acceleration - rate @ connection.derivative(angle) @ rate
            q = model.configuration(model.make_pose(np.zeros(3), np.zeros(2)), angle)
            v, a = np.empty((2, model.model.nv))
            v[0], a[0] = turn, bend
            v[model.legs.v], a[model.legs.v] = rate, acceleration
            out.append(pin.rnea(model.model, data, q, v, a)[model.legs.v])
        return np.reshape(out, (*np.shape(time), self.robot.n_legs))


def plan_yaw(
    robot: Robot | YawModel,
    start: ArrayLike,
    goal: ArrayLike,
    *,
    angle_range: ArrayLike | None = None,
    pair: tuple[int, int] = (0, 1),
    max_rate: float = 2.4,
    max_cycles: int = 1000,
    wrap: bool = False,
) -> YawPlan:
    """Plan from (theta, phi) at rest to another (theta, phi) at rest, exactly.

    The paper's second gait (loops of two legs through the start's posture) makes up what the first
    gait (then each leg in turn straight to its goal) lacks. The loop is the one with most net yaw
    among ellipses through the posture and inside the limits, shrunk until a whole number of cycles
    gives the yaw exactly. Where limits or the posture leave it too little, the legs first go, one
    at a time, to a posture that is better for loops.

    Args:
        robot: with two legs or more and a spherical shell.
        start: (theta, phi_1, ..., phi_n) [rad].
        goal: likewise.
        angle_range: (low, high) of every leg, or a row for each (legs, 2) [rad]; none unless given.
        pair: the two legs that make loops.
        max_rate: highest rate of a leg [rad/s].
        max_cycles: most cycles.
        wrap: arrive at the goal's yaw up to whole turns, by the shorter way.

    Returns:
        the YawPlan.

    Raises:
        GaitError: start or goal outside of the limits; limits so narrow that the yaw needs more
            than `max_cycles`.
        ParameterError: numbers of the wrong size or range.
        ModelError: fewer than two legs, or a robot that the YawModel does not take.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> start, goal = (0.0, 1.2, 1.6), (0.3, 1.8, 1.0)
        >>> plan = rr.steering.plan_yaw(robot, start, goal, angle_range=(0.4, 2.7))
        >>> t = rr.simulate(rr.YawModel(robot), plan.gait, plan.duration, sample_interval=1.0)
        >>> bool(abs(t.euler[-1, 2] - 0.3) < 1e-6), t.leg_angle[-1].round(9).tolist()
        (True, [1.8, 1.0])
    """
    model = robot if isinstance(robot, YawModel) else YawModel(robot)
    connection = Connection(model)
    n = connection.n_legs
    if n < 2:
        raise ModelError(f"the robot has {n} leg: without loops of two legs no yaw is gained.")
    pair = connection.pair(pair)
    first, last = vector("start", start, n + 1, "rad"), vector("goal", goal, n + 1, "rad")
    speed = finite("max_rate", max_rate, "rad/s", above=0)
    if isinstance(max_cycles, bool) or not isinstance(max_cycles, int) or max_cycles < 1:
        raise ParameterError(f"max_cycles is {max_cycles!r}: it must be a whole number, 1 or more.")
    box = _box(angle_range, n)
    for name, where in (("start", first), ("goal", last)):
        _inside(name, where[1:], box)

    planner = Planner(connection, pair, box, first[1:], last[1:], speed)
    turn = float(last[0] - first[0])
    if wrap:
        # The nearer of the turns that are left after the straight moves.
        rest = turn - planner.straight_yaw(first[1:])
        turn -= 2 * np.pi * round(rest / (2 * np.pi))
    gait, cycles, cycle_yaw, straight = planner.moves(turn, max_cycles)
    return YawPlan(
        robot=connection.robot,
        start=first,
        goal=np.concatenate(([first[0] + turn], last[1:])),
        gait=gait,
        cycles=cycles,
        cycle_yaw=cycle_yaw,
        straight_yaw=straight,
    )


def _box(angle_range: ArrayLike | None, n: int) -> Array:
    if angle_range is None:
        return np.tile((-np.inf, np.inf), (n, 1))
    try:
        box = np.array(np.broadcast_to(np.asarray(angle_range, dtype=float), (n, 2)))
    except (TypeError, ValueError):
        box = np.full((n, 2), np.nan)
    if np.any(np.isnan(box)) or np.any(box[:, 0] >= box[:, 1]):
        raise ParameterError(
            f"angle_range is {angle_range!r}: it must be (low, high) for all legs, or ({n}, 2) "
            "with one row for each, low below high [rad]."
        )
    return box


def _inside(name: str, angles: Array, box: Array) -> None:
    for leg, (angle, (low, high)) in enumerate(zip(angles, box, strict=True)):
        if not low <= angle <= high:
            raise GaitError(
                f"{name}: leg {leg + 1} is at {angle:.6g} rad, outside of its limits {low:.6g} .. "
                f"{high:.6g} rad. Move the {name} inside, or widen the limits."
            )
