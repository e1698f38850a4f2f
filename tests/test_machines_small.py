"""Small motions of machines: nutation, critical speeds, rocking, the rattleback's growth, hovering.

Frequencies and growth rates are eigenvalues of equations of motion that are differentiated here.
"""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

import rrrobot as rr
from rrrobot.rotations import euler_rates, quaternion_from_euler, rotation_from_euler
from tests.test_machines_space import CRITICAL, WHEELS, axis, zxy

STENCIL = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))


def slope(function, x, step):
    """Jacobian by central differences of order six."""
    columns = []
    for e in step * np.eye(len(x)):
        parts = [w * (function(x + k * e) - function(x - k * e)) for k, w in STENCIL]
        columns.append(sum(parts) / step)
    return np.array(columns).T


def disc_rates(wheel):
    """d/dt of (lean, u), u the angular velocity in the lean frame: x level, y the axle."""

    def rates(state):
        lean, u = state[0], state[1:]
        R = axis(0, lean)
        a = wheel.evaluate(pose=wheel.at(R), body_velocity=u)
        yaw = u[2] / np.cos(lean)
        frame = np.array((u[0], yaw * np.sin(lean), yaw * np.cos(lean)))
        return np.append(u[0], R.T @ a.pose_acceleration[3:] - np.cross(frame, u))

    return rates


def nutation(wheel, lean, yaw, spin):
    """Frequency squared of small motions about steady rolling; the others are drifts."""
    steady = np.array((lean, 0.0, yaw * np.sin(lean) + spin, yaw * np.cos(lean)))
    rates = disc_rates(wheel)
    np.testing.assert_allclose(rates(steady), 0, atol=2e-8)
    J = slope(rates, steady, 3e-3)
    return -0.5 * np.trace(J @ J)


@pytest.mark.parametrize(
    ("name", "lean", "yaw", "spin", "square"),
    [("disc", 0.3, 2.0, -3.86429879851, 8.452051009),
     ("disc", 1.3, 6.0, -17.9054298214, 508.6037174),
     ("torus", 0.3, 2.0, -3.53741614638, 4.029960244),
     ("torus", 1.3, 6.0, -15.8314067118, 406.582612)],
)  # fmt: skip
def test_nutation_of_steady_rolling(name, lean, yaw, spin, square):
    wheel = rr.machines.rolling_disc(**WHEELS[name])
    assert nutation(wheel, lean, yaw, spin) == pytest.approx(square, rel=2e-9)


@pytest.mark.parametrize("name", WHEELS)
def test_critical_speeds_of_a_disc_to_their_digits(name):
    wheel = rr.machines.rolling_disc(**WHEELS[name])
    m, r, (A, C, _) = 1.2, 0.3, wheel.tree.base.inertia
    R = r + WHEELS[name].get("rho", 0.0)
    square = (C * (C + m * R**2) * 3.0**2 - A * m * 9.81 * r) / (A * (A + m * R**2))
    assert nutation(wheel, 0.0, 0.0, 3.0) == pytest.approx(square, rel=1e-9)
    square = 4.0**2 - m * 9.81 * r / (A + m * R**2)
    assert nutation(wheel, 0.0, 4.0, 0.0) == pytest.approx(square, rel=1e-9)
    rolls, spins = CRITICAL[name]
    found = brentq(lambda rate: nutation(wheel, 0, 0, rate), 3, 4, xtol=1e-12)
    assert found == pytest.approx(rolls, rel=1e-9)
    found = brentq(lambda rate: nutation(wheel, 0, rate, 0), 4, 6, xtol=1e-12)
    assert found == pytest.approx(spins, rel=1e-9)


@pytest.mark.parametrize("name", WHEELS)
def test_a_disc_above_its_critical_speed_leans_as_its_linear_equations_say(name):
    wheel = rr.machines.rolling_disc(**WHEELS[name])
    lean = 1e-7
    for critical, rolling in zip(CRITICAL[name], (True, False), strict=True):
        R = zxy(0.0, lean, 0.0)
        rate = 1.02 * critical
        omega = R.T @ ((0.0, rate, 0.0) if rolling else (0.0, 0.0, rate))
        t = wheel.simulate(None, 8.0, pose=wheel.at(R), start=omega, sample_interval=0.5)
        upright = np.array((0.0, 0.0, rate, 0.0) if rolling else (0.0, 0.0, 0.0, rate))
        J = slope(disc_rates(wheel), upright, 3e-3)
        off = np.array((lean, *(omega - upright[1:])))
        wanted = np.array([(expm(J * s) @ off)[0] for s in t.time])
        # It swings out to 25 or 100 times the lean that it began with, and comes back.
        assert 20 < wanted.max() / lean < 110
        np.testing.assert_allclose(t.wheel_angles[:, 1], wanted, atol=2e-3 * wanted.max())


def stone_rates(stone):
    """d/dt of (roll, pitch, omega in the body)."""

    def rates(state):
        euler, omega = np.append(state[:2], 0.0), state[2:]
        R = rotation_from_euler(euler)
        a = stone.evaluate(pose=R, body_velocity=omega)
        return np.append(euler_rates(euler, omega)[:2], R.T @ a.pose_acceleration[3:])

    return rates


@pytest.mark.parametrize(("spin", "sign"), [(5.0, 1), (-5.0, -1)])
def test_the_rattle_of_a_spinning_rattleback_grows_one_way_round(spin, sign):
    rates = stone_rates(rr.machines.rattleback())
    values = np.linalg.eigvals(slope(rates, np.array((0, 0, 0, 0, spin)), 2e-4))
    fast, slow = (values[np.argmin(np.abs(values.imag - f))] for f in (109.4, 34.1))
    wanted = (sign * 2.1206924 + 109.39232j, -sign * 0.2025213 + 34.14369j)
    np.testing.assert_allclose([fast.real, slow.real], np.real(wanted), atol=6e-8)
    np.testing.assert_allclose([fast.imag, slow.imag], np.imag(wanted), atol=6e-6)


def test_a_rattleback_rocks_at_rest_as_the_closed_form():
    rates = stone_rates(rr.machines.rattleback())
    values = np.linalg.eigvals(slope(rates, np.zeros(5), 2e-4))
    found = np.sort(values.imag)[-2:]
    np.testing.assert_allclose(found, (33.82899128, 107.20765832), rtol=2e-10)
    a, b, c, h = 0.2, 0.03, 0.02, 0.01
    stiffness = 9.81 * np.diag((b * b / c - h, a * a / c - h))
    mass = np.array(((2e-4, 0.2e-4), (0.2e-4, 16e-4))) + (c - h) ** 2 * np.eye(2)
    closed = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)))
    np.testing.assert_allclose(found, np.sort(closed), rtol=1e-9)


def test_a_hovering_submarine_rolls_and_pitches():
    boat = rr.machines.submarine()

    def acceleration(q):
        pose = np.concatenate((q[:3], quaternion_from_euler(q[3:])))
        return boat.evaluate(pose=pose, shape_accelerations=(0, 0, 0)).pose_acceleration

    squares = np.linalg.eigvals(-slope(acceleration, np.zeros(6), 3e-3))
    found = np.sort(np.sqrt(np.abs(squares)))[-2:]
    np.testing.assert_allclose(found, (1.644729762, 4.379144593), rtol=1e-9)
