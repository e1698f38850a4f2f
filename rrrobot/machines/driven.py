"""Balls that are driven from inside: by a pendulum, by rotors, by a vehicle."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import vector
from rrrobot.constraints import RollingContact
from rrrobot.contact.surfaces import Sphere
from rrrobot.drive.gaits import CallableGait, SinusoidalGait
from rrrobot.machines.looks import BLUE, DARK, ball, box, rod, rotor
from rrrobot.machines.machine import Machine
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.tree import Joint, Link, Tree
from rrrobot.rows import RelativeRate


def pendulum_ball(
    *,
    r: float = 0.2,
    ms: float = 0.6,
    Is: float = 0.016,
    my: float = 0.2,
    Iy: ArrayLike = (2e-4, 3e-4, 2e-4),
    mp: float = 1.5,
    lp: float = 0.12,
    Ip: ArrayLike = (4e-4, 5e-4, 3e-4),
) -> Machine:
    """A ball with a pendulum at its centre, on a yoke: shape (drive about y, tilt about x).

    Args:
        r, ms, Is: the shell's radius [m], mass [kg], inertia about its centre [kg m^2].
        my, Iy: the yoke's mass and moments (3,).
        mp, lp, Ip: the pendulum's mass, its centre below the ball's [m], moments about it (3,).

    Example:
        >>> import rrrobot as rr
        >>> ball = rr.machines.pendulum_ball()
        >>> a = ball.evaluate(shape=(0.3, 0.0), shape_accelerations=(0.0, 0.0))
        >>> a.multipliers["contact"].shape
        (3,)
    """
    bob = (rod("z", 0.05 * r, lp, (0, 0, -lp / 2)), ball(0.25 * r, (0, 0, -lp)))
    pendulum = Link("pendulum", mp, vector("Ip", Ip, 3, "kg m^2"), (0.0, 0.0, -lp), bob)
    bar = (rod("y", 0.04 * r, 1.9 * r, colour=BLUE),)
    yoke = Link("yoke", my, vector("Iy", Iy, 3, "kg m^2"), looks=bar)
    tree = Tree(
        Link("shell", ms, Is),
        [
            Joint("drive", "shell", yoke, axis="y"),
            Joint("tilt", "yoke", pendulum, axis="x"),
        ],
    )
    model = tree.model()
    contact = RollingContact(model, model.getFrameId("shell"), Sphere(r))

    def forward(t: float) -> tuple[ArrayLike, ArrayLike, ArrayLike]:
        s, c = np.sin(2 * t), np.cos(2 * t)
        return (
            (0.6 * t - 0.3 * s, 0.2 * (1 - c)),
            (0.6 - 0.6 * c, 0.4 * s),
            (1.2 * s, 0.8 * c),
        )

    return Machine(
        name="pendulum_ball",
        title="pendulum ball: a pendulum drives and tilts inside",
        tree=tree,
        model=Mechanism(model, (contact,), motors=("drive", "tilt")),
        gaits={"spin_up": CallableGait(forward, n_legs=2, name="spin_up")},
        shape=(0.0, 0.0),
    )


def rotor_ball(
    *,
    m: float = 1.0,
    r: float = 0.15,
    I: float = 0.009,  # noqa: E741
    Jr: float = 8e-4,
) -> Machine:
    """A balanced ball with three rotors on axes through its centre (Bhattacharya, Agrawal).

    The momentum about the contact is constant, so from rest the rotors alone move it; which way
    depends on where the ball's axes point.

    Args:
        m, r, I: mass [kg], radius [m] and inertia about the centre, rotors locked [kg m^2].
        Jr: spin inertia of each rotor [kg m^2].

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.rotor_ball().model.motors
        ('rotor_x', 'rotor_y', 'rotor_z')
    """
    # A rotor spins about its own axis only, and what it has across is part of I.
    tree = Tree(
        Link("shell", m, np.full(3, I - Jr)),
        [
            Joint(
                f"rotor_{k}",
                "shell",
                Link(f"wheel_{k}", 0.0, np.eye(3)[i] * Jr, looks=rotor(k, (0.4 + 0.15 * i) * r)),
                axis=k,  # type: ignore[arg-type]
            )
            for i, k in enumerate("xyz")
        ],
    )
    model = tree.model()
    contact = RollingContact(model, model.getFrameId("shell"), Sphere(r))
    return Machine(
        name="rotor_ball",
        title="rotor ball: three rotors inside",
        tree=tree,
        model=Mechanism(model, (contact,), motors=("rotor_x", "rotor_y", "rotor_z")),
        gaits={
            "circle": SinusoidalGait(
                offset=0.0,
                amplitude=(6.0, 6.0, 0.0),
                angular_frequency=2.0,
                phase=(0.0, np.pi / 2, 0.0),
            )
        },
        shape=(0.0, 0.0, 0.0),
    )


def sphericle(
    *,
    r: float = 0.2,
    rho: float = 0.18,
    ms: float = 0.5,
    Is: float = 1 / 75,
    mv: float = 1.2,
    Iv: ArrayLike = (3e-3, 4e-3, 2.5e-3),
    d: float = 0.12,
) -> Machine:
    """The Sphericle of Bicchi: a unicycle that drives inside a ball.

    The vehicle hangs on a spherical joint at the centre, its wheels on the inner radius: relative
    to the ball it turns by (0, -u1 / rho, u2) in its own axes, u1 its speed and u2 its rate of
    turn. Their integrals are the "shape" that a gait gives; the vehicle's orientation is the joint
    "vehicle", a quaternion relative to the ball.

    Args:
        r, ms, Is: the shell's radius [m], mass [kg], inertia about its centre [kg m^2].
        rho: the inner radius, to where the wheels touch [m].
        mv, Iv, d: the vehicle's mass, moments about its centre (3,), which is d below the ball's.

    Example:
        >>> import rrrobot as rr
        >>> ball = rr.machines.sphericle()
        >>> ball.simulate(ball.gaits["weave"], 3.0).pose[-1, :2].round(6).tolist()
        [0.45183, 0.236]
    """
    wheel = 0.5 * (rho - d)
    wheels = (rod("y", wheel, 0.02, (0, y, wheel - 0.97 * rho), DARK) for y in (-0.05, 0.05))
    car = (box((0.7 * d, 0.07, 0.2 * d), (0, 0, -d)), *wheels)
    vehicle = Link("unicycle", mv, vector("Iv", Iv, 3, "kg m^2"), (0.0, 0.0, -d), car)
    tree = Tree(Link("shell", ms, Is), [Joint("vehicle", "shell", vehicle, kind="ball")])
    model = tree.model()
    shell, inner = (model.getFrameId(name) for name in ("shell", "unicycle"))
    contact = RollingContact(model, shell, Sphere(r))
    rates = ((0.0, 0.0), (-1.0 / rho, 0.0), (0.0, 1.0))

    def weave(t: float) -> tuple[ArrayLike, ArrayLike, ArrayLike]:
        return (
            (0.15 * (t - np.sin(2 * t) / 2), 0.6 * (1 - np.cos(t))),
            (0.15 * (1 - np.cos(2 * t)), 0.6 * np.sin(t)),
            (0.3 * np.sin(2 * t), 0.6 * np.cos(t)),
        )

    return Machine(
        name="sphericle",
        title="Sphericle: a unicycle inside a ball",
        tree=tree,
        model=Mechanism(model, (contact,), drives=(RelativeRate(model, shell, inner, rates),)),
        gaits={"weave": CallableGait(weave, n_legs=2, name="weave")},
    )
