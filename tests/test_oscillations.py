"""Rest, modes and periods: Table 3, and any robot's modes against two other computations."""

import functools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rrrobot as rr
from rrrobot.models.base import Model
from tests.twins import UNEQUAL, Array, library_robot, tree_robot

UP = (math.pi / 2, math.pi / 2)
PERIODS = {
    ("rolling", "roll"): (1.29251, 1.29911),
    ("rolling", "pitch"): (1.07346, 1.08145),
    ("pivoting", "roll"): (1.18804, 1.19524),
    ("pivoting", "pitch"): (0.94509, 0.95419),
}
"""Undamped, and with 0.01 N m s/rad; from I and m g d by hand [s]."""


@pytest.fixture(scope="module")
def rows() -> dict[tuple[str, str], rr.orbits.PeriodRow]:
    return {(row.model, row.axis): row for row in rr.orbits.table_3()}


def test_table_3_by_linearisation(rows: dict[tuple[str, str], rr.orbits.PeriodRow]) -> None:
    assert list(rows) == list(PERIODS)
    for key, row in rows.items():
        assert (row.linear, row.damped) == pytest.approx(PERIODS[key], abs=1e-5)


def test_table_3_by_crossings(rows: dict[tuple[str, str], rr.orbits.PeriodRow]) -> None:
    """1e-4 apart at most, and not merely copied: at 0.05 rad they are 0.03 % longer."""
    for row in rows.values():
        assert 0 < abs(row.simulated - row.linear) < 1e-4
    for row in rr.orbits.table_3(amplitude=0.05):
        assert 1e-4 < row.simulated / row.linear - 1 < 1e-3


def test_table_3_beside_the_paper(rows: dict[tuple[str, str], rr.orbits.PeriodRow]) -> None:
    """Three of the paper's four periods; its 0.96 s for pivoting pitch is not to be found, neither
    undamped nor damped."""
    for key, row in rows.items():
        if key != ("pivoting", "pitch"):
            assert round(row.linear, 2) == row.paper
    odd = rows["pivoting", "pitch"]
    assert odd.paper == 0.96
    assert odd.linear == pytest.approx(0.94509, abs=1e-5)
    assert odd.damped == pytest.approx(0.95419, abs=1e-5)
    assert round(odd.linear, 2) != odd.paper and round(odd.damped, 2) != odd.paper


@pytest.mark.parametrize(
    ("kind", "axis", "inertia"),
    [
        (rr.FullModel, "roll", 0.010212),
        (rr.FullModel, "pitch", 0.007044),
        (rr.PivotingModel, "roll", 0.008628),
        (rr.PivotingModel, "pitch", 0.005460),
        (rr.RollModel, "roll", 0.010212),
        (rr.PitchModel, "pitch", 0.007044),
    ],
)
def test_modes_of_rrrobot(kind: Any, axis: str, inertia: float) -> None:
    """s = kappa / 2 I and w^2 = m g d / I - s^2, along one axis each."""
    modes = rr.orbits.modes(kind(library_robot()), UP)
    mode = next(m for m in modes if m.axis == axis and math.isfinite(m.period))
    decay = 0.01 / (2 * inertia)
    assert mode.decay_rate == pytest.approx(decay, rel=1e-8)
    frequency = math.sqrt(0.241326 / inertia - decay**2)
    assert mode.eigenvalue.imag == pytest.approx(frequency, rel=1e-8)
    assert mode.period == pytest.approx(2 * math.pi / frequency, rel=1e-8)
    assert mode.shape == pytest.approx(np.eye(3)[("roll", "pitch", "yaw").index(axis)], abs=1e-9)


