"""Rotations against SciPy's, and their rates against finite differences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from rrrobot import rotations as rot
from tests.strategies import examples, vectors

angles = st.tuples(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1)).map(np.array)
any_angles = vectors(3, -20.0, 20.0)
omegas = vectors(3, -5.0, 5.0)
quaternions = vectors(4, -2.0, 2.0).filter(lambda q: np.linalg.norm(q) > 0.1)


def scipy_rotation(euler: np.ndarray) -> Rotation:
    """Rz(yaw) Ry(pitch) Rx(roll)."""
    return Rotation.from_euler("ZYX", np.asarray(euler)[..., ::-1])


def same_rotation(a: np.ndarray, b: np.ndarray) -> None:
    np.testing.assert_allclose(rot.rotation_from_euler(a), rot.rotation_from_euler(b), atol=1e-12)


@given(omegas, omegas)
@examples(20)
def test_skew_is_the_cross_product(a, b):
    np.testing.assert_allclose(rot.skew(a) @ b, np.cross(a, b), atol=1e-14)


@given(any_angles)
@examples(40)
def test_matrix_and_quaternion_of_euler_are_scipys(euler):
    expected = scipy_rotation(euler)
    np.testing.assert_allclose(rot.rotation_from_euler(euler), expected.as_matrix(), atol=1e-14)
    q = rot.quaternion_from_euler(euler)
    assert abs(abs(q @ expected.as_quat()) - 1) < 1e-14


@given(quaternions)
@examples(40)
def test_quaternion_of_any_length(q):
    unit = Rotation.from_quat(q)
    matrix = unit.as_matrix()
    np.testing.assert_allclose(rot.rotation_from_quaternion(q), matrix, atol=1e-14)
    again = rot.rotation_from_euler(rot.euler_from_quaternion(q))
    # arcsin loses half of the digits where the pitch is near 90 degrees.
    np.testing.assert_allclose(again, matrix, atol=1e-7)


@given(angles)
@examples(40)
def test_euler_round_trip(euler):
    q = rot.quaternion_from_euler(euler)
    np.testing.assert_allclose(rot.euler_from_quaternion(q), euler, atol=1e-12)
    assert rot.euler_from_rotation(rot.rotation_from_euler(euler)) == pytest.approx(
        euler, abs=1e-12
    )


def test_vectorised_over_leading_axes():
    rng = np.random.default_rng(0)
    euler, omega = rng.uniform(-1.5, 1.5, (4, 5, 3)), rng.normal(size=(4, 5, 3))
    q, rates = rot.quaternion_from_euler(euler), rot.euler_rates(euler, omega)
    assert q.shape == (4, 5, 4)
    assert rates.shape == (4, 5, 3)
    np.testing.assert_allclose(rot.euler_from_quaternion(q), euler, atol=1e-13)
    np.testing.assert_array_equal(q[2, 3], rot.quaternion_from_euler(euler[2, 3]))
    np.testing.assert_array_equal(rates[2, 3], rot.euler_rates(euler[2, 3], omega[2, 3]))


@given(angles, omegas)
@examples(30)
def test_quaternion_rate_turns_with_the_body(euler, omega):
    """R_dot = R [omega_body], by central differences along the quaternion's rate."""
    q, h = rot.quaternion_from_euler(euler), 1e-5
    rate = rot.quaternion_rate(q, omega)
    ahead, behind = (rot.rotation_from_quaternion(q + sign * h * rate) for sign in (1, -1))
    expected = rot.rotation_from_quaternion(q) @ rot.skew(omega)
    np.testing.assert_allclose((ahead - behind) / (2 * h), expected, atol=1e-7)


@given(angles, vectors(3, -5.0, 5.0))
@examples(30)
def test_body_rates_matrix_is_the_rotations_rate(euler, rates):
    h = 1e-5
    ahead, behind = (rot.rotation_from_euler(euler + sign * h * rates) for sign in (1, -1))
    spin = rot.rotation_from_euler(euler).T @ (ahead - behind) / (2 * h)
    omega = rot.body_rates_matrix(euler[0], euler[1]) @ rates
    np.testing.assert_allclose(spin, rot.skew(omega), atol=1e-6)
    np.testing.assert_allclose(rot.euler_rates(euler, omega), rates, atol=1e-9)


@given(angles, vectors(3, -5.0, 5.0))
@examples(30)
def test_body_rates_matrix_rate(euler, rates):
    h = 1e-5
    ahead, behind = (rot.body_rates_matrix(*(euler + sign * h * rates)[:2]) for sign in (1, -1))
    rate = rot.body_rates_matrix_rate(euler, rates)
    np.testing.assert_allclose((ahead - behind) / (2 * h), rate, atol=1e-7)


def test_one_turn_about_each_axis_has_the_sign_of_the_right_hand():
    for axis in range(3):
        euler = np.zeros(3)
        euler[axis] = np.pi / 2
        expected = Rotation.from_rotvec(euler).as_matrix()
        np.testing.assert_allclose(rot.rotation_from_euler(euler), expected, atol=1e-15)


@pytest.mark.parametrize("start", [(0, 0, 0), (0, 0, 100 * np.pi), (-40, 0.2, 3)])
def test_continuous_through_many_turns(start):
    time = np.linspace(0, 30, 3001)
    true = np.column_stack((2 * time, 0.8 * np.sin(time), -3 * time)) + start
    wrapped = rot.euler_from_quaternion(rot.quaternion_from_euler(true))
    assert np.abs(np.diff(wrapped, axis=0)).max() > 6
    np.testing.assert_allclose(rot.continuous_euler(wrapped, start), true, atol=1e-9)


@pytest.mark.parametrize("roll, yaw", [(0.0, 0.0), (0.4, -2.0)])
def test_continuous_over_the_pole(roll, yaw):
    """A pitch that grows through 90 degrees and on, which principal angles fold back."""
    true = np.column_stack((np.full(500, roll), np.linspace(0, 13.1, 500), np.full(500, yaw)))
    folded = rot.euler_from_quaternion(rot.quaternion_from_euler(true))
    assert np.abs(folded[:, 1]).max() <= np.pi / 2
    np.testing.assert_allclose(rot.continuous_euler(folded, true[0]), true, atol=1e-6)


@given(any_angles, any_angles)
@examples(40)
def test_continuous_angles_are_the_same_rotation_nearest_to_the_start(euler, start):
    principal = rot.euler_from_quaternion(rot.quaternion_from_euler(euler))
    (found,) = rot.continuous_euler(principal[None], start)
    same_rotation(found, principal)
    others = [principal, (principal[0] + np.pi, np.pi - principal[1], principal[2] + np.pi)]
    turns = 2 * np.pi * np.array(np.meshgrid(*[(-1, 0, 1)] * 3)).reshape(3, -1).T
    for other in others:
        near = other + 2 * np.pi * np.round((start - np.asarray(other)) / (2 * np.pi)) + turns
        assert np.abs(found - start).sum() <= np.abs(near - start).sum(axis=1).min() + 1e-9


def test_continuous_leaves_its_argument_alone():
    history = np.array([[3.1, 0.0, 0.0], [-3.1, 0.0, 0.0]])
    before = history.copy()
    rot.continuous_euler(history, np.zeros(3))
    np.testing.assert_array_equal(history, before)
