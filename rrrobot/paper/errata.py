"""Where the paper errs, and what it leaves open: the evidence for how rrrobot reads it."""

from __future__ import annotations

import math

import numpy as np

from rrrobot.drive.damping import EulerRateDamping
from rrrobot.drive.gaits import StillLegs, gait
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.single_axis import YawModel
from rrrobot.orbits.oscillations import PAPER_TABLE_3, modes
from rrrobot.paper.closed_forms import (
    composite_period,
    rolling_pendulum_period,
    simple_pendulum_period,
    yaw_mass_matrix,
)
from rrrobot.paper.item import (
    DIFFERS,
    ERRATUM,
    Item,
    Limit,
    Result,
    Row,
    about,
    below,
    feature,
    record,
)
from rrrobot.paper.workshop import Workshop
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.robot import Robot
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory


def _erratum(
    quantity: str,
    paper: float | str,
    ours: float,
    unit: str = "",
    note: str = "",
    *,
    limit: Limit,
    right: bool,
) -> Row:
    """What the printed form gives: an erratum if it breaks the limit and the right form does not.

    Args:
        limit: what a right form would keep.
        right: whether the corrected form does, which has a row of its own.
    """
    verdict = ERRATUM if right and not limit.holds(ours) else DIFFERS
    return Row(quantity=quantity, paper=paper, ours=ours, unit=unit, verdict=verdict,
               limit=str(limit), note=note)  # fmt: skip


def _eq_5(shop: Workshop) -> Result:
    run = shop.comparison("circular").trajectories["full"]
    printed, left = _row_residual(run, 0), _row_residual(run, 1)
    row = _erratum(
        "velocity along y that eq (5) leaves, as printed", "0 (no slip)", printed, "m/s",
        "Largest over the circular gait. The third entry must be r cos(pitch) cos(yaw).",
        limit=below(1e-6), right=left < 1e-6,
    )  # fmt: skip
    mended = feature("the same, corrected", "0 (no slip)", left, "m/s", limit=below(1e-06))
    return Result(rows=(row, mended))


def _row_residual(run: Trajectory, angle: int) -> float:
    """Largest y_dot + r cos(angle) cos(yaw) roll_rate - r sin(yaw) pitch_rate [m/s]."""
    from scipy.interpolate import make_interp_spline

    radius = run.robot.shell.radius  # type: ignore[attr-defined]
    along = make_interp_spline(run.time, run.position[:, 1], k=5).derivative()(run.time)
    yaw = run.euler[:, 2]
    roll_rate, pitch_rate = run.euler_rates[:, 0], run.euler_rates[:, 1]
    third = radius * np.cos(run.euler[:, angle]) * np.cos(yaw)
    left = along + third * roll_rate - radius * np.sin(yaw) * pitch_rate
    # The spline is less sure at its ends.
    return float(np.abs(left[5:-5]).max())


def _eq_12(shop: Workshop) -> Result:
    parameters = RRRobotParameters(hip_offset=0.09)
    model = YawModel(Robot.from_parameters(parameters))
    legs = (0.8, 1.1)
    exact = model.mass_matrix(model.make_pose(np.zeros(3), np.zeros(2)), legs)
    printed = yaw_mass_matrix(parameters, legs)
    printed[0, 1:] *= parameters.shell_radius / parameters.hip_offset
    printed[1:, 0] = printed[0, 1:]
    off = float(np.abs(printed - exact).max() / np.abs(exact[0, 1:]).max())
    right = float(np.abs(yaw_mass_matrix(parameters, legs) - exact).max())
    return Result(
        rows=(
            _erratum(
                "g12 and g13 with r as printed, on a robot with b = 0.75 r: relative error",
                "r", off, note="They must have the hip offset b. With b = r of Table 2 all agree.",
                limit=below(1e-6), right=right < 1e-13,
            ),
            feature("with b: difference from Pinocchio", "eq (12)", right, "kg m^2",
                    limit=below(1e-13)),
        ),
        remarks=("M_m in g11 is the servo mass M_s of Table 2.",),
    )  # fmt: skip


