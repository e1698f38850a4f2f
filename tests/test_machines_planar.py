"""Planar machines against values that were derived apart from Pinocchio, to their printed digits.

The values come from Lagrange-d'Alembert equations, a numeric Kane tree, momentum equations and
closed forms, each by at least two of them.
"""

import numpy as np
import pytest
from scipy.special import j1

import rrrobot as rr

S0 = (0.1, -0.2, 0.3)
BOARDS = {"G": {"J": 0.016}, "M": {"J": 0.1654}}
RACERS = {
    "KT": {},
    "F": {"d1": 0.35, "d2": -0.08, "m1": 2.5, "I1": 0.05, "c1": 0.12, "m2": 0.6, "I2": 0.004,
          "c2": -0.05},
}  # fmt: skip
TOL = {"rtol": 1e-9, "atol": 2e-10}


def close(found, wanted):
    np.testing.assert_allclose(found, wanted, **TOL)


def board_state(**drive):
    xi = (0.2012127945, 0.0238403197, 0.4304136545)
    shape, rates = (0.4, 0.5, -0.3), (1.5, -0.8, 0.6)
    return dict(pose=S0, shape=shape, shape_rates=rates, body_velocity=xi, **drive)


@pytest.mark.parametrize(
    ("name", "pose", "sides", "torques"),
    [
        ("G", (-0.0162512762, 0.04651936077, -0.8350816753), (0.1359264366, 0.1844153043),
         (0.004674119375, -0.002515606178, -0.0001756061779)),
        ("M", (0.01794509406, 0.06170583157, -0.7555993622), (-0.1500936086, 0.4748062136),
         (0.01039684592, -0.002412279171, -7.227917088e-5)),
    ],
)  # fmt: skip
def test_snakeboard_accelerations(name, pose, sides, torques):
    a = rr.machines.snakeboard(**BOARDS[name]).evaluate(
        **board_state(shape_accelerations=(0.9, -1.1, 0.7))
    )
    close(a.pose_acceleration, pose)
    close([a.multipliers["front"], a.multipliers["back"]], sides)
    close(a.joint_torques, torques)


def test_snakeboard_with_torques_and_where_its_mass_sits():
    wanted = (-0.02840611031, 0.04112144772, -0.863333046, 1.55777749, 16.24794843, -22.21359003)
    for parts in ({}, {"m_rotor": 1.0, "m_truck": 0.1}):
        board = rr.machines.snakeboard(**parts)
        a = board.evaluate(**board_state(joint_torques=(0.05, 0.02, -0.03)))
        found = np.concatenate((a.pose_acceleration, a.shape_accelerations))
        np.testing.assert_allclose(found, wanted, rtol=2e-9)


@pytest.mark.parametrize(
    ("gait", "name", "turns", "pose"),
    [
        ("drive", "G", 1, (0.1244027847, -0.001190438453, -0.06047402649)),
        ("drive", "M", 1, (0.1201482682, -0.001106748307, -0.05812562375)),
        ("drive", "G", 2, (0.4969244105, -0.002375010707, -0.120948053)),
        ("drive", "M", 2, (0.4799789105, -0.00220845169, -0.1162512475)),
        ("rotate", "G", 1, (0.0001620518627, -0.002679305479, 0.1208183929)),
        ("rotate", "M", 1, (0.0001451394224, -0.002491050332, 0.1163971018)),
        ("park", "G", 1, (0, 0.007735156401, 0)),
        ("park", "M", 1, (0, 0.007172236439, 0)),
    ],
)
def test_snakeboard_gaits_do_what_their_names_say(gait, name, turns, pose):
    board = rr.machines.snakeboard(**BOARDS[name])
    t = board.simulate(board.gaits[gait], 2 * np.pi * turns, sample_interval=0.5)
    close(t.pose[-1], pose)
    assert t.violation.max() < 1e-13


def test_snakeboard_gains_a_bessel_function_of_momentum_per_cycle():
    board = rr.machines.snakeboard(J=0.1654)
    for cycles in (1, 3):
        t = board.simulate(board.gaits["drive"], 2 * np.pi * cycles, sample_interval=1.0)
        # p = b . mu with the closed form's b, which is (1, 0, 0) at straight axles.
        z, v = board.model.split(t.states[-1])
        p = board.model.mass_matrix(board.model.coordinates.to_q(z))[0] @ v
        gain = 2 * np.pi * (0.072 / 0.2) * 0.7 * j1(0.3)
        assert p == pytest.approx(cycles * gain, rel=1e-9)
        assert gain == pytest.approx(0.2348424810, rel=1e-9)


