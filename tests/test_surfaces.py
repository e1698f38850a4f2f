"""Shells: support function, contact arm and its rate, against finite differences and samples."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import rrrobot as rr
from rrrobot.contact.ground import ground_basis
from rrrobot.contact.saved import surface_from_dict
from rrrobot.rotations import rotation_from_quaternion
from tests.strategies import directions, examples, vectors

radii = st.floats(0.05, 1.0)
spheres = radii.map(rr.Sphere)
ellipsoids = st.tuples(radii, radii, radii).map(rr.Ellipsoid)
shells = st.one_of(spheres, ellipsoids)
rotations = (
    vectors(4, -1, 1).filter(lambda q: np.linalg.norm(q) > 0.1).map(rotation_from_quaternion)
)
scales = st.floats(0.5, 2.0)


@given(spheres, rotations, vectors(3, -5, 5), directions())
@examples(25)
def test_sphere_shortcuts_are_the_general_formulas(sphere, rotation, omega, normal):
    general = rr.Surface
    arm = general.arm(sphere, rotation, normal)
    np.testing.assert_allclose(sphere.arm(rotation, normal), arm, atol=1e-15)
    np.testing.assert_allclose(sphere.fixed_arm(normal), arm, atol=1e-15)
    moving = rr.contact.contact_velocity(sphere, rotation, omega, normal)
    np.testing.assert_allclose(np.cross(omega, arm) + moving, 0, atol=1e-14)


@given(shells, directions(), scales)
@examples(50)
def test_contact_is_the_gradient_of_the_support_function(shell, direction, scale):
    u, h = scale * direction, 1e-6
    steps = h * np.eye(3)
    gradient = [(shell.support(u + e) - shell.support(u - e)) / (2 * h) for e in steps]
    np.testing.assert_allclose(shell.contact(u), gradient, atol=1e-8)
    assert shell.support(u) == pytest.approx(u @ shell.contact(u), rel=1e-13)
    assert shell.support(3 * u) == pytest.approx(3 * shell.support(u), rel=1e-13)


@given(shells, directions(), scales)
@examples(50)
def test_hessian_is_the_gradient_of_the_contact(shell, direction, scale):
    u, h = scale * direction, 1e-5
    steps = h * np.eye(3)
    rows = [(shell.contact(u + e) - shell.contact(u - e)) / (2 * h) for e in steps]
    hessian = shell.hessian(u)
    np.testing.assert_allclose(hessian, rows, atol=2e-6)
    np.testing.assert_allclose(hessian, hessian.T, atol=1e-14)
    np.testing.assert_allclose(hessian @ u, 0, atol=1e-13)
    assert np.linalg.eigvalsh(hessian)[0] > -1e-13


@given(ellipsoids, directions())
@examples(25)
def test_contact_lies_on_the_ellipsoid_with_that_normal(shell, u):
    axes = np.array(shell.semi_axes)
    x = shell.contact(u)
    assert np.sum((x / axes) ** 2) == pytest.approx(1, abs=1e-12)
    outward = x / axes**2
    np.testing.assert_allclose(outward / np.linalg.norm(outward), u, atol=1e-12)


@given(radii, directions(), rotations, vectors(3, -5, 5))
@examples(25)
def test_round_ellipsoid_is_a_sphere(radius, u, rotation, omega):
    round_one, sphere = rr.Ellipsoid((radius,) * 3), rr.Sphere(radius)
    assert round_one.support(u) == pytest.approx(sphere.support(u), rel=1e-14)
    np.testing.assert_allclose(round_one.contact(u), sphere.contact(u), atol=1e-14)
    np.testing.assert_allclose(round_one.hessian(u), sphere.hessian(u), atol=1e-14)
    np.testing.assert_allclose(round_one.arm(rotation, u), sphere.arm(rotation, u), atol=1e-14)
    moving = rr.contact.contact_velocity(round_one, rotation, omega, u)
    np.testing.assert_allclose(moving, radius * np.cross(omega, u), atol=1e-13)
    assert round_one.fixed_arm(u) is None


@given(ellipsoids, rotations, vectors(3, -3, 3), directions())
@examples(40)
def test_arm_rate_is_the_rate_of_the_arm(shell, rotation, omega, normal):
    h = 1e-6
    ahead, behind = (
        shell.arm(Rotation.from_rotvec(sign * h * omega).as_matrix() @ rotation, normal)
        for sign in (1, -1)
    )
    moving = rr.contact.contact_velocity(shell, rotation, omega, normal)
    rate = np.cross(omega, shell.arm(rotation, normal)) + moving
    np.testing.assert_allclose((ahead - behind) / (2 * h), rate, atol=1e-6)
    # The contact point stays on the plane.
    assert normal @ moving == pytest.approx(0, abs=1e-12)


@given(shells, rotations, directions())
@examples(25)
def test_contact_is_the_lowest_point(shell, rotation, normal):
    """No sampled point of the shell is below the contact, along any plane's normal."""
    rng = np.random.default_rng(1)
    unit = rng.normal(size=(2000, 3))
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    axes = getattr(shell, "semi_axes", (getattr(shell, "radius", 0.0),) * 3)
    heights = (unit * axes) @ rotation.T @ normal
    lowest = normal @ shell.arm(rotation, normal)
    assert lowest <= heights.min() + 1e-12
    assert heights.min() - lowest < 0.02 * max(axes)
    u = -rotation.T @ normal
    assert lowest == pytest.approx(-shell.support(u), rel=1e-12)


