"""Machines in space against values that were derived apart from Pinocchio: Kane trees, moment
equations, Kirchhoff's equations and closed forms."""

import numpy as np
import pytest

import rrrobot as rr

TOL = {"rtol": 2e-9, "atol": 3e-9}


def close(found, wanted, **more):
    np.testing.assert_allclose(found, wanted, **(TOL | more))


def axis(k, angle):
    i, j = (k + 1) % 3, (k + 2) % 3
    R = np.eye(3)
    c, s = np.cos(angle), np.sin(angle)
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def rpy(roll, pitch, yaw):
    return axis(2, yaw) @ axis(1, pitch) @ axis(0, roll)


def zxy(yaw, lean, spin):
    return axis(2, yaw) @ axis(0, lean) @ axis(1, spin)


def matrix(quaternion):
    return rr.rotations.rotation_from_quaternion(quaternion)


WHEELS = {"disc": {}, "torus": {"A": 0.03, "C": 0.055, "rho": 0.02}}
TURNED = {
    "disc": ((0.99175358, -2.191641855, -0.5380021826), (8.332881122, 2.556704683, 1.271899946),
             (1.190104296, -2.629970226, 11.12639738), (0.3635761647, -0.3277096711),
             (0.8470178579, -0.4241385008, 0.3204173538)),
    "torus": ((0.9453363481, -2.099182664, -0.4437087499), (7.446341984, 2.299715324, 1.060932931),
              (1.134403618, -2.519019197, 11.2395495), (0.3697578018, -0.4859153832),
              (0.718327823, -0.6096504132, 0.3351589361)),
}  # fmt: skip


@pytest.mark.parametrize("name", WHEELS)
def test_disc_and_torus(name):
    wheel = rr.machines.rolling_disc(**WHEELS[name])
    R = zxy(0.4, 0.35, 2.1)
    # u in the lean frame: x horizontal, y the axle.
    omega = axis(1, 2.1).T @ np.array((0.5, -3.0, 1.2))
    close(R @ omega, (1.718194226, -2.779945277, 0.09855383305))
    pose = wheel.at(R)
    pose[:2] = 0.0
    centre, alpha, force, place, axle = TURNED[name]
    a = wheel.evaluate(pose=pose, body_velocity=omega)
    close(a.pose_acceleration, np.concatenate((centre, alpha)))
    close(a.multipliers["contact"], force)
    t = wheel.simulate(None, 1.0, pose=pose, start=omega, sample_interval=0.1)
    close(t.pose[-1, :2], place)
    close(matrix(t.quaternion[-1])[:, 1], axle)


@pytest.mark.parametrize(
    ("name", "seconds"),
    [("disc", 10.0), *(pytest.param(name, 60.0, marks=pytest.mark.slow) for name in WHEELS)],
)
def test_a_disc_keeps_its_energy_through_every_turn_over(name, seconds):
    wheel = rr.machines.rolling_disc(**WHEELS[name])
    omega = axis(1, 2.1).T @ np.array((0.5, -6.0, 1.2))
    t = wheel.simulate(None, seconds, pose=wheel.at(zxy(0.4, 0.35, 2.1)), start=omega,
                       sample_interval=0.05)  # fmt: skip
    assert np.abs(t.energy / t.energy[0] - 1).max() < 1e-10
    assert t.violation.max() < 1e-12
    lowest = [
        p[2] - wheel.model.rolling.surface.support(-matrix(p[3:]).T @ (0, 0, 1.0)) for p in t.pose
    ]
    assert np.abs(lowest).max() < 1e-12
    assert abs(t.wheel_angles[-1, 2] - t.wheel_angles[0, 2]) > 10 * np.pi


CRITICAL = {"disc": (3.30151480384, 5.11468474102), "torus": (3.29079990652, 4.80629493036)}