def test_snakeboard_keeps_its_energy_and_its_constraints_without_torques():
    board = rr.machines.snakeboard()
    t = board.simulate(
        None, 60.0, shape=(0.0, 0.3, -0.2), shape_rates=(1.0, 0.2, -0.1), sample_interval=1.0
    )
    assert np.abs(t.energy / t.energy[0] - 1).max() < 1e-10
    assert t.violation.max() < 1e-12


@pytest.mark.parametrize(
    ("name", "xi", "pose", "sides", "torque", "driven"),
    [
        ("KT", (0.3823607529, 0, 0.8512558648), (-0.05530953202, 0.3235946209, -1.247572977),
         (1.16409637, -0.2273449331), 0.01856361758, 3.760012468),
        ("F", (0.2297542117, 0, 0.3146923161), (0.02292784981, 0.08277452902, -0.4944400414),
         (0.1207540599, -0.1876021451), -0.01008469786, 4.210900591),
    ],
)  # fmt: skip
def test_roller_racer_accelerations(name, xi, pose, sides, torque, driven):
    racer = rr.machines.roller_racer(**RACERS[name])
    state = dict(pose=S0, shape=(0.6,), shape_rates=(-0.8,), body_velocity=xi)
    a = racer.evaluate(**state, shape_accelerations=(0.9,))
    # xi is printed to ten digits, and what follows from it is good to a few of the last.
    np.testing.assert_allclose(a.pose_acceleration, pose, rtol=2e-9, atol=1e-9)
    np.testing.assert_allclose([*a.multipliers.values()], sides, rtol=2e-9, atol=1e-9)
    np.testing.assert_allclose(a.joint_torques, torque, rtol=1e-8)
    a = racer.evaluate(**state, joint_torques=(0.05,))
    np.testing.assert_allclose(a.shape_accelerations, driven, rtol=2e-9)


def test_roller_racer_with_four_real_wheels():
    racer = rr.machines.roller_racer(**RACERS["F"], wheel_radius=0.05, wheel_mass=0.15)
    xi = (0.2297542117, 0, 0.3146923161)
    a = racer.evaluate(
        pose=S0, shape=(0.6,), shape_rates=(-0.8,), body_velocity=xi, shape_accelerations=(0.9,)
    )
    np.testing.assert_allclose(
        a.pose_acceleration, (0.02245681504, 0.08262882089, -0.4957729468), rtol=1e-8
    )
    assert a.joint_torques[0] == pytest.approx(-0.0100247666, rel=1e-8)
    # The same as knife edges with the wheels' masses merged, their spin as mass along the axles.
    radius, track, mass, spin, across = 0.05, 0.08, 0.15, 1.875e-4, 9.375e-5
    F = RACERS["F"]
    plain = rr.machines.roller_racer(**F)
    q = plain.model.coordinates.to_q(plain.model.start(S0, (0.6,)))
    more = 2 * (mass * track**2 + across + spin * track**2 / radius**2)
    M = plain.model.mass_matrix(q)
    front = np.array((F["d1"] * np.cos(0.6) + F["d2"], -np.sin(0.6)))
    # Velocities of both axles along and across their links, and both links' rates of turn.
    c, s_ = np.cos(0.6), np.sin(0.6)
    axles = [np.array(((1, 0, 0, 0), (0, 1, 0, 0))),
             np.array(((c, s_, F["d1"] * s_, 0), (-s_, c, front[0], F["d2"])))]  # fmt: skip
    for along, turns in zip(axles, ((0, 0, 1, 0), (0, 0, 1, 1)), strict=True):
        masses = 2 * np.diag((mass + spin / radius**2, mass))
        M = M + along.T @ masses @ along + more * np.outer(turns, turns)
    wheels = racer.model
    z = wheels.start(S0, (0.6,))
    whole = wheels.mass_matrix(wheels.coordinates.to_q(z))
    rows = wheels.rows(wheels.coordinates.to_q(z), np.zeros(wheels.model.nv), 0.0, None).jacobian
    # Each wheel's rate follows from the other four velocities: by the rows that roll.
    spins = -np.linalg.solve(rows[2:, 4:], rows[2:, :4])
    follow = np.concatenate((np.eye(4), spins))
    free = np.linalg.svd(rows[:2, :4])[2][2:].T
    np.testing.assert_allclose(
        free.T @ follow.T @ whole @ follow @ free, free.T @ M @ free, rtol=1e-12
    )


