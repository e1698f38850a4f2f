"""Optimised gaits: forces against the KKT model, known optima, limits, the front, bad input."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.drive.gaits import FourierGait, GaitBatch, SinusoidalGait
from rrrobot.drive.tables import gait_from_dict
from rrrobot.figures.fronts import pareto
from rrrobot.models.base import Model
from rrrobot.momentum.batch import lower, steady_states
from rrrobot.momentum.coefficients import coefficients
from rrrobot.momentum.forces import bodies
from rrrobot.momentum.loads import TORQUE, loads, n_signals
from rrrobot.rotations import rotation_from_euler
from rrrobot.studies.optimisation.goals import (
    FastestTravel,
    LeastEffort,
    TargetMotion,
    TightestTurn,
    as_goal,
)
from rrrobot.studies.optimisation.lanes import engine_of
from rrrobot.studies.optimisation.pareto import ParetoFront, pareto_front
from rrrobot.studies.optimisation.result import OptimisedGait, confirm
from rrrobot.studies.optimisation.run import optimise
from rrrobot.studies.optimisation.space import Space
from rrrobot.studies.optimisation.table import GaitLimits, Joints, Table, columns
from rrrobot.studies.optimisation.task import Task
from tests.random_robot import random_robot

SETTLE = 15.0
"""Enough for RRRobot's oscillations to fall below a thousandth."""


@pytest.fixture(scope="module")
def model() -> rr.FullModel:
    return rr.FullModel(rr.Robot.from_parameters())


@pytest.fixture(scope="module")
def target(model: rr.FullModel) -> OptimisedGait:
    goal = TargetMotion(speed=0.006, curvature=-1.5)
    return optimise(model, goal, budget=1500, settle_time=20.0, seed=4)


@pytest.fixture(scope="module")
def front(model: rr.FullModel) -> ParetoFront:
    return pareto_front(
        model, n_points=4, budget=1200, settle_time=SETTLE, tied=True, offset=(1.2, 1.9)
    )


def population(n: int, harmonics: int = 1, legs: int = 2, seed: int = 0) -> GaitBatch:
    rng = np.random.default_rng(seed)
    size = rng.uniform(0, 0.4, (n, harmonics, legs)) / np.arange(1, harmonics + 1)[:, None]
    phase = rng.uniform(0, 2 * np.pi, size.shape)
    offset = rng.uniform(0, np.pi, (n, legs))
    return GaitBatch(
        offset, 0 * offset, size * np.cos(phase), size * np.sin(phase),
        rng.uniform(3, 12, n),
    )  # fmt: skip


# The engine with forces.


@pytest.mark.parametrize(
    "make",
    [
        lambda: rr.FullModel(random_robot(3)),
        lambda: rr.FullModel(random_robot(5, 7), damping=rr.BodyRateDamping(0.1, 0.2, 0.3)),
        lambda: rr.FullModel(rr.Robot.from_parameters(), damping=(0.01, 0.02, 0.03)),
        lambda: rr.PivotingModel(rr.Robot.from_parameters()),
        lambda: rr.RollModel(random_robot(4, 6, shell_center=(0, 0, 0)), damping=0.3),
        lambda: rr.PitchModel(rr.Robot.from_parameters()),
        lambda: rr.YawModel(random_robot(4, 6, shell_center=(0, 0, 0)), damping=0.3),
    ],
    ids=["12 joints", "7 joints, body damping", "RRRobot", "pivoting", "roll", "pitch", "yaw"],
)
def test_forces_and_torques_equal_the_kkt_systems(make) -> None:
    """At random states, by recursive Newton-Euler here and by Pinocchio and a KKT solve there."""
    model: Model = make()
    robot, setting = model.robot, lower(model)
    rng = np.random.default_rng(1)
    n, sine = robot.n_legs, rng.normal(size=(2, robot.n_legs))
    gait = FourierGait(
        offset=rng.normal(size=n), cosine=0.5 * sine, sine=sine, angular_frequency=3.0
    )
    free = np.isin(np.arange(3), model.axes)
    euler, rates = 0.5 * rng.normal(size=3) * free, rng.normal(size=3) * free
    pose = model.make_pose(euler, np.zeros(2))
    quasi = rates if model.name == "full" else model.quasi_from_euler_rates(pose, rates)
    place, motion = model.place(pose), gait(0.7)
    expected = model.dynamics(place, quasi, motion)
    c = coefficients(robot, motion.angle[None], motion.rate[None])[0]
    signals, up = np.empty(n_signals(n)), place.rotation[2].copy()
    turning = np.concatenate((up, model.body_velocity(place, quasi)))
    loads(setting.tree, turning, c, np.array(motion),
          setting.parameters, setting.axis, bodies(n + 1), signals)  # fmt: skip
    force = place.rotation.T @ expected.contact_force
    assert signals[0] == pytest.approx(force @ up, rel=1e-10, abs=1e-12)
    np.testing.assert_allclose(signals[1:4], force - (force @ up) * up, atol=1e-9)
    np.testing.assert_allclose(signals[TORQUE : TORQUE + n], expected.leg_torque, atol=1e-9)


