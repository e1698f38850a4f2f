"""An ideal fluid around a neutrally buoyant body: Kirchhoff's added mass, and buoyancy.

The fluid's momentum is (M_A v, J_A w) in body axes, of the body's velocity (v, w) at the centre of
buoyancy. It adds diag(M_A, J_A) to the mass matrix's first block and

    (w x M_A v,   w x J_A w + v x M_A v)

to the bias; buoyancy pushes along +z at the origin. For an ellipsoid the added masses are Lamb's,
closed in the integrals alpha_i = abc int_0^inf dl / ((a_i^2 + l) D), D^2 = prod (a_i^2 + l).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array, finite, vector
from rrrobot.errors import ParameterError
from rrrobot.rotations import skew


@dataclass(frozen=True, eq=False)
class Fluid:
    """What an ideal fluid adds to a body.

    Attributes:
        mass: added mass along each body axis M_A (3,) [kg].
        inertia: added inertia about each J_A (3,) [kg m^2].
        buoyancy: force along +z at the body's origin [N].

    Example:
        >>> from rrrobot.machines.fluid import Fluid
        >>> Fluid.of_ellipsoid((0.5, 0.2, 0.15), density=1000.0).mass.round(3).tolist()
        [8.018, 37.729, 65.829]
    """

    mass: Array
    inertia: Array
    buoyancy: float = 0.0

    @classmethod
    def of_ellipsoid(cls, semi_axes: ArrayLike, *, density: float, buoyancy: float = 0.0) -> Fluid:
        """Of an ellipsoid with semi-axes (a, b, c) [m] in a fluid of a density [kg/m^3]."""
        from scipy.special import elliprd

        axes = vector("semi_axes", semi_axes, 3, "m")
        if not np.all(axes > 0):
            raise ParameterError(f"semi_axes is {axes.tolist()} m: each must be above zero.")
        finite("density", density, "kg/m^3", at_least=0)
        squares, volume = axes**2, 4 * pi / 3 * float(np.prod(axes))
        # int dl / ((a^2 + l) D) = (2/3) R_D of the other two squares and a^2.
        alpha = np.array(
            [
                2 / 3 * np.prod(axes) * elliprd(squares[i - 2], squares[i - 1], squares[i])
                for i in range(3)
            ]
        )
        mass = density * volume * alpha / (2 - alpha)
        inertia = np.zeros(3)
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            apart, sum_ = squares[j] - squares[k], squares[j] + squares[k]
            twist = alpha[k] - alpha[j]
            if apart != 0:
                inertia[i] = density * volume / 5 * apart**2 * twist / (2 * apart - sum_ * twist)
        return cls(mass, inertia, buoyancy)

    @property
    def matrix(self) -> Array:
        """diag(M_A, J_A) (6, 6)."""
        return np.diag(np.concatenate((self.mass, self.inertia)))

    def bias(self, rotation: Array, body_velocity: Array) -> Array:
        """Bias (6,) in body axes of R_world_body and (v, w) in body axes; less the buoyancy."""
        v, w = body_velocity[:3], body_velocity[3:6]
        turn, p = skew(w), self.mass * v
        force = turn @ p - self.buoyancy * rotation[2]
        return np.concatenate((force, turn @ (self.inertia * w) + skew(v) @ p))
