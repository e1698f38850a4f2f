"""Constraint rows: drifts against finite differences, second formulations, and a second model."""

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from rrrobot.contact.discs import Torus
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.tree import Joint, Link, Tree
from rrrobot.rows import NoSideSlip, PlanarMotion, RollingOnBody, RollingOnTurntable, RollingWheel


def drift_by_differences(constraint, model, q, v, legs=None, step=1e-5):
    """d(J v)/dt along q(t) at constant v, which is the drift at v_dot = 0."""
    data = model.createData()
    weights = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
    return (
        sum(
            w * constraint.evaluate(data, pin.integrate(model, q, k * step * v), v).residual
            for k, w in weights
        )
        / step
    )


def two_links():
    tree = Tree(
        Link("one", 1.0, (0.1, 0.2, 0.3)),
        [Joint("hinge", "one", Link("two", 0.5, (0.1, 0.1, 0.1)), (0.3, 0.1, -0.2), "y")],
        frames=[("hub", "one", (0.3, 0.1, -0.2)), ("tip", "two", (0.2, 0.1, 0.4))],
    )
    return tree.model()


def kinds(model):
    frame = model.getFrameId
    yield NoSideSlip(model, frame("tip"), normal=(0.0, 0.6, 0.8))
    yield RollingWheel(model, frame("hub"), frame("two"), 0.07)
    yield RollingOnTurntable(model, frame("one"), rr.Ellipsoid((0.3, 0.2, 0.25)), rate=0.7)
    yield PlanarMotion(model, frame("one"))
    yield rr.constraints.RollingContact(model, frame("one"), Torus(0.3, 0.05))
    yield rr.constraints.RollingContact(model, frame("one"), Torus(0.3))


@pytest.mark.parametrize("which", range(6))
def test_drift_is_the_rate_of_the_rows(which):
    model = two_links()
    constraint = list(kinds(model))[which]
    rng = np.random.default_rng(3)
    for _ in range(3):
        q, v = pin.randomConfiguration(model, -np.ones(8), np.ones(8)), rng.normal(size=7)
        found = constraint.evaluate(model.createData(), q, v).drift
        np.testing.assert_allclose(found, drift_by_differences(constraint, model, q, v), atol=2e-8)


def test_torus_is_a_shell():
    rng = np.random.default_rng(5)
    for shell in (Torus(0.3), Torus(0.3, 0.02)):
        u = rng.normal(size=3)
        steps = 1e-6 * np.eye(3)
        slope = [(shell.support(u + s) - shell.support(u - s)) / 2e-6 for s in steps]
        np.testing.assert_allclose(shell.contact(u), slope, atol=1e-9)
        bend = [(shell.contact(u + s) - shell.contact(u - s)) / 2e-6 for s in steps]
        np.testing.assert_allclose(shell.hessian(u), bend, atol=1e-8)
    with pytest.raises(rr.ConstraintError, match="lies flat"):
        Torus(0.3).contact(np.array((0.0, 1.0, 0.0)))


def test_a_snakeboard_on_a_free_flyer_with_planar_rows_is_the_same():
    planar = rr.machines.snakeboard()
    tree = Tree(planar.tree.base, planar.tree.joints)
    model = tree.model()
    rows = [
        NoSideSlip(model, model.getFrameId(f"{end}_link"), name=end) for end in ("front", "back")
    ]
    rows.append(PlanarMotion(model, model.getFrameId("board")))
    free = Mechanism(model, rows, motors=planar.model.motors)
    state = dict(shape=(0.4, 0.5, -0.3))
    xi = (0.2012127945, 0.0238403197, 0.4304136545)
    a = planar.evaluate(**state, shape_rates=(1.5, -0.8, 0.6), body_velocity=xi,
                        joint_torques=(0.05, 0.02, -0.03))  # fmt: skip
    v = np.array((xi[0], xi[1], 0, 0, 0, xi[2], 1.5, -0.8, 0.6))
    b = free.dynamics(free.start(None, state["shape"]), v, torque=np.array((0.05, 0.02, -0.03)))
    np.testing.assert_allclose(b.acceleration[[0, 1, 5, 6, 7, 8]], a.acceleration, atol=1e-12)
    assert b.forces["front"][0] == pytest.approx(a.multipliers["front"], abs=1e-12)
    assert b.forces["plane"][0] == pytest.approx(6.0 * 9.81)