@pytest.mark.parametrize("harmonics", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_results_equal_those_of_a_kkt_simulation(harmonics: int) -> None:
    damping = rr.EulerRateDamping(0.01, 0.01, 0.01, legs=0.003)
    model = rr.FullModel(rr.Robot.from_parameters(), damping=damping)
    gaits = population(1, harmonics, seed=7)
    found = engine_of(model, 12.0)(gaits)
    gait = FourierGait(offset=gaits.offset[0], cosine=gaits.cosine[0], sine=gaits.sine[0],
                       angular_frequency=float(gaits.angular_frequency[0]))  # fmt: skip
    _, state, measured = confirm(model, gait, 12.0)
    assert found.speed[0] == pytest.approx(state.speed, rel=1e-5)
    assert found.yaw_rate[0] == pytest.approx(state.yaw_rate, rel=1e-4)
    for name in ("pitch", "tilt", "normal_force", "friction", "rms_torque", "peak_torque", "power",
                 "clearance"):  # fmt: skip
        a, b = getattr(found, name)[0], getattr(measured, name)[0]
        assert a == pytest.approx(b, rel=5e-3), name
    for name in Joints._fields:
        a, b = getattr(found.joints, name)[0], getattr(measured.joints, name)[0]
        assert a == pytest.approx(b, rel=5e-3), name


def test_a_gait_is_not_changed_by_its_neighbours(model: rr.FullModel) -> None:
    engine, gaits = engine_of(model, 3.0), population(20)
    together = engine(gaits)
    for i in (0, 7, 19):
        alone = engine(gaits.rows([i]))
        np.testing.assert_array_equal(alone.values[0], together.values[i])


def test_a_gait_that_tips_over_has_a_status_and_spares_the_others(model: rr.FullModel) -> None:
    gaits = population(5)
    gaits.offset[2], gaits.angular_frequency[2] = np.pi / 2, 6.44
    gaits.sine[2], gaits.cosine[2] = 2.0, 0.0
    found = engine_of(model, 5.0)(gaits).values
    status = found[:, columns().index("status")]
    assert status[2] != 0 and not np.delete(status, 2).any()
    assert np.isnan(found[2, 0]) and np.all(np.isfinite(np.delete(found, 2, axis=0)))


# Optima.


@pytest.mark.slow
def test_the_fastest_lateral_gait_is_that_of_a_brute_force_grid(model: rr.FullModel) -> None:
    kept = {"amplitude": 0.3, "angular_frequency": 8.0, "tied": True}
    best = optimise(model, "fastest", budget=1200, settle_time=25.0, **kept)
    offset, phase = np.meshgrid(
        np.linspace(0, np.pi, 21), np.linspace(0, 2 * np.pi, 24, endpoint=False)
    )
    n = offset.size
    gaits = GaitBatch.sinusoidal(
        np.column_stack((offset.ravel(),) * 2),
        np.full((n, 2), 0.3),
        np.column_stack((np.zeros(n), phase.ravel())),
        np.full(n, 8.0),
    )
    grid = steady_states(lower(model), gaits, cycles=34, counted=3, steps_per_cycle=10)
    top = grid[:, 0].max()
    assert top <= best.value < 1.01 * top
    assert best.value == pytest.approx(0.0097, abs=5e-5)
    np.testing.assert_allclose(best.gait.offset, np.pi / 2, atol=1e-3)
    assert best.met and best.discrepancy < 5e-3 and best.lift_off_time is None
    assert best.gait.offset[0] == best.gait.offset[1]
    assert best.gait.amplitude.tolist() == pytest.approx([0.3, 0.3])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("goal", "column", "sign"),
    [
        (TightestTurn(min_speed=0.002), lambda t: np.abs(t.curvature), 1),
        (LeastEffort(cost="work", min_speed=0.002), lambda t: t.power / t.speed, -1),
    ],
    ids=["tightest", "efficient"],
)
def test_no_other_gait_is_better(model: rr.FullModel, goal, column, sign: int) -> None:
    """Against random gaits of the box that have the speed and are within the limits."""
    box = {"offset": (0.5, 2.6), "amplitude": (0.1, 0.4), "angular_frequency": (5.0, 10.0)}
    best = optimise(model, goal, budget=1500, settle_time=SETTLE, **box)
    assert best.met and best.steady_state.speed >= 0.002
    space = Space(2, phase_difference=(0, 2 * np.pi), **box)
    gaits = space.population(np.random.default_rng(99).random((600, space.n)))
    table = engine_of(model, SETTLE)(gaits)
    slack = Task.of(model, as_goal(goal), GaitLimits()).told(table)
    valid = np.all([s >= 0 for s, _ in slack.values()], axis=0) & (table.speed >= 0.002)
    assert valid.sum() > 100
    assert best.value == pytest.approx(float(column(_one(best))[0]), rel=1e-9)
    assert sign * best.value > (sign * column(table)[valid]).max()


