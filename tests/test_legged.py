"""Robots with any number of legs, generated from parameters."""

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr


def robot_of(*args, **options):
    text = rr.robot.legged_urdf(*args, **options)
    return rr.Robot.from_urdf(text, shell=rr.Sphere(0.3), shell_center=(0, 0, 0.25))


@pytest.mark.parametrize("legs", [1, 2, 3, 4, 6, 7])
@pytest.mark.parametrize("joints", [1, 2, 3])
def test_masses_joints_and_reach(legs, joints):
    robot = robot_of(legs, n_joints=joints, body_mass=2.0, leg_mass=0.5)
    assert robot.n_legs == legs * joints
    assert robot.mass == pytest.approx(2.0 + 0.5 * legs, rel=1e-12)
    # Straight down, each leg's mass is nowhere beside its hip.
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    names = [f.name for f in model.frames if f.name.endswith("_shank")]
    assert len(names) == legs
    drop = 0.0 if joints == 1 else -0.16
    top = 0.05 if legs == 1 else 0.0
    for name in names:
        assert data.oMf[model.getFrameId(name)].translation[2] == pytest.approx(top + drop)


def test_hexapod_is_symmetric_and_balanced():
    robot = robot_of(6)
    model, data = robot.model, robot.model.createData()
    centre = pin.centerOfMass(model, data, pin.neutral(model))
    np.testing.assert_allclose(centre[:2], 0, atol=1e-15)


def test_inertia_of_a_leg_is_a_rods():
    robot = robot_of(1, n_joints=1, thigh_length=0.2, shank_length=0.3, leg_mass=0.7)
    body = robot.model.inertias[robot.model.getJointId("C_hfe")]
    radius = 0.09 * 0.2
    np.testing.assert_allclose(body.lever, (0, 0, -0.25))
    across = 0.7 * (radius**2 / 4 + 0.5**2 / 12)
    np.testing.assert_allclose(np.diag(body.inertia), (across, across, 0.7 * radius**2 / 2))


def test_limits_are_those_given():
    joints = robot_of(2, max_rate=7.0, max_torque=1.5).joints
    assert set(joints.velocity) == {7.0} and set(joints.effort) == {1.5}
    assert joints.upper.max() == pytest.approx(np.pi)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"n_limbs": 0}, "n_limbs is 0: it must be a whole number, 1 to 40"),
        ({"n_limbs": True}, "n_limbs is True"),
        ({"n_limbs": 4, "n_joints": 4}, "n_joints is 4: it must be a whole number, 1 to 3"),
        ({"n_limbs": 4, "body_size": (0.1, 0, 0.1)}, "each must be greater than zero"),
        ({"n_limbs": 4, "leg_mass": -1}, "leg_mass is -1"),
        ({"n_limbs": 4, "max_torque": float("nan")}, "max_torque is nan"),
    ],
)
def test_bad_parameters_are_named(options, message):
    with pytest.raises(rr.ParameterError, match=message):
        rr.robot.legged_urdf(**options)
