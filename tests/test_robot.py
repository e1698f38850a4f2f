"""Robots from parameters, any URDF and the example robots: legs, shell, copies, errors."""

import copy
import json
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rrrobot as rr
from rrrobot.contact.surfaces import SHELL_FRAME
from rrrobot.robot import joints
from rrrobot.robot.joints import JointIndex, build_model
from tests.random_robot import random_robot, random_urdf
from tests.strategies import directions, examples

SHELL = rr.Sphere(0.12)
EVERY = tuple(f"joint_{i:02d}" for i in range(12))


def base_frame(robot: rr.Robot) -> pin.SE3:
    """Placement of the shell's frame in the base frame, by Pinocchio."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, pin.neutral(robot.model))
    return data.oMf[robot.model.getFrameId(SHELL_FRAME)]


def assert_same_robot(a: rr.Robot, b: rr.Robot) -> None:
    assert a == b
    assert hash(a) == hash(b)
    assert repr(a) == repr(b)
    assert a.model == b.model
    assert a.shell_placement == b.shell_placement
    q = pin.neutral(a.model)
    mass = [pin.crba(r.model, r.model.createData(), q) for r in (a, b)]
    np.testing.assert_array_equal(*mass)


# From parameters and files


def test_from_parameters():
    p = rr.RRRobotParameters(leg_mass=(0.05, 0.08), shell_radius=0.13, gravity=1.62)
    robot = rr.Robot.from_parameters(p)
    assert (robot.name, robot.legs, robot.n_legs) == ("rrrobot", ("leg_1", "leg_2"), 2)
    assert robot.shell == rr.Sphere(0.13)
    assert robot.mass == pytest.approx(p.total_mass, abs=1e-15)
    assert robot.model.gravity.linear.tolist() == [0, 0, -1.62]
    assert robot.model.nq == 9
    assert robot.model.nv == 8
    np.testing.assert_array_equal(base_frame(robot).homogeneous, np.eye(4))


def test_from_urdf_takes_a_path_a_string_and_text():
    path = rr.urdf_path()
    robots = [rr.Robot.from_urdf(s, shell=SHELL) for s in (path, str(path), path.read_text())]
    own = replace(rr.Robot.from_parameters(), parameters=None)
    assert robots[0] == robots[1] == robots[2] == own


def test_legs_are_pinocchios_unless_given():
    text = random_urdf(1)
    names = pin.buildModelFromXML(text).names
    assert rr.Robot.from_urdf(text, shell=SHELL).legs == tuple(names)[1:]
    assert tuple(names)[1:] != EVERY
    crossed = rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL, legs=("leg_2", "leg_1"))
    assert crossed.legs == ("leg_2", "leg_1")


def test_given_order_of_the_legs_is_the_gaits():
    def run(*order: int) -> rr.Trajectory:
        legs = tuple(("leg_1", "leg_2")[i] for i in order)
        robot = rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL, legs=legs)
        angle, rate = np.array((1.2, 1.7))[list(order)], np.array((0.3, -0.2))[list(order)]
        drive = rr.LegTorques(np.array((0.01, -0.02))[list(order)], angle=angle, rate=rate)
        return rr.simulate(rr.FullModel(robot), drive, duration=0.3)

    straight, crossed = run(0, 1), run(1, 0)
    np.testing.assert_allclose(crossed.euler, straight.euler, atol=1e-13)
    np.testing.assert_allclose(crossed.leg_angle[:, ::-1], straight.leg_angle, atol=1e-13)
    np.testing.assert_allclose(crossed.configuration, straight.configuration, atol=1e-13)


def test_one_leg_by_its_name():
    robot = rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL, legs="leg_2")
    assert robot.legs == ("leg_2",)
    assert dict(robot.locked) == {"leg_1": 0.0}


def test_no_legs_is_a_ball_that_rolls():
    robot = rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL, legs=(), locked={"leg_1": 1.5})
    assert (robot.n_legs, robot.model.nv) == (0, 6)
    t = rr.simulate(rr.FullModel(robot), rr.StillLegs(()), duration=0.2, start=(0.1, 0.2, 0.0))
    assert np.ptp(t.position) > 0


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "continuous"])
def test_locked_joints_are_held_where_they_are_told(kind):
    """Locked at a position, the inertia is that of the free robot with the joint there."""
    text = random_urdf(4)
    free = rr.Robot.from_urdf(text, shell=SHELL)
    name = EVERY[("revolute", "prismatic", "continuous").index(kind)]
    held = rr.Robot.from_urdf(
        text, shell=SHELL, legs=[n for n in EVERY if n != name], locked={name: 0.7}
    )
    assert held.model.nv == free.model.nv - 1
    assert held.mass == pytest.approx(free.mass, rel=1e-14)
    q = pin.neutral(free.model)
    JointIndex(free.model, [name]).write(q, np.array([0.7]))
    whole = pin.crba(free.model, free.model.createData(), q)
    kept = JointIndex(free.model, held.legs).v
    rows = np.concatenate((np.arange(6), kept))
    found = pin.crba(held.model, held.model.createData(), pin.neutral(held.model))
    order = np.concatenate((np.arange(6), JointIndex(held.model, held.legs).v))
    np.testing.assert_allclose(
        found[np.ix_(order, order)], whole[np.ix_(rows, rows)], rtol=1e-12, atol=1e-14
    )


def test_joint_index_writes_each_kind_of_joint():
    """Revolute and prismatic joints take their coordinate, continuous ones cosine and sine."""
    robot = rr.Robot.from_urdf(random_urdf(2), shell=SHELL)
    names = EVERY[::-1]
    index = JointIndex(robot.model, names)
    angles = np.linspace(-1.5, 2.5, 12)
    q = pin.neutral(robot.model)
    base = q[:7].copy()
    index.write(q, angles)
    np.testing.assert_array_equal(q[:7], base)
    for name, angle in zip(names, angles, strict=True):
        joint = robot.model.joints[robot.model.getJointId(name)]
        wide = (np.cos(angle), np.sin(angle))
        expected = wide if int(name[-2:]) % 3 == 2 else (angle,)
        assert joint.nq == len(expected)
        np.testing.assert_array_equal(q[joint.idx_q : joint.idx_q + joint.nq], expected)
    # The rates of these coordinates are those of the joints.
    data, h = robot.model.createData(), 1e-6
    rates = np.random.default_rng(0).normal(size=12)
    v = np.zeros(robot.model.nv)
    v[index.v] = rates
    ahead, behind = q.copy(), q.copy()
    index.write(ahead, angles + h * rates)
    index.write(behind, angles - h * rates)
    difference = pin.difference(robot.model, behind, ahead) / (2 * h)
    np.testing.assert_allclose(difference, v, atol=1e-8)
    assert np.isfinite(pin.crba(robot.model, data, q)).all()


# The shell


def test_shell_frame_is_at_the_centre_in_the_shell_links_axes():
    text = (
        '<robot name="r"><link name="root"/><link name="belly"><inertial><mass value="1"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
        '<joint name="mount" type="fixed"><parent link="root"/><child link="belly"/>'
        '<origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/></joint></robot>'
    )
    center = np.array((0.01, -0.02, 0.03))
    robot = rr.Robot.from_urdf(text, shell=SHELL, shell_link="belly", shell_center=center)
    rotation = pin.rpy.rpyToMatrix(0.4, 0.5, 0.6)
    expected = np.array((0.1, 0.2, 0.3)) + rotation @ center
    for placement in (base_frame(robot), robot.shell_placement):
        np.testing.assert_allclose(placement.translation, expected, atol=1e-15)
        np.testing.assert_allclose(placement.rotation, rotation, atol=1e-15)
    at_root = rr.Robot.from_urdf(text, shell=SHELL)
    assert at_root.shell_link == "root"
    np.testing.assert_array_equal(at_root.shell_placement.homogeneous, np.eye(4))


def test_shell_may_sit_on_a_link_whose_joint_is_locked():
    text, link = random_urdf(3), "link_0"
    others = EVERY[1:]
    robot = rr.Robot.from_urdf(
        text, shell=SHELL, shell_link=link, legs=others, locked={"joint_00": 0.3}
    )
    free = rr.Robot.from_urdf(text, shell=SHELL)
    q = pin.neutral(free.model)
    JointIndex(free.model, ["joint_00"]).write(q, np.array([0.3]))
    data = free.model.createData()
    pin.framesForwardKinematics(free.model, data, q)
    expected = data.oMf[free.model.getFrameId(link, pin.FrameType.BODY)]
    assert robot.shell_placement.isApprox(expected, 1e-12)


def test_shell_link_that_does_not_exist_lists_those_that_do():
    with pytest.raises(rr.ShellError, match=r"no link 'belly'.*links are: shell, battery, leg_1_l"):
        rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL, shell_link="belly")


@pytest.mark.parametrize("shell", [0.12, None, "sphere", {"radius": 0.12}, rr.Sphere], ids=repr)
def test_shell_that_is_no_surface(shell):
    with pytest.raises(rr.ShellError, match=r"it must be a surface, such as Sphere"):
        rr.Robot.from_urdf(rr.urdf_path(), shell=shell)


@pytest.mark.parametrize("center", [(0, 0), "middle", (0, 0, np.nan), 0.0])
def test_bad_shell_center(center):
    with pytest.raises(rr.ParameterError, match=r"^shell_center (is|has)"):
        rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL, shell_center=center)


# The ground and gravity


@given(directions().filter(lambda n: n[2] > 0.01))
@examples(10)
def test_normal_is_made_unit(normal):
    for scale in (1.0, 1e-200, 1e200):
        ground = rr.Plane(scale * normal)
        np.testing.assert_allclose(ground.normal_vector, normal, atol=1e-15)
    assert not ground.normal_vector.flags.writeable


@pytest.mark.parametrize(
    "normal",
    [(0, 0, 0), (0, 0, -1), (1, 0, 0), (0, 0), "up", (0, 0, np.nan), (0, 0, np.inf), 1.0, None,
     ("0", "0", "1"), (True, False, True)],
)  # fmt: skip
def test_bad_normal(normal):
    with pytest.raises(rr.ParameterError, match=r"normal (is|has)"):
        rr.FullModel(rr.Robot.from_parameters(), ground=rr.Plane(normal))


@pytest.mark.parametrize("gravity", [-1, np.nan, np.inf, "9.81", True])
def test_bad_gravity(gravity):
    with pytest.raises(rr.ParameterError, match=r"^gravity is .*at least zero"):
        rr.Plane(gravity=gravity)


def test_gravity_comes_with_the_ground_or_the_parameters():
    moon = rr.Robot.from_parameters(rr.RRRobotParameters(gravity=1.62))
    stranger = rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL)
    mars = rr.Plane(gravity=3.7)
    for kind in (rr.FullModel, rr.PivotingModel, rr.RollModel, rr.PitchModel):
        assert kind(moon).gravity == 1.62
        assert kind(stranger).gravity == 9.81
        assert kind(moon, ground=mars).gravity == kind(stranger, ground=mars).gravity == 3.7
    assert stranger.model.gravity.linear[2] == -9.81
    assert rr.YawModel(moon).gravity == 0.0


def test_damping_comes_with_the_parameters():
    """A robot that is not RRRobot is not damped by RRRobot's number."""
    robot = rr.Robot.from_parameters(rr.RRRobotParameters(damping=0.02))
    stranger = rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL)
    wanted = {
        rr.FullModel: (0.02, 0.02, 0.02), rr.PivotingModel: (0.02, 0.02, 0.0),
        rr.RollModel: (0.02, 0.0, 0.0), rr.PitchModel: (0.0, 0.02, 0.0), rr.YawModel: (0, 0, 0),
    }  # fmt: skip
    for kind, numbers in wanted.items():
        assert kind(robot).damping == rr.EulerRateDamping(*numbers)
        assert kind(stranger).damping == rr.EulerRateDamping()
        assert kind(robot, damping=None).damping == rr.EulerRateDamping()
    with pytest.raises(rr.ParameterError, match="damping is 'own'"):
        rr.FullModel(robot, damping="own")