def _one(found: OptimisedGait) -> Table:
    row = np.array([[found.measured.get(name, 0.0) for name in columns()]])
    return Table(row, Joints(*[np.zeros((1, 0))] * 3, np.zeros(1), np.zeros((1, 0))))


def test_a_target_is_met(target: OptimisedGait) -> None:
    state = target.steady_state
    assert target.met and not target.shortfalls
    assert state.speed == pytest.approx(0.006, rel=1e-3)
    assert state.curvature == pytest.approx(-1.5, rel=1e-3)
    assert target.evaluations <= 1500
    assert target.value == pytest.approx(target.measured["rms_torque"])


def test_the_gait_alone_does_what_the_result_says(
    model: rr.FullModel, target: OptimisedGait
) -> None:
    gait = gait_from_dict(json.loads(json.dumps(target.to_dict()["gait"])))
    duration = 52 * 2 * np.pi / gait.angular_frequency.max()  # type: ignore[attr-defined]
    t = rr.simulate(model, gait, duration, 0.02, method="momentum")
    state = t.steady_state()
    assert state.speed == pytest.approx(0.006, rel=1e-3)
    assert state.curvature == pytest.approx(-1.5, rel=1e-3)


def test_the_same_seed_gives_the_same_bits(model: rr.FullModel) -> None:
    def once(seed: int) -> OptimisedGait:
        return optimise(
            model, "fastest", budget=150, settle_time=3.0, angular_frequency=8.0, seed=seed
        )

    first, again, other = once(3), once(3), once(5)
    assert first.to_dict() == again.to_dict()
    np.testing.assert_array_equal(first.history, again.history)
    assert other.gait.to_dict() != first.gait.to_dict()


