"""Long runs: what holds positions and velocities keeps them to 1e-12, over an hour too."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.machines import Joint, Link, Machine, Mechanism, Tree
from tests.pages import numbers
from tests.test_machines_space import zxy

HOUR = 3600.0


def disc():
    return rr.machines.rolling_disc()


def ball_in_a_bowl():
    bowl = rr.Graph(
        lambda x, y: 0.2 * x * x + 0.3 * y * y,
        lambda x, y: (0.4 * x, 0.6 * y),
        lambda x, y: ((0.4, 0.0), (0.0, 0.6)),
    )
    tree = Tree(Link("body", 1.0, 0.4 * 0.1**2))
    model = tree.model()
    contact = rr.constraints.RollingContact(model, model.getFrameId("body"), rr.Sphere(0.1), bowl)
    return Machine(name="bowl", title="a ball in a bowl", tree=tree,
                   model=Mechanism(model, (contact,)))  # fmt: skip


def ball_in_a_ball():
    inner = Link("inner", 0.5, 0.4 * 0.5 * 0.06**2)
    along = (("along", "shell", "x"), ("across", "x", "y"), ("up", "y", "z"))
    slides = [Joint(a, b, Link(c), axis=c, kind="slide") for a, b, c in along]
    joints = [*slides, Joint("turn", "z", inner, kind="ball")]
    tree = Tree(Link("shell", 0.6, 0.016), joints)
    model = tree.model()
    shell, ball = (model.getFrameId(name) for name in ("shell", "inner"))
    rolls = (
        rr.constraints.RollingContact(model, shell, rr.Sphere(0.2)),
        rr.rows.RollingOnBody(model, shell, ball, (0.19, 0.06), inside=True),
    )
    return Machine(name="pair", title="a ball in a ball", tree=tree, model=Mechanism(model, rolls))


def start(make):
    machine = make()
    if make is disc:
        return machine, {"pose": machine.at(zxy(0.4, 0.05, 0.0)), "start": (0.1, 3.5, 0.2)}
    if make is ball_in_a_bowl:
        return machine, {"pose": machine.at((0, 0, 0, 1.0), (0.3, 0.2)), "start": (0, 0, 3.0)}
    up = np.deg2rad(50)
    return machine, {"passive": {"along": 0.13 * np.sin(up), "up": -0.13 * np.cos(up)}}


@pytest.mark.parametrize("make", [disc, ball_in_a_bowl, ball_in_a_ball])
@pytest.mark.parametrize("seconds", [2.0, pytest.param(HOUR, marks=pytest.mark.slow)])
def test_long_runs_keep_positions_and_velocities(make, seconds):
    # Tolerances so loose that the motion itself is off by far more.
    machine, begin = start(make)
    t = machine.simulate(None, seconds, sample_interval=seconds / 20, rtol=1e-7, atol=1e-7, **begin)
    assert t.gap.max() < 1e-12
    assert t.violation.max() < 1e-12
    assert numbers("reference/machines.md", r"both stay within ([\de-]+), at any") == (1e-12,)
    assert np.ptp(t.energy) > 1e-8 * t.energy[0]
    assert len(t) == 21 and t.time[-1] == seconds


def test_without_correction_they_would_not():
    # The rows at the level of accelerations alone drift: what the correction does is seen.
    machine, begin = start(ball_in_a_bowl)
    machine.model.correct = lambda time, state, motion: None
    t = machine.simulate(None, 2.0, sample_interval=1.0, rtol=1e-7, atol=1e-7, **begin)
    assert t.gap.max() > 1e-9 and t.violation.max() > 1e-9