@pytest.mark.parametrize("name", WHEELS)
def test_critical_speeds_of_a_disc(name):
    wheel = rr.machines.rolling_disc(**WHEELS[name])
    for critical, rolling in zip(CRITICAL[name], (True, False), strict=True):
        # Below it a small lean grows at once; above it, see `tests/test_machines_small.py`.
        R = zxy(0.0, 1e-7, 0.0)
        rate = 0.98 * critical
        omega = R.T @ ((0.0, rate, 0.0) if rolling else (0.0, 0.0, rate))
        t = wheel.simulate(None, 8.0, pose=wheel.at(R), start=omega, sample_interval=0.5)
        assert np.abs(t.wheel_angles[:, 1]).max() > 1e-4


@pytest.mark.parametrize(
    ("name", "lean", "yaw", "spin"),
    [("disc", 0.3, 2.0, -3.86429879851), ("disc", 1.3, 6.0, -17.9054298214),
     ("torus", 0.3, 2.0, -3.53741614638), ("torus", 1.3, 6.0, -15.8314067118)],
)  # fmt: skip
def test_steady_rolling_of_a_disc(name, lean, yaw, spin):
    wheel = rr.machines.rolling_disc(**WHEELS[name])
    R = zxy(0.0, lean, 0.0)
    omega = R.T @ (0, 0, yaw) + np.array((0, spin, 0))
    a = wheel.evaluate(pose=wheel.at(R), body_velocity=omega)
    # Steady: the angular acceleration is that of the spin axis being carried round by the yaw.
    wanted = np.cross((0, 0, yaw), R @ (0, spin, 0))
    np.testing.assert_allclose(a.pose_acceleration[3:], wanted, atol=2e-9)
    np.testing.assert_allclose(a.pose_acceleration[2], 0, atol=1e-9)


def test_a_ball_runs_down_at_five_sevenths():
    ball = rr.machines.ball_on_slope(m=1.3, r=0.1, slope=0.3)
    a = ball.evaluate()
    assert np.linalg.norm(a.pose_acceleration[:3]) == pytest.approx(2.0707523052, rel=1e-10)
    down = np.array((np.cos(0.3), 0, -np.sin(0.3)))
    friction = a.multipliers["contact"] @ down
    assert friction == pytest.approx(-2 / 7 * 1.3 * 9.81 * np.sin(0.3), rel=1e-12)
    t = ball.simulate(None, 2.0, sample_interval=0.5)
    assert (t.pose[-1, :3] - t.pose[0, :3]) @ down == pytest.approx(2 * 2.0707523052, rel=1e-9)


def test_a_ball_on_a_turntable_takes_seven_halves():
    ball = rr.machines.turntable_ball(rate=2.0)
    # v = Omega z x x + r omega x z at the contact: omega from the centre's velocity.
    x, v = np.array((0.3, 0.1)), np.array((0.2, -0.15))
    slip = v - 2.0 * np.array((-x[1], x[0]))
    omega = (-slip[1] / 0.1, slip[0] / 0.1, 0.7)
    t = ball.simulate(None, 3.5 * np.pi, pose=(0.3, 0.1, 0.1, 0, 0, 0, 1), start=omega,
                      sample_interval=0.5)  # fmt: skip
    close(t.pose[2, :2], (0.5309955562, 0.0136357943))
    velocity = matrix(t.quaternion[2]) @ t.body_velocity[2, :3]
    close(velocity[:2], (0.2493509747, -0.01800253934))
    np.testing.assert_allclose(t.pose[-1, :2], x, atol=1e-9)
    world = [matrix(q) @ w for q, w in zip(t.quaternion, t.body_velocity[:, 3:], strict=True)]
    np.testing.assert_allclose(np.array(world)[:, 2], 0.7, atol=1e-10)


def momentum_about_the_contact(t, I, m, r):  # noqa: E741
    found = []
    for q, w in zip(t.quaternion, t.body_velocity[:, 3:], strict=True):
        R = matrix(q)
        up = R[2]
        found.append(R @ (np.array(I) * w + m * r * r * (w - (w @ up) * up)))
    return np.array(found)