@pytest.mark.slow
def test_harmonics_give_a_fourier_gait_within_the_swing(model: rr.FullModel) -> None:
    best = optimise(model, "fastest", budget=700, settle_time=SETTLE, harmonics=2,
                    angular_frequency=(6.0, 8.0), amplitude=(0.0, 0.3))  # fmt: skip
    assert isinstance(best.gait, FourierGait) and best.gait.cosine.shape == (2, 2)
    angle = best.gait(np.linspace(0, best.gait.period, 1000)).angle
    assert np.abs(angle - best.gait.offset).max() < 0.3 * (1 + 3e-3)
    again = gait_from_dict(best.to_dict()["gait"])
    np.testing.assert_array_equal(again(0.3).angle, best.gait(0.3).angle)


def test_numbers_that_are_kept_are_kept(model: rr.FullModel) -> None:
    best = optimise(
        model, "fastest", offset=[[1.0, 1.0], [1.2, 1.2]], amplitude=0.2, angular_frequency=9.0,
        phase_difference=0.5, settle_time=5.0,
    )  # fmt: skip
    assert best.evaluations == 1
    assert best.gait.offset.tolist() == [1.0, 1.2]
    assert best.gait.phase.tolist() == [0.0, 0.5]


def test_any_robot_can_be_optimised() -> None:
    """A tree with prismatic, revolute and continuous joints."""
    model = rr.FullModel(random_robot(2, 3), damping=0.3)
    best = optimise(model, "fastest", budget=300, settle_time=10.0, offset=(-0.1, 0.1),
                    amplitude=(0.0, 0.1), angular_frequency=(3.0, 5.0),
                    limits=GaitLimits(min_clearance=-1.0))  # fmt: skip
    assert best.gait.n_legs == 3 and best.value > 0 and best.discrepancy < 0.02


@pytest.mark.slow
def test_the_pivoting_model_can_be_optimised() -> None:
    model = rr.PivotingModel(rr.Robot.from_parameters())
    best = optimise(model, "fastest", amplitude=0.3, angular_frequency=8.0, offset=np.pi / 2,
                    budget=200, settle_time=SETTLE)  # fmt: skip
    assert best.met and best.value == pytest.approx(0.00978, abs=1e-4)


# Limits.


@pytest.mark.slow
def test_limits_hold_in_a_kkt_simulation(model: rr.FullModel) -> None:
    limits = GaitLimits(
        friction=0.05, max_curvature=0.5, max_torque=0.06, max_leg_acceleration=60.0, max_tilt=0.4
    )
    best = optimise(model, "fastest", limits=limits, budget=2000, settle_time=SETTLE)
    assert best.met
    t = rr.simulate(model, best.gait, 24.0, 0.01)
    late = t.time > 18.0
    assert t.normal_force.min() > 0.05 * 5.1
    assert 0.04 < t.required_friction[late].max() < 0.05
    assert np.abs(t.leg_torque[late]).max() < 0.06
    assert t.tilt[late].max() < 0.4
    assert abs(t.steady_state(after=18.0).curvature) < 0.5
    motion = best.gait(np.linspace(0, 3, 2000))
    assert np.abs(motion.acceleration).max() < 60.0
    assert best.value > 0.005


@pytest.mark.slow
def test_the_tilt_counts_roll_and_pitch_together(model: rr.FullModel) -> None:
    """A gait that rolls: its pitch is small, its tilt is not, and a limit on it is told."""
    gaits = GaitBatch.sinusoidal(np.array([[1.0, 2.2]]), np.full((1, 2), 0.4),
                                 np.array([[0.0, 1.0]]), np.array([6.0]))  # fmt: skip
    table = engine_of(model, SETTLE)(gaits)
    t, _, row = confirm(model, gaits.gait(0), SETTLE)
    late = t.euler[-48:]
    up = np.array([rotation_from_euler(euler)[2, 2] for euler in late])
    assert row.tilt[0] == pytest.approx(np.arccos(up).max(), rel=1e-4)
    assert table.tilt[0] == pytest.approx(row.tilt[0], rel=3e-3)
    assert np.abs(late[:, 1]).max() < table.tilt[0] - 0.01
    kept = {"offset": [[1.0] * 2, [2.2] * 2], "amplitude": 0.4, "phase_difference": 1.0}
    for most, met in ((1.05, True), (0.95, False)):
        limits = GaitLimits(max_tilt=most * float(table.tilt[0]))
        found = optimise(model, "fastest", **kept, angular_frequency=6.0, limits=limits,
                         settle_time=SETTLE)  # fmt: skip
        assert any("tilt above" in s for s in found.shortfalls) != met


