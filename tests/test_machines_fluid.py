"""Added masses of ellipsoids: closed elliptic integrals against quadrature, closed forms, Lamb."""

import numpy as np
import pytest
from scipy.integrate import quad

import rrrobot as rr
from rrrobot.machines.fluid import Fluid


def added(axes, density):
    """Lamb's integrals by quadrature, l = (t / (1 - t))^2, and his formulas of them."""
    squares, volume = np.square(axes), 4 / 3 * np.pi * np.prod(axes)

    def alpha(i):
        def integrand(t):
            root = t / (1 - t)
            D = np.sqrt(np.prod(squares + root**2))
            return 2 * np.prod(axes) * root / ((squares[i] + root**2) * D * (1 - t) ** 2)

        return quad(integrand, 0, 1, epsabs=1e-14, epsrel=1e-13, limit=200)[0]

    a = np.array([alpha(i) for i in range(3)])
    assert a.sum() == pytest.approx(2, abs=1e-13)
    mass, inertia = density * volume * a / (2 - a), np.zeros(3)
    for i in range(3):
        j, k = i - 2, i - 1
        minus, plus = squares[j] - squares[k], squares[j] + squares[k]
        if minus:
            twist = a[k] - a[j]
            inertia[i] = density * volume / 5 * minus**2 * twist / (2 * minus - plus * twist)
    return mass, inertia


@pytest.mark.parametrize("axes", [(0.5, 0.2, 0.15), (0.1, 0.7, 0.3), (1.0, 1.0, 0.2), (2, 1, 1)])
def test_added_mass_of_ellipsoids_is_the_quadrature(axes):
    fluid = Fluid.of_ellipsoid(axes, density=1000.0)
    mass, inertia = added(axes, 1000.0)
    np.testing.assert_allclose(fluid.mass, mass, rtol=1e-9)
    np.testing.assert_allclose(fluid.inertia, inertia, rtol=1e-9, atol=1e-9 * inertia.max())


@pytest.mark.parametrize(
    ("ratio", "printed"),
    [(1.5, (0.305, 0.621, 0.094)), (2.0, (0.209, 0.702, 0.240)), (3.99, (0.082, 0.860, 0.608))],
)
def test_added_mass_of_spheroids(ratio, printed):
    """Both closed forms of a prolate spheroid; Lamb's table of k1, k2, k' was reckoned by hand."""
    fluid = Fluid.of_ellipsoid((ratio, 1.0, 1.0), density=1.0)
    mass, e = 4 / 3 * np.pi * ratio, np.sqrt(1 - ratio**-2)
    long = 2 * (1 - e * e) / e**3 * (np.arctanh(e) - e)
    across = 1 / e**2 - (1 - e * e) / e**3 * np.arctanh(e)
    np.testing.assert_allclose(
        fluid.mass / mass, [a / (2 - a) for a in (long, across, across)], rtol=1e-12
    )
    turn = e**4 * (across - long) / ((2 - e * e) * (2 * e * e - (2 - e * e) * (across - long)))
    assert fluid.inertia[1] / (mass * (ratio**2 + 1) / 5) == pytest.approx(turn, rel=1e-11)
    found = (*fluid.mass[:2] / mass, turn)
    np.testing.assert_allclose(found, printed, atol=2.3e-3)


def test_added_mass_of_a_ball_is_half_of_what_it_displaces():
    ball = Fluid.of_ellipsoid((0.3, 0.3, 0.3), density=1000.0)
    np.testing.assert_allclose(ball.mass, 0.5 * 4 / 3 * np.pi * 0.3**3 * 1000, rtol=1e-12)
    np.testing.assert_array_equal(ball.inertia, 0)
    with pytest.raises(rr.ParameterError, match="each must be above zero"):
        Fluid.of_ellipsoid((0.3, 0.0, 0.3), density=1000.0)
