"""The Chaplygin sleigh: a body on one knife edge, and with a rotor that drives it."""

from __future__ import annotations

from rrrobot.drive.gaits import SinusoidalGait
from rrrobot.machines.looks import DARK, ball, box, rotor
from rrrobot.machines.machine import Machine
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.tree import Joint, Link, Tree, flat
from rrrobot.rows import NoSideSlip


def chaplygin_sleigh(
    *,
    m: float = 1.5,
    I: float = 0.04,  # noqa: E741
    a: float = 0.2,
    Jr: float = 0.0,
) -> Machine:
    """A body on a knife edge, its mass centre ahead of it by a.

    Free, it keeps its energy, turns by pi sqrt(1 + I / (m a^2)) in all of time, and ends straight,
    the mass centre ahead: v = s tanh k(t + t0), omega = s / sqrt(B) sech k(t + t0).

    Args:
        m: mass, the rotor's with it [kg].
        I: inertia about the mass centre, without the rotor's spin [kg m^2].
        a: from the knife edge to the mass centre [m].
        Jr: spin inertia of a rotor at the mass centre; none unless given [kg m^2].

    Example:
        >>> import rrrobot as rr
        >>> sleigh = rr.machines.chaplygin_sleigh(Jr=0.01)
        >>> a = sleigh.evaluate(shape=(0,), body_velocity=(0.4, 0, 1.3), shape_accelerations=(5,))
        >>> round(a.multipliers["blade"], 10)
        0.2181818182
    """
    wheel = Link("wheel", 0.0, flat(Jr), looks=rotor("z", 0.4 * a, (0, 0, 0.3 * a)))
    joints = [Joint("rotor", "body", wheel, (a, 0, 0))] if Jr else []
    skids = (ball(0.1 * a, (1.4 * a, y, 0), DARK) for y in (-0.4 * a, 0.4 * a))
    blade_look = box((0.6 * a, 0.03 * a, 0.2 * a), colour=DARK)
    looks = (box((1.8 * a, a, 0.15 * a), (0.7 * a, 0, 0.15 * a)), blade_look, *skids)
    tree = Tree(Link("body", m, flat(I), (a, 0, 0), looks), joints, root="planar", height=0.1 * a)
    model = tree.model()
    blade = NoSideSlip(model, model.getFrameId("body"), name="blade")
    spin = SinusoidalGait(offset=(0.0,), amplitude=(1.5,), angular_frequency=3.0, phase=(0.0,))
    return Machine(
        name="chaplygin_sleigh",
        title="Chaplygin sleigh: a body on one knife edge",
        tree=tree,
        model=Mechanism(model, (blade,), motors=("rotor",) if Jr else ()),
        gaits={"shake": spin} if Jr else {},
        shape=(0.0,) if Jr else (),
        velocity=(0.4, 0.0, 1.3),
    )