@pytest.mark.parametrize("ground", [rr.Plane((0.0, 0.1, 1.0)), rr.Boulder(0.8)])
def test_the_tilt_is_from_the_ground_s_normal(ground) -> None:
    model = rr.FullModel(rr.Robot.from_parameters(), ground=ground)
    gaits = GaitBatch.sinusoidal(np.full((1, 2), np.pi / 2), np.full((1, 2), 0.2),
                                 np.array([[0.0, 1.0]]), np.array([6.0]))  # fmt: skip
    table = engine_of(model, 2.0)(gaits)
    period = 2 * np.pi / 6.0
    end = (np.ceil(2.0 / period) + 4) * period
    t = rr.simulate(model, gaits.gait(0), end, 0.004, method="momentum")
    last = t.time > end - period
    down = [rotation_from_euler(e).T @ n for e, n in zip(t.euler, t.ground_normal, strict=True)]
    tilt = np.arccos(np.array(down)[last, 2])
    np.testing.assert_allclose(t.tilt[last], tilt, atol=1e-7)
    assert table.tilt[0] == pytest.approx(tilt.max(), rel=2e-3)


def _mirrored(axis: str, limits: str = 'lower="-1.2" upper="1.9"') -> rr.Robot:
    """Two legs that swing up and down beside the base; the left one's axis as given."""

    def leg(name: str, side: int, axis: str, limits: str) -> str:
        return (
            f'<link name="{name}_l"><inertial><origin xyz="0.01 {0.1 * side} 0"/>'
            '<mass value="0.06"/><inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" '
            f'izz="1e-5"/></inertial></link><joint name="{name}" type="revolute"><parent '
            f'link="body"/><child link="{name}_l"/><origin xyz="0.02 {0.1 * side} 0.05"/>'
            f'<axis xyz="{axis}"/><limit {limits} effort="2" velocity="9"/></joint>'
        )

    right = 'lower="-1.9" upper="1.2"'
    text = (
        '<robot name="r"><link name="body"><inertial><origin xyz="0 0 -0.08"/><mass value="0.4"/>'
        '<inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial></link>'
        f"{leg('left', 1, axis, limits)}"
        f"{leg('right', -1, '1 -1 0', right)}</robot>"
    )
    return rr.Robot.from_urdf(text, shell=rr.Sphere(0.12), legs=("left", "right"))


@pytest.mark.parametrize(
    ("axis", "limits", "sign"),
    [("1 1 0", 'lower="-1.2" upper="1.9"', -1), ("-1 -1 0", 'lower="-1.9" upper="1.2"', 1)],
)
def test_tied_legs_mirror_each_other_as_their_axes_do(axis, limits, sign) -> None:
    """Axes written alike, or each its own way: the body only pitches."""
    robot = _mirrored(axis, limits)
    model = rr.FullModel(robot, damping=rr.BodyRateDamping(0.01, 0.01, 0.01))
    best = optimise(model, "fastest", tied=True, phase_difference=0.0, budget=100, settle_time=4.0,
                    angular_frequency=(6.0, 9.0))  # fmt: skip
    (left, right) = best.gait(np.linspace(0.0, 1.0, 9)).angle.T
    np.testing.assert_allclose(right, sign * left, rtol=0, atol=1e-12)
    assert np.ptp(left) > 0.05 and abs(left.mean()) > 1e-3
    state = best.steady_state
    assert abs(state.velocity[1]) < 1e-9 and abs(state.yaw_rate) < 1e-8
    roll, pitch, yaw = state.amplitude
    assert pitch > 0.02 and max(roll, yaw) < 1e-9


