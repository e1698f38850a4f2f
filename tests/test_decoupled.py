"""The single-axis models recombined: superposition, path, forces, and the paper's numbers."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.interpolate import make_interp_spline

import rrrobot as rr
from rrrobot.rotations import body_rates_matrix, body_rates_matrix_rate
from tests.twins import UNEQUAL, Array, library_robot

PERIOD = 2 * np.pi / 8.0
GAIT = rr.SinusoidalGait(
    offset=(0.7, 0.9), amplitude=(0.3, 0.4), angular_frequency=8.0, phase=(0.0, 1.9)
)
MODELS: tuple[Any, ...] = (rr.RollModel, rr.PitchModel, rr.YawModel)


@pytest.fixture(scope="module")
def robot() -> rr.Robot:
    return library_robot(UNEQUAL)


@pytest.fixture(scope="module")
def recombined(robot: rr.Robot) -> rr.Trajectory:
    return rr.decoupled(robot, GAIT, 3.0)


@pytest.fixture(scope="module")
def rolled(robot: rr.Robot) -> rr.Trajectory:
    """The full model on the same gait."""
    return rr.simulate(rr.FullModel(robot), GAIT, 3.0)


def test_superposition_is_the_three_simulations(robot: rr.Robot, recombined: rr.Trajectory) -> None:
    for axis, kind in enumerate(MODELS):
        alone = rr.simulate(kind(robot), GAIT, 3.0)
        assert np.ptp(alone.euler[:, axis]) > 0.05
        assert np.abs(recombined.euler[:, axis] - alone.euler[:, axis]).max() < 1e-9
        assert np.abs(recombined.euler_rates[:, axis] - alone.euler_rates[:, axis]).max() < 1e-8
    legs = GAIT(recombined.time)
    assert np.array_equal(recombined.leg_angle, legs.angle)
    assert np.array_equal(recombined.leg_rate, legs.rate)


def test_the_path_is_that_of_its_angles(recombined: rr.Trajectory) -> None:
    path = rr.contact.contact_path(UNEQUAL.shell_radius, recombined.time, recombined.euler)
    assert np.ptp(path, axis=0).min() > 1e-3
    assert np.abs(recombined.position - path).max() < 1e-8
    assert recombined.slip.max() < 1e-13
    assert np.abs(recombined.height_error).max() < 1e-15


def test_contact_kinematics_of_the_full_model(robot: rr.Robot, rolled: rr.Trajectory) -> None:
    """The full model's own rotation, through eqs (2)-(3), is the full model's path: from samples,
    and from a function."""
    r = UNEQUAL.shell_radius
    from_samples = rr.contact.contact_path(r, rolled.time, rolled.euler)
    assert np.abs(rolled.position - from_samples).max() < 1e-8

    angles = make_interp_spline(rolled.time, rolled.euler, k=7)
    rates = angles.derivative()
    from_function = rr.contact.contact_path(r, rolled.time, lambda t: (angles(t), rates(t)))
    assert np.abs(rolled.position - from_function).max() < 1e-8
    assert np.ptp(rolled.position, axis=0).min() > 1e-2


def momentum_of(t: rr.Trajectory) -> Array:
    """Linear momentum (n, 3) by Pinocchio's centroidal momentum of the free-flyer robot."""
    model, data = t.robot.model, t.robot.model.createData()
    return np.array(
        [
            pin.computeCentroidalMomentum(model, data, q, v).linear.copy()
            for q, v in zip(t.configuration, t.velocity, strict=True)
        ]
    )


def test_contact_force_is_the_rate_of_momentum(recombined: rr.Trajectory) -> None:
    momentum = make_interp_spline(recombined.time, momentum_of(recombined), k=7)
    weight = recombined.robot.mass * UNEQUAL.gravity * np.array([0.0, 0.0, 1.0])
    force = momentum.derivative()(recombined.time) + weight
    inside = slice(10, -10)
    assert np.abs(recombined.contact_force - force)[inside].max() < 1e-6
    assert np.ptp(recombined.contact_force, axis=0).min() > 0.1


def test_inverse_dynamics_of_a_full_motion_find_its_forces(
    robot: rr.Robot, rolled: rr.Trajectory
) -> None:
    """Given the full model's motion, `decoupled`'s forces are the full model's, in balance."""
    model = rr.FullModel(robot)
    decoupled = rr.models.DecoupledModels(robot)
    for i, y in enumerate(rolled.state):
        pose, omega, _ = model.split(y)
        legs = GAIT(rolled.time[i])
        alpha = model.quasi_acceleration(model.dynamics(pose, omega, legs).acceleration)
        euler, rates = rolled.euler[i], rolled.euler_rates[i]
        B, B_rate = body_rates_matrix(*euler[:2]), body_rates_matrix_rate(euler, rates)
        place = decoupled.place(decoupled.make_pose(euler, rolled.position[i]))
        again = decoupled.inverse(place, rates, np.linalg.solve(B, alpha - B_rate @ rates), legs)
        assert np.abs(again.contact_force - rolled.contact_force[i]).max() < 1e-11
        assert np.abs(again.leg_torque - rolled.leg_torque[i]).max() < 1e-12
        assert abs(sum(decoupled.energy(again.q, again.v)) - rolled.energy[i]) < 1e-13
        assert np.abs(again.forces["unbalanced"]).max() < 1e-12
        assert np.abs(again.v - rolled.velocity[i]).max() < 1e-12


def test_a_decoupled_motion_is_out_of_balance(recombined: rr.Trajectory) -> None:
    """It does not obey the full equations, and says by how much: sizeably, but less than the
    largest moment of gravity on the robot."""
    unbalanced = recombined.metadata["unbalanced_moment"]
    assert 1e-3 < unbalanced < 0.5 * recombined.robot.mass * UNEQUAL.gravity * 0.13