def _eqs_7_8(shop: Workshop) -> Result:
    rows = []
    mass = shop.robot.mass
    models = (("rolling", shop.full), ("pivoting", PivotingModel(shop.robot)))
    for where, model in models:
        inertia = _inertia_about_pitch(model)
        gyration = math.sqrt(inertia / mass)
        if where == "rolling":
            eq, by = "eq (7)", rolling_pendulum_period(_RADIUS, gyration)
        else:
            eq, by = "eq (8)", simple_pendulum_period(gyration)
        printed = PAPER_TABLE_3[where, "pitch"]
        right = composite_period(inertia, _stiffness(shop.robot))
        up = np.full(2, np.pi / 2)
        linear = next(m.period for m in modes(type(model)(shop.robot, damping=None), up)
                      if m.axis == "pitch")  # fmt: skip
        rows += [
            _erratum(f"{eq} with RRRobot's radius of gyration in pitch", printed, by, "s",
                     limit=about(printed, 0.1), right=abs(right - linear) < 1e-8),
            feature(
                f"{where}: 2 pi sqrt(I / (m g d)) less the linearised model's period", "-",
                right - linear, "s", limit=about(0.0, 1e-08),
            ),
        ]  # fmt: skip
    return Result(
        rows=tuple(rows),
        remarks=("Both equations are for one point mass. RRRobot is a composite body.",),
    )


_RADIUS = RRRobotParameters().shell_radius


def _inertia_about_pitch(model: Model) -> float:
    """Of the upright robot with legs up, about the axis through the contact or the pivot."""
    legs = np.full(2, np.pi / 2)
    pose = model.make_pose(np.zeros(3), np.zeros(2))
    rates = np.array((0.0, 1.0, 0.0))
    quasi = model.quasi_from_euler_rates(pose, rates)
    v = model.velocity(pose, quasi, np.zeros(2))
    return float(2 * model.energy(model.configuration(pose, legs), v)[0])


def _stiffness(robot: Robot) -> float:
    """m g d of the upright robot with legs up [N m]."""
    model = PivotingModel(robot, damping=None)
    legs = np.full(2, np.pi / 2)

    def height(pitch: float) -> float:
        pose = model.make_pose(np.array((0.0, pitch, 0.0)), np.zeros(2))
        q = model.configuration(pose, legs)
        return model.energy(q, np.zeros(model.model.nv))[1]

    # The potential is m g d (1 - cos pitch).
    return height(np.pi / 2) - height(0.0)


def _eqs_9_10(shop: Workshop) -> Result:
    from scipy.integrate import simpson

    run = simulate(
        shop.full, StillLegs((np.pi / 2, np.pi / 2)), 3.0, 0.002, euler=(0.2, 0.3, 0.0),
        start="rest",
    )  # fmt: skip
    lost = float(run.energy[0] - run.energy[-1])
    squared, linear = (
        0.01 * float(simpson((run.euler_rates**power).sum(axis=1), x=run.time)) / lost
        for power in (3, 2)
    )
    return Result(
        rows=(
            _erratum(
                "0.01 rate^2 times rate, over the energy that a rocking robot loses", "1", squared,
                note="The matrices hold the velocities and multiply them again.",
                limit=about(1.0, 0.1), right=abs(linear - 1) < 1e-6,
            ),
            feature("0.01 rate times rate, over that energy", "1", linear,
                    limit=about(1, 1e-06)),
        ),
        remarks=("The generalised force on each Euler rate is -0.01 N m s/rad times the rate.",),
    )  # fmt: skip


def _legs_up(shop: Workshop) -> Result:
    rows = []
    off = {}
    for name, angle in (("up", np.pi / 2), ("down", -np.pi / 2)):
        models = {
            "rolling": FullModel(shop.robot, damping=None),
            "pivoting": PivotingModel(shop.robot, damping=None),
        }
        found = {
            (where, mode.axis): mode.period
            for where, model in models.items()
            for mode in modes(model, np.full(2, angle))
        }
        off[name] = max(abs(found[key] - printed) for key, printed in PAPER_TABLE_3.items())
        rows += [
            record(f"legs {name}: {where}, {axis}", found[where, axis], "s")
            for where, axis in PAPER_TABLE_3
        ]
    rows.append(feature(
        "largest difference from Table 3, legs up over legs down", "up", off["up"] / off["down"],
        limit=below(0.2),
    ))  # fmt: skip
    return Result(rows=tuple(rows))


