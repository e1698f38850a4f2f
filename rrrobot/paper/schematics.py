"""Figs 1, 3-5, 8-10: the schematic figures, drawn from the models, with what they say measured."""

from __future__ import annotations

import numpy as np

from rrrobot.contact.surfaces import Sphere
from rrrobot.drive.gaits import StillLegs
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.single_axis import PitchModel, YawModel
from rrrobot.orbits.oscillations import measured_period, modes
from rrrobot.paper import figures as paper
from rrrobot.paper.closed_forms import (
    rolling_pendulum_period,
    simple_pendulum_period,
    yaw_mass_matrix,
)
from rrrobot.paper.item import Item, Result, Row, about, below, feature, number, record
from rrrobot.paper.schematic import MassPoint, mass_points
from rrrobot.paper.workshop import Workshop
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.robot.robot import Robot
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory

_WHEEL, _HEIGHT = 0.12, 0.06
"""Radius of the wheel of Figs 4 and 5, and height of its mass over the contact [m]."""
_STARTS = (0.05, 0.8)
"""Angles that its swings begin at [rad]."""


def _fig_1(shop: Workshop) -> Result:
    mass = sum(point.mass for point in _points(shop.robot))
    row = record("mass of what is drawn", mass, "kg", "The sum of Table 2's.")
    return Result(rows=(row,), figures={"fig1": paper.fig_1(shop.robot)})


def _fig_3(shop: Workshop) -> Result:
    run = shop.comparison("circular").trajectories["pivoting"]
    slip = float(run.slip.max())
    row = record("slip of the recombined motion", slip, "m/s", "It rolls by construction.")
    return Result(rows=(row,), figures={"fig3": paper.fig_3(shop.robot)})


def _fig_4(shop: Workshop) -> Result:
    wheel = _point_mass(_HEIGHT)
    period = rolling_pendulum_period(_WHEEL, _HEIGHT)
    swings = _swings(PitchModel(wheel, damping=None), period)
    return Result(
        rows=_pendulum_rows(swings, period, "eq (7)"),
        figures={"fig4": paper.fig_4(swings, period)},
        remarks=(_ONE_MASS.format("the contact"),),
    )


def _fig_5(shop: Workshop) -> Result:
    pendulum = _point_mass(_WHEEL - _HEIGHT)
    period = simple_pendulum_period(_HEIGHT)
    swings = _swings(PivotingModel(pendulum, damping=None), period)
    return Result(
        rows=_pendulum_rows(swings, period, "eq (8)"),
        figures={"fig5": paper.fig_5(swings, period)},
        remarks=(_ONE_MASS.format("the pivot"),),
    )


def _fig_8(shop: Workshop) -> Result:
    return Result(rows=(_period(shop, "roll", 1.29),), figures={"fig8": paper.fig_8(shop.robot)})


def _fig_9(shop: Workshop) -> Result:
    return Result(rows=(_period(shop, "pitch", 1.07),), figures={"fig9": paper.fig_9(shop.robot)})


def _fig_10(shop: Workshop) -> Result:
    model = YawModel(shop.robot)
    rng = np.random.default_rng(12)
    worst = 0.0
    for legs in rng.uniform(-np.pi, np.pi, (50, 2)):
        ours = model.mass_matrix(model.make_pose(np.zeros(3), np.zeros(2)), legs)
        worst = max(worst, float(np.abs(ours - yaw_mass_matrix(RRRobotParameters(), legs)).max()))
    row = feature(
        "Pinocchio's mass matrix less eq (12), 50 random leg angles", "eq (12)", worst, "kg m^2",
        limit=below(1e-13),
    )  # fmt: skip
    return Result(rows=(row,), figures={"fig10": paper.fig_10(shop.robot)})


_ONE_MASS = (
    "One point mass on a massless wheel, as the equation has it: rho is taken from {}. RRRobot, a "
    "composite body, has T = 2 pi sqrt(I / (m g d)) instead: see Table 3."
)


def _points(robot: Robot) -> list[MassPoint]:
    q = np.zeros(robot.model.nq)
    q[6] = 1.0
    return mass_points(robot, q)


def _point_mass(height: float) -> Robot:
    """A massless wheel with one mass, a short rod across it, at a height over its contact."""
    urdf = f"""<robot name="wheel"><link name="shell"><inertial>
      <origin xyz="0 0 {height - _WHEEL!r}"/><mass value="0.3"/>
      <inertia ixx="1e-4" iyy="0" izz="1e-4" ixy="0" ixz="0" iyz="0"/>
    </inertial></link></robot>"""
    return Robot.from_urdf(urdf, shell=Sphere(_WHEEL))


def _swings(model: Model, period: float) -> list[Trajectory]:
    span = 3.2 * period
    return [
        simulate(model, StillLegs([]), span, span / 800, euler=(0, start, 0), start="rest")
        for start in _STARTS
    ]


def _pendulum_rows(swings: list[Trajectory], period: float, equation: str) -> tuple[Row, ...]:
    small = swings[0]
    found = [measured_period(swing, "pitch") for swing in swings]
    cosine = small.euler[0, 1] * np.cos(2 * np.pi * small.time / found[0])
    off = float(np.abs(small.euler[:, 1] - cosine).max() / small.euler[0, 1])
    return (
        feature(
            f"period of a swing from {_STARTS[0]} rad over {equation}", "for small amplitude",
            found[0] / period, limit=about(1, 0.002),
        ),
        feature(
            "its largest deviation from a cosine, of its amplitude", "harmonic for small amplitude",
            off, limit=below(0.002),
        ),
        record(f"period from {_STARTS[1]} rad over {equation}", found[1] / period),
    )  # fmt: skip


def _period(shop: Workshop, axis: str, printed: float) -> Row:
    model = FullModel(shop.robot, damping=None)
    period = next(m.period for m in modes(model, np.full(2, np.pi / 2)) if m.axis == axis)
    return number(f"period of small {axis} oscillations", printed, period, "s", within=0.0051)


SCHEMATICS = (
    Item(
        key="fig1",
        title="Fig 1: RRRobot",
        shows="A massless sphere with two massless legs and five point masses.",
        make=_fig_1,
    ),
    Item(
        key="fig3",
        title="Fig 3: the pivoting model",
        shows="The robot pivoted at its centre, and a sphere that rolls with the same rotation.",
        make=_fig_3,
    ),
    Item(
        key="fig4",
        title="Fig 4: a rolling wheel with an eccentric mass",
        shows="It performs harmonic oscillations of small amplitude, with the period of eq (7).",
        make=_fig_4,
    ),
    Item(
        key="fig5",
        title="Fig 5: the simple pendulum",
        shows="It performs harmonic oscillations of small amplitude, with the period of eq (8).",
        make=_fig_5,
    ),
    Item(
        key="fig8", title="Fig 8: the roll freedom", shows="The robot rolls sideways.", make=_fig_8
    ),
    Item(key="fig9", title="Fig 9: the pitch freedom", shows="The robot pitches.", make=_fig_9),
    Item(
        key="fig10",
        title="Fig 10: the yaw model",
        shows="The robot pivoted at its centre, free to yaw; its mass matrix is eq (12).",
        make=_fig_10,
    ),
)