def test_legs_that_do_not_mirror_cannot_be_tied() -> None:
    with pytest.raises(rr.ParameterError, match=r"no two legs of .* mirror each other"):
        optimise(rr.FullModel(random_robot(2, 3), damping=0.3), "fastest", tied=True)


def test_each_joint_has_its_own_limits() -> None:
    robot = _mirrored("1 1 0")
    assert GaitLimits().ends(robot).upper.tolist() == [1.9, 1.2]
    limits = GaitLimits(max_torque=(0.05, 9.0), max_leg_rate=np.inf, leg_range=((-1, 1), (-2, 2)))
    ends = limits.ends(robot)
    assert ends.effort.tolist() == [0.05, 9.0] and np.isinf(ends.velocity).all()
    assert ends.lower.tolist() == [-1.0, -2.0]
    again = GaitLimits.from_dict(json.loads(json.dumps(limits.to_dict(), allow_nan=False)))
    assert again == limits
    model = rr.FullModel(robot, damping=rr.BodyRateDamping(0.01, 0.01, 0.01))
    kept = {"offset": [[0.4] * 2, [1.0] * 2], "amplitude": 0.3, "angular_frequency": 7.0,
            "phase_difference": 1.0, "settle_time": 3.0}  # fmt: skip
    with pytest.warns(rr.LimitWarning):
        (fast, up) = optimise(model, "fastest", **kept, limits=GaitLimits(
            max_leg_rate=(9.0, 2.0), max_variation=9.0)).shortfalls  # fmt: skip
    assert fast.startswith("rate of right above 2 ") and up.startswith("right goes above 1.2 ")
    with pytest.warns(rr.LimitWarning):
        (told,) = optimise(model, "fastest", **kept, limits=GaitLimits(
            max_torque=(1e-3, 9.0), leg_range=(-9, 9), max_variation=9.0)).shortfalls  # fmt: skip
    assert told.startswith("motor torque of left above 0.001 N m")


def test_an_unreachable_target_gives_the_nearest_and_says_so(model: rr.FullModel) -> None:
    goal = TargetMotion(speed=0.05, curvature=0.0)
    found = optimise(model, goal, budget=800, settle_time=SETTLE, tied=True, offset=np.pi / 2)
    assert not found.met
    (text,) = found.shortfalls
    assert "instead of 0.05 and 0" in text and f"{found.steady_state.speed:.6g}" in text
    assert "NOT MET" in repr(found)
    # The nearest is the fastest straight gait.
    assert found.steady_state.speed == pytest.approx(0.0269, rel=2e-2)
    assert abs(found.steady_state.curvature) < 0.01


def test_limits_that_no_gait_meets_are_named(model: rr.FullModel) -> None:
    limits = GaitLimits(max_torque=1e-4)
    found = optimise(model, "fastest", limits=limits, budget=150, settle_time=3.0, offset=1.0)
    assert not found.met and any(
        "motor torque of leg_1 above 0.0001" in s for s in found.shortfalls
    )
    assert np.isnan(found.history[:, 1]).all()
    with pytest.raises(rr.GaitError, match="no front"):
        pareto_front(model, limits=limits, budget=300, settle_time=3.0, offset=1.0)


def test_gaits_that_all_tip_over_are_an_error() -> None:
    model = rr.FullModel(rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=1.0)))
    with pytest.raises(rr.GaitError, match="90 degrees"):
        optimise(model, "fastest", offset=np.pi / 2, amplitude=(2.8, 3.0),
                 angular_frequency=(5.0, 12.0), phase_difference=0.0, budget=100,
                 settle_time=5.0)  # fmt: skip


# The front.