# What is refused


@pytest.mark.parametrize("legs", [("leg_1", "wing"), ("wing",), "wing"])
def test_missing_joint_lists_those_that_exist(legs):
    with pytest.raises(rr.UrdfError, match=r"no movable joint 'wing'.*joints are: leg_1, leg_2"):
        rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL, legs=legs)


def test_fixed_joint_is_no_leg():
    with pytest.raises(rr.UrdfError, match="no movable joint 'battery_mount'"):
        rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL, legs=("battery_mount",))


def test_leg_named_twice():
    with pytest.raises(rr.UrdfError, match="each joint may be named once"):
        rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL, legs=("leg_1", "leg_1"))


@pytest.mark.parametrize(
    ("locked", "says"),
    [({"wing": 0.0}, "'wing' is no movable joint outside the legs; those are: leg_2"),
     ({"leg_1": 0.0}, "'leg_1' is no movable joint outside the legs; those are: leg_2"),
     ({"leg_2": np.nan}, "locked['leg_2'] is nan: it must be finite"),
     ({"leg_2": "up"}, "locked['leg_2'] is 'up': it must be a number")],
)  # fmt: skip
def test_bad_locked_joints(locked, says):
    with pytest.raises(rr.RRRobotError) as caught:
        rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL, legs=("leg_1",), locked=locked)
    assert says in str(caught.value)


