"""What makes no machine, and starts that nothing can meet, are refused with the shape and rows."""

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.machines import Machine, Mechanism, Tree
from rrrobot.rows import PlanarMotion

BODILESS = [
    ("snakeboard", {"m_truck": 1.0}, "at least those of its rotor and trucks"),
    ("snakeboard", {"J": -0.1}, "at least those of its rotor and trucks"),
    ("chaplygin_sleigh", {"I": -1.0}, "the body has the inertia"),
    ("rotor_ball", {"Jr": 0.01}, "composite inertia below its parts"),
    ("submarine", {"h": 0.3}, "composite inertia below its parts"),
    ("submarine", {"mp": -1.0, "h": 0.0}, "mass of slide_z"),
    ("roller_racer", {"I2": -0.1}, "the fork has the inertia"),
    ("roller_racer", {"m1": -3.0}, "mass of body"),
    ("chaplygin_sphere", {"I": (0.01, 0.014, 0.03)}, "moments 0.01, 0.014, 0.03 kg m.2"),
    ("rolling_disc", {"A": 0.02, "C": 0.054}, "no more than the others' sum"),
    ("falling_cat", {"A": 0.11, "B": 0.05, "d": 0.0}, "no more than the others' sum"),
]


@pytest.mark.parametrize(("name", "parts", "said"), BODILESS)
def test_parameters_that_make_no_body(name, parts, said):
    with pytest.raises(rr.ParameterError, match=said):
        rr.machines.by_name(name, **parts)


def test_every_machine_is_a_body():
    for name in rr.machines.all_names():
        rr.machines.by_name(name)


def test_a_shell_that_is_not_on_its_ground():
    ball = rr.machines.chaplygin_sphere()
    pose = ball.at((0, 0, 0, 1.0), (0.3, 0.1))
    pose[2] += 0.05
    with pytest.raises(rr.ConstraintError, match=r"off the constraint 'contact' by 0\.05 m"):
        ball.simulate(None, 1.0, pose=pose, start=(1, 0, 0))
    # However far off it is on the ground is no matter.
    pose = ball.at((0, 0, 0, 1.0), (3e3, 0.1))
    assert len(ball.simulate(None, 0.1, pose=pose, start=(1, 0, 0), method="kkt")) == 11


def test_a_body_that_leans_out_of_its_plane():
    planar = rr.machines.chaplygin_sleigh()
    tree = Tree(planar.tree.base)
    model = tree.model()
    sled = Machine(name="sled", title="a sled", tree=tree, model=Mechanism(
        model, [PlanarMotion(model, model.getFrameId(tree.base.name), name="floor")]))  # fmt: skip
    lean = rr.rotations.quaternion_from_euler((0.1, 0.0, 0.3))
    with pytest.raises(rr.ConstraintError, match=r"off the constraint 'floor' by 0\.09"):
        sled.simulate(None, 1.0, pose=(0, 0, 0, *lean), start="rest")


def test_velocities_that_break_wheels():
    sleigh = rr.machines.chaplygin_sleigh()
    for call in (lambda v: sleigh.simulate(None, 1.0, start=v),
                 lambda v: sleigh.evaluate(body_velocity=v)):  # fmt: skip
        with pytest.raises(rr.ConstraintError, match=r"the constraint 'blade' by 0\.1: give"):
            call((0.4, 0.1, 0.0))


def test_prescribed_joints_that_contradict_the_wheels():
    snake = rr.machines.kinematic_snake()
    shape = (0.4, -0.4)
    rows = r"shape \(0.4, -0.4\): the velocities break the constraints 'rear', 'middle', 'front'"
    with pytest.raises(rr.ConstraintError, match=rows):
        snake.evaluate(shape=shape, shape_rates=(1.0, 0.3))
    rows = r"shape \(0.4, -0.4\): the constraints 'rear', 'middle', 'front'"
    with pytest.raises(rr.ConstraintError, match=rows):
        snake.evaluate(shape=shape, shape_accelerations=(1.0, 0.3))
    # Standing still there is no contradiction.
    snake.evaluate(shape=shape)


def test_gaits_through_singular_shapes():
    racer = rr.machines.roller_racer(d1=0.3, d2=0.3, I2=0.02)
    swing = rr.SinusoidalGait(offset=(2.9,), amplitude=(0.5,), angular_frequency=1.0, phase=(0.0,))
    said = r"singular shape at t = 0.5\d+ s, shape \(3.142\): .* 'rear', 'front' depend"
    with pytest.raises(rr.ConstraintError, match=said):
        racer.simulate(swing, 6.0)
    snake = rr.machines.kinematic_snake()
    starts = rr.SinusoidalGait(offset=(0.5, -0.5), amplitude=(0.2, 0.1), angular_frequency=1.0,
                               phase=(0.0, 0.0))  # fmt: skip
    with pytest.raises(rr.ConstraintError, match=r"t = 0 s, shape \(0.5, -0.5\): .*'rear'"):
        snake.simulate(starts, 1.0)


def test_snakeboard_has_the_closed_forms_of_set_m():
    # With J + Jr + 2 Jw = m l^2 and axles opposite: xi of psi_dot and of p, b = (1, 0, tan phi/l).
    m, l, Jr, phi = 6.0, 0.2, 0.072, 0.4  # noqa: E741
    form = rr.machines.Reduction(rr.machines.snakeboard(J=0.1654)).at((0.3, phi, -phi))
    s, c = np.sin(phi), np.cos(phi)
    wanted = Jr * np.array((np.sin(2 * phi) / (2 * m * l), 0, s * s / (m * l * l)))
    np.testing.assert_allclose(form.connection[:, 0], wanted, atol=1e-14)
    np.testing.assert_allclose(form.connection[:, 1] - form.connection[:, 2], 0, atol=1e-14)
    scale = 1 / form.free[0, 0]  # p is measured along b, whose first entry is 1
    np.testing.assert_allclose(
        form.response[:, 0] / scale, np.array((c * c, 0, s * c / l)) / m, atol=1e-14
    )


def test_sphericle_that_does_not_spin_drives_as_a_unicycle():
    r, rho, u1, u2 = 0.2, 0.18, 0.3, 0.8
    ball = rr.machines.sphericle()
    a = ball.evaluate(pose=np.eye(3), body_velocity=(0, u1 / rho, 0), shape_rates=(u1, u2))
    # x_dot = (r / rho) u1, and the vehicle, upright, yaws at u2.
    np.testing.assert_allclose(a.velocity[:3], (r / rho * u1, 0, 0), atol=1e-14)
    np.testing.assert_allclose(a.velocity[6:], (0, -u1 / rho, u2), atol=1e-14)