def test_yaw_drifts_or_decays() -> None:
    """Two modes with the eigenvalue zero without damping; with it, zero and -kappa / I_zz."""
    robot = library_robot()
    inertia = 0.003168  # 2 (M_s + M_l) b^2
    for kind in (rr.FullModel, rr.PivotingModel, rr.YawModel):
        free = [m for m in rr.orbits.modes(kind(robot, damping=None), UP) if m.axis == "yaw"]
        assert [m.eigenvalue for m in free] == [0, 0]
        assert [m.period for m in free] == [math.inf, math.inf]
        lossy = [m for m in rr.orbits.modes(kind(robot, damping=0.01), UP) if m.axis == "yaw"]
        rates = sorted(m.decay_rate for m in lossy)
        assert rates == pytest.approx([0.0, 0.01 / inertia], rel=1e-8)
        assert all(math.isinf(m.period) for m in lossy)


def test_modes_are_ordered_by_period() -> None:
    modes = rr.orbits.modes(rr.FullModel(library_robot(), damping=(0.01, 0.01, 0.01)), UP)
    assert [m.axis for m in modes] == ["roll", "pitch", "yaw", "yaw"]
    # Heavier damping than critical: four modes that decay, none that oscillates.
    heavy = rr.orbits.modes(rr.FullModel(library_robot(), damping=1.0), UP)
    assert len(heavy) == 6 and all(math.isinf(m.period) for m in heavy)
    assert min(m.decay_rate for m in heavy) == 0


LEGS = np.array([0.3, -0.5, 0.02, 0.8])


def state_rate(model: Model, legs: rr.drive.LegMotion, state: Array) -> Array:
    """d(pose, quasi)/dt, as the simulation has it."""
    pose, quasi, _ = model.split(state)
    solution = model.dynamics(pose, quasi, legs)
    rate = model.pose_rate(model.place(pose), pose, quasi)
    return np.concatenate([rate, model.quasi_acceleration(solution.acceleration)])


@pytest.mark.parametrize("seed", range(6))
def test_modes_of_any_robot_are_eigenvalues_of_its_equations(seed: int) -> None:
    """Those of the Jacobian in the simulation's own state, quaternion and contact point and all:
    beside zeros for the quaternion's length and the contact point they are the modes."""
    model = rr.FullModel(tree_robot(seed), damping=rr.BodyRateDamping(0.02, 0.03, 0.01))
    legs = rr.drive.LegMotion(LEGS, np.zeros(4), np.zeros(4))
    pose = rr.orbits.equilibrium(model, LEGS)
    assert np.linalg.norm(pose[:4]) == pytest.approx(1.0, abs=1e-15)
    still = np.zeros(3)
    rest = model.dynamics(pose, still, legs)
    assert np.abs(rest.acceleration).max() < 1e-9
    weight = model.robot.mass * model.robot.gravity
    assert rest.contact_force == pytest.approx([0.0, 0.0, weight], abs=1e-8)

    y, h = np.concatenate([pose, still]), 1e-4
    jacobian = np.column_stack(
        [
            (state_rate(model, legs, y + h * e) - state_rate(model, legs, y - h * e)) / (2 * h)
            for e in np.eye(9)
        ]
    )
    every = np.linalg.eigvals(jacobian)
    expected = sorted(every[np.abs(every) > 1e-3], key=lambda z: (z.imag, z.real))
    found = [
        z for m in rr.orbits.modes(model, LEGS) for z in {m.eigenvalue, m.eigenvalue.conjugate()}
    ]
    nonzero = sorted((z for z in found if abs(z) > 1e-3), key=lambda z: (z.imag, z.real))
    # One zero: rests come in families, turned about the line from the centre to the masses'.
    assert len(found) == 6 and len(nonzero) == 5
    assert np.abs(np.array(nonzero) - expected).max() < 1e-5
    assert sum(m.period < 3 for m in rr.orbits.modes(model, LEGS)) >= 2