@pytest.mark.parametrize(("kind", "freedoms"), [("floating", 6), ("planar", 3)])
def test_joints_of_several_freedoms_are_refused(kind, freedoms):
    text = rr.rrrobot_urdf().replace('"leg_2" type="revolute"', f'"leg_2" type="{kind}"')
    for options in ({}, {"legs": ("leg_1",)}):
        with pytest.raises(rr.UrdfError, match=f"'leg_2' has {freedoms} degrees of freedom"):
            rr.Robot.from_urdf(text, shell=SHELL, **options)


def test_no_mass():
    text = '<robot name="r"><link name="a"/></robot>'
    with pytest.raises(rr.UrdfError, match=r"total mass is 0\.0 kg: it must be above zero"):
        rr.Robot.from_urdf(text, shell=SHELL)


def test_build_model_of_a_reduced_urdf_has_no_free_flyer():
    text = rr.robot.reduced_urdf(rr.rrrobot_urdf(), "yaw", height=0.12)
    model = build_model(text, None, ("leg_1",), {"leg_2": 0.5})
    assert list(model.names) == ["universe", "base_yaw", "leg_1"]


# Copies


ROBOTS: list[Any] = [
    rr.Robot.from_parameters(rr.RRRobotParameters(leg_length=(0.1, 0.09))),
    random_robot(5, shell=rr.Ellipsoid((0.3, 0.31, 0.32))),
    rr.Robot.from_urdf(random_urdf(6), shell=SHELL, legs=EVERY[5:2:-1], locked={EVERY[1]: 0.2},
                       package_dirs=("/tmp",)),
]  # fmt: skip