@pytest.mark.parametrize("pole", range(3))
def test_principal_radii_at_the_poles(pole):
    """At the pole of axis a, the radii of curvature are b^2/a and c^2/a."""
    axes = np.array((0.15, 0.1, 0.12))
    others = np.delete(axes, pole)
    found = rr.Ellipsoid(tuple(axes)).principal_radii(-3.0 * np.eye(3)[pole])
    np.testing.assert_allclose(found, np.sort(others**2 / axes[pole]), rtol=1e-13)


@given(spheres, directions())
@examples(10)
def test_principal_radii_of_a_sphere(sphere, u):
    np.testing.assert_allclose(sphere.principal_radii(u), (sphere.radius,) * 2, rtol=1e-13)


@given(directions())
@examples(50)
def test_ground_basis_is_orthonormal_and_right_handed(normal):
    basis = ground_basis(normal)
    np.testing.assert_allclose(basis.T @ basis, np.eye(3), atol=1e-14)
    assert np.linalg.det(basis) == pytest.approx(1, abs=1e-13)
    np.testing.assert_array_equal(basis[:, 2], normal)
    if abs(normal[0]) < 0.9:
        assert basis[1:, 0] @ normal[1:] == pytest.approx(-basis[0, 0] * normal[0], abs=1e-14)
        assert basis[0, 0] == pytest.approx(np.sqrt(1 - normal[0] ** 2), abs=1e-14)


def test_ground_basis_of_level_ground_is_the_world():
    np.testing.assert_array_equal(ground_basis(np.array((0.0, 0.0, 1.0))), np.eye(3))


@given(shells)
@examples(10)
def test_dict_round_trip(shell):
    assert surface_from_dict(shell.to_dict()) == shell


@pytest.mark.parametrize("radius", [0, -1.0, np.nan, np.inf, "0.1", True, None, (0.1, 0.2)])
def test_bad_radius(radius):
    with pytest.raises(rr.ParameterError, match=r"^radius is .*greater than zero"):
        rr.Sphere(radius)


BAD_AXES: list[Any] = [(0.1, 0.2), (0.1, 0.2, 0.0), (0.1, 0.2, -1), (1, 2, np.nan), (1, 2, np.inf),
                       0.1, "abc", ("1", "2", "3"), (True, True, True), None]  # fmt: skip


@pytest.mark.parametrize("axes", BAD_AXES, ids=repr)
def test_bad_semi_axes(axes):
    with pytest.raises(rr.ParameterError, match=r"^semi_axes (is|has)"):
        rr.Ellipsoid(axes)


def test_unknown_shell():
    with pytest.raises(rr.ParameterError, match=r"'cube': known are .*ellipsoid, .*sphere"):
        surface_from_dict({"type": "cube"})
