"""Closed loops: a four-bar linkage against its closed form, and drifts by differences."""

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from rrrobot.machines import FramesCoincide, Joint, Link, Machine, Mechanism, Tree
from rrrobot.machines.tree import flat
from tests.test_machines_rows import drift_by_differences, two_links

GROUND, CRANK, COUPLER, ROCKER = 0.5, 0.15, 0.45, 0.35


def four_bar(crank):
    """Angles of coupler and rocker in the world (open branch) for a crank from pivot to pivot."""
    pin_at = CRANK * np.array((np.cos(crank), np.sin(crank)))
    reach = np.array((GROUND, 0.0)) - pin_at
    far = np.hypot(*reach)
    inner = np.arccos((COUPLER**2 + far**2 - ROCKER**2) / (2 * COUPLER * far))
    coupler = np.arctan2(reach[1], reach[0]) + inner
    end = pin_at + COUPLER * np.array((np.cos(coupler), np.sin(coupler)))
    return coupler, np.arctan2(end[1], end[0] - GROUND)


def linkage(**parts):
    bars = {name: Link(name, 0.2, flat(1e-3), (length / 2, 0, 0)) for name, length in
            (("crank", CRANK), ("coupler", COUPLER), ("rocker", ROCKER))}  # fmt: skip
    tree = Tree(
        Link("frame", 1.0, flat(0.1)),
        [
            Joint("drive", "frame", bars["crank"]),
            Joint("elbow", "crank", bars["coupler"], (CRANK, 0, 0)),
            Joint("pivot", "frame", bars["rocker"], (GROUND, 0, 0)),
        ],
        root="planar",
        frames=[("coupler_end", "coupler", (COUPLER, 0, 0)),
                ("rocker_end", "rocker", (ROCKER, 0, 0))],
    )  # fmt: skip
    model = tree.model()
    frame = model.getFrameId
    rows = (
        FramesCoincide(model, frame("coupler_end"), frame("rocker_end"), **parts),
        FramesCoincide(model, 0, frame("frame"), welded=True, name="bolts"),
    )
    return Machine(name="four_bar", title="a four-bar linkage", tree=tree,
                   model=Mechanism(model, rows, motors=("drive",)))  # fmt: skip


def closed(crank):
    coupler, rocker = four_bar(crank)
    return {"elbow": coupler - crank, "pivot": rocker}


def turning(t):
    return np.array((0.4 + 3.0 * t,)), np.array((3.0,)), np.zeros(1)


@pytest.mark.parametrize("parts", [{}, {"along": ((1, 0, 0), (0, 1, 0))}])
def test_a_four_bar_linkage_moves_as_its_closed_form(parts):
    bar = linkage(**parts)
    crank = rr.CallableGait(turning, n_legs=1, check_span=(0.0, 2.2))
    t = bar.simulate(crank, 2.2, passive=closed(0.4), sample_interval=0.1)
    at = bar.model.coordinates.joint
    for time, state in zip(t.time, t.states, strict=True):
        for name, angle in closed(0.4 + 3.0 * time).items():
            off = state[at[name]][0] - angle
            assert abs((off + np.pi) % (2 * np.pi) - np.pi) < 1e-9
    assert t.gap.max() < 1e-12 > t.violation.max()
    assert np.abs(t.pose).max() < 1e-12


def test_a_free_four_bar_linkage_keeps_its_energy_and_its_power():
    bar = linkage(along=((1, 0, 0), (0, 1, 0)))
    t = bar.simulate(None, 3.0, shape=(0.4,), shape_rates=(2.0,), passive=closed(0.4),
                     sample_interval=0.1)  # fmt: skip
    assert np.abs(t.energy / t.energy[0] - 1).max() < 1e-10
    assert t.gap.max() < 1e-12 > t.violation.max()
    # Driven, what the motor puts in is what the energy gains: no loop does work.
    crank = rr.CallableGait(turning, n_legs=1, check_span=(0.0, 1.0))
    t = bar.simulate(crank, 1.0, passive=closed(0.4), sample_interval=1e-3)
    power = 3.0 * t.joint_torques[:, 0]
    gained = np.diff(t.energy)[1:-1]
    middle = (-power[:-3] + 13 * power[1:-2] + 13 * power[2:-1] - power[3:]) * 1e-3 / 24
    np.testing.assert_allclose(gained, middle, atol=1e-9)


def test_a_loop_that_is_open_at_the_start_is_refused():
    bar = linkage()
    with pytest.raises(rr.ConstraintError, match="off the constraint 'loop'"):
        bar.simulate(None, 1.0, shape=(0.4,), passive={"elbow": 0.3, "pivot": 1.0})
    with pytest.raises(rr.ConstraintError, match="a loop joins two"):
        FramesCoincide(bar.model.model, 3, 3)


@pytest.mark.parametrize("welded", [False, True])
def test_drift_of_a_loop(welded):
    model = two_links()
    loop = FramesCoincide(model, model.getFrameId("hub"), model.getFrameId("tip"), welded=welded)
    rng = np.random.default_rng(4)
    q, v = pin.randomConfiguration(model, -np.ones(8), np.ones(8)), rng.normal(size=7)
    found = loop.evaluate(model.createData(), q, v)
    np.testing.assert_allclose(found.drift, drift_by_differences(loop, model, q, v), atol=2e-8)