@pytest.mark.parametrize(
    ("name", "cycles", "pose"),
    [
        ("KT", 1, (-0.01530432548, -0.0005126597518, -0.00217600243)),
        ("KT", 5, (-0.3605945983, 0.03296165638, -0.1649268195)),
        ("F", 1, (0.1511122949, 0.001040058832, 0.03112248219)),
        ("F", 5, (0.1289534945, 2.335180433, 2.561111581)),
    ],
)
def test_roller_racer_wiggles(name, cycles, pose):
    racer = rr.machines.roller_racer(**RACERS[name])
    t = racer.simulate(racer.gaits["wiggle"], np.pi * cycles, sample_interval=0.5)
    np.testing.assert_allclose(t.pose[-1], pose, rtol=3e-9, atol=1e-10)


def test_roller_racer_cannot_be_stopped_by_steering():
    racer = rr.machines.roller_racer()
    t = racer.simulate(racer.gaits["wiggle"], 5 * np.pi, sample_interval=np.pi)
    m1, d1, d2, inertia = 3.0, 0.3, 0.1, 0.06 + 0.012
    phi = t.shape[:, 0]
    D = d1 * np.cos(phi) + d2
    mu = [racer.model.mass_matrix(racer.model.coordinates.to_q(racer.model.split(s)[0]))[:3]
          @ racer.model.split(s)[1] for s in t.states]  # fmt: skip
    b = np.stack((D, 0 * D, np.sin(phi)), axis=1)
    scaled = np.sum(b * mu, axis=1) / np.sqrt(m1 * D**2 + inertia * np.sin(phi) ** 2)
    np.testing.assert_allclose(np.diff(scaled), -0.0160520905599, rtol=1e-9)


def test_trikke():
    trike = rr.machines.trikke()
    state = dict(pose=S0, shape=(0.4, -0.5), shape_rates=(-0.8, 1.1),
                 body_velocity=(0.535900256, 0, 0.3598193228))  # fmt: skip
    a = trike.evaluate(**state, shape_accelerations=(0.9, -0.6))
    np.testing.assert_allclose(
        a.pose_acceleration, (0.1685941565, 0.2539945349, -0.6954557358), rtol=3e-9
    )
    np.testing.assert_allclose([*a.multipliers.values()], (0.6307761736, -0.5659784571), rtol=3e-9)
    np.testing.assert_allclose(a.joint_torques, (-0.03550377252, -0.08410282976), rtol=5e-9)
    a = trike.evaluate(**state, joint_torques=(0.1, -0.2))
    np.testing.assert_allclose(a.shape_accelerations, (4.630256461, -2.216439845), rtol=3e-9)
    ride = trike.gaits["ride"]
    t = trike.simulate(ride, 5 * np.pi, sample_interval=np.pi)
    close(t.body_velocity[0], (0.003841105261, 0, 0.09795918367))
    close(t.pose[1], (0.09470833191, -0.0009368386617, -0.01855497642))
    close(t.pose[5], (1.665680427, 0.001586082339, -0.07688667899))


def test_a_trikke_without_a_rider_is_a_roller_racer():
    same = dict(d1=0.55, d2=-0.06, m1=4.0, I1=0.15, c1=0.2, m2=1.2, I2=0.02, c2=0.02)
    trike, racer = rr.machines.trikke(**same, mr=0.0, Ir=0.0), rr.machines.roller_racer(**same)
    state = dict(pose=S0, body_velocity=(0.535900256, 0, 0.3598193228))
    xi = racer.evaluate(shape=(0.4,), shape_rates=(-0.8,), shape_accelerations=(0.9,), **state)
    a = trike.evaluate(shape=(0.4, -0.5), shape_rates=(-0.8, 1.1),
                       shape_accelerations=(0.9, -0.6), **state)  # fmt: skip
    np.testing.assert_allclose(a.pose_acceleration, xi.pose_acceleration, atol=1e-13)
    np.testing.assert_allclose(a.joint_torques, (xi.joint_torques[0], 0), atol=1e-13)