@pytest.mark.parametrize("seed", [0, 1])
def test_a_simulation_follows_its_modes(seed: int) -> None:
    """theta(t) = rest + eps Re(shape exp(lambda t)) up to eps^2, for each oscillating mode."""
    model = rr.FullModel(tree_robot(seed), damping=rr.BodyRateDamping(0.02, 0.03, 0.01))
    rest_pose = rr.orbits.equilibrium(model, LEGS)
    rest = Rotation.from_quat(rest_pose[:4]).as_euler("ZYX")[::-1]
    oscillating = [m for m in rr.orbits.modes(model, LEGS) if math.isfinite(m.period)]
    assert len(oscillating) >= 2
    eps = 1e-5
    for mode in oscillating:
        assert np.abs(mode.shape).max() == pytest.approx(1.0)
        t = rr.simulate(
            model,
            rr.StillLegs(LEGS),
            2.0,
            0.02,
            euler=rest + eps * mode.shape.real,
            start=eps * (mode.eigenvalue * mode.shape).real,
            rtol=1e-10,
            atol=1e-14,
        )
        swing = (mode.shape * np.exp(mode.eigenvalue * t.time)[:, None]).real
        assert np.abs(t.euler - rest - eps * swing).max() < 1e-3 * eps


def test_modes_of_rrrobot_with_its_legs_apart() -> None:
    """Rest then has roll, pitch and no yaw; the period agrees with a simulated one about it."""
    model = rr.PitchModel(library_robot(UNEQUAL), damping=None)
    legs = (0.3, 1.2)
    rest = rr.orbits.equilibrium(model, legs)[0]
    assert abs(rest) > 0.1
    t = rr.simulate(model, rr.StillLegs(legs), 6.0, euler=(0, rest + 1e-3, 0), start="rest")
    measured = rr.orbits.measured_period(t, "pitch", about=rest)
    assert rr.orbits.modes(model, legs)[0].period == pytest.approx(measured, rel=1e-6)

    whole = rr.FullModel(library_robot(UNEQUAL))
    pose = rr.orbits.equilibrium(whole, legs)
    roll, pitch, yaw = Rotation.from_quat(pose[:4]).as_euler("ZYX")[::-1]
    assert abs(roll) > 0.02 and abs(pitch) > 0.1 and abs(yaw) < 0.1


def test_the_search_starts_where_it_is_told() -> None:
    """Yaw has no stiffness and stays as it was; the position does too."""
    pivoting = rr.orbits.equilibrium(
        rr.PivotingModel(library_robot()), (0.8, 0.8), euler=(0.2, 0, 1.0)
    )
    pitch = rr.paper.static_pitch(rr.RRRobotParameters(), (0.8, 0.8))
    assert pivoting[:3] == pytest.approx([1.0, pitch, 0.0], abs=0.05)
    assert pivoting[1] == pytest.approx(pitch, abs=1e-12)


def test_an_unstable_rest_grows() -> None:
    """Legs so heavy that the centre of mass is above the shell's: the upright pose is a rest, but
    its modes grow; the stable rest is elsewhere, and Table 3 does not exist."""
    robot = rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=0.3))
    model = rr.PitchModel(robot, damping=None)
    modes = rr.orbits.modes(model, UP)
    # w^2 = -k / I with k = (M_b r - 2 M_l l) g and I = 2 M_s r^2 + 2 M_l (r + l)^2.
    rate = math.sqrt((2 * 0.3 * 0.1 - 0.3 * 0.12) * 9.81 / (0.106 * 0.12**2 + 0.6 * 0.22**2))
    assert sorted(m.decay_rate for m in modes) == pytest.approx([-rate, rate], rel=1e-8)
    assert all(math.isinf(m.period) for m in modes)
    with pytest.raises(rr.ModelError, match="does not oscillate in roll and pitch: it tips over"):
        rr.orbits.table_3(robot)
    assert math.isfinite(rr.orbits.modes(model, (-1.0, -1.0))[0].period)


def ball(normal: tuple[float, float, float], drop: float) -> rr.FullModel:
    urdf = f"""<robot name="ball"><link name="shell"><inertial><origin xyz="0 0 {-drop}"/>
      <mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>
    </inertial></link></robot>"""
    robot = rr.Robot.from_urdf(urdf, shell=rr.Sphere(0.2))
    return rr.FullModel(robot, ground=rr.Plane(normal))