def test_rows_that_repeat_each_other_leave_the_motion_and_share_the_force():
    once = rr.machines.chaplygin_sleigh()
    model = once.tree.model()
    frame = model.getFrameId("body")
    twice = Mechanism(model, [NoSideSlip(model, frame, name=n) for n in ("left", "right")])
    v = np.array((0.4, 0.0, 1.3))
    found = twice.dynamics(twice.start(), v)
    one = once.evaluate(body_velocity=v)
    np.testing.assert_allclose(found.acceleration, one.acceleration, atol=1e-13)
    for side in ("left", "right"):
        assert found.forces[side][0] == pytest.approx(one.multipliers["blade"] / 2, abs=1e-12)


def test_a_freedom_without_inertia_is_refused():
    tree = Tree(Link("body", 1.0, 0.1), [Joint("loose", "body", Link("nothing"))])
    machine = Mechanism(tree.model(), motors=("loose",))
    with pytest.raises(rr.ConstraintError, match="a freedom has no inertia"):
        machine.dynamics(machine.start(), np.zeros(7), torque=np.zeros(1))


def test_a_ball_inside_a_ball_rocks_as_the_closed_form():
    # A small ball of radius b rolls in a fixed hollow of radius R: 7/5 (R - b) angle'' = -g angle.
    # The hollow is heavy and afloat, so that it stays; the small ball is its own free body.
    R, b = 0.5, 0.1
    model = pin.Model()
    model.gravity.linear = np.array((0.0, 0.0, -9.81))
    for name, mass, inertia in (("hollow", 1e9, 1e9), ("ball", 1.0, 0.4 * b * b)):
        at = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), name + "_root")
        model.appendBodyToJoint(at, pin.Inertia(mass, np.zeros(3), inertia * np.eye(3)),
                                pin.SE3.Identity())  # fmt: skip
        model.addFrame(pin.Frame(name, at, pin.SE3.Identity(), pin.FrameType.BODY))
    rolls = RollingOnBody(model, model.getFrameId("hollow"), model.getFrameId("ball"), (R, b),
                          inside=True)  # fmt: skip
    angle = 0.3
    q = pin.neutral(model)
    q[7:10] = (R - b) * np.array((np.sin(angle), 0, -np.cos(angle)))
    data = model.createData()
    v = np.zeros(12)
    rows = rolls.evaluate(data, q, v)
    mass = pin.crba(model, data, q)
    bias = pin.nonLinearEffects(model, data, q, v)
    bias[:6] = 0.0
    a = rr.kkt_solve(rr.kkt_build(mass, bias, np.zeros(12), rows)).acceleration
    along = a[6:9] @ (np.cos(angle), 0, np.sin(angle))
    assert along == pytest.approx(-5 / 7 * 9.81 * np.sin(angle), rel=1e-8)
    # Its drift, at a rolling velocity.
    basis = np.linalg.svd(rows.jacobian)[2][3:].T
    v = basis @ np.random.default_rng(1).normal(size=9)
    found = rolls.evaluate(data, q, v).drift
    np.testing.assert_allclose(found, drift_by_differences(rolls, model, q, v), atol=1e-8)


def test_rrrobot_is_one_of_the_machines():
    p = rr.RRRobotParameters()
    machine = rr.machines.rrrobot(p)
    model = rr.FullModel(rr.Robot.from_parameters(p), damping=None)
    gait = rr.gait("circular")
    theirs = rr.simulate(model, gait, duration=2.0, rtol=1e-12, atol=1e-12)
    t = machine.simulate(gait, 2.0)
    np.testing.assert_allclose(t.pose[:, :2], theirs.position, atol=1e-9)
    np.testing.assert_allclose(t.multipliers["contact"], theirs.contact_force, atol=1e-7)
    np.testing.assert_allclose(t.joint_torques, theirs.leg_torque, atol=1e-8)