def test_kinematic_snake():
    snake = rr.machines.kinematic_snake()
    state = dict(pose=S0, shape=(0.9, 0.5), shape_rates=(0.8, -1.2))
    a = snake.evaluate(**state, shape_accelerations=(0.9, -0.6))
    close(a.pose_acceleration, (-0.1952837067, -0.1200100463, 0.7259729818))
    close([*a.multipliers.values()], (0.1377123991, -0.4679455138, 0.2977074556))
    close(a.joint_torques, (0.04027371294, -0.0310330096))
    a = snake.evaluate(**state, joint_torques=(0.02, -0.05))
    close(a.shape_accelerations, (-5.682782825, -7.780719687))
    ends = {"circle": (-0.0806019395, -0.06059678847, 0),
            "turn": (-0.04513040396, -0.03642500478, 0.0460460454)}  # fmt: skip
    for name, pose in ends.items():
        t = snake.simulate(snake.gaits[name], 2 * np.pi, sample_interval=1.0)
        close(t.pose[-1], pose)


def test_a_snake_through_a_singular_shape_says_which_axles():
    snake = rr.machines.kinematic_snake()
    with pytest.raises(rr.ConstraintError, match=r"shape \(0.4, -0.4\).*'rear', 'middle', 'front'"):
        snake.evaluate(shape=(0.4, -0.4), shape_rates=(0, 0), shape_accelerations=(1.0, 0.3))
    with pytest.raises(rr.ConstraintError, match="break the constraint"):
        snake.evaluate(shape=(0.4, -0.4), shape_rates=(1.0, 0.3))


def sleigh_in_closed_form(time, m=1.5, I=0.04, a=0.2, v=0.4, omega=1.3):  # noqa: E741
    B = (I + m * a * a) / m
    s = np.sqrt(v * v + B * omega**2)
    k = a * s / B
    phase = k * time + np.arctanh(v / s)
    return s * np.tanh(phase), s / np.sqrt(B) / np.cosh(phase)


def test_sleigh_turns_and_goes_straight():
    sleigh = rr.machines.chaplygin_sleigh()
    t = sleigh.simulate(None, 60.0, start=(0.4, 0.0, 1.3), sample_interval=0.5)
    v, omega = sleigh_in_closed_form(t.time)
    np.testing.assert_allclose(t.body_velocity[:, 0], v, atol=1e-10)
    np.testing.assert_allclose(t.body_velocity[:, 2], omega, atol=1e-10)
    close(t.body_velocity[1, [0, 2]], (0.4940667578, 0.6545766439))
    close(t.body_velocity[4, [0, 2]], (0.5219121703, 0.0641505824))
    close(t.pose[1], (0.2182175185, 0.06111036569, 0.4758040739))
    close(t.pose[4], (0.7877434105, 0.5791948962, 0.8603618160))
    assert np.abs(t.energy / t.energy[0] - 1).max() < 1e-10
    assert t.body_velocity[-1, 0] == pytest.approx(0.5221749388, abs=1e-10)


def test_sleigh_turns_by_one_angle_in_all_of_time():
    sleigh = rr.machines.chaplygin_sleigh()
    v, omega = sleigh_in_closed_form(-14.0)
    t = sleigh.simulate(None, 30.0, start=(v, 0.0, omega), sample_interval=1.0)
    assert t.pose[-1, 2] == pytest.approx(np.pi * np.sqrt(1 + 0.04 / (1.5 * 0.04)), abs=1e-8)
    assert t.pose[-1, 2] == pytest.approx(4.055778676, abs=1e-8)


def test_sleigh_with_a_rotor():
    sleigh = rr.machines.chaplygin_sleigh(Jr=0.01)
    a = sleigh.evaluate(shape=(0.0,), body_velocity=(0.4, 0.0, 1.3), shape_accelerations=(5.0,))
    close(a.acceleration[[0, 2]], (0.338, -1.872727273))
    close(a.multipliers["blade"], 0.2181818182)
    close(a.joint_torques, (0.03127272727,))
    t = sleigh.simulate(sleigh.gaits["shake"], 15 * 2 * np.pi / 3, sample_interval=2 * np.pi / 3)
    assert t.body_velocity[0] == pytest.approx((0, 0, -0.4090909091), abs=1e-10)
    close(t.pose[1], (0.03627048478, 0.001471903347, -0.006943436184))
    np.testing.assert_allclose(t.pose[15], (7.902361641, -0.04318381, -0.05802129), rtol=3e-7)