def test_chaplygin_sphere():
    ball = rr.machines.chaplygin_sphere()
    R = rpy(0.1, 0.2, 0.3)
    omega = R.T @ (3, -2, 4)
    a = ball.evaluate(pose=R, body_velocity=omega)
    close(a.pose_acceleration[3:], (0.5830063636, 1.183689366, 0.4912962224))
    close(a.multipliers["contact"], (0.2367378732, -0.1166012727, 9.81))
    t = ball.simulate(None, 60.0, pose=R, start=omega, sample_interval=1.0)
    assert t.energy[0] - 9.81 * 0.2 == pytest.approx(0.5017491412, abs=1e-10)
    K = momentum_about_the_contact(t, (0.010, 0.014, 0.018), 1.0, 0.2)
    close(K[0], (0.1606694328, -0.1103467999, 0.0751990961))
    assert np.abs(K - K[0]).max() < 1e-10 * np.linalg.norm(K[0])
    assert np.abs(t.energy / t.energy[0] - 1).max() < 1e-10
    assert t.violation.max() < 1e-12
    close(t.pose[5, :2], (-1.943051188, -2.825175732))
    close(
        matrix(t.quaternion[5]) @ t.body_velocity[5, 3:],
        (3.059403405, -1.981294706, 3.9005275),
        rtol=1e-8,
    )


def test_routh_sphere_keeps_jellett_and_routh():
    m, r, A, C, a = 1.0, 0.2, 0.012, 0.016, 0.05
    ball = rr.machines.routh_sphere()
    R = rpy(0.3, 0.2, 0.5)
    omega = R.T @ (0.5, 1, 6)
    pose = ball.at(R)
    found = ball.evaluate(pose=pose, body_velocity=omega)
    close(found.pose_acceleration[3:], (-6.14744649, -6.943085991, 0.7321119457))
    t = ball.simulate(None, 60.0, pose=pose, start=omega, sample_interval=1.0)
    jellett, routh = [], []
    for q, w in zip(t.quaternion, t.body_velocity[:, 3:], strict=True):
        up = matrix(q)[2]
        rc = -r * up + np.array((0, 0, a))
        K = np.array((A, A, C)) * w + m * np.cross(rc, np.cross(w, -rc)) * -1
        jellett.append(K @ -rc)
        routh.append(w[2] * np.sqrt(A * C + m * (A * (rc[0] ** 2 + rc[1] ** 2) + C * rc[2] ** 2)))
    for values, wanted in (
        (t.energy, 1.808802837),
        (jellett, 0.01411441433),
        (routh, 0.1317305769),
    ):
        values = np.array(values)
        assert values[0] == pytest.approx(wanted, rel=1e-9)
        assert np.abs(values / values[0] - 1).max() < 1e-10
    close(t.pose[3, :2] - t.pose[0, :2], (-0.2834687331, 0.1049251815))


def test_rattleback_accelerations():
    stone = rr.machines.rattleback()
    R = rpy(0.05, -0.03, 0.4)
    a = stone.evaluate(pose=R, body_velocity=R.T @ (0.3, -0.2, 4))
    close(a.pose_acceleration[:3], (1.11943979, 1.327961515, -6.453615388))
    close(a.pose_acceleration[3:], (-49.76925239, 106.0598102, -24.18664423))
    close(a.multipliers["contact"], (0.06128116676, 0.8278457714, 3.31997844))


def test_rattleback_turns_back():
    half = np.deg2rad(0.5)
    R = zxy(0, half, -half)
    ends = {
        0.0: [
            (5.041042306, -1.761423169, 3.117543537),
            (4.438574943, -1.13123711, 0.884658189),
            (-0.17049031, 0.35663586, -0.25130638),
        ],
        1e-4: [
            (4.370049882, -0.7559666271, 2.577818508),
            (0.91770054, 4.37878725, 0.47237778),
        ],
    }
    for sigma, rates in ends.items():
        stone = rr.machines.rattleback(sigma=sigma)
        t = stone.simulate(None, len(rates), pose=stone.at(R), start=(0, 0, 5.0),
                           sample_interval=0.5, rtol=1e-12)  # fmt: skip
        for second, rate in enumerate(rates, start=1):
            np.testing.assert_allclose(t.body_velocity[2 * second, 3:], rate, atol=6e-9)