@pytest.mark.parametrize("robot", ROBOTS, ids=["rrrobot", "ellipsoid", "locked"])
def test_copies_are_equal(robot):
    assert_same_robot(pickle.loads(pickle.dumps(robot)), robot)
    assert_same_robot(copy.deepcopy(robot), robot)
    assert_same_robot(copy.copy(robot), robot)
    assert_same_robot(rr.Robot.from_dict(json.loads(json.dumps(robot.to_dict()))), robot)


class Egg(rr.Sphere):
    """A surface of somebody else's."""

    def to_dict(self) -> dict[str, Any]:
        return {"type": "egg"}


def test_a_robot_with_a_shell_of_your_own_copies_too():
    robot = rr.Robot.from_urdf(rr.urdf_path(), shell=Egg(0.12))
    for again in (pickle.loads(pickle.dumps(robot)), copy.deepcopy(robot)):
        assert isinstance(again.shell, Egg)
        assert again == robot


def test_robots_differ():
    one = rr.Robot.from_parameters()
    assert one != rr.Robot.from_parameters(rr.RRRobotParameters(gravity=1.0))
    assert one != rr.Robot.from_urdf(rr.urdf_path(), shell=rr.Sphere(0.13))
    assert one != rr.Robot.from_urdf(rr.urdf_path(), shell=SHELL, legs=("leg_2", "leg_1"))
    assert one != "rrrobot"


