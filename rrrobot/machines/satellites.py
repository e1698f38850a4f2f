"""Bodies afloat: the planar three-link satellite and the falling cat."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.drive.gaits import CallableGait, SinusoidalGait
from rrrobot.machines.looks import BLUE, ORANGE, SAND, Look, ball, box, rod
from rrrobot.machines.machine import Machine
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.tree import Joint, Link, Tree, flat


def satellite(
    *,
    m0: float = 10.0,
    I0: float = 0.5,
    h: float = 0.3,
    m1: float = 1.5,
    I1: float = 0.03,
    l1: float = 0.25,
    m2: float = 1.0,
    I2: float = 0.02,
    l2: float = 0.2,
) -> Machine:
    """A planar body with an arm at each end: its arms' swing turns it, momentum zero.

    Arm 1 is hinged at (-h, 0), arm 2 at (h, 0), and at angle zero each points outwards.

    Args:
        m0, I0: the base [kg, kg m^2].
        h: to the hinges [m].
        m1, I1, l1, m2, I2, l2: each arm, its mass centre l from the hinge.

    Example:
        >>> import rrrobot as rr
        >>> body = rr.machines.satellite()
        >>> t = body.simulate(body.gaits["circle"], 6.283185307179586)
        >>> round(t.pose[-1, 2], 8)
        np.float64(-0.01660495)
    """
    w = 0.2 * h
    arms = [
        (box((2 * abs(x), w, w), (x, 0, 0), colour), ball(w, (2 * x, 0, 0), colour))
        for x, colour in ((-l1, BLUE), (l2, ORANGE))
    ]
    tree = Tree(
        Link("base", m0, flat(I0), looks=(box((2 * h, h, 0.5 * h)),)),
        [
            Joint("arm_1", "base", Link("link_1", m1, flat(I1), (-l1, 0, 0), arms[0]), (-h, 0, 0)),
            Joint("arm_2", "base", Link("link_2", m2, flat(I2), (l2, 0, 0), arms[1]), (h, 0, 0)),
        ],
        root="planar",
        height=h,
    )
    swing = SinusoidalGait(
        offset=(0.8, -0.6), amplitude=(0.5, 0.7), angular_frequency=1.0, phase=(pi / 2, 0.0)
    )
    return Machine(
        name="satellite",
        title="planar satellite with two arms",
        tree=tree,
        model=Mechanism(tree.model(0.0), motors=("arm_1", "arm_2")),
        gaits={"circle": swing},
        shape=(0.8, -0.6),
    )


def falling_cat(
    *, m: float = 1.0, A: float = 0.01, B: float = 0.05, d: float = 0.2, beta: float = 0.6
) -> Machine:
    """The cat of Kane and Scher: two equal halves, bent at the spine and never twisted.

    Halves are joined by -Rx(alpha) - Ry(2 beta) - Rx(-alpha) -, shape (a1, a2, a3) = (alpha, 2
    beta, -alpha). One circle of alpha at a constant bend rolls it about its spine by
    2 pi (A cos beta / (A cos^2 beta + B sin^2 beta) - 1). Links between the halves have no mass:
    the motion is determined all the same, by the full KKT matrix.

    Args:
        m: mass of each half [kg].
        A, B: its inertia along and across the spine about its centre [kg m^2].
        d: from its centre to the joint [m].
        beta: half the bend in the gait "roll" [rad].

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.falling_cat().model.n_shape
        3
    """
    half = (A, B, B)
    rear = Link("rear", m, half, (d, 0.0, 0.0), _half_a_cat(d, ORANGE))
    tree = Tree(
        Link("front", m, half, (-d, 0.0, 0.0), _half_a_cat(-d, SAND)),
        [
            Joint("turn", "front", Link("spine_1"), axis="x"),
            Joint("bend", "spine_1", Link("spine_2"), axis="y"),
            Joint("turn_back", "spine_2", rear, axis="x"),
        ],
    )

    def smooth(x: float) -> tuple[float, float, float]:
        if not 0.0 < x < 1.0:
            return float(x >= 1.0), 0.0, 0.0
        return (
            x**3 * (10 - 15 * x + 6 * x * x),
            30 * (x * (1 - x)) ** 2,
            60 * x * (1 - x) * (1 - 2 * x),
        )

    def roll(t: float) -> tuple[ArrayLike, ArrayLike, ArrayLike]:
        # Bend in the first second, turn in the second, unbend in the third.
        up, turn, down = smooth(t), smooth(t - 1), smooth(t - 2)
        bends = 2 * beta * (np.array(up) - np.array(down))
        turns = 2 * pi * np.array(turn)
        return tuple(np.array((a, b, -a)) for a, b in zip(turns, bends, strict=True))  # type: ignore[return-value]

    return Machine(
        name="falling_cat",
        title="falling cat: it turns over without momentum",
        tree=tree,
        model=Mechanism(tree.model(0.0), motors=("turn", "bend", "turn_back")),
        gaits={"roll": CallableGait(roll, n_legs=3, name="roll", check_span=(0.0, 3.0))},
        shape=(0.0, 0.0, 0.0),
    )


def _half_a_cat(d: float, colour: tuple[float, float, float]) -> tuple[Look, ...]:
    """A trunk along x, two feet below, and a head (d < 0) or a tail."""
    size = abs(d)
    trunk = rod("x", 0.3 * size, 1.7 * size, (d, 0, 0), colour)
    feet = (
        rod("z", 0.07 * size, 0.6 * size, (1.5 * d, y, -0.45 * size), colour)
        for y in (-0.2 * size, 0.2 * size)
    )
    end = ball(0.3 * size, (2.1 * d, 0, 0.25 * size), colour)
    if d > 0:
        end = rod("x", 0.05 * size, 0.8 * size, (2.2 * d, 0, 0.1 * size), colour)
    return (trunk, *feet, end)