@pytest.mark.parametrize(
    ("sigma", "zero", "least", "about"),
    [(0.0, 2.684647, -5.357, 5.72), (1e-4, 2.512432, -3.8138, 5.228)],
)
def test_rattleback_spin_passes_zero_and_comes_back(sigma, zero, least, about):
    # Without loss the spin just grazes zero there, for 0.3 ms.
    stone = rr.machines.rattleback(sigma=sigma)
    half = np.deg2rad(0.5)
    pose, omega = stone.at(zxy(0, half, -half)), np.array((0, 0, 5.0))

    def spin(t):
        return np.array(
            [matrix(q)[2] @ w for q, w in zip(t.quaternion, t.body_velocity[:, 3:], strict=True)]
        )

    t = stone.simulate(None, 6.0, pose=pose, start=omega, sample_interval=2e-3)
    before = int(zero / 2e-3) - 1
    begin = t.time[before]
    assert spin(t)[: before + 1].min() > 0
    near = stone.simulate(None, 5e-3, pose=t.pose[before], start=t.body_velocity[before],
                          sample_interval=1e-5)  # fmt: skip
    first = np.argmax(spin(near) < 0)
    before, after = spin(near)[[first - 1, first]]
    found = begin + 1e-5 * (first - 1 + before / (before - after))
    assert found == pytest.approx(zero, abs=2e-6)
    lowest = np.argmin(spin(t))
    c, b, a = np.polynomial.polynomial.polyfit([-1, 0, 1], spin(t)[lowest - 1 : lowest + 2], 2)
    assert c - b * b / (4 * a) == pytest.approx(least, abs=1e-3)
    assert t.time[lowest] == pytest.approx(about, abs=0.01)


def test_rotor_ball():
    ball = rr.machines.rotor_ball()
    R = rpy(0.1, 0.2, 0.3)
    a = ball.evaluate(pose=R, body_velocity=R.T @ (1, -2, 0.5), shape_rates=(30, -20, 10),
                      shape_accelerations=(5, 2, -7))  # fmt: skip
    close(a.pose_acceleration[3:], (-0.1101689739, -0.4996077066, -4.721369715))
    close(a.joint_torques, (0.004552111811, 0.0008724118732, -0.009287784888))
    t = ball.simulate(ball.gaits["circle"], np.pi, sample_interval=0.5)
    close(t.pose[-1, :2], (0.003146775267, 0.01570689162))
    close(t.rotation_vector[-1], (-0.01083547165, 0.001929199585, -0.424094768))
    # From rest the momentum about the contact stays zero, so the rotors' rates give the ball's.
    for q, w, rate in zip(t.quaternion, t.body_velocity[:, 3:], t.shape_rates, strict=True):
        push = 8e-4 * matrix(q) @ rate
        wanted = -push / (0.009 + np.array((1, 1, 0)) * 0.15**2)
        np.testing.assert_allclose(matrix(q) @ w, wanted, atol=1e-11)


def test_pendulum_ball():
    ball = rr.machines.pendulum_ball()
    R = rpy(0.1, 0.2, 0.3)
    state = dict(pose=R, body_velocity=R.T @ (1, -2, 0.5), shape=(0.5, -0.4),
                 shape_rates=(1.5, -0.7))  # fmt: skip
    a = ball.evaluate(**state, joint_torques=(0.3, -0.1))
    close(a.pose_acceleration[3:], (13.00847014, -12.69948453, 0.7385575166))
    close(a.shape_accelerations, (-41.45452956, 14.78246053))
    close(a.multipliers["contact"], (-0.2106282776, -0.1685097554, 15.55175799))
    a = ball.evaluate(**state, shape_accelerations=(2, -1))
    close(a.pose_acceleration[3:], (10.85967677, -11.50390857, -0.6313396354))
    close(a.joint_torques, (1.130403826, -0.4113143589))
    t = ball.simulate(ball.gaits["spin_up"], 3.0, sample_interval=0.5)
    close(t.pose[-1, :2], (-0.3752944072, 0.1094142252))