def test_no_rest_is_an_error() -> None:
    """A balanced ball on a slope rolls, whatever its pose; a slope that is too steep for its
    ballast likewise. A gentle slope it stands, tilted by asin(r sin(slope) / drop)."""
    slope = (math.sin(0.2), 0.0, math.cos(0.2))
    for drop in (0.0, 0.03):
        with pytest.raises(rr.ModelError, match="no rest was found"):
            rr.orbits.equilibrium(ball(slope, drop), [])
        with pytest.raises(rr.ModelError, match="no rest was found"):
            rr.orbits.modes(ball(slope, drop), [])
    tilted = rr.orbits.equilibrium(ball(slope, 0.1), [])
    turn = Rotation.from_quat(tilted[:4]).magnitude()
    assert turn == pytest.approx(math.asin(0.2 * math.sin(0.2) / 0.1), abs=1e-10)


def test_a_balanced_ball_on_level_ground_rests_anywhere() -> None:
    model = ball((0.0, 0.0, 1.0), 0.0)
    assert rr.orbits.equilibrium(model, []).tolist() == [0, 0, 0, 1, 0, 0]
    assert [m.eigenvalue for m in rr.orbits.modes(model, [])] == [0] * 6


@functools.cache
def still() -> rr.Trajectory:
    return rr.simulate(rr.PitchModel(library_robot()), rr.StillLegs(UP), 0.02)


def swinging(angle: Array, time: Array) -> rr.Trajectory:
    """A trajectory whose pitch is what the test wants."""
    return replace(still(), time=time, euler=np.outer(angle, [0.0, 1.0, 0.0]))


def test_measured_period() -> None:
    time = np.linspace(0.0, 2.85, 286)
    for phase in (0.0, 0.3, 2.0):
        sine = np.sin(2 * np.pi * time / 0.7 + phase)
        t = swinging(sine, time)
        assert rr.orbits.measured_period(t, "pitch") == pytest.approx(0.7, rel=1e-7)
        # Up and down crossings of another value are unequally apart; whole periods are not.
        assert rr.orbits.measured_period(t, "pitch", about=0.5) == pytest.approx(0.7, rel=1e-6)
        t = swinging(0.4 + np.exp(-0.5 * time) * sine, time)
        assert rr.orbits.measured_period(t, "pitch", about=0.4) == pytest.approx(0.7, rel=1e-6)


@pytest.mark.parametrize(
    ("axis", "about", "message"),
    [
        ("pitch", 2.0, "crosses 2 rad 0 times"),
        ("roll", 0.0, "roll crosses 0 rad 0 times"),
        ("tilt", 0.0, "axis is 'tilt'"),
        ("pitch", np.nan, "about is nan"),
    ],
)
def test_no_period_to_measure(axis: str, about: float, message: str) -> None:
    time = np.linspace(0.0, 2.0, 201)
    with pytest.raises(rr.ParameterError, match=message):
        rr.orbits.measured_period(swinging(np.sin(6 * time), time), axis, about=about)
    with pytest.raises(rr.ParameterError, match="crosses 0 rad 2 times"):
        rr.orbits.measured_period(swinging(np.sin(4 * time + 0.1), time), "pitch")


def test_bad_input() -> None:
    model = rr.FullModel(library_robot())
    for function in (rr.orbits.modes, rr.orbits.equilibrium):
        with pytest.raises(rr.ParameterError, match="leg_angle has shape"):
            function(model, (1.0, 2.0, 3.0))
        with pytest.raises(rr.ParameterError, match="leg_angle is"):
            function(model, (1.0, np.nan))
        with pytest.raises(rr.ParameterError, match="euler has shape"):
            function(model, UP, euler=(0.0, 0.0))
    with pytest.raises(rr.ParameterError, match="amplitude is"):
        rr.orbits.table_3(amplitude=0.0)
    ellipsoid = rr.Robot.from_urdf(rr.urdf_path(), shell=rr.Ellipsoid((0.12, 0.12, 0.13)))
    with pytest.raises(rr.ModelError, match="spherical shell"):
        rr.orbits.table_3(ellipsoid)