def test_from_dict_checks_the_urdf():
    data = rr.Robot.from_parameters().to_dict()
    with pytest.raises(rr.UrdfError, match="DOCTYPE"):
        rr.Robot.from_dict(data | {"urdf": "<!DOCTYPE robot>" + data["urdf"]})


def test_frozen():
    robot = rr.Robot.from_parameters()
    with pytest.raises(AttributeError):
        robot.gravity = 1.0  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        robot.shell_center[0] = 1.0


# Example robots


def test_solo12_rolls_on_a_belly():
    """Legs up, small swings: finite, no slip, no height."""
    pytest.importorskip("example_robot_data")
    robot = rr.Robot.from_example("solo12", shell=rr.Sphere(0.2))
    assert robot.n_legs == 12
    assert robot.mass == pytest.approx(2.5, abs=0.01)
    # Hips half a turn round: the feet, which hang below at zero, point up.
    up = np.array([np.pi if name.endswith("HFE") else 0.0 for name in robot.legs])
    gait = rr.SinusoidalGait(
        offset=up, amplitude=0.1, angular_frequency=8.0, phase=np.arange(12) * np.pi / 6
    )
    t = rr.simulate(rr.FullModel(robot), gait, duration=2.0)
    for name in ("euler", "position", "contact_force", "leg_torque", "energy", "velocity"):
        assert np.all(np.isfinite(getattr(t, name))), name
    assert t.slip.max() < 1e-12
    assert np.abs(t.height_error).max() < 1e-12
    assert t.leg_torque.shape == (201, 12)
    assert np.ptp(t.euler, axis=0).min() > 5e-4
    # The feet are above the shell's centre all the time.
    data = robot.model.createData()
    for q in t.configuration[::20]:
        pin.framesForwardKinematics(robot.model, data, q)
        feet = [data.oMf[robot.model.getFrameId(f"{leg}_FOOT")] for leg in ("FL", "HR")]
        assert min(foot.translation[2] for foot in feet) > 0.2


def test_example_robots_are_read():
    pytest.importorskip("example_robot_data")
    known = rr.robot.example_robots()
    assert "solo12" in known
    assert list(known) == sorted(known)
    for name in ("solo8", "anymal", "double_pendulum_continuous", "icub"):
        robot = rr.Robot.from_example(name, shell=rr.Sphere(0.5))
        assert robot.n_legs == robot.model.nv - 6
        assert robot.package_dirs
    pendulum = rr.Robot.from_example("double_pendulum_continuous", shell=SHELL)
    assert pendulum.model.nq == 7 + 4


def test_unknown_example_robot_lists_the_known():
    pytest.importorskip("example_robot_data")
    with pytest.raises(rr.UrdfError, match=r"no example robot 'solo13'; there are: .*solo12"):
        rr.Robot.from_example("solo13", shell=SHELL)


def test_missing_extra_says_what_to_install(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "example_robot_data.robots_loader", None)
    with pytest.raises(rr.MissingExtraError, match=r"pip install 'rrrobot\[robots\]'") as caught:
        rr.robot.example_robots()
    assert isinstance(caught.value, ImportError)
    with pytest.raises(rr.MissingExtraError):
        rr.Robot.from_example("solo12", shell=SHELL)


@given(st.integers(0, 100))
@examples(8)
def test_random_trees_keep_their_mass_and_legs(seed):
    robot = random_robot(seed)
    assert sorted(robot.legs) == list(EVERY)
    assert robot.model.nv == 18
    inertias = pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer()).inertias
    assert robot.mass == pytest.approx(sum(i.mass for i in inertias), rel=1e-14)


def test_limit_of_the_legs(monkeypatch):
    monkeypatch.setattr(joints, "_MAX_LEGS", 11)
    with pytest.raises(rr.UrdfError, match="12 moving joints: the limit is 11"):
        random_robot(1)
    assert random_robot(1, legs=EVERY[:11]).n_legs == 11