def _impulsive(shop: Workshop) -> Result:
    found = shop.comparison("lateral")
    model = PivotingModel(shop.robot)
    rest = simulate(model, gait("lateral"), 30.0, 0.01, start="rest")
    full = simulate(shop.full, gait("lateral"), 30.0, 0.01, start="rest").steady_state()
    turned = [abs(float(t.euler[-1, 2])) for t in (found.trajectories["pivoting"], rest)]
    rows = (
        feature(
            "impulsive: the pivoting model turns in 30 s of the lateral gait", "a straight path",
            turned[0], "rad", limit=below(0.2),
        ),
        record(
            "from rest: the same", turned[1], "rad",
            "Legs that move at once over a body at rest are a yaw momentum, which nothing damps.",
        ),
        record("impulsive: pivoting over full, speed (Table 4: 1.01)",
               found.states["pivoting"].speed / found.states["full"].speed),
        record("from rest: the same", rest.steady_state().speed / full.speed),
    )  # fmt: skip
    return Result(rows=rows)


def _cycles(shop: Workshop) -> Result:
    run = shop.comparison("circular").trajectories["full"]
    state = run.steady_state()
    starts = state.after + state.period * np.arange(1, 9) / 9
    off = [abs(_speed_from(run, start, state.period) / state.speed - 1) for start in starts]
    return Result(
        rows=(
            record("speed, cycles from multiples of the period", 1000 * state.speed, "mm/s"),
            record("largest relative difference, cycles from elsewhere", max(off)),
        ),
        remarks=(
            "On a curved path the mean over a cycle depends on where in the gait it begins. "
            "rrrobot begins at multiples of the period.",
        ),
    )


def _speed_from(run: Trajectory, start: float, period: float) -> float:
    from scipy.interpolate import make_interp_spline

    integral = make_interp_spline(run.time, run.position, k=5).antiderivative()
    edges = np.arange(start, run.time[-1], period)
    means = np.diff(integral(edges), axis=0) / period
    return float(np.linalg.norm(np.diff(means, axis=0), axis=1).mean() / period)


def _leg_damping(shop: Workshop) -> Result:
    damped = FullModel(shop.robot, damping=EulerRateDamping(0.01, 0.01, 0.01, legs=0.01))
    with_it, without = (simulate(m, gait("circular"), 3.0) for m in (damped, shop.full))
    motion = float(np.abs(with_it.euler - without.euler).max())
    rates = gait("circular")(without.time).rate
    torque = float(np.abs(with_it.leg_torque - without.leg_torque - 0.01 * rates).max())
    return Result(
        rows=(
            feature("change of the body's angles", "-", motion, "rad", limit=below(1e-12)),
            feature("change of the torques less 0.01 x leg rate", "-", torque, "N m",
                    limit=below(1e-12)),
        ),
        remarks=(
            "Eq (9) damps the legs too. Legs that are prescribed move as they would, and only "
            "their motors feel it; rrrobot leaves it out unless asked.",
        ),
    )  # fmt: skip


ERRATA = (
    Item(
        key="erratum-eq5",
        title="Erratum: eq (5)",
        shows="The second row of the rolling constraint has r cos(roll) cos(yaw).",
        make=_eq_5,
    ),
    Item(
        key="erratum-eq12",
        title="Erratum: eq (12)",
        shows="The mass matrix of the yaw model has r in g12 and g13, and a mass M_m.",
        make=_eq_12,
    ),
    Item(
        key="erratum-eqs7-8",
        title="Erratum: eqs (7) and (8)",
        shows="The periods of rolling and simple pendulum with the radius of gyration.",
        make=_eqs_7_8,
    ),
    Item(
        key="erratum-eqs9-10",
        title="Erratum: eqs (9) and (10)",
        shows="Damping matrices that hold the velocities, multiplied by the velocities.",
        make=_eqs_9_10,
    ),
    Item(
        key="open-legs",
        title="Open: which way the legs point",
        shows="Leg angle pi/2 is vertical; whether up or down is not said.",
        make=_legs_up,
    ),
    Item(
        key="open-start",
        title="Open: how a gait starts",
        shows="Legs at offset + A sin(8 t) move at once; the body's first velocity is not said.",
        make=_impulsive,
    ),
    Item(
        key="open-cycles",
        title="Open: where a cycle begins",
        shows="Speeds are measured at the mean of every cycle.",
        make=_cycles,
    ),
    Item(
        key="open-leg-damping",
        title="Open: damping of the legs",
        shows="Eq (9) damps the leg joints too.",
        make=_leg_damping,
    ),
)
