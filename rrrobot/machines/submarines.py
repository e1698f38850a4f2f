"""A submarine in an ideal fluid (Leonard): rotors inside, or a mass that moves."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import vector
from rrrobot.contact.surfaces import Ellipsoid
from rrrobot.drive.gaits import SinusoidalGait
from rrrobot.errors import ParameterError
from rrrobot.machines.fluid import Fluid
from rrrobot.machines.looks import ball, rotor
from rrrobot.machines.machine import Machine
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.tree import Joint, Link, Tree


def submarine(
    *,
    semi_axes: ArrayLike = (0.5, 0.2, 0.15),
    density: float = 1000.0,
    I: ArrayLike = (0.6, 2.4, 2.6),  # noqa: E741
    h: float = 0.02,
    Jr: ArrayLike = (0.02, 0.03, 0.03),
    mp: float = 0.0,
    gravity: float = 9.81,
) -> Machine:
    """A neutrally buoyant ellipsoid with three rotors, or with a mass on three slides.

    Kirchhoff's equations with added mass: (P, Pi) = (M + M_A)(v, omega) + (0, Jr phi_dot), P_dot =
    P x omega, Pi_dot = Pi x omega + P x v + m g h z_b x gamma. The base frame is at the centre of
    buoyancy.

    Args:
        semi_axes: (3,) [m].
        density: of the fluid [kg/m^3]; the body's mass is what it displaces.
        I: moments about the centre of buoyancy, rotors locked (3,) [kg m^2].
        h: mass centre below the centre of buoyancy [m].
        Jr: spin inertia of the rotors about x, y, z (3,); not with a moving mass [kg m^2].
        mp: a mass on slides along x, y, z instead of rotors, itself buoyant [kg].
        gravity: [m/s^2].

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.submarine().model.fluid.mass.round(4).tolist()
        [8.0181, 37.7287, 65.8286]
    """
    axes, spins = vector("semi_axes", semi_axes, 3, "m"), vector("Jr", Jr, 3, "kg m^2")
    m = density * 4 / 3 * pi * float(np.prod(axes))
    about = np.diag(vector("I", I, 3, "kg m^2")) - m * h**2 * np.diag((1.0, 1.0, 0.0))
    if mp:
        slides = []
        for i, k in enumerate("xyz"):
            parent = "hull" if i == 0 else f"slide_{'xyz'[i - 1]}"
            seen = (ball(0.3 * float(axes.min())),) if k == "z" else ()
            part = Link(f"slide_{k}", mp if k == "z" else 0.0, looks=seen)
            slides.append(Joint(f"move_{k}", parent, part, axis=k, kind="slide"))  # type: ignore[arg-type]
        joints, motors = slides, ("move_x", "move_y", "move_z")
        if gravity and h:
            raise ParameterError("a moving mass is for h = 0 and gravity = 0: it floats itself.")
        gaits = {
            "circle": SinusoidalGait(
                offset=(0.05, 0.0, 0.04),
                amplitude=(0.15, 0.06, 0.0),
                angular_frequency=1.0,
                phase=(pi / 2, 0.0, 0.0),
            )
        }
        shape = (0.05, 0.0, 0.04)
    else:
        about = about - np.diag(spins)
        joints = [
            Joint(
                f"rotor_{k}",
                "hull",
                Link(
                    f"wheel_{k}",
                    0.0,
                    np.eye(3)[i] * spins,
                    looks=rotor(k, (0.3 + 0.15 * i) * float(axes.min())),
                ),
                axis=k,  # type: ignore[arg-type]
            )
            for i, k in enumerate("xyz")
        ]
        motors = ("rotor_x", "rotor_y", "rotor_z")
        gaits = {
            "turn": SinusoidalGait(
                offset=0.0,
                amplitude=(10.0, 8.0, 5.0),
                angular_frequency=(2.0, 2.0, 1.0),
                phase=(0.0, 1.0, 0.5),
            )
        }
        shape = (0.0, 0.0, 0.0)
    tree = Tree(Link("hull", m, about, (0.0, 0.0, -h)), joints, skin=Ellipsoid(tuple(axes)))
    acts = 0.0 if mp else gravity
    fluid = Fluid.of_ellipsoid(axes, density=density, buoyancy=m * acts)
    return Machine(
        name="submarine",
        title="submarine in an ideal fluid" + (", with a moving mass" if mp else ", with rotors"),
        tree=tree,
        model=Mechanism(tree.model(acts), motors=motors, fluid=fluid),
        gaits=gaits,
        shape=shape,
    )