def test_yaw_gait_moves_the_yaw_model_alone(robot: rr.Robot, recombined: rr.Trajectory) -> None:
    wide = rr.SinusoidalGait(
        offset=(0.7, 0.9), amplitude=(0.6, 0.8), angular_frequency=8.0, phase=(0.0, 1.9)
    )
    t = rr.decoupled(robot, GAIT, 3.0, yaw_gait=wide)
    alone = rr.simulate(rr.YawModel(robot), wide, 3.0)
    assert np.abs(t.euler[:, 2] - alone.euler[:, 2]).max() < 1e-9
    assert np.abs(t.euler[:, :2] - recombined.euler[:, :2]).max() < 1e-9
    assert np.abs(t.euler[:, 2] - recombined.euler[:, 2]).max() > 0.05
    assert np.array_equal(t.leg_angle, recombined.leg_angle)
    assert t.metadata["yaw_gait"] == wide.to_dict() != t.metadata["gait"] == GAIT.to_dict()


def test_a_fast_yaw_gait_is_resolved(robot: rr.Robot) -> None:
    """Steps are short enough for the faster of the two gaits."""
    fast = rr.SinusoidalGait(offset=0.8, amplitude=0.3, angular_frequency=200.0, phase=(0, 1.5))
    slow = rr.SinusoidalGait(offset=0.8, amplitude=0.3, angular_frequency=2.0, phase=(0, 1.5))
    t = rr.decoupled(robot, slow, 0.2, yaw_gait=fast)
    alone = rr.simulate(rr.YawModel(robot), fast, 0.2, rtol=1e-12, atol=1e-12)
    assert np.abs(t.euler[:, 2] - alone.euler[:, 2]).max() < 1e-7
    assert t.metadata["integration"]["max_step"] == fast.period / 12


def test_other_models_may_be_given(robot: rr.Robot, recombined: rr.Trajectory) -> None:
    t = rr.decoupled(robot, GAIT, 1.0, pitch=rr.PitchModel(robot, damping=0.1))
    alone = rr.simulate(rr.PitchModel(robot, damping=0.1), GAIT, 1.0)
    assert np.abs(t.euler[:, 1] - alone.euler[:, 1]).max() < 1e-9
    assert np.abs(t.euler[:, 0] - recombined.euler[:101, 0]).max() < 1e-9
    assert np.abs(t.euler[:, 1] - recombined.euler[:101, 1]).max() > 1e-3
    assert t.metadata["model"]["pitch"]["damping"]["pitch"] == 0.1


@pytest.mark.parametrize(
    ("name", "speed", "yaw_rate"),
    [
        ("lateral", 0.009931065, 0.0),
        ("circular", 0.0040926, 0.0135522),
    ],
)
@pytest.mark.slow
def test_steady_state_of_the_two_gaits(name: str, speed: float, yaw_rate: float) -> None:
    t = rr.decoupled(library_robot(), rr.gait(name), 30.0, PERIOD / 25, step=PERIOD / 12)
    steady = t.steady_state()
    assert steady.speed == pytest.approx(speed, rel=2e-5)
    assert steady.yaw_rate == pytest.approx(yaw_rate, abs=1e-7)


def test_bad_input(robot: rr.Robot) -> None:
    torques = rr.LegTorques((0.0, 0.0), angle=(1.0, 1.0))
    with pytest.raises(rr.GaitError, match="prescribed gait"):
        rr.decoupled(robot, torques, 1.0)  # type: ignore[arg-type]
    with pytest.raises(rr.GaitError, match="prescribed gait"):
        rr.decoupled(robot, GAIT, 1.0, yaw_gait=torques)  # type: ignore[arg-type]
    with pytest.raises(rr.GaitError, match="moves 3 leg joints, but the robot has 2"):
        rr.decoupled(robot, rr.StillLegs((1.0, 1.0, 1.0)), 1.0)
    with pytest.raises(rr.GaitError, match="moves 1 leg joint, but the robot has 2"):
        rr.decoupled(robot, GAIT, 1.0, yaw_gait=rr.StillLegs([1.0]))
    with pytest.raises(rr.ParameterError, match="duration"):
        rr.decoupled(robot, GAIT, -1.0)
    with pytest.raises(rr.ModelError, match=r"the pitch model is of .* same robot"):
        rr.decoupled(robot, GAIT, 1.0, pitch=rr.PitchModel(library_robot()))


def broken(time: float) -> tuple[Array, Array, Array]:
    value = np.full(2, np.nan if time > 0.5 else 1.0)
    return value, np.zeros(2), np.zeros(2)


def test_a_gait_that_fails_leaves_the_samples_up_to_then(robot: rr.Robot) -> None:
    gait = rr.CallableGait(broken, n_legs=2, check_span=(0.0, 0.4))
    with pytest.raises(rr.SimulationError, match="finite") as caught:
        rr.decoupled(robot, gait, 2.0)
    t = caught.value.trajectory
    assert t is not None and 0.3 < t.time[-1] <= 0.5
    assert np.all(np.isfinite(t.position))


def test_pickle_save_and_load(recombined: rr.Trajectory, tmp_path: Path) -> None:
    saved = rr.Trajectory.load(recombined.save(tmp_path / "motion.npz"))
    for other in (pickle.loads(pickle.dumps(recombined)), saved):
        for name in ("time", "euler", "position", "contact_force", "leg_torque", "configuration"):
            assert np.array_equal(getattr(other, name), getattr(recombined, name)), name
        assert other.robot == recombined.robot
        assert other.metadata == recombined.metadata
        assert other.model_name == "decoupled" and other.has_contact
        assert repr(other) == repr(recombined)