def test_the_front_is_ordered_and_nothing_dominates_it(front: ParetoFront) -> None:
    assert 3 <= len(front) <= 4
    assert np.all(np.diff(front.speed) > 0) and np.all(np.diff(front.cost) > 0)
    speed, cost = front.tried.T
    for v, c in zip(front.speed, front.cost, strict=True):
        assert not np.any((speed >= v) & (cost < c) & (speed > 0))
        assert not np.any((speed > v) & (cost <= c))
    assert front.evaluations <= 1200 and front.discrepancy < 0.01


def test_a_gait_of_the_front_costs_what_it_says(model: rr.FullModel, front: ParetoFront) -> None:
    i = len(front) // 2
    _, state, measured = confirm(model, front.gaits[i], SETTLE)
    assert state.speed == pytest.approx(front.speed[i], rel=1e-4)
    assert measured.rms_torque[0] == pytest.approx(front.cost[i], rel=1e-3)


def test_the_fastest_of_the_front_is_the_fastest_of_all(front: ParetoFront) -> None:
    assert front.speed[-1] == pytest.approx(0.0269, rel=5e-3)
    assert json.loads(json.dumps(front.to_dict(), allow_nan=False))["cost"] == "torque"
    assert "gaits" in repr(front)


def test_the_figure_shows_the_front_with_units(front: ParetoFront) -> None:
    figure = pareto(front)
    top, *below = figure.axes
    assert top.get_ylabel() == "rms motor torque [mN m]"
    assert below[-1].get_xlabel() == "speed [mm/s]"
    (line,) = [artist for artist in top.get_lines() if artist.get_label() == "Pareto front"]
    np.testing.assert_allclose(line.get_xdata(), 1000 * front.speed)
    assert all("[" in ax.get_ylabel() for ax in figure.axes)


# Input.


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"offset": (2.0, 1.0)}, "offset has the bounds 2 and 1 rad"),
        ({"offset": (0.0, np.nan)}, "upper bound of offset is nan"),
        ({"offset": "up"}, "offset is 'up'"),
        ({"offset": (1.0, 2.0, 3.0)}, "offset has shape"),
        ({"amplitude": (-0.1, 0.3)}, "lower bound of amplitude is -0.1 rad"),
        ({"angular_frequency": (0.0, 8.0)}, "lower bound of angular_frequency"),
        ({"angular_frequency": (8.0, 1e6)}, "the most is 200"),
        ({"angular_frequency": [(1, 2), (3, 4)]}, "angular_frequency has shape"),
        ({"phase_difference": [(0, 1), (0, 1)]}, "phase_difference has shape"),
        ({"harmonics": 0}, "harmonics is 0"),
        ({"harmonics": 1.5}, "harmonics is 1.5"),
        ({"budget": 10}, "budget is 10"),
        ({"budget": 1e4}, "budget is 10000.0"),
        ({"seed": -1}, "seed is -1"),
        ({"settle_time": 0.0}, "settle_time is 0.0 s"),
        ({"limits": {"friction": 0.3}}, "give GaitLimits"),
        ({"goal": "quickest"}, "goal is 'quickest': it must be one of fastest, tightest"),
        ({"goal": "target"}, "needs numbers"),
    ],
)
def test_bad_input_is_told(model: rr.FullModel, options: dict, text: str) -> None:
    goal = options.pop("goal", "fastest")
    with pytest.raises(rr.ParameterError) as caught:
        optimise(model, goal, **options)
    assert text in str(caught.value)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: TightestTurn(min_speed=0.0), "min_speed"),
        (lambda: LeastEffort(cost="money"), "cost is 'money'"),
        (lambda: TargetMotion(speed=0.01), "curvature"),
        (lambda: TargetMotion(speed=0.01, curvature=1.0, yaw_rate=1.0), "one of the two"),
        (lambda: TargetMotion(speed=-0.01, curvature=1.0), "speed is -0.01"),
        (lambda: GaitLimits(friction=-0.1), "friction is -0.1"),
        (lambda: GaitLimits(max_tilt=None), "max_tilt"),  # type: ignore[arg-type]
        (lambda: GaitLimits(min_normal_force=-1.0), "min_normal_force"),
        (lambda: GaitLimits(max_torque=0.0), "max_torque is 0.0: it must be a number above 0"),
        (lambda: GaitLimits(max_torque="much"), "max_torque is 'much'"),
        (lambda: GaitLimits(max_leg_rate=(1.0, -2.0)), "max_leg_rate is (1.0, -2.0)"),
        (lambda: GaitLimits(leg_range=(1.0, -1.0)), "leg_range is (1.0, -1.0)"),
        (lambda: GaitLimits(leg_range=(1.0, 2.0, 3.0)), "(low, high), the lower one first"),
        (
            lambda: GaitLimits(max_torque=(1.0, 2.0, 3.0)).ends(rr.Robot.from_parameters()),
            "max_torque has 3 entries: the robot has 2 legs",
        ),
    ],
)
def test_bad_goals_and_limits_are_told(make, text: str) -> None:
    with pytest.raises(rr.ParameterError) as caught:
        make()
    assert text in str(caught.value)


