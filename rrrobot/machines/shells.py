"""Bodies that roll on a plane by themselves: disc and torus, balls, spheres, the rattleback."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import vector
from rrrobot.constraints import RollingContact
from rrrobot.contact.discs import Torus
from rrrobot.contact.ground import Plane
from rrrobot.contact.surfaces import Ellipsoid, Sphere, Surface
from rrrobot.drive.damping import BodyRateDamping
from rrrobot.machines.looks import BLUE, ORANGE, box, rod
from rrrobot.machines.machine import Machine
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.tree import Link, Tree
from rrrobot.rows import RollingOnTurntable


def roller(
    name: str,
    title: str,
    surface: Surface,
    link: Link,
    *,
    gravity: float = 9.81,
    slope: float = 0.0,
    turntable: float | None = None,
    sigma: float = 0.0,
    velocity: tuple[float, ...] | None = None,
) -> Machine:
    """A single body whose shell, centred at its frame, rolls on a plane."""
    tree = Tree(link)
    model = tree.model(gravity)
    frame = model.getFrameId(link.name)
    ground = Plane((np.sin(slope), 0.0, np.cos(slope)))
    if turntable is None:
        contact = RollingContact(model, frame, surface, ground)
    else:
        contact = RollingOnTurntable(model, frame, surface, ground, rate=turntable)
    damping = BodyRateDamping(sigma, sigma, sigma) if sigma else None
    return Machine(
        name=name,
        title=title,
        tree=tree,
        model=Mechanism(model, (contact,), damping=damping),
        velocity=velocity,
    )


def rolling_disc(
    *, m: float = 1.2, r: float = 0.3, A: float = 0.027, C: float = 0.054, rho: float = 0.0,
    gravity: float = 9.81,
) -> Machine:  # fmt: skip
    """A disc, coin, hoop or torus that rolls on its edge; the axle is the body's y axis.

    Upright it is stable above a spin of sqrt(A m g R0 / (C (C + m R^2))), R0 = r, R = r + rho.

    Args:
        m: mass [kg].
        r: radius, of the circle of the tube's centres if there is a tube [m].
        A, C: inertia across and about the axle [kg m^2].
        rho: radius of the tube; a sharp edge unless given [m].
        gravity: [m/s^2].

    Example:
        >>> import rrrobot as rr
        >>> coin = rr.machines.rolling_disc()
        >>> t = coin.simulate(None, 1.0, start=(0.0, 4.0, 0.0))
        >>> t.pose[-1, :2].round(9).tolist()
        [1.2, 0.0]
    """
    thick = max(2 * rho, 0.05 * r)
    stripe = box((1.8 * (r + rho), 1.1 * thick, 0.15 * r), colour=ORANGE)
    link = Link("wheel", m, (A, C, A), looks=(rod("y", r + rho, thick, colour=BLUE), stripe))
    name = "rolling torus" if rho else "rolling disc"
    title = f"{name}: a wheel by itself, on its edge"
    return roller(
        "rolling_disc", title, Torus(r, rho), link, gravity=gravity, velocity=(0.5, -3.0, 0.2)
    )


def ball_on_slope(*, m: float = 1.0, r: float = 0.1, slope: float = 0.3, k: float = 0.4) -> Machine:
    """A ball of inertia k m r^2 on a slope [rad]: it rolls down x with g sin(slope) / (1 + k).

    Example:
        >>> import rrrobot as rr
        >>> a = rr.machines.ball_on_slope(slope=0.3).evaluate().pose_acceleration
        >>> round(float((a[:3] @ a[:3]) ** 0.5), 10)
        2.0707523052
    """
    link = Link("ball", m, k * m * r**2)
    return roller("ball_on_slope", "ball on a slope: 5/7 g sin", Sphere(r), link, slope=slope)


def turntable_ball(*, m: float = 1.0, r: float = 0.1, rate: float = 2.0, k: float = 0.4) -> Machine:
    """A ball of inertia k m r^2 on a turntable [rad/s]: it circles once in (1 + k) / k turns.

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.turntable_ball().model.rolling.rate
        2.0
    """
    link = Link("ball", m, k * m * r**2)
    return roller(
        "turntable_ball", "ball on a turntable: 7/2 turns", Sphere(r), link, turntable=rate
    )


def chaplygin_sphere(
    *,
    m: float = 1.0,
    r: float = 0.2,
    I: ArrayLike = (0.010, 0.014, 0.018),  # noqa: E741
) -> Machine:
    """A balanced ball of three unlike inertias: its momentum about the contact is constant.

    Args:
        m, r: mass [kg], radius [m].
        I: principal moments about the centre (3,) [kg m^2].

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.chaplygin_sphere().simulate(None, 1.0).energy.shape
        (101,)
    """
    link = Link("ball", m, vector("I", I, 3, "kg m^2"))
    title = "Chaplygin sphere: balanced, three unlike inertias"
    return roller("chaplygin_sphere", title, Sphere(r), link, velocity=(3.0, -2.0, 4.0))


def routh_sphere(
    *, m: float = 1.0, r: float = 0.2, A: float = 0.012, C: float = 0.016, a: float = 0.05
) -> Machine:
    """A ball with an axis of symmetry, its mass centre a below its centre: Jellett and Routh.

    Args:
        m, r: mass [kg], radius [m].
        A, C: inertia about the mass centre, across and about z [kg m^2].
        a: [m].

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.routh_sphere().tree.base.centre
        (0.0, 0.0, -0.05)
    """
    link = Link("ball", m, (A, A, C), (0.0, 0.0, -a))
    title = "Routh sphere: a ball that is heavy below"
    return roller("routh_sphere", title, Sphere(r), link, velocity=(0.5, 1.0, 6.0))


def rattleback(
    *,
    semi_axes: ArrayLike = (0.2, 0.03, 0.02),
    m: float = 1.0,
    h: float = 0.01,
    I: ArrayLike = (2e-4, 16e-4, 17e-4),  # noqa: E741
    Ixy: float = 0.2e-4,
    sigma: float = 0.0,
) -> Machine:
    """The rattleback of Kane and Levinson (1982): spun one way, it rattles and turns back.

    Args:
        semi_axes: of the ellipsoid (3,) [m].
        m: mass [kg].
        h: mass centre below the ellipsoid's centre [m].
        I: moments about the mass centre (3,), z up [kg m^2].
        Ixy: element of the inertia tensor, z up [kg m^2].
        sigma: air's torque -sigma omega [N m s].

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.rattleback().model.rolling.surface
        Ellipsoid(semi_axes=(0.2, 0.03, 0.02))
    """
    inertia = np.diag(vector("I", I, 3, "kg m^2"))
    inertia[0, 1] = inertia[1, 0] = Ixy
    link = Link("stone", m, inertia, (0.0, 0.0, -h))
    surface = Ellipsoid(tuple(vector("semi_axes", semi_axes, 3, "m").tolist()))
    title = "rattleback: it turns back"
    return roller(
        "rattleback", title, surface, link, sigma=sigma, velocity=(0.05, 0.0, 5.0)
    )  # fmt: skip
