"""Losses: the Euler rates' generalised forces of eqs (9)-(10), the body rates' moments."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rrrobot as rr
from rrrobot.drive.damping import as_damping
from rrrobot.rotations import body_rates_matrix
from tests.strategies import examples, vectors

coefficients = vectors(3, 0.0, 0.1)


@given(coefficients, vectors(2, -1.4, 1.4), vectors(3, -5, 5))
@examples(50)
def test_euler_rate_damping_is_a_generalised_force_on_each_rate(k, attitude, rates):
    """The moment's work on any change of the angles is -k rate times that change."""
    matrix = body_rates_matrix(*attitude)
    moment = rr.EulerRateDamping(*k).moment(*attitude, matrix @ rates)
    np.testing.assert_allclose(matrix.T @ moment, -k * rates, atol=1e-11)


@given(coefficients, vectors(2, -3, 3), vectors(3, -5, 5))
@examples(20)
def test_body_rate_damping_is_along_the_bodys_axes(k, attitude, omega):
    moment = rr.BodyRateDamping(*k).moment(*attitude, omega)
    np.testing.assert_array_equal(moment, -k * omega)
    assert moment @ omega <= 0


def test_only_euler_rate_damping_is_singular():
    assert rr.EulerRateDamping(yaw=0.01).singular_at_vertical
    assert not rr.EulerRateDamping(legs=0.01).singular_at_vertical
    assert not rr.EulerRateDamping().singular_at_vertical
    assert not rr.BodyRateDamping(1, 1, 1).singular_at_vertical
    assert rr.BodyRateDamping(legs=0.3).leg_coefficient == 0.3


@pytest.mark.parametrize(
    ("value", "damping"),
    [
        (0.01, rr.EulerRateDamping(0.01, 0.01, 0.01)),
        ((0.1, 0.2, 0.3), rr.EulerRateDamping(0.1, 0.2, 0.3)),
        (np.zeros(3), rr.EulerRateDamping()),
        (None, rr.EulerRateDamping()),
        (rr.BodyRateDamping(0.1), rr.BodyRateDamping(0.1)),
    ],
)
def test_short_forms(value, damping):
    assert as_damping(value) == damping
    assert as_damping(value).to_dict()["type"] == type(damping).__name__


BAD: list[Any] = [-0.01, (0.1, -0.2, 0.3), (0.1, 0.2), np.nan, np.inf, "much", ("a", "b", "c"),
                  True, [[0.1, 0.2, 0.3]], 1j]  # fmt: skip


@pytest.mark.parametrize("value", BAD, ids=repr)
def test_bad_short_forms(value):
    with pytest.raises(rr.ParameterError, match=r"^(damping|roll|pitch)"):
        as_damping(value)


@pytest.mark.parametrize("cls", [rr.EulerRateDamping, rr.BodyRateDamping])
@given(st.sampled_from([-1.0, np.nan, np.inf, "0.1", True, None]))
@examples(6)
def test_bad_coefficients_are_named(cls, value):
    with pytest.raises(rr.ParameterError, match=r"legs is .* at least zero"):
        cls(legs=value)