@pytest.mark.parametrize("name", ["snakeboard", "roller_racer", "trikke", "kinematic_snake"])
def test_urdf_is_the_same_machine(name):
    import pinocchio as pin

    machine = getattr(rr.machines, name)()
    theirs = pin.buildModelFromXML(machine.urdf, pin.JointModelPlanar())
    z = machine.model.start(S0, np.linspace(0.3, 0.9, machine.model.n_shape))
    q = pin.neutral(theirs)
    q[:4] = machine.model.coordinates.to_q(z)[:4]
    order = []
    for motor in machine.model.motors:
        joint = theirs.joints[theirs.getJointId(motor)]
        angle = z[machine.model.coordinates.joint[motor].start]
        q[joint.idx_q : joint.idx_q + 2] = np.cos(angle), np.sin(angle)
        order.append(joint.idx_v)
    order = [0, 1, 2, *order]
    mass = pin.crba(theirs, theirs.createData(), q)[np.ix_(order, order)]
    own = machine.model.mass_matrix(machine.model.coordinates.to_q(z))
    np.testing.assert_allclose(mass, own, atol=1e-14)


def test_bad_machines_and_starts_are_refused():
    with pytest.raises(rr.ParameterError, match="at least those of its rotor and trucks"):
        rr.machines.snakeboard(m_truck=1.0)
    with pytest.raises(rr.ParameterError, match="no moment may be below zero"):
        rr.machines.chaplygin_sleigh(I=-1.0)
    with pytest.raises(rr.ConstraintError, match=r"break the constraint 'blade' by 0\.1"):
        rr.machines.chaplygin_sleigh().evaluate(body_velocity=(0.4, 0.1, 0.0))
    board = rr.machines.snakeboard()
    with pytest.raises(rr.GaitError, match="moves 2 joints, but the machine has 3"):
        board.simulate(rr.gait("lateral"), 1.0)
    with pytest.raises(rr.ModelError, match="not both"):
        board.evaluate(shape_accelerations=(0, 0, 0), joint_torques=(0, 0, 0))


def test_singular_shapes_say_where_and_which_wheels():
    board = rr.machines.snakeboard()
    turn = rr.SinusoidalGait(offset=(0, 0.2, 0.2), amplitude=(0.5, np.pi / 2, np.pi / 2),
                             angular_frequency=1.0, phase=(0.0, np.pi / 2, np.pi / 2))  # fmt: skip
    racer = rr.machines.roller_racer(d1=0.3, d2=0.3, I2=0.02)
    with pytest.raises(rr.ConstraintError, match=r"shape \(3.142\).*'rear', 'front'"):
        racer.evaluate(shape=(np.pi,), shape_rates=(0.0,), shape_accelerations=(1.0,))
    with pytest.raises(rr.ConstraintError, match="singular"):
        rr.machines.Reduction(racer).connection((np.pi,))
    snake = rr.machines.kinematic_snake()
    through = rr.SinusoidalGait(offset=(0.3, 0.3), amplitude=0.5, angular_frequency=1.0,
                                phase=(0.0, 1.0))  # fmt: skip
    with pytest.raises(rr.ConstraintError, match=r"shape at t = .*'rear', 'middle', 'front'"):
        snake.simulate(through, 6.0)
    aligned = r"shape .* 1.571, 1.571.: there the constraints 'front', 'back' depend on each other"
    with pytest.raises(rr.ConstraintError, match=aligned):
        board.simulate(turn, 6.0)
    margin = rr.machines.Reduction(snake).margin
    assert margin((0.4, -0.4)) < 1e-12 < 0.1 < margin((1.0, 1.0))


def test_rr_simulate_takes_a_machine():
    board = rr.machines.snakeboard()
    t = rr.simulate(board.model, board.gaits["drive"], 2 * np.pi, sample_interval=1.0)
    close(t.pose[-1], (0.1244027847, -0.001190438453, -0.06047402649))
    with pytest.raises(rr.GaitError, match="moves 2 joints"):
        rr.simulate(board.model, rr.gait("lateral"), 1.0)
    with pytest.raises(rr.ModelError, match="takes its pose"):
        rr.simulate(board.model, board.gaits["drive"], 1.0, position=(1.0, 0.0))
    with pytest.raises(rr.ModelError, match="takes no state, step"):
        rr.simulate(board.model, board.gaits["drive"], 1.0, step=0.1)
