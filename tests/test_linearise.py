"""Linearised motion against closed forms, a second route, and the nonlinear motion itself."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.orbits.linear import _jacobian

ROBOT = rr.Robot.from_parameters()
UP = (np.pi / 2, np.pi / 2)


def test_pendulum_in_closed_form():
    """k / I of docs' physics: m g d and the inertia about the contact of five point masses."""
    p = rr.RRRobotParameters()
    r, g = p.shell_radius, p.gravity
    heights = [(p.battery_mass, -r), *[(p.servo_mass, 0.0)] * 2, *[(p.leg_mass, p.leg_length)] * 2]
    restoring = -g * sum(m * z for m, z in heights)
    lateral = p.hip_offset**2
    # Roll: rows x = 0; masses at (y, z); about the contact at z = -r.
    inertia = p.battery_mass * 0.0 + 2 * p.servo_mass * (lateral + r**2)
    inertia += 2 * p.leg_mass * (lateral + (p.leg_length + r) ** 2)
    model = rr.RollModel(ROBOT, damping=None)
    A, B, _, _ = rr.linearise(model, leg_angle=UP)
    n = 5  # after the angle, the contact point and the legs
    feedback = np.linalg.solve(B[-2:], A[-2:])
    closed = A - B @ feedback
    assert -closed[n, 0] == pytest.approx(restoring / inertia, rel=1e-8)


@pytest.mark.parametrize("kind", [rr.FullModel, rr.PivotingModel, rr.RollModel, rr.YawModel])
def test_matrices_predict_the_motion(kind):
    """The nonlinear flow of a small deviation, minus the given motion, is expm's."""
    from scipy.linalg import expm

    model = kind(ROBOT, damping=None)
    torque = (0.0, 0.0)
    A, B, C, D = rr.linearise(model, leg_angle=UP, leg_torque=torque)
    assert np.all(D == 0)
    span, size = 0.05, 1e-5
    push = np.array((1.0, -0.4)) * size

    def outputs(u):
        drive = rr.LegTorques(u, angle=UP)
        t = rr.simulate(model, drive, span, span, start="rest", rtol=1e-13, atol=1e-13)
        return np.concatenate((t.euler[-1], t.leg_angle[-1]))

    n, m = B.shape
    block = np.zeros((n + m, n + m))
    block[:n, :n], block[:n, n:] = A, B
    found = C @ expm(block * span)[:n, n:] @ push
    moved = (outputs(push) - outputs(-push)) / 2
    # Of upright legs without torque, an equilibrium by symmetry.
    assert np.abs(moved - found).max() < 1e-6 * np.abs(moved).max()


def test_about_a_motion():
    """Along a trajectory: the difference of two near motions obeys A, in the body's axes."""
    model = rr.FullModel(ROBOT)
    hold = rr.LegTorques((0.02, -0.01), angle=(1.2, 1.8), rate=(0.5, -0.4))
    base = rr.simulate(model, hold, 0.3, 0.01, start=(0.5, -0.4, 0.7))
    A, B, *_ = rr.linearise(model, leg_angle=0, leg_torque=(0.02, -0.01), state=base.final_state)
    state = base.final_state.vector
    omega = state[6:9]
    # The rotation's own rows: x_dot = w - omega x x, and the legs' are their rates.
    expected = np.zeros((3, len(A)))
    expected[:, :3] = -np.array(
        ((0, -omega[2], omega[1]), (omega[2], 0, -omega[0]), (-omega[1], omega[0], 0))
    )
    expected[:, 7:10] = np.eye(3)
    np.testing.assert_allclose(A[:3], expected, atol=1e-10)
    # Torques act by the inverse of the inertia: twice the torque deviation, twice the effect.
    flow = rr.simulation.Flow(model, rr.LegTorques((0.02 + 1.0, -0.01), angle=(1, 1)))
    near = rr.simulation.Flow(model, hold)
    pose, quasi, legs = model.split(state)
    moving = {"leg_angle": legs[:2], "leg_rate": legs[2:]}
    a = [
        model.dynamics(pose, quasi, **moving, leg_torque=f.drive.constant)
        for f in (flow, near)
    ]  # fmt: skip
    difference = a[0].acceleration - a[1].acceleration
    np.testing.assert_allclose(B[7:10, 0], difference[3:6], rtol=1e-9)


def test_differences_are_of_sixth_order():
    found = _jacobian(lambda x: np.array([np.sin(3 * x[0]) * np.exp(x[1])]), np.array((0.3, 0.2)))
    exact = np.exp(0.2) * np.array([[3 * np.cos(0.9), np.sin(0.9)]])
    np.testing.assert_allclose(found, exact, atol=1e-12)


def test_decoupled_models_are_refused():
    with pytest.raises(rr.ModelError, match="no free legs"):
        rr.linearise(rr.models.DecoupledModels(ROBOT), leg_angle=UP)
