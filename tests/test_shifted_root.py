"""A robot whose root link's frame stands elsewhere moves as before, in every model."""

import numpy as np
import pytest

import rrrobot as rr

SHIFT = np.array((0.05, -0.03, 0.07))
ROBOT = rr.Robot.from_parameters()
MODELS = (rr.FullModel, rr.PivotingModel, rr.RollModel, rr.PitchModel, rr.YawModel)
GAIT = rr.gait("circular")


def shifted() -> rr.Robot:
    """RRRobot fixed to a massless root link: its centre is SHIFT from that link's origin."""
    x, y, z = SHIFT
    joint = (
        f'<link name="hull"/><joint name="to_base" type="fixed"><origin xyz="{x} {y} {z}"/>'
        f'<parent link="hull"/><child link="{ROBOT.shell_link}"/></joint></robot>'
    )
    return rr.Robot.from_urdf(
        ROBOT.urdf.replace("</robot>", joint), shell=rr.Sphere(0.12), shell_center=SHIFT
    )


@pytest.mark.parametrize("method", ["kkt", "momentum"])
@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.name)
def test_every_model_moves_alike(model, method):
    here, there = (
        rr.simulate(model(robot, damping=0.01), GAIT, 1.0, 0.05, step=0.01, method=method)
        for robot in (ROBOT, shifted())
    )
    np.testing.assert_allclose(there.euler, here.euler, atol=1e-12)
    np.testing.assert_allclose(there.position, here.position, atol=1e-12)
    np.testing.assert_allclose(there.contact_force, here.contact_force, atol=1e-10)
    np.testing.assert_allclose(there.leg_torque, here.leg_torque, atol=1e-11)
    # The energies differ by that of the height from which they count.
    np.testing.assert_allclose(np.diff(there.energy), np.diff(here.energy), atol=1e-12)


@pytest.mark.slow
def test_models_recombined_and_periods():
    undamped = rr.Robot.from_urdf(ROBOT.urdf, shell=rr.Sphere(0.12))
    here, there = (rr.decoupled(robot, GAIT, 1.0, 0.1) for robot in (undamped, shifted()))
    np.testing.assert_allclose(there.euler, here.euler, atol=1e-12)
    np.testing.assert_allclose(there.position, here.position, atol=1e-12)
    np.testing.assert_allclose(there.contact_force, here.contact_force, atol=1e-10)
    for one, other in zip(rr.orbits.table_3(ROBOT), rr.orbits.table_3(shifted()), strict=True):
        assert other.linear == pytest.approx(one.linear, rel=1e-10)
