"""The roller racer of Krishnaprasad and Tsakiris, and the planar Trikke, which adds a rider."""

from __future__ import annotations

import numpy as np

from rrrobot.constraints import Constraint
from rrrobot.drive.gaits import SinusoidalGait
from rrrobot.machines.looks import BLUE, Look, axle, ball, box, rod
from rrrobot.machines.machine import Machine
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.tree import Joint, Link, Tree, flat
from rrrobot.rows import NoSideSlip, RollingWheel


def roller_racer(
    *,
    d1: float = 0.3,
    d2: float = 0.1,
    m1: float = 3.0,
    I1: float = 0.06,
    c1: float = 0.0,
    m2: float = 0.0,
    I2: float = 0.012,
    c2: float = 0.0,
    wheel_radius: float | None = None,
    wheel_mass: float = 0.0,
    half_track: float = 0.08,
) -> Machine:
    """Two links on an axle each, moved by the swing of the joint between them.

    The base frame is at the rear axle; the joint at (d1, 0); the front axle at d2 of its own link,
    behind the joint if d2 < 0. Singular where both axles lie on one line through the joint. With
    one joint it is mixed: momentum, once gained, is not given back by steering alone.

    Args:
        d1, d2: from the axles to the joint [m].
        m1, I1, c1: the rear link's mass [kg], inertia about its centre [kg m^2], centre [m].
        m2, I2, c2: the front link's.
        wheel_radius: of four real wheels that spin [m]; none unless given: knife edges alone.
        wheel_mass: of each, a uniform disc [kg].
        half_track: from the middle of an axle to a wheel [m].

    Example:
        >>> import rrrobot as rr
        >>> racer = rr.machines.roller_racer()
        >>> racer.evaluate(shape=(0.6,), joint_torques=(0.05,)).shape_accelerations.round(4)
        array([4.5489])
    """
    radius = wheel_radius or 0.15 * d1
    looks = _looks(d1, d2, half_track, radius)
    fork = Link("fork", m2, flat(I2), (c2, 0, 0), looks[1])
    joints = [Joint("steering", "body", fork, (d1, 0, 0))]
    frames = [("rear_axle", "body", (0.0, 0.0, 0.0)), ("front_axle", "fork", (d2, 0.0, 0.0))]
    wheels: list[tuple[str, str, str]] = []
    if wheel_radius is not None:
        spin = wheel_mass * wheel_radius**2 / 2
        for end, link, along in (("rear", "body", 0.0), ("front", "fork", d2)):
            for side, across in (("left", half_track), ("right", -half_track)):
                name, at = f"{end}_{side}", (along, across, 0.0)
                wheel = Link(f"{name}_wheel", wheel_mass, (spin / 2, spin, spin / 2))
                joints.append(Joint(name, link, wheel, at, "y"))
                frames.append((f"{name}_hub", link, at))
                wheels.append((f"{end} {side} roll", f"{name}_hub", f"{name}_wheel"))
    body = Link("body", m1, flat(I1), (c1, 0, 0), looks[0])
    tree = Tree(body, joints, root="planar", frames=frames, height=radius)
    model = tree.model()
    rows: list[Constraint] = [
        NoSideSlip(model, model.getFrameId(f"{end}_axle"), name=end) for end in ("rear", "front")
    ]
    for row, hub, turning in wheels:
        carrier, wheel_frame = model.getFrameId(hub), model.getFrameId(turning)
        rows.append(RollingWheel(model, carrier, wheel_frame, float(wheel_radius or 0.0), name=row))
    gait = SinusoidalGait(offset=(0.2,), amplitude=(0.5,), angular_frequency=2.0, phase=(0.0,))
    return Machine(
        name="roller_racer",
        title="roller racer: two axles, one swinging joint",
        tree=tree,
        model=Mechanism(model, rows, motors=("steering",)),
        gaits={"wiggle": gait},
        shape=(0.2,),
    )


def trikke(
    *,
    d1: float = 0.55,
    d2: float = -0.06,
    m1: float = 4.0,
    I1: float = 0.15,
    c1: float = 0.2,
    m2: float = 1.2,
    I2: float = 0.02,
    c2: float = 0.02,
    b: float = 0.15,
    lr: float = 0.25,
    mr: float = 2.0,
    Ir: float = 0.01,
) -> Machine:
    """A roller racer with a rider: a mass that swings on an arm of the rear link.

    After Chitta, Cheng, Frazzoli and Kumar; their steering axis is inclined, this one is vertical.
    Shape (phi, gamma): steering and rider.

    Args:
        d1, d2, m1, I1, c1, m2, I2, c2: as of `roller_racer`.
        b: the rider's hinge on the rear link (b, 0) [m].
        lr, mr, Ir: the arm [m], the rider's mass [kg], and inertia about its centre [kg m^2].

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.trikke().model.motors
        ('steering', 'rider')
    """
    looks = _looks(d1, d2, 0.15 * d1, 0.1 * d1)
    rider = (box((lr, 0.03, 0.02), (lr / 2, 0, 0.15 * d1), BLUE), ball(0.06, (lr, 0, 0.15 * d1)))
    tree = Tree(
        Link("body", m1, flat(I1), (c1, 0, 0), looks[0]),
        [
            Joint("steering", "body", Link("fork", m2, flat(I2), (c2, 0, 0), looks[1]), (d1, 0, 0)),
            Joint("rider", "body", Link("arm", mr, flat(Ir), (lr, 0, 0), rider), (b, 0, 0)),
        ],
        root="planar",
        height=0.1 * d1,
        frames=[("rear_axle", "body", (0.0, 0, 0)), ("front_axle", "fork", (d2, 0, 0))],
    )
    model = tree.model()
    edges = [
        NoSideSlip(model, model.getFrameId(f"{end}_axle"), name=end) for end in ("rear", "front")
    ]
    swing = SinusoidalGait(
        offset=0.0, amplitude=(0.4, 0.6), angular_frequency=2.0, phase=(0.0, np.pi / 2)
    )
    return Machine(
        name="trikke",
        title="Trikke: a roller racer with a rider who leans",
        tree=tree,
        model=Mechanism(model, edges, motors=("steering", "rider")),
        gaits={"ride": swing},
        shape=(0.2, 0.0),
    )


def _looks(d1: float, d2: float, track: float, radius: float) -> tuple[tuple[Look, ...], ...]:
    """Of the body and of the fork, an axle each."""
    up = 0.5 * radius
    body = box((d1, 0.1 * d1, up), (d1 / 2, 0.0, up))
    long = abs(d2) + 0.3 * d1
    bar = (box((long, 0.08 * d1, up), (d2 / 2, 0, 2 * up), BLUE), rod("z", 0.05 * d1, 4 * up))
    return (body, *axle(0.0, track, radius)), (*bar, *axle(d2, track, radius))