def test_sphericle():
    import pinocchio as pin

    ball = rr.machines.sphericle()
    vehicle, shell = rpy(0.1, 0.15, 0.3), rpy(-0.4, 0.2, 0.9)
    a = ball.evaluate(
        pose=shell, passive={"vehicle": pin.Quaternion(shell.T @ vehicle).coeffs()},
        body_velocity=(0.2, 0.9, -0.3) @ shell, shape_rates=(0.3, 0.8),
        shape_accelerations=(0.5, -0.4),
    )  # fmt: skip
    close(a.pose_acceleration[3:], (-1.4241583, -5.795684442, 0.679648629))
    close(a.multipliers["drive"], (0.172067696, 0.1857011966, -0.001707118256))
    t = ball.simulate(ball.gaits["weave"], 3.0, sample_interval=0.5)
    close(t.pose[-1, :2], (0.4518301026, 0.2360003712))


def test_legged_satellite():
    body = rr.machines.legged_satellite()
    gait = body.gaits["circular"]
    t = body.simulate(gait, gait.period, sample_interval=0.1)
    close(t.rotation_vector[-1], (-0.0008018222554, -0.0001793439198, 0.005523117332))


def test_legs_that_windmill_turn_a_satellite():
    body = rr.machines.legged_satellite()

    def after_a_turn(*legs):
        def windmill(t):
            still = np.array((0.0, np.pi / 2)) * (legs == (1, 0))
            rate = np.array(legs) * 2 * np.pi
            return still + rate * t, rate, np.zeros(2)

        drive = rr.CallableGait(windmill, n_legs=2, check_span=(0.0, 1.0))
        return body.simulate(drive, 1.0, sample_interval=0.5).rotation_vector[-1]

    close(after_a_turn(1, 1), (0, 1.810187352, 0))
    close(after_a_turn(1, 0), (-0.1113273011, 0.5483984964, 0.1242071347))


def test_planar_satellite():
    body = rr.machines.satellite()
    t = body.simulate(body.gaits["circle"], 2 * np.pi, sample_interval=0.5)
    assert t.pose[-1, 2] == pytest.approx(-0.01660494707, rel=1e-9)


@pytest.mark.parametrize(("beta", "turn"), [(0.6, 2.279159652), (0.4609194657, np.pi)])
def test_the_cat_turns_over(beta, turn):
    for parts in ({}, {"m": 3.0, "d": 0.1}):
        cat = rr.machines.falling_cat(beta=beta, **parts)
        t = cat.simulate(cat.gaits["roll"], 3.0, sample_interval=0.5, rtol=1e-12)
        R = matrix(t.quaternion[-1])
        # About its spine, the x axis, which comes back.
        np.testing.assert_allclose(R[:, 0], (1, 0, 0), atol=1e-9)
        angle = np.arctan2(R[2, 1], R[1, 1])
        assert (
            np.cos(angle - turn) == pytest.approx(1, abs=1e-15) or abs(abs(angle) - turn) < 1e-8
        )  # either sense of the roll


def submarine_state():
    return dict(pose=np.concatenate((np.zeros(3), rr.rotations.quaternion_from_euler(
        (0.1, 0.2, 0.3)))), body_velocity=(0.6, -0.2, 0.1, 0.3, -0.4, 0.5))  # fmt: skip