def test_models_that_do_not_fit_are_told(model: rr.FullModel) -> None:
    robot = model.robot
    with pytest.raises(rr.ModelError, match="does not travel"):
        optimise(rr.YawModel(robot), "fastest")
    with pytest.raises(rr.ModelError, match="no friction"):
        optimise(rr.PivotingModel(robot), "fastest", limits=GaitLimits(friction=0.2))
    with pytest.raises(rr.ModelError, match="give a model"):
        optimise(robot, "fastest")  # type: ignore[arg-type]

    class Mine(rr.FullModel):
        """Might have other equations."""

    with pytest.raises(rr.ModelError, match=r"does not know .*Mine"):
        optimise(Mine(model.robot), "fastest")
    with pytest.raises(rr.ParameterError, match="in metres"):
        optimise(rr.FullModel(random_robot(2, 3)), "fastest")
    with pytest.raises(rr.ParameterError, match="no legs"):
        optimise(rr.FullModel(random_robot(2, 0)), "fastest")
    with pytest.raises(rr.ParameterError, match="something to vary"):
        pareto_front(model, offset=1.5, amplitude=0.3, angular_frequency=8.0, phase_difference=1.0)
    with pytest.raises(rr.ParameterError, match="cost is 'work'"):
        pareto_front(model, cost="work")


def test_gaits_from_dictionaries() -> None:
    for gait in (rr.gait("circular"), rr.StillLegs((1.0, 2.0)),
                 FourierGait(offset=(1, 2), cosine=[[0, 1]], sine=[[1, 0]],
                             angular_frequency=3.0)):  # fmt: skip
        again = gait_from_dict(gait.to_dict())
        assert type(again) is type(gait) and again.to_dict() == gait.to_dict()
    for data, text in (({"type": "callable"}, "callable"), ([], "None"), ({}, "None"),
                       ({"type": "sinusoidal", "offset": 1}, "amplitude")):  # fmt: skip
        with pytest.raises(rr.GaitError, match=text):
            gait_from_dict(data)  # type: ignore[arg-type]
    assert isinstance(gait_from_dict(rr.gait("lateral").to_dict()), SinusoidalGait)


def test_progress_is_told_within_the_budget(model: rr.FullModel) -> None:
    calls: list[tuple[int, int]] = []
    optimise(model, FastestTravel(), budget=150, settle_time=2.0,
             progress=lambda used, budget: calls.append((used, budget)))  # fmt: skip
    used, budgets = zip(*calls, strict=True)
    assert list(used) == sorted(used) and used[-1] <= 150 and set(budgets) == {150}


def test_importing_it_loads_neither_numba_nor_scipy() -> None:
    code = "import sys, rrrobot.optimise, rrrobot.optimise_pareto; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert not {"numba", "scipy", "matplotlib"} & set(loaded.stdout.split())