def test_submarine_with_rotors():
    boat = rr.machines.submarine()
    close(boat.model.fluid.mass, (8.018079007, 37.72874897, 65.82858913))
    close(boat.model.fluid.inertia, (0.05853949792, 2.179401169, 1.083471016))
    a = boat.evaluate(**submarine_state(), shape_rates=(20, -10, 5), shape_accelerations=(3, -4, 2))
    close(a.pose_acceleration[:3], (-0.01269240785, 0.1069846305, 0.1015387377))
    close(a.pose_acceleration[3:], (-1.445495994, -0.2311472751, 1.402254163))
    close(a.joint_torques, (0.02602119466, -0.110586714, 0.09181062465))
    start = submarine_state()
    t = boat.simulate(rr.StillLegs((0.0,) * 3), 60.0, pose=start["pose"],
                      start=start["body_velocity"], sample_interval=1.0, rtol=1e-12)  # fmt: skip
    close(t.pose[2, :3], (1.10789658, -0.1468158395, 0.01505219414))
    assert np.abs(t.energy - t.energy[0]).max() < 1e-10 * np.abs(t.energy[0])
    P = np.array([matrix(q) @ p[:3] for q, p in zip(t.quaternion, momenta(t), strict=True)])
    assert np.abs(P - P[0]).max() < 1e-10 * np.linalg.norm(P[0])


def momenta(t):
    """Of body and fluid, in the body's axes, about the centre of buoyancy (n, 6)."""
    model = t.model
    return np.array([model.mass_matrix(model.coordinates.to_q(z))[:6] @ v
                     for z, v in map(model.split, t.states)])  # fmt: skip


def test_submarine_turns_by_its_rotors_alone():
    boat = rr.machines.submarine(h=0.0)
    t = boat.simulate(boat.gaits["turn"], 2 * np.pi, sample_interval=0.5)
    close(t.rotation_vector[-1], (-0.003373647773, -4.193086589e-05, -0.08311333017))
    assert np.abs(t.pose[:, :3]).max() < 1e-10


def test_submarine_is_moved_by_the_fluid():
    boat = rr.machines.submarine(mp=5.0, h=0.0)
    t = boat.simulate(boat.gaits["circle"], 2 * np.pi, sample_interval=0.5)
    close(t.pose[-1, :3], (2.880993462e-05, 0.0008228075559, -5.891875e-07), atol=1e-11)
    close(t.rotation_vector[-1], (-0.001431554186, 0, -0.06999975767))


def test_without_fluid_a_moving_mass_leaves_the_mass_centre_where_it_is():
    boat = rr.machines.submarine(mp=5.0, h=0.0)
    bare = rr.machines.Machine(
        name="bare", title="no fluid", tree=boat.tree, shape=boat.shape, gaits=boat.gaits,
        model=rr.machines.Mechanism(boat.tree.model(0.0), motors=boat.model.motors),
    )  # fmt: skip
    t = bare.simulate(boat.gaits["circle"], 2 * np.pi, sample_interval=0.5)
    hull = boat.tree.base.mass
    centre = [(hull * x + 5 * (x + matrix(q) @ s)) / (hull + 5)
              for x, q, s in zip(t.pose[:, :3], t.quaternion, t.shape, strict=True)]  # fmt: skip
    np.testing.assert_allclose(centre, np.tile(centre[0], (len(t), 1)), atol=1e-13)


@pytest.mark.parametrize("name", ["rattleback", "chaplygin_sphere", "routh_sphere"])
def test_a_lone_body_rolls_alike_by_both_methods(name):
    parts = {"rattleback": {"sigma": 1e-4}}
    body = rr.machines.by_name(name, **parts.get(name, {}))
    start = dict(pose=body.at(rpy(0.05, -0.03, 0.4), (0.1, -0.2)), start=(0.3, -0.2, 4.0))
    kkt = body.simulate(None, 0.3, method="kkt", rtol=1e-13, atol=1e-13, **start)
    fast = body.simulate(None, 0.3, method="momentum", **start)
    np.testing.assert_allclose(fast.states, kkt.states, atol=2e-9)
    np.testing.assert_allclose(fast.multipliers["contact"], kkt.multipliers["contact"], atol=1e-6)
    assert fast.violation.max() < 1e-14


def test_methods_are_refused_where_they_do_not_fit():
    with pytest.raises(rr.ModelError, match="for a lone ball or ellipsoid on a plane"):
        rr.machines.rolling_disc().simulate(None, 1.0, method="momentum")
    with pytest.raises(rr.ParameterError, match="must be 'kkt' or 'momentum'"):
        rr.machines.rattleback().simulate(None, 1.0, method="fast")
